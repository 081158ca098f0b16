//! Decoding image files: PNG, JPEG, BMP, TIFF, TGA, Radiance HDR, OpenEXR and PFM.
//!
//! Input: the bytes of a file, and the meaning of its integers: colours (sRGB) or numbers (linear).
//! Output: an [`Image`] with 16 bits a channel if the file has them, otherwise with 8. Images of
//! floating-point formats are always linear and have no opacity. Colour profiles and orientation
//! tags are not read.
//!
//! # Guarantee
//! An image of more than [`LoadOptions::max_image_texels`] is refused by its header, before memory
//! is allocated. All texels are finite. NaN becomes zero. Infinities become the largest or the
//! least finite value of the image, or zero if that value has the other sign. Values below zero
//! stay: they are valid heights but not valid colours, and only the use of the image decides which
//! of them they are.
//!
//! # Held to this by
//! The tests beside it; `damaged_gltf::an_image_that_claims_to_be_huge_is_refused`.

mod openexr;
mod pfm;
mod tiff;

use std::fmt::Display;
use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::LoadOptions;
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::scene::{Channel, Image, NoteKind, Notes, Pixels};

/// Meaning of integers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Encoding {
    /// Colours, decoded by the sRGB curve.
    Srgb,
    /// Numbers: roughness, metalness, masks.
    Linear,
}

/// A decoded image, with properties that its users need.
#[derive(Debug)]
pub(super) struct Decoded {
    pub image: Image,
    /// True if every texel is opaque.
    pub opaque: bool,
    /// Channel from which a number is read, if it is not the luminance.
    pub lone: Option<Channel>,
    /// Texels that were replaced because they were not finite.
    not_finite: u64,
    /// Descriptions of differences from the meaning of the file.
    approximations: Vec<String>,
}

impl Decoded {
    /// Adds notes of replaced texels and of differences from the meaning of the file.
    pub(super) fn note(&self, notes: &mut Notes, at: &Location) {
        let name = &self.image.name;
        let message = format!("image {name:?} has texels that are not finite: replaced");
        notes.push_many(NoteKind::Repaired, message, at.clone(), self.not_finite);
        for what in &self.approximations {
            notes.push(NoteKind::Approximated, format!("image {name:?}: {what}"), at.clone());
        }
    }
}

/// Result of a decoder: texels from the top row.
struct DecodedImage {
    width: u32,
    height: u32,
    texels: Texels,
    /// Channel from which a number is read, if it is not the luminance.
    lone: Option<Channel>,
    /// Descriptions of differences from the meaning of the file.
    approximations: Vec<String>,
}

impl DecodedImage {
    /// Creates a picture whose numbers are luminances.
    fn new(width: u32, height: u32, texels: Texels) -> Self {
        Self { width, height, texels, lone: None, approximations: Vec::new() }
    }
}

/// Texels as stored in the file.
enum Texels {
    Eight(Vec<[u8; 4]>),
    Sixteen(Vec<[u16; 4]>),
    /// Linear; may be negative, infinite or NaN.
    Floats(Vec<[f32; 3]>),
}

/// Formats that are decoded, for messages.
const FORMATS: &str = "PNG, JPEG, BMP, TIFF, TGA, HDR, EXR or PFM";

/// Memory of decoders besides the picture: tables, one row of tiles (bytes).
const DECODER_SLACK: u64 = 1 << 26;

