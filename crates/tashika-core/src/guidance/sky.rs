//! Sky that a pixel sees, however small its bright parts are.
//!
//! The sun, seen directly or through a ball of glass, may cover a thousandth of a pixel and
//! outshine all else in it, yet most sets of a hundred camera samples miss it. The samples that
//! left the scene nevertheless show its place: three neighbouring ones form a triangle in the
//! pixel, of area `a`, and their directions a triangle on the sphere, of solid angle `Ω`. Let
//! directions `ω_i` be drawn in proportion to the luminance of the sky, whose integral over the
//! sphere is `E`. The luminance of the sky in the pixel is then
//!
//! ```text
//! L = (E/N) Σ_i Σ_t q_t T_t a_t / Ω_t          over the triangles t around direction i
//! ```
//!
//! with the mean throughput `T_t` of the three paths, and the share `q_t` of the samples there
//! whose paths take the same way, over the same surfaces by reflection or transmission. Each way
//! has triangles of its own: each sample with two of its neighbours. A triangle occurs up to three
//! times, once for each corner, and counts a third each time.
//!
//! # Held to this by
//! The tests below, and the suite's `hard_light`.

use std::f32::consts::TAU;

use crate::gather::{PixelSum, SkySample};
use crate::math::elementary::atan2;
use crate::math::{Vec2, Vec3};
use crate::rng::{Purpose, Stream};
use crate::scene::Environment;

/// Number of directions drawn from the sky.
const DIRECTIONS: usize = 64;
/// Number of neighbours of a sample.
const NEIGHBOURS: usize = 6;
/// Number of corners of a triangle, each of which may have it among its own.
const CORNERS: f64 = 3.0;

/// Directions drawn from a sky.
#[derive(Clone, Debug)]
pub struct Sky {
    directions: Vec<Vec3>,
    /// `E/N` (W·m⁻²).
    each: f64,
    /// Largest luminance in the directions (W·m⁻²·sr⁻¹).
    brightest: f64,
}

impl Sky {
    /// Draws directions from an environment. `None` if its radiance is the same everywhere.
    pub fn new(environment: &Environment, seed: u64) -> Option<Self> {
        environment.resolution()?;
        let mut stream = Stream::new(seed, Purpose::Guidance, 0);
        let draw = |k: usize, stream: &mut Stream| {
            let [u, v] = stream.uniform_2();
            environment.sample([(k as f32 + u) / DIRECTIONS as f32, v]).0
        };
        let directions: Vec<Vec3> = (0..DIRECTIONS).map(|k| draw(k, &mut stream)).collect();
        let luminance = |direction: &Vec3| f64::from(environment.radiance(*direction).luminance());
        let brightest = directions.iter().map(luminance).fold(0.0, f64::max);
        let whole = 4.0 * std::f64::consts::PI * f64::from(environment.mean().luminance());
        Some(Self { directions, each: whole / DIRECTIONS as f64, brightest })
    }

    /// Approximate luminance of the sky in a pixel, less two standard errors, at least zero
    /// (W·m⁻²·sr⁻¹).
    ///
    /// * `seen`: camera samples of the pixel.
    pub fn importance_least(&self, seen: &PixelSum) -> f64 {
        let mut exits: Vec<Exit> = seen
            .samples
            .iter()
            .filter_map(|sample| sample.sky.map(|sky| Exit { place: sample.place.into(), sky }))
            .collect();
        exits.sort_by_key(|exit| exit.sky.way);
        let mut values = vec![0.0; self.directions.len()];
        for way in exits.chunk_by(|a, b| a.sky.way == b.sky.way) {
            self.add(way, seen, &mut values);
        }
        let sum: f64 = values.iter().sum();
        let squares: f64 = values.iter().map(|value| value * value).sum();
        let throughput = exits.iter().map(|exit| exit.sky.throughput).fold(0.0, f32::max);
        let most = f64::from(throughput) * seen.samples.len() as f64 * self.brightest;
        (sum - 2.0 * squares.sqrt()).clamp(0.0, most)
    }

