//! Single terms of a pixel's sum, evaluated in batches: one batch of shadow segments for all of them.

use std::ops::Range;

use crate::accel::SegmentBatch;
use crate::color::Rgb;
use crate::gather::GatherPoint;
use crate::transport::Transport;
use crate::vpl::Vpl;

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
}

impl TermBatch {
    /// Forgets all terms but keeps the memory.
    pub fn clear(&mut self) {
        self.values.clear();
        self.traced.clear();
        self.segments.clear();
    }

    /// Adds a term times `factor` (one over its probability).
    pub fn push(&mut self, transport: &Transport, point: &GatherPoint, light: &Vpl, factor: f64) {
        let value = transport.unoccluded(point, light).map(|c| (f64::from(c) * factor) as f32);
        if !value.is_black() {
            self.segments.glass = transport.glass();
            self.traced.push(self.values.len() as u32);
            self.segments.push_fan(light.apex(), [point.position]);
        }
        self.values.push(value);
    }

    /// How many terms there are.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// What has to be traced.
    pub fn segments(&self) -> &SegmentBatch {
        &self.segments
    }

    /// Takes the visibility of each segment into account.
    pub fn shadow(&mut self, visibility: &[f32]) {
        debug_assert_eq!(visibility.len(), self.traced.len());
        for (&term, &v) in self.traced.iter().zip(visibility) {
            self.values[term as usize] *= v;
        }
    }

    /// Values of all terms, in order (W·m⁻²·sr⁻¹): without visibility before [`TermBatch::shadow`], with it afterwards.
    pub fn values(&self) -> &[Rgb] {
        &self.values
    }

    /// How many of the terms in a range have a segment.
    pub fn segments_of(&self, terms: Range<usize>) -> u64 {
        let before = |end: usize| self.traced.partition_point(|&term| (term as usize) < end);
        (before(terms.end) - before(terms.start)) as u64
    }
}
