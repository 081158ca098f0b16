//! Statements on all pixels of a picture, from pixels drawn at random.
//!
//! `n` pixels of a picture are drawn at random and audited; `k` of them are outside of the claim.
//! The only assumption is that the draw is independent of the errors. The method of rendering and
//! the distribution of the errors are arbitrary.
//!
//! ```text
//! share outside ≤ U/(1 − γ)      U: P(X ≤ k | n, U) = δ                       (Clopper, Pearson 1934)
//! ratios below the m-th smallest of n: at least the share s of all, where P(Y ≥ m | n, s) ≤ δ (Wilks 1941)
//! ```
//!
//! with `X` and `Y` binomial and `δ` the risk. `γ` is the probability that a pixel outside of the
//! claim is counted as inside, since its reference value is known only to within an interval.
//!
//! # Guarantee
//! If all pixels of a picture are audited, there is no error of sampling. Only the intervals of the
//! reference values may miss: [`upper_share_outside_of_all`], [`rank_of_all`].
//!
//! Each statement is wrong with probability at most `δ`; several interim analyses of one set of
//! pixels share the risk evenly (Bonferroni). Both are conservative if pixels are drawn without
//! repetition from few pixels (Hoeffding 1963).
//!
//! # Held to this by
//! The tests below: published tables, and pictures of known errors at the edge of the claim.

use super::clopper_pearson;

/// Upper bound on the share of a picture's pixels that are outside of the claim, if `outside` of
/// `audited` drawn pixels are.
///
/// * `risk`: the probability of being wrong, in (0, ½).
/// * `missed`: the probability `γ` that a pixel outside of the claim is counted as inside, in [0,
///   1).
///
/// # Panics
/// If `outside` exceeds `audited`.
///
/// # Example
/// ```
/// use tashika_stats::upper_share_outside;
///
/// assert!(upper_share_outside(0, 59, 0.05, 0.0) < 0.05);
/// assert!(upper_share_outside(1, 59, 0.05, 0.0) > 0.05);
/// ```
pub fn upper_share_outside(outside: u64, audited: u64, risk: f64, missed: f64) -> f64 {
    // The two-sided interval with twice the risk has the given risk in each tail.
    let upper = clopper_pearson(outside, audited, 1.0 - 2.0 * risk).high;
    (upper / (1.0 - missed)).min(1.0)
}

/// Upper bound on the share of a picture's pixels that are outside of the claim, if all `audited`
/// pixels of the picture are audited and `outside` of them are found outside. It is the largest
/// share `K/n` with
///
/// ```text
/// P(X ≤ k | K, 1 − γ) > δ      X binomial: the pixels outside that are found outside
/// ```
///
/// * `risk`, `missed`: as for [`upper_share_outside`].
///
/// # Panics
/// If `outside` exceeds `audited`.
///
/// # Example
/// ```
/// use tashika_stats::upper_share_outside_of_all;
///
/// // Three pixels are all missed with probability 0.05³ = 0.000125.
/// assert_eq!(upper_share_outside_of_all(0, 100, 0.001, 0.05), 0.02);
/// ```
pub fn upper_share_outside_of_all(outside: u64, audited: u64, risk: f64, missed: f64) -> f64 {
    assert!(outside <= audited, "{outside} of {audited}");
    // At least `all − outside` of `all` intervals miss with a probability that is the lower tail of
    // the found ones: the interval of twice the risk ends above the share that is found.
    let is_possible = |all: u64| clopper_pearson(outside, all, 1.0 - 2.0 * risk).high > 1.0 - missed;
    last_true(outside, audited, is_possible) as f64 / audited.max(1) as f64
}

/// Returns the last number from `first` to `last` for which the predicate is true. It is true for
/// `first`, and true up to that number.
fn last_true(first: u64, last: u64, is_true: impl Fn(u64) -> bool) -> u64 {
    let (mut below, mut above) = (first, last + 1);
    while above - below > 1 {
        let middle = below + (above - below) / 2;
        if is_true(middle) { below = middle } else { above = middle }
    }
    below
}

