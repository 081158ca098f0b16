//! Arguments of `coverage` and `experiment`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use tashika::experiment::Grouping;
use tashika::integrator::SumMethod;

use super::{CommonArgs, FilterArgs, GatherArgs, LightArgs, SetArgs, SourceArgs, StageArgs};
use crate::values;

const COVERAGE_EXAMPLES: &str = "\
Examples:
  tashika coverage kitchen.glb --methods mdlc,iwasaki2019
  tashika coverage kitchen.glb --error 1%,2%,5% --confidence 80%,95% --pixels 500 --seeds 10
  tashika coverage builtin:tiny --vpls 1k --json coverage.json

Pixels are drawn at random, their exact sums computed once, and every method rendered with every
error, confidence and seed. Shares are of all pixels and seeds together, with their binomial
interval at 95 %. Methods that state no interval have one row an error.";

const IWASAKI2019_EXAMPLES: &str = "\
Examples:
  tashika experiment iwasaki2019 san-miguel.obj --out figures --pixels 500
  tashika experiment iwasaki2019 kitchen.glb --size 320x180 --vpls 10k --gather 16 --methods mdlc,iwasaki2019

The folder gets an image of each method, the exact reference, pictures of the relative errors, the
table as Markdown, JSON and CSV, plots as SVG, and index.html, which shows them all in one file. With --pixels the reference is that of
some pixels only, and shares come with their binomial interval: a whole reference takes long.";

const SCALING_EXAMPLES: &str = "\
Examples:
  tashika experiment scaling kitchen.glb --out scaling
  tashika experiment scaling kitchen.glb --vpls 1k,10k,100k,1M --gather 16 --methods iwasaki2019";

const EQUAL_QUALITY_EXAMPLES: &str = "\
Examples:
  tashika experiment equal-quality kitchen.glb --out equal
  tashika experiment equal-quality kitchen.glb --error 1% --share 90% --pixels 500

Each method is told larger or smaller errors, by doubling or halving and then by bisection, until
what it is told is the largest, to a tenth, with which that share of its pixels is within --error.";

const ABLATION_EXAMPLES: &str = "\
Examples:
  tashika experiment ablation kitchen.glb --pixels 500 --seeds 4 --out ablation

Each row is the calibrated method without one thing that it is made of.";

const TRANSPORT_EXAMPLES: &str = "\
Examples:
  tashika experiment transport kitchen.glb --out transport
  tashika experiment transport kitchen.glb --error 2% --pixels 500 --reference transport/reference.exr

Pixels are drawn at random and path-traced until the standard error is a quarter of the smallest
--error, or --paths are spent; a row judges by the pixels whose truth has a standard error of at
most a quarter of its own error. The folder gets the truth as reference.exr, to be used again.";

/// Options of all measurements.
#[derive(Debug, Args)]
pub struct MeasureArgs {
    #[arg(long, value_name = "A,B", value_delimiter = ',', value_parser = values::method, help_heading = "Method",
        help = format!("Methods, of {} [default: all of them]", values::method_names()))]
    pub methods: Vec<SumMethod>,

    /// Seed of gather points, lights and the choice of pixels; methods use the seeds 1, 2, ...
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = "Method")]
    pub seed: u64,

    #[command(flatten)]
    pub common: CommonArgs,
}

/// Option for the largest cut; the published size by default.
#[derive(Debug, Args)]
pub struct PairsArgs {
    /// Largest cut, in pairs of clusters
    /// [default: 1000 for lightcuts and mdlc, as published; else 1048576]
    #[arg(long, value_name = "N", value_parser = values::count, help_heading = "Method")]
    pub max_pairs: Option<u64>,
}

/// One tolerance and one confidence.
#[derive(Debug, Args)]
pub struct ToleranceArgs {
    /// Relative error that a pixel may have: above 0, at most 100%
    #[arg(long, value_name = "2%|0.02", value_parser = values::percentage, default_value = "2%",
        allow_negative_numbers = true, help_heading = "Method")]
    pub error: f64,

    /// Confidence, for the methods that state an interval: above 0, below 100%
    #[arg(long, value_name = "95%|0.95", value_parser = values::percentage, default_value = "95%",
        allow_negative_numbers = true, help_heading = "Method")]
    pub confidence: f64,
}

/// Options for the numbers of pixels and of seeds.
#[derive(Debug, Args)]
pub struct TrialsArgs {
    /// Number of pixels, drawn at random, whose exact sums are computed; more: narrower intervals
    #[arg(long, value_name = "N", value_parser = values::count, default_value = "200", help_heading = "Image")]
    pub pixels: u64,

    /// Number of times that each pixel is rendered, with the seeds 1 to N
    #[arg(long, value_name = "N", value_parser = values::count, default_value = "1", help_heading = "Method")]
    pub seeds: u64,
}

