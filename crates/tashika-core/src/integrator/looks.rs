//! Interim analyses of a growing estimate, which stops when its interval is narrow enough.

use super::ControlOptions;

/// Share of the tolerance that growth aims at. The margin avoids a further analysis, which would
/// cost more than a little excess work.
pub(super) const AIM: f64 = 0.92;

/// Interim analyses that may state an interval. Since the estimate stops at the first narrow one,
/// each has a share of the error probability `δ`:
///
/// ```text
/// Σ_j δ_j ≤ δ          δ_1 = 0.7 δ,   δ_j = 0.3 δ 2^−(j−1)
/// ```
///
/// The probability that any of the intervals fails is then at most `δ` (union bound). An analysis
/// may state an interval only if this was planned before its samples were drawn, because the
/// estimate was predicted to be precise enough by then. Other analyses only predict the work that
/// is left, and have no share. Most pixels need a single analysis with a share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Looks {
    delta: f64,
    vain: u32,
}

/// Share of `δ` that the first analysis has.
const FIRST_SHARE: f64 = 0.7;

impl Looks {
    /// State before the first analysis.
    pub fn new(options: &ControlOptions) -> Self {
        Self { delta: 1.0 - options.confidence, vain: 0 }
    }

    /// Error probability `δ_j` of the next analysis.
    pub fn delta(&self) -> f64 {
        let share =
            if self.vain == 0 { FIRST_SHARE } else { (1.0 - FIRST_SHARE) / f64::from(1_u32 << self.vain) };
        share * self.delta
    }

    /// Counts an analysis whose interval was too wide.
    pub fn next(&mut self) {
        self.vain = (self.vain + 1).min(MOST_LOOKS);
    }
}

/// Number of analyses with different shares; no pixel has more.
const MOST_LOOKS: u32 = 31;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_looks_together_cost_what_there_is() {
        let mut looks = Looks::new(&ControlOptions { confidence: 0.96, ..ControlOptions::default() });
        let mut sum = 0.0;
        for _ in 0..MOST_LOOKS {
            sum += looks.delta();
            looks.next();
        }
        assert!((sum - 0.04).abs() < 1e-9, "{sum}");
    }
}
