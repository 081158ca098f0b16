//! Pairs of a cut as strata that keep their samples: a split hands each sample on to the child that it lies in.
//!
//! ```text
//! L̂ = E + Σ_k ȳ_k          V̂ = Σ_k s_k² / n_k          y in [0, R_k],   n_k ≥ 2
//! ```
//!
//! with the mean `ȳ_k` and the sample variance `s_k²` of the `n_k` terms drawn from pair `k`, and the sum `E` of all pairs that are evaluated as a
//! whole.
//!
//! | pair | a term is drawn with probability | value `y` | `R` |
//! |---|---|---|---|
//! | large | `I_i / I_C · w_j / W_G` | term `· I_C W_G / (I_i w_j)` | upper bound |
//! | [listed](super::ListedTerms) | `u_ij / U` | term `· U / u_ij` | `U` |
//!
//! # Why samples may be kept
//! A term drawn from a pair has, given that it lies in a child, the child's own distribution of the same kind. Where a large pair has a listed
//! child, a sample is kept with the probability `(u/(I w)) / max (u/(I w))`, the maximum over the terms of the child: what is kept has the
//! distribution of the listed pair (rejection sampling). So the samples of a child are independent draws from it, given how many there are,
//! *if neither the split nor the rejection looked at visibility*. An [`Order`] cannot: it sees clusters alone. Rejection sees `u`. What an order
//! may look at besides (other pixels) comes from streams of its own.
//!
//! # Guarantee
//! Given the partition and the counts `n_k`, which do not depend on any visibility of this pixel's samples, all samples are independent, those of
//! a stratum identically distributed, with mean `L_k` and within `[0, R_k]` (luminance). Tested by the suite's `control`.

use smallvec::SmallVec;

use super::clusters::Clusters;
use super::listed::{Listed, Listing};
use super::refinement::{Order, Refinement, RefinementMemory};
use super::terms::{Term, TermBatch};
use crate::accel::Tracer;
use crate::bounds::UpperMaterial;
use crate::color::{Controlled, Rgb, RgbSum};
use crate::rng::Stream;
use crate::stats::stratified::{self, Spread};
use crate::transport::Transport;

/// Samples of a stratum that is not evaluated as a whole.
const SAMPLES: usize = 2;
/// Terms up to which a pair is listed. Higher: fewer bounds and fewer segments, but more terms to evaluate and to search.
const LISTED: u64 = 1024;
/// How many samples of the pixel an expected visibility weighs as much as, when it is corrected by what they saw.
const EXPECTATION_WEIGHT: f64 = 1.0;

/// A term that was evaluated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) term: Term,
    /// What its probability is proportional to: `I_i w_j`, or `u` of a listed pair's.
    pub(super) measure: f64,
    /// Its value, with visibility, over that.
    pub(super) unit: Rgb,
}

/// A pair of the cut, with its samples.
#[derive(Clone, Debug, Default)]
pub(super) struct Stratum {
    was_split: bool,
    /// Into [`InheritedCut::samples`]; none if the pair was split, contributes nothing, or is evaluated as a whole.
    pub(super) samples: SmallVec<[u32; 4]>,
}

/// What the samples of a stratum of the cut say; nothing of it changes until the stratum is split.
#[derive(Clone, Copy, Debug)]
pub(super) struct Said {
    /// Of the pair.
    pub(super) number: u32,
    /// How many there are.
    pub(super) samples: u32,
    /// Estimate of the stratum.
    pub(super) mean: RgbSum,
    /// Sample variance of each part that is controlled.
    variances: [f64; Controlled::MOST_PARTS],
    /// `R`, `R'` and `σ'²` of the luminance ([`stratified`]).
    upper: f64,
    importance_range: f64,
    importance_variance: f64,
}

/// Where the value of a term of the batch goes.
#[derive(Clone, Copy, Debug)]
enum Destination {
    /// A sample.
    Sample(u32),
    /// The sum of what is evaluated as a whole.
    Whole(Term),
}

