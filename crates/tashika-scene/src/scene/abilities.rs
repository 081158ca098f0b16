//! What not every method renders: media, and instances that move while the shutter is open.
//!
//! Held to this by the suite's `media`, `volume_lights` and `moving_objects`.

use super::Scene;
use crate::error::{Error, Result};

/// What a method renders beside surfaces that stand still in vacuum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Abilities {
    /// Participating media.
    pub media: bool,
    /// Instances that move while the shutter is open.
    pub motion: bool,
}

impl Abilities {
    /// Neither.
    pub const STILL_SURFACES: Self = Self { media: false, motion: false };
    /// Everything.
    pub const ALL: Self = Self { media: true, motion: true };
}

impl Scene {
    /// Whether what is claimed of light transport is claimed by path tracing only.
    pub fn needs_paths(&self) -> bool {
        self.has_media() || self.moves()
    }

    /// Whether a method of these abilities may render it.
    ///
    /// # Errors
    /// [`Error::Option`] if not, naming the methods that render it and why.
    pub fn check_method(&self, method: &str, abilities: Abilities) -> Result<()> {
        let expected = if let Some([open, close]) = self.shutter().filter(|_| !abilities.motion) {
            let moving = "things in it move while the shutter is open";
            format!(
                "path, or truth vpl, as {moving} ({open} to {close} s): all of their light is found by paths, or estimated as a sum over one set of VPLs; at one time all stands still"
            )
        } else if self.has_media() && !abilities.media {
            let named: Vec<&str> = self.media().iter().map(|m| m.name.as_str()).take(3).collect();
            let media = named.join(", ");
            format!(
                "path, or truth vpl, as the scene has media ({media}): all of their light is found by paths, or estimated as a sum over one set of VPLs"
            )
        } else {
            return Ok(());
        };
        Err(Error::option("method", method, expected))
    }
}
