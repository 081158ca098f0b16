//! Decoding image files: PNG, JPEG, BMP, TIFF, TGA and Radiance HDR.
//!
//! Input: the bytes of a file, and whether its eight-bit values are colours (sRGB) or numbers (linear).
//! Output: an [`Image`]. Sixteen bits a channel are rounded to eight; floating-point formats are linear
//! whatever the caller says, and their negative values become zero. Colour profiles and orientation
//! tags are not read.
//!
//! # Guarantee
//! An image of more than [`LoadOptions::max_image_texels`] is refused by its header, before memory is
//! asked for. All texels are finite.
//!
//! # Held to this by
//! The tests below; `damaged_gltf::an_image_that_claims_to_be_huge_is_refused`.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::LoadOptions;
use crate::error::{Error, Location, Result};
use crate::scene::{Image, Pixels};

/// What eight-bit values stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Encoding {
    /// Colours, through the sRGB curve.
    Srgb,
    /// Numbers: roughness, metalness, masks.
    Linear,
}

/// What is decoded, for messages.
const FORMATS: &str = "PNG, JPEG, BMP, TIFF, TGA or HDR";

/// Decoders may hold this much besides the picture: tables, one row of tiles (bytes).
const DECODER_SLACK: u64 = 1 << 26;

/// Decodes an image file; `name` is for messages and tells TGA, which has no signature, by its ending.
pub(super) fn decode(
    bytes: &[u8],
    name: &str,
    encoding: Encoding,
    options: &LoadOptions,
    at: &Location,
) -> Result<Image> {
    let unreadable = |e: image::ImageError| {
        Error::invalid(at.clone(), format!("image {name:?} that cannot be decoded ({e})"), FORMATS)
    };
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format_of(bytes, name, at)?);
    let mut limits = Limits::default();
    // Sixteen bytes a texel: RGBA in f32, the widest there is.
    limits.max_alloc = Some(options.max_image_texels.saturating_mul(16).saturating_add(DECODER_SLACK));
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(unreadable)?;
    let (width, height) = decoder.dimensions();
    let texels = u64::from(width) * u64::from(height);
    if texels == 0 || texels > options.max_image_texels {
        let found = format!("image {name:?} of {width}×{height} texels");
        return Err(Error::invalid(at.clone(), found, format!("1 to {} texels", options.max_image_texels)));
    }
    let decoded = DynamicImage::from_decoder(decoder).map_err(unreadable)?;
    let pixels = match decoded {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            let raw = decoded.into_rgb32f().into_raw();
            if !raw.iter().all(|v| v.is_finite()) {
                let found = format!("image {name:?} with texels that are not finite");
                return Err(Error::invalid(at.clone(), found, "finite numbers"));
            }
            Pixels::Float(raw.as_chunks::<3>().0.iter().map(|texel| texel.map(|v| v.max(0.0))).collect())
        }
        other => {
            let raw = other.into_rgba8().into_raw();
            let texels = raw.as_chunks::<4>().0.to_vec();
            match encoding {
                Encoding::Srgb => Pixels::Srgb8(texels),
                Encoding::Linear => Pixels::Linear8(texels),
            }
        }
    };
    Ok(Image { name: name.to_owned(), width, height, pixels })
}

/// The format by the file's signature, whatever its name; TGA has none and goes by the name.
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
mod tests {
    use image::{ImageBuffer, Luma, Rgb, Rgba};

    use super::*;

    fn encoded(picture: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    fn decoded(bytes: &[u8], name: &str) -> Result<Image> {
        decode(bytes, name, Encoding::Linear, &LoadOptions::default(), &Location::file("s.gltf"))
    }

    #[test]
    fn every_format_gives_its_texels_from_the_top_row() {
        let picture =
            DynamicImage::from(ImageBuffer::from_fn(3, 2, |x, y| Rgb([x as u8 * 100, y as u8 * 200, 7])));
        for (format, name) in [
            (ImageFormat::Png, "a.png"),
            (ImageFormat::Bmp, "wrong-ending.jpg"),
            (ImageFormat::Tiff, "a"),
            (ImageFormat::Tga, "a.TGA"),
        ] {
            let image = decoded(&encoded(&picture, format), name).unwrap();
            assert_eq!((image.width, image.height, image.name.as_str()), (3, 2, name));
            let Pixels::Linear8(texels) = image.pixels else { panic!("{name}") };
            assert_eq!((texels[2], texels[3]), ([200, 0, 7, 255], [0, 200, 7, 255]), "{name}");
        }
        let jpeg = decoded(&encoded(&picture, ImageFormat::Jpeg), "a.jpg").unwrap();
        assert_eq!((jpeg.width, jpeg.height), (3, 2));
    }

    #[test]
    fn sixteen_bits_are_reduced_and_the_encoding_is_kept() {
        let picture = DynamicImage::from(ImageBuffer::from_pixel(1, 1, Luma([0x8080_u16])));
        let bytes = encoded(&picture, ImageFormat::Png);
        let at = Location::default();
        let image = decode(&bytes, "a", Encoding::Srgb, &LoadOptions::default(), &at).unwrap();
        assert!(matches!(image.pixels, Pixels::Srgb8(t) if t == [[0x80, 0x80, 0x80, 255]]));
        let picture = DynamicImage::from(ImageBuffer::from_pixel(1, 1, Rgba([1_u8, 2, 3, 4])));
        let image = decoded(&encoded(&picture, ImageFormat::Png), "a").unwrap();
        assert!(matches!(image.pixels, Pixels::Linear8(t) if t == [[1, 2, 3, 4]]));
    }

    #[test]
    fn floating_point_stays_linear_finite_and_not_negative() {
        let float = |v| DynamicImage::from(ImageBuffer::from_pixel(1, 1, Rgb([v, 8.0_f32, -1.0])));
        let image = decoded(&encoded(&float(0.5), ImageFormat::Tiff), "a").unwrap();
        assert!(matches!(image.pixels, Pixels::Float(t) if t == [[0.5, 8.0, 0.0]]));
        let error = decoded(&encoded(&float(f32::NAN), ImageFormat::Tiff), "a").unwrap_err();
        assert!(error.to_string().contains("not finite"), "{error}");
        let hdr = encoded(
            &DynamicImage::from(ImageBuffer::from_pixel(2, 1, Rgb([2.0_f32, 0.5, 0.0]))),
            ImageFormat::Hdr,
        );
        assert!(matches!(decoded(&hdr, "a").unwrap().pixels, Pixels::Float(t) if t == [[2.0, 0.5, 0.0]; 2]));
    }

    #[test]
    fn more_texels_than_permitted_are_refused_and_other_formats_named() {
        let picture = DynamicImage::from(ImageBuffer::from_pixel(3, 2, Luma([1_u8])));
        let bytes = encoded(&picture, ImageFormat::Png);
        let at = Location::file("s.gltf").item("images[0]");
        let limit = |max_image_texels| LoadOptions { max_image_texels, ..Default::default() };
        assert!(decode(&bytes, "a", Encoding::Srgb, &limit(6), &at).is_ok());
        let error = decode(&bytes, "a", Encoding::Srgb, &limit(5), &at).unwrap_err().to_string();
        assert_eq!(error, "s.gltf: images[0]: image \"a\" of 3×2 texels; expected 1 to 5 texels");
        assert!(matches!(decoded(b"RIFF\x10\0\0\0WEBPVP8 ", "a.webp"), Err(Error::Unsupported { .. })));
        assert!(matches!(decoded(b"", "a.png"), Err(Error::Invalid { .. })));
    }
}
