//! Claims of pixels, and reasons why work on pixels ended.

use serde::{Deserialize, Serialize};

/// Claim of an estimate about its distance to the truth that it estimates.
///
/// The kind of truth and the confidence of intervals are stored once per film, in the metadata
/// [`TRUTH`](super::keys::TRUTH) and [`CONFIDENCE`](super::keys::CONFIDENCE).
///
/// Held to this by the suite's `control` and `cuts`, against exact sums.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Claim {
    /// No claim.
    #[default]
    None,
    /// The estimate is the sum over the given VPLs and gather points, to rounding.
    Exact,
    /// The interval that a published method states: the truth is supposed to be within the
    /// half-width. Neither proven nor calibrated.
    Published,
    /// An interval that, over scenes in general, holds at least as often as its confidence states.
    /// This is measured, not proven.
    Calibrated,
    /// An interval that holds with at least the confidence, for this pixel; proven.
    Certified,
    /// An interval of an audited map, which holds for a share of the picture's pixels
    /// ([`PictureClaim`](super::PictureClaim)). Nothing is known of a single pixel.
    Audited,
}

/// Reason why work on a pixel ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Stop {
    /// Work has not begun.
    #[default]
    NotRendered,
    /// There was nothing left to do.
    Complete,
    /// The requested number of samples is reached.
    SampleCount,
    /// The estimate is accurate enough by the method's own rule.
    RuleMet,
    /// The cost of the pixel has reached its budget.
    Budget,
    /// Too much light is unsampled for a claim: the method has no way to find it.
    NotFound,
    /// The estimate is infinite or not a number, because an intermediate result left the range of
    /// the numbers. The pixel claims nothing, whatever the method.
    NotFinite,
}

/// A code of a plane: a small number, and the words that it stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Code {
    /// Sample value in the plane.
    pub id: u32,
    /// Identifier for programs.
    pub name: &'static str,
    /// Meaning in a few words.
    pub label: &'static str,
    /// Colour of the code on pages, `#rrggbb`.
    pub color: &'static str,
}

const fn code(id: u32, name: &'static str, label: &'static str, color: &'static str) -> Code {
    Code { id, name, label, color }
}

impl Claim {
    /// All claims, in the order of their codes.
    pub const ALL: [Self; 6] =
        [Self::None, Self::Exact, Self::Published, Self::Calibrated, Self::Certified, Self::Audited];

    /// The codes of the plane `claim`, in the order of [`Self::ALL`].
    pub const CODES: &[Code] = &[
        code(0, "none", "nothing is claimed", "#d55e00"),
        code(1, "exact", "exact", "#0072b2"),
        code(2, "published", "published", "#e69f00"),
        code(3, "calibrated", "calibrated", "#56b4e9"),
        code(4, "certified", "certified", "#009e73"),
        code(5, "audited", "audited", "#cc79a7"),
    ];

    /// Row of the claim in [`Self::CODES`].
    pub const fn code(self) -> &'static Code {
        &Self::CODES[self as usize]
    }

    /// Number of the claim in the plane `claim` of a film.
    pub const fn id(self) -> u32 {
        self.code().id
    }

    /// Returns the claim of that number; [`Self::None`] if this version does not know the number.
    pub fn of_id(id: u32) -> Self {
        Self::ALL.into_iter().find(|claim| claim.id() == id).unwrap_or_default()
    }

    /// Returns true if anything is claimed, including exactness.
    pub fn is_some(self) -> bool {
        self != Self::None
    }

    /// Returns true if an interval is stated. Exact pixels and pixels without a claim state none.
    pub fn states_interval(self) -> bool {
        match self {
            Self::None | Self::Exact => false,
            Self::Published | Self::Calibrated | Self::Certified | Self::Audited => true,
        }
    }

    /// Returns the half-width as stated (W·m⁻²·sr⁻¹): zero if no interval is stated.
    pub fn stated(self, half_width: f64) -> f32 {
        if self.states_interval() { half_width as f32 } else { 0.0 }
    }

    /// Predicates of sentences about one pixel and about several pixels with this claim.
    pub fn sentences(self) -> [&'static str; 2] {
        match self {
            Self::None => ["claims nothing: do not rely on it.", "claim nothing: do not rely on them."],
            Self::Exact => {
                ["is the whole sum, exact up to rounding.", "are the whole sum, exact up to rounding."]
            }
            Self::Published => [
                "carries an interval as its method was published, not checked by this program.",
                "carry intervals as their method was published, not checked by this program.",
            ],
            Self::Calibrated => [
                "carries a calibrated interval: it holds at least as often as the confidence says, by measurement on other scenes.",
                "carry calibrated intervals: they hold at least as often as the confidence says, by measurement on other scenes.",
            ],
            Self::Certified => [
                "carries a certified interval: it holds by a theorem.",
                "carry certified intervals: they hold by a theorem.",
            ],
            Self::Audited => [
                "carries an interval of an audited map: most pixels of the picture are within theirs, as an audit found.",
                "carry intervals of an audited map: most pixels of the picture are within theirs, as an audit found.",
            ],
        }
    }
}

impl Stop {
    /// All reasons, in the order of their codes.
    pub const ALL: [Self; 7] = [
        Self::NotRendered,
        Self::Complete,
        Self::SampleCount,
        Self::RuleMet,
        Self::Budget,
        Self::NotFound,
        Self::NotFinite,
    ];

    /// The codes of the plane `stop`, in the order of [`Self::ALL`].
    pub const CODES: &[Code] = &[
        code(0, "not_rendered", "not rendered", "#969696"),
        code(1, "complete", "complete", "#0072b2"),
        code(2, "sample_count", "sample count", "#cc79a7"),
        code(3, "rule_met", "rule met", "#009e73"),
        code(4, "budget", "out of budget", "#d55e00"),
        code(5, "not_found", "light not found", "#f0e442"),
        code(6, "not_finite", "not finite", "#000000"),
    ];

    /// Row of the reason in [`Self::CODES`].
    pub const fn code(self) -> &'static Code {
        &Self::CODES[self as usize]
    }

    /// Number of the reason in the plane `stop` of a film.
    pub const fn id(self) -> u32 {
        self.code().id
    }

    /// Returns the reason of that number; [`Self::Budget`] if this version does not know the
    /// number. Such a pixel was rendered, and is not to be relied on.
    pub fn of_id(id: u32) -> Self {
        Self::ALL.into_iter().find(|stop| stop.id() == id).unwrap_or(Self::Budget)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_read_back_and_in_order() {
        for (claim, code) in Claim::ALL.into_iter().zip(Claim::CODES) {
            assert_eq!((claim.code(), Claim::of_id(code.id)), (code, claim));
        }
        for (stop, code) in Stop::ALL.into_iter().zip(Stop::CODES) {
            assert_eq!((stop.code(), Stop::of_id(code.id)), (code, stop));
        }
        assert_eq!((Claim::ALL.len(), Stop::ALL.len()), (Claim::CODES.len(), Stop::CODES.len()));
    }

    #[test]
    fn a_code_of_another_version_claims_nothing() {
        assert_eq!(Claim::of_id(6), Claim::None);
        assert_eq!(Stop::of_id(7), Stop::Budget, "it was rendered, and is not to be relied on");
    }

    #[test]
    fn only_intervals_have_a_half_width() {
        let stated = Claim::ALL.map(|claim| claim.stated(0.5));
        assert_eq!(stated, [0.0, 0.0, 0.5, 0.5, 0.5, 0.5]);
    }
}
