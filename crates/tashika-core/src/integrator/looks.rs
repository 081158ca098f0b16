//! When an interval may be stated, by an estimate that grows until its interval is narrow enough.

use super::ControlOptions;

/// Share of the tolerance that growth aims at: the next look costs more than a little too much
/// work.
pub(super) const AIM: f64 = 0.92;

/// The looks at which an interval may be stated: whoever stops when satisfied pays for every one.
///
/// ```text
/// Σ_j δ_j ≤ δ          δ_1 = 0.7 δ,   δ_j = 0.3 δ 2^−(j−1)
/// ```
///
/// so that the chance that any of the intervals fails stays within `δ` (union bound). It is decided
/// before a look whether it is one of these: when the estimate is foreseen to be good enough; looks
/// before only tell how far it is from that. Most pixels need one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Looks {
    delta: f64,
    vain: u32,
}

/// Share of `δ` that the first look has.
const FIRST_SHARE: f64 = 0.7;

impl Looks {
    /// Before the first.
    pub fn new(options: &ControlOptions) -> Self {
        Self { delta: 1.0 - options.confidence, vain: 0 }
    }

    /// `δ_j` of the next.
    pub fn delta(&self) -> f64 {
        let share =
            if self.vain == 0 { FIRST_SHARE } else { (1.0 - FIRST_SHARE) / f64::from(1_u32 << self.vain) };
        share * self.delta
    }

    /// One was in vain.
    pub fn next(&mut self) {
        self.vain = (self.vain + 1).min(MOST_LOOKS);
    }
}

/// Looks that are told apart: no pixel has more.
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
