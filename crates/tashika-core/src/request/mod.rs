//! Options of a render: their defaults, their ranges, and the combinations that are accepted.
//!
//! The program and the Python package spell the same options differently. The meaning of each
//! option is defined only here, so that equal options give equal images. A [`Request`] holds the
//! given options. [`Request::plan`] returns a [`Plan`] for a scene: the method with every value in
//! range, and the names of the options that have no effect on it. [`Request::validate`] finds
//! errors of usage before a scene is read. [`Request::check`] and [`Request::check_in`] refuse
//! options that contradict each other; the program and the Python package call them, so that no
//! given option is silently ignored.
//!
//! | unset | default |
//! |---|---|
//! | method | our method |
//! | claim | [`Request::claim`] |
//! | truth | light transport; the sum over one set of VPLs with certified claims or given VPLs |
//! | error | 5 % of light transport, 2 % of a sum, 10 % of an audited picture |
//! | share, assurance, audited pixels | those of [`AuditTerms`] |
//! | confidence, control, absolute | those of [`ControlOptions`] |
//! | most pairs | those of the method |
//! | passes | as many as the claim, the time limit or 64 million paths permit |
//! | VPLs | those of [`VplOptions`], or by the error `ε` as below |
//! | gather points | those of [`GatherOptions`], or by the error as below |
//! | filter | the box |
//! | paths | 64; at most 2²⁰ where an interval stops them |
//! | size | the camera's, or 640×360 |
//!
//! If the truth is about all sets of VPLs and all gather points, the default is 1000/ε² VPLs,
//! between one and four million, and 2.56/ε gather points, between 32 and 256. The default for an
//! audited picture is 2500/ε² VPLs, between 250,000 and four million. Our method computes sums of
//! few terms whole, with any claim ([`SumMethod::for_terms`]).
//!
//! # Held to this by
//! `request::tests`. The tests of the Python package check that the program and the package make
//! equal planes.

mod audited;
mod camera_change;
mod contradictions;
mod framing;
mod method;
#[cfg(test)]
mod tests;

pub use audited::{AuditTerms, ClaimName, Quality};
pub use camera_change::{CameraChange, ProjectionName};
pub use framing::{Framed, Framing};
pub use method::{Method, MethodName};

use crate::color::Controlled;
use crate::error::{Error, Result};
use crate::gather::{Filter, GatherOptions};
use crate::integrator::{ControlOptions, PathStop, Promise, SumMethod, Truth};
use crate::scene::Scene;
use crate::vpl::{Clamp, VplOptions};

/// Default relative error of light transport.
const PICTURE_ERROR: f64 = 0.05;
/// Time limit of a picture of this many pixels, if nothing else ends it (s).
const PICTURE_SECONDS: f64 = 30.0;
const PICTURE_PIXELS: f64 = 640.0 * 360.0;
/// Smallest such time limit (s): guidance takes most of it.
const FEWEST_SECONDS: f64 = 8.0;
/// Default relative error of an audited picture.
const AUDITED_ERROR: f64 = 0.1;
/// Number of VPLs of an audited picture, times the squared error. The number must grow with the
/// required precision, since more paths do not reduce the variance between sets of VPLs.
const AUDITED_VPLS_BY_ERROR: f64 = 2500.0;
/// Fewest and most VPLs of an audited picture.
const AUDITED_VPLS: [f64; 2] = [250_000.0, 4_000_000.0];
/// Default paths a pixel, where their number stops path tracing.
const PATHS: u32 = 64;
/// Default for the most paths a pixel, where an interval stops path tracing.
const MOST_PATHS: u32 = 1 << 20;
/// Number of VPLs where the truth is about all sets of VPLs, times the squared error. With this
/// number, the choice of the set causes about a third of the half-width.
const VPLS_BY_ERROR: f64 = 1000.0;
/// Fewest and most of these VPLs; more would take more memory than most scenes.
const MANY_VPLS: [f64; 2] = [1_000_000.0, 4_000_000.0];
/// Number of gather points where the truth is about all gather points, times the error.
const POINTS_BY_ERROR: f64 = 2.56;
/// Fewest and most of these gather points.
const MANY_POINTS: [f64; 2] = [32.0, 256.0];

