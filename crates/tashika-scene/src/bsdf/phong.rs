//! Diffuse reflection and a cosine lobe around the mirror direction.
//!
//! ```text
//! f_r = ρ_d / π + ρ_s (n + 2) / (2π) · cosⁿα          (sr⁻¹)
//! ```
//!
//! `α ≤ 90°` is the angle between `ω_i` and the mirror direction of `ω_o`. With the factor
//! `(n + 2) / (2π)` the lobe reflects exactly `ρ_s` at normal incidence. Elsewhere it reflects
//! less, since part of it is below the horizon (Lafortune and Willems 1994, "Using the modified
//! Phong reflectance model for physically based rendering"). So `ρ_d + ρ_s ≤ 1` conserves energy.
//! Directions of the lobe are drawn with density `(n + 1) / (2π) · cosⁿα`.
//!
//! # Precision
//! `1 − cos α` is computed as `‖ω_i − mirror‖² / 2`. If `cos α` were computed as a scalar product,
//! its rounding alone would change the peak of the lobe of `n = 10⁶` by a tenth.
//!
//! For a given `1 − cos α`, `cosⁿα` is computed as `2^(n log₂ cos α)` with a relative error of at
//! most `5·10⁻⁷ (1 + |ln cosⁿα|)`. Whole and half exponents up to 128 use products instead: the
//! rounding of `cos α` and of at most `n − 1` products amounts to at most `2n u = 1.6·10⁻⁵` of the
//! value. Powers by the logarithm that are below 2⁻¹²⁵ are replaced by zero.
//!
//! # Held to this by
//! `phong::tests::sharp_lobes_are_precise`, `phong::tests::powers_are_precise` and `bsdf::tests`.

use std::f32::consts::PI;

use super::{Lobe, Model, diffuse_brdf, glossy_probability, mirror_direction, sum_of_lobes, validate};
use crate::color::Rgb;
use crate::math::elementary::{exp, exp2_of, ln, log2_1m_of, sin_cos};
use crate::math::simd::each;
use crate::math::{Frame, Real, Vec3};
use crate::warp;

/// Largest exponent. Its lobe is 0.08° wide; for larger exponents, the rounding of directions
/// changes values visibly.
const MAX_EXPONENT: f32 = 1e6;

/// Smallest `x` for which `2⁻ˣ` counts as zero: the limit of `exp2_of`. For any exponent, the
/// omitted value, normalisation included, is below 10⁻³².
const NEGLIGIBLE_POWER: f32 = 125.0;

/// Largest whole or half exponent for which powers are products. With a higher limit, fewer
/// exponents need logarithms, but the rounding grows in proportion to the limit. The bounds of
/// lobes include a margin for it.
const MOST_PRODUCTS: f32 = 128.0;

/// The largest number below 1.
const LARGEST_VERSINE: f32 = 1.0 - f32::EPSILON / 2.0;

/// Diffuse reflection and a cosine lobe around the mirror direction (the modified Phong model).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    /// Reflectance of the diffuse part.
    pub diffuse: Rgb,
    /// Reflectance of the lobe at normal incidence. `diffuse + specular ≤ 1` in each channel.
    pub specular: Rgb,
    /// Exponent `n` in `[0, 10⁶]`. Higher values make the lobe narrower.
    pub exponent: f32,
}

impl Model for Phong {
    #[inline(always)]
    fn eval<R: Real>(&self, wo: Vec3, wi: [R; 3]) -> [R; 3] {
        let lobe = self.cosine_power(wo, wi) * R::splat((self.exponent + 2.0) / (2.0 * PI));
        sum_of_lobes(diffuse_brdf(self.diffuse), R::splat(1.0), self.specular, lobe)
    }

