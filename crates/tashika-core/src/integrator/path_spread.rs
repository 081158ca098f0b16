//! Spread of the mean of a pixel's paths, estimated from these paths and from paths of the
//! neighbourhood.
//!
//! If one path in a thousand is bright, the hundred paths of a pixel may all be dark. The paths of
//! its neighbours, taken together, include bright ones.
//!
//! ```text
//! V = max(s², (n s² + w s'²) / (n + w)) / n          ν = n + w − 1          b = max(x, x') / n
//! ```
//!
//! `s²` is the sample variance and `x` the largest value of the pixel's `n` paths; `s'²` and `x'`
//! are those of the paths of the neighbourhood. `V` is never below `s²/n`.

use crate::stats::Moments;

/// `w`: number of the pixel's own paths that weigh as much as the neighbourhood.
const NEIGHBOURHOOD_WEIGHT: f64 = 256.0;
/// Factor `κ` for paths and VPLs, few of which are far brighter than most: the 1/3 of Bernstein's
/// inequality.
pub(super) const KAPPA_OF_PATHS: f64 = 1.0 / 3.0;

/// Error statistics of a mean of paths.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathSpread {
    /// `V`, the variance of the mean.
    pub variance: f64,
    /// `ν`, the degrees of freedom, at least 1.
    pub freedom: f64,
    /// `b`: largest observed contribution of one path to the mean.
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

    /// A pixel has 100 paths without a bright one. Of 1000 paths of the neighbourhood, one in fifty
    /// met a caustic. Variance and largest value include the neighbourhood. With the roles
    /// exchanged, the neighbourhood does not reduce the variance.
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
