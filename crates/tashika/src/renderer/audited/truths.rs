//! Random pixels of a picture, and their truths.
//!
//! # Independence
//! Truths are computed from separate lights, gather points and random numbers ([`Purpose::Audit`]).
//! They use nothing of the picture except the variance of its paths ([`Around`]).

use super::truth::{Around, FEWEST_PATHS, STAGES, Truth};
use super::verdict::{Analysis, AuditedPixel, Tolerance, describe, luminance_at, outside, shown};
use crate::color::Rgb;
use crate::error::Result;
use crate::film::{Film, Window};
use crate::gather::View;
use crate::integrator::{
    ControlOptions, GuidedLights, LightTransport, PathSampler, PathStop, PathTracer, Setting,
};
use crate::picture::{Wanted, paths_of};
use crate::render::Progress;
use crate::renderer::Prepared;
use crate::renderer::observer::{Observer, Phase, during};
use crate::request::AuditTerms;
use crate::rng::{self, Purpose, Stream};
use crate::vpl::VplOptions;

/// Share of the remaining time that truths may take. Chosen.
const SHARE_OF_TIME: f64 = 0.25;
/// Assumed ratio of the time of all stages to the time of the first. Chosen.
const STAGES_COST: f64 = 4.0;
/// Smallest number of pixels of an audit, even if time is short. Their time predicts that of more.
const FEWEST: usize = 32;
/// Number of VPLs that truths are drawn from.
const VPLS: u64 = 500_000;
/// Number of these VPLs if there is a time limit. Intervals include the variance between sets.
const VPLS_IN_TIME: u64 = 150_000;

/// The audited pixels of a picture.
pub(super) struct Truths<'p> {
    source: Source<'p>,
    truths: Vec<Truth>,
    /// Audited pixels, with their intervals.
    pub pixels: Vec<AuditedPixel>,
    /// Pixels that were drawn together with the audited ones and are not audited yet.
    spare: Vec<Truth>,
    /// For each pixel of the window, row by row: true if it is of the population that audited
    /// pixels were drawn from.
    pub population: Vec<bool>,
    pub rays: u64,
    /// Time of the first stage (s), if there is a time limit.
    seconds: f64,
    /// Number of paths that further stages may have, if the work is fixed.
    paths_left: Option<u64>,
}

/// Origin of truths: sampler, options and tolerance.
pub(super) struct Source<'p> {
    setting: Setting<'p>,
    options: ControlOptions,
    pub tolerance: Tolerance,
    /// VPLs to draw from; `None` if truths are found by path tracing.
    lights: Option<GuidedLights>,
    observer: &'p dyn Observer,
}

impl<'p> Source<'p> {
    /// Most stages of a truth.
    pub const STAGES: usize = STAGES.len();

    /// Returns a source with lights, gather points and random numbers that the picture does not
    /// use.
    ///
    /// * `options`: options of the picture.
    pub fn of(prepared: &'p Prepared<'p>, options: &ControlOptions, tolerance: &Tolerance) -> Result<Self> {
        let (setting, observer) = (prepared.setting(), prepared.observer);
        let seed = seed_of(options.seed);
        let setting = Setting { view: View { seed, ..setting.view }, ..setting };
        let count = if observer.seconds_left().is_some() { VPLS_IN_TIME } else { VPLS };
        let lights = VplOptions { count, seed, ..VplOptions::default() };
        let traced = || {
            during(observer, Phase::Vpls { count }, || {
                GuidedLights::to_audit(setting.tracer, &lights, &setting.view)
            })
        };
        let lights = prepared.job.provenance().is_some().then(traced).transpose()?;
        let options = ControlOptions { seed, ..*options };
        Ok(Self { setting, options, tolerance: *tolerance, lights, observer })
    }

