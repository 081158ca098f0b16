//! What the published methods have in common: rules, and the way from a tile to cuts.
//!
//! All of them refine the pair with the largest upper bound, on the same trees, with the same
//! transport and the same rays. They differ in what is clustered (lights, or pairs with gather
//! points), how a pair is estimated, how the material is bounded, and when they stop.

use super::{ControlOptions, ErrorClaim, HalfWidths, Lights, PixelEstimate, Setting, StopReason};
use crate::bounds::UpperMaterial;
use crate::color::RgbSum;
use crate::cut::{Clusters, Cut, CutEnd, CutEstimate, CutMemory, PairEstimates, StoppingRule, gather_tree};
use crate::film::{Metadata, Window};
use crate::gather::GatherPoint;
use crate::rng::{self, Purpose, Stream};
use crate::transport::Transport;

/// Pairs before the t-interval is looked at. Two terms that are both in shadow have no variance: a
/// cut of a few pairs would end there.
pub(super) const MIN_PAIRS: u64 = 32;

impl ControlOptions {
    /// The rule of Walter 2005.
    pub(super) fn largest_upper(&self) -> StoppingRule {
        StoppingRule::LargestUpper { error: self.error }
    }

    /// The rule of Nabata 2016.
    pub(super) fn interval(&self) -> StoppingRule {
        let Self { error, confidence, .. } = *self;
        StoppingRule::Interval { error, confidence, min_pairs: MIN_PAIRS }
    }
}

/// What one cut is made over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scope {
    /// Lights and all gather points of the pixel.
    Pixel,
    /// Lights alone, for each gather point by itself.
    Point,
}

/// A published method: everything in which they differ, but for the bound of the material and how
/// pairs are estimated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Published<'a> {
    pub lights: Lights<'a>,
    pub scope: Scope,
    pub rule: StoppingRule,
    pub max_pairs: u64,
    pub seed: u64,
}

impl Published<'_> {
    /// Writes down what the result depends on.
    pub(super) fn describe(&self, metadata: &mut Metadata) {
        super::describe_lights(self.lights.provenance, metadata);
        metadata.set("max_pairs", self.max_pairs);
        metadata.set("cut.seed", self.seed);
        match self.rule {
            StoppingRule::LargestUpper { error } => metadata.set("error", error),
            StoppingRule::Interval { error, confidence, min_pairs } => {
                metadata.set("error", error);
                metadata.set("confidence", confidence);
                metadata.set("min_pairs", min_pairs);
            }
        }
    }

    /// Estimates of the tile's pixels, row by row, with materials bounded by `B` and pairs
    /// estimated by `S`.
    pub(super) fn estimate<B: UpperMaterial, S: PairEstimates<B> + Default>(
        &self,
        setting: &Setting<'_>,
        tile: &Window,
    ) -> Vec<PixelEstimate> {
        let mut memory = CutMemory::default();
        tile.pixels().map(|(x, y)| self.pixel::<B, S>(setting, [x, y], &mut memory)).collect()
    }

    fn pixel<B: UpperMaterial, S: PairEstimates<B> + Default>(
        &self,
        setting: &Setting<'_>,
        [x, y]: [u32; 2],
        memory: &mut CutMemory,
    ) -> PixelEstimate {
        let pixel = setting.view.pixel(setting.tracer, [x, y]);
        let key = rng::key(self.seed, Purpose::Cut, u64::from(y) << 32 | u64::from(x));
        let mut cut = |points: &[GatherPoint], number: u64| {
            self.cut::<B, S>(setting, points, Stream::new(key, Purpose::Cut, number), memory)
        };
        let cuts: Vec<CutEstimate> = match self.scope {
            Scope::Pixel => vec![cut(&pixel.points, 0)],
            Scope::Point => {
                (0..).zip(pixel.points.chunks(1)).map(|(number, point)| cut(point, number)).collect()
            }
        };
        let mut radiance = RgbSum::default();
        radiance.add(pixel.background);
        let (mut variance, mut squared_width, mut pairs, mut rays) = (0.0, 0.0, 0, 0);
        for cut in &cuts {
            radiance.merge(&cut.radiance);
            variance += cut.variance;
            squared_width += cut.half_width * cut.half_width;
            pairs += cut.pairs;
            rays += cut.segments;
        }
        let stop = if cuts.iter().any(|cut| cut.end == CutEnd::Budget) {
            StopReason::Budget
        } else if cuts.iter().any(|cut| cut.end == CutEnd::RuleMet) {
            StopReason::RuleMet
        } else {
            StopReason::Complete
        };
        let claim = match self.rule.confidence() {
            Some(confidence) if stop != StopReason::Budget => ErrorClaim::Published {
                half_width: squared_width.sqrt() as f32,
                confidence: confidence as f32,
            },
            _ => ErrorClaim::None,
        };
        PixelEstimate {
            radiance: radiance.total(),
            standard_error: variance.sqrt() as f32,
            claim,
            half_widths: HalfWidths { clustering: claim.half_width(), ..HalfWidths::default() },
            stop,
            pairs,
            rays,
            features: pixel.features,
        }
    }

    fn cut<B: UpperMaterial, S: PairEstimates<B> + Default>(
        &self,
        setting: &Setting<'_>,
        points: &[GatherPoint],
        stream: Stream,
        memory: &mut CutMemory,
    ) -> CutEstimate {
        let transport = Transport::new(self.lights.provenance.clamp_distance).within(setting.tracer.scene());
        let points = gather_tree::<B>(points);
        let clusters = Clusters { lights: self.lights.tree, points: &points, transport };
        let cut = Cut::published(clusters, S::default(), setting.tracer, stream, memory);
        cut.map(|cut| self.rule.refine(cut, self.max_pairs)).unwrap_or_default()
    }
}
