//! Ours, against light transport itself: the mean over independent sets of VPLs, with what VPLs do not carry put back.
//!
//! A pixel is repeated with `R` independent sets of VPLs ([`LightSets`]), each time with gather points, cuts and paths of its own:
//!
//! ```text
//! X_r = B_r + Σ_pairs ȳ_k + (1/m) Σ_paths          E X_r = light transport          L̂ = X̄ over r = 1 … R
//! ```
//!
//! the emission seen directly, a stratified sum over the VPLs of the set by a cut of a size that no sample of the estimate has a say in
//! ([`cut`](crate::cut)), and paths of what VPLs do not carry ([`uncarried`](crate::uncarried)). The size of the cut is planned on a set that is
//! used for no estimate, so that it is refined about as far as worth while: until its own interval is a few times wider than the one that
//! is asked for. Where less work is foreseen for it, and where sets differ by too much for as many as there are, a repetition is made of paths of all
//! there is instead ([`Estimator`]). After 8, 12, 18, … repetitions, and when all sets are used up after whole rounds of repetitions with all of them, the interval of
//! [`stats::Replicates`](crate::stats::Replicates) is looked at, and work ends when its half-width is at most `max(ε L̂ / (1 + ε), ε_abs)`.
//!
//! The spread between repetitions holds everything: which VPLs there are, which of them were drawn, gather points, paths. What is known within
//! repetitions, the spread of samples within pairs and of paths, steadies it. The variance of paths is pooled with that of paths of
//! the neighbourhood.
//!
//! # Guarantee
//! For a given number of repetitions the estimate is unbiased, but for paths longer than the longest light path. Intervals are calibrated: measured,
//! not proven. Held to this by the suite's `light_transport`; the record has the measurements.

mod attempt;
mod cells;
mod looks;
mod plan;
mod replicate;
mod sets;

pub use replicate::Estimator;
pub use sets::LightSets;

use std::sync::OnceLock;

use smallvec::SmallVec;

use super::{ControlOptions, ErrorClaim, HalfWidths, Integrator, PixelEstimate, Setting, StopReason, Truth};
use crate::accel::Tracer;
use crate::cut::CutMemory;
use crate::film::{Metadata, Window};
use crate::gather::View;
use crate::rng::{self, Purpose};
use crate::vpl::EmitterSampler;

use attempt::{Attempt, Finding};
use cells::{Cell, Cells};
use looks::Look;
use plan::{Plan, plan};
use replicate::{Recipe, Repetition};

/// Error control against light transport.
#[derive(Debug)]
pub struct LightTransport<'a> {
    sets: &'a LightSets,
    emitters: EmitterSampler<'a>,
    options: ControlOptions,
    only: Option<Estimator>,
    cells: OnceLock<Cells>,
}

impl<'a> LightTransport<'a> {
    /// The method on these sets of the tracer's scene.
    ///
    /// An instance is for one view: what it knows of neighbourhoods is of the view it is first used with.
    pub fn new(tracer: &'a Tracer, sets: &'a LightSets, options: &ControlOptions) -> Self {
        let emitters = EmitterSampler::by_use(tracer, sets.options());
        Self { sets, emitters, options: *options, only: None, cells: OnceLock::new() }
    }

    /// The same with one estimator for all pixels, to measure it or to test it. Nothing changes unless the truth is light transport.
    #[must_use]
    pub fn only_by(mut self, estimator: Estimator) -> Self {
        self.only = Some(estimator);
        self
    }

    /// Whether what VPLs do not carry is put back.
    fn compensates(&self) -> bool {
        self.sets.truth() == Truth::Transport
    }

