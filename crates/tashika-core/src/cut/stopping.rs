//! Stopping rules of published methods, which are evaluated after every single split.
//!
//! ```text
//! L̂ = Σ_k L̂_k          V̂ = Σ_k s_k²          k: pairs of the cut
//! ```
//!
//! The order of splits does not depend on samples. Therefore the splits of an epoch are planned in
//! advance, their terms drawn and all segments traced together. Work beyond the split at which the
//! rule is met is discarded and not counted.

use super::engine::Cut;
use super::strata::PairEstimates;
use crate::bounds::UpperMaterial;
use crate::color::RgbSum;
use crate::stats::student_t_two_sided;

/// Number of splits of an epoch, as a share of the pairs in the cut; see also [`MIN_EPOCH`].
const EPOCH_SHARE: f64 = 0.125;
/// Minimum number of splits of an epoch; see [`EPOCH_SHARE`].
const MIN_EPOCH: u64 = 31;

/// Stopping rules of published methods, a closed set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StoppingRule {
    /// The largest upper bound of a pair that can be split is at most `error` times the estimate
    /// (Walter 2005, section 3.3).
    LargestUpper {
        /// Relative error `ε` of the estimate.
        error: f64,
    },
    /// The half-width of the t-interval is at most `error` times the estimate (Nabata 2016):
    ///
    /// ```text
    /// t_N √(Σ s²) ≤ ε L̂          N: pairs of the cut
    /// ```
    ///
    /// The rule is not evaluated before the cut has `min_pairs` pairs.
    Interval {
        /// Relative error `ε` of the estimate.
        error: f64,
        /// Confidence of the interval, in (0, 1).
        confidence: f64,
        /// Number of pairs from which the rule is evaluated.
        min_pairs: u64,
    },
}

/// Reason why a cut ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CutEnd {
    /// The stopping rule of the cut is met.
    RuleMet,
    /// No pair can be split.
    #[default]
    Finest,
    /// The cut has reached the permitted number of pairs.
    Budget,
}

/// Estimate of a sum by a cut. The default is the estimate of a sum without terms.
#[derive(Clone, Copy, Debug, Default)]
pub struct CutEstimate {
    /// Estimate (W·m⁻²·sr⁻¹).
    pub radiance: RgbSum,
    /// Estimated variance of the luminance.
    pub variance: f64,
    /// Half-width of the interval that the rule states for the luminance (W·m⁻²·sr⁻¹); 0 if the
    /// rule states none.
    pub half_width: f64,
    /// Reason why the cut ended.
    pub end: CutEnd,
    /// Number of pairs in the cut.
    pub pairs: u64,
    /// Number of segments traced for the estimate.
    pub segments: u64,
}

impl StoppingRule {
    /// Refines a cut until the rule is met or the cut has `max_pairs` pairs.
    pub fn refine<B: UpperMaterial, S: PairEstimates<B>>(
        &self,
        mut cut: Cut<'_, B, S>,
        max_pairs: u64,
    ) -> CutEstimate {
        let mut now = CutEstimate::default();
        (0..cut.roots() as u32).for_each(|root| now.add(&cut, root));
        loop {
            let wanted = ((now.pairs as f64 * EPOCH_SHARE) as u64).max(MIN_EPOCH);
            cut.grow((now.pairs + wanted).min(max_pairs));
            for split in cut.splits() {
                if self.ends(&mut now, Some(split.rank), max_pairs) {
                    return now;
                }
                now.remove(&cut, split.parent);
                now.add(&cut, split.children);
                now.add(&cut, split.children + 1);
            }
            if self.ends(&mut now, cut.highest_rank(), max_pairs) {
                return now;
            }
        }
    }

    /// Returns true if the cut ends here, and records the reason. `largest_upper` is the largest
    /// bound of a pair that can be split; `None` if no pair can be split.
    fn ends(&self, now: &mut CutEstimate, largest_upper: Option<f64>, max_pairs: u64) -> bool {
        let half_width = self.confidence().map_or(0.0, |confidence| {
            student_t_two_sided(confidence, now.pairs as f64) * now.variance.max(0.0).sqrt()
        });
        let luminance = now.radiance.luminance();
        let is_met = match *self {
            Self::LargestUpper { error } => largest_upper.is_none_or(|upper| upper <= error * luminance),
            Self::Interval { error, min_pairs, .. } => {
                now.pairs >= min_pairs && half_width <= error * luminance
            }
        };
        now.end = match largest_upper {
            None => CutEnd::Finest,
            Some(_) if is_met => CutEnd::RuleMet,
            Some(_) if now.pairs >= max_pairs => CutEnd::Budget,
            Some(_) => return false,
        };
        now.half_width = half_width;
        now.variance = now.variance.max(0.0);
        true
    }

    /// Confidence of the interval that the rule states; `None` if the rule states none.
    pub fn confidence(&self) -> Option<f64> {
        match *self {
            Self::LargestUpper { .. } => None,
            Self::Interval { confidence, .. } => Some(confidence),
        }
    }
}

impl CutEstimate {
    fn add<B: UpperMaterial, S: PairEstimates<B>>(&mut self, cut: &Cut<'_, B, S>, number: u32) {
        let pair = cut.estimate_of(number);
        self.radiance.add(pair.radiance);
        self.variance += pair.variance;
        self.segments += pair.segments;
        self.pairs += 1;
    }

    fn remove<B: UpperMaterial, S: PairEstimates<B>>(&mut self, cut: &Cut<'_, B, S>, number: u32) {
        let pair = cut.estimate_of(number);
        self.radiance.remove(pair.radiance);
        self.variance -= pair.variance;
        self.pairs -= 1;
    }
}