    #[inline]
    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let Some(p) = self.lobe_probability() else { return 0.0 };
        let lobe = self.cosine_power(wo, wi.to_array()) * (self.exponent + 1.0) / (2.0 * PI);
        (1.0 - p) * warp::cosine_hemisphere_pdf(wi.z) + p * lobe
    }

    fn draw(&self, wo: Vec3, u: [f32; 3]) -> Option<(Vec3, Lobe)> {
        if u[0] >= self.lobe_probability()? {
            return Some((warp::cosine_hemisphere([u[1], u[2]]), Lobe::Diffuse));
        }
        // cos α = (1 − u)^(1/(n+1)), computed as 1 − cos α so that narrow lobes keep their
        // precision.
        let versine = one_minus_exp(ln_1m(u[1]) / (self.exponent + 1.0));
        let sin = (versine * (2.0 - versine)).max(0.0).sqrt();
        let (sin_phi, cos_phi) = sin_cos(2.0 * PI * u[2]);
        let about_mirror = Vec3::new(sin * cos_phi, sin * sin_phi, 1.0 - versine);
        Some((Frame::about(mirror_direction(wo)).to_world(about_mirror).normalize(), Lobe::Glossy))
    }

    fn vpl_reflectance(&self, _: Vec3) -> Rgb {
        self.diffuse
    }

    fn scale_diffuse(&mut self, factor: f32) {
        self.diffuse *= factor;
    }

    fn importance_gloss(&self, _: Vec3) -> f32 {
        self.specular.max_channel()
    }

    fn roughness(&self) -> Option<f32> {
        (!self.specular.is_black()).then(|| (2.0 / (self.exponent + 2.0)).sqrt())
    }

    fn albedo(&self) -> Rgb {
        self.diffuse + self.specular
    }

    fn validate(&self) -> Result<(), String> {
        validate::fraction("diffuse", self.diffuse)?;
        validate::fraction("specular", self.specular)?;
        validate::fraction_of_sum("(diffuse + specular)", self.diffuse + self.specular)?;
        validate::in_range("exponent", self.exponent, 0.0, MAX_EXPONENT)
    }
}

impl Phong {
    /// `cosⁿα`, zero for `α > 90°`.
    #[inline(always)]
    fn cosine_power<R: Real>(&self, wo: Vec3, wi: [R; 3]) -> R {
        let mirror = mirror_direction(wo).to_array();
        let [x, y, z] = each!(|axis| wi[axis] - R::splat(mirror[axis]));
        let versine = R::splat(0.5) * (x * x + y * y + z * z);
        let above = versine.le(R::splat(LARGEST_VERSINE));
        // Directions at more than 90° are evaluated as if they were at slightly less, so that the
        // power is finite. Their values are then replaced by zero.
        let within = versine.min(R::splat(LARGEST_VERSINE));
        R::select(above, power_1m(within, self.exponent), R::splat(0.0))
    }

    /// Probability of drawing from the lobe; `None` if the surface is black.
    fn lobe_probability(&self) -> Option<f32> {
        glossy_probability(self.specular.max_channel(), self.diffuse.max_channel())
    }
}

/// `(1 − x)ⁿ` for `x` in `[0, 1)`.
#[inline(always)]
fn power_1m<R: Real>(x: R, n: f32) -> R {
    let twice = n + n;
    if n <= MOST_PRODUCTS && twice == twice.trunc() {
        return product_of(R::splat(1.0) - x, twice as u32);
    }
    let power = R::splat(n) * log2_1m_of(x);
    let value = exp2_of(power.max(R::splat(-NEGLIGIBLE_POWER)));
    R::select(power.gt(R::splat(-NEGLIGIBLE_POWER)), value, R::splat(0.0))
}

/// `x^(n / 2)` for `x` in `[0, 1]`, by squaring.
#[inline(always)]
fn product_of<R: Real>(x: R, n: u32) -> R {
    let mut product = if n & 1 != 0 { x.sqrt() } else { R::splat(1.0) };
    let (mut square, mut rest) = (x, n >> 1);
    while rest != 0 {
        if rest & 1 != 0 {
            product = product * square;
        }
        square = square * square;
        rest >>= 1;
    }
    product
}

/// `ln(1 − x)` for `x` in `[0, 1)`, precise for small `x`.
fn ln_1m(x: f32) -> f32 {
    log2_1m_of(x) * std::f32::consts::LN_2
}

