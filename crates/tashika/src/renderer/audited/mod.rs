//! A picture that is made until an audit is content: reconstructed, and claimed as a whole.
//!
//! ```text
//! passes (work doubles) ── reconstruction ─► picture ── look ─► reached? ── yes ─► PictureClaim
//!                ▲                                       no │
//!                └──────────────────────────────────────────┘
//! ```
//!
//! The schedule of pictures is fixed beforehand by the view, the lights, the seed and, if there is an
//! end of it, the time: what the audit finds says only where to stop. A picture is looked at where it
//! is foreseen to be good enough, at most [`AuditTerms::PICTURES`] times, the last at the end whatever
//! is foreseen. Where pictures are dear, [more pixels](AuditTerms::more_pixels) are audited. Which looks
//! there can be is fixed with the pictures (`looks`), and each has an equal share of the risk. So there
//! is always an answer: a certificate, or the share that is certain.
//!
//! Whatever was reached, the map of half-widths is what the reconstruction foresees of its own
//! error, scaled by the [rank](AuditTerms::rank) of the audited pixels' ratios: as sure as the
//! certificate, the asked-for share of the pixels is within theirs. A rank for each of two groups of
//! pixels, by brightness or by what is foreseen, would widen the map by 8 to 34 %: so few pixels in a
//! group have their largest ratio for the rank.
//!
//! The picture is made of paths by what VPLs tell or, if the scene needs paths, by path tracing alone.
//!
//! # Guarantee
//! With at least the assurance, what is claimed is true: of the pixels that show more than a constant
//! background, the share is within the error of light transport; and so for the map. Assumed is that
//! an interval of an audited pixel's own truth misses it no more often than it says
//! ([`AuditTerms::CONFIDENCE`]).
//!
//! # Held to this by
//! `stats::audit` (pictures at the edge of the claim) and the tests of `renderer::audited`; the record
//! of 2026-11-26 (audited pictures) has pictures of real scenes.

mod looks;
mod truths;

pub(super) use truths::by_paths;

#[cfg(test)]
mod tests;

use std::sync::atomic::Ordering;

use super::observer::{Phase, during};
use super::{Lights, Prepared};
use crate::color::Rgb;
use crate::error::Result;
use crate::film::{Claim, Film, Metadata, PictureClaim, PixelRecord, RenderFilm, Stop, keys};
use crate::integrator::{ControlOptions, Integrator, LightTransport, SamplePaths};
use crate::math::elementary::exp_f64;
use crate::picture::{Picture, importance};
use crate::reconstruction::Reconstructed;
use crate::render::{Begun, Finished, Progress, RenderOptions, Rendered, Totals, blank};
use crate::request::AuditTerms;
use looks::{Looks, is_dear, is_hopeful};
use truths::{Look, Tolerance, Truths};

/// Paths of all pixels at most, where no time is said: a picture in minutes.
const MOST_PATHS: u64 = 64_000_000;
/// Passes at least, whatever the size of the image, and at most.
const PASSES: [u32; 2] = [5, 12];
/// Least growth that is worth a pass where time ends.
const LEAST_GROWTH: f64 = 0.2;
/// What the map adds to what is foreseen, as a share of the tolerance: about how well truths are known.
const OF_TRUTHS: f64 = 0.5;

/// Renders the picture; `begin` takes the film with which it begins, and gives it back.
pub(super) fn render(
    prepared: &Prepared<'_>,
    options: &ControlOptions,
    terms: &AuditTerms,
    begin: impl FnOnce(Film) -> Result<Begun>,
) -> Result<Rendered> {
    let setting = prepared.setting();
    if let Lights::Guided(lights) = &prepared.lights {
        let method = LightTransport::new(&prepared.tracer, lights, options);
        let options = ControlOptions { absolute_error: method.absolute_error(), ..*options };
        return render_by(prepared, &method, method.path_sampler(setting), &options, terms, begin);
    }
    let brightness = prepared.path_tracer(by_paths(options))?.importance_brightness(&setting);
    let options = options.in_view_of(brightness);
    let method = prepared.path_tracer(by_paths(&options))?;
    render_by(prepared, &method, method.path_sampler(setting), &options, terms, begin)
}

