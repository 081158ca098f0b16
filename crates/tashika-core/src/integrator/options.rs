//! What the methods that control their error are told, and the lights that they work on.

use std::fmt;

use super::Setting;
use crate::color::{Controlled, RgbSum};
use crate::contribution::ContributionKernel;
use crate::error::{Error, Result};
use crate::tree::LightTree;
use crate::vpl::Provenance;

/// The lights of an image, in a tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lights<'a> {
    /// The tree over them.
    pub tree: &'a LightTree,
    /// Where they come from, with the clamp that belongs to them.
    pub provenance: &'a Provenance,
}

impl Lights<'_> {
    /// What evaluates, and bounds, their contributions to what a view sees.
    pub fn kernel<'s>(&self, setting: &Setting<'s>) -> ContributionKernel<'s> {
        let (scene, about) = (setting.tracer.scene(), setting.view.camera.medium);
        ContributionKernel::new(self.provenance.clamp_distance)
            .within(scene)
            .dimmed(scene.least_extinction(about))
    }
}

/// What an error is the distance from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Truth {
    /// The sum over one given set of VPLs and one given set of gather points.
    Vpl,
    /// The expectation of that sum over sets, clamped as it is, and of what is seen directly: what
    /// VPLs do not carry is missing.
    Clamped,
    /// Light transport.
    Transport,
}

impl Truth {
    /// All of them, as users choose among them.
    pub const ALL: [Self; 3] = [Self::Vpl, Self::Clamped, Self::Transport];
}

impl fmt::Display for Truth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Vpl => "vpl",
            Self::Clamped => "clamped",
            Self::Transport => "transport",
        })
    }
}

/// What a user chooses of a method that controls its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlOptions {
    /// Relative error `ε`. Lower values cost more. Default 0.02; above 0, at most 1.
    pub error: f64,
    /// What `error` is the error of. Default: luminance. Only our own method takes another.
    pub controlled: Controlled,
    /// Absolute error that is enough where it is more than `ε` of the pixel: for the dark, where
    /// nobody sees a relative error (W·m⁻²·sr⁻¹). Default 0; at least 0. Only our own method takes
    /// it.
    pub absolute_error: f64,
    /// Confidence of the interval, for the methods that state one. Higher values cost more. Default
    /// 0.95; in (0, 1).
    pub confidence: f64,
    /// Pairs beyond which a cut does not grow. Default: what the method's source says, or
    /// [`MANY_PAIRS`]. At least 1.
    pub max_pairs: Option<u64>,
    /// Seed of the terms that are drawn. The gather points have their own, in the view. Default 1.
    pub seed: u64,
}

impl Default for ControlOptions {
    fn default() -> Self {
        Self {
            error: 0.02,
            controlled: Controlled::Luminance,
            absolute_error: 0.0,
            confidence: 0.95,
            max_pairs: None,
            seed: 1,
        }
    }
}

/// Largest cut where no source names one: bounds the memory of a pixel to about 100 MB.
pub const MANY_PAIRS: u64 = 1 << 20;

/// `ε_abs` where nobody says it: `ε` of this share of the mean luminance of the view.
const DARK: f64 = 0.01;

impl ControlOptions {
    /// The same for light transport in a view of this mean luminance (W·m⁻²·sr⁻¹): where nobody says
    /// which absolute error is enough, a hundredth of the mean is dark.
    #[must_use]
    pub fn in_view_of(mut self, brightness: f64) -> Self {
        if self.absolute_error == 0.0 {
            self.absolute_error = DARK * self.error * brightness;
        }
        self
    }

    /// Half-width that is narrow enough for an estimate: `max(ε L̂ / (1 + ε), ε_abs)`.
    ///
    /// With the error at most `ε L̂ / (1 + ε)`, it is at most `ε L` relative to the truth.
    pub fn tolerance(&self, sum: &RgbSum) -> f64 {
        self.tolerance_of(self.controlled.size(sum))
    }

    /// The same of what is controlled, if it is so large (W·m⁻²·sr⁻¹).
    pub fn tolerance_of(&self, size: f64) -> f64 {
        (self.error / (1.0 + self.error) * size).max(self.absolute_error)
    }

    /// # Errors
    /// Says which value is out of range, and the range.
    pub fn validate(&self) -> Result<()> {
        if !(self.error > 0.0 && self.error <= 1.0) {
            return Err(Error::option("error", self.error, "above 0, at most 1 (100%)"));
        }
        if !(self.absolute_error >= 0.0 && self.absolute_error.is_finite()) {
            return Err(Error::option("absolute", self.absolute_error, "a radiance of 0 or more"));
        }
        if !(self.confidence > 0.0 && self.confidence < 1.0) {
            return Err(Error::option("confidence", self.confidence, "above 0 and below 1 (100%)"));
        }
        if self.max_pairs == Some(0) {
            return Err(Error::option("max_pairs", 0, "1 or more"));
        }
        Ok(())
    }
}
