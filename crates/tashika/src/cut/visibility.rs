//! The order of refinement that visibility suggests, where it is expected to be known.

use super::refinement::{Candidate, Expectation, Order};

/// Visibility below which none is taken: what no pilot segment has seen may still be seen by the pixel.
const LEAST_VISIBILITY: f64 = 0.001;
/// `c` of pairs that are known by their bounds: the variance of an unoccluded term in units of `(q R)²`. A quarter is the most that it can be;
/// larger values trust visibility less.
const UNOCCLUDED_VARIANCE: f64 = 0.5;
/// `c` of listed pairs, whose terms differ by visibility alone: keeps those in sight from growing beyond all bounds.
const LISTED_VARIANCE: f64 = 0.3;
/// Terms up to which a pair is evaluated as a whole: as many as would be drawn from it.
const FINEST: u64 = 2;

/// An order by the standard deviation that pairs are expected to have, from their bounds and from the visibility `p` that is expected of
/// their lights.
///
/// ```text
/// rank = q R √(p (1 − p) + c p)
/// ```
///
/// A term is `V u` with `0 ≤ u ≤ R`, and `q R` is about the root mean square of `u` ([`Clusters::importance_of_bound`](super::Clusters::importance_of_bound)): `p (1 − p) (q R)²` is its variance if
/// `u = q R` throughout, `c p (q R)²` stands for that of `u`. Where lights are around a point, `q` is small: hardly any is as near as the bound has all of them, and without
/// `q` the larger a set is, the more of the cut would be spent on bounds that no light comes up to.
#[derive(Clone, Copy, Debug)]
pub struct ByVisibility<'a> {
    /// By [number](crate::tree::LightCluster::number) of the cluster of lights: a place in `visibility`.
    pub place_of: &'a [u32],
    /// Visibilities, in `[0, 1]`.
    pub visibility: &'a [f32],
}

impl Order for ByVisibility<'_> {
    fn expect(&mut self, candidate: &Candidate<'_>) -> Expectation {
        let place = self.place_of[candidate.pair.light.number()];
        let p = f64::from(self.visibility[place as usize]).max(LEAST_VISIBILITY);
        let c = if candidate.is_listed { LISTED_VARIANCE } else { UNOCCLUDED_VARIANCE };
        let size = candidate.upper * candidate.importance_of_bound;
        Expectation { rank: size * (p * (1.0 - p) + c * p).sqrt(), importance_visibility: p }
    }

    fn finest(&self) -> u64 {
        FINEST
    }
}
