//! The CIE's standard observer of 1931, Rec. 709, and daylight.
//!
//! ```text
//! x̄(λ) ≈ Σ aᵢ exp(−½ (λ − μᵢ)² / σᵢ²),   σᵢ one value below μᵢ and one above
//! ```
//!
//! Source: Wyman 2013, the fit with several lobes. Its largest deviation from the CIE's table is
//! below 0.03 by the test below; the functions themselves reach 1.06, 1.0 and 1.78.

use std::sync::LazyLock;

use crate::math::elementary::exp;

/// Wavelength of the first of the [`responses`] (nm).
pub(super) const FIRST_NM: f32 = 380.0;
/// Number of the [`responses`], 1 nm apart.
const COUNT: usize = 401;

/// XYZ to linear Rec. 709: the inverse of the matrix whose columns are the primaries ([^bt709],
/// table of chromaticities) scaled so that they add up to D65 of luminance 1.
pub(super) const XYZ_TO_RGB: [[f64; 3]; 3] = [
    [3.240_969_94, -1.537_383_18, -0.498_610_76],
    [-0.969_243_64, 1.875_967_50, 0.041_555_06],
    [0.055_630_08, -0.203_976_96, 1.056_971_51],
];

/// Relative power of D65 from 380 nm in steps of 10 nm: [^cie15], table T.1.
const D65: [f64; 41] = [
    49.9755, 54.6482, 82.7549, 91.4860, 93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861, 115.923,
    108.811, 109.354, 107.802, 104.790, 107.689, 104.405, 104.046, 100.000, 96.3342, 95.7880, 88.6856,
    90.0062, 89.5991, 87.6987, 83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091,
    74.3490, 61.6040, 69.8856, 75.0870, 63.5927, 46.4182, 66.8054, 63.3828,
];

/// Response of the observer, and power of daylight, at one wavelength.
pub(super) struct Response {
    /// Colour matching functions `x̄ ȳ z̄`.
    pub xyz: [f64; 3],
    /// Colour matching functions in linear Rec. 709.
    pub rgb: [f64; 3],
    /// Relative power of D65.
    pub d65: f64,
}

/// Responses from [`FIRST_NM`] to 780 nm, 1 nm apart.
pub(super) fn responses() -> &'static [Response] {
    static RESPONSES: LazyLock<Vec<Response>> = LazyLock::new(|| {
        let response = |i: usize| {
            let xyz = matching(FIRST_NM + i as f32).map(f64::from);
            let (before, share) = (i / 10, (i % 10) as f64 / 10.0);
            let after = (before + 1).min(D65.len() - 1);
            Response { xyz, rgb: to_rgb(xyz), d65: D65[before] + (D65[after] - D65[before]) * share }
        };
        (0..COUNT).map(response).collect()
    });
    &RESPONSES
}

/// Converts XYZ to linear Rec. 709.
pub(super) fn to_rgb(xyz: [f64; 3]) -> [f64; 3] {
    XYZ_TO_RGB.map(|row| row.iter().zip(xyz).map(|(m, v)| m * v).sum())
}

/// `x̄ ȳ z̄` at a wavelength (nm).
fn matching(nm: f32) -> [f32; 3] {
    let lobe = |height: f32, centre: f32, below: f32, above: f32| {
        let t = (nm - centre) / if nm < centre { below } else { above };
        height * exp(-0.5 * t * t)
    };
    [
        lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) - lobe(0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fit_is_within_its_error_of_the_cies_table() {
        let table = [
            (400.0, [0.0143, 0.0004, 0.0679]),
            (420.0, [0.1344, 0.0040, 0.6456]),
            (440.0, [0.3483, 0.0230, 1.7471]),
            (460.0, [0.2908, 0.0600, 1.6692]),
            (480.0, [0.0956, 0.1390, 0.8130]),
            (500.0, [0.0049, 0.3230, 0.2720]),
            (520.0, [0.0633, 0.7100, 0.0782]),
            (540.0, [0.2904, 0.9540, 0.0203]),
            (560.0, [0.5945, 0.9950, 0.0039]),
            (580.0, [0.9163, 0.8700, 0.0017]),
            (600.0, [1.0622, 0.6310, 0.0008]),
            (620.0, [0.8544, 0.3810, 0.0002]),
            (640.0, [0.4479, 0.1750, 0.0]),
            (660.0, [0.1649, 0.0610, 0.0]),
            (680.0, [0.0468, 0.0170, 0.0]),
            (700.0, [0.0114, 0.0041, 0.0]),
        ];
        let mut worst = 0.0_f32;
        for (nm, expected) in table {
            for (fit, expected) in matching(nm).into_iter().zip(expected) {
                worst = worst.max((fit - expected).abs());
            }
        }
        assert!(worst < 0.03, "{worst}");
    }

    #[test]
    fn the_matrix_maps_primaries_and_white_of_rec_709() {
        let seen = |x: f64, y: f64| to_rgb([x / y, 1.0, (1.0 - x - y) / y]);
        for (c, (x, y)) in [(0.64, 0.33), (0.30, 0.60), (0.15, 0.06)].into_iter().enumerate() {
            let rgb = seen(x, y);
            let own = 1.0 / f64::from(crate::color::LUMINANCE_WEIGHTS[c]);
            for (i, value) in rgb.into_iter().enumerate() {
                // The published weights have four digits.
                assert!((value - if i == c { own } else { 0.0 }).abs() < 1e-3 * own, "{c}: {rgb:?}");
            }
        }
        assert!(seen(0.3127, 0.3290).iter().all(|v| (v - 1.0).abs() < 1e-6), "{:?}", seen(0.3127, 0.3290));
    }

    #[test]
    fn daylight_has_the_chromaticity_of_the_white() {
        let [x, y, z] = super::super::integrate(|_| 1.0, |r| r.xyz.map(|v| v * r.d65));
        let sum = x + y + z;
        // Tolerance for the error of the fit.
        assert!(
            (x / sum - 0.3127).abs() < 0.002 && (y / sum - 0.3290).abs() < 0.002,
            "{} {}",
            x / sum,
            y / sum
        );
        let [_, norm, _] = super::super::integrate(|_| 1.0, |r| r.xyz);
        assert!((norm / 106.857 - 1.0).abs() < 0.005, "{norm}");
    }
}
