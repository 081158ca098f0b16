//! Light of a clear day: the sky, and the sun behind the atmosphere.
//!
//! Preetham, Shirley and Smits 1999, "A Practical Analytic Model for Daylight". The sky has the
//! luminance and chromaticity
//!
//! ```text
//! Y(θ, γ) = Y_z F(θ, γ) / F(0, θ_s)      F(θ, γ) = (1 + A e^(B / cos θ)) (1 + C e^(D γ) + E cos² γ)
//! ```
//!
//! and likewise for `x` and `y`. `θ` is the angle of the direction from the zenith, `γ` its angle
//! from the sun, and `θ_s` the angle of the sun from the zenith. `A … E`, `Y_z`, `x_z`, `y_z`
//! depend on the turbidity, and the latter three on `θ_s` (appendix A.2 there). The sun is a black
//! body of temperature [`SUN_TEMPERATURE`] that fills [`SUN_SOLID_ANGLE`]. The atmosphere transmits
//! the share
//!
//! ```text
//! e^(−0.008735 λ^(−4.08) m)  ·  e^(−β λ^(−1.3) m)      β = 0.04608 T − 0.04586      (λ in µm)
//! ```
//!
//! of its light (Rayleigh and aerosol extinction, appendix A.1), with the relative air mass
//! `m = 1 / (cos θ_s + 0.15 (93.885° − θ_s)^(−1.253))`.
//!
//! Frame: `+y` is up. Radiance is spectral radiance (W·m⁻²·sr⁻¹·nm⁻¹), averaged over the spectrum
//! with the weights of the CIE's observer of 1931. This is also the unit of Mitsuba's `sunsky`; a
//! radiance of 1 is a luminance of `683 · 106.86` cd·m⁻².
//!
//! # Assumption
//! Turbidity from [`MIN_TURBIDITY`] to [`MAX_TURBIDITY`]; the sun at or above the horizon. No light
//! comes from below the horizon. Ozone, mixed gases and water vapour, which absorb a few percent of
//! the visible light, are ignored.
//!
//! Checked by the tests below.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3;

use super::Image;
use super::hemisphere::sky_image;
use crate::color::Rgb;
use crate::color::spectrum::{blackbody, rgb_of_emission};
use crate::math::elementary::{acos, exp, powf, sin_cos, tan};

/// Turbidity of the clearest air to which the polynomials were fitted.
pub const MIN_TURBIDITY: f32 = 1.7;
/// Turbidity of the haziest air to which the polynomials were fitted.
pub const MAX_TURBIDITY: f32 = 10.0;

/// Effective temperature of the sun (K).
pub const SUN_TEMPERATURE: f32 = 5778.0;
/// Solid angle of the sun's disc, of radius 0.2666° (sr).
pub const SUN_SOLID_ANGLE: f32 = 6.8e-5;

/// Luminance (cd·m⁻²) of one unit of radiance: the maximum luminous efficacy times `∫ ȳ dλ` (nm).
const LUMINANCE_OF_UNIT: f32 = 683.0 * 106.857;

/// Smallest cosine from the zenith at which the sky is evaluated.
const MIN_COSINE: f32 = 0.01;

/// Coefficients `A … E`, each as slope and offset in the turbidity, of `Y`, `x`, `y`.
const PEREZ: [[[f32; 2]; 5]; 3] = [
    [[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]],
    [[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]],
    [[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]],
];

/// Zenith chromaticities: rows by `T²`, `T`, 1; columns by `θ_s³`, `θ_s²`, `θ_s`, 1.
const ZENITH: [[[f32; 4]; 3]; 2] = [
    [
        [0.00166, -0.00375, 0.00209, 0.0],
        [-0.02903, 0.06377, -0.03202, 0.00394],
        [0.11693, -0.21196, 0.06052, 0.25886],
    ],
    [
        [0.00275, -0.00610, 0.00317, 0.0],
        [-0.04214, 0.08970, -0.04153, 0.00516],
        [0.15346, -0.26756, 0.06670, 0.26688],
    ],
];

/// A clear sky with its sun.
#[derive(Clone, Copy, Debug)]
pub struct Sky {
    turbidity: f32,
    to_sun: Vec3,
    /// Angle of the sun from the zenith (radians).
    sun_zenith: f32,
    /// `Y` (in units of radiance), `x`, `y` at the zenith, divided by `F(0, θ_s)`.
    scale: [f32; 3],
    perez: [[f32; 5]; 3],
}

