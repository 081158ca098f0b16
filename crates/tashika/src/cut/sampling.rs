//! How a pair of a cut is estimated: by terms drawn from it, or by a representative.
//!
//! | scheme | terms of a pair | estimate | variance of the estimate |
//! |---|---|---|---|
//! | [`Strata`] | two, independent, with `p_ij = I_i / I_C · w_j / W_G` | `½ (y₁ + y₂)`, `y = term / p_ij` | `s² = ¼ (y₁ − y₂)²` |
//! | [`Representatives`] | one, with the same probability, or the parent's if that lies in the pair | `y` | not known |
//!
//! Both give unbiased estimates of the pair's sum. A pair that is a single term has that term as its estimate, without variance, and a pair
//! whose upper bound is zero is zero. Luminance is what variance is of.

use super::clusters::{Clusters, Pair};
use super::terms::{Term, TermBatch};
use crate::bounds::UpperMaterial;
use crate::color::Rgb;
use crate::rng::Stream;
use crate::transport::Transport;

/// Estimate of a pair's sum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairEstimate {
    /// Estimate (W·m⁻²·sr⁻¹).
    pub radiance: Rgb,
    /// Estimated variance of its luminance (squared unit).
    pub variance: f64,
}

/// A way to estimate pairs.
pub trait Scheme {
    /// What a pair remembers of its terms.
    type Drawn: Copy;

    /// Draws the terms of a pair that has a positive bound, given what its parent drew (`None` for the root). Terms that have to be evaluated
    /// are appended to `batch`.
    fn draw<B: UpperMaterial>(
        &self,
        clusters: &Clusters<'_, B>,
        pair: &Pair,
        parent: Option<&Self::Drawn>,
        transport: &Transport,
        stream: &mut Stream,
        batch: &mut TermBatch,
    ) -> Self::Drawn;

    /// The estimate of a pair.
    ///
    /// * `values`: of the terms that [`Scheme::draw`] appended for it, with visibility.
    /// * `parent`: estimate of its parent.
    fn estimate(&self, drawn: &Self::Drawn, values: &[Rgb], parent: &PairEstimate) -> PairEstimate;
}

/// Two independent terms a pair, fresh after each split (Nabata 2016, Sakai 2018, Iwasaki 2019).
#[derive(Clone, Copy, Debug)]
pub struct Strata;

impl Scheme for Strata {
    type Drawn = ();

    fn draw<B: UpperMaterial>(
        &self,
        clusters: &Clusters<'_, B>,
        pair: &Pair,
        _: Option<&()>,
        transport: &Transport,
        stream: &mut Stream,
        batch: &mut TermBatch,
    ) {
        let count = if clusters.is_single(pair) { 1 } else { 2 };
        for _ in 0..count {
            let term = clusters.draw(pair, stream);
            push_term(clusters, pair, term, transport, batch);
        }
    }

    fn estimate(&self, (): &(), values: &[Rgb], _: &PairEstimate) -> PairEstimate {
        match values {
            [y] => PairEstimate { radiance: *y, variance: 0.0 },
            [a, b] => {
                let difference = f64::from(a.luminance()) - f64::from(b.luminance());
                PairEstimate { radiance: (*a + *b) * 0.5, variance: 0.25 * difference * difference }
            }
            _ => unreachable!("one or two terms are drawn of a pair"),
        }
    }
}

/// One representative a pair, which a child takes over from its parent where it can (Walter 2005, 2006).
#[derive(Clone, Copy, Debug)]
pub struct Representatives;

/// A representative.
#[derive(Clone, Copy, Debug)]
pub struct Representative {
    term: Term,
    /// `I_C W_G` over the parent's, if the term is the parent's.
    share_of_parent: Option<f32>,
    weight: f64,
}

impl Scheme for Representatives {
    type Drawn = Representative;

    fn draw<B: UpperMaterial>(
        &self,
        clusters: &Clusters<'_, B>,
        pair: &Pair,
        parent: Option<&Representative>,
        transport: &Transport,
        stream: &mut Stream,
        batch: &mut TermBatch,
    ) -> Representative {
        let fresh = clusters.draw(pair, stream);
        let weight = clusters.weight(pair);
        let of = |range: (u32, u32), parent: u32, fresh: u32| {
            if parent >= range.0 && parent - range.0 < range.1 { parent } else { fresh }
        };
        let term = parent.map_or(fresh, |parent| {
            let (light, points) = (&pair.light, &clusters.points.nodes()[pair.points as usize]);
            Term {
                light: of((light.first, light.count), parent.term.light, fresh.light),
                point: of((points.first, points.count), parent.term.point, fresh.point),
            }
        });
        let share_of_parent =
            parent.filter(|parent| parent.term == term).map(|parent| (weight / parent.weight) as f32);
        if share_of_parent.is_none() {
            push_term(clusters, pair, term, transport, batch);
        }
        Representative { term, share_of_parent, weight }
    }

    fn estimate(&self, drawn: &Representative, values: &[Rgb], parent: &PairEstimate) -> PairEstimate {
        let radiance = match (values, drawn.share_of_parent) {
            ([y], None) => *y,
            ([], Some(share)) => parent.radiance * share,
            _ => unreachable!("a representative is evaluated unless it is the parent's"),
        };
        PairEstimate { radiance, variance: 0.0 }
    }
}

/// Appends a term of a pair, over its probability.
fn push_term<B: UpperMaterial>(
    clusters: &Clusters<'_, B>,
    pair: &Pair,
    term: Term,
    transport: &Transport,
    batch: &mut TermBatch,
) {
    let (light, point) = (clusters.lights.light(term.light), clusters.points.point(term.point));
    batch.push(transport, point, &light, clusters.weight(pair) / clusters.weight_of_term(term));
}
