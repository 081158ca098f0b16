//! Picture of the luminance of each pixel in false colours, with isolines and the scale beside it.
//!
//! ```text
//! L_v = K_r R + K_g G + K_b B          cd·m⁻²
//! ```
//!
//! The coefficients `K` are the luminous efficacies of the channels (lm·W⁻¹). Colours are those of
//! the picture of errors, in proportion from black at 0 to yellow at the end of the scale; brighter
//! pixels are red, pixels that were not rendered are gray. Isolines are at the inner numbers of the
//! scale, which has five equal steps. They are those of the median of 5 × 5 pixels, which removes
//! noise and leaves edges where they are.
//!
//! # Held to this by
//! The tests below.

use embedded_graphics::mono_font::ascii::FONT_8X13;
use embedded_graphics::text::Baseline;

use super::color_scale::{BEYOND, ColorScale, NO_VALUE};
use super::isolines::isoline;
use super::picture::Picture;
use crate::film::{Film, RenderFilm};

/// Number of equal parts of the scale.
const STEPS: u32 = 5;
/// Minimum of the picture's longer side, and of the height of the scale (pixels).
const LEAST_SIDE: u32 = 256;
const MARGIN: u32 = 12;
/// Width of the scale, and of the scale with its labels (pixels).
const BAR: u32 = 18;
const LEGEND: u32 = BAR + 8 + 10 * 8;
/// Height of the fields for colours beside the scale (pixels).
const FIELD: u32 = 16;
/// Shade above which lines are black; on darker ground they are white.
const LIGHT: f64 = 0.5;
/// Share of the pixels that the default scale includes.
const SHOWN: f64 = 0.99;

/// Scale of a picture of luminances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LuminanceScale {
    /// Luminance of a radiance of 1 in each channel (lm·W⁻¹).
    pub efficacies: [f64; 3],
    /// Luminance at the end of the scale (cd·m⁻²), above 0. Default: the smallest of 1, 2 and 5
    /// times a power of ten that includes 99 % of the pixels.
    pub end: Option<f64>,
}

/// Draws the luminance of each pixel; `None` if the film has no colours.
pub fn luminance_image(film: &Film, scale: &LuminanceScale) -> Option<Picture> {
    let read = RenderFilm::of(film);
    let luminance = |pixel: usize| match read.color(pixel) {
        Some(color) if read.is_rendered(pixel) => {
            let channels = color.to_array().into_iter().zip(scale.efficacies);
            channels.map(|(value, efficacy)| f64::from(value) * efficacy).sum()
        }
        _ => f64::NAN,
    };
    film.colors().is_some().then(|| {
        let values: Vec<f64> = (0..read.pixels()).map(luminance).collect();
        let window = film.window();
        draw([window.width, window.height], &values, scale.end.unwrap_or_else(|| default_end(&values)))
    })
}

/// Smallest round number that includes most of the values.
fn default_end(values: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let last = ((sorted.len() as f64 * SHOWN).ceil() as usize).clamp(1, sorted.len().max(1)) - 1;
    let most = sorted.get(last).copied().unwrap_or(0.0);
    if most <= 0.0 {
        return 1.0;
    }
    let mut power = 1.0;
    while power < most && power < 1e300 {
        power *= 10.0;
    }
    while power >= 10.0 * most && power > 1e-300 {
        power /= 10.0;
    }
    // Here `power / 10 < most ≤ power`.
    [0.1, 0.2, 0.5].map(|factor| factor * power).into_iter().find(|end| *end >= most).unwrap_or(power)
}

fn draw(size: [u32; 2], values: &[f64], end: f64) -> Picture {
    let scale = ColorScale::new();
    let magnification = LEAST_SIDE.div_ceil(size[0].max(size[1])).max(1);
    let [width, height] = size.map(|side| side * magnification);
    let body = height.max(LEAST_SIDE);
    let mut canvas = Picture::filled([width + 3 * MARGIN + LEGEND, body + 2 * MARGIN], [255, 255, 255]);
    let pixels = Picture::of_pixels(size, values.iter().map(|value| scale.color(value / end)));
    canvas.put([MARGIN; 2], &pixels, magnification);
    let columns = size[0] as usize;
    let smooth = medians(values, columns);
    let value = |x: usize, y: usize| smooth[y * columns + x];
    for step in 1..STEPS {
        let share = f64::from(step) / f64::from(STEPS);
        let ink = if share > LIGHT { [0; 3] } else { [255; 3] };
        for [from, to] in isoline(size.map(|side| side as usize), &value, share * end) {
            // Values are at the middles of pixels.
            let place = |p: [f64; 2]| p.map(|v| f64::from(MARGIN) + (v + 0.5) * f64::from(magnification));
            line(&mut canvas, place(from), place(to), ink);
        }
    }
    let left_out = values.iter().any(|value| value.is_nan());
    legend(&mut canvas, [width + 2 * MARGIN, MARGIN], body, &scale, end, left_out);
    canvas
}