/// What strata are made with. To leave something out is for measuring what it is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StrataOptions {
    /// Whether samples are handed on.
    pub inherits: bool,
    /// Whether small pairs are listed.
    pub lists: bool,
    /// Whether what samples see corrects the visibility that was expected.
    pub corrects: bool,
    /// Which numbers of the colour the strata tell about.
    pub controlled: Controlled,
}

/// A cut whose strata inherit samples.
pub struct InheritedCut<'a, B, O> {
    pub(super) refinement: Refinement<'a, B, O>,
    pub(super) options: StrataOptions,
    tracer: &'a Tracer,
    pub(super) transport: Transport,
    stream: Stream,
    /// `E`.
    whole: RgbSum,
    pairs: u64,
    segments: u64,
    pub(super) memory: &'a mut StrataMemory,
}

/// Memory of an [`InheritedCut`], which the next one uses again.
#[derive(Debug, Default)]
pub struct CutMemory {
    refinement: RefinementMemory,
    strata: StrataMemory,
}

#[derive(Debug, Default)]
pub(super) struct StrataMemory {
    pub(super) strata: Vec<Stratum>,
    pub(super) samples: Vec<Sample>,
    /// Terms that were evaluated as a whole.
    pub(super) whole_terms: Vec<(Term, Rgb)>,
    /// Of all strata that have samples, in the order of their pairs.
    pub(super) said: Vec<Said>,
    batch: TermBatch,
    /// Of the terms of the batch.
    destinations: Vec<Destination>,
    visibility: Vec<f32>,
}

impl<'a, B: UpperMaterial, O: Order> InheritedCut<'a, B, O> {
    /// The cut of a single pair; `None` if the sum has no terms.
    ///
    /// * `stream`: where samples come from; the order must not draw from it.
    pub fn new(
        clusters: Clusters<'a, B>,
        order: O,
        options: StrataOptions,
        tracer: &'a Tracer,
        transport: Transport,
        stream: Stream,
        memory: &'a mut CutMemory,
    ) -> Option<Self> {
        let listing = options.lists.then_some(Listing { transport, most: LISTED });
        let CutMemory { refinement, strata: memory } = memory;
        memory.strata.clear();
        memory.samples.clear();
        memory.whole_terms.clear();
        memory.said.clear();
        memory.strata.push(Stratum::default());
        let mut cut = Self {
            refinement: Refinement::new(clusters, order, listing, refinement)?,
            options,
            tracer,
            transport,
            stream,
            whole: RgbSum::default(),
            pairs: 1,
            segments: 0,
            memory,
        };
        cut.take(0, &[], None);
        cut.complete(0);
        Some(cut)
    }

    /// Refines until there are `pairs` pairs or nothing can be split, and draws and traces what new strata lack.
    pub fn grow(&mut self, pairs: u64) {
        let first = self.memory.strata.len();
        while self.pairs < pairs {
            let Some(next) = self.refinement.split_next() else { break };
            let (parent, children) = (next.parent as usize, next.children as usize);
            let mut inherited = std::mem::take(&mut self.memory.strata[parent].samples);
            if !self.options.inherits {
                inherited.clear();
            }
            let from = self.refinement.known(parent).listed;
            self.memory.strata[parent].was_split = true;
            self.pairs += 1;
            for child in [children, children + 1] {
                self.memory.strata.push(Stratum::default());
                self.take(child, &inherited, from);
            }
        }
        self.complete(first);
    }

    /// Pairs of the cut.
    pub fn pairs(&self) -> u64 {
        self.pairs
    }

    /// Segments traced.
    pub fn segments(&self) -> u64 {
        self.segments
    }

    /// Terms of the whole sum.
    pub fn terms(&self) -> u64 {
        self.refinement.clusters().terms(&self.refinement.pairs()[0])
    }

    /// Whether nothing is left that is only sampled: the estimate is the sum.
    pub fn is_whole(&self) -> bool {
        self.memory.said.is_empty()
    }

