//! Decoding image files: PNG, JPEG, BMP, TIFF, TGA, Radiance HDR, OpenEXR and PFM.
//!
//! Input: the bytes of a file, and whether its eight-bit values are colours (sRGB) or numbers
//! (linear). Output: an [`Image`]. Sixteen bits a channel are rounded to eight; floating-point
//! formats are linear whatever the caller says, without opacity. Colour profiles and orientation
//! tags are not read.
//!
//! # Guarantee
//! An image of more than [`LoadOptions::max_image_texels`] is refused by its header, before memory
//! is asked for. All texels are finite and not negative: negative values and values that are no
//! number become zero, positive infinity the largest finite value of the image.
//!
//! # Held to this by
//! The tests below; `damaged_gltf::an_image_that_claims_to_be_huge_is_refused`.

mod openexr;
mod pfm;

use std::fmt::Display;
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

/// A decoded image, and what its users ask about it.
#[derive(Debug)]
pub(super) struct Decoded {
    pub image: Image,
    /// Whether every texel is opaque.
    pub opaque: bool,
    /// Texels that were replaced because they were not finite.
    not_finite: u64,
}

impl Decoded {
    /// What a note says about the texels that were replaced, if there are some.
    pub(super) fn repairs(&self) -> Option<String> {
        let name = &self.image.name;
        (self.not_finite > 0).then(|| format!("image {name:?} has texels that are not finite: replaced"))
    }
}

/// Linear texels from the top row; anything may be wrong with them.
struct Floats {
    width: u32,
    height: u32,
    texels: Vec<[f32; 3]>,
}

/// What is decoded, for messages.
const FORMATS: &str = "PNG, JPEG, BMP, TIFF, TGA, HDR, EXR or PFM";

/// Decoders may hold this much besides the picture: tables, one row of tiles (bytes).
const DECODER_SLACK: u64 = 1 << 26;

/// Decodes an image file; `name` is for messages and tells TGA, which has no signature, by its
/// ending.
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
    let Floats { width, height, mut texels } = if bytes.starts_with(&openexr::SIGNATURE) {
        openexr::decode(bytes, name, max_texels).map_err(unreadable)?
    } else if pfm::matches(bytes) {
        pfm::decode(bytes, max_texels).map_err(unreadable)?
    } else {
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format_of(bytes, name, at)?);
        let mut limits = Limits::default();
        // Sixteen bytes a texel: RGBA in f32, the widest there is.
        limits.max_alloc = Some(max_texels.saturating_mul(16).saturating_add(DECODER_SLACK));
        reader.limits(limits);
        let decoder = reader.into_decoder().map_err(|e| unreadable(e.to_string()))?;
        let (width, height) = decoder.dimensions();
        check_size(width, height, max_texels).map_err(unreadable)?;
        match DynamicImage::from_decoder(decoder).map_err(|e| unreadable(e.to_string()))? {
            decoded @ (DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)) => {
                let texels = decoded.into_rgb32f().into_raw().as_chunks::<3>().0.to_vec();
                Floats { width, height, texels }
            }
            other => {
                let texels = other.into_rgba8().into_raw().as_chunks::<4>().0.to_vec();
                let opaque = texels.iter().all(|t| t[3] == u8::MAX);
                let pixels = match encoding {
                    Encoding::Srgb => Pixels::Srgb8(texels),
                    Encoding::Linear => Pixels::Linear8(texels),
                };
                let image = Image { name: name.to_owned(), width, height, pixels };
                return Ok(Decoded { image, opaque, not_finite: 0 });
            }
        }
    };
    let not_finite = repair(&mut texels);
    let image = Image { name: name.to_owned(), width, height, pixels: Pixels::Float(texels) };
    Ok(Decoded { image, opaque: true, not_finite })
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

