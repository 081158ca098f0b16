//! What one set of VPLs is worth: by how much another, traced with another seed, would change the picture.

use std::sync::atomic::AtomicBool;

use serde::Serialize;
use tashika::experiment::{Pixels, Pool};
use tashika::film::Film;
use tashika::integrator::{Integrator, Setting};
use tashika::report::Tolerance;

use crate::exit::Failure;
use crate::progress::Meter;
use crate::summary::counted;

/// Pixels that are rendered with the other set.
const PIXELS: u64 = 64;

/// How pixels at random differ between two sets.
#[derive(Debug, Serialize)]
pub struct OtherSet {
    /// How many pixels were held against each other.
    pub pixels: u64,
    /// Median of their relative differences.
    pub median: f64,
    /// What one in ten of them exceeds.
    pub one_in_ten: f64,
}

/// Renders pixels at random of a finished film with another set of lights; none if interrupted.
///
/// * `integrator`: the film's, on the other set.
/// * `tolerance`: that of both estimates.
pub fn differ(
    film: &Film,
    setting: &Setting<'_>,
    integrator: &dyn Integrator,
    tolerance: Tolerance,
    meter: &Meter,
    cancel: &AtomicBool,
) -> Result<Option<OtherSet>, Failure> {
    let count = PIXELS.min(film.window().area());
    let pixels = Pixels::of(film.window(), Some(count), setting.view.seed.wrapping_add(0x07e5))?;
    meter.phase(&format!("another set of VPLs: {}", counted(pixels.count(), "pixel", "pixels")));
    // The progress that is told is that of the picture.
    let other = pixels.render(setting, integrator, &|_| (), cancel)?;
    if !other.complete {
        return Ok(None);
    }
    let mut pool = Pool::new(tolerance);
    pool.add(film, &other.film.cropped(film.window())?)?;
    Ok(Some(OtherSet { pixels: pool.trials(), median: pool.quantile(50), one_in_ten: pool.quantile(90) }))
}
