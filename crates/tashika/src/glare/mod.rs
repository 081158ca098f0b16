//! Glare of a fisheye image: the unified glare rating and the daylight glare probability, each with
//! an interval that follows from those of the pixels.
//!
//! ```text
//! UGR  = 8 log₁₀(0.25 / L_b · Σ_s L_s² ω_s / p_s²)                            CIE 117:1995
//! DGP  = 5.87·10⁻⁵ E_v + 0.0918 log₁₀(1 + Σ_s L_s² ω_s / (E_v^1.87 p_s²)) + 0.16
//! E_v  = Σ L ω cos θ          L_b = (E_v − Σ over pixels of sources of L ω cos θ) / π
//! ```
//!
//! `L` is the luminance of a pixel (cd·m⁻²), `ω` its solid angle, `θ` the angle of its direction
//! from the line of sight. The sums over `s` are over glare sources (module `sources`) of mean
//! luminance `L_s`, solid angle `ω_s` and position index `p_s` (module `position`). `E_v` is the
//! vertical illuminance at the eye (lx). The DGP is that of Wienold and Christoffersen 2006,
//! limited to 1; it was fitted to DGP from 0.2 to 0.8 and `E_v` of at least 380 lx.
//!
//! # Intervals
//! Every sum has positive terms, so its limits are those with all pixels at their lower or upper
//! limit `L ± h` (at least 0). The limits of an index are those of interval arithmetic: the lower
//! limit of UGR has the sources at their lower and the background at its upper limit; the lower
//! limit of DGP has `E_v` at its lower limit in the first term, and at its upper limit under the
//! logarithm.
//!
//! # Guarantee
//! If every pixel is within its interval, the indices of the same glare sources are within theirs.
//! To first order the half-width of an index is at least `Σ |∂/∂L| h`, so that it holds with the
//! confidence of one pixel if errors of pixels are jointly normal, with any correlation (a standard
//! deviation of a sum is at most the sum of the standard deviations).
//!
//! # Assumption
//! The set of pixels that belong to a source is that of the estimates: a pixel whose interval
//! includes the threshold stays on its side. Solid angles and position indices are exact for the
//! equidistant fisheye; the rim of the circle is resolved to a pixel.
//!
//! # Held to this by
//! The tests below, by closed forms. The record of 2026-11-29 compares with Radiance's `evalglare`.

mod position;
mod sources;
#[cfg(test)]
mod tests;

use std::f64::consts::{FRAC_PI_2, LN_10, PI};

use serde::Serialize;

pub use self::position::position_index;
pub use self::sources::GlareSource;
use crate::color::Controlled;
use crate::error::{Error, Location, Result};
use crate::film::{Claim, Film, RenderFilm, keys};
use crate::math::DVec3;
use crate::math::elementary::{ln_f64, powf_f64, sin_cos_f64};
use crate::sensors::{Bounds, Photometry};

/// Options of an evaluation of glare.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlareOptions {
    /// Conversion of radiance to luminance.
    pub photometry: Photometry,
    /// Angle across the circle of the fisheye (degrees): above 0, at most 360. Default: the angle
    /// in the metadata of the film, else 180.
    pub angle: Option<f64>,
    /// Luminance above which a pixel belongs to a glare source (cd·m⁻²): above 0. Higher values
    /// give fewer and smaller sources. Default: 2000, the threshold of Radiance's `evalglare`.
    pub threshold: f64,
}

impl Default for GlareOptions {
    fn default() -> Self {
        Self { photometry: Photometry::default(), angle: None, threshold: 2000.0 }
    }
}

impl GlareOptions {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`Error::Option`] with the name of the option.
    pub fn validate(&self) -> Result<()> {
        let Self { angle, threshold, .. } = *self;
        if let Some(angle) = angle.filter(|angle| !(*angle > 0.0 && *angle <= 360.0)) {
            return Err(Error::option("angle", angle, "above 0, at most 360 degrees"));
        }
        if !(threshold > 0.0 && threshold.is_finite()) {
            return Err(Error::option("threshold", threshold, "a luminance above 0"));
        }
        Ok(())
    }
}

