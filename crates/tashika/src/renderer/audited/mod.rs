//! A picture that is refined until its audit passes. It is reconstructed, and the claim is about
//! the picture as a whole.
//!
//! ```text
//! passes (work doubles) ── reconstruction ─► picture ── look ─► reached? ── yes ─► PictureClaim
//!                ▲                                       no │
//!                └──────────────────────────────────────────┘
//! ```
//!
//! The schedule of pictures is fixed beforehand by the view, the lights, the seed and the time
//! limit or the number of passes, if there is one. The audit decides only where to stop. A picture
//! has an interim analysis if it is predicted to be good enough, and the last picture always has
//! one; at most [`AuditTerms::PICTURES`] pictures have one, two with a time limit, and one with a
//! number of passes. If pictures are expensive, [more pixels](AuditTerms::more_pixels) are audited.
//! The possible analyses are fixed along with the pictures (`looks`), and each has an equal share
//! of the risk. The result is always valid: either a certificate, or the share that is certain to
//! be within the error.
//!
//! The film also has a map of half-widths: the errors predicted by the reconstruction, multiplied
//! by one factor. The factor is the ratio of error to prediction that has a certain
//! [rank](AuditTerms::rank) among the audited pixels. With the confidence of the certificate, the
//! requested share of the pixels is then within their half-widths. There is no map if too few
//! pixels are audited for a rank, or if the truth of the pixel of that rank is unknown, for example
//! because time was short. Half-widths are then NaN, and no pixel claims anything. A separate
//! factor for each of two groups of pixels, divided by brightness or by predicted error, would
//! widen the map by 8 to 34 %: with so few pixels in a group, the rank is that of the group's
//! largest ratio.
//!
//! The paths of the picture draw VPLs, or a pilot finds that paths alone take less work
//! ([`Works`]). The audit draws VPLs in either case, since VPLs carry light that paths rarely meet.
//! Some scenes need paths alone, for both. A share of
//! the tiles, for one of several machines, is rendered differently ([`parts`]). The picture joined
//! from such shares differs from a picture rendered as a whole, and has a single analysis.
//!
//! # Guarantee
//! With at least the stated assurance, the claim is true: among the pixels that show more than a
//! constant background in the first pass (with a number of passes, in the last one), the stated
//! share is within the error of light transport. The same holds for the map. The assumption is that
//! the interval of an audited pixel misses that pixel's truth no more often than stated
//! ([`AuditTerms::CONFIDENCE`]).
//!
//! # Held to this by
//! `stats::audit` (pictures at the edge of the claim) and the tests of `renderer::audited`; the
//! record of 2026-11-26 (audited pictures) has measurements of real scenes.

mod choice;
mod foreseen;
mod looks;
mod parts;
mod truth;
mod truths;
mod verdict;

pub use parts::finish_merged;

#[cfg(test)]
mod tests;

use std::sync::atomic::Ordering;

use super::observer::{Phase, during};
use super::{AuditedJob, Prepared};
use crate::error::Result;
use crate::film::{Claim, Film, Metadata, RenderFilm, keys};
use crate::integrator::{ControlOptions, Integrator, LightTransport, PathSampler, PathStop};
use crate::picture::Picture;
use crate::reconstruction::Reconstructed;
use crate::render::{Begun, Finished, Progress, RenderOptions, Rendered, Totals, blank};
use crate::request::AuditTerms;
use choice::Works;
use foreseen::{half_widths, importance_of, share_outside};
use looks::{Looks, can_pass, is_expensive};
use truth::Around;
use truths::{Source, Truths};
use verdict::{Analysis, Pictured, Stated, Tolerance, Verdict, count_true};

/// Largest number of paths of all pixels if there is no time limit; a picture then takes minutes.
const MOST_PATHS: u64 = 64_000_000;
/// Fewest passes without a time limit, whatever the size of the image.
const FEWEST_PASSES: u32 = 6;
/// With a time limit, smallest growth for which another pass is made: less hardly changes the
/// picture, and its time decides more pixels of the audit. Chosen.
const LEAST_GROWTH: f64 = 0.5;

