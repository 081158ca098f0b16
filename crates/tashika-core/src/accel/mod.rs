//! Rays: the closest hit, and the visibility of *batches* of segments.
//!
//! # The interface
//! * [`Tracer::closest_hit`]: the first surface along a ray.
//! * [`Tracer::visibility`]: for each segment of a [`SegmentBatch`] the share of light that passes,
//!   `V ∈ [0, 1]`. Segments come as *fans*: one end is common to all segments of a fan (a VPL, or a
//!   gather point, or a direction to infinity), the other ends are its targets. Those of a fan walk
//!   through the trees together as long as they can, so that the order of targets decides the
//!   speed: neighbours should be close.
//!
//! Both have a twin for scenes in which instances move while the shutter is open
//! ([`Tracer::closest_hit_at`], [`Tracer::visibility_at`]), which asks for a time.
//!
//! Nothing outside this module names a ray tracer or asks about a single segment in a loop.
//!
//! # When does a triangle block a segment
//! For a segment from `o` to `x` and a triangle `(v₀, v₁, v₂)` with `n = (v₁ − v₀) × (v₂ − v₀)`:
//!
//! 1. *Ends on opposite sides, certainly.* `T₀ = (v₀ − o)·n` and `T₁ = (v₀ − x)·n` have opposite
//!    signs and each is larger than the bound of its own rounding error (`triangle::Planes`). For a
//!    segment to infinity, `T₁ = −d·n`.
//! 2. *The line passes inside.* `d·(b × c)`, `d·(c × a)`, `d·(a × b)` with `a, b, c = vᵢ − o` all
//!    have the sign of `T₀`, or are zero. Two triangles with a common edge compute the very same
//!    number for it, negated, so that no segment slips between them (edge functions as in Plücker
//!    coordinates). Where several edges meet in a corner the signs are independent: a segment that
//!    passes a corner within rounding error may slip.
//!
//! Points on surfaces leave them by
//! [`math::offset_from_surface`](crate::math::offset_from_surface), after which the true plane of
//! their triangle is certainly behind. By rule 1 that triangle, and any other in the same plane,
//! then never blocks the segment: not at grazing angles, not far from the origin, not for slivers.
//! What is lost are blockers closer to an end than the arithmetic can tell. Held to this by
//! `accel::tests`.
//!
//! # What lets light pass
//! Surfaces with opacity pass `1 − α`; glass passes `(1 − F) t` at each face, straight ([`Glass`]).
//! What passes several of them is the product. Where the line passes an edge exactly, both
//! triangles count.
//!
//! # Same bits everywhere
//! The answer for a segment is a function of the scene and its two ends: it is tested against the
//! triangles of exactly those leaves whose boxes it meets itself, in the order of the tree, and the
//! arithmetic is plain IEEE operations without contraction. Grouping, threads, instruction sets and
//! what was asked before do not enter.

mod beam;
mod bvh;
mod kernel;
mod listener;
mod moving;
mod occluders;
mod packet;
mod segments;
mod single;
mod split;
mod tracer;
mod trees;
mod triangle;

#[cfg(test)]
mod tests;

pub use listener::Listener;
pub use segments::{Apex, Fan, Glass, SegmentBatch};
pub use tracer::{Hit, Tracer, TracerSize};
