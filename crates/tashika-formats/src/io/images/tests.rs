//! Tests of every format except OpenEXR against exact values, and with damaged files.

use ::exr::prelude::f16;
use image::{ImageBuffer, Luma, LumaA, Rgb, Rgba};

use super::*;

fn encoded(picture: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

pub(super) fn decoded(bytes: &[u8], name: &str) -> Result<Decoded> {
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
fn sixteen_bits_are_kept_and_so_is_the_encoding() {
    let grey = DynamicImage::from(ImageBuffer::from_pixel(1, 1, Luma([0x8001_u16])));
    let colors = DynamicImage::from(ImageBuffer::from_fn(2, 1, |x, _| {
        Rgba(if x == 0 { [1_u16, 0x0203, 0xfffe, 0xffff] } else { [0, 256, 257, 0xfffe] })
    }));
    let half_clear = DynamicImage::from(ImageBuffer::from_pixel(1, 1, LumaA([300_u16, 0x7fff])));
    for encoding in [Encoding::Srgb, Encoding::Linear] {
        let texels = |picture: &DynamicImage, format| {
            let bytes = encoded(picture, format);
            let decoded = decode(&bytes, "a", encoding, &LoadOptions::default(), &Location::default());
            let Decoded { image, opaque, .. } = decoded.unwrap();
            let texels = match (image.pixels, encoding) {
                (Pixels::Srgb16(t), Encoding::Srgb) | (Pixels::Linear16(t), Encoding::Linear) => t,
                (other, _) => panic!("{encoding:?}: {other:?}"),
            };
            (texels, opaque)
        };
        for format in [ImageFormat::Png, ImageFormat::Tiff] {
            assert_eq!(texels(&grey, format), (vec![[0x8001, 0x8001, 0x8001, 0xffff]], true));
            let rows = vec![[1, 0x0203, 0xfffe, 0xffff], [0, 256, 257, 0xfffe]];
            assert_eq!(texels(&colors, format), (rows, false));
        }
        assert_eq!(texels(&half_clear, ImageFormat::Png), (vec![[300, 300, 300, 0x7fff]], false));
    }
}

#[test]
fn eight_bits_stay_eight() {
    let picture = DynamicImage::from(ImageBuffer::from_pixel(1, 1, Rgba([1_u8, 2, 3, 4])));
    let bytes = encoded(&picture, ImageFormat::Png);
    let Decoded { image, opaque, .. } = decoded(&bytes, "a").unwrap();
    assert!(!opaque);
    assert_eq!(image.bytes(), 4);
    assert!(matches!(image.pixels, Pixels::Linear8(t) if t == [[1, 2, 3, 4]]));
    let at = Location::default();
    let image = decode(&bytes, "a", Encoding::Srgb, &LoadOptions::default(), &at).unwrap().image;
    assert!(matches!(image.pixels, Pixels::Srgb8(t) if t == [[1, 2, 3, 4]]));
}

/// Size and texels of a floating-point image, and the number of repaired texels.
pub(super) fn floats(bytes: &[u8]) -> ([u32; 2], Vec<[f32; 3]>, u64) {
    let decoded = decoded(bytes, "a").unwrap();
    let mut notes = Notes::default();
    decoded.note(&mut notes, &Location::default());
    assert_eq!(notes.iter().map(|note| note.count).sum::<u64>(), decoded.not_finite);
    let Decoded { image, opaque, not_finite, .. } = decoded;
    let Pixels::Float(texels) = image.pixels else { panic!("{:?}", image.pixels) };
    assert!(opaque);
    ([image.width, image.height], texels, not_finite)
}

#[test]
fn floating_point_stays_linear_keeps_its_sign_and_becomes_finite() {
    let picture = |texels: [[f32; 3]; 2]| {
        DynamicImage::from(ImageBuffer::from_fn(2, 1, |x, _| Rgb(texels[x as usize])))
    };
    let tiff = |texels| floats(&encoded(&picture(texels), ImageFormat::Tiff));
    assert_eq!(tiff([[0.5, 8.0, -1.0], [0.0; 3]]), ([2, 1], vec![[0.5, 8.0, -1.0], [0.0; 3]], 0));
    let (nan, infinite) = (f32::NAN, f32::INFINITY);
    let broken = tiff([[nan, -infinite, 3.0], [infinite, 1.0, infinite]]);
    assert_eq!(broken, ([2, 1], vec![[0.0, 0.0, 3.0], [3.0, 1.0, 3.0]], 2));
    let broken = tiff([[nan, -infinite, -3.0], [infinite, -1.0, 0.5]]);
    assert_eq!(broken, ([2, 1], vec![[0.0, -3.0, -3.0], [0.5, -1.0, 0.5]], 2));
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

/// An image in a TIFF file: width, height, tile, bits, sample format (1 unsigned, 3 floating
/// point), samples a texel, kind of an extra sample (1 opacity multiplied, 2 straight), planar.
struct Tiff {
    size: [u32; 2],
    /// Side of a tile; strips of one row otherwise.
    tile: Option<u32>,
    bits: u16,
    format: u16,
    samples: u16,
    extra: Option<u16>,
    planar: bool,
}

const TILED: Tiff =
    Tiff { size: [7, 5], tile: Some(4), bits: 8, format: 1, samples: 3, extra: None, planar: false };

/// Bytes of a file of these images; `value(image, x, y, sample)` is a sample in little-endian
/// bytes.
fn tiff(images: &[Tiff], value: impl Fn(usize, u32, u32, u16) -> Vec<u8>) -> Vec<u8> {
    let mut bytes = b"II\x2a\0\0\0\0\0".to_vec();
    // Position of the address of the next directory.
    let mut link = 4;
    for (number, image) in images.iter().enumerate() {
        let ([width, height], side) = (image.size, image.tile);
        let (across, down) = side.map_or((width, 1), |s| (s, s));
        let planes = if image.planar { image.samples } else { 1 };
        let mut chunks: Vec<[u32; 2]> = Vec::new();
        for plane in 0..planes {
            for top in (0..height).step_by(down as usize) {
                for left in (0..width).step_by(across as usize) {
                    let mut raw = Vec::new();
                    for (y, x) in (top..top + down).flat_map(|y| (left..left + across).map(move |x| (y, x))) {
                        let samples = if image.planar { plane..plane + 1 } else { 0..image.samples };
                        // Beyond the picture, tiles may contain anything.
                        let (x, y) = (x.min(width - 1), y.min(height - 1));
                        raw.extend(samples.flat_map(|sample| value(number, x, y, sample)));
                    }
                    let packed = Vec::new();
                    let mut packer = flate2::write::ZlibEncoder::new(packed, flate2::Compression::default());
                    std::io::Write::write_all(&mut packer, &raw).unwrap();
                    let packed = packer.finish().unwrap();
                    chunks.push([bytes.len() as u32, packed.len() as u32]);
                    bytes.extend(packed);
                }
            }
        }
        let mut fields: Vec<(u16, u16, Vec<u32>)> = vec![
            (254, 4, vec![u32::from(number > 0)]),
            (256, 4, vec![width]),
            (257, 4, vec![height]),
            (258, 3, vec![u32::from(image.bits); usize::from(image.samples)]),
            (259, 3, vec![8]),
            (262, 3, vec![if image.samples < 3 { 1 } else { 2 }]),
            (277, 3, vec![u32::from(image.samples)]),
            (284, 3, vec![if image.planar { 2 } else { 1 }]),
            (339, 3, vec![u32::from(image.format); usize::from(image.samples)]),
        ];
        let column = |i: usize| chunks.iter().map(|chunk| chunk[i]).collect::<Vec<u32>>();
        fields.extend(match side {
            Some(side) => {
                vec![(322, 4, vec![side]), (323, 4, vec![side]), (324, 4, column(0)), (325, 4, column(1))]
            }
            None => vec![(273, 4, column(0)), (278, 4, vec![1]), (279, 4, column(1))],
        });
        fields.extend(image.extra.map(|kind| (338, 3, vec![u32::from(kind)])));
        fields.sort();
        let mut directory = (fields.len() as u16).to_le_bytes().to_vec();
        for (tag, kind, values) in fields {
            let values: Vec<u8> = values
                .iter()
                .flat_map(|v| v.to_le_bytes()[..if kind == 3 { 2 } else { 4 }].to_vec())
                .collect();
            let count = values.len() as u32 / if kind == 3 { 2 } else { 4 };
            directory.extend([tag.to_le_bytes(), kind.to_le_bytes()].concat());
            directory.extend(count.to_le_bytes());
            if values.len() <= 4 {
                directory.extend([values, vec![0; 4]].concat()[..4].to_vec());
            } else {
                directory.extend((bytes.len() as u32).to_le_bytes());
                bytes.extend(values);
            }
        }
        let start = bytes.len() as u32;
        bytes[link..link + 4].copy_from_slice(&start.to_le_bytes());
        bytes.extend(directory);
        link = bytes.len();
        bytes.extend([0; 4]);
    }
    bytes
}

/// A number below 128 that identifies a sample.
fn number(x: u32, y: u32, sample: u16) -> u16 {
    (y * 7 + x) as u16 * 3 + sample
}

#[test]
fn tiled_tiffs_give_their_largest_level_in_every_depth() {
    // A second image in another size, whose samples are all 99: it is not read.
    let of = |image: Tiff, value: &dyn Fn(u16) -> Vec<u8>| {
        let small = Tiff { size: [3, 2], ..image };
        let bytes = tiff(&[image, small], |level, x, y, sample| {
            value(if level == 0 { number(x, y, sample) } else { 99 })
        });
        decoded(&bytes, "wood.tx").unwrap()
    };
    let expected: Vec<[u16; 3]> =
        (0..35).map(|i| [0, 1, 2].map(|sample| number(i % 7, i / 7, sample))).collect();
    for (tile, planar) in [(Some(4), false), (Some(16), false), (None, false), (None, true), (Some(5), true)]
    {
        let image = |bits, format| Tiff { tile, planar, bits, format, ..TILED };
        let Pixels::Linear8(texels) = of(image(8, 1), &|v| vec![v as u8]).image.pixels else { panic!() };
        assert!(texels.iter().zip(&expected).all(|(t, e)| *t == [e[0] as u8, e[1] as u8, e[2] as u8, 255]));
        let wide = of(image(16, 1), &|v| (v + 1000).to_le_bytes().to_vec());
        assert_eq!([wide.image.width, wide.image.height], [7, 5]);
        let Pixels::Linear16(texels) = wide.image.pixels else { panic!() };
        assert!(
            texels
                .iter()
                .zip(&expected)
                .all(|(t, [r, g, b])| { *t == [r + 1000, g + 1000, b + 1000, 0xffff] })
        );
        // A quarter of each number, which 16-bit floats represent exactly.
        let floats: Vec<[f32; 3]> = expected.iter().map(|e| e.map(|v| f32::from(v) * 0.25)).collect();
        let quarter = |v: u16| f32::from(v) * 0.25;
        for (bits, value) in [
            (16, &(|v| f16::from_f32(quarter(v)).to_le_bytes().to_vec()) as &dyn Fn(u16) -> Vec<u8>),
            (32, &|v| quarter(v).to_le_bytes().to_vec()),
            (64, &|v| f64::from(quarter(v)).to_le_bytes().to_vec()),
        ] {
            let Pixels::Float(texels) = of(image(bits, 3), value).image.pixels else { panic!() };
            assert_eq!(texels, floats, "{bits} bits, {tile:?}, {planar}");
        }
    }
}

#[test]
fn samples_of_tiffs_are_grey_colour_and_opacity_as_the_file_says() {
    let texel = |samples: &[u8], extra| {
        let image = Tiff { size: [1, 1], samples: samples.len() as u16, extra, ..TILED };
        let bytes = tiff(&[image], |_, _, _, sample| vec![samples[usize::from(sample)]]);
        let Decoded { image, opaque, .. } = decoded(&bytes, "a.tx").unwrap();
        let Pixels::Linear8(texels) = image.pixels else { panic!() };
        assert_eq!(opaque, texels[0][3] == 255);
        texels[0]
    };
    assert_eq!(texel(&[9], None), [9, 9, 9, 255]);
    assert_eq!(texel(&[9, 50], Some(2)), [9, 9, 9, 50]);
    assert_eq!(texel(&[9, 50], Some(0)), [9, 9, 9, 255], "anything else");
    assert_eq!(texel(&[1, 2, 3, 50], Some(2)), [1, 2, 3, 50]);
    assert_eq!(texel(&[1, 2, 3, 50], None), [1, 2, 3, 50]);
    // The colours were multiplied by the opacity 51/255 = 1/5. They are divided by it, rounded, and
    // limited to 255.
    assert_eq!(texel(&[10, 11, 60, 51], Some(1)), [50, 55, 255, 51]);
    assert_eq!(texel(&[1, 2, 3, 0], Some(1)), [1, 2, 3, 0]);
    for (image, part) in [
        (Tiff { bits: 32, samples: 1, ..TILED }, "32 bits"),
        (Tiff { samples: 4, extra: Some(0), ..TILED }, "4 samples a texel, of which some are neither"),
        (Tiff { planar: true, ..TILED }, "planes in tiles that reach beyond"),
    ] {
        let error = decoded(&tiff(&[image], |_, _, _, _| vec![0; 4]), "a.tx").unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
}

/// A file that is cut off gives an error. With one byte changed, it gives an error or a whole
/// picture.
#[test]
fn damaged_tiffs_are_refused_or_read() {
    for image in [TILED, Tiff { tile: None, planar: true, ..TILED }] {
        let bytes = tiff(&[image], |_, x, y, sample| vec![number(x, y, sample) as u8]);
        for length in 4..bytes.len() - 4 {
            assert!(matches!(decoded(&bytes[..length], "a.tx"), Err(Error::Invalid { .. })), "{length}");
        }
        for i in 4..bytes.len() {
            for change in [0x01, 0x02, 0x80, 0xff] {
                let mut damaged = bytes.clone();
                damaged[i] ^= change;
                if let Ok(Decoded { image, .. }) = decoded(&damaged, "a.tx") {
                    assert_eq!(
                        image.pixels.len() as u64,
                        u64::from(image.width) * u64::from(image.height),
                        "{i}"
                    );
                }
            }
        }
    }
    // One tile of 16384² texels in a file of 300 bytes: refused before memory is allocated.
    let mut huge = tiff(&[Tiff { size: [1, 1], ..TILED }], |_, _, _, _| vec![0]);
    for tag in [256_u16, 257, 322, 323] {
        let field = [tag.to_le_bytes(), 4_u16.to_le_bytes()].concat();
        let at = huge.windows(4).position(|w| w == field).unwrap();
        huge[at + 8..at + 12].copy_from_slice(&16384_u32.to_le_bytes());
    }
    let error = decoded(&huge, "a.tx").unwrap_err().to_string();
    assert!(error.contains("805306368 bytes of texels in a file of"), "{error}");
}
