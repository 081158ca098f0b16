//! Diffuse reflection and a cosine lobe about the mirror direction.
//!
//! ```text
//! f_r = ρ_d / π + ρ_s (n + 2) / (2π) · cosⁿα          (sr⁻¹)
//! ```
//!
//! `α ≤ 90°` is the angle between `ω_i` and the mirror direction of `ω_o`. The factor makes the lobe
//! reflect exactly `ρ_s` at normal incidence, and less elsewhere, where part of it is below the horizon
//! (Lafortune and Willems 1994, "Using the modified Phong reflectance model for physically based
//! rendering"). So `ρ_d + ρ_s ≤ 1` conserves energy. The lobe is drawn with density
//! `(n + 1) / (2π) · cosⁿα`.
//!
//! # Precision
//! `α` enters as `1 − cos α = ‖ω_i − mirror‖² / 2`. From the scalar product, the rounding of `cos α`
//! alone would change the peak of `n = 10⁶` by a tenth. Tested by
//! `phong::sharp_lobes_are_precise` and `bsdf::tests`.

use std::f32::consts::PI;

use super::{Lobe, diffuse_brdf, glossy_probability, mirror_direction, sum_of_lobes, validate};
use crate::color::Rgb;
use crate::math::elementary::{exp, exp_of, ln, ln_of, sin_cos};
use crate::math::simd::each;
use crate::math::{Frame, Real, Vec3};
use crate::warp;

/// Largest exponent. Its lobe is 0.08° wide; beyond, rounding of the directions shows in the value.
const MAX_EXPONENT: f32 = 1e6;

/// Where `exp(−x)`, with any normalisation below 10⁻³², counts as zero if `x` is not smaller: what `exp_of` takes.
const NEGLIGIBLE_POWER: f32 = 87.0;

/// The largest number below 1.
const LARGEST_VERSINE: f32 = 1.0 - f32::EPSILON / 2.0;

/// Diffuse reflection and a cosine lobe about the mirror direction (the modified Phong model).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    /// Reflectance of the diffuse part.
    pub diffuse: Rgb,
    /// Reflectance of the lobe at normal incidence. `diffuse + specular ≤ 1` in each channel.
    pub specular: Rgb,
    /// Exponent `n` in `[0, 10⁶]`. Higher values make the lobe narrower.
    pub exponent: f32,
}

impl Phong {
    #[inline(always)]
    pub(super) fn eval<R: Real>(&self, wo: Vec3, wi: [R; 3]) -> [R; 3] {
        let lobe = self.cosine_power(wo, wi) * R::splat((self.exponent + 2.0) / (2.0 * PI));
        sum_of_lobes(diffuse_brdf(self.diffuse), R::splat(1.0), self.specular, lobe)
    }

    #[inline]
    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let Some(p) = self.lobe_probability() else { return 0.0 };
        let lobe = self.cosine_power(wo, wi.to_array()) * (self.exponent + 1.0) / (2.0 * PI);
        (1.0 - p) * warp::cosine_hemisphere_pdf(wi.z) + p * lobe
    }

    pub(super) fn draw(&self, wo: Vec3, u: [f32; 3]) -> Option<(Vec3, Lobe)> {
        if u[0] >= self.lobe_probability()? {
            return Some((warp::cosine_hemisphere([u[1], u[2]]), Lobe::Diffuse));
        }
        // cos α = (1 − u)^(1/(n+1)), as 1 − cos α so that narrow lobes keep their precision.
        let versine = one_minus_exp(ln_1m(u[1]) / (self.exponent + 1.0));
        let sin = (versine * (2.0 - versine)).max(0.0).sqrt();
        let (sin_phi, cos_phi) = sin_cos(2.0 * PI * u[2]);
        let about_mirror = Vec3::new(sin * cos_phi, sin * sin_phi, 1.0 - versine);
        Some((Frame::about(mirror_direction(wo)).to_world(about_mirror).normalize(), Lobe::Glossy))
    }

    /// `cosⁿα`, zero for `α > 90°`.
    #[inline(always)]
    fn cosine_power<R: Real>(&self, wo: Vec3, wi: [R; 3]) -> R {
        let mirror = mirror_direction(wo).to_array();
        let [x, y, z] = each!(|axis| wi[axis] - R::splat(mirror[axis]));
        let versine = R::splat(0.5) * (x * x + y * y + z * z);
        // Directions behind are evaluated as if they were just in front, which is finite, and left out.
        let within = versine.min(R::splat(LARGEST_VERSINE));
        let power = R::splat(self.exponent) * ln_1m(within);
        let lobe = exp_of(power.max(R::splat(-NEGLIGIBLE_POWER)));
        let above = R::both(versine.le(R::splat(LARGEST_VERSINE)), power.gt(R::splat(-NEGLIGIBLE_POWER)));
        R::select(above, lobe, R::splat(0.0))
    }

    /// Probability of drawing from the lobe; `None` if the surface is black.
    fn lobe_probability(&self) -> Option<f32> {
        glossy_probability(self.specular.max_channel(), self.diffuse.max_channel())
    }

    pub(super) fn validate(&self) -> Result<(), String> {
        validate::fraction("diffuse", self.diffuse)?;
        validate::fraction("specular", self.specular)?;
        validate::fraction_of_sum("(diffuse + specular)", self.diffuse + self.specular)?;
        validate::in_range("exponent", self.exponent, 0.0, MAX_EXPONENT)
    }
}

/// `ln(1 − x)` for `x` in `[0, 1)`, precise for small `x`.
///
/// The rounding of `u = 1 − x` is undone by the factor `x / (1 − u)`, which has the same one
/// (Kahan; Goldberg 1991, "What every computer scientist should know about floating-point arithmetic",
/// theorem 4).
#[inline(always)]
fn ln_1m<R: Real>(x: R) -> R {
    let one = R::splat(1.0);
    let u = one - x;
    let corrected = ln_of(u) * (x / (one - u));
    R::select(one.gt(u), corrected, R::splat(0.0) - x)
}

/// `1 − eˣ` for `x ≤ 0`, precise for small `x` by the same device.
fn one_minus_exp(x: f32) -> f32 {
    let u = exp(x);
    if u == 1.0 { -x } else { (1.0 - u) * (x / ln(u)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lobes of all widths against `cosⁿα` in `f64`, of the very same `f32` directions.
    ///
    /// The exact angle is taken between directions normalised in `f64`. Rounding moves a direction by
    /// at most `√3 · 2⁻²⁵`, so that `n(1 − cos α) ≤ 8` can change by `n sin α · 1e-7 ≈ √(16 n) · 1e-7`.
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
                    let allowed = 1e-5 + 2e-7 * (16.0 * f64::from(exponent)).sqrt();
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
            assert!((f64::from(ln_1m(x)) - exact).abs() <= 4e-7 * exact.abs(), "ln(1 − {x})");
            let exact = -(-f64::from(x) * 3.0).exp_m1();
            assert!((f64::from(one_minus_exp(-3.0 * x)) - exact).abs() <= 4e-7 * exact, "exp(−3 · {x})");
        }
    }

    /// The peak is `ρ_s (n + 2) / 2π` wherever the light comes from.
    #[test]
    fn the_peak_is_normalised() {
        let phong = Phong { diffuse: Rgb::BLACK, specular: Rgb::gray(0.5), exponent: 98.0 };
        let wo = Vec3::new(0.6, 0.0, 0.8);
        let peak = phong.eval(wo, mirror_direction(wo).to_array())[1];
        assert!((peak - 0.5 * 100.0 / (2.0 * PI)).abs() < 1e-5, "{peak}");
    }
}
