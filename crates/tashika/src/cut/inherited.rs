//! Pairs of a cut as strata that keep their samples: a split hands each sample on to the child that it lies in.
//!
//! ```text
//! L̂ = Σ_k ȳ_k          V̂ = Σ_k s_k² / n_k          y = term · I_C W_G / (I_i w_j) in [0, R_k],   n_k ≥ 2
//! ```
//!
//! with the mean `ȳ_k` and the sample variance `s_k²` of the `n_k` terms drawn from pair `k`. Pairs of few terms are evaluated as a whole and
//! have no variance.
//!
//! # Why samples may be kept
//! A term drawn from a pair with probability `I_i/I_C · w_j/W_G` has, given that it lies in a child, the child's own distribution. So the
//! samples of a child are independent draws from it, given how many there are, *if the split did not look at their values*. An
//! [`Order`] cannot: it sees clusters alone. What it may look at besides (unoccluded terms, other pixels) comes from streams of its own.
//!
//! # Guarantee
//! Given the partition and the counts `n_k`, which do not depend on any value, all samples are independent, those of a stratum
//! identically distributed, with mean `L_k` and within `[0, R_k]` (luminance). Tested by the suite's `control`.

use smallvec::SmallVec;

use super::clusters::Clusters;
use super::refinement::{Order, Refinement};
use super::terms::{Term, TermBatch};
use crate::accel::Tracer;
use crate::bounds::UpperMaterial;
use crate::color::{Rgb, RgbSum};
use crate::rng::Stream;
use crate::stats::stratified;
use crate::transport::Transport;

/// Samples of a stratum that is not evaluated as a whole.
const SAMPLES: usize = 2;

/// A term that was evaluated.
#[derive(Clone, Copy, Debug)]
struct Sample {
    term: Term,
    /// Its value over `I_i w_j`, with visibility (W·m⁻²·sr⁻¹ for each unit of `I W`).
    unit: Rgb,
}

/// A pair of the cut, with its samples.
#[derive(Clone, Debug, Default)]
struct Stratum {
    in_cut: bool,
    /// Whether its samples are all its terms.
    whole: bool,
    /// Upper bound `R` (W·m⁻²·sr⁻¹); zero if the pair contributes nothing.
    upper: f64,
    /// Into [`InheritedCut::samples`].
    samples: SmallVec<[u32; 4]>,
}

/// A cut whose strata inherit samples.
pub struct InheritedCut<'a, B, O> {
    refinement: Refinement<'a, B, O>,
    tracer: &'a Tracer,
    transport: Transport,
    stream: Stream,
    strata: Vec<Stratum>,
    samples: Vec<Sample>,
    batch: TermBatch,
    visibility: Vec<f32>,
    pairs: u64,
    segments: u64,
}

impl<'a, B: UpperMaterial, O: Order> InheritedCut<'a, B, O> {
    /// The cut of a single pair; `None` if the sum has no terms.
    ///
    /// * `stream`: where samples come from; the order must not draw from it.
    pub fn new(
        clusters: Clusters<'a, B>,
        order: O,
        tracer: &'a Tracer,
        transport: Transport,
        stream: Stream,
    ) -> Option<Self> {
        let refinement = Refinement::new(clusters, order)?;
        let upper = clusters.upper(&refinement.pairs()[0]);
        let mut cut = Self {
            refinement,
            tracer,
            transport,
            stream,
            strata: vec![Stratum { in_cut: true, upper, ..Stratum::default() }],
            samples: Vec::new(),
            batch: TermBatch::default(),
            visibility: Vec::new(),
            pairs: 1,
            segments: 0,
        };
        cut.fill(0);
        cut.trace(0);
        Some(cut)
    }

    /// Refines until there are `pairs` pairs or nothing can be split, and draws and traces what new strata lack.
    pub fn grow(&mut self, pairs: u64) {
        let (first_pair, first_sample) = (self.strata.len(), self.samples.len());
        while self.pairs < pairs {
            let Some(split) = self.refinement.split_next() else { break };
            self.split(split.parent as usize, split.children as usize);
        }
        for number in first_pair..self.strata.len() {
            if self.strata[number].in_cut {
                self.fill(number);
            }
        }
        self.trace(first_sample);
    }

    /// Whether nothing can be split any more: the estimate is the whole sum.
    pub fn is_finest(&self) -> bool {
        self.refinement.highest_rank().is_none()
    }

