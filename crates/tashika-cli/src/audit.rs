//! The audit after a render: exact sums of pixels at random, and how many are within the tolerance.

use std::sync::atomic::AtomicBool;

use serde::Serialize;
use tashika::experiment::{Pixels, Pool};
use tashika::film::{Film, Window};
use tashika::integrator::{ControlOptions, Exact, Setting};
use tashika::report::{Claims, Tolerance};
use tashika::vpl::VplSet;

use crate::exit::Failure;
use crate::progress::Meter;
use crate::summary::counted;

/// What an audit found.
#[derive(Debug, Serialize)]
pub struct Audit {
    /// Pixels within the tolerance.
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
    /// Whether the whole interval is below the confidence of the claim.
    pub contradicts: bool,
}

/// What is audited.
pub struct Subject<'a> {
    /// What was rendered.
    pub film: &'a Film,
    /// The part of the image that it is.
    pub window: Window,
    /// Rays and gather points.
    pub setting: Setting<'a>,
    /// Lights.
    pub set: &'a VplSet,
    /// What was promised.
    pub options: ControlOptions,
}

/// Audits `count` pixels; none if interrupted.
pub fn audit(
    count: u64,
    subject: &Subject<'_>,
    meter: &Meter,
    cancel: &AtomicBool,
) -> Result<Option<Audit>, Failure> {
    let Subject { film, window, setting, set, options } = subject;
    // Pixels are drawn apart from anything that the render has drawn.
    let pixels = Pixels::of(*window, Some(count), options.seed.wrapping_add(0x5eed))?;
    meter.phase(&format!("audit: exact sums of {}", counted(pixels.count(), "pixel", "pixels")));
    let exact = pixels.render(setting, &Exact::new(set), &|p| meter.update(p), cancel)?;
    if !exact.complete {
        return Ok(None);
    }
    let mut pool = Pool::new(Tolerance { relative: options.error, absolute: options.absolute_error });
    let comparison = pool.add(film, &exact.film)?;
    let share = pool.within();
    let interval = share.interval();
    Ok(Some(Audit {
        kept: share.count,
        of: share.of,
        low: interval.low,
        high: interval.high,
        confidence: Claims::CONFIDENCE,
        worst: comparison.worst,
        contradicts: interval.high < options.confidence,
    }))
}
