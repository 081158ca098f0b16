//! Arguments of `sensors`.

use std::path::PathBuf;

use clap::Args as ClapArgs;
use tashika::render::TileShare;
use tashika::sensors::{Photometry, SensorGridRequest};

use super::{BudgetArgs, Claim, CommonArgs, LightArgs, Method, SceneArgs};
use crate::values;

const SENSORS_EXAMPLES: &str = "\
Examples:
  tashika sensors office.glb --points desk.pts --error 2%         a table on standard output
  tashika sensors office.glb --grid floor:0.5,height=0.8 -o floor.csv --html floor.html
  tashika sensors office.glb --grid 0,0.8,0..6,0.8,4:0.25 -o desk.csv
  tashika sensors hall.glb --light ies:downlight.ies@2,3,2.8 --points desk.csv -o desk.csv
  tashika sensors office.glb --environment cie:overcast --daylight-factor --grid floor:1 -o df.csv
  tashika sensors office.glb --points desk.pts --claim certified --error 5%

A file of points has lines of six numbers, x y z nx ny nz, in metres in the coordinates of the scene;
a table has columns x, y, z, and optionally nx, ny, nz, name and shape (plane, cylinder or sphere).
Each value is within its half-width with the confidence that was asked for. A certified value is about
the sum over one set of virtual point lights; model, materials and sky are the user's in any case.";

/// Options of `sensors`.
#[derive(Debug, ClapArgs)]
#[command(after_help = SENSORS_EXAMPLES)]
pub struct SensorsArgs {
    /// Scene file (.gltf, .glb, .usda, .usdc, .usdz, .obj, .pbrt, .rad, .xml), or builtin:room,
    /// builtin:tiny
    pub scene: String,

    /// File of sensors: lines x y z nx ny nz (.pts), or a table with a header (.csv)
    #[arg(long, value_name = "FILE", required_unless_present = "grid", help_heading = "Sensors")]
    pub points: Option<PathBuf>,

    /// Grid of sensors over the faces of an object that look up, OBJECT:SPACING[,height=H][,up=z],
    /// or over a rectangle with two equal coordinates, X0,Y0,Z0..X1,Y1,Z1:SPACING[,height=H]; in
    /// metres
    #[arg(long, value_name = "OBJECT:SPACING", value_parser = values::sensor_grid, conflicts_with = "points",
        allow_hyphen_values = true, help_heading = "Sensors")]
    pub grid: Option<SensorGridRequest>,

    /// Conversion to illuminance: scene, the numbers of the scene are photometric, as in IES files
    /// and glTF (1 lm/W); cie, they are radiometric (683 lm/W, luminosity of Rec. 709); radiance,
    /// as Radiance has them (179 lm/W, its weights)
    #[arg(long, value_name = "scene|cie|radiance", value_parser = values::photometry, default_value_t,
        help_heading = "Sensors")]
    pub photometry: Photometry,

    /// Add the daylight factor: illuminance relative to that of an unobstructed horizontal plane
    /// under the environment
    #[arg(long, help_heading = "Sensors")]
    pub daylight_factor: bool,

    /// Axis to the zenith, for the daylight factor
    #[arg(long, value_name = "y|z", value_parser = ["y", "z"], default_value = "y", help_heading = "Sensors")]
    pub up: String,

    /// Refuse a scene that cannot be rendered as its file describes it: each item that `info` lists
    /// as repaired, approximated or ignored becomes an error
    #[arg(long, help_heading = "Scene")]
    pub strict: bool,

    #[command(flatten)]
    pub scene_args: SceneArgs,

    /// Measure only the K-th of N shares of the sensors, for N machines; the rows of all shares
    /// together are those of one machine
    #[arg(long, value_name = "K/N", help_heading = "Sensors")]
    pub tiles: Option<TileShare>,

    #[command(flatten)]
    pub lights: LightArgs,

    /// Method that computes the sensors
    #[arg(long, value_enum, default_value_t = Method::Tashika, help_heading = "Method")]
    pub method: Method,

    /// Relative error that a sensor may have: above 0, at most 100%
    /// [default: 5%; 2% with --claim certified]
    #[arg(long, value_name = "2%|0.02", value_parser = values::percentage, allow_negative_numbers = true,
        help_heading = "Method")]
    pub error: Option<f64>,

    /// Absolute error in lux that suffices at dark sensors, at which --error would allow less
    /// [default: --error times a hundredth of the mean; with --claim certified, 0]
    #[arg(long, value_name = "LX", allow_negative_numbers = true, help_heading = "Method")]
    pub absolute: Option<f64>,

    /// Confidence of the interval of a sensor: above 0, below 100%
    /// [default: 95%]
    #[arg(long, value_name = "95%|0.95", value_parser = values::percentage, allow_negative_numbers = true,
        help_heading = "Method")]
    pub confidence: Option<f64>,

    /// Make the intervals of all sensors hold together with the confidence: each of N sensors then
    /// has the confidence 1 - (1 - C)/N
    #[arg(long, help_heading = "Method")]
    pub jointly: bool,

    /// Kind of claim: calibrated, by measurement, about light transport; certified, by proof, about
    /// the sum over one set of virtual point lights
    /// [default: calibrated]
    #[arg(long, value_enum, help_heading = "Method")]
    pub claim: Option<Claim>,

    /// Largest cut, in pairs and paths; a sensor that reaches it claims nothing
    /// [default: 65536; 1048576 with --claim certified]
    #[arg(long, value_name = "N", value_parser = values::count, help_heading = "Method")]
    pub max_pairs: Option<u64>,

    /// Largest number of paths of a sensor, with --method path
    /// [default: 1048576]
    #[arg(long, value_name = "N", value_parser = values::count, help_heading = "Method")]
    pub paths: Option<u64>,

    /// Seed of all random numbers; the same seed gives the same values on any machine
    #[arg(long, value_name = "N", default_value_t = 1, help_heading = "Method")]
    pub seed: u64,

    /// Table to write; - is standard output
    #[arg(short, long, value_name = "FILE.csv", default_value = "-", help_heading = "Output")]
    pub output: PathBuf,

    /// Page to write: the plan in false colours with the interval of each sensor, the summary and
    /// the worst sensors
    #[arg(long, value_name = "FILE.html", help_heading = "Output")]
    pub html: Option<PathBuf>,

    #[command(flatten)]
    pub budget: BudgetArgs,

    #[command(flatten)]
    pub common: CommonArgs,
}
