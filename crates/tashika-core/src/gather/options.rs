//! How many gather points a pixel has, and how they are spread.

use super::Filter;
use crate::error::{Error, Result};

/// How many gather points a pixel has, and how they are spread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GatherOptions {
    /// Points a pixel, 1 to 1024. Higher: smoother edges, depth of field and mirrors. Default: 4.
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
    /// # Errors
    /// Names the option that is out of range, and the range.
    pub fn validate(&self) -> Result<()> {
        if (1..=1024).contains(&self.points) {
            Ok(())
        } else {
            Err(Error::option("gather", self.points, "1 to 1024"))
        }
    }
}
