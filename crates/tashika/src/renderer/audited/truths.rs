//! Pixels drawn at random from a picture, their truths, and what they say of it.
//!
//! ```text
//! stage 0: truth to ε/2 ── open? ─► stage 1: to ε/4 ── open? ─► stage 2: to ε/8
//! ```
//!
//! Where a look finds that the interval of a truth leaves it open on which side a pixel is, its truth
//! is computed once more, to half the width and by other random numbers, in [stages](STAGES). An outside pixel is taken for one
//! inside only if one of its intervals misses its truth, each with an equal share of `γ`.
//!
//! # Independence
//! The truths come from lights, gather points and random numbers of their own
//! ([`Purpose::Audit`]), and from another estimator than the picture's: sums over VPLs by cuts. Where
//! path tracing alone makes the picture, it finds the truths too, by other paths.

use super::verdict::{AuditedPixel, Look, Tolerance, describe, luminance_at, outside, shown};
use crate::color::Rgb;
use crate::error::Result;
use crate::film::{Film, PixelRecord, RenderFilm, Window};
use crate::gather::{GatherOptions, View};
use crate::integrator::{
    ControlOptions, GuidedLights, Integrator, LightTransport, PathStop, PathTracer, Setting, Truth,
};
use crate::render::render_pixels;
use crate::renderer::observer::{Observer, Phase, during};
use crate::request::AuditTerms;
use crate::rng::{self, Purpose, Stream};
use crate::stats::student_t_two_sided;
use crate::vpl::VplOptions;

/// A way to compute truths.
struct Stage {
    /// Half-width, as a share of the tolerance.
    half_width: f64,
    /// Pairs and paths at which a truth is taken as it is.
    most_work: u64,
}

/// How truths are computed at first, and then where they are open. Most pixels of a picture that is
/// good enough are so by far, and a wide interval tells.
const STAGES: [Stage; 3] = [
    Stage { half_width: 0.5, most_work: 1 << 13 },
    Stage { half_width: 0.25, most_work: 1 << 15 },
    Stage { half_width: 0.125, most_work: 1 << 18 },
];
/// Pixels that are tried for how long truths take.
const TRIED: u64 = 16;
/// Share of the time that is left which truths may take.
const SHARE_OF_TIME: f64 = 0.3;
/// What all stages take, over the first. Chosen.
const STAGES_COST: f64 = 4.0;
/// What a pixel takes in a stage, over what one took in the stage before. Measured.
const NEXT_STAGE_COST: f64 = 4.0;
/// Pixels of an audit at least, however little time there is.
const FEWEST: usize = 20;
/// VPLs that truths are summed over.
const VPLS: u64 = 500_000;
/// Gather points of a truth at first.
const POINTS: u32 = 64;

/// Paths of a truth at least, if it is found by path tracing: Student's interval of fewer may not have
/// met the rare bright ones. Chosen.
const FIRST_PATHS: u32 = 1024;

/// How path tracing finds what is within these options.
pub(in crate::renderer) fn by_paths(options: &ControlOptions) -> PathStop {
    let most = options.max_pairs.unwrap_or(STAGES[STAGES.len() - 1].most_work);
    PathStop::Until { options: *options, first: FIRST_PATHS, most: most.min(u32::MAX.into()) as u32 }
}

/// The audited pixels of a picture.
pub(super) struct Truths<'p> {
    source: Source<'p>,
    pub pixels: Vec<AuditedPixel>,
    /// The stage of each.
    stages: Vec<usize>,
    /// Drawn as they were, and not audited yet.
    pub spare: Vec<[u32; 2]>,
    /// Whether they were drawn from a pixel, too: of the window's, row by row.
    pub population: Vec<bool>,
    pub rays: u64,
    /// What the first stage took (s), if there is an end of the time.
    seconds: f64,
}

/// Where truths come from.
pub(super) struct Source<'p> {
    setting: Setting<'p>,
    options: ControlOptions,
    pub tolerance: Tolerance,
    /// That truths are summed over; none if they are found by path tracing.
    lights: Option<GuidedLights>,
    observer: &'p dyn Observer,
}

impl<'p> Source<'p> {
    /// How often a truth is computed at most.
    pub const STAGES: usize = STAGES.len();

    /// With lights, gather points and random numbers of its own.
    ///
    /// * `options`: those of the picture; `by_lights`: whether truths are sums over VPLs, rather than
    ///   means of paths.
    pub fn new(
        setting: &Setting<'p>,
        options: &ControlOptions,
        tolerance: &Tolerance,
        by_lights: bool,
        observer: &'p dyn Observer,
    ) -> Result<Self> {
        let seed = seed_of(options.seed);
        let gather = GatherOptions { points: POINTS, ..setting.view.gather };
        let setting = Setting { view: View { seed, gather, ..setting.view }, ..*setting };
        let lights = VplOptions { count: VPLS, seed, ..VplOptions::default() };
        let traced = || {
            during(observer, Phase::Vpls { count: VPLS }, || {
                GuidedLights::trace(setting.tracer, &lights, Truth::Transport, &setting.view)
            })
        };
        let lights = by_lights.then(traced).transpose()?;
        let options = ControlOptions { seed, ..*options };
        Ok(Self { setting, options, tolerance: *tolerance, lights, observer })
    }

