//! Our method: refines each pixel until its interval is within the tolerance, with intervals of
//! measured or proven coverage.
//!
//! In epochs, on cuts whose strata [inherit](crate::cut::InheritedCut) their samples:
//!
//! 1. refine the cut by a fixed factor, in an order that does not depend on samples of the
//!    estimate;
//! 2. draw the samples that new strata lack, and trace all segments together;
//! 3. state an interval ([`stats::stratified`](crate::stats)); stop if its half-width is at most
//!    `max(ε L̂ / (1 + ε), ε_abs)`.
//!
//! If the half-width is at most `ε L̂ / (1 + ε)` and the interval covers the *true* sum `L`, the
//! error is at most `ε L`.
//!
//! | claim | refined by | interval |
//! |---|---|---|
//! | [`Promise::Calibrated`] | bounds, [`PilotVisibility`] | Student's and a rare-light term |
//! | [`Promise::Certified`] | bounds | finite-sample certificate, `δ/J` each |
//!
//! The coverage of calibrated intervals is measured; the coverage of certificates is proven. `J` is
//! the largest number of interim analyses, each of which has `δ/J`.
//!
//! # Assumptions of the certificate
//! Upper bounds hold (`bounds`, `cut::tests`); the partition and the sample counts are functions of
//! bounds and of draws that the estimate does not use (`cut::Rank` has no access to sampled
//! values); random numbers are random. The certificate is about the luminance of this pixel's sum
//! over the given VPLs and gather points, and of emission seen directly, which is exact. Where the
//! error metric is all channels ([`Controlled`](crate::color::Controlled)), each channel has a
//! third of `δ`. The upper bound on a channel is the bound on luminance, divided by the weight of
//! the channel in luminance.
//!
//! # Differences from the published methods
//! Samples are inherited; pairs whose lights nearby pixels do not see are split late; terms of
//! small pairs are drawn in proportion to their unoccluded contributions; interim analyses are few;
//! the interval has a term for rare light; pairs of two terms are evaluated exactly; the error is
//! relative to the truth. The record has the effect of each.
//!
//! Tested by the suite's `control`.

mod ingredient;
mod schedule;

pub use ingredient::Ingredient;

use schedule::{CALIBRATED, CERTIFIED, OFTEN, Schedule};

use std::fmt;
use std::sync::OnceLock;

use super::{
    Claim, ControlOptions, Estimates, HalfWidths, Integrator, Lights, MANY_PAIRS, PixelRecord, Setting, Stop,
};
use crate::bounds::UpperAnalytic;
use crate::color::RgbSum;
use crate::cut::{
    CellVisibility, Clusters, CutMemory, InheritedCut, Pilot, PilotVisibility, Rank, StrataOptions,
    VisibilityPrior, gather_tree,
};
use crate::film::{Metadata, Window, keys};
use crate::guidance::cell_of;
use crate::rng::{self, Purpose, Stream};
use crate::scene::Abilities;

/// Kind of evidence for the intervals: measurement or proof. The outcome for each pixel is a
/// [`Claim`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Promise {
    /// Measured: over many scenes, the share of intervals that cover the truth is at least the
    /// confidence.
    #[default]
    Calibrated,
    /// Proven, for each pixel.
    Certified,
}

impl Promise {
    /// Claim of a pixel whose interval is narrow enough.
    pub fn claim(self) -> Claim {
        match self {
            Self::Calibrated => Claim::Calibrated,
            Self::Certified => Claim::Certified,
        }
    }

    /// Name of the method with this promise, on the command line and in files.
    pub fn method_name(self) -> &'static str {
        match self {
            Self::Calibrated => "tashika",
            Self::Certified => "tashika-certified",
        }
    }
}

impl fmt::Display for Promise {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.claim().code().name)
    }
}

/// Our method for a sum over VPLs.
#[derive(Debug)]
pub(super) struct Tashika<'a> {
    lights: Lights<'a>,
    options: ControlOptions,
    promise: Promise,
    left_out: Option<Ingredient>,
}

/// The method on one view.
struct CutView<'v> {
    method: &'v Tashika<'v>,
    setting: Setting<'v>,
    pilot: OnceLock<PilotVisibility>,
}

