//! What is to be done: every value checked, before any work.

use std::fs;
use std::path::{Path, PathBuf};

use tashika::film::{Film, Window};
use tashika::gather::GatherOptions;
use tashika::io::{LoadOptions, SCENE_FORMATS, ToneMap, check_writable, load_scene};
use tashika::render::TileShare;
use tashika::report::Tolerance;
use tashika::scene::{Camera, Scene, builtin};
use tashika::vpl::VplOptions;

use crate::args::{CommonArgs, CompareArgs, InfoArgs, LightArgs, Method, RenderArgs, SceneArgs, VplArgs};
use crate::exit::Failure;

/// Image size where neither the user nor the camera says.
const DEFAULT_SIZE: [u32; 2] = [640, 360];
/// Paths a pixel where the user does not say.
const DEFAULT_PATHS: u32 = 64;
/// Begins the name of a scene that needs no file.
const BUILTIN: &str = "builtin:";

/// Where the scene comes from.
#[derive(Debug)]
pub struct SceneSource {
    kind: SceneKind,
    options: LoadOptions,
}

#[derive(Debug)]
enum SceneKind {
    Builtin(fn() -> Scene),
    File(PathBuf),
}

impl SceneSource {
    fn new(typed: Option<&str>, args: &SceneArgs) -> Result<Self, Failure> {
        let kind = match typed {
            None => SceneKind::Builtin(builtin::room),
            Some(name) => match name.strip_prefix(BUILTIN) {
                Some("room") => SceneKind::Builtin(builtin::room),
                Some("tiny") => SceneKind::Builtin(builtin::tiny),
                Some(_) => {
                    let known = "builtin:room or builtin:tiny, or a scene file";
                    return Err(Failure::usage(format!("there is no scene '{name}'; expected {known}")));
                }
                None => SceneKind::File(PathBuf::from(name)),
            },
        };
        Ok(Self {
            kind,
            options: LoadOptions { allow_outside: args.allow_outside, ..LoadOptions::default() },
        })
    }

    /// Reads or makes the scene.
    pub fn load(&self) -> Result<Scene, Failure> {
        match &self.kind {
            SceneKind::Builtin(scene) => Ok(scene()),
            SceneKind::File(path) => Ok(load_scene(path, &self.options)?),
        }
    }

    /// What to call the scene while it is being read.
    pub fn label(&self) -> String {
        match &self.kind {
            SceneKind::Builtin(_) => "the built-in scene".to_owned(),
            SceneKind::File(path) => path.display().to_string(),
        }
    }

    /// Name of the format.
    pub fn format(&self) -> &'static str {
        let SceneKind::File(path) = &self.kind else { return "built-in" };
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        SCENE_FORMATS.iter().find(|(e, _)| *e == ending).map_or("unknown", |(_, name)| name)
    }

    fn file(&self) -> Option<&Path> {
        match &self.kind {
            SceneKind::Builtin(_) => None,
            SceneKind::File(path) => Some(path),
        }
    }
}

/// Where the lights come from.
#[derive(Debug)]
pub enum Lights {
    /// Traced for this render.
    Trace(VplOptions),
    /// Read from a file.
    File(PathBuf),
}

/// How pixels are computed, with what only that method needs.
#[derive(Debug)]
pub enum Integration {
    /// The whole sum.
    Exact(Lights),
    /// Path tracing with so many paths a pixel.
    Path(u32),
}

/// A render.
#[derive(Debug)]
pub struct RenderPlan {
    /// The scene.
    pub scene: SceneSource,
    /// Whether notes that depart from the file are errors.
    pub strict: bool,
    /// Name of the camera, if not the first.
    pub camera: Option<String>,
    size: Option<[u32; 2]>,
    crop: Option<Window>,
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
}

