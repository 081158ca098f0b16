//! Upper bounds of the reflectance of facets over all angles of incidence up to a given one.
//!
//! With `c` the cosine of the angle of incidence, `N = η + i k` and `w = √(1 + (N² − 1) / c²)`:
//!
//! * Schlick's `F₀ + (1 − F₀)(1 − c)⁵` falls with `c` (Schlick 1994).
//! * A dielectric's `F = ½ ((w − 1)/(w + 1))² + ½ ((w − η²)/(w + η²))²` does *not* always fall with
//!   `c`: for `η = 5` it is 0.44 at normal incidence and 0.42 at 80°. With `a = η²`, its derivative
//!   by `w` has the sign of `(w² − a)((1 + a)(w² + a) + (6a − 1 − a²) w)`. The product of the two
//!   roots of the second factor is `a`, so at most one of them is above `√a`, the value of `w` at
//!   normal incidence. As `w` grows and `c` falls, `F` therefore either falls and then grows, or
//!   only grows. Its maximum over a range of `c` is at an end of the range. For `η + 1/η ≤ 4` it
//!   only grows.
//! * A conductor: `F ≤ R_s = |(w − 1)/(w + 1)|²`, the reflectance of s-polarised light, since that
//!   of p-polarised light is never larger. `z = (w − 1)/(w + 1)` is the inverse of Koebe's
//!   function: `4z/(1 − z)² = w² − 1 = (N² − 1)/c²`. Koebe's function maps the unit disk to a
//!   region that is star-shaped about zero; along a ray from zero, `|z|` therefore grows (Schwarz's
//!   lemma). So `R_s` falls with `c`. It is at most twice `F`; for metals it is hardly larger than
//!   `F`.
//!
//! # Guarantee
//! The bounds are at least the `f32` values of [`bsdf::fresnel`](crate::bsdf::fresnel). The
//! functions below state the roundings that are allowed for.
//!
//! # Held to this by
//! The tests below, `bounds::tests::reflector`.

use crate::bsdf::boundary::Boundary;
use crate::bsdf::{TintedFresnel, fresnel};
use crate::color::Rgb;

/// Reflectance of a facet, times a factor.
#[derive(Clone, Copy, Debug)]
pub(in crate::bounds) enum Reflected {
    /// Schlick's approximation.
    Schlick {
        /// Factor, by channel.
        scale: Rgb,
        /// Reflectance at normal incidence, by channel.
        f0: Rgb,
    },
    /// A dielectric, by the Fresnel equations.
    Dielectric {
        /// Largest channel of the factor.
        scale: f32,
        /// Relative index, at least 1.
        ior: f32,
    },
    /// A metal, by the Fresnel equations.
    Conductor {
        /// Factor, by channel.
        scale: Rgb,
        /// Real part of the index.
        eta: Rgb,
        /// Imaginary part of the index.
        k: Rgb,
    },
    /// A weighted mean of Schlick's approximation and the reflectance of a dielectric.
    Tinted {
        /// Factor.
        scale: f32,
        /// Reflectance without the factor.
        fresnel: TintedFresnel,
    },
}

impl Reflected {
    /// Returns true if nothing is reflected at any angle.
    pub(in crate::bounds) fn is_black(&self) -> bool {
        match self {
            Self::Schlick { scale, .. } | Self::Conductor { scale, .. } => scale.max_channel() <= 0.0,
            Self::Dielectric { scale, .. } => *scale <= 0.0,
            // At grazing angles the reflectance is always 1.
            Self::Tinted { scale, .. } => *scale <= 0.0,
        }
    }

    /// The reflectance times `factor`.
    pub(super) fn scaled(mut self, factor: f32) -> Self {
        match &mut self {
            Self::Schlick { scale, .. } | Self::Conductor { scale, .. } => *scale *= factor,
            Self::Dielectric { scale, .. } | Self::Tinted { scale, .. } => *scale *= factor,
        }
        self
    }

    /// Upper bound of the largest channel of the reflectance at any angle of incidence whose cosine
    /// is at least `cos`.
    pub(in crate::bounds) fn upper(&self, cos: f64) -> f64 {
        match *self {
            Self::Schlick { scale, f0 } => {
                // Rounding down the cosine enlarges the angle.
                let reflected = Rgb::from(fresnel::schlick(f0, (cos as f32).next_down().max(0.0))) * scale;
                f64::from(reflected.max_channel())
            }
            Self::Dielectric { scale, ior } => f64::from(scale) * upper_dielectric(cos, ior),
            Self::Conductor { scale, eta, k } => {
                let channels = eta.zip(k, |eta, k| upper_conductor(cos, f64::from(eta), f64::from(k)) as f32);
                f64::from((channels * scale).max_channel())
            }
            Self::Tinted { scale, fresnel: TintedFresnel { schlick, f0, ior } } => {
                let (schlick, scale) = (f64::from(schlick), f64::from(scale));
                let tinted = Self::Schlick { scale: Rgb::WHITE, f0 }.upper(cos);
                scale * (schlick * tinted + (1.0 - schlick) * upper_dielectric(cos, ior))
            }
        }
    }
}