/// Result of a pixel when work on it ends.
struct Ended {
    /// Sum of the pixel, including its background.
    sum: RgbSum,
    interval: Interval,
    stop: Stop,
}

/// Widest interval among the parts of the error metric.
#[derive(Clone, Copy, Default)]
struct Interval {
    half_width: f64,
    standard_error: f64,
}

impl<'a> Tashika<'a> {
    /// Returns the method for these lights.
    pub(super) fn new(lights: Lights<'a>, options: &ControlOptions, promise: Promise) -> Self {
        Self { lights, options: *options, promise, left_out: None }
    }

    /// Returns the calibrated method without one of its ingredients.
    pub(super) fn without(lights: Lights<'a>, options: &ControlOptions, ingredient: Ingredient) -> Self {
        Self { left_out: Some(ingredient), ..Self::new(lights, options, Promise::Calibrated) }
    }

    fn has(&self, ingredient: Ingredient) -> bool {
        self.left_out != Some(ingredient)
    }

    fn strata_options<'v>(&self, prior: VisibilityPrior<'v>) -> StrataOptions<'v> {
        StrataOptions {
            inherits: self.has(Ingredient::Inheritance),
            tabulates: self.has(Ingredient::Listing),
            corrects: self.has(Ingredient::Correction),
            controlled: self.options.controlled,
            prior,
        }
    }

    fn schedule(&self) -> Schedule {
        match self.promise {
            Promise::Calibrated if self.has(Ingredient::FewLooks) => CALIBRATED,
            Promise::Calibrated => OFTEN,
            Promise::Certified => CERTIFIED,
        }
    }

    fn pixel(
        &self,
        setting: &Setting<'_>,
        [x, y]: [u32; 2],
        visibility: Option<&CellVisibility<'_>>,
        memory: &mut CutMemory,
    ) -> PixelRecord {
        let pixel = setting.view.pixel_at(setting.tracer, [x, y], self.lights.tree.instants());
        let number = u64::from(y) << 32 | u64::from(x);
        let key = rng::key(self.options.seed, Purpose::Cut, number);
        let contribution = self.lights.kernel(setting);
        let points = gather_tree::<UpperAnalytic>(&pixel.points);
        let clusters = Clusters { lights: self.lights.tree, points: &points, contribution };
        let samples = Stream::new(key, Purpose::Cut, 0);
        let mut background = RgbSum::default();
        background.add(pixel.background);
        let prior = visibility.map(CellVisibility::prior);
        let options = self.strata_options(prior.unwrap_or(VisibilityPrior::NONE));
        let rank = prior.map_or(Rank::Upper, Rank::Deviation);
        let cut = InheritedCut::new(clusters, rank, options, setting.tracer, samples, memory);
        let (ended, pairs, segments) = self.control(cut, &background);
        let rays = segments + visibility.map_or(0, |v| v.segments_per_pixel);
        let claim = match ended.stop {
            Stop::Complete => Claim::Exact,
            Stop::RuleMet => self.promise.claim(),
            _ => Claim::None,
        };
        let half_width = claim.stated(ended.interval.half_width);
        PixelRecord {
            radiance: ended.sum.total(),
            standard_error: ended.interval.standard_error as f32,
            claim,
            half_width,
            half_widths: HalfWidths { clustering: half_width, ..HalfWidths::default() },
            stop: ended.stop,
            pairs,
            rays,
            ..pixel.features.into()
        }
    }

    /// Refines a cut until its interval is narrow enough. Returns the numbers of pairs and segments
    /// as well.
    fn control(
        &self,
        cut: Option<InheritedCut<'_, UpperAnalytic>>,
        background: &RgbSum,
    ) -> (Ended, u64, u64) {
        let Some(mut cut) = cut else {
            let interval = Interval::default();
            return (Ended { sum: *background, interval, stop: Stop::Complete }, 0, 0);
        };
        let max_pairs = self.max_pairs();
        let schedule = self.schedule();
        let looks = schedule.looks(max_pairs.min(cut.terms()));
        let mut wanted = schedule.first;
        loop {
            cut.grow(wanted.min(max_pairs));
            let gathered = cut.estimate();
            let mut sum = *background;
            sum.merge(&gathered);
            let interval = self.interval(&cut, &gathered, looks);
            let stop = if cut.is_whole() {
                Some(Stop::Complete)
            } else if interval.half_width <= self.options.tolerance(&sum) {
                Some(Stop::RuleMet)
            } else if cut.pairs() >= max_pairs {
                Some(Stop::Budget)
            } else {
                None
            };
            if let Some(stop) = stop {
                return (Ended { sum, interval, stop }, cut.pairs(), cut.segments());
            }
            wanted = schedule.next(wanted);
        }
    }

    /// Interval at one of `looks` interim analyses. The parts of the error metric share `δ` evenly.
    fn interval(&self, cut: &InheritedCut<'_, UpperAnalytic>, gathered: &RgbSum, looks: u32) -> Interval {
        let parts = self.options.controlled.parts().len();
        let delta = (1.0 - self.options.confidence) / parts as f64;
        let mut widest = Interval::default();
        for part in 0..parts {
            let spread = cut.spread(part, gathered);
            let half_width = match self.promise {
                Promise::Calibrated if self.has(Ingredient::RareLight) => spread.calibrated(1.0 - delta),
                Promise::Calibrated => spread.student(1.0 - delta),
                Promise::Certified => spread.certified(delta / f64::from(looks)),
            };
            let standard_error = spread.variance.sqrt();
            if half_width >= widest.half_width {
                widest = Interval { half_width, standard_error };
            }
        }
        widest
    }

    fn max_pairs(&self) -> u64 {
        self.options.max_pairs.unwrap_or(MANY_PAIRS)
    }
}

