//! Arguments of `glare`.

use std::path::PathBuf;

use clap::Args as ClapArgs;
use tashika::sensors::Photometry;

use super::CommonArgs;
use crate::values;

const GLARE_EXAMPLES: &str = "\
Examples:
  tashika render office.glb --camera desk --projection fisheye --fov 180 --size 800x800 --error 5% -o eye.exr
  tashika glare eye.exr
  tashika glare eye.exr --photometry radiance --json glare.json
  tashika glare eye.exr --image eye-luminance.png

UGR is that of CIE 117, DGP that of Wienold and Christoffersen 2006. The intervals have every pixel
at its lower or upper limit, whichever makes the index smaller or larger; they are about the glare
sources that the image shows, and need an image whose pixels claim (--error).";

/// Options of `glare`.
#[derive(Debug, ClapArgs)]
#[command(after_help = GLARE_EXAMPLES)]
pub struct GlareArgs {
    /// OpenEXR image of an equidistant fisheye that looks where the observer looks, as --projection
    /// fisheye renders it
    #[arg(value_name = "FILE.exr")]
    pub image: PathBuf,

    /// Angle across the circle of the image in degrees; pixels beyond 180 do not count
    /// [default: the angle that the image was rendered with, or 180]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, help_heading = "Glare")]
    pub angle: Option<f64>,

    /// Luminance in cd/m2 above which a pixel belongs to a glare source
    #[arg(
        long,
        value_name = "CD/M2",
        default_value_t = 2000.0,
        allow_negative_numbers = true,
        help_heading = "Glare"
    )]
    pub threshold: f64,

    /// Conversion to luminance: scene, the numbers of the scene are photometric (1 lm/W); cie, they
    /// are radiometric (683 lm/W, luminosity of Rec. 709); radiance, as Radiance has them (179
    /// lm/W, its weights)
    #[arg(long, value_name = "scene|cie|radiance", value_parser = values::photometry, default_value_t,
        help_heading = "Glare")]
    pub photometry: Photometry,

    /// Write a picture of the luminance in false colours, whose scale ends at the threshold
    #[arg(id = "picture", long = "image", value_name = "FILE.png", help_heading = "Output")]
    pub picture: Option<PathBuf>,

    #[command(flatten)]
    pub common: CommonArgs,
}
