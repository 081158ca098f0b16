//! First surfaces along camera rays: their instances, their motion over the film, the times at
//! which they are in front, and the transmittance of the media before them.
//! [`Features`](super::Features) describe the same surfaces.

use glam::{Vec2, Vec3};

use super::{Beginning, View};
use crate::accel::{Apex, Hit, Tracer};
use crate::color::Rgb;
use crate::math::Ray;
use crate::media::{MOST_PASSED, along_segment};
use crate::rng::{self, Purpose, Stream};
use crate::scene::{InstanceId, Seen, Surface};

/// Middle of the shutter interval, as a share of it.
const MIDDLE: f32 = 0.5;

/// First surface along the ray of a camera sample, if there is one.
struct FirstHit {
    ray: Ray,
    key: u64,
    /// Time as a share of the shutter interval; 0 where no instance moves.
    share: f32,
    hit: Option<Hit>,
}

impl View<'_> {
    /// Returns the instance that camera sample `index` of pixel `(x, y)` meets first; `None` if it
    /// meets nothing. The ray is that of [`Self::pixel`], with the same random decisions about
    /// surfaces with holes. It passes boundaries of media, which are not visible.
    pub fn first_instance(&self, tracer: &Tracer, pixel: [u32; 2], index: u32) -> Option<InstanceId> {
        self.look(tracer, pixel, index)?.hit.map(|hit| hit.instance)
    }

    /// Returns the time at which a pixel shows its frontmost instance, as a share of the shutter
    /// interval; `None` if no sample meets a surface. The frontmost instance is that of the nearest
    /// hit among the pixel's first `samples` camera samples. The time is the mean over the samples
    /// that meet this instance.
    ///
    /// The time is 1/2 if neither the camera nor the instance moves.
    pub fn time_in_front(&self, tracer: &Tracer, pixel: [u32; 2], samples: u32) -> Option<f32> {
        let met: Vec<(f32, InstanceId, f32)> = (0..samples)
            .filter_map(|index| {
                let FirstHit { ray, share, hit, .. } = self.look(tracer, pixel, index)?;
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

    /// Returns the transmittance of the media before the first surface, or before infinity where
    /// there is no surface. It is the mean, by channel in `[0, 1]`, over the pixel's first
    /// `samples` camera samples, without those for which the film shows nothing; black if none is
    /// left.
    ///
    /// It is an unbiased estimate of the mean over the pixel, and exact for each ray except where
    /// the density of a medium varies.
    pub fn transmittance(&self, tracer: &Tracer, pixel: [u32; 2], samples: u32) -> Rgb {
        let mut sum = Rgb::BLACK;
        let mut looks = 0;
        for FirstHit { ray, key, share, hit } in
            (0..samples).filter_map(|index| self.look(tracer, pixel, index))
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

    /// Returns the first surface of camera sample `index` of a pixel; `None` where the film shows
    /// nothing.
    fn look(&self, tracer: &Tracer, pixel: [u32; 2], index: u32) -> Option<FirstHit> {
        let (Beginning::Ray(ray), key) = self.beginning(pixel, index) else { return None };
        let share = if tracer.scene().moves() { self.time(pixel, index) } else { 0.0 };
        Some(FirstHit { ray, key, share, hit: first_hit(tracer, ray, key, share) })
    }

    /// Returns the motion over the film of the surface that pixel `(x, y)` shows at its centre
    /// (pixels: to the right, down). The surface is seen through the lens' centre in the middle of
    /// the shutter interval; the motion is from its position when the shutter opens to that when
    /// the shutter closes. Where there is no surface, it is the motion of a point at infinity.
    ///
    /// Zero where the film shows nothing, or if one of the two positions has no place on the film,
    /// such as a position behind the camera.
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

/// Returns the position of a hit after a share of the shutter interval.
fn place(tracer: &Tracer, hit: &Hit, share: f32) -> Vec3 {
    tracer.scene().surface_point_at(share, hit.instance, hit.triangle, hit.barycentric).position
}

/// Returns the first surface that is no boundary of media, after a share of the shutter interval.
/// Holes are the same along the whole ray.
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
