//! Arguments as typed. The doc comments are the texts of `--help`.

mod camera;
mod compare;
mod farm;
mod film;
mod frames;
mod frequent;
mod glare;
mod measure;
mod sensors;
mod shell;

pub use camera::CameraArgs;
pub use compare::CompareArgs;
pub use farm::FarmArgs;
pub use film::{ExrArgs, FalseColorArgs, PictureArgs, PlaneArgs};
pub use frames::FramesArgs;
pub use frequent::parsed;
pub use glare::GlareArgs;
pub use measure::{
    AblationArgs, CoverageArgs, EqualQualityArgs, ExperimentArgs, Iwasaki2019Args, MeasureArgs, ScalingArgs,
    TransportArgs, TransportMethod,
};

pub use sensors::SensorsArgs;
use shell::{COMPLETIONS_EXAMPLES, MAN_EXAMPLES};
pub use shell::{CompletionsArgs, ManArgs};

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args as ClapArgs, Parser, Subcommand, ValueEnum};
use tashika::color::Controlled;
use tashika::film::Window;
use tashika::gather::{Filter, GatherOptions};
use tashika::integrator::Truth;
use tashika::io::{AskedEnvironment, AskedLight, Tone};
use tashika::render::TileShare;
use tashika::request::{ClaimName, MethodName, Quality};
use tashika::vpl::{Clamp, VplOptions};

use crate::tev;
use crate::values;

/// A many-light renderer that knows its own error
#[derive(Debug, Parser)]
#[command(name = "tashika", version, arg_required_else_help = true, max_term_width = 100, after_help = EXIT_CODES)]
pub struct Args {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to an OpenEXR image with a PNG and a page beside it
    Render(Box<RenderArgs>),
    /// Measure illuminance at points or over a grid, each with its interval
    Sensors(Box<SensorsArgs>),
    /// List the contents of a scene, and the items that were approximated or ignored
    Info(InfoArgs),
    /// Trace the virtual point lights of a scene to a file, or describe such a file
    Vpl(VplArgs),
    /// Measure the glare in a fisheye image: UGR and DGP, each with an interval
    Glare(GlareArgs),
    /// Measure an image against a reference: shares, errors, claims that hold, and a picture of the
    /// error
    Compare(CompareArgs),
    /// Write a render as a job for many machines: shares of its tiles, then a merge
    #[command(subcommand)]
    Farm(FarmArgs),
    /// Join parts of an image that were rendered with --tiles
    Merge(MergeArgs),
    /// View an image of any size in the browser: its planes, its claims and, with a reference, its
    /// error
    View(ViewArgs),
    /// Measure how often methods meet their tolerance, and how often their intervals cover the
    /// truth
    Coverage(CoverageArgs),
    /// Run an experiment of the literature: images, tables, a page
    #[command(subcommand)]
    Experiment(ExperimentArgs),
    /// Print the script by which a shell completes commands and options
    #[command(after_help = COMPLETIONS_EXAMPLES)]
    Completions(CompletionsArgs),
    /// Print the man page of a command, or of the program
    #[command(after_help = MAN_EXAMPLES)]
    Man(ManArgs),
}

const EXIT_CODES: &str = "\
Exit codes:
  0    done
  2    usage: an option or its value cannot be
  3    files: an input cannot be used, or an output cannot be written
  4    rendered, but some pixels ran out of budget, or an audited picture without a limit on its
       time or passes has not reached its share
  5    rendered, but the audit contradicts what is claimed
  6    rendered, but some pixels are infinite or not a number; they claim nothing
  130  interrupted (Ctrl-C, SIGTERM); what is finished is written, a second Ctrl-C ends it at once";

