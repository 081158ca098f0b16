//! Single terms of a pixel's sum, evaluated in batches: one batch of shadow segments for all of
//! them.

use super::clusters::Clusters;
use crate::accel::{Glass, SegmentBatch, Tracer};
use crate::color::Rgb;
use crate::media::Segments;

/// One term: a light and a gather point, as places in the sorted orders of their trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Term {
    /// The light.
    pub light: u32,
    /// The gather point.
    pub point: u32,
}

/// Terms whose visibility is asked for at once.
///
/// Those that contribute nothing even unoccluded need no segment.
#[derive(Clone, Debug, Default)]
pub struct TermBatch {
    values: Vec<Rgb>,
    /// Which terms have a segment.
    traced: Vec<u32>,
    segments: SegmentBatch,
    visibility: Vec<f32>,
    in_media: Segments,
}

impl TermBatch {
    /// Forgets all terms but keeps the memory; `glass`: what it does to the segments that follow.
    pub fn clear(&mut self, glass: Glass) {
        self.values.clear();
        self.traced.clear();
        self.segments.clear();
        self.in_media.clear();
        self.segments.glass = glass;
    }

    /// Adds a term times `factor` (one over its probability).
    pub fn push<B>(&mut self, clusters: &Clusters<'_, B>, term: Term, factor: f64) {
        let (light, point) = (clusters.lights.light(term.light), clusters.points.point(term.point));
        let value = clusters.contribution.unoccluded(point, &light).map(|c| (f64::from(c) * factor) as f32);
        if !value.is_black() {
            self.traced.push(self.values.len() as u32);
            self.segments.push_fan(light.apex(), [point.position]);
            self.in_media.push(point.medium);
        }
        self.values.push(value);
    }

    /// How many segments there are.
    pub fn segments(&self) -> u64 {
        self.segments.len() as u64
    }

    /// Takes visibility into account, and what media leave of light.
    pub fn trace(&mut self, tracer: &Tracer) {
        tracer.visibility(&self.segments, &mut self.visibility);
        if self.in_media.matter(tracer) {
            let passing = self.in_media.passing(tracer, &self.segments, 0.0, &self.visibility);
            for (&term, &v) in self.traced.iter().zip(passing) {
                self.values[term as usize] *= v;
            }
            return;
        }
        for (&term, &v) in self.traced.iter().zip(&self.visibility) {
            self.values[term as usize] *= v;
        }
    }

    /// Values of all terms, in order (W·m⁻²·sr⁻¹): without visibility before [`TermBatch::trace`],
    /// with it afterwards.
    pub fn values(&self) -> &[Rgb] {
        &self.values
    }
}
