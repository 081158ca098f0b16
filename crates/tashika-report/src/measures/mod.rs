//! Error of a picture against its reference by the measures that the field reports.
//!
//! With the colours `x` (linear RGB, W·m⁻²·sr⁻¹) and those of the reference, `r`, over `n` pixels
//! and their three channels:
//!
//! ```text
//! RMSE   = √( Σ (x − r)² / 3n )                          unit of the film
//! relMSE = Σ (x − r)² / (r² + 0.01) / 3n                  0.01 in the unit of the film, squared
//! PSNR   = −10 log₁₀( Σ (X − R)² / 3n )                  dB, of the display picture; its peak is 1
//! SSIM   = mean of the map of `ssim`                     of the display picture's luma
//! FLIP   = mean of the map of `flip`                     of the display picture, 67 pixels per degree
//! ```
//!
//! relMSE is that of Rousselle et al. 2011. The constant, which prevents black references from
//! dominating, is a choice: 10⁻² and 10⁻³ are in use.
//!
//! # The display picture
//! `X = sRGB(clamp(2ᵉ x, 0, 1))` by IEC 61966-2-1, without rounding to bytes and without a
//! shoulder. The exposure `e` of both pictures is the automatic exposure of the reference
//! ([`automatic_stops`]). So all pictures that are compared with one reference have one exposure,
//! whatever the unit of radiance in its scene.
//!
//! # Omitted pixels
//! Pixels that were not rendered, or that are not finite in one of the two, enter no mean. Around
//! them SSIM uses the rest of a window, and FLIP sees equal colours in both pictures.
//! [`super::Comparison::failed`] counts the pixels that are not finite in the image alone.
//!
//! # Guarantee
//! Equal pictures have the RMSE, relMSE and FLIP 0, the SSIM 1 and an infinite PSNR. FLIP is in 0
//! to 1.
//!
//! # Held to this by
//! `tests`: PSNR, SSIM and FLIP by independent programs (`scripts/picture_measures.py`), the others
//! by closed forms.

mod flip;
mod grid;
mod ssim;

use super::pairs::{Pairs, Pixel};
use crate::color::{Rgb, srgb_encode};
use crate::film::{Window, automatic_stops};
use crate::math::elementary::{ln_f64, powf};

/// Added to the squared reference in relMSE (unit of the film, squared).
const LEAST_SQUARE: f64 = 0.01;
/// Pixels per degree of the visual field: a monitor of 3840 × 2160 pixels, 0.7 m wide, seen from
/// 0.7 m (Andersson et al. 2020).
const PIXELS_PER_DEGREE: f64 = 67.0;

/// Measures of a picture against its reference; see the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measures {
    /// Root mean squared error of linear RGB (unit of the film).
    pub rmse: f64,
    /// Mean of the squared errors over the squared reference plus 0.01.
    pub relmse: f64,
    /// Peak signal-to-noise ratio of the display picture (dB); infinite if the pictures are equal.
    pub psnr: f64,
    /// Structural similarity of the display picture's luma, −1 to 1 (Wang et al. 2004); `None` if
    /// no window of 11 × 11 pixels is inside.
    pub ssim: Option<f64>,
    /// LDR-FLIP of the display picture, 0 to 1, at 67 pixels per degree (Andersson et al. 2020).
    pub flip: f64,
    /// Exposure of both display pictures (stops).
    pub exposure_stops: f64,
}

impl Measures {
    /// Measures two films; `None` if no pixel is finite in both.
    pub(super) fn of(window: Window, pairs: Pairs<'_>) -> Option<Self> {
        let (mut squared, mut relative, mut count) = (0.0, 0.0, 0_u64);
        for pixel in pairs.pixels() {
            let Pixel::Finite { color, truth } = pixel else { continue };
            for (x, r) in color.to_array().into_iter().zip(truth.to_array()) {
                let [x, r] = [x, r].map(f64::from);
                squared += (x - r) * (x - r);
                relative += (x - r) * (x - r) / (r * r + LEAST_SQUARE);
            }
            count += 3;
        }
        if count == 0 {
            return None;
        }
        let (pictures, stops) = Pictures::of(window, pairs);
        Some(Self {
            rmse: (squared / count as f64).sqrt(),
            relmse: relative / count as f64,
            psnr: pictures.psnr(),
            ssim: ssim::mean(&pictures),
            flip: pictures.mean(&flip::map(&pictures, PIXELS_PER_DEGREE)),
            exposure_stops: stops.into(),
        })
    }
}

/// An image and its reference as a display shows them, before encoding: linear RGB of 0 to 1.
struct Pictures {
    width: usize,
    colors: [Vec<Rgb>; 2],
    /// True for pixels that are finite in both.
    is_there: Vec<bool>,
}

impl Pictures {
    /// Exposes two films by the reference; also returns the stops.
    fn of(window: Window, pairs: Pairs<'_>) -> (Self, f32) {
        let stops = automatic_stops(pairs.pixels().map(|pixel| match pixel {
            Pixel::Failed { truth } | Pixel::Finite { truth, .. } => truth.luminance(),
            Pixel::NotRendered | Pixel::NoTruth => 0.0,
        }));
        let scale = powf(2.0, stops);
        let shown = |color: Rgb| color.map(|v| (v * scale).clamp(0.0, 1.0));
        let mut pictures =
            Self { width: window.width as usize, colors: [Vec::new(), Vec::new()], is_there: Vec::new() };
        for pixel in pairs.pixels() {
            let (both, is_there) = match pixel {
                Pixel::Finite { color, truth } => ([color, truth], true),
                Pixel::Failed { truth } => ([truth; 2], false),
                Pixel::NotRendered | Pixel::NoTruth => ([Rgb::BLACK; 2], false),
            };
            for (colors, color) in pictures.colors.iter_mut().zip(both) {
                colors.push(shown(color));
            }
            pictures.is_there.push(is_there);
        }
        (pictures, stops)
    }

    /// The sRGB codes of a picture, 0 to 1.
    fn encoded(&self, picture: usize) -> impl Iterator<Item = [f64; 3]> {
        self.colors[picture].iter().map(|color| color.to_array().map(|v| f64::from(srgb_encode(v))))
    }

    fn psnr(&self) -> f64 {
        let squares: Vec<f64> = self
            .encoded(0)
            .zip(self.encoded(1))
            .map(|(x, r)| x.iter().zip(r).map(|(x, r)| (x - r) * (x - r)).sum::<f64>() / 3.0)
            .collect();
        -10.0 / std::f64::consts::LN_10 * ln_f64(self.mean(&squares))
    }

    /// Mean over the pixels that are finite in both, of which there is at least one.
    fn mean(&self, values: &[f64]) -> f64 {
        let there = values.iter().zip(&self.is_there).filter(|(_, is_there)| **is_there);
        let (sum, count) = there.fold((0.0, 0_u64), |(sum, count), (value, _)| (sum + value, count + 1));
        sum / count as f64
    }
}

#[cfg(test)]
mod tests;
