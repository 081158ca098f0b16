//! Comparisons of films with known errors, and their presentation.

use std::path::Path;

use super::error_image::{error_image, half_width_image};
use super::*;
use crate::film::{Film, PictureClaim, PlaneSpec, SampleKind, Window};

const fn spec(name: &'static str, channels: &'static [&'static str], kind: SampleKind) -> PlaneSpec {
    PlaneSpec { name, channels, unit: "1", kind, doc: "" }
}

const COLOR: PlaneSpec = spec("", &["R", "G", "B"], SampleKind::F32);
const STOP: PlaneSpec = spec("stop", &["id"], SampleKind::U32);
const HALF_WIDTH: PlaneSpec = spec("half_width", &["Y"], SampleKind::F32);
const CLAIM: PlaneSpec = spec("claim", &["id"], SampleKind::U32);

/// First pixel of the films below, in their image.
const CORNER: [u32; 2] = [3, 7];

/// A film of grays, `width` in a row, inside a larger image.
fn film_in_rows(width: u32, grays: &[f32], specs: &[PlaneSpec]) -> Film {
    let window = Window { x: CORNER[0], y: CORNER[1], width, height: grays.len() as u32 / width };
    let mut film = Film::new([40_000, 100], window, specs).unwrap();
    for ((x, y), gray) in window.pixels().zip(grays) {
        film.plane_mut("").unwrap().set_f32(x, y, &[*gray; 3]);
    }
    film
}

fn film(grays: &[f32]) -> Film {
    film_in_rows(grays.len() as u32, grays, &[COLOR])
}

fn named<'a>(name: &'a str, film: &'a Film) -> Named<'a> {
    Named { name: Path::new(name), film }
}

fn compared(image: &Film, reference: &Film, relative: f64, absolute: f64) -> Comparison {
    let tolerance = Tolerance { relative, absolute };
    compare(named("a.exr", image), named("ref.exr", reference), &tolerance).unwrap()
}

/// Asserts that relative errors are equal up to the rounding of stored luminances to single
/// precision.
#[track_caller]
fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= f64::from(f32::EPSILON), "{found}, not {expected}");
}

/// An image and its reference, with relative errors of 0.001 to 0.1 in a shuffled order,
/// alternately too bright and too dark.
fn known_errors() -> (Film, Film) {
    let error = |i: u32| (i * 37 % 100 + 1) as f32 / 1000.0;
    let image: Vec<f32> = (0..100).map(|i| 2.0 + if i % 2 == 0 { 2.0 } else { -2.0 } * error(i)).collect();
    (film(&image), film(&[2.0; 100]))
}

#[test]
fn known_errors_give_known_numbers() {
    let (image, reference) = known_errors();
    let c = compared(&image, &reference, 0.0205, 0.0);
    assert_eq!((c.pixels, c.within, c.infinite, c.left_out()), (100, 20, 0, 0));
    near(c.within_share(), 0.2);
    near(c.mean, 0.0505);
    near(c.median, 0.05);
    near(c.p95, 0.095);
    near(c.worst, 0.1);
    // 37 · 27 = 999: pixel 27 is the worst.
    assert_eq!(c.worst_at, [CORNER[0] + 27, CORNER[1]]);
    near(c.errors[0], 0.001);
    near(c.relative_l1, 0.0505);
    // Even pixels are too bright by odd numbers of thousandths. Odd pixels are too dark by even
    // numbers, which are larger by one on average.
    near(c.bias, -0.0005);
}

#[test]
fn the_95th_percentile_is_within_exactly_if_95_percent_are() {
    let (image, reference) = known_errors();
    for (tolerance, kept) in [(0.0955, true), (0.0945, false)] {
        let c = compared(&image, &reference, tolerance, 0.0);
        assert_eq!((c.within_share() >= 0.95, c.p95 <= tolerance), (kept, kept));
    }
    // With one pixel, each quantile is its error. With two, the smaller error is the median.
    let c = compared(&film(&[1.5]), &film(&[1.0]), 0.5, 0.0);
    assert_eq!([c.median, c.p95, c.worst].map(|e| (1e6 * e).round()), [5e5; 3]);
    let c = compared(&film(&[1.5, 1.25]), &film(&[1.0, 1.0]), 0.5, 0.0);
    near(c.median, 0.25);
    near(c.p95, 0.5);
}

