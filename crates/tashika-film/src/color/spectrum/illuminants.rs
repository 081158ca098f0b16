//! The CIE's standard illuminants by name.
//!
//! Source: [^cie15], tables T.3 and T.8 (chromaticities for the 2° observer). Held to this by the
//! tests below.

use super::observer::to_rgb;
use super::{Rgb, of_luminance};

/// Name in lower case and chromaticity `(x, y)`. D65 is rounded as in Rec. 709, so that it is
/// exactly white.
const CHROMATICITIES: [(&str, f64, f64); 22] = [
    ("a", 0.447_57, 0.407_45),
    ("b", 0.348_42, 0.351_61),
    ("c", 0.310_06, 0.316_16),
    ("d50", 0.345_67, 0.358_50),
    ("d55", 0.332_42, 0.347_43),
    ("d60", 0.321_68, 0.337_67),
    ("acesd60", 0.321_68, 0.337_67),
    ("d65", 0.312_7, 0.329_0),
    ("d75", 0.299_02, 0.314_85),
    ("e", 1.0 / 3.0, 1.0 / 3.0),
    ("f1", 0.313_1, 0.337_1),
    ("f2", 0.372_1, 0.375_1),
    ("f3", 0.409_1, 0.394_1),
    ("f4", 0.440_2, 0.403_1),
    ("f5", 0.313_8, 0.345_2),
    ("f6", 0.377_9, 0.388_2),
    ("f7", 0.312_9, 0.329_2),
    ("f8", 0.345_8, 0.358_6),
    ("f9", 0.374_1, 0.372_7),
    ("f10", 0.345_8, 0.358_8),
    ("f11", 0.380_5, 0.376_9),
    ("f12", 0.437_0, 0.404_2),
];

/// Returns the colour of an illuminant, with luminance 1, given its name in any case of letters:
/// `A`, `D65`, `stdillum-F2`, `illum-acesD60`.
pub fn illuminant_rgb(name: &str) -> Option<Rgb> {
    let name = name.to_ascii_lowercase();
    let short = name.strip_prefix("stdillum-").or_else(|| name.strip_prefix("illum-")).unwrap_or(&name);
    let &(_, x, y) = CHROMATICITIES.iter().find(|(known, ..)| *known == short)?;
    let [r, g, b] = to_rgb([x / y, 1.0, (1.0 - x - y) / y]).map(|c| c as f32);
    Some(of_luminance(Rgb::new(r, g, b), 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::spectrum::{blackbody_rgb, rgb_of_emission};

    #[test]
    fn names_of_each_format_are_known_and_luminance_is_one() {
        for name in ["stdillum-D65", "illum-D65", "d65"] {
            let white = illuminant_rgb(name).unwrap();
            assert!(white.zip(Rgb::WHITE, |a, b| (a - b).abs()).max_channel() < 1e-5, "{name}: {white:?}");
        }
        for (name, ..) in CHROMATICITIES {
            let color = illuminant_rgb(name).unwrap();
            assert!(color.is_valid() && (color.luminance() - 1.0).abs() < 1e-6, "{name}");
        }
        assert_eq!((illuminant_rgb("stdillum-F13"), illuminant_rgb("")), (None, None));
    }

    #[test]
    fn chromaticities_agree_with_spectra() {
        let lamp = illuminant_rgb("stdillum-A").unwrap();
        let spectrum = blackbody_rgb(2855.5).unwrap();
        assert!(lamp.zip(spectrum, |a, b| (a - b).abs()).max_channel() < 0.02, "{lamp:?} {spectrum:?}");
        let equal = illuminant_rgb("E").unwrap();
        let spectrum = rgb_of_emission(&[(500.0, 1.0)]).unwrap();
        assert!(equal.zip(spectrum, |a, b| (a - b).abs()).max_channel() < 0.005, "{equal:?} {spectrum:?}");
    }
}
