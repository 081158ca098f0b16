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
//! is asked for. After 8, 12, 18, … repetitions, and when all sets are used up after whole rounds of repetitions with all of them, the interval of
//! [`stats::Replicates`](crate::stats::Replicates) is looked at, and work ends when its half-width is at most `max(ε L̂ / (1 + ε), ε_abs)`.
//!
//! The spread between repetitions holds everything: which VPLs there are, which of them were drawn, gather points, paths. What is known within
//! repetitions, the spread of samples within pairs and of paths, steadies it. The variance of paths is pooled with that of paths of
//! the neighbourhood.
//!
//! # Guarantee
//! For a given number of repetitions the estimate is unbiased, but for paths longer than the longest light path. Intervals are calibrated: measured,
//! not proven. Held to this by the suite's `light_transport`; the record has the measurements.

mod cells;
mod looks;
mod replicate;
mod sets;

pub use sets::LightSets;

use std::sync::OnceLock;

use smallvec::SmallVec;

use super::{ControlOptions, ErrorClaim, HalfWidths, Integrator, PixelEstimate, Setting, StopReason, Truth};
use crate::accel::Tracer;
use crate::color::{Part, RgbSum};
use crate::film::{Metadata, Window};
use crate::gather::Features;
use crate::rng::{self, Purpose};
use crate::stats::{Moments, ReplicateInterval, Replicates};
use crate::vpl::EmitterSampler;

use cells::{Cell, Cells};
use looks::Look;
use replicate::{Known, Planned, Repeated, Repetition};

// What follows was chosen on the development scenes; it decides about cost, and about how rare the light may be that intervals reckon with, not about the mean.

/// How many times wider than asked for the interval of a single cut is.
const LOOSE: f64 = 3.0;
/// Pairs of the smallest cut.
const FIRST_PAIRS: u64 = 16;
/// Growth of a cut from look to look while planning.
const PAIRS_GROWTH: f64 = 1.3;
/// Pairs of the largest cut: beyond, another repetition tells more.
const MOST_PAIRS: u64 = 256;
/// Standard errors in the half-width of an interval, about.
const ERRORS_OF_HALF_WIDTH: f64 = 2.0;
/// Fewest and most paths of a repetition.
const PATHS: std::ops::RangeInclusive<f64> = 4.0..=256.0;
/// Paths by which it is planned how many there are.
const PLANNING_PATHS: u32 = 64;
/// Share of the variance of a repetition that paths may have.
const PATHS_SHARE: f64 = 0.5;
/// As many paths of the neighbourhood count as much as the pixel's own.
const NEIGHBOURHOOD_WEIGHT: f64 = 1024.0;

/// Error control against light transport.
#[derive(Debug)]
pub struct LightTransport<'a> {
    sets: &'a LightSets,
    emitters: EmitterSampler<'a>,
    options: ControlOptions,
    cells: OnceLock<Cells>,
}

impl<'a> LightTransport<'a> {
    /// The method on these sets of the tracer's scene.
    ///
    /// An instance is for one view: what it knows of neighbourhoods is of the view it is first used with.
    pub fn new(tracer: &'a Tracer, sets: &'a LightSets, options: &ControlOptions) -> Self {
        let emitters = EmitterSampler::by_use(tracer, sets.options());
        Self { sets, emitters, options: *options, cells: OnceLock::new() }
    }

    /// Whether what VPLs do not carry is put back.
    fn compensates(&self) -> bool {
        self.sets.truth() == Truth::Transport
    }

