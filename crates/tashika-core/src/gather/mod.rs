//! Gather points: the points at which light was last reflected, or scattered in a medium, before it
//! reached the camera.
//!
//! A pixel is the sum over its gather points (Walter et al. 2006), each weighted by the pixel
//! filter, the lens and the specular surfaces on its path:
//!
//! ```text
//! L = B + Σ_j w_j Σ_i M_ji G_ji V_ji I_i        B = background: emission seen directly or through mirrors and glass
//! ```
//!
//! Film and lens positions are an Owen-scrambled Sobol' sequence keyed by (seed, pixel) (Burley
//! 2020, `sobol_burley`). The four numbers at each surface, and the time of a sample, come from
//! separate sequences. Output is a function of scene, camera, size, options, seed and pixel.
//!
//! A surface may have several parts: a gathering and a specular part, a part for each side, or two
//! materials. Each sample selects one of them at random ([`Scatter`]), by the last of the surface's
//! four numbers.
//!
//! The gather points of a pixel of [sensors](crate::scene::Sensor) are given: they are white, and
//! no path leads to them from a camera.

mod camera_path;
mod features;
mod filter;
mod first;
mod options;
mod panes;
mod pyramid;
mod scatter;

#[cfg(test)]
mod tests;

pub use features::{FeatureSums, Features, FirstSurface};
pub use filter::Filter;
pub use options::GatherOptions;
pub use panes::{Passage, through_panes};
pub use scatter::{Scatter, SpecularPoint};

use camera_path::{CameraPath, End, Media};
use glam::{Vec2, Vec3};

use crate::accel::Tracer;
use crate::bsdf::{Bsdf, HenyeyGreenstein, Lambert};
use crate::color::Rgb;
use crate::film::Window;
use crate::math::{Frame, Instants, Ray, offset_from_surface};
use crate::media::{Leg, Scattering};
use crate::rng::{self, Purpose, Stream};
use crate::scene::{Camera, CameraSample, MediumId, Sensor};

/// Relative error of the position of a sensor, which files and transforms may have rounded.
const SENSOR_ERROR: f32 = 4.0 * f32::EPSILON;

/// Most draws of a pixel that has a sensor, before the first such pixel is taken.
const MAX_DRAWS: u32 = 256;
/// Number of pixels that a sensor counts for in guidance. Chosen.
const PIXELS_OF_SENSOR: u64 = 1024;

/// Point that gathers light from all VPLs: on a surface, or in a medium.
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
    /// BSDF of the surface; black in a medium.
    pub bsdf: Bsdf,
    /// Weight `w_j` (unitless). The weights of a pixel's points sum to at most the squared index of
    /// refraction around the camera, in expectation.
    pub weight: Rgb,
    /// Medium through which light reaches the point; `None` is vacuum.
    pub medium: Option<MediumId>,
    /// Phase function of the medium, for a point in a medium; `None` on a surface.
    pub phase: Option<HenyeyGreenstein>,
    /// Number of the point's instant ([`Instants`]); only lights of this instant illuminate the
    /// point.
    pub instant: u16,
}

impl GatherPoint {
    /// Makes a gather point in a medium, where light is scattered into a path that came from the
    /// viewer.
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

    /// Makes a gather point on a plane sensor in a medium: white and diffuse, so that its radiance
    /// is the irradiance over π.
    pub fn on_sensor(sensor: &Sensor, medium: Option<MediumId>) -> Self {
        let normal = sensor.normal;
        // A sensor that lies in a surface of the scene measures in front of it.
        let error = sensor.position.abs() * SENSOR_ERROR;
        Self {
            position: offset_from_surface(sensor.position, error, normal),
            geometric_normal: normal,
            frame: Frame::about(normal),
            wo: Vec3::Z,
            bsdf: Bsdf::Lambert(Lambert { reflectance: Rgb::WHITE }),
            weight: Rgb::WHITE,
            medium,
            phase: None,
            instant: 0,
        }
    }

    /// Returns the unit direction in which the path from the viewer reached a point in a medium.
    #[inline]
    pub fn before(&self) -> Vec3 {
        -self.geometric_normal
    }

    /// Returns a rough overall reflectance, each channel in `[0, 1]`; white in a medium, where the
    /// weight contains the absorption.
    pub fn albedo(&self) -> Rgb {
        if self.phase.is_some() { Rgb::WHITE } else { self.bsdf.albedo() }
    }
}

/// Finite sum of one pixel, before any VPL contributes.
#[derive(Clone, Debug, Default)]
pub struct PixelSum {
    /// Gather points, one for each sample that reached one.
    pub points: Vec<GatherPoint>,
    /// Weighted emission that is visible without any VPL (W·m⁻²·sr⁻¹).
    pub background: Rgb,
    /// Camera samples of the pixel, in order.
    pub samples: Vec<SeenSample>,
    /// Averages over the samples, for denoisers and compositing.
    pub features: Features,
}

