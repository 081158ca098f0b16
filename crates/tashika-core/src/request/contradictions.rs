//! Options that contradict each other: a table of the needs of each option.
//!
//! | option | needs |
//! |---|---|
//! | vpls, clamp, gather, lights | a method that sums over VPLs, not path |
//! | instants | a sum over one set of VPLs |
//! | paths | method path, not audited; or groups of lights |
//! | error | a method that stops by it, not exact |
//! | control, absolute | method tashika, or path with an error or a claim |
//! | confidence | a method that states an interval for each pixel |
//! | claim | method tashika, or path unless certified |
//! | truth | method tashika; with other methods, only the truth that they estimate |
//! | max_pairs | a method that refines cuts |
//! | audit | a method that makes a claim |
//! | share, assurance, passes | claim audited |
//! | quality | no claim of another kind, and a method that can make the claim |
//!
//! An option whose need is not met is refused, with one exception. In scenes that move or whose
//! media scatter, the default method becomes path tracing ([`Request::in_scene`]). Options that
//! have no effect only for this reason are reported and ignored, so that one command serves many
//! scenes.
//!
//! # Held to this by
//! `request::tests`; the program's test `requests`.

use super::{ClaimName, MethodName, Quality, Request};
use crate::error::{Error, Result};
use crate::integrator::{SumMethod, Truth};
use crate::scene::Scene;
use crate::vpl::Clamp;

/// A given option that has no effect together with the rest of a request.
struct UnusedOption {
    /// Field of [`Request`].
    name: &'static str,
    value: String,
    /// Description of values that would be accepted.
    expected: String,
}

impl Request {
    /// Refuses options that contradict each other in every scene.
    ///
    /// # Errors
    /// [`Error::Option`] with the name and the value of one option, and the options that it
    /// contradicts.
    pub fn check(&self) -> Result<()> {
        let anywhere = self.by_paths().unused();
        self.refuse(|name| anywhere.contains(&name))
    }

