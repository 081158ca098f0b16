//! Picture of the relative error of each pixel, or of its claimed half-width, with the scale beside
//! it and numbers below.
//!
//! Colours run from black (no error) over blue and green to yellow (five times the tolerance);
//! larger errors are red, omitted pixels are gray. Small images are magnified by a whole factor, so
//! that the text fits beside them.

use embedded_graphics::mono_font::MonoFont;
use embedded_graphics::mono_font::ascii::{FONT_8X13, FONT_10X20};
use embedded_graphics::text::Baseline;

use super::color_scale::{BEYOND, ColorScale, NO_VALUE};
use super::compare::{Comparison, Tolerance};
use super::picture::Picture;
use crate::film::{Film, RenderFilm};
use crate::film::{percent_of_error, percent_of_share, percent_of_tolerance};

/// End of the scale, in tolerances; there is a tick for each.
const TICKS: u32 = 5;
/// Minimum of the picture's longer side, and of the height of the scale (pixels).
const LEAST_SIDE: u32 = 256;
const MARGIN: u32 = 12;
/// Width of the scale, without and with its labels (pixels).
const BAR: u32 = 18;
const LEGEND: u32 = BAR + 8 + 10 * 8;
/// Height of the fields for colours beside the scale (pixels).
const FIELD: u32 = 16;
const PAPER: [u8; 3] = [255, 255, 255];
const INK: [u8; 3] = [0, 0, 0];

/// Draws the error of each pixel; at most a few hundred pixels larger than the window.
pub fn error_image(comparison: &Comparison) -> Picture {
    let tolerance = comparison.tolerance.relative;
    let within = format!(
        "within {}: {}",
        percent_of_tolerance(tolerance),
        percent_of_share(comparison.within_share())
    );
    let details = format!(
        "mean {}  95th {}  worst {}",
        percent_of_error(comparison.mean),
        percent_of_error(comparison.p95),
        percent_of_error(comparison.worst)
    );
    let size = [comparison.window.width, comparison.window.height];
    draw(size, comparison.errors.iter().copied(), tolerance, &within, &details)
}

/// Draws the half-width that each pixel claims, on the scale of errors, relative to the pixel's
/// size in the error metric. Pixels that claim nothing are gray. `None` if the film has no
/// half-widths or no colours.
pub fn half_width_image(film: &Film, tolerance: &Tolerance) -> Option<Picture> {
    let read = RenderFilm::of(film);
    if !read.has_half_widths() || film.colors().is_none() {
        return None;
    }
    let pixels = 0..film.window().area() as usize;
    let widths: Vec<f64> = pixels.map(|pixel| read.relative_half_width(pixel).unwrap_or(f64::NAN)).collect();
    let claimed = widths.iter().filter(|width| !width.is_nan());
    let share = claimed.clone().count() as f64 / widths.len() as f64;
    let widest = claimed.copied().fold(0.0, f64::max);
    let window = film.window();
    let what = format!("claimed: {} of the pixels", percent_of_share(share));
    let details = format!("widest {}", percent_of_error(widest));
    let size = [window.width, window.height];
    Some(draw(size, widths.into_iter(), tolerance.relative, &what, &details))
}

/// Draws values relative to a tolerance, with the scale and two lines of text; NaN is drawn as no
/// value.
fn draw(
    size: [u32; 2],
    values: impl Iterator<Item = f64> + Clone,
    tolerance: f64,
    headline: &str,
    details: &str,
) -> Picture {
    let scale = ColorScale::new();
    let end = tolerance * f64::from(TICKS);
    let left_out = values.clone().any(f64::is_nan);
    let errors = Picture::of_pixels(size, values.map(|value| scale.color(value / end)));
    let magnification = LEAST_SIDE.div_ceil(size[0].max(size[1])).max(1);
    let [width, height] = size.map(|side| side * magnification);
    let caption_width = text_width(headline, &FONT_10X20).max(text_width(details, &FONT_8X13));
    let body = height.max(LEAST_SIDE);
    let caption = MARGIN + body + MARGIN;
    let mut canvas = Picture::filled(
        [(width + MARGIN + LEGEND).max(caption_width) + 2 * MARGIN, caption + 20 + 4 + 13 + MARGIN],
        PAPER,
    );
    canvas.put([MARGIN; 2], &errors, magnification);
    legend(&mut canvas, [width + 2 * MARGIN, MARGIN], body, &scale, tolerance, left_out);
    canvas.write(headline, [MARGIN, caption], Baseline::Top, &FONT_10X20);
    canvas.write(details, [MARGIN, caption + 24], Baseline::Top, &FONT_8X13);
    canvas
}

fn text_width(text: &str, font: &MonoFont<'_>) -> u32 {
    text.len() as u32 * (font.character_size.width + font.character_spacing)
}

/// Draws the scale from its end at the top to zero, a field for values beyond it, and one for
/// omitted pixels.
fn legend(
    canvas: &mut Picture,
    [x, y]: [u32; 2],
    height: u32,
    scale: &ColorScale,
    tolerance: f64,
    left_out: bool,
) {
    let label = x + BAR + 8;
    let told = |n: u32| percent_of_tolerance(tolerance * f64::from(n));
    canvas.fill([x, y], [BAR, FIELD], BEYOND);
    canvas.write(&format!("> {}", told(TICKS)), [label, y + FIELD / 2], Baseline::Middle, &FONT_8X13);
    let mut bottom = y + height - 1;
    if left_out {
        canvas.fill([x, bottom + 1 - FIELD], [BAR, FIELD], NO_VALUE);
        canvas.write("left out", [label, bottom - FIELD / 2], Baseline::Middle, &FONT_8X13);
        bottom -= 2 * FIELD;
    }
    // Labels of the scale's ends are centred on them.
    let top = y + 2 * FIELD;
    bottom -= FIELD / 2;
    for row in top..=bottom {
        let value = f64::from(bottom - row) / f64::from(bottom - top);
        canvas.fill([x, row], [BAR, 1], scale.color(value));
    }
    for n in 0..=TICKS {
        let row = bottom - (bottom - top) * n / TICKS;
        canvas.fill([x + BAR, row], [4, 1], INK);
        canvas.write(&told(n), [label, row], Baseline::Middle, &FONT_8X13);
    }
}