#[test]
fn errors_are_of_luminance() {
    let mut image = film(&[1.0]);
    image.plane_mut("").unwrap().set_f32(CORNER[0], CORNER[1], &[1.0, 1.5, 1.0]);
    near(compared(&image, &film(&[1.0]), 0.02, 0.0).mean, 0.7152 * 0.5);
    // A single channel is gray.
    let mut gray = Film::new([40_000, 100], image.window(), &[spec("", &["Y"], SampleKind::F32)]).unwrap();
    gray.plane_mut("").unwrap().set_f32(CORNER[0], CORNER[1], &[1.25]);
    near(compared(&gray, &film(&[1.0]), 0.02, 0.0).mean, 0.25);
}

#[test]
fn black_references_allow_black_only() {
    let (image, reference) = (film(&[0.0, 1e-6, 1.0, -1.0]), film(&[0.0, 0.0, 1.0, -1.0]));
    let c = compared(&image, &reference, 0.02, 0.0);
    assert_eq!((c.within, c.infinite, c.worst, c.mean), (3, 1, f64::INFINITY, 0.0));
    assert_eq!((c.median, c.p95, c.worst_at), (0.0, f64::INFINITY, [CORNER[0] + 1, CORNER[1]]));
    assert_eq!(compared(&film(&[0.1]), &film(&[0.0]), 0.02, 0.0).mean, f64::INFINITY, "no error is finite");
    let c = compared(&film(&[0.0; 4]), &film(&[0.0; 4]), 0.02, 0.0);
    assert_eq!((c.within, c.bias, c.relative_l1), (4, 0.0, 0.0));
}

#[test]
fn dark_pixels_are_judged_by_the_absolute_tolerance() {
    // References of 10, 0.5, 0.1 and 0, each with an error of 0.015; the tolerance is 0.02
    // relative, or 0.02 absolute.
    let (image, reference) = (film(&[10.015, 0.515, 0.085, 0.015]), film(&[10.0, 0.5, 0.1, 0.0]));
    assert_eq!(compared(&image, &reference, 0.02, 0.0).within, 1);
    let c = compared(&image, &reference, 0.02, 0.02);
    assert_eq!((c.within, c.infinite), (4, 0));
    near(c.errors[0], 0.0015);
    // Errors of dark pixels are relative to the absolute tolerance over the relative one,
    // 0.02/0.02 = 1.
    c.errors[1..].iter().for_each(|e| near(*e, 0.015));
    assert_eq!(compared(&image, &reference, 0.02, 0.014).within, 1);
}

#[test]
fn what_has_no_error_is_counted_and_left_out() {
    let specs = [COLOR, STOP];
    let mut image = film_in_rows(3, &[1.0, 9.0, 1.0, 1.0, 1.1, 1.0], &specs);
    let mut reference = film_in_rows(3, &[1.0, 1.0, 1.0, f32::INFINITY, 1.0, 1.0], &specs);
    for (i, (x, y)) in image.window().pixels().enumerate() {
        image.plane_mut("stop").unwrap().set_u32(x, y, &[u32::from(i != 1)]);
        reference.plane_mut("stop").unwrap().set_u32(x, y, &[if i == 2 { 0 } else { 2 }]);
    }
    let c = compared(&image, &reference, 0.02, 0.0);
    assert_eq!((c.pixels, c.not_rendered, c.not_finite, c.within), (3, 2, 1, 2));
    let has_error: Vec<bool> = c.errors.iter().map(|e| !e.is_nan()).collect();
    assert_eq!(has_error, [true, false, false, false, true, true]);
    assert_eq!(c.worst_at, [CORNER[0] + 1, CORNER[1] + 1]);
    near(c.mean, 0.1 / 3.0);
    near(c.bias, 0.1 / 3.0);
    let said = compare(
        named("a.exr", &film(&[1.0])),
        named("ref.exr", &film(&[f32::INFINITY])),
        &Tolerance::default(),
    );
    let said = said.unwrap_err().to_string();
    assert!(
        said.contains("a.exr: no pixel") && said.contains("ref.exr") && said.contains("1 not finite"),
        "{said}"
    );
}

