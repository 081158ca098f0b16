//! Conversion of attributes from text to numbers, vectors and colours.
//!
//! Numbers in lists are separated by blanks, commas, or both. Every number must be finite. Names
//! become the snake case of Mitsuba 3, so that the rest of the loader sees one spelling: `intIOR`
//! and `int_ior` are one name.
//!
//! Held to this by the tests below.

use glam::DVec3;

use crate::color::{Rgb, srgb_decode};

/// A spectrum as the file gives it.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Spectrum {
    /// Equal at all wavelengths; white as an emission.
    Constant(f64),
    /// Equal at all wavelengths; as an emission it is equal energy, which is reddish.
    Uniform(f64),
    /// Wavelength (nm) and value, by increasing wavelength.
    Samples(Vec<(f32, f32)>),
}

/// Parses a finite number in double precision.
pub(super) fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|v: &f64| v.is_finite())
}

/// A list of finite numbers.
pub(super) fn numbers(text: &str) -> Option<Vec<f64>> {
    let words = text.split(|c: char| c.is_whitespace() || c == ',').filter(|w| !w.is_empty());
    words.map(number).collect()
}

/// A whole number; `3.0` counts as one.
pub(super) fn integer(text: &str) -> Option<i64> {
    let text = text.trim();
    text.parse()
        .ok()
        .or_else(|| number(text).filter(|v| v.fract() == 0.0 && v.abs() < 1e15).map(|v| v as i64))
}

/// `true` or `1`, `false` or `0`; in any case of letters.
pub(super) fn boolean(text: &str) -> Option<bool> {
    match text.trim().to_ascii_lowercase().as_str() {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    }
}

/// Three numbers, or one for all three.
pub(super) fn vector(text: &str) -> Option<DVec3> {
    match *numbers(text)?.as_slice() {
        [v] => Some(DVec3::splat(v)),
        [x, y, z] => Some(DVec3::new(x, y, z)),
        _ => None,
    }
}

/// Linear Rec. 709: one number, three, or `#rrggbb` (sRGB).
pub(super) fn rgb(text: &str) -> Option<Rgb> {
    if let Some(digits) = text.trim().strip_prefix('#') {
        return hexadecimal(digits);
    }
    vector(text).map(|v| Rgb::new(v.x as f32, v.y as f32, v.z as f32)).filter(|c| c.is_finite())
}

/// As [`rgb`], for numbers that are sRGB.
pub(super) fn srgb(text: &str) -> Option<Rgb> {
    if text.trim().starts_with('#') { rgb(text) } else { rgb(text).map(|c| c.map(srgb_decode)) }
}

/// `rrggbb`; an `aa` after it is ignored.
fn hexadecimal(digits: &str) -> Option<Rgb> {
    if !matches!(digits.len(), 6 | 8) || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    let channel =
        |i: usize| u8::from_str_radix(&digits[i..i + 2], 16).ok().map(|v| srgb_decode(f32::from(v) / 255.0));
    Some(Rgb::new(channel(0)?, channel(2)?, channel(4)?))
}

/// One number, `400:0.1, 500:0.2, …`, or the three numbers of a colour (returned as `Err`).
pub(super) fn spectrum(text: &str) -> Option<Result<Spectrum, Rgb>> {
    if !text.contains(':') {
        return match *numbers(text)?.as_slice() {
            [v] => Some(Ok(Spectrum::Constant(v))),
            [r, g, b] => Some(Err(Rgb::new(r as f32, g as f32, b as f32))),
            _ => None,
        };
    }
    let words = text.split(|c: char| c.is_whitespace() || c == ',').filter(|w| !w.is_empty());
    let mut samples = Vec::new();
    // Blanks around the colon are accepted: words are joined first.
    let joined: Vec<&str> = words.collect();
    for pair in joined.join(" ").replace(" :", ":").replace(": ", ":").split(' ') {
        let (wavelength, value) = pair.split_once(':')?;
        samples.push((number(wavelength)? as f32, number(value)? as f32));
    }
    Some(Ok(Spectrum::Samples(sorted(samples)?)))
}

