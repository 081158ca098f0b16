//! Measurement of a method on chosen pixels: the share of pixels within the tolerance, and the
//! share of intervals that cover the truth.
//!
//! For each seed `s = 1, …, n` the method renders all pixels with seed `s`. Gather points and VPLs
//! stay the same, and therefore the truth does too. The results are pooled over pixels and seeds
//! ([`Pool`]).
//!
//! # Guarantee
//! The same numbers for any number of threads.

use std::sync::atomic::AtomicBool;

use super::{Group, Pixels, Pool};
use crate::error::Result;
use crate::film::Film;
use crate::integrator::{ControlOptions, Setting, SumMethod};
use crate::render::Progress;
use crate::report::Tolerance;
use crate::tree::LightSet;

/// Common ground on which methods are compared.
#[derive(Clone, Copy, Debug)]
pub struct Ground<'a> {
    /// Scene, camera and gather points.
    pub setting: Setting<'a>,
    /// VPLs of the sum.
    pub lights: &'a LightSet,
    /// Pixels on which methods are run.
    pub pixels: &'a Pixels,
    /// Film of the exact sums of the pixels.
    pub reference: &'a Film,
    /// Groups of pixels whose results are also pooled separately.
    pub groups: &'a [Group],
}

/// One method with one setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Method that the cell runs.
    pub method: SumMethod,
    /// Options of the method; the seed is replaced.
    pub options: ControlOptions,
    /// Relative tolerance for judging the method.
    pub tolerance: f64,
    /// Number of times that each pixel is rendered, with the seeds 1, 2, ….
    pub seeds: u64,
}

impl Cell {
    /// One cell for each method, error and confidence. A method that states no interval has one
    /// cell for each error.
    pub fn grid(methods: &[SumMethod], errors: &[f64], confidences: &[f64], common: &Self) -> Vec<Self> {
        let mut cells = Vec::new();
        for &method in methods {
            for &error in errors {
                let cell = |confidence: f64| Self {
                    method,
                    tolerance: error,
                    options: ControlOptions { error, confidence, ..common.options },
                    ..*common
                };
                if method.states_interval() {
                    cells.extend(confidences.iter().map(|confidence| cell(*confidence)));
                } else {
                    cells.push(cell(common.options.confidence));
                }
            }
        }
        cells
    }

    /// Tolerance for judging the method.
    pub fn allowed(&self) -> Tolerance {
        Tolerance { relative: self.tolerance, absolute: self.options.absolute_error }
    }

    /// Confidence of the method, if it states an interval.
    pub fn confidence(&self) -> Option<f64> {
        self.method.states_interval().then_some(self.options.confidence)
    }
}

/// Callbacks of a run.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Called now and then with the progress, which counts trials as pixels.
    pub progress: &'a (dyn Fn(&Progress) + Sync),
    /// Cancels the run when it becomes true.
    pub cancel: &'a AtomicBool,
    /// Seconds since any moment.
    pub clock: &'a (dyn Fn() -> f64 + Sync),
}

impl Ground<'_> {
    /// Runs all seeds of a cell. Returns the pool of all pixels followed by the pool of each group,
    /// and the seconds that rendering took. `None` if cancelled.
    ///
    /// # Errors
    /// As [`Pixels::render`] and [`Pool::add`].
    pub fn run(&self, cell: &Cell, watch: &Watch<'_>) -> Result<Option<(Vec<Pool>, f64)>> {
        let mut pools = vec![Pool::new(cell.allowed()); 1 + self.groups.len()];
        let mut seconds = 0.0;
        let mut before = Progress { of: cell.seeds * self.pixels.count(), ..Progress::default() };
        for seed in 1..=cell.seeds {
            let integrator = cell.method.integrator(self.lights, &ControlOptions { seed, ..cell.options })?;
            let tell = |now: &Progress| {
                (watch.progress)(&Progress {
                    tally: before.tally + now.tally,
                    rays: before.rays + now.rays,
                    ..before
                });
            };
            let begun = (watch.clock)();
            let rendered = self.pixels.render(&self.setting, integrator.as_ref(), &tell, watch.cancel)?;
            seconds += (watch.clock)() - begun;
            if !rendered.complete {
                return Ok(None);
            }
            let references = std::iter::once(self.reference).chain(self.groups.iter().map(|g| &g.reference));
            for (pool, reference) in pools.iter_mut().zip(references) {
                pool.add(&rendered.film, reference)?;
            }
            before.tally = before.tally + rendered.totals.tally;
            before.rays += rendered.totals.rays;
        }
        Ok(Some((pools, seconds)))
    }
}