#[test]
fn a_pixel_that_is_not_finite_has_failed_and_keeps_no_claim() {
    let specs = [COLOR, HALF_WIDTH, CLAIM];
    let mut image = film_in_rows(5, &[1.0, 1.5, f32::INFINITY, 1.0, f32::INFINITY], &specs);
    for (x, y) in image.window().pixels() {
        // Even an infinite half-width does not cover a pixel that is not finite.
        image.plane_mut("half_width").unwrap().set_f32(x, y, &[f32::INFINITY]);
        image.plane_mut("claim").unwrap().set_u32(x, y, &[1]);
    }
    let mut reference = film_in_rows(5, &[1.0, 1.0, 1.0, 0.0, f32::INFINITY], &specs);
    for (x, y) in reference.window().pixels() {
        reference.plane_mut("claim").unwrap().set_u32(x, y, &[1]);
    }
    let c = compared(&image, &reference, 1.0, 0.0);
    assert_eq!((c.pixels, c.within, c.failed, c.infinite, c.not_finite), (4, 2, 1, 1, 1));
    assert_eq!(
        (c.errors[2], c.worst, c.worst_at),
        (f64::INFINITY, f64::INFINITY, [CORNER[0] + 2, CORNER[1]])
    );
    assert_eq!((c.mean, c.p95), (0.25, f64::INFINITY));
    // Sums over the three finite pixels: 3.5 in the image, 2 in the reference.
    assert_eq!((c.bias, c.relative_l1), (0.75, 0.75));
    let claims = c.claims.as_ref().unwrap();
    assert_eq!((claims.kept, claims.of), (3, 4));
    assert_eq!(c.intervals.as_ref().unwrap().claimed_in_both, 3);
    let rmse = c.measures.unwrap().rmse;
    assert!((rmse - (1.25_f64 / 3.0).sqrt()).abs() < 1e-12, "{rmse}");
    let said = summary(&c);
    let row = |label: &str| said.iter().find(|row| row.0 == label).map(|row| row.1.as_str());
    assert_eq!(row("failed"), Some("1 pixel: not finite, outside of any tolerance and in no mean"));
    assert_eq!(row("left out"), Some("1 pixel: 0 not rendered, 1 where the reference is not finite"));

    let all = compared(&film(&[f32::INFINITY; 2]), &film(&[1.0; 2]), 0.02, 0.0);
    assert_eq!((all.pixels, all.failed, all.within, all.mean), (2, 2, 0, f64::INFINITY));
    assert_eq!((all.bias, all.measures), (f64::INFINITY, None));
    assert!(summary(&all).iter().all(|(_, text)| !text.contains("NaN")), "{:?}", summary(&all));
}

#[test]
fn a_pixel_that_has_failed_is_not_within_what_is_claimed_of_the_picture() {
    let mut image = film(&[1.0, 1.0, f32::INFINITY, 1.0]);
    let claim = PictureClaim {
        error: 0.1,
        share: 0.8,
        assurance: 0.95,
        audited: 4,
        outside: 0,
        upper_outside: 0.2,
        reached: true,
        population: 4,
        looks: 1,
        passes: 1,
    };
    claim.describe(image.metadata_mut());
    let c = compared(&image, &film(&[1.0, 1.0, 1.0, f32::INFINITY]), 0.1, 0.0);
    let judged = c.picture.unwrap();
    assert_eq!((judged.within, judged.of, judged.held()), (2, 3, false));
}

