//! Measures of pictures given by formulas, against independent programs.

use std::path::Path;

use super::*;
use crate::compare::Named;
use crate::film::{Film, PlaneSpec, SampleKind};

const WIDTH: usize = 56;
const HEIGHT: usize = 44;
/// Pixels at which values of maps are compared.
const PLACES: [(usize, usize); 4] = [(20, 17), (31, 30), (0, 25), (55, 43)];
/// Output of `scripts/picture_measures.py`: lines of a change, a measure, numbers.
const INDEPENDENT: &str = include_str!("independent.txt");

/// Picture `reference` of the script.
fn reference(x: usize, y: usize) -> [f64; 3] {
    let board = ((x / 9 + y / 7) % 2) as f64;
    let stripe = if (x + y) % 16 < 6 { 14 } else { 0 };
    [
        (x + stripe) as f64 / 70.0,
        ((3 * x + 5 * y) % 31) as f64 / 40.0 + board / 8.0,
        (1.0 + 3.0 * board) / 5.0,
    ]
}

/// Picture `changed` of the script.
fn changed(change: &str, x: usize, y: usize) -> [f64; 3] {
    let color = reference(x, y);
    match change {
        "noise" => [0, 1, 2].map(|c| {
            let noise = ((7 * x + 13 * y + 5 * c + x * y) % 11) as f64 - 5.0;
            (color[c] + noise / 40.0).max(0.0)
        }),
        "shift" => reference(x + 2, y + 1),
        "dark" => color.map(|v| 0.8 * v),
        "hue" if x > y => [color[2], color[0], color[1]],
        "fireflies" if (x * x + 3 * y).is_multiple_of(97) => [1.0; 3],
        _ => color,
    }
}

fn picture(of: impl Fn(usize, usize) -> [f64; 3]) -> Vec<Rgb> {
    let shown = |color: [f64; 3]| Rgb::from(color.map(|v| v.clamp(0.0, 1.0) as f32));
    (0..WIDTH * HEIGHT).map(|i| shown(of(i % WIDTH, i / WIDTH))).collect()
}

fn pictures(change: &str) -> Pictures {
    Pictures {
        width: WIDTH,
        colors: [picture(|x, y| changed(change, x, y)), picture(reference)],
        is_there: vec![true; WIDTH * HEIGHT],
    }
}

/// Rows of a measure: the change, and its numbers.
fn rows(measure: &str) -> Vec<(&'static str, Vec<f64>)> {
    let rows = INDEPENDENT.lines().map(|line| line.split(' ').collect::<Vec<_>>());
    let rows = rows.filter(|words| words[1] == measure);
    let rows: Vec<_> =
        rows.map(|words| (words[0], words[2..].iter().map(|w| w.parse().unwrap()).collect())).collect();
    assert_eq!(rows.len(), 5, "{measure}");
    rows
}

#[track_caller]
fn near(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found}, not {expected}");
}

/// Colours in single precision have relative errors of 6e-8. Where the curve is steep, codes have
/// at most ten times that. Relative to the squares of errors of a tenth this is 5e-6; in decibels
/// it is 4.3 times as much.
#[test]
fn psnr_is_that_of_scikit_image() {
    for (change, expected) in rows("psnr") {
        near(pictures(change).psnr(), expected[0], 2e-5, change);
    }
}

/// The tolerance is derived as for PSNR. In a window without contrast, an error of 1e-9 in the
/// squares is 1e-6 of `C₂`.
#[test]
fn ssim_is_that_of_scikit_image() {
    for (change, expected) in rows("ssim") {
        let pictures = pictures(change);
        near(ssim::mean(&pictures).unwrap(), expected[0], 1e-6, change);
        let map = ssim::map(&pictures);
        for (&(x, y), expected) in PLACES.iter().zip(&expected[1..]) {
            near(map.values[y * WIDTH + x], *expected, 1e-6, change);
        }
    }
}

