//! Sky that a pixel sees, however small its bright parts are.
//!
//! The sun, seen directly or through a ball of glass, may cover a thousandth of a pixel and
//! outshine all else in it, yet most sets of a hundred camera samples miss it. The samples that
//! left the scene nevertheless show its place. Near one of them, the map from the place `p` in the
//! pixel to the direction `ω` in which the path leaves is nearly linear, with a matrix `A` that is
//! fitted to its neighbours. Let directions `ω_i` be drawn in proportion to the luminance of the
//! sky, whose integral over the sphere is `E`. The luminance of the sky in the pixel is then
//!
//! ```text
//! L = (E/N) Σ_i q_i T_i / |det A_i|          over the directions whose place lies in the pixel
//! ```
//!
//! with the throughput `T_i` of the nearest path, and the share `q_i` of the samples around it
//! whose paths take the same way, over the same surfaces by reflection or transmission. Each way
//! has a map of its own.
//!
//! # Held to this by
//! The tests below, and the suite's `hard_light`.

use crate::gather::{PixelSum, SkySample};
use crate::math::{Mat2, Vec2, Vec3};
use crate::rng::{Purpose, Stream};
use crate::scene::Environment;

/// Number of directions drawn from the sky.
const DIRECTIONS: usize = 64;
/// Number of neighbours to which the map is fitted.
const NEIGHBOURS: usize = 5;
/// Largest distance of a direction's place from the nearest sample, over that of the farthest
/// neighbour.
const MAX_EXTRAPOLATION: f32 = 1.5;
/// Largest root mean square residual of the fit, over the root mean square of the directions.
const MAX_RESIDUAL: f32 = 0.5;
/// Least cosine between a direction and the nearest sample.
const MIN_COSINE: f32 = 0.5;

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
        let (mut sum, mut squares, mut largest) = (0.0, 0.0, 0.0_f64);
        for of_way in exits.chunk_by(|a, b| a.sky.way == b.sky.way).filter(|way| way.len() > NEIGHBOURS) {
            for direction in &self.directions {
                let Some(found) = density(of_way, seen, *direction) else { continue };
                let throughput = f64::from(found.throughput) * seen.samples.len() as f64;
                let value = self.each * throughput * f64::from(found.per_solid_angle);
                sum += value;
                squares += value * value;
                largest = largest.max(throughput);
            }
        }
        (sum - 2.0 * squares.sqrt()).clamp(0.0, largest * self.brightest)
    }
}

/// Camera sample that left the scene.
#[derive(Clone, Copy)]
struct Exit {
    place: Vec2,
    sky: SkySample,
}

/// Density of the paths of a pixel at a direction.
struct Density {
    /// Share of the pixel by solid angle, `q / |det A|` (sr⁻¹).
    per_solid_angle: f32,
    /// Throughput of the nearest path, over the number of samples.
    throughput: f32,
}

/// Density of the paths of one way that leave in a direction. `None` if no place of the pixel sees
/// it, or if the samples around that place do not map linearly.
fn density(exits: &[Exit], seen: &PixelSum, direction: Vec3) -> Option<Density> {
    let cosine = |exit: &Exit| exit.sky.direction.dot(direction);
    let nearest = exits.iter().max_by(|a, b| cosine(a).total_cmp(&cosine(b)))?;
    if cosine(nearest) < MIN_COSINE {
        return None;
    }
    // Gnomonic projection around the nearest direction.
    let (right, up) = nearest.sky.direction.any_orthonormal_pair();
    let projected = |d: Vec3| Vec2::new(d.dot(right), d.dot(up)) / d.dot(nearest.sky.direction);
    let mut offsets: Vec<(Vec2, Vec2)> = exits
        .iter()
        .filter(|exit| exit.place != nearest.place && exit.sky.direction.dot(nearest.sky.direction) > 0.0)
        .map(|exit| (exit.place - nearest.place, projected(exit.sky.direction)))
        .collect();
    offsets.sort_unstable_by(|a, b| a.0.length_squared().total_cmp(&b.0.length_squared()));
    let neighbours = offsets.get(..NEIGHBOURS)?;
    let radius = neighbours[NEIGHBOURS - 1].0.length();
    let map = fitted(neighbours)?;
    let area = map.determinant().abs();
    let place = map.inverse() * projected(direction);
    let in_pixel = nearest.place + place;
    let is_inside = in_pixel.min_element() >= 0.0 && in_pixel.max_element() <= 1.0;
    if !is_inside || place.length() > MAX_EXTRAPOLATION * radius {
        return None;
    }
    let around =
        seen.samples.iter().filter(|s| Vec2::from(s.place).distance(nearest.place) <= radius).count();
    let share = (NEIGHBOURS + 1) as f32 / around.max(NEIGHBOURS + 1) as f32;
    Some(Density { per_solid_angle: share / area, throughput: nearest.sky.throughput })
}

/// Matrix that maps offsets in the pixel to projected directions, by least squares. `None` if the
/// offsets lie on a line, if the matrix has no inverse, or if the map is not linear.
fn fitted(neighbours: &[(Vec2, Vec2)]) -> Option<Mat2> {
    let (mut of_offsets, mut mixed) = (Mat2::ZERO, Mat2::ZERO);
    for (offset, direction) in neighbours {
        of_offsets += Mat2::from_cols(*offset * offset.x, *offset * offset.y);
        mixed += Mat2::from_cols(*direction * offset.x, *direction * offset.y);
    }
    let trace = of_offsets.x_axis.x + of_offsets.y_axis.y;
    if of_offsets.determinant() <= 1e-4 * trace * trace {
        return None;
    }
    let map = mixed * of_offsets.inverse();
    let residual: f32 = neighbours.iter().map(|(o, d)| (*d - map * *o).length_squared()).sum();
    let whole: f32 = neighbours.iter().map(|(_, d)| d.length_squared()).sum();
    let has_inverse = map.determinant().abs() > 1e-12;
    (has_inverse && residual <= MAX_RESIDUAL * MAX_RESIDUAL * whole).then_some(map)
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
    /// third, and the share of the way is that of a dozen samples.
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
        assert_eq!(sky.importance_least(&samples(128, 26, inside)), 0.0);
        assert!(Sky::new(&Environment::constant(Rgb::WHITE), 1).is_none());
    }
}
