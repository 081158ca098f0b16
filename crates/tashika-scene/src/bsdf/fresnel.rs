//! Reflectance of a smooth boundary for unpolarised light.
//!
//! Every function takes the cosine of the angle of incidence, in `[0, 1]`, and returns a fraction
//! in `[0, 1]`. Indices of refraction are relative to the medium that the light comes from.
//!
//! * [`dielectric`], [`conductor`]: the Fresnel equations (Born and Wolf 1999, sections 1.5.2 and
//!   14.2).
//! * [`schlick`]: `F₀ + (1 − F₀)(1 − c)⁵` (Schlick 1994, equation 15).
//! * [`dielectric_average`], [`schlick_hemisphere`]: integrals over the hemisphere, as fits to
//!   quadrature.
//!
//! # Held to this by
//! The tests below: normal incidence, Brewster's angle, total reflection, limits of the conductor,
//! and the fits against quadrature.

use crate::color::Rgb;
use crate::math::Real;
use crate::math::simd::each;

/// Reflectance of the boundary to a dielectric of relative index `eta = η_t / η_i`.
///
/// * `cos`: cosine `c` of the angle of incidence.
///
/// With `g = η cos θ_t = √(η² − 1 + c²)` the amplitudes are `(η² c − g) / (η² c + g)` in the plane
/// of incidence and `(c − g) / (c + g)` across it. Exactly 1 under total internal reflection.
#[inline(always)]
pub fn dielectric<R: Real>(cos: R, eta: f32) -> R {
    let g2 = R::splat((eta - 1.0) * (eta + 1.0)) + cos * cos;
    let g = g2.max(R::splat(0.0)).sqrt();
    let dense = R::splat(eta * eta) * cos;
    let (parallel, perpendicular) = ((dense - g) * (cos + g), (cos - g) * (dense + g));
    let denominator = (dense + g) * (cos + g);
    // One division serves both squares; the minimum only removes a rounding above 1.
    let squares = R::splat(0.5) * (parallel * parallel + perpendicular * perpendicular);
    let reflected = (squares / (denominator * denominator)).min(R::splat(1.0));
    R::select(g2.le(R::splat(0.0)), R::splat(1.0), reflected)
}

/// Reflectance of the boundary to a conductor of relative complex index `eta + i k`, by channel.
#[inline(always)]
pub fn conductor<R: Real>(cos: R, eta: Rgb, k: Rgb) -> [R; 3] {
    let (eta, k) = (eta.to_array(), k.to_array());
    each!(|channel| conductor_channel(cos, eta[channel], k[channel]))
}

/// Reflectance in one channel. With `a + i b = √((η + i k)² − sin²θ)` and `m = a² + b²`,
///
/// ```text
/// |r_s|² = (m − 2 a c + c²) / (m + 2 a c + c²)
/// |r_p|² = |r_s|² (c² m − 2 a c s² + s⁴) / (c² m + 2 a c s² + s⁴)          s = sin θ
/// ```
///
/// so that their mean has the numerator `(m − 2 a c + c²)(c² m + s⁴)`.
#[inline(always)]
fn conductor_channel<R: Real>(cos: R, eta: f32, k: f32) -> R {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let cos2 = cos * cos;
    let sin2 = (one - cos) * (one + cos);
    let real = R::splat((eta - k) * (eta + k)) - sin2;
    let modulus = (real * real + R::splat(4.0 * eta * eta * k * k)).sqrt();
    let a = (R::splat(0.5) * (modulus + real)).max(zero).sqrt();
    let (across, across_mixed) = (modulus + cos2, R::splat(2.0) * cos * a);
    let (within, within_mixed) = (cos2 * modulus + sin2 * sin2, across_mixed * sin2);
    let numerator = (across - across_mixed) * within;
    let denominator = (across + across_mixed) * (within + within_mixed);
    // The lower limit of the denominator matters only for η = 1, k = 0 (no boundary) at grazing
    // incidence.
    (numerator / denominator.max(R::splat(f32::MIN_POSITIVE))).max(zero).min(one)
}

