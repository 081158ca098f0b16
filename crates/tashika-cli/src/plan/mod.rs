//! Plans of all commands, with every value checked before any work.

mod camera;
mod farm;
mod frames;
mod measure;
mod outputs;
mod render;
mod sensors;
mod transport;

pub use camera::Cameras;
pub use farm::{Farm, FarmPlan};
pub use frames::Frames;
pub use measure::{
    AblationPlan, CoveragePlan, EqualQualityPlan, ExperimentPlan, Folder, Iwasaki2019Plan, MeasurePlan,
    ScalingPlan,
};
pub use outputs::Outputs;
pub use render::RenderPlan;
pub use sensors::{SensorsFrom, SensorsPlan};
pub use transport::TransportPlan;

use std::fs;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::available_parallelism;

use tashika::film::Window;
use tashika::glare::GlareOptions;
use tashika::io::{
    ExrLayout, LightChanges, LoadOptions, Tone, ToneMap, check_writable, open_scene, scene_format,
};
use tashika::reconstruction::Smoother;
use tashika::render::TileShare;
use tashika::report::{LuminanceScale, Tolerance};
use tashika::request::{CameraChange, Framing, Request};
use tashika::scene::{LightGrouping, Scene, builtin};
use tashika::vpl::VplOptions;
use tashika_oidn::Oidn;

use crate::args::{
    CameraArgs, CommonArgs, CompareArgs, GatherArgs, GlareArgs, InfoArgs, LogStyle, MergeArgs, PictureArgs,
    SceneArgs, ServeArgs, SourceArgs, StageArgs, ViewArgs, VplArgs,
};
use crate::exit::Failure;

/// Source of the scene, with the options for reading it.
#[derive(Clone, Debug)]
pub struct SceneSource {
    name: PathBuf,
    lights: LightChanges,
    options: LoadOptions,
}

impl SceneSource {
    fn new(typed: Option<&str>, args: &SceneArgs) -> Result<Self, Failure> {
        let name = typed.map_or_else(|| format!("{}room", builtin::PREFIX), str::to_owned);
        if let Some(name) = name.strip_prefix(builtin::PREFIX) {
            // The message names no option, since a scene is a positional argument.
            builtin::by_name(name).map_err(|e| Failure::usage(e.to_string()))?;
        }
        let lights = LightChanges { environment: args.environment.clone(), lights: args.light.clone() };
        let options = LoadOptions {
            allow_outside: args.allow_outside,
            allow_missing: args.allow_missing,
            at: args.at,
            shutter: args.shutter,
            ..LoadOptions::default()
        };
        options.validate()?;
        Ok(Self { name: PathBuf::from(name), lights, options })
    }

    /// Returns the file of the scene; `None` for a built-in scene.
    fn file(&self) -> Option<&Path> {
        let is_builtin = self.name.to_str().is_some_and(|name| name.starts_with(builtin::PREFIX));
        (!is_builtin).then_some(&self.name)
    }

    /// Returns the file of the scene if it does not exist.
    pub fn missing_file(&self) -> Option<&Path> {
        self.file().filter(|path| !path.exists())
    }

    /// Reads or makes the scene.
    pub fn load(&self) -> Result<Scene, Failure> {
        Ok(open_scene(&self.name, &self.lights, &self.options)?)
    }

    /// Name of the scene in messages while it is read.
    pub fn label(&self) -> String {
        self.file().map_or_else(|| "the built-in scene".to_owned(), |path| path.display().to_string())
    }

    /// Name of the scene's file format.
    pub fn format(&self) -> &'static str {
        let Some(path) = self.file() else { return "built-in" };
        scene_format(path).unwrap_or("unknown")
    }

    /// Returns the requested changes to the scene's light.
    pub fn lights(&self) -> &LightChanges {
        &self.lights
    }

    /// Returns the files of the scene that the user names.
    fn files(&self) -> impl Iterator<Item = &Path> {
        self.file().into_iter().chain(self.lights.files())
    }
}

