//! Round trips, files of other programs, damaged files.

use ::exr::image::write::WritableImage;
use ::exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
use ::exr::meta::attribute::IntegerBounds;
use ::exr::meta::header::{ImageAttributes, LayerAttributes};
use ::exr::meta::{BlockDescription, MetaData};
use ::exr::prelude::{Vec2, f16};

use super::read::decode;
use super::write::encode;
use super::*;
use crate::error::Result;
use crate::film::{Film, PlaneSpec, SampleKind, Value, Window};

const SPECS: &[PlaneSpec] = &[
    PlaneSpec {
        name: "",
        channels: &["R", "G", "B"],
        unit: "W·m⁻²·sr⁻¹",
        kind: SampleKind::F32,
        doc: "Radiance.",
    },
    PlaneSpec {
        name: "half_width",
        channels: &["Y"],
        unit: "W·m⁻²·sr⁻¹",
        kind: SampleKind::F32,
        doc: "Half the width of the interval.",
    },
    PlaneSpec {
        name: "cost",
        channels: &["rays", "pairs"],
        unit: "1",
        kind: SampleKind::U32,
        doc: "Work done.",
    },
];

/// A cropped film with awkward numbers and every type of metadata.
pub(super) fn film() -> Film {
    let window = Window { x: 5, y: 3, width: 19, height: 37 };
    let mut film = Film::new([40, 50], window, SPECS).unwrap();
    let awkward = [0.0, -0.0, f32::MIN_POSITIVE / 4.0, f32::MAX, -1.5e-30, f32::INFINITY, 0.1];
    for (i, (x, y)) in window.pixels().enumerate() {
        let value = |k: usize| awkward[(i + k) % awkward.len()];
        film.plane_mut("").unwrap().set_f32(x, y, &[value(0), x as f32, y as f32 + 0.25]);
        film.plane_mut("half_width").unwrap().set_f32(x, y, &[value(3)]);
        film.plane_mut("cost").unwrap().set_u32(x, y, &[i as u32, u32::MAX - i as u32]);
    }
    let metadata = film.metadata_mut();
    metadata.set("seed", 7_u32);
    metadata.set("large_seed", u64::MAX);
    metadata.set("small", i64::MIN);
    metadata.set("clamp_m", 0.1);
    metadata.set("complete", false);
    metadata.set("scene", "Küche.gltf");
    metadata.set("digits", "12");
    metadata.set("a_name_longer_than_the_thirty_one_letters_of_old_readers", "x");
    film
}

fn decoded(bytes: &[u8]) -> Result<Film> {
    decode(Path::new("film.exr"), bytes)
}

#[test]
fn a_film_comes_back_bit_by_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.exr");
    write_exr(&path, &film()).unwrap();
    let back = read_exr(&path).unwrap();
    assert_eq!(back, film());
    assert_eq!(back.metadata().get("complete"), Some(&Value::Bool(false)));
    assert_eq!(back.metadata().text("digits"), Some("12"));
    assert_eq!(back.plane("cost").unwrap().channels(), ["rays", "pairs"], "in the order of the spec");
}

/// Every layout that can be chosen.
pub(super) fn layouts() -> impl Iterator<Item = ExrLayout> {
    let flags = [[false, false], [true, false], [false, true], [true, true]];
    ExrCompression::ALL
        .into_iter()
        .flat_map(move |compression| flags.map(|[parts, tiles]| ExrLayout { parts, tiles, compression }))
}

#[test]
fn a_film_comes_back_from_every_layout_and_equal_films_are_equal_files() {
    for layout in layouts() {
        let bytes = encode(&film(), &layout).unwrap();
        let back = decoded(&bytes).unwrap_or_else(|e| panic!("{layout}: {e}"));
        assert_eq!(back, film(), "{layout}");
        assert!(encode(&film(), &layout).unwrap() == bytes, "{layout}");
        let meta = MetaData::read_from_buffered(&bytes[..], true).unwrap();
        let names =
            meta.headers.iter().map(|part| part.own_attributes.layer_name.as_ref().map(ToString::to_string));
        let expected = ["rgb", "half_width", "cost"].map(|name| Some(name.to_owned()));
        let expected = if layout.parts { expected.to_vec() } else { vec![None] };
        assert_eq!(names.collect::<Vec<_>>(), expected, "{layout}");
        for part in &meta.headers {
            assert_eq!(matches!(part.blocks, BlockDescription::Tiles(_)), layout.tiles);
        }
    }
}

