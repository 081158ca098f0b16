//! Summary of a grid of sensors: mean, extremes and uniformity, each with an interval.
//!
//! Readings share their lights, so that their errors may agree. With the intervals `E_i ± h_i` of
//! confidence `1 − α`,
//!
//! ```text
//! mean          Ē ± mean of h_i                        confidence 1 − α
//! min, max      [min (E_i − H_i), min (E_i + H_i)]     confidence 1 − α for all i together
//! U₀ = min/Ē    [min (E_i − H_i) / Ē⁺, min (E_i + H_i) / Ē⁻]      Ē± = mean of E_i ± H_i
//! H_i = h_i · z(1 − α/2n) / z(1 − α/2)                 z: quantile of the normal distribution
//! ```
//!
//! # Guarantee
//! The interval of the mean assumes that errors are jointly normal, with any correlation: the
//! standard deviation of a mean is at most the mean of the standard deviations. The other intervals
//! are those of a union bound over the `n` sensors, and assume that the tails of single errors fall
//! like those of a normal distribution. Certified half-widths are not widened by this rule, so that
//! `U₀` and the extremes of certified readings have no interval unless each sensor was rendered
//! with the confidence `1 − α/n` ([`GridSummary::joint_confidence`]).
//!
//! # Held to this by
//! The tests below; the suite's `sensors`, seed against seed.

use serde::Serialize;

use crate::film::Claim;
use crate::stats::normal_quantile;

use super::Reading;

/// A value with the ends of its interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bounds {
    /// Estimate.
    pub value: f64,
    /// Lower and upper end of the interval; `None` if nothing is claimed.
    pub interval: Option<[f64; 2]>,
}

/// Summary of the readings of a grid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GridSummary {
    /// Number of sensors that were measured.
    pub sensors: usize,
    /// Mean of all illuminances (lx).
    pub mean: Bounds,
    /// Smallest illuminance (lx).
    pub min: Bounds,
    /// Largest illuminance (lx).
    pub max: Bounds,
    /// Uniformity `U₀`: the smallest illuminance over the mean.
    pub uniformity: Bounds,
}

impl GridSummary {
    /// Summarises readings; `None` if no sensor was measured.
    ///
    /// * `confidence`: confidence of the intervals of the readings.
    /// * `are_joint`: true if this is [`joint_confidence`](Self::joint_confidence), so that all
    ///   intervals hold together.
    pub fn of(readings: &[Reading], confidence: f64, are_joint: bool) -> Option<Self> {
        let measured: Vec<&Reading> = readings.iter().filter(|reading| reading.is_measured()).collect();
        let count = measured.len() as f64;
        if measured.is_empty() {
            return None;
        }
        let least = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::INFINITY, f64::min);
        let most = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::NEG_INFINITY, f64::max);
        let values = || measured.iter().map(|reading| reading.illuminance);
        let mean = values().sum::<f64>() / count;
        let (min, max) = (least(&mut values()), most(&mut values()));
        let half_widths: Option<Vec<f64>> = measured.iter().map(|reading| reading.half_width).collect();
        let of_mean = half_widths.as_ref().map(|half_widths| half_widths.iter().sum::<f64>() / count);
        let is_normal =
            measured.iter().all(|reading| matches!(reading.claim, Claim::Calibrated | Claim::Exact));
        let widening = match (are_joint, is_normal) {
            (true, _) => Some(1.0),
            (false, true) => Some(widening(confidence, measured.len())),
            (false, false) => None,
        };
        // Ends of intervals that hold for all sensors together.
        let ends = half_widths.zip(widening).map(|(half_widths, factor)| {
            let end = |sign: f64| {
                let of_one = |(value, half_width): (f64, &f64)| (value + sign * factor * half_width).max(0.0);
                values().zip(&half_widths).map(of_one).collect::<Vec<f64>>()
            };
            [end(-1.0), end(1.0)]
        });
        let joint = |of: &dyn Fn(&[f64]) -> f64| ends.as_ref().map(|ends| ends.each_ref().map(|end| of(end)));
        let min_interval = joint(&|end| least(&mut end.iter().copied()));
        let means = joint(&|end| end.iter().sum::<f64>() / count);
        let ratio = |a: f64, b: f64| if b > 0.0 { (a / b).min(1.0) } else { 1.0 };
        Some(Self {
            sensors: measured.len(),
            mean: Bounds { value: mean, interval: of_mean.map(|h| [(mean - h).max(0.0), mean + h]) },
            min: Bounds { value: min, interval: min_interval },
            max: Bounds { value: max, interval: joint(&|end| most(&mut end.iter().copied())) },
            uniformity: Bounds {
                value: ratio(min, mean),
                interval: min_interval
                    .zip(means)
                    .map(|(min, mean)| [ratio(min[0], mean[1]), ratio(min[1], mean[0])]),
            },
        })
    }

    /// Confidence `1 − α/n` of each of `n` sensors with which all intervals hold together with the
    /// confidence `1 − α`.
    pub fn joint_confidence(confidence: f64, sensors: usize) -> f64 {
        1.0 - (1.0 - confidence) / sensors.max(1) as f64
    }
}