/// Request for pixels and planes, with the lights if they come from a file.
#[derive(Clone, Debug)]
pub struct Asked {
    /// Method and options that the pixels are rendered with.
    pub request: Request,
    /// File to read the VPLs from.
    pub vpl_file: Option<PathBuf>,
    /// Share of the tiles to render.
    pub share: TileShare,
    /// Smoother of an audited picture; `None` for our reconstruction.
    pub smoother: Option<Arc<dyn Smoother>>,
    /// Number of ranks of the mattes; `None` without mattes.
    pub mattes: Option<u32>,
    /// True if motion vectors are added.
    pub motion_vectors: bool,
    /// Groups of lights that have a layer each; `None` without such layers.
    pub groups: Option<LightGrouping>,
}

impl Asked {
    /// Checks every value; all tiles are rendered.
    fn new(request: Request, vpl_file: Option<&Path>) -> Result<Self, Failure> {
        let request = Request { lights_given: vpl_file.is_some(), ..request };
        request.validate()?;
        Ok(Self {
            request,
            vpl_file: vpl_file.map(Path::to_owned),
            share: TileShare::default(),
            smoother: None,
            mattes: None,
            motion_vectors: false,
            groups: None,
        })
    }

    /// Request of a sum over lights that are traced or read, from the arguments.
    fn of_a_sum(source: &SourceArgs, gather: &GatherArgs, seed: u64) -> Result<Self, Failure> {
        let request = Request {
            vpls: source.lights.vpls,
            clamp: source.lights.set.clamp,
            instants: source.lights.set.instants,
            gather: gather.points,
            filter: gather.filter.filter,
            seed,
            ..Request::of_a_sum()
        };
        Self::new(request, source.vpl_file.as_deref())
    }

    /// Returns the file of the VPLs, if there is one.
    pub fn vpl_file(&self) -> Option<&Path> {
        self.vpl_file.as_deref()
    }
}

/// Scene, cameras, and size of the image.
#[derive(Clone, Debug)]
pub struct StagePlan {
    /// Source that the scene is read from.
    pub scene: SceneSource,
    /// True if notes about departures from the file are errors.
    pub strict: bool,
    /// Names of the cameras to render.
    pub cameras: Cameras,
    /// Replacements of the cameras' projection and lens.
    pub change: CameraChange,
    /// Size of the image, and the part that is rendered.
    pub framing: Framing,
}

impl StagePlan {
    fn new(args: &StageArgs, crop: Option<Window>) -> Result<Self, Failure> {
        let scene = SceneSource::new(args.scene.as_deref(), &args.scene_args)?;
        let framing = Framing { size: args.size, crop };
        framing.check()?;
        let CameraArgs { projection, fov, lens_radius, focus_distance, blades, blade_rotation, .. } =
            args.camera;
        let change = CameraChange { projection, fov, lens_radius, focus_distance, blades, blade_rotation };
        let cameras = Cameras::new(&args.camera.cameras);
        Ok(Self { scene, strict: args.strict, cameras, change, framing })
    }

    /// Returns the plan for the scene at another time (s).
    pub fn at(&self, seconds: f64) -> Self {
        let mut stage = self.clone();
        stage.scene.options.at = Some(seconds);
        stage
    }

    /// Returns the files of the scene, and that of the lights if there is one.
    fn inputs<'a>(&'a self, lights: Option<&'a Path>) -> Vec<&'a Path> {
        self.scene.files().chain(lights).collect()
    }
}

/// Checked arguments of `info`.
#[derive(Debug)]
pub struct InfoPlan {
    /// Source that the scene is read from.
    pub scene: SceneSource,
    /// Options of every command.
    pub common: Common,
}

impl InfoPlan {
    /// Checks the arguments, and that the outputs can be written.
    pub fn new(args: &InfoArgs) -> Result<Self, Failure> {
        let scene = SceneSource::new(args.scene.as_deref(), &args.scene_args)?;
        let inputs: Vec<&Path> = scene.files().collect();
        let common = Common::new(&args.common, &[], &inputs)?;
        Ok(Self { scene, common })
    }
}

/// Checked arguments of `vpl`.
#[derive(Debug)]
pub struct VplPlan {
    /// Tracing of lights, or description of a file.
    pub task: VplTask,
    /// Options of every command.
    pub common: Common,
}

