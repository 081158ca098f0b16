//! Single terms of a pixel's sum, evaluated in batches. All shadow segments of an instant are
//! traced together.

use super::clusters::Clusters;
use crate::accel::{Glass, SegmentBatch, Tracer};
use crate::color::Rgb;
use crate::math::Instants;
use crate::media::Segments;

/// One term: a light and a gather point, as indices in the sorted orders of their trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Term {
    /// Index of the light in the order of the light tree.
    pub light: u32,
    /// Index of the gather point in the order of the gather tree.
    pub point: u32,
}

/// Terms whose visibility is traced together.
///
/// Terms whose unoccluded contribution is zero need no segment.
#[derive(Clone, Debug, Default)]
pub struct TermBatch {
    values: Vec<Rgb>,
    glass: Glass,
    /// Segments, by instant.
    traced: Vec<Traced>,
}

/// The segments of an instant.
#[derive(Clone, Debug, Default)]
struct Traced {
    /// Indices of the terms to which the segments belong.
    terms: Vec<u32>,
    segments: SegmentBatch,
    in_media: Segments,
    visibility: Vec<f32>,
}

impl TermBatch {
    /// Removes all terms and keeps the memory. `glass` is the effect of glass on later segments.
    pub fn clear(&mut self, glass: Glass) {
        self.values.clear();
        self.glass = glass;
        for traced in &mut self.traced {
            traced.terms.clear();
            traced.segments.clear();
            traced.segments.glass = glass;
            traced.in_media.clear();
        }
    }

    /// Adds a term multiplied by `factor`, the inverse of its probability.
    pub fn push<B>(&mut self, clusters: &Clusters<'_, B>, term: Term, factor: f64) {
        let (light, point) = (clusters.lights.light(term.light), clusters.points.point(term.point));
        let value = clusters.contribution.unoccluded(point, &light).map(|c| (f64::from(c) * factor) as f32);
        if !value.is_black() {
            let instant = usize::from(point.instant);
            if instant >= self.traced.len() {
                let empty = || Traced { segments: SegmentBatch::new(self.glass), ..Traced::default() };
                self.traced.resize_with(instant + 1, empty);
            }
            let traced = &mut self.traced[instant];
            traced.terms.push(self.values.len() as u32);
            traced.segments.push_fan(light.apex(), [point.position]);
            traced.in_media.push(point.medium);
        }
        self.values.push(value);
    }

    /// Number of segments in the batch.
    pub fn segments(&self) -> u64 {
        self.traced.iter().map(|traced| traced.segments.len() as u64).sum()
    }

    /// Multiplies the terms by visibility and by the transmittance of media, at the times of
    /// `instants`.
    pub fn trace(&mut self, tracer: &Tracer, instants: &Instants) {
        for (Traced { terms, segments, in_media, visibility }, &share) in
            self.traced.iter_mut().zip(instants.shares()).filter(|(traced, _)| !traced.terms.is_empty())
        {
            tracer.visibility_at(segments, share, visibility);
            if in_media.matter(tracer) {
                for (&term, &v) in terms.iter().zip(in_media.passing(tracer, segments, share, visibility)) {
                    self.values[term as usize] *= v;
                }
            } else {
                for (&term, &v) in terms.iter().zip(&*visibility) {
                    self.values[term as usize] *= v;
                }
            }
        }
    }

    /// Values of all terms, in order (W·m⁻²·sr⁻¹). They include visibility after
    /// [`TermBatch::trace`] was called.
    pub fn values(&self) -> &[Rgb] {
        &self.values
    }
}
