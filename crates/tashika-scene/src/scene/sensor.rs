//! Sensors: places at which irradiance is measured, without a camera.
//!
//! A sensor measures the light that reaches a surface element, which does not cast a shadow itself:
//!
//! ```text
//! plane      E = ∫ L(ω) cos⁺(n, ω) dω              irradiance on one side (W·m⁻²)
//! cylinder   E = 1/2π ∫ E_plane(n_φ) dφ            over the normals at right angles to the axis
//! sphere     E = 1/4π ∫ E_plane(n) dn              over all normals: a quarter of the fluence rate
//! ```
//!
//! The renderer treats a sensor as a pixel whose gather points are given: white, diffuse surfaces
//! with the normals of the sensor. The radiance of the pixel is then `E/π`, and everything that is
//! claimed about the pixel holds for the sensor, times π ([`Sensor::IRRADIANCE_PER_RADIANCE`]).
//!
//! # Held to this by
//! The suite's `sensors`, against closed forms.

use std::f32::consts::PI;

use glam::{DVec3, Vec3};

use super::Scene;
use crate::math::elementary::sin_cos;

/// Shape of the surface on which a sensor measures irradiance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SensorShape {
    /// One side of a plane.
    #[default]
    Plane,
    /// Lateral surface of a small cylinder: cylindrical irradiance.
    Cylinder,
    /// Surface of a small sphere: spherical irradiance.
    Sphere,
}

/// A place at which irradiance is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// Place of the sensor (m, relative to the scene's origin).
    pub position: Vec3,
    /// Unit normal of a plane, or axis of a cylinder; without effect for a sphere.
    pub normal: Vec3,
    /// Surface over which the irradiance is averaged.
    pub shape: SensorShape,
}

impl Sensor {
    /// Irradiance of a sensor over the radiance of its pixel: π (sr).
    pub const IRRADIANCE_PER_RADIANCE: f64 = std::f64::consts::PI;

    /// Returns a plane sensor at a position (m) with a unit normal.
    pub fn plane(position: Vec3, normal: Vec3) -> Self {
        Self { position, normal, shape: SensorShape::Plane }
    }

    /// Returns the unit normal of the surface element that two uniform numbers select.
    pub fn normal_at(&self, [u, v]: [f32; 2]) -> Vec3 {
        let (sin, cos) = sin_cos(2.0 * PI * v);
        match self.shape {
            SensorShape::Plane => self.normal,
            SensorShape::Cylinder => {
                let (a, b) = self.normal.any_orthonormal_pair();
                a * cos + b * sin
            }
            SensorShape::Sphere => {
                let z = 1.0 - 2.0 * u;
                let across = (1.0 - z * z).max(0.0).sqrt();
                Vec3::new(across * cos, across * sin, z).normalize()
            }
        }
    }

    /// Returns true if its position is finite and its normal has unit length.
    fn is_valid(&self) -> bool {
        self.position.is_finite() && self.normal.is_normalized()
    }
}

/// A sensor in the coordinates of the scene's file.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorPoint {
    /// Name for tables; empty if it has none.
    pub name: String,
    /// Place of the sensor (m, in the coordinates of the file).
    pub position: DVec3,
    /// Normal of a plane or axis of a cylinder, of any length above zero; without effect for a
    /// sphere.
    pub normal: DVec3,
    /// Surface over which the irradiance is averaged.
    pub shape: SensorShape,
}

impl SensorPoint {
    /// Returns an unnamed plane sensor at a position (m), with a normal of any length above zero.
    pub fn plane(position: DVec3, normal: DVec3) -> Self {
        Self { name: String::new(), position, normal, shape: SensorShape::Plane }
    }
}

