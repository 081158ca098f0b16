//! Terms of an audit, which makes a claim about a picture as a whole, and qualities by name.

use std::fmt;
use std::str::FromStr;

use super::Request;
use crate::error::{Error, Result};
use crate::integrator::{Promise, SumMethod};
use crate::stats::{rank_of_all, tolerance_rank, upper_share_outside, upper_share_outside_of_all};

/// A kind of claim, as users name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ClaimName {
    /// About each pixel, by measurement.
    Calibrated,
    /// About each pixel, by proof.
    Certified,
    /// About a share of the picture's pixels, by an audit of some of them.
    Audited,
}

impl ClaimName {
    /// All claims, those about each pixel first.
    pub const ALL: [Self; 3] = [Self::Calibrated, Self::Certified, Self::Audited];

    /// Name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Calibrated => "calibrated",
            Self::Certified => "certified",
            Self::Audited => "audited",
        }
    }

    /// Returns the promise about each pixel, or `None` for [`Audited`](Self::Audited).
    pub fn promise(self) -> Option<Promise> {
        match self {
            Self::Calibrated => Some(Promise::Calibrated),
            Self::Certified => Some(Promise::Certified),
            Self::Audited => None,
        }
    }
}

impl From<Promise> for ClaimName {
    fn from(promise: Promise) -> Self {
        match promise {
            Promise::Calibrated => Self::Calibrated,
            Promise::Certified => Self::Certified,
        }
    }
}

impl fmt::Display for ClaimName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for ClaimName {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        let named = Self::ALL.into_iter().find(|claim| claim.name() == name);
        named.ok_or_else(|| {
            Error::option("claim", name, format!("one of {}", Self::ALL.map(Self::name).join(", ")))
        })
    }
}

/// Terms on which a picture is audited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AuditTerms {
    /// Share of the pixels that is to be within the error. Default 0.95; in (0, 1).
    pub share: f64,
    /// Confidence of the claim about that share. Default 0.99; in (½, 1).
    pub assurance: f64,
    /// Number of pixels to audit. Default 600.
    pub pixels: u64,
    /// Number of interim analyses that share the risk, at least 1. With fewer analyses, each gives
    /// a tighter bound. Default [`LOOKS`](Self::LOOKS); 2 with a time limit, 1 for a picture in
    /// parts or of fixed work.
    pub looks: u32,
    /// Number of pixels that the audited ones are drawn from, once it is known. If all of them are
    /// audited, the audit has no error of sampling.
    pub population: Option<u64>,
}

impl Default for AuditTerms {
    fn default() -> Self {
        Self { share: 0.95, assurance: 0.99, pixels: 600, looks: Self::LOOKS, population: None }
    }
}

impl AuditTerms {
    /// Largest number of pictures that are analysed.
    pub const PICTURES: u32 = 6;
    /// Largest number of interim analyses: one for each picture, and a second one for the first
    /// picture, with more pixels.
    pub const LOOKS: u32 = Self::PICTURES + 1;
    /// Largest number of passes of a picture. The paths double with each pass.
    pub const MAX_PASSES: u32 = 13;
    /// Joint confidence of all intervals of one audited pixel's truth.
    pub const CONFIDENCE: f64 = 0.95;
    /// Largest probability that these intervals miss the truth.
    const MISSED: f64 = 1.0 - Self::CONFIDENCE;

    /// Largest probability that one interim analysis is wrong.
    pub fn risk(&self) -> f64 {
        (1.0 - self.assurance) / f64::from(self.looks)
    }

    /// Upper bound on the share of the pixels that is outside the error, if `outside` of `audited`
    /// pixels are.
    pub fn upper_outside(&self, outside: u64, audited: u64) -> f64 {
        let bound = if self.is_of_all(audited) { upper_share_outside_of_all } else { upper_share_outside };
        bound(outside, audited, self.risk(), Self::MISSED)
    }

    /// Returns true if the audited pixels are all that there are.
    fn is_of_all(&self, audited: u64) -> bool {
        audited > 0 && self.population.is_some_and(|population| audited >= population)
    }

