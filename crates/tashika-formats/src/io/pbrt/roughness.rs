//! Conversion of a file's roughness to the `α` of GGX.
//!
//! ```text
//! pbrt-v3, remapped:   x = ln max(r, 10⁻³),   α = 1.62142 + 0.819955 x + 0.1734 x² + 0.0171201 x³ + 0.000640711 x⁴
//! pbrt-v4, remapped:   α = √r
//! otherwise:           α = r
//! ```
//!
//! If the remapped roughness of pbrt-v3 is a texture, `1.62 r^0.54` replaces the polynomial; it is
//! within 6 % of the polynomial from `r = 0.01` to 1.
//!
//! Source: Pharr et al. 2023, section 9.6.4 (v4); pbrt-v3's format description, "remaproughness".
//! Tested by the tests below.

use super::version::Version;
use crate::math::elementary::ln;

/// Smallest roughness that pbrt-v3 maps.
const SMALLEST: f32 = 1e-3;

/// Factor and exponent of the power that approximates pbrt-v3's polynomial.
pub(super) const POWER_V3: (f32, f32) = (1.62, 0.54);

/// Returns `α` of a constant roughness, 0 to 1.
pub(super) fn alpha(roughness: f32, remap: bool, version: Version) -> f32 {
    let r = roughness.max(0.0);
    let alpha = match (remap, version) {
        (false, _) => r,
        (true, Version::V4) => r.sqrt(),
        (true, Version::V3) => {
            let x = ln(r.max(SMALLEST));
            1.621_42 + x * (0.819_955 + x * (0.173_4 + x * (0.017_120_1 + x * 0.000_640_711)))
        }
    };
    alpha.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary::powf;

    #[test]
    fn roughness_is_mapped_as_each_format_does() {
        for (r, expected) in [(0.01, 0.138_85), (0.1, 0.461_8), (0.5, 1.129_85_f32.min(1.0)), (0.0, 0.047_1)]
        {
            assert!(
                (alpha(r, true, Version::V3) - expected).abs() < 2e-4,
                "{r}: {}",
                alpha(r, true, Version::V3)
            );
        }
        assert_eq!((alpha(0.25, true, Version::V4), alpha(0.25, false, Version::V4)), (0.5, 0.25));
        assert_eq!(alpha(-1.0, false, Version::V3), 0.0);
    }

    #[test]
    fn the_power_follows_the_polynomial() {
        let (factor, exponent) = POWER_V3;
        for i in 0..=20 {
            let r = powf(10.0, -0.1 * i as f32);
            let exact = {
                let x = ln(r);
                1.621_42 + x * (0.819_955 + x * (0.173_4 + x * (0.017_120_1 + x * 0.000_640_711)))
            };
            let power = factor * powf(r, exponent);
            assert!((power / exact - 1.0).abs() < 0.06, "{r}: {power} for {exact}");
        }
    }
}
