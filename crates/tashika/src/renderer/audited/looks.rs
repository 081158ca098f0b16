//! Schedule of the interim analyses: which pictures have one, and by how many pixels.
//!
//! ```text
//! first picture      by n pixels; if it is dear, and there is hope, by m > n
//! each after it      by m if it is dear, else by n
//! the last           likewise
//! ```
//!
//! This schedule follows from the pictures, except that a possible analysis may be omitted. So
//! there are at most [`AuditTerms::LOOKS`] analyses, which are fixed before anything is audited,
//! and each has its share of the risk. An omitted analysis loses only its chance to succeed.

use crate::request::AuditTerms;

/// Predicted share outside, over the permitted share, up to which the first picture is analysed.
/// Chosen.
const LOOK_AT: f64 = 0.5;
/// Approximate number of rays of a truth.
const TRUTH_RAYS: u64 = 20_000;
/// Share of the expected pixels outside that an analysis by more pixels may miss by luck. Chosen.
const LUCK: f64 = 0.1;

/// Number of pictures analysed so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Looks {
    pictures: u32,
}

impl Looks {
    /// Returns true if a picture that is not the last is to be analysed.
    ///
    /// * `outside`: predicted share of its pixels outside the error.
    pub fn is_due(&self, terms: &AuditTerms, outside: f64) -> bool {
        let is_good = self.pictures > 0 || outside <= LOOK_AT * (1.0 - terms.share);
        is_good && self.pictures + 1 < AuditTerms::PICTURES
    }

    /// Begins with a picture. Returns `None` if no more may be analysed, else true for the first.
    pub fn begin(&mut self) -> Option<bool> {
        (self.pictures < AuditTerms::PICTURES).then(|| {
            self.pictures += 1;
            self.pictures == 1
        })
    }
}

/// Returns true if a picture of `rays` rays is so expensive that more pixels are audited before
/// another picture is made.
pub(super) fn is_dear(terms: &AuditTerms, rays: u64) -> bool {
    rays >= TRUTH_RAYS.saturating_mul(terms.more_pixels() - terms.pixels)
}

/// Returns true if a picture with `outside` of `of` pixels outside may pass by `most` pixels.
pub(super) fn is_hopeful(terms: &AuditTerms, outside: u64, [of, most]: [u64; 2]) -> bool {
    let luck = if most > of { LUCK } else { 0.0 };
    let of_most = (1.0 - luck) * outside as f64 * most as f64 / of.max(1) as f64;
    terms.is_reached((of_most as u64).min(most), most)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TERMS: AuditTerms =
        AuditTerms { share: 0.95, assurance: 0.99, pixels: 600, looks: AuditTerms::LOOKS };

    /// However many pictures there are, every analysis has a share of the risk.
    #[test]
    fn no_look_is_taken_that_is_not_paid_for() {
        let (mut looks, mut taken) = (Looks::default(), 0);
        for picture in 0..20 {
            let is_last = picture == 12;
            // Every picture is predicted to be perfect; a cancelled render asks again after the
            // last.
            if is_last || picture > 12 || looks.is_due(&TERMS, 0.0) {
                taken += match looks.begin() {
                    Some(true) => 2,
                    Some(false) => 1,
                    None => 0,
                };
            }
            assert!(picture >= 12 || taken < AuditTerms::LOOKS, "the last picture must have one left");
        }
        assert_eq!(taken, AuditTerms::LOOKS);
    }

    /// Pictures are analysed once few pixels are predicted to be outside.
    #[test]
    fn looks_are_due_where_pictures_are_foreseen_to_be_good() {
        let mut looks = Looks::default();
        let due = |looks: &Looks| [0.026, 0.025].map(|outside| looks.is_due(&TERMS, outside));
        assert_eq!(due(&looks), [false, true]);
        assert_eq!(looks.begin(), Some(true));
        for _ in 2..AuditTerms::PICTURES {
            assert_eq!(due(&looks), [true; 2]);
            assert_eq!(looks.begin(), Some(false));
        }
        assert_eq!(due(&looks), [false; 2], "what is left is for the end");
    }

    /// With more pixels an analysis may pass by a little luck; without more, only if the claim
    /// holds.
    #[test]
    fn there_is_hope_as_long_as_a_look_may_succeed() {
        let most = |pixels: u64, of: u64| (0..of).rev().find(|k| TERMS.is_reached(*k, pixels)).unwrap();
        let (few, many) = (most(600, 600), most(1200, 1200));
        assert!(is_hopeful(&TERMS, few, [600, 600]) && !is_hopeful(&TERMS, few + 1, [600, 600]));
        let hopeful = (0..600).rev().find(|k| is_hopeful(&TERMS, *k, [600, 1200])).unwrap();
        assert!(hopeful > few && hopeful as f64 * 2.0 * 0.9 < (many + 1) as f64, "{few} {hopeful} {many}");
        assert!(!is_dear(&TERMS, 11_999_999) && is_dear(&TERMS, 12_000_000));
    }
}