/// Replaces what is no radiance; the number of texels with a value that is not finite.
fn repair(texels: &mut [[f32; 3]]) -> u64 {
    let finite = texels.as_flattened().iter().copied().filter(|v| v.is_finite());
    let largest = finite.fold(0.0, f32::max);
    let mut not_finite = 0;
    for texel in texels {
        not_finite += u64::from(!texel.iter().all(|v| v.is_finite()));
        // `max` takes the other value if one is no number.
        *texel = texel.map(|v| v.max(0.0).min(largest));
    }
    not_finite
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
    use ::exr::image::write::WritableImage;
    use ::exr::image::{AnyChannel, AnyChannels, FlatSamples, Layer};
    use ::exr::meta::header::LayerAttributes;
    use ::exr::prelude::f16;
    use image::{ImageBuffer, Luma, Rgb, Rgba};

    use super::*;

    fn encoded(picture: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    fn decoded(bytes: &[u8], name: &str) -> Result<Decoded> {
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
            let Decoded { image, opaque, .. } = decoded(&encoded(&picture, format), name).unwrap();
            assert!(opaque);
            assert_eq!((image.width, image.height, image.name.as_str()), (3, 2, name));
            let Pixels::Linear8(texels) = image.pixels else { panic!("{name}") };
            assert_eq!((texels[2], texels[3]), ([200, 0, 7, 255], [0, 200, 7, 255]), "{name}");
        }
        let jpeg = decoded(&encoded(&picture, ImageFormat::Jpeg), "a.jpg").unwrap().image;
        assert_eq!((jpeg.width, jpeg.height), (3, 2));
    }

    #[test]
    fn sixteen_bits_are_reduced_and_the_encoding_is_kept() {
        let picture = DynamicImage::from(ImageBuffer::from_pixel(1, 1, Luma([0x8080_u16])));
        let bytes = encoded(&picture, ImageFormat::Png);
        let at = Location::default();
        let image = decode(&bytes, "a", Encoding::Srgb, &LoadOptions::default(), &at).unwrap().image;
        assert!(matches!(image.pixels, Pixels::Srgb8(t) if t == [[0x80, 0x80, 0x80, 255]]));
        let picture = DynamicImage::from(ImageBuffer::from_pixel(1, 1, Rgba([1_u8, 2, 3, 4])));
        let Decoded { image, opaque, .. } = decoded(&encoded(&picture, ImageFormat::Png), "a").unwrap();
        assert!(!opaque);
        assert!(matches!(image.pixels, Pixels::Linear8(t) if t == [[1, 2, 3, 4]]));
    }

    /// Size and texels of a floating-point image, and how many of them were repaired.
    fn floats(bytes: &[u8]) -> ([u32; 2], Vec<[f32; 3]>, u64) {
        let decoded = decoded(bytes, "a").unwrap();
        assert_eq!(decoded.repairs().is_some(), decoded.not_finite > 0);
        let Decoded { image, opaque, not_finite } = decoded;
        let Pixels::Float(texels) = image.pixels else { panic!("{:?}", image.pixels) };
        assert!(opaque);
        ([image.width, image.height], texels, not_finite)
    }

    #[test]
    fn floating_point_stays_linear_and_becomes_finite_and_not_negative() {
        let picture = |texels: [[f32; 3]; 2]| {
            DynamicImage::from(ImageBuffer::from_fn(2, 1, |x, _| Rgb(texels[x as usize])))
        };
        let tiff = |texels| floats(&encoded(&picture(texels), ImageFormat::Tiff));
        assert_eq!(tiff([[0.5, 8.0, -1.0], [0.0; 3]]), ([2, 1], vec![[0.5, 8.0, 0.0], [0.0; 3]], 0));
        let (nan, infinite) = (f32::NAN, f32::INFINITY);
        let broken = tiff([[nan, -infinite, 3.0], [infinite, 1.0, infinite]]);
        assert_eq!(broken, ([2, 1], vec![[0.0, 0.0, 3.0], [3.0, 1.0, 3.0]], 2));
        assert_eq!(tiff([[infinite; 3], [1.0, nan, 0.0]]).1, [[1.0; 3], [1.0, 0.0, 0.0]]);
        assert_eq!(tiff([[infinite; 3]; 2]), ([2, 1], vec![[0.0; 3]; 2], 2));
        let hdr = encoded(&picture([[2.0, 0.5, 0.0]; 2]), ImageFormat::Hdr);
        assert_eq!(floats(&hdr).1, [[2.0, 0.5, 0.0]; 2]);
    }

    /// A float map with these numbers from the bottom row.
    fn pfm(header: &str, numbers: &[f32]) -> Vec<u8> {
        let big = !header.contains('-');
        let bytes = numbers.iter().flat_map(|v| if big { v.to_be_bytes() } else { v.to_le_bytes() });
        header.bytes().chain(bytes).collect()
    }

    #[test]
    fn float_maps_are_read_in_both_byte_orders_from_the_bottom_row() {
        let numbers: Vec<f32> = (0..12).map(|i| i as f32).collect();
        let color = vec![[6.0, 7.0, 8.0], [9.0, 10.0, 11.0], [0.0, 1.0, 2.0], [3.0, 4.0, 5.0]];
        for header in ["PF\n2 2\n-1.0\n", "PF 2\r\n2 1 "] {
            assert_eq!(floats(&pfm(header, &numbers)), ([2, 2], color.clone(), 0), "{header:?}");
        }
        let grey = vec![[6.0; 3], [8.0; 3], [10.0; 3], [0.0; 3], [2.0; 3], [4.0; 3]];
        assert_eq!(floats(&pfm("Pf\n3 2\n-2\n", &numbers[..6])), ([3, 2], grey, 0));
    }

    #[test]
    fn damaged_float_maps_are_refused() {
        for (header, part) in [
            ("PF\n2 2\n-1.0\n", "bytes for 2×2 texels of 3 channels"),
            ("PF\n4294967295 4294967295\n-1.0\n", "texels, where 1 to"),
            ("PF\n99999999999 2\n-1.0\n", "width \"99999999999\""),
            ("PF\n0 2\n-1.0\n", "0×2 texels"),
            ("PF\n2 2\n0\n", "scale \"0\""),
            ("PF\n2 2\nnan\n", "scale \"nan\""),
            ("PF\n2 -2\n", "height \"-2\""),
            ("PF\n2", "no width"),
        ] {
            let error = decoded(&pfm(header, &[]), "a.pfm").unwrap_err().to_string();
            assert!(error.contains("image \"a.pfm\"") && error.contains(part), "{error}");
        }
    }

    /// An OpenEXR file with these channels of 3 × 2 samples.
    fn exr(channels: Vec<(&str, FlatSamples)>, encoding: exr::image::Encoding) -> Vec<u8> {
        let channels = channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples));
        let layer =
            Layer::new((3, 2), LayerAttributes::default(), encoding, AnyChannels::sort(channels.collect()));
        let mut bytes = Cursor::new(Vec::new());
        exr::image::Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn openexr_gives_its_colors_or_grey_whatever_the_layout() {
        let ramp = |first: f32| FlatSamples::F32((0..6).map(|i| first + i as f32).collect());
        let halves = |first: f32| FlatSamples::F16((0..6).map(|i| f16::from_f32(first + i as f32)).collect());
        let expected: Vec<[f32; 3]> =
            (0..6).map(|i| [10.0, 20.0, 30.0].map(|first| first + i as f32)).collect();
        let mut tiles = exr::image::Encoding::FAST_LOSSLESS;
        tiles.blocks = exr::image::Blocks::Tiles(exr::math::Vec2(2, 2));
        for encoding in [exr::image::Encoding::SMALL_LOSSLESS, tiles] {
            for prefix in ["", "View Layer.Combined."] {
                let name = |letter: &str| format!("{prefix}{letter}");
                let names = ["R", "G", "B", "A"].map(name);
                let bytes = exr(
                    vec![
                        (&names[0], ramp(10.0)),
                        (&names[1], halves(20.0)),
                        (&names[2], ramp(30.0)),
                        (&names[3], ramp(0.0)),
                        ("Depth.Z", ramp(5.0)),
                    ],
                    encoding,
                );
                assert_eq!(floats(&bytes), ([3, 2], expected.clone(), 0), "{prefix:?}");
            }
        }
        let grey = exr(vec![("Y", halves(1.0))], tiles);
        assert_eq!(floats(&grey).1, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0].map(|v| [v; 3]));
    }

    #[test]
    fn openexr_of_other_primaries_becomes_rec_709() {
        use ::exr::meta::attribute::Chromaticities;
        let written = |chromaticities| {
            let constant = |value: f32| FlatSamples::F32(vec![value; 6]);
            let channels = [("R", 0.3), ("G", 0.4), ("B", 0.3)].map(|(n, v)| AnyChannel::new(n, constant(v)));
            let channels = AnyChannels::sort(channels.into_iter().collect());
            let encoding = exr::image::Encoding::UNCOMPRESSED;
            let layer = Layer::new((3, 2), LayerAttributes::default(), encoding, channels);
            let mut image = exr::image::Image::from_layer(layer);
            image.attributes.chromaticities = Some(chromaticities);
            let mut bytes = Cursor::new(Vec::new());
            image.write().to_buffered(&mut bytes).unwrap();
            bytes.into_inner()
        };
        let at = |x, y| exr::math::Vec2(x, y);
        let white = at(0.3127, 0.329);
        let rec2020 =
            Chromaticities { red: at(0.708, 0.292), green: at(0.17, 0.797), blue: at(0.131, 0.046), white };
        let rec709 = Chromaticities { red: at(0.64, 0.33), green: at(0.3, 0.6), blue: at(0.15, 0.06), white };
        assert_eq!(floats(&written(rec709)).1[0], [0.3, 0.4, 0.3], "the same bits");
        let found = floats(&written(rec2020)).1[5];
        let difference = found.iter().zip([0.2412, 0.4133, 0.2899]).map(|(a, b): (&f32, f32)| (a - b).abs());
        assert!(difference.fold(0.0, f32::max) < 2e-4, "{found:?}");
        let nothing = Chromaticities { red: white, green: white, blue: white, white };
        let error = decoded(&written(nothing), "a.exr").unwrap_err().to_string();
        assert!(error.contains("chromaticities"), "{error}");
    }

    #[test]
    fn damaged_and_other_openexr_files_are_refused() {
        let bytes = exr(vec![("Z", FlatSamples::F32(vec![1.0; 6]))], exr::image::Encoding::UNCOMPRESSED);
        let error = decoded(&bytes, "a.exr").unwrap_err().to_string();
        assert!(error.contains("channels Z without R, G, B or Y"), "{error}");
        let bytes = exr(vec![("Y", FlatSamples::F32(vec![1.0; 6]))], exr::image::Encoding::UNCOMPRESSED);
        let few = LoadOptions { max_image_texels: 5, ..Default::default() };
        let error = decode(&bytes, "a.exr", Encoding::Linear, &few, &Location::default()).unwrap_err();
        assert!(error.to_string().contains("3×2 texels, where 1 to 5"), "{error}");
        for length in 4..bytes.len() - 1 {
            assert!(matches!(decoded(&bytes[..length], "a.exr"), Err(Error::Invalid { .. })), "{length}");
        }
        for i in 0..bytes.len() {
            for change in [0x01, 0x80, 0xff] {
                let mut damaged = bytes.clone();
                damaged[i] ^= change;
                if let Ok(Decoded { image, .. }) = decoded(&damaged, "a.exr") {
                    let Pixels::Float(texels) = image.pixels else { continue };
                    assert_eq!(texels.len() as u64, u64::from(image.width) * u64::from(image.height));
                }
            }
        }
    }

    #[test]
    fn more_texels_than_permitted_are_refused_and_other_formats_named() {
        let picture = DynamicImage::from(ImageBuffer::from_pixel(3, 2, Luma([1_u8])));
        let bytes = encoded(&picture, ImageFormat::Png);
        let at = Location::file("s.gltf").item("images[0]");
        let limit = |max_image_texels| LoadOptions { max_image_texels, ..Default::default() };
        assert!(decode(&bytes, "a", Encoding::Srgb, &limit(6), &at).is_ok());
        let error = decode(&bytes, "a", Encoding::Srgb, &limit(5), &at).unwrap_err().to_string();
        assert!(
            error.starts_with("s.gltf: images[0]: image \"a\" that cannot be decoded (3×2 texels,"),
            "{error}"
        );
        assert!(matches!(decoded(b"RIFF\x10\0\0\0WEBPVP8 ", "a.webp"), Err(Error::Unsupported { .. })));
        assert!(matches!(decoded(b"", "a.png"), Err(Error::Invalid { .. })));
    }
}
