//! The mean of independent repetitions, and how wrong it can be.
//!
//! `X_1 … X_R` are independent and identically distributed, `L = E X`. Each comes with estimates of parts of its variance, `v_r`: what it knows of its
//! own noise. With the means `X̄`, `v̄` and the sample variance `s²`,
//!
//! ```text
//! e = max(0, s² − v̄)        V̂ = v̄ + e        h = t_ν √(V̂/R) + κ b̄ ln(2/δ)/R        ν = (R − 1) (V̂/e)²
//! ```
//!
//! `s²` holds everything, but has `R − 1` degrees of freedom only; `v̄` holds what is known within, from hundreds of samples. What `s²` has beyond `v̄`, the
//! excess `e`, is what repetitions alone can show. `V̂` is never below either, and its degrees of freedom are those of Satterthwaite 1946
//! with as many for `v̄` as need not be counted: where the excess is all, Student's interval of `R` numbers; where there is none, nearly the normal one.
//! The last term is that of [`stratified`](super::stratified), with the mean `b̄` of what a repetition knows of rare and large values.
//!
//! The interval is an estimate: measured, not proven. Held to this by the tests below.

use super::Moments;
use super::stratified::KAPPA;
use super::student_t_two_sided;
use crate::math::elementary::ln_f64;

/// Most degrees of freedom that are told from infinitely many.
const MANY: f64 = 1e6;

/// What repetitions say, `N` parts of their variance being known within each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Replicates<const N: usize> {
    values: Moments,
    within: [f64; N],
    rare: f64,
}

/// An interval about a mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReplicateInterval<const N: usize> {
    /// Half-width `h`.
    pub half_width: f64,
    /// Standard error `√(V̂/R)`.
    pub standard_error: f64,
    /// What the half-width would be if each known part were all.
    pub within: [f64; N],
    /// What it would be if the excess were all.
    pub excess: f64,
}

impl<const N: usize> Default for Replicates<N> {
    fn default() -> Self {
        Self { values: Moments::default(), within: [0.0; N], rare: 0.0 }
    }
}

impl<const N: usize> Replicates<N> {
    /// Takes in a repetition: its value, the parts of its variance that are known within, and about the largest rare value.
    pub fn push(&mut self, value: f64, within: [f64; N], rare: f64) {
        self.values.push(value);
        self.within.iter_mut().zip(within).for_each(|(sum, v)| *sum += v);
        self.rare += rare;
    }

    /// How many.
    pub fn count(&self) -> u64 {
        self.values.count()
    }

    /// `X̄`.
    pub fn mean(&self) -> f64 {
        self.values.mean()
    }

