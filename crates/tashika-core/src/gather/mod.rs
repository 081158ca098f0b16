//! Gather points: where the light that a pixel sees was last reflected, or scattered in a medium.
//!
//! A pixel is the sum over its gather points (Walter et al. 2006), each
//! weighted by pixel filter, lens and the specular surfaces on the way:
//!
//! ```text
//! L = B + Σ_j w_j Σ_i M_ji G_ji V_ji I_i        B = background: emission seen directly or through mirrors and glass
//! ```
//!
//! Camera samples are an Owen-scrambled Sobol' sequence keyed by (seed, pixel) (Burley 2020,
//! `sobol_burley`): film and lens in the first four dimensions, four more at each surface. When a
//! sample is seen by a camera that moves is a sequence of its own. Output is a function of scene,
//! camera, size, options, seed and pixel.
//!
//! A surface that both gathers and is specular, scatters to both sides, or is one of two materials,
//! does one of these at random ([`Scatter`]): the last of the four numbers chooses.

mod camera_path;
mod filter;
mod first;
mod options;
mod panes;
mod pyramid;
mod scatter;

#[cfg(test)]
mod tests;

pub use filter::Filter;
pub use options::GatherOptions;
pub use panes::{Passage, through_panes};
pub use scatter::{Scatter, SpecularPoint};

use camera_path::{CameraPath, End, Media};
use glam::{Vec2, Vec3};

use crate::accel::Tracer;
use crate::bsdf::{Bsdf, HenyeyGreenstein, Lambert};
use crate::color::Rgb;
use crate::film::PixelRecord;
use crate::math::{Frame, Instants, Ray};
use crate::media::{Leg, Scattering};
use crate::rng::{self, Purpose};
use crate::scene::{Camera, CameraSample, MediumId};

/// A point that gathers light from all VPLs: on a surface, or in a medium.
#[derive(Clone, Copy, Debug)]
pub struct GatherPoint {
    /// Position (m), already moved off its surface to the side of the viewer.
    pub position: Vec3,
    /// Unit geometric normal on the side of the viewer; in a medium the direction to the viewer.
    pub geometric_normal: Vec3,
    /// Shading frame; its axis is the shading normal on the side of the viewer.
    pub frame: Frame,
    /// Unit direction to the viewer, in the frame.
    pub wo: Vec3,
    /// How the surface scatters; black in a medium.
    pub bsdf: Bsdf,
    /// Weight `w_j` (unitless). The weights of a pixel's points sum to at most the squared index of
    /// refraction around the camera, in expectation.
    pub weight: Rgb,
    /// The medium that it gathers light from; nothing is vacuum.
    pub medium: Option<MediumId>,
    /// How the medium scatters, of a point that lies in it, and not on a surface.
    pub phase: Option<HenyeyGreenstein>,
    /// Number of the instant that it is of, and so the lights that light it ([`Instants`]).
    pub instant: u16,
}

impl GatherPoint {
    /// A point in a medium, where light is scattered into a path that came from the viewer.
    pub fn in_medium(&Scattering { place, before, medium, phase }: &Scattering, weight: Rgb) -> Self {
        Self {
            position: place,
            geometric_normal: -before,
            frame: Frame::about(-before),
            wo: Vec3::Z,
            bsdf: Bsdf::Lambert(Lambert { reflectance: Rgb::BLACK }),
            weight,
            medium: Some(medium),
            phase: Some(phase),
            instant: 0,
        }
    }

    /// The unit direction in which the path from the viewer came to a point in a medium.
    #[inline]
    pub fn before(&self) -> Vec3 {
        -self.geometric_normal
    }

    /// A rough overall reflectance, each channel in `[0, 1]`: white in a medium, where the weight has
    /// what is absorbed.
    pub fn albedo(&self) -> Rgb {
        if self.phase.is_some() { Rgb::WHITE } else { self.bsdf.albedo() }
    }
}

/// Averages over a pixel's camera samples for denoisers and compositing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Features {
    /// Mean distance to the first surface (m), over the samples that met one.
    pub depth: f32,
    /// Mean shading normal of the first surface (world), over the samples that met one.
    pub normal: Vec3,
    /// Mean rough reflectance of what gathers; white of media.
    pub albedo: Rgb,
    /// Share of samples that met a surface.
    pub coverage: f32,
}

/// The record of a pixel of which nothing else is known.
impl From<Features> for PixelRecord {
    fn from(features: Features) -> Self {
        let Features { depth, normal, albedo, coverage } = features;
        Self { depth, normal, albedo, coverage, ..Self::default() }
    }
}

/// The finite sum of one pixel, before any light is looked at.
#[derive(Clone, Debug, Default)]
pub struct PixelSum {
    /// Points that gather.
    pub points: Vec<GatherPoint>,
    /// Weighted emission that is seen without any VPL (W·m⁻²·sr⁻¹).
    pub background: Rgb,
    /// The camera samples that these come from.
    pub samples: Vec<SeenSample>,
    /// For denoisers and compositing.
    pub features: Features,
}

/// What a camera sample has seen.
#[derive(Clone, Copy, Debug)]
pub struct SeenSample {
    /// Where it went through the pixel: two uniform numbers that the filter takes.
    pub place: [f32; 2],
    /// Weighted emission that is seen without any VPL (W·m⁻²·sr⁻¹).
    pub background: Rgb,
    /// Its place among the points, if it met one.
    pub point: Option<u32>,
}

/// Everything that defines the gather points of an image.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// Size of the full image (pixels).
    pub size: [u32; 2],
    /// How many points, and how they are spread.
    pub gather: GatherOptions,
    /// Seed of the camera samples.
    pub seed: u64,
}

