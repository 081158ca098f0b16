//! Options for the planes of the image, the layout of its file, and the picture that is made of it.

use clap::Args as ClapArgs;
use tashika::io::{Exposure, ExrLayout, Tone};
use tashika::sensors::Photometry;

use crate::values;

/// Option for the layout of the image file.
#[derive(Debug, ClapArgs)]
pub struct ExrArgs {
    /// Layout of FILE.exr, in words separated by commas: parts (one for each layer), tiles (of
    /// 64x64 pixels), and a lossless compression (none, rle, zips, zip or piz)
    #[arg(long, value_name = "parts,tiles,piz", default_value = "zip", help_heading = "Output")]
    pub exr: ExrLayout,
}

/// Options for the picture beside the image; they do not change the image itself.
#[derive(Debug, ClapArgs)]
pub struct PictureArgs {
    /// Brightness of the PNG: auto (log-average at middle gray) or stops; 0 shows radiance as it is
    #[arg(long, value_name = "auto|STOPS", value_parser = values::exposure, default_value = "auto",
        allow_negative_numbers = true, help_heading = "Output")]
    pub exposure: Exposure,

    /// Tone mapping of the PNG, and the initial one of the page: natural (in proportion up to a
    /// knee), linear (cut off at 1), filmic (Hable), aces (Hill's fit) or agx
    #[arg(long, value_name = "natural|linear|filmic|aces|agx", default_value_t, help_heading = "Output")]
    pub tonemap: Tone,
}

/// Options for the picture of luminances; they do not change the image itself.
#[derive(Debug, ClapArgs)]
pub struct FalseColorArgs {
    /// Write a picture of the luminance in false colours, with isolines and a scale from 0 to MAX
    /// cd/m2, to FILE-luminance.png, and show it on the page. Without MAX the scale includes 99% of
    /// the pixels
    #[arg(long, value_name = "cd/m2[:MAX]", value_parser = values::false_color, help_heading = "Output")]
    pub false_color: Option<values::FalseColor>,

    /// Conversion to luminance, with --false-color: scene, the numbers of the scene are photometric
    /// (1 lm/W); cie, they are radiometric (683 lm/W, luminosity of Rec. 709); radiance, as
    /// Radiance has them (179 lm/W, its weights)
    /// [default: scene]
    #[arg(long, value_name = "scene|cie|radiance", value_parser = values::photometry, help_heading = "Output")]
    pub photometry: Option<Photometry>,
}

/// Options that add planes to those that every render has.
#[derive(Debug, ClapArgs)]
pub struct PlaneArgs {
    /// Add mattes of objects and of materials to the image, in the layout of Cryptomatte: layers
    /// CryptoObject00 and CryptoMaterial00, 01, ... with RANKS names a pixel, 1 to 32 (6 if not
    /// given), and layers object_id and material_id of the object and material that cover most of a
    /// pixel
    #[arg(long, value_name = "RANKS", num_args = 0..=1, require_equals = true, default_missing_value = "6",
        value_parser = values::count, help_heading = "Output")]
    pub cryptomatte: Option<u64>,

    /// Add a layer motion: the distance that the surface in a pixel moves on the film while the
    /// shutter is open, in pixels to the right (motion.x) and up (motion.y)
    #[arg(long, help_heading = "Output")]
    pub motion_vectors: bool,

    /// Add one layer for each group of lights, with its contribution. A group is GROUP=NAME,NAME,
    /// with names of objects or materials that emit, of lights, or environment; the word each makes
    /// a group for every name. May be given several times; all other lights are the group rest.
    /// With --method path the layers add up to the picture. With the default method they are
    /// estimated by paths of their own (--paths), and no layer claims anything
    #[arg(long, value_name = "each|GROUP=NAME,...", help_heading = "Output")]
    pub groups: Vec<String>,
}
