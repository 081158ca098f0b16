//! Strata that keep their samples: a split passes each sample to the child that contains its term.
//!
//! ```text
//! L̂ = E + Σ_k ȳ_k          V̂ = Σ_k s_k² / n_k          y in [0, R_k],   n_k ≥ 2
//! ```
//!
//! Here `ȳ_k` and `s_k²` are the mean and the sample variance of the `n_k` terms drawn from pair
//! `k`, and `E` is the sum of all pairs that are evaluated as a whole.
//!
//! | pair | a term is drawn with probability | value `y` | `R` |
//! |---|---|---|---|
//! | not tabulated | `I_i / I_C · w_j / W_G` | term `· I_C W_G / (I_i w_j)` | upper bound |
//! | [tabulated](crate::cut::TermTable) | `u_ij / U` | term `· U / u_ij` | `U` |
//!
//! # Why samples may be kept
//! Consider a term drawn from a pair, given that it lies in a child. Its distribution is that of a
//! term drawn from the child by the same rule. If a pair without a table has halves with tables, a
//! sample is kept with probability `(u/(I w)) / max (u/(I w))`, where the maximum is over the terms
//! of the half. The samples that are kept have the distribution of the half (rejection sampling).
//! Given their number, the samples of a child are therefore independent draws from it, *if neither
//! the split nor the rejection depends on visibility*. A [`Rank`] depends on clusters alone, and
//! the rejection on `u`. Other data that a rank may use (of other pixels) comes from separate
//! random streams.
//!
//! # Guarantee
//! The partition and the counts `n_k` do not depend on the visibility of any of this pixel's
//! samples. Given these, all samples are independent, and those of a stratum are identically
//! distributed, with mean `L_k` and within `[0, R_k]` (luminance). Tested by the suite's `control`.

use smallvec::SmallVec;

use super::Strata;
use super::summary::StratumSummary;
use crate::accel::Tracer;
use crate::bounds::UpperMaterial;
use crate::color::{Controlled, Rgb, RgbSum};
use crate::cut::clusters::Clusters;
use crate::cut::engine::{Cut, CutMemory};
use crate::cut::rank::{Rank, VisibilityPrior};
use crate::cut::refinement::{Refinement, RefinementOptions, Split};
use crate::cut::terms::{Term, TermBatch};
use crate::rng::Stream;

/// Number of samples of each stratum that is not evaluated as a whole.
const SAMPLES: usize = 2;
/// Largest number of terms of a pair that is evaluated as a whole: the number that would be drawn
/// from it.
const FINEST: u64 = 2;
/// Largest number of terms of a pair that is tabulated when it is split.
const TABULATED: u64 = 1024;

/// A cut whose strata inherit samples.
pub type InheritedCut<'a, B> = Cut<'a, B, InheritedStrata<'a>>;

/// Options of strata. A feature can be switched off to measure its benefit.
#[derive(Clone, Copy, Debug)]
pub struct StrataOptions<'a> {
    /// True if samples are passed on to children.
    pub inherits: bool,
    /// True if small pairs are tabulated.
    pub tabulates: bool,
    /// True if the visibility of samples updates the expected visibility.
    pub corrects: bool,
    /// Error metric: the components of the colour whose variances are estimated.
    pub controlled: Controlled,
    /// Expected visibility, from which intervals estimate the spread of terms that were not drawn.
    pub prior: VisibilityPrior<'a>,
}

/// Strata that inherit samples.
#[derive(Debug)]
pub struct InheritedStrata<'a> {
    pub(super) options: StrataOptions<'a>,
    /// `E`.
    pub(super) whole: RgbSum,
    pub(super) memory: &'a mut InheritedMemory,
}

/// Memory of [`InheritedStrata`].
#[derive(Debug, Default)]
pub(in crate::cut) struct InheritedMemory {
    /// Indices in `samples`, by number of the pair. Empty if the pair was split, contributes
    /// nothing, or is evaluated as a whole.
    pub(super) strata: Vec<Samples>,
    pub(super) samples: Vec<Sample>,
    /// Terms of pairs that were evaluated as a whole, with their values.
    pub(super) whole_terms: Vec<(Term, Rgb)>,
    /// Terms of whole pairs whose values have not been received yet.
    drawn_whole: Vec<Term>,
    /// Summaries of all strata that have samples, in the order of their pairs.
    pub(super) summaries: Vec<StratumSummary>,
}

type Samples = SmallVec<[u32; 4]>;

/// A term that was evaluated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) term: Term,
    /// Measure to which the probability of the term is proportional: `I_i w_j`, or `u` if it was
    /// drawn from a table.
    pub(super) measure: f64,
    /// Value of the term, including visibility, divided by `measure`.
    pub(super) unit: Rgb,
}

impl<'a, B: UpperMaterial> InheritedCut<'a, B> {
    /// Creates the initial cut: a single pair, or one for each instant. `None` if the sum has no
    /// terms.
    ///
    /// * `stream`: source of samples. The ranks of pairs must not depend on it.
    pub fn new(
        clusters: Clusters<'a, B>,
        rank: Rank<'a>,
        options: StrataOptions<'a>,
        tracer: &'a Tracer,
        stream: Stream,
        memory: &'a mut CutMemory,
    ) -> Option<Self> {
        let CutMemory { refinement, epoch, inherited: memory } = memory;
        let tabulated = if options.tabulates { TABULATED } else { 0 };
        let refinement =
            Refinement::new(clusters, RefinementOptions { rank, finest: FINEST, tabulated }, refinement)?;
        memory.strata.clear();
        memory.samples.clear();
        memory.whole_terms.clear();
        memory.summaries.clear();
        memory.strata.resize_with(refinement.roots(), Samples::default);
        let strata = InheritedStrata { options, whole: RgbSum::default(), memory };
        Some(Self::begin(refinement, strata, tracer, stream, epoch))
    }
}