/// The authors round their matrix from RGB to XYZ. It differs by up to 3e-5 from the matrix by the
/// chromaticities, which is used here. The steepest later step, the power 0.7 and the piecewise
/// linear map after it, at most doubles this difference.
#[test]
fn flip_is_that_of_its_authors() {
    for density in [67.0, 30.0] {
        for (change, expected) in rows(&format!("flip{density}")) {
            let pictures = pictures(change);
            let map = flip::map(&pictures, density);
            near(pictures.mean(&map), expected[0], 2e-5, change);
            for (&(x, y), expected) in PLACES.iter().zip(&expected[1..]) {
                near(map[y * WIDTH + x], *expected, 6e-5, &format!("{change} {density} {x},{y}"));
            }
            assert!(map.iter().all(|v| (0.0..=1.0).contains(v)), "{change}");
        }
    }
}

const COLOR: PlaneSpec =
    PlaneSpec { name: "", channels: &["R", "G", "B"], unit: "1", kind: SampleKind::F32, doc: "" };
const STOP: PlaneSpec =
    PlaneSpec { name: "stop", channels: &["id"], unit: "1", kind: SampleKind::U32, doc: "" };

/// A film of which every pixel is rendered.
fn film(of: impl Fn(usize, usize) -> [f64; 3]) -> Film {
    let size = [WIDTH as u32, HEIGHT as u32];
    let mut film = Film::new(size, Window::full(size), &[COLOR, STOP]).unwrap();
    for (x, y) in film.window().pixels() {
        let color = of(x as usize, y as usize).map(|v| v as f32);
        film.plane_mut("").unwrap().set_f32(x, y, &color);
        film.plane_mut("stop").unwrap().set_u32(x, y, &[2]);
    }
    film
}

fn measured(image: &Film, reference: &Film) -> Option<Measures> {
    let named = |film| Named { name: Path::new("a.exr"), film };
    Measures::of(image.window(), Pairs::of(named(image), named(reference)).unwrap())
}

#[test]
fn errors_of_linear_colours_are_those_of_their_formulas() {
    // Two of the three channels have errors, of 3 and 4: their squares are 9 and 16.
    let image = film(|_, _| [5.0, 4.0, 1.0]);
    let found = measured(&image, &film(|_, _| [2.0, 0.0, 1.0])).unwrap();
    near(found.rmse, (25.0_f64 / 3.0).sqrt(), 1e-12, "rmse");
    near(found.relmse, (9.0 / 4.01 + 16.0 / 0.01) / 3.0, 1e-9, "relmse");
}

#[test]
fn equal_pictures_are_equal_by_all_measures() {
    let image = film(reference);
    let found = measured(&image, &image).unwrap();
    assert_eq!((found.rmse, found.relmse, found.psnr, found.flip), (0.0, 0.0, f64::INFINITY, 0.0));
    near(found.ssim.unwrap(), 1.0, 1e-12, "ssim");
}

#[test]
fn both_are_shown_as_bright_as_the_reference_asks() {
    let [dark, dim] = [1.0, 64.0].map(|scale| {
        let times = |color: [f64; 3]| color.map(|v| v * scale);
        let reference = film(|x, y| times(reference(x, y)));
        measured(&film(|x, y| times(changed("noise", x, y))), &reference).unwrap()
    });
    // A power of two: exposed bits are equal except for the rounding of the stops.
    near(dark.exposure_stops - dim.exposure_stops, 6.0, 1e-5, "stops");
    for (of, a, b) in
        [("psnr", dark.psnr, dim.psnr), ("flip", dark.flip, dim.flip), ("rmse", 64.0 * dark.rmse, dim.rmse)]
    {
        near(b / a, 1.0, 1e-4, of);
    }
    let twice = measured(&film(|x, y| reference(x, y).map(|v| 2.0 * v)), &film(reference)).unwrap();
    assert!(twice.flip > 0.1 && twice.exposure_stops == dark.exposure_stops, "{twice:?}");
}

