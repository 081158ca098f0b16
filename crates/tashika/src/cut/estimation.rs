//! Refines a cut until a rule is met, in epochs: plan, draw, trace at once, look.
//!
//! ```text
//! L̂ = Σ_k L̂_k          V̂ = Σ_k s_k²          k: pairs of the cut
//! ```
//!
//! The rule is looked at after every single split, as the published methods do. But since the order of splits does not depend on any
//! sample, those of an epoch are planned and drawn ahead and their segments traced together; what lies beyond the split at
//! which the rule was met is thrown away, and not counted.

use super::clusters::{Clusters, Pair};
use super::refinement::{ByUpper, Refinement, RefinementMemory, Split};
use super::sampling::{PairEstimate, Scheme};
use super::stopping::{Progress, StoppingRule};
use super::terms::TermBatch;
use crate::accel::Tracer;
use crate::bounds::UpperMaterial;
use crate::color::RgbSum;
use crate::rng::Stream;
use crate::transport::Transport;

/// Splits of an epoch: this share of the cut, and at least [`MIN_EPOCH`].
const EPOCH_SHARE: f64 = 0.125;
/// See [`EPOCH_SHARE`].
const MIN_EPOCH: usize = 31;

/// How a cut ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutEnd {
    /// Its rule is met.
    RuleMet,
    /// Nothing can be split any more.
    Finest,
    /// It has as many pairs as permitted.
    Budget,
}

/// The estimate that a cut gives.
#[derive(Clone, Copy, Debug)]
pub struct CutEstimate {
    /// Estimate (W·m⁻²·sr⁻¹).
    pub radiance: RgbSum,
    /// Estimated variance of its luminance.
    pub variance: f64,
    /// Half-width of the interval that the rule states for its luminance (W·m⁻²·sr⁻¹).
    pub half_width: f64,
    /// How it ended.
    pub end: CutEnd,
    /// Pairs of the cut.
    pub pairs: u64,
    /// Segments traced for it.
    pub segments: u64,
}

/// What a cut is refined with.
#[derive(Clone, Copy, Debug)]
pub struct Refiner<'a, S> {
    /// Rays.
    pub tracer: &'a Tracer,
    /// Evaluates terms.
    pub transport: Transport,
    /// How pairs are estimated.
    pub scheme: S,
    /// When to stop.
    pub rule: StoppingRule,
    /// Pairs beyond which the cut does not grow.
    pub max_pairs: u64,
}

impl<S: Scheme> Refiner<'_, S> {
    /// Estimates the sum of all terms; random numbers come from `stream`.
    pub fn estimate<B: UpperMaterial>(&self, clusters: Clusters<'_, B>, stream: &mut Stream) -> CutEstimate {
        let mut memory = RefinementMemory::default();
        let Some(refinement) = Refinement::new(clusters, ByUpper { finest: 1 }, None, &mut memory) else {
            return CutEstimate {
                radiance: RgbSum::default(),
                variance: 0.0,
                half_width: 0.0,
                end: CutEnd::Finest,
                pairs: 0,
                segments: 0,
            };
        };
        Cut::new(self, refinement, stream).run()
    }
}

/// A cut while it is refined.
struct Cut<'a, 'b, S: Scheme, B> {
    refiner: &'b Refiner<'b, S>,
    refinement: Refinement<'a, B, ByUpper>,
    stream: &'b mut Stream,
    /// By the number of the pair; `None` if the pair contributes nothing.
    drawn: Vec<Option<S::Drawn>>,
    estimates: Vec<PairEstimate>,
    batch: TermBatch,
    /// Where in the batch each pair's terms end, from the first pair of the epoch.
    ends: Vec<u32>,
    visibility: Vec<f32>,
    radiance: RgbSum,
    variance: f64,
    pairs: u64,
    segments: u64,
}

impl<'a, 'b, S: Scheme, B: UpperMaterial> Cut<'a, 'b, S, B> {
    fn new(
        refiner: &'b Refiner<'b, S>,
        refinement: Refinement<'a, B, ByUpper>,
        stream: &'b mut Stream,
    ) -> Self {
        Self {
            refiner,
            refinement,
            stream,
            drawn: Vec::new(),
            estimates: Vec::new(),
            batch: TermBatch::default(),
            ends: Vec::new(),
            visibility: Vec::new(),
            radiance: RgbSum::default(),
            variance: 0.0,
            pairs: 1,
            segments: 0,
        }
    }

