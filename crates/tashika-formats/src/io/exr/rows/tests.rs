//! Rows that are read on demand equal those of the whole film; damage is an error.

use std::fs;

use ::exr::image::write::WritableImage;
use ::exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer, Layers};
use ::exr::meta::attribute::{IntegerBounds, LineOrder};
use ::exr::meta::header::{ImageAttributes, LayerAttributes};
use ::exr::prelude::{Compression, f16};

use super::super::tests::{film, layouts};
use super::super::{read_exr, write_exr, write_exr_as};
use super::*;

const SIZE: Vec2<usize> = Vec2(37, 83);

/// A layer as other programs write it: halves, floats and counts, which depend on `seed`.
fn layer(
    name: &str,
    seed: usize,
    position: Vec2<i32>,
    encoding: Encoding,
) -> Layer<AnyChannels<FlatSamples>> {
    let samples = |c: usize| (0..SIZE.area()).map(move |i| (i * 7919 + seed + c * 31) % 65_521);
    let halves = |c| samples(c).map(|v| f16::from_f32(v as f32 / 64.0 - 100.0)).collect();
    let channels = [
        ("R", FlatSamples::F16(halves(0))),
        ("G", FlatSamples::F16(halves(1))),
        ("B", FlatSamples::F32(samples(2).map(|v| v as f32 / 3.0).collect())),
        ("depth.Z", FlatSamples::F32(samples(3).map(|v| v as f32 * 1e-3).collect())),
        ("id", FlatSamples::U32(samples(4).map(|v| v as u32 * 60_000).collect())),
    ];
    let list = channels.into_iter().map(|(n, s)| AnyChannel::new(n, s)).collect();
    let attributes = LayerAttributes::named(name).with_position(position);
    Layer::new(SIZE, attributes, encoding, AnyChannels::sort(list))
}

fn write(path: &Path, layers: Layers<AnyChannels<FlatSamples>>) {
    // The display window lies inside data that begin at (5, −9). It begins one column and one row
    // before data that begin at (9, 3).
    let display = IntegerBounds::new(Vec2(8, 2), Vec2(30, 70));
    Image::from_layers(ImageAttributes::new(display), layers).write().to_file(path).unwrap();
}

/// Reads a file `step` rows at a time, from the bottom, and compares the rows with the whole film.
fn assert_same_rows(path: &Path, step: u32) {
    let whole = read_exr(path).unwrap();
    let file = ExrFile::open(path).unwrap();
    assert_eq!((file.size(), file.window()), (whole.size(), whole.window()));
    assert_eq!(file.metadata(), whole.metadata());
    let words: Vec<_> =
        file.planes().iter().map(|p| (&*p.name, &*p.channels, &*p.unit, &*p.doc, p.kind)).collect();
    let expected = whole.planes().iter().map(|p| (p.name(), p.channels(), p.unit(), p.doc(), p.kind()));
    assert_eq!(words, expected.collect::<Vec<_>>());
    let window = whole.window();
    let starts: Vec<u32> = (window.y..window.y + window.height).step_by(step as usize).collect();
    for &start in starts.iter().rev() {
        let end = (start + step).min(window.y + window.height);
        let part = file.read_rows(start..end).unwrap();
        assert_eq!(part.window(), Window { y: start, height: end - start, ..window });
        assert_eq!(part.metadata(), whole.metadata());
        for (part, whole) in part.planes().iter().zip(whole.planes()) {
            let count = whole.channels().len();
            let range = window.index(window.x, start) * count
                ..(window.index(window.x, end - 1) + window.width as usize) * count;
            let is_same = match (part.samples(), whole.samples()) {
                (Samples::F32(a), Samples::F32(b)) => {
                    Samples::F32(a.clone()) == Samples::F32(b[range].to_vec())
                }
                (Samples::U32(a), Samples::U32(b)) => *a == b[range],
                _ => false,
            };
            assert!(is_same, "{}: plane {:?}, rows {start}..{end}", path.display(), whole.name());
        }
    }
}

#[test]
fn our_own_films_come_in_rows_bit_by_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.exr");
    write_exr(&path, &film()).unwrap();
    for step in [1, 7, 16, 37] {
        assert_same_rows(&path, step);
    }
    assert_eq!(ExrFile::open(&path).unwrap().rows_per_block(), 16);
    assert_eq!(ExrFile::open(&path).unwrap().read_rows(3..40).unwrap(), film());
}

#[test]
fn our_own_films_come_in_rows_from_every_layout() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.exr");
    // Wider and higher than a tile.
    let mut wide = film().blank([200, 300], Window { x: 7, y: 9, width: 150, height: 140 }).unwrap();
    for (i, (x, y)) in wide.window().pixels().enumerate() {
        wide.plane_mut("cost").unwrap().set_u32(x, y, &[i as u32, x * y]);
        wide.plane_mut("").unwrap().set_f32(x, y, &[x as f32, y as f32 / 3.0, -0.0]);
    }
    for layout in layouts() {
        for film in [&film(), &wide] {
            write_exr_as(&path, film, &layout).unwrap();
            for step in [1, 70] {
                assert_same_rows(&path, step);
            }
            assert_eq!(read_exr(&path).unwrap(), *film, "{layout}");
        }
    }
}

