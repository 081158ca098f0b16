//! Pixel filters: distributions of the camera samples in and around a pixel.
//!
//! A pixel is the mean of its samples, all of equal weight. The offsets `x` of samples from the
//! pixel's centre (pixels, each axis by itself) have the filter as their density `f` (Ernst et al.
//! 2006). An offset is drawn by the inverse of the cumulative distribution,
//!
//! ```text
//! F(x(u)) = u        F(x) = ∫_{−∞}^x f        u uniform on [0, 1)
//! ```
//!
//! | filter | `f(x)` | where | variance (pixels²) |
//! |---|---|---|---:|
//! | box | 1 | `\|x\| ≤ 1/2` | 1/12 |
//! | tent | `1 − \|x\|` | `\|x\| ≤ 1` | 1/6 |
//! | Gaussian | of standard deviation 1/2 | everywhere; drawn to 2.4 | 1/4 |
//! | Blackman-Harris | `Σ_k a_k cos(kπx/r) / (2 r a_0)` | `\|x\| ≤ r = 3/2` | 0.173 |
//!
//! The Blackman-Harris filter is the window of four terms with the smallest side lobes (Harris
//! 1978). It is three pixels wide.
//!
//! Filters with negative lobes (Mitchell and Netravali, Lanczos) are not densities. Their samples
//! would need weights of both signs, and a pixel would not be a mean of samples of equal weight, as
//! its claim requires. So no such filter is offered.
//!
//! # Guarantee
//! `F(x(u))` is `u` to within 2⁻²⁴ for all filters except the Gaussian, for which it is within
//! 5·10⁻⁴. The bits of `x(u)` are the same on every machine.
//!
//! # Held to this by
//! The tests below; the suite's `filters`, by edges and constants that are rendered.

use std::f32::consts::SQRT_2;
use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

use crate::error::{Error, Result};
use crate::math::elementary::{ln, sin_cos_f64};
use crate::warp;

/// Pixel filter, sampled so that all points of a pixel have equal weight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// Equal weight over the pixel, as in the box filters of other renderers.
    #[default]
    Box,
    /// Tent of radius one pixel.
    Tent,
    /// Gaussian of standard deviation half a pixel.
    Gaussian,
    /// Blackman-Harris window of four terms, of radius one pixel and a half.
    BlackmanHarris,
}

impl Filter {
    /// All filters, in the order in which they are offered to users.
    pub const ALL: [Self; 4] = [Self::Box, Self::Tent, Self::Gaussian, Self::BlackmanHarris];

    /// Returns the name by which users choose the filter.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Tent => "tent",
            Self::Gaussian => "gaussian",
            Self::BlackmanHarris => "blackman-harris",
        }
    }

    /// Returns the largest offset from the pixel's centre (pixels).
    pub(super) fn reach(self) -> f32 {
        self.warp(0.0).abs().max(self.warp(1.0_f32.next_down()).abs())
    }

    /// Returns the offset from the pixel's centre (pixels) for a uniform number.
    pub(super) fn warp(self, u: f32) -> f32 {
        match self {
            Self::Box => u - 0.5,
            Self::Tent => warp::tent(u),
            Self::Gaussian => 0.5 * SQRT_2 * inverse_erf(2.0 * u.clamp(1e-6, 1.0 - 1e-6) - 1.0),
            Self::BlackmanHarris => blackman_harris(u),
        }
    }
}

impl fmt::Display for Filter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Filter {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|filter| filter.name() == name).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            Error::option("filter", name, format!("one of {names}"))
        })
    }
}

/// Returns the inverse error function to about 2·10⁻³ (Winitzki 2008), ample for a filter.
fn inverse_erf(x: f32) -> f32 {
    const A: f32 = 0.147;
    let l = ln(1.0 - x * x);
    let b = 2.0 / (std::f32::consts::PI * A) + 0.5 * l;
    ((b * b - l / A).sqrt() - b).sqrt().copysign(x)
}

/// Radius of the Blackman-Harris window (pixels).
const RADIUS: f64 = 1.5;
/// Coefficients of the window (Harris 1978, the minimum of four terms, −92 dB).
const WINDOW: [f64; 4] = [0.358_75, 0.488_29, 0.141_28, 0.011_68];