/// Result of one camera sample.
#[derive(Clone, Copy, Debug)]
pub struct SeenSample {
    /// Position within the pixel: the two uniform numbers that the filter takes.
    pub place: [f32; 2],
    /// Weighted emission that is visible without any VPL (W·m⁻²·sr⁻¹).
    pub background: Rgb,
    /// Index of the sample's gather point, if it reached one.
    pub point: Option<u32>,
    /// End of the path in the sky, if the path left the scene.
    pub sky: Option<SkySample>,
}

/// End of a camera path that left the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkySample {
    /// Unit direction in which the path left.
    pub direction: Vec3,
    /// Luminance that the sample adds to its pixel for each unit of the sky's luminance in this
    /// direction.
    pub throughput: f32,
    /// Hash of the specular surfaces on the way, and of whether they reflected or transmitted.
    pub way: u64,
}

/// Beginning of a path from the camera.
#[derive(Clone, Copy, Debug)]
pub enum Beginning {
    /// A ray that leaves the camera.
    Ray(Ray),
    /// A surface element of a sensor, as a plane sensor: a path begins with its gather point.
    Sensor(Sensor),
    /// The film shows nothing, and is black.
    Nothing,
}

impl Beginning {
    /// Returns the camera ray, if the path begins with one.
    pub fn ray(self) -> Option<Ray> {
        if let Self::Ray(ray) = self { Some(ray) } else { None }
    }
}

/// Inputs that determine the gather points of an image of a scene.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Camera that sees the image.
    pub camera: &'a Camera,
    /// Size of the full image (pixels).
    pub size: [u32; 2],
    /// Number of gather points of a pixel, and the pixel filter.
    pub gather: GatherOptions,
    /// Seed of the camera samples.
    pub seed: u64,
}