impl Sky {
    /// Creates the sky for a turbidity and a direction to the sun, `+y` up. The turbidity is
    /// clamped to the range of the model; a sun below the horizon is moved up to the horizon.
    pub fn new(turbidity: f32, to_sun: Vec3) -> Self {
        let t = turbidity.clamp(MIN_TURBIDITY, MAX_TURBIDITY);
        let to_sun = Vec3::new(to_sun.x, to_sun.y.max(0.0), to_sun.z).normalize_or(Vec3::Y);
        let sun_zenith = acos(to_sun.y).min(FRAC_PI_2);
        let perez = PEREZ.map(|rows| rows.map(|[slope, offset]| slope * t + offset));
        let chi = (4.0 / 9.0 - t / 120.0) * (PI - 2.0 * sun_zenith);
        let luminance = (4.0453 * t - 4.9710) * tan(chi) - 0.2155 * t + 2.4192;
        let zenith = ZENITH.map(|rows| {
            let cubic = |c: [f32; 4]| ((c[0] * sun_zenith + c[1]) * sun_zenith + c[2]) * sun_zenith + c[3];
            (cubic(rows[0]) * t + cubic(rows[1])) * t + cubic(rows[2])
        });
        let radiance = (luminance * 1000.0).max(0.0) / LUMINANCE_OF_UNIT;
        let mut scale = [radiance, zenith[0], zenith[1]];
        for (value, perez) in scale.iter_mut().zip(&perez) {
            *value /= distribution(perez, 1.0, sun_zenith);
        }
        Self { turbidity: t, to_sun, sun_zenith, scale, perez }
    }

    /// Radiance of the sky in a unit direction; the sun is not included.
    pub fn radiance(&self, direction: Vec3) -> Rgb {
        if direction.y < 0.0 {
            return Rgb::BLACK;
        }
        let gamma = acos(direction.dot(self.to_sun));
        let at = |i: usize| self.scale[i] * distribution(&self.perez[i], direction.y.max(MIN_COSINE), gamma);
        rgb_of_chromaticity(at(0), at(1), at(2))
    }

    /// Irradiance by the sun on a surface that faces it (W·m⁻²·nm⁻¹, averaged over the spectrum
    /// like radiances).
    pub fn sun_irradiance(&self) -> Rgb {
        let degrees = self.sun_zenith.to_degrees();
        let air_mass = 1.0 / (self.to_sun.y.max(0.0) + 0.15 * powf(93.885 - degrees, -1.253));
        let beta = 0.04608 * self.turbidity - 0.04586;
        let samples: Vec<(f32, f32)> = (360..=830_u16)
            .step_by(5)
            .map(|nm| {
                let nm = f32::from(nm);
                let micrometres = nm / 1000.0;
                let extinction = 0.008735 * powf(micrometres, -4.08) + beta * powf(micrometres, -1.3);
                (nm, blackbody(nm, SUN_TEMPERATURE) * exp(-extinction * air_mass) * SUN_SOLID_ANGLE)
            })
            .collect();
        rgb_of_emission(&samples).unwrap_or(Rgb::BLACK).map(|v| v.max(0.0))
    }

    /// Unit direction towards the sun.
    pub fn to_sun(&self) -> Vec3 {
        self.to_sun
    }

    /// The sky without its sun as a latitude-longitude image: row 0 at `+y`, `u = 0.5` at `−z`,
    /// `u = 0.75` at `+x`.
    pub fn image(&self, width: u32, height: u32) -> Image {
        sky_image(width, height, |direction| self.radiance(direction.as_vec3()).to_array())
    }
}

/// Returns `F` at a cosine from the zenith and an angle from the sun.
fn distribution(c: &[f32; 5], cos: f32, gamma: f32) -> f32 {
    let cos_gamma = sin_cos(gamma).1;
    (1.0 + c[0] * exp(c[1] / cos)) * (1.0 + c[2] * exp(c[3] * gamma) + c[4] * cos_gamma * cos_gamma)
}

