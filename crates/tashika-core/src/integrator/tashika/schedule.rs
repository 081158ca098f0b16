//! Schedule of the interim analyses of a cut, and their largest number.

/// Interim analyses of a cut: one at a number of pairs, and one whenever the cut has grown by a
/// factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Schedule {
    /// Pairs at the first analysis.
    pub first: u64,
    /// Growth from analysis to analysis.
    pub growth: f64,
}

/// Schedule of calibrated claims. With fewer analyses of small cuts, equal samples would end a
/// pixel wrongly less often, but pixels would use more pairs than needed.
pub(super) const CALIBRATED: Schedule = Schedule { first: 64, growth: 1.15 };
/// Schedule of certificates, whose error probability is shared by all analyses.
pub(super) const CERTIFIED: Schedule = Schedule { first: 512, growth: 1.15 };

/// Frequent analyses, to measure the effect of few ones.
pub(super) const OFTEN: Schedule = Schedule { first: 8, growth: 1.02 };

impl Schedule {
    /// Pairs at the analysis after the one at `pairs`.
    pub(super) fn next(&self, pairs: u64) -> u64 {
        ((pairs as f64 * self.growth) as u64).max(pairs + 1)
    }

    /// Largest number of analyses until a cut has `most` pairs.
    pub(super) fn looks(&self, most: u64) -> u32 {
        let (mut pairs, mut looks) = (self.first, 1);
        while pairs < most {
            pairs = self.next(pairs);
            looks += 1;
        }
        looks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of analyses that share a certificate's error probability equals a count by hand.
    /// The last analysis is at a cut that is whole or out of budget.
    #[test]
    fn looks_are_counted() {
        // 512, 588, 676, 777, 893.
        let expected =
            [(1, 1), (512, 1), (513, 2), (588, 2), (589, 3), (777, 4), (778, 5), (893, 5), (894, 6)];
        for (most, looks) in expected {
            assert_eq!(CERTIFIED.looks(most), looks, "{most}");
        }
        // A cut grows by at least one pair.
        assert_eq!(Schedule { first: 1, growth: 1.0 }.looks(10), 10);
    }
}