impl RenderPlan {
    /// Checks what was typed, and that the outputs can be written.
    pub fn new(args: &RenderArgs) -> Result<Self, Failure> {
        let scene = SceneSource::new(args.scene.as_deref(), &args.scene_args)?;
        let gather = match args.gather {
            None => GatherOptions::default(),
            // Counts beyond `u32` are as far out of range as `u32::MAX`.
            Some(n) => {
                GatherOptions { points: u32::try_from(n).unwrap_or(u32::MAX), ..GatherOptions::default() }
            }
        };
        gather.validate()?;
        let tone_map = ToneMap { exposure: args.exposure };
        tone_map.validate()?;
        if let Some(size) = args.size {
            Film::check(size, args.crop.unwrap_or(Window::full(size)))?;
        }
        let (integration, unused) = integration(args)?;
        let exr = with_ending(&args.output, "exr")?;
        let png = exr.with_extension("png");
        let mut inputs: Vec<&Path> = scene.file().into_iter().collect();
        inputs.extend(args.vpl_file.as_deref());
        let common = Common::new(&args.common, &[&exr, &png], &inputs)?;
        Ok(Self {
            scene,
            strict: args.strict,
            camera: args.camera.clone(),
            size: args.size,
            crop: args.crop,
            share: args.tiles.unwrap_or_default(),
            gather,
            integration,
            seed: args.seed,
            exr,
            png,
            tone_map,
            common,
            unused,
        })
    }

    /// File that the lights are read from, if they are.
    pub fn lights_file(&self) -> Option<&Path> {
        match &self.integration {
            Integration::Exact(Lights::File(path)) => Some(path),
            Integration::Exact(Lights::Trace(_)) | Integration::Path(_) => None,
        }
    }

    /// Size of the image and the part that is rendered, once the camera is known.
    pub fn window(&self, camera: &Camera) -> Result<([u32; 2], Window), Failure> {
        let size = self.size.or(camera.resolution).unwrap_or(DEFAULT_SIZE);
        // The file's crop counts pixels of the file's own size.
        let own = camera.crop.filter(|_| self.size.is_none());
        let own = own.map(|c| Window { x: c.x, y: c.y, width: c.width, height: c.height });
        let window = self.crop.or(own).unwrap_or(Window::full(size));
        Film::check(size, window)?;
        Ok((size, window))
    }
}

fn integration(args: &RenderArgs) -> Result<(Integration, Vec<&'static str>), Failure> {
    let mut unused = Vec::new();
    let integration = match args.method {
        Method::Exact => {
            if args.paths.is_some() {
                unused.push("--paths");
            }
            Integration::Exact(match &args.vpl_file {
                Some(file) => Lights::File(file.clone()),
                None => Lights::Trace(vpl_options(&args.lights, args.seed)?),
            })
        }
        Method::Path => {
            let typed = [
                ("--vpls", args.lights.vpls.is_some()),
                ("--clamp", args.lights.clamp.is_some()),
                ("--vpl-file", args.vpl_file.is_some()),
                ("--gather", args.gather.is_some()),
            ];
            unused.extend(typed.into_iter().filter(|(_, typed)| *typed).map(|(option, _)| option));
            let paths = match args.paths {
                None => DEFAULT_PATHS,
                Some(n) => u32::try_from(n)
                    .ok()
                    .filter(|n| *n > 0)
                    .ok_or_else(|| Failure::option("paths", n, format!("1 to {}", u32::MAX)))?,
            };
            Integration::Path(paths)
        }
    };
    Ok((integration, unused))
}

fn vpl_options(args: &LightArgs, seed: u64) -> Result<VplOptions, Failure> {
    let default = VplOptions::default();
    let options = VplOptions {
        count: args.vpls.unwrap_or(default.count),
        clamp: args.clamp.unwrap_or(default.clamp),
        seed,
        ..default
    };
    options.validate()?;
    Ok(options)
}

/// A look at a scene.
#[derive(Debug)]
pub struct InfoPlan {
    /// The scene.
    pub scene: SceneSource,
    /// What every command has.
    pub common: Common,
}

impl InfoPlan {
    /// Checks what was typed, and that the outputs can be written.
    pub fn new(args: &InfoArgs) -> Result<Self, Failure> {
        let scene = SceneSource::new(args.scene.as_deref(), &args.scene_args)?;
        let inputs: Vec<&Path> = scene.file().into_iter().collect();
        let common = Common::new(&args.common, &[], &inputs)?;
        Ok(Self { scene, common })
    }
}

