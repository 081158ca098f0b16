//! Light from infinitely far away, from all directions.

use std::f32::consts::PI;

use glam::{Mat3, Vec3};

use super::texels::means_of_bilinear;
use super::{Image, SphereMap};
use crate::color::Rgb;
use crate::stats::Piecewise2d;

/// Radiance by direction: a constant, or an image in one of the layouts of [`SphereMap`].
#[derive(Clone, Debug)]
pub struct Environment {
    radiance: Radiance,
    /// Transform from the world to the frame of the image.
    to_local: Mat3,
    /// Mean radiance over the sphere (W·m⁻²·sr⁻¹).
    mean: Rgb,
}

#[derive(Clone, Debug)]
enum Radiance {
    Constant(Rgb),
    Map { image: Image, mapping: SphereMap, scale: Rgb, density: Box<Piecewise2d> },
}

impl Environment {
    /// An environment with the same radiance from all directions.
    pub fn constant(radiance: Rgb) -> Self {
        Self { radiance: Radiance::Constant(radiance), to_local: Mat3::IDENTITY, mean: radiance }
    }

    /// A latitude-longitude image times `scale`, turned by the rotation (or reflection) `to_world`.
    pub fn lat_long(image: Image, scale: Rgb, to_world: Mat3) -> Self {
        Self::map(image, SphereMap::LatLong, scale, to_world)
    }

    /// An equal-area octahedral image times `scale`, turned by the rotation (or reflection)
    /// `to_world`.
    pub fn octahedral(image: Image, scale: Rgb, to_world: Mat3) -> Self {
        Self::map(image, SphereMap::EqualArea, scale, to_world)
    }

    fn map(image: Image, mapping: SphereMap, scale: Rgb, to_world: Mat3) -> Self {
        let (w, h) = (image.width as usize, image.height as usize);
        let mut luminance = Vec::with_capacity(w * h);
        let mut mean = [0.0f64; 3];
        let mut solid_angle = 0.0;
        let sound = image.is_finite() && scale.is_valid();
        let size_of_row = |y: usize| mapping.size_of_row(y, h);
        for y in 0..h {
            let size = size_of_row(y);
            for x in 0..w {
                // `is_valid` rejects invalid radiances later; here they count as black, so that the
                // tables can be built.
                let c = image.texel(x as u32, y as u32).0 * scale;
                let c = if c.is_valid() { c } else { Rgb::BLACK };
                luminance.push(f64::from(c.luminance()));
                for (m, v) in mean.iter_mut().zip(c.to_array()) {
                    *m += f64::from(v) * size;
                }
                solid_angle += size;
            }
        }
        let mean = Rgb::from(mean.map(|m| (m / solid_angle) as f32));
        let mut weights = means_of_bilinear(&luminance, w, mapping.wrap());
        weights.iter_mut().enumerate().for_each(|(i, weight)| *weight *= size_of_row(i / w));
        match Piecewise2d::new(&weights, w) {
            None => Self::constant(if sound { Rgb::BLACK } else { Rgb::gray(f32::NAN) }),
            Some(density) => {
                let radiance = Radiance::Map { image, mapping, scale, density: Box::new(density) };
                Self { radiance, to_local: to_world.transpose(), mean }
            }
        }
    }

    /// Returns true if the environment emits no light.
    pub fn is_black(&self) -> bool {
        self.mean.is_black()
    }

    /// Mean radiance over the sphere (W·m⁻²·sr⁻¹).
    pub fn mean(&self) -> Rgb {
        self.mean
    }