    /// Adds the luminance that each direction gives to the pixel through the triangles of one way.
    fn add(&self, way: &[Exit], seen: &PixelSum, values: &mut [f64]) {
        let middle: Vec3 = way.iter().map(|exit| exit.sky.direction).sum();
        let cosine = |direction: Vec3| direction.dot(middle);
        let least = way.iter().map(|exit| cosine(exit.sky.direction)).fold(f32::INFINITY, f32::min);
        // Directions beside all paths lie in no triangle: a cap of at most a hemisphere is convex.
        let is_near = |k: &usize| least <= 0.0 || cosine(self.directions[*k]) >= least;
        let near: Vec<usize> = (0..values.len()).filter(is_near).collect();
        if near.is_empty() {
            return;
        }
        for exit in way {
            let neighbours = neighbours(exit, way);
            for (k, first) in neighbours.iter().enumerate() {
                let second = &neighbours[(k + 1) % neighbours.len()];
                let Some(triangle) = Triangle::new([exit, first, second]) else { continue };
                for &direction in &near {
                    if triangle.holds(self.directions[direction]) {
                        values[direction] += self.each * triangle.density(way, seen) / CORNERS;
                    }
                }
            }
        }
    }
}

/// Camera sample that left the scene.
#[derive(Clone, Copy)]
struct Exit {
    place: Vec2,
    sky: SkySample,
}

/// The samples of a way that are nearest to one of them in the pixel, counter-clockwise around it.
fn neighbours(exit: &Exit, way: &[Exit]) -> Vec<Exit> {
    let offset = |other: &Exit| other.place - exit.place;
    let mut near: Vec<Exit> = way.iter().filter(|other| other.place != exit.place).copied().collect();
    let by_distance = |a: &Exit, b: &Exit| offset(a).length_squared().total_cmp(&offset(b).length_squared());
    if near.len() > NEIGHBOURS {
        near.select_nth_unstable_by(NEIGHBOURS - 1, by_distance);
        near.truncate(NEIGHBOURS);
    }
    let angle = |other: &Exit| atan2(offset(other).y, offset(other).x);
    near.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    near
}

/// Three samples of a way.
struct Triangle {
    corners: [Exit; 3],
    /// `a`, as a share of the pixel.
    area: f32,
    /// `Ω` (sr).
    solid_angle: f32,
    /// Volume spanned by the directions, whose sign is their orientation.
    volume: f32,
}

impl Triangle {
    /// `None` if the corners are not counter-clockwise in the pixel, or their directions lie on a
    /// great circle.
    fn new(corners: [&Exit; 3]) -> Option<Self> {
        let [a, b, c] = corners.map(|exit| exit.place);
        let area = 0.5 * (b - a).perp_dot(c - a);
        let [d, e, f] = corners.map(|exit| exit.sky.direction);
        let volume = d.dot(e.cross(f));
        // Equation 8 of Oosterom 1983.
        let half = atan2(volume.abs(), 1.0 + d.dot(e) + e.dot(f) + f.dot(d));
        let solid_angle = 2.0 * half;
        let is_proper = area > 0.0 && volume != 0.0 && solid_angle > 0.0 && solid_angle < 0.5 * TAU;
        is_proper.then(|| Self { corners: corners.map(|exit| *exit), area, solid_angle, volume })
    }

    /// Returns true if a direction lies in the triangle on the sphere.
    fn holds(&self, direction: Vec3) -> bool {
        let [a, b, c] = self.corners.map(|exit| exit.sky.direction);
        let is_inside = |d: Vec3, e: Vec3| direction.dot(d.cross(e)) * self.volume >= 0.0;
        direction.dot(a + b + c) > 0.0 && is_inside(a, b) && is_inside(b, c) && is_inside(c, a)
    }