/// Decodes an image file. `name` is for messages, and its ending identifies TGA, which has no
/// signature.
pub(super) fn decode(
    bytes: &[u8],
    name: &str,
    encoding: Encoding,
    options: &LoadOptions,
    at: &Location,
) -> Result<Decoded> {
    let max_texels = options.max_image_texels;
    let unreadable = |why: String| {
        Error::invalid(at.clone(), format!("image {name:?} that cannot be decoded ({why})"), FORMATS)
    };
    let picture = if bytes.starts_with(&openexr::SIGNATURE) {
        openexr::decode(bytes, name, max_texels).map_err(unreadable)?
    } else if pfm::matches(bytes) {
        pfm::decode(bytes, max_texels).map_err(unreadable)?
    } else {
        let format = format_of(bytes, name, at)?;
        let picture = match format {
            ImageFormat::Tiff => tiff::decode(bytes, max_texels),
            _ => Ok(None),
        };
        let picture = picture.transpose().unwrap_or_else(|| common(bytes, format, max_texels));
        picture.map_err(unreadable)?
    };
    let DecodedImage { width, height, texels, lone, approximations } = picture;
    let (pixels, opaque, not_finite) = match texels {
        Texels::Eight(texels) => {
            let opaque = texels.iter().all(|t| t[3] == u8::MAX);
            let pixels = match encoding {
                Encoding::Srgb => Pixels::Srgb8(texels),
                Encoding::Linear => Pixels::Linear8(texels),
            };
            (pixels, opaque, 0)
        }
        Texels::Sixteen(texels) => {
            let opaque = texels.iter().all(|t| t[3] == u16::MAX);
            let pixels = match encoding {
                Encoding::Srgb => Pixels::Srgb16(texels),
                Encoding::Linear => Pixels::Linear16(texels),
            };
            (pixels, opaque, 0)
        }
        Texels::Floats(mut texels) => {
            let not_finite = repair(&mut texels);
            (Pixels::Float(texels), true, not_finite)
        }
    };
    let image = Image { name: name.to_owned(), width, height, pixels };
    Ok(Decoded { image, opaque, lone, not_finite, approximations })
}

/// An image of one colour.
pub(super) fn one_texel(name: &str, color: Rgb) -> Image {
    let pixels = Pixels::Float(vec![color.to_array()]);
    Image { name: name.to_owned(), width: 1, height: 1, pixels }
}

/// Decodes the formats of the `image` crate.
fn common(bytes: &[u8], format: ImageFormat, max_texels: u64) -> Result<DecodedImage, String> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    // Sixteen bytes a texel: RGBA in `f32`, the widest format.
    limits.max_alloc = Some(max_texels.saturating_mul(16).saturating_add(DECODER_SLACK));
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(|e| e.to_string())?;
    let (width, height) = decoder.dimensions();
    check_size(width, height, max_texels)?;
    let texels = match DynamicImage::from_decoder(decoder).map_err(|e| e.to_string())? {
        decoded @ (DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)) => {
            Texels::Floats(decoded.into_rgb32f().into_raw().as_chunks::<3>().0.to_vec())
        }
        decoded @ (DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_)) => {
            Texels::Sixteen(decoded.into_rgba16().into_raw().as_chunks::<4>().0.to_vec())
        }
        other => Texels::Eight(other.into_rgba8().into_raw().as_chunks::<4>().0.to_vec()),
    };
    Ok(DecodedImage::new(width, height, texels))
}

/// Refuses images without texels, or with more than permitted.
fn check_size<N: Copy + Display + TryInto<u32>>(width: N, height: N, max_texels: u64) -> Result<(), String> {
    let texels = match (width.try_into(), height.try_into()) {
        (Ok(width), Ok(height)) => u64::from(width) * u64::from(height),
        _ => u64::MAX,
    };
    if (1..=max_texels).contains(&texels) {
        return Ok(());
    }
    Err(format!("{width}×{height} texels, where 1 to {max_texels} are permitted"))
}

/// Replaces values that are not finite. Returns the number of texels with such a value.
fn repair(texels: &mut [[f32; 3]]) -> u64 {
    let finite = || texels.as_flattened().iter().copied().filter(|v| v.is_finite());
    let (least, largest) = (finite().fold(0.0, f32::min), finite().fold(0.0, f32::max));
    let mut not_finite = 0;
    for texel in texels {
        not_finite += u64::from(!texel.iter().all(|v| v.is_finite()));
        *texel = texel.map(|v| if v.is_nan() { 0.0 } else { v.clamp(least, largest) });
    }
    not_finite
}

/// Format by the signature of the file, regardless of its name. TGA has no signature and is
/// recognised by the name.
fn format_of(bytes: &[u8], name: &str, at: &Location) -> Result<ImageFormat> {
    use ImageFormat::{Bmp, Hdr, Jpeg, Png, Tga, Tiff};
    match image::guess_format(bytes) {
        Ok(format @ (Png | Jpeg | Bmp | Tiff | Hdr)) => Ok(format),
        Ok(other) => {
            let what = format!("image {name:?} in the format {}", other.to_mime_type());
            Err(Error::unsupported(at.clone(), what, format!("convert it to {FORMATS}")))
        }
        Err(_) if name.to_ascii_lowercase().ends_with(".tga") => Ok(Tga),
        Err(_) => Err(Error::invalid(at.clone(), format!("image {name:?} of unknown format"), FORMATS)),
    }
}

#[cfg(test)]
mod tests;