    /// The view, as it is looked at in a stage.
    pub fn setting(&self, stage: usize) -> Setting<'_> {
        let seed = self.options(stage).seed;
        Setting { view: View { seed, ..self.setting.view }, ..self.setting }
    }

    fn options(&self, stage: usize) -> ControlOptions {
        let Stage { half_width, most_work } = STAGES[stage];
        ControlOptions {
            error: half_width * self.tolerance.error,
            absolute_error: half_width * self.tolerance.absolute,
            confidence: 1.0 - (1.0 - AuditTerms::CONFIDENCE) / STAGES.len() as f64,
            max_pairs: Some(most_work),
            // The draw of the pixels has the key 0.
            seed: rng::key(self.options.seed, Purpose::Audit, 1 + stage as u64),
            ..self.options
        }
    }

    /// What computes truths in a stage.
    pub fn method(&self, stage: usize) -> Result<Box<dyn Integrator + '_>> {
        let (options, tracer) = (self.options(stage), self.setting.tracer);
        Ok(match &self.lights {
            Some(lights) => Box::new(LightTransport::new(tracer, lights, &options)),
            None => {
                Box::new(PathTracer::new(tracer, by_paths(&options), VplOptions::default().path_depth())?)
            }
        })
    }

    /// What such an estimate says of a pixel.
    pub fn truth(&self, pixel: [u32; 2], record: &PixelRecord, stage: usize) -> AuditedPixel {
        let luminance = f64::from(record.radiance.luminance());
        // The interval of a mean of paths is one too where it is wider than was asked for.
        let half_width = match self.lights {
            Some(_) => record.claim.is_some().then_some(f64::from(record.half_width)),
            None => Some(half_width_of_paths(record, self.options(stage).confidence)),
        };
        let interval = half_width.map(|of| [(luminance - of).max(0.0), luminance + of]);
        AuditedPixel { pixel, interval }
    }

    /// The truths of these pixels, and the rays for them; none if it was cancelled.
    fn truths(&self, pixels: &[[u32; 2]], stage: usize) -> Result<Option<(Vec<AuditedPixel>, u64)>> {
        let by = if self.lights.is_some() { "sums over other lights" } else { "other paths" };
        let phase = Phase::Audit { by, pixels: pixels.len() as u64 };
        let (observer, setting, method) = (self.observer, self.setting(stage), self.method(stage)?);
        let rendered = during(observer, phase, || {
            let tell = |progress: &_| observer.progress(progress);
            render_pixels(&setting, method.as_ref(), pixels, &tell, observer.cancel())
        })?;
        let read = RenderFilm::of(&rendered.film);
        let truth = |pixel: &[u32; 2]| self.truth(*pixel, &read.at(pixel[0], pixel[1]), stage);
        let truths = pixels.iter().map(truth).collect();
        Ok(rendered.complete.then_some((truths, rendered.totals.rays)))
    }
}

/// The seed of a picture's audit.
pub(super) fn seed_of(picture: u64) -> u64 {
    rng::key(picture, Purpose::Audit, 0)
}

/// Student's, about a mean of paths (W·m⁻²·sr⁻¹).
fn half_width_of_paths(record: &PixelRecord, confidence: f64) -> f64 {
    let freedom = record.pairs.saturating_sub(1).max(1) as f64;
    student_t_two_sided(confidence, freedom) * f64::from(record.standard_error)
}

