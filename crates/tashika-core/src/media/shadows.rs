//! Transmittance along single shadow segments, each from a point to a light.

use super::Segments;
use crate::accel::{Apex, Glass, SegmentBatch, Tracer};
use crate::color::Rgb;
use crate::math::Vec3;
use crate::scene::MediumId;

/// A set of shadow segments that are traced together, with the transmittance of surfaces and media.
#[derive(Clone, Debug)]
pub struct Shadows {
    batch: SegmentBatch,
    in_media: Segments,
    visibility: Vec<f32>,
    passing: Vec<Rgb>,
}

impl Shadows {
    /// Creates an empty set of segments.
    pub fn new(glass: Glass) -> Self {
        Self {
            batch: SegmentBatch::new(glass),
            in_media: Segments::default(),
            visibility: Vec::new(),
            passing: Vec::new(),
        }
    }

    /// Removes all segments; keeps the allocated memory.
    pub fn clear(&mut self) {
        self.batch.clear();
        self.in_media.clear();
    }

    /// Adds the segment from a point to a light. `medium` is the medium at the point, on its side
    /// towards the light.
    pub fn push(&mut self, (place, medium): (Vec3, Option<MediumId>), light: Apex) {
        self.batch.push_fan(light, [place]);
        self.in_media.push(medium);
    }

    /// Transmittance along each segment, by channel in `[0, 1]`, in the order in which the segments
    /// were added. Nothing in the scene may move.
    pub fn trace(&mut self, tracer: &Tracer) -> &[Rgb] {
        tracer.visibility(&self.batch, &mut self.visibility);
        if self.in_media.matter(tracer) {
            return self.in_media.passing(tracer, &self.batch, 0.0, &self.visibility);
        }
        self.passing.clear();
        self.passing.extend(self.visibility.iter().map(|visible| Rgb::gray(*visible)));
        &self.passing
    }

    /// Transmittance along a single segment, as by [`trace`](Self::trace).
    pub fn trace_one(&mut self, tracer: &Tracer, from: (Vec3, Option<MediumId>), light: Apex) -> Rgb {
        self.clear();
        self.push(from, light);
        self.trace(tracer)[0]
    }
}
