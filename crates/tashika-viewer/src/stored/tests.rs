//! Tiles and pixels of films in files and of films being rendered, against the film itself.

use std::path::PathBuf;

use tashika::film::{Film, PlaneSpec, SampleKind, Samples};
use tashika::io::write_exr;
use tashika::report::least_certain;

use super::*;
use crate::live::LiveFilm;
use crate::shown::Headline;

const fn spec(name: &'static str, channels: &'static [&'static str], kind: SampleKind) -> PlaneSpec {
    PlaneSpec { name, channels, unit: "1", kind, doc: "" }
}
const SPECS: &[PlaneSpec] = &[
    spec("", &["R", "G", "B"], SampleKind::F32),
    spec("half_width", &["Y"], SampleKind::F32),
    spec("claim", &["id"], SampleKind::U32),
    spec("stop", &["id"], SampleKind::U32),
];

/// A film whose pixels all differ in certainty, so that the least certain one does not depend on
/// the order of choosing.
pub(crate) fn film(window: Window) -> Film {
    let size = [window.x + window.width + 4, window.y + window.height + 2];
    let mut film = Film::new(size, window, SPECS).unwrap();
    film.metadata_mut().set("seed", 7_u32);
    for (i, (x, y)) in window.pixels().enumerate() {
        let mixed = (i as u32).wrapping_mul(2_654_435_761) >> 8;
        film.plane_mut("").unwrap().set_f32(x, y, &[1.0; 3]);
        film.plane_mut("half_width").unwrap().set_f32(x, y, &[mixed as f32 / 65_536.0 + 1e-3]);
        film.plane_mut("claim").unwrap().set_u32(x, y, &[3]);
        film.plane_mut("stop").unwrap().set_u32(x, y, &[i as u32 + 1]);
    }
    film
}

/// Writes the film to a file in a folder, which exists as long as its handle.
pub(crate) fn written(film: &Film) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.exr");
    write_exr(&path, film).unwrap();
    (folder, path)
}

fn expected(film: &Film, description: &Description, at: TileAddress, planes: &[&str]) -> Vec<u8> {
    planes.iter().flat_map(|plane| expected_plane(film, description, at, plane)).collect()
}

fn expected_plane(film: &Film, description: &Description, at: TileAddress, plane: &str) -> Vec<u8> {
    let chosen = least_certain(film, description.part(at).unwrap(), 1 << at.level);
    let plane = film.plane(plane).unwrap();
    let mut bytes = Vec::new();
    for channel in 0..plane.channels().len() {
        for &[x, y] in &chosen {
            bytes.extend(match plane.samples() {
                Samples::F32(_) => plane.f32_at(x, y)[channel].to_le_bytes(),
                Samples::U32(_) => plane.u32_at(x, y)[channel].to_le_bytes(),
            });
        }
    }
    bytes
}

fn assert_shows(shown: &dyn Shown, film: &Film) {
    let window = film.window();
    let description = shown.description().unwrap();
    assert_eq!((description.size, description.planes.len()), (film.size(), 4));
    assert_eq!(description.metadata["seed"], 7);
    for level in 0..description.levels {
        let side = 256 << level;
        let tiles =
            Window { x: 0, y: 0, width: window.width.div_ceil(side), height: window.height.div_ceil(side) };
        for (x, y) in tiles.pixels() {
            let at = TileAddress { level, x, y };
            for planes in [&[""][..], &["half_width"], &["stop", ""]] {
                let tile = shown.tile(at, planes).unwrap();
                assert!(tile.bytes == expected(film, &description, at, planes), "{at:?} of {planes:?}");
                assert!(tile.version <= shown.version());
            }
        }
    }
    for (x, y) in [(window.x, window.y), (window.x + window.width - 1, window.y + window.height - 1)] {
        let values = shown.pixel(x, y).unwrap();
        for (found, plane) in values.iter().zip(film.planes()) {
            let expected = match plane.samples() {
                Samples::F32(_) => Samples::F32(plane.f32_at(x, y).to_vec()),
                Samples::U32(_) => Samples::U32(plane.u32_at(x, y).to_vec()),
            };
            assert_eq!((found.plane.as_str(), &found.values), (plane.name(), &expected));
        }
    }
    assert_eq!(shown.tile(TileAddress { level: 0, x: 0, y: 0 }, &["", "absent"]), Err(Refusal::NoPlane));
    let beyond = shown.tile(TileAddress { level: u32::MAX, x: u32::MAX, y: u32::MAX }, &[""]);
    assert!(matches!(beyond, Err(Refusal::Outside(_))));
    assert!(matches!(shown.pixel(window.x, window.y + window.height), Err(Refusal::Outside(_))));
}

/// A window whose sides are not multiples of the sides of tiles and blocks.
const WINDOW: Window = Window { x: 3, y: 5, width: 601, height: 333 };