    /// Refuses options that contradict each other in a scene. Returns the names of the options that
    /// have no effect in this scene only; they are ignored.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn check_in(&self, scene: &Scene) -> Result<Vec<&'static str>> {
        let mut here = self.in_scene(scene).unused();
        self.refuse(|name| here.contains(&name))?;
        let always = self.unused();
        here.retain(|name| !always.contains(name));
        Ok(here)
    }

    /// Refuses an option of audited pictures in a request without an audit.
    ///
    /// # Errors
    /// [`Error::Option`] with the name and the value of the option.
    pub fn check_audited(&self, name: &str, value: impl ToString) -> Result<()> {
        if self.is_audited() {
            return Ok(());
        }
        Err(Error::option(name, value.to_string(), WITHOUT_AUDIT))
    }

    /// Refuses a number of passes beside a time limit, or of a share of the tiles, whose passes
    /// follow from its errors.
    ///
    /// # Errors
    /// [`Error::Option`] with the number of passes.
    pub fn check_passes(&self, has_time_limit: bool, is_whole: bool) -> Result<()> {
        let expected = match (has_time_limit, is_whole) {
            (false, true) => return Ok(()),
            (true, _) => "none with time, which ends the work; take one of the two away",
            (false, false) => {
                "none with tiles, whose work follows from their errors; take one of the two away"
            }
        };
        self.passes.map_or(Ok(()), |passes| Err(Error::option("passes", passes, expected)))
    }

    /// Fills unset fields from a quality, unless the set fields contradict it.
    ///
    /// # Errors
    /// [`Error::Option`] with the name of the quality and the option that contradicts it.
    pub fn with_quality(self, quality: Quality) -> Result<Self> {
        let is_audited = quality.claim() == ClaimName::Audited;
        let is_ours = self.is_ours() && (!is_audited || self.method == MethodName::default());
        let expected = match self.claim {
            Some(claim) if (claim == ClaimName::Audited) != is_audited => {
                let own = if is_audited { "audited, of the picture" } else { "of each pixel" };
                format!("none with claim {claim}: its own is {own}; take one of the two away")
            }
            _ if !is_ours && self.method != MethodName::Path => {
                format!("none with method {}, which cannot keep it; take one of the two away", self.method)
            }
            _ => return Ok(self.of_quality(quality)),
        };
        Err(Error::option("quality", quality.name(), expected))
    }

    /// Names of the options that have no effect on the method.
    pub(super) fn unused(&self) -> Vec<&'static str> {
        self.unused_options().into_iter().map(|option| option.name).collect()
    }

    fn refuse(&self, is_in_vain: impl Fn(&str) -> bool) -> Result<()> {
        match self.unused_options().into_iter().find(|option| is_in_vain(option.name)) {
            Some(UnusedOption { name, value, expected }) => Err(Error::option(name, value, expected)),
            None => Ok(()),
        }
    }

    /// Returns the options whose needs are not met, by the table above.
    fn unused_options(&self) -> Vec<UnusedOption> {
        let is_path = self.method == MethodName::Path;
        let is_exact = self.method == SumMethod::Exact.into();
        let (is_ours, is_audited) = (self.is_ours(), self.is_audited());
        let is_calibrated = self.is_by_calibrated_paths();
        let until = is_path && (self.error.is_some() || is_audited || is_calibrated);
        let states_interval = self.sum_method().is_some_and(SumMethod::states_interval);
        let promises = is_audited || until || (!is_path && !is_exact);
        let estimated = if is_path { Truth::Transport } else { Truth::Vpl };

        let with_method = |why: &str| format!("none with method {}, {why}; {ONE_OF_TWO}", self.method);
        let of_lights = || with_method("which follows paths from the camera alone");
        let audited = |why: &str| format!("none with claim audited, {why}; {ONE_OF_TWO}");
        let of_count =
            || with_method("unless an error or a claim is asked for: so many paths promise nothing");
        let of_interval = |why: &str| if is_path { of_count() } else { with_method(why) };
        let of_claim =
            |why: &str| if is_path && self.claim().is_none() { of_count() } else { with_method(why) };

        let mut found = Vec::new();
        let mut row = |name, value: Option<String>, is_in_vain: bool, expected: &dyn Fn() -> String| {
            if let (Some(value), true) = (value, is_in_vain) {
                found.push(UnusedOption { name, value, expected: expected() });
            }
        };
        row("vpls", text(self.vpls), is_path, &of_lights);
        row("clamp", self.clamp.map(clamp), is_path, &of_lights);
        row("instants", text(self.instants), is_path || self.is_about_all_sets(), &|| {
            if is_path {
                of_lights()
            } else {
                format!(
                    "none with truth {}: sums over one set of lights (truth vpl) look at instants",
                    self.truth()
                )
            }
        });
        row("lights", self.lights_given.then(|| "given ones".to_owned()), is_path, &of_lights);
        row("gather", text(self.gather), is_path, &of_lights);
        row(
            "paths",
            text(self.paths),
            !self.groups_asked && (!is_path || is_audited),
            &|| match is_audited {
                true => audited("which has as many as its error and its time ask for"),
                false => format!(
                    "none with method {} unless groups are asked for; method path has them",
                    self.method
                ),
            },
        );
        row("error", text(self.error), is_exact, &|| with_method("whose sums have no error"));
        for (name, value) in [("control", text(self.control)), ("absolute", text(self.absolute))] {
            row(name, value, !(is_ours || until), &|| of_interval("which has its own rule"));
        }
        row("confidence", text(self.confidence), !(states_interval || until) || is_audited, &|| {
            if is_audited {
                audited("where assurance says how sure it is")
            } else {
                of_interval("which states no interval")
            }
        });
        let of_audits =
            [("share", text(self.share)), ("assurance", text(self.assurance)), ("passes", text(self.passes))];
        for (name, value) in of_audits {
            row(name, value, !is_audited, &|| WITHOUT_AUDIT.to_owned());
        }
        row("claim", text(self.claim), !(is_ours || is_audited || is_calibrated), &|| {
            with_method("which cannot claim that")
        });
        row("truth", text(self.truth), !is_ours && self.truth != Some(estimated), &|| {
            format!("{estimated} with method {}; take one of the two away", self.method)
        });
        row("max_pairs", text(self.max_pairs), is_exact || is_path || is_audited, &|| match is_audited {
            true => audited("which has as much work as its error and its time ask for"),
            false => with_method("which refines no cuts"),
        });
        row("audit", text(self.audit), !promises, &|| {
            of_claim("which promises nothing that could be audited")
        });
        found
    }
}

/// Accepted values of an option of audits in a request without an audit.
const WITHOUT_AUDIT: &str =
    "none without claim audited: take it away, or have such a picture, without an error or by a quality";
/// Remedy for two options that contradict each other.
const ONE_OF_TWO: &str = "take one of the two away";

/// Formats a clamp as it is typed.
fn clamp(clamp: Clamp) -> String {
    match clamp {
        Clamp::Auto => "auto".to_owned(),
        Clamp::Off => "off".to_owned(),
        Clamp::Distance(metres) => metres.to_string(),
    }
}

fn text<T: ToString>(value: Option<T>) -> Option<String> {
    value.map(|value| value.to_string())
}