/// Reads the lines of a `.spd` file: wavelength and value; `#` begins a comment.
pub(super) fn spectrum_file(bytes: &[u8]) -> Option<Spectrum> {
    let mut samples = Vec::new();
    for line in std::str::from_utf8(bytes).ok()?.lines() {
        let line = line.split('#').next().unwrap_or_default();
        match *numbers(line)?.as_slice() {
            [] => {}
            [wavelength, value] => samples.push((wavelength as f32, value as f32)),
            _ => return None,
        }
    }
    Some(Spectrum::Samples(sorted(samples)?))
}

/// Samples by wavelength; `None` if there are none, a number is not finite, or a wavelength is not
/// above 0.
pub(super) fn sorted(mut samples: Vec<(f32, f32)>) -> Option<Vec<(f32, f32)>> {
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    samples.dedup_by(|a, b| a.0 == b.0);
    let sound = samples.iter().all(|s| s.0.is_finite() && s.0 > 0.0 && s.1.is_finite());
    (sound && !samples.is_empty()).then_some(samples)
}

/// `toWorld` as `to_world`, `intIOR` as `int_ior`; snake case stays.
pub(super) fn snake_case(name: &str) -> String {
    let mut snake = String::with_capacity(name.len() + 4);
    let mut after_lower = false;
    for c in name.trim().chars() {
        if c.is_uppercase() && after_lower {
            snake.push('_');
        }
        after_lower = c.is_lowercase() || c.is_ascii_digit();
        snake.extend(c.to_lowercase());
    }
    snake
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_separated_by_blanks_or_commas_and_are_finite() {
        assert_eq!(numbers(" 1, 2 3,4\n5"), Some(vec![1.0, 2.0, 3.0, 4.0, 5.0]));
        for wrong in ["1 x", "nan", "1e999", "inf"] {
            assert_eq!(numbers(wrong), None, "{wrong}");
        }
        assert_eq!(
            (integer("7"), integer("7.0"), integer("7.5"), integer("1e300")),
            (Some(7), Some(7), None, None)
        );
        assert_eq!((boolean("True"), boolean("0"), boolean("yes")), (Some(true), Some(false), None));
        assert_eq!((vector("2"), vector("1 2")), (Some(DVec3::splat(2.0)), None));
    }

    #[test]
    fn colours_have_one_or_three_numbers_or_hexadecimal_digits() {
        assert_eq!(rgb("0.5"), Some(Rgb::gray(0.5)));
        assert_eq!(rgb("0.5,0.2 0.1"), Some(Rgb::new(0.5, 0.2, 0.1)));
        assert_eq!(rgb("#ff0000"), Some(Rgb::new(1.0, 0.0, 0.0)));
        assert_eq!(srgb("1, 0, 1"), Some(Rgb::new(1.0, 0.0, 1.0)));
        assert!((srgb("0.5").unwrap().g - 0.214).abs() < 1e-3, "decoded");
        for wrong in ["#ff00", "#ggffff", "#ä€€", "1 2", "", "1 2 3 4"] {
            assert_eq!(rgb(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn spectra_are_sorted_samples_or_one_number() {
        assert_eq!(spectrum("2"), Some(Ok(Spectrum::Constant(2.0))));
        assert_eq!(spectrum("1 2 3"), Some(Err(Rgb::new(1.0, 2.0, 3.0))));
        let samples = Spectrum::Samples(vec![(400.0, 0.1), (500.0, 0.2)]);
        for text in ["400:0.1, 500:0.2", "500: 0.2 400 :0.1"] {
            assert_eq!(spectrum(text), Some(Ok(samples.clone())), "{text}");
        }
        assert_eq!(spectrum_file(b"# title\n400 0.1\n\n500\t0.2 # end\n"), Some(samples));
        for wrong in ["400:", ":1", "400:1:2", "-400:1"] {
            assert_eq!(spectrum(wrong), None, "{wrong}");
        }
        assert_eq!((spectrum_file(b""), spectrum_file(b"1 2 3")), (None, None));
    }

    #[test]
    fn both_spellings_of_a_name_are_one() {
        for (camel, snake) in [
            ("toWorld", "to_world"),
            ("intIOR", "int_ior"),
            ("alphaU", "alpha_u"),
            ("uoffset", "uoffset"),
            ("fov_axis", "fov_axis"),
        ] {
            assert_eq!(snake_case(camel), snake);
        }
    }
}
