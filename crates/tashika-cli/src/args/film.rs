//! What is in the image beside what every render has, how its file is laid out, and how a picture is
//! made of it.

use clap::Args as ClapArgs;
use tashika::io::{Exposure, ExrLayout, Tone};

use crate::values;

/// How the image is laid out.
#[derive(Debug, ClapArgs)]
pub struct ExrArgs {
    /// How FILE.exr is laid out, in words with commas between them: parts, one for each layer; tiles
    /// of 64x64 pixels; and a compression, none, rle, zips, zip or piz, none of which loses anything
    #[arg(long, value_name = "parts,tiles,piz", default_value = "zip", help_heading = "Output")]
    pub exr: ExrLayout,
}

/// How the picture beside the image is made; the image itself knows nothing of it.
#[derive(Debug, ClapArgs)]
pub struct PictureArgs {
    /// Brightness of the PNG: auto (log-average at middle gray) or stops; 0 shows radiance as it is
    #[arg(long, value_name = "auto|STOPS", value_parser = values::exposure, default_value = "auto",
        allow_negative_numbers = true, help_heading = "Output")]
    pub exposure: Exposure,

    /// Tone mapping of the PNG, and the one that the page begins with: natural (in proportion up to a
    /// knee), linear (cut off at 1), filmic (Hable), aces (Hill's fit) or agx
    #[arg(long, value_name = "natural|linear|filmic|aces|agx", default_value_t, help_heading = "Output")]
    pub tonemap: Tone,
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

    /// Add a layer motion: how far what a pixel shows goes on the film while the shutter is open, in
    /// pixels to the right (motion.x) and up (motion.y)
    #[arg(long, help_heading = "Output")]
    pub motion_vectors: bool,

    /// Add layers of what each group of lights gives: lights of each name apart, or GROUP=NAME,NAME with
    /// names of objects or materials that emit, of lights, or environment; may be said several times,
    /// other lights are the group rest. With --method path they add up to the picture; with the default
    /// method --paths of their own tell them, and no layer claims anything
    #[arg(long, value_name = "each|GROUP=NAME,...", help_heading = "Output")]
    pub groups: Vec<String>,
}