impl<'p> Truths<'p> {
    /// Draws pixels of a film and computes their truths; none if it was cancelled.
    ///
    /// Where there is an end of the time, they are as many as are foreseen to take their
    /// [share](SHARE_OF_TIME) of it, by pixels of which nothing else is used: so what a truth costs
    /// and what it says may depend on each other as they like.
    ///
    /// * `options`: those of the picture; the audit has a seed of its own from theirs.
    /// * `by_lights`: whether truths are sums over VPLs, rather than means of paths.
    pub fn compute(
        film: &Film,
        setting: &Setting<'p>,
        options: &ControlOptions,
        terms: &AuditTerms,
        tolerance: &Tolerance,
        by_lights: bool,
        observer: &'p dyn Observer,
    ) -> Result<Option<Self>> {
        let began = observer.seconds_left();
        let population = shown(film);
        let pixels = film.window().pixels().zip(&population);
        let shown: Vec<[u32; 2]> =
            pixels.filter(|(_, is_shown)| **is_shown).map(|((x, y), _)| [x, y]).collect();
        let source = Source::new(setting, options, tolerance, by_lights, observer)?;
        let all = shown.len() as u64;
        let count = terms.pixels.min(all);
        // Those that come first are tried for what they take, the others are the audit's.
        let [tried, spare] = match began {
            Some(_) => [TRIED.min(all - count), 0],
            None => [0, terms.more_pixels().min(all) - count],
        };
        let mut chosen = drawn(shown, tried + count + spare, seed_of(options.seed));
        let mut of_audit = chosen.split_off(tried as usize);
        let spare = of_audit.split_off(count as usize);
        let mut count = count as usize;
        if let (Some(began), Some(before), false) = (began, observer.seconds_left(), chosen.is_empty()) {
            if source.truths(&chosen, 0)?.is_none() {
                return Ok(None);
            }
            let of_one = (before - observer.seconds_left().unwrap_or(before)) / tried as f64;
            let affordable = (SHARE_OF_TIME * began - (began - before)).max(0.0) / (STAGES_COST * of_one);
            count = count.min((affordable as usize).max(FEWEST));
        }
        let before = observer.seconds_left();
        let Some((pixels, rays)) = source.truths(&of_audit[..count], 0)? else { return Ok(None) };
        let seconds = before.zip(observer.seconds_left()).map_or(0.0, |(before, after)| before - after);
        let stages = vec![0; pixels.len()];
        Ok(Some(Self { source, pixels, stages, spare, population, rays, seconds }))
    }

    /// Audits [more pixels](AuditTerms::more_pixels), if they are not audited already; false if it was
    /// cancelled. Where there is an end of the time there are no more.
    pub fn extend(&mut self) -> Result<bool> {
        if self.spare.is_empty() {
            return Ok(true);
        }
        let Some((truths, rays)) = self.source.truths(&self.spare, 0)? else { return Ok(false) };
        self.spare.clear();
        self.pixels.extend(truths);
        self.stages.resize(self.pixels.len(), 0);
        self.rays += rays;
        Ok(true)
    }

    /// What truths are summed over.
    #[cfg(test)]
    pub fn lights(&self) -> &GuidedLights {
        self.source.lights.as_ref().expect("they are sums over lights")
    }

    /// About what it will take to refine them (s), if there is an end of the time.
    pub fn seconds_of_refinement(&self) -> f64 {
        (STAGES_COST - 1.0) * self.seconds
    }

    /// Computes the truths once more, stage by stage, of pixels that may be on either side; false if
    /// it was cancelled. Where there is an end of the time, as many as fit: what stays open counts as
    /// outside.
    ///
    /// * `radiance`: of the window's pixels, row by row.
    /// * `decides`: whether it is decided what the audit finds, where so many pixels are outside for
    ///   certain, and so many may be.
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
            let mut open: Vec<usize> = all.into_iter().filter(|k| self.stages[*k] + 1 == stage).collect();
            of_one *= NEXT_STAGE_COST;
            if let Some(left) = self.source.observer.seconds_left() {
                open.truncate((left / of_one) as usize);
            }
            if open.is_empty() {
                continue;
            }
            let pixels: Vec<[u32; 2]> = open.iter().map(|k| self.pixels[*k].pixel).collect();
            let Some((truths, rays)) = self.source.truths(&pixels, stage)? else { return Ok(false) };
            for (k, truth) in open.iter().zip(truths) {
                self.pixels[*k] = truth;
                self.stages[*k] = stage;
            }
            self.rays += rays;
        }
        Ok(true)
    }

    fn is_open(&self, k: usize, window: &Window, radiance: &[Rgb]) -> bool {
        let truth = &self.pixels[k];
        truth.is_open(luminance_at(truth.pixel, window, radiance), &self.source.tolerance)
    }

    /// Holds a picture against the truths.
    ///
    /// * `radiance`, `half_widths`: of the window's pixels, row by row.
    pub fn look(&self, window: &Window, radiance: &[Rgb], half_widths: &[f64]) -> Look {
        Look::at(&self.pixels, &self.source.tolerance, window, radiance, half_widths)
    }

    /// Adds the plane of the audited pixels to a film.
    pub fn describe(&self, film: &mut Film) {
        describe(&self.pixels, &self.source.tolerance, film);
    }
}

/// `count` of these pixels at random, each subset as likely as another.
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
    fn means_of_paths_have_the_intervals_of_the_tables() {
        let of = |pairs| PixelRecord { pairs, standard_error: 2.0, ..PixelRecord::default() };
        assert!((half_width_of_paths(&of(5), 0.95) - 2.0 * 2.776_4).abs() < 1e-3);
        assert!((half_width_of_paths(&of(1 << 20), 0.95) - 2.0 * 1.96).abs() < 1e-3);
    }

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