#[test]
fn parts_that_do_not_fit_together_are_refused() {
    let parts = ExrLayout { parts: true, compression: ExrCompression::None, ..ExrLayout::default() };
    let good = encode(&film(), &parts).unwrap();
    let (name, length) = (b"dataWindow\0box2i\0", 16);
    let last = good.windows(name.len()).rposition(|bytes| bytes == name).unwrap() + name.len() + 4;
    let mut bytes = good.clone();
    // Moves the data window of the last part down by one row, without a change of its size.
    for at in [last + 4, last + 12] {
        let number = i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) + 1;
        bytes[at..at + 4].copy_from_slice(&number.to_le_bytes());
    }
    assert!(last + length < bytes.len());
    let said = decoded(&bytes).unwrap_err().to_string();
    assert!(said.contains("expected one for all of them"), "{said}");
    for end in [good.len() - 1, good.len() / 2, good.len() / 3] {
        assert!(decoded(&good[..end]).is_err(), "{end}");
    }
}

#[test]
fn equal_films_are_equal_files() {
    let first = encode(&film(), &ExrLayout::default()).unwrap();
    for _ in 0..8 {
        assert!(
            encode(&film(), &ExrLayout::default()).unwrap() == first,
            "the order of attributes must not depend on a hash"
        );
    }
}

#[test]
fn a_line_says_what_the_image_is_and_promises() {
    let line = |film: &Film| {
        let bytes = encode(film, &ExrLayout::default()).unwrap();
        let meta = MetaData::read_from_buffered(&bytes[..], false).unwrap();
        meta.headers[0].own_attributes.comments.as_ref().map(ToString::to_string)
    };
    let mut film = film();
    assert_eq!(line(&film), None, "it is not said how the film was made");
    film.metadata_mut().set("method", "path");
    film.metadata_mut().set("complete", true);
    film.metadata_mut().set("scene", "room");
    let made = "room by path: radiance in W/(m^2 sr), linear Rec. 709";
    assert_eq!(line(&film).as_deref(), Some(made));
    film.metadata_mut().set("error", 0.05);
    film.metadata_mut().set("confidence", 0.95);
    film.metadata_mut().set("truth", "transport");
    let promised = "; luminance within 5 % of light transport at 95 % in each pixel whose claim.id is not 0 and whose stop.id is not 4";
    assert_eq!(line(&film), Some(format!("{made}{promised}")));
    film.metadata_mut().set("error_absolute", 0.25);
    assert!(line(&film).unwrap().contains("transport, or 0.25 where it is dark, at 95 %"));
    film.metadata_mut().set("error_absolute", 0.0);
    film.metadata_mut().set("complete", false);
    assert_eq!(line(&film), Some(format!("{made}{promised}; NOT COMPLETE")));
    assert_eq!(
        decoded(&encode(&film, &ExrLayout::default()).unwrap()).unwrap(),
        film,
        "it is no part of the film"
    );
}

#[test]
fn colours_are_colours_to_lossy_compression_in_every_plane() {
    let specs = [
        PlaneSpec { name: "", channels: &["R"], unit: "1", kind: SampleKind::F32, doc: "" },
        PlaneSpec { name: "albedo", channels: &["R"], unit: "1", kind: SampleKind::F32, doc: "" },
        PlaneSpec { name: "coverage", channels: &["A"], unit: "1", kind: SampleKind::F32, doc: "" },
    ];
    let bytes =
        encode(&Film::new([1, 1], Window::full([1, 1]), &specs).unwrap(), &ExrLayout::default()).unwrap();
    let meta = MetaData::read_from_buffered(&bytes[..], false).unwrap();
    let linear = meta.headers[0].channels.list.iter().map(|c| (c.name.to_string(), c.quantize_linearly));
    let expected = [("R", false), ("albedo.R", false), ("coverage.A", true)];
    assert_eq!(linear.collect::<Vec<_>>(), expected.map(|(name, linear)| (name.to_owned(), linear)));
}