    /// Number of pixels of a more precise audit. If 95 % of the picture is to be within the error,
    /// up to 3 % of this number may be found outside, and up to 2 % of the usual number.
    pub fn more_pixels(&self) -> u64 {
        self.pixels.saturating_mul(2)
    }

    /// Returns true if an audit with this outcome finds enough pixels within the error.
    pub fn is_reached(&self, outside: u64, audited: u64) -> bool {
        self.upper_outside(outside, audited) <= 1.0 - self.share
    }

    /// Rank, from 1, of a ratio among the sorted ratios of `audited` pixels. The ratio of this rank
    /// scales the map of half-widths. `None` if the pixels are too few. The rank allows for
    /// intervals that miss the truth of an audited pixel.
    pub fn rank(&self, audited: u64) -> Option<u64> {
        if self.is_of_all(audited) {
            return rank_of_all(audited, self.share, self.risk(), Self::MISSED);
        }
        tolerance_rank(audited, 1.0 - (1.0 - self.share) * Self::CONFIDENCE, self.risk())
    }

    /// Checks that all values are in range.
    ///
    /// # Errors
    /// [`Error::Option`] with the value that is out of range, and the range.
    pub fn validate(&self) -> Result<()> {
        if !(self.share > 0.0 && self.share < 1.0) {
            return Err(Error::option("share", self.share, "above 0 and below 1 (100%)"));
        }
        if !(self.assurance > 0.5 && self.assurance < 1.0) {
            return Err(Error::option("assurance", self.assurance, "above 0.5 (50%) and below 1 (100%)"));
        }
        if !self.is_reached(0, self.pixels) || self.rank(self.pixels).is_none() {
            let is_enough = |n: &u64| self.is_reached(0, *n) && self.rank(*n).is_some();
            let enough = (0..24).map(|k| 1u64 << k).find(is_enough);
            let expected = match enough {
                Some(enough) => format!("more: {enough} are enough for {} at {}", self.share, self.assurance),
                None => "a share and an assurance that an audit can find".to_owned(),
            };
            return Err(Error::option("audit", self.pixels, expected));
        }
        Ok(())
    }
}

/// Quality of a picture: a claim and an error under one name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quality {
    /// Audited: 95 % of the pixels within 10 %.
    Draft,
    /// Audited: 95 % of the pixels within 5 %.
    Good,
    /// Each pixel within 2 %, with a confidence for each pixel.
    Final,
}

impl Quality {
    /// All qualities, from the largest error to the smallest.
    pub const ALL: [Self; 3] = [Self::Draft, Self::Good, Self::Final];

    /// Name on the command line and in Python.
    pub fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Good => "good",
            Self::Final => "final",
        }
    }

    /// Returns the claim of the quality.
    pub fn claim(self) -> ClaimName {
        match self {
            Self::Draft | Self::Good => ClaimName::Audited,
            Self::Final => ClaimName::Calibrated,
        }
    }

    /// Returns the relative error that the quality allows a pixel.
    pub fn error(self) -> f64 {
        match self {
            Self::Draft => 0.1,
            Self::Good => 0.05,
            Self::Final => 0.02,
        }
    }
}

impl FromStr for Quality {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        let named = Self::ALL.into_iter().find(|quality| quality.name() == name);
        named.ok_or_else(|| {
            Error::option("quality", name, format!("one of {}", Self::ALL.map(Self::name).join(", ")))
        })
    }
}

impl Request {
    /// Fills an unset claim and an unset error from a quality. If the method has a certified claim
    /// in its name, that claim is kept where the quality would set a calibrated one.
    /// [`with_quality`](Self::with_quality) refuses options that contradict the quality.
    #[must_use]
    pub fn of_quality(mut self, quality: Quality) -> Self {
        let is_certified = self.method.of_lights() == Some(SumMethod::Tashika(Promise::Certified));
        if !is_certified || quality.claim() == ClaimName::Audited {
            self.claim.get_or_insert(quality.claim());
        }
        self.error.get_or_insert(quality.error());
        self
    }
}