/// Renders the picture. `begin` receives the film with which the render begins, and returns it.
pub(super) fn render(
    prepared: &Prepared<'_>,
    job: &AuditedJob,
    begin: impl FnOnce(Film) -> Result<Begun>,
) -> Result<Rendered> {
    let setting = prepared.setting();
    let AuditedJob { options, terms, passes, lights } = job;
    let planned = Planned { prepared, terms: *terms, passes: *passes };
    let Some(lights) = lights else { return planned.by_paths_alone(options, begin) };
    let method = LightTransport::new(&prepared.tracer, lights, options);
    let options = ControlOptions { absolute_error: method.absolute_error(), ..*options };
    let sampler = method.path_sampler(setting);
    let alone = prepared.path_tracer(PathStop::Count(1))?;
    let works = Works::measure(prepared, &sampler, &alone.path_sampler(setting), &Tolerance::to(&options));
    if works.is_some_and(|works| works.is_alone_better()) {
        return planned.by_paths_alone(&options, begin);
    }
    planned.render(&method, sampler, &options, begin)
}

/// Terms and work of a picture, before its paths are chosen.
struct Planned<'v, 'p> {
    prepared: &'v Prepared<'p>,
    terms: AuditTerms,
    /// Number of passes, if it is fixed.
    passes: Option<u32>,
}

impl<'v> Planned<'v, '_> {
    fn by_paths_alone(
        &self,
        options: &ControlOptions,
        begin: impl FnOnce(Film) -> Result<Begun>,
    ) -> Result<Rendered> {
        let stop = self.prepared.of_audited(options)?;
        let method = self.prepared.path_tracer(stop)?;
        let options = stop.options().unwrap_or(options);
        self.render(&method, method.path_sampler(self.prepared.setting()), options, begin)
    }

    /// Renders with paths of the sampler, and writes the metadata of the method.
    fn render(
        &self,
        method: &dyn Integrator,
        sampler: impl PathSampler,
        options: &ControlOptions,
        begin: impl FnOnce(Film) -> Result<Begun>,
    ) -> Result<Rendered> {
        let prepared = self.prepared;
        if !prepared.share.is_whole() {
            return parts::render(prepared, method, &sampler, options, &self.terms, begin);
        }
        let looks = match (self.passes, prepared.observer.seconds_left()) {
            (Some(_), _) => Looks::FIXED,
            (None, Some(_)) => Looks::IN_TIME,
            (None, None) => Looks::OPEN,
        };
        let terms = AuditTerms { looks: looks.most(), ..self.terms };
        let whole = RenderOptions { window: prepared.window, share: prepared.share.clone() };
        let mut film = blank(&prepared.setting(), method, &whole)?;
        describe(prepared, &terms, film.metadata_mut());
        let mut work = Work {
            prepared,
            terms,
            passes: self.passes,
            options,
            tolerance: Tolerance::to(options),
            film: begin(film)?.film,
            picture: Picture::new(sampler, prepared.window, options.seed),
            reconstructed: Reconstructed::default(),
            truths: None,
            look: None,
            looks,
            taken: 0,
        };
        work.go_on()?;
        work.finish()
    }
}

/// Writes the metadata of the audit that the integrator does not write.
fn describe(prepared: &Prepared<'_>, terms: &AuditTerms, metadata: &mut Metadata) {
    prepared.change.describe(metadata);
    if let Some(smoother) = &prepared.smoother {
        metadata.set(keys::DENOISER, smoother.name());
    }
    metadata.set(keys::CLAIM, Claim::Audited.code().name);
    metadata.set(keys::PAIRS_ARE, "paths");
    // The half-widths of the map hold for this share of the pixels.
    metadata.set(keys::CONFIDENCE, terms.share);
    metadata.set(keys::AUDIT_SHARE, terms.share);
    metadata.set(keys::AUDIT_ASSURANCE, terms.assurance);
    metadata.set(keys::AUDIT_MOST_LOOKS, terms.looks);
    for name in [keys::MAX_PAIRS, keys::PATHS_MOST] {
        metadata.remove(name);
    }
}

/// A picture in progress, and its audit.
struct Work<'p, 'v> {
    prepared: &'p Prepared<'p>,
    terms: AuditTerms,
    /// Number of passes, if it is fixed.
    passes: Option<u32>,
    options: &'p ControlOptions,
    tolerance: Tolerance,
    film: Film,
    picture: Picture<'v>,
    reconstructed: Reconstructed,
    truths: Option<Truths<'p>>,
    /// Result of the last analysis.
    look: Option<Analysis>,
    looks: Looks,
    /// Number of analyses so far.
    taken: u32,
}

