//! Intensity by direction, from an image: photometric data of lamps, slides of projectors.
//!
//! ```text
//! I(ω) = I₀ · t(ω)         t(ω) = image(u, v) · w(ω) / b      ≤ 1 in each channel
//! ```
//!
//! `I₀` is the brightest intensity (W·sr⁻¹), `(u, v)` the place of the direction in the layout, `w`
//! the weight of the layout, and `b` the largest texel times the largest weight. Directions are
//! sampled with a density that is constant over each texel of the image, in proportion to its mean
//! luminance, weight and solid angle. The density is above zero wherever `t` is.
//!
//! # Guarantee
//! No channel of `t` exceeds 1, also in `f32`: a light of intensity `I₀` in all directions is an
//! upper bound. The intensity in a sampled direction, divided by the density, is an unbiased
//! estimate of the integral for every image. Checked by the tests below and by
//! `suite::light_images`.

use std::sync::Arc;

use glam::{Mat3, Vec2, Vec3};

use super::SphereMap;
use super::texels::means_of_bilinear;
use super::{Falloff, Image, Sampling, Wrap};
use crate::color::Rgb;
use crate::stats::Piecewise2d;

/// Directions into which an image emits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spread {
    /// All directions.
    Sphere(SphereMap),
    /// Through a pinhole along `+z`: `x/z = (2u − 1) · tan₀`, `y/z = (2v − 1) · tan₁`, `v` from the
    /// top row.
    Slide {
        /// Half the size of the image at distance 1 along each axis; above 0, finite.
        tan: [f32; 2],
        /// Factor on the image by direction.
        weight: SlideWeight,
    },
}

/// Factor on the image of a slide, at the angle `θ` from the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SlideWeight {
    /// 1: texels are intensities.
    Even,
    /// `1/cos³ θ`: the irradiance on a screen at right angles to the axis is proportional to the
    /// image.
    Screen,
    /// Falloff of a spot light.
    Spot(Falloff),
}

/// Interpolation of texels, and continuation of the image beyond its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lookup {
    /// Interpolation between texels.
    pub sampling: Sampling,
    /// Wrapping beyond the sides, and beyond top and bottom, for bilinear lookups at the edge. For
    /// slides only; the wrapping of spheres is that of their [`SphereMap`].
    pub wrap: [Wrap; 2],
}

/// Intensity by direction, in the local frame of the map.
#[derive(Debug)]
pub struct IntensityMap {
    image: Image,
    spread: Spread,
    lookup: Lookup,
    /// Largest texel times the largest weight (`b`), by channel.
    brightest: Rgb,
    /// `∫ image · w dω` (sr).
    integral: Rgb,
    density: Piecewise2d,
}

/// Factor by which rounding may increase a weight.
const ROUNDED: f32 = 1.0 + 1e-5;

impl IntensityMap {
    /// Creates a map from an image of finite texels; texels below zero count as 0. `None` if the
    /// map is black.
    pub fn new(image: Image, spread: Spread, lookup: Lookup) -> Option<Self> {
        let wrap = match spread {
            Spread::Sphere(map) => map.wrap(),
            Spread::Slide { .. } => lookup.wrap,
        };
        let lookup = Lookup { wrap, ..lookup };
        let (w, h) = (image.width as usize, image.height as usize);
        let texels: Vec<Rgb> = (0..w * h)
            .map(|i| image.texel((i % w) as u32, (i / w) as u32).0)
            // The builder rejects invalid texels later; here they count as black, so that the
            // tables can be built.
            .map(|c| if c.is_valid() { c } else { Rgb::BLACK })
            .collect();
        let luminance: Vec<f64> = texels.iter().map(|c| f64::from(c.luminance())).collect();
        let mut weights = match lookup.sampling {
            Sampling::Bilinear => means_of_bilinear(&luminance, w, wrap),
            Sampling::Nearest => luminance,
        };
        let mut integral = [0.0f64; 3];
        let mut brightest = Rgb::BLACK;
        for (i, (texel, weight)) in texels.iter().zip(&mut weights).enumerate() {
            let [x, y] = [i % w, i / w];
            let place = [(x as f32 + 0.5) / w as f32, (y as f32 + 0.5) / h as f32];
            let d = spread.direction(place);
            let solid_angle = spread.solid_angle(d) / (w * h) as f32;
            let here = spread.weight(d) * solid_angle;
            for (sum, c) in integral.iter_mut().zip(texel.to_array()) {
                *sum += f64::from(c * here);
            }
            // A texel at the rim of a spot may be lit only in part. The density therefore uses the
            // weight at the texel's point nearest to the axis.
            let nearest = |k: usize, n: usize| 0.5f32.clamp(k as f32 / n as f32, (k + 1) as f32 / n as f32);
            let lit = match spread {
                Spread::Slide { weight: SlideWeight::Spot(_), .. } => {
                    spread.weight(spread.direction([nearest(x, w), nearest(y, h)])) * solid_angle
                }
                _ => here,
            };
            *weight *= f64::from(lit);
            brightest = brightest.zip(*texel, f32::max);
        }
        let density = Piecewise2d::new(&weights, w)?;
        let brightest = brightest * spread.largest_weight();
        let integral = Rgb::from(integral.map(|sum| sum as f32));
        Some(Self { image, spread, lookup, brightest, integral, density })
    }

