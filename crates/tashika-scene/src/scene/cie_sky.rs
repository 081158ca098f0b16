//! Skies of the trade: the sixteen relative luminance distributions of ISO 15469:2004 (CIE S 011),
//! scaled to a horizontal illuminance.
//!
//! ```text
//! L(Z, χ) / L_z = f(χ) φ(Z) / (f(Z_s) φ(0))
//! φ(Z) = 1 + a e^(b / cos Z)        f(χ) = 1 + c (e^(d χ) − e^(d π/2)) + e cos² χ
//! type 16:  L(Z) / L_z = (1 + 2 cos Z) / 3                            the overcast sky of 1955
//! ```
//!
//! `Z` is the angle of a direction from the zenith, `χ` its angle from the sun, and `Z_s` the angle
//! of the sun from the zenith. The coefficients `a … e` are those of table 1 of the standard
//! (Darula and Kittler 2002). The sky is grey. The ground is a horizontal diffuse plane that
//! reflects the share `ρ` of the horizontal illuminance `E`: its luminance is `ρ E / π` in all
//! directions below the horizon. The sun itself is not included.
//!
//! Units: `E` in the unit of the scene times sr, so that an `E` in lux gives luminances in cd·m⁻².
//! Frame: `+y` is up.
//!
//! # Held to this by
//! The tests below: integrals, the ratio of horizon to zenith, and published values.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec3, Vec3};

use super::Image;
use super::hemisphere::{hemispherical_irradiance, sky_image};
use crate::math::elementary::{atan2_f64, exp_f64};

/// Rows of the standard's table: `a … e` by type, from type 1.
const COEFFICIENTS: [[f64; 5]; 15] = [
    [4.0, -0.70, 0.0, -1.0, 0.00],
    [4.0, -0.70, 2.0, -1.5, 0.15],
    [1.1, -0.80, 0.0, -1.0, 0.00],
    [1.1, -0.80, 2.0, -1.5, 0.15],
    [0.0, -1.00, 0.0, -1.0, 0.00],
    [0.0, -1.00, 2.0, -1.5, 0.15],
    [0.0, -1.00, 5.0, -2.5, 0.30],
    [0.0, -1.00, 10.0, -3.0, 0.45],
    [-1.0, -0.55, 2.0, -1.5, 0.15],
    [-1.0, -0.55, 5.0, -2.5, 0.30],
    [-1.0, -0.55, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 16.0, -3.0, 0.30],
    [-1.0, -0.15, 16.0, -3.0, 0.30],
    [-1.0, -0.15, 24.0, -2.8, 0.15],
];

/// Smallest cosine from the zenith at which the gradation is evaluated.
const MIN_COSINE: f64 = 1e-3;

/// A sky of ISO 15469 with its ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CieSky {
    kind: u32,
    to_sun: DVec3,
    /// Luminance over relative luminance.
    scale: f64,
    /// Luminance of directions below the horizon.
    ground: f64,
}

impl CieSky {
    /// Number of the overcast sky of 1955, whose zenith is three times as bright as its horizon.
    pub const OVERCAST: u32 = 16;
    /// Number of the uniform sky.
    pub const UNIFORM: u32 = 5;
    /// Number of the clear sky of low turbidity.
    pub const CLEAR: u32 = 12;

    /// Creates a sky.
    ///
    /// * `kind`: type, 1 to 16; other numbers are clamped to this range.
    /// * `to_sun`: unit direction to the sun, without effect for types that have no sun.
    /// * `illuminance`: horizontal illuminance `E` by the sky.
    /// * `reflectance`: reflectance `ρ` of the ground, 0 to 1.
    pub fn new(kind: u32, to_sun: Vec3, illuminance: f64, reflectance: f64) -> Self {
        let ground = reflectance * illuminance / PI;
        let sky = Self { kind: kind.clamp(1, Self::OVERCAST), to_sun: to_sun.as_dvec3(), scale: 1.0, ground };
        Self { scale: illuminance / sky.horizontal(), ..sky }
    }

    /// Returns true if the luminance of the type depends on the position of the sun.
    pub fn has_sun(kind: u32) -> bool {
        kind < Self::OVERCAST && COEFFICIENTS[kind.max(1) as usize - 1][2] > 0.0
    }

    /// Luminance in a unit direction.
    pub fn luminance(&self, direction: DVec3) -> f64 {
        if direction.y < 0.0 { self.ground } else { self.scale * self.relative(direction) }
    }

