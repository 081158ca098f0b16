//! Cuts: partitions of a pixel's sum into pairs of clusters, refined where their bounds are largest.
//!
//! ```text
//! L = Σ_k L_k          k: pairs (C, G) of a light cluster and a gather cluster, every term in exactly one of them
//! ```
//!
//! * [`Clusters`]: pairs, their bounds, how they are split.
//! * [`Refinement`]: the order of splits, by ranks that an [`Order`] gives: upper bounds ([`ByUpper`]), or these with pilot visibility
//!   ([`ByVisibility`]).
//! * [`Scheme`]: how a pair is estimated, by [`Strata`] or by [`Representatives`].
//! * [`StoppingRule`]: when a cut is fine enough; a closed family.
//! * [`Refiner`]: all of these together, as the published methods do it.
//! * [`InheritedCut`]: strata that keep their samples when they are split; small ones with all their terms [listed](ListedTerms).
//! * [`Population`]: what its samples say of lights and points that are themselves drawn.
//! * [`PilotVisibility`]: what other pixels of the neighbourhood see.
//!
//! # Guarantee
//! The partition is a function of bounds, which samples do not enter; so the samples of a cut are independent of it. But *when* the published rules
//! stop does depend on the samples that the estimate is made of: their intervals are not exact.
//!
//! # Held to this by
//! `cut::tests`, and the suite's `cuts`: the finest cut is the exact sum, and estimates at a fixed cut are unbiased.

mod clusters;
mod estimation;
mod inherited;
mod listed;
mod pilot;
mod population;
mod refinement;
mod sampling;
mod stopping;
mod terms;
mod visibility;

#[cfg(test)]
mod tests;

pub use clusters::{Clusters, Pair, gather_tree};
pub use estimation::{CutEnd, CutEstimate, Refiner};
pub use inherited::{CutMemory, InheritedCut, StrataOptions};
pub use listed::{Listed, ListedTerms, Listing};
pub use pilot::{CellVisibility, Pilot, PilotVisibility};
pub use population::{OfPoint, Population};
pub use refinement::{ByUpper, Candidate, Expectation, Known, Order, Refinement, RefinementMemory, Split};
pub use sampling::{PairEstimate, Representative, Representatives, Scheme, Strata};
pub use stopping::{Progress, StoppingRule};
pub use terms::{Term, TermBatch};
pub use visibility::ByVisibility;
