//! Audit of a render: computes the truth of random pixels, and counts the pixels within the
//! tolerance.

use serde::Serialize;

use super::observer::{Observer, Phase, during};
use crate::error::Result;
use crate::experiment::{Pixels, Pool, converged};
use crate::film::{Film, Metadata, keys};
use crate::integrator::{ControlOptions, Integrator, Setting};
use crate::report::{Claims, Tolerance};

/// Result of an audit of random pixels.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Audit {
    /// Number of audited pixels within the tolerance.
    pub within: u64,
    /// Equal to `within`, under the name of earlier versions.
    pub kept: u64,
    /// Number of pixels that were audited.
    pub of: u64,
    /// Lower end of the Clopper–Pearson interval of the share within the tolerance.
    pub low: f64,
    /// Upper end of that interval.
    pub high: f64,
    /// Confidence of that Clopper–Pearson interval.
    pub confidence: f64,
    /// Largest relative error found; none if infinite.
    pub worst: f64,
    /// Number of audited pixels that claim something within their budget.
    pub claiming: u64,
    /// Number of claiming pixels within the tolerance.
    pub claiming_within: u64,
    /// True if too few claiming pixels are within the tolerance: the whole Clopper–Pearson interval
    /// of their share is below the confidence of the claims. False if nothing is claimed.
    pub contradicts: bool,
}

impl Audit {
    /// Largest number of paths for the truth of one pixel.
    pub const MOST_PATHS: u32 = 1 << 20;

    /// Writes the result to a film's metadata.
    pub fn describe(&self, metadata: &mut Metadata) {
        metadata.set(keys::AUDIT_WITHIN, self.within);
        metadata.set(keys::AUDIT_KEPT, self.within);
        metadata.set(keys::AUDIT_OF, self.of);
    }
}

/// Audits `count` pixels; `None` if cancelled.
pub(super) fn of(
    film: &Film,
    count: u64,
    setting: &Setting<'_>,
    truth: &dyn Integrator,
    promise: &ControlOptions,
    observer: &dyn Observer,
) -> Result<Option<Audit>> {
    // In an image of fewer pixels, all are audited: an error would come after the work of
    // rendering.
    let count = count.min(film.window().area());
    // The draw of the pixels is independent of all random numbers of the render.
    let pixels = Pixels::of(film.window(), Some(count), promise.seed.wrapping_add(0x5eed))?;
    let phase = Phase::Audit { by: truth.name(), pixels: pixels.count() };
    let known = during(observer, phase, || {
        pixels.render(setting, truth, &|p| observer.progress(p), observer.cancel())
    })?;
    if !known.complete {
        return Ok(None);
    }
    let tolerance = Tolerance { relative: promise.error, absolute: promise.absolute_error };
    let mut pool = Pool::new(tolerance);
    // The truth is a film of the whole image, so it is cropped to the window.
    pool.add(film, &converged(&known.film.cropped(film.window())?, &tolerance))?;
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
        contradicts: claiming.of > 0 && claiming.interval().high < promise.confidence,
    }))
}