/// Schlick's approximation from the reflectance `f0` at normal incidence.
#[inline(always)]
pub fn schlick<R: Real>(f0: Rgb, cos: R) -> [R; 3] {
    let weight = schlick_weight(cos);
    let f0 = f0.to_array();
    each!(|channel| R::splat(f0[channel]) + R::splat(1.0 - f0[channel]) * weight)
}

/// `(1 − c)⁵`.
#[inline(always)]
pub fn schlick_weight<R: Real>(cos: R) -> R {
    let x = (R::splat(1.0) - cos).max(R::splat(0.0));
    let x2 = x * x;
    x2 * x2 * x
}

/// Reflectance of the outside of a dielectric under diffuse light, `2 ∫₀¹ F(c, η) c dc`, for
/// `η ≥ 1`.
///
/// The reflectance of the inside follows from it: `F_int = 1 − (1 − F_ext) / η²`. In equilibrium
/// the radiance inside is `η²` times that outside, and the fluxes through the boundary in both
/// directions are equal.
///
/// Approximated by a polynomial in `√s`, `s = (η − 1) / (η + 1)`, fitted by least squares over 80
/// Chebyshev nodes of `0 ≤ √s ≤ √(2/3)`, that is `1 ≤ η ≤ 5`. The error is at most `2·10⁻⁵`.
#[inline]
pub fn dielectric_average(eta: f32) -> f32 {
    const COEFFICIENTS: [f32; 6] =
        [0.695_846_56, -0.846_781_46, -0.256_086_3, 3.618_041_2, -4.099_722, 1.861_793_4];
    let s = ((eta - 1.0) / (eta + 1.0)).max(0.0);
    s * polynomial(&COEFFICIENTS, s.sqrt())
}

/// `∫ (1 − ω_o·h)⁵ cos θ_i / π dω_i` over the hemisphere, as a function of `cos θ_o`.
///
/// Share of its albedo that a diffuse part loses if it is weighted by `(1 − F(ω_o·h)) / (1 − F₀)`,
/// with Schlick's `F`. Approximated by a polynomial, fitted by least squares over 40 Chebyshev
/// nodes. The error is at most `6·10⁻⁶`.
#[inline]
pub fn schlick_hemisphere(cos_o: f32) -> f32 {
    const COEFFICIENTS: [f32; 5] =
        [0.028_161_304, -0.079_801_76, 0.086_255_23, -0.043_383_756, 0.008_851_009];
    polynomial(&COEFFICIENTS, cos_o)
}