    fn pixel(&self, setting: &Setting<'_>, [x, y]: [u32; 2]) -> PixelEstimate {
        let controlled = self.options.controlled;
        let none = Cell::default();
        let cell = if self.compensates() {
            let cells = self.cells.get_or_init(|| Cells::new(setting.view.size));
            cells.of([x, y], setting, &self.emitters, self.sets, controlled, self.options.seed)
        } else {
            &none
        };
        let key = rng::key(self.options.seed, Purpose::Replicate, u64::from(y) << 32 | u64::from(x));
        let repetition = |number: usize, set| {
            let key = rng::key(key, Purpose::Replicate, number as u64);
            Repetition::new(setting, &self.emitters, set, [x, y], key, self.compensates())
        };
        let sets = self.sets.estimating();
        let (pairs, paths, planning_rays) = self.plan(&repetition(0, self.sets.planning()), cell);
        let mut by_set: Vec<OfSet> = Vec::new();
        let mut totals = Totals { rays: planning_rays + cell.rays_per_pixel, ..Totals::default() };
        let mut look = Look::FIRST;
        let (interval, stop, mean) = loop {
            let wanted = look.sets.min(sets.len());
            by_set.resize_with(wanted, OfSet::default);
            for (number, (of_set, set)) in by_set.iter_mut().zip(sets).enumerate() {
                while of_set.repetitions < look.rounds {
                    let round = of_set.repetitions as usize;
                    let repeated =
                        repetition(1 + round * sets.len() + number, set).estimate(controlled, pairs, paths);
                    totals.add(&repeated);
                    of_set.add(repeated);
                }
            }
            let interval = self.interval(&by_set, cell);
            let mean = totals.sum.scaled(1.0 / totals.repetitions as f64);
            let tolerance = self.options.tolerance(&mean);
            if interval.half_width <= tolerance {
                break (interval, StopReason::RuleMet, mean);
            }
            match look.next(sets.len()) {
                Some(next) if self.can_be_met(&by_set, tolerance) => look = next,
                _ => break (interval, StopReason::Budget, mean),
            }
        };
        let (half_width, confidence) = (interval.half_width as f32, self.options.confidence as f32);
        let claim = match stop {
            StopReason::RuleMet => ErrorClaim::Calibrated { half_width, confidence },
            _ => ErrorClaim::None,
        };
        let [clustering, compensation] = interval.within.map(|h| h as f32);
        PixelEstimate {
            radiance: mean.total(),
            standard_error: interval.standard_error as f32,
            claim,
            half_widths: HalfWidths { clustering, lights: interval.excess as f32, compensation },
            stop,
            pairs: totals.pairs,
            rays: totals.rays,
            features: totals.features,
        }
    }

    /// Pairs of a cut and paths that are worth while, and the rays that it took to know.
    fn plan(&self, planning: &Repetition<'_>, cell: &Cell) -> (u64, u32, u64) {
        let confidence = self.options.confidence;
        let next = |n: &u64| Some((*n as f64 * PAIRS_GROWTH) as u64).filter(|n| *n <= MOST_PAIRS);
        let sizes = std::iter::successors(Some(FIRST_PAIRS), next);
        let Planned { pairs, sum, rays } = planning.plan(self.options.controlled, sizes, |sum, spread| {
            spread.calibrated(confidence) <= LOOSE * self.options.tolerance(sum)
        });
        let mut own = Moments::default();
        let mut path_rays = 0;
        if self.compensates() {
            path_rays = planning.paths(PLANNING_PATHS, |value, _| own.push(f64::from(value.luminance())));
        }
        // The neighbourhood may be brighter than the pixel, but has seen more.
        let nearby = cell.paths.iter().map(Moments::variance).fold(0.0, f64::max);
        let known = own.count() as f64;
        let variance = if known > 0.0 { 0.5 * (own.variance() + nearby) } else { nearby };
        let error = PATHS_SHARE.sqrt() * LOOSE * self.options.tolerance(&sum) / ERRORS_OF_HALF_WIDTH;
        let paths = if variance > 0.0 { variance / (error * error) } else { 0.0 };
        let paths = if self.compensates() { paths.clamp(*PATHS.start(), *PATHS.end()) as u32 } else { 0 };
        (pairs, paths, rays + path_rays)
    }

