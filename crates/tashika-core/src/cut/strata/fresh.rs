//! Strata with two independent terms per pair, drawn afresh after each split (Nabata 2016, Sakai
//! 2018, Iwasaki 2019).
//!
//! ```text
//! L̂_k = ½ (y₁ + y₂)          s² = ¼ (y₁ − y₂)²          y = term · I_C W_G / (I_i w_j), drawn with probability I_i / I_C · w_j / W_G
//! ```

use super::{PairEstimate, PairEstimates, Strata};
use crate::bounds::UpperMaterial;
use crate::color::Rgb;
use crate::cut::refinement::Refinement;
use crate::cut::terms::TermBatch;
use crate::rng::Stream;

/// Pairs as strata with two fresh terms each.
#[derive(Clone, Debug, Default)]
pub struct FreshStrata {
    /// Estimate of each pair, by its number.
    estimates: Vec<PairEstimate>,
}

impl<B: UpperMaterial> Strata<B> for FreshStrata {
    fn draw(&mut self, refinement: &Refinement<'_, B>, k: usize, stream: &mut Stream, to: &mut TermBatch) {
        let (clusters, pair) = (refinement.clusters(), &refinement.pairs()[k]);
        let info = refinement.info(k);
        let before = to.segments();
        if info.upper.0 > 0.0 {
            for _ in 0..if info.is_finest { 1 } else { 2 } {
                let term = clusters.draw(pair, stream);
                to.push(clusters, term, clusters.inverse_probability(pair, term));
            }
        }
        let segments = to.segments() - before;
        self.estimates.push(PairEstimate { segments, ..PairEstimate::default() });
    }

    fn hear<'v>(&mut self, _: &Refinement<'_, B>, values: impl Iterator<Item = (usize, &'v [Rgb])>) {
        for (number, values) in values {
            let estimate = &mut self.estimates[number];
            match values {
                [] => (),
                [y] => estimate.radiance = *y,
                [a, b] => {
                    let difference = f64::from(a.luminance()) - f64::from(b.luminance());
                    estimate.radiance = (*a + *b) * 0.5;
                    estimate.variance = 0.25 * difference * difference;
                }
                _ => unreachable!("at most two terms are drawn of a pair"),
            }
        }
    }
}

impl<B: UpperMaterial> PairEstimates<B> for FreshStrata {
    fn estimate(&self, number: usize) -> &PairEstimate {
        &self.estimates[number]
    }
}
