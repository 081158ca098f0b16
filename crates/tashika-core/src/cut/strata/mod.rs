//! Estimators of the pairs of a cut. The cuts of different methods differ only in these.
//!
//! | strata | terms of a pair | estimate |
//! |---|---|---|
//! | [`FreshStrata`] | two, drawn anew after each split | their mean |
//! | [`Representatives`] | one, or the parent's if that lies in the pair | its value |
//! | [`InheritedStrata`] | at least two: the parent's in the pair, and new ones | their mean |
//!
//! All are unbiased estimates of the pair's sum. The estimate of a pair that is evaluated as a
//! whole is its exact sum, with variance zero. The estimate of a pair whose upper bound is zero is
//! zero. Variances are those of luminance.

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

/// An estimator of pairs. In each epoch it receives all splits, then draws terms, and then receives
/// their values.
///
/// Root pairs do not come from a split; their terms are drawn like those of any other pair.
pub trait Strata<B> {
    /// Passes the data of a split pair to its two children.
    fn split(&mut self, _: &Refinement<'_, B>, _: &Split, _: &mut Stream) {}

    /// Adds the terms that the new pair `k` lacks; called once for each new pair, in ascending
    /// order.
    fn draw(&mut self, refinement: &Refinement<'_, B>, k: usize, stream: &mut Stream, to: &mut TermBatch);

    /// Receives the values of the drawn terms, including visibility, for each new pair `k`, in
    /// order.
    fn hear<'v>(&mut self, refinement: &Refinement<'_, B>, values: impl Iterator<Item = (usize, &'v [Rgb])>);
}

/// Strata with an estimate for each pair, so that a rule can be evaluated after every split.
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
