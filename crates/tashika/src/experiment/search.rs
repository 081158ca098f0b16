//! Search for the largest setting with which a method reaches a goal.
//!
//! The goal is a share of the pixels within the tolerance. The setting is the error `ε` that the
//! method receives. The search begins with the tolerance itself. While the goal is reached it
//! doubles `ε`; otherwise it halves `ε` until the goal is reached. Then it bisects:
//!
//! ```text
//! ε = √(ε_reached · ε_missed)          until ε_missed ≤ 1.1 ε_reached
//! ```
//!
//! # Assumption
//! A smaller `ε` never lowers the share of the pixels within the tolerance. If this holds only
//! approximately, the result is *a* setting that succeeded, close to a larger one that failed.
//!
//! # Held to this by
//! `experiment::tests`.

/// State of a search. The caller runs each trial and reports its outcome.
#[derive(Clone, Debug)]
pub struct Search {
    start: f64,
    reached: Option<f64>,
    missed: Option<f64>,
}

/// Ratio of missed to reached setting at which the search ends. It takes three bisections from a
/// ratio of two.
const CLOSE: f64 = 1.1;
/// Halvings after which the search gives up.
const MOST_HALVINGS: i32 = 10;

impl Search {
    /// Returns a search that begins with the given setting, above 0 and at most 1.
    pub fn new(start: f64) -> Self {
        Self { start, reached: None, missed: None }
    }

    /// Next setting to try; `None` if the search has ended.
    pub fn next_trial(&self) -> Option<f64> {
        match (self.reached, self.missed) {
            (None, None) => Some(self.start),
            // 1 is the largest error that a method takes.
            (Some(reached), None) => (reached < 1.0).then(|| (2.0 * reached).min(1.0)),
            (None, Some(missed)) => {
                let least = self.start / f64::from(1 << MOST_HALVINGS);
                (missed > least).then_some(0.5 * missed)
            }
            (Some(reached), Some(missed)) => (missed > CLOSE * reached).then(|| (reached * missed).sqrt()),
        }
    }

    /// Records whether a setting reached the goal.
    pub fn tell(&mut self, setting: f64, reached: bool) {
        *if reached { &mut self.reached } else { &mut self.missed } = Some(setting);
    }

    /// Largest setting known to reach the goal.
    pub fn found(&self) -> Option<f64> {
        self.reached
    }
}
