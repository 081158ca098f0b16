//! What is to be done by `render`.

use std::path::{Path, PathBuf};

use tashika::gather::GatherOptions;
use tashika::integrator::{self, ControlOptions, LightSets, PathStop, Truth};
use tashika::io::ToneMap;
use tashika::render::TileShare;
use tashika::vpl::VplOptions;

use super::{Common, Lights, Serving, StagePlan, gather_options, vpl_options, with_ending};
use crate::args::{Claim, LightArgs, Method, RenderArgs};
use crate::exit::Failure;

/// Paths a pixel where the user does not say.
const DEFAULT_PATHS: u32 = 64;
/// Paths at which the interval of a path tracer is looked at first.
pub(super) const FIRST_PATHS: u32 = 64;
/// Paths a pixel at most where its interval ends it.
const MOST_PATHS: u32 = 1 << 20;
/// VPLs of each of many sets where the user does not say.
const VPLS_OF_SET: u64 = 30_000;

/// Gather points of each of many repetitions where the user does not say.
pub(super) const POINTS_OF_SET: u64 = 16;

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
    /// Independent sets of VPLs.
    Transport {
        /// How each set is traced.
        lights: VplOptions,
        /// How many sets.
        sets: u32,
        /// Light transport, or what is left of it without what VPLs do not carry.
        truth: Truth,
        /// What is promised.
        options: ControlOptions,
    },
    /// Path tracing.
    Path(PathStop),
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
    /// Page to write.
    pub html: PathBuf,
    /// How the picture is made.
    pub tone_map: ToneMap,
    /// Where the viewer listens that is to show it meanwhile.
    pub tev: Option<String>,
    /// Whether pixels that ran out of budget are no matter.
    pub accept_budget: bool,
    /// Where finished tiles are kept meanwhile, if they are.
    pub checkpoint: Option<PathBuf>,
    /// How it is shown in the browser, if it is.
    pub serve: Option<Serving>,
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
        let tone_map = ToneMap { exposure: args.exposure };
        tone_map.validate()?;
        let (integration, unused) = integration(args)?;
        let gather = match &integration {
            Integration::Transport { .. } => gather_options(args.gather.points.or(Some(POINTS_OF_SET)))?,
            Integration::ManyLights { .. } | Integration::Path(_) => gather_options(args.gather.points)?,
        };
        let exr = with_ending(&args.output, "exr")?;
        let [png, html] = ["png", "html"].map(|ending| exr.with_extension(ending));
        let inputs = stage.inputs(args.source.vpl_file.as_deref());
        if !args.serve && (args.serving.port != 0 || args.serving.no_browser) {
            return Err(Failure::usage("--port and --no-browser go with --serve"));
        }
        let checkpoint = args.checkpoint.then(|| {
            let mut path = exr.clone().into_os_string();
            path.push(".checkpoint");
            PathBuf::from(path)
        });
        let outputs: Vec<&Path> =
            [&exr, &png, &html].into_iter().chain(&checkpoint).map(PathBuf::as_path).collect();
        let common = Common::new(&args.common, &outputs, &inputs)?;
        Ok(Self {
            stage,
            share: args.tiles.clone().unwrap_or_default(),
            gather,
            integration,
            seed: args.seed,
            exr,
            png,
            html,
            tone_map,
            tev: args.tev.clone(),
            checkpoint,
            accept_budget: args.budget.accept_budget,
            serve: args.serve.then(|| Serving::new(&args.serving)),
            common,
            audit: args.audit.filter(|_| !unused.contains(&"--audit")),
            unused,
        })
    }

    /// Whether an error is promised.
    pub fn promises(&self) -> bool {
        !matches!(self.integration, Integration::Path(PathStop::Count(_)))
    }

    /// The lights, if the method has any.
    pub fn lights(&self) -> Option<&Lights> {
        match &self.integration {
            Integration::ManyLights { lights, .. } => Some(lights),
            Integration::Transport { .. } | Integration::Path(_) => None,
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
    let truth = args.truth.unwrap_or_default();
    let controlled = method != Some(Many::Exact);
    let is_tashika = args.method == Method::Tashika;
    let of_sets = is_tashika && truth != Truth::Vpl;
    if of_sets && args.claim == Some(Claim::Certified) {
        let message = format!("--claim certified goes with --truth vpl: there is no proof about {truth}");
        return Err(Failure::usage(message));
    }
    if of_sets && args.source.vpl_file.is_some() {
        let message = format!("--vpl-file is one set, but --truth {truth} needs many; leave one of them out");
        return Err(Failure::usage(message));
    }
    let until = method.is_none() && args.error.is_some();
    let typed_in_vain = [
        ("--vpls", args.source.lights.vpls.is_some() && method.is_none()),
        ("--clamp", args.source.lights.clamp.clamp.is_some() && method.is_none()),
        ("--vpl-file", args.source.vpl_file.is_some() && method.is_none()),
        ("--gather", args.gather.points.is_some() && method.is_none()),
        ("--paths", args.paths.is_some() && method.is_some()),
        ("--error", args.error.is_some() && !controlled),
        ("--control", args.control.is_some() && !(is_tashika || until)),
        ("--absolute", args.absolute.is_some() && !(is_tashika || until)),
        ("--confidence", args.confidence.is_some() && !until && !method.is_some_and(Many::states_interval)),
        ("--claim", args.claim.is_some() && !is_tashika),
        ("--truth", args.truth.is_some() && !is_tashika),
        ("--sets", args.sets.is_some() && !of_sets),
        ("--audit", args.audit.is_some() && !(controlled && method.is_some())),
        ("--max-pairs", args.max_pairs.is_some() && (!controlled || method.is_none() || of_sets)),
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
        let paths = |default| args.paths.map_or(Ok(default), path_count);
        let length = if until {
            let most = paths(MOST_PATHS)?.max(2);
            PathStop::Until { options, first: FIRST_PATHS.min(most), most }
        } else {
            PathStop::Count(paths(DEFAULT_PATHS)?)
        };
        return Ok((Integration::Path(length), unused));
    };
    if of_sets {
        let (lights, sets) = light_sets(&args.source.lights, args.sets, args.seed)?;
        return Ok((Integration::Transport { lights, sets, truth, options }, unused));
    }
    let lights = Lights::of(&args.source, args.seed)?;
    Ok((Integration::ManyLights { method, lights, options }, unused))
}

/// How each of many sets is traced, and how many there are.
pub(super) fn light_sets(
    args: &LightArgs,
    sets: Option<u64>,
    seed: u64,
) -> Result<(VplOptions, u32), Failure> {
    let lights = vpl_options(Some(args.vpls.unwrap_or(VPLS_OF_SET)), &args.clamp, seed)?;
    // Counts beyond `u32` are as far out of range as `u32::MAX`.
    let sets = sets.map_or(LightSets::DEFAULT_COUNT, |n| u32::try_from(n).unwrap_or(u32::MAX));
    LightSets::check(sets)?;
    Ok((lights, sets))
}

/// That many paths.
pub(super) fn path_count(n: u64) -> Result<u32, Failure> {
    let count = u32::try_from(n).ok().filter(|n| *n > 0);
    count.ok_or_else(|| Failure::option("paths", n, format!("1 to {}", u32::MAX)))
}
