//! Gather points: where the light that a pixel sees was last reflected.
//!
//! A pixel is the sum over its gather points (METHOD of the family: Walter et al. 2006), each weighted by pixel filter,
//! lens and the specular surfaces on the way:
//!
//! ```text
//! L = B + Σ_j w_j Σ_i M_ji G_ji V_ji I_i        B = background: emission seen directly or through mirrors and glass
//! ```
//!
//! Camera samples are an Owen-scrambled Sobol' sequence keyed by (seed, pixel) (Burley 2020, `sobol_burley`): film and
//! lens in the first four dimensions, four more at each specular surface. Output is a function of scene, camera, size,
//! options, seed and pixel.

mod options;

#[cfg(test)]
mod tests;

pub use options::{Filter, GatherOptions};

use glam::{Vec2, Vec3};

use crate::accel::Tracer;
use crate::bsdf::Bsdf;
use crate::color::Rgb;
use crate::math::{Frame, Ray};
use crate::rng::{self, Purpose};
use crate::scene::{Camera, CameraSample, SurfacePoint};

/// A point that gathers light from all VPLs.
#[derive(Clone, Copy, Debug)]
pub struct GatherPoint {
    /// Position (m), already moved off its surface to the side of the viewer.
    pub position: Vec3,
    /// Unit geometric normal on the side of the viewer.
    pub geometric_normal: Vec3,
    /// Shading frame; its axis is the shading normal on the side of the viewer.
    pub frame: Frame,
    /// Unit direction to the viewer, in the frame.
    pub wo: Vec3,
    /// How the surface scatters.
    pub bsdf: Bsdf,
    /// Weight `w_j` (unitless); those of a pixel's points and background sum to at most 1.
    pub weight: Rgb,
}

/// Averages over a pixel's camera samples for denoisers and compositing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Features {
    /// Mean distance to the first surface (m), over the samples that met one.
    pub depth: f32,
    /// Mean shading normal of the first surface (world), over the samples that met one.
    pub normal: Vec3,
    /// Mean rough reflectance of the surface that gathers.
    pub albedo: Rgb,
    /// Share of samples that met a surface.
    pub coverage: f32,
}

/// The finite sum of one pixel, before any light is looked at.
#[derive(Clone, Debug, Default)]
pub struct PixelSum {
    /// Points that gather.
    pub points: Vec<GatherPoint>,
    /// Weighted emission that is seen without any VPL (W·m⁻²·sr⁻¹).
    pub background: Rgb,
    /// For denoisers and compositing.
    pub features: Features,
}

