//! Intervals and certificates for strata whose mean is known, in many runs; and deliberate mistakes
//! that these tests must detect.

use super::*;
use crate::rng::{Purpose, Stream};

/// Stratum of skewed values, like light that is mostly in shadow: a value is `upper` with
/// probability `share`, else zero.
#[derive(Clone, Copy, Debug)]
struct Skewed {
    upper: f64,
    share: f64,
    samples: u32,
}

impl Skewed {
    fn mean(&self) -> f64 {
        self.upper * self.share
    }

    /// Variance of the stratum's mean.
    fn variance(&self) -> f64 {
        self.upper * self.upper * self.share * (1.0 - self.share) / f64::from(self.samples)
    }

    /// Draws values and returns their mean and the summary of the stratum. The stated bound is the
    /// true one times `told`.
    fn draw(&self, told: f64, s: &mut Stream) -> (f64, Stratum) {
        let lit = (0..self.samples).filter(|_| s.uniform_f64() < self.share).count() as f64;
        let n = f64::from(self.samples);
        let share = lit / n;
        let variance = self.upper * self.upper * share * (1.0 - share) * n / (n - 1.0);
        let upper = self.upper * told;
        (
            self.upper * share,
            Stratum {
                samples: self.samples,
                upper,
                importance_range: upper,
                variance,
                importance_variance: 0.0,
            },
        )
    }
}

fn same(upper: f64, share: f64, samples: u32, count: usize) -> Vec<Skewed> {
    vec![Skewed { upper, share, samples }; count]
}

/// Fraction of `runs` in which `fails(mean, spread)` is true.
fn share(strata: &[Skewed], told: f64, runs: u32, fails: impl Fn(f64, &Spread) -> bool) -> f64 {
    let mut s = Stream::new(3, Purpose::Test, 0);
    let mut all = Vec::new();
    let failed = (0..runs).filter(|_| {
        let mut mean = 0.0;
        all.clear();
        for stratum in strata {
            let (of_stratum, said) = stratum.draw(told, &mut s);
            mean += of_stratum;
            all.push(said);
        }
        fails(mean, &Spread::of(all.iter().copied()))
    });
    failed.count() as f64 / f64::from(runs)
}

/// Share of `runs` in which the interval does not contain the true sum.
fn missed(strata: &[Skewed], runs: u32, half_width: impl Fn(&Spread) -> f64) -> f64 {
    let truth: f64 = strata.iter().map(Skewed::mean).sum();
    share(strata, 1.0, runs, |mean, spread| (mean - truth).abs() > half_width(spread))
}

/// Many small strata and one large one that is rarely lit.
fn one_rarely_lit() -> Vec<Skewed> {
    let large = Skewed { upper: 5.0, share: 0.05, samples: 2 };
    std::iter::once(large).chain(same(0.1, 0.5, 2, 100)).collect()
}

#[test]
fn certificates_hold() {
    let cases = [
        same(1.0, 0.5, 2, 30),
        same(1.0, 0.02, 2, 30),
        same(1.0, 0.02, 2, 300),
        same(1.0, 0.5, 3, 1),
        (0..40).map(|k| Skewed { upper: 1.0 / f64::from(k + 1), share: 0.3, samples: 2 + k % 3 }).collect(),
        one_rarely_lit(),
    ];
    for (number, strata) in cases.iter().enumerate() {
        for delta in [0.3, 0.05] {
            let missed = missed(strata, 100_000, |spread| spread.certified(delta));
            assert!(missed <= delta, "case {number}, {delta}: {missed}");
        }
    }
}

/// Strata whose share of lit values is chosen so that the variance is `units` times `m ln(1/δ)`. If
/// all samples are zero, the bound `U` is 1 in this unit.
fn hardly_lit(units: f64, delta: f64) -> Vec<Skewed> {
    let count = 400;
    // V = count · share (1 − share)/2, m = 1/4.
    let product = units * 0.5 * ln_f64(1.0 / delta) / f64::from(count);
    let share = 0.5 - (0.25 - product).sqrt();
    same(1.0, share, 2, count as usize)
}

/// Share of runs in which the variance is above its bound.
fn variance_missed(units: f64, delta: f64, told: f64) -> f64 {
    let strata = hardly_lit(units, delta);
    let truth: f64 = strata.iter().map(Skewed::variance).sum();
    share(&strata, told, 30_000, |_, spread| spread.upper_variance(delta) < truth)
}

