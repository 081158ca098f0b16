//! The audit after a render: the truth of pixels at random, by exact sums or by path tracing, and
//! how many are within the tolerance.

use std::sync::atomic::AtomicBool;

use serde::Serialize;
use tashika::experiment::{Pixels, Pool, converged};
use tashika::film::Film;
use tashika::integrator::{ControlOptions, Integrator, Setting};
use tashika::report::{Claims, Tolerance};

use crate::exit::Failure;
use crate::progress::Meter;
use crate::summary::counted;

/// What an audit found.
#[derive(Debug, Serialize)]
pub struct Audit {
    /// Pixels within the tolerance.
    pub within: u64,
    /// The same, by its name in earlier versions.
    pub kept: u64,
    /// Pixels that were looked at.
    pub of: u64,
    /// Lower end of the Clopper–Pearson interval of the share.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Confidence of that interval.
    pub confidence: f64,
    /// Largest relative error found; none if infinite.
    pub worst: f64,
    /// Of the pixels that were looked at, those that claim something within their budget.
    pub claiming: u64,
    /// Of these, pixels within the tolerance.
    pub claiming_within: u64,
    /// Whether these are fewer than the confidence of the claims allows: the whole interval of
    /// their share is below it. Where nothing is claimed, nothing is contradicted.
    pub contradicts: bool,
}

/// What is audited.
pub struct Subject<'a> {
    /// What was rendered.
    pub film: &'a Film,
    /// Rays and gather points.
    pub setting: Setting<'a>,
    /// What tells the truth.
    pub truth: Box<dyn Integrator + 'a>,
    /// What was promised.
    pub promise: ControlOptions,
}

/// Paths at which the truth of a pixel is given up, if nobody says otherwise.
pub const MOST_PATHS: u32 = 1 << 20;

/// Audits `count` pixels; none if interrupted.
pub fn audit(
    count: u64,
    subject: &Subject<'_>,
    meter: &Meter,
    cancel: &AtomicBool,
) -> Result<Option<Audit>, Failure> {
    let Subject { film, setting, truth, promise: options } = subject;
    // Of a small image all pixels are enough: a refusal would come after the work.
    let count = count.min(film.window().area());
    // Pixels are drawn apart from anything that the render has drawn.
    let pixels = Pixels::of(film.window(), Some(count), options.seed.wrapping_add(0x5eed))?;
    meter.phase(&format!("audit by {}: {}", truth.name(), counted(pixels.count(), "pixel", "pixels")));
    let exact = pixels.render(setting, truth.as_ref(), &|p| meter.update(p), cancel)?;
    if !exact.complete {
        return Ok(None);
    }
    let tolerance = Tolerance { relative: options.error, absolute: options.absolute_error };
    let mut pool = Pool::new(tolerance);
    // The truth is a film of the whole image.
    pool.add(film, &converged(&exact.film.cropped(film.window())?, &tolerance))?;
    let (share, claiming) = (pool.within(), pool.claiming_within());
    let interval = share.interval();
    Ok(Some(Audit {
        within: share.count,
        kept: share.count,
        of: share.of,
        low: interval.low,
        high: interval.high,
        confidence: Claims::CONFIDENCE,
        worst: pool.quantile(100),
        claiming: claiming.of,
        claiming_within: claiming.count,
        contradicts: claiming.of > 0 && claiming.interval().high < options.confidence,
    }))
}
