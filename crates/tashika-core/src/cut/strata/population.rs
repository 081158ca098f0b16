//! Uncertainty of a cut's sum if its lights and points are themselves random, estimated from the
//! samples of the cut.
//!
//! A cut estimates `L = Σ_j Σ_i c_ij` over given points `j` and lights `i`. If the truth is the
//! expectation over random lights and random points, the deviation of `L` from that expectation has
//! to be estimated, too.
//!
//! # Lights
//! If lights are drawn independently, the variance of the sum over all of them is at most
//! `Σ_i c_i²`, with `c_i = Σ_j c_ij`. It is estimated from the samples `s` of the strata, each
//! drawn with probability `p_s`:
//!
//! ```text
//! Σ_i c_i² = Σ_ij c_ij c_i = E Σ_k (1/n_k) Σ_s c_s ĉ_s / p_s          ĉ_s = c_s / ω_s     or     c_s Σ_j u_ij / u_s
//! ```
//!
//! Here `ĉ_s` approximates the contribution of the sample's light to all points. `ω_j` is the share
//! of point `j` in the weights, and `ω_s` the share of the sample's point. The first form of `ĉ_s`
//! costs nothing. It is exact if all points receive the same from a light, and otherwise too large
//! on average (Cauchy's inequality): far too large for a light close to a few of many points. The
//! second form assumes that the light is visible from all points if it is visible from the sample's
//! point. Unoccluded terms `u_ij` of a few other points represent those of all points. This form is
//! too large by the contribution of points in shadow. If few lights contribute most, the variance
//! itself is uncertain. This uncertainty follows from `Σ_i c_i⁴`, which is estimated in the same
//! way. Lights that are not drawn, such as points and spots, are ignored. If lights are not drawn
//! independently, the variance has to be multiplied by their correlation
//! ([`importance_correlation`](crate::guidance::importance_correlation)).
//!
//! # Points
//! The contribution of point `j`, `c_j = Σ_i c_ij`, is estimated from the means of its strata and
//! the deviations of its samples:
//!
//! ```text
//! c_j = b_j + r_j        b_j = Σ_{k ∋ j} ω_jk ȳ_k        r_j = Σ_k Σ_{s at j} (y_s − ȳ_k)/(n_k − 1)        d_j = Σ of the squares of these
//! ```
//!
//! Samples of different strata are independent, so `r_j² − d_j` is free of their noise on average.
//! The same holds for the squared difference of two points, minus both values of `d`.
//!
//! Tested by `cut::tests::population`.

use super::inherited::InheritedCut;
use crate::bounds::UpperMaterial;
use crate::cut::terms::Term;
use crate::vpl::Vpl;

/// Estimates for the lights and points that a cut sums over.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Population {
    /// Approximate upper bound of the variance of the sum due to the random choice of lights.
    pub importance_by_lights: f64,
    /// Approximate upper bound of the sum of the fourth powers of the lights' contributions. It is
    /// larger if fewer lights cause the variance.
    pub importance_fourth: f64,
    /// Approximate upper bound of the contribution of a single light.
    pub importance_largest: f64,
    /// Contribution of each point, in the order of the gather tree.
    pub points: Vec<OfPoint>,
}

/// Contribution of a point to the sum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OfPoint {
    /// `b_j + r_j`.
    pub value: f64,
    /// `d_j`: noise in the square of `value`.
    pub noise: f64,
}

/// A drawn term whose light was drawn at random.
struct Drawn {
    term: Term,
    /// Contribution of the term to the sum.
    value: f64,
    /// Number of terms that this one represents.
    count: f64,
}

/// Number of other points that represent all points.
const BESIDE: usize = 4;

impl Population {
    /// Computes the estimates for lights. `added` returns the contribution of a drawn term's light
    /// to all points.
    fn with_lights(&mut self, drawn: &[Drawn], added: impl Fn(usize, &Drawn) -> f64) {
        (self.importance_by_lights, self.importance_fourth, self.importance_largest) = (0.0, 0.0, 0.0);
        for (number, drawn) in drawn.iter().enumerate() {
            let added = added(number, drawn).abs();
            let of_term = drawn.count * drawn.value.abs() * added;
            self.importance_largest = self.importance_largest.max(added);
            self.importance_by_lights += of_term;
            self.importance_fourth += of_term * added * added;
        }
    }
}