    /// Calls `work` with the sampler of paths for truths.
    pub fn with_sampler<T>(&self, work: impl FnOnce(&dyn PathSampler) -> Result<T>) -> Result<T> {
        let Self { setting, options, lights, .. } = self;
        match lights {
            Some(lights) => {
                work(&LightTransport::new(setting.tracer, lights, options).path_sampler(*setting))
            }
            None => {
                let depth = VplOptions::default().path_depth();
                let method = PathTracer::new(setting.tracer, PathStop::Count(1), depth)?;
                work(&method.path_sampler(*setting))
            }
        }
    }

    /// Computes the next stage of the given truths, which must all be at the same stage; false if
    /// cancelled.
    ///
    /// * `sampler`: sampler of [paths for truths](Self::with_sampler); `tell`: receives progress.
    pub fn advance(
        &self,
        truths: &mut [&mut Truth],
        sampler: &dyn PathSampler,
        tell: &(dyn Fn(&Progress) + Sync),
    ) -> bool {
        let Some(first) = truths.first() else { return true };
        // The key 0 belongs to the draw of the pixels.
        let seed = rng::key(self.options.seed, Purpose::Audit, 1 + first.stage as u64);
        let wanted: Vec<Wanted> = truths.iter().map(|truth| self.wanted(truth, sampler)).collect();
        let cancel = self.observer.cancel();
        let Some(found) = paths_of(sampler, &wanted, seed, tell, cancel) else { return false };
        for (truth, found) in truths.iter_mut().zip(found) {
            truth.advance(found);
        }
        true
    }

    /// Creates a sampler, computes the next stage, and reports it as a phase of the work.
    fn told(&self, truths: &mut [&mut Truth]) -> Result<bool> {
        let by = if self.lights.is_some() { "paths by other lights" } else { "other paths" };
        let phase = Phase::Audit { by, pixels: truths.len() as u64 };
        let tell = |progress: &Progress| self.observer.progress(progress);
        let told = |sampler: &dyn PathSampler| Ok(self.advance(truths, sampler, &tell));
        during(self.observer, phase, || self.with_sampler(told))
    }

    /// Number of these truths, in their order, whose next stages have at most `most` paths in all,
    /// and the number of these paths.
    fn affordable<'t>(&self, truths: impl Iterator<Item = &'t Truth>, most: u64) -> Result<(usize, u64)> {
        self.with_sampler(|sampler| {
            let (mut count, mut paths) = (0, 0);
            for truth in truths {
                let wanted = u64::from(self.wanted(truth, sampler).paths);
                if paths + wanted > most {
                    break;
                }
                (count, paths) = (count + 1, paths + wanted);
            }
            Ok((count, paths))
        })
    }

    /// Number of paths of the next stage of these truths.
    fn paths<'t>(&self, truths: impl Iterator<Item = &'t Truth>) -> Result<u64> {
        self.with_sampler(|sampler| {
            Ok(truths.map(|truth| u64::from(self.wanted(truth, sampler).paths)).sum())
        })
    }

    fn wanted(&self, truth: &Truth, sampler: &dyn PathSampler) -> Wanted {
        truth.wanted(&self.tolerance, FEWEST_PATHS.max(sampler.telling()))
    }
}

/// Seed of a picture's audit.
pub(super) fn seed_of(picture: u64) -> u64 {
    rng::key(picture, Purpose::Audit, 0)
}

