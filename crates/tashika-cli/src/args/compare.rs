//! Arguments of `compare`.

use std::path::PathBuf;

use clap::Args as ClapArgs;
use tashika::io::Tone;

use super::CommonArgs;
use crate::values;

const COMPARE_EXAMPLES: &str = "\
Examples:
  tashika compare kitchen.exr reference.exr
  tashika compare kitchen.exr reference.exr --image error.png --html error.html
  tashika compare other_renderer.exr reference.exr --error 5% --absolute 1e-4 --json numbers.json

The error of a pixel is the distance of its luminance from the reference's, relative to the
reference. It is infinite where a lit pixel meets a black reference; --absolute tolerates that.
Infinite errors are null in the JSON file and are left out of the mean alone. A pixel of A.exr that
is not finite has failed: it is outside of any tolerance. RMSE and relMSE are of linear RGB; PSNR,
SSIM and LDR-FLIP (67 pixels per degree) of the sRGB picture, exposed as the reference asks.";

/// Options of `compare`.
#[derive(Debug, ClapArgs)]
#[command(after_help = COMPARE_EXAMPLES)]
pub struct CompareArgs {
    /// OpenEXR image to measure, of any renderer
    #[arg(value_name = "A.exr")]
    pub image: PathBuf,

    /// OpenEXR image of the same size that is taken for the truth
    #[arg(value_name = "REF.exr")]
    pub reference: PathBuf,

    /// Layer of A.exr to measure instead of the image; a layer has no claims
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,

    /// Tolerance, relative to the reference: above 0, at most 100%
    /// [default: the error that A.exr was rendered to, with its absolute tolerance, or 2%]
    #[arg(long, value_name = "2%|0.02", value_parser = values::percentage,
        allow_negative_numbers = true, help_heading = "Tolerance")]
    pub error: Option<f64>,

    /// Absolute error that is tolerated even where the reference is dark, as luminance in the unit
    /// of the images
    /// [default: 0]
    #[arg(long, value_name = "E", allow_negative_numbers = true, help_heading = "Tolerance")]
    pub absolute: Option<f64>,

    /// Write a picture of each pixel's error, with its scale
    #[arg(id = "picture", long = "image", value_name = "FILE.png", help_heading = "Output")]
    pub picture: Option<PathBuf>,

    /// Write a page with both images, their error and the numbers, in one file
    #[arg(long, value_name = "FILE.html", help_heading = "Output")]
    pub html: Option<PathBuf>,

    /// Initial tone mapping of the page, as for `render`; the page has all of them. The numbers and
    /// the picture of the error do not depend on it
    /// [default: natural]
    #[arg(long, value_name = "natural|linear|filmic|aces|agx", requires = "html", help_heading = "Output")]
    pub tonemap: Option<Tone>,

    #[command(flatten)]
    pub common: CommonArgs,
}
