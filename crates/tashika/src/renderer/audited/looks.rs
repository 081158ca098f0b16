//! Schedule of the interim analyses: which pictures are analysed, and with how many pixels.
//!
//! ```text
//! first picture      by n pixels; if it is dear, and there is hope, by m > n
//! each after it      by m if it is dear, else by n
//! the last           likewise
//! ```
//!
//! The schedule depends on the pictures alone, so the possible analyses are fixed before anything
//! is audited. There are at most [`AuditTerms::LOOKS`], and each has its share of the risk. An
//! analysis may be omitted because of audit results: this adds no risk, and only loses a chance to
//! succeed.

use crate::request::AuditTerms;

/// Largest ratio of the predicted share outside to the permitted share at which the first picture
/// is analysed. Chosen.
const LOOK_AT: f64 = 0.5;
/// Approximate number of rays of a truth.
const TRUTH_RAYS: u64 = 20_000;
/// Fraction by which an analysis with more pixels may, by luck, find fewer pixels outside than
/// expected. Chosen.
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

    /// Begins the analysis of a picture. Returns true for the first picture, false for a later one,
    /// and `None` if no more pictures may be analysed.
    pub fn begin(&mut self) -> Option<bool> {
        (self.pictures < AuditTerms::PICTURES).then(|| {
            self.pictures += 1;
            self.pictures == 1
        })
    }
}

/// Returns true if a picture of `rays` rays is so expensive that auditing more pixels is cheaper
/// than making another picture.
pub(super) fn is_expensive(terms: &AuditTerms, rays: u64) -> bool {
    rays >= TRUTH_RAYS.saturating_mul(terms.more_pixels() - terms.pixels)
}

/// Returns true if a picture with `outside` of `of` audited pixels outside may pass an audit of
/// `most` pixels.
pub(super) fn can_pass(terms: &AuditTerms, outside: u64, [of, most]: [u64; 2]) -> bool {
    let luck = if most > of { LUCK } else { 0.0 };
    let of_most = (1.0 - luck) * outside as f64 * most as f64 / of.max(1) as f64;
    terms.is_reached((of_most as u64).min(most), most)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TERMS: AuditTerms =
        AuditTerms { share: 0.95, assurance: 0.99, pixels: 600, looks: AuditTerms::LOOKS };

    /// 20 pictures, all predicted to be perfect. No more than `LOOKS` analyses are made, so each
    /// has its share of the risk.
    #[test]
    fn no_look_is_taken_that_is_not_paid_for() {
        let (mut looks, mut taken) = (Looks::default(), 0);
        for picture in 0..20 {
            let is_last = picture == 12;
            // A cancelled render begins a further analysis after the last picture.
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

    /// The first picture is analysed only if few enough pixels are predicted to be outside.
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

    /// If more pixels can be audited, there is hope as long as a little luck would suffice. If not,
    /// there is hope only if the claim is reached already.
    #[test]
    fn there_is_hope_as_long_as_a_look_may_succeed() {
        let most = |pixels: u64, of: u64| (0..of).rev().find(|k| TERMS.is_reached(*k, pixels)).unwrap();
        let (few, many) = (most(600, 600), most(1200, 1200));
        assert!(can_pass(&TERMS, few, [600, 600]) && !can_pass(&TERMS, few + 1, [600, 600]));
        let hopeful = (0..600).rev().find(|k| can_pass(&TERMS, *k, [600, 1200])).unwrap();
        assert!(hopeful > few && hopeful as f64 * 2.0 * 0.9 < (many + 1) as f64, "{few} {hopeful} {many}");
        assert!(!is_expensive(&TERMS, 11_999_999) && is_expensive(&TERMS, 12_000_000));
    }
}
