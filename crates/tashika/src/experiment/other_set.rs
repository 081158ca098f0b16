//! Effect of the choice of one set of VPLs: some pixels are rendered again with another set, traced
//! with another seed, and compared.

use std::sync::atomic::AtomicBool;

use serde::Serialize;

use super::{Pixels, Pool};
use crate::error::Result;
use crate::film::Film;
use crate::integrator::{ControlOptions, Setting, SumMethod};
use crate::report::{Tolerance, percent_of_error};
use crate::rng::{self, Purpose};
use crate::tree::LightSet;
use crate::vpl::{VplOptions, VplSet};

/// Pixels that are rendered with the other set.
const PIXELS: u64 = 64;
/// Offset added to the seed for drawing these pixels.
const SEED: u64 = 0x07e5;

/// Differences of random pixels between two sets.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OtherSet {
    /// Number of pixels that were compared.
    pub pixels: u64,
    /// Median of the relative differences.
    pub median: f64,
    /// Relative difference that one in ten pixels exceeds.
    pub one_in_ten: f64,
}

impl OtherSet {
    /// Renders random pixels of a finished film with a set of equally many VPLs, traced with
    /// another seed; `None` if cancelled.
    ///
    /// * `method`, `options`: the film's; `lights`: options by which its VPLs were traced.
    ///
    /// # Errors
    /// Options out of range.
    pub fn of(
        film: &Film,
        setting: &Setting<'_>,
        method: SumMethod,
        options: &ControlOptions,
        lights: &VplOptions,
        cancel: &AtomicBool,
    ) -> Result<Option<Self>> {
        let lights = VplOptions { seed: rng::key(lights.seed, Purpose::Replicate, 0), ..lights.clone() };
        let lights = LightSet::new(VplSet::trace(setting.tracer, &lights)?);
        let integrator = method.integrator(&lights, options)?;
        let count = PIXELS.min(film.window().area());
        let pixels = Pixels::of(film.window(), Some(count), setting.view.seed.wrapping_add(SEED))?;
        let other = pixels.render(setting, integrator.as_ref(), &|_| (), cancel)?;
        if !other.complete {
            return Ok(None);
        }
        let mut pool = Pool::new(Tolerance { relative: options.error, absolute: options.absolute_error });
        pool.add(film, &other.film.cropped(film.window())?)?;
        Ok(Some(Self { pixels: pool.trials(), median: pool.quantile(50), one_in_ten: pool.quantile(90) }))
    }

    /// Description for people.
    pub fn words(&self) -> String {
        let [median, one_in_ten] = [self.median, self.one_in_ten].map(percent_of_error);
        format!(
            "as many others change a pixel by {median} in the median, one in ten by more than {one_in_ten} (of {} at random)",
            self.pixels
        )
    }
}
