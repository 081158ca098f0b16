//! Verdict on a picture from the truths of some pixels, and the claim that its film states.
//!
//! ```text
//! truth in [l, h]       pixel y is within if |y − t| ≤ max(ε t, ε_abs) for t = l and for t = h
//! ```
//!
//! The condition then holds for every `t` in between: as a function of `t`, the distance minus the
//! tolerance falls up to `t = y` and rises beyond, so it is largest at an end. A pixel whose truth
//! has no interval is outside.

use crate::color::Rgb;
use crate::film::{Claim, Film, PictureClaim, PixelRecord, RenderFilm, Samples, Stop, Window, keys, planes};
use crate::integrator::ControlOptions;
use crate::reconstruction::Reconstructed;
use crate::request::AuditTerms;

/// An audited pixel, with its truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AuditedPixel {
    /// Position in the full image.
    pub pixel: [u32; 2],
    /// Interval of its true luminance (W·m⁻²·sr⁻¹), if known.
    pub interval: Option<[f64; 2]>,
}

/// Tolerance of a pixel of luminance `t`: `max(ε t, ε_abs)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tolerance {
    pub error: f64,
    pub absolute: f64,
}

impl Tolerance {
    /// Tolerance of the pixels of a request.
    pub fn to(options: &ControlOptions) -> Self {
        Self { error: options.error, absolute: options.absolute_error }
    }

    /// Tolerance of a pixel of the given luminance.
    pub fn of(&self, luminance: f64) -> f64 {
        (self.error * luminance).max(self.absolute)
    }
}

impl AuditedPixel {
    /// Largest possible distance of the pixel from its truth.
    pub fn distance(&self, luminance: f64) -> f64 {
        let of = |[low, high]: [f64; 2]| (luminance - low).abs().max((luminance - high).abs());
        self.interval.filter(|_| luminance.is_finite()).map_or(f64::INFINITY, of)
    }

    /// Returns true if the pixel is within the tolerance of every truth in the interval.
    pub fn is_within(&self, luminance: f64, tolerance: &Tolerance) -> bool {
        self.interval
            .is_some_and(|ends| ends.iter().all(|truth| (luminance - truth).abs() <= tolerance.of(*truth)))
    }

    /// Returns true if the pixel is within the tolerance of some truth in the interval, but not of
    /// every one. A pixel that is not finite is within the tolerance of no truth.
    pub fn is_open(&self, luminance: f64, tolerance: &Tolerance) -> bool {
        if !luminance.is_finite() {
            return false;
        }
        let may_be = self.interval.is_none_or(|[low, high]| {
            let nearest = luminance.clamp(low, high);
            (luminance - nearest).abs() <= tolerance.of(nearest)
        });
        may_be && !self.is_within(luminance, tolerance)
    }
}

/// Result of an interim analysis of a picture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Analysis {
    /// Number of audited pixels that are not certainly within the tolerance.
    pub outside: u64,
    /// Largest possible error of each pixel, over its half-width in the map.
    pub ratios: Vec<f64>,
}

impl Analysis {
    /// Compares a picture with truths.
    ///
    /// * `radiance`, `half_widths`: of the window's pixels, row by row.
    pub fn at(
        pixels: &[AuditedPixel],
        tolerance: &Tolerance,
        window: &Window,
        radiance: &[Rgb],
        half_widths: &[f64],
    ) -> Self {
        let ratio = |truth: &AuditedPixel| {
            let half_width = half_widths[window.index(truth.pixel[0], truth.pixel[1])];
            truth.distance(luminance_at(truth.pixel, window, radiance)) / half_width
        };
        let outside = outside(pixels, tolerance, window, radiance);
        Self { outside, ratios: pixels.iter().map(ratio).collect() }
    }

    /// Returns true if enough pixels are within.
    pub fn is_reached(&self, terms: &AuditTerms) -> bool {
        terms.is_reached(self.outside, self.ratios.len() as u64)
    }

