//! What is to be done by `render`.

use std::path::{Path, PathBuf};

use tashika::gather::GatherOptions;
use tashika::integrator;
use tashika::io::ToneMap;
use tashika::render::TileShare;
use tashika::request::{Integration, Request, Resolved};

use super::{Common, Lights, Outputs, Serving, StagePlan};
use crate::args::{Claim, Method, RenderArgs};
use crate::exit::Failure;

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
    /// The one set of lights, if the method sums over one, or if it is given.
    pub lights: Option<Lights>,
    /// Where the lights are written, if they are all that is made.
    pub write_vpls: Option<PathBuf>,
    /// Seed of the camera samples.
    pub seed: u64,
    /// Files to write; of several cameras, what theirs are named after.
    pub outputs: Outputs,
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
    pub unused: Vec<String>,
    /// Pixels whose exact sums are computed after the render, if the method controls its error.
    pub audit: Option<u64>,
}

impl RenderPlan {
    /// Checks what was typed, and that the outputs can be written.
    pub fn new(args: &RenderArgs) -> Result<Self, Failure> {
        let stage = StagePlan::new(&args.stage, args.crop)?;
        let tone_map = ToneMap { exposure: args.exposure };
        tone_map.validate()?;
        let Resolved { integration, gather, unused } = request(args).resolve()?;
        let mut unused: Vec<String> = unused.into_iter().map(typed).collect();
        let lights = match &integration {
            Integration::ManyLights { lights: Some(options), .. } => Some(Lights::Trace(options.clone())),
            Integration::ManyLights { lights: None, .. } | Integration::Transport { lights: None, .. } => {
                args.source.vpl_file.clone().map(Lights::File)
            }
            Integration::Transport { .. } | Integration::Path(_) => None,
        };
        if args.write_vpls.is_some() && matches!(integration, Integration::Path(_)) {
            return Err(Failure::usage("--write-vpls: --method path has no virtual point lights"));
        }
        let audit = args.audit.filter(|_| can_be_audited(&integration));
        if audit.is_none() && args.audit.is_some() {
            unused.push("--audit".to_owned());
        }
        let outputs = Outputs::new(&args.output, args.common.json.clone())?;
        let Outputs { exr, png, html, .. } = &outputs;
        let several = stage.cameras.several();
        if let (true, Some(option)) = (several, of_one_image(args)) {
            let cameras = stage.cameras.typed();
            return Err(Failure::option("camera", cameras, format!("one camera with {option}")));
        }
        let inputs = stage.inputs(args.source.vpl_file.as_deref());
        if !args.serve && (args.serving.port != 0 || args.serving.no_browser) {
            return Err(Failure::usage("--port and --no-browser go with --serve"));
        }
        let told = args.common.log_file.is_some();
        let serve = args.serve.then(|| Serving::new(&args.serving, args.common.quiet, told)).transpose()?;
        let checkpoint = args.checkpoint.then(|| {
            let mut path = exr.clone().into_os_string();
            path.push(".checkpoint");
            PathBuf::from(path)
        });
        let written: Vec<&Path> = match &args.write_vpls {
            Some(path) => vec![path],
            // The names are known when the scene is.
            None if several => Vec::new(),
            None => [exr, png, html].into_iter().chain(&checkpoint).map(PathBuf::as_path).collect(),
        };
        let common = Common::new(&args.common, &written, &inputs)?;
        Ok(Self {
            stage,
            share: args.tiles.clone().unwrap_or_default(),
            gather,
            lights,
            write_vpls: args.write_vpls.clone(),
            seed: args.seed,
            outputs,
            tone_map,
            tev: args.tev.clone(),
            checkpoint,
            accept_budget: integration.is_picture() || args.budget.accept_budget,
            serve,
            common,
            integration,
            audit,
            unused,
        })
    }
}

/// An option that goes with one image only.
fn of_one_image(args: &RenderArgs) -> Option<&'static str> {
    [
        (args.write_vpls.is_some(), "--write-vpls"),
        (args.checkpoint, "--checkpoint"),
        (args.serve, "--serve"),
        (args.tev.is_some(), "--tev"),
    ]
    .into_iter()
    .find_map(|(typed, option)| typed.then_some(option))
}

/// Whether something was promised that is not computed anyway.
fn can_be_audited(integration: &Integration) -> bool {
    match integration {
        Integration::ManyLights { method, .. } => *method != integrator::Method::Exact,
        Integration::Transport { .. } => true,
        Integration::Path(_) => false,
    }
}

/// An option as it is typed, by its name in a request.
fn typed(name: &str) -> String {
    match name {
        "lights" => "--vpl-file".to_owned(),
        _ => format!("--{}", name.replace('_', "-")),
    }
}

fn request(args: &RenderArgs) -> Request {
    use integrator::{Method as Many, Promise};
    Request {
        method: match args.method {
            Method::Exact => Some(Many::Exact),
            Method::Lightcuts => Some(Many::Lightcuts),
            Method::Mdlc => Some(Many::Mdlc),
            Method::Nabata2016 => Some(Many::Nabata2016),
            Method::Sakai2018 => Some(Many::Sakai2018),
            Method::Iwasaki2019 => Some(Many::Iwasaki2019),
            Method::Tashika => Some(Many::Tashika(Promise::Calibrated)),
            Method::TashikaCertified => Some(Many::Tashika(Promise::Certified)),
            Method::Path => None,
        },
        claim: args.claim.map(|claim| match claim {
            Claim::Calibrated => Promise::Calibrated,
            Claim::Certified => Promise::Certified,
        }),
        truth: args.truth,
        error: args.error,
        control: args.control,
        absolute: args.absolute,
        confidence: args.confidence,
        max_pairs: args.max_pairs,
        paths: args.paths,
        lights_given: args.source.vpl_file.is_some(),
        vpls: args.source.lights.vpls,
        clamp: args.source.lights.clamp.clamp,
        gather: args.gather.points,
        filter: args.gather.filter.filter,
        seed: args.seed,
    }
}
