//! When a cut is fine enough.

use crate::stats::student_t_two_sided;

/// The rules by which published methods end, a closed family.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StoppingRule {
    /// No pair that can be split has an upper bound above `error` times the estimate (Walter 2005, section 3.3).
    LargestUpper {
        /// Relative error `ε`.
        error: f64,
    },
    /// The half-width of the t-interval is at most `error` times the estimate (Nabata 2016):
    ///
    /// ```text
    /// t_N √(Σ s²) ≤ ε L̂          N: pairs of the cut
    /// ```
    ///
    /// It is not looked at before the cut has `min_pairs` pairs.
    Interval {
        /// Relative error `ε`.
        error: f64,
        /// Confidence of the interval, in (0, 1).
        confidence: f64,
        /// Pairs from which on the rule counts.
        min_pairs: u64,
    },
}

/// What rules look at.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Pairs of the cut.
    pub pairs: u64,
    /// Luminance of the estimate (W·m⁻²·sr⁻¹).
    pub luminance: f64,
    /// Its estimated variance.
    pub variance: f64,
    /// Largest upper bound of a pair that can be split; `None` if no pair can be.
    pub largest_upper: Option<f64>,
}

impl StoppingRule {
    /// Whether the cut is fine enough.
    pub fn is_met(&self, progress: &Progress) -> bool {
        match *self {
            Self::LargestUpper { error } => {
                progress.largest_upper.is_none_or(|upper| upper <= error * progress.luminance)
            }
            Self::Interval { error, min_pairs, .. } => {
                progress.pairs >= min_pairs && self.half_width(progress) <= error * progress.luminance
            }
        }
    }

    /// Half-width of the interval that the rule states (W·m⁻²·sr⁻¹); 0 if it states none.
    pub fn half_width(&self, progress: &Progress) -> f64 {
        match *self {
            Self::LargestUpper { .. } => 0.0,
            Self::Interval { confidence, .. } => {
                student_t_two_sided(confidence, progress.pairs as f64) * progress.variance.max(0.0).sqrt()
            }
        }
    }

    /// Confidence of the interval that it states, if it states one.
    pub fn confidence(&self) -> Option<f64> {
        match *self {
            Self::LargestUpper { .. } => None,
            Self::Interval { confidence, .. } => Some(confidence),
        }
    }
}
