//! The phase function of Henyey and Greenstein (1941), for scattering in a medium.
//!
//! With `θ` the angle of deflection, 0 for light that continues straight (sr⁻¹):
//!
//! ```text
//! p(cos θ) = (1 − g²) / 4π (1 + g² − 2 g cos θ)^(3/2)          ∫ p dω = 1          ∫ p cos θ dω = g
//! ```
//!
//! The asymmetry `g` is the mean cosine: 0 is isotropic, towards 1 light is scattered forwards,
//! towards −1 backwards. Cosines are drawn by inversion of the cumulative distribution. The usual
//! form of the inverse subtracts nearly equal numbers at small `g`; with `s = 2u − 1` it is this
//! quotient, which does not:
//!
//! ```text
//! cos θ = (s + g (s² + 3) / 2 + g² s + g³ (s² − 1) / 2) / (1 + g s)²
//! ```
//!
//! The density and the cosine are computed in `f64`, so that narrow lobes keep their digits.
//!
//! # Held to this by
//! The tests below: the integral, the mean cosine, and draws against the density.

use std::f32::consts::TAU;
use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::math::elementary::{atan2, sin_cos};
use crate::math::{Frame, Vec3};

/// Asymmetry below which scattering is isotropic to the precision of `f32`.
const ISOTROPIC: f64 = 1e-6;

/// A phase function of Henyey and Greenstein.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HenyeyGreenstein {
    /// The mean cosine `g`, in (−1, 1); 0 is isotropic.
    pub asymmetry: f32,
}

impl HenyeyGreenstein {
    /// Share of the scattered light per solid angle (sr⁻¹). It is also the density of
    /// [`Self::sample`], so that samples have the weight 1.
    ///
    /// * `cos`: cosine of the angle between the directions of propagation before and after
    ///   scattering, of light or of a path.
    #[inline]
    pub fn density(&self, cos: f32) -> f32 {
        let g = f64::from(self.asymmetry);
        // 1 + g² − 2 g cos, in a form that does not subtract nearly equal numbers within a narrow
        // lobe.
        let ahead = (1.0 - g.abs()) * (1.0 - g.abs()) + 2.0 * (g.abs() - g * f64::from(cos));
        let squared = ahead.max((1.0 - g.abs()) * (1.0 - g.abs()));
        ((1.0 - g * g) / (4.0 * PI * squared * squared.sqrt())) as f32
    }

    /// Draws the unit direction of a path after scattering and returns it with its density (sr⁻¹).
    /// `before` is the unit direction of the path before scattering.
    pub fn sample(&self, before: Vec3, u: [f32; 2]) -> (Vec3, f32) {
        let (g, s) = (f64::from(self.asymmetry), 2.0 * f64::from(u[0]) - 1.0);
        let numerator = s + 0.5 * g * (s * s + 3.0) + g * g * s + 0.5 * g * g * g * (s * s - 1.0);
        let cos = (numerator / ((1.0 + g * s) * (1.0 + g * s))).clamp(-1.0, 1.0);
        let sin = (1.0 - cos * cos).sqrt() as f32;
        let (sin_phi, cos_phi) = sin_cos(TAU * u[1]);
        let local = Vec3::new(sin * cos_phi, sin * sin_phi, cos as f32);
        (Frame::about(before).to_world(local).normalize(), self.density(cos as f32))
    }

    /// Returns the numbers that [`Self::sample`] maps to the unit direction `after`, for a path
    /// along the unit direction `before`.
    pub fn sample_inverse(&self, before: Vec3, after: Vec3) -> [f32; 2] {
        let local = Frame::about(before).to_local(after);
        let (g, cos) = (f64::from(self.asymmetry), f64::from(local.z).clamp(-1.0, 1.0));
        let below = if g.abs() < ISOTROPIC {
            0.5 * (1.0 + cos)
        } else {
            let reach = (1.0 + g * g - 2.0 * g * cos).max((1.0 - g.abs()) * (1.0 - g.abs())).sqrt();
            (1.0 - g * g) / (2.0 * g) * (reach.recip() - (1.0 + g).recip())
        };
        let around = atan2(local.y, local.x) / TAU;
        [below.clamp(0.0, 1.0) as f32, around - around.floor()]
    }

