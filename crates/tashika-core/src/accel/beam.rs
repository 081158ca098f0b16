//! Tests of boxes against segments: the eight boxes of a node against one segment or a group of
//! segments, and one box against sixteen segments.
//!
//! All three use the same monotone roundings. Therefore a group enters every box that any of its
//! segments would enter alone, and a segment that meets the box of a leaf also meets the boxes of
//! all ancestors of the leaf.

use super::bvh::Node;
use super::triangle::Lines;
use crate::math::gamma;
use crate::math::simd::{F32x8, Vector, each};

/// Factor on the far end of a slab. It covers two bounds of three rounded operations each (Ize
/// 2013) and the rounding of the direction.
const SLAB_SLACK: f32 = 1.0 + 2.0 * gamma(5);

/// Components of directions whose absolute values are below this are replaced by ± this, so that no
/// slab is `0 · ∞`.
const SMALLEST_DIRECTION: f32 = 1e-30;

/// `1 / d`, finite and with the sign of `d`.
#[inline(always)]
pub(super) fn reciprocal(d: f32) -> f32 {
    1.0 / if d.abs() < SMALLEST_DIRECTION { SMALLEST_DIRECTION.copysign(d) } else { d }
}

/// Reciprocals of several numbers, each finite and with the sign of its number.
#[inline(always)]
pub(super) fn reciprocals<F: Vector>(d: F) -> F {
    let smallest = F::splat(SMALLEST_DIRECTION);
    F::splat(1.0) / F::select(smallest.gt(d.abs()), smallest.flipped_by(d), d)
}

/// Returns the largest parameter up to which a segment is tested against boxes: `t_max` with slack
/// for rounding.
#[inline(always)]
pub(super) fn limit(t_max: f32) -> f32 {
    t_max * SLAB_SLACK
}

/// A segment or ray, prepared for slab tests.
#[derive(Clone, Copy)]
pub(super) struct Slope<F> {
    origin: [F; 3],
    reciprocal: [F; 3],
    /// Indices of the near and far planes of each axis in [`Node::planes`].
    near: [usize; 3],
    far: [usize; 3],
}

impl<F: F32x8> Slope<F> {
    #[inline(always)]
    pub fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        let mut slope = Self {
            origin: each!(|axis| F::splat(origin[axis])),
            reciprocal: [F::splat(0.0); 3],
            near: [0, 1, 2],
            far: [3, 4, 5],
        };
        for (axis, d) in direction.into_iter().enumerate() {
            let r = reciprocal(d);
            slope.reciprocal[axis] = F::splat(r);
            if r < 0.0 {
                (slope.near[axis], slope.far[axis]) = (axis + 3, axis);
            }
        }
        slope
    }

    /// Mask of the children of a node whose boxes the segment meets below [`limit`], and the
    /// parameters at which the segment enters them.
    #[inline(always)]
    pub fn meets_children(&self, node: &Node, limit: f32) -> (u32, F) {
        let (mut near, mut far) = (F::splat(0.0), F::splat(limit));
        let slack = F::splat(SLAB_SLACK);
        for axis in 0..3 {
            let into = F::load(&node.planes[self.near[axis]]) - self.origin[axis];
            let out = F::load(&node.planes[self.far[axis]]) - self.origin[axis];
            near = (into * self.reciprocal[axis]).max(near);
            far = (out * self.reciprocal[axis] * slack).min(far);
        }
        (F::bits(near.le(far)), near)
    }
}

/// Intervals around the origins and reciprocal directions of segments whose directions have the
/// same signs.
#[derive(Clone, Copy)]
pub(super) struct Beam<F> {
    /// For each axis, the end of the interval of origins that bounds the parameter of the near
    /// plane from below, then the end that bounds the parameter of the far plane from above.
    from: [[F; 3]; 2],
    /// For each axis, the reciprocal direction of smallest magnitude, then that of largest
    /// magnitude.
    reciprocal: [[F; 3]; 2],
    near: [usize; 3],
    far: [usize; 3],
}

impl<F: F32x8> Beam<F> {
    /// Creates the beam around a group of segments from the least and largest values of their
    /// origins and reciprocal directions on each axis. `None` if on some axis the directions differ
    /// in sign.
    #[inline(always)]
    pub fn new(origins: [[f32; 2]; 3], reciprocals: [[f32; 2]; 3]) -> Option<Self> {
        let mut beam = Self {
            from: [[F::splat(0.0); 3]; 2],
            reciprocal: [[F::splat(0.0); 3]; 2],
            near: [0, 1, 2],
            far: [3, 4, 5],
        };
        for axis in 0..3 {
            let [least, largest] = reciprocals[axis];
            if least < 0.0 && largest > 0.0 {
                return None;
            }
            let (lower, upper) = (F::splat(origins[axis][0]), F::splat(origins[axis][1]));
            let (least, largest) = (F::splat(least), F::splat(largest));
            if reciprocals[axis][0] < 0.0 {
                (beam.near[axis], beam.far[axis]) = (axis + 3, axis);
                (beam.from[0][axis], beam.from[1][axis]) = (lower, upper);
                (beam.reciprocal[0][axis], beam.reciprocal[1][axis]) = (largest, least);
            } else {
                (beam.from[0][axis], beam.from[1][axis]) = (upper, lower);
                (beam.reciprocal[0][axis], beam.reciprocal[1][axis]) = (least, largest);
            }
        }
        Some(beam)
    }

    /// Mask of the children of a node whose boxes some segment of the group may meet below
    /// [`limit`].
    #[inline(always)]
    pub fn meets_children(&self, node: &Node, limit: f32) -> u32 {
        let (mut near, mut far) = (F::splat(0.0), F::splat(limit));
        let slack = F::splat(SLAB_SLACK);
        for axis in 0..3 {
            let into = F::load(&node.planes[self.near[axis]]) - self.from[0][axis];
            let out = F::load(&node.planes[self.far[axis]]) - self.from[1][axis];
            // Both ends of the interval of reciprocals are multiplied: the smaller product bounds
            // the entry, the larger the exit.
            let [small, large] = [self.reciprocal[0][axis], self.reciprocal[1][axis]];
            near = (into * small).min(into * large).max(near);
            far = ((out * small).max(out * large) * slack).min(far);
        }
        F::bits(near.le(far))
    }
}

/// Mask of the segments that meet the box of one child below [`limit`].
#[inline(always)]
pub(super) fn meet_child<F: Vector>(
    s: &Lines<F>,
    reciprocal: &[F; 3],
    limit: f32,
    node: &Node,
    slot: usize,
) -> u32 {
    let (mut near, mut far) = (F::splat(0.0), F::splat(limit));
    let slack = F::splat(SLAB_SLACK);
    for (axis, &r) in reciprocal.iter().enumerate() {
        let lower = (F::splat(node.planes[axis][slot]) - s.origin[axis]) * r;
        let upper = (F::splat(node.planes[axis + 3][slot]) - s.origin[axis]) * r;
        near = lower.min(upper).max(near);
        far = (lower.max(upper) * slack).min(far);
    }
    F::bits(near.le(far))
}