/// Indices of an image with the quantities that they are computed from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Glare {
    /// Unified glare rating. `None` without glare sources, or without light around them.
    pub ugr: Option<Bounds>,
    /// Daylight glare probability, 0 to 1.
    pub dgp: Bounds,
    /// Illuminance `E_v` of the plane at the eye that faces the line of sight (lx).
    pub vertical_illuminance: Bounds,
    /// Mean luminance `L_b` around the sources, weighted by the cosine (cd·m⁻²).
    pub background: Bounds,
    /// Glare sources, the one that contributes most first.
    pub sources: Vec<GlareSource>,
    /// Angle across the circle of the fisheye (degrees).
    pub angle: f64,
    /// Number of pixels in the field of view, which is at most a hemisphere.
    pub pixels: usize,
    /// Number of these that state no interval of their luminance. If there are any, no value has an
    /// interval.
    pub silent: usize,
}

/// Pixel in the field of view.
#[derive(Clone, Copy, Debug)]
struct ViewedPixel {
    /// Column and row.
    place: [u32; 2],
    /// Unit direction: line of sight `−z`, up `+y`, right `+x`.
    direction: DVec3,
    solid_angle: f64,
    /// Lower limit, estimate and upper limit of the luminance (cd·m⁻²). Without an interval all are
    /// the estimate.
    luminance: [f64; 3],
}

impl ViewedPixel {
    /// Contribution of each luminance to the vertical illuminance.
    fn illuminance(&self) -> [f64; 3] {
        self.luminance.map(|luminance| luminance * self.solid_angle * -self.direction.z)
    }
}

impl Glare {
    /// Evaluates an image of an equidistant fisheye whose line of sight is the observer's.
    ///
    /// # Errors
    /// [`Error::Option`] for options out of range; [`Error::Invalid`] for a film without colours,
    /// of another projection, of a part of an image, or with a pixel in view that was not rendered
    /// or is not finite. Its location names no file.
    pub fn of(film: &Film, options: &GlareOptions) -> Result<Self> {
        options.validate()?;
        let angle = angle_across(film, options)?;
        let (pixels, silent) = viewed(film, angle.to_radians(), options.photometry)?;
        let (sources, is_source) =
            sources::glare_sources(&pixels, film.size(), angle.to_radians(), options.threshold);
        let mut vertical = [0.0; 3];
        let mut indirect = [0.0; 3];
        for (pixel, is_source) in pixels.iter().zip(is_source) {
            for (k, illuminance) in pixel.illuminance().into_iter().enumerate() {
                vertical[k] += illuminance;
                indirect[k] += if is_source { 0.0 } else { illuminance };
            }
        }
        let background = indirect.map(|illuminance| illuminance / PI);
        // Sums over sources of the terms of both indices, without `E_v`.
        let mut glare = [0.0; 3];
        for source in &sources {
            for (sum, term) in glare.iter_mut().zip(source.terms()) {
                *sum += term;
            }
        }
        let bounds = |values: [f64; 3]| Bounds {
            value: values[1],
            interval: (silent == 0 && values.iter().all(|v| v.is_finite())).then_some([values[0], values[2]]),
        };
        let ugr = |k: usize| 8.0 * log10(0.25 / background[2 - k] * glare[k]);
        let has_ugr = glare[1] > 0.0 && background[1] > 0.0;
        let dgp = |k: usize| {
            let under = powf_f64(vertical[2 - k], 1.87);
            let log = if under > 0.0 { log10(1.0 + glare[k] / under) } else { 0.0 };
            (5.87e-5 * vertical[k] + 0.0918 * log + 0.16).min(1.0)
        };
        Ok(Self {
            ugr: has_ugr.then(|| bounds([0, 1, 2].map(ugr))),
            dgp: bounds([0, 1, 2].map(dgp)),
            vertical_illuminance: bounds(vertical),
            background: bounds(background),
            sources,
            angle,
            pixels: pixels.len(),
            silent,
        })
    }
}

