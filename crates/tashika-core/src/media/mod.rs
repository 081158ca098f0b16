//! Media between surfaces: free flights of paths, transmittance along segments, and the medium at a
//! place.
//!
//! * [`Leg`]: a straight part of a path in one medium. [`fly`] draws whether the path is scattered
//!   before the next surface. All paths consist of legs.
//! * [`transmittance`]: transmittance along a part of a ray in one medium.
//! * [`Segments`]: transmittance of media along whole batches of shadow segments, from interface to
//!   interface. It is the coloured counterpart of
//!   [`Tracer::visibility`](crate::accel::Tracer::visibility), evaluated only in scenes with media.
//!   [`Shadows`] combines both for single segments.
//! * [`Outside`]: the medium in which a light path starts.
//!
//! None of this code runs for scenes without media.
//!
//! # Held to this by
//! The tests below; the suite's `media`, `grid_media` and `volume_lights`.

mod flight;
mod leg;
mod null_collisions;
mod outside;
mod segments;
mod shadows;

pub use flight::{Flight, MAX_SURVIVAL_IN_MEDIUM, fly, transmittance};
pub use leg::{Leg, Scattering};
pub use outside::Outside;
pub use segments::{Segments, along_segment};
pub use shadows::Shadows;

/// Maximum number of boundaries and other surfaces that a straight line passes; a path or segment
/// that passes this many ends there.
pub const MOST_PASSED: u32 = 4096;
