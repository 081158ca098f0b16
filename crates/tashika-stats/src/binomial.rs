//! The exact interval of a probability, from the successes of independent trials.
//!
//! Let `k` of `n` trials succeed. The interval of Clopper and Pearson contains every `p` for which
//! both tails, `P(X ≥ k)` and `P(X ≤ k)`, are at least `(1 − confidence)/2`. Its ends are
//!
//! ```text
//! low:  P(X ≥ k | p = low)  = (1 − confidence)/2     0 if k = 0
//! high: P(X ≤ k | p = high) = (1 − confidence)/2     1 if k = n        X binomial of n trials
//! ```
//!
//! (Clopper, Pearson 1934). `P(X ≥ k)` is the regularised incomplete beta function
//! `I_p(k, n − k + 1)`. Its parameters are integers, so it is summed here as a tail of positive
//! terms. The sum begins with the term nearest the mean. This term is computed by Stirling's
//! series, with the error terms split off so that large `n` cancels (Loader 2000). Each further
//! term is computed from its neighbour.
//!
//! # Guarantee
//! The interval covers the true probability with at least the given confidence, whatever the
//! probability, if trials are independent and equally probable. Its ends have a relative error of
//! at most 10⁻⁹ for up to 10⁸ trials.
//!
//! # Held to this by
//! The tests below, against closed forms, a published table and an independent incomplete beta
//! function.

use crate::math::elementary::{exp_f64, ln_f64};

/// An interval that holds a probability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// The Clopper–Pearson interval of a probability, from `successes` of `trials`; `[0, 1]` without
/// trials.
///
/// * `confidence` in `(0, 1)`.
///
/// # Panics
/// If there are more successes than trials.
pub fn clopper_pearson(successes: u64, trials: u64, confidence: f64) -> Interval {
    assert!(successes <= trials, "{successes} successes in {trials} trials");
    debug_assert!(confidence > 0.0 && confidence < 1.0);
    let tail = 0.5 * (1.0 - confidence);
    Interval {
        low: lower_end(successes, trials, tail),
        // The upper end is 1 minus the lower end for the failures.
        high: 1.0 - lower_end(trials - successes, trials, tail),
    }
}

/// The largest `p` with `P(X ≥ k) ≤ tail`, from below.
fn lower_end(k: u64, n: u64, tail: f64) -> f64 {
    if k == 0 {
        return 0.0;
    }
    // At p = k/n the tail is about one half; only a confidence of one half or less may need a
    // larger p.
    let (mut low, mut high) = (0.0, if tail < 0.25 { k as f64 / n as f64 } else { 1.0 });
    // Halves the interval until there is no number between its ends: about 64 steps, and one for
    // each leading zero of `low`.
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return low;
        }
        if upper_tail(k, n, middle) <= tail {
            low = middle;
        } else {
            high = middle;
        }
    }
}

/// `P(X ≥ k)` for `0 < k ≤ n` and `0 < p < 1`.
fn upper_tail(k: u64, n: u64, p: f64) -> f64 {
    let (n_f, odds) = (n as f64, p / (1.0 - p));
    if k as f64 > n_f * p {
        // P(X = j+1) = P(X = j) · (n − j)/(j + 1) · p/(1 − p)
        let ratio = |j: u64| (n - j) as f64 / (j + 1) as f64 * odds;
        probability(k, n, p) * sum_of_products((k..n).map(ratio))
    } else {
        let ratio = |j: u64| j as f64 / (n - j + 1) as f64 / odds;
        1.0 - probability(k - 1, n, p) * sum_of_products((1..k).rev().map(ratio))
    }
}

/// `1 + r₁ + r₁r₂ + r₁r₂r₃ + …` to rounding. The ratios must be below 1 and fall.
fn sum_of_products(ratios: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut term) = (1.0, 1.0);
    for ratio in ratios {
        term *= ratio;
        sum += term;
        // The sum of all further terms is at most a geometric series of this ratio.
        if term < 1e-17 * sum * (1.0 - ratio) {
            break;
        }
    }
    sum
}

/// `P(X = k)` for `0 < p < 1`.
fn probability(k: u64, n: u64, p: f64) -> f64 {
    let (k_f, n_f, rest) = (k as f64, n as f64, (n - k) as f64);
    if k == 0 {
        return exp_f64(n_f * ln_f64(1.0 - p));
    }
    if k == n {
        return exp_f64(n_f * ln_f64(p));
    }
    let stirling = stirling_error(n) - stirling_error(k) - stirling_error(n - k);
    let deviance = k_f * ln_f64(k_f / (n_f * p)) + rest * ln_f64(rest / (n_f * (1.0 - p)));
    exp_f64(stirling - deviance) * (n_f / (std::f64::consts::TAU * k_f * rest)).sqrt()
}

