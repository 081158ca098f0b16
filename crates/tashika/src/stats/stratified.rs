//! How wrong a stratified mean can be: intervals that are calibrated, and certificates that are proven.
//!
//! A sum `L = Σ_k L_k` is estimated by `L̂ = Σ_k ȳ_k` from `n_k ≥ 2` independent samples of each stratum, with values in `[0, R_k]`,
//! means `L_k` and variances `σ_k²`. Let
//!
//! ```text
//! V = Σ σ_k²/n_k     V̂ = Σ s_k²/n_k     b = max R_k/n_k     m = max R_k² / (4 (n_k − 1))     B = Σ R_k²/n_k
//! ```
//!
//! # The certificate
//! With probability at least `1 − δ`, `|L̂ − L|` is at most the smaller of
//!
//! ```text
//! H₁ = √(½ B ln(2/δ₁))
//! H₂ = √(2 U ln(2/δ₂)) + (b/3) ln(2/δ₂)          √U = a/2 + √(a²/4 + V̂)     a = √(2 m ln(1/δ₃))
//! ```
//!
//! with `δ = δ₁ + δ₂ + δ₃`. No asymptotics, and no assumption on the values but that they are in `[0, R_k]`.
//!
//! **Proof.** *H₁* fails with probability at most `δ₁`: `L̂` is a sum of independent variables `y/n_k` with ranges `R_k/n_k`, whose squares sum to `B`;
//! Hoeffding 1963, theorem 2, on both sides.
//!
//! *U.* `X_k = s_k²/n_k` are independent and not negative, with means `σ_k²/n_k`. For `n` values in `[0, R]`, `s² ≤ R² n/(4(n − 1))`; so
//! `E X_k² ≤ max(X_k) E X_k ≤ R_k²/(4(n_k − 1)) · σ_k²/n_k`, hence `Σ E X_k² ≤ m V`. For such variables
//! `P(Σ E X − Σ X ≥ τ) ≤ exp(−τ²/(2 Σ E X²))` (Maurer 2003, theorem 1). With `τ = a √V` this is `P(V − a√V ≥ V̂) ≤ δ₃`, and where
//! `V − a√V < V̂`, `√V < a/2 + √(a²/4 + V̂) = √U`.
//!
//! *H₂.* The variables `(y − L_k)/n_k` are independent, have mean zero, are at most `b` in size, and their variances sum to `V`. Bernstein's
//! inequality, solved for the deviation and relaxed by `√(x + y) ≤ √x + √y`, gives `|L̂ − L| ≤ √(2 V ln(2/δ₂)) + (2b/3) ln(2/δ₂)` with the
//! coefficient `2/3`; Bennett's inequality in the form of Boucheron et al. 2013 (theorem 2.10, variables of the sub-gamma kind with scale
//! `b/3`) gives the `1/3` above. It fails with probability at most `δ₂`, and `V ≤ U` fails with at most `δ₃`. ∎
//!
//! # Several looks
//! Whoever looks at the data more than once and stops when satisfied has to pay for every look: [`share_of_look`] gives look `j` the
//! share `6/(π² j²)` of `δ`, and these sum to 1, whatever the number of looks.
//!
//! # The calibrated interval
//!
//! ```text
//! h = t_ν √V̂ + κ b' ln(2/δ)          b' = max R'_k/n_k          ν = (Σ S_k)² / Σ (S_k²/(ν_k + 2)) − 2,   S_k = s_k²/n_k,   ν_k = n_k − 1
//! ```
//!
//! The first term is Student's, with the degrees of freedom of Satterthwaite 1946 corrected for estimated variances (`E S² = σ⁴ (1 + 2/ν_k)` for
//! normal samples). The second is what Bernstein's inequality has for a single rare and large value, with a smaller factor, [`KAPPA`]: samples
//! that are all alike, all in shadow say, are no certainty. `R'` is what a stratum is expected to reach (`importance_range`), at most `R`.
//! The interval is an estimate: measured, not proven.

