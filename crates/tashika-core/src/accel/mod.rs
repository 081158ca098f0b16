//! Rays: the closest hit, and the visibility of *batches* of segments.
//!
//! # The interface
//! * [`Tracer::closest_hit`]: the first surface along a ray.
//! * [`Tracer::visibility`]: the transmittance `V ∈ [0, 1]` of each segment of a [`SegmentBatch`].
//!   Segments come as *fans*: one end is common to all segments of a fan (a VPL, or a gather point,
//!   or a direction to infinity), the other ends are its targets. The segments of a fan walk
//!   through the trees together as long as they can, so the order of targets decides the speed:
//!   neighbours should be close.
//!
//! Both have a variant that takes a time, for scenes in which instances move while the shutter is
//! open ([`Tracer::closest_hit_at`], [`Tracer::visibility_at`]).
//!
//! Nothing outside this module names a ray tracer or queries single segments in a loop.
//!
//! # When does a triangle block a segment
//! For a segment from `o` to `x` and a triangle `(v₀, v₁, v₂)` with `n = (v₁ − v₀) × (v₂ − v₀)`:
//!
//! 1. *The ends are on opposite sides, in exact geometry.* `T₀ = (v₀ − o)·n` and `T₁ = (v₀ − x)·n`
//!    have opposite signs. For a segment to infinity, `T₁ = −d·n`. In the space of an instance the
//!    ends are rounded: there each volume must exceed the bound of its error (`triangle::Planes`).
//! 2. *The line meets the closed triangle, in exact geometry.* For the line from `o` along `d`, no
//!    two of the edge functions `d·(b × c)`, `d·(c × a)`, `d·(a × b)` with `a, b, c = vᵢ − o` have
//!    opposite signs.
//!
//! The signs are exact: they are taken from single precision where an error bound allows, else from
//! double precision, else from exact sums (`exact`).
//!
//! A triangle is met by exactly the lines that pass through it, however small and far away it is: a
//! triangle whose size is 10⁻¹⁵ times the distance is met by a correspondingly small share of rays.
//! No line slips between triangles that have corners in common, neither through an edge nor through
//! a corner. The proof: every ray from inside a closed surface that passes no edge meets a
//! triangle, as the surface winds around its start. A ray that passes edges is the limit of rays
//! that pass none and that leave the planes of the finitely many triangles seen edge-on. One of the
//! other triangles is met by such rays arbitrarily close to the limit and, being closed, by the
//! limit itself. Held to this by `accel::scales`, against arithmetic of another library.
//!
//! # How points leave surfaces
//! [`math::offset_from_surface`](crate::math::offset_from_surface) moves a point so far that the
//! plane of its triangle is certainly behind. By rule 1 that triangle then never blocks the
//! segment: not at grazing angles, not far from the origin, not for slivers. A point near an edge
//! of its triangle is rounded, too, and could lie behind a wall that stands there:
//! [`Scene::surface_point`](crate::scene::Scene::surface_point) moves it away from the edge. Held
//! to this by `accel::tests` and `accel::scales`.
//!
//! # Transmittance
//! Surfaces with opacity pass `1 − α`; glass passes `(1 − F) t` at each face, straight ([`Glass`]).
//! Several surfaces multiply. Where the line passes an edge exactly, both triangles count.
//!
//! # Same bits everywhere
//! The answer for a segment is a function of the scene and its two ends: it is tested against the
//! triangles of exactly those leaves whose boxes it meets itself, in the order of the tree, and the
//! arithmetic is plain IEEE operations without contraction. Grouping, threads, instruction sets and
//! earlier queries do not enter.

mod around;
mod beam;
mod bvh;
mod exact;
mod kernel;
mod listener;
mod moving;
mod occluders;
mod packet;
mod pyramid;
mod segments;
mod single;
mod split;
mod tracer;
mod trees;
mod triangle;

#[cfg(test)]
mod scales;
#[cfg(test)]
mod tests;

pub use listener::Listener;
pub use pyramid::Pyramid;
pub use segments::{Apex, Fan, Glass, SegmentBatch};
pub use tracer::{Hit, Tracer, TracerSize};
