//! What a pixel's repetitions are made of, decided before the first of them.
//!
//! Sums over VPLs with paths of what these do not carry, and paths alone, have the same mean. For either [`Estimator`] the work to the end is foreseen from
//! what is known of the pixel and its neighbourhood, and the one with less of it is taken:
//!
//! ```text
//! W = R w        R = max(8, V / σ²)        σ = τ/2        V = V_sets + V_cut + V_path / m      or      V = V_path / m
//! ```
//!
//! with the tolerance `τ` and the work `w` of a repetition. Of VPLs it must be likely that the sets at hand are enough: `V_sets / R_max ≤ σ²`.
//!
//! # Independence
//! Sets, streams and pixels that are used for no estimate; so the decision has no say in the mean.

use smallvec::{SmallVec, smallvec};

use super::super::ControlOptions;
use super::cells::Cell;
use super::looks::Look;
use super::replicate::{Estimator, Planned, Recipe, Repetition};
use crate::color::{Rgb, RgbSum};
use crate::stats::Moments;

// What follows was chosen on the development scenes; it decides about cost, and about how rare the light may be that intervals reckon with, not about the mean.

/// How many times wider than asked for the interval of a single repetition is.
const LOOSE: f64 = 3.0;
/// Pairs of the smallest cut.
const FIRST_PAIRS: u64 = 16;
/// Growth of a cut from look to look while planning.
const PAIRS_GROWTH: f64 = 1.3;
/// Pairs of the largest cut: beyond, another repetition tells more.
const MOST_PAIRS: u64 = 256;
/// Standard errors in the half-width of an interval, about.
pub(super) const ERRORS_OF_HALF_WIDTH: f64 = 2.0;
/// Fewest paths of a repetition.
const FEWEST_PATHS: f64 = 4.0;
/// Most paths of a repetition beside a sum: beyond, another repetition tells more.
const MOST_PATHS: f64 = 256.0;
/// Most paths of a repetition of nothing else.
const MOST_PATHS_ALONE: f64 = 1024.0;
/// Paths of either estimator by which it is planned how many there are.
const PLANNING_PATHS: u32 = 32;
/// Share of the variance of a repetition that paths may have where there are sums.
const PATHS_SHARE: f64 = 0.5;
/// Work of a ray of a sum, with its share of bounds and lists, in rays of a path.
const WORK_OF_SUMS: f64 = 3.0;

/// How a pixel is estimated.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plan {
    /// What its repetitions are made of; each recipe but the first is for the case that the one before did not get there.
    pub recipes: SmallVec<[Recipe; 2]>,
    /// Rays that it took to know.
    pub rays: u64,
}

/// What is known of the paths of an estimator.
struct Foreseen {
    /// Of paths of the pixel only.
    own_mean: f64,
    mean: f64,
    variance: f64,
    rays_per_path: f64,
}

impl Foreseen {
    /// By paths of the pixel, and of its neighbourhood, which may be brighter, but has seen more.
    fn of(estimator: Estimator, planning: &Repetition<'_>, cell: &Cell, rays: &mut u64) -> Self {
        let paths = cell.paths(estimator);
        let nearby = paths.moments.first().copied().unwrap_or_default();
        let mut own = Moments::default();
        *rays += planning.paths(estimator, PLANNING_PATHS, |value, _| own.push(f64::from(value.luminance())));
        let even = |a: f64, b: f64| if own.count() > 0 { 0.5 * (a + b) } else { b };
        Self {
            own_mean: own.mean(),
            mean: even(own.mean(), nearby.mean()),
            variance: even(own.variance(), nearby.variance()),
            rays_per_path: paths.rays_per_path(),
        }
    }

    /// Paths of a repetition after which this is the error of their mean.
    fn count(&self, error: f64, most: f64) -> u32 {
        let paths = if self.variance > 0.0 { self.variance / (error * error) } else { 0.0 };
        paths.clamp(FEWEST_PATHS, most) as u32
    }
}

/// Plans for a pixel, with one of the sets that plan.
///
/// * `cell`: its neighbourhood; none if nothing is asked for but sums over VPLs.
/// * `only`: the estimator, if it is not to be chosen.
/// * `sets`: how many sets there are to repeat with.
pub(super) fn plan(
    planning: &Repetition<'_>,
    cell: Option<&Cell>,
    options: &ControlOptions,
    only: Option<Estimator>,
    sets: usize,
) -> Plan {
    let next = |n: &u64| Some((*n as f64 * PAIRS_GROWTH) as u64).filter(|n| *n <= MOST_PAIRS);
    let sizes = std::iter::successors(Some(FIRST_PAIRS), next);
    let Planned { pairs, sum, rays: rays_of_sum } =
        planning.plan(options.controlled, sizes, |sum, spread| {
            spread.calibrated(options.confidence) <= LOOSE * options.tolerance(sum)
        });
    let mut rays = rays_of_sum;
    let by_vpls = Recipe { estimator: Estimator::Vpls, pairs, paths: 0 };
    let Some(cell) = cell else { return Plan { recipes: smallvec![by_vpls], rays } };
    let uncarried = Foreseen::of(Estimator::Vpls, planning, cell, &mut rays);
    // Negative paths tell of their noise only.
    let mut whole = sum;
    whole.merge(&gray(uncarried.mean.max(0.0)));
    let tolerance = options.tolerance(&whole);
    let (error, loose) = (tolerance / ERRORS_OF_HALF_WIDTH, LOOSE * tolerance / ERRORS_OF_HALF_WIDTH);
    let repetitions = |variance: f64| (variance / (error * error)).max(Look::FIRST.sets as f64);

    let over_vpls = f64::from(sum.total().luminance());
    let of_sets = cell.relative_variance_of_sets * over_vpls * over_vpls;
    let paths = uncarried.count(PATHS_SHARE.sqrt() * loose, MOST_PATHS);
    let variance = of_sets + loose * loose + uncarried.variance / f64::from(paths);
    let work = WORK_OF_SUMS * rays_of_sum as f64 + f64::from(paths) * uncarried.rays_per_path;
    let by_vpls = Recipe { paths, ..by_vpls };
    let work_by_vpls =
        if of_sets <= error * error * sets as f64 { repetitions(variance) * work } else { f64::INFINITY };
    if only == Some(Estimator::Vpls) {
        return Plan { recipes: smallvec![by_vpls], rays };
    }

    let all = Foreseen::of(Estimator::Paths, planning, cell, &mut rays);
    // Where the neighbourhood is brighter than the pixel, it does not say what the pixel tolerates.
    let tolerance = options.tolerance(&gray(all.own_mean.min(all.mean)));
    let paths = all.count(LOOSE * tolerance / ERRORS_OF_HALF_WIDTH, MOST_PATHS_ALONE);
    let work_by_paths = repetitions(all.variance / f64::from(paths)) * f64::from(paths) * all.rays_per_path;
    let by_paths = Recipe { estimator: Estimator::Paths, pairs: 0, paths };
    if only == Some(Estimator::Paths) || work_by_paths < work_by_vpls {
        return Plan { recipes: smallvec![by_paths], rays };
    }
    Plan { recipes: smallvec![by_vpls, by_paths], rays }
}

fn gray(luminance: f64) -> RgbSum {
    let mut sum = RgbSum::default();
    sum.add(Rgb::gray(luminance as f32));
    sum
}