/// The given options of a render; `None` stands for the default.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Method of the render. Default: ours.
    pub method: MethodName,
    /// Claim of our method, which replaces the claim in the name of `method`; or claim of path
    /// tracing, which then stops by our interval or is audited. Default:
    /// [`claim`](Request::claim).
    pub claim: Option<ClaimName>,
    /// Share of the pixels that is to be within the error, for an audited picture.
    pub share: Option<f64>,
    /// Confidence of the claim about an audited picture.
    pub assurance: Option<f64>,
    /// Number of pixels to audit.
    pub audit: Option<u64>,
    /// Number of passes of an audited picture, whose work is then fixed.
    pub passes: Option<u64>,
    /// Quantity that the error of our method is measured from.
    pub truth: Option<Truth>,
    /// Relative error allowed in a pixel.
    pub error: Option<f64>,
    /// Error metric.
    pub control: Option<Controlled>,
    /// Absolute error that suffices in dark pixels (W·m⁻²·sr⁻¹).
    pub absolute: Option<f64>,
    /// Confidence of the intervals; in (0, 1).
    pub confidence: Option<f64>,
    /// Largest cut, in pairs of clusters.
    pub max_pairs: Option<u64>,
    /// Number of paths for each pixel of path tracing; with an error or a calibrated claim, the
    /// maximum number.
    pub paths: Option<u64>,
    /// True if planes of light groups are requested. If pixels are not computed by paths, these
    /// planes are estimated by `paths` separate paths for each pixel.
    pub groups_asked: bool,
    /// True if the VPLs are given, rather than traced.
    pub lights_given: bool,
    /// Number of VPLs to trace.
    pub vpls: Option<u64>,
    /// Distance below which the contribution of a VPL is clamped.
    pub clamp: Option<Clamp>,
    /// Number of times at which one set of VPLs samples moving objects.
    pub instants: Option<u64>,
    /// Number of gather points a pixel.
    pub gather: Option<u64>,
    /// Pixel filter, of paths as well.
    pub filter: Option<Filter>,
    /// Seed of all random numbers. Default: 1.
    pub seed: u64,
}

impl Default for Request {
    fn default() -> Self {
        Self {
            method: MethodName::default(),
            claim: None,
            share: None,
            assurance: None,
            audit: None,
            passes: None,
            truth: None,
            error: None,
            control: None,
            absolute: None,
            confidence: None,
            max_pairs: None,
            paths: None,
            groups_asked: false,
            lights_given: false,
            vpls: None,
            clamp: None,
            instants: None,
            gather: None,
            filter: None,
            seed: 1,
        }
    }
}

/// A request for one scene, with every value in range.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Estimator of the pixels, with its options.
    pub method: Method,
    /// Number of gather points, and pixel filter.
    pub gather: GatherOptions,
    /// Names of the given options that have no effect on the method: fields of [`Request`], or
    /// `lights` for given VPLs.
    pub unused: Vec<&'static str>,
}

impl Request {
    /// Returns a request for sums over one set of VPLs.
    pub fn of_a_sum() -> Self {
        Self { truth: Some(Truth::Vpl), ..Self::default() }
    }

    /// Returns the request for a scene. A request for light transport by the default method becomes
    /// one for path tracing if the scene [moves](Scene::moves) or, unless the truth was named, if
    /// its media [scatter](Scene::scatters). In such media sums over VPLs are faster in most
    /// pixels, but leave some intervals wider than requested. Other requests stay as they are.
    #[must_use]
    pub fn in_scene(&self, scene: &Scene) -> Self {
        let is_by_paths = scene.moves() || (scene.scatters() && self.truth.is_none());
        if is_by_paths { self.by_paths() } else { self.clone() }
    }