const RENDER_EXAMPLES: &str = "\
Examples:
  tashika render                                   the built-in room: render.exr, .png, .html
  tashika render kitchen.glb -o kitchen.exr        a picture in 30 s, with the share that is certain
  tashika render kitchen.glb --time 5m             the same with more time
  tashika render kitchen.glb --size 320x180 --crop 100,50,64,64 --camera top
  tashika render kitchen.glb --camera all -o view.exr    view-top.exr, view-side.exr, ...
  tashika render walk.glb --frames 1..48 -o walk.exr     walk-0001.exr, walk-0002.exr, ...
  tashika render kitchen.glb --projection spherical --size 1024x512
  tashika render kitchen.glb --tiles 1/2 -o left.exr     on one machine, 2/2 on another
  tashika render kitchen.glb --error 2% --confidence 95% --audit 100   a promise for each pixel
  tashika render kitchen.glb --claim certified --error 5%
  tashika render kitchen.glb --truth vpl --vpls 55k --gather 16
  tashika render kitchen.glb --cryptomatte               with mattes of objects and materials
  tashika render kitchen.glb --method path --groups each   with a layer of what each light gives
  tashika render kitchen.glb --serve                     watch it in the browser
  tashika render kitchen.glb --tev                       watch it in the viewer tev
  tashika render kitchen.glb --method path --paths 1024  the independent reference";

const VPL_EXAMPLES: &str = "\
Examples:
  tashika vpl kitchen.glb --vpls 55k -o kitchen.vpl
  tashika vpl kitchen.vpl
  tashika render kitchen.glb --vpl-file kitchen.vpl";

const MERGE_EXAMPLES: &str = "\
Examples:
  tashika merge part-1.exr part-2.exr -o kitchen.exr
  tashika merge part-*.exr -o so-far.exr --partial

Of all parts the image is the one that a single machine renders, bit by bit. Parts of another scene,
seed or method are refused; a part that was rendered twice is not.

Audited pictures (`render --tiles` without --error) are reconstructed and
audited here, when no part is missing: exit code 4 where the share was not reached. Any number of parts
gives the same bits, but other ones than the whole that a single machine makes without --tiles.";

const VIEW_EXAMPLES: &str = "\
Examples:
  tashika view kitchen.exr
  tashika view kitchen.exr reference.exr

The page is served to this machine alone, at an address that nobody else can guess, until Ctrl-C.
Tiles are read when they are looked at, so that a file may be larger than the memory.";

/// Options for reading a scene, shared by the commands that read one.
#[derive(Debug, ClapArgs)]
pub struct SceneArgs {
    /// Let the scene read files outside its own folder
    #[arg(long, help_heading = "Scene")]
    pub allow_outside: bool,

    /// Continue without meshes and images that the scene names but that do not exist; `info` lists
    /// their replacements
    #[arg(long, help_heading = "Scene")]
    pub allow_missing: bool,

    /// Time in seconds at which a scene with motion is read
    /// [default: glTF and USD, without their animations; pbrt and Mitsuba, at the first positions]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, help_heading = "Scene")]
    pub at: Option<f64>,