    /// The estimate, in the order of the pairs.
    pub fn estimate(&self) -> RgbSum {
        let mut sum = self.whole;
        for said in &self.memory.said {
            sum.merge(&said.mean);
        }
        sum
    }

    /// What the strata say of a part that is controlled, by its number among [`Controlled::parts`].
    ///
    /// * `estimate`: [of the cut](InheritedCut::estimate). How much of the part there is for a luminance of 1 is taken from it, for what is expected; not
    ///   for bounds.
    pub fn spread(&self, part: usize, estimate: &RgbSum) -> Spread {
        let of = &self.options.controlled.parts()[part];
        let luminance = estimate.luminance();
        let per_luminance = if luminance > 0.0 { of.of_sum(estimate) / luminance } else { of.per_luminance };
        Spread::of(self.memory.said.iter().map(|said| {
            let upper = said.upper * of.per_luminance;
            stratified::Stratum {
                samples: said.samples,
                upper,
                importance_range: (said.importance_range * per_luminance).min(upper),
                variance: said.variances[part],
                importance_variance: said.importance_variance * per_luminance * per_luminance,
            }
        }))
    }

    /// Draws and traces what the strata from `first` on lack, and hears what they say.
    fn complete(&mut self, first: usize) {
        let strata = &self.memory.strata;
        self.memory.said.retain(|said| !strata[said.number as usize].was_split);
        for number in first..self.memory.strata.len() {
            if !self.memory.strata[number].was_split {
                self.fill(number);
            }
        }
        self.trace();
        for number in first..self.memory.strata.len() {
            if !self.memory.strata[number].samples.is_empty() {
                self.memory.said.push(self.said(number));
            }
        }
    }

    fn said(&self, number: usize) -> Said {
        let known = self.refinement.known(number);
        let weight = self.weight(number);
        let samples = &self.memory.strata[number].samples;
        let n = samples.len() as f64;
        let units = || samples.iter().map(|&k| self.memory.samples[k as usize].unit);
        let mut mean = RgbSum::default();
        for unit in units() {
            mean.add(unit);
        }
        let luminance = mean.luminance();
        let mean = mean.scaled(1.0 / n);
        let mut variances = [0.0; Controlled::MOST_PARTS];
        for (variance, part) in variances.iter_mut().zip(self.options.controlled.parts()) {
            let middle = part.of_sum(&mean);
            let squares: f64 =
                units().map(|unit| part.of(unit) - middle).map(|deviation| deviation * deviation).sum();
            *variance = squares * weight * weight / (n - 1.0);
        }
        let expected = known.expectation.importance_visibility;
        let mut visibility = expected;
        if self.options.corrects {
            // What is expected to be in shadow and is seen in the light is a reason to expect more.
            let seen = (luminance * weight / known.upper).min(n);
            visibility = (EXPECTATION_WEIGHT * expected + seen) / (EXPECTATION_WEIGHT + n);
        }
        let size = known.upper * known.importance_of_bound;
        Said {
            number: number as u32,
            samples: samples.len() as u32,
            mean: mean.scaled(weight),
            variances,
            upper: known.upper,
            importance_range: size * visibility.sqrt(),
            importance_variance: expected * (1.0 - expected) * size * size,
        }
    }

    /// What makes values of units: `I_C W_G`, or `U` of a listed pair.
    pub(super) fn weight(&self, number: usize) -> f64 {
        let listed = self.refinement.known(number).listed;
        let weight = || self.refinement.clusters().weight(&self.refinement.pairs()[number]);
        listed.map_or_else(weight, |listed| listed.total)
    }