impl<B: UpperMaterial> Strata<B> for InheritedStrata<'_> {
    fn split(&mut self, refinement: &Refinement<'_, B>, split: &Split, stream: &mut Stream) {
        let mut samples = std::mem::take(&mut self.memory.strata[split.parent as usize]);
        if !self.options.inherits {
            samples.clear();
        }
        let from_table = refinement.info(split.parent as usize).table.is_some();
        for child in [split.children, split.children + 1] {
            let inherited = self.inherited(refinement, child as usize, &samples, from_table, stream);
            self.memory.strata.push(inherited);
        }
    }

    fn draw(&mut self, refinement: &Refinement<'_, B>, k: usize, stream: &mut Stream, to: &mut TermBatch) {
        let info = refinement.info(k);
        if info.upper.0 <= 0.0 || info.is_split {
            return;
        }
        if info.is_finest {
            self.draw_whole(refinement, k, to);
            return;
        }
        let (clusters, pair) = (refinement.clusters(), &refinement.pairs()[k]);
        while self.memory.strata[k].len() < SAMPLES {
            let (term, measure) = if let Some(entry) = &info.table {
                let term = refinement.table().draw(clusters, pair, entry, stream.uniform_f64());
                (term, refinement.table().unoccluded(entry, term))
            } else {
                let term = clusters.draw(pair, stream);
                (term, clusters.weight_of_term(term))
            };
            self.memory.strata[k].push(self.memory.samples.len() as u32);
            self.memory.samples.push(Sample { term, measure, unit: Rgb::BLACK });
            to.push(clusters, term, 1.0 / measure);
        }
    }

    fn hear<'v>(&mut self, refinement: &Refinement<'_, B>, values: impl Iterator<Item = (usize, &'v [Rgb])>) {
        let InheritedMemory { strata, samples, whole_terms, drawn_whole, summaries } = &mut *self.memory;
        summaries.retain(|summary| !strata[summary.number as usize].is_empty());
        let mut drawn_whole = drawn_whole.drain(..);
        for (number, values) in values {
            let of_pair = &strata[number];
            if of_pair.is_empty() {
                for (&value, term) in values.iter().zip(&mut drawn_whole) {
                    self.whole.add(value);
                    whole_terms.push((term, value));
                }
                continue;
            }
            // New samples come after the inherited ones.
            for (&value, &k) in values.iter().rev().zip(of_pair.iter().rev()) {
                samples[k as usize].unit = value;
            }
            let units = || of_pair.iter().map(|&k| samples[k as usize].unit);
            let summary = StratumSummary::new(number, units, refinement, &self.options);
            summaries.push(summary);
        }
    }
}

impl InheritedStrata<'_> {
    /// Samples of a parent that the child keeps. `from_table` is true if they were drawn from a
    /// table.
    fn inherited<B: UpperMaterial>(
        &mut self,
        refinement: &Refinement<'_, B>,
        child: usize,
        samples: &[u32],
        from_table: bool,
        stream: &mut Stream,
    ) -> Samples {
        let (clusters, pair, info) =
            (refinement.clusters(), &refinement.pairs()[child], refinement.info(child));
        if info.upper.0 <= 0.0 {
            return Samples::default();
        }
        let all = &mut self.memory.samples;
        let is_inside = |k: &u32| clusters.holds(pair, all[*k as usize].term);
        let mut inside: Samples = samples.iter().copied().filter(is_inside).collect();
        if let (Some(entry), false, false) = (&info.table, from_table || info.is_finest, inside.is_empty()) {
            let table = refinement.table();
            let most = table.largest_share(clusters, pair, entry);
            inside.retain(|k| {
                let sample = &mut all[*k as usize];
                let unoccluded = table.unoccluded(entry, sample.term);
                let share = unoccluded / clusters.weight_of_term(sample.term);
                let keep = stream.uniform_f64() * most < share;
                if keep {
                    sample.unit = scaled(sample.unit, 1.0 / share);
                    sample.measure = unoccluded;
                }
                keep
            });
        }
        inside
    }

    /// Evaluates all terms of a pair. The values of terms that were drawn before are reused.
    fn draw_whole<B: UpperMaterial>(
        &mut self,
        refinement: &Refinement<'_, B>,
        number: usize,
        batch: &mut TermBatch,
    ) {
        let (clusters, pair) = (refinement.clusters(), &refinement.pairs()[number]);
        let entry = refinement.info(number).table;
        let memory = &mut *self.memory;
        let samples = std::mem::take(&mut memory.strata[number]);
        for term in clusters.all_terms(pair) {
            if entry.is_some_and(|entry| refinement.table().unoccluded(&entry, term) <= 0.0) {
                continue;
            }
            let mut drawn = samples.iter().map(|&k| &memory.samples[k as usize]);
            if let Some(sample) = drawn.find(|sample| sample.term == term) {
                let value = scaled(sample.unit, sample.measure);
                self.whole.add(value);
                memory.whole_terms.push((term, value));
            } else {
                batch.push(clusters, term, 1.0);
                memory.drawn_whole.push(term);
            }
        }
    }
}

fn scaled(unit: Rgb, factor: f64) -> Rgb {
    unit.map(|c| (f64::from(c) * factor) as f32)
}