/// Medians of the values within two columns and two rows; NaN stays NaN, and does not count.
fn medians(values: &[f64], columns: usize) -> Vec<f64> {
    const REACH: usize = 2;
    let rows = values.len() / columns.max(1);
    let mut near = Vec::with_capacity((2 * REACH + 1).pow(2));
    let mut smooth = values.to_vec();
    for (at, smooth) in smooth.iter_mut().enumerate().filter(|(_, value)| !value.is_nan()) {
        let (x, y) = (at % columns, at / columns);
        near.clear();
        for row in y.saturating_sub(REACH)..(y + REACH + 1).min(rows) {
            let across = x.saturating_sub(REACH)..(x + REACH + 1).min(columns);
            near.extend(values[row * columns..][across].iter().filter(|value| !value.is_nan()));
        }
        let middle = near.len() / 2;
        *smooth = *near.select_nth_unstable_by(middle, f64::total_cmp).1;
    }
    smooth
}

/// Draws a line of the width of a pixel.
fn line(canvas: &mut Picture, from: [f64; 2], to: [f64; 2], ink: [u8; 3]) {
    let longer = (to[0] - from[0]).abs().max((to[1] - from[1]).abs());
    let steps = (longer.ceil() as u32).max(1);
    for step in 0..=steps {
        let share = f64::from(step) / f64::from(steps);
        let place: [u32; 2] = std::array::from_fn(|k| (from[k] + share * (to[k] - from[k])) as u32);
        canvas.fill(place, [1, 1], ink);
    }
}

/// Draws the scale from its end at the top to zero, a field for values beyond it, and one for
/// pixels that were not rendered.
fn legend(canvas: &mut Picture, [x, y]: [u32; 2], height: u32, scale: &ColorScale, end: f64, left_out: bool) {
    let label = x + BAR + 8;
    let number = |step: u32| rounded(end * f64::from(step) / f64::from(STEPS));
    canvas.fill([x, y], [BAR, FIELD], BEYOND);
    canvas.write(&format!("> {}", number(STEPS)), [label, y + FIELD / 2], Baseline::Middle, &FONT_8X13);
    let mut bottom = y + height - 1;
    if left_out {
        canvas.fill([x, bottom + 1 - FIELD], [BAR, FIELD], NO_VALUE);
        canvas.write("left out", [label, bottom - FIELD / 2], Baseline::Middle, &FONT_8X13);
        bottom -= 2 * FIELD;
    }
    // Labels of the scale's ends are centred on them.
    let top = y + 3 * FIELD;
    bottom -= FIELD / 2;
    canvas.write("cd/m2", [label, y + FIELD + FIELD / 2], Baseline::Middle, &FONT_8X13);
    for row in top..=bottom {
        let value = f64::from(bottom - row) / f64::from(bottom - top);
        canvas.fill([x, row], [BAR, 1], scale.color(value));
    }
    for step in 0..=STEPS {
        let row = bottom - (bottom - top) * step / STEPS;
        let share = f64::from(step) / f64::from(STEPS);
        if (1..STEPS).contains(&step) {
            canvas.fill([x, row], [BAR, 1], if share > LIGHT { [0; 3] } else { [255; 3] });
        }
        canvas.fill([x + BAR, row], [4, 1], [0; 3]);
        canvas.write(&number(step), [label, row], Baseline::Middle, &FONT_8X13);
    }
}