/// `ln n! − ln(√(2πn) (n/e)ⁿ)` for `n > 0`.
fn stirling_error(n: u64) -> f64 {
    let n_f = n as f64;
    if n < 16 {
        let factorial: f64 = (2..=n).map(|i| i as f64).product();
        return ln_f64(factorial) - (0.5 * ln_f64(std::f64::consts::TAU * n_f) + n_f * ln_f64(n_f) - n_f);
    }
    // The next term of the series is below 10⁻¹³ from 16 on.
    let square = n_f * n_f;
    (1.0 / 12.0
        - (1.0 / 360.0 - (1.0 / 1260.0 - (1.0 / 1680.0 - 1.0 / 1188.0 / square) / square) / square) / square)
        / n_f
}

#[cfg(test)]
mod tests {
    use statrs::function::beta::beta_reg;

    use super::*;

    #[test]
    fn the_ends_have_closed_forms_where_all_or_none_succeeded() {
        for n in [1_u64, 2, 10, 400, 100_000] {
            let none = clopper_pearson(0, n, 0.95);
            // (1 − high)ⁿ = 0.025
            let high = -f64::exp_m1(f64::ln(0.025) / n as f64);
            assert_eq!(none.low, 0.0);
            assert!((none.high / high - 1.0).abs() < 1e-9, "{n}: {none:?}");
            let all = clopper_pearson(n, n, 0.95);
            assert_eq!(all.high, 1.0);
            assert!((all.low - (1.0 - high)).abs() < 1e-12, "{n}: {all:?}");
        }
        assert_eq!(clopper_pearson(0, 0, 0.95), Interval { low: 0.0, high: 1.0 });
    }

    #[test]
    fn small_cases_agree_with_published_tables() {
        // Tables of exact binomial limits at 95 %, as in Clopper, Pearson 1934, to four digits.
        for (k, n, low, high) in [
            (1, 10, 0.0025, 0.4450),
            (5, 10, 0.1871, 0.8129),
            (9, 10, 0.5550, 0.9975),
            (3, 20, 0.0321, 0.3789),
        ] {
            let i = clopper_pearson(k, n, 0.95);
            assert!((i.low - low).abs() < 5e-5 && (i.high - high).abs() < 5e-5, "{k} of {n}: {i:?}");
        }
    }

    #[test]
    fn the_incomplete_beta_function_at_the_ends_is_the_tail() {
        for n in [2_u64, 7, 15, 16, 33, 200, 5_000] {
            for share in [0.0001, 0.03, 0.3, 0.5, 0.87, 0.95, 0.999] {
                let k = ((n as f64 * share) as u64).clamp(1, n - 1);
                for confidence in [0.3, 0.8, 0.95, 0.9999] {
                    let i = clopper_pearson(k, n, confidence);
                    let tail = 0.5 * (1.0 - confidence);
                    let (a, b) = (k as f64, (n - k) as f64);
                    let below = beta_reg(a, b + 1.0, i.low);
                    let above = beta_reg(b, a + 1.0, 1.0 - i.high);
                    let wrong = (below / tail - 1.0).abs().max((above / tail - 1.0).abs());
                    assert!(wrong < 1e-9, "{k} of {n} at {confidence}: {i:?} leaves {below}, {above}");
                }
            }
        }
    }

    #[test]
    fn tails_are_those_of_enumeration() {
        // n = 5, p = 1/4: numerators of C(5,j) 3^(5−j) over 4⁵.
        let counts = [243.0, 405.0, 270.0, 90.0, 15.0, 1.0];
        for k in 1..=5_u64 {
            let tail: f64 = counts[k as usize..].iter().sum::<f64>() / 1024.0;
            assert!((upper_tail(k, 5, 0.25) / tail - 1.0).abs() < 1e-13, "{k}");
            // The number of successes at p = 3/4 is distributed like the number of failures at p =
            // 1/4.
            let tail: f64 = counts[..=5 - k as usize].iter().sum::<f64>() / 1024.0;
            assert!((upper_tail(k, 5, 0.75) / tail - 1.0).abs() < 1e-13, "{k}");
        }
    }

    #[test]
    fn tails_of_many_trials_keep_their_digits() {
        // Reference value, summed with 40 digits. (`upper_tail` loses six of its sixteen digits
        // here.)
        let exact = 0.350_000_000_006_632_9;
        assert!((upper_tail(300_000, 1_000_000, 0.299_823_010_569_483_7) / exact - 1.0).abs() < 1e-9);
    }

    #[test]
    fn no_count_of_trials_takes_long() {
        let i = clopper_pearson(95_000_000, 100_000_000, 0.95);
        let normal = 1.959_964 * f64::sqrt(0.95 * 0.05 / 1e8);
        assert!((i.low - (0.95 - normal)).abs() < 0.01 * normal, "{i:?}");
        assert!((i.high - (0.95 + normal)).abs() < 0.01 * normal, "{i:?}");
    }
}