    /// The interval of this confidence, in (0, 1); infinite for fewer than two repetitions.
    pub fn interval(&self, confidence: f64) -> ReplicateInterval<N> {
        let count = self.count() as f64;
        if self.count() < 2 {
            let none = f64::INFINITY;
            return ReplicateInterval {
                half_width: none,
                standard_error: none,
                within: [none; N],
                excess: none,
            };
        }
        let within = self.within.map(|sum| sum / count);
        let known: f64 = within.iter().sum();
        let excess = (self.values.variance() - known).max(0.0);
        let variance = known + excess;
        let freedom = if excess > 0.0 {
            ((count - 1.0) * (variance / excess) * (variance / excess)).min(MANY)
        } else {
            MANY
        };
        let t = student_t_two_sided(confidence, freedom);
        let of = |variance: f64| t * (variance / count).sqrt();
        let rare = KAPPA * self.rare / count * ln_f64(2.0 / (1.0 - confidence)) / count;
        ReplicateInterval {
            half_width: of(variance) + rare,
            standard_error: (variance / count).sqrt(),
            within: within.map(of),
            excess: of(excess),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary::ln_f64;
    use crate::rng::{Purpose, Stream};
    use crate::stats::clopper_pearson;

    /// A pixel whose light sets have the standard deviation `of_sets`, and whose samples have that of `of_samples`, half of it known from each of two
    /// sources.
    struct Model {
        of_sets: f64,
        of_samples: f64,
        repetitions: usize,
        /// Whether each set is used twice under different names.
        sets_are_shared: bool,
    }

    /// About normal: the sum of twelve uniform numbers.
    fn normal(s: &mut Stream) -> f64 {
        (0..12).map(|_| s.uniform_f64()).sum::<f64>() - 6.0
    }

    impl Model {
        /// How many of 4000 intervals at 95 % hold the truth, 1.
        fn kept(&self) -> u64 {
            let trial = |trial: u64| {
                let mut s = Stream::new(11, Purpose::Test, trial);
                let mut replicates = Replicates::<2>::default();
                let mut set = 0.0;
                for number in 0..self.repetitions {
                    if !(self.sets_are_shared && number % 2 == 1) {
                        set = self.of_sets * normal(&mut s);
                    }
                    let sample = self.of_samples * normal(&mut s);
                    // A chi-squared estimate of 20 degrees of freedom, of each half.
                    let mut known = || {
                        let squares: f64 = (0..20).map(|_| normal(&mut s)).map(|z| z * z).sum();
                        0.5 * self.of_samples * self.of_samples * squares / 20.0
                    };
                    let within = [known(), known()];
                    replicates.push(1.0 + set + sample, within, 0.0);
                }
                let interval = replicates.interval(0.95);
                u64::from((replicates.mean() - 1.0).abs() <= interval.half_width)
            };
            (0..4000).map(trial).sum()
        }

        fn interval(&self) -> crate::stats::Interval {
            clopper_pearson(self.kept(), 4000, 0.999)
        }
    }

    const SETS: Model = Model { of_sets: 0.1, of_samples: 0.01, repetitions: 8, sets_are_shared: false };

    #[test]
    fn intervals_hold_whichever_noise_is_the_larger() {
        for (of_sets, of_samples) in [(0.1, 0.0), (0.1, 0.03), (0.1, 0.1), (0.03, 0.1), (0.0, 0.1)] {
            for repetitions in [8, 27] {
                let interval = Model { of_sets, of_samples, repetitions, ..SETS }.interval();
                // The lower end is what is promised; the upper keeps it from being empty talk.
                let case = (of_sets, of_samples, repetitions, interval);
                assert!(interval.high > 0.94 && interval.low < 0.98, "{case:?}");
            }
        }
    }

    #[test]
    fn sets_that_are_not_independent_are_noticed() {
        let interval = Model { sets_are_shared: true, ..SETS }.interval();
        assert!(interval.high < 0.92, "two repetitions with one set are not two sets: {interval:?}");
    }

    #[test]
    fn parts_are_told_apart() {
        let mut replicates = Replicates::<2>::default();
        for value in [1.0, 3.0, 5.0, 7.0] {
            replicates.push(value, [1.0, 2.0], 0.0);
        }
        // s² = 20/3, of which 3 are known.
        let interval = replicates.interval(0.95);
        let excess = 20.0 / 3.0 - 3.0;
        let t = student_t_two_sided(0.95, 3.0 * (20.0 / 3.0 / excess) * (20.0 / 3.0 / excess));
        let expected = [1.0, 2.0, excess].map(|variance: f64| t * (variance / 4.0).sqrt());
        let found = [interval.within[0], interval.within[1], interval.excess];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?} {expected:?}");
        assert!((interval.half_width - t * (5.0_f64 / 3.0).sqrt()).abs() < 1e-12);
        assert!((interval.standard_error - (5.0_f64 / 3.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn what_is_known_within_is_never_forgotten() {
        let mut replicates = Replicates::<2>::default();
        // As it happens, all values are equal.
        (0..8).for_each(|_| replicates.push(2.0, [0.5, 1.5], 0.1));
        let interval = replicates.interval(0.95);
        let rare = KAPPA * 0.1 / 8.0 * ln_f64(2.0 / 0.05);
        assert!((interval.half_width - (1.959_964 * 0.5 + rare)).abs() < 1e-4, "{interval:?}");
        assert_eq!(Replicates::<2>::default().interval(0.95).half_width, f64::INFINITY);
    }
}