use super::student_t_two_sided;
use crate::math::elementary::ln_f64;

/// `κ`. The factor in Bernstein's inequality is 1/3; lower values cost fewer rays and promise less. Set by `tashika coverage`; see the record.
pub const KAPPA: f64 = 0.2;

/// Share of `δ` that goes to `H₁`.
const HOEFFDING_SHARE: f64 = 0.05;
/// Share of the rest that goes to the variance.
const VARIANCE_SHARE: f64 = 0.3;

/// What one stratum says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stratum {
    /// Number of samples `n`, at least 2.
    pub samples: u32,
    /// Upper bound `R` of a sample.
    pub upper: f64,
    /// About the largest sample that is to be expected, at most `R`; not proven.
    pub importance_range: f64,
    /// Sample variance `s²`.
    pub variance: f64,
}

/// What all strata say together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// `V̂`.
    pub variance: f64,
    /// `Σ S_k²/(ν_k + 2)`.
    fourth: f64,
    /// `b`.
    largest: f64,
    /// The same of what is expected to be the range.
    importance_largest: f64,
    /// `m`.
    largest_squared: f64,
    /// `B`.
    squares: f64,
}

impl Spread {
    /// Of these strata.
    pub fn of<'a>(strata: impl IntoIterator<Item = &'a Stratum>) -> Self {
        let mut spread = Self::default();
        for &Stratum { samples, upper, importance_range, variance } in strata {
            let n = f64::from(samples);
            let of_mean = variance / n;
            spread.variance += of_mean;
            spread.fourth += of_mean * of_mean / (n + 1.0);
            spread.largest = spread.largest.max(upper / n);
            spread.importance_largest = spread.importance_largest.max(importance_range / n);
            spread.largest_squared = spread.largest_squared.max(upper * upper / (4.0 * (n - 1.0)));
            spread.squares += upper * upper / n;
        }
        spread
    }

    /// Effective degrees of freedom `ν` of `V̂`, at least 1.
    pub fn freedom(&self) -> f64 {
        if self.fourth > 0.0 { (self.variance * self.variance / self.fourth - 2.0).max(1.0) } else { 1.0 }
    }

    /// Half-width `h` of the calibrated interval of this confidence, in (0, 1).
    pub fn calibrated(&self, confidence: f64) -> f64 {
        let t = student_t_two_sided(confidence, self.freedom());
        t * self.variance.sqrt() + KAPPA * self.importance_largest * ln_f64(2.0 / (1.0 - confidence))
    }

    /// Half-width that `|L̂ − L|` does not exceed, but for a probability of `delta`, in (0, 1).
    pub fn certified(&self, delta: f64) -> f64 {
        let hoeffding = (0.5 * self.squares * ln_f64(2.0 / (HOEFFDING_SHARE * delta))).sqrt();
        let rest = (1.0 - HOEFFDING_SHARE) * delta;
        let a = (2.0 * self.largest_squared * ln_f64(1.0 / (VARIANCE_SHARE * rest))).sqrt();
        let root_u = 0.5 * a + (0.25 * a * a + self.variance).sqrt();
        let log = ln_f64(2.0 / ((1.0 - VARIANCE_SHARE) * rest));
        hoeffding.min(root_u * (2.0 * log).sqrt() + self.largest * log / 3.0)
    }
}

