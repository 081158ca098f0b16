//! Cuts: partitions of a pixel's sum into pairs of clusters, refined where it matters most.
//!
//! ```text
//! L = Σ_k L_k          k: pairs (C, G) of a light cluster and a gather cluster, every term in exactly one of them
//! ```
//!
//! * [`Clusters`]: pairs, with their bounds, splits and draws; [`TermTable`]: the terms of small
//!   pairs.
//! * [`Refinement`]: the next pair to split, by [`Rank`].
//! * [`Cut`]: the engine. In each epoch it splits pairs, draws terms and traces their segments.
//! * [`Strata`]: estimators of pairs. [`FreshStrata`], [`Representatives`], or [`InheritedStrata`],
//!   which keep their samples when a pair is split.
//! * [`StoppingRule`]: the rules by which published methods end a cut, a closed set.
//! * [`PilotVisibility`]: visibility measured from other pixels nearby, as a [`VisibilityPrior`].
//! * [`Population`]: estimates for lights and points that are drawn at random, from the samples of
//!   [`InheritedStrata`].
//!
//! # Held to this by
//! `cut::tests`, and the suite's `cuts`: the finest cut is the exact sum, and estimates at a fixed
//! cut are unbiased.

mod clusters;
mod engine;
mod pilot;
mod rank;
mod refinement;
mod stopping;
mod strata;
mod table;
mod terms;

#[cfg(test)]
mod tests;

pub use clusters::{Clusters, KernelBound, Pair, RadianceBound, gather_tree};
pub use engine::{Cut, CutMemory};
pub use pilot::{CellVisibility, Pilot, PilotVisibility};
pub use rank::{Rank, VisibilityPrior};
pub use refinement::{PairInfo, Refinement, RefinementMemory, RefinementOptions, Split};
pub use stopping::{CutEnd, CutEstimate, StoppingRule};
pub use strata::{
    FreshStrata, InheritedCut, InheritedStrata, OfPoint, PairEstimate, PairEstimates, Population,
    Representatives, Strata, StrataOptions,
};
pub use table::{TableEntry, TermTable};
pub use terms::{Term, TermBatch};