    /// Plans for a pixel.
    fn begin<'v>(&'v self, setting: &'v Setting<'a>, [x, y]: [u32; 2]) -> Pixel<'v> {
        let cell = self.compensates().then(|| {
            let cells = self.cells.get_or_init(|| Cells::new(setting.view.size));
            let Self { emitters, sets, options, .. } = self;
            cells.of([x, y], setting, emitters, sets, options.controlled, options.seed)
        });
        let key = rng::key(self.options.seed, Purpose::Replicate, u64::from(y) << 32 | u64::from(x));
        let (set, planning_key) = (&self.sets.planning()[0], rng::key(key, Purpose::Guidance, 0));
        let planning =
            Repetition::new(setting, &self.emitters, set, [x, y], planning_key, self.compensates());
        let Plan { recipes, rays } =
            plan(&planning, cell, &self.options, self.only, self.sets.estimating().len());
        let rays = rays + cell.map_or(0, |cell| cell.rays_per_pixel);
        Pixel { at: [x, y], key, cell, recipes, attempt: Attempt::default(), finding: None, pairs: 0, rays }
    }

    /// One more repetition of a pixel with the set of that number.
    fn repeat(
        &self,
        setting: &Setting<'a>,
        pixel: &mut Pixel<'_>,
        recipe: &Recipe,
        number: usize,
        memory: &mut CutMemory,
    ) {
        let sets = self.sets.estimating();
        let round = pixel.attempt.rounds(number) as usize;
        let key = rng::key(pixel.key, Purpose::Replicate, recipe.estimator as u64);
        let key = rng::key(key, Purpose::Replicate, (round * sets.len() + number) as u64);
        let mut gather = setting.view.gather;
        if recipe.estimator == Estimator::Paths {
            // Each path from a point of its own: what is seen in a pixel differs as much as what lights it.
            gather.points = gather.points.max(recipe.paths);
        }
        let setting = Setting { view: View { gather, ..setting.view }, ..*setting };
        let compensates = self.compensates();
        let repetition = Repetition::new(&setting, &self.emitters, &sets[number], pixel.at, key, compensates);
        let repeated = repetition.estimate(self.options.controlled, recipe, memory);
        pixel.pairs += repeated.pairs;
        pixel.rays += repeated.rays;
        pixel.attempt.add(number, repeated);
    }

    /// Repeats pixels by their recipe of that number, until their intervals are narrow enough or never will be.
    ///
    /// Set after set, each for all pixels: what one pixel needs of a set's tree its neighbours need, too.
    fn attempt(&self, setting: &Setting<'a>, mut pixels: Vec<&mut Pixel<'_>>, number: usize) {
        let sets = self.sets.estimating().len();
        let mut memory = CutMemory::default();
        pixels.iter_mut().for_each(|pixel| pixel.attempt = Attempt::default());
        let mut look = Some(Look::FIRST);
        while let Some(now) = look.filter(|_| !pixels.is_empty()) {
            for set in 0..now.sets.min(sets) {
                for pixel in &mut pixels {
                    let recipe = pixel.recipes[number];
                    while pixel.attempt.rounds(set) < now.rounds {
                        self.repeat(setting, pixel, &recipe, set, &mut memory);
                    }
                }
            }
            look = now.next(sets);
            pixels.retain_mut(|pixel| {
                let estimator = pixel.recipes[number].estimator;
                let nearby = pixel.cell.map_or(&[][..], |cell| &cell.paths(estimator).moments);
                let finding = pixel.attempt.finding(&self.options, nearby);
                let goes_on = !finding.is_met && (estimator == Estimator::Paths || finding.can_be_met);
                pixel.finding = Some(finding);
                goes_on
            });
        }
    }

    fn estimate_of(&self, pixel: Pixel<'_>) -> PixelEstimate {
        let Finding { interval, mean, is_met, .. } = pixel.finding.expect("each pixel has a recipe");
        let (half_width, confidence) = (interval.half_width as f32, self.options.confidence as f32);
        let (claim, stop) = if is_met {
            (ErrorClaim::Calibrated { half_width, confidence }, StopReason::RuleMet)
        } else {
            (ErrorClaim::None, StopReason::Budget)
        };
        let [clustering, compensation] = interval.within.map(|h| h as f32);
        PixelEstimate {
            radiance: mean.total(),
            standard_error: interval.standard_error as f32,
            claim,
            half_widths: HalfWidths { clustering, lights: interval.excess as f32, compensation },
            stop,
            pairs: pixel.pairs,
            rays: pixel.rays,
            features: pixel.attempt.features(),
        }
    }
}

/// A pixel in work.
struct Pixel<'a> {
    at: [u32; 2],
    key: u64,
    /// None if nothing is asked for but sums over VPLs.
    cell: Option<&'a Cell>,
    recipes: SmallVec<[Recipe; 2]>,
    /// By the last recipe that was begun.
    attempt: Attempt,
    /// What that came to at its last look.
    finding: Option<Finding>,
    pairs: u64,
    rays: u64,
}

impl Integrator for LightTransport<'_> {
    fn name(&self) -> &'static str {
        "tashika"
    }

    fn describe(&self, metadata: &mut Metadata) {
        let (o, lights) = (&self.options, self.sets.options());
        metadata.set("truth", self.sets.truth().to_string());
        metadata.set("sets", self.sets.count());
        metadata.set("vpls", self.sets.lights());
        metadata.set("vpls.requested", lights.count);
        metadata.set("vpls.seed", lights.seed);
        metadata.set("vpls.max_depth", lights.max_depth);
        metadata.set("vpls.clamp_distance_m", f64::from(self.sets.clamp_distance()));
        metadata.set("error", o.error);
        metadata.set("control", o.controlled.to_string());
        metadata.set("error_absolute", o.absolute_error);
        metadata.set("confidence", o.confidence);
        metadata.set("claim", "calibrated");
        metadata.set("cut.seed", o.seed);
    }

    fn estimate(&self, setting: &Setting<'_>, tile: &Window) -> Vec<PixelEstimate> {
        let mut pixels: Vec<Pixel<'_>> = tile.pixels().map(|(x, y)| self.begin(setting, [x, y])).collect();
        let most = pixels.iter().map(|pixel| pixel.recipes.len()).max().unwrap_or(0);
        for number in 0..most {
            let is_open = |pixel: &&mut Pixel<'_>| {
                pixel.recipes.len() > number && !pixel.finding.as_ref().is_some_and(|found| found.is_met)
            };
            self.attempt(setting, pixels.iter_mut().filter(is_open).collect(), number);
        }
        pixels.into_iter().map(|pixel| self.estimate_of(pixel)).collect()
    }
}
