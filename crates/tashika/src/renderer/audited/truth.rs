//! The truth of an audited pixel: an interval, from as many paths as are needed.
//!
//! ```text
//! stage 0: n₀ paths, to 0.7 ε ── open? ─► n₁ others, to 0.35 ε ── open? ─► n₂ others, to 0.175 ε
//!
//! t ± t_ν √(max(s², (n s² + w σ²)/(n + w))/n + V_set)          w = 256
//! ```
//!
//! Here `s²` is the variance of the pixel's own paths, `σ²` the variance of the picture's paths
//! around the pixel ([`Picture::importance_variance`]), and `V_set` the variance between sets of
//! VPLs. `σ²` accounts for rare bright paths: a hundred paths of the pixel may all miss one path in
//! a thousand. A truth with too much unsampled light is unknown.
//!
//! If an interval leaves open on which side of the tolerance a pixel is, an analysis computes the
//! truth again, in [stages](STAGES), with new paths. The earlier paths contribute only their
//! variance, as part of `σ²`. The number of paths of a stage is computed from `σ` before any of
//! them is drawn. Each of the possible intervals therefore misses its truth with an equal share of
//! the probability `γ`, and an outside pixel is taken for one inside only if an interval misses.
//!
//! The variance of the picture determines the number of paths, and can only widen an interval: no
//! interval is narrower than the pixel's own paths make it.
//!
//! # Held to this by
//! The tests below, with known variances; the record of 2026-11-26 (truths by paths) compares
//! truths of four scenes with path tracing.

use super::verdict::{AuditedPixel, Tolerance, luminance_at};
use crate::color::Rgb;
use crate::integrator::PathSamples;
use crate::picture::{Picture, Wanted};
use crate::request::AuditTerms;
use crate::stats::student_t_two_sided;

/// Precision of a truth.
pub(super) struct Stage {
    /// Half-width, over the tolerance.
    half_width: f64,
    /// Most paths of the stage.
    pub most_paths: u32,
}

/// Stages of a truth: the first for all pixels, the others for pixels that are still open. Most
/// pixels of a good picture are well within the tolerance, so that a wide interval decides.
pub(super) const STAGES: [Stage; 3] = [
    Stage { half_width: 0.7, most_paths: 1 << 13 },
    Stage { half_width: 0.35, most_paths: 1 << 15 },
    Stage { half_width: 0.175, most_paths: 1 << 17 },
];
/// Smallest number of paths of a truth: the variance of fewer paths would be estimated poorly.
/// Chosen.
pub(super) const FEWEST_PATHS: u32 = 64;
/// Weight `w` of the variance `σ²` of the picture's paths, as a number of the pixel's own paths.
const NEIGHBOURHOOD_WEIGHT: f64 = 256.0;
/// Number of degrees of freedom at which Student's interval is nearly normal.
const MANY: f64 = 1e6;
/// Largest amount of unsampled light in a known truth, over the tolerance.
const NEGLIGIBLE: f64 = 0.25;

/// Estimates about the paths of a pixel, made before the paths are drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Around {
    /// Approximate luminance of the pixel.
    pub luminance: f64,
    /// Approximate variance of single paths (luminance²).
    pub variance: f64,
}

impl Around {
    /// Estimates from the paths of a picture.
    ///
    /// * `radiance`: of its pixels, row by row.
    pub fn of(picture: &Picture<'_>, pixel: [u32; 2], radiance: &[Rgb], tolerance: &Tolerance) -> Self {
        let luminance = luminance_at(pixel, &picture.window(), radiance);
        let least = tolerance.absolute / tolerance.error;
        Self { luminance, variance: picture.importance_variance(pixel, radiance, least) }
    }
}

/// A truth in progress, over its stages.
#[derive(Clone, Debug)]
pub(super) struct Truth {
    pixel: [u32; 2],
    /// Luminance of the last stage. Variance of single paths, pooled from the picture's paths
    /// around the pixel and the pixel's own paths of all stages.
    known: Around,
    /// Paths of the last stage.
    found: PathSamples,
    /// Index of the next stage.
    pub stage: usize,
    /// Number of rays of all stages.
    rays: u64,
}

impl Truth {
    /// Truth of a pixel before its first stage.
    pub fn new(pixel: [u32; 2], around: Around) -> Self {
        Self { pixel, known: around, found: PathSamples::default(), stage: 0, rays: 0 }
    }

    /// Number of paths of the last stage.
    pub fn paths(&self) -> u64 {
        self.found.luminance.count()
    }

    /// Number of rays so far.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Paths of the next stage.
    ///
    /// * `fewest`: fewest paths of a truth.
    pub fn wanted(&self, tolerance: &Tolerance, fewest: u32) -> Wanted {
        let Self { pixel, known, stage, .. } = self;
        let Stage { half_width, most_paths } = STAGES[*stage];
        let error = half_width * tolerance.of(known.luminance) / of_errors(MANY);
        let wanted = (known.variance / (error * error)).ceil() as u32;
        Wanted { pixel: *pixel, paths: wanted.clamp(fewest, most_paths.max(fewest)) }
    }

