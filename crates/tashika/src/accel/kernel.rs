//! Visibility of up to [`LANES`] segments at once: one tree, one instruction stream, a mask of lanes.
//!
//! The code is written for `N` lanes as loops over arrays, which the compiler turns into vector instructions; it is
//! compiled for several instruction sets and the best is chosen at run time (`multiversion`). With one lane it is its own
//! scalar twin: `accel::tests` compare the two on random segments, bit by bit.

use glam::Vec3;
use multiversion::multiversion;

use super::bvh::{INNER, MAX_DEPTH, Node};
use super::triangle::{Planes, Triangle, cross, dot, flag, sub};
use crate::math::gamma;

/// Segments that travel together: one AVX-512 register, two of AVX2, four of SSE or NEON.
pub(super) const LANES: usize = 16;

/// Factor on the far end of a slab: two bounds of three rounded operations each (Ize 2013), and the rounding of the direction.
const SLAB_SLACK: f32 = 1.0 + 2.0 * gamma(5);

/// Directions closer to zero than this are moved away from it, so that no slab is `0 · ∞`.
const SMALLEST_DIRECTION: f32 = 1e-30;

/// Segments of one fan, in the space of one tree.
#[derive(Clone, Copy)]
pub(super) struct Bundle<const N: usize> {
    /// Where all segments start, if `SHARED`.
    pub apex: [f32; 3],
    /// Where each segment starts, if not `SHARED`.
    pub origin: [[f32; N]; 3],
    /// Where each segment ends; not used if segments go to infinity.
    pub target: [[f32; N]; 3],
    /// From start to end, or the direction to infinity.
    pub direction: [[f32; N]; 3],
    /// Reciprocal of `direction`, kept finite.
    pub reciprocal: [[f32; N]; 3],
    /// Largest parameter: 1, or infinity.
    pub t_max: f32,
    /// Error of each component of the ends (m), from transforming them into this space.
    pub point_error: f32,
    /// Lanes that hold a segment that is not known to be blocked.
    pub active: u32,
}

impl<const N: usize> Bundle<N> {
    /// Segments from `apex` to `targets`; at most `N`.
    pub fn from_point(apex: Vec3, targets: &[Vec3], point_error: f32) -> Self {
        let mut b = Self::empty(targets.len(), 1.0, point_error);
        b.apex = apex.to_array();
        for (i, t) in targets.iter().enumerate() {
            b.set(i, apex, *t, *t - apex);
        }
        b
    }

    /// Segments from `targets` along `direction` to infinity; at most `N`.
    pub fn to_infinity(direction: Vec3, targets: &[Vec3], point_error: f32) -> Self {
        let mut b = Self::empty(targets.len(), f32::INFINITY, point_error);
        for (i, t) in targets.iter().enumerate() {
            b.set(i, *t, *t, direction);
        }
        b
    }

    fn empty(count: usize, t_max: f32, point_error: f32) -> Self {
        debug_assert!(count <= N && N <= 32);
        Self {
            apex: [0.0; 3],
            origin: [[0.0; N]; 3],
            target: [[0.0; N]; 3],
            direction: [[0.0; N]; 3],
            reciprocal: [[0.0; N]; 3],
            t_max,
            point_error,
            active: ((1u64 << count) - 1) as u32,
        }
    }

    fn set(&mut self, lane: usize, origin: Vec3, target: Vec3, direction: Vec3) {
        for axis in 0..3 {
            let d = direction[axis];
            self.origin[axis][lane] = origin[axis];
            self.target[axis][lane] = target[axis];
            self.direction[axis][lane] = d;
            self.reciprocal[axis][lane] = reciprocal(d);
        }
    }

    #[inline(always)]
    fn start<const SHARED: bool>(&self, lane: usize) -> [f32; 3] {
        if SHARED { self.apex } else { [self.origin[0][lane], self.origin[1][lane], self.origin[2][lane]] }
    }
}

/// `1 / d`, finite and with the sign of `d`.
#[inline(always)]
pub(super) fn reciprocal(d: f32) -> f32 {
    1.0 / if d.abs() < SMALLEST_DIRECTION { SMALLEST_DIRECTION.copysign(d) } else { d }
}

