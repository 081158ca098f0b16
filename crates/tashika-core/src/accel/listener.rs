//! Recording of the queries to a tracer, so that the tracing alone can be replayed and timed.

use std::fmt;

use super::segments::SegmentBatch;
use crate::math::Ray;

/// Receives every query to a [`Tracer`](super::Tracer) before it is answered. Called from any
/// thread.
pub trait Listener: fmt::Debug + Send + Sync {
    /// Receives a batch of segments whose visibility is queried.
    fn segments(&self, batch: &SegmentBatch);

    /// Receives a ray whose closest hit is queried, and the key that decides which partly opaque
    /// surfaces it passes.
    fn ray(&self, ray: &Ray, key: u64);
}
