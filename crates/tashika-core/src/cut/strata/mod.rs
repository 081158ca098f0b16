//! Estimators of the pairs of a cut: the one thing in which the cuts of different methods differ.
//!
//! | strata | terms of a pair | estimate |
//! |---|---|---|
//! | [`FreshStrata`] | two, drawn anew after each split | their mean |
//! | [`Representatives`] | one, or the parent's if that lies in the pair | its value |
//! | [`InheritedStrata`] | at least two: the parent's in the pair, and new ones | their mean |
//!
//! All are unbiased estimates of the pair's sum. A pair that is evaluated as a whole has its sum as
//! estimate, without variance, and a pair whose upper bound is zero is zero. Variances are those of
//! luminance.

mod fresh;
mod inherited;
mod population;
mod representatives;
mod summary;

pub use fresh::FreshStrata;
pub use inherited::{InheritedCut, InheritedStrata, StrataOptions};
pub use population::{OfPoint, Population};
pub use representatives::Representatives;

pub(super) use inherited::InheritedMemory;

use super::refinement::{Refinement, Split};
use super::terms::TermBatch;
use crate::color::Rgb;
use crate::rng::Stream;

/// An estimator of pairs: in each epoch it receives all splits, then draws terms, then receives
/// their values.
///
/// Roots come of no split; they are drawn like any other pair.
pub trait Strata<B> {
    /// Passes data of a split pair on to its two children.
    fn split(&mut self, _: &Refinement<'_, B>, _: &Split, _: &mut Stream) {}

    /// Adds the terms that the new pair `k` lacks; called once for each new pair, in this order.
    fn draw(&mut self, refinement: &Refinement<'_, B>, k: usize, stream: &mut Stream, to: &mut TermBatch);

    /// Receives the values of the drawn terms, with visibility, for each new pair `k`, in order.
    fn hear<'v>(&mut self, refinement: &Refinement<'_, B>, values: impl Iterator<Item = (usize, &'v [Rgb])>);
}

/// Strata whose pairs have an estimate each, so that a rule can be evaluated after every split.
pub trait PairEstimates<B>: Strata<B> {
    /// Estimate of the sum of pair `k`.
    fn estimate(&self, k: usize) -> &PairEstimate;
}

/// Estimate of a pair's sum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairEstimate {
    /// Estimate (W·m⁻²·sr⁻¹).
    pub radiance: Rgb,
    /// Estimated variance of the luminance (squared unit).
    pub variance: f64,
    /// Number of segments traced for the estimate.
    pub segments: u64,
}