/// Common logarithm; `−∞` for 0.
fn log10(x: f64) -> f64 {
    ln_f64(x) / LN_10
}

/// Angle across the circle (degrees).
fn angle_across(film: &Film, options: &GlareOptions) -> Result<f64> {
    let metadata = film.metadata();
    match metadata.text(keys::CAMERA_PROJECTION) {
        Some("fisheye") => Ok(options.angle.or(metadata.number(keys::CAMERA_FOV)).unwrap_or(180.0)),
        None => Ok(options.angle.unwrap_or(180.0)),
        Some(other) => Err(Error::invalid(
            Location::default(),
            format!("an image of projection {other}"),
            "an image of an equidistant fisheye: --projection fisheye",
        )),
    }
}

/// Pixels in the front hemisphere of the circle, and the number of those without an interval.
fn viewed(film: &Film, angle: f64, photometry: Photometry) -> Result<(Vec<ViewedPixel>, usize)> {
    let invalid = |found: String, expected: &str| Error::invalid(Location::default(), found, expected);
    let (size, window) = (film.size(), film.window());
    if [window.x, window.y] != [0, 0] || [window.width, window.height] != size {
        return Err(invalid("a part of an image".to_owned(), "a whole image"));
    }
    if film.colors().is_none() {
        return Err(invalid("an image without colours".to_owned(), "an image with channels R, G and B"));
    }
    let read = RenderFilm::of(film);
    let efficacies = photometry.efficacies();
    // The half-width of luminance bounds no other mean of the channels.
    let has_half_widths =
        photometry.controlled() == Controlled::Luminance || read.controlled() == Controlled::Channels;
    let smaller = f64::from(size[0].min(size[1]));
    let step = angle / smaller;
    let (mut pixels, mut silent) = (Vec::new(), 0);
    for (pixel, (x, y)) in window.pixels().enumerate() {
        let right = f64::from(x) + 0.5 - 0.5 * f64::from(size[0]);
        let up = 0.5 * f64::from(size[1]) - f64::from(y) - 0.5;
        let distance = (right * right + up * up).sqrt();
        let theta = distance * step;
        if theta > (0.5 * angle).min(FRAC_PI_2) {
            continue;
        }
        let (sin, cos) = sin_cos_f64(theta);
        let across = if distance > 0.0 { sin / distance } else { 0.0 };
        let sinc = if theta > 0.0 { sin / theta } else { 1.0 };
        let color = read.color(pixel).filter(|color| color.is_finite() && read.is_rendered(pixel));
        let Some(color) = color else {
            return Err(invalid(
                format!("pixel {x},{y} without a finite luminance"),
                "an image that is rendered completely, with finite pixels",
            ));
        };
        let channels = color.to_array().into_iter().zip(efficacies);
        let value: f64 = channels.map(|(value, efficacy)| f64::from(value) * efficacy).sum();
        let states = has_half_widths && ![Claim::None, Claim::Audited].contains(&read.claim(pixel));
        let half_width = read.half_width(pixel).filter(|half_width| states && half_width.is_finite());
        silent += usize::from(half_width.is_none());
        let h = half_width.map_or(0.0, |half_width| f64::from(half_width) * photometry.efficacy());
        pixels.push(ViewedPixel {
            place: [x, y],
            direction: DVec3::new(right * across, up * across, -cos),
            solid_angle: step * step * sinc,
            luminance: [(value - h).max(0.0), value.max(0.0), value.max(0.0) + h],
        });
    }
    if pixels.is_empty() {
        return Err(invalid("no pixel in view".to_owned(), "a fisheye of more pixels"));
    }
    Ok((pixels, silent))
}
