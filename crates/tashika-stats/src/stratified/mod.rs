//! Error of a stratified mean: calibrated intervals, and proven certificates.
//!
//! A sum `L = Σ_k L_k` is estimated by `L̂ = Σ_k ȳ_k` from `n_k ≥ 2` independent samples of each
//! stratum, with values in `[0, R_k]`, means `L_k` and variances `σ_k²`. Let
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
//! H₂ = √(2 U ln(2/δ₂)) + (b/3) ln(2/δ₂)          U − V̂ − V̂ ln(U/V̂) = m ln(1/δ₃),   U ≥ V̂
//! ```
//!
//! with `δ = δ₁ + δ₂ + δ₃`. The bound is not asymptotic. It assumes nothing about the values except
//! that they are in `[0, R_k]`.
//!
//! **Proof.** *H₁* fails with probability at most `δ₁`: `L̂` is a sum of independent variables
//! `y/n_k` with ranges `R_k/n_k`. The squares of these ranges sum to `B` (Hoeffding 1963, theorem
//! 2, applied to both tails).
//!
//! *U.* `X_k = s_k²/n_k` are independent, with means `σ_k²/n_k`, and in `[0, m]`, since
//! `s² ≤ R² n/(4(n − 1))` for `n` values in `[0, R]`. A chord lies above the convex `e^{−tx}`, so
//! `E e^{−tX} ≤ 1 − (E X/m)(1 − e^{−tm}) ≤ exp(−(E X/m)(1 − e^{−tm}))`, and by Markov's inequality
//! `P(V̂ ≤ v) ≤ exp(t v − (V/m)(1 − e^{−tm}))` for every `t > 0`. For `v < V`, the minimum over `t`
//! is at `t = ln(V/v)/m` and gives `P(V̂ ≤ v) ≤ exp(−(V − v − v ln(V/v))/m)` (Chernoff 1952, as for
//! a Poisson variable). Let `v` be the value for which the right side is `δ₃`. Since
//! `V − v − v ln(V/v)` falls with `v` and grows with `V`, `V̂ > v` implies `V < U`.
//!
//! *H₂.* The variables `(y − L_k)/n_k` are independent, have mean zero, are at most `b` in size,
//! and their variances sum to `V`. Bernstein's inequality, solved for the deviation and relaxed by
//! `√(x + y) ≤ √x + √y`, gives `|L̂ − L| ≤ √(2 V ln(2/δ₂)) + (2b/3) ln(2/δ₂)` with the coefficient
//! `2/3`; Bennett's inequality in the form of Boucheron et al. 2013 (theorem 2.10, sub-gamma
//! variables with scale `b/3`) gives the `1/3` above. That bound fails with probability at most
//! `δ₂`, and `V ≤ U` fails with probability at most `δ₃`. ∎
//!
//! # Interim analyses
//! If data are analysed several times, until the result is good enough, each analysis adds to the
//! chance of failure. If at most `J` analyses are planned beforehand and each uses `δ/J`, any of
//! the intervals fails with probability at most `δ`.
//!
//! # The calibrated interval
//!
//! ```text
//! h = t_ν √(V̂ + γ E) + κ b' ln(2/δ)          E = Σ σ'_k²/n_k          b' = max R'_k/n_k          ν = (Σ S_k)² / Σ (S_k²/(ν_k + 2)) − 2,   S_k = s_k²/n_k,   ν_k = n_k − 1
//! ```
//!
//! The first term is Student's, with the degrees of freedom of Satterthwaite 1946 corrected for
//! estimated variances (`E S² = σ⁴ (1 + 2/ν_k)` for normal samples). The second term is that of
//! Bernstein's inequality for a single rare, large value, with the smaller factor [`KAPPA`]. It is
//! needed because equal samples, for example all in shadow, do not prove that a stratum has no
//! variance. `R'` (`importance_range`, at most `R`) is the value that a stratum is expected to
//! reach. If a share of about `p` of the stratum is visible and the root mean square of the visible
//! values is about `q R`, the mean square of a value is `p (q R)²` and `R' = q R √p`. The second
//! term depends on the largest stratum alone. If hundreds of strata seem to be in shadow and each
//! may receive some light, their sum matters. Therefore a share [`GAMMA`] of the expected variance
//! of each stratum, `σ'² = p (1 − p) (q R)²` (`importance_variance`), is added to the estimated
//! variance, even if no sample shows any. The coverage of the interval is measured, not proven.

use super::student_t_two_sided;
use crate::math::elementary::ln_f64;

/// Factor `κ` of the range term; 1/3 in Bernstein's inequality. Lower values need fewer rays and
/// cover the truth less often. Chosen by measurements with `tashika coverage`; see `record/`.
pub const KAPPA: f64 = 0.2;

/// Share `γ` of the expected variance that is added to the estimated variance. It is small because
/// visibility is nearly constant in most strata, though not in all: most vary far less than
/// expected. Chosen by the measurements that set [`KAPPA`].
pub const GAMMA: f64 = 0.001;

