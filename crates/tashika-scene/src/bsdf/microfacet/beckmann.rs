//! Beckmann's facets: normals whose slopes are normally distributed.
//!
//! With `t = tan²θ_h` of the half vector, roughness `α`, and `a = 1 / (α tan θ)` of a direction:
//!
//! ```text
//! D  = e^(−t/α²) (1 + t)² / (π α²)                                                   (sr⁻¹)
//! G₁ ≈ (3.535 a + 2.181 a²) / (1 + 2.276 a + 2.577 a²)  if a < 1.6, else 1
//! A  = c (1 + erf a) / 2 + α sin θ e^(−a²) / (2 √π)                    visible area, c / G₁ exactly
//! ```
//!
//! (Walter et al. 2007, equations 25 to 27; Heitz 2014, appendix A.) Values use the rational `G₁`,
//! as Mitsuba does: it is within 0.35 % of `c / A`. Densities use `A`, so that they are exactly
//! those of the draws.
//!
//! Visible normals are drawn by their slopes (Heitz and d'Eon 2014, "Importance sampling
//! microfacet-based BSDFs using the distribution of visible normals"). On a surface of `α = 1` the
//! slopes across a direction `(sin θ, cos θ)` are normally distributed, and those along it have the
//! density
//!
//! ```text
//! ∝ (cos θ + x sin θ)⁺ e^(−x²),   its integral up to x:   √π/2 cos θ (erf x + erf a) + ½ sin θ (e^(−a²) − e^(−x²))
//! ```
//!
//! This integral is inverted by Newton's method within an interval that contains the solution. A
//! step that would leave the interval is replaced by its middle.

use std::f32::consts::{FRAC_1_PI, LOG2_E};

use super::HalfVector;
use crate::math::elementary::{erfc, exp_f64, exp2_of};
use crate::math::{Real, Vec3};

/// Value of `t/α²` from which `D` is taken as zero: there it is `10⁻³⁴` of its value at the normal.
const DARK: f32 = 80.0;

/// Value of `a` from which `G₁` is 1: almost nothing is masked.
const UNMASKED: f32 = 1.6;

/// Largest slope considered: `e^(−6²)` is `2·10⁻¹⁶`.
const STEEPEST: f64 = 6.0;

/// Density `D` of normals at `half` (sr⁻¹, per area of the surface).
///
/// * `slopes`: `t` of the exponent, times the squared length of `half` along the normal. For
///   brushed surfaces, the tangential components of `half` in `t` are scaled
///   ([`Microfacets`](super::Microfacets)).
#[inline(always)]
pub(super) fn distribution<R: Real>(half: HalfVector<R>, slopes: R, alpha: f32) -> R {
    let t = half.tangential2 / half.axial2;
    let x = slopes / half.axial2 * R::splat(1.0 / (alpha * alpha));
    let exponential = exp2_of(R::splat(-LOG2_E) * x.min(R::splat(DARK)));
    let root = t + R::splat(1.0);
    let density = exponential * (root * root) * R::splat(FRAC_1_PI / (alpha * alpha));
    R::select(x.le(R::splat(DARK)), density, R::splat(0.0))
}

/// `G₁ G₁ / (4 c_o c_i)`: masking and shadowing, independent, with the Jacobian of the reflection.
///
/// * `spread_o`, `spread_i`: [`spread`] of each direction.
#[inline(always)]
pub(super) fn visibility<R: Real>(cos_o: f32, spread_o: f32, cos_i: R, spread_i: R) -> R {
    R::splat(0.25 * unmasked(cos_o, spread_o) / cos_o) * (unmasked(cos_i, spread_i) / cos_i)
}

/// Spread `α sin θ` of a direction of cosine `cos`.
#[inline(always)]
pub(super) fn spread<R: Real>(cos: R, alpha: f32) -> R {
    let sin2 = (R::splat(1.0) - cos * cos).max(R::splat(f32::MIN_POSITIVE));
    R::splat(alpha) * sin2.sqrt()
}

/// `G₁` at a cosine above zero.
#[inline(always)]
fn unmasked<R: Real>(cos: R, spread: R) -> R {
    let one = R::splat(1.0);
    let a = cos / spread;
    // Limited to the range in which the quotient is used, so that `a` cannot overflow.
    let a = a.min(R::splat(UNMASKED));
    let above = a * (R::splat(3.535) + R::splat(2.181) * a);
    let below = one + a * (R::splat(2.276) + R::splat(2.577) * a);
    (above / below).min(one)
}

/// `A = ∫ (ω·m)⁺ D dm`: projected area of the facets that face a direction of cosine `cos`.
///
/// * `spread`: `α sin θ` of the direction.
#[inline]
pub(super) fn visible_area(cos: f64, spread: f64) -> f32 {
    let a = cos / spread.max(f64::MIN_POSITIVE);
    let slopes = spread * exp_f64(-a * a) / std::f64::consts::PI.sqrt();
    (0.5 * (cos * (2.0 - erfc(a)) + slopes)) as f32
}

/// Draws a normal visible along the unit vector `w` (`z > 0`) on a surface of `α = 1`, not
/// normalised.
pub(super) fn sample_visible_normal(w: Vec3, u: [f32; 2]) -> Vec3 {
    let across = (w.x * w.x + w.y * w.y).sqrt();
    let along = if across > 0.0 { [w.x / across, w.y / across] } else { [1.0, 0.0] };
    let x = slope(f64::from(w.z), f64::from(across), f64::from(u[0]));
    let y = slope(1.0, 0.0, f64::from(u[1]));
    Vec3::new(along[0] * x - along[1] * y, along[1] * x + along[0] * y, 1.0)
}

/// Returns the slope below which the share `u` of the integral of `(cos + x sin)⁺ e^(−x²)` lies.
fn slope(cos: f64, sin: f64, u: f64) -> f32 {
    let root_pi = std::f64::consts::PI.sqrt();
    let mut low = if cos < STEEPEST * sin { -cos / sin } else { -STEEPEST };
    let mut high = STEEPEST;
    let integral = |x: f64| 0.5 * (root_pi * cos * (2.0 - erfc(x)) - sin * exp_f64(-x * x));
    let (first, last) = (integral(low), integral(high));
    let wanted = first + u * (last - first);
    let mut x = 0.0_f64.max(low);
    // 40 steps reach the precision of `f32` even if every step only halves the interval.
    for _ in 0..40 {
        let beyond = integral(x) - wanted;
        if beyond > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let density = (cos + x * sin) * exp_f64(-x * x);
        let newton = x - beyond / density;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        let step = (next - x).abs();
        x = next;
        if step < 1e-9 {
            break;
        }
    }
    x as f32
}
