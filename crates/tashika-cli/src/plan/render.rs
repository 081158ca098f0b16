//! What is to be done by `render`.

use std::path::PathBuf;

use tashika::gather::GatherOptions;
use tashika::integrator::{self, ControlOptions};
use tashika::io::ToneMap;
use tashika::render::TileShare;

use super::{Common, Lights, StagePlan, gather_options, with_ending};
use crate::args::{Claim, Method, RenderArgs};
use crate::exit::Failure;

/// Paths a pixel where the user does not say.
const DEFAULT_PATHS: u32 = 64;

/// How pixels are computed, with what only that method needs.
#[derive(Debug)]
pub enum Integration {
    /// A sum over VPLs.
    ManyLights {
        /// How the sum is found.
        method: integrator::Method,
        /// What is summed over.
        lights: Lights,
        /// What methods that control their error are told.
        options: ControlOptions,
    },
    /// Path tracing with so many paths a pixel.
    Path(u32),
}

/// A render.
#[derive(Debug)]
pub struct RenderPlan {
    /// Scene, camera, size.
    pub stage: StagePlan,
    /// Which tiles.
    pub share: TileShare,
    /// Gather points.
    pub gather: GatherOptions,
    /// Method.
    pub integration: Integration,
    /// Seed of the camera samples.
    pub seed: u64,
    /// Image to write.
    pub exr: PathBuf,
    /// Picture to write.
    pub png: PathBuf,
    /// How the picture is made.
    pub tone_map: ToneMap,
    /// What every command has.
    pub common: Common,
    /// Options that were typed and mean nothing to the method.
    pub unused: Vec<&'static str>,
    /// Pixels whose exact sums are computed after the render, if the method controls its error.
    pub audit: Option<u64>,
}

impl RenderPlan {
    /// Checks what was typed, and that the outputs can be written.
    pub fn new(args: &RenderArgs) -> Result<Self, Failure> {
        let stage = StagePlan::new(&args.stage, args.crop)?;
        let gather = gather_options(args.gather.points)?;
        let tone_map = ToneMap { exposure: args.exposure };
        tone_map.validate()?;
        let (integration, unused) = integration(args)?;
        let exr = with_ending(&args.output, "exr")?;
        let png = exr.with_extension("png");
        let inputs = stage.inputs(args.source.vpl_file.as_deref());
        let common = Common::new(&args.common, &[&exr, &png], &inputs)?;
        Ok(Self {
            stage,
            share: args.tiles.unwrap_or_default(),
            gather,
            integration,
            seed: args.seed,
            exr,
            png,
            tone_map,
            common,
            audit: args.audit.filter(|_| !unused.contains(&"--audit")),
            unused,
        })
    }

    /// The lights, if the method has any.
    pub fn lights(&self) -> Option<&Lights> {
        match &self.integration {
            Integration::ManyLights { lights, .. } => Some(lights),
            Integration::Path(_) => None,
        }
    }
}

fn integration(args: &RenderArgs) -> Result<(Integration, Vec<&'static str>), Failure> {
    use integrator::Method as Many;
    let method = match args.method {
        Method::Exact => Some(Many::Exact),
        Method::Lightcuts => Some(Many::Lightcuts),
        Method::Mdlc => Some(Many::Mdlc),
        Method::Nabata2016 => Some(Many::Nabata2016),
        Method::Sakai2018 => Some(Many::Sakai2018),
        Method::Iwasaki2019 => Some(Many::Iwasaki2019),
        Method::Tashika => Some(Many::Tashika(match args.claim {
            None | Some(Claim::Calibrated) => integrator::Claim::Calibrated,
            Some(Claim::Certified) => integrator::Claim::Certified,
        })),
        Method::Path => None,
    };
    let controlled = method.is_some_and(|method| method != Many::Exact);
    let typed_in_vain = [
        ("--vpls", args.source.lights.vpls.is_some() && method.is_none()),
        ("--clamp", args.source.lights.clamp.clamp.is_some() && method.is_none()),
        ("--vpl-file", args.source.vpl_file.is_some() && method.is_none()),
        ("--gather", args.gather.points.is_some() && method.is_none()),
        ("--paths", args.paths.is_some() && method.is_some()),
        ("--error", args.error.is_some() && !controlled),
        ("--control", args.control.is_some() && args.method != Method::Tashika),
        ("--absolute", args.absolute.is_some() && args.method != Method::Tashika),
        ("--confidence", args.confidence.is_some() && !method.is_some_and(Many::states_interval)),
        ("--claim", args.claim.is_some() && args.method != Method::Tashika),
        ("--audit", args.audit.is_some() && !controlled),
        ("--max-pairs", args.max_pairs.is_some() && !controlled),
    ];
    let unused = typed_in_vain.into_iter().filter(|(_, vain)| *vain).map(|(option, _)| option).collect();
    let default = ControlOptions::default();
    let options = ControlOptions {
        error: args.error.unwrap_or(default.error),
        controlled: args.control.unwrap_or_default(),
        absolute_error: args.absolute.unwrap_or(default.absolute_error),
        confidence: args.confidence.unwrap_or(default.confidence),
        max_pairs: args.max_pairs,
        seed: args.seed,
    };
    options.validate()?;
    let Some(method) = method else {
        let paths = match args.paths {
            None => DEFAULT_PATHS,
            Some(n) => u32::try_from(n)
                .ok()
                .filter(|n| *n > 0)
                .ok_or_else(|| Failure::option("paths", n, format!("1 to {}", u32::MAX)))?,
        };
        return Ok((Integration::Path(paths), unused));
    };
    let lights = Lights::of(&args.source, args.seed)?;
    Ok((Integration::ManyLights { method, lights, options }, unused))
}
