//! Which medium a light path begins in.
//!
//! Only cameras say which medium they stand in; an emitter may be anywhere. Interfaces enclose what
//! they bound, so the medium about a place is on the near side of the first interface that a ray from
//! there meets, whatever else it passes; where it meets none, it is the medium outside of all
//! interfaces, to which a ray from a camera leads.
//!
//! # Assumptions
//! Surfaces with an interface are closed, and agree with each other on what is between them; else
//! what is seen of the light may not be what paths from the camera find.
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

/// The medium outside of all interfaces of a scene; nothing is vacuum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outside(Option<MediumId>);

impl Outside {
    /// Of the tracer's scene, as its first camera has it.
    pub fn new(tracer: &Tracer) -> Self {
        Self(tracer.scene().cameras().first().and_then(|camera| outside_of(tracer, camera)))
    }

    /// Whether all cameras of a scene agree on it.
    ///
    /// # Errors
    /// [`Error::Option`] naming two cameras that do not.
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

    /// The medium that a ray begins in.
    ///
    /// * `key`: as [`Tracer::closest_hit`] takes it.
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
                // What is beyond it for who comes back is before it.
                return scene.medium_beyond(&surface, -ray.direction, None);
            }
            ray = Ray::new(surface.leave(ray.direction), ray.direction);
        }
        self.0
    }

    /// The share of light from infinity that comes as far as the origin of a ray that lies outside of
    /// all interfaces and goes on along it, by channel.
    pub fn arriving(self, tracer: &Tracer, ray: &Ray, stream: &mut Stream) -> Rgb {
        self.0.map_or(Rgb::WHITE, |medium| {
            let back = Ray::new(ray.origin, -ray.direction);
            transmittance(&tracer.scene().media()[medium.index()], &back, f32::INFINITY, stream)
        })
    }

    /// It, for a path that is there.
    pub fn medium(self) -> Option<MediumId> {
        self.0
    }
}

/// The medium at the end of a straight way from a camera, in the middle of what it shows, out of the
/// scene.
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
