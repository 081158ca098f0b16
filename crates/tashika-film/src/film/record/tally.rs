//! Numbers of pixels by claim.

use std::array;
use std::ops::Add;

use serde::ser::{Serialize, SerializeMap, Serializer};

use super::claim::{Claim, Stop};

/// Numbers of pixels by kind: each pixel is of one kind.
///
/// | kind | a pixel is of it |
/// |---|---|
/// | not rendered | if [`Stop::NotRendered`] |
/// | not finite | if [`Stop::NotFinite`], whatever it claims: such a radiance has no error |
/// | out of budget | if [`Stop::Budget`], whatever it claims: its interval is too wide |
/// | exact, published, calibrated, certified | by its [`Claim`] |
/// | none | if it claims nothing |
///
/// A claim is a statement of an estimate about itself. Only a reference or an audit can show that
/// it *covers the truth*: see `report::Claims`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Finite pixels within the budget, by claim.
    by_claim: [u64; Claim::ALL.len()],
    /// Pixels that ran out of budget.
    pub out_of_budget: u64,
    /// Pixels that ran out of budget and claim something nevertheless.
    pub wider: u64,
    /// Pixels that claim nothing because too much of their light is unsampled.
    pub not_found: u64,
    /// Pixels whose radiance is infinite or not a number.
    pub not_finite: u64,
    /// Pixels that were not rendered.
    pub not_rendered: u64,
}

impl Tally {
    /// Adds a pixel to the number of its kind.
    pub fn count(&mut self, claim: Claim, stop: Stop) {
        match stop {
            Stop::NotRendered => self.not_rendered += 1,
            Stop::NotFinite => self.not_finite += 1,
            Stop::Budget => {
                self.out_of_budget += 1;
                self.wider += u64::from(claim.is_some());
            }
            Stop::Complete | Stop::SampleCount | Stop::RuleMet | Stop::NotFound => {
                self.by_claim[claim as usize] += 1;
                self.not_found += u64::from(stop == Stop::NotFound);
            }
        }
    }

    /// Pixels of this claim, within the budget.
    pub fn of(&self, claim: Claim) -> u64 {
        self.by_claim[claim as usize]
    }

    /// Pixels that claim anything, within the budget.
    pub fn claiming(&self) -> u64 {
        Claim::ALL.into_iter().filter(|claim| claim.is_some()).map(|claim| self.of(claim)).sum()
    }

    /// Rendered pixels that claim nothing, for any reason.
    pub fn silent(&self) -> u64 {
        self.of(Claim::None) + self.out_of_budget - self.wider + self.not_finite
    }

    /// Pixels that were rendered, finite or not.
    pub fn rendered(&self) -> u64 {
        self.by_claim.iter().sum::<u64>() + self.out_of_budget + self.not_finite
    }

    /// All pixels, rendered or not.
    pub fn pixels(&self) -> u64 {
        self.rendered() + self.not_rendered
    }
}

/// Sums the numbers of two sets of pixels.
impl Add for Tally {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            by_claim: array::from_fn(|k| self.by_claim[k] + other.by_claim[k]),
            out_of_budget: self.out_of_budget + other.out_of_budget,
            wider: self.wider + other.wider,
            not_found: self.not_found + other.not_found,
            not_finite: self.not_finite + other.not_finite,
            not_rendered: self.not_rendered + other.not_rendered,
        }
    }
}

/// A map with the names of [`Claim::CODES`], then `out_of_budget` and the other fields.
impl Serialize for Tally {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for claim in Claim::ALL {
            map.serialize_entry(claim.code().name, &self.of(claim))?;
        }
        map.serialize_entry("out_of_budget", &self.out_of_budget)?;
        map.serialize_entry("wider", &self.wider)?;
        map.serialize_entry("not_found", &self.not_found)?;
        map.serialize_entry("not_finite", &self.not_finite)?;
        map.serialize_entry("not_rendered", &self.not_rendered)?;
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tally(pixels: &[(Claim, Stop)]) -> Tally {
        let mut tally = Tally::default();
        pixels.iter().for_each(|(claim, stop)| tally.count(*claim, *stop));
        tally
    }

    #[test]
    fn each_pixel_is_of_one_kind() {
        let found = tally(&[
            (Claim::Exact, Stop::Complete),
            (Claim::Calibrated, Stop::RuleMet),
            (Claim::Calibrated, Stop::RuleMet),
            (Claim::Calibrated, Stop::Budget),
            (Claim::None, Stop::Budget),
            (Claim::None, Stop::NotFound),
            (Claim::Exact, Stop::NotFinite),
            (Claim::None, Stop::SampleCount),
            (Claim::None, Stop::NotRendered),
        ]);
        assert_eq!(Claim::ALL.map(|claim| found.of(claim)), [2, 1, 0, 2, 0, 0]);
        assert_eq!((found.claiming(), found.out_of_budget, found.wider, found.silent()), (3, 2, 1, 4));
        assert_eq!((found.not_found, found.not_finite, found.rendered(), found.pixels()), (1, 1, 8, 9));
    }

    #[test]
    fn programs_read_it_by_name() {
        let json = serde_json::to_value(tally(&[(Claim::Certified, Stop::RuleMet)])).unwrap();
        let expected = serde_json::json!({
            "none": 0, "exact": 0, "published": 0, "calibrated": 0, "certified": 1, "audited": 0,
            "out_of_budget": 0, "wider": 0, "not_found": 0, "not_finite": 0,
            "not_rendered": 0,
        });
        assert_eq!(json, expected);
    }
}
