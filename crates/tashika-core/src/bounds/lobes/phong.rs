//! Upper bound of the Phong lobe over a range of angles and exponents.
//!
//! ```text
//! max over n in [n₀, n₁] of (n + 2) / (2π) cosⁿα = the value at n* = clamp(−1 / ln cos α − 2, n₀, n₁)          (sr⁻¹)
//! ```
//!
//! Here `α` is the smallest angle to the mirror direction, since the lobe falls with `α`. As a
//! function of `n`, the logarithm of the lobe has the derivative `1 / (n + 2) + ln cos α`, which
//! falls with `n`. The value at the largest exponent is *not* a bound: away from the mirror
//! direction wide lobes are brighter.
//!
//! # Guarantee
//! At least the value of [`bsdf::Phong`](crate::bsdf::Phong) in its `f32` arithmetic. In that
//! arithmetic the error of `1 − cos α` is 2·10⁻⁶ from the lengths of two directions, plus seven
//! roundings; the relative error of `n log₂(1 − x)` is 6·10⁻⁷ (3·10⁻⁶ together); products are off
//! by 1.6·10⁻⁵ of the value; and powers below `e⁻¹⁰⁰` are zero.
//!
//! # Held to this by
//! The tests below, `bounds::tests::reflector`, `bounds::tests::analytic`.

use std::f64::consts::TAU;

use crate::bounds::angle::{Angle, TURN};
use crate::math::elementary::{exp, powf_f64};

/// Factor on `1 − cos α` for its roundings and those of the exponent. `−ln(1 − x)` is convex and
/// zero at zero, so reducing `x` by a factor reduces the exponent by at least the same factor.
const VERSINE: f64 = 1.0 - 4e-6;

/// Negated exponent above which `bsdf::Phong` returns zero for a power, `e⁻¹⁰⁰`. Includes room for
/// the rounding of that comparison.
const NEGLIGIBLE_POWER: f64 = 100.001;

/// Largest ratio of powers computed by multiplication to the exact ones (`bsdf::phong`).
const PRODUCTS: f64 = 1.0 + 1.6e-5;

/// Upper bound of `(n + 2) / 2π cosⁿα` (sr⁻¹) for all `n` in the range and all angles of at least
/// `least`.
pub(in crate::bounds) fn upper_power(exponents: [f64; 2], least: Angle) -> f64 {
    let half = least.half().sin;
    let versine = 2.0 * half * half * VERSINE;
    let [low, high] = exponents;
    if versine >= 1.0 || low * versine > NEGLIGIBLE_POWER {
        return 0.0;
    }
    let log = upper_ln_1m(versine);
    let n = if log < 0.0 { (-1.0 / log - 2.0).clamp(low, high) } else { high };
    PRODUCTS * (n + 2.0) * f64::from(exp((n * log) as f32)) / TAU
}

/// Upper bound of `(n + 2) / 2π cosⁿα cos⁺θ_i` (sr⁻¹) over all light directions, for a mirror
/// direction at least `mirror` from the normal.
///
/// In the plane of normal and mirror direction, with `t = tan α`, the value is
/// `(1 + t²)^(−(n+1)/2) (cos θ + t sin θ)`. It is largest at
/// `n sin θ t² + (n + 1) cos θ t = sin θ`.
pub(in crate::bounds) fn upper_peak(exponent: f64, mirror: Angle) -> f64 {
    let Angle { sin, cos } = mirror.minus(TURN);
    let b = (exponent + 1.0) * cos;
    let t = 2.0 * sin / (b + (b * b + 4.0 * exponent * sin * sin).sqrt());
    let power = powf_f64(1.0 + t * t, -0.5 * (exponent + 1.0));
    PRODUCTS * (exponent + 2.0) / TAU * power * (cos + t * sin)
}