#[test]
fn what_is_left_out_enters_no_measure() {
    let is_hole = |x: usize, y: usize| (x * 5 + y * 3).is_multiple_of(29) || x < 4;
    let truth = film(reference);
    let holes = |color: [f64; 3], stop: u32| {
        let mut image = film(|x, y| if is_hole(x, y) { color } else { changed("noise", x, y) });
        for (x, y) in image.window().pixels().filter(|&(x, y)| is_hole(x as usize, y as usize)) {
            image.plane_mut("stop").unwrap().set_u32(x, y, &[stop]);
        }
        measured(&image, &truth).unwrap()
    };
    // Failed; not rendered, with any content.
    let failed = holes([f64::INFINITY; 3], 2);
    let [black, bright] = [0.0, 1000.0].map(|v| holes([v; 3], 0));
    assert_eq!(black, bright);
    let squares = |m: &Measures| (m.rmse, m.relmse);
    assert_eq!(squares(&failed), squares(&black));
    near(failed.psnr, black.psnr, 0.2, "the exposure is by other pixels");
    assert!(holes([1000.0; 3], 2).flip > failed.flip + 0.05, "rendered, it would count");
    // The rest is unchanged: holes at every 29th pixel hardly change the visible noise.
    let whole = measured(&film(|x, y| changed("noise", x, y)), &truth).unwrap();
    near(failed.ssim.unwrap(), whole.ssim.unwrap(), 0.02, "ssim");
    near(failed.flip, whole.flip, 0.02, "flip");
    assert!(measured(&film(|_, _| [f64::INFINITY; 3]), &truth).is_none());
}

/// Image and reference are constant grays; every second column of the image is then infinite, and
/// every third row is not rendered. The mean over any set of the remaining pixels is equal, so that
/// a measure differs if and only if omitted pixels enter it.
#[test]
fn means_are_of_what_is_there_alone() {
    let [dark, light] = [0.1, 0.2];
    let truth = film(|_, _| [light; 3]);
    let whole = measured(&film(|_, _| [dark; 3]), &truth).unwrap();
    let mut half = film(|x, _| [if x % 2 == 0 { dark } else { f64::INFINITY }; 3]);
    for (x, y) in half.window().pixels().filter(|(_, y)| y % 3 == 0) {
        half.plane_mut("stop").unwrap().set_u32(x, y, &[0]);
    }
    let half = measured(&half, &truth).unwrap();
    for (of, whole, half) in [
        ("rmse", whole.rmse, half.rmse),
        ("relmse", whole.relmse, half.relmse),
        ("psnr", whole.psnr, half.psnr),
        ("ssim", whole.ssim.unwrap(), half.ssim.unwrap()),
    ] {
        near(half, whole, 1e-9, of);
    }
    assert!(whole.ssim.unwrap() < 0.99, "{whole:?}");
    // FLIP blurs each pixel with its neighbours, so omitted pixels, which are equal in both
    // pictures, lower it. It is therefore tested on a strip that fills half of the picture. A mean
    // over all pixels would give half the value.
    let strip = film(|x, _| [if x < WIDTH / 2 { dark } else { f64::INFINITY }; 3]);
    let strip = measured(&strip, &truth).unwrap();
    near(strip.ssim.unwrap(), whole.ssim.unwrap(), 1e-9, "no window without a pixel");
    assert!(strip.flip > 0.8 * whole.flip && strip.flip < 1.05 * whole.flip, "{strip:?} {whole:?}");
}

#[test]
fn pictures_of_few_pixels_have_no_window_for_ssim() {
    let row = |width: u32, height: u32| {
        let mut film = Film::new([width, height], Window::full([width, height]), &[COLOR]).unwrap();
        for (x, y) in film.window().pixels() {
            film.plane_mut("").unwrap().set_f32(x, y, &[0.1 + x as f32; 3]);
        }
        measured(&film, &film).unwrap()
    };
    assert_eq!([row(1, 1), row(10, 200), row(200, 10)].map(|m| m.ssim), [None; 3]);
    near(row(11, 11).ssim.unwrap(), 1.0, 1e-12, "one window");
}
