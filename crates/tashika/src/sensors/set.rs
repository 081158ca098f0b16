//! Sets of sensors, and their places in an image.

use crate::error::{Error, Location, Result};
use crate::film::{Film, RenderFilm};
use crate::math::Aabb;
use crate::renderer::Renderer;
use crate::request::Framing;
use crate::scene::{Camera, Scene, Sensor, SensorGrid, SensorPoint, SensorShape};

use super::Photometry;
use super::readings::{Reading, reading};

/// Side of a block of pixels with common guidance.
const BLOCK: usize = 16;
/// Gather points of a sensor whose surface has many normals.
const POINTS_OF_ROUND: u64 = 64;
/// Bits of a coordinate in the order of sensors.
const BITS: u32 = 10;

/// Sensors of a scene, in the pixels of an image.
///
/// Sensors near each other, with similar normals, are put into the same block of 16×16 pixels,
/// since the pixels of a block have common guidance. The order of the sensors in a file has no
/// influence on their values.
#[derive(Clone, Debug)]
pub struct SensorSet {
    points: Vec<SensorPoint>,
    camera: Camera,
    size: [u32; 2],
    /// Pixel of each sensor.
    pixels: Vec<[u32; 2]>,
    gather: u64,
}

impl SensorSet {
    /// Makes a set of sensors in the medium of the scene's first camera, outside of solid glass.
    ///
    /// # Errors
    /// [`Error::Option`] if there is no sensor; [`Error::Invalid`] for a sensor whose position is
    /// not finite or whose normal has no direction, with its number from 1.
    pub fn new(scene: &Scene, points: Vec<SensorPoint>) -> Result<Self> {
        if points.is_empty() {
            return Err(Error::option("points", "no sensor", "one sensor or more"));
        }
        let mut sensors = Vec::with_capacity(points.len());
        for (number, point) in (1..).zip(&points) {
            sensors.push(scene.sensor(point).ok_or_else(|| {
                let at = Location::default().item(format!("sensor {number}"));
                let found = format!("position {}, normal {}", point.position, point.normal);
                Error::invalid(at, found, "a finite position and a normal with a direction")
            })?);
        }
        let blocks = sensors.len().div_ceil(BLOCK * BLOCK);
        // The smallest number of blocks across with which the image is at least as wide as high.
        let across = (1..).find(|across| across * across >= blocks).unwrap_or(1);
        let [width, rows] = match blocks {
            1 => [sensors.len().min(BLOCK), sensors.len().div_ceil(BLOCK)],
            _ => [across * BLOCK, blocks.div_ceil(across) * BLOCK],
        };
        let size = [width as u32, rows as u32];
        let mut pixels = vec![[0; 2]; sensors.len()];
        let mut cells = vec![None; width * rows];
        for (place, sensor) in in_space(&sensors).into_iter().enumerate() {
            let (block, within) = (place / (BLOCK * BLOCK), place % (BLOCK * BLOCK));
            let x = block % across * BLOCK + within % BLOCK;
            let y = block / across * BLOCK + within / BLOCK;
            pixels[sensor] = [x as u32, y as u32];
            cells[y * width + x] = Some(sensors[sensor]);
        }
        let camera = scene.cameras()[0].with_sensors(SensorGrid::new(size[0], cells));
        let is_round = points.iter().any(|point| point.shape != SensorShape::Plane);
        let gather = if is_round { POINTS_OF_ROUND } else { 1 };
        Ok(Self { points, camera, size, pixels, gather })
    }

    /// Sensors in the order in which they were given.
    pub fn points(&self) -> &[SensorPoint] {
        &self.points
    }

    /// Camera whose pixels are the sensors.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Size of the image (pixels).
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Number of gather points of a sensor: one for planes.
    pub fn gather_points(&self) -> u64 {
        self.gather
    }

