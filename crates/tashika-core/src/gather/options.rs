//! Number of gather points of a pixel, and the pixel filter.

use super::Filter;
use crate::error::{Error, Result};

/// Number of gather points of a pixel, and their distribution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GatherOptions {
    /// Gather points for each pixel, 1 to 1024. Higher: smoother edges, depth of field and mirrors.
    /// Default: 4.
    pub points: u32,
    /// The pixel filter. Default: the box.
    pub filter: Filter,
}

impl Default for GatherOptions {
    fn default() -> Self {
        Self { points: 4, filter: Filter::Box }
    }
}

impl GatherOptions {
    /// Most gather points of a pixel.
    pub const MAX_POINTS: u32 = 1024;

    /// Checks that the options are in range.
    ///
    /// # Errors
    /// Names the option that is out of range, and the range.
    pub fn validate(&self) -> Result<()> {
        if (1..=Self::MAX_POINTS).contains(&self.points) {
            Ok(())
        } else {
            Err(Error::option("gather", self.points, format!("1 to {}", Self::MAX_POINTS)))
        }
    }
}
