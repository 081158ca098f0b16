//! How many gather points a pixel has, and how they are spread.

use std::f32::consts::SQRT_2;

use crate::error::{Error, Result};
use crate::warp;

/// The pixel filter, sampled so that all points of a pixel have equal weight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// Equal weight over the pixel. What other renderers' box-filtered references use.
    #[default]
    Box,
    /// The tent of radius one pixel.
    Tent,
    /// A Gaussian of standard deviation half a pixel.
    Gaussian,
}

impl Filter {
    /// Offset from the pixel's centre (pixels) for a uniform number.
    pub(super) fn warp(self, u: f32) -> f32 {
        match self {
            Self::Box => u - 0.5,
            Self::Tent => warp::tent(u),
            Self::Gaussian => 0.5 * SQRT_2 * inverse_erf(2.0 * u.clamp(1e-6, 1.0 - 1e-6) - 1.0),
        }
    }
}

/// Inverse error function to about 2·10⁻³ (Winitzki 2008), ample for a filter.
fn inverse_erf(x: f32) -> f32 {
    const A: f32 = 0.147;
    let l = crate::math::elementary::ln(1.0 - x * x);
    let b = 2.0 / (std::f32::consts::PI * A) + 0.5 * l;
    ((b * b - l / A).sqrt() - b).sqrt().copysign(x)
}

/// How many gather points a pixel has, and how they are spread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GatherOptions {
    /// Points a pixel, 1 to 1024. Higher: smoother edges, depth of field and mirrors. Default: 4.
    pub points: u32,
    /// The pixel filter.
    pub filter: Filter,
}

impl Default for GatherOptions {
    fn default() -> Self {
        Self { points: 4, filter: Filter::Box }
    }
}

impl GatherOptions {
    /// # Errors
    /// Names the option that is out of range, and the range.
    pub fn validate(&self) -> Result<()> {
        if (1..=1024).contains(&self.points) {
            Ok(())
        } else {
            Err(Error::option("gather", self.points, "1 to 1024"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_have_their_mean_and_variance() {
        let moments = |f: Filter| {
            let n = 100_000;
            let values = (0..n).map(|i| f64::from(f.warp((i as f32 + 0.5) / n as f32)));
            let (sum, squares) = values.fold((0.0, 0.0), |(s, q), v| (s + v, q + v * v));
            (sum / f64::from(n), squares / f64::from(n))
        };
        for (filter, variance) in
            [(Filter::Box, 1.0 / 12.0), (Filter::Tent, 1.0 / 6.0), (Filter::Gaussian, 0.25)]
        {
            let (mean, v) = moments(filter);
            assert!(mean.abs() < 1e-3 && (v / variance - 1.0).abs() < 0.01, "{filter:?}: {mean} {v}");
        }
    }
}