/// Range of parameters in which a line is inside a slab box: `(nearest, farthest)`, not yet clipped.
#[inline(always)]
pub(super) fn slabs(lo: Vec3, hi: Vec3, o: [f32; 3], r: [f32; 3]) -> (f32, f32) {
    let min = |a: f32, b: f32| if a < b { a } else { b };
    let max = |a: f32, b: f32| if a > b { a } else { b };
    let (x0, x1) = ((lo.x - o[0]) * r[0], (hi.x - o[0]) * r[0]);
    let (y0, y1) = ((lo.y - o[1]) * r[1], (hi.y - o[1]) * r[1]);
    let (z0, z1) = ((lo.z - o[2]) * r[2], (hi.z - o[2]) * r[2]);
    let near = max(max(min(x0, x1), min(y0, y1)), min(z0, z1));
    let far = min(min(max(x0, x1), max(y0, y1)), max(z0, z1));
    (near, far * SLAB_SLACK)
}

/// Lanes whose segment meets a box.
#[inline(always)]
fn meets_box<const N: usize, const SHARED: bool>(b: &Bundle<N>, lo: Vec3, hi: Vec3) -> u32 {
    let mut hit = [0u32; N];
    let limit = b.t_max * SLAB_SLACK;
    for i in 0..N {
        let r = [b.reciprocal[0][i], b.reciprocal[1][i], b.reciprocal[2][i]];
        let (near, far) = slabs(lo, hi, b.start::<SHARED>(i), r);
        hit[i] = u32::from(near <= far) & u32::from(far >= 0.0) & u32::from(near <= limit);
    }
    mask(&hit)
}

/// Lanes whose segment meets a box, whatever kind of bundle it is.
pub(super) fn meets_box_any<const N: usize>(b: &Bundle<N>, lo: Vec3, hi: Vec3) -> u32 {
    meets_box::<N, false>(b, lo, hi)
}

#[inline(always)]
fn mask<const N: usize>(hit: &[u32; N]) -> u32 {
    let mut m = 0;
    for (i, h) in hit.iter().enumerate() {
        m |= h << i;
    }
    m
}

/// Lanes whose segment a triangle blocks, by the two rules of [`accel`](crate::accel).
#[inline(always)]
fn meets_triangle<const N: usize, const SHARED: bool, const BOUNDED: bool>(b: &Bundle<N>, t: &Triangle) -> u32 {
    let planes = Planes::new(t);
    let mut hit = [0u32; N];
    if SHARED {
        // No lane can be blocked if the common end is not certainly off the plane.
        let a = sub(t.v[0], b.apex);
        if planes.volume(a).abs() <= planes.error(a, b.point_error) {
            return 0;
        }
    }
    for i in 0..N {
        let o = b.start::<SHARED>(i);
        let (a, bb, c) = (sub(t.v[0], o), sub(t.v[1], o), sub(t.v[2], o));
        let d = [b.direction[0][i], b.direction[1][i], b.direction[2][i]];
        let start = planes.volume(a);
        let start_error = planes.error(a, b.point_error);
        // Turned so that the start is on the positive side.
        let sign = 1.0f32.copysign(start);
        let (u, v, w) =
            (sign * dot(cross(bb, c), d), sign * dot(cross(c, a), d), sign * dot(cross(a, bb), d));
        let (end, end_error) = if BOUNDED {
            let e = sub(t.v[0], [b.target[0][i], b.target[1][i], b.target[2][i]]);
            (-sign * planes.volume(e), planes.error(e, b.point_error))
        } else {
            (sign * planes.volume(d), planes.error(d, 0.0))
        };
        hit[i] = u32::from(u >= 0.0)
            & u32::from(v >= 0.0)
            & u32::from(w >= 0.0)
            & u32::from(sign * start > start_error)
            & u32::from(end > end_error);
    }
    mask(&hit)
}

/// Barycentric weights of the point at which the line of one lane passes a triangle.
pub(super) fn barycentric(origin: [f32; 3], direction: [f32; 3], t: &Triangle) -> [f32; 3] {
    let (a, b, c) = (sub(t.v[0], origin), sub(t.v[1], origin), sub(t.v[2], origin));
    let [u, v, w] = super::triangle::edges(a, b, c, direction);
    let sum = u + v + w;
    if sum == 0.0 || !sum.is_finite() { [1.0 / 3.0; 3] } else { [u / sum, v / sum, w / sum] }
}

