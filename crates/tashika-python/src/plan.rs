//! What is to be rendered: every argument checked before any work, with the defaults of the program.

use pyo3::prelude::*;
use tashika::gather::GatherOptions;
use tashika::integrator::{Claim, ControlOptions, LightSets, Method, PathStop, Truth};
use tashika::vpl::VplOptions;

use crate::errors::{option, raised};
use crate::vpls::{self, Lights};
use crate::words;

/// Paths a pixel where the caller does not say.
const DEFAULT_PATHS: u32 = 64;
/// Paths at which the interval of a path tracer is looked at first.
const FIRST_PATHS: u32 = 64;
/// Paths a pixel at most where its interval ends it.
const MOST_PATHS: u32 = 1 << 20;
/// VPLs of each of many sets where the caller does not say.
const VPLS_OF_SET: u64 = 30_000;
/// Gather points of each of many repetitions where the caller does not say.
const POINTS_OF_SET: u32 = 16;

/// How pixels are computed.
pub enum Integration {
    /// A sum over one set of VPLs.
    ManyLights(Method, Lights, ControlOptions),
    /// Independent sets of VPLs.
    Transport(VplOptions, u32, Truth, ControlOptions),
    /// Path tracing.
    Path(PathStop),
}

/// What was said of the method; nothing stands for the default.
pub struct Said<'a, 'py> {
    pub method: &'a str,
    pub error: Option<f64>,
    pub confidence: Option<f64>,
    pub claim: Option<&'a str>,
    pub truth: Option<&'a str>,
    pub control: Option<&'a str>,
    pub absolute: Option<f64>,
    pub max_pairs: Option<u64>,
    pub paths: Option<u32>,
    pub sets: Option<u32>,
    pub vpls: Option<&'a Bound<'py, PyAny>>,
    pub clamp: Option<&'a Bound<'py, PyAny>>,
    pub gather: Option<u32>,
    pub seed: u64,
}

impl Said<'_, '_> {
    /// The plan, the gather points, and the arguments that mean nothing to the method.
    pub fn plan(&self) -> PyResult<(Integration, GatherOptions, Vec<&'static str>)> {
        let method = self.method()?;
        let truth =
            self.truth.map_or(Ok(Truth::default()), |name| words::named("truth", name, &Truth::ALL))?;
        let of_sets = matches!(method, Some(Method::Tashika(_))) && truth != Truth::Vpl;
        let unused = self.unused(method, of_sets);
        let options = self.options()?;
        let (integration, points) = match method {
            None => (Integration::Path(self.stop(options)?), GatherOptions::default().points),
            Some(method) if of_sets => (self.transport(method, truth, options)?, POINTS_OF_SET),
            Some(method) => {
                let lights = Lights::of(self.vpls, self.clamp, self.seed)?;
                (Integration::ManyLights(method, lights, options), GatherOptions::default().points)
            }
        };
        Ok((integration, gather(self.gather.or(Some(points)))?, unused))
    }

    /// The method; none is the path tracer.
    fn method(&self) -> PyResult<Option<Method>> {
        match (self.method, self.claim) {
            ("path", _) => Ok(None),
            ("tashika", Some(claim)) => Ok(Some(Method::Tashika(words::claim(claim)?))),
            (name, _) => Method::ALL.into_iter().find(|m| m.name() == name).map(Some).ok_or_else(|| {
                let names = Method::ALL.map(Method::name).join(", ");
                option("method", name, format!("one of {names}, path"))
            }),
        }
    }

    fn options(&self) -> PyResult<ControlOptions> {
        let default = ControlOptions::default();
        let control = |name| words::named("control", name, &tashika::color::Controlled::ALL);
        let options = ControlOptions {
            error: self.error.unwrap_or(default.error),
            controlled: self.control.map_or(Ok(default.controlled), control)?,
            absolute_error: self.absolute.unwrap_or(default.absolute_error),
            confidence: self.confidence.unwrap_or(default.confidence),
            max_pairs: self.max_pairs,
            seed: self.seed,
        };
        options.validate().map_err(raised)?;
        Ok(options)
    }

    /// When the path tracer stops: by its interval, if an error was said.
    fn stop(&self, options: ControlOptions) -> PyResult<PathStop> {
        if self.paths == Some(0) {
            return Err(option("paths", 0, format!("1 to {}", u32::MAX)));
        }
        Ok(if self.error.is_some() {
            let most = self.paths.unwrap_or(MOST_PATHS).max(2);
            PathStop::Until { options, first: FIRST_PATHS.min(most), most }
        } else {
            PathStop::Count(self.paths.unwrap_or(DEFAULT_PATHS))
        })
    }

    fn transport(&self, method: Method, truth: Truth, options: ControlOptions) -> PyResult<Integration> {
        if method == Method::Tashika(Claim::Certified) {
            let expected = format!("calibrated with truth={truth}, about which there is no proof");
            return Err(option("claim", "certified", expected));
        }
        let count = self.vpls.map_or(Ok(VPLS_OF_SET), vpls::number)?;
        let lights = vpls::options(Some(count), self.seed, self.clamp)?;
        let sets = self.sets.unwrap_or(LightSets::DEFAULT_COUNT);
        LightSets::check(sets).map_err(raised)?;
        Ok(Integration::Transport(lights, sets, truth, options))
    }

    fn unused(&self, method: Option<Method>, of_sets: bool) -> Vec<&'static str> {
        let is_path = method.is_none();
        let controlled = method != Some(Method::Exact);
        let until = is_path && self.error.is_some();
        let is_tashika = matches!(method, Some(Method::Tashika(_)));
        let said_in_vain = [
            ("vpls", self.vpls.is_some() && is_path),
            ("clamp", self.clamp.is_some() && is_path),
            ("gather", self.gather.is_some() && is_path),
            ("paths", self.paths.is_some() && !is_path),
            ("error", self.error.is_some() && !controlled),
            ("control", self.control.is_some() && !(is_tashika || until)),
            ("absolute", self.absolute.is_some() && !(is_tashika || until)),
            (
                "confidence",
                self.confidence.is_some() && !until && !method.is_some_and(Method::states_interval),
            ),
            ("claim", self.claim.is_some() && self.method != "tashika"),
            ("truth", self.truth.is_some() && !is_tashika),
            ("sets", self.sets.is_some() && !of_sets),
            ("max_pairs", self.max_pairs.is_some() && (!controlled || is_path || of_sets)),
        ];
        said_in_vain.into_iter().filter(|(_, vain)| *vain).map(|(name, _)| name).collect()
    }
}

/// So many gather points a pixel, or the default.
pub fn gather(points: Option<u32>) -> PyResult<GatherOptions> {
    let default = GatherOptions::default();
    let options = GatherOptions { points: points.unwrap_or(default.points), ..default };
    options.validate().map_err(raised)?;
    Ok(options)
}