    fn by_paths(&self) -> Self {
        let is_default = self.method == MethodName::default();
        if is_default
            && !self.lights_given
            && self.claim() != Some(ClaimName::Certified)
            && self.truth() == Truth::Transport
        {
            // A number of paths without an error is a request for that number, without a claim.
            let is_count = self.paths.is_some() && self.error.is_none();
            let claim = self.claim().or((!is_count).then_some(ClaimName::Calibrated));
            return Self { method: MethodName::Path, claim, ..self.clone() };
        }
        self.clone()
    }

    /// Returns the plan of the request in a scene.
    ///
    /// # Errors
    /// [`Error::Option`] with the field that is out of range, or contradicts the others or the
    /// scene.
    pub fn plan(&self, scene: &Scene) -> Result<Plan> {
        let request = self.in_scene(scene);
        let plan = request.plan_for_still_scene()?;
        scene.check_method(request.method.name(), plan.method.abilities())?;
        Ok(plan)
    }

    /// Returns the plan of the request in a scene that neither moves nor scatters light in media.
    ///
    /// # Errors
    /// [`Error::Option`] with the field that is out of range or contradicts the others.
    pub fn plan_for_still_scene(&self) -> Result<Plan> {
        Ok(Plan { method: self.planned()?, gather: self.gather_options()?, unused: self.unused() })
    }

    /// Refuses options that are out of range, or that contradict each other in every scene.
    ///
    /// # Errors
    /// [`Error::Option`] with one such option.
    pub fn validate(&self) -> Result<()> {
        self.check()?;
        self.planned().and(self.gather_options()).map(drop)
    }

    /// Method with all of its options.
    fn planned(&self) -> Result<Method> {
        let options = self.control_options()?;
        let is_certified = self.method.of_lights() == Some(SumMethod::Tashika(Promise::Certified));
        if is_certified && self.claim() == Some(ClaimName::Calibrated) {
            let method = Promise::Certified.method_name();
            return Err(Error::option(
                "claim",
                ClaimName::Calibrated,
                format!("certified, or a method other than {method}"),
            ));
        }
        Ok(match self.sum_method() {
            method if self.is_audited() => self.audited(method, options)?,
            None => self.path_tracing(options)?,
            Some(method) if self.is_about_all_sets() => {
                let truth = self.truth();
                if method == SumMethod::Tashika(Promise::Certified) {
                    let expected = format!("calibrated with truth {truth}, about which there is no proof");
                    return Err(Error::option("claim", "certified", expected));
                }
                Method::Transport {
                    lights: if self.lights_given { None } else { Some(self.many_lights()?) },
                    truth,
                    options,
                }
            }
            Some(method) => {
                let lights = if self.lights_given { None } else { Some(self.lights()?) };
                Method::Sum { method, lights, options }
            }
        })
    }

    /// Options for tracing one set of VPLs.
    ///
    /// # Errors
    /// As [`VplOptions::validate`].
    pub fn lights(&self) -> Result<VplOptions> {
        self.lights_of(VplOptions::default().count)
    }

    /// Options for tracing VPLs where the truth is about all sets of them.
    ///
    /// # Errors
    /// As [`VplOptions::validate`].
    pub fn many_lights(&self) -> Result<VplOptions> {
        let [fewest, most] = MANY_VPLS;
        let error = self.error();
        self.control_options()?;
        self.lights_of((VPLS_BY_ERROR / (error * error)).clamp(fewest, most).round() as u64)
    }

