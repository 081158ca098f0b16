//! What repetitions of a pixel say together.

use smallvec::SmallVec;

use super::super::ControlOptions;
use super::plan::ERRORS_OF_HALF_WIDTH;
use super::replicate::{Known, Repeated};
use crate::color::{Part, RgbSum};
use crate::gather::Features;

use crate::stats::{Moments, ReplicateInterval, Replicates};

/// As many paths of the neighbourhood count as much as the pixel's own.
const NEIGHBOURHOOD_WEIGHT: f64 = 1024.0;

/// Repetitions of a pixel by one recipe, so far.
#[derive(Default)]
pub(super) struct Attempt {
    /// As many of the sets, in their order, as were used.
    by_set: Vec<OfSet>,
    /// Of the first repetition.
    features: Option<Features>,
}

/// What is found at a look.
pub(super) struct Finding {
    /// The widest of what is controlled.
    pub interval: ReplicateInterval<2>,
    pub mean: RgbSum,
    /// Whether the interval is within the tolerance.
    pub is_met: bool,
    /// Whether more rounds with the same sets could bring it there.
    pub can_be_met: bool,
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

impl Attempt {
    /// How often the set of that number was used.
    pub(super) fn rounds(&self, set: usize) -> u32 {
        self.by_set.get(set).map_or(0, |of_set| of_set.repetitions)
    }

    /// Takes in a repetition with the set of that number, which is at most the first that was not used.
    pub(super) fn add(&mut self, set: usize, repeated: Repeated) {
        self.features.get_or_insert(repeated.features);
        if self.by_set.len() == set {
            self.by_set.push(OfSet::default());
        }
        self.by_set[set].add(repeated);
    }

    pub(super) fn features(&self) -> Features {
        self.features.unwrap_or_default()
    }

    /// What is found now that all sets have been used equally often.
    ///
    /// * `nearby`: of paths of the neighbourhood, by part of what is controlled.
    pub(super) fn finding(&self, options: &ControlOptions, nearby: &[Moments]) -> Finding {
        let interval = self.interval(options, nearby);
        let mut sum = RgbSum::default();
        self.by_set.iter().for_each(|of_set| sum.merge(&of_set.sum));
        let repetitions: u32 = self.by_set.iter().map(|of_set| of_set.repetitions).sum();
        let mean = sum.scaled(1.0 / f64::from(repetitions));
        let tolerance = options.tolerance(&mean);
        let can_be_met = self.can_be_met(options, tolerance);
        Finding { interval, mean, is_met: interval.half_width <= tolerance, can_be_met }
    }

    /// Whether more rounds with the same sets could bring the interval to the tolerance: they do nothing about which VPLs there are.
    ///
    /// With the variance `w` between the repetitions with one set, known from two rounds on, the sets' own share of the variance of their means is
    /// about `s² − w / rounds`. That samples of the estimate are looked at here decides about giving up, and who gives up claims nothing.
    fn can_be_met(&self, options: &ControlOptions, tolerance: f64) -> bool {
        let sets = self.by_set.len() as f64;
        let of_part = |number: usize| {
            let mut of_sets = Moments::default();
            let mut within = 0.0;
            for of_set in &self.by_set {
                let value = &of_set.known[number].value;
                of_sets.push(value.mean());
                within += value.variance() / value.count() as f64 / sets;
            }
            let hopeless =
                ERRORS_OF_HALF_WIDTH * ((of_sets.variance() - within).max(0.0) / sets).sqrt() > tolerance;
            self.by_set[0].repetitions < 2 || !hopeless
        };
        (0..options.controlled.parts().len()).all(of_part)
    }

    /// The widest interval of what is controlled.
    fn interval(&self, options: &ControlOptions, nearby: &[Moments]) -> ReplicateInterval<2> {
        let parts = options.controlled.parts();
        let delta = (1.0 - options.confidence) / parts.len() as f64;
        let interval_of = |(number, part): (usize, &Part)| {
            let mut paths = Moments::default();
            for of_set in &self.by_set {
                paths.merge(&of_set.known[number].paths);
            }
            // Without a gather point there is no path to be unlike those that were followed.
            let nearby = nearby.get(number).copied().filter(|_| paths.count() > 0).unwrap_or_default();
            let (own, theirs) = (paths.count() as f64, NEIGHBOURHOOD_WEIGHT.min(nearby.count() as f64));
            let largest = paths.largest().max(nearby.largest());
            let of_path = (own * paths.variance() + theirs * nearby.variance()) / (own + theirs).max(1.0);
            let mut replicates = Replicates::<2>::default();
            for of_set in &self.by_set {
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
