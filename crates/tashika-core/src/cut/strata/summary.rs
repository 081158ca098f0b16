//! Statistics of inherited samples: of each stratum, of the whole sum, and of its possible error.

use super::inherited::{InheritedCut, StrataOptions};
use crate::bounds::UpperMaterial;
use crate::color::{Controlled, Rgb, RgbSum};
use crate::cut::refinement::Refinement;
use crate::stats::stratified::{Spread, Stratum};

/// Weight of an expected visibility, in samples of the pixel, when it is corrected by their
/// visibility.
const PRIOR_WEIGHT: f64 = 1.0;

/// Statistics of the samples of a stratum of the cut, which stay until the stratum is split.
#[derive(Clone, Copy, Debug)]
pub(super) struct StratumSummary {
    /// Number of the stratum's pair.
    pub(super) number: u32,
    /// Number of the stratum's samples.
    pub(super) samples: u32,
    /// Estimate of the stratum.
    pub(super) mean: RgbSum,
    /// Sample variance of each part of the error metric.
    variances: [f64; Controlled::MOST_PARTS],
    /// `R`, `R'` and `σ'²` of the luminance ([`stratified`](crate::stats::stratified)).
    upper: f64,
    importance_range: f64,
    importance_variance: f64,
}

impl StratumSummary {
    /// Summarizes the samples of a stratum.
    ///
    /// * `units`: values of the samples over the measures to which their probabilities are
    ///   proportional.
    pub(super) fn new<B: UpperMaterial, U: Iterator<Item = Rgb>>(
        number: usize,
        units: impl Fn() -> U,
        refinement: &Refinement<'_, B>,
        options: &StrataOptions<'_>,
    ) -> Self {
        let info = refinement.info(number);
        let weight = refinement.weight(number);
        let (mut sum, mut samples) = (RgbSum::default(), 0);
        for unit in units() {
            sum.add(unit);
            samples += 1;
        }
        let n = f64::from(samples);
        let mean = sum.scaled(1.0 / n);
        let mut variances = [0.0; Controlled::MOST_PARTS];
        for (variance, part) in variances.iter_mut().zip(options.controlled.parts()) {
            let middle = part.of_sum(&mean);
            let squares: f64 =
                units().map(|unit| part.of(unit) - middle).map(|deviation| deviation * deviation).sum();
            *variance = squares * weight * weight / (n - 1.0);
        }
        let expected = options.prior.importance_visibility(&refinement.pairs()[number].light);
        let mut visibility = expected;
        if options.corrects {
            // Lights that were expected in shadow but are visible are a reason to expect more.
            let seen = (sum.luminance() * weight / info.upper.0).min(n);
            visibility = (PRIOR_WEIGHT * expected + seen) / (PRIOR_WEIGHT + n);
        }
        let size = info.importance_size();
        Self {
            number: number as u32,
            samples,
            mean: mean.scaled(weight),
            variances,
            upper: info.upper.0,
            importance_range: size * visibility.sqrt(),
            importance_variance: expected * (1.0 - expected) * size * size,
        }
    }
}

impl<B: UpperMaterial> InheritedCut<'_, B> {
    /// Returns true if no pair is merely sampled: the estimate is the exact sum.
    pub fn is_whole(&self) -> bool {
        self.strata.memory.summaries.is_empty()
    }

    /// Estimate of the sum, added up in the order of the pairs.
    pub fn estimate(&self) -> RgbSum {
        let mut sum = self.strata.whole;
        for summary in &self.strata.memory.summaries {
            sum.merge(&summary.mean);
        }
        sum
    }

    /// Statistics of the strata for a part of the error metric, by its number among
    /// [`Controlled::parts`].
    ///
    /// * `estimate`: [of the cut](InheritedCut::estimate). The ratio of the part to luminance is
    ///   taken from it, for expected ranges and variances; not for bounds.
    pub fn spread(&self, part: usize, estimate: &RgbSum) -> Spread {
        let of = &self.strata.options.controlled.parts()[part];
        let luminance = estimate.luminance();
        let per_luminance = if luminance > 0.0 { of.of_sum(estimate) / luminance } else { of.per_luminance };
        Spread::of(self.strata.memory.summaries.iter().map(|summary| {
            let upper = summary.upper * of.per_luminance;
            Stratum {
                samples: summary.samples,
                upper,
                importance_range: (summary.importance_range * per_luminance).min(upper),
                variance: summary.variances[part],
                importance_variance: summary.importance_variance * per_luminance * per_luminance,
            }
        }))
    }
}