/// One of the two tasks of `vpl`.
#[derive(Debug)]
pub enum VplTask {
    /// Trace the lights of a scene, and write them if there is an output.
    Trace {
        /// Source that the scene is read from.
        scene: SceneSource,
        /// Number of lights, clamp, instants and seed.
        options: VplOptions,
        /// File to write.
        output: Option<PathBuf>,
    },
    /// Describe a file of lights.
    Inspect(PathBuf),
}

impl VplPlan {
    /// Checks the arguments, and that the outputs can be written.
    pub fn new(args: &VplArgs) -> Result<Self, Failure> {
        let file = args.input.as_deref().map(Path::new).filter(|p| has_ending(p, "vpl"));
        if let Some(file) = file {
            let typed = [
                ("--output", args.output.is_some()),
                ("--vpls", args.lights.vpls.is_some()),
                ("--clamp", args.lights.set.clamp.is_some()),
                ("--instants", args.lights.set.instants.is_some()),
                ("--seed", args.seed.is_some()),
                ("--at", args.scene_args.at.is_some()),
                ("--shutter", args.scene_args.shutter.is_some()),
                ("--environment", args.scene_args.environment.is_some()),
                ("--light", !args.scene_args.light.is_empty()),
            ];
            if let Some((option, _)) = typed.into_iter().find(|(_, typed)| *typed) {
                let message =
                    format!("{option} is for tracing a scene, but {} is a file of lights", file.display());
                return Err(Failure::usage(message));
            }
            let common = Common::new(&args.common, &[], &[file])?;
            return Ok(Self { task: VplTask::Inspect(file.to_owned()), common });
        }
        let scene = SceneSource::new(args.input.as_deref(), &args.scene_args)?;
        let seed = args.seed.unwrap_or(VplOptions::default().seed);
        let request = Request {
            vpls: args.lights.vpls,
            clamp: args.lights.set.clamp,
            instants: args.lights.set.instants,
            seed,
            ..Request::default()
        };
        let options = request.lights()?;
        let output = args.output.as_deref().map(|path| with_ending(path, "vpl")).transpose()?;
        let outputs: Vec<&Path> = output.as_deref().into_iter().collect();
        let inputs: Vec<&Path> = scene.files().collect();
        let common = Common::new(&args.common, &outputs, &inputs)?;
        Ok(Self { task: VplTask::Trace { scene, options, output }, common })
    }
}

/// Checked arguments of `compare`.
#[derive(Debug)]
pub struct ComparePlan {
    /// OpenEXR image that is measured.
    pub image: PathBuf,
    /// Image that is taken for the truth.
    pub reference: PathBuf,
    /// Layer of the image, if not its main one.
    pub layer: Option<String>,
    /// Relative tolerance, if one was given.
    pub error: Option<f64>,
    /// Absolute tolerance, if one was given.
    pub absolute: Option<f64>,
    /// Picture of the error to write.
    pub picture: Option<PathBuf>,
    /// Page to write.
    pub html: Option<PathBuf>,
    /// Initial tone mapping of the page.
    pub tone: Tone,
    /// Options of every command.
    pub common: Common,
}

impl ComparePlan {
    /// Checks the arguments, and that the outputs can be written.
    pub fn new(args: &CompareArgs) -> Result<Self, Failure> {
        let default = Tolerance::default();
        let relative = args.error.unwrap_or(default.relative);
        Tolerance { relative, absolute: args.absolute.unwrap_or(default.absolute) }.validate()?;
        if let Some(path) = args.picture.as_deref().filter(|p| !has_ending(p, "png")) {
            return Err(Failure::option("image", path.display(), "a file name ending in .png"));
        }
        let outputs: Vec<&Path> = args.picture.as_deref().into_iter().chain(args.html.as_deref()).collect();
        let common = Common::new(&args.common, &outputs, &[&args.image, &args.reference])?;
        Ok(Self {
            image: args.image.clone(),
            reference: args.reference.clone(),
            layer: args.layer.clone(),
            error: args.error,
            absolute: args.absolute,
            picture: args.picture.clone(),
            html: args.html.clone(),
            tone: args.tonemap.unwrap_or_default(),
            common,
        })
    }
}