/// For some strata the bound of the variance fails nearly as often as it may. Therefore stated
/// bounds of samples that are 10 % too small make it fail too often, and are detected. 30,000 runs
/// have a standard error of 0.0013 around 0.05.
#[test]
fn the_bound_of_the_variance_holds_and_just_so() {
    let delta = 0.05;
    for units in [0.2, 0.7, 0.85, 0.98, 1.02, 1.2, 2.0, 5.0] {
        let missed = variance_missed(units, delta, 1.0);
        assert!(missed <= delta + 0.005, "{units}: {missed}");
    }
    assert!(variance_missed(1.02, delta, 1.0) > 0.7 * delta);
    let planted = variance_missed(0.85, delta, 0.9);
    assert!(planted > 1.3 * delta, "bounds that are 10 % too small go unnoticed: {planted}");
}

/// Probability that at least one of `looks` analyses fails. Each uses new samples, and its bound
/// allows a failure with probability `delta`.
fn any_look_fails(looks: u32, delta: f64) -> f64 {
    1.0 - (1.0 - variance_missed(1.02 / ln_f64(1.0 / 0.05) * ln_f64(1.0 / delta), delta, 1.0))
        .powi(looks as i32)
}

#[test]
fn looks_have_to_be_counted() {
    assert!(any_look_fails(8, 0.05 / 8.0) <= 0.05);
    assert!(any_look_fails(8, 0.05) > 0.2, "looks that are not counted go unnoticed");
}

#[test]
fn variances_are_bounded_by_more_than_they_are_estimated_at() {
    for (variance, upper) in [(0.0, 1.0), (1e-6, 1.0), (1.0, 1.0), (1.0, 1e-6), (1e6, 1.0), (1.0, 1e-200)] {
        let said = Stratum { samples: 2, upper, importance_range: upper, variance, importance_variance: 0.0 };
        let spread = Spread::of([said]);
        let target = 0.25 * upper * upper * ln_f64(20.0);
        let bound = spread.upper_variance(0.05);
        assert!(bound >= spread.variance && bound >= target, "{variance} {upper}: {bound}");
        if spread.variance > 0.0 && bound > spread.variance * (1.0 + 1e-6) {
            let left = bound - spread.variance - spread.variance * ln_f64(bound / spread.variance);
            assert!((left / target - 1.0).abs() < 1e-6, "{variance} {upper}: {left} {target}");
        }
    }
}

/// Light that is rarely sampled: the plain interval of Student misses the true sum in over 30 % of
/// the runs. The certificate, which allows for values that no sample has met, does not.
#[test]
fn rare_light_is_what_intervals_miss() {
    let rare = same(1.0, 0.01, 2, 30);
    let plain = |spread: &Spread| student_t_two_sided(0.95, 30.0) * spread.variance.sqrt();
    assert!(missed(&rare, 4000, plain) > 0.3);
    assert_eq!(missed(&rare, 4000, |spread| spread.certified(0.05)), 0.0);
}

/// In nine of ten runs no sample of the large stratum is lit. The interval still misses in at most
/// 5 % of the runs, owing to its term for rare, large values.
#[test]
fn calibrated_intervals_know_of_what_is_rare_and_bright() {
    let missed = missed(&one_rarely_lit(), 20_000, |spread| spread.calibrated(0.95));
    assert!(missed <= 0.05, "{missed}");
}

/// Hundreds of strata, each with a small chance of light that no sample has met. The term for the
/// largest stratum does not grow with their number, so the interval needs the expected variance.
#[test]
fn calibrated_intervals_know_of_many_strata_in_shadow() {
    let visibility: f64 = 0.02;
    let dark = Stratum {
        samples: 2,
        upper: 1.0,
        importance_range: visibility.sqrt(),
        variance: 0.0,
        importance_variance: visibility * (1.0 - visibility),
    };
    let width = |count: usize| Spread::of(vec![dark; count]).calibrated(0.95);
    // For many strata, the width grows with the square root of their number.
    assert!(width(40_000) > 1.8 * width(10_000) && width(10_000) > 2.0 * width(1));
}

/// With many strata of comparable size the certificate is within a small factor of the normal
/// interval.
#[test]
fn certificates_are_tight_where_strata_are_many() {
    let strata = vec![
        Stratum {
            samples: 2,
            upper: 1.0,
            importance_range: 1.0,
            variance: 0.1,
            importance_variance: 0.0
        };
        100_000
    ];
    let spread = Spread::of(strata);
    let normal = student_t_two_sided(0.95, 1e6) * spread.variance.sqrt();
    let ratio = spread.certified(0.05) / normal;
    assert!((1.0..2.0).contains(&ratio), "{ratio}");
}

