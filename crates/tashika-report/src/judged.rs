//! Judgement of a claim about a picture as a whole.

use super::own_error::OwnError;
use super::pairs::{Pairs, Pixel};
use crate::film::{Claim, Film, PictureClaim, RenderFilm, keys};

/// A claim about a picture, compared with a reference.
///
/// A pixel is *within* if the reference, taken for the truth, is within the claimed error; noise of
/// the reference can only lower this count (see `claims`). A pixel is *outside* if it exceeds the
/// claimed error for every truth within the reference's own error. Pixels that the audit did not
/// cover are omitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureJudged {
    /// Claim of the audit about the picture.
    pub claim: PictureClaim,
    /// Pixels within the claimed error of the reference.
    pub within: u64,
    /// Pixels that are outside for every truth within the reference's own error.
    pub outside: u64,
    /// Number of pixels that were judged.
    pub of: u64,
}

impl PictureJudged {
    /// Compares a film's claim with a reference, pixel by pixel; `None` if nothing is claimed of
    /// the picture, or no pixel can be judged. A pixel that failed is outside.
    pub(super) fn of(film: &Film, pairs: Pairs<'_>, own_error: &OwnError<'_>) -> Option<Self> {
        let claim = PictureClaim::of(film.metadata())?;
        let absolute = film.metadata().number(keys::ERROR_ABSOLUTE).unwrap_or(0.0);
        let read = RenderFilm::of(film);
        let has_map = read.tally().of(Claim::Audited) > 0;
        let mut judged = Self { claim, within: 0, outside: 0, of: 0 };
        for (pixel, found) in pairs.pixels().enumerate() {
            let of_pixel = read.claim(pixel);
            if of_pixel == Claim::Exact || (has_map && of_pixel != Claim::Audited) {
                continue;
            }
            match found {
                Pixel::Failed { .. } => judged.outside += 1,
                Pixel::Finite { color, truth } => {
                    let [value, truth] = [color, truth].map(|color| f64::from(color.luminance()));
                    let own = own_error.half_width(pixel);
                    let [low, high] = [(truth - own).max(0.0_f64.min(truth)), truth + own];
                    let is_within = |truth: f64| (value - truth).abs() <= (claim.error * truth).max(absolute);
                    judged.within += u64::from(is_within(truth));
                    judged.outside += u64::from(!is_within(value.clamp(low, high)));
                }
                Pixel::NotRendered | Pixel::NoTruth => continue,
            }
            judged.of += 1;
        }
        (judged.of > 0).then_some(judged)
    }

    /// Returns the share of the pixels within the claimed error of the reference.
    pub fn share(&self) -> f64 {
        self.within as f64 / self.of as f64
    }

    /// Returns the share of the pixels that are not certainly outside.
    pub fn upper_share(&self) -> f64 {
        (self.of - self.outside) as f64 / self.of as f64
    }

    /// Returns true if the share is as large as claimed; `None` if the reference is too noisy for a
    /// verdict.
    pub fn verdict(&self) -> Option<bool> {
        let claimed = self.claim.lower_within();
        // Share of the pixels at which the reference exceeds its own error bound.
        let mistaken = 1.0 - OwnError::CONFIDENCE;
        match (self.share() >= claimed, self.upper_share() + mistaken < claimed) {
            (true, _) => Some(true),
            (false, true) => Some(false),
            (false, false) => None,
        }
    }

    /// Returns true if the share is certainly as large as claimed.
    pub fn held(&self) -> bool {
        self.verdict() == Some(true)
    }
}
