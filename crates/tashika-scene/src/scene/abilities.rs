//! Scene features that only some methods render: instances that move while the shutter is open.
//!
//! Checked by the suite's `moving_objects`.

use super::Scene;
use crate::error::{Error, Result};

/// Features that a method renders besides static scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Abilities {
    /// True if instances may move while the shutter is open.
    pub motion: bool,
}

impl Abilities {
    /// Static scenes only.
    pub const STILL: Self = Self { motion: false };
    /// Every feature.
    pub const ALL: Self = Self { motion: true };
}

impl Scene {
    /// Checks that a method with these abilities can render the scene.
    ///
    /// # Errors
    /// [`Error::Option`] if not, with the methods that can and the reason.
    pub fn check_method(&self, method: &str, abilities: Abilities) -> Result<()> {
        let Some([open, close]) = self.shutter().filter(|_| !abilities.motion) else { return Ok(()) };
        let moving = "things in it move while the shutter is open";
        let expected = format!(
            "path, or truth vpl, as {moving} ({open} to {close} s): all of their light is found by paths, or estimated as a sum over one set of VPLs; at one time all stands still"
        );
        Err(Error::option("method", method, expected))
    }
}
