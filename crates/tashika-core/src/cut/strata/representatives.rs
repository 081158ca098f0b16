//! Strata with one representative term per pair. A child keeps its parent's representative where
//! possible (Walter 2005, 2006).
//!
//! ```text
//! L̂_k = term · I_C W_G / (I_i w_j)          drawn with probability I_i / I_C · w_j / W_G, unless the parent's lies in the pair
//! ```
//!
//! Given that the parent's representative lies in a child, it has the distribution of a term drawn
//! from the child. The variance is unknown.

use super::{PairEstimate, PairEstimates, Strata};
use crate::bounds::UpperMaterial;
use crate::color::Rgb;
use crate::cut::refinement::{Refinement, Split};
use crate::cut::terms::{Term, TermBatch};
use crate::rng::Stream;

/// Pairs with one representative.
#[derive(Clone, Debug, Default)]
pub struct Representatives {
    /// Representative of each pair; `None` if the pair contributes nothing.
    terms: Vec<Option<Term>>,
    /// Parent of each pair that is not a root.
    parents: Vec<u32>,
    estimates: Vec<PairEstimate>,
}

impl<B: UpperMaterial> Strata<B> for Representatives {
    fn split(&mut self, _: &Refinement<'_, B>, split: &Split, _: &mut Stream) {
        self.parents.extend([split.parent; 2]);
    }

    fn draw(&mut self, refinement: &Refinement<'_, B>, k: usize, stream: &mut Stream, to: &mut TermBatch) {
        let (clusters, pair) = (refinement.clusters(), &refinement.pairs()[k]);
        let before = to.segments();
        let mut term = None;
        if refinement.info(k).upper.0 > 0.0 {
            let fresh = clusters.draw(pair, stream);
            let of_parent = self.parent_of(refinement, k).and_then(|parent| self.terms[parent]);
            let kept = of_parent.map_or(fresh, |parent| {
                let (points, lights) = clusters.members(pair);
                let light =
                    if lights.contains(&(parent.light as usize)) { parent.light } else { fresh.light };
                let point =
                    if points.contains(&(parent.point as usize)) { parent.point } else { fresh.point };
                Term { light, point }
            });
            if of_parent != Some(kept) {
                to.push(clusters, kept, clusters.inverse_probability(pair, kept));
            }
            term = Some(kept);
        }
        self.terms.push(term);
        let segments = to.segments() - before;
        self.estimates.push(PairEstimate { segments, ..PairEstimate::default() });
    }

    fn hear<'v>(&mut self, refinement: &Refinement<'_, B>, values: impl Iterator<Item = (usize, &'v [Rgb])>) {
        let weight = |number: usize| refinement.clusters().weight(&refinement.pairs()[number]);
        for (number, values) in values {
            if let [y] = values {
                self.estimates[number].radiance = *y;
            } else if let (Some(_), Some(parent)) = (self.terms[number], self.parent_of(refinement, number)) {
                let share = (weight(number) / weight(parent)) as f32;
                self.estimates[number].radiance = self.estimates[parent].radiance * share;
            }
        }
    }
}

impl<B: UpperMaterial> PairEstimates<B> for Representatives {
    fn estimate(&self, number: usize) -> &PairEstimate {
        &self.estimates[number]
    }
}

impl Representatives {
    fn parent_of<B: UpperMaterial>(&self, refinement: &Refinement<'_, B>, number: usize) -> Option<usize> {
        Some(self.parents[number.checked_sub(refinement.roots())?] as usize)
    }
}
