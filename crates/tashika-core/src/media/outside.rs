//! The medium in which a light path starts.
//!
//! Only cameras specify the medium that they stand in; an emitter may be anywhere. Interfaces
//! enclose the media that they bound. Therefore the medium around a point is the one on the near
//! side of the first interface that a ray from the point meets, whatever other surfaces the ray
//! passes. If the ray meets no interface, it is the medium outside of all interfaces. That one is
//! found by a ray that leaves the scene from a camera.
//!
//! # Assumptions
//! Surfaces with an interface are closed, and they agree on the medium between them. Otherwise
//! light paths and camera paths may disagree on the light that is seen.
//!
//! # Held to this by
//! The suite's `volume_lights`.

use super::flight::transmittance;
use super::{Leg, MOST_PASSED};
use crate::accel::Tracer;
use crate::color::Rgb;
use crate::error::{Error, Result};
use crate::math::{Ray, Vec2};
use crate::rng::Stream;
use crate::scene::{Camera, MediumId};

/// The medium outside of all interfaces of a scene; `None` is vacuum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outside(Option<MediumId>);

impl Outside {
    /// Finds the outside medium of the tracer's scene from its first camera.
    pub fn new(tracer: &Tracer) -> Self {
        Self(tracer.scene().cameras().first().and_then(|camera| outside_of(tracer, camera)))
    }

    /// Checks that all cameras of a scene agree on the medium.
    ///
    /// # Errors
    /// [`Error::Option`] with the names of two cameras that disagree.
    pub fn check(tracer: &Tracer) -> Result<()> {
        let scene = tracer.scene();
        let Self(first) = Self::new(tracer);
        match scene.cameras().iter().find(|camera| outside_of(tracer, camera) != first) {
            None => Ok(()),
            Some(other) => {
                let names = [&scene.cameras()[0].name, &other.name];
                let found = format!("those of cameras {} and {}", names[0], names[1]);
                let expected = "the same medium outside of all interfaces for all cameras, as light comes from there to each of them";
                Err(Error::option("camera medium", found, expected))
            }
        }
    }

    /// Returns the medium in which a ray starts.
    ///
    /// * `key`: see [`Tracer::closest_hit`].
    pub fn medium_at(self, tracer: &Tracer, ray: &Ray, key: u64, share: f32) -> Option<MediumId> {
        let scene = tracer.scene();
        if !scene.has_interfaces() {
            return self.0;
        }
        let mut ray = *ray;
        for _ in 0..MOST_PASSED {
            let Some(hit) = tracer.closest_hit_at(&ray, key, share) else { break };
            let surface = scene.surface_point_at(share, hit.instance, hit.triangle, hit.barycentric);
            if scene.mesh_of(surface.instance).interface.is_some() {
                // `medium_beyond` for the reversed ray gives the medium in front of the interface.
                return scene.medium_beyond(&surface, -ray.direction, None);
            }
            ray = Ray::new(surface.leave(ray.direction), ray.direction);
        }
        self.0
    }

    /// Transmittance, by channel, from infinity to the origin of a ray of light. The origin must be
    /// outside of all interfaces.
    pub fn arriving(self, tracer: &Tracer, ray: &Ray, stream: &mut Stream) -> Rgb {
        self.0.map_or(Rgb::WHITE, |medium| {
            let back = Ray::new(ray.origin, -ray.direction);
            transmittance(&tracer.scene().media()[medium.index()], &back, f32::INFINITY, stream)
        })
    }

    /// Returns the medium, for a path that starts outside of all interfaces.
    pub fn medium(self) -> Option<MediumId> {
        self.0
    }
}

/// Medium at the end of a straight line out of the scene, from a camera through the centre of its
/// image.
fn outside_of(tracer: &Tracer, camera: &Camera) -> Option<MediumId> {
    let scene = tracer.scene();
    let medium = camera.medium;
    if !scene.has_interfaces() {
        return medium;
    }
    let Some(ray) = camera.central_ray(Vec2::splat(0.5), 0.0, [1, 1]) else { return medium };
    let mut leg = Leg { ray, medium };
    for _ in 0..MOST_PASSED {
        let Some(hit) = tracer.closest_hit_at(&leg.ray, 0, 0.0) else { break };
        let surface = scene.surface_point_at(0.0, hit.instance, hit.triangle, hit.barycentric);
        leg = leg.beyond(scene, &surface);
    }
    leg.medium
}
