//! Tests of OpenEXR against exact values (channels, windows, primaries, levels), and with damaged
//! files.

use ::exr::image::write::WritableImage;
use ::exr::image::{AnyChannel, AnyChannels, FlatSamples, Layer};
use ::exr::meta::header::LayerAttributes;
use ::exr::prelude::f16;

use super::*;
use crate::error::{Error, Location};
use crate::io::LoadOptions;
use crate::io::images::tests::{decoded, floats};
use crate::io::images::{self, Decoded, Encoding};
use crate::scene::Pixels;

/// Returns an OpenEXR file with the given channels of 3 × 2 samples.
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
    let expected: Vec<[f32; 3]> = (0..6).map(|i| [10.0, 20.0, 30.0].map(|first| first + i as f32)).collect();
    let mut tiles = exr::image::Encoding::FAST_LOSSLESS;
    tiles.blocks = exr::image::Blocks::Tiles(Vec2(2, 2));
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
    for samples in [halves(-2.0), ramp(-2.0)] {
        let grey = exr(vec![("Y", samples)], tiles);
        assert_eq!(floats(&grey).1, [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0].map(|v| [v; 3]));
    }
}

/// Returns a part of constant channels, given its data window (first column and row, size).
fn part(
    name: &str,
    channels: &[(&str, f32)],
    window: ([i32; 2], [usize; 2]),
) -> Layer<AnyChannels<FlatSamples>> {
    let ([x, y], [width, height]) = window;
    let channels = channels
        .iter()
        .map(|(name, value)| AnyChannel::new(*name, FlatSamples::F32(vec![*value; width * height])));
    let mut attributes = LayerAttributes::named(name);
    attributes.layer_position = Vec2(x, y);
    let encoding = exr::image::Encoding::FAST_LOSSLESS;
    Layer::new((width, height), attributes, encoding, AnyChannels::sort(channels.collect()))
}