#[test]
fn what_a_film_was_rendered_to_is_a_tolerance_if_it_can_be() {
    let mut image = film(&[1.0]);
    assert_eq!(Tolerance::of(&image), None);
    image.metadata_mut().set("error", 0.05);
    assert_eq!(Tolerance::of(&image), Some(Tolerance { relative: 0.05, absolute: 0.0 }));
    image.metadata_mut().set("error_absolute", 1e-4);
    assert_eq!(Tolerance::of(&image), Some(Tolerance { relative: 0.05, absolute: 1e-4 }));
    let chosen = |relative, absolute, image: &Film| {
        let (tolerance, from) = Tolerance::asked_or_of(relative, absolute, image);
        ([tolerance.relative, tolerance.absolute], from.name())
    };
    assert_eq!(chosen(None, None, &image), ([0.05, 1e-4], "image"));
    assert_eq!(chosen(None, Some(0.5), &image), ([0.05, 0.5], "image"));
    assert_eq!(chosen(Some(0.1), None, &image), ([0.1, 0.0], "asked"));
    assert_eq!(chosen(None, Some(0.5), &film(&[1.0])), ([0.02, 0.5], "default"));
    for error in [0.0, 5.0, f64::NAN] {
        image.metadata_mut().set("error", error);
        assert_eq!(Tolerance::of(&image), None, "{error}");
    }
}

#[test]
fn claims_are_kept_up_to_their_half_widths() {
    let specs = [COLOR, HALF_WIDTH, CLAIM];
    // The first four pixels are 0.1 from the reference; the third of them claims nothing. The last
    // pixel equals the reference and claims to be exact.
    let grays = [1.1, 1.1, 1.1, 0.9, 1.0];
    let half_widths = [0.11, 0.09, 0.01, f32::INFINITY, 0.0];
    let mut image = film_in_rows(5, &grays, &specs);
    for (i, (x, y)) in image.window().pixels().enumerate() {
        image.plane_mut("half_width").unwrap().set_f32(x, y, &[half_widths[i]]);
        image.plane_mut("claim").unwrap().set_u32(x, y, &[if i == 2 { 0 } else { 1 }]);
    }
    let reference = film(&[1.0; 5]);
    let claims = compared(&image, &reference, 0.02, 0.0).claims.unwrap();
    assert_eq!((claims.kept, claims.of, claims.share()), (3, 4, Some(0.75)));
    // Exact limits of 3 of 4, from published tables.
    assert!((claims.interval.low - 0.1941).abs() < 5e-5 && (claims.interval.high - 0.9937).abs() < 5e-5);
    assert!(
        compared(&reference, &image, 0.02, 0.0).claims.is_none(),
        "a film without half-widths claims nothing"
    );

    assert!(claims.same_truth(), "neither film says of what");
    let mut other = reference.clone();
    other.metadata_mut().set("gather.points", 16_u32);
    image.metadata_mut().set("gather.points", 16_u32);
    image.metadata_mut().set("method", "lightcuts");
    assert!(
        compared(&image, &other, 0.02, 0.0).claims.unwrap().same_truth(),
        "methods estimate the same sum"
    );
    other.metadata_mut().set("vpls.seed", 2_u32);
    assert!(!compared(&image, &other, 0.02, 0.0).claims.unwrap().same_truth());

    let mut all = film_in_rows(1, &[1.1], &[COLOR, HALF_WIDTH]);
    all.plane_mut("half_width").unwrap().set_f32(CORNER[0], CORNER[1], &[0.2]);
    let claims = compared(&all, &film(&[1.0]), 0.02, 0.0).claims.unwrap();
    assert_eq!((claims.kept, claims.of), (1, 1), "without a plane of claims every half-width is one");
}

