//! Which pictures are looked at, and by how many pixels.
//!
//! ```text
//! first picture      by n pixels; if it is dear, and there is hope, by m > n
//! each after it      by m if it is dear, else by n
//! the last           likewise
//! ```
//!
//! All of it follows from the pictures, but for whether a look that could be taken is left out: so
//! there are no looks but [`AuditTerms::LOOKS`] that are fixed before anything is audited, and each
//! has its share of the risk. A look that is left out costs nothing but its chance.

use crate::request::AuditTerms;

/// The first look is taken where so much of the share that may be outside is foreseen to be. Chosen.
const LOOK_AT: f64 = 0.5;
/// Rays of a truth, about.
const TRUTH_RAYS: u64 = 20_000;
/// Share of the pixels outside that a closer look at a picture may be lucky to miss. Chosen.
const LUCK: f64 = 0.1;

/// The pictures that were looked at so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Looks {
    pictures: u32,
}

impl Looks {
    /// Whether a picture is to be looked at that is not the last.
    ///
    /// * `outside`: share of its pixels that are foreseen to be outside.
    pub fn is_due(&self, terms: &AuditTerms, outside: f64) -> bool {
        let is_good = self.pictures > 0 || outside <= LOOK_AT * (1.0 - terms.share);
        is_good && self.pictures + 1 < AuditTerms::PICTURES
    }

    /// Begins with a picture: whether it may be looked at, and whether it is the first.
    pub fn begin(&mut self) -> Option<bool> {
        (self.pictures < AuditTerms::PICTURES).then(|| {
            self.pictures += 1;
            self.pictures == 1
        })
    }
}

/// Whether a picture of so many rays is so dear that more pixels are audited rather than another is
/// made.
pub(super) fn is_dear(terms: &AuditTerms, rays: u64) -> bool {
    rays >= TRUTH_RAYS.saturating_mul(terms.more_pixels() - terms.pixels)
}

/// Whether a picture may be found good enough by `most` pixels, if `outside` of so many are outside.
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

    /// However many pictures there are, no look is taken that has no share of the risk.
    #[test]
    fn no_look_is_taken_that_is_not_paid_for() {
        let (mut looks, mut taken) = (Looks::default(), 0);
        for picture in 0..20 {
            let is_last = picture == 12;
            // Every picture is foreseen to be perfect; what is cancelled after the last asks again.
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

    /// Pictures are looked at from where few pixels are foreseen outside.
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

    /// There is hope where a little luck would do; without more pixels, where the claim holds.
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