impl Scene {
    /// Returns a sensor in the coordinates of this scene; `None` if its position is not finite or
    /// too far away for single precision, or if its normal has no direction.
    pub fn sensor(&self, point: &SensorPoint) -> Option<Sensor> {
        let position = (point.position - self.origin()).as_vec3();
        let normal = match (point.normal.try_normalize(), point.shape) {
            (Some(normal), _) => normal.as_vec3().normalize(),
            (None, SensorShape::Sphere) => Vec3::Z,
            (None, _) => return None,
        };
        let sensor = Sensor { position, normal, shape: point.shape };
        sensor.is_valid().then_some(sensor)
    }
}

/// Sensors in the pixels of an image. Neighbouring pixels share their guidance, so that they should
/// have neighbouring sensors.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorGrid {
    width: u32,
    /// Sensors row by row; `None` for pixels without a sensor, which are black.
    cells: Vec<Option<Sensor>>,
}

impl SensorGrid {
    /// Puts sensors into the pixels of an image of a width above zero, row by row.
    pub fn new(width: u32, cells: Vec<Option<Sensor>>) -> Self {
        debug_assert!(width > 0);
        Self { width, cells }
    }

    /// Returns the sensor of pixel `(x, y)`; `None` if it has none.
    pub fn at(&self, [x, y]: [u32; 2]) -> Option<Sensor> {
        if x >= self.width {
            return None;
        }
        *self.cells.get(y as usize * self.width as usize + x as usize)?
    }

    /// Returns true if the parameters of all sensors are in range.
    pub(super) fn is_valid(&self) -> bool {
        self.cells.iter().flatten().all(Sensor::is_valid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The normals of a cylinder are at right angles to its axis and sum to zero; those of a sphere
    /// have the second moments of uniform directions.
    #[test]
    fn normals_are_spread_over_the_surface() {
        const SIDE: u32 = 64;
        let axis = Vec3::new(1.0, 2.0, -2.0) / 3.0;
        let normals = |shape| {
            let sensor = Sensor { shape, ..Sensor::plane(Vec3::ZERO, axis) };
            let number = |k: u32| (k as f32 + 0.5) / SIDE as f32;
            (0..SIDE * SIDE).map(move |k| sensor.normal_at([number(k % SIDE), number(k / SIDE)]))
        };
        let mean = |of: &dyn Fn(Vec3) -> f32, shape| {
            normals(shape).map(|n| f64::from(of(n))).sum::<f64>() / f64::from(SIDE * SIDE)
        };
        assert!(normals(SensorShape::Plane).all(|n| n == axis));
        assert!(normals(SensorShape::Cylinder).all(|n| n.dot(axis).abs() < 1e-6 && n.is_normalized()));
        for shape in [SensorShape::Cylinder, SensorShape::Sphere] {
            for direction in [Vec3::X, Vec3::Y, Vec3::Z] {
                assert!(mean(&|n| n.dot(direction), shape).abs() < 1e-5);
                let across = 1.0 - direction.dot(axis) * direction.dot(axis);
                let expected = if shape == SensorShape::Sphere { 1.0 / 3.0 } else { f64::from(across) / 2.0 };
                let found = mean(&|n| n.dot(direction) * n.dot(direction), shape);
                assert!((found - expected).abs() < 1e-3, "{shape:?}: {found} for {expected}");
            }
        }
    }

    #[test]
    fn pixels_have_the_sensors_of_their_rows() {
        let sensor = |x: f32| Some(Sensor::plane(Vec3::new(x, 0.0, 0.0), Vec3::Y));
        let grid = SensorGrid::new(2, vec![sensor(0.0), None, sensor(2.0)]);
        let x = |pixel| grid.at(pixel).map(|sensor| sensor.position.x);
        assert_eq!([x([0, 0]), x([1, 0]), x([0, 1]), x([1, 1])], [Some(0.0), None, Some(2.0), None]);
        assert_eq!(x([2, 0]), None, "beyond the row");
        assert!(grid.is_valid());
        let bad = Sensor::plane(Vec3::ZERO, Vec3::ZERO);
        assert!(!SensorGrid::new(1, vec![Some(bad)]).is_valid());
    }
}