    /// Upper bound on the density (sr⁻¹) over an interval of cosines and an interval of
    /// asymmetries.
    ///
    /// * `cos`, `asymmetry`: the least and the largest value of each.
    ///
    /// The density is `(1 − g²) / 4π s^(3/2)` with `s = 1 + g² − 2 g cos`. For `g ≥ 0` it grows
    /// with the cosine, for `g ≤ 0` it falls, so that only the two ends of the interval of cosines
    /// matter. For a given cosine, `s` is least at the `g` nearest to the cosine, and `1 − g²` is
    /// largest at the `g` nearest to zero. If the interval of asymmetries is a single value, the
    /// bound is exact.
    pub fn upper_density(cos: [f32; 2], asymmetry: [f32; 2]) -> f32 {
        let cos = cos.map(|c| f64::from(c).clamp(-1.0, 1.0));
        let [least, largest] = asymmetry.map(f64::from);
        let of = |cos: f64, [least, largest]: [f64; 2]| {
            let g = cos.clamp(least, largest);
            let nearest_zero = 0.0_f64.clamp(least, largest);
            // As in `density`, in a form that does not subtract nearly equal numbers.
            let s = (1.0 - g.abs()) * (1.0 - g.abs()) + 2.0 * (g.abs() - g * cos);
            (1.0 - nearest_zero * nearest_zero) / (4.0 * PI * s * s.sqrt())
        };
        let mut upper = 0.0_f64;
        if largest >= 0.0 {
            upper = upper.max(of(cos[1], [least.max(0.0), largest]));
        }
        if least <= 0.0 {
            upper = upper.max(of(cos[0], [least, largest.min(0.0)]));
        }
        // Covers the rounding of the bound and of the density.
        (upper as f32).next_up().next_up()
    }

    /// The phase function of the nearest asymmetry between −1 and 1; isotropic for NaN.
    pub fn nearest(asymmetry: f32) -> Self {
        let most = 1.0_f32.next_down();
        Self { asymmetry: if asymmetry.is_nan() { 0.0 } else { asymmetry.clamp(-most, most) } }
    }

    /// Returns true if the asymmetry is in range.
    pub fn is_valid(&self) -> bool {
        self.asymmetry.abs() < 1.0
    }
}

#[cfg(test)]
mod tests {
    use statrs::distribution::{ChiSquared, ContinuousCDF};

    use super::*;
    use crate::rng::{Purpose, Stream};

    const ASYMMETRIES: [f32; 9] = [-0.95, -0.5, -1e-3, 0.0, 1e-7, 0.1, 0.6, 0.9, 0.99];

    /// Integral over the cosine. Steps are uniform in `(1 + g² − 2 g cos)^(−1/2)`, of which the
    /// cumulative distribution is a linear function. They are therefore fine within a narrow lobe.
    fn integral(phase: HenyeyGreenstein, of: impl Fn(f64) -> f64) -> f64 {
        let steps = 20_000;
        let g = f64::from(phase.asymmetry);
        let cos = |k: f64| {
            if g.abs() < 0.01 {
                return 2.0 * k - 1.0;
            }
            let reach = |c: f64| (1.0 + g * g - 2.0 * g * c).sqrt().recip();
            let at = reach(-1.0) + (reach(1.0) - reach(-1.0)) * k;
            (1.0 + g * g - (at * at).recip()) / (2.0 * g)
        };
        (0..steps)
            .map(|k| {
                let [a, b, c] = [0.0, 0.5, 1.0].map(|h| cos((f64::from(k) + h) / f64::from(steps)));
                let value = |c: f64| of(c) * f64::from(phase.density(c as f32));
                2.0 * PI * (c - a) * (value(0.5 * (a + b)) + value(b)) * 0.5
            })
            .sum()
    }

    #[test]
    fn it_scatters_all_light_by_the_mean_cosine_that_it_states() {
        for asymmetry in ASYMMETRIES {
            let phase = HenyeyGreenstein { asymmetry };
            // Cosines in single precision are off by 6e-8, which is 1e-3 of the width of the
            // narrowest lobe.
            let [all, mean] = [integral(phase, |_| 1.0), integral(phase, |c| c)];
            assert!((all - 1.0).abs() < 1e-3, "{asymmetry}: {all}");
            assert!((mean - f64::from(asymmetry)).abs() < 1e-3, "{asymmetry}: {mean}");
        }
    }