#[test]
fn what_cannot_be_compared_is_refused_by_name() {
    let refused = |a: &Film, b: &Film, tolerance: Tolerance| {
        compare(named("a.exr", a), named("ref.exr", b), &tolerance).unwrap_err().to_string()
    };
    let tolerance = Tolerance::default();
    let said = refused(&film(&[1.0; 4]), &film(&[1.0; 3]), tolerance);
    assert!(said.starts_with("a.exr: an image of 40000x100 pixels, its part 3,7,4,1"), "{said}");
    assert!(said.contains("what ref.exr shows: 40000x100 pixels, its part 3,7,3,1"), "{said}");
    let whole = Film::new([4, 1], Window::full([4, 1]), &[COLOR]).unwrap();
    assert!(refused(&film(&[1.0; 4]), &whole, tolerance).ends_with("ref.exr shows: 4x1 pixels"));
    let colorless = Film::new([4, 1], Window::full([4, 1]), &[STOP]).unwrap();
    assert!(
        refused(&whole, &colorless, tolerance)
            .starts_with(r#"ref.exr: an image without colours, of the layers ["stop"]"#)
    );
    for relative in [0.0, -0.02, 2.0, f64::NAN] {
        assert!(
            refused(&whole, &whole, Tolerance { relative, ..tolerance }).starts_with("error ="),
            "{relative}"
        );
    }
    for absolute in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(refused(&whole, &whole, Tolerance { absolute, ..tolerance }).starts_with("absolute ="));
    }
}

#[test]
fn the_picture_shows_errors_where_they_are() {
    // Pixels with no error, with the tolerance, just below the end of the scale (five times the
    // tolerance), and beyond it; then one that failed, and one whose reference is infinite.
    let c = compared(
        &film_in_rows(2, &[1.0, 1.02, 1.0999, 1.3, f32::INFINITY, 1.0], &[COLOR]),
        &film_in_rows(2, &[1.0, 1.0, 1.0, 1.0, 1.0, f32::INFINITY], &[COLOR]),
        0.02,
        0.0,
    );
    let picture = error_image(&c);
    // Three rows are magnified 86 times, to at least 256 pixels.
    let at = |column: u32, row: u32| picture.pixel(12 + column * 86 + 43, 12 + row * 86 + 43);
    let luminance = |[r, g, b]: [u8; 3]| 2 * u32::from(r) + 7 * u32::from(g) + u32::from(b);
    assert_eq!(at(0, 0), [0, 0, 0]);
    assert!(luminance(at(1, 0)) > 0 && luminance(at(0, 1)) > luminance(at(1, 0)));
    let [r, g, b] = at(0, 1);
    assert!(r > 240 && g > 240 && b < 80, "yellow at the end of the scale: {:?}", [r, g, b]);
    let [r, g, b] = at(1, 1);
    assert!(r > 180 && g < 80 && b < 80, "red beyond: {:?}", [r, g, b]);
    assert_eq!(at(0, 2), at(1, 1), "what failed is beyond");
    let [r, g, b] = at(1, 2);
    assert!(r == g && g == b && r > 0, "gray if left out");
    // The legend has these colours, and there is ink below the picture.
    let [width, height] = picture.size();
    let legend: Vec<[u8; 3]> = (12..270).map(|y| picture.pixel(12 + 172 + 12 + 5, y)).collect();
    assert!(legend.contains(&at(0, 1)) && legend.contains(&at(1, 1)) && legend.contains(&at(1, 2)));
    let ink = (0..width).any(|x| (height - 40..height).any(|y| picture.pixel(x, y) == [0, 0, 0]));
    assert!(ink, "the numbers are printed");
    let decoded = image::load_from_memory(&picture.png()).unwrap().into_rgb8();
    assert_eq!(
        (decoded.dimensions(), decoded.get_pixel(12 + 86 + 43, 12 + 43).0),
        ((width, height), at(1, 0))
    );
}

