//! Judgement of a film's claims about its own error, by a reference.
//!
//! A film makes a claim at a pixel if its plane `half_width` holds the half-width `h` of an
//! interval around the luminance (W·m⁻²·sr⁻¹) and its plane `claim` is not 0 there. Without a plane
//! `claim` every half-width is a claim. Let `d = |L − L_r|` be the distance from a reference whose
//! own error is at most `q` ([`OwnError`]), and `ρ = 2⁻²³ (|L_r| + d)` a bound on the rounding of
//! stored colours to single precision. A claim is
//!
//! ```text
//! kept          d + q ≤ h + ρ      it holds for every truth within q of the reference
//! broken        d − q > h + ρ      it holds for no truth within q of the reference
//! undecidable   otherwise          the reference is too noisy
//! ```
//!
//! # Verdict
//! Claims at confidence `c` promise that a share `p = 1 − (1 − c) n_i/n` of the `n` pixels is kept,
//! where `n_i` pixels state an interval and the others are exact. A true claim is called broken
//! only if the reference is off by more than `q`. The probability of this, `α`, is 0.1 % at most.
//! With the Clopper–Pearson interval of a share, the verdict is
//!
//! ```text
//! not kept      low(broken) > 1 − p + α
//! kept          inside/n ≥ p
//! open          otherwise: too many undecidable claims, or too few pixels
//! ```
//!
//! A claim is *inside* if its interval contains the reference, `d ≤ h + ρ`. Noise of the reference
//! can only lower this count: an error `X` that is symmetric and unimodal and noise `N` that does
//! not depend on it have `P(|X + N| ≤ h) ≤ P(|X| ≤ h)` (Anderson 1955).
//!
//! The share of true claims is between the share that is kept and the share that is not broken. Its
//! bounds are the lower end of the Clopper–Pearson interval of the former and the upper end of that
//! of the latter.
//!
//! If the verdict is open, the number of *consistent* claims is reported, which is weaker evidence.
//! If the errors of both films are normal, the interval around their difference has the half-width
//! `√(h² + (z(c) s)²)`, with the reference's standard error `s = q/z(99.9 %)`. A claim is
//! consistent if this interval contains zero; for a true claim it does with probability `c`. The
//! larger `s` is, the less the count shows: against a reference of pure noise, a share `c` of any
//! claims is consistent.
//!
//! # Guarantee
//! For independent pixels and a reference whose errors are normal, true claims are called *not
//! kept* with probability 2.5 % at most. If errors are also symmetric and unimodal, claims are
//! called *kept* only if at least the share `p` is true, within the sampling error of the pixels.
//!
//! # Assumption
//! The interval of the share takes pixels for independent trials. Pixels of one image share their
//! VPLs, so that the interval is narrower than the variation from render to render.
//!
//! # Held to this by
//! `claims::tests`, on films whose truth is known, with references from exact ones to nearly pure
//! noise.

use super::own_error::OwnError;
use super::truths::Truths;
use crate::film::{Claim, Film, RenderFilm, keys};
use crate::stats::{Interval, clopper_pearson, normal_quantile};

/// Numbers of true, false and undecidable claims of a film.
#[derive(Clone, Debug, PartialEq)]
pub struct Claims {
    /// Claims that are true for every truth within the reference's own error.
    pub kept: u64,
    /// Claims that are false for every truth within the reference's own error.
    pub broken: u64,
    /// Claims whose interval contains the reference, taken for the truth.
    pub inside: u64,
    /// Claims that are consistent with the reference if the errors of both are normal.
    pub consistent: u64,
    /// Number of claims of pixels that have an error.
    pub of: u64,
    /// Bounds of the share of true claims, at [`Claims::CONFIDENCE`]: the lower end of the
    /// Clopper–Pearson interval of the share kept, and the upper end of the interval of the share
    /// not broken.
    pub interval: Interval,
    /// Promised share of true claims; `None` if the film states no confidence.
    pub promised: Option<f64>,
    /// Claims judged by a pixel of the reference that has an error of its own.
    pub by_estimates: u64,
    /// Comparison of the truths of the two films.
    pub truths: Truths,
}

