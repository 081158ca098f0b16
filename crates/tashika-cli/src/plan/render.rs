//! Plan of `render`.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use tashika::film::{Matte, Window};
use tashika::io::{ExrLayout, ToneMap};
use tashika::reconstruction::Smoother;
use tashika::report::LuminanceScale;
use tashika::request::{ClaimName, MethodName, Request};
use tashika::scene::LightGrouping;
use tashika_oidn::Oidn;

use super::{Asked, Common, Frames, Outputs, Serving, StagePlan, tone_map};
use crate::args::{FalseColorArgs, RenderArgs};
use crate::exit::Failure;

/// Checked arguments of `render`.
#[derive(Debug)]
pub struct RenderPlan {
    /// Scene, camera, size.
    pub stage: StagePlan,
    /// Request for pixels and planes.
    pub asked: Asked,
    /// File that the lights are written to, if nothing is rendered.
    pub write_vpls: Option<PathBuf>,
    /// Frames of an animation; `None` for the scene at one time.
    pub frames: Option<Frames>,
    /// Files to write; with several cameras or frames, their names are derived from these.
    pub outputs: Outputs,
    /// Layout of the image file.
    pub layout: ExrLayout,
    /// Exposure and tone mapping of the picture.
    pub tone_map: ToneMap,
    /// Scale of the picture of luminances in false colours, if one is written.
    pub luminance: Option<LuminanceScale>,
    /// Address of the viewer that shows the image during the render.
    pub tev: Option<String>,
    /// True if pixels that ran out of budget do not change the exit code, even if an error was
    /// requested.
    pub accept_budget: bool,
    /// File that keeps finished tiles during the render, if there is one.
    pub checkpoint: Option<PathBuf>,
    /// Port and browser of the page that shows the render; `None` without such a page.
    pub serve: Option<Serving>,
    /// Options of every command.
    pub common: Common,
    /// Time limit of an audited picture, if one was given.
    pub time: Option<Duration>,
    /// Number of pixels whose truths are computed after the render.
    pub audit: Option<u64>,
}

impl RenderPlan {
    /// Checks the arguments, and that the outputs can be written.
    pub fn new(args: &RenderArgs) -> Result<Self, Failure> {
        let stage = StagePlan::new(&args.stage, args.crop)?;
        let tone_map = tone_map(&args.picture)?;
        let share = args.tiles.clone().unwrap_or_default();
        let asked = Asked { share, ..Asked::new(request(args)?, args.source.vpl_file.as_deref())? };
        let is_audited = asked.request.is_audited();
        if let Some(time) = args.time {
            asked.request.check_audited("time", format!("{time:?}"))?;
        }
        if let Some(name) = &args.denoiser {
            asked.request.check_audited("denoiser", name.display())?;
        }
        let smoother = if is_audited { smoother(args)? } else { None };
        let asked =
            Asked { smoother, mattes: args.planes.cryptomatte.map(Matte::ranks).transpose()?, ..asked };
        let asked = Asked { motion_vectors: args.planes.motion_vectors, ..asked };
        let typed = args.planes.groups.iter().map(String::as_str);
        let groups = (!args.planes.groups.is_empty()).then(|| LightGrouping::parse(typed)).transpose()?;
        let asked = Asked { groups, ..asked };
        asked.request.check_passes(args.time.is_some(), asked.share.is_whole())?;
        if args.time.is_some() && is_audited && !asked.share.is_whole() {
            return Err(Failure::usage(
                "--time: a part (--tiles) of a picture with --claim audited is a fixed amount of work, so that \
                 all parts together are the same picture",
            ));
        }
        let luminance = luminance(&args.false_color)?;
        let outputs = Outputs::new(&args.output, args.common.json.clone())?;
        let outputs = if luminance.is_some() { outputs.with_luminance() } else { outputs };
        let frames = Frames::new(&args.frames)?;
        let one = frames.map_or_else(|| outputs.clone(), |frames| outputs.of_frame(frames.first()));
        let several = stage.cameras.several();
        if let (true, Some(option)) = (several, of_one_image(args)) {
            let cameras = stage.cameras.typed();
            return Err(Failure::option("camera", cameras, format!("one camera with {option}")));
        }
        if let (Some(frames), Some(option)) = (frames, of_one_image(args).or_else(|| of_one_scene(args))) {
            return Err(Failure::option(
                "frames",
                frames.typed(),
                format!("--at, for one frame, with {option}"),
            ));
        }
        if args.checkpoint && is_audited && asked.share.is_whole() {
            return Err(Failure::usage(
                "--checkpoint: a picture that is audited as a whole is made in passes, not in tiles; --error 5% \
                 or parts of it (--tiles) can be kept",
            ));
        }
        if let (Some(file), true) = (&args.write_vpls, is_audited || asked.request.method == MethodName::Path)
        {
            let expected = "none with method path, nor with a picture that is audited as a whole, which render with no \
                            set of lights; --error 5% renders with one";
            return Err(Failure::option("write-vpls", file.display(), expected));
        }
        let inputs = stage.inputs(asked.vpl_file());
        if !args.serve && (args.serving.port != 0 || args.serving.no_browser) {
            return Err(Failure::usage("--port and --no-browser go with --serve"));
        }
        let told = args.common.log_file.is_some();
        let serve = args.serve.then(|| Serving::new(&args.serving, args.common.quiet, told)).transpose()?;
        let checkpoint = args.checkpoint.then(|| {
            let mut path = one.exr.clone().into_os_string();
            path.push(".checkpoint");
            PathBuf::from(path)
        });
        let written: Vec<&Path> = match &args.write_vpls {
            Some(path) => vec![path],
            // The names of these files follow from the scene's cameras or from the frames, and are
            // checked later.
            None if several => Vec::new(),
            None => one.images().chain(&checkpoint).map(PathBuf::as_path).collect(),
        };
        let common = Common::new(&args.common, &written, &inputs)?;
        Ok(Self {
            stage,
            write_vpls: args.write_vpls.clone(),
            frames,
            outputs,
            layout: args.layout.exr,
            tone_map,
            luminance,
            tev: args.tev.clone(),
            checkpoint,
            accept_budget: args.budget.accept_budget,
            serve,
            common,
            asked,
            time: args.time,
            audit: args.audit.filter(|_| !is_audited),
        })
    }
}

