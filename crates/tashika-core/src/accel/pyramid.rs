//! Pyramids of rays from one point, and a test that proves that they contain no surface.
//!
//! A pyramid with apex `a` is the set of points `p` with `n_k · (p − a) ≥ 0` for the inward normals
//! `n_k` of its sides. It misses a box of center `c` and half extents `h` if one of its sides
//! separates the two:
//!
//! ```text
//! n_k · (c − a) + |n_k| · h < −s (|c| + |h| + m) max(|n_k|, 1)
//! ```
//!
//! Here `s` bounds the rounding of coordinates and of normals, which are cross products of
//! single-precision rays, and `m` is the largest of the coordinates that `a` was computed from. The
//! boxes of trees are culled with this test. A pyramid misses a triangle if the test holds for its
//! corners, or if the plane through the apex and one edge of the triangle separates the two.
//!
//! # Guarantee
//! No ray of a pyramid that passes this test meets a surface. The converse does not hold: a pyramid
//! without surfaces may fail the test. Held to this by `gather::pyramid`, with random rays.

use super::bvh::Node;
use super::tracer::Tracer;
use super::trees::Tree;
use crate::math::simd::WIDTH;
use crate::math::{Affine3A, DVec3, Vec3};

/// `s`: the errors of unit directions, of their products and of coordinates are each below 2⁻²².
const ROUNDING: f64 = 1e-6;

/// Rays from an apex within four planes.
#[derive(Clone, Copy, Debug)]
pub struct Pyramid {
    apex: DVec3,
    /// Bound of the coordinates that the apex was computed from (m).
    magnitude: f64,
    /// Inward normals: first of two opposite sides, then of the other two.
    sides: [DVec3; 4],
}

impl Pyramid {
    /// Creates the pyramid around the direction `axis`.
    ///
    /// * `sides`: for each side, two unit directions in its plane, well separated. The first two
    ///   sides are opposite to each other.
    pub fn new(apex: Vec3, axis: Vec3, sides: [[Vec3; 2]; 4]) -> Self {
        let inward = |[a, b]: [Vec3; 2]| {
            let normal = a.as_dvec3().cross(b.as_dvec3());
            normal * normal.dot(axis.as_dvec3()).signum()
        };
        let apex = apex.as_dvec3();
        Self { apex, magnitude: apex.length(), sides: sides.map(inward) }
    }

    /// Transforms the pyramid into the space of an instance.
    fn in_space_of(&self, to_world: &Affine3A, to_object: &Affine3A) -> Self {
        let normals = to_world.matrix3.as_dmat3().transpose();
        let (linear, moved) = (to_object.matrix3.as_dmat3(), to_object.translation.as_dvec3());
        let columns = [linear.x_axis, linear.y_axis, linear.z_axis].map(|column| column.length());
        let magnitude = columns.iter().sum::<f64>() * self.magnitude + moved.length();
        let apex = linear * self.apex + moved;
        Self { apex, magnitude, sides: self.sides.map(|side| normals * side) }
    }

    /// Returns true if certainly no ray of the pyramid meets the box.
    fn misses_box(&self, lo: DVec3, hi: DVec3) -> bool {
        let (center, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
        let size = center.length() + half.length() + self.magnitude;
        self.sides.iter().any(|side| {
            let farthest = side.dot(center - self.apex) + side.abs().dot(half);
            farthest < -ROUNDING * size * side.length().max(1.0)
        })
    }

    /// Returns true if certainly no ray of the pyramid meets the triangle.
    fn misses_triangle(&self, corners: [DVec3; 3]) -> bool {
        let size = corners.iter().map(|p| p.length()).fold(self.magnitude, f64::max);
        let seen = corners.map(|p| p - self.apex);
        let is_outside = |side: &DVec3| {
            let farthest = seen.iter().map(|p| side.dot(*p)).fold(f64::NEG_INFINITY, f64::max);
            farthest < -ROUNDING * 3.0 * size * side.length().max(1.0)
        };
        let [a, b, c, d] = self.sides;
        let edges = [a.cross(c), a.cross(d), b.cross(c), b.cross(d)].map(|edge| {
            let unit = edge.normalize_or_zero();
            // An edge of the pyramid has the sign for which it lies inside the other sides.
            let inside: f64 = self.sides.iter().map(|side| side.dot(unit)).sum();
            unit * inside.signum()
        });
        let is_beside = |[p, q, other]: [DVec3; 3]| {
            let plane = p.cross(q);
            let inward = plane * plane.dot(other).signum();
            let nearest = edges.iter().map(|edge| inward.dot(*edge)).fold(f64::NEG_INFINITY, f64::max);
            nearest < -ROUNDING * 3.0 * size * (p.length() + q.length())
        };
        let [p, q, r] = seen;
        self.sides.iter().any(is_outside) || [[p, q, r], [q, r, p], [r, p, q]].into_iter().any(is_beside)
    }

    /// Returns true if for every leaf all rays certainly miss its box, or `is_missed` returns true.
    fn misses_leaves(&self, nodes: &[Node], is_missed: impl Fn(u32) -> bool) -> bool {
        let mut waiting = if nodes.is_empty() { vec![] } else { vec![0] };
        while let Some(number) = waiting.pop() {
            let node = &nodes[number as usize];
            for slot in 0..WIDTH {
                let plane = |axis: usize| f64::from(node.planes[axis][slot]);
                let lo = DVec3::new(plane(0), plane(1), plane(2));
                let hi = DVec3::new(plane(3), plane(4), plane(5));
                // Boxes of absent children are inverted.
                if lo.x > hi.x || self.misses_box(lo, hi) {
                    continue;
                }
                if node.is_inner(slot) {
                    waiting.push(node.first[slot]);
                } else if !is_missed(node.first[slot]) {
                    return false;
                }
            }
        }
        true
    }

    /// Returns true if certainly no ray of the pyramid meets a triangle of the tree.
    fn misses_tree(&self, tree: &Tree) -> bool {
        self.misses_leaves(&tree.nodes, |leaf| {
            let block = &tree.blocks[leaf as usize];
            let mut triangles = (0..WIDTH).map(|slot| block.triangle(slot).v);
            // Corners of absent triangles are NaN.
            triangles.all(|v| v[0].is_nan() || self.misses_triangle(v.map(|p| p.as_dvec3())))
        })
    }
}

impl Tracer {
    /// Returns true if certainly no ray of a pyramid meets a surface. Always false for scenes with
    /// motion.
    pub fn is_empty_within(&self, pyramid: &Pyramid) -> bool {
        let (trees, scene) = (self.trees(), self.scene());
        let misses_placed = |leaf: u32| {
            let placed = &trees.placed[leaf as usize];
            let instance = &scene.instances()[placed.instance as usize];
            let local = pyramid.in_space_of(&instance.to_world, &instance.to_object());
            local.misses_tree(&trees.shared[placed.tree as usize])
        };
        trees.moving.movers.is_empty()
            && pyramid.misses_tree(&trees.world)
            && pyramid.misses_leaves(&trees.top.nodes, misses_placed)
    }
}