    /// Luminance of the pixel for each unit of the sky's irradiance in the triangle, `q T a / Ω`
    /// (sr⁻¹).
    fn density(&self, way: &[Exit], seen: &PixelSum) -> f64 {
        let middle = self.corners.iter().map(|exit| exit.place).sum::<Vec2>() / 3.0;
        let distances = self.corners.map(|exit| exit.place.distance(middle));
        let radius = distances.into_iter().fold(0.0, f32::max);
        let is_near = |place: Vec2| place.distance(middle) <= radius;
        let all = seen.samples.iter().filter(|sample| is_near(sample.place.into())).count();
        let of_way = way.iter().filter(|exit| is_near(exit.place)).count();
        let share = of_way as f64 / all.max(1) as f64;
        let throughput: f32 = self.corners.iter().map(|exit| exit.sky.throughput).sum();
        let mean = f64::from(throughput) * seen.samples.len() as f64 / 3.0;
        share * mean * f64::from(self.area / self.solid_angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::gather::SeenSample;
    use crate::math::Mat3;
    use crate::scene::{Image, Pixels};

    /// Sky with radiance 1, and a sun of one texel of 512 × 256 with radiance 10⁵ about `+z`.
    fn sky() -> (Environment, f64) {
        let (w, h) = (512, 256);
        let mut texels = vec![[1.0; 3]; w * h];
        let sun = (h / 2) * w;
        texels[sun] = [1e5; 3];
        let image = Image { name: "sky".into(), width: 512, height: 256, pixels: Pixels::Float(texels) };
        let environment = Environment::lat_long(image, Rgb::WHITE, Mat3::IDENTITY);
        let texel = 2.0 * std::f64::consts::PI / w as f64 * std::f64::consts::PI / h as f64;
        (environment, 1e5 * texel)
    }

    /// Camera samples of a pixel with the given map from place to direction, every `stride`-th of
    /// which takes that way.
    fn samples(count: u32, stride: u32, direction: impl Fn(Vec2) -> Vec3) -> PixelSum {
        let mut stream = Stream::new(5, Purpose::Test, 0);
        let mut seen = PixelSum::default();
        for k in 0..count {
            let place = stream.uniform_2();
            let throughput = 1.0 / count as f32;
            let sky = (k % stride == 0).then(|| SkySample {
                direction: direction(place.into()).normalize(),
                throughput,
                way: 7,
            });
            seen.samples.push(SeenSample { place, background: Rgb::BLACK, point: None, sky });
        }
        seen
    }

    fn sun(environment: &Environment) -> Vec3 {
        let sky = Sky::new(environment, 1).unwrap();
        *sky.directions
            .iter()
            .max_by(|a, b| {
                environment.radiance(**a).luminance().total_cmp(&environment.radiance(**b).luminance())
            })
            .unwrap()
    }

    /// A pixel that covers 0.2 × 0.1 in the plane of projection around the sun sees the flux of the
    /// sun over that area, though no sample meets the sun. If only half of the samples take the way
    /// to the sky, it sees half of the light. Two standard errors of 35 draws of the sun are a
    /// third, and triangles of random samples overlap in some places and leave gaps in others.
    #[test]
    fn a_sun_that_no_sample_meets_is_found() {
        let (environment, flux) = sky();
        let toward = sun(&environment);
        let (right, up) = toward.any_orthonormal_pair();
        let map = |p: Vec2| toward + right * 0.2 * (p.x - 0.47) + up * 0.1 * (p.y - 0.53);
        let sky = Sky::new(&environment, 1).unwrap();
        for (stride, share) in [(1, 1.0), (2, 0.5)] {
            let found = sky.importance_least(&samples(128, stride, map));
            let expected = share * flux / 0.02;
            assert!((0.4..1.1).contains(&(found / expected)), "{found} for {expected}");
        }
    }

    /// The sun is beside the pixel, or too few samples leave the scene.
    #[test]
    fn a_sun_outside_the_pixel_is_not() {
        let (environment, _) = sky();
        let toward = sun(&environment);
        let (right, up) = toward.any_orthonormal_pair();
        let sky = Sky::new(&environment, 1).unwrap();
        let beside = |p: Vec2| toward + right * 0.2 * (p.x + 0.3) + up * 0.1 * (p.y - 0.5);
        let found = sky.importance_least(&samples(128, 1, beside));
        assert!(found < 3.0, "{found}: the rest of the sky");
        let inside = |p: Vec2| toward + right * 0.2 * (p.x - 0.5) + up * 0.1 * (p.y - 0.5);
        assert_eq!(sky.importance_least(&samples(128, 64, inside)), 0.0);
        assert!(Sky::new(&Environment::constant(Rgb::WHITE), 1).is_none());
    }
}
