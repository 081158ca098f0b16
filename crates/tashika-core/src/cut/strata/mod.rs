//! How the pairs of a cut are estimated: the one thing in which the cuts of different methods
//! differ.
//!
//! | strata | terms of a pair | estimate |
//! |---|---|---|
//! | [`FreshStrata`] | two, drawn anew after each split | their mean |
//! | [`Representatives`] | one, or the parent's if that lies in the pair | its value |
//! | [`InheritedStrata`] | at least two: the parent's that lie in the pair, and what is lacking | their mean |
//!
//! All are unbiased estimates of the pair's sum. A pair that is evaluated as a whole has that as
//! its estimate, without variance, and a pair whose upper bound is zero is zero. Luminance is what
//! variance is of.

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

/// A way to estimate pairs: in each epoch it is given all splits, then asked to draw, then given
/// the values.
///
/// Roots come of no split; they are drawn like any other pair.
pub trait Strata<B> {
    /// A pair gave way to two: what they take over from it.
    fn split(&mut self, _: &Refinement<'_, B>, _: &Split, _: &mut Stream) {}

    /// Adds the terms that the new pair `k` lacks; called once for each, in this order.
    fn draw(&mut self, refinement: &Refinement<'_, B>, k: usize, stream: &mut Stream, to: &mut TermBatch);

    /// Takes the values of these terms, with visibility: for each new pair `k`, in order.
    fn hear<'v>(&mut self, refinement: &Refinement<'_, B>, values: impl Iterator<Item = (usize, &'v [Rgb])>);
}

/// Strata whose pairs have an estimate each, so that a rule can be looked at after every split.
pub trait PairEstimates<B>: Strata<B> {
    /// Of pair `k`.
    fn estimate(&self, k: usize) -> &PairEstimate;
}

/// Estimate of a pair's sum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairEstimate {
    /// Estimate (W·m⁻²·sr⁻¹).
    pub radiance: Rgb,
    /// Estimated variance of its luminance (squared unit).
    pub variance: f64,
    /// Segments that were traced for it.
    pub segments: u64,
}