    /// Times at which the shutter of cameras opens and closes, in seconds from --at, from the time
    /// of each frame with --frames, or else from 0. Cameras that move in this interval are blurred;
    /// so are objects that move, in path tracing and in sums over one set of lights
    /// [default: with --at or --frames, no blur; otherwise as in the file, for pbrt and Mitsuba]
    #[arg(long, value_name = "OPEN,CLOSE", value_parser = values::shutter, allow_hyphen_values = true,
        help_heading = "Scene")]
    pub shutter: Option<[f64; 2]>,

    /// Light from infinity, which replaces that of the scene: an image by latitude and longitude,
    /// FILE[,scale=S][,rotate=DEG][,up=z]; a clear sky,
    /// sky:elevation=DEG,azimuth=DEG[,turbidity=T][,scale=S][,up=z]; a sky of ISO 15469 by its
    /// type, 1 to 16, overcast, uniform or clear,
    /// cie:TYPE[,illuminance=LX][,elevation=DEG,azimuth=DEG][,ground=R][,scale=S][,up=z]; or the
    /// all-weather sky of Perez with its sun, by irradiances in W/m2,
    /// perez:dni=E,dhi=E,elevation=DEG,azimuth=DEG or
    /// perez:dni=E,dhi=E,latitude=DEG,longitude=DEG,zone=HOURS,date=YYYY-MM-DD,time=HH:MM, or by an
    /// hour of a weather file, epw:FILE,date=MM-DD,time=HH:MM, each with
    /// [,ground=R][,unit=lx|W][,sun=on|off][,scale=S][,up=z]
    #[arg(long, value_name = "FILE|sky:...|cie:...|perez:...|epw:...", help_heading = "Scene")]
    pub environment: Option<AskedEnvironment>,

    /// Light in addition to the scene's:
    /// sun:elevation=DEG,azimuth=DEG[,turbidity=T][,scale=S][,up=z], point:X,Y,Z,WATTS, or
    /// ies:FILE@X,Y,Z[,scale=S][,rotate=DEG][,up=z], with an IES or EULUMDAT file; may be given
    /// several times
    #[arg(long, value_name = "sun:...|point:...|ies:...", help_heading = "Scene")]
    pub light: Vec<AskedLight>,
}

/// Options for the scene, its cameras and the size of the image.
#[derive(Debug, ClapArgs)]
pub struct StageArgs {
    /// Scene file (.gltf, .glb, .usda, .usdc, .usdz, .obj, .pbrt, .rad, .xml), or builtin:room,
    /// builtin:tiny
    /// [default: builtin:room]
    pub scene: Option<String>,

    #[command(flatten)]
    pub camera: CameraArgs,

    /// Refuse a scene that cannot be rendered as its file describes it: each item that `info` lists
    /// as repaired, approximated or ignored becomes an error
    #[arg(long, help_heading = "Scene")]
    pub strict: bool,

    #[command(flatten)]
    pub scene_args: SceneArgs,

    /// Image size in pixels [default: the camera's, or 640x360]
    #[arg(long, value_name = "WxH", value_parser = values::size, help_heading = "Image")]
    pub size: Option<[u32; 2]>,
}

#[derive(Debug, ClapArgs)]
#[command(after_help = RENDER_EXAMPLES)]
pub struct RenderArgs {
    #[command(flatten)]
    pub stage: StageArgs,

    #[command(flatten)]
    pub frames: FramesArgs,

    /// Render only this part of the image, in pixels from the top left
    #[arg(long, value_name = "X,Y,W,H", value_parser = values::crop, help_heading = "Image")]
    pub crop: Option<Window>,

    /// Render only the K-th of N shares of the image's tiles, for N machines, or several shares
    /// (1,3/4); `tashika merge` joins the parts. Parts of an audited picture claim nothing; merging
    /// audits the whole picture. Its bits differ from those of a picture rendered without --tiles
    #[arg(long, value_name = "K/N", help_heading = "Image")]
    pub tiles: Option<TileShare>,

    #[command(flatten)]
    pub gather: GatherArgs,

    #[command(flatten)]
    pub source: SourceArgs,

