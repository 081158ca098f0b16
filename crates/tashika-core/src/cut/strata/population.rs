//! Estimates, by the samples of a cut, for lights and points that are themselves drawn from all
//! possible ones.
//!
//! A cut estimates `L = Σ_j Σ_i c_ij` over given points `j` and lights `i`. If the truth is the
//! expectation over other lights and other points, the distance of `L` from it has to be estimated,
//! too.
//!
//! # Lights
//! If lights are drawn independently, the sum over all of them has a variance of at most
//! `Σ_i c_i²`, with `c_i = Σ_j c_ij`. From the samples `s` of the strata, each drawn with
//! probability `p_s`,
//!
//! ```text
//! Σ_i c_i² = Σ_ij c_ij c_i = E Σ_k (1/n_k) Σ_s c_s ĉ_s / p_s          ĉ_s = c_s / ω_s     or     c_s Σ_j u_ij / u_s
//! ```
//!
//! where `ĉ_s` approximates the contribution of the sample's light at all points. The first form
//! costs nothing; `ω_j` is the share of point `j` in the weights, and `ω_s` that of the sample's
//! point. It is equal to the contribution where all points receive the same from a light, and else
//! larger (Cauchy's inequality): far larger for a light next to a few of many points. The second
//! form takes the light to be visible everywhere if it is visible at the point of the sample. The
//! unoccluded terms `u_ij` of a few other points stand for those of all. It is too large by the
//! part in shadow. The uncertainty of the variance itself, where few lights contribute most,
//! follows from `Σ_i c_i⁴`, which is estimated in the same way. Lights that are not drawn, such as
//! points and spots, are ignored. Where lights are not drawn independently, the variance has to be
//! multiplied by their correlation
//! ([`importance_correlation`](crate::guidance::importance_correlation)).
//!
//! # Points
//! The contribution of point `j`, `c_j = Σ_i c_ij`, is estimated from the means of its strata and
//! from the deviations of its own samples:
//!
//! ```text
//! c_j = b_j + r_j        b_j = Σ_{k ∋ j} ω_jk ȳ_k        r_j = Σ_k Σ_{s at j} (y_s − ȳ_k)/(n_k − 1)        d_j = Σ of the squares of these
//! ```
//!
//! `r_j² − d_j` is without the noise of samples, since samples of different strata are independent.
//! So are squares of differences between points, less both `d`.
//!
//! Tested by `cut::tests::population`.

use super::inherited::InheritedCut;
use crate::bounds::UpperMaterial;
use crate::cut::terms::Term;
use crate::vpl::Vpl;

/// Estimates for the lights and points that a cut sums over.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Population {
    /// Approximate upper bound of the variance of the sum by the draw of lights.
    pub importance_by_lights: f64,
    /// Approximate upper bound of the sum of the fourth powers of the lights' contributions: it
    /// grows as fewer lights make up the variance.
    pub importance_fourth: f64,
    /// Approximate upper bound of the contribution of a single light.
    pub importance_largest: f64,
    /// Contribution of each point, in the order of the tree.
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

/// A term of a light that is drawn.
struct Drawn {
    term: Term,
    /// Contribution of the term to the sum.
    value: f64,
    /// Number of terms that it stands for.
    count: f64,
}

/// Number of other points that stand for all points.
const BESIDE: usize = 4;

impl Population {
    /// Sets the estimates for lights; `added` returns the contribution of a drawn term's light at
    /// all points.
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
    /// Estimates for a part of the error metric, by its number among
    /// [`Controlled::parts`](crate::color::Controlled::parts).
    ///
    /// * `is_given`: true if a light is always there, rather than drawn.
    /// * `worth`: variance by lights above which it is estimated again, with points other than
    ///   those of the samples.
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
        // Means of strata by the node of their points, over its weight.
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

    /// Approximates `Σ_j u_ij / u_s`. Different samples use different points that stand for all, by
    /// the number of the sample.
    fn all_points(&self, part: usize, number: usize, term: Term) -> f64 {
        let of = &self.strata.options.controlled.parts()[part];
        let clusters = self.refinement.clusters();
        let light = clusters.lights.light(term.light);
        let points = clusters.points.points();
        let unoccluded = |point: usize| of.of(clusters.contribution.unoccluded(&points[point], &light));
        let others = points.len() - 1;
        let beside = others.min(BESIDE);
        // Numbers of the other points, from that of the sample on.
        let other =
            |k: usize| (term.point as usize + 1 + (number + k * others / beside) % others) % points.len();
        let sum: f64 = (0..beside).map(|k| unoccluded(other(k))).sum();
        let scale = if beside > 0 { others as f64 / beside as f64 } else { 0.0 };
        let of_sample = unoccluded(term.point as usize);
        if of_sample > 0.0 { 1.0 + scale * sum / of_sample } else { 1.0 }
    }
}