/// Checked arguments of `glare`.
#[derive(Debug)]
pub struct GlarePlan {
    /// OpenEXR image that is evaluated.
    pub image: PathBuf,
    /// Photometry, angle and threshold.
    pub options: GlareOptions,
    /// Picture of the luminances to write.
    pub picture: Option<PathBuf>,
    /// Options of every command.
    pub common: Common,
}

impl GlarePlan {
    /// Checks the arguments, and that the outputs can be written.
    pub fn new(args: &GlareArgs) -> Result<Self, Failure> {
        let GlareArgs { angle, threshold, photometry, .. } = *args;
        let options = GlareOptions { photometry, angle, threshold };
        options.validate()?;
        if let Some(path) = args.picture.as_deref().filter(|p| !has_ending(p, "png")) {
            return Err(Failure::option("image", path.display(), "a file name ending in .png"));
        }
        let outputs: Vec<&Path> = args.picture.as_deref().into_iter().collect();
        let common = Common::new(&args.common, &outputs, &[&args.image])?;
        Ok(Self { image: args.image.clone(), options, picture: args.picture.clone(), common })
    }
}

/// Checked arguments of `merge`.
#[derive(Debug)]
pub struct MergePlan {
    /// Films to be joined.
    pub parts: Vec<PathBuf>,
    /// Image to write.
    pub exr: PathBuf,
    /// Layout of the image file.
    pub layout: ExrLayout,
    /// Picture to write.
    pub png: PathBuf,
    /// Page to write.
    pub html: PathBuf,
    /// True if parts may be missing.
    pub partial: bool,
    /// True if pixels that ran out of budget do not change the exit code.
    pub accept_budget: bool,
    /// Smoother of an audited picture; `None` for our reconstruction.
    pub smoother: Option<Arc<dyn Smoother>>,
    /// Exposure and tone mapping of the picture.
    pub tone_map: ToneMap,
    /// Picture of the luminances in false colours with its scale, if one is written.
    pub luminance: Option<(PathBuf, LuminanceScale)>,
    /// Options of every command.
    pub common: Common,
}

impl MergePlan {
    /// Checks the arguments, and that the outputs can be written.
    pub fn new(args: &MergeArgs) -> Result<Self, Failure> {
        let tone_map = tone_map(&args.picture)?;
        let exr = with_ending(&args.output, "exr")?;
        let [png, html] = ["png", "html"].map(|ending| exr.with_extension(ending));
        let luminance = render::luminance(&args.false_color)?;
        let luminance = luminance.map(|scale| (outputs::named(&png, "luminance"), scale));
        let inputs: Vec<&Path> = args.parts.iter().map(PathBuf::as_path).collect();
        let written: Vec<&Path> = [&exr, &png, &html]
            .into_iter()
            .chain(luminance.as_ref().map(|(path, _)| path))
            .map(PathBuf::as_path)
            .collect();
        let common = Common::new(&args.common, &written, &inputs)?;
        let smoother = args.denoiser.as_deref();
        let smoother = smoother.map(|name| Oidn::by_name(name, || None, args.common.threads)).transpose()?;
        Ok(Self {
            smoother: smoother.flatten(),
            parts: args.parts.clone(),
            exr,
            layout: args.layout.exr,
            png,
            html,
            partial: args.partial,
            accept_budget: args.budget.accept_budget,
            tone_map,
            luminance,
            common,
        })
    }
}

/// Checks the options for the picture beside an image.
fn tone_map(args: &PictureArgs) -> Result<ToneMap, Failure> {
    let tone_map = ToneMap { exposure: args.exposure, tone: args.tonemap };
    tone_map.validate()?;
    Ok(tone_map)
}

/// Checked arguments of `view`.
#[derive(Debug)]
pub struct ViewPlan {
    /// OpenEXR image that is shown.
    pub image: PathBuf,
    /// Image that errors are measured from.
    pub reference: Option<PathBuf>,
    /// Initial tone mapping of the page.
    pub tone: Tone,
    /// Port of the page, and the choice of a browser.
    pub serving: Serving,
    /// Options of every command.
    pub common: Common,
}

