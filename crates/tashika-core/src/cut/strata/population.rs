//! What the samples of a cut say of the lights and points that it sums over, where these are
//! themselves drawn from all that there could be.
//!
//! A cut estimates `L = Σ_j Σ_i c_ij` over the points `j` and lights `i` that there are. Whose
//! truth is the expectation over other lights and other points has to know how far `L` is from it.
//!
//! # Lights
//! Of lights that are drawn independently, the sum over all of them has a variance of at most `Σ_i
//! c_i²`, with `c_i = Σ_j c_ij`. From the samples `s` of the strata, each drawn with probability
//! `p_s`,
//!
//! ```text
//! Σ_i c_i² = Σ_ij c_ij c_i = E Σ_k (1/n_k) Σ_s c_s ĉ_s / p_s          ĉ_s = c_s / ω_s     or     c_s Σ_j u_ij / u_s
//! ```
//!
//! where `ĉ_s` is about what the light of the sample adds at all points. The first costs nothing,
//! with the share `ω_j` that the point `j` has of the weights: equal where all points receive the
//! same of a light, and else more (Cauchy's inequality). A light next to a few of many points adds
//! far less than that. The second takes the light to be visible everywhere if it is at the point of
//! the sample, and the unoccluded terms `u_ij` of a few other points, which stand for all: more
//! than it is by what is in shadow. How uncertain the variance is itself, where few lights give
//! most, follows from `Σ_i c_i⁴`, which is estimated in the same way. Lights that are not drawn,
//! points and spots say, are left out. Where lights are not drawn each by itself it has to be
//! multiplied by what they have in common
//! ([`importance_correlation`](crate::guidance::importance_correlation)).
//!
//! # Points
//! How much light point `j` adds, `c_j = Σ_i c_ij`, is known from what its strata have on average
//! and how its own samples deviate from that:
//!
//! ```text
//! c_j = b_j + r_j        b_j = Σ_{k ∋ j} ω_jk ȳ_k        r_j = Σ_k Σ_{s at j} (y_s − ȳ_k)/(n_k − 1)        d_j = Σ of the squares of these
//! ```
//!
//! `r_j² − d_j` is without the noise of samples, since those of different strata are independent:
//! so are squares of differences, less both `d`.
//!
//! Tested by `cut::tests::population`.

use super::inherited::InheritedCut;
use crate::bounds::UpperMaterial;
use crate::cut::terms::Term;
use crate::vpl::Vpl;

/// What the samples of a cut say of the lights and points that it sums over.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Population {
    /// About at most the variance of the sum by which lights were drawn.
    pub importance_by_lights: f64,
    /// About at most the sum of the fourth powers of what each light adds: how few lights that
    /// variance comes from.
    pub importance_fourth: f64,
    /// About the most that one light adds.
    pub importance_largest: f64,
    /// Of each point, in the order of the tree.
    pub points: Vec<OfPoint>,
}

/// What a point adds to the sum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OfPoint {
    /// `b_j + r_j`.
    pub value: f64,
    /// `d_j`: how much of the square of that is noise.
    pub noise: f64,
}

/// A term of a light that is drawn.
struct Drawn {
    term: Term,
    /// What it adds to the sum.
    value: f64,
    /// How many it stands for.
    count: f64,
}

/// Other points that tell what a light adds at all of them.
const BESIDE: usize = 4;

impl Population {
    /// With what lights add, for a light of which a term is known.
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
    /// What the samples say of a part that is controlled, by its number among
    /// [`Controlled::parts`](crate::color::Controlled::parts).
    ///
    /// * `is_given`: whether a light is always there, rather than one of those that could be.
    /// * `worth`: a variance by lights beyond which it is told with other points than those of the
    ///   samples.
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

    /// About `Σ_j u_ij / u_s`. Which points stand for all goes round with the number of the sample.
    fn all_points(&self, part: usize, number: usize, term: Term) -> f64 {
        let of = &self.strata.options.controlled.parts()[part];
        let clusters = self.refinement.clusters();
        let light = clusters.lights.light(term.light);
        let points = clusters.points.points();
        let unoccluded = |point: usize| of.of(clusters.contribution.unoccluded(&points[point], &light));
        let others = points.len() - 1;
        let beside = others.min(BESIDE);
        // Numbers of the others, from that of the sample on.
        let other =
            |k: usize| (term.point as usize + 1 + (number + k * others / beside) % others) % points.len();
        let sum: f64 = (0..beside).map(|k| unoccluded(other(k))).sum();
        let scale = if beside > 0 { others as f64 / beside as f64 } else { 0.0 };
        let of_sample = unoccluded(term.point as usize);
        if of_sample > 0.0 { 1.0 + scale * sum / of_sample } else { 1.0 }
    }
}