#[test]
fn many_strata_of_one_kind_have_the_calibrated_coverage() {
    for confidence in [0.5, 0.8, 0.95] {
        let missed = missed(&same(1.0, 0.5, 2, 300), 20_000, |spread| spread.calibrated(confidence));
        // The interval may only be too wide, by the term for rare values. The limit adds five
        // standard errors.
        let allowed = 1.0 - confidence + 5.0 * (confidence * (1.0 - confidence) / 20_000.0_f64).sqrt();
        assert!(missed <= allowed && missed > 0.5 * (1.0 - confidence), "{confidence}: {missed}");
    }
}

/// A row of terms, a tenth of them lit, in runs of neighbours. 40 times, one part of the row is
/// halved, as in the refinement of a cut; each part has two samples. The part to be halved is
/// chosen by its size, or by the variance of its own samples.
fn halved(s: &mut Stream, by_own_samples: bool) -> (f64, Spread) {
    const TERMS: usize = 4096;
    let lit = |term: usize| if (term / 37) % 10 == 3 { 1.0 } else { 0.0 };
    let draw = |(from, to): (usize, usize), s: &mut Stream| from + s.below((to - from) as u64) as usize;
    let said = |part: &((usize, usize), Vec<usize>)| {
        let ((from, to), samples) = part;
        let (upper, n) = ((to - from) as f64, samples.len() as f64);
        let mean = samples.iter().map(|&t| lit(t) * upper).sum::<f64>() / n;
        let variance = samples.iter().map(|&t| (lit(t) * upper - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (
            mean,
            Stratum {
                samples: samples.len() as u32,
                upper,
                importance_range: 0.0,
                variance,
                importance_variance: 0.0,
            },
        )
    };
    let all = (0, TERMS);
    let mut parts = vec![(all, vec![draw(all, s), draw(all, s)])];
    for _ in 0..40 {
        let rank = |part: &((usize, usize), Vec<usize>)| {
            let (from, to) = part.0;
            if to - from < 4 {
                -1.0
            } else if by_own_samples {
                said(part).1.variance
            } else {
                (to - from) as f64
            }
        };
        let most = (0..parts.len()).max_by(|a, b| rank(&parts[*a]).total_cmp(&rank(&parts[*b]))).unwrap();
        let ((from, to), samples) = parts.swap_remove(most);
        let middle = from.midpoint(to);
        for half in [(from, middle), (middle, to)] {
            let mut kept: Vec<usize> =
                samples.iter().copied().filter(|t| (half.0..half.1).contains(t)).collect();
            while kept.len() < 2 {
                kept.push(draw(half, s));
            }
            parts.push((half, kept));
        }
    }
    let told: Vec<(f64, Stratum)> = parts.iter().map(said).collect();
    let truth: f64 = (0..TERMS).map(lit).sum();
    (told.iter().map(|(mean, _)| mean).sum::<f64>() / truth, Spread::of(told.iter().map(|(_, of)| *of)))
}

/// A mistake that is easily made if parts inherit samples: if splits are chosen by the samples that
/// also give the estimate, parts whose samples differ are split until the variance vanishes, and
/// parts whose samples are alike are never split. The test detects it.
#[test]
fn refining_by_ones_own_samples_is_noticed() {
    let runs = 4000;
    let within_two_sigma = |by_own_samples: bool| {
        let mut s = Stream::new(11, Purpose::Test, 2);
        let truth = (0..4096).filter(|term| (term / 37) % 10 == 3).count() as f64;
        let held = (0..runs).filter(|_| {
            let (ratio, spread) = halved(&mut s, by_own_samples);
            (ratio - 1.0).abs() * truth <= 2.0 * spread.variance.sqrt()
        });
        held.count() as f64 / f64::from(runs)
    };
    let (by_size, by_samples) = (within_two_sigma(false), within_two_sigma(true));
    assert!(by_size > 0.85 && by_samples < 0.6, "{by_size} by size, {by_samples} by own samples");
}

#[test]
fn freedom_counts_strata() {
    // Equal variances of two samples each: 3 N − 2.
    let spread = Spread::of(vec![
        Stratum {
            samples: 2,
            upper: 1.0,
            importance_range: 1.0,
            variance: 0.2,
            importance_variance: 0.0
        };
        40
    ]);
    assert!((spread.freedom() - 118.0).abs() < 1e-9);
    assert_eq!(Spread::of([]).freedom(), 1.0);
}
