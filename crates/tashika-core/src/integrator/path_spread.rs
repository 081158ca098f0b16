//! Spread of the mean of a pixel's paths, by its own paths and those of its neighbourhood.
//!
//! A hundred paths of a pixel may all miss the bright one in a thousand; those of its neighbours
//! together do not.
//!
//! ```text
//! V = max(s², (n s² + w s'²) / (n + w)) / n          ν = n + w − 1          b = max(x, x') / n
//! ```
//!
//! with the sample variance `s²` and the largest value `x` of the pixel's `n` paths, and `s'²` and
//! `x'` of those of the neighbourhood. The variance is never below that of the pixel's own paths.

use crate::stats::Moments;

/// `w`: number of the pixel's own paths that weigh as much as the neighbourhood.
const NEIGHBOURHOOD_WEIGHT: f64 = 256.0;
/// Factor `κ` of paths and of VPLs, of which few are far brighter than most: that of Bernstein's
/// inequality.
pub(super) const KAPPA_OF_PATHS: f64 = 1.0 / 3.0;

/// Error statistics of a mean of paths.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathSpread {
    /// `V`, the variance of the mean.
    pub variance: f64,
    /// `ν`, the degrees of freedom, at least 1.
    pub freedom: f64,
    /// `b`: the most that one path adds to the mean, as far as observed.
    pub largest: f64,
}

impl PathSpread {
    /// Spread from a pixel's own paths, and from those of its neighbourhood, which no estimate
    /// uses.
    pub fn of(own: &Moments, nearby: &Moments) -> Self {
        let count = own.count() as f64;
        let weight = NEIGHBOURHOOD_WEIGHT.min(nearby.count() as f64);
        let pooled = (count * own.variance() + weight * nearby.variance()) / (count + weight).max(1.0);
        Self {
            variance: pooled.max(own.variance()) / count.max(1.0),
            freedom: (count + weight - 1.0).max(1.0),
            largest: own.largest().max(nearby.largest()) / count.max(1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moments(values: impl IntoIterator<Item = f64>) -> Moments {
        let mut moments = Moments::default();
        values.into_iter().for_each(|value| moments.push(value));
        moments
    }

    /// A hundred dark paths beside neighbours of which one in fifty met a caustic; and a pixel with
    /// a larger variance than its neighbours, which do not reduce it.
    #[test]
    fn neighbours_tell_what_a_pixel_has_not_met_and_never_that_it_varies_less() {
        let own = moments((0..100).map(|k| f64::from(k % 2)));
        let bright = moments((0..1000).map(|k| if k % 50 == 0 { 40.0 } else { 0.5 }));
        let alone = PathSpread::of(&own, &Moments::default());
        assert!((alone.variance * 100.0 / own.variance() - 1.0).abs() < 1e-12);
        assert_eq!((alone.freedom, alone.largest), (99.0, 0.01));
        let told = PathSpread::of(&own, &bright);
        let pooled = (100.0 * own.variance() + 256.0 * bright.variance()) / 356.0;
        assert!((told.variance * 100.0 / pooled - 1.0).abs() < 1e-12);
        assert_eq!((told.freedom, told.largest), (355.0, 0.4));
        let calm = PathSpread::of(&bright, &own);
        assert!((calm.variance * 1000.0 / bright.variance() - 1.0).abs() < 1e-12);
    }
}
