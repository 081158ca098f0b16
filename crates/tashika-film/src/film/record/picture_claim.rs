//! Claim of an audit about a picture as a whole.

use std::fmt;

use serde::Serialize;

use super::{Claim, keys, planes};
use crate::film::{Film, Metadata, SampleKind};

/// "At least a share of the pixels are within the error": the claim about all pixels that an audit
/// of some of them supports.
///
/// The audited pixels were drawn at random from those of the picture, and their truths are
/// independent of the picture (`stats::upper_share_outside` has the formula). The claim is stored
/// in the metadata of the whole film, never of a part of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PictureClaim {
    /// Relative error that a pixel may have.
    pub error: f64,
    /// Share of the pixels that is to be within the error, in (0, 1).
    pub share: f64,
    /// Confidence of the claim about that share, in [½, 1).
    pub assurance: f64,
    /// Number of pixels that were audited.
    pub audited: u64,
    /// Audited pixels that are outside the error, or not known well enough.
    pub outside: u64,
    /// Upper bound of the share of the pixels that is outside, at confidence `assurance`.
    pub upper_outside: f64,
    /// True if `upper_outside` is at most `1 − share`.
    pub reached: bool,
    /// Pixels that the audited ones were drawn from: those that show more than a constant
    /// background.
    pub population: u64,
    /// Number of interim analyses, which compared unfinished pictures with the audited pixels.
    pub looks: u64,
    /// Passes that the picture was made in.
    pub passes: u64,
}

impl PictureClaim {
    /// Writes the claim into a film's metadata.
    pub fn describe(&self, metadata: &mut Metadata) {
        metadata.set(keys::ERROR, self.error);
        metadata.set(keys::AUDIT_SHARE, self.share);
        metadata.set(keys::AUDIT_ASSURANCE, self.assurance);
        metadata.set(keys::AUDIT_OF, self.audited);
        metadata.set(keys::AUDIT_WITHIN, self.audited - self.outside);
        metadata.set(keys::AUDIT_UPPER_OUTSIDE, self.upper_outside);
        metadata.set(keys::AUDIT_REACHED, self.reached);
        metadata.set(keys::AUDIT_POPULATION, self.population);
        metadata.set(keys::AUDIT_LOOKS, self.looks);
        metadata.set(keys::PASSES, self.passes);
    }

    /// Reads the claim from a film's metadata; `None` if nothing is claimed of the picture.
    pub fn of(metadata: &Metadata) -> Option<Self> {
        let number = |key: super::Key| metadata.number(key);
        let count = |key: super::Key| number(key).map(|n| n as u64);
        let audited = count(keys::AUDIT_OF)?;
        Some(Self {
            error: number(keys::ERROR)?,
            share: number(keys::AUDIT_SHARE)?,
            assurance: number(keys::AUDIT_ASSURANCE)?,
            audited,
            outside: audited.checked_sub(count(keys::AUDIT_WITHIN)?)?,
            upper_outside: number(keys::AUDIT_UPPER_OUTSIDE)?,
            reached: metadata.bool(keys::AUDIT_REACHED)?,
            population: count(keys::AUDIT_POPULATION)?,
            looks: count(keys::AUDIT_LOOKS)?,
            passes: count(keys::PASSES)?,
        })
    }

    /// Removes the claim, and the claims of the pixels, from a film that is only a part of the
    /// picture.
    pub(in crate::film) fn forget(film: &mut Film) {
        if Self::of(film.metadata()).is_none() {
            return;
        }
        for key in [keys::AUDIT_UPPER_OUTSIDE, keys::AUDIT_REACHED, keys::AUDIT_FACTOR] {
            film.metadata_mut().remove(key);
        }
        let window = film.window();
        if let Some(claims) = film.plane_mut(planes::CLAIM).filter(|plane| plane.kind() == SampleKind::U32) {
            let claiming = |(x, y): &(u32, u32)| claims.u32_at(*x, *y) == [Claim::Audited.id()];
            let claiming: Vec<(u32, u32)> = window.pixels().filter(claiming).collect();
            claiming.iter().for_each(|(x, y)| claims.set_u32(*x, *y, &[Claim::None.id()]));
            for spec in [planes::HALF_WIDTH, planes::HALF_WIDTH_PARTS] {
                let unknown = vec![f32::NAN; spec.channels.len()];
                let plane = film.plane_mut(spec).filter(|plane| plane.kind() == SampleKind::F32);
                if let Some(plane) = plane.filter(|plane| plane.channels().len() == unknown.len()) {
                    claiming.iter().for_each(|(x, y)| plane.set_f32(*x, *y, &unknown));
                }
            }
        }
    }

    /// Lower bound of the share of the pixels that is within the error.
    pub fn lower_within(&self) -> f64 {
        1.0 - self.upper_outside
    }
}

/// A sentence for people.
impl fmt::Display for PictureClaim {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { error, assurance, audited, outside, .. } = self;
        // Rounded down, so that the sentence claims no more than was shown.
        let within = (1000.0 * self.lower_within()).floor() / 10.0;
        let [error, assurance] = [error, assurance].map(|share| (share * 1e6).round() / 1e4);
        write!(
            f,
            "at least {within} % of the pixels are within {error} % of light transport, {assurance} % sure; \
             {audited} pixels were checked, {outside} were not certainly within"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{PixelRecord, RenderFilm, Window};

    fn claim() -> PictureClaim {
        PictureClaim {
            error: 0.1,
            share: 0.95,
            assurance: 0.99,
            audited: 300,
            outside: 4,
            upper_outside: 0.0437,
            reached: true,
            population: 5000,
            looks: 2,
            passes: 3,
        }
    }

    #[test]
    fn a_claim_comes_back_from_metadata() {
        let mut metadata = Metadata::default();
        assert_eq!(PictureClaim::of(&metadata), None);
        claim().describe(&mut metadata);
        assert_eq!(PictureClaim::of(&metadata), Some(claim()));
        metadata.set(keys::AUDIT_WITHIN, 301u64);
        assert_eq!(PictureClaim::of(&metadata), None, "more within than were audited");
    }

    #[test]
    fn a_part_of_a_picture_claims_nothing() {
        let size = [3, 2];
        let mut film = Film::new(size, Window::full(size), PixelRecord::PLANES).unwrap();
        claim().describe(film.metadata_mut());
        let audited = PixelRecord { claim: Claim::Audited, half_width: 0.5, ..PixelRecord::default() };
        film.window().pixels().for_each(|(x, y)| audited.store(&mut film, x, y));
        let whole = film.cropped(film.window()).unwrap();
        assert_eq!(PictureClaim::of(whole.metadata()), Some(claim()));
        let part = film.cropped(Window { x: 1, y: 0, width: 1, height: 2 }).unwrap();
        assert_eq!(PictureClaim::of(part.metadata()), None);
        assert_eq!(RenderFilm::of(&part).at(1, 1).claim, Claim::None);
        assert!(RenderFilm::of(&part).at(1, 1).half_width.is_nan(), "zero would be exact");
        assert_eq!(RenderFilm::of(&whole).at(1, 1).claim, Claim::Audited);
    }

    #[test]
    fn no_more_is_said_than_is_known() {
        let told = claim().to_string();
        assert!(told.starts_with("at least 95.6 % of the pixels are within 10 %"), "{told}");
        assert!(told.ends_with("300 pixels were checked, 4 were not certainly within"), "{told}");
    }
}
