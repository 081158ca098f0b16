//! The engine that all cuts share. It plans splits by rank, lets the new pairs draw the terms that
//! they lack, and traces all segments of an epoch together.
//!
//! ```text
//! for each epoch:   split the pair of the highest rank, as often as wanted     Refinement, Rank
//!                   draw the terms that new pairs lack                         Strata
//!                   trace all of their segments at once                        Tracer
//!                   hear their values                                          Strata
//! ```
//!
//! Cuts differ in the estimators of their pairs ([`Strata`]) and in the times at which these are
//! evaluated: after every single split in the published methods
//! ([`StoppingRule`](super::StoppingRule)), after each epoch in ours.
//!
//! # Guarantee
//! The partition is a function of ranks, which depend on clusters and not on values. Given the
//! partition and the number of terms that are drawn from each pair, the terms are therefore
//! independent. The time at which a rule *ends* a cut may depend on values; intervals have to allow
//! for that.

use super::clusters::Clusters;
use super::refinement::{Refinement, RefinementMemory, RefinementOptions, Split};
use super::strata::{InheritedMemory, PairEstimate, PairEstimates, Strata};
use super::terms::TermBatch;
use crate::accel::Tracer;
use crate::bounds::UpperMaterial;
use crate::rng::Stream;

/// A growing cut of a pixel's sum.
pub struct Cut<'a, B, S> {
    pub(super) refinement: Refinement<'a, B>,
    pub(super) strata: S,
    tracer: &'a Tracer,
    stream: Stream,
    pairs: u64,
    segments: u64,
    epoch: &'a mut Epoch,
}

/// Memory of a [`Cut`], reused by the next one.
#[derive(Debug, Default)]
pub struct CutMemory {
    pub(super) refinement: RefinementMemory,
    pub(super) epoch: Epoch,
    pub(super) inherited: InheritedMemory,
}

/// Splits and terms since the cut was last evaluated.
#[derive(Debug, Default)]
pub(super) struct Epoch {
    splits: Vec<Split>,
    batch: TermBatch,
    /// Ends of the ranges of terms of each new pair in the batch.
    ends: Vec<u32>,
}

impl<'a, B: UpperMaterial, S: PairEstimates<B>> Cut<'a, B, S> {
    /// Creates the initial cut of published methods: a single pair, or one for each instant. `None`
    /// if the sum has no terms.
    pub fn published(
        clusters: Clusters<'a, B>,
        strata: S,
        tracer: &'a Tracer,
        stream: Stream,
        memory: &'a mut CutMemory,
    ) -> Option<Self> {
        let refinement = Refinement::new(clusters, RefinementOptions::PUBLISHED, &mut memory.refinement)?;
        Some(Self::begin(refinement, strata, tracer, stream, &mut memory.epoch))
    }

    /// The estimate of a pair.
    pub(super) fn estimate_of(&self, number: u32) -> &PairEstimate {
        self.strata.estimate(number as usize)
    }
}

impl<'a, B: UpperMaterial, S: Strata<B>> Cut<'a, B, S> {
    /// Creates the cut of the roots and evaluates it.
    ///
    /// * `stream`: source of samples. The ranks of pairs must not depend on it.
    pub(super) fn begin(
        refinement: Refinement<'a, B>,
        strata: S,
        tracer: &'a Tracer,
        stream: Stream,
        epoch: &'a mut Epoch,
    ) -> Self {
        epoch.splits.clear();
        let pairs = refinement.roots() as u64;
        let mut cut = Self { refinement, strata, tracer, stream, pairs, segments: 0, epoch };
        cut.complete(0);
        cut
    }

    /// Performs one epoch: splits until there are `pairs` pairs or nothing can be split.
    pub fn grow(&mut self, pairs: u64) {
        let first = self.refinement.pairs().len();
        self.epoch.splits.clear();
        while self.pairs < pairs {
            let Some(split) = self.refinement.split_next() else { break };
            self.strata.split(&self.refinement, &split, &mut self.stream);
            self.epoch.splits.push(split);
            self.pairs += 1;
        }
        self.complete(first);
    }

    /// Draws and traces the terms that the pairs from number `first` on lack, and passes the values
    /// to the strata.
    fn complete(&mut self, first: usize) {
        let Self { refinement, strata, stream, epoch: Epoch { batch, ends, .. }, .. } = self;
        batch.clear(refinement.clusters().contribution.glass());
        ends.clear();
        for number in first..refinement.pairs().len() {
            strata.draw(refinement, number, stream, batch);
            ends.push(batch.values().len() as u32);
        }
        batch.trace(self.tracer, refinement.clusters().lights.instants());
        self.segments += batch.segments();
        let mut begin = 0;
        let of_pair = |(number, &end): (usize, &u32)| {
            let values = &batch.values()[begin..end as usize];
            begin = end as usize;
            (number, values)
        };
        strata.hear(refinement, (first..).zip(&*ends).map(of_pair));
    }

    /// Number of pairs in the cut.
    pub fn pairs(&self) -> u64 {
        self.pairs
    }

    /// Number of pairs of the initial cut; these have the lowest numbers.
    pub(super) fn roots(&self) -> usize {
        self.refinement.roots()
    }

    /// Number of segments traced so far.
    pub fn segments(&self) -> u64 {
        self.segments
    }

    /// Number of terms of the complete sum.
    pub fn terms(&self) -> u64 {
        let (clusters, roots) = (self.refinement.clusters(), &self.refinement.pairs()[..self.roots()]);
        roots.iter().map(|root| clusters.terms(root)).sum()
    }

    /// The splits of the last epoch, in order.
    pub fn splits(&self) -> &[Split] {
        &self.epoch.splits
    }

    /// Rank of the pair that would be split next; `None` if there is none.
    pub fn highest_rank(&self) -> Option<f64> {
        self.refinement.highest_rank()
    }
}