impl<'p> Work<'p, '_> {
    /// Makes passes and analyses until the audit passes, no work is left, or the render is
    /// cancelled.
    fn go_on(&mut self) -> Result<()> {
        let observer = self.prepared.observer;
        let mut growth = 1.0;
        loop {
            let (before, paths) = (observer.seconds_left(), self.picture.paths());
            if !self.pass(growth)? {
                return Ok(());
            }
            let after = observer.seconds_left();
            let of_path =
                before.zip(after).map(|(a, b)| (a - b) / (self.picture.paths() - paths).max(1) as f64);
            let is_ready = self.passes.is_none_or(|fixed| self.picture.passes() >= fixed);
            if self.truths.is_none() && is_ready {
                self.truths = self.first_truths()?;
                let Some(truths) = &self.truths else { return Ok(()) };
                self.terms.population = Some(count_true(&truths.population));
            }
            // There is nothing to audit in a picture of the background alone.
            let next = if self.terms.population == Some(0) { None } else { self.growth(of_path) };
            let is_last = next.is_none();
            let is_due = is_last
                || self.passes.is_none() && self.looks.is_due(&self.terms, share_outside(&self.importance()));
            let is_reached = is_due && self.audit(is_last)?;
            match next {
                Some(next) if !is_reached => growth = next,
                _ => return Ok(()),
            }
        }
    }

    /// Computes the truths of the first audited pixels. Numbers of paths follow from the variances
    /// of the picture. `None` if cancelled.
    fn first_truths(&self) -> Result<Option<Truths<'p>>> {
        let Self { prepared, options, terms, tolerance, picture, .. } = self;
        let source = Source::of(prepared, options, tolerance)?;
        // The audit of a fixed amount of work has as many paths as the picture.
        let paths = self.passes.map(|_| picture.paths());
        let around = |pixel| Around::of(picture, pixel, &self.reconstructed.radiance, tolerance);
        Truths::compute(source, &picture.film()?, &around, terms, self.looks.extends(), paths)
    }

    /// Ratio of the paths of the next pass to all paths so far; `None` if there is no next pass.
    ///
    /// * `of_path`: time of a path (s), if there is a time limit.
    fn growth(&self, of_path: Option<f64>) -> Option<f64> {
        let passes = self.picture.passes();
        if let Some(fixed) = self.passes {
            return (passes < fixed).then_some(1.0);
        }
        if passes >= AuditTerms::MAX_PASSES {
            return None;
        }
        let Some((of_path, left)) = of_path.zip(self.prepared.observer.seconds_left()) else {
            return self.has_paths_left().then_some(1.0);
        };
        let for_truths = self.truths.as_ref().map_or(0.0, Truths::seconds_of_refinement);
        let growth = (left - for_truths) / (of_path * self.picture.paths() as f64);
        (growth >= LEAST_GROWTH).then(|| growth.min(1.0))
    }

    /// Makes one more pass, reconstructs the picture and stores it; false if cancelled.
    ///
    /// * `growth`: ratio of the paths of this pass to all paths so far.
    fn pass(&mut self, growth: f64) -> Result<bool> {
        let (window, observer) = (self.prepared.window, self.prepared.observer);
        let smoother = self.prepared.smoother.as_deref();
        let phase = Phase::Pixels { method: "paths", window, is_of_a_sum: false, promises: false };
        let by_error = (self.picture.passes() > 0).then(|| self.importance());
        if !during(observer, phase, || self.picture.pass(by_error.as_deref(), growth, observer.cancel())) {
            return Ok(false);
        }
        if by_error.is_some() {
            let squared = self.picture.squared_error(&self.reconstructed.radiance);
            let metadata = self.film.metadata_mut();
            if squared > 0.0 && squared.is_finite() {
                metadata.set(keys::ERROR_BEFORE, squared.sqrt());
            } else {
                metadata.remove(keys::ERROR_BEFORE);
            }
        }
        self.reconstructed = during(observer, Phase::Reconstruction, || self.picture.reconstruct(smoother))?;
        self.store()?;
        let tally = RenderFilm::of(&self.film).tally();
        let progress = Progress { tally, of: window.area(), rays: self.picture.rays() };
        observer.tile(&Finished { progress, film: &self.film, tile: window });
        Ok(true)
    }

    /// Returns true if the limit on paths permits another pass.
    fn has_paths_left(&self) -> bool {
        self.picture.passes() < FEWEST_PASSES || 2 * self.picture.paths() <= MOST_PATHS
    }

    /// Predicted error of each pixel over its tolerance.
    fn importance(&self) -> Vec<f32> {
        importance_of(&self.reconstructed, &self.tolerance)
    }

    /// Analyses the picture, if any analyses are left. Returns true if enough pixels are within the
    /// error.
    ///
    /// * `is_last`: true if the number of pixels outside is needed even if they are too many.
    fn audit(&mut self, is_last: bool) -> Result<bool> {
        let Some(is_first) = self.looks.begin() else { return Ok(false) };
        let most = self.most_pixels();
        if is_first {
            let of = self.audited();
            let is_reached = self.look(is_last)?;
            let outside = self.look.as_ref().map_or(0, |look| look.outside);
            if is_reached || of == most || !can_pass(&self.terms, outside, [of, most]) {
                return Ok(is_reached);
            }
        }
        let is_extended = match &mut self.truths {
            Some(truths) if most > truths.pixels.len() as u64 => truths.extend()?,
            _ => true,
        };
        Ok(is_extended && self.look(is_last)?)
    }

    /// Number of pixels that have truths.
    fn audited(&self) -> u64 {
        self.truths.as_ref().map_or(0, |truths| truths.pixels.len() as u64)
    }

    /// Most pixels of an analysis of this picture.
    fn most_pixels(&self) -> u64 {
        let is_expensive = is_expensive(&self.terms, self.picture.rays());
        let spare = self.truths.as_ref().filter(|_| is_expensive).map_or(0, Truths::spare);
        self.audited() + spare as u64
    }

    /// Makes one analysis of the picture. Returns true if enough audited pixels are within the
    /// error.
    fn look(&mut self, is_last: bool) -> Result<bool> {
        let half_widths = half_widths(&self.reconstructed, &self.tolerance);
        let (terms, of, most) = (self.terms, self.audited(), self.most_pixels());
        let decides = |outside: u64, may_be: u64| {
            terms.is_reached(may_be, of) || !(is_last || can_pass(&terms, outside, [of, most]))
        };
        let Some(truths) = &mut self.truths else { return Ok(false) };
        let (window, radiance) = (self.prepared.window, &self.reconstructed.radiance);
        truths.refine(&window, radiance, decides)?;
        let look = truths.look(&window, radiance, &half_widths);
        let is_reached = look.is_reached(&self.terms);
        self.look = Some(look);
        self.taken += 1;
        Ok(is_reached)
    }

    /// Stores the picture in the film, without a claim about any pixel.
    fn store(&mut self) -> Result<()> {
        let plain = self.picture.film()?;
        let picture = Pictured {
            plain: RenderFilm::of(&plain),
            reconstructed: &self.reconstructed,
            half_widths: &half_widths(&self.reconstructed, &self.tolerance),
        };
        self.film.metadata_mut().set(keys::PASSES, self.picture.passes());
        picture.store(&mut self.film, |_, _| Stated::NOTHING);
        Ok(())
    }

    /// Stores the claim of the last analysis in the film, with the audited pixels.
    fn store_claim(&mut self) -> Result<()> {
        let Some((truths, look)) = self.truths.as_ref().zip(self.look.as_ref()) else { return Ok(()) };
        let verdict = Verdict {
            look,
            terms: &self.terms,
            tolerance: &self.tolerance,
            population: &truths.population,
            looks: self.taken,
            passes: self.picture.passes(),
        };
        let plain = self.picture.film()?;
        let picture = Pictured {
            plain: RenderFilm::of(&plain),
            reconstructed: &self.reconstructed,
            half_widths: &half_widths(&self.reconstructed, &self.tolerance),
        };
        if truths.pixels.is_empty() {
            picture.store(&mut self.film, |k, record| verdict.unaudited(k, record));
            return Ok(());
        }
        verdict.store(&picture, &mut self.film);
        self.film.metadata_mut().set(keys::AUDIT_RAYS, truths.rays);
        truths.describe(&mut self.film);
        Ok(())
    }

    /// Returns the film with its claims.
    fn finish(mut self) -> Result<Rendered> {
        let was_cancelled = self.prepared.observer.cancel().load(Ordering::Relaxed);
        if was_cancelled && self.truths.is_some() {
            self.audit(true)?;
        }
        self.store_claim()?;
        let complete = !was_cancelled && self.look.is_some();
        let mut film = self.film;
        film.metadata_mut().set(keys::COMPLETE, complete);
        let totals = Totals::of(&film);
        Ok(Rendered { film, complete, totals })
    }
}