/// An image as other programs write it: half floats are allowed, and the data window differs from
/// the display window.
fn foreign(display: IntegerBounds, position: Vec2<i32>, channels: &[(&str, FlatSamples)]) -> Vec<u8> {
    let list = channels.iter().map(|(n, s)| AnyChannel::new(*n, s.clone())).collect();
    let attributes = LayerAttributes::default().with_position(position);
    let layer = Layer::new(Vec2(3, 2), attributes, Encoding::FAST_LOSSLESS, AnyChannels::sort(list));
    let mut bytes = std::io::Cursor::new(Vec::new());
    let image = Image::empty(ImageAttributes::new(display)).with_layer(layer);
    image.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn other_programs_files_are_gathered_into_planes() {
    let ramp = |start: u32| (start..start + 6).collect::<Vec<u32>>();
    let halves = |start| FlatSamples::F16(ramp(start).iter().map(|&v| f16::from_f32(v as f32)).collect());
    let channels = [
        ("A", FlatSamples::F32(vec![1.0; 6])),
        ("R", halves(10)),
        ("G", halves(20)),
        ("B", halves(30)),
        ("light.sun.R", halves(40)),
        ("id", FlatSamples::U32(ramp(50))),
    ];
    // The display window begins one column to the right of the data and ends one row above its end.
    let display = IntegerBounds::new(Vec2(8, 2), Vec2(4, 1));
    let film = decoded(&foreign(display, Vec2(7, 2), &channels)).unwrap();
    assert_eq!((film.size(), film.window()), ([4, 1], Window { x: 0, y: 0, width: 2, height: 1 }));
    assert_eq!(film.plane("").unwrap().channels(), ["R", "G", "B", "A"]);
    assert_eq!(film.plane("").unwrap().f32_at(1, 0), [12.0, 22.0, 32.0, 1.0]);
    assert_eq!(film.plane("light.sun").unwrap().f32_samples(), Some(&[41.0, 42.0][..]));
    assert_eq!(film.plane("id").unwrap().u32_samples(), Some(&[51, 52][..]));
}

#[test]
fn a_data_window_outside_the_picture_is_refused() {
    let display = IntegerBounds::new(Vec2(0, 0), Vec2(4, 4));
    let bytes = foreign(display, Vec2(4, 0), &[("Y", FlatSamples::F32(vec![1.0; 6]))]);
    assert!(decoded(&bytes).unwrap_err().to_string().contains("does not meet the display window"));
}

#[test]
fn damaged_files_are_refused_and_never_panic() {
    assert!(decoded(&[]).is_err());
    assert!(matches!(decoded(b"#?RADIANCE\n").unwrap_err(), Error::Invalid { .. }));
    for layout in ["zip", "parts,tiles,rle"].map(|layout| layout.parse::<ExrLayout>().unwrap()) {
        let good = encode(&film(), &layout).unwrap();
        for length in (8..good.len()).step_by(7) {
            let said = decoded(&good[..length]).unwrap_err().to_string();
            assert!(said.contains("truncated"), "{length} of {} bytes: {said}", good.len());
        }
        // Most of the file has no checksum, so a wrong byte may go unnoticed, but the reader must
        // not panic.
        for i in 0..good.len() {
            let mut bad = good.clone();
            bad[i] ^= 0x15;
            let _ = decoded(&bad);
        }
    }
}

#[test]
fn an_image_larger_than_its_bytes_is_refused_before_memory_is_taken() {
    let mut bytes = encode(&film(), &ExrLayout::default()).unwrap();
    for name in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
        let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4;
        for (i, corner) in [0, 0, 50_000, 50_000_i32].into_iter().enumerate() {
            bytes[at + 4 * i..at + 4 * i + 4].copy_from_slice(&corner.to_le_bytes());
        }
    }
    let said = decoded(&bytes).unwrap_err().to_string();
    assert!(said.contains("an image of 50001x50001 in"), "{said}");
}

#[test]
fn a_wrong_list_of_planes_is_refused() {
    let good = encode(&film(), &ExrLayout::default()).unwrap();
    let at = good.windows(6).position(|w| w == br#""rays""#).expect("in the list of planes") + 1;
    let mut bad = good.clone();
    bad[at..at + 4].copy_from_slice(b"ways");
    let said = decoded(&bad).unwrap_err().to_string();
    assert!(said.starts_with("film.exr: tashika:planes: no channel \"cost.ways\"; expected"), "{said}");
}
