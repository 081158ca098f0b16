//! Options of methods that control their error, and the lights that these methods use.

use std::fmt;

use super::Setting;
use crate::color::{Controlled, RgbSum};
use crate::contribution::ContributionKernel;
use crate::error::{Error, Result};
use crate::tree::LightTree;
use crate::vpl::Provenance;

/// Lights of an image, in a tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lights<'a> {
    /// Light tree that cuts refine.
    pub tree: &'a LightTree,
    /// Origin of the lights, with the clamp that belongs to them.
    pub provenance: &'a Provenance,
}

impl Lights<'_> {
    /// Kernel that evaluates and bounds the contributions of the lights to the points of a view.
    pub fn kernel<'s>(&self, setting: &Setting<'s>) -> ContributionKernel<'s> {
        let (scene, about) = (setting.tracer.scene(), setting.view.camera.medium);
        ContributionKernel::new(self.provenance.clamp_distance)
            .within(scene)
            .dimmed(scene.least_extinction(about))
    }
}

/// Quantity that an error is measured from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Truth {
    /// Sum over one given set of VPLs and one given set of gather points.
    Vpl,
    /// Expectation of that sum, with its clamp, over all sets of VPLs and of gather points, plus
    /// emission seen directly. Light that VPLs do not carry is missing.
    Clamped,
    /// Light transport itself: without clamp, and independent of any set.
    Transport,
}

impl Truth {
    /// All truths, in the order in which users choose among them.
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

/// Options of a method that controls its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlOptions {
    /// Relative error `ε`. Lower values cost more. Default 0.02; above 0, at most 1.
    pub error: f64,
    /// Error metric. Default: luminance. Only our own method takes another.
    pub controlled: Controlled,
    /// Absolute error that suffices where it exceeds `ε` of the pixel (W·m⁻²·sr⁻¹): for dark
    /// pixels, in which relative errors are invisible. Default 0; at least 0. Only our own method
    /// takes it.
    pub absolute_error: f64,
    /// Confidence of the interval, for the methods that state one. Higher values cost more. Default
    /// 0.95; in (0, 1).
    pub confidence: f64,
    /// Largest cut, in pairs. Default: the limit in the method's source, or [`MANY_PAIRS`]. At
    /// least 1.
    pub max_pairs: Option<u64>,
    /// Seed of the drawn terms. Gather points have a seed of their own, in the view. Default 1.
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

/// Largest cut of methods whose source sets no limit. It limits the memory of a pixel to about 100
/// MB.
pub const MANY_PAIRS: u64 = 1 << 20;

/// Default of `ε_abs`: `ε` of this share of the mean luminance of the view.
const DARK: f64 = 0.01;

impl ControlOptions {
    /// Returns the options for light transport in a view of this mean luminance (W·m⁻²·sr⁻¹). An
    /// absolute error of 0 becomes `ε` of a hundredth of the mean.
    #[must_use]
    pub fn in_view_of(mut self, brightness: f64) -> Self {
        if self.absolute_error == 0.0 {
            self.absolute_error = DARK * self.error * brightness;
        }
        self
    }

    /// Half-width that is narrow enough for an estimate: `max(ε L̂ / (1 + ε), ε_abs)`.
    ///
    /// If the error is at most `ε L̂ / (1 + ε)`, it is at most `ε L`, where `L` is the truth.
    pub fn tolerance(&self, sum: &RgbSum) -> f64 {
        self.tolerance_of(self.controlled.size(sum))
    }

    /// Tolerance for a given size of the error metric (W·m⁻²·sr⁻¹).
    pub fn tolerance_of(&self, size: f64) -> f64 {
        (self.error / (1.0 + self.error) * size).max(self.absolute_error)
    }

    /// Checks that all values are in range.
    ///
    /// # Errors
    /// [`Error::Option`] with the value that is out of range, and the range.
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
