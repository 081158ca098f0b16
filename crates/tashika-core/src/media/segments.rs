//! Transmittance of media along segments that no surface blocks, by channel.
//!
//! ```text
//! T = Π T_m(d_m)          over the parts of the segment that lie in media m, from interface to interface
//! ```
//!
//! Where the density of a medium varies, `T_m` is a random number in `[0, 1]` whose mean is the
//! transmittance (ratio tracking, Novák et al. 2014). The random numbers are keyed by the two ends
//! of the segment. A pair of a gather point and a VPL therefore has *one* transmittance, in all
//! queries and in any order. It follows that the sum of a pixel over its gather points and VPLs is
//! a definite number, which a cut can estimate. The mean of that sum over random points and lights
//! is the one with the true transmittances.
//!
//! # Guarantee
//! At most 1 in each channel. The result depends only on the scene, the time and the two ends.
//!
//! # Held to this by
//! The tests below; the suite's `media` and `volume_lights`.

use super::{MOST_PASSED, flight};
use crate::accel::{Apex, Fan, SegmentBatch, Tracer};
use crate::color::Rgb;
use crate::math::{Ray, Vec3};
use crate::rng::{self, Purpose, Stream};
use crate::scene::MediumId;

/// Media at the targets of a batch, in the order of the targets.
#[derive(Clone, Debug, Default)]
pub struct Segments {
    media: Vec<Option<MediumId>>,
    left: Vec<Rgb>,
}

impl Segments {
    /// Removes all segments; keeps the allocated memory.
    pub fn clear(&mut self) {
        self.media.clear();
    }

    /// Adds the next target of the batch; `medium` is the medium on its side towards the apex.
    pub fn push(&mut self, medium: Option<MediumId>) {
        self.media.push(medium);
    }

    /// Returns true if media may affect these segments: the scene has media, or a camera stands in
    /// one.
    pub fn matter(&self, tracer: &Tracer) -> bool {
        tracer.scene().has_media() || self.media.iter().any(Option::is_some)
    }

    /// Transmittance of surfaces and media together along each segment, at a time given as a
    /// `share` of the time that the shutter is open, 0 to 1.
    ///
    /// * `visibility`: transmittance of surfaces; where it is zero, media are not evaluated.
    pub fn passing(
        &mut self,
        tracer: &Tracer,
        batch: &SegmentBatch,
        share: f32,
        visibility: &[f32],
    ) -> &[Rgb] {
        debug_assert_eq!(self.media.len(), batch.len());
        self.left.clear();
        self.left.resize(batch.len(), Rgb::BLACK);
        for Fan { apex, targets } in batch.fans() {
            let of_fan = targets.start as usize..targets.end as usize;
            let places = batch.targets()[of_fan.clone()].iter().zip(&self.media[of_fan.clone()]);
            let free = visibility[of_fan.clone()].iter().zip(&mut self.left[of_fan]);
            for ((&place, &medium), (&visible, left)) in places.zip(free) {
                if visible > 0.0 {
                    let key = key_of(place, *apex);
                    let mut stream = Stream::new(key, Purpose::Transmittance, 0);
                    let (media, _) = along_segment(tracer, (place, medium), *apex, (key, share), &mut stream);
                    *left = media * visible;
                }
            }
        }
        &self.left
    }
}

/// Key of the two ends of a segment.
fn key_of(place: Vec3, apex: Apex) -> u64 {
    let (Apex::Point(end) | Apex::Direction(end)) = apex;
    let pairs = [[place.x, place.y], [place.z, end.x], [end.y, end.z]];
    let word = |[a, b]: [f32; 2]| u64::from(a.to_bits()) << 32 | u64::from(b.to_bits());
    pairs.into_iter().fold(0, |key, pair| rng::key(key, Purpose::Transmittance, word(pair)))
}

/// Transmittance of media along a segment that no surface blocks, and the number of rays traced to
/// find the interfaces. `medium` is the medium at `place`, on its side towards the end.
///
/// * `key`, `share`: as in [`Tracer::closest_hit_at`].
pub fn along_segment(
    tracer: &Tracer,
    (place, mut medium): (Vec3, Option<MediumId>),
    end: Apex,
    (key, at): (u64, f32),
    stream: &mut Stream,
) -> (Rgb, u64) {
    let scene = tracer.scene();
    let (direction, mut distance) = match end {
        Apex::Direction(direction) => (direction, f32::INFINITY),
        Apex::Point(point) => {
            let length = place.distance(point);
            ((point - place) / length.max(f32::MIN_POSITIVE), length)
        }
    };
    let mut share = |medium: Option<MediumId>, origin: Vec3, distance: f32| {
        medium.map_or(Rgb::WHITE, |m| {
            let ray = Ray::new(origin, direction);
            flight::transmittance(&scene.media()[m.index()], &ray, distance, stream)
        })
    };
    let (mut left, mut origin, mut rays) = (Rgb::WHITE, place, 0);
    if scene.has_interfaces() {
        for _ in 0..MOST_PASSED {
            rays += 1;
            let ray = Ray { origin, direction, t_max: distance };
            let Some(hit) = tracer.closest_hit_at(&ray, key, at) else {
                return (left * share(medium, origin, distance), rays);
            };
            left *= share(medium, origin, hit.t);
            if left.is_black() {
                return (left, rays);
            }
            let surface = scene.surface_point_at(at, hit.instance, hit.triangle, hit.barycentric);
            medium = scene.medium_beyond(&surface, direction, medium);
            origin = surface.leave(direction);
            distance -= hit.t;
        }
        return (Rgb::BLACK, rays);
    }
    (left * share(medium, origin, distance), rays)
}
