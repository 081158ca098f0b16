//! Upper bounds of the factors of reflection at Beckmann facets.
//!
//! ```text
//! D = e^(−t/α²) (1 + t)² / (π α²)        t = tan²θ_h; falls with t from 2α² − 1 on; largest over α at α = √t
//! V = v(c_o) v(c_i), v(c) = G₁(c) / 2c    v falls with α and c, v c = G₁/2 grows with c
//! ```
//!
//! The derivatives of `D` are `∂ ln D/∂t = 2/(1 + t) − 1/α²` and `∂ ln D/∂α = 2 (t/α² − 1)/α`. If
//! `D` is largest off the normal, at `t = 2α² − 1`, then this maximum falls with `α`:
//! `∂/∂α (1/α² + 2 ln 2α) = 2 (1 − 1/α²)/α ≤ 0`. `G₁` is the rational function of
//! [`bsdf::microfacet`](crate::bsdf::microfacet).
//!
//! # Held to this by
//! The tests of [`facets`](super::facets).

use std::f64::consts::FRAC_1_PI;

use crate::bounds::angle::Angle;
use crate::math::elementary::exp_f64;

/// Least ratio of `t/α²` as computed in `f32` to its exact value. It covers three roundings and
/// those of `t`, which is a quotient of sums of squares.
const ROUNDED: f64 = 1.0 - 2e-6;

/// Upper bound of `D` (sr⁻¹) for all `α` in the range and all half vectors at an angle of at least
/// `least` from the normal.
///
/// The half vector of two directions above the horizon is never beyond `π/2`; there `D` is zero.
pub(super) fn upper_distribution(alphas: [f64; 2], least: Angle) -> f64 {
    if least.cos <= 0.0 {
        return 0.0;
    }
    let tan = least.sin / least.cos;
    let alpha = tan.clamp(alphas[0], alphas[1]);
    let alpha2 = alpha * alpha;
    let t = (tan * tan).max(2.0 * alpha2 - 1.0);
    exp_f64(-ROUNDED * t / alpha2) * (1.0 + t) * (1.0 + t) * FRAC_1_PI / alpha2
}

/// Upper bound of `v` for all cosines and roughnesses that are at least the given ones.
pub(super) fn upper_visible(alpha: f64, cos: f64) -> f64 {
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let a = cos / (alpha * sin).max(f64::MIN_POSITIVE);
    let rational = |a: f64| a * (3.535 + 2.181 * a) / (1.0 + a * (2.276 + 2.577 * a));
    0.5 * rational(a.min(1.6)).min(1.0) / cos
}
