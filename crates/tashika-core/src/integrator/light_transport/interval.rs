//! Interval of an estimate of a pixel whose errors have several sources.
//!
//! ```text
//! V = V_cut + V_lights + V_points + V_paths        h = t_ν √V + κ b ln(2/δ)        ν = V² / (V_cut²/ν_cut + V_lights²/ν_lights + V_paths²/ν_paths)
//! ```
//!
//! | from the choice of | known from |
//! |---|---|
//! | terms: `V_cut` | the strata of the cut ([`stratified`](crate::stats::stratified)) |
//! | VPLs: `V_lights`, camera samples: `V_points` | [`Population`](crate::cut::Population) |
//! | paths: `V_paths` | the pixel's own paths and [`nearby`](super::nearby) ones |
//!
//! The degrees of freedom `ν` are those of Satterthwaite 1946.
//! [`Population`](crate::cut::Population) uses the samples of the cut. If emission that the camera
//! sees is rare, `V_paths` includes the variance of that emission over all camera samples. `b` is
//! approximately the largest contribution that may be missing from the samples: of a stratum, of a
//! path of the neighbourhood, or of a VPL. If no camera sample met a surface although one may be in
//! the pixel, the last term is at least the luminance of surfaces in the neighbourhood times the
//! share of the pixel that the samples may have missed ([`Estimate::unmet`]). The interval is an
//! estimate: measured, not proven.

use super::super::ControlOptions;
use super::super::looks::AIM;
use super::super::path_spread::{KAPPA_OF_PATHS, PathSpread};
use super::estimate::Estimate;
use crate::color::RgbSum;
use crate::math::elementary::{ln_f64, powf_f64};
use crate::stats::stratified::KAPPA;
use crate::stats::{Moments, student_t_two_sided};

/// Exponent `p` of the variance of a cut, which falls as `pairs^(−p)` (record, light transport).
const CUT_VARIANCE_EXPONENT: f64 = 1.77;

/// Result of an interim analysis, for the part of the error metric with the widest interval.
#[derive(Clone, Copy, Debug)]
pub(super) struct Finding {
    pub mean: RgbSum,
    /// Luminance of the sum over VPLs, and of the mean of paths.
    pub by_estimator: [f32; 2],
    pub tolerance: f64,
    pub half_width: f64,
    /// `V_cut`, `V_lights`, `V_points`, `V_paths`.
    variances: [f64; 4],
    /// `t_ν`.
    errors: f64,
    /// Terms `κ b ln(2/δ)` of strata, of paths and of VPLs.
    rare: [f64; 3],
}

impl Finding {
    /// Returns the interval of confidence `1 − δ`.
    ///
    /// * `nearby`: moments of paths of the neighbourhood, by part of the error metric.
    pub(super) fn of(
        estimate: &Estimate<'_>,
        nearby: &[Moments],
        options: &ControlOptions,
        delta: f64,
    ) -> Self {
        let mean = estimate.value();
        let tolerance = options.tolerance(&mean);
        let gathered = estimate.gathered();
        let by_estimator = [&gathered, &estimate.by_paths()].map(|part| part.total().luminance());
        let parts = options.controlled.parts();
        let delta = delta / parts.len() as f64;
        let of_part = |part: usize| {
            let spread = estimate.spread(part, &gathered);
            let own = &estimate.moments()[part];
            // Where no surface is met, paths find no light.
            let theirs = nearby.get(part).copied().filter(|_| estimate.meets_surfaces()).unwrap_or_default();
            let paths = PathSpread::of(own, &theirs);
            let emission = estimate.rare_emission().map(|parts| parts[part]).unwrap_or_default();
            let samples = (emission.count() as f64).max(1.0);
            // The two variances are added as if independent. The variance of the sum is smaller,
            // since a camera sample that sees only emission has no path.
            let of_paths = paths.variance + emission.variance() / samples;
            let by_draws = estimate.by_draws(part, tolerance);
            let of_cut = spread.reckoned_variance();
            let variances = [of_cut, by_draws.lights, by_draws.points, of_paths];
            let variance: f64 = variances.iter().sum();
            let squares = of_cut * of_cut / spread.freedom()
                + by_draws.square_of_lights
                + of_paths * of_paths / paths.freedom;
            let freedom = if squares > 0.0 { (variance * variance / squares).max(1.0) } else { 1.0 };
            let errors = student_t_two_sided(1.0 - delta, freedom);
            let largest = paths.largest.max(emission.largest() / samples);
            let rare = [
                KAPPA * spread.importance_largest(),
                KAPPA_OF_PATHS * largest,
                KAPPA_OF_PATHS * by_draws.largest_of_lights,
            ];
            let mut rare = rare.map(|b| b * ln_f64(2.0 / delta));
            // The number of camera samples of gather points is fixed, so that the error due to
            // unmet surfaces does not fall. That of paths grows, and the error falls with it.
            let by_source = if estimate.has_points() { 2 } else { 1 };
            rare[by_source] = rare[by_source].max(estimate.unmet(part, delta));
            let half_width = errors * variance.sqrt() + rare.into_iter().fold(0.0, f64::max);
            Self { mean, by_estimator, tolerance, half_width, variances, errors, rare }
        };
        let widest = (0..parts.len()).map(of_part).max_by(|a, b| a.half_width.total_cmp(&b.half_width));
        widest.expect("something is controlled")
    }

    pub(super) fn is_narrow_enough(&self) -> bool {
        self.half_width <= self.tolerance
    }

    /// Returns true if the half-width is zero.
    pub(super) fn is_exact(&self) -> bool {
        self.half_width == 0.0
    }

