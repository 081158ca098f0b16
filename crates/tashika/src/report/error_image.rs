//! The relative error of each pixel as a picture, with the scale beside it and the numbers below.
//!
//! Colours run from black (no error) over blue and green to yellow (five times the tolerance), errors beyond are red, pixels left out
//! are gray. Small images are magnified by a whole factor, so that the text fits beside them.

use embedded_graphics::mono_font::MonoFont;
use embedded_graphics::mono_font::ascii::{FONT_8X13, FONT_10X20};
use embedded_graphics::text::Baseline;

use super::color_scale::{BEYOND, ColorScale, NO_VALUE};
use super::compare::Comparison;
use super::picture::Picture;
use super::words::{percent_of_error, percent_of_share, percent_of_tolerance};

/// End of the scale, in tolerances; there is a tick for each.
const TICKS: u32 = 5;
/// Least length of the picture's longer side, and height of the scale (pixels).
const LEAST_SIDE: u32 = 256;
const MARGIN: u32 = 12;
/// Width of the scale, without and with its labels.
const BAR: u32 = 18;
const LEGEND: u32 = BAR + 8 + 10 * 8;
/// Height of the fields for colours beside the scale.
const FIELD: u32 = 16;
const PAPER: [u8; 3] = [255, 255, 255];
const INK: [u8; 3] = [0, 0, 0];

/// Draws the error of each pixel; at most a few hundred pixels larger than the window.
pub fn error_image(comparison: &Comparison) -> Picture {
    let scale = ColorScale::new();
    let end = comparison.tolerance.relative * f64::from(TICKS);
    let size = [comparison.window.width, comparison.window.height];
    let errors = Picture::of_pixels(size, comparison.errors.iter().map(|e| scale.color(e / end)));
    let magnification = LEAST_SIDE.div_ceil(size[0].max(size[1])).max(1);
    let [width, height] = size.map(|side| side * magnification);

    let within = format!(
        "within {}: {}",
        percent_of_tolerance(comparison.tolerance.relative),
        percent_of_share(comparison.within_share())
    );
    let details = format!(
        "mean {}  95th {}  worst {}",
        percent_of_error(comparison.mean),
        percent_of_error(comparison.p95),
        percent_of_error(comparison.worst)
    );
    let caption_width = text_width(&within, &FONT_10X20).max(text_width(&details, &FONT_8X13));
    let body = height.max(LEAST_SIDE);
    let caption = MARGIN + body + MARGIN;
    let mut canvas = Picture::filled(
        [(width + MARGIN + LEGEND).max(caption_width) + 2 * MARGIN, caption + 20 + 4 + 13 + MARGIN],
        PAPER,
    );
    canvas.put([MARGIN; 2], &errors, magnification);
    legend(&mut canvas, [width + 2 * MARGIN, MARGIN], body, &scale, comparison);
    canvas.write(&within, [MARGIN, caption], Baseline::Top, &FONT_10X20);
    canvas.write(&details, [MARGIN, caption + 24], Baseline::Top, &FONT_8X13);
    canvas
}

fn text_width(text: &str, font: &MonoFont<'_>) -> u32 {
    text.len() as u32 * (font.character_size.width + font.character_spacing)
}

/// The scale from its end at the top to zero, a field for what is beyond, and one for what is left out.
fn legend(canvas: &mut Picture, [x, y]: [u32; 2], height: u32, scale: &ColorScale, comparison: &Comparison) {
    let label = x + BAR + 8;
    let tolerance = comparison.tolerance.relative;
    let told = |n: u32| percent_of_tolerance(tolerance * f64::from(n));
    canvas.fill([x, y], [BAR, FIELD], BEYOND);
    canvas.write(&format!("> {}", told(TICKS)), [label, y + FIELD / 2], Baseline::Middle, &FONT_8X13);
    let mut bottom = y + height - 1;
    if comparison.left_out() > 0 {
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