    /// Options of the gather points.
    ///
    /// # Errors
    /// As [`GatherOptions::validate`].
    pub fn gather_options(&self) -> Result<GatherOptions> {
        let default = GatherOptions::default();
        let [fewest, most] = MANY_POINTS;
        let by_error = |error: f64| (POINTS_BY_ERROR / error).clamp(fewest, most) as u64;
        let many = || by_error(self.error());
        let said = self.gather.or_else(|| self.is_about_all_sets().then(many));
        let options = GatherOptions {
            points: said.map_or(default.points, saturated),
            filter: self.filter.unwrap_or(default.filter),
        };
        options.validate()?;
        Ok(options)
    }

    /// Returns the paths a pixel, if given.
    ///
    /// # Errors
    /// [`Error::Option`] if the number is zero or above `u32::MAX`.
    pub fn path_count(&self) -> Result<Option<u32>> {
        let Some(said) = self.paths else { return Ok(None) };
        let count = u32::try_from(said).ok().filter(|n| *n > 0);
        count.map(Some).ok_or_else(|| Error::option("paths", said, format!("1 to {}", u32::MAX)))
    }

    /// Paths a pixel for planes of light groups, where radiance is not computed by paths: the given
    /// number, or 64.
    ///
    /// # Errors
    /// As [`path_count`](Self::path_count).
    pub fn paths_of_groups(&self) -> Result<u32> {
        Ok(self.path_count()?.unwrap_or(PATHS))
    }

    /// Returns the claim, if the request has one: the given claim, or [`ClaimName::Audited`] for
    /// the default method without an error and without any option that only a claim about each
    /// pixel or a fixed number of paths has.
    pub fn claim(&self) -> Option<ClaimName> {
        let is_of_pixels = self.error.is_some()
            || self.lights_given
            || self.groups_asked
            || self.truth.is_some_and(|truth| truth != Truth::Transport)
            || self.control.is_some_and(|control| control != Controlled::Luminance)
            || [self.max_pairs, self.paths].iter().any(Option::is_some)
            || self.confidence.is_some();
        let is_picture = self.method == MethodName::default() && !is_of_pixels;
        self.claim.or(is_picture.then_some(ClaimName::Audited))
    }

    /// Time limit of a picture of `pixels` pixels for which neither precision nor work is set (s):
    /// 30 s for 640×360, in proportion to the pixels, and at least 8 s. `None` for other requests.
    pub fn default_seconds(&self, pixels: u64) -> Option<f64> {
        let is_open = self.is_audited() && self.claim.is_none() && self.passes.is_none();
        is_open.then(|| (PICTURE_SECONDS * pixels as f64 / PICTURE_PIXELS).max(FEWEST_SECONDS))
    }

    /// Number of passes of an audited picture, if given.
    fn fixed_passes(&self) -> Result<Option<u32>> {
        let Some(said) = self.passes else { return Ok(None) };
        let count = u32::try_from(said).ok().filter(|count| (1..=AuditTerms::MAX_PASSES).contains(count));
        let expected = || Error::option("passes", said, format!("1 to {}", AuditTerms::MAX_PASSES));
        count.map(Some).ok_or_else(expected)
    }

    /// Method with the claim of the request; `None` for path tracing.
    fn sum_method(&self) -> Option<SumMethod> {
        match (self.method.of_lights(), self.claim().and_then(ClaimName::promise)) {
            (Some(SumMethod::Tashika(_)), Some(promise)) => Some(SumMethod::Tashika(promise)),
            (method, _) => method,
        }
    }

    fn truth(&self) -> Truth {
        let is_of_a_sum =
            self.lights_given || self.sum_method() == Some(SumMethod::Tashika(Promise::Certified));
        self.truth.unwrap_or(if is_of_a_sum { Truth::Vpl } else { Truth::Transport })
    }

    fn error(&self) -> f64 {
        let unsaid = match (self.is_audited(), self.is_about_all_sets() || self.is_by_calibrated_paths()) {
            (true, _) => AUDITED_ERROR,
            (false, true) => PICTURE_ERROR,
            (false, false) => ControlOptions::default().error,
        };
        self.error.unwrap_or(unsaid)
    }

