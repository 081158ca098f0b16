//! Parts of the calibrated method, each of which can be disabled.

/// A part of the calibrated method that can be disabled to measure its effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Ingredient {
    /// Samples are inherited when pairs are split; without it, fresh ones are drawn.
    Inheritance,
    /// Small pairs are tabulated term by term when split; without it, bounds stand for their terms.
    Listing,
    /// Pairs are ranked by pilot visibility; without it, by bounds alone.
    Pilot,
    /// Visibilities of samples correct the predicted visibility.
    Correction,
    /// The interval has a term for rare bright light; without it, the interval is Student's.
    RareLight,
    /// Interim analyses are few, from 64 pairs on; without it, from 8 pairs on at every 2 % of
    /// growth.
    FewLooks,
}

impl Ingredient {
    /// The ingredients, in order of declaration.
    pub const ALL: [Self; 6] =
        [Self::Inheritance, Self::Listing, Self::Pilot, Self::Correction, Self::RareLight, Self::FewLooks];

    /// Name of the method without the ingredient.
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