#[test]
fn the_picture_of_half_widths_is_on_the_same_scale() {
    let specs = [COLOR, HALF_WIDTH, spec("claim", &["id"], SampleKind::U32)];
    let mut film = Film::new([2, 2], Window::full([2, 2]), &specs).unwrap();
    // Relative half-widths: 0 (exact), the tolerance, beyond the scale, and the tolerance without a
    // claim.
    for (pixel, (half_width, claim)) in (0..).zip([(0.0, 1), (0.04, 3), (0.3, 3), (0.04, 0)]) {
        let [x, y] = [pixel % 2, pixel / 2];
        film.plane_mut("").unwrap().set_f32(x, y, &[2.0; 3]);
        film.plane_mut("half_width").unwrap().set_f32(x, y, &[half_width]);
        film.plane_mut("claim").unwrap().set_u32(x, y, &[claim]);
    }
    let tolerance = Tolerance { relative: 0.02, absolute: 0.0 };
    let picture = half_width_image(&film, &tolerance).unwrap();
    // Two rows are magnified 128 times.
    let at = |x: u32, y: u32| picture.pixel(12 + x * 128 + 64, 12 + y * 128 + 64);
    // Colours of the errors 0, more than five tolerances, and one tolerance. They are read from an
    // error image of three rows of one pixel, magnified 86 times.
    let errors = compared(
        &film_in_rows(1, &[1.0, 1.3, 1.02], &[COLOR]),
        &film_in_rows(1, &[1.0; 3], &[COLOR]),
        0.02,
        0.0,
    );
    let error = |y: u32| error_image(&errors).pixel(12 + 43, 12 + y * 86 + 43);
    assert_eq!([at(0, 0), at(0, 1), at(1, 0)], [error(0), error(1), error(2)]);
    let [r, g, b] = at(1, 1);
    assert!(r == g && g == b && r > 0, "gray where nothing is claimed");
    assert!(half_width_image(&film_in_rows(1, &[1.0], &[COLOR]), &tolerance).is_none());
}

#[test]
fn pictures_of_extreme_shapes_are_drawn() {
    for (width, height) in [(1, 1), (3000, 1), (1, 3000), (1, 255)] {
        let grays = vec![1.0; (width * height) as usize];
        let mut film = Film::new([5000, 5000], Window { x: 0, y: 0, width, height }, &[COLOR]).unwrap();
        for ((x, y), gray) in film.window().pixels().zip(grays) {
            film.plane_mut("").unwrap().set_f32(x, y, &[gray; 3]);
        }
        let c = compared(&film, &film, 0.02, 0.0);
        let [w, h] = error_image(&c).size();
        assert!(w > width && h > height && w < width + 600 && h < height + 400, "{width}x{height}: {w}x{h}");
    }
}

#[test]
fn half_widths_are_told_by_their_sources() {
    let specs = [COLOR, HALF_WIDTH, spec("half_width_parts", &["a", "b", "c"], SampleKind::F32)];
    let mut film = Film::new([5, 1], Window::full([5, 1]), &specs).unwrap();
    // Luminances and half-widths. The fourth half-width is 0, and the fifth pixel is black; both
    // are ignored.
    let pixels = [(1.0, 0.1), (2.0, 0.6), (4.0, 0.8), (1.0, 0.0), (0.0, 0.5)];
    for (x, (luminance, half_width)) in (0..).zip(pixels) {
        film.plane_mut("").unwrap().set_f32(x, 0, &[luminance; 3]);
        film.plane_mut("half_width").unwrap().set_f32(x, 0, &[half_width]);
        let parts = [0.5 * half_width, 0.25 * half_width, 0.125 * half_width];
        film.plane_mut("half_width_parts").unwrap().set_f32(x, 0, &parts);
    }
    // Relative: 0.1, 0.3, 0.2.
    let found = error_budget(&film).unwrap();
    let expected = [0.2, 0.1, 0.05, 0.025];
    let found = [found.total, found.clustering, found.lights, found.compensation];
    assert!(found.iter().zip(expected).all(|(a, b): (&f64, f64)| (a - b).abs() < 1e-6), "{found:?}");
    film.plane_mut("half_width").unwrap().set_f32(0, 0, &[0.0]);
    assert!(error_budget(&Film::new([5, 1], Window::full([5, 1]), &specs).unwrap()).is_none());
}