/// Verdict on all claims of a film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// At least the promised share is kept.
    Kept,
    /// Less than the promised share is kept.
    NotKept,
    /// The reference is too noisy for a verdict.
    TooNoisy,
    /// There are too few pixels for a verdict.
    TooFew,
}

impl Verdict {
    /// Returns one word, for scripts.
    pub fn name(self) -> &'static str {
        match self {
            Self::Kept => "kept",
            Self::NotKept => "not_kept",
            Self::TooNoisy => "reference_too_noisy",
            Self::TooFew => "too_few_pixels",
        }
    }

    /// Returns the words after "95 % claimed:".
    pub fn words(self) -> &'static str {
        match self {
            Self::Kept => "kept",
            Self::NotKept => "NOT kept",
            Self::TooNoisy => "open, the reference is too noisy to tell",
            Self::TooFew => "open, too few pixels to tell",
        }
    }
}

impl Claims {
    /// Confidence of the bounds of the share.
    pub const CONFIDENCE: f64 = 0.95;

    /// Returns the share of claims that are certainly true; `None` if there are no claims.
    pub fn share(&self) -> Option<f64> {
        (self.of > 0).then(|| self.kept as f64 / self.of as f64)
    }

    /// Returns the number of claims for which the reference is too noisy.
    pub fn undecidable(&self) -> u64 {
        self.of - self.kept - self.broken
    }

    /// Returns the verdict; `None` if nothing is promised or claimed, or if the reference estimates
    /// another truth.
    pub fn verdict(&self) -> Option<Verdict> {
        let promised = self.promised?;
        if self.of == 0 || self.truths.differ() {
            return None;
        }
        let share = |count: u64| count as f64 / self.of as f64;
        let mistaken = (1.0 - OwnError::CONFIDENCE) * share(self.by_estimates);
        let broken = clopper_pearson(self.broken, self.of, Self::CONFIDENCE).low;
        Some(if broken > 1.0 - promised + mistaken {
            Verdict::NotKept
        } else if share(self.inside) >= promised {
            Verdict::Kept
        } else if share(self.of - self.broken) >= promised {
            Verdict::TooNoisy
        } else {
            Verdict::TooFew
        })
    }

    /// Returns true if the metadata of both films name the same truth ([`Truths::Same`]).
    pub fn same_truth(&self) -> bool {
        self.truths == Truths::Same
    }
}

/// Bound on the rounding of stored colours to single precision, for colours at the given distance
/// from a reference of the given size.
pub(super) fn rounding(distance: f64, size: f64) -> f64 {
    f64::from(f32::EPSILON) * (size + distance)
}

/// Counter of true, false and undecidable claims.
pub(super) struct Judge<'f> {
    film: RenderFilm<'f>,
    confidence: Option<f64>,
    truths: Truths,
    kept: u64,
    broken: u64,
    inside: u64,
    consistent: u64,
    by_estimates: u64,
    intervals: u64,
    of: u64,
    /// Factor that converts a half-width at the confidence of the reference's own error to one at
    /// the confidence of the claims.
    of_own: f64,
}

impl<'f> Judge<'f> {
    /// Counter for the claims of a film, judged by a reference; `None` if the film has no
    /// half-widths.
    pub(super) fn of(film: &'f Film, reference: &Film) -> Option<Self> {
        let truths = Truths::of(film, reference);
        let confidence = film.metadata().number(keys::CONFIDENCE).filter(|c| *c > 0.0 && *c < 1.0);
        let film = RenderFilm::of(film);
        let z = |confidence: f64| normal_quantile(0.5 + 0.5 * confidence);
        let judge = Self {
            film,
            confidence,
            truths,
            kept: 0,
            broken: 0,
            inside: 0,
            consistent: 0,
            by_estimates: 0,
            intervals: 0,
            of: 0,
            of_own: z(confidence.unwrap_or(Claims::CONFIDENCE)) / z(OwnError::CONFIDENCE),
        };
        film.has_half_widths().then_some(judge)
    }

