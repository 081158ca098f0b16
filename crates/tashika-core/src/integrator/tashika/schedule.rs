//! When a cut is looked at, and how often that can be.

/// When a cut is looked at: at a number of pairs, and whenever it has grown by a factor since.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Schedule {
    /// Pairs at the first look.
    pub first: u64,
    /// Growth from look to look.
    pub growth: f64,
}

/// Fewer looks at small cuts would mean fewer chances to be fooled by samples that are all alike,
/// and more pairs than needed.
pub(super) const CALIBRATED: Schedule = Schedule { first: 64, growth: 1.15 };
/// Certificates pay for every look.
pub(super) const CERTIFIED: Schedule = Schedule { first: 512, growth: 1.15 };

/// For measuring what few looks are worth.
pub(super) const OFTEN: Schedule = Schedule { first: 8, growth: 1.02 };

impl Schedule {
    /// Pairs at the look after the one at `pairs`.
    pub(super) fn next(&self, pairs: u64) -> u64 {
        ((pairs as f64 * self.growth) as u64).max(pairs + 1)
    }

    /// How many looks there are at most until a cut has `most` pairs.
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

    /// The number of looks that a certificate pays for, counted by hand: the last is at a cut that
    /// is whole, or out of budget.
    #[test]
    fn looks_are_counted() {
        // 512, 588, 676, 777, 893.
        let expected =
            [(1, 1), (512, 1), (513, 2), (588, 2), (589, 3), (777, 4), (778, 5), (893, 5), (894, 6)];
        for (most, looks) in expected {
            assert_eq!(CERTIFIED.looks(most), looks, "{most}");
        }
        // A cut grows by a pair at least.
        assert_eq!(Schedule { first: 1, growth: 1.0 }.looks(10), 10);
    }
}