#[derive(Debug, Args)]
#[command(after_help = COVERAGE_EXAMPLES)]
pub struct CoverageArgs {
    #[command(flatten)]
    pub stage: StageArgs,

    #[command(flatten)]
    pub gather: GatherArgs,

    #[command(flatten)]
    pub source: SourceArgs,

    /// Relative errors that the methods aim at and are judged by: above 0, at most 100%
    #[arg(long, value_name = "1%,2%", value_delimiter = ',', value_parser = values::percentage,
        default_values = ["2%"], allow_negative_numbers = true, help_heading = "Method")]
    pub error: Vec<f64>,

    /// Confidences of the methods that state intervals: above 0, below 100%
    #[arg(long, value_name = "80%,95%", value_delimiter = ',', value_parser = values::percentage,
        default_values = ["50%", "80%", "90%", "95%", "99%"], allow_negative_numbers = true, help_heading = "Method")]
    pub confidence: Vec<f64>,

    /// Also report groups of pixels separately: quarters by brightness, or diffuse and glossy
    /// surfaces
    #[arg(long, value_name = "brightness,material", value_delimiter = ',', value_parser = values::grouping,
        help_heading = "Image")]
    pub by: Vec<Grouping>,

    /// Write a page with the table and plots, in one file
    #[arg(long, value_name = "FILE.html", help_heading = "Output")]
    pub html: Option<PathBuf>,

    /// Write the table for spreadsheets
    #[arg(long, value_name = "FILE.csv", help_heading = "Output")]
    pub csv: Option<PathBuf>,

    #[command(flatten)]
    pub pairs: PairsArgs,

    #[command(flatten)]
    pub trials: TrialsArgs,

    #[command(flatten)]
    pub measure: MeasureArgs,
}

#[derive(Debug, Subcommand)]
pub enum ExperimentArgs {
    /// Make the figures of Iwasaki 2019: images, reference and relative errors of each method
    #[command(name = "iwasaki2019", alias = "seed", after_help = IWASAKI2019_EXAMPLES)]
    Iwasaki2019(Iwasaki2019Args),
    /// Measure rays a pixel against the number of virtual point lights and of gather points
    #[command(after_help = SCALING_EXAMPLES)]
    Scaling(ScalingArgs),
    /// Measure the cost of each method at equal quality
    #[command(after_help = EQUAL_QUALITY_EXAMPLES)]
    EqualQuality(EqualQualityArgs),
    /// Measure the claims that hold and the cost of our method, whole and without each of its
    /// ingredients
    #[command(after_help = ABLATION_EXAMPLES)]
    Ablation(AblationArgs),
    /// Measure our method with --truth transport, and a path tracer that stops at its own interval,
    /// against converged path tracing
    #[command(after_help = TRANSPORT_EXAMPLES)]
    Transport(TransportArgs),
}

#[derive(Debug, Args)]
pub struct Iwasaki2019Args {
    #[command(flatten)]
    pub stage: StageArgs,

    /// Gather points a pixel, 1 to 1024
    #[arg(long, value_name = "N", value_parser = values::count, default_value = "256", help_heading = "Image")]
    pub gather: u64,

    #[command(flatten)]
    pub filter: FilterArgs,

    /// Approximate number of virtual point lights
    #[arg(long, value_name = "N", value_parser = values::count, default_value = "55k", help_heading = "Light")]
    pub vpls: u64,

    #[command(flatten)]
    pub set: SetArgs,

    /// Virtual point lights from a file that `tashika vpl` wrote, instead of tracing them
    #[arg(long, value_name = "FILE", conflicts_with_all = ["vpls", "clamp", "instants"], help_heading = "Light")]
    pub vpl_file: Option<PathBuf>,

    #[command(flatten)]
    pub tolerance: ToleranceArgs,

    #[command(flatten)]
    pub pairs: PairsArgs,

    /// Compute the exact sums of only N pixels, drawn at random [default: of all pixels]
    #[arg(long, value_name = "N", value_parser = values::count, help_heading = "Image")]
    pub pixels: Option<u64>,

    /// Folder for all files; made if it does not exist
    #[arg(long, value_name = "DIR", default_value = "iwasaki2019", help_heading = "Output")]
    pub out: PathBuf,

    #[command(flatten)]
    pub measure: MeasureArgs,
}

#[derive(Debug, Args)]
pub struct ScalingArgs {
    #[command(flatten)]
    pub stage: StageArgs,