impl View<'_> {
    /// The camera ray of sample `index` of pixel `(x, y)`, if the film shows anything there, and
    /// the key of the sample's random decisions.
    pub fn camera_ray(&self, pixel: [u32; 2], index: u32) -> (Option<Ray>, u64) {
        self.camera_ray_at(pixel, index, || self.time(pixel, index))
    }

    /// The same at a time that is asked for if the camera moves.
    fn camera_ray_at(&self, pixel: [u32; 2], index: u32, time: impl FnOnce() -> f32) -> (Option<Ray>, u64) {
        let key = self.pixel_key(pixel);
        let u = sobol_burley::sample_4d(index, 0, key as u32);
        (self.ray_through(pixel, u, time), rng::key(key, Purpose::Gather, u64::from(index)))
    }

    /// When sample `index` of pixel `(x, y)` is: a share of the time that the shutter is open, 0 to 1.
    pub fn time(&self, pixel: [u32; 2], index: u32) -> f32 {
        let of_shutter = rng::key(self.pixel_key(pixel), Purpose::Shutter, 0);
        sobol_burley::sample_4d(index, 0, of_shutter as u32)[0]
    }

    /// The camera ray of pixel `(x, y)` for four uniform numbers: two for the filter, two for the
    /// lens; and one for the time, which a camera that stands does not ask for. `None` where the film
    /// shows nothing: there it is black.
    pub fn ray_through(&self, pixel: [u32; 2], u: [f32; 4], time: impl FnOnce() -> f32) -> Option<Ray> {
        let offset = Vec2::new(self.gather.filter.warp(u[0]), self.gather.filter.warp(u[1]));
        let film = Vec2::new(pixel[0] as f32 + 0.5, pixel[1] as f32 + 0.5) + offset;
        let time = if self.camera.motion.is_some() { time() } else { 0.0 };
        self.camera.ray(&CameraSample { film, lens: [u[2], u[3]], time }, self.size)
    }

    fn pixel_key(&self, pixel: [u32; 2]) -> u64 {
        rng::key(self.seed, Purpose::Gather, u64::from(pixel[1]) << 32 | u64::from(pixel[0]))
    }

    /// The view by so many camera samples of another seed.
    #[must_use]
    pub fn by(&self, count: u32, seed: u64) -> Self {
        Self { gather: GatherOptions { points: count, ..self.gather }, seed, ..*self }
    }

    /// The sum of one pixel over so many camera samples of another seed.
    pub fn samples(&self, tracer: &Tracer, pixel: [u32; 2], count: u32, seed: u64) -> PixelSum {
        self.by(count, seed).pixel(tracer, pixel)
    }

    /// What the first surfaces of one pixel are, over so many camera samples of another seed: of those
    /// that are seen through all media.
    pub fn features(&self, tracer: &Tracer, pixel: [u32; 2], count: u32, seed: u64) -> Features {
        self.by(count, seed).sum(tracer, pixel, Media::SeenThrough, None).features
    }

    /// The sum of one pixel of a scene that stands.
    pub fn pixel(&self, tracer: &Tracer, pixel: [u32; 2]) -> PixelSum {
        self.sum(tracer, pixel, Media::Count, None)
    }

    /// The sum of one pixel, each of whose samples is at one of some instants; where nothing moves and
    /// there is one instant, the camera goes on at all times.
    pub fn pixel_at(&self, tracer: &Tracer, pixel: [u32; 2], instants: &Instants) -> PixelSum {
        let is_still = instants.is_single() && !tracer.scene().moves();
        self.sum(tracer, pixel, Media::Count, (!is_still).then_some(instants))
    }

    /// The sum of one pixel; without instants, each sample is at a time of its own.
    fn sum(&self, tracer: &Tracer, pixel: [u32; 2], media: Media, instants: Option<&Instants>) -> PixelSum {
        let n = self.gather.points;
        let mut sum = PixelSum::default();
        let mut met = 0u32;
        let weight = 1.0 / n as f32;
        // Weight of basic radiance, which paths carry.
        let of_basic = weight * self.camera.squared_index();
        sum.samples.reserve_exact(n as usize);
        for index in 0..n {
            let time = || self.time(pixel, index);
            let (instant, share) = match instants {
                Some(instants) => instants.draw(time()),
                None if tracer.scene().moves() => (0, time()),
                None => (0, 0.0),
            };
            let (ray, key) =
                self.camera_ray_at(pixel, index, || if instants.is_some() { share } else { time() });
            let [x, y, ..] = sobol_burley::sample_4d(index, 0, self.pixel_key(pixel) as u32);
            // Each surface has a sequence of its own: projections of one long sequence to
            // dimensions that far apart would be worse than random.
            let choices = |bounce: u32| {
                let of_surface =
                    rng::key(self.pixel_key(pixel), Purpose::Gather, u64::MAX - u64::from(bounce));
                sobol_burley::sample_4d(index, 0, of_surface as u32)
            };
            let end = ray.map_or(End::NOTHING, |ray| {
                let leg = Leg { ray, medium: self.camera.medium };
                CameraPath { tracer, camera: self.camera, share, media, key }.follow(leg, choices)
            });
            sum.background += end.background * of_basic;
            sum.samples.push(SeenSample {
                place: [x, y],
                background: end.background * of_basic,
                point: end.point.is_some().then_some(sum.points.len() as u32),
            });
            if let Some(mut point) = end.point {
                point.weight *= of_basic;
                point.instant = instant;
                sum.features.albedo += point.albedo() * weight;
                sum.points.push(point);
            }
            if let Some(first) = end.first {
                met += 1;
                sum.features.depth += first.distance;
                sum.features.normal += first.normal;
            }
        }
        if met > 0 {
            sum.features.depth /= met as f32;
            sum.features.normal /= met as f32;
            sum.features.coverage = met as f32 / n as f32;
        }
        sum
    }
}
