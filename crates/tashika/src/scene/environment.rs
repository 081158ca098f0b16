//! Light from infinitely far away, from all directions.

use std::f32::consts::PI;

use glam::{Mat3, Vec3};

use super::{Image, Pixels, Wrap};
use crate::color::Rgb;
use crate::math::elementary::{atan2, sin_cos};
use crate::stats::Piecewise2d;

/// Radiance by direction.
///
/// A latitude-longitude image has its pole at `+y` of its own frame: row `v` in `[0, 1]` from the top is the
/// polar angle `θ = π v`, column `u` is the azimuth, and `u = 0.5` looks along `−z`, `u = 0.75` along `+x`.
#[derive(Clone, Debug)]
pub struct Environment {
    radiance: Radiance,
    /// World to the frame of the image.
    to_local: Mat3,
    /// Mean radiance over the sphere (W·m⁻²·sr⁻¹).
    mean: Rgb,
}

#[derive(Clone, Debug)]
enum Radiance {
    Constant(Rgb),
    Map { image: Image, scale: Rgb, density: Box<Piecewise2d> },
}

/// The solid angle of a texel at the poles does not quite vanish.
const SMALLEST_SINE: f32 = 1e-5;

impl Environment {
    /// The same radiance from everywhere.
    pub fn constant(radiance: Rgb) -> Self {
        Self { radiance: Radiance::Constant(radiance), to_local: Mat3::IDENTITY, mean: radiance }
    }

    /// A latitude-longitude image times `scale`, turned by the rotation `to_world`.
    pub fn lat_long(image: Image, scale: Rgb, to_world: Mat3) -> Self {
        let (w, h) = (image.width as usize, image.height as usize);
        let mut luminance = Vec::with_capacity(w * h);
        let mut mean = [0.0f64; 3];
        let mut solid_angle = 0.0;
        for y in 0..h {
            let sin = f64::from(sin_cos(PI * (y as f32 + 0.5) / h as f32).0);
            for x in 0..w {
                let c = image.texel(x as u32, y as u32).0 * scale;
                luminance.push(f64::from(c.luminance()));
                for (m, v) in mean.iter_mut().zip(c.to_array()) {
                    *m += f64::from(v) * sin;
                }
                solid_angle += sin;
            }
        }
        let mean = Rgb::new(
            (mean[0] / solid_angle) as f32,
            (mean[1] / solid_angle) as f32,
            (mean[2] / solid_angle) as f32,
        );
        // The mean of the bilinear interpolation over a texel, which is what a lookup in it returns on average, mixes in an
        // eighth of each neighbour.
        let at = |x: usize, y: usize| luminance[y * w + x];
        let across =
            |x: usize, y: usize| (at((x + w - 1) % w, y) + 6.0 * at(x, y) + at((x + 1) % w, y)) / 8.0;
        let mut weights = Vec::with_capacity(w * h);
        for y in 0..h {
            let sin = f64::from(sin_cos(PI * (y as f32 + 0.5) / h as f32).0);
            let (above, below) = (y.saturating_sub(1), (y + 1).min(h - 1));
            weights.extend(
                (0..w).map(|x| (across(x, above) + 6.0 * across(x, y) + across(x, below)) / 8.0 * sin),
            );
        }
        match Piecewise2d::new(&weights, w) {
            None => Self::constant(Rgb::BLACK),
            Some(density) => {
                let radiance = Radiance::Map { image, scale, density: Box::new(density) };
                Self { radiance, to_local: to_world.transpose(), mean }
            }
        }
    }

    /// Whether no light comes from anywhere.
    pub fn is_black(&self) -> bool {
        self.mean.is_black()
    }

    /// Mean radiance over the sphere (W·m⁻²·sr⁻¹).
    pub fn mean(&self) -> Rgb {
        self.mean
    }

    /// Image size, if it is an image.
    pub fn resolution(&self) -> Option<[u32; 2]> {
        match &self.radiance {
            Radiance::Constant(_) => None,
            Radiance::Map { image, .. } => Some([image.width, image.height]),
        }
    }

    /// Radiance seen looking along the unit vector `direction` (W·m⁻²·sr⁻¹).
    pub fn radiance(&self, direction: Vec3) -> Rgb {
        match &self.radiance {
            Radiance::Constant(c) => *c,
            Radiance::Map { image, scale, .. } => {
                let [u, v] = self.to_map(direction);
                image.bilinear(glam::Vec2::new(u, v), [Wrap::Repeat, Wrap::Clamp]).0 * *scale
            }
        }
    }

