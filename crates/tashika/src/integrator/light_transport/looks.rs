//! When repetitions are looked at.

/// So many sets are used, each so often.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Look {
    pub sets: usize,
    pub rounds: u32,
}

/// Growth from look to look: every look is a chance to be fooled, and repetitions beyond what was needed cost.
const GROWTH: f64 = 1.5;
/// Rounds at which a pixel is out of budget.
const MOST_ROUNDS: u32 = 16;

impl Look {
    /// As few as a variance can be told from.
    pub(super) const FIRST: Self = Self { sets: 8, rounds: 1 };

    /// The look after this one where there are `sets` sets; none if the pixel is out of budget.
    pub(super) fn next(self, sets: usize) -> Option<Self> {
        let grown = |n: f64| (n * GROWTH).ceil();
        if self.sets < sets {
            return Some(Self { sets: (grown(self.sets as f64) as usize).min(sets), ..self });
        }
        (self.rounds < MOST_ROUNDS)
            .then(|| Self { rounds: (grown(self.rounds.into()) as u32).min(MOST_ROUNDS), ..self })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_more_sets_then_more_rounds() {
        let looks: Vec<Look> = std::iter::successors(Some(Look::FIRST), |look| look.next(20)).collect();
        let found: Vec<(usize, u32)> = looks.iter().map(|look| (look.sets, look.rounds)).collect();
        let expected =
            [(8, 1), (12, 1), (18, 1), (20, 1), (20, 2), (20, 3), (20, 5), (20, 8), (20, 12), (20, 16)];
        assert_eq!(found, expected);
    }
}