impl<'p> Truths<'p> {
    /// Draws pixels of a film and computes their truths; `None` if cancelled.
    ///
    /// With a time limit, the number of pixels is chosen so that all stages of their truths are
    /// predicted to take a given [share](SHARE_OF_TIME) of the remaining time; with a number of
    /// paths, so that they are predicted to take these. The prediction uses the mean number of
    /// paths of all drawn pixels, and the time of a path: the pixels that are audited then are the
    /// first ones of a random order, whatever they cost.
    ///
    /// * `film`: the picture without its reconstruction; `around`: estimates about the paths of a
    ///   pixel; `extends`: true if more pixels may be audited later; `paths`: number of paths of
    ///   all stages, if the work is fixed.
    pub fn compute(
        source: Source<'p>,
        film: &Film,
        around: &dyn Fn([u32; 2]) -> Around,
        terms: &AuditTerms,
        extends: bool,
        paths: Option<u64>,
    ) -> Result<Option<Self>> {
        let population = shown(film);
        let pixels = film.window().pixels().zip(&population);
        let shown: Vec<[u32; 2]> =
            pixels.filter(|(_, is_shown)| **is_shown).map(|((x, y), _)| [x, y]).collect();
        let before = source.observer.seconds_left();
        let all = shown.len() as u64;
        let [count, more] = [terms.pixels, terms.more_pixels()].map(|pixels| pixels.min(all));
        let with_spare = if extends { more } else { count };
        let chosen = drawn(shown, with_spare, source.options.seed);
        let mut truths: Vec<Truth> = chosen.into_iter().map(|at| Truth::new(at, around(at))).collect();
        let spare = truths.split_off(count as usize);
        let spare = if extends { spare } else { Vec::new() };
        let mean_paths = source.paths(truths.iter())? as f64 / truths.len().max(1) as f64;
        if let Some(paths) = paths {
            let count = (paths as f64 / (STAGES_COST * mean_paths.max(1.0))) as usize;
            truths.truncate(count.max(FEWEST));
        }
        let first_paths = source.paths(truths.iter())?;
        if let Some(before) = before {
            let tried = FEWEST.min(truths.len());
            if !source.told(&mut truths[..tried].iter_mut().collect::<Vec<_>>())? {
                return Ok(None);
            }
            let seconds = before - source.observer.seconds_left().unwrap_or(0.0);
            let tried_paths: u64 = truths[..tried].iter().map(Truth::paths).sum();
            let of_path = seconds.max(f64::MIN_POSITIVE) / tried_paths.max(1) as f64;
            let count = (SHARE_OF_TIME * before / (STAGES_COST * of_path * mean_paths)) as usize;
            truths.truncate(count.max(tried));
        }
        let mut others: Vec<&mut Truth> = truths.iter_mut().filter(|truth| truth.stage == 0).collect();
        if !others.is_empty() && !source.told(&mut others)? {
            return Ok(None);
        }
        let paths_left = paths.map(|paths| paths.saturating_sub(first_paths));
        let seconds = before.zip(source.observer.seconds_left());
        let seconds = seconds.map_or(0.0, |(before, after)| before - after);
        let pixels = truths.iter().map(|truth| truth.audited(&source.tolerance)).collect();
        let rays = truths.iter().map(Truth::rays).sum();
        Ok(Some(Self { source, truths, pixels, spare, population, rays, seconds, paths_left }))
    }

    /// Audits [more pixels](AuditTerms::more_pixels), if they are not audited already; false if
    /// cancelled.
    pub fn extend(&mut self) -> Result<bool> {
        if self.spare.is_empty() {
            return Ok(true);
        }
        if !self.source.told(&mut self.spare.iter_mut().collect::<Vec<_>>())? {
            return Ok(false);
        }
        self.rays += self.spare.iter().map(Truth::rays).sum::<u64>();
        self.pixels.extend(self.spare.iter().map(|truth| truth.audited(&self.source.tolerance)));
        self.truths.append(&mut self.spare);
        Ok(true)
    }

    /// Number of pixels that are drawn and not audited yet.
    pub fn spare(&self) -> usize {
        self.spare.len()
    }

    /// VPLs that truths are drawn from.
    #[cfg(test)]
    pub fn lights(&self) -> &GuidedLights {
        self.source.lights.as_ref().expect("they are drawn from lights")
    }

    /// Approximate time of refining all truths (s), if there is a time limit.
    pub fn seconds_of_refinement(&self) -> f64 {
        (STAGES_COST - 1.0) * self.seconds
    }

