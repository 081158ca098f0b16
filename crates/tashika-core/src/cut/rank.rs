//! Order in which pairs are split, and the visibility that is expected before any term is drawn.
//!
//! Neither has access to the samples of an estimate. The partition is therefore independent of
//! them.

use super::clusters::Pair;
use super::refinement::PairInfo;
use crate::tree::LightCluster;

/// Least expected visibility: a light that is hidden from all pilot segments may still be visible
/// from the pixel.
const LEAST_VISIBILITY: f64 = 0.001;
/// Constant `c` of pairs that are not tabulated: the variance of an unoccluded term in units of
/// `(q R)²`. A quarter is its largest possible value; a larger constant gives less weight to
/// visibility.
const UNOCCLUDED_VARIANCE: f64 = 0.5;
/// Constant `c` of tabulated pairs, whose terms differ by visibility alone. It prevents fully
/// visible pairs from growing without limit.
const TABULATED_VARIANCE: f64 = 0.3;

/// Expected share of a cluster of lights that is visible from the surroundings of a pixel. Not
/// guaranteed.
#[derive(Clone, Copy, Debug, Default)]
pub struct VisibilityPrior<'a> {
    /// For the [number](LightCluster::number) of each cluster, an index in `visibility`.
    place_of: &'a [u32],
    visibility: &'a [f32],
}

impl<'a> VisibilityPrior<'a> {
    /// No prior: all lights are expected to be visible.
    pub const NONE: VisibilityPrior<'static> = VisibilityPrior { place_of: &[], visibility: &[] };

    /// Creates a prior from visibilities.
    ///
    /// * `place_of`: for the number of each cluster, an index in `visibility`.
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

/// Criterion by which pairs are split, those of the highest rank first.
#[derive(Clone, Copy, Debug)]
pub enum Rank<'a> {
    /// The bound `R`. It is used by all published methods, and by certificates, whose width depends
    /// on the largest bounds.
    Upper,
    /// The expected standard deviation of a pair, from its bound and the visibility `p` of its
    /// lights.
    ///
    /// ```text
    /// rank = q R √(p (1 − p) + c p)
    /// ```
    ///
    /// A term is `V u` with `0 ≤ u ≤ R`, and `q R` is approximately the root mean square of `u`
    /// ([`Clusters::importance_of_bound`](super::Clusters::importance_of_bound)). If `u = q R` for
    /// all terms, the variance of a term is `p (1 − p) (q R)²`; the summand `c p (q R)²` stands for
    /// the variance of `u`. Where lights surround a point, `q` is small: the bound assumes that all
    /// lights are as near as the nearest, but hardly any is. Without `q`, larger sets of lights
    /// would spend more of the cut on bounds that no light attains.
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
