//! Rays: the closest hit, and the visibility of *batches* of segments.
//!
//! # The interface
//! * [`Tracer::closest_hit`]: the first surface along a ray.
//! * [`Tracer::visibility`]: the transmittance `V ∈ [0, 1]` of each segment of a [`SegmentBatch`].
//!   Segments are grouped in *fans*. All segments of a fan share one end (a VPL, a gather point, or
//!   a direction to infinity); their other ends are the fan's targets. The segments of a fan
//!   traverse the trees together as long as possible, which is faster if successive targets are
//!   close to each other.
//!
//! Both have a variant that takes a time, for scenes in which instances move while the shutter is
//! open ([`Tracer::closest_hit_at`], [`Tracer::visibility_at`]).
//!
//! No code outside this module names a ray tracer or queries single segments in a loop.
//!
//! # When does a triangle block a segment
//! For a segment from `o` to `x` and a triangle `(v₀, v₁, v₂)` with `n = (v₁ − v₀) × (v₂ − v₀)`:
//!
//! 1. *The ends are on opposite sides of the plane, in exact geometry.* `T₀ = (v₀ − o)·n` and
//!    `T₁ = (v₀ − x)·n` have opposite signs. For a segment to infinity, `T₁ = −d·n`. In the space
//!    of an instance the ends are rounded, so there each of the two values must exceed its error
//!    bound (`triangle::Planes`).
//! 2. *The line meets the closed triangle, in exact geometry.* For the line from `o` along `d`, no
//!    two of the edge functions `d·(b × c)`, `d·(c × a)`, `d·(a × b)` with `a, b, c = vᵢ − o` have
//!    opposite signs.
//!
//! The signs are exact. They are taken from single precision where an error bound allows that,
//! otherwise from double precision, and otherwise from exact sums (`exact`).
//!
//! The lines that meet a triangle are exactly those that pass through it, however small and far
//! away it is: a triangle whose size is 10⁻¹⁵ times the distance is met by a correspondingly small
//! share of rays. No line slips between triangles with common corners, whether through an edge or
//! through a corner. The proof: consider a ray from inside a closed surface. If it passes through
//! no edge, it meets a triangle, as the surface winds around its start. If it passes through edges,
//! it is the limit of rays that pass through none and that do not lie in the plane of any of the
//! finitely many triangles seen edge-on. One of the remaining triangles is met by such rays
//! arbitrarily close to the limit. Since this triangle is closed, the limit meets it, too. Held to
//! this by `accel::scales`, against arithmetic of another library.
//!
//! # How points leave surfaces
//! [`math::offset_from_surface`](crate::math::offset_from_surface) moves a point so far that it is
//! certainly in front of the plane of its triangle. By rule 1 that triangle then never blocks the
//! segment, even at grazing angles, far from the origin and for slivers. A point near an edge of
//! its triangle is rounded, too, and could end up behind an adjoining wall:
//! [`Scene::surface_point`](crate::scene::Scene::surface_point) therefore moves it away from the
//! edge. Held to this by `accel::tests` and `accel::scales`.
//!
//! # Transmittance
//! A surface of opacity `α` transmits `1 − α`. Glass transmits `(1 − F) t` at each face, without a
//! change of direction ([`Glass`]). The transmittances of several surfaces are multiplied. If the
//! line passes exactly through an edge, both of its triangles count.
//!
//! # Same bits everywhere
//! The answer for a segment depends only on the scene and the two ends. The segment is tested
//! against the triangles of exactly those leaves whose boxes it meets itself, in the order of the
//! tree, and the arithmetic consists of plain IEEE operations without contraction. Grouping,
//! threads, instruction sets and earlier queries have no influence.

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