    /// Takes a pair into the cut, with those samples of its parent that lie in it; `from` is what is known of the parent's terms.
    fn take(&mut self, number: usize, inherited: &[u32], from: Option<Listed>) {
        let (clusters, pair) = (*self.refinement.clusters(), self.refinement.pairs()[number]);
        let known = *self.refinement.known(number);
        if known.upper <= 0.0 {
            return;
        }
        let inside = inherited
            .iter()
            .copied()
            .filter(|&k| clusters.holds(&pair, self.memory.samples[k as usize].term));
        let mut samples: SmallVec<[u32; 4]> = inside.collect();
        if known.is_finest {
            self.evaluate_whole(number, &samples, from);
            return;
        }
        if let (Some(listed), None, false) = (&known.listed, from, samples.is_empty()) {
            let terms = self.refinement.terms();
            let share = |term: Term| terms.unoccluded(listed, term) / clusters.weight_of_term(term);
            let most = terms.largest_share(&clusters, &pair, listed);
            samples.retain(|k| {
                let sample = &mut self.memory.samples[*k as usize];
                let share = share(sample.term);
                let keep = self.stream.uniform_f64() * most < share;
                if keep {
                    sample.unit = scaled(sample.unit, 1.0 / share);
                    sample.measure *= share;
                }
                keep
            });
        }
        self.memory.strata[number].samples = samples;
    }

    /// Adds all terms of a pair to the sum; those that have been drawn are known.
    fn evaluate_whole(&mut self, number: usize, drawn: &[u32], from: Option<Listed>) {
        let (clusters, pair) = (*self.refinement.clusters(), self.refinement.pairs()[number]);
        let listed = self.refinement.known(number).listed;
        for term in clusters.all_terms(&pair) {
            if listed.is_some_and(|listed| self.refinement.terms().unoccluded(&listed, term) <= 0.0) {
                continue;
            }
            let known =
                drawn.iter().map(|&k| &self.memory.samples[k as usize]).find(|sample| sample.term == term);
            if let Some(sample) = known {
                let measure = match &from {
                    Some(listed) => self.refinement.terms().unoccluded(listed, term),
                    None => clusters.weight_of_term(term),
                };
                let value = scaled(sample.unit, measure);
                self.whole.add(value);
                self.memory.whole_terms.push((term, value));
            } else {
                self.evaluate(term, 1.0, Destination::Whole(term));
            }
        }
    }

    /// Draws what a stratum lacks.
    fn fill(&mut self, number: usize) {
        let known = *self.refinement.known(number);
        if known.upper <= 0.0 || known.is_finest {
            return;
        }
        let (clusters, pair) = (*self.refinement.clusters(), self.refinement.pairs()[number]);
        while self.memory.strata[number].samples.len() < SAMPLES {
            let (term, measure) = if let Some(listed) = &known.listed {
                let terms = self.refinement.terms();
                let term = terms.draw(&clusters, &pair, listed, self.stream.uniform_f64());
                (term, terms.unoccluded(listed, term))
            } else {
                let term = clusters.draw(&pair, &mut self.stream);
                (term, clusters.weight_of_term(term))
            };
            let sample = self.memory.samples.len() as u32;
            self.memory.strata[number].samples.push(sample);
            self.memory.samples.push(Sample { term, measure, unit: Rgb::BLACK });
            self.evaluate(term, 1.0 / measure, Destination::Sample(sample));
        }
    }

    fn evaluate(&mut self, term: Term, factor: f64, destination: Destination) {
        let clusters = self.refinement.clusters();
        let (light, point) = (clusters.lights.light(term.light), clusters.points.point(term.point));
        self.memory.batch.push(&self.transport, point, &light, factor);
        self.memory.destinations.push(destination);
    }

    /// Traces the batch.
    fn trace(&mut self) {
        self.tracer.visibility(self.memory.batch.segments(), &mut self.memory.visibility);
        self.memory.batch.shadow(&self.memory.visibility);
        for (&value, destination) in self.memory.batch.values().iter().zip(&self.memory.destinations) {
            match destination {
                Destination::Sample(k) => self.memory.samples[*k as usize].unit = value,
                Destination::Whole(term) => {
                    self.whole.add(value);
                    self.memory.whole_terms.push((*term, value));
                }
            }
        }
        self.segments += self.memory.batch.segments().len() as u64;
        self.memory.batch.clear();
        self.memory.destinations.clear();
    }
}

fn scaled(unit: Rgb, factor: f64) -> Rgb {
    unit.map(|c| (f64::from(c) * factor) as f32)
}
