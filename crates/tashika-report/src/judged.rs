//! What became of what is claimed of a picture as a whole.

use super::pairs::{Pairs, Pixel};
use crate::film::{Claim, Film, PictureClaim, RenderFilm, keys};

/// A claim about a picture, held against a reference.
///
/// The reference is taken for the truth: where it is an estimate, what it is off itself is judged
/// too. Pixels that the audit was not about are left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureJudged {
    /// What is claimed.
    pub claim: PictureClaim,
    /// Pixels within the claimed error of the reference.
    pub within: u64,
    /// Of so many.
    pub of: u64,
}

impl PictureJudged {
    /// Holds a film's claim against a reference, pixel by pixel; none if nothing is claimed of the
    /// picture, or no pixel is there to be judged. A pixel that failed is not within.
    pub(super) fn of(film: &Film, pairs: Pairs<'_>) -> Option<Self> {
        let claim = PictureClaim::of(film.metadata())?;
        let absolute = film.metadata().number(keys::ERROR_ABSOLUTE).unwrap_or(0.0);
        let read = RenderFilm::of(film);
        let has_map = read.tally().of(Claim::Audited) > 0;
        let mut judged = Self { claim, within: 0, of: 0 };
        for (pixel, found) in pairs.pixels().enumerate() {
            let (Pixel::Failed { color, truth } | Pixel::Finite { color, truth }) = found else { continue };
            if has_map && read.claim(pixel) != Claim::Audited {
                continue;
            }
            let [value, truth] = [color, truth].map(|color| f64::from(color.luminance()));
            judged.of += 1;
            judged.within += u64::from((value - truth).abs() <= (claim.error * truth).max(absolute));
        }
        (judged.of > 0).then_some(judged)
    }

    /// Share of the pixels within the claimed error.
    pub fn share(&self) -> f64 {
        self.within as f64 / self.of as f64
    }

    /// Whether it is as large as is claimed.
    pub fn held(&self) -> bool {
        self.share() >= self.claim.lower_within()
    }
}