    /// Adds the paths of the next stage.
    pub fn advance(&mut self, found: PathSamples) {
        let (paths, own) = (found.luminance.count() as f64, found.luminance.variance());
        let weight = NEIGHBOURHOOD_WEIGHT;
        let pooled = (paths * own + weight * self.known.variance) / (paths + weight);
        // At least the variance of the pixel's own paths. `f64::max` would drop a NaN.
        let variance = if pooled < own { own } else { pooled };
        self.known = Around { luminance: found.luminance.mean(), variance };
        self.rays += found.rays;
        self.found = found;
        self.stage += 1;
    }

    /// Audited pixel, with an interval if the truth is known.
    pub fn audited(&self, tolerance: &Tolerance) -> AuditedPixel {
        let Self { pixel, known, found, .. } = self;
        let (luminance, paths) = (found.luminance.mean(), found.luminance.count() as f64);
        let variance = (known.variance + found.importance_of_set) / paths;
        let half_width = of_errors(paths + NEIGHBOURHOOD_WEIGHT - 1.0) * variance.sqrt();
        let is_found =
            paths > 0.0 && found.importance_not_found <= NEGLIGIBLE * tolerance.of(luminance) * paths;
        // A value that is not finite is not a truth.
        let is_known = is_found && luminance.is_finite() && half_width.is_finite();
        let interval = is_known.then(|| [(luminance - half_width).max(0.0), luminance + half_width]);
        AuditedPixel { pixel: *pixel, interval }
    }
}

/// Half-width of an interval, in standard errors.
fn of_errors(freedom: f64) -> f64 {
    let confidence = 1.0 - (1.0 - AuditTerms::CONFIDENCE) / STAGES.len() as f64;
    student_t_two_sided(confidence, freedom)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOLERANCE: Tolerance = Tolerance { error: 0.1, absolute: 0.01 };

    /// Half-width of the interval of `paths` paths of mean 10 and standard deviation 1.
    fn half_width(paths: u32, around: f64, change: impl Fn(&mut PathSamples)) -> Option<f64> {
        let mut truth = Truth::new([0, 0], Around { luminance: 10.0, variance: around });
        let mut found = PathSamples::default();
        (0..paths).for_each(|k| found.luminance.push(if k % 2 == 0 { 9.0 } else { 11.0 }));
        change(&mut found);
        truth.advance(found);
        truth.audited(&TOLERANCE).interval.map(|[low, high]| (high - low) / 2.0)
    }

    /// With many paths, an interval is the normal interval of confidence 1 − γ/3. The variances of
    /// the neighbourhood and between sets widen it.
    #[test]
    fn intervals_know_of_neighbours_and_of_sets() {
        const OF_ERRORS: f64 = 2.394;
        let is = |found: Option<f64>, expected: f64| {
            let found = found.unwrap();
            assert!((found / expected - 1.0).abs() < 2e-3, "{found} for {expected}");
        };
        is(half_width(1 << 16, 1.0, |_| {}), OF_ERRORS / 256.0);
        is(half_width(1 << 16, 0.0, |_| {}), OF_ERRORS / 256.0);
        // The neighbourhood has the weight of 256 paths, a quarter of 1,024, and a variance of 101.
        // The pooled variance is 21.
        is(half_width(1024, 101.0, |_| {}), OF_ERRORS * (21.0_f64 / 1024.0).sqrt());
        let of_set = |found: &mut PathSamples| found.importance_of_set = 0.5 * 65_536.0;
        is(half_width(1 << 16, 1.0, of_set), OF_ERRORS * 0.5_f64.sqrt());
    }

    #[test]
    fn truths_of_which_light_is_not_found_are_none() {
        let missing = |light: f64| {
            half_width(1 << 16, 1.0, |found| found.importance_not_found = light * 65_536.0).is_some()
        };
        assert!(missing(0.0) && missing(0.24) && !missing(0.26));
        assert_eq!(half_width(0, 1.0, |_| {}), None);
        for path in [f64::NAN, f64::INFINITY] {
            assert_eq!(half_width(64, 1.0, |found| found.luminance.push(path)), None);
            assert_eq!(half_width(64, path, |_| {}), None, "nor where the paths around it are not");
        }
    }

    /// The number of paths is the one that gives the stage's half-width, clamped to the limits.
    #[test]
    fn paths_are_told_by_those_around() {
        let wanted = |variance: f64, stage: usize| {
            let around = Around { luminance: 1.0, variance };
            let truth = Truth { stage, ..Truth::new([3, 2], around) };
            truth.wanted(&TOLERANCE, 64).paths
        };
        let first = |variance: f64| (variance * (2.394_f64 / 0.07).powi(2)) as u32;
        assert!(wanted(1.0, 0).abs_diff(first(1.0)) < 5, "{}", wanted(1.0, 0));
        assert!(wanted(1.0, 1).abs_diff(4 * first(1.0)) < 20);
        assert_eq!((wanted(0.0, 0), wanted(0.0, 1)), (64, 64));
        assert_eq!((wanted(1e9, 0), wanted(1e9, 1)), (1 << 13, 1 << 15));
        assert_eq!(wanted(f64::INFINITY, 0), 1 << 13);
    }
}