impl Integrator for Tashika<'_> {
    fn name(&self) -> &'static str {
        self.left_out.map_or(self.promise.method_name(), Ingredient::left_out)
    }

    fn abilities(&self) -> Abilities {
        Abilities::ALL
    }

    fn describe(&self, metadata: &mut Metadata) {
        super::describe_lights(self.lights.provenance, self.lights.tree.instants(), metadata);
        let o = &self.options;
        metadata.set(keys::ERROR, o.error);
        metadata.set(keys::CONTROL, o.controlled.to_string());
        metadata.set(keys::ERROR_ABSOLUTE, o.absolute_error);
        metadata.set(keys::CONFIDENCE, o.confidence);
        metadata.set(keys::CLAIM, self.promise.to_string());
        metadata.set(keys::MAX_PAIRS, self.max_pairs());
        metadata.set(keys::PAIRS_ARE, "pairs of clusters");
        metadata.set(keys::CUT_SEED, o.seed);
    }

    fn begin<'v>(&'v self, setting: Setting<'v>) -> Box<dyn Estimates + 'v> {
        Box::new(CutView { method: self, setting, pilot: OnceLock::new() })
    }
}

impl CutView<'_> {
    /// Visibility of the lights from the neighbourhood of a cell.
    fn about(&self, cell: [u32; 2]) -> CellVisibility<'_> {
        let (Setting { tracer, view }, lights) = (self.setting, self.method.lights);
        let pilot = Pilot { tracer, view, lights: lights.tree, contribution: lights.kernel(&self.setting) };
        let visibility = self.pilot.get_or_init(|| PilotVisibility::new(&pilot, self.method.options.seed));
        visibility.about(&pilot, cell)
    }
}

impl Estimates for CutView<'_> {
    fn tile(&self, tile: &Window) -> Vec<PixelRecord> {
        let Self { method, setting, .. } = self;
        let mut cells: Vec<([u32; 2], CellVisibility<'_>)> = Vec::new();
        let mut memory = CutMemory::default();
        let mut estimate = |pixel: [u32; 2]| {
            if method.promise == Promise::Certified || !method.has(Ingredient::Pilot) {
                return method.pixel(setting, pixel, None, &mut memory);
            }
            let cell = cell_of(pixel);
            let place = cells.iter().position(|(known, _)| *known == cell).unwrap_or_else(|| {
                cells.push((cell, self.about(cell)));
                cells.len() - 1
            });
            method.pixel(setting, pixel, Some(&cells[place].1), &mut memory)
        };
        tile.pixels().map(|(x, y)| estimate([x, y])).collect()
    }
}