    /// Returns true if the claim is about the picture as a whole.
    pub fn is_audited(&self) -> bool {
        let is_picture = self.is_ours() || self.method == MethodName::Path;
        is_picture && self.claim() == Some(ClaimName::Audited)
    }

    /// Method of an audited picture: `method`, or path tracing if there is none.
    fn audited(&self, method: Option<SumMethod>, options: ControlOptions) -> Result<Method> {
        if let Some(method) = method.filter(|method| *method != SumMethod::Tashika(Promise::Calibrated)) {
            return Err(Error::option("method", method.name(), "tashika or path with claim audited"));
        }
        if method.is_some() && self.lights_given {
            let expected = "lights that are traced, for the picture and apart from them for its audit";
            return Err(Error::option("lights", "given ones", expected));
        }
        if method.is_some() && self.truth() != Truth::Transport {
            return Err(Error::option("truth", self.truth(), "transport with claim audited"));
        }
        if options.controlled != Controlled::Luminance {
            return Err(Error::option("control", options.controlled, "luminance with claim audited"));
        }
        let default = AuditTerms::default();
        let terms = AuditTerms {
            share: self.share.unwrap_or(default.share),
            assurance: self.assurance.unwrap_or(default.assurance),
            pixels: self.audit.unwrap_or(default.pixels),
            ..default
        };
        terms.validate()?;
        let [fewest, most] = AUDITED_VPLS;
        let count = (AUDITED_VPLS_BY_ERROR / (options.error * options.error)).round().clamp(fewest, most);
        let lights = method.map(|_| self.lights_of(count as u64)).transpose()?;
        Ok(Method::Audited { lights, options, terms, passes: self.fixed_passes()? })
    }

    fn is_ours(&self) -> bool {
        matches!(self.method, MethodName::ManyLights(SumMethod::Tashika(_)))
    }

    /// Returns true if the truth does not depend on one set of VPLs.
    fn is_about_all_sets(&self) -> bool {
        self.is_ours() && self.truth() != Truth::Vpl
    }

    fn lights_of(&self, count: u64) -> Result<VplOptions> {
        let default = VplOptions::default();
        let options = VplOptions {
            count: self.vpls.unwrap_or(count),
            clamp: self.clamp.unwrap_or(default.clamp),
            instants: self.instants.map_or(default.instants, saturated),
            seed: self.seed,
            ..default
        };
        options.validate()?;
        Ok(options)
    }

    fn control_options(&self) -> Result<ControlOptions> {
        let default = ControlOptions::default();
        let options = ControlOptions {
            error: self.error(),
            controlled: self.control.unwrap_or(default.controlled),
            absolute_error: self.absolute.unwrap_or(default.absolute_error),
            confidence: self.confidence.unwrap_or(default.confidence),
            max_pairs: self.max_pairs,
            seed: self.seed,
        };
        options.validate()?;
        Ok(options)
    }

    /// Returns true if path tracing states our own interval.
    fn is_by_calibrated_paths(&self) -> bool {
        self.method == MethodName::Path && self.claim() == Some(ClaimName::Calibrated)
    }

    /// Path tracing and its stopping rule: our own interval with a calibrated claim, else Student's
    /// interval if an error was given, else the number of paths.
    fn path_tracing(&self, options: ControlOptions) -> Result<Method> {
        let said = self.path_count()?;
        let most = said.unwrap_or(MOST_PATHS);
        let is_calibrated = self.is_by_calibrated_paths();
        let stop = match self.error {
            _ if is_calibrated => PathStop::Calibrated { options, most: most.max(2) },
            Some(_) => PathStop::until(options, most),
            None => PathStop::Count(said.unwrap_or(PATHS)),
        };
        Ok(Method::Path { stop })
    }
}

/// Converts a count to `u32`. Larger counts become `u32::MAX`, which is out of range as well.
fn saturated(count: u64) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}
