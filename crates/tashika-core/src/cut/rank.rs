//! Order in which pairs are split, and visibility that is expected before anything is drawn.
//!
//! Neither has access to the samples of an estimate: that makes the partition independent of them.

use super::clusters::Pair;
use super::refinement::PairInfo;
use crate::tree::LightCluster;

/// Least expected visibility: lights that no pilot segment has seen may still be seen by the pixel.
const LEAST_VISIBILITY: f64 = 0.001;
/// Constant `c` of pairs that are bounded only: the variance of an unoccluded term in units of
/// `(q R)²`. A quarter is the most that it can be; larger values trust visibility less.
const UNOCCLUDED_VARIANCE: f64 = 0.5;
/// Constant `c` of tabulated pairs, whose terms differ by visibility alone: keeps pairs in full
/// sight from growing beyond all bounds.
const TABULATED_VARIANCE: f64 = 0.3;

/// Expected share of a cluster of lights that is visible from the neighbourhood of a pixel; not
/// proven.
#[derive(Clone, Copy, Debug, Default)]
pub struct VisibilityPrior<'a> {
    /// For the [number](LightCluster::number) of a cluster, a place in `visibility`.
    place_of: &'a [u32],
    visibility: &'a [f32],
}

impl<'a> VisibilityPrior<'a> {
    /// No expectation: all lights are taken to be visible.
    pub const NONE: VisibilityPrior<'static> = VisibilityPrior { place_of: &[], visibility: &[] };

    /// Creates the expectation from visibilities.
    ///
    /// * `place_of`: for the number of each cluster, a place in `visibility`.
    /// * `visibility`: in `[0, 1]`.
    pub const fn new(place_of: &'a [u32], visibility: &'a [f32]) -> Self {
        Self { place_of, visibility }
    }

    /// Expected visibility of a cluster, in `(0, 1]`.
    pub fn importance_visibility(&self, lights: &LightCluster) -> f64 {
        let visibility = |place: &u32| f64::from(self.visibility[*place as usize]).max(LEAST_VISIBILITY);
        self.place_of.get(lights.number()).map_or(1.0, visibility)
    }
}

/// Criterion by which pairs are split: the highest rank first.
#[derive(Clone, Copy, Debug)]
pub enum Rank<'a> {
    /// The bound `R`: the order of all published methods, and of certificates, which the largest
    /// bounds decide.
    Upper,
    /// The expected standard deviation of a pair, from its bound and the visibility `p` of its
    /// lights.
    ///
    /// ```text
    /// rank = q R √(p (1 − p) + c p)
    /// ```
    ///
    /// A term is `V u` with `0 ≤ u ≤ R`, and `q R` is about the root mean square of `u`
    /// ([`Clusters::importance_of_bound`](super::Clusters::importance_of_bound)):
    /// `p (1 − p) (q R)²` is its variance if `u = q R` throughout, `c p (q R)²` stands for that of
    /// `u`. Where lights surround a point, `q` is small: hardly any light is as near as the bound
    /// assumes all to be. Without `q`, the larger a set is, the more of the cut would be spent on
    /// bounds that no light reaches.
    Deviation(VisibilityPrior<'a>),
}

impl Rank<'_> {
    /// Rank of a pair; not negative.
    pub(super) fn of(&self, pair: &Pair, info: &PairInfo) -> f64 {
        match self {
            Self::Upper => info.upper.0,
            Self::Deviation(prior) => {
                let p = prior.importance_visibility(&pair.light);
                let c = if info.table.is_some() { TABULATED_VARIANCE } else { UNOCCLUDED_VARIANCE };
                info.importance_size() * (p * (1.0 - p) + c * p).sqrt()
            }
        }
    }
}
