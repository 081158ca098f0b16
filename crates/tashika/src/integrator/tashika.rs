//! Ours: a pixel is refined until its interval is as narrow as was asked for, and the interval means what it says.
//!
//! In epochs, on cuts whose strata [inherit](crate::cut::InheritedCut) their samples:
//!
//! 1. refine the cut by a fixed factor, in an order that no sample of the estimate has a say in;
//! 2. draw what new strata lack, and trace all segments together;
//! 3. state an interval ([`stats::stratified`](crate::stats)); stop if its half-width is at most `max(ε L̂ / (1 + ε), ε_abs)`.
//!
//! With the half-width at most `ε L̂ / (1 + ε)`, the error is at most `ε L` relative to the *true* sum, whenever the interval holds.
//!
//! | claim | order of refinement | interval |
//! |---|---|---|
//! | [`Claim::Calibrated`] | by upper bounds and pilot visibility ([`PilotVisibility`]) | Student's, with a term for what is rare and bright; measured coverage |
//! | [`Claim::Certified`] | by upper bounds | a finite-sample certificate, with `δ/J` for each of the `J` looks that there can be; proven |
//!
//! # Assumptions of the certificate
//! Upper bounds hold (`bounds`, `cut::tests`); the partition and the sample counts are functions of bounds and of draws that the estimate does not
//! use (`cut::InheritedCut`: the order has no way to sampled values); random numbers are random. It speaks of the luminance of this
//! pixel's sum over the given VPLs and gather points, without what is seen directly, which is exact.
//!
//! # Differences to the published methods
//! Samples are inherited; pairs whose lights other pixels near by do not see are split late; terms of small pairs are drawn in proportion to what
//! they would contribute unoccluded; looks are few; the interval knows of rare light; pairs of two terms are evaluated as a whole; the error is
//! relative to the truth. The record says what each is worth.
//!
//! Tested by the suite's `control`.

use std::fmt;
use std::sync::OnceLock;

use super::{ControlOptions, ErrorClaim, Integrator, Lights, MANY_PAIRS, PixelEstimate, Setting, StopReason};
use crate::bounds::{UpperAnalytic, UpperMaterial};
use crate::color::RgbSum;
use crate::cut::{
    ByUpper, CellVisibility, Clusters, InheritedCut, Order, Pilot, PilotVisibility, gather_tree,
};
use crate::film::{Metadata, Window};
use crate::rng::{self, Purpose, Stream};
use crate::stats::stratified::Spread;
use crate::transport::Transport;

/// When a cut is looked at: at a number of pairs, and whenever it has grown by a factor since.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Schedule {
    first: u64,
    growth: f64,
}

/// Fewer looks at small cuts would mean fewer chances to be fooled by samples that are all alike, and more pairs than needed.
const CALIBRATED: Schedule = Schedule { first: 64, growth: 1.15 };
/// Certificates pay for every look.
const CERTIFIED: Schedule = Schedule { first: 512, growth: 1.3 };

impl Schedule {
    /// Pairs at the look after the one at `pairs`.
    fn next(&self, pairs: u64) -> u64 {
        ((pairs as f64 * self.growth) as u64).max(pairs + 1)
    }

    /// How many looks there are at most until a cut has `most` pairs.
    fn looks(&self, most: u64) -> u32 {
        let (mut pairs, mut looks) = (self.first, 1);
        while pairs < most {
            pairs = self.next(pairs);
            looks += 1;
        }
        looks
    }
}

/// Terms up to which a pair is evaluated as a whole: as many as would be drawn from it.
const FINEST: u64 = 2;

/// By which kind of argument an interval is stated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Claim {
    /// Measured: on scenes at large, at least as many intervals hold as the confidence says.
    #[default]
    Calibrated,
    /// Proven for each pixel.
    Certified,
}

impl fmt::Display for Claim {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Calibrated => "calibrated",
            Self::Certified => "certified",
        })
    }
}

/// Error control that keeps its promise.
///
/// An instance is for one view: pilot visibility is that of the view it is first used with.
#[derive(Debug)]
pub struct Tashika<'a> {
    lights: Lights<'a>,
    options: ControlOptions,
    claim: Claim,
    pilot: OnceLock<PilotVisibility>,
}

/// What is known of a pixel when work on it ends.
struct Ended {
    sum: RgbSum,
    spread: Spread,
    half_width: f64,
    stop: StopReason,
}

impl<'a> Tashika<'a> {
    /// The method on these lights.
    pub fn new(lights: Lights<'a>, options: &ControlOptions, claim: Claim) -> Self {
        Self { lights, options: *options, claim, pilot: OnceLock::new() }
    }

    fn pixel(
        &self,
        setting: &Setting<'_>,
        [x, y]: [u32; 2],
        visibility: Option<&CellVisibility<'_>>,
    ) -> PixelEstimate {
        let pixel = setting.view.pixel(setting.tracer, [x, y]);
        let number = u64::from(y) << 32 | u64::from(x);
        let key = rng::key(self.options.seed, Purpose::Cut, number);
        let clamp_distance = self.lights.provenance.clamp_distance;
        let transport = Transport::new(clamp_distance);
        let points = gather_tree::<UpperAnalytic>(&pixel.points);
        let clusters = Clusters { lights: self.lights.tree, points: &points, clamp_distance };
        let samples = Stream::new(key, Purpose::Cut, 0);
        let (ended, pairs, segments) = match visibility {
            Some(visibility) => {
                let order = visibility.order();
                self.control(InheritedCut::new(clusters, order, setting.tracer, transport, samples))
            }
            None => {
                let order = ByUpper { finest: FINEST };
                self.control(InheritedCut::new(clusters, order, setting.tracer, transport, samples))
            }
        };
        let rays = segments + visibility.map_or(0, |v| v.segments_per_pixel);
        let mut radiance = ended.sum;
        radiance.add(pixel.background);
        let (half_width, confidence) = (ended.half_width as f32, self.options.confidence as f32);
        let claim = match (ended.stop, self.claim) {
            (StopReason::Complete, _) => ErrorClaim::Exact,
            (StopReason::RuleMet, Claim::Calibrated) => ErrorClaim::Calibrated { half_width, confidence },
            (StopReason::RuleMet, Claim::Certified) => ErrorClaim::Certified { half_width, confidence },
            _ => ErrorClaim::None,
        };
        PixelEstimate {
            radiance: radiance.total(),
            standard_error: ended.spread.variance.sqrt() as f32,
            claim,
            stop: ended.stop,
            pairs,
            rays,
            features: pixel.features,
        }
    }