    fn run(mut self) -> CutEstimate {
        self.draw(None);
        self.trace();
        self.take(0, 0, &PairEstimate::default());
        let mut epoch: Vec<Split> = Vec::new();
        loop {
            let first = self.drawn.len();
            self.plan(&mut epoch);
            self.trace();
            for split in &epoch {
                if let Some(end) = self.end(Some(split.rank)) {
                    return self.finish(end, Some(split.rank));
                }
                self.replace(split, first);
            }
            let largest = self.refinement.highest_rank();
            if let Some(end) = self.end(largest) {
                return self.finish(end, largest);
            }
        }
    }

    /// Plans the splits of an epoch and draws the terms of the new pairs.
    fn plan(&mut self, epoch: &mut Vec<Split>) {
        epoch.clear();
        self.batch.clear();
        self.ends.clear();
        let permitted = self.refiner.max_pairs.saturating_sub(self.pairs);
        let wanted = ((self.pairs as f64 * EPOCH_SHARE) as usize).max(MIN_EPOCH);
        while epoch.len() < wanted && (epoch.len() as u64) < permitted {
            let Some(split) = self.refinement.split_next() else { break };
            epoch.push(split);
            for _ in 0..2 {
                self.draw(Some(split.parent));
            }
        }
    }

    /// Draws the terms of the next pair.
    fn draw(&mut self, parent: Option<u32>) {
        let clusters = self.refinement.clusters();
        let pair: &Pair = &self.refinement.pairs()[self.drawn.len()];
        let drawn = (clusters.upper(pair) > 0.0).then(|| {
            let parent = parent.and_then(|parent| self.drawn[parent as usize].as_ref());
            let Refiner { scheme, transport, .. } = self.refiner;
            scheme.draw(clusters, pair, parent, transport, self.stream, &mut self.batch)
        });
        self.drawn.push(drawn);
        self.ends.push(self.batch.len() as u32);
    }

    fn trace(&mut self) {
        self.refiner.tracer.visibility(self.batch.segments(), &mut self.visibility);
        self.batch.shadow(&self.visibility);
    }

    /// Puts the children of a split into the parent's place; `first` is the first pair of the epoch.
    fn replace(&mut self, split: &Split, first: usize) {
        let parent = self.estimates[split.parent as usize];
        self.radiance.remove(parent.radiance);
        self.variance -= parent.variance;
        let child = split.children as usize;
        self.take(child, first, &parent);
        self.take(child + 1, first, &parent);
        self.pairs += 1;
    }

    /// Takes pair `number` into the cut.
    fn take(&mut self, number: usize, first: usize, parent: &PairEstimate) {
        let place = number - first;
        let start = if place == 0 { 0 } else { self.ends[place - 1] as usize };
        let terms = start..self.ends[place] as usize;
        self.segments += self.batch.segments_of(terms.clone());
        let estimate = self.drawn[number].as_ref().map_or_else(PairEstimate::default, |drawn| {
            self.refiner.scheme.estimate(drawn, &self.batch.values()[terms], parent)
        });
        self.radiance.add(estimate.radiance);
        self.variance += estimate.variance;
        self.estimates.push(estimate);
    }

    fn progress(&self, largest_upper: Option<f64>) -> Progress {
        Progress {
            pairs: self.pairs,
            luminance: self.radiance.luminance(),
            variance: self.variance,
            largest_upper,
        }
    }

    /// Whether the cut ends here; `largest_upper` as in [`Progress`].
    fn end(&self, largest_upper: Option<f64>) -> Option<CutEnd> {
        if largest_upper.is_none() {
            Some(CutEnd::Finest)
        } else if self.refiner.rule.is_met(&self.progress(largest_upper)) {
            Some(CutEnd::RuleMet)
        } else if self.pairs >= self.refiner.max_pairs {
            Some(CutEnd::Budget)
        } else {
            None
        }
    }

    fn finish(&self, end: CutEnd, largest_upper: Option<f64>) -> CutEstimate {
        CutEstimate {
            radiance: self.radiance,
            variance: self.variance.max(0.0),
            half_width: self.refiner.rule.half_width(&self.progress(largest_upper)),
            end,
            pairs: self.pairs,
            segments: self.segments,
        }
    }
}
