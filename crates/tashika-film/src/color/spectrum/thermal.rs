//! Emission of black bodies.
//!
//! ```text
//! L(λ, T) = c₁ / (λ⁵ (exp(c₂ / (λ T)) − 1)),   c₁ = 2 h c²,   c₂ = h c / k
//! ```
//!
//! Source: Planck 1901, with the constants that the SI has been defined by since 2019. Held to this
//! by the tests below.

use super::{Rgb, emission};
use crate::math::elementary::exp;

/// `2 h c²` (W·m²·sr⁻¹).
const C1: f64 = 1.191_042_972e-16;
/// `h c / k` (m·K).
const C2: f64 = 1.438_776_877e-2;
/// Wien's displacement constant `λ_max T` (m·K).
const WIEN: f64 = 2.897_771_955e-3;
/// Lowest temperature that has a colour here (K): below it, nothing is visible in `f32`.
const MIN_KELVIN: f32 = 300.0;
/// Highest temperature that has a colour here (K): beyond it, colours do not change.
const MAX_KELVIN: f32 = 1e9;

/// Spectral radiance of a black body (W·m⁻²·sr⁻¹·nm⁻¹); zero for wavelengths or temperatures that
/// are not positive.
pub fn blackbody(nm: f32, kelvin: f32) -> f32 {
    radiance(f64::from(nm), f64::from(kelvin)) as f32
}

fn radiance(nm: f64, kelvin: f64) -> f64 {
    if !(nm > 0.0 && kelvin > 0.0) {
        return 0.0;
    }
    let metres = nm * 1e-9;
    let x = C2 / (metres * kelvin);
    // For small `x` the subtraction `exp(x) − 1` loses digits; its series does not.
    let denominator = if x < 1e-2 { x * (1.0 + x * (0.5 + x / 6.0)) } else { f64::from(exp(x as f32)) - 1.0 };
    let squared = metres * metres;
    C1 / (squared * squared * metres * denominator) * 1e-9
}

/// Colour of a black body with luminance 1; `None` outside of 300 K to 10⁹ K.
pub fn blackbody_rgb(kelvin: f32) -> Option<Rgb> {
    let peak = peak(kelvin)?;
    let color = emission(|nm| radiance(f64::from(nm), f64::from(kelvin)) / peak);
    let luminance = color.luminance();
    (luminance > 0.0).then(|| color / luminance)
}

/// Colour of a black body whose spectrum has the maximum 1 over all wavelengths, as `blackbody` in
/// pbrt-v3; `None` outside of 300 K to 10⁹ K.
pub fn blackbody_rgb_of_unit_peak(kelvin: f32) -> Option<Rgb> {
    let peak = peak(kelvin)?;
    Some(emission(|nm| radiance(f64::from(nm), f64::from(kelvin)) / peak))
}

/// Largest spectral radiance at a temperature; `None` outside of 300 K to 10⁹ K.
fn peak(kelvin: f32) -> Option<f64> {
    let kelvin = (MIN_KELVIN..=MAX_KELVIN).contains(&kelvin).then_some(f64::from(kelvin))?;
    Some(radiance(WIEN / kelvin * 1e9, kelvin))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radiance_agrees_with_plancks_law_its_peak_and_its_limit() {
        // The Sun at 5772 K: 2.62e13 W·m⁻²·sr⁻¹·m⁻¹ at 502 nm, c₁ T⁵ / (c₂⁵ · 0.0470).
        let sun = blackbody(502.0, 5772.0);
        let expected = 4.095_7e-6 * 5772.0_f32 * 5772.0 * 5772.0 * 5772.0 * 5772.0 * 1e-9;
        assert!((sun / expected - 1.0).abs() < 1e-3, "{sun} {expected}");
        assert!(sun > blackbody(480.0, 5772.0) && sun > blackbody(525.0, 5772.0));
        // Rayleigh and Jeans: 2 c k T / λ⁴ for long waves.
        let (nm, kelvin) = (1e7_f64, 5000.0);
        let metres = nm * 1e-9;
        let limit = 2.0 * 299_792_458.0 * 1.380_649e-23 * kelvin / (metres * metres * metres * metres) * 1e-9;
        assert!((f64::from(blackbody(nm as f32, kelvin as f32)) / limit - 1.0).abs() < 2e-4);
        // The two forms of the denominator meet.
        let (below, above) = (radiance(C2 * 1e9 / 0.00999, 1.0), radiance(C2 * 1e9 / 0.01001, 1.0));
        assert!((above / below - (0.01001_f64 / 0.00999).powi(4)).abs() < 1e-4);
        assert_eq!([blackbody(0.0, 5000.0), blackbody(500.0, -1.0), blackbody(f32::NAN, 1.0)], [0.0; 3]);
    }

    #[test]
    fn colors_follow_the_planckian_locus() {
        // Chromaticities of black bodies ([^cie15]), by their XYZ of luminance 1.
        for (kelvin, x, y) in
            [(2856.0, 0.44757, 0.40745), (5000.0, 0.34510, 0.35161), (10_000.0, 0.28063, 0.28829)]
        {
            let expected = super::super::observer::to_rgb([x / y, 1.0, (1.0 - x - y) / y]);
            let rgb = blackbody_rgb(kelvin).unwrap();
            assert!((rgb.luminance() - 1.0).abs() < 1e-6);
            for (seen, expected) in rgb.to_array().into_iter().zip(expected) {
                // Tolerance for the error of the fit of the matching functions.
                assert!((f64::from(seen) - expected).abs() < 0.02, "{kelvin}: {rgb:?} {expected}");
            }
        }
    }

    #[test]
    fn a_spectrum_of_unit_peak_is_as_bright_as_the_eye_is_broad() {
        // With its peak in the green, a spectrum is nearly 1 wherever the eye is sensitive.
        let sun = blackbody_rgb_of_unit_peak(5200.0).unwrap();
        assert!((0.97..1.0).contains(&sun.luminance()), "{sun:?}");
        // Colder spectra have the peak in the infrared, λ_max = 2.8978 mm·K / T, which is
        // invisible.
        let samples: Vec<(f32, f32)> = (380_u16..=780)
            .map(|nm| (f32::from(nm), blackbody(f32::from(nm), 2000.0) / blackbody(1448.9, 2000.0)))
            .collect();
        let expected = super::super::rgb_of_emission(&samples).unwrap();
        let warm = blackbody_rgb_of_unit_peak(2000.0).unwrap();
        assert!(warm.zip(expected, |a, b| (a - b).abs()).max_channel() < 1e-5, "{warm:?} {expected:?}");
        for kelvin in [f32::NAN, -5.0, 0.0, 299.0, f32::INFINITY] {
            assert_eq!((blackbody_rgb(kelvin), blackbody_rgb_of_unit_peak(kelvin)), (None, None));
        }
        for kelvin in [300.0, 1e9] {
            assert!(blackbody_rgb(kelvin).unwrap().is_valid());
        }
    }
}