    /// Whether more rounds with the same sets could bring the interval to the tolerance: they do nothing about which VPLs there are.
    ///
    /// With the variance `w` between the repetitions with one set, known from two rounds on, the sets' own share of the variance of their means is
    /// about `s² − w / rounds`. That samples of the estimate are looked at here decides about giving up, and who gives up claims nothing.
    fn can_be_met(&self, by_set: &[OfSet], tolerance: f64) -> bool {
        let sets = by_set.len() as f64;
        let of_part = |number: usize| {
            let mut of_sets = Moments::default();
            let mut within = 0.0;
            for of_set in by_set {
                let value = &of_set.known[number].value;
                of_sets.push(value.mean());
                within += value.variance() / value.count() as f64 / sets;
            }
            let hopeless =
                ERRORS_OF_HALF_WIDTH * ((of_sets.variance() - within).max(0.0) / sets).sqrt() > tolerance;
            by_set[0].repetitions < 2 || !hopeless
        };
        (0..self.options.controlled.parts().len()).all(of_part)
    }

    /// The widest interval of what is controlled.
    fn interval(&self, by_set: &[OfSet], cell: &Cell) -> ReplicateInterval<2> {
        let parts = self.options.controlled.parts();
        let delta = (1.0 - self.options.confidence) / parts.len() as f64;
        let interval_of = |(number, part): (usize, &Part)| {
            let mut paths = Moments::default();
            for of_set in by_set {
                paths.merge(&of_set.known[number].paths);
            }
            let nearby = cell.paths.get(number).copied().unwrap_or_default();
            let (own, theirs) = (paths.count() as f64, NEIGHBOURHOOD_WEIGHT.min(nearby.count() as f64));
            let largest = paths.largest().max(nearby.largest());
            let of_path = (own * paths.variance() + theirs * nearby.variance()) / (own + theirs).max(1.0);
            let mut replicates = Replicates::<2>::default();
            for of_set in by_set {
                let (known, count) = (&of_set.known[number], f64::from(of_set.repetitions));
                let of_paths = of_path / known.paths.count().max(1) as f64;
                let clustering = known.clustering / (count * count);
                // What no path may have met is about as bright as the brightest of the neighbourhood.
                let of_path = largest / known.paths.count().max(1) as f64;
                let rare = (known.rare / (count * count)).max(of_path);
                replicates.push(part.of_sum(&of_set.sum) / count, [clustering, of_paths], rare);
            }
            replicates.interval(1.0 - delta)
        };
        let widest = parts.iter().enumerate().map(interval_of);
        widest.max_by(|a, b| a.half_width.total_cmp(&b.half_width)).expect("something is controlled")
    }
}

/// What the repetitions with one set say together.
#[derive(Default)]
struct OfSet {
    repetitions: u32,
    sum: RgbSum,
    /// Sums over the repetitions.
    known: SmallVec<[Known; 3]>,
}

impl OfSet {
    fn add(&mut self, repeated: Repeated) {
        self.repetitions += 1;
        self.sum.merge(&repeated.sum);
        self.known.resize(repeated.known.len(), Known::default());
        for (sum, known) in self.known.iter_mut().zip(repeated.known) {
            sum.clustering += known.clustering;
            sum.rare += known.rare;
            sum.paths.merge(&known.paths);
            sum.value.merge(&known.value);
        }
    }
}

/// What all repetitions of a pixel come to.
#[derive(Default)]
struct Totals {
    repetitions: u64,
    sum: RgbSum,
    features: Features,
    pairs: u64,
    rays: u64,
}

impl Totals {
    fn add(&mut self, repeated: &Repeated) {
        if self.repetitions == 0 {
            self.features = repeated.features;
        }
        self.repetitions += 1;
        self.sum.merge(&repeated.sum);
        self.pairs += repeated.pairs;
        self.rays += repeated.rays;
    }
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
        tile.pixels().map(|(x, y)| self.pixel(setting, [x, y])).collect()
    }
}
