//! Errors that a reconstruction predicts. They guide the work; no claim rests on them.

use super::verdict::Tolerance;
use crate::color::Rgb;
use crate::math::elementary::exp_f64;
use crate::picture::importance;
use crate::reconstruction::Reconstructed;

/// Amount that is added to each predicted error in the map of half-widths, over the tolerance. It
/// is about the half-width of an audited pixel's truth.
const OF_TRUTHS: f64 = 0.5;

/// Predicted error of each pixel over its tolerance.
pub(super) fn importance_of(reconstructed: &Reconstructed, tolerance: &Tolerance) -> Vec<f32> {
    importance(reconstructed, |radiance| tolerance.of(radiance.luminance().into()))
}

/// Predicted share of the pixels outside the tolerance, if errors are normally distributed.
pub(super) fn share_outside(importance: &[f32]) -> f64 {
    let outside = importance.iter().map(|share| beyond(1.0 / f64::from(*share))).sum::<f64>();
    outside / importance.len() as f64
}

/// Half-widths of the map, before they are scaled by the audit (W·m⁻²·sr⁻¹).
pub(super) fn half_widths(reconstructed: &Reconstructed, tolerance: &Tolerance) -> Vec<f64> {
    let Reconstructed { radiance, importance_error } = reconstructed;
    let of_pixel = |(radiance, error): (&Rgb, &f32)| {
        let of_truth = OF_TRUTHS * tolerance.of(radiance.luminance().into());
        (f64::from(*error) + of_truth).max(f64::MIN_POSITIVE)
    };
    radiance.iter().zip(importance_error).map(of_pixel).collect()
}

/// Probability that a normal number is more than `x` standard deviations from its mean, to 10⁻⁶
/// (Abramowitz, Stegun 1964, 7.1.26); `x` at least 0.
fn beyond(x: f64) -> f64 {
    let z = x * std::f64::consts::FRAC_1_SQRT_2;
    let k = 1.0 / (1.0 + 0.327_591_1 * z);
    let polynomial = [1.061_405_429, -1.453_152_027, 1.421_413_741, -0.284_496_736, 0.254_829_592];
    let sum = polynomial.iter().fold(0.0, |sum, factor| (sum + factor) * k);
    if z.is_finite() { sum * exp_f64(-z * z) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_are_those_of_the_tables() {
        let table =
            [(0.0, 1.0), (1.0, 0.317_310_5), (1.959_964, 0.05), (3.0, 0.002_699_8), (f64::INFINITY, 0.0)];
        for (x, tail) in table {
            assert!((beyond(x) - tail).abs() < 1e-6, "{x}: {}", beyond(x));
        }
    }
}
