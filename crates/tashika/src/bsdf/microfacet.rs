//! The GGX distribution of microfacets: density, masking and shadowing, visible normals.
//!
//! With `t = tan²θ_h` of the half vector, roughness `α` and `S(c) = √(α² + (1 − α²) c²)`:
//!
//! ```text
//! D = [ (1 + t) α / (α² + t) ]² / π                                   (sr⁻¹)
//! G₂ / (4 c_o c_i) = ½ / (c_o S(c_i) + c_i S(c_o))                    height-correlated
//! D_v / (4 ω_o·h) = D / (2 (c_o + S(c_o)))                            density of ω_i (sr⁻¹)
//! ```
//!
//! `D` is the usual `α² / (π (cos²θ_h (α² − 1) + 1)²)` (Walter et al. 2007, equation 33), in a form
//! without cancellation. `G₂` is equation 99 of Heitz 2014, "Understanding the masking-shadowing function
//! in microfacet-based BRDFs". Visible normals are drawn as in Dupuy and Benyoub 2023, "Sampling visible
//! GGX normals with spherical caps".
//!
//! # Precision
//! The half vector is never normalised: its angles come from `ω_o + ω_i` as it is, which cannot be
//! zero for two directions above the horizon. What remains is the rounding of the directions: it turns
//! the half vector by about `10⁻⁷ / 2 ω_o·h`, to be compared with `α`. Hence [`MIN_ALPHA`].
//!
//! # Held to this by
//! The tests below, and the `χ²` tests of `bsdf::tests`.

use std::f32::consts::{FRAC_1_PI, PI};

use crate::math::elementary::sin_cos;
use crate::math::{Real, Vec3};

/// Smallest roughness `α` for which `f32` directions determine the value.
///
/// There, the lobe is 0.06° wide and its peak at normal incidence `D = 1 / (π α²) = 3.2·10⁵` sr⁻¹.
/// Rounding the directions changes values by less than 1 % for cosines above 0.1 and by less than 10 %
/// above 0.01 (test `rounding_is_harmless_down_to_min_alpha`). Smoother surfaces are a
/// [`Mirror`](super::Mirror) or [`Glass`](super::Glass), or are given this value.
pub const MIN_ALPHA: f32 = 1e-3;

/// The half vector of two directions above the horizon, as far as the model needs it, not normalised.
#[derive(Clone, Copy, Debug)]
pub struct HalfVector<R> {
    /// Squared length of the part in the surface.
    pub tangential2: R,
    /// Squared length of the part along the normal.
    pub axial2: R,
}

impl<R: Real> HalfVector<R> {
    /// `ω_o + ω_i` of unit vectors with positive `z`.
    #[inline(always)]
    pub fn between(wo: Vec3, wi: [R; 3]) -> Self {
        let [x, y, z] = [R::splat(wo.x) + wi[0], R::splat(wo.y) + wi[1], R::splat(wo.z) + wi[2]];
        Self { tangential2: x * x + y * y, axial2: z * z }
    }

    /// `ω_o·h = ω_i·h = ‖ω_o + ω_i‖ / 2`, in `[0, 1]`.
    #[inline(always)]
    pub fn cos_incidence(self) -> R {
        (R::splat(0.5) * (self.tangential2 + self.axial2).sqrt()).min(R::splat(1.0))
    }
}

/// The density `D` of microfacet normals at `half` (sr⁻¹, per area of the surface).
#[inline(always)]
pub fn distribution<R: Real>(half: HalfVector<R>, alpha: f32) -> R {
    let HalfVector { tangential2, axial2 } = half;
    let root = R::splat(alpha) * (tangential2 + axial2) / (R::splat(alpha * alpha) * axial2 + tangential2);
    root * root * R::splat(FRAC_1_PI)
}

/// `G₂ / (4 c_o c_i)`: masking and shadowing with the Jacobian of the reflection.
#[inline(always)]
pub fn visibility<R: Real>(cos_o: f32, cos_i: R, alpha: f32) -> R {
    let both = R::splat(cos_o) * stretch(cos_i, alpha) + cos_i * R::splat(stretch(cos_o, alpha));
    R::splat(0.5) / both
}

/// `S(c)`: length of a direction of cosine `c` after stretching the surface to `α = 1`.
#[inline(always)]
fn stretch<R: Real>(cos: R, alpha: f32) -> R {
    let alpha2 = alpha * alpha;
    (R::splat(alpha2) + R::splat(1.0 - alpha2) * cos * cos).sqrt()
}

/// Density (sr⁻¹) of the reflections drawn by [`sample_reflection`].
#[inline]
pub fn reflection_pdf(cos_o: f32, half: HalfVector<f32>, alpha: f32) -> f32 {
    distribution(half, alpha) / (2.0 * (cos_o + stretch(cos_o, alpha)))
}

/// Reflects `wo` (`z > 0`) at a microfacet drawn from those that it sees.
///
/// The result may lie below the horizon; such paths end in the single-scattering model.
pub fn sample_reflection(wo: Vec3, alpha: f32, u: [f32; 2]) -> Vec3 {
    let h = sample_visible_normal(wo, alpha, u);
    (h * (2.0 * wo.dot(h)) - wo).normalize()
}