/// Returns a file of the given parts with the given display window.
fn parts(layers: Vec<Layer<AnyChannels<FlatSamples>>>, display: ([i32; 2], [usize; 2])) -> Vec<u8> {
    let ([x, y], [width, height]) = display;
    let window = IntegerBounds::new((x, y), (width, height));
    let attributes = exr::meta::header::ImageAttributes::new(window);
    let image = exr::image::Image { attributes, layer_data: exr::prelude::SmallVec::from_vec(layers) };
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// Returns the picture of a file, its approximations and its only channel.
fn approximated(bytes: &[u8]) -> (Vec<[f32; 3]>, Vec<String>, Option<Channel>) {
    let Decoded { image, approximations, lone, .. } = decoded(bytes, "a").unwrap();
    let Pixels::Float(texels) = image.pixels else { panic!() };
    (texels, approximations, lone)
}

#[test]
fn openexr_channels_are_taken_by_their_names() {
    let window = ([0, 0], [1, 1]);
    let colour = |channels: &[(&str, f32)]| {
        let (texels, approximations, lone) = approximated(&parts(vec![part("a", channels, window)], window));
        assert!(approximations.is_empty(), "{approximations:?}");
        (texels[0], lone)
    };
    assert_eq!(colour(&[("R", 0.5)]), ([0.5, 0.0, 0.0], Some(Channel::R)));
    assert_eq!(colour(&[("b", 0.5), ("A", 1.0)]), ([0.0, 0.0, 0.5], Some(Channel::B)));
    assert_eq!(colour(&[("R", 0.5), ("G", 0.25)]), ([0.5, 0.25, 0.0], None));
    assert_eq!(colour(&[("r", 1.0), ("g", 2.0), ("b", 3.0)]), ([1.0, 2.0, 3.0], None));
    assert_eq!(colour(&[("Y", 0.5), ("Z", 9.0)]), ([0.5; 3], None));
    // Three colour channels of a layer take precedence over a single plain colour channel. Three
    // plain ones take precedence over those of a layer.
    let layer = [("d.Z", 9.0), ("v.R", 1.0), ("v.G", 2.0), ("v.B", 3.0)];
    assert_eq!(colour(&layer), ([1.0, 2.0, 3.0], None));
    assert_eq!(colour(&[&layer[..], &[("R", 7.0)]].concat()), ([1.0, 2.0, 3.0], None));
    let plain = [("R", 4.0), ("G", 5.0), ("B", 6.0)];
    assert_eq!(colour(&[&layer[..], &plain].concat()), ([4.0, 5.0, 6.0], None));
    // A Y with an X beside it is a position or a motion, not a luminance.
    assert_eq!(colour(&[("m.X", 8.0), ("m.Y", 8.0), ("v.R", 1.0)]).0, [1.0, 0.0, 0.0]);
    // The first part with colours is read, even if a part without colours comes before it.
    let depth = part("depth", &[("Z", 9.0)], window);
    let several = vec![depth.clone(), part("rgb", &plain, window), part("more", &layer, window)];
    assert_eq!(approximated(&parts(several, window)), (vec![[4.0, 5.0, 6.0]], vec![], None));
    let (texels, said, _) = approximated(&parts(vec![depth], window));
    assert_eq!((texels[0], said), ([9.0; 3], vec!["its only channel \"Z\" is taken as grey".to_owned()]));
}

/// The data window consists of ones. It must be cut off at the edges of the display window, and the
/// rest of the display window must be zero.
#[test]
fn openexr_is_padded_and_cropped_to_its_display_window() {
    let picture = |data, display| approximated(&parts(vec![part("a", &[("Y", 1.0)], data)], display));
    let rows = |rows: &[&str]| -> Vec<[f32; 3]> {
        rows.iter().flat_map(|row| row.chars()).map(|c| [f32::from(u8::from(c == '#')); 3]).collect()
    };
    for (data, display, expected) in [
        (([0, 1], [3, 1]), ([0, 0], [3, 2]), rows(&["...", "###"])),
        (([-2, -1], [6, 4]), ([0, 0], [2, 2]), rows(&["##", "##"])),
        (([-5, -4], [2, 2]), ([-6, -4], [4, 3]), rows(&[".##.", ".##.", "...."])),
        (([1, 1], [9, 1]), ([0, 0], [3, 3]), rows(&["...", ".##", "..."])),
        (([7, 7], [1, 1]), ([7, 7], [1, 1]), rows(&["#"])),
    ] {
        assert_eq!(picture(data, display), (expected, vec![], None), "{data:?} in {display:?}");
    }
    let (texels, said, _) = picture(([1_000_000_000, -1_000_000_000], [1, 1]), ([0, 0], [2, 1]));
    assert_eq!(texels, [[0.0; 3]; 2]);
    assert_eq!(said, ["its data window lies outside of its display window: 0 everywhere"]);
}

/// The display window of a file of 300 bytes claims 1.2 GB, which the limit of texels permits. The
/// file must be refused. With a display window of 2048 × 2048, it must be accepted.
#[test]
fn an_openexr_display_window_takes_no_more_than_the_file_is_worth() {
    let tiny = |display| parts(vec![part("a", &[("Y", 1.0)], ([5, 5], [1, 1]))], display);
    let limit = LoadOptions { max_image_texels: 1 << 40, ..Default::default() };
    let decode =
        |bytes: &[u8]| images::decode(bytes, "a.exr", Encoding::Linear, &limit, &Location::default());
    let bytes = tiny(([0, 0], [10_000, 10_000]));
    let error = decode(&bytes).unwrap_err().to_string();
    let expected =
        format!("a display window of 10000×10000 for 1×1 texels in a file of {} bytes", bytes.len());
    assert!(error.contains(&expected), "{error}");
    assert!(decode(&tiny(([0, 0], [2048, 2048]))).is_ok());
    let few = LoadOptions { max_image_texels: 3, ..Default::default() };
    let error = images::decode(&tiny(([0, 0], [2, 2])), "a", Encoding::Linear, &few, &Location::default());
    assert!(error.unwrap_err().to_string().contains("2×2 texels, where 1 to 3"));
}

#[test]
fn openexr_of_other_primaries_becomes_rec_709() {
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
    let at = |x, y| Vec2(x, y);
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
    let ones = || FlatSamples::F32(vec![1.0; 6]);
    let bytes = exr(vec![("X", ones()), ("Y", ones()), ("Z", ones())], exr::image::Encoding::UNCOMPRESSED);
    let error = decoded(&bytes, "a.exr").unwrap_err().to_string();
    assert!(error.contains("channels X, Y, Z without R, G, B or Y"), "{error}");
    let bytes = exr(vec![("Y", FlatSamples::F32(vec![1.0; 6]))], exr::image::Encoding::UNCOMPRESSED);
    let few = LoadOptions { max_image_texels: 5, ..Default::default() };
    let error = images::decode(&bytes, "a.exr", Encoding::Linear, &few, &Location::default()).unwrap_err();
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

/// The file is a ramp of 7 × 5 texels in three levels, written by `maketx`. Its largest level must
/// be read exactly. With one byte changed, the file must give an error or a whole picture.
#[test]
fn openexr_of_several_levels_is_its_largest_and_damaged_it_is_refused_or_read() {
    let bytes = include_bytes!("../../../../../../fuzz/seeds/image/levels.tx");
    let (size, texels, _) = floats(bytes);
    assert_eq!(size, [7, 5]);
    for (i, texel) in texels.into_iter().enumerate() {
        let expected = [0, 1, 2].map(|k| (3 * i + k) as f32 / 105.0);
        assert_eq!(texel, expected, "texel {i}");
    }
    let mut other_levels = 0;
    for i in 0..bytes.len() {
        for change in [0x01, 0x02, 0x80, 0xff] {
            let mut damaged = bytes.to_vec();
            damaged[i] ^= change;
            match decoded(&damaged, "a.tx") {
                Ok(Decoded { image, .. }) => {
                    let texels = u64::from(image.width) * u64::from(image.height);
                    assert_eq!(image.pixels.len() as u64, texels);
                }
                Err(error) => other_levels += u32::from(error.to_string().contains("of another level")),
            }
        }
    }
    assert!(other_levels > 0, "damage that the reader would not see");
}
