//! Comparison of a film with a reference, pixel by pixel.
//!
//! The measured quantity is the luminance `L = 0.2126 R + 0.7152 G + 0.0722 B` of the main plane.
//! If the metadata of the film state that its worst channel was controlled, `|L − L_r|` stands for
//! the largest distance of the three channels, and `|L_r|` for the largest channel. With the
//! tolerance `ε` (relative) and `ε_abs` (in the film's unit), the error of a pixel of luminance `L`
//! with reference `L_r` is
//!
//! ```text
//! e = |L − L_r| / max(|L_r|, ε_abs/ε)        0 if L = L_r, infinite where only the divisor is 0
//! within tolerance:  e ≤ ε                   that is |L − L_r| ≤ max(ε |L_r|, ε_abs)
//! bias = ΣL / ΣL_r − 1                       0 if both sums are 0
//! ```
//!
//! A pixel where the image is not finite has *failed*: its error is infinite, whatever the
//! tolerance, and its claim is not kept. It has no luminance, so sums omit it, but it counts as a
//! pixel.
//!
//! The mean is over finite errors; the number of infinite errors is reported separately. `bias` and
//! the mean distance are over the pixels that did not fail. All other quantities are over all
//! errors. Quantiles are of the nearest rank: the smallest error that at least that share of the
//! pixels does not exceed. So `p95 ≤ ε` is equivalent to "at least 95 % of the pixels are within
//! the tolerance".
//!
//! # Omitted pixels
//! Pixels that one of the films did not render (its plane `stop` is 0) and pixels where the
//! reference is not finite have no error. They are counted, and enter no other quantity.
//!
//! # Assumption
//! Errors are measured from the reference, taken for the truth. If the reference is an estimate
//! with a stated error, claims are judged with that error (`claims`), and [`Comparison::own_error`]
//! bounds its part in the measured errors. If the reference also claims intervals, the intervals of
//! both films are compared, which needs no truth ([`Intervals`]).
//!
//! # Held to this by
//! The tests below, on films whose errors are known.

use std::path::Path;

use super::claims::{Claims, Judge};
use super::intervals::{DisjointCounter, Intervals};
use super::judged::PictureJudged;
use super::measures::Measures;
use super::own_error::OwnError;
use super::pairs::{Pairs, Pixel};
use crate::color::{LUMINANCE_WEIGHTS, Rgb};
use crate::error::{Error, Location, Result};
use crate::film::{Film, RenderFilm, Window, keys};

/// A film and the name of its file, for messages.
#[derive(Clone, Copy, Debug)]
pub struct Named<'a> {
    /// Name of the file, as the user wrote it.
    pub name: &'a Path,
    /// Contents of the file.
    pub film: &'a Film,
}

/// Largest allowed distance of a pixel from the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Relative to the reference: 0.02 for 2 %. Accepted: above 0, at most 1. Default: 0.02.
    pub relative: f64,
    /// Error that is allowed however dark the reference is, in the unit of the film (W·m⁻²·sr⁻¹).
    /// Default: 0.
    pub absolute: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { relative: 0.02, absolute: 0.0 }
    }
}

/// Origin of a tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToleranceFrom {
    /// The user's request.
    Asked,
    /// The error that the image was rendered to.
    Image,
    /// Neither a request nor the image: [`Tolerance::default`].
    Default,
}

impl ToleranceFrom {
    /// Returns one word, for scripts.
    pub fn name(self) -> &'static str {
        match self {
            Self::Asked => "asked",
            Self::Image => "image",
            Self::Default => "default",
        }
    }

    /// Returns the words after "the tolerance is".
    pub fn words(self) -> &'static str {
        match self {
            Self::Asked => "what was asked for",
            Self::Image => "the error that the image was rendered to",
            Self::Default => "the default: none was asked for, and the image was rendered to none",
        }
    }
}

impl Tolerance {
    /// Returns a tolerance and its origin: the requested tolerance, else the error that the film
    /// was rendered to, else the default. The absolute tolerance is the requested one; without a
    /// request, that of the film if its error is used, else 0.
    pub fn asked_or_of(relative: Option<f64>, absolute: Option<f64>, film: &Film) -> (Self, ToleranceFrom) {
        let (own, from) = match (relative, Self::of(film)) {
            (Some(relative), _) => (Self { relative, absolute: 0.0 }, ToleranceFrom::Asked),
            (None, Some(own)) => (own, ToleranceFrom::Image),
            (None, None) => (Self::default(), ToleranceFrom::Default),
        };
        (Self { absolute: absolute.unwrap_or(own.absolute), ..own }, from)
    }

    /// Returns the error that a film was rendered to; `None` if its metadata do not state one, or
    /// if it is out of range.
    pub fn of(film: &Film) -> Option<Self> {
        let number = |key| film.metadata().number(key);
        let absolute = number(keys::ERROR_ABSOLUTE).unwrap_or(0.0);
        let tolerance = Self { relative: number(keys::ERROR)?, absolute };
        tolerance.validate().is_ok().then_some(tolerance)
    }

