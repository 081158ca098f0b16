//! Schedule of the interim analyses: which pictures are analysed, and with how many pixels.
//!
//! ```text
//! first picture      by n pixels; if it is dear, and there is hope, by m > n
//! each after it      by m if it is dear, else by n
//! the last           likewise
//! ```
//!
//! With a time limit, fewer pixels can be audited, and each share of the risk costs more. One
//! picture is then analysed early, and the last one, each by the same pixels. A picture of fixed
//! work has one analysis.
//!
//! The schedule depends on the pictures alone, so the possible analyses are fixed before anything
//! is audited. There are at most [`Looks::most`], and each has its share of the risk. An
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

/// Largest number of pictures that are analysed with a time limit.
const PICTURES_IN_TIME: u32 = 2;

/// Number of pictures that are analysed: so far, and at most.
#[derive(Clone, Copy, Debug)]
pub(super) struct Looks {
    pictures: u32,
    most: u32,
    /// True if the first picture may be analysed twice, the second time by more pixels.
    extends: bool,
}

impl Looks {
    /// Schedule without a limit on the work.
    pub const OPEN: Self = Self { pictures: 0, most: AuditTerms::PICTURES, extends: true };
    /// Schedule for a time limit.
    pub const IN_TIME: Self = Self { pictures: 0, most: PICTURES_IN_TIME, extends: false };
    /// Schedule for a fixed number of passes.
    pub const FIXED: Self = Self { pictures: 0, most: 1, extends: false };

    /// Largest number of analyses.
    pub fn most(&self) -> u32 {
        self.most + u32::from(self.extends)
    }

    /// Returns true if the first picture may be analysed again by more pixels.
    pub fn extends(&self) -> bool {
        self.extends
    }

    /// Returns true if a picture that is not the last is to be analysed.
    ///
    /// * `outside`: predicted share of its pixels outside the error.
    pub fn is_due(&self, terms: &AuditTerms, outside: f64) -> bool {
        let is_good = self.pictures > 0 || outside <= LOOK_AT * (1.0 - terms.share);
        is_good && self.pictures + 1 < self.most
    }

    /// Begins the analysis of a picture. Returns true for the first picture, false for a later one,
    /// and `None` if no more pictures may be analysed.
    pub fn begin(&mut self) -> Option<bool> {
        (self.pictures < self.most).then(|| {
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
        AuditTerms { share: 0.95, assurance: 0.99, pixels: 600, looks: AuditTerms::LOOKS, population: None };

    /// 20 pictures, all predicted to be perfect. No more than `most` analyses are made, so each has
    /// its share of the risk.
    #[test]
    fn no_look_is_taken_that_is_not_paid_for() {
        assert_eq!([Looks::OPEN, Looks::IN_TIME, Looks::FIXED].map(|looks| looks.most()), [7, 2, 1]);
        [Looks::OPEN, Looks::IN_TIME, Looks::FIXED].into_iter().for_each(all_are_paid_for);
    }

    fn all_are_paid_for(mut looks: Looks) {
        let mut taken = 0;
        for picture in 0..20 {
            let is_last = picture == 12;
            // A cancelled render begins a further analysis after the last picture.
            if is_last || picture > 12 || looks.is_due(&TERMS, 0.0) {
                taken += match looks.begin() {
                    Some(true) if looks.extends() => 2,
                    Some(_) => 1,
                    None => 0,
                };
            }
            assert!(picture >= 12 || taken < looks.most(), "the last picture must have one left");
        }
        assert_eq!(taken, looks.most());
    }

    /// The first picture is analysed only if few enough pixels are predicted to be outside.
    #[test]
    fn looks_are_due_where_pictures_are_foreseen_to_be_good() {
        let mut looks = Looks::OPEN;
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
