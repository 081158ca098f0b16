//! What camera rays meet first: the surfaces that [`Features`](super::Features) are of, by the
//! instance that they belong to, how they move over the film, when they are in front, and what media
//! leave of their light.

use glam::{Vec2, Vec3};

use super::View;
use crate::accel::{Apex, Hit, Tracer};
use crate::color::Rgb;
use crate::math::Ray;
use crate::media::{MOST_PASSED, along_segment};
use crate::rng::{self, Purpose, Stream};
use crate::scene::{InstanceId, Seen, Surface};

/// The middle of the time that the shutter is open, as a share of it.
const MIDDLE: f32 = 0.5;

/// What a camera sample meets first.
struct Look {
    ray: Ray,
    key: u64,
    /// When it is: a share of the time that the shutter is open; 0 where no instance moves.
    share: f32,
    hit: Option<Hit>,
}

impl View<'_> {
    /// The instance that camera sample `index` of pixel `(x, y)` meets first; none where it meets
    /// nothing. The ray is that of [`Self::pixel`], with the same random decisions about surfaces with
    /// holes. Boundaries of media are no surfaces that are seen: it goes on through them.
    pub fn first_instance(&self, tracer: &Tracer, pixel: [u32; 2], index: u32) -> Option<InstanceId> {
        self.look(tracer, pixel, index)?.hit.map(|hit| hit.instance)
    }

    /// When what is in front is there: the mean time, as a share of the time that the shutter is open,
    /// of those of the pixel's first `samples` camera samples that meet the instance of which a sample
    /// meets the nearest place. None where all meet nothing.
    ///
    /// What stands before a camera that stands has 1/2.
    pub fn time_in_front(&self, tracer: &Tracer, pixel: [u32; 2], samples: u32) -> Option<f32> {
        let met: Vec<(f32, InstanceId, f32)> = (0..samples)
            .filter_map(|index| {
                let Look { ray, share, hit, .. } = self.look(tracer, pixel, index)?;
                let hit = hit?;
                let distance = place(tracer, &hit, share).distance(ray.origin);
                Some((distance, hit.instance, self.time(pixel, index)))
            })
            .collect();
        let (_, front, _) = met.iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
        if self.camera.motion.is_none() && tracer.scene().motion_of(*front).is_none() {
            return Some(MIDDLE);
        }
        let times = met.iter().filter(|(_, instance, _)| instance == front).map(|(.., time)| *time);
        Some(times.clone().sum::<f32>() / times.count() as f32)
    }

    /// What media leave of the light of the first surface, or of what is infinitely far away, on its
    /// way to the camera: the mean over the pixel's first `samples` camera samples that there are, by
    /// channel in `[0, 1]`; black where the film shows nothing.
    ///
    /// An unbiased estimate of the mean over the pixel, exact for each ray but where the density of a
    /// medium varies.
    pub fn transmittance(&self, tracer: &Tracer, pixel: [u32; 2], samples: u32) -> Rgb {
        let mut sum = Rgb::BLACK;
        let mut looks = 0;
        for Look { ray, key, share, hit } in (0..samples).filter_map(|index| self.look(tracer, pixel, index))
        {
            let end = match hit {
                Some(hit) => Apex::Point(place(tracer, &hit, share)),
                None => Apex::Direction(ray.direction),
            };
            let mut stream = Stream::new(key, Purpose::Transmittance, 0);
            let from = (ray.origin, self.camera.medium);
            sum += along_segment(tracer, from, end, (key, share), &mut stream).0;
            looks += 1;
        }
        sum / looks.max(1) as f32
    }

    /// What camera sample `index` of a pixel meets; none where the film shows nothing.
    fn look(&self, tracer: &Tracer, pixel: [u32; 2], index: u32) -> Option<Look> {
        let (ray, key) = self.camera_ray(pixel, index);
        let (ray, share) = (ray?, if tracer.scene().moves() { self.time(pixel, index) } else { 0.0 });
        Some(Look { ray, key, share, hit: first_hit(tracer, ray, key, share) })
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
            Some(hit) => Seen::Place { open: place(tracer, &hit, 0.0), close: place(tracer, &hit, 1.0) },
        };
        self.camera.way_on_film(seen, self.size).unwrap_or(Vec2::ZERO)
    }
}

/// Where what was hit is after a share of the time that the shutter is open.
fn place(tracer: &Tracer, hit: &Hit, share: f32) -> Vec3 {
    tracer.scene().surface_point_at(share, hit.instance, hit.triangle, hit.barycentric).position
}

/// The first surface that is one, after a share of the time that the shutter is open. Holes are the same
/// along the whole ray.
fn first_hit(tracer: &Tracer, mut ray: Ray, key: u64, share: f32) -> Option<Hit> {
    let scene = tracer.scene();
    for _ in 0..MOST_PASSED {
        let hit = tracer.closest_hit_at(&ray, key, share)?;
        if scene.material_of(hit.instance).surface != Surface::Boundary {
            return Some(hit);
        }
        let surface = scene.surface_point_at(share, hit.instance, hit.triangle, hit.barycentric);
        ray = Ray::new(surface.leave(ray.direction), ray.direction);
    }
    None
}
