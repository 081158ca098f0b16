//! What media do to light between surfaces: how far paths fly in them, what they leave of light along
//! segments, and which of them is where.
//!
//! * [`Leg`]: a straight part of a path in one medium, and by [`fly`] whether it is scattered on its way
//!   to the next surface. All paths go by legs.
//! * [`transmittance`]: what is left of light along a part of a ray in one medium.
//! * [`Segments`]: the same along whole batches of shadow segments, from interface to interface:
//!   the coloured companion of [`Tracer::visibility`](crate::accel::Tracer::visibility), which is
//!   asked for in scenes with media only. [`Shadows`] are both, for single segments.
//! * [`Outside`]: the medium that a light path begins in.
//!
//! A scene without media takes none of this code.
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

/// Boundaries and other surfaces that one straight line passes at most: a path or segment ends
/// there.
pub const MOST_PASSED: u32 = 4096;