    /// Pairs of the cut.
    pub fn pairs(&self) -> u64 {
        self.pairs
    }

    /// Segments traced.
    pub fn segments(&self) -> u64 {
        self.segments
    }

    /// The estimate, in the order of the pairs, and what each stratum that is not whole says.
    pub fn summarize(&self, strata: &mut Vec<stratified::Stratum>) -> RgbSum {
        strata.clear();
        let mut sum = RgbSum::default();
        for (number, (stratum, pair)) in self.strata.iter().zip(self.refinement.pairs()).enumerate() {
            if !stratum.in_cut || stratum.samples.is_empty() {
                continue;
            }
            let values = stratum.samples.iter().map(|&k| self.samples[k as usize]);
            if stratum.whole {
                let clusters = self.refinement.clusters();
                values.for_each(|s| sum.add(scaled(s.unit, clusters.weight_of_term(s.term))));
                continue;
            }
            let weight = self.refinement.clusters().weight(pair);
            let n = stratum.samples.len() as f64;
            let mut mean = 0.0;
            for sample in values.clone() {
                sum.add(scaled(sample.unit, weight / n));
                mean += f64::from(sample.unit.luminance()) / n;
            }
            let squares: f64 = values
                .map(|s| f64::from(s.unit.luminance()) - mean)
                .map(|deviation| deviation * deviation)
                .sum();
            strata.push(stratified::Stratum {
                samples: stratum.samples.len() as u32,
                upper: stratum.upper,
                importance_range: self.refinement.expectation(number).importance_range,
                variance: squares * weight * weight / (n - 1.0),
            });
        }
        sum
    }

    /// Takes two children for their parent, and hands the parent's samples on.
    fn split(&mut self, parent: usize, children: usize) {
        let inherited = std::mem::take(&mut self.strata[parent].samples);
        self.strata[parent].in_cut = false;
        self.pairs += 1;
        let clusters = self.refinement.clusters();
        for number in [children, children + 1] {
            let pair = &self.refinement.pairs()[number];
            let upper = clusters.upper(pair);
            let holds = |&k: &u32| clusters.holds(pair, self.samples[k as usize].term);
            // A pair that contributes nothing needs no samples, and one that is evaluated as a whole needs each term once.
            let keeps = upper > 0.0 && !self.refinement.is_finest(pair);
            let samples =
                if keeps { inherited.iter().copied().filter(holds).collect() } else { SmallVec::new() };
            self.strata.push(Stratum { in_cut: true, whole: false, upper, samples });
        }
    }

    /// Draws what a stratum lacks.
    fn fill(&mut self, number: usize) {
        let pair = self.refinement.pairs()[number];
        if self.strata[number].upper <= 0.0 {
            return;
        }
        let clusters = *self.refinement.clusters();
        if self.refinement.is_finest(&pair) {
            self.strata[number].whole = true;
            let light = clusters.lights.nodes()[pair.light as usize];
            let points = clusters.points.nodes()[pair.points as usize];
            for light in light.first..light.first + light.count {
                for point in points.first..points.first + points.count {
                    self.evaluate(number, Term { light, point });
                }
            }
        } else {
            while self.strata[number].samples.len() < SAMPLES {
                let term = clusters.draw(&pair, &mut self.stream);
                self.evaluate(number, term);
            }
        }
    }

    fn evaluate(&mut self, number: usize, term: Term) {
        let clusters = self.refinement.clusters();
        let (light, point) = (clusters.lights.light(term.light), clusters.points.point(term.point));
        self.batch.push(&self.transport, point, light, 1.0 / clusters.weight_of_term(term));
        self.strata[number].samples.push(self.samples.len() as u32);
        self.samples.push(Sample { term, unit: Rgb::BLACK });
    }

    /// Traces the batch, whose terms are the samples from `first` on.
    fn trace(&mut self, first: usize) {
        self.tracer.visibility(self.batch.segments(), &mut self.visibility);
        self.batch.shadow(&self.visibility);
        for (sample, &value) in self.samples[first..].iter_mut().zip(self.batch.values()) {
            sample.unit = value;
        }
        self.segments += self.batch.segments().len() as u64;
        self.batch.clear();
    }
}

fn scaled(unit: Rgb, factor: f64) -> Rgb {
    unit.map(|c| (f64::from(c) * factor) as f32)
}