/// The share of `δ` for look number `look`, from 1: `6/(π² look²)`.
pub fn share_of_look(look: u32) -> f64 {
    let root = std::f64::consts::PI * f64::from(look);
    6.0 / (root * root)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    /// Strata of skewed values: mostly zero, rarely `R`, as light that is mostly in shadow.
    fn draw(s: &mut Stream, strata: &[(f64, f64, u32)]) -> (f64, Spread) {
        let mut mean = 0.0;
        let all: Vec<Stratum> = strata
            .iter()
            .map(|&(upper, share, samples)| {
                let values: Vec<f64> =
                    (0..samples).map(|_| if s.uniform_f64() < share { upper } else { 0.0 }).collect();
                let average = values.iter().sum::<f64>() / f64::from(samples);
                mean += average;
                let squares: f64 = values.iter().map(|y| (y - average) * (y - average)).sum();
                Stratum {
                    samples,
                    upper,
                    importance_range: upper,
                    variance: squares / f64::from(samples - 1),
                }
            })
            .collect();
        (mean, Spread::of(&all))
    }

    /// Share of 4000 runs in which the interval misses.
    fn missed(strata: &[(f64, f64, u32)], half_width: impl Fn(&Spread) -> f64) -> f64 {
        let truth: f64 = strata.iter().map(|&(upper, share, _)| upper * share).sum();
        let mut s = Stream::new(3, Purpose::Test, 0);
        let runs = 4000;
        let misses = (0..runs).filter(|_| {
            let (mean, spread) = draw(&mut s, strata);
            (mean - truth).abs() > half_width(&spread)
        });
        misses.count() as f64 / f64::from(runs)
    }

    fn cases() -> Vec<Vec<(f64, f64, u32)>> {
        vec![
            vec![(1.0, 0.5, 2); 30],
            vec![(1.0, 0.02, 2); 30],
            vec![(1.0, 0.02, 2); 500],
            vec![(1.0, 0.5, 3); 1],
            (0..40).map(|k| (1.0 / f64::from(k + 1), 0.3, 2 + k % 3)).collect(),
            // Many small strata and one large one that is rarely lit.
            std::iter::once((5.0, 0.05, 2)).chain((0..200).map(|_| (0.1, 0.5, 2))).collect(),
        ]
    }

    #[test]
    fn certificates_hold() {
        for (number, strata) in cases().iter().enumerate() {
            for delta in [0.3, 0.05] {
                let missed = missed(strata, |spread| spread.certified(delta));
                assert!(missed <= delta, "case {number}, {delta}: {missed}");
            }
        }
    }

    /// Certificates without the bound of what was not seen would miss where light is rare; the plain interval of Student does.
    #[test]
    fn rare_light_is_what_intervals_miss() {
        let rare = vec![(1.0, 0.01, 2); 30];
        let plain = |spread: &Spread| student_t_two_sided(0.95, 30.0) * spread.variance.sqrt();
        assert!(missed(&rare, plain) > 0.3);
        assert_eq!(missed(&rare, |spread| spread.certified(0.05)), 0.0);
    }

    /// Of many strata of comparable size the certificate is within a small factor of the normal interval.
    #[test]
    fn certificates_are_tight_where_strata_are_many() {
        let strata = vec![Stratum { samples: 2, upper: 1.0, importance_range: 1.0, variance: 0.1 }; 100_000];
        let spread = Spread::of(&strata);
        let normal = student_t_two_sided(0.95, 1e6) * spread.variance.sqrt();
        let ratio = spread.certified(0.05) / normal;
        assert!((1.0..2.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn many_strata_of_one_kind_have_the_calibrated_coverage() {
        for confidence in [0.5, 0.8, 0.95] {
            let missed = missed(&vec![(1.0, 0.5, 2); 300], |spread| spread.calibrated(confidence));
            // The term for rare values only adds; five standard errors.
            let allowed = 1.0 - confidence + 5.0 * (confidence * (1.0 - confidence) / 4000.0).sqrt();
            assert!(missed <= allowed && missed > 0.5 * (1.0 - confidence), "{confidence}: {missed}");
        }
    }

    #[test]
    fn looks_share_delta() {
        let sum: f64 = (1..100_000).map(share_of_look).sum();
        assert!(sum <= 1.0 && sum > 0.9999);
    }

    #[test]
    fn freedom_counts_strata() {
        // Equal variances of two samples each: 3 N − 2.
        let spread =
            Spread::of(&vec![Stratum { samples: 2, upper: 1.0, importance_range: 1.0, variance: 0.2 }; 40]);
        assert!((spread.freedom() - 118.0).abs() < 1e-9);
        assert_eq!(Spread::of(&[]).freedom(), 1.0);
    }
}