    /// Readings of a film of this set, in the order in which the sensors were given.
    ///
    /// # Panics
    /// If the film has another size.
    pub fn readings(&self, film: &Film, photometry: Photometry) -> Vec<Reading> {
        assert_eq!(film.size(), self.size, "a film of these sensors");
        let (window, read) = (film.window(), RenderFilm::of(film));
        let of_pixel = |[x, y]: [u32; 2]| {
            if window.contains(x, y) { reading(&read, [x, y], photometry) } else { Reading::NONE }
        };
        self.pixels.iter().map(|pixel| of_pixel(*pixel)).collect()
    }
}

impl Renderer<'_> {
    /// Sets the camera, the whole image and the gather points to those of a set of sensors.
    #[must_use]
    pub fn sensors(self, sensors: &SensorSet) -> Self {
        let framing = Framing { size: Some(sensors.size()), crop: None };
        self.camera(sensors.camera().clone()).framing(framing).gather_points(sensors.gather_points())
    }
}

/// Indices of sensors by the axis that their normals are nearest to, and then along a Morton curve
/// through the box of their positions.
fn in_space(sensors: &[Sensor]) -> Vec<usize> {
    let bounds = Aabb::of_points(sensors.iter().map(|sensor| sensor.position));
    let side = bounds.size().max_element().max(f32::MIN_POSITIVE);
    let key = |sensor: &Sensor| {
        let axis = sensor.normal.abs().max_position();
        let faces = 2 * axis + usize::from(sensor.normal[axis] < 0.0);
        let most = ((1_u32 << BITS) - 1) as f32;
        let cell = ((sensor.position - bounds.lo) / side * most).to_array().map(|v| v as u32);
        let morton = (0..BITS)
            .rev()
            .fold(0_u64, |code, bit| cell.iter().fold(code, |code, v| code << 1 | u64::from(*v >> bit & 1)));
        (faces, morton, sensor.position.to_array().map(f32::to_bits))
    };
    let mut order: Vec<usize> = (0..sensors.len()).collect();
    order.sort_by_cached_key(|k| key(&sensors[*k]));
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;
    use glam::DVec3;

    /// Each sensor has its own pixel, and all other pixels are empty. The pixel of a sensor does
    /// not depend on its number.
    #[test]
    fn each_sensor_has_a_pixel() {
        let scene = builtin::tiny();
        for count in [1, 5, 256, 257, 1000] {
            let point =
                |k: usize| SensorPoint::plane(DVec3::new((k % 31) as f64, (k / 31) as f64, 0.5), DVec3::Z);
            let points: Vec<SensorPoint> = (0..count).map(point).collect();
            let set = SensorSet::new(&scene, points.clone()).unwrap();
            let grid = set.camera().sensors.as_ref().unwrap();
            for (point, pixel) in points.iter().zip(&set.pixels) {
                assert_eq!(grid.at(*pixel), scene.sensor(point));
            }
            let [width, height] = set.size();
            let full = (0..width * height).filter(|k| grid.at([k % width, k / width]).is_some());
            assert_eq!(full.count(), count);
            let reversed = SensorSet::new(&scene, points.into_iter().rev().collect()).unwrap();
            assert_eq!(reversed.camera(), set.camera());
        }
    }

    #[test]
    fn sensors_without_a_direction_are_refused_with_their_number() {
        let scene = builtin::tiny();
        let good = SensorPoint::plane(DVec3::ZERO, DVec3::Y);
        for bad in [
            SensorPoint::plane(DVec3::ZERO, DVec3::ZERO),
            SensorPoint::plane(DVec3::NAN, DVec3::Y),
            SensorPoint::plane(DVec3::splat(1e300), DVec3::Y),
        ] {
            let message = SensorSet::new(&scene, vec![good.clone(), bad]).unwrap_err().to_string();
            assert!(message.contains("sensor 2"), "{message}");
        }
        assert!(SensorSet::new(&scene, Vec::new()).is_err());
        let sphere =
            SensorPoint { shape: SensorShape::Sphere, ..SensorPoint::plane(DVec3::ZERO, DVec3::ZERO) };
        assert!(SensorSet::new(&scene, vec![sphere]).is_ok(), "it has no direction");
    }
}