    /// Checks the ranges of both tolerances.
    ///
    /// # Errors
    /// [`Error::Option`] naming `error` or `absolute` if out of range.
    pub fn validate(&self) -> Result<()> {
        if !(self.relative > 0.0 && self.relative <= 1.0) {
            return Err(Error::option(
                "error",
                self.relative,
                "more than 0 and at most 1 (100 %), such as 2% or 0.02",
            ));
        }
        if !(self.absolute >= 0.0 && self.absolute.is_finite()) {
            return Err(Error::option("absolute", self.absolute, "a luminance that is not negative"));
        }
        Ok(())
    }

    /// Error of a pixel; see the module.
    fn error(&self, distance: f64, size: f64) -> f64 {
        if distance == 0.0 {
            return 0.0;
        }
        distance / size.max(self.absolute / self.relative)
    }
}

/// Result of [`compare()`]: counts, errors and judgements.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The part of the image that both films hold.
    pub window: Window,
    /// Tolerance that errors were compared with.
    pub tolerance: Tolerance,
    /// Pixels that have an error, including those that failed.
    pub pixels: u64,
    /// Pixels omitted because one of the films did not render them.
    pub not_rendered: u64,
    /// Pixels omitted because the reference is not finite there.
    pub not_finite: u64,
    /// Pixels that failed: the image is not finite there, but the reference is. Their error is
    /// infinite.
    pub failed: u64,
    /// Pixels with an error within the tolerance.
    pub within: u64,
    /// Pixels that did not fail and have an infinite error: the reference is black, the image is
    /// not.
    pub infinite: u64,
    /// Mean of the errors that are finite; infinite if none is.
    pub mean: f64,
    /// Error that half the pixels do not exceed.
    pub median: f64,
    /// Error that 95 % of the pixels do not exceed.
    pub p95: f64,
    /// Largest error.
    pub worst: f64,
    /// Pixel of the largest error, the first one if there are several, in coordinates of the full
    /// image.
    pub worst_at: [u32; 2],
    /// Mean luminance over that of the reference, less one; infinite if all pixels failed.
    pub bias: f64,
    /// Mean distance over the mean reference: a mean error that dark pixels do not dominate.
    /// Infinite if all pixels failed.
    pub relative_l1: f64,
    /// RMSE, PSNR and similar measures of the pixels that did not fail; `None` if all failed.
    pub measures: Option<Measures>,
    /// Judgement of the film's claims; `None` if it has no half-widths.
    pub claims: Option<Claims>,
    /// Judgement of the claim about the picture as a whole, if there is one.
    pub picture: Option<PictureJudged>,
    /// Number of disjoint intervals, if the two films are about one truth and both claim an
    /// interval at some pixel.
    pub intervals: Option<Intervals>,
    /// Relative error of the reference that half of its pixels do not exceed, at 99.9 %; `None` if
    /// the reference does not state its error, or is exact.
    pub own_error: Option<f64>,
    /// Error of each pixel in the order of [`Window::pixels`]; NaN for omitted pixels.
    pub errors: Vec<f64>,
}

impl Comparison {
    /// Share of pixels within the tolerance, of those that have an error.
    pub fn within_share(&self) -> f64 {
        self.within as f64 / self.pixels as f64
    }

    /// Number of omitted pixels, which have no error.
    pub fn left_out(&self) -> u64 {
        self.not_rendered + self.not_finite
    }
}