    pub(super) fn image(&self) -> &Image {
        &self.image
    }

    /// Largest texel times the largest weight, by channel: ratio of the brightest intensity to the
    /// intensity where `image · w` is 1.
    pub fn brightest(&self) -> Rgb {
        self.brightest
    }

    /// Integral of the product of image and weight over all directions, `∫ image · w dω`, by the
    /// midpoints of the texels (sr).
    pub fn integral(&self) -> Rgb {
        self.integral
    }

    /// Cosine of the largest angle from `+z` at which the map emits; −1 for all directions.
    pub fn cos_outer(&self) -> f32 {
        match self.spread {
            Spread::Sphere(_) => -1.0,
            Spread::Slide { tan: [x, y], weight } => {
                let corner = 1.0 / (1.0 + x * x + y * y).sqrt() / ROUNDED;
                match weight {
                    SlideWeight::Spot(falloff) => corner.max(falloff.cos_outer),
                    SlideWeight::Even | SlideWeight::Screen => corner,
                }
            }
        }
    }

    /// Returns `t` in a unit direction: at most 1 in each channel.
    fn relative(&self, d: Vec3) -> Rgb {
        let Some([u, v]) = self.spread.place(d) else { return Rgb::BLACK };
        let uv = Vec2::new(u, v);
        let texel = match self.lookup.sampling {
            Sampling::Bilinear => self.image.bilinear(uv, self.lookup.wrap),
            Sampling::Nearest => self.image.nearest(uv, [Wrap::Clamp; 2]),
        };
        let value = (texel.0 * self.spread.weight(d)).to_array();
        let brightest = self.brightest.to_array();
        let share = |k: usize| if brightest[k] > 0.0 { (value[k] / brightest[k]).min(1.0) } else { 0.0 };
        Rgb::new(share(0), share(1), share(2))
    }

    /// Samples a unit direction; returns it with its density (sr⁻¹).
    fn sample(&self, u: [f32; 2]) -> (Vec3, f32) {
        let (place, density) = self.density.sample(u.map(f64::from));
        let d = self.spread.direction(place.map(|v| v as f32));
        (d, (density / f64::from(self.spread.solid_angle(d))) as f32)
    }
}

impl Spread {
    /// Returns the place of a unit direction in the image, if it has one.
    fn place(self, d: Vec3) -> Option<[f32; 2]> {
        match self {
            Self::Sphere(map) => Some(map.place(d)),
            Self::Slide { tan, .. } => {
                let at = [d.x, d.y].map(|v| v / d.z);
                let place = [0, 1].map(|k| 0.5 + 0.5 * (at[k] / tan[k]));
                let is_inside = d.z > 0.0 && place.iter().all(|v| (0.0..=1.0).contains(v));
                is_inside.then_some(place)
            }
        }
    }

    fn direction(self, [u, v]: [f32; 2]) -> Vec3 {
        match self {
            Self::Sphere(map) => map.direction([u, v]),
            Self::Slide { tan: [x, y], .. } => {
                Vec3::new((2.0 * u - 1.0) * x, (2.0 * v - 1.0) * y, 1.0).normalize()
            }
        }
    }

    /// Solid angle per area of the image, whose whole area is 1, at a unit direction (sr).
    fn solid_angle(self, d: Vec3) -> f32 {
        match self {
            Self::Sphere(map) => map.solid_angle(d),
            Self::Slide { tan: [x, y], .. } => 4.0 * x * y * (d.z * d.z * d.z),
        }
    }

    fn weight(self, d: Vec3) -> f32 {
        match self {
            Self::Sphere(_) | Self::Slide { weight: SlideWeight::Even, .. } => 1.0,
            Self::Slide { weight: SlideWeight::Screen, .. } => 1.0 / (d.z * d.z * d.z),
            Self::Slide { weight: SlideWeight::Spot(falloff), .. } => falloff.at(d.z),
        }
    }

    fn largest_weight(self) -> f32 {
        match self {
            Self::Slide { tan: [x, y], weight: SlideWeight::Screen } => {
                let squared = 1.0 + x * x + y * y;
                squared * squared.sqrt() * ROUNDED
            }
            _ => 1.0,
        }
    }
}

/// Intensity map in the scene, turned to its direction.
#[derive(Clone, Debug)]
pub struct AimedMap {
    map: Arc<IntensityMap>,
    to_local: Mat3,
}

impl AimedMap {
    /// Turns a map by the rotation (or reflection) `to_world`.
    pub(super) fn new(map: Arc<IntensityMap>, to_world: Mat3) -> Self {
        Self { map, to_local: to_world.transpose() }
    }