/// Upper bound of `ln(1 − x)` for `x` in `[0, 1)`: the first terms of `−2 (y + y³/3 + y⁵/5 + …)`
/// with `y = x / (2 − x)`.
///
/// The relative error is 2·10⁻⁵ at `x = ½` and 4 % at `x = 0.9`.
fn upper_ln_1m(x: f64) -> f64 {
    let y = x / (2.0 - x);
    let y2 = y * y;
    -2.0 * y * (1.0 + y2 * (1.0 / 3.0 + y2 * (1.0 / 5.0 + y2 * (1.0 / 7.0))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::lobes::round_up;
    use crate::bsdf::{Bsdf, Phong};
    use crate::color::Rgb;
    use crate::math::Vec3;
    use crate::math::elementary::powf;
    use crate::rng::{Purpose, Stream};
    use crate::warp;

    /// Compares the bound of a range with exponents in steps of 1 %, which miss less than 10⁻⁴ of
    /// the largest value. At wide angles the error of the series is added, as documented there.
    #[test]
    fn ranges_of_exponents_hold_and_are_tight() {
        for exponents in [[0.0, 0.0], [0.0, 3.0], [1.0, 100.0], [10.0, 1e6], [0.0, 1e6], [1e6, 1e6]] {
            for angle in [0.0_f64, 1e-4, 1e-3, 0.02, 0.3, 1.0] {
                let (sin, cos) = angle.sin_cos();
                let bound = upper_power(exponents, Angle { sin, cos });
                let [low, high] = exponents;
                let mut largest = 0.0_f64;
                for step in 0..=2000 {
                    let n = (low + 1.0) * ((high + 1.0) / (low + 1.0)).powf(f64::from(step) / 2000.0) - 1.0;
                    let log = (-2.0 * (angle / 2.0).sin().powi(2)).ln_1p();
                    // Smaller powers are zero in `bsdf::Phong`.
                    let power = if n * log < -100.0 { 0.0 } else { (n * log).exp() };
                    let value = (n + 2.0) * power / TAU;
                    assert!(value <= bound * (1.0 + 2e-7), "{exponents:?} at {angle}: {value} above {bound}");
                    largest = largest.max(value);
                }
                assert!(
                    bound <= largest * 1.002 || bound < 1e-37,
                    "{exponents:?} at {angle}: {bound} for {largest}"
                );
            }
        }
    }

    /// Each value is bounded at the angle between its own `f32` directions, so that only rounding
    /// errors remain. The slack is necessary and sufficient.
    #[test]
    fn values_in_f32_are_below() {
        let mut s = Stream::new(42, Purpose::Test, 0);
        let mut above = 0;
        for _ in 0..200_000 {
            let exponent = powf(1e6, s.uniform());
            // Powers with integer exponents are computed by multiplication.
            let exponent = if s.below(2) == 0 { exponent.round() } else { exponent };
            let wo = warp::cone(s.uniform_2(), 0.05).normalize();
            let mirror = Vec3::new(-wo.x, -wo.y, wo.z);
            let wide = 13.0 * s.uniform() / (exponent + 4.0).sqrt();
            let wi = (mirror + warp::sphere(s.uniform_2()) * wide).normalize();
            let phong = Phong { diffuse: Rgb::BLACK, specular: Rgb::WHITE, exponent };
            let value = Bsdf::Phong(phong).eval(wo, wi).g;
            let (mirror, wi) = (mirror.as_dvec3(), wi.as_dvec3());
            let least = Angle { sin: mirror.cross(wi).length(), cos: mirror.dot(wi) };
            assert!(value <= round_up(upper_power([f64::from(exponent); 2], least)), "{phong:?} {wo} {wi}");
            let versine = 1.0 - (least.cos / least.sin.hypot(least.cos));
            let exact = (f64::from(exponent) + 2.0) * ((-versine).ln_1p() * f64::from(exponent)).exp() / TAU;
            above += u32::from(f64::from(value) > exact * (1.0 + 1e-5));
        }
        assert!(above > 0, "without slack no value would be above");
    }

    /// Angles `α` in steps of a 50th of the lobe's width miss less than 10⁻³ of the peak.
    #[test]
    fn peaks_hold_and_are_tight() {
        for exponent in [0.0_f64, 0.3, 1.0, 30.0, 1e4, 1e6] {
            for theta in [0.0_f64, 1e-3, 0.3, 1.2, 1.5, 1.57, 1.570_5] {
                let bound = upper_peak(exponent, Angle { sin: theta.sin(), cos: theta.cos() });
                let width = 4.0 / (exponent + 4.0).sqrt();
                let values = (0..=400).map(|i| {
                    let alpha = f64::from(i) / 100.0 * 0.5 * width;
                    (exponent + 2.0) / TAU * alpha.cos().max(0.0).powf(exponent) * (theta - alpha).cos()
                });
                let largest = values.fold(0.0, f64::max);
                // The first factor covers roundings of f64, the second TURN at a cosine of at least
                // 1/√n.
                assert!(
                    bound * (1.0 + 1e-12) >= largest && bound < 1.005 * largest,
                    "{exponent} at {theta}: {bound} for {largest}"
                );
            }
        }
    }

    #[test]
    fn the_series_is_above_the_logarithm() {
        for step in 0..1000 {
            let x = f64::from(step) / 1000.0;
            let (exact, bound) = ((-x).ln_1p(), upper_ln_1m(x));
            assert!(bound >= exact - 1e-15, "{x}");
            if x <= 0.5 {
                assert!(bound <= exact * (1.0 - 2e-5), "{x}");
            }
        }
        assert!(upper_ln_1m(0.9) < 0.96 * (-0.9_f64).ln_1p());
    }
}