    /// Factor by which the half-widths of the map are multiplied. `None` if too few pixels are
    /// audited or too many truths are unknown.
    fn factor(&self, terms: &AuditTerms) -> Option<f64> {
        let mut ratios = self.ratios.clone();
        ratios.sort_unstable_by(f64::total_cmp);
        let rank = terms.rank(ratios.len() as u64)?;
        Some(ratios[rank as usize - 1]).filter(|factor| factor.is_finite())
    }
}

/// Claim about a picture by an analysis.
pub(super) struct Verdict<'l> {
    pub look: &'l Analysis,
    pub terms: &'l AuditTerms,
    pub tolerance: &'l Tolerance,
    /// For each pixel of the window, row by row: true if it is of the population that audited
    /// pixels were drawn from.
    pub population: &'l [bool],
    /// Number of analyses so far, including this one.
    pub looks: u32,
    pub passes: u32,
}

impl Verdict<'_> {
    /// Returns the claim about the picture.
    pub fn claim(&self) -> PictureClaim {
        let Self { look, terms, .. } = self;
        let (audited, outside) = (look.ratios.len() as u64, look.outside);
        PictureClaim {
            error: self.tolerance.error,
            share: terms.share,
            assurance: terms.assurance,
            audited,
            outside,
            upper_outside: terms.upper_outside(outside, audited),
            reached: look.is_reached(terms),
            population: count_true(self.population),
            looks: self.looks.into(),
            passes: self.passes.into(),
        }
    }

    /// Stores the claim and the picture in the film.
    pub fn store(&self, picture: &Pictured<'_>, film: &mut Film) {
        let (claim, factor) = (self.claim(), self.look.factor(self.terms));
        let metadata = film.metadata_mut();
        claim.describe(metadata);
        if let Some(factor) = factor {
            metadata.set(keys::AUDIT_FACTOR, factor);
        }
        let of_pixels = if factor.is_some() { Claim::Audited } else { Claim::None };
        let stop = if claim.reached { Stop::RuleMet } else { Stop::Budget };
        picture.store(film, |k, record| match self.population[k] {
            true => Stated { claim: of_pixels, factor: factor.unwrap_or(f64::NAN), stop },
            false => self.unaudited(k, record),
        });
    }

    /// Statement about a pixel of a picture without audited pixels, or outside of the population.
    /// Later passes may find something where the first one found nothing.
    pub fn unaudited(&self, k: usize, record: &PixelRecord) -> Stated {
        if self.population[k] || is_shown(record) { Stated::NOTHING } else { Stated::BACKGROUND }
    }
}

/// Statement of a picture about a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stated {
    pub claim: Claim,
    /// Factor by which the pixel's half-width in the map is multiplied, if an interval is claimed.
    pub factor: f64,
    pub stop: Stop,
}

impl Stated {
    /// Statement about a pixel of an unfinished picture.
    pub const NOTHING: Self = Self { claim: Claim::None, factor: f64::NAN, stop: Stop::SampleCount };
    /// Statement about a pixel that shows only a constant background: its radiance is exact.
    pub const BACKGROUND: Self = Self { claim: Claim::Exact, factor: 0.0, stop: Stop::Complete };
}

/// A picture with its predicted errors, for the pixels of a window, row by row.
pub(super) struct Pictured<'f> {
    /// Estimates that the picture was reconstructed from.
    pub plain: RenderFilm<'f>,
    pub reconstructed: &'f Reconstructed,
    /// Half-widths of the map before scaling (W·m⁻²·sr⁻¹).
    pub half_widths: &'f [f64],
}

impl Pictured<'_> {
    /// Stores the picture in a film, with a statement for each pixel and the record of its
    /// estimate.
    pub fn store(&self, film: &mut Film, stated: impl Fn(usize, &PixelRecord) -> Stated) {
        film.metadata_mut().set(keys::FORESEEN, self.reconstructed.importance_median());
        for (k, (x, y)) in film.window().pixels().enumerate() {
            let plain = self.plain.at(x, y);
            let Stated { claim, factor, stop } = stated(k, &plain);
            let record = PixelRecord {
                radiance: self.reconstructed.radiance[k],
                standard_error: self.reconstructed.importance_error[k],
                half_width: claim.stated(factor * self.half_widths[k]),
                claim,
                stop,
                ..plain
            };
            record.store(film, x, y);
        }
    }
}

