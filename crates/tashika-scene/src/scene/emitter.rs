//! Emitters without a surface: point, spot, directional, image.

use glam::Vec3;

use crate::color::Rgb;
use crate::math::elementary::acos;

/// Curve by which a spot light fades.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum FalloffShape {
    /// Factor `s²`, with `s` computed from the cosine (glTF, `KHR_lights_punctual`).
    Squared,
    /// Factor `s² (3 − 2s)`, with `s` computed from the cosine (pbrt-v4).
    Smoothstep,
    /// Factor `s⁴`, with `s` computed from the cosine (pbrt-v3).
    Fourth,
    /// Factor `s`, with `s` computed from the angle (Mitsuba).
    LinearInAngle,
}

/// Fading of a spot light from its axis to its rim.
///
/// The factor is a function of `s = clamp((x − x_outer) / (x_inner − x_outer), 0, 1)`, where `x` is
/// the cosine of the angle from the axis, or the angle itself. The [`FalloffShape`] specifies the
/// function and `x`.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Falloff {
    /// Cosine of the angle up to which the intensity is at its maximum.
    pub cos_inner: f32,
    /// Cosine of the angle from which the intensity is zero; below `cos_inner`.
    pub cos_outer: f32,
    /// Curve between the two angles.
    pub shape: FalloffShape,
}

impl Falloff {
    /// Factor on the intensity at an angle of cosine `cos` from the axis, 0 to 1.
    #[inline]
    pub fn at(&self, cos: f32) -> f32 {
        let share = |x: f32, inner: f32, outer: f32| ((x - outer) / (inner - outer)).clamp(0.0, 1.0);
        match self.shape {
            FalloffShape::Squared => {
                let s = share(cos, self.cos_inner, self.cos_outer);
                s * s
            }
            FalloffShape::Smoothstep => {
                let s = share(cos, self.cos_inner, self.cos_outer);
                s * s * (3.0 - 2.0 * s)
            }
            FalloffShape::Fourth => {
                let s = share(cos, self.cos_inner, self.cos_outer);
                (s * s) * (s * s)
            }
            FalloffShape::LinearInAngle => share(angle(cos), angle(self.cos_inner), angle(self.cos_outer)),
        }
    }

    /// Solid angle weighted by the factor, `∫ at(cos θ) dω` (sr).
    ///
    /// ```text
    /// 2π (1 − c_i + w)      w = (c_i − c_o)/3, (c_i − c_o)/2, (c_i − c_o)/5, c_i − (sin θ_o − sin θ_i)/(θ_o − θ_i)   by shape
    /// ```
    #[inline]
    pub fn solid_angle(&self) -> f32 {
        let (inner, outer) = (self.cos_inner, self.cos_outer);
        let fading = match self.shape {
            FalloffShape::Squared => (inner - outer) / 3.0,
            FalloffShape::Smoothstep => (inner - outer) / 2.0,
            FalloffShape::Fourth => (inner - outer) / 5.0,
            FalloffShape::LinearInAngle => {
                let sin = |cos: f32| (1.0 - cos * cos).max(0.0).sqrt();
                inner - (sin(outer) - sin(inner)) / (angle(outer) - angle(inner))
            }
        };
        2.0 * std::f32::consts::PI * (1.0 - inner + fading)
    }
}

#[inline]
fn angle(cos: f32) -> f32 {
    acos(cos.clamp(-1.0, 1.0))
}

/// Reference to the intensity map of a light.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Beam {
    /// Index of the map in the scene's list
    /// ([`Scene::intensity_maps`](super::Scene::intensity_maps)).
    pub map: u32,
    /// Cosine of the angle from the axis beyond which the intensity is zero; −1 for all directions.
    pub cos_outer: f32,
}

/// An emitter that no ray can hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Emitter {
    /// Equal intensity in all directions.
    Point {
        /// Position in the world (m).
        position: Vec3,
        /// Intensity in every direction (W·sr⁻¹).
        intensity: Rgb,
    },
    /// Intensity within a cone.
    Spot {
        /// Position in the world (m).
        position: Vec3,
        /// Unit axis, from the light.
        axis: Vec3,
        /// Intensity on the axis (W·sr⁻¹).
        intensity: Rgb,
        /// Fading from the axis to the rim.
        falloff: Falloff,
    },
    /// Intensity by direction, from an intensity map of the scene. Created by
    /// [`SceneBuilder::add_image_light`](super::SceneBuilder::add_image_light).
    Image {
        /// Position in the world (m).
        position: Vec3,
        /// Unit axis, from the light: `+z` of the map's frame.
        axis: Vec3,
        /// Largest intensity of each channel over all directions (W·sr⁻¹).
        intensity: Rgb,
        /// Intensity map, and the cone into which it emits.
        beam: Beam,
    },
    /// Parallel light from infinitely far away.
    Directional {
        /// Unit direction in which the light travels.
        direction: Vec3,
        /// Irradiance of a surface that faces the light (W·m⁻²).
        irradiance: Rgb,
    },
}

impl Emitter {
    /// Returns the position (m); `None` for an emitter that is infinitely far away.
    pub fn position(&self) -> Option<Vec3> {
        match *self {
            Self::Point { position, .. } | Self::Spot { position, .. } | Self::Image { position, .. } => {
                Some(position)
            }
            Self::Directional { .. } => None,
        }
    }

    /// Moves the emitter to a position (m), unless it is infinitely far away.
    pub(super) fn move_to(&mut self, place: Vec3) {
        match self {
            Self::Point { position, .. } | Self::Spot { position, .. } | Self::Image { position, .. } => {
                *position = place;
            }
            Self::Directional { .. } => {}
        }
    }

    /// Returns the emitter with `factor` times its brightness.
    #[must_use]
    pub fn scaled(mut self, factor: f32) -> Self {
        match &mut self {
            Self::Point { intensity, .. } | Self::Spot { intensity, .. } | Self::Image { intensity, .. } => {
                *intensity *= factor;
            }
            Self::Directional { irradiance, .. } => *irradiance *= factor,
        }
        self
    }

    /// Colour of the emitter, whose unit depends on its kind.
    pub(super) fn color(&self) -> Rgb {
        match *self {
            Self::Point { intensity, .. } | Self::Spot { intensity, .. } | Self::Image { intensity, .. } => {
                intensity
            }
            Self::Directional { irradiance, .. } => irradiance,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solid_angle_is_the_integral_of_the_falloff() {
        let shapes = [FalloffShape::Squared, FalloffShape::Smoothstep, FalloffShape::Fourth];
        for shape in shapes.into_iter().chain([FalloffShape::LinearInAngle]) {
            let f = Falloff { cos_inner: 0.9, cos_outer: 0.5, shape };
            let n = 100_000;
            let sum: f64 = (0..n).map(|i| f64::from(f.at(-1.0 + 2.0 * (i as f32 + 0.5) / n as f32))).sum();
            let integral = sum * 2.0 / f64::from(n) * 2.0 * std::f64::consts::PI;
            assert!((integral - f64::from(f.solid_angle())).abs() < 1e-4 * integral, "{shape:?}");
            assert_eq!((f.at(0.95), f.at(0.4)), (1.0, 0.0));
        }
    }
}