/// Specular surfaces after which a camera path is given up; what it would have seen is missing from the image.
const MAX_CHAIN: u32 = 32;

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
    /// The camera ray of sample `index` of pixel `(x, y)`, and the key of the sample's random decisions.
    pub fn camera_ray(&self, pixel: [u32; 2], index: u32) -> (Ray, u64) {
        let key = self.pixel_key(pixel);
        let u = sobol_burley::sample_4d(index, 0, key as u32);
        (self.ray_through(pixel, u), rng::key(key, Purpose::Gather, u64::from(index)))
    }

    /// The camera ray of pixel `(x, y)` for four uniform numbers: two for the filter, two for the lens.
    pub fn ray_through(&self, pixel: [u32; 2], u: [f32; 4]) -> Ray {
        let offset = Vec2::new(self.gather.filter.warp(u[0]), self.gather.filter.warp(u[1]));
        let film = Vec2::new(pixel[0] as f32 + 0.5, pixel[1] as f32 + 0.5) + offset;
        self.camera.ray(&CameraSample { film, lens: [u[2], u[3]] }, self.size)
    }

    fn pixel_key(&self, pixel: [u32; 2]) -> u64 {
        rng::key(self.seed, Purpose::Gather, u64::from(pixel[1]) << 32 | u64::from(pixel[0]))
    }

    /// The sum of one pixel.
    pub fn pixel(&self, tracer: &Tracer, pixel: [u32; 2]) -> PixelSum {
        let n = self.gather.points;
        let mut sum = PixelSum::default();
        let mut met = 0u32;
        let weight = 1.0 / n as f32;
        for index in 0..n {
            let (ray, key) = self.camera_ray(pixel, index);
            let seed = self.pixel_key(pixel) as u32;
            let specular = |bounce: u32| {
                let [a, b, c, _] = sobol_burley::sample_4d(index, bounce + 1, seed);
                [a, b, c]
            };
            let end = follow(tracer, ray, key, specular);
            sum.background += end.background * weight;
            if let Some(mut point) = end.point {
                point.weight *= weight;
                sum.features.albedo += point.bsdf.albedo() * weight;
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

struct First {
    distance: f32,
    normal: Vec3,
}

struct End {
    point: Option<GatherPoint>,
    background: Rgb,
    first: Option<First>,
}

/// Follows a camera ray through specular surfaces to one that is not.
fn follow(tracer: &Tracer, mut ray: Ray, key: u64, specular: impl Fn(u32) -> [f32; 3]) -> End {
    let scene = tracer.scene();
    let mut weight = Rgb::WHITE;
    let mut end = End { point: None, background: Rgb::BLACK, first: None };
    for bounce in 0..MAX_CHAIN {
        let Some(hit) = tracer.closest_hit(&ray, key.wrapping_add(u64::from(bounce))) else {
            if let Some(e) = scene.environment() {
                end.background += weight * e.radiance(ray.direction.normalize());
            }
            break;
        };
        let surface = scene.surface_point(hit.instance, hit.triangle, hit.barycentric);
        let outgoing = -ray.direction;
        end.background += weight * scene.emitted(&surface, outgoing);
        let bsdf = scene.bsdf(&surface);
        if bounce == 0 {
            let (_, normal) = facing(&surface, outgoing);
            end.first = Some(First { distance: hit.t, normal });
        }
        if !bsdf.is_specular() {
            end.point = Some(gather_point(&surface, outgoing, bsdf, weight));
            break;
        }
        let Some((next, factor)) = specular_step(&surface, outgoing, &bsdf, specular(bounce)) else { break };
        weight *= factor;
        if weight.is_black() {
            break;
        }
        ray = next;
    }
    end
}

/// Geometric and shading normal on the side of `direction`; the geometric one for both where the shading normal turns away,
/// as it does at the silhouettes of smooth-shaded meshes.
pub fn facing(surface: &SurfacePoint, direction: Vec3) -> (Vec3, Vec3) {
    let (ng, ns) = surface.normals_towards(direction);
    (ng, if ns.dot(direction) > 0.0 { ns } else { ng })
}

/// The gather point of a surface seen from `outgoing`.
pub fn gather_point(surface: &SurfacePoint, outgoing: Vec3, bsdf: Bsdf, weight: Rgb) -> GatherPoint {
    let (geometric_normal, shading_normal) = facing(surface, outgoing);
    let frame = Frame::about(shading_normal);
    GatherPoint {
        position: surface.leave(outgoing),
        geometric_normal,
        wo: frame.to_local(outgoing),
        frame,
        bsdf,
        weight,
    }
}

/// The ray after a specular surface, and its weight; `None` where the path ends.
pub fn specular_step(surface: &SurfacePoint, outgoing: Vec3, bsdf: &Bsdf, u: [f32; 3]) -> Option<(Ray, Rgb)> {
    // Glass tells inside from outside by the sign of wo.z, so the frame keeps the surface's own orientation.
    let (ng, ns) = facing(surface, outgoing);
    let outside = if ng.dot(surface.geometric_normal) > 0.0 { ns } else { -ns };
    let frame = Frame::about(outside);
    let sample = bsdf.sample(frame.to_local(outgoing), u)?;
    let direction = frame.to_world(sample.wi).normalize();
    Some((Ray::new(surface.leave(direction), direction), sample.weight))
}