impl RenderPlan {
    /// Time limit of an audited picture of this part of an image: the given one, else the
    /// [default](Request::default_seconds). Parts for several machines have none.
    pub fn time_limit(&self, window: Window) -> Option<Duration> {
        let by_default = || self.asked.request.default_seconds(window.area()).map(Duration::from_secs_f64);
        self.time.or_else(by_default).filter(|_| self.asked.share.is_whole())
    }
}

/// Scale of the picture of luminances, if one was requested.
pub(super) fn luminance(args: &FalseColorArgs) -> Result<Option<LuminanceScale>, Failure> {
    if args.false_color.is_none() && args.photometry.is_some() {
        return Err(Failure::usage("--photometry goes with --false-color"));
    }
    let photometry = args.photometry.unwrap_or_default();
    let efficacies = photometry.efficacies();
    Ok(args.false_color.map(|scale| LuminanceScale { efficacies, end: scale.end }))
}

/// Denoiser of an audited picture; `None` for our reconstruction. Pictures of fixed work, and
/// parts, have ours unless another was given, so that they are the same bits everywhere.
fn smoother(args: &RenderArgs) -> Result<Option<Arc<dyn Smoother>>, Failure> {
    let is_fixed = args.passes.is_some() || args.tiles.is_some();
    let by_default = if is_fixed { Oidn::OWN } else { Oidn::AUTO };
    let name = args.denoiser.as_deref().unwrap_or(Path::new(by_default));
    Ok(Oidn::by_name(name, || None, args.common.threads)?)
}

/// Returns an option that was given and is possible for one image only, if there is one.
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

/// Returns an option that was given and is possible for one scene only, if there is one.
fn of_one_scene(args: &RenderArgs) -> Option<&'static str> {
    args.source.vpl_file.is_some().then_some("--vpl-file")
}

fn request(args: &RenderArgs) -> Result<Request, Failure> {
    let request = Request {
        method: args.method.name()?,
        claim: args.claim.map(ClaimName::from),
        share: args.share,
        assurance: args.assurance,
        audit: args.audit,
        passes: args.passes,
        truth: args.truth,
        error: args.error,
        control: args.control,
        absolute: args.absolute,
        confidence: args.confidence,
        max_pairs: args.max_pairs,
        paths: args.paths,
        groups_asked: !args.planes.groups.is_empty(),
        lights_given: args.source.vpl_file.is_some(),
        vpls: args.source.lights.vpls,
        clamp: args.source.lights.set.clamp,
        instants: args.source.lights.set.instants,
        gather: args.gather.points,
        filter: args.gather.filter.filter,
        seed: args.seed,
    };
    Ok(match args.quality {
        Some(quality) => request.with_quality(quality)?,
        None => request,
    })
}