/// Compares the main planes of two films, the claims of the first with the second, and the
/// intervals of both with each other.
///
/// # Errors
/// [`Error::Option`] for a tolerance out of range. [`Error::Invalid`] naming both films if they
/// show different parts or images, or have no pixel in common, and naming one film if it has no
/// colours.
pub fn compare(image: Named<'_>, reference: Named<'_>, tolerance: &Tolerance) -> Result<Comparison> {
    tolerance.validate()?;
    same_window(image, reference)?;
    let pairs = Pairs::of(image, reference)?;

    let controlled = RenderFilm::of(image.film).controlled();
    let mut out = Comparison::empty(image.film.window(), *tolerance);
    let own_error = OwnError::of(reference.film);
    // A stated error of the luminance is taken for an equal relative error of the largest channel.
    let is_by_channels = controlled != RenderFilm::of(reference.film).controlled();
    let mut own_errors = Vec::new();
    let mut judge = Judge::of(image.film, reference.film);
    let mut meeting = DisjointCounter::of(image.film, reference.film);
    let (mut sum, mut reference_sum, mut distance_sum, mut error_sum) = (0.0, 0.0, 0.0, 0.0);
    let mut worst: Option<(f64, usize)> = None;
    for (i, pixel) in pairs.pixels().enumerate() {
        let error = match pixel {
            Pixel::NotRendered => {
                out.not_rendered += 1;
                f64::NAN
            }
            Pixel::NoTruth => {
                out.not_finite += 1;
                f64::NAN
            }
            Pixel::Failed { .. } => {
                out.failed += 1;
                if let Some(judge) = &mut judge {
                    judge.judge(i, f64::NAN, 0.0, 0.0);
                }
                f64::INFINITY
            }
            Pixel::Finite { color, truth } => {
                let (l, r) = (luminance(color), luminance(truth));
                let (size, distance) = controlled.size_and_distance(truth, color);
                let error = tolerance.error(distance, size);
                out.within += u64::from(error <= tolerance.relative);
                out.infinite += u64::from(error.is_infinite());
                sum += l;
                reference_sum += r;
                distance_sum += (l - r).abs();
                if error.is_finite() {
                    error_sum += error;
                }
                let own =
                    own_error.half_width(i) * if is_by_channels { ratio(size, r).max(1.0) } else { 1.0 };
                own_errors.push(ratio(own, size));
                if let Some(judge) = &mut judge {
                    judge.judge(i, distance, size, own);
                }
                if let Some(meeting) = &mut meeting {
                    meeting.take(i, distance, size);
                }
                error
            }
        };
        out.errors.push(error);
        if error.is_nan() {
            continue;
        }
        out.pixels += 1;
        if worst.is_none_or(|(e, _)| error > e) {
            worst = Some((error, i));
        }
    }
    let Some((worst, at)) = worst else {
        let found = format!(
            "no pixel is rendered both here and in {}, and finite there ({} not rendered, {} not finite)",
            reference.name.display(),
            out.not_rendered,
            out.not_finite
        );
        return Err(Error::invalid(Location::file(image.name), found, "pixels in common"));
    };
    let column = at as u64 % u64::from(out.window.width);
    let row = at as u64 / u64::from(out.window.width);
    out.worst_at = [out.window.x + column as u32, out.window.y + row as u32];
    out.worst = worst;
    let finite = out.pixels - out.infinite - out.failed;
    out.mean = if finite > 0 { error_sum / finite as f64 } else { f64::INFINITY };
    [out.median, out.p95] = quantiles(&out.errors, [50, 95]);
    if out.failed < out.pixels {
        out.bias = ratio(sum - reference_sum, reference_sum);
        out.relative_l1 = ratio(distance_sum, reference_sum.abs());
    }
    out.measures = Measures::of(out.window, pairs);
    out.claims = judge.map(Judge::claims);
    out.picture = PictureJudged::of(image.film, pairs, &own_error);
    if own_errors.iter().any(|error| *error > 0.0) {
        [out.own_error] = quantiles(&own_errors, [50]).map(Some);
    }
    out.intervals = meeting.and_then(DisjointCounter::intervals);
    Ok(out)
}

impl Comparison {
    fn empty(window: Window, tolerance: Tolerance) -> Self {
        Self {
            window,
            tolerance,
            pixels: 0,
            not_rendered: 0,
            not_finite: 0,
            failed: 0,
            within: 0,
            infinite: 0,
            mean: 0.0,
            median: 0.0,
            p95: 0.0,
            worst: 0.0,
            worst_at: [window.x, window.y],
            bias: f64::INFINITY,
            relative_l1: f64::INFINITY,
            measures: None,
            claims: None,
            picture: None,
            intervals: None,
            own_error: None,
            errors: Vec::with_capacity(window.area() as usize),
        }
    }
}

/// Luminance in `f64`, so that the sum of three large channels stays finite.
fn luminance(color: Rgb) -> f64 {
    color.to_array().iter().zip(LUMINANCE_WEIGHTS).map(|(c, w)| f64::from(*c) * f64::from(w)).sum()
}

/// Returns `a / b`, and 0 for 0 / 0.
fn ratio(a: f64, b: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a / b }
}

/// Quantiles of the nearest rank, given in percent, of all errors that are numbers.
fn quantiles<const N: usize>(errors: &[f64], percents: [u64; N]) -> [f64; N] {
    let mut sorted: Vec<f64> = errors.iter().copied().filter(|e| !e.is_nan()).collect();
    percents.map(|percent| {
        let rank = (sorted.len() as u64 * percent).div_ceil(100).max(1);
        *sorted.select_nth_unstable_by(rank as usize - 1, f64::total_cmp).1
    })
}

fn same_window(image: Named<'_>, reference: Named<'_>) -> Result<()> {
    let shows = |film: &Film| (film.size(), film.window());
    if shows(image.film) == shows(reference.film) {
        return Ok(());
    }
    let told = |film: &Film| {
        let ([width, height], w) = shows(film);
        let part = if w == Window::full(film.size()) {
            String::new()
        } else {
            format!(", its part {},{},{},{}", w.x, w.y, w.width, w.height)
        };
        format!("{width}x{height} pixels{part}")
    };
    Err(Error::invalid(
        Location::file(image.name),
        format!("an image of {}", told(image.film)),
        format!("what {} shows: {}", reference.name.display(), told(reference.film)),
    ))
}
