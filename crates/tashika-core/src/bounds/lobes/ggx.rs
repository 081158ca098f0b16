//! Upper bounds of the factors of GGX reflection.
//!
//! ```text
//! D  = [ (1 + t) α / (α² + t) ]² / π            t = tan²θ_h; falls with t; largest over α at α = √t      where α ≤ 1
//!    ≤ α² / π                                                                                        where α ≥ 1
//! V  = ½ / (c_o S(c_i) + c_i S(c_o))              correlated by height; falls with α, c_o and c_i
//! V c_i = ½ / (c_o S(c_i) / c_i + S(c_o))         falls with α and c_o, grows with c_i
//! V  = v(c_o) v(c_i), v(c) = 1 / (c + S(c))       independent; v falls with α and c, v c = 1 / (1 + S(c)/c) grows with c
//! ```
//!
//! Here `S(c) = √(α² (1 − c²) + c²)` grows with `α` and `c`, and `S(c) / c = √(α² (1/c² − 1) + 1)`
//! grows with `α` and falls with `c` (Heitz 2014). `D` is a function of the unnormalised half
//! vector: `t = ‖(ω_o + ω_i)_xy‖² / (ω_o + ω_i)_z²`.
//!
//! # Held to this by
//! The tests of [`facets`](super::facets).

use std::f64::consts::FRAC_1_PI;

use crate::bounds::angle::Angle;

/// Upper bound of `D` (sr⁻¹) for all `α` in the range and all half vectors at an angle of at least
/// `least` from the normal.
///
/// The half vector of two directions above the horizon is never beyond `π/2`; there `D` is zero.
pub(super) fn upper_distribution(alphas: [f64; 2], least: Angle) -> f64 {
    if least.cos <= 0.0 {
        return 0.0;
    }
    let tan = least.sin / least.cos;
    let alpha = tan.clamp(alphas[0].min(1.0), alphas[1].min(1.0));
    let mut root = alpha * (1.0 + tan * tan) / (alpha * alpha + tan * tan);
    if alphas[1] > 1.0 {
        root = root.max(alphas[1]);
    }
    root * root * FRAC_1_PI
}

/// Upper bound of the height-correlated `V` for all cosines and roughnesses that are at least the
/// given ones.
pub(super) fn upper_visibility(alpha: f64, cos_o: f64, cos_i: f64) -> f64 {
    0.5 / (cos_o * stretch(cos_i, alpha) + cos_i * stretch(cos_o, alpha))
}

/// Upper bound of `V c_i`, with height-correlated `V`, for cosines of light of at most `cos_i`,
/// which must be positive, and for other quantities that are at least the given ones.
pub(super) fn upper_visibility_cos(alpha: f64, cos_o: f64, cos_i: f64) -> f64 {
    0.5 / (cos_o * stretch(cos_i, alpha) / cos_i + stretch(cos_o, alpha))
}

/// Upper bound of `v` for all cosines and roughnesses that are at least the given ones.
pub(super) fn upper_visible(alpha: f64, cos: f64) -> f64 {
    1.0 / (cos + stretch(cos, alpha))
}

/// `S(c)`.
fn stretch(cos: f64, alpha: f64) -> f64 {
    let cos2 = (cos * cos).min(1.0);
    (alpha * alpha * (1.0 - cos2) + cos2).sqrt()
}