    /// Trace the virtual point lights of this render, write them to a file, and exit. Runs with
    /// --vpl-file, this file and the same --truth then render the same bits
    #[arg(long, value_name = "FILE", conflicts_with_all = ["vpl_file", "tiles", "audit", "checkpoint", "serve", "tev"],
        help_heading = "Light")]
    pub write_vpls: Option<PathBuf>,

    /// Method that computes the pixels
    #[arg(long, value_enum, default_value_t = Method::Tashika, help_heading = "Method")]
    pub method: Method,

    /// Relative error that a pixel may have, for the methods that control it: above 0, at most
    /// 100%. Each pixel is then rendered until it is within it; without this option
    /// and without --claim, the picture is audited as a whole
    /// [default: 10% for an audited picture, 5% with --claim calibrated, 2% for a sum]
    #[arg(long, value_name = "2%|0.02", value_parser = values::percentage, allow_negative_numbers = true,
        help_heading = "Method")]
    pub error: Option<f64>,

    /// Quantity whose error is controlled, with --method tashika, or path with --error or --claim:
    /// the luminance, or the worst of the three channels, relative to the largest
    /// [default: luminance]
    #[arg(long, value_name = "luminance|channels", value_parser = values::controlled, help_heading = "Method")]
    pub control: Option<Controlled>,

    /// Absolute error that suffices in dark pixels, in which --error would allow less, as luminance
    /// in the unit of the image; with --method tashika, or path with --error or --claim
    /// [default: for light transport, --error times a hundredth of the view's mean; for a sum, 0]
    #[arg(long, value_name = "E", allow_negative_numbers = true, help_heading = "Method")]
    pub absolute: Option<f64>,

    /// Confidence of the interval around a pixel, for the methods that state one: above 0, below
    /// 100%
    /// [default: 95%]
    #[arg(long, value_name = "95%|0.95", value_parser = values::percentage, allow_negative_numbers = true,
        help_heading = "Method")]
    pub confidence: Option<f64>,

    /// Kind of claim, for --method tashika and, except certified, for path. Calibrated: the
    /// interval of each pixel covers the truth at least as often as the confidence says, by
    /// measurement. Certified: by proof, for two to six times the rays. Audited: the picture is
    /// reconstructed, and --share of its pixels are within --error, by a check of --audit pixels
    /// [default: calibrated with --error and for sums; else audited]
    #[arg(long, value_enum, help_heading = "Method")]
    pub claim: Option<Claim>,

    /// Share of the pixels that is to be within --error, with --claim audited
    /// [default: 95%]
    #[arg(long, value_name = "95%|0.95", value_parser = values::percentage, allow_negative_numbers = true,
        help_heading = "Method")]
    pub share: Option<f64>,

    /// Confidence that --share is reached, with --claim audited
    /// [default: 99%]
    #[arg(long, value_name = "99%|0.99", value_parser = values::percentage, allow_negative_numbers = true,
        help_heading = "Method")]
    pub assurance: Option<f64>,

    /// Quality of the picture: draft is --claim audited --error 10%, good is --claim audited
    /// --error 5%, final has each pixel within 2%
    #[arg(long, value_name = "draft|good|final", value_parser = values::quality, help_heading = "Method")]
    pub quality: Option<Quality>,

    /// Approximate time limit of an audited picture, including its audit; the claim states the
    /// share that was reached by then. Parts of a picture (--tiles) have no time limit
    /// [default: 30s for 640x360, in proportion to the pixels, at least 8s; with --quality or
    /// --claim, until the share is reached, or as long as 64 million paths take]
    #[arg(long, value_name = "60s|5m|1h", value_parser = values::duration, help_heading = "Method")]
    pub time: Option<Duration>,

    /// Number of passes of an audited picture, each of which doubles its paths: a fixed amount of
    /// work, so that the bits are the same on any machine; 1 to 13
    /// [default: as many as the time permits]
    #[arg(long, value_name = "N", value_parser = values::count, help_heading = "Method")]
    pub passes: Option<u64>,

    /// Denoiser of an audited picture: our reconstruction (own), or Open Image Denoise 2, in the
    /// library that TASHIKA_OIDN or the system names (oidn) or in this FILE; auto is oidn where it
    /// is found, else own. With Open Image Denoise the bits may depend on the machine. Parts
    /// (--tiles) store its name, and `merge` needs the same --denoiser
    /// [default: auto; own with --passes and --tiles]
    #[arg(long, value_name = "auto|own|oidn|FILE", help_heading = "Method")]
    pub denoiser: Option<PathBuf>,

    /// Truth that --error is measured from, with --method tashika: light transport itself
    /// (transport), the sum over one set of virtual point lights (vpl), or the limit of that sum
    /// for infinitely many lights (clamped), which lacks the light that the clamp removes and light
    /// that such lights cannot carry
    /// [default: transport; vpl with --claim certified and with --vpl-file]
    #[arg(long, value_name = "vpl|transport|clamped", value_parser = values::truth, help_heading = "Method")]
    pub truth: Option<Truth>,

    /// After the render, compute the truth of N random pixels, by exact sums or by path tracing,
    /// and report how many are within --error. With --claim audited, number of pixels that the
    /// audit checks
    /// [default: none; 600 with --claim audited]
    #[arg(long, value_name = "N", value_parser = values::count, help_heading = "Method")]
    pub audit: Option<u64>,

    /// Largest cut, in pairs of clusters; for light transport, in pairs and paths. A pixel that
    /// reaches it is marked as such and claims nothing
    /// [default: for light transport 65536; for lightcuts and mdlc 1000, as published; else
    /// 1048576]
    #[arg(long, value_name = "N", value_parser = values::count, help_heading = "Method")]
    pub max_pairs: Option<u64>,

    /// Number of paths a pixel, with --method path; with --error or --claim calibrated, the largest
    /// number
    /// [default: 64; 1048576 with --error or --claim calibrated]
    #[arg(long, value_name = "N", value_parser = values::count, help_heading = "Method")]
    pub paths: Option<u64>,

    /// Seed of all random numbers; the same seed gives the same image on any machine, except under
    /// a time limit or with Open Image Denoise
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = "Method")]
    pub seed: u64,

    /// Image to write; its PNG and its page go beside it
    #[arg(short, long, value_name = "FILE.exr", default_value = "render.exr", help_heading = "Output")]
    pub output: PathBuf,

    #[command(flatten)]
    pub layout: ExrArgs,

    #[command(flatten)]
    pub planes: PlaneArgs,

    #[command(flatten)]
    pub picture: PictureArgs,

    #[command(flatten)]
    pub false_color: FalseColorArgs,

    /// Show the image in the viewer tev at HOST:PORT while it is rendered; without an address, tev
    /// on this machine is used (127.0.0.1:14158)
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, default_missing_value = tev::DEFAULT_ADDRESS,
        value_parser = values::address, help_heading = "Output")]
    pub tev: Option<String>,

    #[command(flatten)]
    pub budget: BudgetArgs,

    /// Keep finished tiles in FILE.exr.checkpoint until the image is written; resume from that file
    /// if an earlier run of the same command left one, however that run ended
    #[arg(long, help_heading = "Output")]
    pub checkpoint: bool,

    /// Show the render in the browser while it runs; the program then does not end until the page
    /// is closed
    #[arg(long, help_heading = "Output")]
    pub serve: bool,

    #[command(flatten)]
    pub serving: ServeArgs,

    #[command(flatten)]
    pub common: CommonArgs,
}

