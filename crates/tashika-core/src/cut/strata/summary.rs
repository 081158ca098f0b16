//! Statistics of inherited samples: for each stratum, for the whole sum, and for the error of the
//! sum.

use super::inherited::{InheritedCut, StrataOptions};
use crate::bounds::UpperMaterial;
use crate::color::{Controlled, Rgb, RgbSum};
use crate::cut::refinement::Refinement;
use crate::stats::stratified::{Spread, Stratum};

/// Weight of the expected visibility when it is updated by the visibility of the pixel's samples;
/// in units of samples.
const PRIOR_WEIGHT: f64 = 1.0;

/// Statistics of the samples of a stratum of the cut; valid until the stratum is split.
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
    /// * `units`: values of the samples, each divided by the measure to which its probability is
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
            // If lights that were expected to be in shadow are visible, more of them are expected
            // to be visible.
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
    /// Returns true if all pairs are evaluated as a whole. The estimate is then the exact sum.
    pub fn is_whole(&self) -> bool {
        self.strata.memory.summaries.is_empty()
    }

    /// Estimate of the sum; its terms are added in the order of the pairs.
    pub fn estimate(&self) -> RgbSum {
        let mut sum = self.strata.whole;
        for summary in &self.strata.memory.summaries {
            sum.merge(&summary.mean);
        }
        sum
    }

    /// Statistics of the strata for one component of the error metric, given by its index in
    /// [`Controlled::parts`].
    ///
    /// * `estimate`: the [estimate](InheritedCut::estimate) of this cut. Its ratio of the component
    ///   to luminance scales expected ranges and variances; bounds do not use it.
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