/// `1 − eˣ` for `x ≤ 0`, precise for small `x`.
///
/// The rounding of `u = eˣ` is cancelled by the factor `x / ln u`, which contains the same rounding
/// (Kahan; Goldberg 1991, "What every computer scientist should know about floating-point
/// arithmetic", theorem 4).
fn one_minus_exp(x: f32) -> f32 {
    let u = exp(x);
    if u == 1.0 { -x } else { (1.0 - u) * (x / ln(u)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For lobes of all widths, values agree with `cosⁿα` in `f64` for the same `f32` directions.
    ///
    /// The exact angle is taken between directions normalised in `f64`. Rounding moves a direction
    /// by at most `√3 · 2⁻²⁵`. It can therefore change `n(1 − cos α)`, which is at most 8 here, by
    /// `n sin α · 1e-7 ≈ √(16 n) · 1e-7`.
    #[test]
    fn sharp_lobes_are_precise() {
        for exponent in [0.0_f32, 1.0, 10.0, 1e3, 1e5, 1e6] {
            let phong = Phong { diffuse: Rgb::BLACK, specular: Rgb::WHITE, exponent };
            for step in 0..50 {
                let angle = (f64::from(step) / 50.0) * (16.0 / f64::from(exponent + 1.0)).sqrt().min(1.5);
                for tilt in [0.0, 0.7, 1.3] {
                    let wo = Vec3::new(-tilt_sin(tilt), 0.0, tilt_cos(tilt));
                    let wi = Vec3::new(tilt_sin(tilt - angle), 0.0, tilt_cos(tilt - angle));
                    let (a, b) = (mirror_direction(wo).as_dvec3().normalize(), wi.as_dvec3().normalize());
                    let exact = ((-(b - a).length_squared() / 2.0).ln_1p() * f64::from(exponent)).exp();
                    let error = (f64::from(phong.cosine_power(wo, wi.to_array())) - exact).abs() / exact;
                    let allowed = 1.6e-5 + 2e-7 * (16.0 * f64::from(exponent)).sqrt();
                    assert!(error < allowed, "n = {exponent}, angle {angle}: {error:e}");
                }
            }
        }
    }

    fn tilt_sin(angle: f64) -> f32 {
        angle.sin() as f32
    }

    fn tilt_cos(angle: f64) -> f32 {
        angle.cos() as f32
    }

    #[test]
    fn small_arguments_keep_their_precision() {
        for x in [0.0_f32, 1e-9, 3e-8, 1e-4, 0.3, 0.9, 1.0 - f32::EPSILON / 2.0] {
            let exact = (-f64::from(x)).ln_1p();
            assert!((f64::from(ln_1m(x)) - exact).abs() <= 7e-7 * exact.abs(), "ln(1 − {x})");
            let exact = -(-f64::from(x) * 3.0).exp_m1();
            assert!((f64::from(one_minus_exp(-3.0 * x)) - exact).abs() <= 4e-7 * exact, "exp(−3 · {x})");
        }
    }

    /// Both forms of the power, products and `2^(n log₂ cos α)`, agree with `f64` to within the
    /// errors that the module states.
    #[test]
    fn powers_are_precise() {
        let exponents =
            [0.0_f32, 0.3, 0.5, 1.0, 2.5, 31.0, 63.5, 127.5, 128.0, 128.5, 90.1, 1e3, 77_777.7, 1e6];
        for n in exponents {
            let products = n <= 128.0 && (2.0 * n).fract() == 0.0;
            for step in 0..20_000 {
                // Limited to values above e⁻⁶⁰.
                let x = (step as f32 / 20_000.0).powi(3) * (60.0 / n).min(LARGEST_VERSINE);
                let log = f64::from(n) * (-f64::from(x)).ln_1p();
                if log < -60.0 {
                    break;
                }
                let error = (f64::from(power_1m(x, n)) / log.exp() - 1.0).abs();
                let allowed =
                    if products { f64::from(n + 1.0) * 2.0_f64.powi(-23) } else { 5e-7 * (1.0 + log.abs()) };
                assert!(error <= allowed, "(1 − {x})^{n}: off by {error:e} of {allowed:e}");
            }
        }
        assert_eq!(power_1m(0.9_f32, 1e3), 0.0);
        assert_eq!(power_1m(LARGEST_VERSINE, 0.5), (f32::EPSILON / 2.0).sqrt());
    }

    /// At more than 90° from the mirror direction the lobe is zero for every exponent.
    #[test]
    fn lobes_end_at_a_right_angle() {
        let wo = Vec3::new(0.8, 0.0, 0.6);
        for exponent in [0.0, 0.5, 1.0, 7.3, 128.0, 1e6] {
            let phong = Phong { diffuse: Rgb::BLACK, specular: Rgb::WHITE, exponent };
            assert_eq!(phong.cosine_power(wo, [0.8, 0.0, 0.6_f32]), 0.0, "{exponent}");
            assert!(phong.cosine_power(wo, [-0.8, 0.0, 0.6_f32]) == 1.0, "{exponent}");
        }
    }

    /// The value in the mirror direction is `ρ_s (n + 2) / 2π`.
    #[test]
    fn the_peak_is_normalised() {
        let phong = Phong { diffuse: Rgb::BLACK, specular: Rgb::gray(0.5), exponent: 98.0 };
        let wo = Vec3::new(0.6, 0.0, 0.8);
        let peak = phong.eval(wo, mirror_direction(wo).to_array())[1];
        assert!((peak - 0.5 * 100.0 / (2.0 * PI)).abs() < 1e-5, "{peak}");
    }
}