#[derive(Debug, ClapArgs)]
pub struct GatherArgs {
    #[arg(long = "gather", value_name = "N", value_parser = values::count, help_heading = "Image",
        help = format!("Gather points a pixel, 1 to 1024; more: smoother edges, depth of field, mirrors \
            [default: {} for sums; for light transport by --error, 51 at 5%]", GatherOptions::default().points))]
    pub points: Option<u64>,

    #[command(flatten)]
    pub filter: FilterArgs,
}

#[derive(Debug, ClapArgs)]
pub struct FilterArgs {
    /// Pixel filter, by which the points or paths of a pixel are distributed: box, evenly inside
    /// the pixel; tent, gaussian (standard deviation 1/2 pixel) and blackman-harris (3 pixels
    /// across), also around it
    /// [default: box]
    #[arg(long, value_name = "box|tent|gaussian|blackman-harris", value_parser = values::filter,
        help_heading = "Image")]
    pub filter: Option<Filter>,
}

/// Lights that are traced, or read from a file.
#[derive(Debug, ClapArgs)]
pub struct SourceArgs {
    #[command(flatten)]
    pub lights: LightArgs,

    /// Virtual point lights from a file that `tashika vpl` or --write-vpls wrote, instead of
    /// tracing them
    #[arg(long, value_name = "FILE", conflicts_with_all = ["vpls", "clamp", "instants"], help_heading = "Light")]
    pub vpl_file: Option<PathBuf>,
}