    /// Numbers of gather points a pixel, 1 to 1024; each is measured with each number of lights
    #[arg(long, value_name = "N,N", value_delimiter = ',', value_parser = values::count,
        default_values = ["1", "4", "16", "64"], help_heading = "Image")]
    pub gather: Vec<u64>,

    #[command(flatten)]
    pub filter: FilterArgs,

    /// Approximate numbers of virtual point lights
    #[arg(long, value_name = "N,N", value_delimiter = ',', value_parser = values::count,
        default_values = ["1k", "10k", "100k"], help_heading = "Light")]
    pub vpls: Vec<u64>,

    #[command(flatten)]
    pub set: SetArgs,

    #[command(flatten)]
    pub tolerance: ToleranceArgs,

    #[command(flatten)]
    pub pairs: PairsArgs,

    #[command(flatten)]
    pub trials: TrialsArgs,

    /// Folder for the tables; made if it does not exist
    #[arg(long, value_name = "DIR", default_value = "scaling", help_heading = "Output")]
    pub out: PathBuf,

    #[command(flatten)]
    pub measure: MeasureArgs,
}

#[derive(Debug, Args)]
pub struct AblationArgs {
    #[command(flatten)]
    pub stage: StageArgs,

    #[command(flatten)]
    pub gather: GatherArgs,

    #[command(flatten)]
    pub source: SourceArgs,

    #[command(flatten)]
    pub tolerance: ToleranceArgs,

    #[command(flatten)]
    pub trials: TrialsArgs,

    /// Folder for the tables; made if it does not exist
    #[arg(long, value_name = "DIR", default_value = "ablation", help_heading = "Output")]
    pub out: PathBuf,

    #[command(flatten)]
    pub measure: MeasureArgs,
}

#[derive(Debug, Args)]
pub struct EqualQualityArgs {
    #[command(flatten)]
    pub stage: StageArgs,

    #[command(flatten)]
    pub gather: GatherArgs,

    #[command(flatten)]
    pub source: SourceArgs,

    #[command(flatten)]
    pub tolerance: ToleranceArgs,

    /// Share of the pixels that has to be within the error: above 0, at most 100%
    #[arg(long, value_name = "95%|0.95", value_parser = values::percentage, default_value = "95%",
        allow_negative_numbers = true, help_heading = "Method")]
    pub share: f64,

    /// Largest cut, in pairs of clusters, for all methods: the published maximum of lightcuts and
    /// mdlc would limit their quality [default: 1048576]
    #[arg(long, value_name = "N", value_parser = values::count, help_heading = "Method")]
    pub max_pairs: Option<u64>,

    #[command(flatten)]
    pub trials: TrialsArgs,

    /// Folder for the tables; made if it does not exist
    #[arg(long, value_name = "DIR", default_value = "equal-quality", help_heading = "Output")]
    pub out: PathBuf,

    #[command(flatten)]
    pub measure: MeasureArgs,
}

#[derive(Debug, Args)]
pub struct TransportArgs {
    #[command(flatten)]
    pub stage: StageArgs,

    #[command(flatten)]
    pub gather: GatherArgs,

    #[command(flatten)]
    pub lights: LightArgs,

    /// Relative errors that both methods aim at and are judged by: above 0, at most 100%
    #[arg(long, value_name = "2%,5%", value_delimiter = ',', value_parser = values::percentage,
        default_values = ["2%", "5%", "10%"], allow_negative_numbers = true, help_heading = "Method")]
    pub error: Vec<f64>,

    /// Confidence of the intervals of both methods: above 0, below 100%
    #[arg(long, value_name = "95%|0.95", value_parser = values::percentage, default_value = "95%",
        allow_negative_numbers = true, help_heading = "Method")]
    pub confidence: f64,

    /// Methods to measure; path is the path tracer
    #[arg(long, value_name = "tashika,path", value_delimiter = ',', value_enum,
        default_values = ["tashika", "path"], help_heading = "Method")]
    pub methods: Vec<TransportMethod>,

    /// Largest number of paths a pixel, of the truth and of the path tracer
    #[arg(long, value_name = "N", value_parser = values::count, default_value = "1M", help_heading = "Method")]
    pub paths: u64,

    /// Truth from an earlier run with the same scene, size, camera, seed and number of pixels
    #[arg(long, value_name = "FILE.exr", help_heading = "Image")]
    pub reference: Option<PathBuf>,

    /// Number of pixels, drawn at random
    #[arg(long, value_name = "N", value_parser = values::count, default_value = "200", help_heading = "Image")]
    pub pixels: u64,

    /// Seed of all random numbers, also those of the truth
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = "Method")]
    pub seed: u64,

    /// Number of times that each pixel is rendered, each with lights and paths of its own
    #[arg(long, value_name = "N", value_parser = values::count, default_value = "1", help_heading = "Method")]
    pub seeds: u64,

    /// Folder for the tables and the truth; made if it does not exist
    #[arg(long, value_name = "DIR", default_value = "transport", help_heading = "Output")]
    pub out: PathBuf,

    #[command(flatten)]
    pub common: CommonArgs,
}

/// Estimator of light transport.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TransportMethod {
    /// Our method
    Tashika,
    /// Path tracing until Student's interval is narrow enough
    Path,
}