/// Renders by paths of this sampler, as the method describes them.
fn render_by<'v>(
    prepared: &'v Prepared<'_>,
    method: &dyn Integrator,
    sampler: impl SamplePaths + 'v,
    options: &ControlOptions,
    terms: &AuditTerms,
    begin: impl FnOnce(Film) -> Result<Begun>,
) -> Result<Rendered> {
    let setting = prepared.setting();
    let whole = RenderOptions { window: prepared.window, share: prepared.share.clone() };
    let mut film = blank(&setting, method, &whole)?;
    prepared.method.describe(film.metadata_mut());
    prepared.change.describe(film.metadata_mut());
    describe(terms, film.metadata_mut());
    if let Some(smoother) = &prepared.smoother {
        film.metadata_mut().set(keys::DENOISER, smoother.name());
    }
    let mut work = Work {
        prepared,
        terms,
        options,
        tolerance: Tolerance { error: options.error, absolute: options.absolute_error },
        by_lights: matches!(prepared.lights, Lights::Guided(_)),
        film: begin(film)?.film,
        picture: Picture::new(sampler, prepared.window, options.seed),
        reconstructed: Reconstructed::default(),
        truths: None,
        look: None,
        looks: Looks::default(),
        taken: 0,
    };
    work.go_on()?;
    work.finish()
}

/// What a film says of the audit beside what its integrator says of the pixels.
fn describe(terms: &AuditTerms, metadata: &mut Metadata) {
    metadata.set(keys::CLAIM, Claim::Audited.code().name);
    metadata.set(keys::PAIRS_ARE, "paths");
    // Of the map, each half-width holds for as many pixels as the share says.
    metadata.set(keys::CONFIDENCE, terms.share);
    metadata.set(keys::AUDIT_SHARE, terms.share);
    metadata.set(keys::AUDIT_ASSURANCE, terms.assurance);
    metadata.set(keys::AUDIT_MOST_LOOKS, AuditTerms::LOOKS);
    for name in [keys::MAX_PAIRS, keys::PATHS_FIRST, keys::PATHS_MOST] {
        metadata.remove(name);
    }
}

/// A picture in work, and its audit.
struct Work<'p, 'v> {
    prepared: &'p Prepared<'p>,
    terms: &'p AuditTerms,
    options: &'p ControlOptions,
    tolerance: Tolerance,
    /// Whether VPLs are drawn from and summed over.
    by_lights: bool,
    film: Film,
    picture: Picture<'v>,
    reconstructed: Reconstructed,
    truths: Option<Truths<'p>>,
    /// The last.
    look: Option<Look>,
    looks: Looks,
    /// Looks so far.
    taken: u32,
}

