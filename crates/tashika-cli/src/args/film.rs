//! What is in the image beside what every render has, and how its file is laid out.

use clap::Args as ClapArgs;
use tashika::io::ExrLayout;

use crate::values;

/// How the image is laid out.
#[derive(Debug, ClapArgs)]
pub struct ExrArgs {
    /// How FILE.exr is laid out, in words with commas between them: parts, one for each layer; tiles
    /// of 64x64 pixels; and a compression, none, rle, zips, zip or piz, none of which loses anything
    #[arg(long, value_name = "parts,tiles,piz", default_value = "zip", help_heading = "Output")]
    pub exr: ExrLayout,
}

/// What is in the image beside what every render has.
#[derive(Debug, ClapArgs)]
pub struct PlaneArgs {
    /// Add mattes of objects and of materials to the image, as Cryptomatte has them: layers
    /// CryptoObject00 and CryptoMaterial00, 01, ... of RANKS names a pixel, 1 to 32, and layers
    /// object_id and material_id of what covers most of it
    #[arg(long, value_name = "RANKS", num_args = 0..=1, require_equals = true, default_missing_value = "6",
        value_parser = values::count, help_heading = "Output")]
    pub cryptomatte: Option<u64>,

    /// Add layers of what each group of lights gives, with --method path: lights of each name apart, or
    /// GROUP=NAME,NAME with names of objects or materials that emit, of lights, or environment; may be
    /// said several times, other lights are the group rest
    #[arg(long, value_name = "each|GROUP=NAME,...", help_heading = "Output")]
    pub groups: Vec<String>,
}
