//! Emitters without a surface: point, spot, directional.

use glam::Vec3;

use crate::color::Rgb;

/// How a spot light fades from its axis to its rim.
///
/// With `s = clamp((cos θ − cos_outer) / (cos_inner − cos_outer), 0, 1)` the factor is `s²`, as
/// the glTF extension `KHR_lights_punctual` defines it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Falloff {
    /// Cosine of the angle up to which the intensity is full.
    pub cos_inner: f32,
    /// Cosine of the angle from which it is zero; below `cos_inner`.
    pub cos_outer: f32,
}

impl Falloff {
    /// Factor on the intensity at an angle of cosine `cos` from the axis, 0 to 1.
    #[inline]
    pub fn at(&self, cos: f32) -> f32 {
        let s = ((cos - self.cos_outer) / (self.cos_inner - self.cos_outer)).clamp(0.0, 1.0);
        s * s
    }

    /// Solid angle weighted by the factor, `∫ at(cos θ) dω` (sr): `2π (1 − c_i + (c_i − c_o)/3)`.
    pub fn solid_angle(&self) -> f32 {
        2.0 * std::f32::consts::PI * (1.0 - self.cos_inner + (self.cos_inner - self.cos_outer) / 3.0)
    }
}

/// An emitter that no ray can hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Emitter {
    /// Equal intensity in all directions.
    Point {
        /// Position (m).
        position: Vec3,
        /// Intensity (W·sr⁻¹).
        intensity: Rgb,
    },
    /// Intensity in a cone.
    Spot {
        /// Position (m).
        position: Vec3,
        /// Unit axis, from the light.
        axis: Vec3,
        /// Intensity on the axis (W·sr⁻¹).
        intensity: Rgb,
        /// How it fades.
        falloff: Falloff,
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
    /// Unscaled colour of the emitter, whatever its unit.
    pub(super) fn color(&self) -> Rgb {
        match *self {
            Self::Point { intensity, .. } | Self::Spot { intensity, .. } => intensity,
            Self::Directional { irradiance, .. } => irradiance,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solid_angle_is_the_integral_of_the_falloff() {
        let f = Falloff { cos_inner: 0.9, cos_outer: 0.5 };
        let n = 100_000;
        let sum: f64 = (0..n).map(|i| f64::from(f.at(-1.0 + 2.0 * (i as f32 + 0.5) / n as f32))).sum();
        let integral = sum * 2.0 / f64::from(n) * 2.0 * std::f64::consts::PI;
        assert!((integral - f64::from(f.solid_angle())).abs() < 1e-4 * integral);
        assert_eq!((f.at(0.95), f.at(0.4)), (1.0, 0.0));
    }
}
