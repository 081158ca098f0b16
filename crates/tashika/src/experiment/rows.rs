//! Stored results of one cell of an experiment.

use serde::Serialize;

use super::{Cell, Pool};

/// Scene, sum and pixels that a cell was run on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subject {
    /// Name of the scene that was rendered.
    pub scene: String,
    /// Number of VPLs in the sum.
    pub vpls: u64,
    /// Number of gather points a pixel.
    pub gather: u32,
    /// Number of pixels compared with their exact sums.
    pub pixels: u64,
    /// Common property of the pixels, if they are a group.
    pub group: Option<&'static str>,
}

/// Results of one cell. Shares are in 0 to 1, errors relative; infinite errors become `null` in
/// JSON. All counts and means are over the trials: `pixels` times `seeds`.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Name of the method that was run.
    pub method: &'static str,
    /// Name of the scene that was rendered.
    pub scene: String,
    /// Common property of the pixels, if they are a group.
    pub group: Option<&'static str>,
    /// Number of VPLs in the sum.
    pub vpls: u64,
    /// Number of gather points a pixel.
    pub gather: u32,
    /// Relative tolerance for judging the method.
    pub error: f64,
    /// Relative error that the method received.
    pub method_error: f64,
    /// Confidence that the method received, if it states an interval.
    pub confidence: Option<f64>,
    /// Largest cut that the method received, if not its own default.
    pub max_pairs: Option<u64>,
    /// Number of pixels that were compared.
    pub pixels: u64,
    /// Number of times that each pixel was rendered.
    pub seeds: u64,
    /// Share of the trials within the tolerance.
    pub within_tolerance: f64,
    /// Lower end of the Clopper–Pearson interval of `within_tolerance`, at 95 %.
    pub low: f64,
    /// Upper end of the interval of `within_tolerance`.
    pub high: f64,
    /// Mean of the finite errors.
    pub mean: f64,
    /// Error that half of the trials do not exceed.
    pub median: f64,
    /// Error that 95 % of the trials do not exceed.
    pub p95: f64,
    /// Largest error of a trial.
    pub worst: f64,
    /// Number of trials that claimed an interval.
    pub claims: u64,
    /// Share of the claims whose interval covers the exact sum; `None` without claims.
    pub claims_kept: Option<f64>,
    /// Lower end of the Clopper–Pearson interval of `claims_kept`, at 95 %.
    pub claims_low: Option<f64>,
    /// Upper end of the interval of `claims_kept`.
    pub claims_high: Option<f64>,
    /// Number of trials that ran out of budget.
    pub budget_hit: u64,
    /// Mean number of rays of a trial.
    pub rays_per_pixel: f64,
    /// Mean number of pairs of a trial.
    pub pairs_per_pixel: f64,
    /// Seconds that the method took for all of its renders.
    pub seconds: f64,
}

/// Method of a run, with its options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    /// Name of the method that was run.
    pub method: &'static str,
    /// Relative tolerance for judging the method.
    pub tolerance: f64,
    /// Relative error that the method received.
    pub error: f64,
    /// Confidence that the method received, if it states an interval.
    pub confidence: Option<f64>,
    /// Largest cut that the method received.
    pub max_pairs: Option<u64>,
    /// Number of times that each pixel was rendered.
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
    /// Returns the row of a run on a subject, which took `seconds`.
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