impl View<'_> {
    /// Returns the beginning of sample `index` of pixel `(x, y)`, and the key of the sample's
    /// random decisions.
    pub fn beginning(&self, pixel: [u32; 2], index: u32) -> (Beginning, u64) {
        self.beginning_at(pixel, index, || self.time(pixel, index))
    }

    /// Returns the [`beginning`](Self::beginning) at a given time, which is computed only if the
    /// camera moves.
    fn beginning_at(&self, pixel: [u32; 2], index: u32, time: impl FnOnce() -> f32) -> (Beginning, u64) {
        let key = self.pixel_key(pixel);
        let u = sobol_burley::sample_4d(index, 0, key as u32);
        (self.beginning_of(pixel, u, time), rng::key(key, Purpose::Gather, u64::from(index)))
    }

    /// Returns the time of sample `index` of pixel `(x, y)`, from 0 to 1 of the shutter interval.
    pub fn time(&self, pixel: [u32; 2], index: u32) -> f32 {
        let of_shutter = rng::key(self.pixel_key(pixel), Purpose::Shutter, 0);
        sobol_burley::sample_4d(index, 0, of_shutter as u32)[0]
    }

    /// Returns the beginning of a path of pixel `(x, y)` for four uniform numbers, two for the
    /// filter and two for the lens, and a time, which is computed only if the camera moves. At a
    /// sensor, the first two numbers select the surface element.
    pub fn beginning_of(&self, pixel: [u32; 2], u: [f32; 4], time: impl FnOnce() -> f32) -> Beginning {
        if let Some(sensors) = &self.camera.sensors {
            let element = |sensor: Sensor| {
                Beginning::Sensor(Sensor::plane(sensor.position, sensor.normal_at([u[0], u[1]])))
            };
            return sensors.at(pixel).map_or(Beginning::Nothing, element);
        }
        let offset = Vec2::new(self.gather.filter.warp(u[0]), self.gather.filter.warp(u[1]));
        let film = Vec2::new(pixel[0] as f32 + 0.5, pixel[1] as f32 + 0.5) + offset;
        let time = if self.camera.motion.is_some() { time() } else { 0.0 };
        let ray = self.camera.ray(&CameraSample { film, lens: [u[2], u[3]], time }, self.size);
        ray.map_or(Beginning::Nothing, Beginning::Ray)
    }

    /// Draws a pixel of a window, each with the same probability; of a window with sensors, a pixel
    /// that has one.
    pub fn random_pixel(&self, window: &Window, stream: &mut Stream) -> [u32; 2] {
        let mut draw = || {
            let x = window.x + stream.below(window.width.into()) as u32;
            [x, window.y + stream.below(window.height.into()) as u32]
        };
        let Some(sensors) = &self.camera.sensors else { return draw() };
        let drawn = (0..MAX_DRAWS).map(|_| draw()).find(|pixel| sensors.at(*pixel).is_some());
        let first = || window.pixels().map(|(x, y)| [x, y]).find(|pixel| sensors.at(*pixel).is_some());
        drawn.or_else(first).unwrap_or([window.x, window.y])
    }

    /// Number of gather points a pixel by which images are divided into tiles: that of the options,
    /// or as many as make the smallest tiles for sensors, each of which is as much work as many
    /// pixels.
    pub fn points_of_tiles(&self) -> u32 {
        if self.camera.sensors.is_some() { GatherOptions::MAX_POINTS } else { self.gather.points }
    }

    /// Number of pixels to which the work of guidance is proportional. A sensor counts as many
    /// pixels: few sensors are worth as much as a picture.
    pub fn guided_pixels(&self) -> u64 {
        let pixels = u64::from(self.size[0]) * u64::from(self.size[1]);
        if self.camera.sensors.is_some() { pixels.saturating_mul(PIXELS_OF_SENSOR) } else { pixels }
    }

    fn pixel_key(&self, pixel: [u32; 2]) -> u64 {
        rng::key(self.seed, Purpose::Gather, u64::from(pixel[1]) << 32 | u64::from(pixel[0]))
    }

    /// Returns the view with `count` camera samples a pixel, of another seed.
    #[must_use]
    pub fn by(&self, count: u32, seed: u64) -> Self {
        Self { gather: GatherOptions { points: count, ..self.gather }, seed, ..*self }
    }

    /// Returns the sum of one pixel over `count` camera samples of another seed.
    pub fn samples(&self, tracer: &Tracer, pixel: [u32; 2], count: u32, seed: u64) -> PixelSum {
        self.by(count, seed).pixel(tracer, pixel)
    }

    /// Returns the features of the first surfaces of one pixel, as seen through all media, over
    /// `count` camera samples of another seed.
    pub fn features(&self, tracer: &Tracer, pixel: [u32; 2], count: u32, seed: u64) -> Features {
        self.by(count, seed).sum(tracer, pixel, Media::SeenThrough, None).features
    }

    /// Returns the sum of one pixel of a scene without motion.
    pub fn pixel(&self, tracer: &Tracer, pixel: [u32; 2]) -> PixelSum {
        self.sum(tracer, pixel, Media::Count, None)
    }

    /// Returns the sum of one pixel, with each sample at one of the given instants. If the scene
    /// does not move and there is a single instant, each sample of a moving camera still has its
    /// own time.
    pub fn pixel_at(&self, tracer: &Tracer, pixel: [u32; 2], instants: &Instants) -> PixelSum {
        let is_still = instants.is_single() && !tracer.scene().moves();
        self.sum(tracer, pixel, Media::Count, (!is_still).then_some(instants))
    }

    /// Returns the sum of one pixel; without instants, each sample has its own time.
    fn sum(&self, tracer: &Tracer, pixel: [u32; 2], media: Media, instants: Option<&Instants>) -> PixelSum {
        let n = self.gather.points;
        let mut sum = PixelSum::default();
        let mut features = FeatureSums::new(n);
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
            let (beginning, key) =
                self.beginning_at(pixel, index, || if instants.is_some() { share } else { time() });
            let [x, y, ..] = sobol_burley::sample_4d(index, 0, self.pixel_key(pixel) as u32);
            // Each surface has a separate sequence. In a single sequence of many dimensions,
            // projections to high dimensions would be worse than random numbers.
            let choices = |bounce: u32| {
                let of_surface =
                    rng::key(self.pixel_key(pixel), Purpose::Gather, u64::MAX - u64::from(bounce));
                sobol_burley::sample_4d(index, 0, of_surface as u32)
            };
            let end = match beginning {
                Beginning::Nothing => End::NOTHING,
                Beginning::Sensor(sensor) => {
                    End { point: Some(GatherPoint::on_sensor(&sensor, self.camera.medium)), ..End::NOTHING }
                }
                Beginning::Ray(ray) => {
                    let leg = Leg { ray, medium: self.camera.medium };
                    CameraPath { tracer, camera: self.camera, share, media, key }.follow(leg, choices)
                }
            };
            sum.background += end.background * of_basic;
            sum.samples.push(SeenSample {
                place: [x, y],
                background: end.background * of_basic,
                point: end.point.is_some().then_some(sum.points.len() as u32),
                sky: end.sky.map(|sky| SkySample { throughput: sky.throughput * of_basic, ..sky }),
            });
            features.add(end.first.as_ref(), end.point.as_ref().map(GatherPoint::albedo));
            if let Some(mut point) = end.point {
                point.weight *= of_basic;
                point.instant = instant;
                sum.points.push(point);
            }
        }
        sum.features = features.mean();
        sum
    }
}