    /// Refines a cut until its interval is narrow enough; with the pairs and segments that it took.
    fn control<B: UpperMaterial, O: Order>(&self, cut: Option<InheritedCut<'_, B, O>>) -> (Ended, u64, u64) {
        let Some(mut cut) = cut else {
            let nothing = Ended {
                sum: RgbSum::default(),
                spread: Spread::default(),
                half_width: 0.0,
                stop: StopReason::Complete,
            };
            return (nothing, 0, 0);
        };
        let max_pairs = self.max_pairs();
        let schedule = match self.claim {
            Claim::Calibrated => CALIBRATED,
            Claim::Certified => CERTIFIED,
        };
        let looks = schedule.looks(max_pairs.min(cut.terms()));
        let mut strata = Vec::new();
        let mut wanted = schedule.first;
        loop {
            cut.grow(wanted.min(max_pairs));
            let sum = cut.summarize(&mut strata);
            let spread = Spread::of(&strata);
            let half_width = self.half_width(&spread, looks);
            let tolerance = self.tolerance(sum.luminance());
            let stop = if strata.is_empty() {
                Some(StopReason::Complete)
            } else if half_width <= tolerance {
                Some(StopReason::RuleMet)
            } else if cut.pairs() >= max_pairs {
                Some(StopReason::Budget)
            } else {
                None
            };
            if let Some(stop) = stop {
                let ended = Ended { sum, spread, half_width, stop };
                return (ended, cut.pairs(), cut.segments());
            }
            wanted = schedule.next(wanted);
        }
    }

    fn max_pairs(&self) -> u64 {
        self.options.max_pairs.unwrap_or(MANY_PAIRS)
    }

    /// Half-width that is narrow enough for an estimate.
    fn tolerance(&self, luminance: f64) -> f64 {
        let ControlOptions { error, absolute_error, .. } = self.options;
        (error / (1.0 + error) * luminance).max(absolute_error)
    }

    /// Half-width at one of that many looks.
    fn half_width(&self, spread: &Spread, looks: u32) -> f64 {
        let delta = 1.0 - self.options.confidence;
        match self.claim {
            Claim::Calibrated => spread.calibrated(self.options.confidence),
            Claim::Certified => spread.certified(delta / f64::from(looks)),
        }
    }

    /// What the neighbourhood of a cell sees of the lights.
    fn about(&self, setting: &Setting<'_>, cell: [u32; 2]) -> CellVisibility<'_> {
        let transport = Transport::new(self.lights.provenance.clamp_distance);
        let pilot = Pilot { tracer: setting.tracer, view: setting.view, lights: self.lights.tree, transport };
        let visibility = self.pilot.get_or_init(|| PilotVisibility::new(&pilot, self.options.seed));
        visibility.about(&pilot, cell)
    }
}

impl Integrator for Tashika<'_> {
    fn name(&self) -> &'static str {
        "tashika"
    }

    fn describe(&self, metadata: &mut Metadata) {
        super::describe_lights(self.lights.provenance, metadata);
        let o = &self.options;
        metadata.set("error", o.error);
        metadata.set("error_absolute", o.absolute_error);
        metadata.set("confidence", o.confidence);
        metadata.set("claim", self.claim.to_string());
        metadata.set("max_pairs", self.max_pairs());
        metadata.set("cut.seed", o.seed);
    }

    fn estimate(&self, setting: &Setting<'_>, tile: &Window) -> Vec<PixelEstimate> {
        let mut cells: Vec<([u32; 2], CellVisibility<'_>)> = Vec::new();
        let mut estimate = |pixel: [u32; 2]| {
            if self.claim == Claim::Certified {
                return self.pixel(setting, pixel, None);
            }
            let cell = PilotVisibility::cell_of(pixel);
            let place = cells.iter().position(|(known, _)| *known == cell).unwrap_or_else(|| {
                cells.push((cell, self.about(setting, cell)));
                cells.len() - 1
            });
            self.pixel(setting, pixel, Some(&cells[place].1))
        };
        tile.pixels().map(|(x, y)| estimate([x, y])).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of looks that a certificate pays for is the number of looks that there can be.
    #[test]
    fn looks_are_counted() {
        for schedule in [CALIBRATED, CERTIFIED, Schedule { first: 1, growth: 1.0 }] {
            for most in [1, 2, 63, 64, 65, 511, 512, 513, 1000, 4000] {
                let (mut wanted, mut looks) = (schedule.first, 1);
                // As `control` does it: the last look is at a cut that is whole, or out of budget.
                while wanted.min(most) < most {
                    wanted = schedule.next(wanted);
                    looks += 1;
                }
                assert_eq!(schedule.looks(most), looks, "{schedule:?} {most}");
            }
        }
        assert!((20..30).contains(&CERTIFIED.looks(1 << 18)));
    }
}
