//! Pyramids of rays from one point, and whether they certainly meet nothing.
//!
//! A pyramid is the set of places `p` with `n_k · (p − a) ≥ 0` for its apex `a` and the inward normals
//! `n_k` of its sides. A box of center `c` and half extents `h` is outside if one side separates them:
//!
//! ```text
//! n_k · (c − a) + |n_k| · h < −s (|c| + |h| + |a|)
//! ```
//!
//! with `s` for rounding: of the normals, which are products of rays in single precision, and of the
//! coordinates. The trees are walked through with this test. Triangles of a leaf are outside by the same
//! test of their corners, or if the plane of the apex and an edge separates them.
//!
//! # Guarantee
//! If a pyramid is said to be empty, no ray of it meets a surface. The opposite is not said of the
//! others. Held to this by `gather::pyramid`, by rays at random.

use super::bvh::Node;
use super::tracer::Tracer;
use super::trees::Tree;
use crate::math::simd::WIDTH;
use crate::math::{Affine3A, DVec3, Vec3};

/// `s`: errors of unit directions, of their products and of coordinates are each below 2⁻²².
const ROUNDING: f64 = 1e-6;

/// A pyramid of rays.
#[derive(Clone, Copy, Debug)]
pub struct Pyramid {
    apex: DVec3,
    /// Inward normals: of two sides opposite to each other, and of the two others.
    sides: [DVec3; 4],
}

impl Pyramid {
    /// The rays from `apex` that are, of each side, where the direction `axis` is.
    ///
    /// * `sides`: two unit directions in the plane of each side, far from each other; the first two
    ///   sides are opposite to each other.
    pub fn new(apex: Vec3, axis: Vec3, sides: [[Vec3; 2]; 4]) -> Self {
        let inward = |[a, b]: [Vec3; 2]| {
            let normal = a.as_dvec3().cross(b.as_dvec3());
            normal * normal.dot(axis.as_dvec3()).signum()
        };
        Self { apex: apex.as_dvec3(), sides: sides.map(inward) }
    }

    /// The same in the space of an instance.
    fn in_space_of(&self, to_world: &Affine3A, to_object: &Affine3A) -> Self {
        let normals = to_world.matrix3.as_dmat3().transpose();
        let apex = to_object.matrix3.as_dmat3() * self.apex + to_object.translation.as_dvec3();
        Self { apex, sides: self.sides.map(|side| normals * side) }
    }

    /// Whether a box is certainly outside.
    fn excludes_box(&self, lo: DVec3, hi: DVec3) -> bool {
        let (center, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
        let size = center.length() + half.length() + self.apex.length();
        self.sides.iter().any(|side| {
            let farthest = side.dot(center - self.apex) + side.abs().dot(half);
            farthest < -ROUNDING * size * side.length().max(1.0)
        })
    }

    /// Whether a triangle is certainly outside: of one of the sides, or because the plane of the apex
    /// and one of its edges is between it and the pyramid.
    fn excludes_triangle(&self, corners: [DVec3; 3]) -> bool {
        let size = corners.iter().map(|p| p.length()).fold(self.apex.length(), f64::max);
        let seen = corners.map(|p| p - self.apex);
        let is_outside = |side: &DVec3| {
            let farthest = seen.iter().map(|p| side.dot(*p)).fold(f64::NEG_INFINITY, f64::max);
            farthest < -ROUNDING * 3.0 * size * side.length().max(1.0)
        };
        let [a, b, c, d] = self.sides;
        let edges = [a.cross(c), a.cross(d), b.cross(c), b.cross(d)].map(|edge| {
            let unit = edge.normalize_or_zero();
            // Of two directions, the one that is inside of the other sides.
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

    /// Whether all leaves below the root of a tree are outside, or `is_clear`.
    fn meets_none(&self, nodes: &[Node], is_clear: impl Fn(u32) -> bool) -> bool {
        let mut waiting = if nodes.is_empty() { vec![] } else { vec![0] };
        while let Some(number) = waiting.pop() {
            let node = &nodes[number as usize];
            for slot in 0..WIDTH {
                let plane = |axis: usize| f64::from(node.planes[axis][slot]);
                let lo = DVec3::new(plane(0), plane(1), plane(2));
                let hi = DVec3::new(plane(3), plane(4), plane(5));
                // Absent children are inverted.
                if lo.x > hi.x || self.excludes_box(lo, hi) {
                    continue;
                }
                if node.is_inner(slot) {
                    waiting.push(node.first[slot]);
                } else if !is_clear(node.first[slot]) {
                    return false;
                }
            }
        }
        true
    }

    /// Whether all triangles of a tree are outside.
    fn misses(&self, tree: &Tree) -> bool {
        self.meets_none(&tree.nodes, |leaf| {
            let block = &tree.blocks[leaf as usize];
            let mut triangles = (0..WIDTH).map(|slot| block.triangle(slot).v);
            // Absent triangles are not numbers.
            triangles.all(|v| v[0].is_nan() || self.excludes_triangle(v.map(|p| p.as_dvec3())))
        })
    }
}

impl Tracer {
    /// Whether no ray of a pyramid meets a surface, for certain; never where something moves.
    pub fn is_empty_within(&self, pyramid: &Pyramid) -> bool {
        let (trees, scene) = (self.trees(), self.scene());
        let misses_placed = |leaf: u32| {
            let placed = &trees.placed[leaf as usize];
            let instance = &scene.instances()[placed.instance as usize];
            let local = pyramid.in_space_of(&instance.to_world, &instance.to_object());
            local.misses(&trees.shared[placed.tree as usize])
        };
        trees.moving.movers.is_empty()
            && pyramid.misses(&trees.world)
            && pyramid.meets_none(&trees.top.nodes, misses_placed)
    }
}
