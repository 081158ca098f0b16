//! GGX facets.
//!
//! With `t = tan²θ_h` of the half vector, roughness `α` and `S(c) = √(α² + (1 − α²) c²)`:
//!
//! ```text
//! D = [ (1 + t) α / (α² + t) ]² / π                                   (sr⁻¹)
//! G₁ = 2c / (c + S(c))
//! G₂ / (4 c_o c_i) = ½ / (c_o S(c_i) + c_i S(c_o))                    correlated by height
//! G₁ G₁ / (4 c_o c_i) = 1 / ((c_o + S(c_o)) (c_i + S(c_i)))           independent
//! ```
//!
//! `D` is the usual `α² / (π (cos²θ_h (α² − 1) + 1)²)` (Walter et al. 2007, equation 33), in a form
//! without cancellation. The correlated `G₂` is equation 99 of Heitz 2014, "Understanding the
//! masking-shadowing function in microfacet-based BRDFs". Visible normals are drawn as in Dupuy and
//! Benyoub 2023, "Sampling visible GGX normals with spherical caps".

use std::f32::consts::{FRAC_1_PI, PI};

use super::HalfVector;
use crate::math::elementary::sin_cos;
use crate::math::{Real, Vec3};

/// Density `D` of normals at `half` (sr⁻¹, per area of the surface).
///
/// * `slopes`: `t` times the squared length of `half` along the normal. For brushed surfaces, the
///   tangential components of `half` in `t` are scaled ([`Microfacets`](super::Microfacets)).
#[inline(always)]
pub(super) fn distribution<R: Real>(half: HalfVector<R>, slopes: R, alpha: f32) -> R {
    let HalfVector { tangential2, axial2 } = half;
    let root = R::splat(alpha) * (tangential2 + axial2) / (R::splat(alpha * alpha) * axial2 + slopes);
    root * root * R::splat(FRAC_1_PI)
}

/// `G₂ / (4 c_o c_i)`, correlated by height: masking and shadowing with the Jacobian of the
/// reflection.
///
/// * `stretch_o`, `stretch_i`: [`stretch`] of each direction.
#[inline(always)]
pub(super) fn visibility<R: Real>(cos_o: f32, stretch_o: R, cos_i: R, stretch_i: R) -> R {
    R::splat(0.5) / (R::splat(cos_o) * stretch_i + cos_i * stretch_o)
}

/// `G₁ G₁ / (4 c_o c_i)`: masking and shadowing, independent, with the Jacobian of the reflection.
#[inline(always)]
pub(in crate::bsdf) fn independent_visibility<R: Real>(
    cos_o: f32,
    stretch_o: f32,
    cos_i: R,
    stretch_i: R,
) -> R {
    R::splat(1.0) / (R::splat(cos_o + stretch_o) * (cos_i + stretch_i))
}

/// `S(c)`: length of a direction of cosine `c` after the surface is stretched to `α = 1`.
#[inline(always)]
pub(in crate::bsdf) fn stretch<R: Real>(cos: R, alpha: f32) -> R {
    let alpha2 = alpha * alpha;
    (R::splat(alpha2) + R::splat(1.0 - alpha2) * cos * cos).sqrt()
}

/// `∫ (ω·m)⁺ D dm = c / G₁`: projected area of the facets that face a direction of cosine `cos`.
#[inline]
pub(super) fn visible_area(cos: f32, stretch: f32) -> f32 {
    0.5 * (cos + stretch)
}

/// Draws a normal visible along the unit vector `w` (`z > 0`) on a surface of `α = 1`, not
/// normalised.
///
/// The facets form a hemisphere. The mirror directions of those visible along `w` fill the
/// spherical cap `z ≥ −w.z` uniformly, and the half vector of `w` and such a direction is the
/// normal.
pub(super) fn sample_visible_normal(w: Vec3, u: [f32; 2]) -> Vec3 {
    // The point on the cap has z = 1 − k with k = (1 + w.z) u. Written with k, no step below
    // subtracts nearly equal numbers.
    let height = 1.0 + w.z;
    let k = height * u[0];
    let sin = (k * (2.0 - k)).max(0.0).sqrt();
    let (sin_phi, cos_phi) = sin_cos(2.0 * PI * u[1]);
    Vec3::new(sin * cos_phi + w.x, sin * sin_phi + w.y, height * (1.0 - u[0]))
}