    /// Luminance of a direction above the horizon, relative to that of the zenith times `f(Z_s)
    /// φ(0)`.
    fn relative(&self, direction: DVec3) -> f64 {
        if self.kind == Self::OVERCAST {
            return (1.0 + 2.0 * direction.y) / 3.0;
        }
        let [a, b, c, d, e] = COEFFICIENTS[self.kind as usize - 1];
        let gradation = 1.0 + a * exp_f64(b / direction.y.max(MIN_COSINE));
        let cos = direction.dot(self.to_sun).clamp(-1.0, 1.0);
        let angle = atan2_f64(direction.cross(self.to_sun).length(), cos);
        let indicatrix = 1.0 + c * (exp_f64(d * angle) - exp_f64(d * FRAC_PI_2)) + e * cos * cos;
        gradation * indicatrix
    }

    /// Illuminance of an unobstructed horizontal plane, at the present scale.
    fn horizontal(&self) -> f64 {
        hemispherical_irradiance(DVec3::Y, |direction| [self.luminance(direction)])[0]
    }

    /// Image of the sky and its ground, as that of [`Sky::image`](super::sky::Sky::image).
    pub fn image(&self, width: u32, height: u32) -> Image {
        sky_image(width, height, |direction| [self.luminance(direction) as f32; 3])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary::sin_cos_f64;

    /// Direction at an angle from the zenith, towards `+x`.
    fn towards(degrees: f64) -> DVec3 {
        let (sin, cos) = sin_cos_f64(degrees.to_radians());
        DVec3::new(sin, cos, 0.0)
    }

    fn sky(kind: u32, sun_zenith: f64) -> CieSky {
        CieSky::new(kind, towards(sun_zenith).as_vec3(), 10_000.0, 0.2)
    }

    /// Every type has the requested horizontal illuminance, is positive, and has a grey ground.
    #[test]
    fn every_sky_has_its_illuminance() {
        for kind in 1..=16 {
            for zenith in [0.0, 40.0, 85.0] {
                let sky = sky(kind, zenith);
                assert!((sky.horizontal() / 10_000.0 - 1.0).abs() < 1e-12, "{kind}");
                for degrees in [-89.9, -45.0, 0.0, 30.0, 89.9] {
                    let luminance = sky.luminance(towards(degrees));
                    assert!(luminance > 0.0 && luminance.is_finite(), "{kind} {degrees}: {luminance}");
                }
                assert_eq!(sky.luminance(DVec3::NEG_Y), 2000.0 / PI);
            }
        }
    }

    /// Zenith luminances over horizontal illuminance in closed form: `9/(7π)` for the overcast sky,
    /// `1/π` for the uniform sky. The overcast horizon is a third of the zenith.
    #[test]
    fn overcast_and_uniform_skies_have_their_closed_forms() {
        let overcast = sky(CieSky::OVERCAST, 0.0);
        let zenith = overcast.luminance(DVec3::Y);
        assert!((zenith / 10_000.0 - 9.0 / (7.0 * PI)).abs() < 1e-5, "{zenith}");
        assert!((overcast.luminance(towards(90.0)) / zenith - 1.0 / 3.0).abs() < 1e-9);
        assert!((sky(CieSky::UNIFORM, 30.0).luminance(towards(50.0)) / 10_000.0 - 1.0 / PI).abs() < 1e-9);
    }

    /// Ratios worked out by hand from the formulas of the standard: type 1 at the horizon,
    /// `1 / (1 + 4 e^(−0.7))`; type 12 at the sun, 40° from the zenith, over the zenith; type 3 at
    /// 60° from the zenith, `(1 + 1.1 e^(−1.6)) / (1 + 1.1 e^(−0.8))`.
    #[test]
    fn luminances_are_those_of_the_standard() {
        let ratio = |kind: u32, degrees: f64| {
            let sky = sky(kind, 40.0);
            sky.luminance(towards(degrees)) / sky.luminance(DVec3::Y)
        };
        assert!((ratio(1, 90.0) - 0.334_858).abs() < 1e-3, "{}", ratio(1, 90.0));
        assert!((ratio(3, 60.0) - 0.817_853).abs() < 1e-5, "{}", ratio(3, 60.0));
        // φ(40°)/φ(0) = (1 − e^(−0.32/0.766044)) / (1 − e^(−0.32)) = 0.341468/0.273851; f(0) = 1 +
        // 10 (1 − e^(−1.5π)) + 0.45; f(40°) = 1 + 10 (e^(−2.094395) − e^(−1.5π)) + 0.45 · 0.586824.
        assert!((ratio(12, 40.0) - 5.8881).abs() < 5e-3, "{}", ratio(12, 40.0));
        assert!((1..=16).filter(|kind| CieSky::has_sun(*kind)).count() == 12);
    }
}
