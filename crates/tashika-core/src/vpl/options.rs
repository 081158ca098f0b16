//! How many VPLs, and which: what is asked of [`trace`](super::trace).

use super::Clamp;
use crate::error::{Error, Result};
use crate::math::Instants;

/// Which emitters light paths start from, and how many direct VPLs each has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Emission {
    /// In proportion to power. Light from infinity has the power of all that enters the sphere
    /// about the scene, most of which may miss what can be seen of it.
    #[default]
    ByPower,
    /// Emitters in the scene, and light from infinity, by how much light of either reaches surfaces
    /// as a pilot finds it; among those of a kind by power. Where few light paths leave VPLs, on
    /// metals say, the set stays smaller sooner.
    ByUse,
}

impl Emission {
    /// Most light paths for each VPL that was asked for: where nearly all light misses the scene,
    /// the set stays smaller.
    pub(super) fn max_paths_per_vpl(self) -> u64 {
        match self {
            Self::ByPower => 256,
            Self::ByUse => 4,
        }
    }
}

/// How a set of VPLs is made.
#[derive(Clone, Debug, PartialEq)]
pub struct VplOptions {
    /// How many VPLs, to within a few percent; 1 to 10⁸. Higher: less noise and less clamping.
    /// Default: 5000.
    pub count: u64,
    /// Seed of the light paths.
    pub seed: u64,
    /// Longest light path, in surfaces met; 0 to 1000. Zero: direct light only. Being scattered in a
    /// medium does not count. Default: 64.
    pub max_depth: u32,
    /// Share of the VPLs that is placed on surfaces that emit and towards the environment, 0 to 1:
    /// at 0 their direct light is left out, at 1 all indirect light. Default: 0.25.
    pub direct_share: f32,
    /// Which emitters have them. Default: by power.
    pub emission: Emission,
    /// Distance below which the geometric term no longer grows; where there are several instants, by
    /// the mean of what the lights of each come to.
    pub clamp: Clamp,
    /// At how many times the scene is looked at, if anything in it moves while the shutter is open; 1 to
    /// 1024. More: things that move leave fewer images of themselves beside each other, and cuts begin
    /// with more pairs. Default: 32.
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
    /// Surfaces that a path of light meets at most, that which the camera sees included.
    pub fn path_depth(&self) -> u32 {
        self.max_depth + 1
    }

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
