//! The truth of an audited pixel: an interval, by so many paths as it takes.
//!
//! ```text
//! stage 0: n₀ paths, to 0.7 ε ── open? ─► n₁ others, to 0.35 ε ── open? ─► n₂ others, to 0.175 ε
//!
//! t ± t_ν √(max(s², (n s² + w σ²)/(n + w))/n + V_set)          w = 256
//! ```
//!
//! with the variance `s²` of the pixel's own paths, that of the picture's paths around it, `σ²`
//! ([`Picture::importance_variance`]), which knows of the bright one of a thousand that a hundred do
//! not meet, and how much light varies by which VPLs there are (`V_set`). A truth of which too much
//! light is not found is none.
//!
//! Where a look finds that an interval leaves it open on which side a pixel is, the truth is computed
//! once more, in [stages](STAGES), by other paths: of those before only their variance is known, as
//! `σ²`. How many paths a stage has is told by `σ` before any of them is drawn. So each of the
//! intervals that there may be misses its truth with its equal share of `γ`, and an outside pixel is
//! taken for one inside only if one of them does.
//!
//! # Held to this by
//! The tests below, which know the variances; the record of 2026-11-26 (truths by paths) holds truths
//! of four scenes against path tracing.
//!
//! The picture says how many paths there are and how wide an interval is at least, which makes none
//! narrower than its own paths do.

use super::verdict::{AuditedPixel, Tolerance, luminance_at};
use crate::color::Rgb;
use crate::integrator::PathSamples;
use crate::picture::{Picture, Wanted};
use crate::request::AuditTerms;
use crate::stats::student_t_two_sided;

/// How closely a truth is known.
pub(super) struct Stage {
    /// Half-width, as a share of the tolerance.
    half_width: f64,
    /// Paths at most.
    pub most_paths: u32,
}

/// How closely truths are known at first, and then where they are open. Most pixels of a picture that
/// is good enough are so by far, and a wide interval tells.
pub(super) const STAGES: [Stage; 3] = [
    Stage { half_width: 0.7, most_paths: 1 << 13 },
    Stage { half_width: 0.35, most_paths: 1 << 15 },
    Stage { half_width: 0.175, most_paths: 1 << 17 },
];
/// Paths of a truth at least: fewer tell little of their own variance. Chosen.
pub(super) const FEWEST_PATHS: u32 = 64;
/// As many paths of the picture around a pixel count as much as its own.
const NEIGHBOURHOOD_WEIGHT: f64 = 256.0;
/// Degrees of freedom of a normal interval, nearly.
const MANY: f64 = 1e6;
/// Share of the tolerance that light which is not found may have.
const NEGLIGIBLE: f64 = 0.25;

/// What is known of the paths of a pixel before they are drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Around {
    /// About how bright the pixel is (luminance).
    pub luminance: f64,
    /// About the variance of single paths (luminance²).
    pub variance: f64,
}

impl Around {
    /// By the paths of a picture.
    ///
    /// * `radiance`: of its pixels, row by row.
    pub fn of(picture: &Picture<'_>, pixel: [u32; 2], radiance: &[Rgb], tolerance: &Tolerance) -> Self {
        let luminance = luminance_at(pixel, &picture.window(), radiance);
        let least = tolerance.absolute / tolerance.error;
        Self { luminance, variance: picture.importance_variance(pixel, radiance, least) }
    }
}

/// A truth in work.
#[derive(Clone, Debug)]
pub(super) struct Truth {
    pixel: [u32; 2],
    /// Of single paths, by those around and by its own of all stages.
    known: Around,
    /// In the last stage.
    found: PathSamples,
    /// The next.
    pub stage: usize,
    /// Of all stages.
    rays: u64,
}

impl Truth {
    /// Of a pixel, of which nothing is known yet.
    pub fn new(pixel: [u32; 2], around: Around) -> Self {
        Self { pixel, known: around, found: PathSamples::default(), stage: 0, rays: 0 }
    }

    /// Rays so far.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// The paths of the next stage.
    ///
    /// * `fewest`: paths of a truth at least.
    pub fn wanted(&self, tolerance: &Tolerance, fewest: u32) -> Wanted {
        let Self { pixel, known, stage, .. } = self;
        let Stage { half_width, most_paths } = STAGES[*stage];
        let error = half_width * tolerance.of(known.luminance) / of_errors(MANY);
        let wanted = (known.variance / (error * error)).ceil() as u32;
        Wanted { pixel: *pixel, paths: wanted.clamp(fewest, most_paths.max(fewest)) }
    }

    /// Takes in the paths of the next stage.
    pub fn advance(&mut self, found: PathSamples) {
        let (paths, own) = (found.luminance.count() as f64, found.luminance.variance());
        let weight = NEIGHBOURHOOD_WEIGHT;
        let pooled = (paths * own + weight * self.known.variance) / (paths + weight);
        // Not below that of its own paths; `f64::max` would lose what is not a number.
        let variance = if pooled < own { own } else { pooled };
        self.known = Around { luminance: found.luminance.mean(), variance };
        self.rays += found.rays;
        self.found = found;
        self.stage += 1;
    }

    /// What is known of it.
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

/// How many standard errors an interval has on either side.
fn of_errors(freedom: f64) -> f64 {
    let confidence = 1.0 - (1.0 - AuditTerms::CONFIDENCE) / STAGES.len() as f64;
    student_t_two_sided(confidence, freedom)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOLERANCE: Tolerance = Tolerance { error: 0.1, absolute: 0.01 };

    /// Half the width of the interval of so many paths of mean 10 and standard deviation 1.
    fn half_width(paths: u32, around: f64, change: impl Fn(&mut PathSamples)) -> Option<f64> {
        let mut truth = Truth::new([0, 0], Around { luminance: 10.0, variance: around });
        let mut found = PathSamples::default();
        (0..paths).for_each(|k| found.luminance.push(if k % 2 == 0 { 9.0 } else { 11.0 }));
        change(&mut found);
        truth.advance(found);
        truth.audited(&TOLERANCE).interval.map(|[low, high]| (high - low) / 2.0)
    }

    /// Normal intervals of 1 − γ/3 where there are many paths; wider by what is known from elsewhere.
    #[test]
    fn intervals_know_of_neighbours_and_of_sets() {
        const OF_ERRORS: f64 = 2.394;
        let is = |found: Option<f64>, expected: f64| {
            let found = found.unwrap();
            assert!((found / expected - 1.0).abs() < 2e-3, "{found} for {expected}");
        };
        is(half_width(1 << 16, 1.0, |_| {}), OF_ERRORS / 256.0);
        is(half_width(1 << 16, 0.0, |_| {}), OF_ERRORS / 256.0);
        // A quarter of 1,024 paths more know of a variance of 101.
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

    /// As many paths as the half-width of the stage takes, at least so many, and not more than the most.
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
