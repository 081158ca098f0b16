//! What the calibrated method is made of, and can be made without.

/// A part of the calibrated method that can be left out, for measuring what it is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Ingredient {
    /// Samples are handed on where pairs are split; without it, fresh ones are drawn.
    Inheritance,
    /// Small pairs are tabulated term by term when split; without it, all are known by bounds.
    Listing,
    /// Pairs are ranked by pilot visibility; without it, by bounds alone.
    Pilot,
    /// What samples see corrects the visibility that was expected.
    Correction,
    /// The interval has a term for what is rare and bright; without it, it is Student's.
    RareLight,
    /// There are few looks, beginning at 64 pairs; without it, from 8 pairs on at every 2 %.
    FewLooks,
}

impl Ingredient {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Inheritance, Self::Listing, Self::Pilot, Self::Correction, Self::RareLight, Self::FewLooks];

    /// Name of the method without it.
    pub fn left_out(self) -> &'static str {
        match self {
            Self::Inheritance => "without inheritance",
            Self::Listing => "without listing",
            Self::Pilot => "without pilot visibility",
            Self::Correction => "without correction",
            Self::RareLight => "without rare light",
            Self::FewLooks => "without few looks",
        }
    }
}
