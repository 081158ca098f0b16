//! What is written down of one cell of an experiment.

use serde::Serialize;

use super::{Cell, Pool};

/// What a cell was run on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subject {
    /// Name of the scene.
    pub scene: String,
    /// VPLs.
    pub vpls: u64,
    /// Gather points a pixel.
    pub gather: u32,
    /// Pixels that were held against their exact sums.
    pub pixels: u64,
    /// What they have in common, if they are not all.
    pub group: Option<&'static str>,
}

/// One row. Shares are in 0 to 1, errors relative; infinite errors become `null` in JSON. All
/// counts and means are over the trials: `pixels` times `seeds`.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Method.
    pub method: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// What the pixels have in common, if they are not all.
    pub group: Option<&'static str>,
    /// VPLs.
    pub vpls: u64,
    /// Gather points a pixel.
    pub gather: u32,
    /// Tolerance by which it is judged.
    pub error: f64,
    /// Error that the method was told.
    pub method_error: f64,
    /// Confidence that the method was told, if it states an interval.
    pub confidence: Option<f64>,
    /// Largest cut that the method was told, if not its own default.
    pub max_pairs: Option<u64>,
    /// Pixels.
    pub pixels: u64,
    /// Times that each was rendered.
    pub seeds: u64,
    /// Share of the trials within the tolerance.
    pub within_tolerance: f64,
    /// Lower end of its Clopper–Pearson interval at 95 %.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Mean of the finite errors.
    pub mean: f64,
    /// Error that half of the trials do not exceed.
    pub median: f64,
    /// Error that 95 % of the trials do not exceed.
    pub p95: f64,
    /// Largest error.
    pub worst: f64,
    /// Trials that claimed an interval.
    pub claims: u64,
    /// Share of the claims whose interval holds the exact sum; none if nothing was claimed.
    pub claims_kept: Option<f64>,
    /// Lower end of its Clopper–Pearson interval at 95 %.
    pub claims_low: Option<f64>,
    /// Upper end.
    pub claims_high: Option<f64>,
    /// Trials that ran out of budget.
    pub budget_hit: u64,
    /// Mean number of rays of a trial.
    pub rays_per_pixel: f64,
    /// Mean number of pairs of a trial.
    pub pairs_per_pixel: f64,
    /// Seconds that the method took for everything that it rendered.
    pub seconds: f64,
}

/// What was run, and what it was told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    /// Name of the method.
    pub method: &'static str,
    /// Tolerance by which it is judged.
    pub tolerance: f64,
    /// Error that it was told.
    pub error: f64,
    /// Confidence that it was told, if it states an interval.
    pub confidence: Option<f64>,
    /// Largest cut that it was told.
    pub max_pairs: Option<u64>,
    /// Times that each pixel was rendered.
    pub seeds: u64,
}

impl From<&Cell> for Told {
    fn from(cell: &Cell) -> Self {
        Self {
            method: cell.method.name(),
            tolerance: cell.tolerance,
            error: cell.options.error,
            confidence: cell.confidence(),
            max_pairs: cell.options.max_pairs,
            seeds: cell.seeds,
        }
    }
}

impl Row {
    /// The row of what was run on that subject, in so many seconds.
    pub fn new(subject: &Subject, told: Told, pool: &Pool, seconds: f64) -> Self {
        let (within, claims) = (pool.within(), pool.claims());
        let claimed = (claims.of > 0).then(|| claims.interval());
        Self {
            method: told.method,
            scene: subject.scene.clone(),
            group: subject.group,
            vpls: subject.vpls,
            gather: subject.gather,
            error: told.tolerance,
            method_error: told.error,
            confidence: told.confidence,
            max_pairs: told.max_pairs,
            pixels: subject.pixels,
            seeds: told.seeds,
            within_tolerance: within.value().unwrap_or(0.0),
            low: within.interval().low,
            high: within.interval().high,
            mean: pool.mean(),
            median: pool.quantile(50),
            p95: pool.quantile(95),
            worst: pool.quantile(100),
            claims: claims.of,
            claims_kept: claims.value(),
            claims_low: claimed.map(|interval| interval.low),
            claims_high: claimed.map(|interval| interval.high),
            budget_hit: pool.budget_hit(),
            rays_per_pixel: pool.rays_per_pixel(),
            pairs_per_pixel: pool.pairs_per_pixel(),
            seconds,
        }
    }
}