impl<B: UpperMaterial> InheritedCut<'_, B> {
    /// Estimates for one component of the error metric, given by its index in
    /// [`Controlled::parts`](crate::color::Controlled::parts).
    ///
    /// * `is_given`: returns true for lights that always exist and are not drawn at random.
    /// * `worth`: if the variance due to lights exceeds this, it is computed by the second form,
    ///   with additional points.
    pub fn population(&self, part: usize, is_given: impl Fn(&Vpl) -> bool, worth: f64) -> Population {
        let of = &self.strata.options.controlled.parts()[part];
        let (clusters, memory) = (self.refinement.clusters(), &*self.strata.memory);
        let nodes = clusters.points.nodes();
        let Some(root) = nodes.first() else { return Population::default() };
        let share = |point: u32| {
            f64::from(clusters.points.point(point).weight.max_channel()) / f64::from(root.weight)
        };
        let mut population =
            Population { points: vec![OfPoint::default(); root.count as usize], ..Population::default() };
        let mut drawn = Vec::new();
        let mut draw = |term: Term, value: f64, count: f64| {
            if value != 0.0 && !is_given(&clusters.lights.light(term.light)) {
                drawn.push(Drawn { term, value, count });
            }
        };
        // Means of strata, summed by the node of their points and divided by its weight.
        let mut means = vec![0.0; nodes.len()];
        for summary in &memory.summaries {
            let number = summary.number as usize;
            let (weight, n) = (self.refinement.weight(number), f64::from(summary.samples));
            let mean = of.of_sum(&summary.mean);
            let node = self.refinement.pairs()[number].points as usize;
            means[node] += mean / f64::from(nodes[node].weight);
            for &k in &memory.strata[number] {
                let sample = &memory.samples[k as usize];
                let (value, point) = (weight * of.of(sample.unit), sample.term.point);
                let probability = sample.measure / weight;
                draw(sample.term, value * probability, 1.0 / (probability * n));
                let residual = (value - mean) / (n - 1.0);
                let point = &mut population.points[point as usize];
                point.value += residual;
                point.noise += residual * residual;
            }
        }
        for (term, value) in &memory.whole_terms {
            let value = of.of(*value);
            population.points[term.point as usize].value += value;
            draw(*term, value, 1.0);
        }
        for (number, node) in nodes.iter().enumerate() {
            if let Some(children) = node.children {
                children.into_iter().for_each(|child| means[child as usize] += means[number]);
            } else {
                population.points[node.first as usize].value += means[number] * f64::from(node.weight);
            }
        }
        population.with_lights(&drawn, |_, drawn| drawn.value / share(drawn.term.point));
        if population.importance_by_lights > worth {
            population
                .with_lights(&drawn, |number, drawn| drawn.value * self.all_points(part, number, drawn.term));
        }
        population
    }

    /// Approximates `Σ_j u_ij / u_s`. The points that represent all others depend on the sample's
    /// number, so that different samples use different points.
    fn all_points(&self, part: usize, number: usize, term: Term) -> f64 {
        let of = &self.strata.options.controlled.parts()[part];
        let clusters = self.refinement.clusters();
        let light = clusters.lights.light(term.light);
        let points = clusters.points.points();
        let unoccluded = |point: usize| of.of(clusters.contribution.unoccluded(&points[point], &light));
        let others = points.len() - 1;
        let beside = others.min(BESIDE);
        // Index of the `k`-th other point, counted from the sample's point.
        let other =
            |k: usize| (term.point as usize + 1 + (number + k * others / beside) % others) % points.len();
        let sum: f64 = (0..beside).map(|k| unoccluded(other(k))).sum();
        let scale = if beside > 0 { others as f64 / beside as f64 } else { 0.0 };
        let of_sample = unoccluded(term.point as usize);
        if of_sample > 0.0 { 1.0 + scale * sum / of_sample } else { 1.0 }
    }
}
