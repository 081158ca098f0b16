//! How often a method keeps to its tolerance and to its own intervals, measured on chosen pixels.
//!
//! For each seed `s = 1, …, n` the method renders all pixels with seed `s`; gather points and VPLs,
//! and with them the truth, stay the same. What comes of it is pooled over pixels and seeds
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

/// What methods are held against each other on.
#[derive(Clone, Copy, Debug)]
pub struct Ground<'a> {
    /// The world and the gather points.
    pub setting: Setting<'a>,
    /// The VPLs.
    pub lights: &'a LightSet,
    /// The pixels.
    pub pixels: &'a Pixels,
    /// Their exact sums.
    pub reference: &'a Film,
    /// Groups of them that are told of by themselves, too.
    pub groups: &'a [Group],
}

/// One method with one setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// The method.
    pub method: SumMethod,
    /// What it is told; the seed is replaced.
    pub options: ControlOptions,
    /// Relative tolerance by which it is judged.
    pub tolerance: f64,
    /// Times that each pixel is rendered, with the seeds 1, 2, ….
    pub seeds: u64,
}

impl Cell {
    /// One cell for each method, error and confidence; methods that state no interval take no
    /// confidence.
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

    /// What it is judged by.
    pub fn allowed(&self) -> Tolerance {
        Tolerance { relative: self.tolerance, absolute: self.options.absolute_error }
    }

    /// The confidence that it is told, if it states an interval.
    pub fn confidence(&self) -> Option<f64> {
        self.method.states_interval().then_some(self.options.confidence)
    }
}

/// Whom a run tells of itself, and listens to.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Called now and then, with trials for pixels.
    pub progress: &'a (dyn Fn(&Progress) + Sync),
    /// When it becomes true, nothing more is begun.
    pub cancel: &'a AtomicBool,
    /// Seconds since any moment.
    pub clock: &'a (dyn Fn() -> f64 + Sync),
}

impl Ground<'_> {
    /// Runs all seeds of a cell: what they say together, first of all pixels, then of each group;
    /// and the seconds that rendering took. Nothing if it was cancelled.
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