#[test]
fn files_show_what_the_film_holds_at_every_level_from_any_overview_with_any_cache() {
    let film = film(WINDOW);
    let (_folder, path) = written(&film);
    for (factor, kept) in [(1, KEPT_BYTES), (2, 1), (4, KEPT_BYTES), (32, 1)] {
        let stored = StoredFilm::new(Rows::open(&path, None).unwrap(), factor, kept).unwrap();
        let before = stored.version();
        build(&Arc::downgrade(&stored.inner));
        assert_shows(&stored, &film);
        let Status { live, finished, ready, failure, .. } = stored.status();
        assert_eq!((live, finished, ready, failure), (false, true, 1.0, None));
        assert_eq!(stored.version(), before + u64::from(stored.inner.strips.count()));
    }
}

#[test]
fn a_film_too_large_to_be_looked_at_whole_has_an_overview_that_fills_up() {
    let film = film(Window { x: 1, y: 2, width: 1601, height: 1401 });
    let (_folder, path) = written(&film);
    let stored = StoredFilm::open(&path, None).unwrap();
    assert_eq!(stored.inner.read().overview.factor(), 2);
    while !stored.status().finished {
        thread::yield_now();
    }
    assert_shows(&stored, &film);
}

#[test]
fn what_was_not_read_yet_looks_like_what_is_above_and_what_cannot_be_read_is_told() {
    let film = film(WINDOW);
    let (_folder, path) = written(&film);
    let stored = StoredFilm::new(Rows::open(&path, None).unwrap(), 4, 1).unwrap();
    let top = TileAddress { level: 2, x: 0, y: 0 };
    assert!(stored.tile(top, &["stop"]).unwrap().bytes.iter().all(|&b| b == 0));
    stored.inner.see(1);
    let row = |row: usize| stored.tile(top, &["stop"]).unwrap().bytes[row * 151 * 4..][..151 * 4].to_vec();
    let is_there = |number: usize| row(number).iter().any(|&b| b != 0);
    assert_eq!([3, 4, 7, 83].map(is_there), [false, true, true, true], "from row 16 on");
    assert!(row(8) == row(7) && row(83) == row(7) && row(6) != row(7));
    stored.inner.see(3);
    assert!(row(11) == row(7) && row(12) != row(7) && row(16) == row(15), "as far as nothing else is known");
    std::fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(4000).unwrap();
    build(&Arc::downgrade(&stored.inner));
    let failure = stored.status().failure.unwrap();
    assert!(failure.contains("film.exr"), "{failure}");
    let finest = TileAddress { level: 0, x: 0, y: 1 };
    assert!(
        matches!(stored.tile(finest, &[""]), Err(Refusal::Unreadable(said)) if said.contains("film.exr"))
    );
}

#[test]
fn the_order_of_strips_has_each_once_and_its_beginning_is_spread() {
    for count in [1, 2, 3, 7, 8, 100] {
        let mut order: Vec<u32> = bit_reversed(count).collect();
        let begin: Vec<u32> = order.iter().copied().take(3).collect();
        order.sort_unstable();
        assert_eq!(order, (0..count).collect::<Vec<_>>());
        if count == 8 {
            assert_eq!(begin, [0, 4, 2]);
        }
    }
}

#[test]
fn a_film_being_rendered_shows_what_was_told_of_it() {
    for window in [WINDOW, Window { x: 1, y: 2, width: 1601, height: 1401 }] {
        let whole = film(window);
        let live = LiveFilm::new();
        assert_eq!((live.description(), live.version()), (None, 0));
        assert_eq!(live.tile(TileAddress { level: 0, x: 0, y: 0 }, &[""]), Err(Refusal::NotYet));
        assert_eq!(live.pixel(window.x, window.y), Err(Refusal::NotYet));

        let mut shown = whole.blank(whole.size(), window).unwrap();
        let tile = Window { x: window.x + 37, y: window.y + 300, width: 16, height: 16 };
        for y in tile.y..tile.y + 16 {
            shown.copy_pixels([tile.x, y], &whole, [tile.x, y], 16);
        }
        live.update(&whole, tile);
        assert_eq!(live.version(), 1);
        let seen = live.tile(TileAddress { level: 0, x: 0, y: 1 }, &["half_width"]).unwrap();
        let description = live.description().unwrap();
        assert!(
            seen.bytes
                == expected(&shown, &description, TileAddress { level: 0, x: 0, y: 1 }, &["half_width"])
        );
        let top = TileAddress { level: description.levels - 1, x: 0, y: 0 };
        assert!(live.tile(top, &["stop"]).unwrap().bytes == expected(&shown, &description, top, &["stop"]));

        let headline =
            Headline { text: "a quarter".to_owned(), pixels: 1, of: 4, claiming: 1, promise_met: 1 };
        live.progress(headline.clone());
        let Status { live: is_live, finished, ready, headline: told, .. } = live.status();
        assert_eq!((is_live, finished, ready, told), (true, false, 0.25, Some(headline)));

        for y in (window.y..window.y + window.height).step_by(16) {
            for x in (window.x..window.x + window.width).step_by(16) {
                let tile = Window {
                    x,
                    y,
                    width: 16.min(window.x + window.width - x),
                    height: 16.min(window.y + window.height - y),
                };
                live.update(&whole, tile);
            }
        }
        assert_shows(&live, &whole);
        let before = live.version();
        live.finish(whole.clone());
        assert!(live.version() > before && live.status().finished);
        assert_shows(&live, &whole);
    }
}