/// Upper bound of `fresnel::dielectric` at any cosine in `[cos, 1]`.
fn upper_dielectric(cos: f64, ior: f32) -> f64 {
    let grazing = fresnel::dielectric((cos as f32).next_down().max(0.0), ior);
    let root = f64::from(grazing.max(fresnel::dielectric(1.0, ior))).sqrt();
    // Here and in `fresnel::dielectric`, both amplitudes are off by less than six roundings of 1.
    let root = root + 1e-6;
    (root * root).min(1.0)
}

/// Upper bound of `1 − fresnel::dielectric` at any cosine in `[0, cos]`.
///
/// For an index of up to `2 + √3`, transmittance grows with the cosine. For larger ones,
/// `F ≥ R_s / 2 ≥ F(1) / 2`.
pub(in crate::bounds) fn upper_transmittance(cos: f64, ior: f32) -> f64 {
    let reflected = if ior < 3.73 {
        fresnel::dielectric((cos as f32).next_up().min(1.0), ior)
    } else {
        0.5 * fresnel::dielectric(1.0, ior)
    };
    // Twelve roundings of 1 in each of the two values of F.
    (1.0 - f64::from(reflected) + 4e-6).min(1.0)
}

/// Number of pieces into which the range of cosines is divided to bound a rough boundary.
const PIECES: u32 = 8;

/// Upper bound of [`Boundary::transmittance`] at any cosine in `[0, cos]`. In each piece, the
/// smooth boundary is bounded by its value at the end that makes the result large. The cubic is
/// bounded by its largest Bernstein coefficient, which no value of the cubic exceeds.
pub(in crate::bounds) fn upper_passed(cos: f64, ior: f32, boundary: &Boundary) -> f64 {
    let (share, cubic) = boundary.fit();
    if cubic == [0.0; 4] {
        return upper_transmittance(cos, ior);
    }
    let share = f64::from(share);
    let [a, b, c, d] = cubic.map(f64::from);
    let of_piece = |piece: u32| {
        let [low, high] = [piece, piece + 1].map(|end| cos * f64::from(end) / f64::from(PIECES));
        let width = high - low;
        // Taylor coefficients of the cubic at the lower end, in units of the width.
        let slope = (b + low * (2.0 * c + 3.0 * d * low)) * width;
        let bend = (c + 3.0 * d * low) * width * width;
        let start = a + low * (b + low * (c + d * low));
        let coefficients = [
            start,
            start + slope / 3.0,
            start + (2.0 * slope + bend) / 3.0,
            start + slope + bend + d * width * width * width,
        ];
        let smooth =
            if share > 0.0 { upper_transmittance(high, ior) } else { 1.0 - upper_dielectric(low, ior) };
        share * smooth + coefficients.into_iter().fold(f64::NEG_INFINITY, f64::max)
    };
    let largest = (0..PIECES).map(of_piece).fold(0.0, f64::max);
    // Covers ten roundings of the largest term of the fit, which is below 8.
    (largest + 5e-6).min(1.0)
}

