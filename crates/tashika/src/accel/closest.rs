//! The closest hit of one ray in one tree.

use super::bvh::{INNER, MAX_WAITING, Node, WIDTH};
use super::kernel::{Beam, barycentric};
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
    let mut beam = Beam::of_ray(o, d, ray.t_max, point_error);
    let mut best = None;
    let mut waiting = [(0u32, 0.0f32); MAX_WAITING];
    let mut top = 1;
    let mut entry = [0.0; WIDTH];
    while top > 0 {
        top -= 1;
        let (number, near) = waiting[top];
        if beam.is_beyond(near) {
            continue;
        }
        let node = &nodes[number as usize];
        let mut met = beam.meets_children(node, &mut entry);
        let base = top;
        while met != 0 {
            let slot = met.trailing_zeros() as usize;
            met &= met - 1;
            let first = node.first[slot];
            if node.count[slot] == INNER {
                // Sorted, so that the nearest is on top.
                let mut at = top;
                while at > base && waiting[at - 1].1 < entry[slot] {
                    waiting[at] = waiting[at - 1];
                    at -= 1;
                }
                waiting[at] = (first, entry[slot]);
                top += 1;
                continue;
            }
            for k in first..first + node.count[slot] {
                let t = &triangles[k as usize];
                if let Some(at) = meets(&ray, point_error, t)
                    && at < ray.t_max
                {
                    let b = barycentric(o, d, t);
                    if accept(t, b) {
                        ray.t_max = at;
                        beam.set_t_max(at);
                        best = Some(TreeHit { t: at, slot: k, barycentric: b });
                    }
                }
            }
        }
    }
    best
}