#[derive(Debug, ClapArgs)]
pub struct LightArgs {
    #[arg(long, value_name = "N", value_parser = values::count, help_heading = "Light",
        help = format!("Approximate number of virtual point lights; 55k and 55_000 are accepted; more: less noise, less \
            clamping [default: {} for sums; for light transport a million or more, for audited pictures 250k or more]", VplOptions::default().count))]
    pub vpls: Option<u64>,

    #[command(flatten)]
    pub set: SetArgs,
}

/// Options for making a set of virtual point lights.
#[derive(Debug, ClapArgs)]
pub struct SetArgs {
    /// Distance in metres below which a virtual point light grows no brighter; auto follows the
    /// spacing of the lights, off leaves bright spots [default: auto]
    #[arg(long, value_name = "auto|off|METRES", value_parser = values::clamp, allow_negative_numbers = true,
        help_heading = "Light")]
    pub clamp: Option<Clamp>,

    #[arg(long, value_name = "N", value_parser = values::count, help_heading = "Light",
        help = format!("Times at which lights and pixels look at what moves while the shutter is open, of \
            sums over one set of lights; more: smoother blur [default: {}]", VplOptions::default().instants))]
    pub instants: Option<u64>,
}

/// Options of every command.
#[derive(Debug, ClapArgs)]
pub struct CommonArgs {
    /// Write the summary as JSON, for scripts; - is standard output, in place of the summary
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub json: Option<PathBuf>,

    /// Format of progress on standard error
    #[arg(long, value_enum, default_value_t = LogStyle::Auto, help_heading = "Output")]
    pub log: LogStyle,

    /// Append progress to a file too, in words, or in JSON with --log json; - is standard error,
    /// line by line
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub log_file: Option<PathBuf>,

    /// Print nothing but errors
    #[arg(short, long, help_heading = "Output")]
    pub quiet: bool,

    /// Number of threads; 0 is one for each core. The image does not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Machine")]
    pub threads: usize,
}

/// Format of progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LogStyle {
    /// One line that is redrawn on a terminal, plain lines elsewhere
    Auto,
    /// One plain line a message
    Plain,
    /// One JSON object a line, for programs
    Json,
}

/// Kind of a claim, by its justification.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Claim {
    /// Measured
    Calibrated,
    /// Proven
    Certified,
    /// Share of the pixels, by an audit
    Audited,
}

impl From<Claim> for ClaimName {
    fn from(claim: Claim) -> Self {
        match claim {
            Claim::Calibrated => Self::Calibrated,
            Claim::Certified => Self::Certified,
            Claim::Audited => Self::Audited,
        }
    }
}

/// Method that computes the pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// The whole sum over all virtual point lights
    Exact,
    /// Walter 2005: clusters of lights, one representative each
    Lightcuts,
    /// Walter 2006: clusters of lights and gather points
    Mdlc,
    /// Nabata 2016: clusters of lights as strata, with a confidence interval
    Nabata2016,
    /// Sakai 2018: pairs of clusters as strata, with a confidence interval
    Sakai2018,
    /// Iwasaki 2019: as Sakai 2018, with bounds for glossy materials
    Iwasaki2019,
    /// Ours: refines each pixel until its interval, which covers the truth with the stated
    /// confidence, is narrow enough
    Tashika,
    /// Ours with certified claims: --method tashika --claim certified
    TashikaCertified,
    /// Path tracing, an independent estimate of light transport itself
    Path,
}

impl Method {
    /// Returns the library's method of this name.
    pub fn name(self) -> tashika::error::Result<MethodName> {
        self.to_possible_value().expect("no method is hidden").get_name().parse()
    }
}

