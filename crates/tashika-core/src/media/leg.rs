//! Legs of a path: straight parts in one medium, each from one surface or scattering to the next.
//!
//! All paths consist of legs: those of the path tracer, camera paths to gather points, light paths
//! that create VPLs, and paths that compensate for light that VPLs do not carry.
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

/// A ray and the medium in which it starts.
#[derive(Clone, Copy, Debug)]
pub struct Leg {
    /// Origin and direction of the leg.
    pub ray: Ray,
    /// Medium of the leg; `None` is vacuum.
    pub medium: Option<MediumId>,
}

/// Scattering of a path in a medium.
#[derive(Clone, Copy, Debug)]
pub struct Scattering {
    /// Place of the scattering (m).
    pub place: Vec3,
    /// Unit direction in which the path arrived.
    pub before: Vec3,
    /// Medium that scatters the path.
    pub medium: MediumId,
    /// Phase function of the medium.
    pub phase: HenyeyGreenstein,
}

impl Leg {
    /// Draws the flight of a path of weight `weight` up to `hit`, or to infinity if there is no
    /// hit. Returns the path's weight at the hit, or an earlier scattering and the weight after it.
    ///
    /// In vacuum the weight does not change. For the guarantee see [`fly`].
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

    /// Returns the next leg: it starts at the surface where this one ends, with the given ray.
    #[must_use]
    #[inline]
    pub fn onward(&self, scene: &Scene, surface: &SurfacePoint, ray: Ray) -> Self {
        Self { ray, medium: scene.medium_beyond(surface, ray.direction, self.medium) }
    }

    /// Returns the straight continuation of this leg beyond a surface that it meets.
    #[must_use]
    #[inline]
    pub fn beyond(&self, scene: &Scene, surface: &SurfacePoint) -> Self {
        let direction = self.ray.direction;
        self.onward(scene, surface, Ray::new(surface.leave(direction), direction))
    }
}