/// Upper bound of one channel of `fresnel::conductor` at any cosine in `[cos, 1]`: `R_s`, increased
/// by a bound of its rounding errors.
///
/// Let `q = √(N² − s²)` and `R_s = |(c − q)/(c + q)|²`. In `f32` the error of `q²` is
/// `ε = 4·10⁻⁷ (|N|² + 1)`. Hence the error of `q` is `min(√ε, ε/|q|)`, and that of the amplitude
/// `2/max(c, |q|)` times as large. The real part of `q` is the root of a sum that may cancel,
/// `½(|q²| + Re q²)`; where it cancels, `R_s` is above one half and off by at most 7·10⁻⁴.
/// `|c − q|²` is a difference, too: its error is eight roundings of 1 in `R_s`.
fn upper_conductor(cos: f64, eta: f64, k: f64) -> f64 {
    let sin2 = (1.0 - cos) * (1.0 + cos);
    let real = (eta - k) * (eta + k) - sin2;
    let imaginary = 2.0 * eta * k;
    let modulus = (real * real + imaginary * imaginary).sqrt();
    let a = (0.5 * (modulus + real)).max(0.0).sqrt();
    let (sum, mixed) = (modulus + cos * cos, 2.0 * cos * a);
    let across = ((sum - mixed).max(0.0) / (sum + mixed).max(f64::MIN_POSITIVE)).sqrt();
    let error = 4e-7 * (eta * eta + k * k + 1.0);
    let q = modulus.sqrt();
    let amplitude = across + 2.0 * error.sqrt().min(error / q.max(1e-30)) / cos.max(q).max(1e-30);
    (amplitude * amplitude * (1.0 + 2e-3) + 1e-6).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    /// Cosines from grazing to normal incidence, dense where the reflectance is steep.
    fn cosines() -> impl DoubleEndedIterator<Item = f64> {
        (0..=400).map(|i| (f64::from(i) / 400.0).powi(3))
    }

    /// Compares the bound with all reflectances from normal incidence outwards. Returns the largest
    /// ratio of the bound to the largest reflectance so far.
    fn check(facets: &Reflected, reflected: impl Fn(f32) -> f32) -> f64 {
        let (mut largest, mut loosest) = (0.0_f64, 1.0_f64);
        for cos in cosines().rev() {
            largest = largest.max(f64::from(reflected(cos as f32)));
            let bound = facets.upper(cos);
            assert!(largest <= bound * (1.0 + 1e-6), "{facets:?} at {cos}: {largest} above {bound}");
            if largest > 1e-3 {
                loosest = loosest.max(bound / largest);
            }
        }
        loosest
    }

    #[test]
    fn dielectrics_hold_and_are_tight() {
        for step in 0..=200 {
            let ior = 1.0001 + 3.9999 * (step as f32 / 200.0).powi(3);
            let facets = Reflected::Dielectric { scale: 1.0, ior };
            // The tolerance covers a step of the cosine by one rounding, and 10⁻⁶ of an amplitude
            // above 0.03.
            assert!(check(&facets, |cos| fresnel::dielectric(cos, ior)) < 1.001, "{ior}");
        }
    }

    #[test]
    fn metals_hold_and_are_tight() {
        let mut s = Stream::new(33, Purpose::Test, 0);
        for round in 0..500 {
            let low = [1e-3, 0.1, 0.9, 1.0][round % 4];
            let eta = low + 3.0 * s.uniform() * s.uniform() * s.uniform();
            let k = [0.0, 0.01, 1.0, 8.0][round / 4 % 4] * s.uniform();
            let facets = Reflected::Conductor { scale: Rgb::WHITE, eta: Rgb::gray(eta), k: Rgb::gray(k) };
            let loosest = check(&facets, |cos| fresnel::conductor(cos, Rgb::gray(eta), Rgb::gray(k))[0]);
            if eta > 1.1 || k > 0.1 {
                // R_s ≤ 2 F. The tolerance covers the 2·10⁻³ of the cancelling root and twice the
                // error of an amplitude of 0.03.
                assert!(loosest < 2.01, "{eta} + {k} i: {loosest}");
            }
        }
        // Where the indices are nearly equal, the `f32` value at grazing angles is still positive.
        for (eta, k) in [(1.0, 0.0), (1.0, 1e-4), (1.0, 0.01), (0.9999, 0.0), (1.0001, 0.0), (1.001, 1e-3)] {
            let facets = Reflected::Conductor { scale: Rgb::WHITE, eta: Rgb::gray(eta), k: Rgb::gray(k) };
            check(&facets, |cos| fresnel::conductor(cos, Rgb::gray(eta), Rgb::gray(k))[0]);
        }
        // Silver, gold and aluminium at 550 nm.
        for (eta, k) in [(0.06, 3.6), (0.36, 2.77), (0.96, 6.7)] {
            let facets = Reflected::Conductor { scale: Rgb::WHITE, eta: Rgb::gray(eta), k: Rgb::gray(k) };
            let loosest = check(&facets, |cos| fresnel::conductor(cos, Rgb::gray(eta), Rgb::gray(k))[0]);
            assert!(loosest < 1.15, "{eta} + {k} i: {loosest}");
        }
    }

    #[test]
    fn schlick_holds_and_is_tight() {
        for f0 in [Rgb::BLACK, Rgb::new(0.04, 0.5, 1.0), Rgb::gray(0.04)] {
            let scale = Rgb::new(1.0, 0.5, 0.25);
            let facets = Reflected::Schlick { scale, f0 };
            let loosest = check(&facets, |cos| (Rgb::from(fresnel::schlick(f0, cos)) * scale).max_channel());
            assert!(loosest < 1.0 + 1e-5, "{f0:?}: {loosest}");
        }
    }

    #[test]
    fn transmittances_hold_and_are_tight() {
        for step in 0..=200 {
            let ior = 1.0001 + 3.9999 * (step as f32 / 200.0).powi(3);
            let mut largest = 0.0_f64;
            for cos in cosines() {
                largest = largest.max(f64::from(1.0 - fresnel::dielectric(cos as f32, ior)));
                let bound = upper_transmittance(cos, ior);
                assert!(largest <= bound, "{ior} at {cos}: {largest} above {bound}");
                if ior < 3.7 {
                    assert!(
                        bound - largest < 1e-5 + 1e-4 * (1.0 - largest),
                        "{ior} at {cos}: {bound} for {largest}"
                    );
                }
            }
        }
    }
}