#[derive(Debug, ClapArgs)]
pub struct InfoArgs {
    /// Scene file (.gltf, .glb, .usda, .usdc, .usdz, .obj, .pbrt, .rad, .xml), or builtin:room,
    /// builtin:tiny
    /// [default: builtin:room]
    pub scene: Option<String>,

    #[command(flatten)]
    pub scene_args: SceneArgs,

    #[command(flatten)]
    pub common: CommonArgs,
}

#[derive(Debug, ClapArgs)]
#[command(after_help = VPL_EXAMPLES)]
pub struct VplArgs {
    /// Scene to trace (as for `render`), or a .vpl file to describe [default: builtin:room]
    #[arg(value_name = "SCENE|FILE.vpl")]
    pub input: Option<String>,

    #[command(flatten)]
    pub scene_args: SceneArgs,

    #[command(flatten)]
    pub lights: LightArgs,

    /// Seed of the light paths [default: 1]
    #[arg(long, value_name = "N", help_heading = "Light")]
    pub seed: Option<u64>,

    /// File to write
    #[arg(short, long, value_name = "FILE.vpl", help_heading = "Output")]
    pub output: Option<PathBuf>,

    #[command(flatten)]
    pub common: CommonArgs,
}

#[derive(Debug, ClapArgs)]
#[command(after_help = MERGE_EXAMPLES)]
pub struct MergeArgs {
    /// Parts, in any order, as `tashika render --tiles K/N` wrote them
    #[arg(value_name = "PART.exr", required = true)]
    pub parts: Vec<PathBuf>,

    /// Image to write; its PNG and its page go beside it
    #[arg(short, long, value_name = "FILE.exr", help_heading = "Output")]
    pub output: PathBuf,

    /// Write the image even if parts are missing; its metadata lists the shares that it has
    #[arg(long, help_heading = "Output")]
    pub partial: bool,

    #[command(flatten)]
    pub layout: ExrArgs,

    #[command(flatten)]
    pub budget: BudgetArgs,

    /// Denoiser of an audited picture, as for `render`; it has to be the one for which the parts
    /// were rendered
    /// [default: own]
    #[arg(long, value_name = "own|oidn|FILE", help_heading = "Output")]
    pub denoiser: Option<PathBuf>,

    #[command(flatten)]
    pub picture: PictureArgs,

    #[command(flatten)]
    pub false_color: FalseColorArgs,

    #[command(flatten)]
    pub common: CommonArgs,
}

#[derive(Debug, ClapArgs)]
#[command(after_help = VIEW_EXAMPLES)]
pub struct ViewArgs {
    /// OpenEXR image to view, of any renderer
    #[arg(value_name = "FILE.exr")]
    pub image: PathBuf,

    /// OpenEXR image of the same size, from which errors are measured
    #[arg(value_name = "REF.exr")]
    pub reference: Option<PathBuf>,

    /// Initial tone mapping of the page, as for `render`; the page has all of them
    #[arg(long, value_name = "natural|linear|filmic|aces|agx", default_value_t, help_heading = "Output")]
    pub tonemap: Tone,

    #[command(flatten)]
    pub serve: ServeArgs,

    #[command(flatten)]
    pub common: CommonArgs,
}

/// Option for the exit code when pixels ran out of budget.
#[derive(Debug, ClapArgs)]
pub struct BudgetArgs {
    /// Exit with 0 instead of 4 if pixels ran out of budget, for engines that would repeat the work
    #[arg(long, help_heading = "Output")]
    pub accept_budget: bool,
}

/// Options for serving a page.
#[derive(Debug, ClapArgs)]
pub struct ServeArgs {
    /// Port of this machine on which the page is served; 0 is any free port
    #[arg(long, value_name = "PORT", default_value_t = 0, help_heading = "Machine")]
    pub port: u16,

    /// Print the address of the page without opening it
    #[arg(long, help_heading = "Machine")]
    pub no_browser: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_consistent() {
        Args::command().debug_assert();
    }
}