    /// The map in its own frame.
    pub fn map(&self) -> &IntensityMap {
        &self.map
    }

    /// Unit axis: `+z` of the map's frame, in the world.
    pub(super) fn axis(&self) -> Vec3 {
        (self.to_local.transpose() * Vec3::Z).normalize()
    }

    /// Share of the brightest intensity in a unit direction: at most 1 in each channel.
    pub fn relative(&self, direction: Vec3) -> Rgb {
        self.map.relative(self.to_local * direction)
    }

    /// Samples a unit direction; returns it with its density (sr⁻¹).
    pub fn sample(&self, u: [f32; 2]) -> (Vec3, f32) {
        let (local, density) = self.map.sample(u);
        ((self.to_local.transpose() * local).normalize(), density)
    }

    /// Returns the numbers that [`AimedMap::sample`] maps to a unit direction; arbitrary numbers if
    /// the direction is outside of the image.
    pub fn inverse(&self, direction: Vec3) -> [f32; 2] {
        let place = self.map.spread.place(self.to_local * direction).unwrap_or_default();
        self.map.density.inverse(place.map(f64::from)).map(|u| (u as f32).min(1.0f32.next_down()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};
    use crate::scene::{FalloffShape, Pixels};
    use crate::stats::Moments;
    use crate::warp;

    /// Rotated maps of every spread, weight and lookup.
    fn maps() -> Vec<AimedMap> {
        let pixels: Vec<[f32; 3]> = (0..42)
            .map(|i| if i % 5 < 2 { [0.0; 3] } else { [0.1 * i as f32, 3.0, f32::from(i % 7 == 0)] })
            .collect();
        let image = || Image { name: "i".into(), width: 7, height: 6, pixels: Pixels::Float(pixels.clone()) };
        let falloff = Falloff { cos_inner: 0.95, cos_outer: 0.85, shape: FalloffShape::LinearInAngle };
        let slide = |weight| Spread::Slide { tan: [0.9, 0.5], weight };
        let spreads = [
            Spread::Sphere(SphereMap::LatLong),
            Spread::Sphere(SphereMap::EqualArea),
            slide(SlideWeight::Even),
            slide(SlideWeight::Screen),
            slide(SlideWeight::Spot(falloff)),
        ];
        let turn = Mat3::from_rotation_x(0.4) * Mat3::from_diagonal(Vec3::new(-1.0, 1.0, 1.0));
        let mut maps = Vec::new();
        for spread in spreads {
            for sampling in [Sampling::Bilinear, Sampling::Nearest] {
                for wrap in [Wrap::Repeat, Wrap::Black] {
                    let map = IntensityMap::new(image(), spread, Lookup { sampling, wrap: [wrap; 2] });
                    maps.push(AimedMap::new(Arc::new(map.unwrap()), turn));
                }
            }
        }
        maps
    }

    /// The mean of the intensity over the density, for sampled directions, agrees with the integral
    /// by uniform directions. The density is above zero at every sample.
    #[test]
    fn drawn_directions_carry_the_whole_light() {
        for map in maps() {
            let mut s = Stream::new(1, Purpose::Test, 0);
            let (mut drawn, mut uniform) = (Moments::default(), Moments::default());
            let mut integral = Moments::default();
            for _ in 0..200_000 {
                let (direction, density) = map.sample(s.uniform_2());
                let t = map.relative(direction);
                assert!(t.max_channel() <= 1.0 && density > 0.0);
                drawn.push(f64::from(t.luminance() / density));
                integral.push(f64::from(((t * map.map().brightest()) / density).luminance()));
                let u = warp::sphere(s.uniform_2());
                let t = map.relative(u);
                uniform.push(f64::from(t.luminance()) * 4.0 * std::f64::consts::PI);
                assert!(t.is_black() || map.axis().dot(u) > map.map().cos_outer() - 1e-6);
            }
            let error = drawn.standard_error().hypot(uniform.standard_error());
            let found = (drawn.mean(), uniform.mean());
            assert!((found.0 - found.1).abs() < 5.0 * error && error < 0.02 * found.1, "{found:?} ± {error}");
            // The midpoint rule is coarse: a texel is up to a sixth of the image wide.
            let by_midpoints = f64::from(map.map().integral().luminance());
            assert!((integral.mean() / by_midpoints - 1.0).abs() < 0.3, "{} {by_midpoints}", integral.mean());
        }
    }

    #[test]
    fn numbers_lead_to_directions_and_back() {
        let mut s = Stream::new(2, Purpose::Test, 0);
        for map in maps() {
            for _ in 0..2000 {
                let u = s.uniform_2();
                let (direction, _) = map.sample(u);
                let again = map.sample(map.inverse(direction)).0;
                assert!((again - direction).length() < 1e-3, "{u:?}: {direction} {again}");
            }
        }
    }
}
