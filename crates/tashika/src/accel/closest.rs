//! The closest hit of one ray in one tree.

use super::bvh::{INNER, MAX_DEPTH, Node};
use super::kernel::{barycentric, reciprocal, slabs};
use super::triangle::{Planes, Triangle, cross, dot, sub};
use crate::math::Ray;

/// A hit in one tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct TreeHit {
    /// Ray parameter.
    pub t: f32,
    /// Position in the tree's list of triangles.
    pub slot: u32,
    /// Barycentric weights of the corners, summing to 1.
    pub barycentric: [f32; 3],
}

/// Parameter at which a ray meets a triangle, by the same rules as for segments: the origin is certainly off the
/// plane, the direction certainly towards it, and the line passes inside.
#[inline(always)]
fn meets(ray: &Ray, point_error: f32, t: &Triangle) -> Option<f32> {
    let planes = Planes::new(t);
    let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
    let a = sub(t.v[0], o);
    let start = planes.volume(a);
    let slope = planes.volume(d);
    let sign = 1.0f32.copysign(start);
    if sign * start <= planes.error(a, point_error) || sign * slope <= planes.error(d, 0.0) {
        return None;
    }
    let (b, c) = (sub(t.v[1], o), sub(t.v[2], o));
    let inside = sign * dot(cross(b, c), d) >= 0.0
        && sign * dot(cross(c, a), d) >= 0.0
        && sign * dot(cross(a, b), d) >= 0.0;
    inside.then(|| start / slope)
}

/// The hit with the smallest parameter below `ray.t_max` that `accept`s (which is asked with the position in the list of
/// triangles and the barycentric weights).
pub(super) fn closest_hit(
    nodes: &[Node],
    triangles: &[Triangle],
    mut ray: Ray,
    point_error: f32,
    mut accept: impl FnMut(&Triangle, [f32; 3]) -> bool,
) -> Option<TreeHit> {
    if nodes.is_empty() {
        return None;
    }
    let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
    let r = d.map(reciprocal);
    let mut best = None;
    let mut stack = [(0u32, 0.0f32); MAX_DEPTH];
    let mut top = 1;
    while top > 0 {
        top -= 1;
        let (number, near) = stack[top];
        if near > ray.t_max {
            continue;
        }
        let node = &nodes[number as usize];
        let mut inner = [(0u32, f32::INFINITY); 2];
        for slot in [0, 1] {
            let (near, far) = slabs(node.lo[slot], node.hi[slot], o, r);
            // The slack on the far end covers the far end only; the near end is compared with a hit.
            if near > far || far < 0.0 || near > ray.t_max * 1.000_001 {
                continue;
            }
            if node.count[slot] == INNER {
                inner[slot] = (node.first[slot], near * 0.999_999);
                continue;
            }
            let first = node.first[slot];
            for k in first..first + node.count[slot] {
                let t = &triangles[k as usize];
                if let Some(at) = meets(&ray, point_error, t)
                    && at < ray.t_max
                {
                    let b = barycentric(o, d, t);
                    if accept(t, b) {
                        ray.t_max = at;
                        best = Some(TreeHit { t: at, slot: k, barycentric: b });
                    }
                }
            }
        }
        // The nearer child is popped first.
        let (nearer, farther) = if inner[0].1 <= inner[1].1 { (inner[0], inner[1]) } else { (inner[1], inner[0]) };
        for child in [farther, nearer] {
            if child.1 < f32::INFINITY {
                stack[top] = child;
                top += 1;
            }
        }
    }
    best
}