/// Draws a normal with density `D_v(h) = G₁(ω_o) (ω_o·h)⁺ D(h) / c_o`.
///
/// After stretching the surface to `α = 1` its facets are a hemisphere; the mirror directions of those
/// that `w` sees fill the spherical cap `z ≥ −w.z` uniformly, and the half vector leads back.
pub fn sample_visible_normal(wo: Vec3, alpha: f32, u: [f32; 2]) -> Vec3 {
    let w = Vec3::new(alpha * wo.x, alpha * wo.y, wo.z).normalize();
    // With k = (1 + w.z) u: z = 1 − k is the point on the cap, and nothing below cancels.
    let height = 1.0 + w.z;
    let k = height * u[0];
    let sin = (k * (2.0 - k)).max(0.0).sqrt();
    let (sin_phi, cos_phi) = sin_cos(2.0 * PI * u[1]);
    Vec3::new(alpha * (sin * cos_phi + w.x), alpha * (sin * sin_phi + w.y), height * (1.0 - u[0])).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    const ALPHAS: [f32; 5] = [MIN_ALPHA, 0.01, 0.1, 0.5, 1.0];

    /// Sums `f(tan²θ, cos θ)` times `2π sin θ dθ`, with `tan θ = α x / (1 − x)` so that all widths work.
    fn integrate_normals(alpha: f32, f: impl Fn(f64, f64) -> f64) -> f64 {
        let n = 20_000;
        let alpha = f64::from(alpha);
        (0..n)
            .map(|i| {
                let x = (f64::from(i) + 0.5) / f64::from(n);
                let tan = alpha * x / (1.0 - x);
                let cos = 1.0 / (1.0 + tan * tan).sqrt();
                let dtheta = cos * cos * alpha / (1.0 - x).powi(2) / f64::from(n);
                f(tan * tan, cos) * 2.0 * std::f64::consts::PI * tan * cos * dtheta
            })
            .sum()
    }

    /// `D` at `tan²θ_h = tan2`.
    fn density(tan2: f64, alpha: f32) -> f64 {
        f64::from(distribution(HalfVector { tangential2: tan2 as f32, axial2: 1.0 }, alpha))
    }

    #[test]
    fn the_projected_area_of_all_facets_is_one() {
        for alpha in ALPHAS {
            let area = integrate_normals(alpha, |t, cos| density(t, alpha) * cos);
            assert!((area - 1.0).abs() < 1e-5, "alpha {alpha}: {area}");
        }
    }

    /// `∫ G₁ (ω_o·h)⁺ D dh = c_o`: the visible facets cover exactly what is seen (Heitz 2014).
    #[test]
    fn visible_facets_cover_the_projected_surface() {
        for alpha in ALPHAS {
            for cos_o in [1.0_f64, 0.7, 0.2, 0.02] {
                let sin_o = (1.0 - cos_o * cos_o).sqrt();
                // ∫ (ω_o·h)⁺ dφ / 2π in closed form.
                let facing = |t: f64, cos: f64| {
                    let (a, b) = (cos_o * cos, sin_o * cos * t.sqrt());
                    if a >= b {
                        return a;
                    }
                    let phi = (-a / b).acos();
                    (a * phi + b * phi.sin()) / std::f64::consts::PI
                };
                let seen = integrate_normals(alpha, |t, cos| density(t, alpha) * facing(t, cos));
                let g1 = 2.0 * cos_o / (cos_o + f64::from(stretch(cos_o as f32, alpha)));
                assert!((g1 * seen / cos_o - 1.0).abs() < 2e-5, "alpha {alpha}, cos {cos_o}: {}", g1 * seen);
            }
        }
    }

    /// Random pairs near the lobe against the textbook formula, of the unrounded directions, in `f64`.
    #[test]
    fn rounding_is_harmless_down_to_min_alpha() {
        let mut stream = Stream::new(5, Purpose::Test, 0);
        for (cos_o, allowed) in [(1.0_f64, 1e-3), (0.5, 3e-3), (0.1, 0.01), (0.01, 0.1)] {
            let mut worst = 0.0_f64;
            for _ in 0..20_000 {
                let sin_o = (1.0 - cos_o * cos_o).sqrt();
                let phi = 6.3 * stream.uniform_f64();
                let wo = glam::DVec3::new(sin_o * phi.cos(), sin_o * phi.sin(), cos_o);
                let tan = f64::from(MIN_ALPHA) * 3.0 * stream.uniform_f64();
                let psi = 6.3 * stream.uniform_f64();
                let h = glam::DVec3::new(tan * psi.cos(), tan * psi.sin(), 1.0).normalize();
                let wi = h * (2.0 * wo.dot(h)) - wo;
                if wi.z < 0.5 * cos_o {
                    continue;
                }
                let a2 = f64::from(MIN_ALPHA).powi(2);
                let exact = a2 / (std::f64::consts::PI * (h.z * h.z * (a2 - 1.0) + 1.0).powi(2));
                let half = HalfVector::between(wo.as_vec3(), wi.as_vec3().to_array());
                let got = f64::from(distribution(half, MIN_ALPHA));
                worst = worst.max((got / exact - 1.0).abs());
                assert!((f64::from(half.cos_incidence()) - wo.dot(h)).abs() < 2e-7);
            }
            assert!(worst < allowed, "cos {cos_o}: {worst:e}");
        }
    }

    /// `G₂ / 4 c_o c_i` against `1 / (1 + Λ_o + Λ_i)` with `Λ = (√(1 + α² tan²θ) − 1) / 2`.
    #[test]
    fn visibility_is_height_correlated_smith() {
        for alpha in ALPHAS {
            for (cos_o, cos_i) in [(1.0_f64, 1.0_f64), (0.9, 0.3), (0.2, 0.05), (0.01, 0.8)] {
                let lambda =
                    |c: f64| ((1.0 + f64::from(alpha).powi(2) * (1.0 / (c * c) - 1.0)).sqrt() - 1.0) / 2.0;
                let exact = 1.0 / (1.0 + lambda(cos_o) + lambda(cos_i)) / (4.0 * cos_o * cos_i);
                let got = f64::from(visibility(cos_o as f32, cos_i as f32, alpha));
                assert!((got / exact - 1.0).abs() < 1e-5, "alpha {alpha}: {got} against {exact}");
            }
        }
    }
}