    pub(super) fn standard_error(&self) -> f64 {
        self.variances.iter().sum::<f64>().sqrt()
    }

    /// Half-widths from single sources of error: terms drawn, VPLs with camera samples, and paths.
    pub(super) fn parts(&self) -> [f64; 3] {
        let [cut, lights, points, paths] = self.variances;
        [cut, lights + points, paths].map(|variance| self.errors * variance.sqrt())
    }

    /// Variance that would meet the tolerance, with the margin of [`AIM`].
    pub(super) fn tolerated_variance(&self) -> f64 {
        let error = AIM * self.tolerance / self.errors;
        error * error
    }

    /// Returns true if a source of error that does not fall as the estimate grows exceeds `share`
    /// of the tolerance, and its variance is known well enough.
    pub(super) fn is_limited_by(&self, source: Source, share: f64) -> bool {
        self.share_of(source) > share && self.variance_by(source) > KNOWN * self.variances[0]
    }

    /// Half-width from a source of error alone, over the tolerance.
    pub(super) fn share_of(&self, source: Source) -> f64 {
        self.errors * self.variance_by(source).sqrt() / self.tolerance
    }

    fn variance_by(&self, source: Source) -> f64 {
        match source {
            Source::Lights => self.variances[1],
            Source::Points => self.variances[2],
            Source::Both => self.variances[1] + self.variances[2],
        }
    }

    /// Factors by which to grow the pairs and the paths of an estimate. Each step grows the one
    /// that lowers the half-width most for its work, until the half-width is predicted to be narrow
    /// enough, or the growth reaches `most`.
    ///
    /// * `work`: work of all pairs and of all paths so far.
    ///
    /// Also returns true if the growth is predicted to be enough.
    pub(super) fn growth(&self, work: [f64; 2], most: [f64; 2]) -> ([f64; 2], bool) {
        let [cut, lights, points, paths] = self.variances;
        let mut growth = [1.0, 1.0];
        // An estimate without variance may still miss rare light.
        let error = self.standard_error();
        let error = if error > 0.0 { error } else { 1.0 };
        loop {
            let falls = [powf_f64(growth[0], -CUT_VARIANCE_EXPONENT), 1.0 / growth[1]];
            let varies = [cut * falls[0], paths * falls[1]];
            let rare = [self.rare[0] / growth[0], self.rare[1] / growth[1], self.rare[2]];
            let half_width = self.errors * (varies[0] + varies[1] + lights + points).sqrt()
                + rare.into_iter().fold(0.0, f64::max);
            if half_width <= AIM * self.tolerance {
                return (growth, true);
            }
            // Decrease of the half-width per unit of work, up to a common factor.
            let gain = |k: usize| {
                let power = if k == 0 { CUT_VARIANCE_EXPONENT } else { 1.0 };
                let by_variance = self.errors * power * varies[k];
                let by_rare = if rare[k] >= rare[1 - k].max(rare[2]) { rare[k] * error } else { 0.0 };
                if work[k] > 0.0 { (by_variance + by_rare) / (work[k] * growth[k]) } else { 0.0 }
            };
            let pick = usize::from(gain(1) > gain(0));
            if gain(pick) <= 0.0 || growth[pick] >= most[pick] {
                return (growth, false);
            }
            growth[pick] *= STEP;
        }
    }
}

/// A source of error that does not fall as an estimate grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Source {
    Lights,
    Points,
    Both,
}

/// Least ratio of another variance to the variance of the cut at which the samples of the cut
/// estimate the former well.
const KNOWN: f64 = 3.0;
/// Factor of one step of growth.
const STEP: f64 = 1.05;

#[cfg(test)]
mod tests {
    use super::*;

    /// All variances are zero, and the term for rare light of paths exceeds the tolerance, as for a
    /// background of one colour after a few samples. The number of paths grows.
    #[test]
    fn what_does_not_vary_grows_as_well() {
        let found = Finding {
            mean: RgbSum::default(),
            by_estimator: [0.0; 2],
            tolerance: 0.1,
            half_width: 0.2,
            variances: [0.0; 4],
            errors: 2.0,
            rare: [0.0, 0.2, 0.0],
        };
        let (growth, is_enough) = found.growth([0.0, 32.0], [2.0, 4.0]);
        assert!(is_enough && growth[0] == 1.0 && (2.0..2.5).contains(&growth[1]), "{growth:?}");
    }

    /// If the variance of paths makes the interval wide, paths grow; if the variance of the cut
    /// does, pairs grow. Both grow only as far as needed, and at most as far as permitted.
    #[test]
    fn estimates_grow_where_they_are_wide() {
        let found = |cut: f64, paths: f64| Finding {
            mean: RgbSum::default(),
            by_estimator: [0.0; 2],
            tolerance: 0.1,
            half_width: 2.0 * (cut + paths).sqrt(),
            variances: [cut, 0.0, 0.0, paths],
            errors: 2.0,
            rare: [0.0; 3],
        };
        let (growth, is_enough) = found(1e-6, 1e-2).growth([100.0, 100.0], [50.0, 50.0]);
        assert!(is_enough && growth[0] == 1.0 && (4.0..6.0).contains(&growth[1]), "{growth:?}");
        let (growth, is_enough) = found(1e-2, 1e-6).growth([100.0, 100.0], [50.0, 50.0]);
        assert!(is_enough && growth[1] == 1.0 && (2.0..3.0).contains(&growth[0]), "{growth:?}");
        let (growth, is_enough) = found(1e-2, 1e-2).growth([100.0, 100.0], [1.5, 1.5]);
        assert!(!is_enough && growth.iter().any(|growth| *growth >= 1.5), "{growth:?}");
    }
}