/// Adds the plane of the audited pixels to a film.
pub(super) fn describe(pixels: &[AuditedPixel], tolerance: &Tolerance, film: &mut Film) {
    let read = RenderFilm::of(film);
    let window = film.window();
    let channels = planes::AUDITED.channels.len();
    let not_audited = [f32::NAN, f32::NAN, 0.0];
    let mut samples = not_audited.repeat(window.area() as usize);
    for truth in pixels {
        let [x, y] = truth.pixel;
        let at = channels * window.index(x, y);
        let luminance = read.at(x, y).radiance.luminance().into();
        let [low, high] = truth.interval.unwrap_or([f64::NAN; 2]).map(|end| end as f32);
        let verdict = if truth.is_within(luminance, tolerance) { 1.0 } else { 2.0 };
        samples[at..at + channels].copy_from_slice(&[low, high, verdict]);
    }
    film.add_plane(&planes::AUDITED, Samples::F32(samples));
}

/// Number of audited pixels that are not certainly within the tolerance.
pub(super) fn outside(
    pixels: &[AuditedPixel],
    tolerance: &Tolerance,
    window: &Window,
    radiance: &[Rgb],
) -> u64 {
    let is_within =
        |truth: &&AuditedPixel| truth.is_within(luminance_at(truth.pixel, window, radiance), tolerance);
    (pixels.len() - pixels.iter().filter(is_within).count()) as u64
}

pub(super) fn count_true(values: &[bool]) -> u64 {
    values.iter().map(|value| u64::from(*value)).sum()
}

pub(super) fn luminance_at(pixel: [u32; 2], window: &Window, radiance: &[Rgb]) -> f64 {
    radiance[window.index(pixel[0], pixel[1])].luminance().into()
}

/// Returns, for each pixel of a film, true if it shows more than a constant background. Pixels of a
/// constant background are not audited: they are correct in any picture, and say nothing about
/// other pixels. A pixel that is not finite is wrong, and therefore counts as showing more.
pub(super) fn shown(film: &Film) -> Vec<bool> {
    let read = RenderFilm::of(film);
    film.window().pixels().map(|(x, y)| is_shown(&read.at(x, y))).collect()
}

fn is_shown(PixelRecord { radiance, coverage, standard_error, .. }: &PixelRecord) -> bool {
    *coverage > 0.0 || *standard_error > 0.0 || !radiance.is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_is_within_only_with_its_whole_interval() {
        let tolerance = Tolerance { error: 0.1, absolute: 0.05 };
        let at = |interval| AuditedPixel { pixel: [0, 0], interval };
        let known = at(Some([1.0, 1.04]));
        assert!(known.is_within(1.0, &tolerance) && known.is_within(1.09, &tolerance));
        assert!(!known.is_within(0.93, &tolerance), "1.04 may be the truth, and 11 % is too much");
        assert!(!known.is_within(1.11, &tolerance), "1.0 may be the truth");
        assert!(!at(None).is_within(1.0, &tolerance), "what is not known is not within");
        assert!(at(Some([0.0, 0.0])).is_within(0.04, &tolerance), "in the dark the absolute error counts");
        assert!(known.is_open(1.11, &tolerance) && known.is_open(0.93, &tolerance));
        assert!(!known.is_open(1.0, &tolerance) && !known.is_open(1.3, &tolerance));
        assert!(at(None).is_open(1.0, &tolerance));
        assert_eq!(known.distance(0.9), 1.04 - 0.9);
        assert_eq!(at(None).distance(0.9), f64::INFINITY);
        for pixel in [f64::NAN, f64::INFINITY] {
            assert!(!known.is_within(pixel, &tolerance) && !known.is_open(pixel, &tolerance));
            assert!(!at(None).is_open(pixel, &tolerance), "no truth helps");
            assert_eq!(known.distance(pixel), f64::INFINITY);
        }
    }
}