#[test]
fn a_block_that_says_it_is_another_one_is_damage_by_both_readers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.exr");
    write_exr(&path, &film()).unwrap();
    let file = ExrFile::open(&path).unwrap();
    let second = file.blocks[0].offset(0, 1) as usize;
    let first_row = file.blocks[0].first_row(&file.meta, 0);
    let mut bytes = fs::read(&path).unwrap();
    bytes[second..second + 4].copy_from_slice(&first_row.to_le_bytes());
    fs::write(&path, &bytes).unwrap();
    let whole = read_exr(&path).unwrap_err().to_string();
    let rows = ExrFile::open(&path).unwrap().read_rows(3..40).unwrap_err().to_string();
    assert!(whole == rows && whole.contains(&format!("block 0,1 at byte {second}: the place [")), "{whole}");
}

#[test]
fn other_programs_files_come_in_rows_by_any_compression_in_lines_and_tiles_in_either_order() {
    let folder = tempfile::tempdir().unwrap();
    let kinds = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::B44A,
    ];
    for compression in kinds {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 12))] {
            for line_order in [LineOrder::Increasing, LineOrder::Decreasing] {
                let path = folder.path().join(format!("{compression}-{blocks:?}-{line_order:?}.exr"));
                let encoding = Encoding { compression, blocks, line_order };
                write(&path, vec![layer("only", 1, Vec2(5, -9), encoding)].into());
                assert_same_rows(&path, 9);
            }
        }
    }
}

#[test]
fn of_several_layers_the_first_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("parts.exr");
    for encoding in [Encoding::FAST_LOSSLESS, Encoding::SMALL_LOSSLESS] {
        let layers =
            [("first", 1), ("second", 2)].map(|(name, seed)| layer(name, seed, Vec2(9, 3), encoding));
        write(&path, Vec::from(layers).into());
        assert_same_rows(&path, 20);
    }
}

#[test]
fn rows_outside_the_window_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.exr");
    write_exr(&path, &film()).unwrap();
    let file = ExrFile::open(&path).unwrap();
    for rows in [2..5, 39..41, 7..7, 0..u32::MAX] {
        let said = file.read_rows(rows).unwrap_err().to_string();
        assert!(said.starts_with("rows = ") && said.ends_with("expected rows inside 3..40"), "{said}");
    }
}

#[test]
fn damaged_files_give_errors_that_name_the_file_and_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.exr");
    let tiles = Encoding {
        compression: Compression::ZIP1,
        blocks: Blocks::Tiles(Vec2(32, 32)),
        line_order: LineOrder::Increasing,
    };
    write(&path, vec![layer("only", 1, Vec2(5, -9), tiles)].into());
    let tiled = fs::read(&path).unwrap();
    write_exr(&path, &film()).unwrap();
    let lines = fs::read(&path).unwrap();
    write_exr_as(&path, &film(), &"parts".parse().unwrap()).unwrap();
    let parts = fs::read(&path).unwrap();
    let all = |path: &Path| {
        let file = ExrFile::open(path)?;
        file.read_rows(file.window().y..file.window().y + file.window().height)
    };
    for good in [lines, tiled, parts] {
        let stride = 1 + good.len() / 300;
        for length in (0..good.len()).step_by(stride) {
            fs::write(&path, &good[..length]).unwrap();
            let said = all(&path).unwrap_err().to_string();
            assert!(said.contains("damaged.exr"), "{length} bytes: {said}");
        }
        for i in (0..good.len()).step_by(stride).chain(0..600) {
            let mut bad = good.clone();
            bad[i] ^= 0x15;
            fs::write(&path, &bad).unwrap();
            // Both readers may miss a wrong sample. If both accept the file, they must find the
            // same window.
            if let (Ok(rows), Ok(whole)) = (all(&path), read_exr(&path)) {
                assert_eq!(rows.window(), whole.window());
            }
        }
    }
}

#[test]
fn a_block_at_another_ones_place_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.exr");
    write_exr(&path, &film()).unwrap();
    let mut bytes = fs::read(&path).unwrap();
    let file = ExrFile::open(&path).unwrap();
    let second = file.blocks[0].offsets[1].to_le_bytes();
    let at = bytes.windows(8).position(|w| w == second).unwrap();
    bytes.copy_within(at - 8..at, at);
    fs::write(&path, &bytes).unwrap();
    let file = ExrFile::open(&path).unwrap();
    assert!(file.read_rows(3..19).is_ok(), "rows of other blocks");
    let said = file.read_rows(18..20).unwrap_err().to_string();
    assert!(
        said.contains("film.exr: block 0,1 at byte") && said.contains("the place [3]; expected [19]"),
        "{said}"
    );
}

#[test]
fn a_file_that_becomes_shorter_while_open_gives_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.exr");
    write_exr(&path, &film()).unwrap();
    let file = ExrFile::open(&path).unwrap();
    let open = fs::OpenOptions::new().write(true).open(&path).unwrap();
    open.set_len(file.blocks[0].offsets[2]).unwrap();
    assert!(file.read_rows(3..35).is_ok());
    let said = file.read_rows(3..36).unwrap_err().to_string();
    assert!(said.contains("truncated"), "{said}");
}
