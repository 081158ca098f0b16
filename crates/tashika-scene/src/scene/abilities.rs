//! What not every method renders: instances that move while the shutter is open.
//!
//! Held to this by the suite's `moving_objects`.

use super::Scene;
use crate::error::{Error, Result};

/// What a method renders beside what stands still.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Abilities {
    /// Instances that move while the shutter is open.
    pub motion: bool,
}

impl Abilities {
    /// Nothing.
    pub const STILL: Self = Self { motion: false };
    /// Everything.
    pub const ALL: Self = Self { motion: true };
}

impl Scene {
    /// Whether a method of these abilities may render it.
    ///
    /// # Errors
    /// [`Error::Option`] if not, naming the methods that render it and why.
    pub fn check_method(&self, method: &str, abilities: Abilities) -> Result<()> {
        let Some([open, close]) = self.shutter().filter(|_| !abilities.motion) else { return Ok(()) };
        let moving = "things in it move while the shutter is open";
        let expected = format!(
            "path, or truth vpl, as {moving} ({open} to {close} s): all of their light is found by paths, or estimated as a sum over one set of VPLs; at one time all stands still"
        );
        Err(Error::option("method", method, expected))
    }
}