/// `Σ cᵢ xⁱ` by Horner's rule.
#[inline]
fn polynomial(coefficients: &[f32], x: f32) -> f32 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_incidence_follows_the_square_law() {
        for eta in [1.0001_f32, 1.33, 1.5, 2.4, 5.0, 1.0 / 1.5] {
            let root = (eta - 1.0) / (eta + 1.0);
            let expected = root * root;
            // `η − 1` is computed exactly, but in the formula it is a difference of larger terms,
            // which costs a relative ε / (η − 1).
            let tolerance = expected * 8.0 * f32::EPSILON / (eta - 1.0).abs();
            assert!((dielectric(1.0, eta) - expected).abs() <= tolerance, "eta {eta}");
        }
        let gold = conductor(1.0_f32, Rgb::gray(0.2), Rgb::gray(3.0))[0];
        let expected = (0.8 * 0.8 + 9.0) / (1.2 * 1.2 + 9.0);
        assert!((gold - expected).abs() < 1e-6, "{gold} against {expected}");
    }

    /// At Brewster's angle `tan θ = η` the parallel part vanishes: `F = ½ ((1 − η²) / (1 + η²))²`.
    #[test]
    fn brewster_leaves_one_polarisation() {
        for eta in [1.33_f32, 1.5, 2.4] {
            let cos = 1.0 / (1.0 + eta * eta).sqrt();
            let root = (1.0 - eta * eta) / (1.0 + eta * eta);
            let expected = 0.5 * root * root;
            assert!((dielectric(cos, eta) - expected).abs() < 1e-6, "eta {eta}");
        }
    }

    #[test]
    fn light_is_reflected_totally_beyond_the_critical_angle() {
        let eta = 1.0 / 1.5_f32;
        let critical = (1.0 - eta * eta).sqrt();
        assert_eq!(dielectric(critical - 1e-4, eta), 1.0);
        assert!(dielectric(critical + 1e-3, eta) < 0.95);
        assert_eq!(dielectric(0.0, 1.5), 1.0);
    }

    /// For light from inside, at the angle to which the light from outside is refracted, a boundary
    /// has the same reflectance as for the light from outside.
    ///
    /// A rounding of `cos_t` by `10⁻⁷` moves the outer cosine by `2·10⁻⁷ / cos`; the slope of `F`
    /// is below 6.
    #[test]
    fn both_sides_reflect_the_same() {
        for i in 1..100 {
            let cos = i as f32 / 100.0;
            let cos_t = (1.0 - (1.0 - cos * cos) / 2.25).sqrt();
            let difference = (dielectric(cos, 1.5) - dielectric(cos_t, 1.0 / 1.5)).abs();
            assert!(difference < 1.2e-6 / cos, "cos {cos}: {difference:e}");
        }
    }

    /// A conductor with `k = 0` reflects like a dielectric; with `η = 1` as well, it reflects
    /// nothing.
    #[test]
    fn a_conductor_without_absorption_is_a_dielectric() {
        for i in 0..=100 {
            let cos = i as f32 / 100.0;
            let metal = conductor(cos, Rgb::gray(1.5), Rgb::BLACK)[1];
            assert!((metal - dielectric(cos, 1.5)).abs() < 2e-6, "cos {cos}");
            let nothing = conductor(cos, Rgb::WHITE, Rgb::BLACK)[1];
            assert!(nothing.is_finite() && (i == 0 || nothing < 1e-6), "cos {cos}: {nothing}");
        }
    }

    /// Silver at 60°, computed with complex arithmetic: `η = 0.05 + 3.5 i`.
    #[test]
    fn conductor_agrees_with_complex_arithmetic() {
        type Complex = (f64, f64);
        let mul = |a: Complex, b: Complex| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
        let norm = |a: Complex| a.0 * a.0 + a.1 * a.1;
        let sqrt = |a: Complex| {
            let r = norm(a).sqrt();
            (((r + a.0) / 2.0).sqrt(), ((r - a.0) / 2.0).sqrt().copysign(a.1))
        };
        for (eta, k) in [(0.05, 3.5), (1.5, 7.0), (4.0, 0.3)] {
            for i in 1..=50 {
                let cos = f64::from(i) / 50.0;
                let index: Complex = (eta, k);
                let index2 = mul(index, index);
                let q = sqrt((index2.0 - (1.0 - cos * cos), index2.1));
                let s = norm((cos - q.0, -q.1)) / norm((cos + q.0, q.1));
                let p = norm((index2.0 * cos - q.0, index2.1 * cos - q.1))
                    / norm((index2.0 * cos + q.0, index2.1 * cos + q.1));
                let got = conductor(cos as f32, Rgb::gray(eta as f32), Rgb::gray(k as f32))[0];
                assert!((f64::from(got) - 0.5 * (s + p)).abs() < 3e-6, "{eta} + {k}i at {cos}");
            }
        }
    }

    #[test]
    fn schlick_meets_its_ends() {
        let f0 = Rgb::new(0.04, 0.5, 0.9);
        assert_eq!(schlick(f0, 1.0_f32), f0.to_array());
        assert_eq!(schlick(f0, 0.0_f32), [1.0; 3]);
    }

    /// The fit agrees with quadrature by the midpoint rule. It uses the variable `√c`, in which the
    /// integrand is smooth at grazing angles.
    #[test]
    fn the_average_fits_quadrature() {
        for step in 0..=80 {
            let x = step as f32 / 80.0;
            let eta = 1.0001 + (5.0 - 1.0001) * x * x * x;
            let n = 4000;
            let integral: f64 = (0..n)
                .map(|i| {
                    let t = (f64::from(i) + 0.5) / f64::from(n);
                    f64::from(dielectric((t * t) as f32, eta)) * 4.0 * t.powi(3)
                })
                .sum::<f64>()
                / f64::from(n);
            let error = (f64::from(dielectric_average(eta)) - integral).abs();
            assert!(error < 2e-5, "eta {eta}: {error:e}");
        }
    }
}
