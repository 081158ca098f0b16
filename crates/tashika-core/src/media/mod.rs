//! Media between surfaces: free flights of paths, transmittance along segments, and the medium at a
//! place.
//!
//! * [`Leg`]: a straight part of a path in one medium. [`fly`] draws whether the path is scattered
//!   on its way to the next surface. All paths consist of legs.
//! * [`transmittance`]: transmittance of a part of a ray in one medium.
//! * [`Segments`]: transmittance of whole batches of shadow segments, from interface to interface:
//!   the coloured companion of [`Tracer::visibility`](crate::accel::Tracer::visibility), which is
//!   evaluated in scenes with media only. [`Shadows`] combine both for single segments.
//! * [`Outside`]: the medium in which a light path begins.
//!
//! A scene without media runs none of this code.
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

/// Maximum number of boundaries and other surfaces that one straight line passes: a path or segment
/// ends there.
pub const MOST_PASSED: u32 = 4096;