/// Formats a value with three significant digits, an integer from 100, or two decimals below 1.
pub(super) fn rounded(value: f64) -> String {
    match value {
        v if v >= 1e6 => format!("{v:.1e}"),
        v if v >= 99.95 || v == 0.0 => format!("{v:.0}"),
        v if v >= 9.995 => format!("{v:.1}"),
        v if v >= 0.00995 => format!("{v:.2}"),
        v => format!("{v:.0e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::film::{PixelRecord, Window};

    fn film(size: [u32; 2], radiance: impl Fn(u32, u32) -> Option<Rgb>) -> Film {
        let mut film = Film::new(size, Window::full(size), PixelRecord::PLANES).unwrap();
        for (x, y) in film.window().pixels() {
            if let Some(radiance) = radiance(x, y) {
                let stop = crate::film::Stop::Complete;
                PixelRecord { radiance, stop, ..PixelRecord::default() }.store(&mut film, x, y);
            }
        }
        film
    }

    /// Green of radiance 2 at an efficacy of 100 lm·W⁻¹ is 200 cd·m⁻². On a scale to 400 it has the
    /// colour of one half, beyond 100 it is red, and a pixel that was not rendered is gray.
    #[test]
    fn pixels_have_the_colour_of_their_luminance() {
        let green = film([256, 256], |x, _| (x > 0).then_some(Rgb::new(5.0, 2.0, 0.0)));
        let shown = |end: f64| {
            let scale = LuminanceScale { efficacies: [0.0, 100.0, 7.0], end: Some(end) };
            luminance_image(&green, &scale).unwrap()
        };
        let half = ColorScale::new().color(0.5);
        assert_eq!(shown(400.0).pixel(MARGIN + 100, MARGIN + 100), half);
        assert_eq!(shown(100.0).pixel(MARGIN + 100, MARGIN + 100), BEYOND);
        assert_eq!(shown(400.0).pixel(MARGIN, MARGIN + 100), NO_VALUE);
    }

    /// A ramp from 0 to 100 cd·m⁻² has its lines at 20, 40, 60 and 80, white on dark ground and
    /// black on light ground.
    #[test]
    fn isolines_are_at_the_numbers_of_the_scale() {
        let ramp = film([300, 20], |x, _| Some(Rgb::gray(x as f32 / 299.0)));
        let scale = LuminanceScale { efficacies: [0.0, 100.0, 0.0], end: Some(100.0) };
        let picture = luminance_image(&ramp, &scale).unwrap();
        for (share, ink) in [(0.2, [255; 3]), (0.4, [255; 3]), (0.6, [0; 3]), (0.8, [0; 3])] {
            let column = MARGIN + (share * 299.0 + 0.5) as u32;
            assert_eq!(picture.pixel(column, MARGIN + 10), ink, "{share}");
            assert_ne!(picture.pixel(column + 4, MARGIN + 10), ink, "{share}");
        }
    }

    /// A single bright pixel has no line around it, and the edge of a bright half stays in place.
    #[test]
    fn lines_follow_medians() {
        let mut values = vec![0.0; 12 * 12];
        values[5 * 12 + 5] = 9.0;
        values[0] = f64::NAN;
        assert!(medians(&values, 12).iter().all(|value| *value == 0.0 || value.is_nan()));
        assert!(medians(&values, 12)[0].is_nan());
        let half: Vec<f64> = (0..144).map(|k| f64::from(u8::from(k % 12 >= 6))).collect();
        assert_eq!(medians(&half, 12), half);
        assert!(medians(&[], 0).is_empty());
    }

    #[test]
    fn the_default_scale_ends_at_a_round_number() {
        let mut values: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.1).collect();
        values.extend([1e9, f64::NAN]);
        assert_eq!(default_end(&values), 100.0);
        for (most, end) in [(1.0, 1.0), (1.5, 2.0), (3e-7, 5e-7), (1234.0, 2000.0), (0.0, 1.0)] {
            assert!((default_end(&[most]) / end - 1.0).abs() < 1e-9, "{most}: {}", default_end(&[most]));
        }
        assert_eq!(default_end(&[]), 1.0);
        assert!(default_end(&[f64::MAX]).is_finite() && default_end(&[5e-324]) > 0.0);
        let black = film([4, 3], |_, _| Some(Rgb::BLACK));
        let scale = LuminanceScale { efficacies: [1.0; 3], end: None };
        assert!(luminance_image(&black, &scale).is_some());
    }
}