    /// Refines the truths of pixels that may be on either side of the tolerance, stage by stage;
    /// false if cancelled. With a time limit, or a number of paths, only as many are refined as it
    /// is predicted to allow. Pixels that stay open count as outside.
    ///
    /// * `radiance`: of the window's pixels, row by row.
    /// * `decides`: returns true if the outcome of the audit is decided, given the number of pixels
    ///   that are certainly outside and the number that may be.
    pub fn refine(
        &mut self,
        window: &Window,
        radiance: &[Rgb],
        decides: impl Fn(u64, u64) -> bool,
    ) -> Result<bool> {
        let mut of_one = self.seconds / self.pixels.len() as f64;
        for stage in 1..STAGES.len() {
            let all: Vec<usize> =
                (0..self.pixels.len()).filter(|k| self.is_open(*k, window, radiance)).collect();
            let may_be = outside(&self.pixels, &self.source.tolerance, window, radiance);
            if decides(may_be - all.len() as u64, may_be) {
                break;
            }
            let mut open: Vec<usize> = all.into_iter().filter(|k| self.truths[*k].stage == stage).collect();
            of_one *= f64::from(STAGES[stage].most_paths) / f64::from(STAGES[stage - 1].most_paths);
            if let Some(left) = self.source.observer.seconds_left() {
                open.truncate((left / of_one) as usize);
            }
            if let Some(left) = self.paths_left {
                let (count, paths) = self.source.affordable(open.iter().map(|k| &self.truths[*k]), left)?;
                open.truncate(count);
                self.paths_left = Some(left - paths);
            }
            let rays = |truths: &[Truth]| open.iter().map(|k| truths[*k].rays()).sum::<u64>();
            let before = rays(&self.truths);
            let is_chosen = |k: &usize| open.binary_search(k).is_ok();
            let chosen = self.truths.iter_mut().enumerate().filter(|(k, _)| is_chosen(k));
            let mut chosen: Vec<&mut Truth> = chosen.map(|(_, truth)| truth).collect();
            if chosen.is_empty() {
                continue;
            }
            if !self.source.told(&mut chosen)? {
                return Ok(false);
            }
            self.rays += rays(&self.truths) - before;
            for k in open {
                self.pixels[k] = self.truths[k].audited(&self.source.tolerance);
            }
        }
        Ok(true)
    }

    fn is_open(&self, k: usize, window: &Window, radiance: &[Rgb]) -> bool {
        let truth = &self.pixels[k];
        truth.is_open(luminance_at(truth.pixel, window, radiance), &self.source.tolerance)
    }

    /// Analyses a picture by the truths.
    ///
    /// * `radiance`, `half_widths`: of the window's pixels, row by row.
    pub fn look(&self, window: &Window, radiance: &[Rgb], half_widths: &[f64]) -> Analysis {
        Analysis::at(&self.pixels, &self.source.tolerance, window, radiance, half_widths)
    }

    /// Adds the plane of the audited pixels to a film.
    pub fn describe(&self, film: &mut Film) {
        describe(&self.pixels, &self.source.tolerance, film);
    }
}

/// Draws `count` of these pixels at random, each subset with equal probability.
pub(super) fn drawn(mut pixels: Vec<[u32; 2]>, count: u64, seed: u64) -> Vec<[u32; 2]> {
    let mut stream = Stream::new(seed, Purpose::Audit, 0);
    for k in 0..count as usize {
        let other = k + stream.below((pixels.len() - k) as u64) as usize;
        pixels.swap(k, other);
    }
    pixels.truncate(count as usize);
    pixels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_drawn_as_often_as_another_and_none_twice() {
        let pixels: Vec<[u32; 2]> = (0..10).map(|x| [x, 0]).collect();
        let mut counts = [0u32; 10];
        for seed in 0..3000 {
            let chosen = drawn(pixels.clone(), 4, seed);
            let mut sorted = chosen.clone();
            sorted.sort_unstable();
            sorted.dedup();
            assert_eq!(sorted.len(), 4);
            chosen.iter().for_each(|[x, _]| counts[*x as usize] += 1);
        }
        // Binomial of mean 1200 and standard deviation 27.
        assert!(counts.iter().all(|count| count.abs_diff(1200) < 5 * 27), "{counts:?}");
    }
}