    /// Size of the image (texels), if the environment is an image.
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
            Radiance::Map { image, mapping, scale, .. } => {
                let [u, v] = mapping.place(self.to_local * direction);
                image.bilinear(glam::Vec2::new(u, v), mapping.wrap()).0 * *scale
            }
        }
    }

    /// Samples a direction of view in proportion to the luminance seen along it; returns the
    /// direction with its density (sr⁻¹).
    pub fn sample(&self, u: [f32; 2]) -> (Vec3, f32) {
        match &self.radiance {
            Radiance::Constant(_) => (crate::warp::sphere(u), 1.0 / (4.0 * PI)),
            Radiance::Map { density, mapping, .. } => {
                let ([x, y], pdf) = density.sample(u.map(f64::from));
                let local = mapping.direction([x as f32, y as f32]);
                let direction = (self.to_local.transpose() * local).normalize();
                (direction, (pdf / f64::from(mapping.solid_angle(local))) as f32)
            }
        }
    }

    /// Number of steps of [`Self::read_ahead`].
    pub const READS: usize = 3;

    /// Reads ahead for [`Self::sample`] with the numbers `u`, and for the radiance of the sampled
    /// direction, in [`Self::READS`] steps. A step needs the read of the step before.
    #[inline]
    pub fn read_ahead(&self, u: [f32; 2], step: usize) {
        if let Radiance::Map { image, density, .. } = &self.radiance {
            let u = u.map(f64::from);
            match step {
                0 => density.read_guide_ahead(u),
                1 => density.read_items_ahead(u),
                _ => image.read_ahead(density.sample(u).0.map(|c| c as f32)),
            }
        }
    }

    /// Reads ahead the radiance and the density at a unit direction.
    #[inline]
    pub fn read_ahead_at(&self, direction: Vec3) {
        if let Radiance::Map { image, density, mapping, .. } = &self.radiance {
            let place = mapping.place(self.to_local * direction);
            image.read_ahead(place);
            density.read_ahead_at(place.map(f64::from));
        }
    }

    /// Returns the point of `[0, 1]²` that represents a unit direction in the layout of the image.
    /// For a constant environment the layout is equal-area.
    pub(super) fn place(&self, direction: Vec3) -> [f32; 2] {
        self.mapping().place(self.to_local * direction)
    }

    /// Returns the unit direction of a point of `[0, 1]²`, the inverse of [`Self::place`].
    pub(super) fn direction(&self, place: [f32; 2]) -> Vec3 {
        (self.to_local.transpose() * self.mapping().direction(place)).normalize()
    }

    fn mapping(&self) -> SphereMap {
        match &self.radiance {
            Radiance::Constant(_) => SphereMap::EqualArea,
            Radiance::Map { mapping, .. } => *mapping,
        }
    }

    /// Density of [`Environment::sample`] over the image, if the environment is an image.
    pub(super) fn density(&self) -> Option<&Piecewise2d> {
        match &self.radiance {
            Radiance::Constant(_) => None,
            Radiance::Map { density, .. } => Some(density),
        }
    }

    /// Density of [`Environment::sample`] at a unit direction (sr⁻¹).
    pub fn pdf(&self, direction: Vec3) -> f32 {
        match &self.radiance {
            Radiance::Constant(_) => 1.0 / (4.0 * PI),
            Radiance::Map { density, mapping, .. } => {
                let local = self.to_local * direction;
                let place = mapping.place(local).map(f64::from);
                (density.pdf(place) / f64::from(mapping.solid_angle(local))) as f32
            }
        }
    }

    /// Returns true if every texel is finite, and the scale is not negative.
    pub fn is_valid(&self) -> bool {
        match &self.radiance {
            Radiance::Constant(c) => c.is_valid(),
            Radiance::Map { image, scale, .. } => scale.is_valid() && image.is_finite(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};
    use crate::scene::Pixels;
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

    fn octahedral_sky() -> Environment {
        let side = 16;
        let mut pixels = vec![[0.2, 0.3, 0.4]; side * side];
        pixels[3 * side + 5] = [300.0, 200.0, 100.0];
        pixels[15 * side + 9] = [100.0; 3];
        let (width, height) = (side as u32, side as u32);
        let image = Image { name: "sky".into(), width, height, pixels: Pixels::Float(pixels) };
        Environment::octahedral(image, Rgb::gray(2.0), Mat3::from_rotation_x(0.7))
    }

    #[test]
    fn the_image_is_where_the_convention_says() {
        let mut pixels = vec![[0.0f32; 3]; 4 * 2];
        pixels[3] = [1.0; 3];
        let image = Image { name: "e".into(), width: 4, height: 2, pixels: Pixels::Float(pixels) };
        let e = Environment::lat_long(image, Rgb::WHITE, Mat3::IDENTITY);
        // Column 3 of 4 is centred on u = 0.875: between +x (0.75) and +z (1); row 0 is above the
        // horizon.
        let bright = Vec3::new(1.0, 2f32.sqrt(), 1.0).normalize();
        assert!(e.radiance(bright).r > 0.99, "{:?}", e.radiance(bright));
        assert!(e.radiance(Vec3::new(-1.0, 1.0, -1.0).normalize()).r < 1e-3);
    }

    #[test]
    fn what_is_no_radiance_is_not_valid_wherever_it_stands() {
        let map = |texels: &[f32]| {
            let pixels = Pixels::Float(texels.iter().map(|t| [*t; 3]).collect());
            let image = Image { name: "e".into(), width: texels.len() as u32, height: 1, pixels };
            Environment::lat_long(image, Rgb::WHITE, Mat3::IDENTITY)
        };
        assert!(map(&[0.0, 0.0]).is_valid() && map(&[0.0, 0.0]).is_black() && map(&[0.0, 1.0]).is_valid());
        for texels in [[f32::NAN; 2], [0.0, f32::NAN], [1.0, f32::INFINITY]] {
            assert!(!map(&texels).is_valid(), "{texels:?}");
        }
        assert!(map(&[-1.0, 0.0]).is_black() && map(&[-1.0, 2.0]).is_valid(), "below zero counts as 0");
    }

    /// The mean of radiance / pdf agrees with the integral over the sphere, to within five standard
    /// errors. The variance is small because the density follows the luminance, so this test is
    /// sharp.
    #[test]
    fn sampling_integrates_the_radiance() {
        sampling_integrates(&sky());
        sampling_integrates(&octahedral_sky());
    }

    fn sampling_integrates(e: &Environment) {
        let mut by_density = Moments::default();
        let mut uniform = Moments::default();
        let mut unequal = 0;
        let mut s = Stream::new(5, Purpose::Test, 0);
        for _ in 0..200_000 {
            let (d, pdf) = e.sample(s.uniform_2());
            // Rounding may move a direction across a border between texels.
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
