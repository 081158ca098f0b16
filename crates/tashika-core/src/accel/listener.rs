//! Hearing what is asked of a tracer: to measure it again, alone.

use std::fmt;

use super::segments::SegmentBatch;
use crate::math::Ray;

/// Hears of every question to a [`Tracer`](super::Tracer), before it is answered. Called from any
/// thread.
pub trait Listener: fmt::Debug + Send + Sync {
    /// Visibility is asked for.
    fn segments(&self, batch: &SegmentBatch);

    /// The closest hit is asked for, with the key of holes.
    fn ray(&self, ray: &Ray, key: u64);
}
