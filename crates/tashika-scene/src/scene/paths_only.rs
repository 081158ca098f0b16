//! What only path tracing renders: media, and instances that move while the shutter is open. Sums over
//! VPLs know neither.
//!
//! Held to this by the suite's `media` and `moving_objects`.

use super::Scene;
use crate::error::{Error, Result};

impl Scene {
    /// Whether only path tracing renders it.
    pub fn needs_paths(&self) -> bool {
        self.has_media() || self.moves()
    }

    /// Whether a method other than path tracing may render it.
    ///
    /// # Errors
    /// [`Error::Option`] if the scene [needs paths](Self::needs_paths), naming the method that
    /// renders it and why.
    pub fn check_method(&self, method: &str) -> Result<()> {
        let why = if self.has_media() {
            let named: Vec<&str> = self.media().iter().map(|m| m.name.as_str()).take(3).collect();
            format!("the scene has media ({}), which nothing else renders", named.join(", "))
        } else if let Some([open, close]) = self.shutter() {
            let moving = "things in it move while the shutter is open";
            format!(
                "{moving} ({open} to {close} s), which nothing else renders; at one time all stands still"
            )
        } else {
            return Ok(());
        };
        Err(Error::option("method", method, format!("path, as {why}")))
    }
}