/// Factor `z(1 − α/2n) / z(1 − α/2)` on a half-width.
fn widening(confidence: f64, sensors: usize) -> f64 {
    let alpha = 1.0 - confidence;
    normal_quantile(1.0 - 0.5 * alpha / sensors as f64) / normal_quantile(1.0 - 0.5 * alpha)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Stop;
    use crate::rng::{Purpose, Stream};

    fn reading(illuminance: f64, half_width: Option<f64>, claim: Claim) -> Reading {
        let stop = Stop::RuleMet;
        Reading { irradiance: [illuminance; 3], illuminance, half_width, claim, stop, rays: 1 }
    }

    #[test]
    fn grids_have_a_mean_extremes_and_a_uniformity() {
        let of = |e: f64| reading(e, Some(0.1 * e), Claim::Calibrated);
        let found = GridSummary::of(&[of(100.0), of(200.0), of(300.0)], 0.95, true).unwrap();
        assert_eq!((found.mean.value, found.min.value, found.max.value), (200.0, 100.0, 300.0));
        assert_eq!(found.mean.interval, Some([180.0, 220.0]));
        assert_eq!(found.min.interval, Some([90.0, 110.0]));
        let [low, high] = found.uniformity.interval.unwrap();
        assert!((low - 90.0 / 220.0).abs() < 1e-12 && (high - 110.0 / 180.0).abs() < 1e-12);
        // Three intervals at 95 % hold together only if they are wider.
        let wider = GridSummary::of(&[of(100.0), of(200.0), of(300.0)], 0.95, false).unwrap();
        let factor = (100.0 - wider.min.interval.unwrap()[0]) / 10.0;
        assert!((factor - 2.394 / 1.960).abs() < 1e-3, "{factor}");
    }

    #[test]
    fn nothing_is_claimed_where_a_sensor_claims_nothing() {
        let good = reading(1.0, Some(0.1), Claim::Calibrated);
        let found = GridSummary::of(&[good, reading(2.0, None, Claim::None)], 0.95, false).unwrap();
        assert_eq!((found.mean.interval, found.uniformity.interval), (None, None));
        let certified = reading(1.0, Some(0.1), Claim::Certified);
        let found = GridSummary::of(&[certified; 2], 0.95, false).unwrap();
        assert!(found.mean.interval.is_some() && found.min.interval.is_none());
        assert!(GridSummary::of(&[certified; 2], 0.95, true).unwrap().min.interval.is_some());
        let dark = reading(0.0, Some(0.0), Claim::Exact);
        assert_eq!(GridSummary::of(&[dark], 0.95, false).unwrap().uniformity.interval, Some([1.0, 1.0]));
        assert!(GridSummary::of(&[Reading { stop: Stop::NotRendered, ..dark }], 0.95, false).is_none());
    }

    /// Normal errors of 40 sensors with a common part: the intervals of all four values cover the
    /// truth at least as often as is claimed. With the half-widths as they are, the smallest value
    /// would be outside of its interval far more often.
    #[test]
    fn intervals_of_a_grid_cover_as_often_as_claimed() {
        const SENSORS: usize = 40;
        const TRIALS: usize = 2000;
        let truth = |k: usize| 100.0 + (k % 7) as f64;
        let mean = (0..SENSORS).map(truth).sum::<f64>() / SENSORS as f64;
        let mut s = Stream::new(1, Purpose::Test, 0);
        let mut normal = || normal_quantile(s.uniform_f64().clamp(1e-12, 1.0 - 1e-12));
        for common in [0.0, 0.9] {
            let mut misses = [0; 4];
            for _ in 0..TRIALS {
                let shared = normal();
                let error = |own: f64| common * shared + f64::sqrt(1.0 - common * common) * own;
                let readings: Vec<Reading> = (0..SENSORS)
                    .map(|k| reading(truth(k) + error(normal()), Some(1.96), Claim::Calibrated))
                    .collect();
                let found = GridSummary::of(&readings, 0.95, false).unwrap();
                let truths = [mean, 100.0, 106.0, 100.0 / mean];
                let bounds = [found.mean, found.min, found.max, found.uniformity];
                for ((misses, bounds), truth) in misses.iter_mut().zip(bounds).zip(truths) {
                    let [low, high] = bounds.interval.unwrap();
                    *misses += usize::from(truth < low || truth > high);
                }
            }
            let most = TRIALS / 20 + 20;
            assert!(misses.iter().all(|misses| *misses <= most), "{misses:?} of {TRIALS}");
        }
    }
}
