//! What camera samples meet first: the surfaces that [`Features`](super::Features) are of, by the
//! instance that they belong to.

use super::{MAX_CHAIN, View};
use crate::accel::Tracer;
use crate::math::Ray;
use crate::scene::{InstanceId, Surface};

impl View<'_> {
    /// The instance that camera sample `index` of pixel `(x, y)` meets first; none where it meets
    /// nothing. The ray is that of [`Self::pixel`], with the same random decisions about surfaces with
    /// holes. Boundaries of media are no surfaces that are seen: it goes on through them.
    pub fn first_instance(&self, tracer: &Tracer, pixel: [u32; 2], index: u32) -> Option<InstanceId> {
        let (ray, key) = self.camera_ray(pixel, index);
        let scene = tracer.scene();
        let time = if scene.moves() { self.time(pixel, index) } else { 0.0 };
        let mut ray = ray?;
        for bounce in 0..MAX_CHAIN {
            let hit = tracer.closest_hit_at(&ray, key.wrapping_add(u64::from(bounce)), time)?;
            if scene.material_of(hit.instance).surface != Surface::Boundary {
                return Some(hit.instance);
            }
            let surface = scene.surface_point_at(time, hit.instance, hit.triangle, hit.barycentric);
            ray = Ray::new(surface.leave(ray.direction), ray.direction);
        }
        None
    }
}