/// Returns the offset below which the share `u` of the window lies.
///
/// With the angle `θ = π|x|/r` in `[0, π]` this is the root of
///
/// ```text
/// W(θ) = a_0 θ + Σ_k a_k sin(kθ)/k = 2π a_0 |u − 1/2|
/// ```
///
/// whose derivative, the window, falls from 1 to 6·10⁻⁵. So `W` is concave, and Newton's steps from
/// 0 rise to the root and never pass it. They end when the share that is left is below 2⁻²⁶: after
/// 4 steps on average, after 13 where `u` is 0.
fn blackman_harris(u: f32) -> f32 {
    const MOST_STEPS: u32 = 16;
    let [a0, a1, a2, a3] = WINDOW;
    let whole = 2.0 * PI * a0;
    let u = f64::from(u) - 0.5;
    let wanted = whole * u.abs();
    let mut theta = 0.0;
    for _ in 0..MOST_STEPS {
        let (s, c) = sin_cos_f64(theta);
        let (s2, c2) = (2.0 * s * c, 2.0 * c * c - 1.0);
        let (s3, c3) = (s * c2 + c * s2, c * c2 - s * s2);
        let left = wanted - (a0 * theta + a1 * s + a2 / 2.0 * s2 + a3 / 3.0 * s3);
        if left <= whole / f64::from(1 << 26) {
            break;
        }
        theta = (theta + left / (a0 + a1 * c + a2 * c2 + a3 * c3)).min(PI);
    }
    (RADIUS / PI * theta).copysign(u) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary::erfc;

    /// Returns the share of the window below `x`, by Simpson's sums from the centre: an error below
    /// 10⁻¹².
    fn share_of_window(x: f64) -> f64 {
        let integral = |to: f64| -> f64 {
            const PIECES: u32 = 400;
            let h = to / f64::from(2 * PIECES);
            let window = |k: u32| {
                let angle = PI * f64::from(k) * h / RADIUS;
                let term = |(k, a): (usize, f64)| a * sin_cos_f64(k as f64 * angle).1;
                WINDOW.into_iter().enumerate().map(term).sum::<f64>()
            };
            let pieces = (0..PIECES).map(|k| window(2 * k) + 4.0 * window(2 * k + 1) + window(2 * k + 2));
            pieces.sum::<f64>() * h / 3.0
        };
        0.5 + integral(x) / (2.0 * integral(RADIUS))
    }

    fn cumulative(filter: Filter, x: f64) -> f64 {
        match filter {
            Filter::Box => x + 0.5,
            Filter::Tent if x < 0.0 => 0.5 * (1.0 + x) * (1.0 + x),
            Filter::Tent => 1.0 - 0.5 * (1.0 - x) * (1.0 - x),
            Filter::Gaussian => 0.5 * erfc(-x * std::f64::consts::SQRT_2),
            Filter::BlackmanHarris => share_of_window(x),
        }
    }

    #[test]
    fn offsets_are_the_inverse_of_the_cumulative_distribution() {
        // The ends, numbers next to the ends and to the middle, powers of two, and numbers in
        // between.
        let small = (1..=24).map(|k| 1.0 / (1_u32 << k) as f32);
        let edges = small.flat_map(|v| [v, 1.0 - v, 0.5 - 0.5 * v, 0.5 + 0.5 * v]);
        let between = (0..2048).map(|k| (k as f32 + 0.37) / 2048.0);
        for u in [0.0].into_iter().chain(edges).chain(between) {
            for filter in Filter::ALL {
                let x = filter.warp(u);
                let error = (cumulative(filter, x.into()) - f64::from(u)).abs();
                // Rounding of offsets below 1 is at most 2⁻²⁵, and no density is above 1; the
                // residual of the search is below 2⁻²⁶. For the Gaussian, Winitzki's function is
                // the exact inverse of a function that is within 1.3·10⁻⁴ of erf, which gives half
                // of that error in the share. Near the centre, a root is taken of the difference of
                // two numbers above 4. Each is rounded by 2.4·10⁻⁷, which changes the share by
                // 4·10⁻⁴.
                let tolerance = if filter == Filter::Gaussian { 5e-4 } else { 1.0 / f64::from(1 << 24) };
                assert!(error <= tolerance, "{filter} {u:e}: {x}, {error:e}");
                if filter == Filter::BlackmanHarris {
                    assert!(x.abs() <= RADIUS as f32);
                    assert!(u == 0.0 || filter.warp(1.0 - u) == -x || 1.0 - (1.0 - u) != u, "{u}");
                }
            }
        }
        assert_eq!(Filter::BlackmanHarris.warp(0.5), 0.0);
    }

    /// The window's variance is `r² (1/3 + 2/(a_0 π²) Σ_k (−1)ᵏ a_k/k²)`, since
    /// `∫_{−1}^1 t² cos(kπt) dt = 4 (−1)ᵏ/(kπ)²`.
    #[test]
    fn filters_have_their_mean_and_variance() {
        let [a0, a1, a2, a3] = WINDOW;
        let window = RADIUS * RADIUS * (1.0 / 3.0 + 2.0 / (a0 * PI * PI) * (-a1 + a2 / 4.0 - a3 / 9.0));
        assert!((window - 0.173).abs() < 5e-4, "as the table above has it: {window}");
        // The middles of equal parts of the unit interval, each without rounding.
        let parts = 1_u32 << 16;
        for (filter, variance, reach, approximation) in [
            (Filter::Box, 1.0 / 12.0, 0.5, 0.0),
            (Filter::Tent, 1.0 / 6.0, 1.0, 0.0),
            // Winitzki's inverse is within 2·10⁻³ of its value.
            (Filter::Gaussian, 0.25, 2.5, 4e-3),
            (Filter::BlackmanHarris, window, RADIUS, 0.0),
        ] {
            let offsets = || (0..parts).map(|k| f64::from(filter.warp((k as f32 + 0.5) / parts as f32)));
            let mean = offsets().sum::<f64>() / f64::from(parts);
            let found = offsets().map(|x| x * x).sum::<f64>() / f64::from(parts);
            // The value at the middle of a part differs from the mean over the part by at most the
            // change over the part. Over all parts, the changes add up to twice the reach for `x`,
            // and to twice the square of the reach for `x²`. Offsets are rounded to less than 10⁻⁶.
            let (of_mean, of_square) = (2.0 * reach, 2.0 * reach * reach);
            assert!(mean.abs() <= of_mean / f64::from(parts) + 1e-6, "{filter}: mean {mean}");
            let tolerance = of_square / f64::from(parts) + approximation * variance + 1e-6;
            assert!((found - variance).abs() <= tolerance, "{filter}: variance {found} for {variance}");
        }
    }

    #[test]
    fn names_are_read_back() {
        for filter in Filter::ALL {
            assert_eq!(filter.to_string().parse::<Filter>().unwrap(), filter);
        }
        let said = "mitchell".parse::<Filter>().unwrap_err().to_string();
        assert_eq!(said, "filter = mitchell; expected one of box, tent, gaussian, blackman-harris");
        assert!("Box".parse::<Filter>().is_err() && "".parse::<Filter>().is_err());
    }
}
