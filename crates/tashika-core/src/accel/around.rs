//! Index of refraction of the medium that encloses a place, such as a camera or an emitter.
//!
//! Rays are traced from the place through all glass, up to the first surface that is not glass.
//! Each crossing changes the index of the medium that the ray is in: it is multiplied by `1/η`
//! where the ray leaves glass of index `η`, and by `η` where it enters. The thinnest medium on the
//! way is taken to be the one outside of all glass, with index 1. The index around the place by
//! that ray is then
//!
//! ```text
//! n = max_k Π_{j ≤ k} η_j^(±1)          + where crossing j leaves glass, − where it enters it, k ≥ 0
//! ```
//!
//! The result is the median over the rays that cross any glass, and 1 if none does. The median is
//! needed because glass need not be closed: the surface of a pond is a single sheet, and not all
//! rays leave the water.
//!
//! Panes of thin glass and boundaries of media do not refract; rays pass through them.
//!
//! # Use
//! Paths carry *basic* radiance `L/n²` ([`crate::bsdf::Glass`]). In a medium of index `n`, the
//! radiance that a camera measures is `n²` times the basic radiance, and an emitter in such a
//! medium shines with `1/n²` of its radiance.
//!
//! # Assumptions
//! Around a place the normals of glass point outwards. A single sheet whose inside faces the place
//! counts as glass that encloses it.
//!
//! # Held to this by
//! The suite's `inside_glass`, by closed forms.

use std::sync::Arc;

use rayon::prelude::*;

use super::Tracer;
use crate::color::Rgb;
use crate::math::elementary::sin_cos;
use crate::math::{Instants, Ray, Vec2, Vec3};
use crate::scene::{Camera, Emitter, InstanceId, Scene, Surface, SurfacePoint};

/// Number of rays from a place.
const RAYS: u32 = 64;
/// Maximum number of surfaces that a ray crosses.
const MOST_PASSED: u32 = 64;

/// Factors `1/n²` of emitters; 1 outside of glass.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OfEmitters {
    instances: Vec<f32>,
    emitters: Vec<f32>,
}

impl OfEmitters {
    /// Factors of all emitters in the tracer's scene; `None` if no emitter is inside glass.
    pub(super) fn of(tracer: &Tracer) -> Option<Arc<Self>> {
        let scene = tracer.scene();
        if !has_solid_glass(scene) {
            return None;
        }
        let factor = |index: f32| (index * index).recip();
        let of_instance = |instance: InstanceId| match scene.material_of(instance).emission {
            None => 1.0,
            Some(_) => {
                let surface = scene.surface_point(instance, 0, [1.0 / 3.0; 3]);
                factor(tracer.index_around(surface.leave(surface.geometric_normal), Instants::STILL))
            }
        };
        let of_emitter = |emitter: &Emitter| match *emitter {
            Emitter::Point { position, .. }
            | Emitter::Spot { position, .. }
            | Emitter::Image { position, .. } => factor(tracer.index_around(position, Instants::STILL)),
            Emitter::Directional { .. } => 1.0,
        };
        let ids: Vec<InstanceId> = scene.instance_ids().collect();
        let instances: Vec<f32> = ids.into_par_iter().map(of_instance).collect();
        let emitters: Vec<f32> = scene.emitters().par_iter().map(of_emitter).collect();
        let is_any_inside = instances.iter().chain(&emitters).any(|factor| *factor != 1.0);
        is_any_inside.then(|| Arc::new(Self { instances, emitters }))
    }
}

impl Tracer {
    /// Basic radiance emitted from a point in direction `outgoing` (W·m⁻²·sr⁻¹): radiance divided
    /// by the square of the index of refraction around the emitter.
    #[inline]
    pub fn emitted(&self, point: &SurfacePoint, outgoing: Vec3) -> Rgb {
        let radiance = self.scene().emitted(point, outgoing);
        match &self.of_emitters {
            None => radiance,
            Some(inside) => radiance * inside.instances[point.instance.index()],
        }
    }

    /// Emitters without a surface, in the order of the scene, with basic intensity: intensity
    /// divided by the square of the index of refraction around the emitter.
    pub fn emitters(&self) -> impl Iterator<Item = Emitter> + '_ {
        self.scene().emitters().iter().enumerate().map(|(place, emitter)| match &self.of_emitters {
            None => *emitter,
            Some(inside) => emitter.scaled(inside.emitters[place]),
        })
    }

    /// Index of refraction of the medium around a camera, relative to the medium outside of all
    /// glass; 1 if no glass encloses the camera. For a moving camera, the index at its position in
    /// the middle of the time that the shutter is open. Sensors are taken to be outside of glass.
    pub fn index_around_camera(&self, camera: &Camera) -> f32 {
        if camera.sensors.is_some() {
            return 1.0;
        }
        let middle = camera.central_ray(Vec2::splat(0.5), Instants::STILL, [1, 1]);
        self.index_around(middle.map_or(camera.position(), |ray| ray.origin), Instants::STILL)
    }

    /// Index of refraction around a place, at a time given as a `share` of the time that the
    /// shutter is open.
    pub(super) fn index_around(&self, place: Vec3, share: f32) -> f32 {
        if !has_solid_glass(self.scene()) {
            return 1.0;
        }
        let along = |number| self.index_along(Ray::new(place, direction(number)), share);
        let mut found: Vec<f32> = (0..RAYS).filter_map(along).collect();
        found.sort_unstable_by(f32::total_cmp);
        if found.is_empty() { 1.0 } else { found[(found.len() - 1) / 2] }
    }

    /// Index around the origin of a ray; `None` if the ray crosses no glass.
    fn index_along(&self, mut ray: Ray, share: f32) -> Option<f32> {
        let scene = self.scene();
        let (mut index, mut largest, mut crossed) = (1.0_f64, 1.0_f64, false);
        for _ in 0..MOST_PASSED {
            let Some(hit) = self.closest_hit_at(&ray, 0, share) else { break };
            let surface = scene.surface_point_at(share, hit.instance, hit.triangle, hit.barycentric);
            match scene.material_of(hit.instance).surface {
                Surface::Glass { ior, .. } => {
                    let leaves = surface.geometric_normal.dot(ray.direction) > 0.0;
                    index *= if leaves { f64::from(ior) } else { f64::from(ior).recip() };
                    largest = largest.max(index);
                    crossed = true;
                }
                Surface::ThinGlass { .. } | Surface::Boundary => {}
                _ => break,
            }
            ray = Ray::new(surface.leave(ray.direction), ray.direction);
        }
        crossed.then_some(largest as f32)
    }
}

/// Returns true if any instance is solid glass.
fn has_solid_glass(scene: &Scene) -> bool {
    scene.instance_ids().any(|instance| matches!(scene.material_of(instance).surface, Surface::Glass { .. }))
}

/// One of [`RAYS`] unit vectors that are spread evenly: points of a Fibonacci spiral on the sphere.
fn direction(number: u32) -> Vec3 {
    /// Golden angle (rad).
    const TURN: f32 = 2.399_963_2;
    let z = 1.0 - (2.0 * number as f32 + 1.0) / RAYS as f32;
    let (sin, cos) = sin_cos(TURN * number as f32);
    let radius = (1.0 - z * z).sqrt();
    Vec3::new(radius * cos, radius * sin, z)
}
