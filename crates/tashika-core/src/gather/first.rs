//! What camera rays meet first: the surfaces that [`Features`](super::Features) are of, by the
//! instance that they belong to, and how they move over the film.

use glam::Vec2;

use super::{MAX_CHAIN, View};
use crate::accel::{Hit, Tracer};
use crate::math::Ray;
use crate::rng::{self, Purpose};
use crate::scene::{InstanceId, Seen, Surface};

/// The middle of the time that the shutter is open, as a share of it.
const MIDDLE: f32 = 0.5;

impl View<'_> {
    /// The instance that camera sample `index` of pixel `(x, y)` meets first; none where it meets
    /// nothing. The ray is that of [`Self::pixel`], with the same random decisions about surfaces with
    /// holes. Boundaries of media are no surfaces that are seen: it goes on through them.
    pub fn first_instance(&self, tracer: &Tracer, pixel: [u32; 2], index: u32) -> Option<InstanceId> {
        let (ray, key) = self.camera_ray(pixel, index);
        let time = if tracer.scene().moves() { self.time(pixel, index) } else { 0.0 };
        first_hit(tracer, ray?, key, time).map(|hit| hit.instance)
    }

    /// How far what pixel `(x, y)` shows goes on the film while the shutter is open (pixels: to the
    /// right, down): of the surface that its centre shows, through the lens' centre and in the middle
    /// of the time, from where it is when the shutter opens to where it is when that closes. Where
    /// there is no surface, of what is infinitely far away.
    ///
    /// Zero where the film shows nothing, or where it does not show one of the two ends, behind the
    /// camera.
    pub fn motion(&self, tracer: &Tracer, pixel: [u32; 2]) -> Vec2 {
        let scene = tracer.scene();
        if self.camera.motion.is_none() && !scene.moves() {
            return Vec2::ZERO;
        }
        let film = Vec2::new(pixel[0] as f32 + 0.5, pixel[1] as f32 + 0.5);
        let Some(ray) = self.camera.central_ray(film, MIDDLE, self.size) else { return Vec2::ZERO };
        let key = rng::key(self.pixel_key(pixel), Purpose::Gather, 0);
        let seen = match first_hit(tracer, ray, key, MIDDLE) {
            None => Seen::Direction(ray.direction),
            Some(Hit { instance, triangle, barycentric, .. }) => {
                let place = |share| scene.surface_point_at(share, instance, triangle, barycentric).position;
                Seen::Place { open: place(0.0), close: place(1.0) }
            }
        };
        self.camera.way_on_film(seen, self.size).unwrap_or(Vec2::ZERO)
    }
}

/// The first surface that is one, after a share of the time that the shutter is open.
fn first_hit(tracer: &Tracer, mut ray: Ray, key: u64, share: f32) -> Option<Hit> {
    let scene = tracer.scene();
    for bounce in 0..MAX_CHAIN {
        let hit = tracer.closest_hit_at(&ray, key.wrapping_add(u64::from(bounce)), share)?;
        if scene.material_of(hit.instance).surface != Surface::Boundary {
            return Some(hit);
        }
        let surface = scene.surface_point_at(share, hit.instance, hit.triangle, hit.barycentric);
        ray = Ray::new(surface.leave(ray.direction), ray.direction);
    }
    None
}