/// Rank, counted from 1, of a number among all `n` numbers of a picture: at least the share `share`
/// of the true numbers is at most as large as the number of this rank. It is `n − k` for the
/// largest `k` with [`upper_share_outside_of_all`] at most `1 − share`. If the statement were
/// false, at most `k` numbers would be found above with a probability of at most the risk. `None`
/// if there is no such `k`.
///
/// * `risk`, `missed`: as for [`upper_share_outside`], where a number is outside if it is above the
///   returned one.
///
/// # Example
/// ```
/// // If two of 100 are found above a number, at most five are above it.
/// assert_eq!(tashika_stats::rank_of_all(100, 0.95, 0.001, 0.05), Some(98));
/// ```
pub fn rank_of_all(n: u64, share: f64, risk: f64, missed: f64) -> Option<u64> {
    let is_within = |k: u64| upper_share_outside_of_all(k, n, risk, missed) <= 1.0 - share;
    (n > 0 && is_within(0)).then(|| n - last_true(0, n - 1, is_within))
}

/// Rank `m`, counted from 1, in a random sample of `n` numbers: at least the share `share` of all
/// numbers is at most as large as the `m`-th smallest of the sample. `None` if `n` is too small.
///
/// * `risk`: the probability of being wrong, in (0, ½).
///
/// # Example
/// ```
/// assert_eq!(tashika_stats::tolerance_rank(300, 0.95, 0.05), Some(292));
/// ```
pub fn tolerance_rank(n: u64, share: f64, risk: f64) -> Option<u64> {
    // The m-th smallest number is below the quantile of `share` if at least m of the n numbers are.
    // The probability of this falls with m. It is at most `risk` if the lower end of the
    // Clopper–Pearson interval for m of n is at least `share`.
    let is_above = |m: u64| clopper_pearson(m, n, 1.0 - 2.0 * risk).low >= share;
    if n == 0 || !is_above(n) {
        return None;
    }
    Some(n - last_true(0, n - 1, |fewer| is_above(n - fewer)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    /// For a number of outside pixels, the smallest number of audited pixels that certifies 95 % is
    /// that of published tables of binomial sampling.
    #[test]
    fn numbers_of_pixels_are_those_of_the_tables() {
        let tables = [
            (0.05, [(0, 59), (1, 93), (3, 153), (5, 208), (10, 336)]),
            (0.01, [(0, 90), (1, 130), (3, 198), (5, 259), (10, 398)]),
        ];
        for (risk, rows) in tables {
            for (outside, audited) in rows {
                assert!(upper_share_outside(outside, audited, risk, 0.0) <= 0.05, "{outside} of {audited}");
                assert!(upper_share_outside(outside, audited - 1, risk, 0.0) > 0.05, "{outside} {audited}");
            }
        }
    }

    #[test]
    fn intervals_that_miss_are_reckoned_with() {
        let [sure, unsure] = [0.0, 0.2].map(|missed| upper_share_outside(3, 153, 0.05, missed));
        assert!((unsure - sure / 0.8).abs() < 1e-12);
        assert_eq!(upper_share_outside(153, 153, 0.05, 0.2), 1.0);
    }

    /// Bounds by sums of binomial terms, where every pixel is audited.
    #[test]
    fn bounds_of_a_picture_that_is_audited_as_a_whole_are_binomial() {
        let tail = |found: u64, all: u64, missed: f64| -> f64 {
            let choose = |k: u64| (0..k).map(|i| (all - i) as f64 / (i + 1) as f64).product::<f64>();
            let term = |k: u64| choose(k) * (1.0 - missed).powi(k as i32) * missed.powi((all - k) as i32);
            (0..=found).map(term).sum()
        };
        for (found, risk, missed) in [(0, 0.001, 0.05), (3, 0.01, 0.05), (7, 0.005, 0.2), (20, 0.05, 0.5)] {
            let most = (found..=100).take_while(|all| tail(found, *all, missed) > risk).last().unwrap();
            let bound = upper_share_outside_of_all(found, 100, risk, missed);
            assert_eq!(bound, most as f64 / 100.0, "{found} {risk} {missed}");
            assert!(bound < upper_share_outside(found, 100, risk, missed));
        }
        assert_eq!(upper_share_outside_of_all(100, 100, 0.01, 0.05), 1.0);
        assert_eq!(upper_share_outside_of_all(2, 100, 0.01, 0.0), 0.02, "no interval misses");
    }

    /// A picture in which just too few true numbers are at most 1, and intervals that miss as often
    /// as they may. A number of the returned rank of at most 1 would be a false statement.
    #[test]
    fn ranks_among_all_numbers_are_wrong_no_more_often_than_the_risk() {
        const PICTURES: u64 = 20_000;
        let (n, share, risk, missed) = (300u64, 0.9, 0.05, 0.05);
        let rank = rank_of_all(n, share, risk, missed).unwrap();
        let above = (n as f64 * (1.0 - share)) as u64 + 1;
        let is_wrong = |rank: u64| {
            let count = (0..PICTURES).filter(|picture| {
                let mut s = Stream::new(3, Purpose::Test, *picture);
                let found_above = (0..above).filter(|_| f64::from(s.uniform()) >= missed).count() as u64;
                n - found_above >= rank
            });
            count.count() as f64 / PICTURES as f64
        };
        // Three standard errors of the count.
        assert!(is_wrong(rank) < risk + 0.0047, "{}", is_wrong(rank));
        assert!(is_wrong(rank - 1) > risk, "{}", is_wrong(rank - 1));
        assert_eq!(rank_of_all(10, 0.95, 0.001, 0.05), None, "two of ten may be missed");
    }

    #[test]
    fn ranks_are_those_of_wilks() {
        let ranks = [(58, None), (59, Some(59)), (300, Some(292)), (500, Some(484)), (1000, Some(962))];
        for (n, rank) in ranks {
            assert_eq!(tolerance_rank(n, 0.95, 0.05), rank, "{n}");
        }
        assert_eq!(tolerance_rank(0, 0.95, 0.05), None);
    }

    /// In each picture, the share of outside pixels is just above the claimed share. The share of
    /// pictures that are certified all the same is at most the risk.
    #[test]
    fn pictures_at_the_edge_are_certified_no_more_often_than_the_risk() {
        const PICTURES: u64 = 10_000;
        let (share, risk, audited) = (0.95, 0.05, 153);
        let mut certified = [0u64; 2];
        for picture in 0..PICTURES {
            let mut s = Stream::new(1, Purpose::Test, picture);
            let outside = (0..audited).filter(|_| s.uniform() > 0.95).count() as u64;
            for (looks, certified) in [1, 3].into_iter().zip(&mut certified) {
                let upper = upper_share_outside(outside, audited, risk / f64::from(looks), 0.0);
                *certified += u64::from(upper <= 1.0 - share);
            }
        }
        let rate = certified.map(|n| n as f64 / PICTURES as f64);
        // The exact risk for this number of pixels is 4.97 %; the limits add three standard errors
        // of the count.
        assert!(rate[0] < risk + 0.0066 && rate[0] > 0.03, "{rate:?}");
        assert!(rate[1] < risk / 3.0 + 0.004, "{rate:?}");
    }

    /// The ratio at the returned rank fails to cover the share of all ratios at most as often as
    /// the risk. The ratio two ranks lower fails more often.
    #[test]
    fn ranks_cover_the_share_as_often_as_they_say() {
        const PICTURES: u64 = 10_000;
        let (n, share, risk) = (300u64, 0.95f64, 0.05);
        let rank = tolerance_rank(n, share, risk).unwrap();
        let covers = |rank: u64| {
            let count = (0..PICTURES).filter(|picture| {
                let mut s = Stream::new(2, Purpose::Test, *picture);
                let below = (0..n).filter(|_| f64::from(s.uniform()) < share).count() as u64;
                below < rank
            });
            count.count() as f64 / PICTURES as f64
        };
        assert!(covers(rank) > 1.0 - risk - 0.0066, "{}", covers(rank));
        assert!(covers(rank - 2) < 1.0 - risk, "{}", covers(rank - 2));
    }
}
