//! Options of light tracing ([`trace`](super::trace)).

use super::Clamp;
use crate::error::{Error, Result};
use crate::math::Instants;

/// Distribution of light paths and direct VPLs over the emitters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Emission {
    /// In proportion to power. Light from infinity has the power of all light that enters the
    /// sphere around the scene, most of which may miss the visible part of the scene.
    #[default]
    ByPower,
    /// In proportion to the light that reaches surfaces. A pilot measures this share for emitters
    /// in the scene and for light from infinity; within each kind, emitters are drawn by power. The
    /// number of light paths is limited more strictly: if few of them create VPLs, for example on
    /// metals, the set falls short of the requested number sooner.
    ByUse,
}

impl Emission {
    /// Returns the maximum number of light paths per requested VPL. If nearly all light misses the
    /// scene, the set therefore stays smaller.
    pub(super) fn max_paths_per_vpl(self) -> u64 {
        match self {
            Self::ByPower => 256,
            Self::ByUse => 4,
        }
    }
}

/// Options for a set of VPLs.
#[derive(Clone, Debug, PartialEq)]
pub struct VplOptions {
    /// Number of VPLs, met to within a few percent; 1 to 10⁸. More VPLs give less noise and less
    /// clamping. Default: 5000.
    pub count: u64,
    /// Seed of the light paths.
    pub seed: u64,
    /// Maximum number of surfaces on a light path; 0 to 1000. At zero there is only direct light.
    /// Scattering in media does not count. Default: 64.
    pub max_depth: u32,
    /// Share of the VPLs on emitting surfaces and towards the environment, 0 to 1. At 0 the direct
    /// light of these emitters is omitted, at 1 all indirect light. Default: 0.25.
    pub direct_share: f32,
    /// Distribution of light paths and direct VPLs over the emitters. Default: by power.
    pub emission: Emission,
    /// Distance below which the geometric term no longer grows. With several instants, the mean of
    /// the distances of all instants is used.
    pub clamp: Clamp,
    /// Number of instants at which the scene is sampled if anything moves while the shutter is
    /// open; 1 to 1024. With more instants, the separate images of moving objects are less visible,
    /// and cuts start with more pairs. Default: 32.
    pub instants: u32,
}

impl Default for VplOptions {
    fn default() -> Self {
        Self {
            count: 5000,
            seed: 1,
            max_depth: 64,
            direct_share: 0.25,
            emission: Emission::ByPower,
            clamp: Clamp::Auto,
            instants: 32,
        }
    }
}

/// Largest number of VPLs (4.8 GB).
const MAX_COUNT: u64 = 100_000_000;

impl VplOptions {
    /// Returns the maximum number of surfaces on a path of light, including the one that the camera
    /// sees.
    pub fn path_depth(&self) -> u32 {
        self.max_depth + 1
    }

    /// Checks that all options are in range.
    ///
    /// # Errors
    /// Names the option that is out of range, and the range.
    pub fn validate(&self) -> Result<()> {
        if !(1..=MAX_COUNT).contains(&self.count) {
            return Err(Error::option("vpls", self.count, format!("1 to {MAX_COUNT}")));
        }
        if self.max_depth > 1000 {
            return Err(Error::option("max_depth", self.max_depth, "0 to 1000"));
        }
        if !(0.0..=1.0).contains(&self.direct_share) {
            return Err(Error::option("direct_share", self.direct_share, "0 to 1"));
        }
        if !(1..=Instants::MOST).contains(&self.instants) {
            return Err(Error::option("instants", self.instants, format!("1 to {}", Instants::MOST)));
        }
        self.clamp.validate()
    }
}
