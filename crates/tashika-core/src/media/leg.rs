//! The legs of a path: straight ways, each in one medium, from one surface or scattering to the next.
//!
//! All paths go by them: those of the path tracer, camera paths to gather points, light paths that leave
//! VPLs, paths that compensate for what these do not carry.
//!
//! # Held to this by
//! The suite's `media` and `volume_lights`.

use super::flight::{Flight, fly};
use crate::accel::Hit;
use crate::bsdf::HenyeyGreenstein;
use crate::color::Rgb;
use crate::math::{Ray, Vec3};
use crate::rng::Stream;
use crate::scene::{MediumId, Scene, SurfacePoint};

/// A ray, and the medium that it begins in; nothing is vacuum.
#[derive(Clone, Copy, Debug)]
pub struct Leg {
    /// Where it begins and goes.
    pub ray: Ray,
    /// What it is in.
    pub medium: Option<MediumId>,
}

/// Where a path is scattered in a medium.
#[derive(Clone, Copy, Debug)]
pub struct Scattering {
    /// The place (m).
    pub place: Vec3,
    /// The unit direction in which it came.
    pub before: Vec3,
    /// What scatters it.
    pub medium: MediumId,
    /// How that does.
    pub phase: HenyeyGreenstein,
}

impl Leg {
    /// What becomes of a path of weight `weight` that meets `hit`, or nothing: its weight there, or where
    /// it is scattered before.
    ///
    /// The weight stays what it is in vacuum; see [`fly`] for the guarantee.
    #[inline]
    pub fn fly(
        &self,
        scene: &Scene,
        hit: Option<&Hit>,
        weight: Rgb,
        stream: &mut Stream,
    ) -> (Rgb, Option<Scattering>) {
        let Some(id) = self.medium else { return (weight, None) };
        let medium = &scene.media()[id.index()];
        if medium.is_clear() || weight.is_black() {
            return (weight, None);
        }
        let distance = hit.map_or(f32::INFINITY, |hit| hit.t);
        match fly(medium, weight, &self.ray, distance, stream) {
            Flight::Passed { weight } => (weight, None),
            Flight::Scattered { after, weight } => {
                let (place, before) = (self.ray.at(after), self.ray.direction);
                (weight, Some(Scattering { place, before, medium: id, phase: medium.phase }))
            }
        }
    }

    /// The leg that begins at the surface where this one ends, with a ray that leaves it.
    #[must_use]
    #[inline]
    pub fn onward(&self, scene: &Scene, surface: &SurfacePoint, ray: Ray) -> Self {
        Self { ray, medium: scene.medium_beyond(surface, ray.direction, self.medium) }
    }

    /// The straight continuation of this leg beyond a surface that it meets.
    #[must_use]
    #[inline]
    pub fn beyond(&self, scene: &Scene, surface: &SurfacePoint) -> Self {
        let direction = self.ray.direction;
        self.onward(scene, surface, Ray::new(surface.leave(direction), direction))
    }
}