impl Work<'_, '_> {
    /// Passes and looks until the audit is content, or no work is left, or it is cancelled.
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
            if self.truths.is_none() {
                let (film, setting) = (self.picture.film()?, self.prepared.setting());
                let Self { options, terms, tolerance, by_lights, .. } = self;
                self.truths =
                    Truths::compute(&film, &setting, options, terms, tolerance, *by_lights, observer)?;
                if self.truths.is_none() {
                    return Ok(());
                }
            }
            let next = self.growth(of_path);
            let is_last = next.is_none();
            let is_due = is_last || self.looks.is_due(self.terms, self.foreseen());
            let is_reached = is_due && self.audit(is_last)?;
            match next {
                Some(next) if !is_reached => growth = next,
                _ => return Ok(()),
            }
        }
    }

    /// How many paths the next pass may have, over those that there are; none if there is no next.
    ///
    /// * `of_path`: what a path takes (s), if there is an end of the time.
    fn growth(&self, of_path: Option<f64>) -> Option<f64> {
        if self.picture.passes() >= PASSES[1] {
            return None;
        }
        let Some((of_path, left)) = of_path.zip(self.prepared.observer.seconds_left()) else {
            return self.has_paths_left().then_some(1.0);
        };
        let for_truths = self.truths.as_ref().map_or(0.0, Truths::seconds_of_refinement);
        let growth = (left - for_truths) / (of_path * self.picture.paths() as f64);
        (growth >= LEAST_GROWTH).then(|| growth.min(1.0))
    }

    /// One pass more, and what is seen of it; false if it was cancelled.
    ///
    /// * `growth`: its paths, over those that there are.
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
        self.store(Claim::None, Stop::SampleCount, 0.0)?;
        let tally = RenderFilm::of(&self.film).tally();
        let progress = Progress { tally, of: window.area(), rays: self.picture.rays() };
        observer.tile(&Finished { progress, film: &self.film, tile: window });
        Ok(true)
    }

    /// Whether another pass fits into the paths of a picture.
    fn has_paths_left(&self) -> bool {
        self.picture.passes() < PASSES[0] || 2 * self.picture.paths() <= MOST_PATHS
    }

    /// What pixels are foreseen to be off, as a share of what they may be.
    fn importance(&self) -> Vec<f32> {
        importance(&self.reconstructed, |radiance| self.tolerance.of(radiance.luminance().into()))
    }

    /// Share of the pixels that are foreseen to be outside, if errors are normal.
    fn foreseen(&self) -> f64 {
        let importance = self.importance();
        let outside = importance.iter().map(|share| beyond(1.0 / f64::from(*share))).sum::<f64>();
        outside / importance.len() as f64
    }

    /// Half-widths of the map, not scaled yet (W·m⁻²·sr⁻¹).
    fn half_widths(&self) -> Vec<f64> {
        let Reconstructed { radiance, importance_error } = &self.reconstructed;
        let of_pixel = |(radiance, error): (&Rgb, &f32)| {
            let of_truth = OF_TRUTHS * self.tolerance.of(radiance.luminance().into());
            (f64::from(*error) + of_truth).max(f64::MIN_POSITIVE)
        };
        radiance.iter().zip(importance_error).map(of_pixel).collect()
    }

    /// Looks at the picture, if it may be looked at: whether enough pixels are within.
    ///
    /// * `is_last`: whether it matters how many are not, if they are too many.
    fn audit(&mut self, is_last: bool) -> Result<bool> {
        let Some(is_first) = self.looks.begin() else { return Ok(false) };
        let most = self.most_pixels();
        if is_first {
            let of = self.audited();
            let is_reached = self.look(is_last)?;
            let outside = self.look.as_ref().map_or(0, |look| look.outside);
            if is_reached || of == most || !is_hopeful(self.terms, outside, [of, most]) {
                return Ok(is_reached);
            }
        }
        let is_extended = match &mut self.truths {
            Some(truths) if most > truths.pixels.len() as u64 => truths.extend()?,
            _ => true,
        };
        Ok(is_extended && self.look(is_last)?)
    }

    /// Pixels whose truths there are.
    fn audited(&self) -> u64 {
        self.truths.as_ref().map_or(0, |truths| truths.pixels.len() as u64)
    }

    /// Pixels that the picture is looked at by, at most.
    fn most_pixels(&self) -> u64 {
        let is_dear = is_dear(self.terms, self.picture.rays());
        let spare = self.truths.as_ref().filter(|_| is_dear).map_or(0, |truths| truths.spare.len());
        self.audited() + spare as u64
    }

    /// Holds the picture against the audited pixels: whether enough of them are within.
    fn look(&mut self, is_last: bool) -> Result<bool> {
        let half_widths = self.half_widths();
        let (terms, of, most) = (self.terms, self.audited(), self.most_pixels());
        let decides = |outside: u64, may_be: u64| {
            terms.is_reached(may_be, of) || !(is_last || is_hopeful(terms, outside, [of, most]))
        };
        let Some(truths) = &mut self.truths else { return Ok(false) };
        let (window, radiance) = (self.prepared.window, &self.reconstructed.radiance);
        truths.refine(&window, radiance, decides)?;
        let look = truths.look(&window, radiance, &half_widths);
        let is_reached = self.terms.is_reached(look.outside, look.ratios.len() as u64);
        self.look = Some(look);
        self.taken += 1;
        Ok(is_reached)
    }

    /// What the half-widths of the map are to be multiplied by; none if the audit cannot tell.
    fn factor(&self) -> Option<f64> {
        let mut ratios = self.look.as_ref()?.ratios.clone();
        ratios.sort_unstable_by(f64::total_cmp);
        let rank = self.terms.rank(ratios.len() as u64)?;
        Some(ratios[rank as usize - 1]).filter(|factor| factor.is_finite())
    }

    /// Puts the picture into the film.
    fn store(&mut self, claim: Claim, stop: Stop, factor: f64) -> Result<()> {
        let plain = self.picture.film()?;
        let read = RenderFilm::of(&plain);
        let half_widths = self.half_widths();
        let metadata = self.film.metadata_mut();
        metadata.set(keys::PASSES, self.picture.passes());
        metadata.set(keys::FORESEEN, self.reconstructed.importance_median());
        for (k, (x, y)) in self.prepared.window.pixels().enumerate() {
            let record = read.at(x, y);
            let is_audited = self.truths.as_ref().is_some_and(|truths| truths.population[k]);
            let claim = if is_audited { claim } else { Claim::None };
            let record = PixelRecord {
                radiance: self.reconstructed.radiance[k],
                standard_error: self.reconstructed.importance_error[k],
                half_width: claim.stated(factor * half_widths[k]),
                claim,
                stop,
                ..record
            };
            record.store(&mut self.film, x, y);
        }
        Ok(())
    }

    /// What the last look says of the picture.
    fn claim(&self) -> Option<PictureClaim> {
        let (truths, look) = self.truths.as_ref().zip(self.look.as_ref())?;
        let (audited, outside) = (look.ratios.len() as u64, look.outside);
        let AuditTerms { share, assurance, .. } = *self.terms;
        Some(PictureClaim {
            error: self.tolerance.error,
            share,
            assurance,
            audited,
            outside,
            upper_outside: self.terms.upper_outside(outside, audited),
            reached: self.terms.is_reached(outside, audited),
            population: truths.population.iter().map(|is_shown| u64::from(*is_shown)).sum(),
            looks: self.taken.into(),
            passes: self.picture.passes().into(),
        })
    }

    /// Puts what is claimed into the film, with the pixels that were audited.
    fn store_claim(&mut self, found: &PictureClaim) -> Result<()> {
        let factor = self.factor();
        let metadata = self.film.metadata_mut();
        found.describe(metadata);
        if let Some(factor) = factor {
            metadata.set(keys::AUDIT_FACTOR, factor);
        }
        let claim = if factor.is_some() { Claim::Audited } else { Claim::None };
        let stop = if found.reached { Stop::RuleMet } else { Stop::Budget };
        self.store(claim, stop, factor.unwrap_or_default())?;
        if let Some(truths) = &self.truths {
            self.film.metadata_mut().set(keys::AUDIT_RAYS, truths.rays);
            truths.describe(&mut self.film);
        }
        Ok(())
    }

    /// The film with all that is claimed.
    fn finish(mut self) -> Result<Rendered> {
        let was_cancelled = self.prepared.observer.cancel().load(Ordering::Relaxed);
        if was_cancelled && self.truths.is_some() {
            self.audit(true)?;
        }
        if let Some(found) = self.claim() {
            self.store_claim(&found)?;
        }
        let complete = !was_cancelled && self.look.is_some();
        let mut film = self.film;
        film.metadata_mut().set(keys::COMPLETE, complete);
        let totals = Totals::of(&film);
        Ok(Rendered { film, complete, totals })
    }
}

/// The probability that a normal number is more than `x` standard deviations from its mean, to 10⁻⁶
/// (Abramowitz, Stegun 1964, 7.1.26); `x` at least 0.
fn beyond(x: f64) -> f64 {
    let z = x * std::f64::consts::FRAC_1_SQRT_2;
    let k = 1.0 / (1.0 + 0.327_591_1 * z);
    let polynomial = [1.061_405_429, -1.453_152_027, 1.421_413_741, -0.284_496_736, 0.254_829_592];
    let sum = polynomial.iter().fold(0.0, |sum, factor| (sum + factor) * k);
    if z.is_finite() { sum * exp_f64(-z * z) } else { 0.0 }
}