    /// The counts of drawn directions in cells of the cosine and of the azimuth agree with the
    /// closed form of the cumulative distribution. One `χ²` test for each asymmetry, at a level of
    /// 10⁻⁴ for all together.
    #[test]
    fn directions_follow_the_density() {
        let (draws, slices, sectors) = (40_000_u32, 20, 4);
        for (number, asymmetry) in ASYMMETRIES.into_iter().enumerate() {
            let phase = HenyeyGreenstein { asymmetry };
            let before = Vec3::new(0.48, -0.6, 0.64);
            let frame = Frame::about(before);
            let g = f64::from(asymmetry);
            // Share of the light that is scattered to cosines below `c`: the integral of the
            // density.
            let below = |c: f64| {
                if g.abs() < 1e-5 {
                    return 0.5 * (c + 1.0);
                }
                (1.0 - g * g) / (2.0 * g) * ((1.0 + g * g - 2.0 * g * c).sqrt().recip() - (1.0 + g).recip())
            };
            let mut counts = vec![0_u32; slices * sectors];
            let mut stream = Stream::new(11, Purpose::Test, number as u64);
            for _ in 0..draws {
                let (after, density) = phase.sample(before, stream.uniform_2());
                assert!((after.length() - 1.0).abs() < 1e-5);
                let cos = before.dot(after);
                // A rounded cosine moves the density of the narrowest lobe by 1.5 ε / (1 − g)².
                let off = (phase.density(cos) - density).abs();
                let slack = 1.0 - asymmetry.abs();
                assert!(off <= 2e-6 * density / (slack * slack), "{density} is not that at {cos}");
                let local = frame.to_local(after);
                let sector = usize::from(local.x > 0.0) * 2 + usize::from(local.y > 0.0);
                let slice = (below(f64::from(cos)) * slices as f64).clamp(0.0, slices as f64 - 1.0);
                counts[slice as usize * sectors + sector] += 1;
            }
            let expected = f64::from(draws) / counts.len() as f64;
            let statistic: f64 = counts.iter().map(|&n| (f64::from(n) - expected).powi(2) / expected).sum();
            let p = ChiSquared::new(counts.len() as f64 - 1.0).unwrap().sf(statistic);
            assert!(p > 1e-4 / ASYMMETRIES.len() as f64, "{asymmetry}: χ² {statistic}, p {p}");
        }
    }

    #[test]
    fn directions_are_taken_back_to_their_numbers() {
        let mut stream = Stream::new(3, Purpose::Test, 0);
        for asymmetry in ASYMMETRIES {
            let phase = HenyeyGreenstein { asymmetry };
            let before = Vec3::new(0.48, -0.6, 0.64);
            for _ in 0..1000 {
                let u = stream.uniform_2();
                let (after, density) = phase.sample(before, u);
                let found = phase.sample_inverse(before, after);
                let (again, _) = phase.sample(before, found);
                // The rounding of a cosine by 10⁻⁷, at a density `p`, changes the number by
                // `2π p · 10⁻⁷`.
                assert!((found[0] - u[0]).abs() < 2e-6 * (1.0 + density), "{asymmetry}: {found:?} for {u:?}");
                assert!(again.distance(after) < 2e-3, "{asymmetry}: {again} for {after}");
            }
        }
    }

    /// No density in the ranges is above the bound; for a single asymmetry, some density is close
    /// to it.
    #[test]
    fn the_bound_holds_and_is_sharp() {
        let mut stream = Stream::new(4, Purpose::Test, 0);
        for round in 0..20_000 {
            let mut range = |width: f32, most: f32| {
                let (a, b) = (stream.uniform(), stream.uniform());
                let lo = (2.0 * a - 1.0) * most;
                [lo, (lo + width * b).min(most)]
            };
            let one_asymmetry = round % 2 == 0;
            let (cos, g) = (range(1.0, 1.0), range(if one_asymmetry { 0.0 } else { 0.5 }, 0.99));
            let upper = HenyeyGreenstein::upper_density(cos, g);
            let mut largest = 0.0_f32;
            for k in 0..40 {
                let (u, v) = (k as f32 / 39.0, stream.uniform());
                let phase = HenyeyGreenstein { asymmetry: g[0] + (g[1] - g[0]) * v };
                let density = phase.density(cos[0] + (cos[1] - cos[0]) * u);
                assert!(density <= upper, "{density} > {upper} for {cos:?} and {g:?}");
                largest = largest.max(density);
            }
            assert!(!one_asymmetry || upper <= 1.001 * largest, "{upper} for {largest}: {cos:?}, {g:?}");
        }
    }

    #[test]
    fn asymmetries_are_below_one() {
        let is_valid = |asymmetry| HenyeyGreenstein { asymmetry }.is_valid();
        assert!(is_valid(-0.999) && is_valid(0.0) && is_valid(0.999));
        assert!(!is_valid(1.0) && !is_valid(-1.0) && !is_valid(f32::NAN));
    }
}
