//! Position index of Guth: by how much a glare source may be brighter than one on the line of
//! sight.
//!
//! ```text
//! above    p = e^{(35.2 − 0.31889 τ − 1.22 e^(−2τ/9)) 10⁻³ σ + (21 + 0.26667 τ − 0.002963 τ²) 10⁻⁵ σ²}
//! below    p = e^{6.49·10⁻³ β + 21·10⁻⁵ β²}           tan β = tan σ √(1 + 0.3225 cos² τ)
//! ```
//!
//! `σ` is the angle of the source from the line of sight, and `τ` the angle at the line of sight
//! between the planes of the source and of the vertical (both in degrees). Above the line of sight
//! the formula is the fit of Levin 1975 to the indices of Luckiesh and Guth 1949; below, it is the
//! fit to those of Iwata and Tokura 1997 in the form that Radiance's `evalglare` 3.02 adopted. Both
//! are limited to 16.
//!
//! # Held to this by
//! The tests below.

use crate::math::DVec3;
use crate::math::elementary::{atan2_f64, exp_f64};

/// Largest index.
const MOST: f64 = 16.0;

/// Returns the position index of a unit direction: line of sight `−z`, up `+y`.
pub fn position_index(direction: DVec3) -> f64 {
    let across = (direction.x * direction.x + direction.y * direction.y).sqrt();
    if across == 0.0 {
        return 1.0;
    }
    let sigma = atan2_f64(across, -direction.z).to_degrees();
    if direction.y < 0.0 {
        let cos_tau = direction.y / across;
        let wider = (1.0 + 0.3225 * cos_tau * cos_tau).sqrt();
        let beta = atan2_f64(across * wider, -direction.z).to_degrees();
        return exp_f64(6.49e-3 * beta + 21e-5 * beta * beta).min(MOST);
    }
    let tau = atan2_f64(direction.x.abs(), direction.y).to_degrees();
    let linear = (35.2 - 0.31889 * tau - 1.22 * exp_f64(-2.0 * tau / 9.0)) * 1e-3;
    let squared = (21.0 + 0.26667 * tau - 0.002963 * tau * tau) * 1e-5;
    exp_f64(linear * sigma + squared * sigma * sigma).min(MOST)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary::sin_cos_f64;

    /// Direction at an angle from the line of sight, in a plane turned from the vertical.
    fn at(sigma: f64, tau: f64) -> DVec3 {
        let [(sin, cos), (across, up)] = [sigma, tau].map(|degrees| sin_cos_f64(degrees.to_radians()));
        DVec3::new(sin * across, sin * up, -cos)
    }

    /// Values worked out by hand. Upwards 30°, `τ = 0`: `(35.2 − 1.22) 10⁻³ · 30 + 21·10⁻⁵ · 900 =
    /// 1.2084`. Sideways 30°, `τ = 90`: `(35.2 − 28.7001 − 2.5·10⁻⁹) 10⁻³ · 30 + (21 + 24.0003 −
    /// 24.0003) 10⁻⁵ · 900 = 0.384`. Downwards 30°: `tan β = 0.57735 · 1.15 = 0.66395`, `β =
    /// 33.583°`, exponent 0.45479. Almost sideways from both sides the fits agree to 0.1 %.
    #[test]
    fn indices_are_those_of_the_formulas() {
        for (sigma, tau, expected) in [
            (30.0, 0.0, 3.3481),
            (30.0, 90.0, 1.46814),
            (30.0, 180.0, 1.57583),
            (0.0, 0.0, 1.0),
            (80.0, 0.0, 16.0),
        ] {
            let found = position_index(at(sigma, tau));
            assert!((found / expected - 1.0).abs() < 1e-3, "{sigma} {tau}: {found}");
        }
        let [above, below] = [89.999, 90.001].map(|tau| position_index(at(40.0, tau)));
        assert!((above / below - 1.0).abs() < 1e-3, "{above} {below}");
        assert!((position_index(at(25.0, 60.0)) - position_index(at(25.0, -60.0))).abs() < 1e-12);
        assert!(position_index(DVec3::new(0.0, 1.0, 0.0)) <= 16.0 && position_index(at(90.0, 180.0)) <= 16.0);
    }
}
