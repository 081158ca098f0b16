//! Shared code of the published methods: stopping rules, and the estimates of a tile by cuts.
//!
//! All of them refine the pair with the largest upper bound, and use the same trees, contribution
//! kernel and rays. They differ in the clusters (of lights, or pairs with gather points), the
//! estimate of a pair, the bound of the material, and the stopping rule.

use super::{Claim, ControlOptions, Estimates, HalfWidths, Lights, PixelRecord, Setting, Stop};
use crate::bounds::UpperMaterial;
use crate::color::RgbSum;
use crate::cut::{Clusters, Cut, CutEnd, CutEstimate, CutMemory, PairEstimates, StoppingRule, gather_tree};
use crate::film::{Metadata, Window, keys};
use crate::gather::GatherPoint;
use crate::rng::{self, Purpose, Stream};

/// Fewest pairs at which the t-interval is tested. Two terms in shadow have no variance, so that a
/// cut of a few pairs could end as black.
pub(super) const MIN_PAIRS: u64 = 32;

impl ControlOptions {
    /// Returns the rule of Walter 2005.
    pub(super) fn largest_upper(&self) -> StoppingRule {
        StoppingRule::LargestUpper { error: self.error }
    }

    /// Returns the rule of Nabata 2016.
    pub(super) fn interval(&self) -> StoppingRule {
        let Self { error, confidence, .. } = *self;
        StoppingRule::Interval { error, confidence, min_pairs: MIN_PAIRS }
    }
}

/// Extent of one cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scope {
    /// Lights and all gather points of the pixel.
    Pixel,
    /// Lights alone; each gather point has its own cut.
    Point,
}

/// A published method, except for the bound of the material and the estimate of a pair.
#[derive(Clone, Copy, Debug)]
pub(super) struct Published<'a> {
    pub lights: Lights<'a>,
    pub scope: Scope,
    pub rule: StoppingRule,
    pub max_pairs: u64,
    pub seed: u64,
}

impl Published<'_> {
    /// Writes the options that the result depends on to the metadata.
    pub(super) fn describe(&self, metadata: &mut Metadata) {
        super::describe_lights(self.lights.provenance, self.lights.tree.instants(), metadata);
        metadata.set(keys::MAX_PAIRS, self.max_pairs);
        metadata.set(keys::PAIRS_ARE, "pairs of clusters");
        metadata.set(keys::CUT_SEED, self.seed);
        match self.rule {
            StoppingRule::LargestUpper { error } => metadata.set(keys::ERROR, error),
            StoppingRule::Interval { error, confidence, min_pairs } => {
                metadata.set(keys::ERROR, error);
                metadata.set(keys::CONFIDENCE, confidence);
                metadata.set(keys::MIN_PAIRS, min_pairs);
            }
        }
    }

    /// Begins with a view. Materials are bounded by `B` and pairs estimated by `S`. Nothing is
    /// learned from tile to tile.
    pub(super) fn begin<'v, B: UpperMaterial, S: PairEstimates<B> + Default>(
        &'v self,
        setting: Setting<'v>,
    ) -> Box<dyn Estimates + 'v> {
        Box::new(move |tile: &Window| {
            let mut memory = CutMemory::default();
            tile.pixels().map(|(x, y)| self.pixel::<B, S>(&setting, [x, y], &mut memory)).collect()
        })
    }

    fn pixel<B: UpperMaterial, S: PairEstimates<B> + Default>(
        &self,
        setting: &Setting<'_>,
        [x, y]: [u32; 2],
        memory: &mut CutMemory,
    ) -> PixelRecord {
        let pixel = setting.view.pixel_at(setting.tracer, [x, y], self.lights.tree.instants());
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
            Stop::Budget
        } else if cuts.iter().any(|cut| cut.end == CutEnd::RuleMet) {
            Stop::RuleMet
        } else {
            Stop::Complete
        };
        let states_interval = self.rule.confidence().is_some() && stop != Stop::Budget;
        let claim = if states_interval { Claim::Published } else { Claim::None };
        let half_width = claim.stated(squared_width.sqrt());
        // A single representative for each cluster gives no estimate of the error.
        let is_known = self.rule.confidence().is_some() || stop == Stop::Complete;
        PixelRecord {
            radiance: radiance.total(),
            standard_error: if is_known { variance.sqrt() as f32 } else { f32::NAN },
            claim,
            half_width,
            half_widths: HalfWidths { clustering: half_width, ..HalfWidths::default() },
            stop,
            pairs,
            rays,
            ..pixel.features.into()
        }
    }

    fn cut<B: UpperMaterial, S: PairEstimates<B> + Default>(
        &self,
        setting: &Setting<'_>,
        points: &[GatherPoint],
        stream: Stream,
        memory: &mut CutMemory,
    ) -> CutEstimate {
        let contribution = self.lights.kernel(setting);
        let points = gather_tree::<B>(points);
        let clusters = Clusters { lights: self.lights.tree, points: &points, contribution };
        let cut = Cut::published(clusters, S::default(), setting.tracer, stream, memory);
        cut.map(|cut| self.rule.refine(cut, self.max_pairs)).unwrap_or_default()
    }
}