/// What is asked where light may pass: `(instance of the triangle, triangle, barycentric weights)` to opacity.
pub(super) type Opacity<'a> = &'a dyn Fn(u32, u32, [f32; 3]) -> f32;

/// Visits every triangle that may block a lane, in the tree's order.
///
/// `visible[i]` starts at what has passed so far and is multiplied by what passes here; lanes at zero
/// are no longer active.
#[inline(always)]
fn traverse<const N: usize, const SHARED: bool, const BOUNDED: bool>(
    nodes: &[Node],
    triangles: &[Triangle],
    bundle: &mut Bundle<N>,
    visible: &mut [f32; N],
    opacity: Opacity<'_>,
) {
    if nodes.is_empty() || bundle.active == 0 {
        return;
    }
    let mut stack = [(0u32, 0u32); MAX_DEPTH];
    stack[0] = (0, bundle.active);
    let mut top = 1;
    while top > 0 {
        top -= 1;
        let (number, lanes) = stack[top];
        let lanes = lanes & bundle.active;
        if lanes == 0 {
            continue;
        }
        let node = &nodes[number as usize];
        let met = [0, 1].map(|slot| lanes & meets_box::<N, SHARED>(bundle, node.lo[slot], node.hi[slot]));
        for slot in [0, 1] {
            if met[slot] == 0 || node.count[slot] == INNER {
                continue;
            }
            let first = node.first[slot] as usize;
            for t in &triangles[first..first + node.count[slot] as usize] {
                let mut hit = met[slot] & bundle.active & meets_triangle::<N, SHARED, BOUNDED>(bundle, t);
                if hit == 0 {
                    continue;
                }
                if t.flags & flag::TRANSPARENT == 0 {
                    bundle.active &= !hit;
                    while hit != 0 {
                        visible[hit.trailing_zeros() as usize] = 0.0;
                        hit &= hit - 1;
                    }
                } else {
                    while hit != 0 {
                        let i = hit.trailing_zeros() as usize;
                        hit &= hit - 1;
                        let d = [bundle.direction[0][i], bundle.direction[1][i], bundle.direction[2][i]];
                        let b = barycentric(bundle.start::<SHARED>(i), d, t);
                        visible[i] *= 1.0 - opacity(t.instance, t.index, b);
                        if visible[i] <= 0.0 {
                            bundle.active &= !(1 << i);
                        }
                    }
                }
            }
        }
        for slot in [1, 0] {
            if met[slot] != 0 && node.count[slot] == INNER {
                stack[top] = (node.first[slot], met[slot]);
                top += 1;
            }
        }
    }
}

/// Fans that meet in a point.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "x86_64+sse4.2"))]
pub(super) fn occlude_from_point(
    nodes: &[Node],
    triangles: &[Triangle],
    bundle: &mut Bundle<LANES>,
    visible: &mut [f32; LANES],
    opacity: Opacity<'_>,
) {
    traverse::<LANES, true, true>(nodes, triangles, bundle, visible, opacity);
}

/// Fans of parallel segments to infinity.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "x86_64+sse4.2"))]
pub(super) fn occlude_to_infinity(
    nodes: &[Node],
    triangles: &[Triangle],
    bundle: &mut Bundle<LANES>,
    visible: &mut [f32; LANES],
    opacity: Opacity<'_>,
) {
    traverse::<LANES, false, false>(nodes, triangles, bundle, visible, opacity);
}

/// A single segment between points.
pub(super) fn occlude_one(
    nodes: &[Node],
    triangles: &[Triangle],
    bundle: &mut Bundle<1>,
    visible: &mut [f32; 1],
    opacity: Opacity<'_>,
) {
    traverse::<1, true, true>(nodes, triangles, bundle, visible, opacity);
}

/// A single segment to infinity.
pub(super) fn occlude_one_to_infinity(
    nodes: &[Node],
    triangles: &[Triangle],
    bundle: &mut Bundle<1>,
    visible: &mut [f32; 1],
    opacity: Opacity<'_>,
) {
    traverse::<1, false, false>(nodes, triangles, bundle, visible, opacity);
}