/// Linear Rec. 709 colour of a luminance and chromaticity (IEC 61966-2-1), without negative values.
fn rgb_of_chromaticity(luminance: f32, x: f32, y: f32) -> Rgb {
    if !(luminance > 0.0 && y > 0.0) {
        return Rgb::BLACK;
    }
    let (x, z) = (x / y * luminance, (1.0 - x - y) / y * luminance);
    let y = luminance;
    Rgb::new(
        3.2406 * x - 1.5372 * y - 0.4986 * z,
        -0.9689 * x + 1.8758 * y + 0.0415 * z,
        0.0557 * x - 0.2040 * y + 1.0570 * z,
    )
    .map(|v| v.max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sun at an angle from the zenith, towards `+x`.
    fn sky(turbidity: f32, degrees: f32) -> Sky {
        let (sin, cos) = sin_cos(degrees.to_radians());
        Sky::new(turbidity, Vec3::new(sin, cos, 0.0))
    }

    /// Direction at an angle from the zenith, towards `+x`.
    fn towards(degrees: f32) -> Vec3 {
        let (sin, cos) = sin_cos(degrees.to_radians());
        Vec3::new(sin, cos, 0.0)
    }

    /// The luminance of the zenith is that of the paper's formula (section A.2), worked out by hand
    /// for `T = 3`, `θ_s = 45°`: `χ = (4/9 − 1/40) π/2 = 0.65886`,
    /// `Y_z = 7.1649 tan χ − 0.6465 + 2.4192 = 7.3276` kcd·m⁻².
    #[test]
    fn the_zenith_has_the_luminance_of_the_formula() {
        let zenith = sky(3.0, 45.0).radiance(Vec3::Y).luminance() * LUMINANCE_OF_UNIT;
        assert!((zenith - 7327.6).abs() < 0.002 * 7327.6, "{zenith} cd/m²");
    }

    #[test]
    fn the_sky_is_blue_and_brightest_about_the_sun() {
        let s = sky(3.0, 45.0);
        let zenith = s.radiance(Vec3::Y);
        assert!(zenith.b > 1.5 * zenith.r, "{zenith:?}");
        let about_the_sun = s.radiance(towards(45.0)).luminance();
        for degrees in [-80.0, -30.0, 0.0, 30.0, 60.0] {
            assert!(s.radiance(towards(degrees)).luminance() < about_the_sun, "{degrees}");
        }
        assert!(s.radiance(Vec3::new(0.0, -0.01, 1.0)).is_black());
    }

    #[test]
    fn a_low_sun_is_red_and_weak() {
        let (high, low) = (sky(3.0, 10.0).sun_irradiance(), sky(3.0, 85.0).sun_irradiance());
        assert!(low.luminance() < 0.4 * high.luminance(), "{low:?} {high:?}");
        assert!(low.r / low.b > 3.0 * high.r / high.b);
        // Sun irradiance of Mitsuba 3.9's `sunsky` (Hosek and Wilkie's sun) at turbidity 2, with
        // the sun 18.4° from the zenith.
        let other = [1.543, 1.304, 1.021];
        for (ours, theirs) in sky(2.0, 18.43).sun_irradiance().to_array().into_iter().zip(other) {
            assert!((ours / theirs - 1.0).abs() < 0.15, "{ours} for {theirs}");
        }
    }

    #[test]
    fn the_image_shows_the_sky_where_the_environment_looks() {
        let s = sky(4.0, 60.0);
        let image = s.image(64, 32);
        let environment = crate::scene::Environment::lat_long(image, Rgb::WHITE, glam::Mat3::IDENTITY);
        for direction in [Vec3::new(0.8, 0.5, 0.1), Vec3::new(-0.3, 0.6, -0.9), Vec3::new(0.0, 1.0, 0.2)] {
            let direction = direction.normalize();
            let (seen, exact) = (environment.radiance(direction), s.radiance(direction));
            assert!((seen.luminance() / exact.luminance() - 1.0).abs() < 0.05, "{direction}");
        }
    }

    #[test]
    fn every_turbidity_and_sun_gives_finite_radiances() {
        for turbidity in [-1.0, 0.0, 1.7, 6.0, 10.0, 1e9] {
            for to_sun in [Vec3::Y, Vec3::X, Vec3::NEG_Y, Vec3::ZERO, Vec3::new(1.0, 1e-8, 0.0)] {
                let s = Sky::new(turbidity, to_sun);
                for degrees in [0.0, 30.0, 60.0, 89.9, 90.0] {
                    assert!(s.radiance(towards(degrees)).is_valid(), "{turbidity} {to_sun} {degrees}");
                }
                assert!(s.sun_irradiance().is_valid());
            }
        }
    }
}