    /// Judges a pixel, given its distance from the reference, the size of the reference, and a
    /// bound `own` on the reference's own error. A pixel that failed has no distance (NaN); its
    /// claim is broken.
    pub(super) fn judge(&mut self, pixel: usize, distance: f64, size: f64, own: f64) {
        let Some(half_width) = self.film.half_width(pixel) else { return };
        let allowed = f64::from(half_width) + rounding(distance, size);
        self.of += 1;
        self.intervals += u64::from(self.film.claim(pixel) != Claim::Exact);
        self.by_estimates += u64::from(own > 0.0);
        // The interval of a NaN half-width contains no value.
        self.inside += u64::from(distance <= allowed);
        let (half_width, own_error) = (f64::from(half_width), own * self.of_own);
        let with_own = (half_width * half_width + own_error * own_error).sqrt() + rounding(distance, size);
        self.consistent += u64::from(distance <= with_own);
        self.kept += u64::from(distance + own <= allowed);
        let may_hold = distance - own <= allowed;
        self.broken += u64::from(!may_hold);
    }

    /// Returns the counts, with bounds of the share of true claims.
    pub(super) fn claims(self) -> Claims {
        let Self { truths, kept, broken, inside, consistent, by_estimates, intervals, of, .. } = self;
        let bounds = |count| clopper_pearson(count, of, Claims::CONFIDENCE);
        let interval = Interval { low: bounds(kept).low, high: bounds(of - broken).high };
        let of_intervals = intervals as f64 / of.max(1) as f64;
        let promised = match self.confidence {
            Some(confidence) => Some(1.0 - (1.0 - confidence) * of_intervals),
            None => (intervals == 0).then_some(1.0),
        };
        Claims { kept, broken, inside, consistent, of, interval, promised, by_estimates, truths }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{PixelRecord, Stop, Window};
    use crate::rng::{Purpose, Stream};
    use crate::{Named, Tolerance, compare};
    use std::path::Path;

    const PIXELS: u32 = 20_000;

    /// Judges an image by a reference, both with the truth 1. The errors of the image are normal
    /// with a standard deviation of 0.01; its half-widths are `widths` times the correct ones at
    /// 95 %. The errors of the reference have a standard deviation of `noise` times 0.01, which the
    /// reference states.
    fn verdict(widths: f64, noise: f64) -> Claims {
        const SIGMA: f64 = 0.01;
        let size = [PIXELS, 1];
        let film = |key: u64, of: &dyn Fn(f64) -> PixelRecord| {
            let mut film = Film::new(size, Window::full(size), PixelRecord::PLANES).unwrap();
            let mut s = Stream::new(7, Purpose::Test, key);
            for x in 0..PIXELS {
                let z = normal_quantile(s.uniform_f64().max(f64::MIN_POSITIVE));
                of(z).store(&mut film, x, 0);
            }
            film
        };
        let gray = |value: f64| crate::color::Rgb::gray(value as f32);
        let half_width = (widths * normal_quantile(0.975) * SIGMA) as f32;
        let mut image = film(1, &|z| PixelRecord {
            radiance: gray(1.0 + SIGMA * z),
            half_width,
            claim: Claim::Calibrated,
            stop: Stop::RuleMet,
            ..PixelRecord::default()
        });
        image.metadata_mut().set(keys::CONFIDENCE, 0.95);
        let reference = film(2, &|z| PixelRecord {
            radiance: gray(1.0 + noise * SIGMA * z),
            standard_error: (noise * SIGMA) as f32,
            stop: Stop::SampleCount,
            ..PixelRecord::default()
        });
        let named = |film| Named { name: Path::new("a"), film };
        compare(named(&image), named(&reference), &Tolerance::default()).unwrap().claims.unwrap()
    }

    /// Half-widths of 1 to 2 times the correct ones, so that at least 95 % of the claims hold, and
    /// references of any noise. The verdict is never `NotKept`.
    #[test]
    fn claims_that_hold_are_never_called_broken() {
        for noise in [0.0, 0.1, 0.3, 1.0, 3.0, 30.0] {
            for widths in [1.0, 1.3, 2.0] {
                let found = verdict(widths, noise);
                let told = found.verdict().unwrap();
                assert_ne!(told, Verdict::NotKept, "{widths} {noise}: {found:?}");
                let [low, high] = [found.interval.low, found.interval.high];
                // Shares of normal errors within the half-widths.
                let truth = [(1.0, 0.95), (1.3, 0.989_2), (2.0, 0.999_911)];
                let (_, truth) = truth.into_iter().find(|(w, _)| *w == widths).unwrap();
                // Tolerance: five standard errors due to the number of pixels, and 0.001 for errors
                // of the reference above its bound.
                let of_pixels = 5.0 * (truth * (1.0 - truth) / f64::from(PIXELS)).sqrt();
                let spread = of_pixels + 0.001;
                // With normal errors the share is at least the claimed one.
                let consistent = found.consistent as f64 / f64::from(PIXELS);
                assert!(consistent >= 0.95 - of_pixels.max(0.008), "{widths} {noise}: {consistent}");
                assert!(low <= truth + spread && truth - spread <= high, "{widths} {noise}: {low} {high}");
                // Noise as large as the error itself leaves 83 %, 93 % and 99.4 % inside.
                match noise {
                    n if n <= 0.3 && widths > 1.0 => assert_eq!(told, Verdict::Kept, "{widths} {noise}"),
                    1.0 if widths > 1.5 => assert_eq!(told, Verdict::Kept, "{widths} {noise}"),
                    n if n >= 1.0 => assert_eq!(told, Verdict::TooNoisy, "{widths} {noise}"),
                    _ => {}
                }
            }
        }
        // If this reference were taken for the truth, only 1 − P(|Z| > 1.96/√2) of the claims would
        // hold.
        let naive = verdict(1.0, 1.0);
        assert!((naive.inside as f64) < 0.85 * naive.of as f64, "{naive:?}");
    }

    /// Half-widths of 0.5 and 0.8 times the correct ones, so that 67 % and 88 % of the claims hold.
    /// The verdict is never `Kept`.
    #[test]
    fn claims_that_do_not_hold_are_never_called_kept() {
        for widths in [0.5, 0.8] {
            for noise in [0.0, 0.03, 0.1, 0.3, 1.0, 3.0, 30.0] {
                let found = verdict(widths, noise);
                let told = found.verdict().unwrap();
                assert_ne!(told, Verdict::Kept, "{widths} {noise}: {found:?}");
                // 33 % and 12 % are false; a little noise leaves more than 5 % of the claims
                // certainly false.
                if noise <= 0.1 {
                    assert_eq!(told, Verdict::NotKept, "{widths} {noise}: {found:?}");
                }
                if noise >= 1.0 {
                    assert_eq!(told, Verdict::TooNoisy, "{widths} {noise}: {found:?}");
                }
                let share = found.consistent as f64 / f64::from(PIXELS);
                assert!(noise > 1.0 || share < 0.945, "{widths} {noise}: {share}");
            }
        }
    }

    #[test]
    fn each_claim_is_kept_broken_or_undecidable() {
        let size = [4, 1];
        let film = |record: &dyn Fn(u32) -> PixelRecord| {
            let mut film = Film::new(size, Window::full(size), PixelRecord::PLANES).unwrap();
            (0..4).for_each(|x| record(x).store(&mut film, x, 0));
            film
        };
        // Errors of 0.1, 0.1, 0.5 and 0.5. The reference is off by 0.05 at most; its error at the
        // last pixel is unknown.
        let grays = [1.1, 1.1, 1.5, 1.5];
        let half_widths = [0.2, 0.12, 0.2, 0.2];
        let image = film(&|x| PixelRecord {
            radiance: crate::color::Rgb::gray(grays[x as usize]),
            half_width: half_widths[x as usize],
            claim: Claim::Certified,
            stop: Stop::RuleMet,
            ..PixelRecord::default()
        });
        let own = [0.05, 0.05, 0.05, f32::NAN];
        let reference = film(&|x| PixelRecord {
            radiance: crate::color::Rgb::gray(1.0),
            standard_error: own[x as usize] / 3.290_527,
            stop: Stop::SampleCount,
            ..PixelRecord::default()
        });
        let named = |film| Named { name: Path::new("a"), film };
        let found = compare(named(&image), named(&reference), &Tolerance::default()).unwrap();
        let found = found.claims.unwrap();
        assert_eq!((found.kept, found.broken, found.undecidable(), found.of), (1, 1, 2, 4));
        assert_eq!((found.inside, found.by_estimates), (2, 4));
        assert_eq!(found.verdict(), None, "the film does not say with which confidence");
    }
}