/// Lights traced to a file, or a look at such a file.
#[derive(Debug)]
pub struct VplPlan {
    /// What to do.
    pub task: VplTask,
    /// What every command has.
    pub common: Common,
}

/// The two things that `vpl` does.
#[derive(Debug)]
pub enum VplTask {
    /// Trace the lights of a scene; write them, if there is a file to write.
    Trace {
        /// The scene.
        scene: SceneSource,
        /// How many lights, and which.
        options: VplOptions,
        /// File to write.
        output: Option<PathBuf>,
    },
    /// Tell about a file.
    Inspect(PathBuf),
}

impl VplPlan {
    /// Checks what was typed, and that the outputs can be written.
    pub fn new(args: &VplArgs) -> Result<Self, Failure> {
        let file = args.input.as_deref().map(Path::new).filter(|p| has_ending(p, "vpl"));
        if let Some(file) = file {
            let typed = [
                ("--output", args.output.is_some()),
                ("--vpls", args.lights.vpls.is_some()),
                ("--clamp", args.lights.clamp.is_some()),
                ("--seed", args.seed.is_some()),
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
        let options = vpl_options(&args.lights, args.seed.unwrap_or(VplOptions::default().seed))?;
        let output = args.output.as_deref().map(|path| with_ending(path, "vpl")).transpose()?;
        let outputs: Vec<&Path> = output.as_deref().into_iter().collect();
        let inputs: Vec<&Path> = scene.file().into_iter().collect();
        let common = Common::new(&args.common, &outputs, &inputs)?;
        Ok(Self { task: VplTask::Trace { scene, options, output }, common })
    }
}

/// A comparison.
#[derive(Debug)]
pub struct ComparePlan {
    /// Image to measure.
    pub image: PathBuf,
    /// Image that is taken for the truth.
    pub reference: PathBuf,
    /// What is tolerated.
    pub tolerance: Tolerance,
    /// Picture of the error to write.
    pub picture: Option<PathBuf>,
    /// Page to write.
    pub html: Option<PathBuf>,
    /// What every command has.
    pub common: Common,
}

impl ComparePlan {
    /// Checks what was typed, and that the outputs can be written.
    pub fn new(args: &CompareArgs) -> Result<Self, Failure> {
        let tolerance = Tolerance { relative: args.error, absolute: args.absolute };
        tolerance.validate()?;
        if let Some(path) = args.picture.as_deref().filter(|p| !has_ending(p, "png")) {
            return Err(Failure::option("image", path.display(), "a file name ending in .png"));
        }
        let outputs: Vec<&Path> = args.picture.as_deref().into_iter().chain(args.html.as_deref()).collect();
        let common = Common::new(&args.common, &outputs, &[&args.image, &args.reference])?;
        Ok(Self {
            image: args.image.clone(),
            reference: args.reference.clone(),
            tolerance,
            picture: args.picture.clone(),
            html: args.html.clone(),
            common,
        })
    }
}

/// What every command has.
#[derive(Debug)]
pub struct Common {
    /// File for scripts.
    pub json: Option<PathBuf>,
    /// Whether only errors are printed.
    pub quiet: bool,
    /// Threads; zero is one a core.
    pub threads: usize,
}

impl Common {
    /// Checks that all outputs can be written and none is written twice or over an input.
    fn new(args: &CommonArgs, outputs: &[&Path], inputs: &[&Path]) -> Result<Self, Failure> {
        let mut all = outputs.to_vec();
        all.extend(args.json.as_deref());
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
        Ok(Self { json: args.json.clone(), quiet: args.quiet, threads: args.threads })
    }
}

fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending))
}

/// The path, if it ends so.
fn with_ending(path: &Path, ending: &str) -> Result<PathBuf, Failure> {
    if has_ending(path, ending) {
        Ok(path.to_owned())
    } else {
        Err(Failure::option("output", path.display(), format!("a file name ending in .{ending}")))
    }
}