    /// A direction to look along, and its density (sr⁻¹), in proportion to luminance.
    pub fn sample(&self, u: [f32; 2]) -> (Vec3, f32) {
        match &self.radiance {
            Radiance::Constant(_) => (crate::warp::sphere(u), 1.0 / (4.0 * PI)),
            Radiance::Map { density, .. } => {
                let ([x, y], pdf) = density.sample(u.map(f64::from));
                let (sin_theta, cos_theta) = sin_cos(PI * y as f32);
                let sin_theta = sin_theta.max(SMALLEST_SINE);
                let (sin_phi, cos_phi) = sin_cos(2.0 * PI * (x as f32 - 0.5));
                let local = Vec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi);
                let direction = (self.to_local.transpose() * local).normalize();
                (direction, (pdf / (2.0 * f64::from(PI * PI) * f64::from(sin_theta))) as f32)
            }
        }
    }

    /// Density of [`Environment::sample`] (sr⁻¹).
    pub fn pdf(&self, direction: Vec3) -> f32 {
        match &self.radiance {
            Radiance::Constant(_) => 1.0 / (4.0 * PI),
            Radiance::Map { density, .. } => {
                let [u, v] = self.to_map(direction);
                let local = self.to_local * direction;
                let sin_theta = horizontal(local).max(SMALLEST_SINE);
                (density.pdf([f64::from(u), f64::from(v)])
                    / (2.0 * f64::from(PI * PI) * f64::from(sin_theta))) as f32
            }
        }
    }

    fn to_map(&self, direction: Vec3) -> [f32; 2] {
        let d = self.to_local * direction;
        let u = atan2(d.x, -d.z) / (2.0 * PI) + 0.5;
        // Near the poles the arc cosine of a rounded cosine would be noise.
        [u.rem_euclid(1.0), atan2(horizontal(d), d.y) / PI]
    }

    /// Whether every texel is finite and not negative.
    pub fn is_valid(&self) -> bool {
        match &self.radiance {
            Radiance::Constant(c) => c.is_valid(),
            Radiance::Map { image, scale, .. } => {
                scale.is_valid()
                    && match &image.pixels {
                        Pixels::Float(p) => p.iter().flatten().all(|v| v.is_finite() && *v >= 0.0),
                        Pixels::Srgb8(_) | Pixels::Linear8(_) => true,
                    }
            }
        }
    }
}

/// Distance from the polar axis.
fn horizontal(d: Vec3) -> f32 {
    (d.x * d.x + d.z * d.z).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};
    use crate::stats::Moments;

    fn sky() -> Environment {
        let (w, h) = (16, 8);
        let mut pixels = vec![[0.2, 0.3, 0.4]; w * h];
        pixels[2 * w + 5] = [500.0, 400.0, 300.0];
        for p in &mut pixels[6 * w..] {
            *p = [0.0; 3];
        }
        let image =
            Image { name: "sky".into(), width: w as u32, height: h as u32, pixels: Pixels::Float(pixels) };
        Environment::lat_long(image, Rgb::gray(2.0), Mat3::from_rotation_y(0.7))
    }

    #[test]
    fn the_image_is_where_the_convention_says() {
        let mut pixels = vec![[0.0f32; 3]; 4 * 2];
        pixels[3] = [1.0; 3];
        let image = Image { name: "e".into(), width: 4, height: 2, pixels: Pixels::Float(pixels) };
        let e = Environment::lat_long(image, Rgb::WHITE, Mat3::IDENTITY);
        // Column 3 of 4 is centred on u = 0.875: between +x (0.75) and +z (1); row 0 is above the horizon.
        let bright = Vec3::new(1.0, 2f32.sqrt(), 1.0).normalize();
        assert!(e.radiance(bright).r > 0.99, "{:?}", e.radiance(bright));
        assert!(e.radiance(Vec3::new(-1.0, 1.0, -1.0).normalize()).r < 1e-3);
    }

    /// E[radiance / pdf] is the integral over the sphere; the variance is small because the density follows
    /// the luminance, so five standard errors are a sharp test.
    #[test]
    fn sampling_integrates_the_radiance() {
        let e = sky();
        let mut by_density = Moments::default();
        let mut uniform = Moments::default();
        let mut unequal = 0;
        let mut s = Stream::new(5, Purpose::Test, 0);
        for _ in 0..200_000 {
            let (d, pdf) = e.sample(s.uniform_2());
            // Directions on a border between texels may round to the other side.
            unequal += u32::from((e.pdf(d) / pdf - 1.0).abs() > 1e-3);
            by_density.push(f64::from(e.radiance(d).luminance() / pdf));
            let d = crate::warp::sphere(s.uniform_2());
            uniform.push(f64::from(e.radiance(d).luminance()) * 4.0 * std::f64::consts::PI);
        }
        assert!(unequal < 40, "{unequal} of 200000");
        let error = by_density.standard_error().hypot(uniform.standard_error());
        assert!((by_density.mean() - uniform.mean()).abs() < 5.0 * error);
        assert!(by_density.standard_error() < 0.5 * uniform.standard_error());
    }
}