impl ViewPlan {
    /// Checks the arguments.
    pub fn new(args: &ViewArgs) -> Result<Self, Failure> {
        let inputs: Vec<&Path> =
            std::iter::once(args.image.as_path()).chain(args.reference.as_deref()).collect();
        Ok(Self {
            image: args.image.clone(),
            reference: args.reference.clone(),
            tone: args.tonemap,
            serving: Serving::new(&args.serve, args.common.quiet, args.common.json.is_some())?,
            common: Common::new(&args.common, &[], &inputs)?,
        })
    }
}

/// Options for serving a page.
#[derive(Debug)]
pub struct Serving {
    /// Port of the server; zero is any free port.
    pub port: u16,
    /// True if a browser opens the page.
    pub browser: bool,
}

impl Serving {
    /// Checks the options. A browser is opened only if standard error is a terminal. `told` is true
    /// if the address is written to a file.
    fn new(args: &ServeArgs, quiet: bool, told: bool) -> Result<Self, Failure> {
        let browser = !args.no_browser && std::io::stderr().is_terminal();
        if quiet && !browser && !told {
            let message = "--quiet would leave nobody to tell the page's address: leave it out, or write the address to a file \
                (`view --json`, `render --serve --log-file`)";
            return Err(Failure::usage(message));
        }
        Ok(Self { port: args.port, browser })
    }
}

/// Options of every command.
#[derive(Debug)]
pub struct Common {
    /// File for scripts; `-` is standard output.
    pub json: Option<PathBuf>,
    /// True if only errors are printed.
    pub quiet: bool,
    /// Format and file of progress.
    pub log: Log,
    /// Number of threads; zero is one a core.
    pub threads: usize,
}

/// Format and file of progress.
#[derive(Debug)]
pub struct Log {
    /// Format on standard error.
    pub style: LogStyle,
    /// File that progress is appended to as well; `-` is standard error.
    pub file: Option<PathBuf>,
}

/// Returns true if a path is `-`, which stands for a standard stream.
pub fn is_standard_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}

impl Common {
    /// Returns true if rows for people are printed to standard output. With `quiet`, or if JSON is
    /// printed there, they are not.
    pub fn prints_rows(&self) -> bool {
        !self.quiet && !self.json.as_deref().is_some_and(is_standard_stream)
    }

    /// Number of threads of the work.
    pub fn thread_count(&self) -> usize {
        if self.threads > 0 { self.threads } else { available_parallelism().map_or(1, usize::from) }
    }

    /// Checks that all outputs can be written and none is written twice or over an input.
    fn new(args: &CommonArgs, outputs: &[&Path], inputs: &[&Path]) -> Result<Self, Failure> {
        let mut all = outputs.to_vec();
        let named = args.json.as_deref().into_iter().chain(args.log_file.as_deref());
        all.extend(named.filter(|path| !is_standard_stream(path)));
        for (i, output) in all.iter().enumerate() {
            if all[..i].contains(output) {
                return Err(Failure::usage(format!("{} would be written twice", output.display())));
            }
            let same = |input: &&Path| match (fs::canonicalize(output), fs::canonicalize(input)) {
                (Ok(output), Ok(input)) => output == input,
                _ => false,
            };
            if inputs.iter().any(same) {
                return Err(Failure::usage(format!(
                    "{} is an input and would be overwritten",
                    output.display()
                )));
            }
            check_writable(output).map_err(|e| Failure::file(format!("cannot write {e}")))?;
        }
        let log = Log { style: args.log, file: args.log_file.clone() };
        Ok(Self { json: args.json.clone(), quiet: args.quiet, log, threads: args.threads })
    }
}

fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending))
}

/// Returns the path if it has the ending.
fn with_ending(path: &Path, ending: &str) -> Result<PathBuf, Failure> {
    if has_ending(path, ending) {
        Ok(path.to_owned())
    } else {
        Err(Failure::option("output", path.display(), format!("a file name ending in .{ending}")))
    }
}
