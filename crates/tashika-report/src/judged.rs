//! What became of what is claimed of a picture as a whole.

use super::own_error::OwnError;
use super::pairs::{Pairs, Pixel};
use crate::film::{Claim, Film, PictureClaim, RenderFilm, keys};

/// A claim about a picture, held against a reference.
///
/// Pixels are counted within by the reference as if it were the truth: its own noise only takes pixels
/// out of that count (see `claims`). A pixel is *outside* only if it is so wherever within its own error
/// the reference may be. Pixels that the audit was not about are left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureJudged {
    /// What is claimed.
    pub claim: PictureClaim,
    /// Pixels within the claimed error of the reference.
    pub within: u64,
    /// Pixels outside, whatever the reference's own error.
    pub outside: u64,
    /// Of so many.
    pub of: u64,
}

impl PictureJudged {
    /// Holds a film's claim against a reference, pixel by pixel; none if nothing is claimed of the
    /// picture, or no pixel is there to be judged. A pixel that failed is outside.
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

    /// Share of the pixels within the claimed error of the reference.
    pub fn share(&self) -> f64 {
        self.within as f64 / self.of as f64
    }

    /// Share of the pixels that are not certainly outside.
    pub fn upper_share(&self) -> f64 {
        (self.of - self.outside) as f64 / self.of as f64
    }

    /// Whether it is as large as is claimed; none if the reference is too noisy to tell.
    pub fn verdict(&self) -> Option<bool> {
        let claimed = self.claim.lower_within();
        // The reference is mistaken so often.
        let mistaken = 1.0 - OwnError::CONFIDENCE;
        match (self.share() >= claimed, self.upper_share() + mistaken < claimed) {
            (true, _) => Some(true),
            (false, true) => Some(false),
            (false, false) => None,
        }
    }

    /// Whether that is as large as is claimed.
    pub fn held(&self) -> bool {
        self.verdict() == Some(true)
    }
}