/// Share of `δ` that goes to `H₁`, as `δ₁`.
const HOEFFDING_SHARE: f64 = 0.05;
/// Share of `δ − δ₁` that goes to the bound `U` of the variance, as `δ₃`.
const VARIANCE_SHARE: f64 = 0.3;

/// Number of Newton steps. The start is at most twice the root, so the last step is smaller than
/// rounding.
const NEWTON_STEPS: usize = 6;

/// Summary of the samples of one stratum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stratum {
    /// Number of samples `n`, at least 2.
    pub samples: u32,
    /// Upper bound `R` of a sample.
    pub upper: f64,
    /// Rough estimate `R'` of the largest sample, at most `R`; not proven.
    pub importance_range: f64,
    /// Unbiased variance `s²` of the samples.
    pub variance: f64,
    /// Expected variance `σ'²`; not proven.
    pub importance_variance: f64,
}

/// Summary of all strata: the sums and maxima that intervals need.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Estimated variance `V̂` of the sum.
    pub variance: f64,
    /// `Σ S_k²/(ν_k + 2)`.
    fourth: f64,
    /// `b`.
    largest: f64,
    /// `b'`.
    importance_largest: f64,
    /// `m`.
    largest_squared: f64,
    /// `B`.
    squares: f64,
    /// `E`.
    importance_variance: f64,
}

impl Spread {
    /// Collects the sums and maxima of strata.
    pub fn of(strata: impl IntoIterator<Item = Stratum>) -> Self {
        let mut spread = Self::default();
        for Stratum { samples, upper, importance_range, variance, importance_variance } in strata {
            let n = f64::from(samples);
            let of_mean = variance / n;
            spread.variance += of_mean;
            spread.fourth += of_mean * of_mean / (n + 1.0);
            spread.largest = spread.largest.max(upper / n);
            spread.importance_largest = spread.importance_largest.max(importance_range / n);
            spread.largest_squared = spread.largest_squared.max(upper * upper / (4.0 * (n - 1.0)));
            spread.squares += upper * upper / n;
            spread.importance_variance += importance_variance / n;
        }
        spread
    }

    /// Variance `V̂ + γ E` that calibrated intervals use.
    #[inline]
    pub fn reckoned_variance(&self) -> f64 {
        self.variance + GAMMA * self.importance_variance
    }

    /// `b'`: roughly the largest contribution that samples may have missed.
    #[inline]
    pub fn importance_largest(&self) -> f64 {
        self.importance_largest
    }

    /// Effective degrees of freedom `ν` of `V̂`, at least 1.
    #[inline]
    pub fn freedom(&self) -> f64 {
        if self.fourth > 0.0 { (self.variance * self.variance / self.fourth - 2.0).max(1.0) } else { 1.0 }
    }

    /// Half-width of Student's interval, which depends on the samples alone. `confidence` is in
    /// (0, 1).
    pub fn student(&self, confidence: f64) -> f64 {
        student_t_two_sided(confidence, self.freedom()) * self.variance.sqrt()
    }

    /// Half-width `h` of the calibrated interval. `confidence`, `1 − δ`, is in (0, 1).
    pub fn calibrated(&self, confidence: f64) -> f64 {
        let t = student_t_two_sided(confidence, self.freedom());
        t * self.reckoned_variance().sqrt()
            + KAPPA * self.importance_largest * ln_f64(2.0 / (1.0 - confidence))
    }

    /// Half-width that `|L̂ − L|` exceeds with a probability of at most `delta`. `delta` is in
    /// (0, 1).
    pub fn certified(&self, delta: f64) -> f64 {
        let hoeffding = (0.5 * self.squares * ln_f64(2.0 / (HOEFFDING_SHARE * delta))).sqrt();
        let rest = (1.0 - HOEFFDING_SHARE) * delta;
        let upper = self.upper_variance(VARIANCE_SHARE * rest);
        let log = ln_f64(2.0 / ((1.0 - VARIANCE_SHARE) * rest));
        hoeffding.min((2.0 * upper * log).sqrt() + self.largest * log / 3.0)
    }

    /// Bound `U`, which `V` exceeds with a probability of at most `delta`.
    fn upper_variance(&self, delta: f64) -> f64 {
        let (v, target) = (self.variance, self.largest_squared * ln_f64(1.0 / delta));
        if v <= 0.0 {
            return target;
        }
        // The left side of the equation for `U` is convex, and at least `(U − V̂)²/(2 U)`. Newton's
        // method starts where this lower bound equals `target`, so all steps stay above the root.
        let mut upper = v + target + (target * (target + 2.0 * v)).sqrt();
        for _ in 0..NEWTON_STEPS {
            let left = upper - v - v * ln_f64(upper / v);
            upper -= (left - target).max(0.0) * upper / (upper - v).max(f64::MIN_POSITIVE);
        }
        upper.max(v)
    }
}

#[cfg(test)]
mod tests;
