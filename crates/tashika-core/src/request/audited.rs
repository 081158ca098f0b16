//! A claim about a picture as a whole: what is asked of its audit, and qualities by name.

use std::fmt;
use std::str::FromStr;

use super::Request;
use crate::error::{Error, Result};
use crate::integrator::{Promise, SumMethod};
use crate::stats::{tolerance_rank, upper_share_outside};

/// What is claimed, as users call it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ClaimName {
    /// Of each pixel, by measurement.
    Calibrated,
    /// Of each pixel, by proof.
    Certified,
    /// Of a share of the picture's pixels, by an audit of some of them.
    Audited,
}

impl ClaimName {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Calibrated, Self::Certified, Self::Audited];

    /// Name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Calibrated => "calibrated",
            Self::Certified => "certified",
            Self::Audited => "audited",
        }
    }

    /// What is promised of each pixel, if it is that.
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

/// What an audit is to find out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AuditTerms {
    /// Share of the pixels that is to be within the error. Default 0.95; in (0, 1).
    pub share: f64,
    /// How sure that is to be. Default 0.99; in [½, 1).
    pub assurance: f64,
    /// Pixels that are audited. Default 600.
    pub pixels: u64,
    /// Looks that share the risk, at least 1: fewer make each say more. Default
    /// [`LOOKS`](Self::LOOKS); of a picture in parts 1.
    pub looks: u32,
}

impl Default for AuditTerms {
    fn default() -> Self {
        Self { share: 0.95, assurance: 0.99, pixels: 600, looks: Self::LOOKS }
    }
}

impl AuditTerms {
    /// Pictures that are looked at, at most.
    pub const PICTURES: u32 = 6;
    /// Looks at these: the first picture may have a second, at more pixels.
    pub const LOOKS: u32 = Self::PICTURES + 1;
    /// Confidence of the intervals of an audited pixel's own truth, of all together.
    pub const CONFIDENCE: f64 = 0.95;

    /// The probability with which one look may be wrong.
    pub fn risk(&self) -> f64 {
        (1.0 - self.assurance) / f64::from(self.looks)
    }

    /// The share of the pixels that is outside at most, where `outside` of `audited` were.
    pub fn upper_outside(&self, outside: u64, audited: u64) -> f64 {
        upper_share_outside(outside, audited, self.risk(), 1.0 - Self::CONFIDENCE)
    }

    /// Pixels of an audit that tells more closely: 3 % of them may be outside where 95 % are to be
    /// within, and of the usual number 2 %.
    pub fn more_pixels(&self) -> u64 {
        self.pixels.saturating_mul(2)
    }

    /// Whether an audit with this outcome finds enough pixels within the error.
    pub fn is_reached(&self, outside: u64, audited: u64) -> bool {
        self.upper_outside(outside, audited) <= 1.0 - self.share
    }

    /// Which of the sorted ratios of `audited` pixels scales the map of half-widths; none if they are
    /// too few to tell. Intervals of truths that miss are reckoned with.
    pub fn rank(&self, audited: u64) -> Option<u64> {
        tolerance_rank(audited, 1.0 - (1.0 - self.share) * Self::CONFIDENCE, self.risk())
    }

    /// # Errors
    /// Says which value is out of range, and the range.
    pub fn validate(&self) -> Result<()> {
        if !(self.share > 0.0 && self.share < 1.0) {
            return Err(Error::option("share", self.share, "above 0 and below 1 (100%)"));
        }
        if !(self.assurance >= 0.5 && self.assurance < 1.0) {
            return Err(Error::option("assurance", self.assurance, "at least 0.5 (50%) and below 1 (100%)"));
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

/// How good a picture is to be, in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quality {
    /// Audited: 95 % of the pixels within 10 %.
    Draft,
    /// Audited: 95 % of the pixels within 5 %.
    Good,
    /// Each pixel within 2 %, with a confidence of its own.
    Final,
}

impl Quality {
    /// All of them.
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
    /// Fills an unset claim and an unset error from a quality; the name of a method may set the
    /// claim. [`with_quality`](Self::with_quality) refuses options that contradict the quality.
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
