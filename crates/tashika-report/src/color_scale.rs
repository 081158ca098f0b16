//! Colours of errors: black, blue, green, yellow for `[0, 1]`, and red beyond.
//!
//! The scale consists of straight lines in the colour space Oklab (Ottosson 2020) between four
//! points. Their lightness is nearly proportional to the value, so that a larger error is always a
//! lighter colour. The picture is legible in print without colours and with colour vision
//! deficiency. Red is off these lines: it means "beyond the scale", without an amount.
//!
//! ```text
//! value        0       0.36     0.70     1
//! lightness    0       0.350    0.680    0.965
//! a            0      −0.015   −0.140   −0.068
//! b            0      −0.190    0.115    0.185
//! ```
//!
//! # Guarantee
//! Luminance grows strictly with the value. Every colour of the lines is displayable (sRGB) to
//! 0.4 % of white.
//!
//! # Held to this by
//! The tests below.

use crate::color::{Rgb, srgb_encode};

/// Values and their colours in Oklab: value, lightness, a, b.
const POINTS: [[f32; 4]; 4] = [
    [0.0, 0.0, 0.0, 0.0],
    [0.36, 0.350, -0.015, -0.190],
    [0.70, 0.680, -0.140, 0.115],
    [1.0, 0.965, -0.068, 0.185],
];
/// Colour of values beyond the scale.
pub(super) const BEYOND: [u8; 3] = [214, 40, 40];
/// Colour of pixels without a value.
pub(super) const NO_VALUE: [u8; 3] = [150, 150, 150];

/// Number of shades of the scale.
const SHADES: usize = 256;

/// The scale as a table.
pub(super) struct ColorScale([[u8; 3]; SHADES]);

impl ColorScale {
    pub(super) fn new() -> Self {
        Self(std::array::from_fn(|i| {
            linear(i as f32 / (SHADES - 1) as f32)
                .to_array()
                .map(|v| to_8_bits(srgb_encode(v.clamp(0.0, 1.0))))
        }))
    }

    /// Colour of a value from 0 to 1; [`NO_VALUE`] for NaN, [`BEYOND`] above 1.
    pub(super) fn color(&self, value: f64) -> [u8; 3] {
        match value {
            v if v.is_nan() => NO_VALUE,
            v if v > 1.0 => BEYOND,
            v => self.0[(v.max(0.0) * (SHADES - 1) as f64 + 0.5) as usize],
        }
    }
}

/// Converts an encoded channel in `[0, 1]` to a byte.
pub(super) fn to_8_bits(value: f32) -> u8 {
    (value * 255.0 + 0.5) as u8
}

/// Converts a value in `[0, 1]` to linear Rec. 709.
fn linear(value: f32) -> Rgb {
    let last = POINTS.len() - 2;
    let i = POINTS[1..=last].iter().filter(|p| p[0] < value).count();
    let (from, to) = (POINTS[i], POINTS[i + 1]);
    let t = (value - from[0]) / (to[0] - from[0]);
    let [_, l, a, b] = std::array::from_fn(|k| from[k] + (to[k] - from[k]) * t);
    of_oklab(l, a, b)
}

/// Converts Oklab to linear Rec. 709, by the inverse matrices of Ottosson 2020.
fn of_oklab(lightness: f32, a: f32, b: f32) -> Rgb {
    let cube = |v: f32| v * v * v;
    let l = cube(lightness + 0.396_337_78 * a + 0.215_803_76 * b);
    let m = cube(lightness - 0.105_561_346 * a - 0.063_854_17 * b);
    let s = cube(lightness - 0.089_484_18 * a - 1.291_485_5 * b);
    Rgb::new(
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_93 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_4 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_corners_of_srgb_have_the_coordinates_of_the_source() {
        // White is lightness 1 without chroma; pure blue by its published coordinates.
        for (oklab, rgb) in
            [([1.0, 0.0, 0.0], [1.0, 1.0, 1.0]), ([0.452_01, -0.032_46, -0.311_53], [0.0, 0.0, 1.0])]
        {
            let found = of_oklab(oklab[0], oklab[1], oklab[2]).to_array();
            assert!(found.iter().zip(rgb).all(|(f, r)| (f - r).abs() < 1e-3), "{found:?}");
        }
    }

    #[test]
    fn larger_values_are_lighter_and_all_are_displayable() {
        let mut last = -1.0;
        for i in 0..=1000 {
            let c = linear(i as f32 / 1000.0);
            assert!(c.luminance() > last, "{i}");
            assert!(c.to_array().iter().all(|v| (-0.004..=1.004).contains(v)), "{i}: {c:?}");
            last = c.luminance();
        }
    }

    #[test]
    fn the_order_is_black_blue_green_yellow_red() {
        let scale = ColorScale::new();
        assert_eq!(scale.color(0.0), [0, 0, 0]);
        let [r, g, b] = scale.color(0.36);
        assert!(b > 2 * r.max(g), "blue");
        let [r, g, b] = scale.color(0.7);
        assert!(g > 2 * r.max(b), "green");
        let [r, g, b] = scale.color(1.0);
        assert!(r.min(g) > 3 * b, "yellow");
        assert_eq!([scale.color(1.01), scale.color(f64::INFINITY)], [BEYOND; 2]);
        assert_eq!(scale.color(f64::NAN), NO_VALUE);
    }
}
