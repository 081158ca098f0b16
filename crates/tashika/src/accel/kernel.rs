//! Visibility of up to [`LANES`] segments at once: one walk through the tree for all of them.
//!
//! Inner nodes are judged for the whole group: intervals around the segments' origins and reciprocal directions bound
//! the parameters at which any of them can be inside a box, for the eight children of a node at once. What is left, and
//! triangles, is judged lane by lane. Segments whose directions differ in sign have no useful intervals; they walk alone.
//!
//! The intervals are made of the same roundings as the lanes' own, which are monotone: a group enters every box that one of its
//! lanes would enter alone, and a lane that meets the box of a leaf meets those of all its ancestors. So the triangles that are
//! tested against a lane, and their order, do not depend on its group (`accel::tests::grouping_does_not_change_a_bit`).
//!
//! The code is written as loops over arrays, which the compiler turns into vector instructions; it is compiled for several
//! instruction sets and the best is chosen at run time (`multiversion`).

use glam::Vec3;
use multiversion::multiversion;

use super::bvh::{INNER, MAX_WAITING, Node, WIDTH};
use super::triangle::{Planes, Triangle, cross, dot, flag, sub};
use crate::math::gamma;

/// Segments that travel together: one AVX-512 register, two of AVX2, four of SSE or NEON.
pub(super) const LANES: usize = 16;

/// Factor on the far end of a slab: two bounds of three rounded operations each (Ize 2013), and the rounding of the direction.
const SLAB_SLACK: f32 = 1.0 + 2.0 * gamma(5);

/// How far boxes reach for segments whose ends are wrong: the start's error, and twice that for the difference of the ends.
const REACH_PER_ERROR: f32 = 3.0;

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
    /// Error of each component of a segment's ends (m), from transforming them into this space. A lane's own: that of its
    /// neighbours must not enter its answer.
    pub point_error: [f32; N],
    /// Lanes that hold a segment that is not known to be blocked.
    pub active: u32,
}

impl<const N: usize> Bundle<N> {
    /// Segments from `apex` to `targets`; at most `N`.
    pub fn from_point(apex: Vec3, targets: &[Vec3], point_error: [f32; N]) -> Self {
        let mut b = Self::empty(targets.len(), 1.0, point_error);
        b.apex = apex.to_array();
        for (i, t) in targets.iter().enumerate() {
            b.set(i, apex, *t, *t - apex);
        }
        b
    }

    /// Segments from `targets` along `direction` to infinity; at most `N`.
    pub fn to_infinity(direction: Vec3, targets: &[Vec3], point_error: [f32; N]) -> Self {
        let mut b = Self::empty(targets.len(), f32::INFINITY, point_error);
        for (i, t) in targets.iter().enumerate() {
            b.set(i, *t, *t, direction);
        }
        b
    }

    fn empty(count: usize, t_max: f32, point_error: [f32; N]) -> Self {
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

    /// One lane by itself.
    #[inline(always)]
    fn lane(&self, i: usize) -> Bundle<1> {
        let one = |v: &[[f32; N]; 3]| [[v[0][i]], [v[1][i]], [v[2][i]]];
        Bundle {
            apex: self.apex,
            origin: one(&self.origin),
            target: one(&self.target),
            direction: one(&self.direction),
            reciprocal: one(&self.reciprocal),
            t_max: self.t_max,
            point_error: [self.point_error[i]],
            active: 1,
        }
    }

    /// Lanes that may meet children of a node: all or none, judged for the group.
    pub fn beams(&self) -> Vec<(Beam, u32)> {
        match Beam::of_bundle(self) {
            Some(beam) => vec![(beam, self.active)],
            None => (0..N)
                .filter(|i| self.active & 1 << i != 0)
                .filter_map(|i| Some((Beam::of_bundle(&self.lane(i))?, 1 << i)))
                .collect(),
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

#[inline(always)]
fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Intervals around the origins and reciprocal directions of segments whose directions have the same signs.
#[derive(Clone, Copy)]
pub(super) struct Beam {
    /// The end of the origins' interval that bounds the parameter of the near plane from below, and of the far plane from above.
    origin: [[f32; 2]; 3],
    /// Smallest and largest magnitude of the reciprocal direction, with its sign.
    reciprocal: [[f32; 2]; 3],
    /// Whether the near plane is the upper one.
    negative: [bool; 3],
    /// Largest parameter, with slack.
    limit: f32,
}

impl Beam {
    /// The beam of a single ray, whose points are wrong by at most `error` (m) in each component.
    pub fn of_ray(origin: [f32; 3], direction: [f32; 3], t_max: f32, error: f32) -> Self {
        let r = direction.map(reciprocal);
        let reach = REACH_PER_ERROR * error;
        let ends = |(o, r): (f32, f32)| if r < 0.0 { [o - reach, o + reach] } else { [o + reach, o - reach] };
        Self {
            origin: [0, 1, 2].map(|axis| ends((origin[axis], r[axis]))),
            reciprocal: r.map(|r| [r; 2]),
            negative: r.map(|r| r < 0.0),
            limit: t_max * SLAB_SLACK,
        }
    }

    /// The same beam up to a smaller parameter.
    pub fn set_t_max(&mut self, t_max: f32) {
        self.limit = t_max * SLAB_SLACK;
    }

    /// Whether a parameter of entry lies beyond the end.
    pub fn is_beyond(&self, entry: f32) -> bool {
        entry > self.limit
    }

    /// The beam around the active lanes of a bundle; `None` if their directions differ in sign.
    fn of_bundle<const N: usize>(b: &Bundle<N>) -> Option<Self> {
        let mut beam = Self::of_ray([0.0; 3], [1.0; 3], b.t_max, 0.0);
        let reach = REACH_PER_ERROR * b.point_error.into_iter().fold(0.0, f32::max);
        for axis in 0..3 {
            let mut origin = [f32::INFINITY, f32::NEG_INFINITY];
            let mut r = [f32::INFINITY, f32::NEG_INFINITY];
            for i in (0..N).filter(|i| b.active & 1 << i != 0) {
                let (o, k) = (b.origin[axis][i], b.reciprocal[axis][i]);
                origin = [min(o, origin[0]), max(o, origin[1])];
                r = [min(k, r[0]), max(k, r[1])];
            }
            if r[0] < 0.0 && r[1] > 0.0 {
                return None;
            }
            beam.negative[axis] = r[0] < 0.0;
            let origin = [origin[0] - reach, origin[1] + reach];
            // Magnitudes and ends, such that slot 0 makes the entry early and slot 1 the exit late.
            beam.origin[axis] = if beam.negative[axis] { origin } else { [origin[1], origin[0]] };
            beam.reciprocal[axis] = if beam.negative[axis] { [r[1], r[0]] } else { r };
        }
        Some(beam)
    }

    /// Children of a node that some segment may meet, as a mask; and the parameters at which it may enter them.
    #[inline(always)]
    pub fn meets_children(&self, node: &Node, entry: &mut [f32; WIDTH]) -> u32 {
        let mut near = [0.0f32; WIDTH];
        let mut far = [self.limit; WIDTH];
        for axis in 0..3 {
            let (lower, upper) = if self.negative[axis] {
                (&node.hi[axis], &node.lo[axis])
            } else {
                (&node.lo[axis], &node.hi[axis])
            };
            let ([o_in, o_out], [r_small, r_large]) = (self.origin[axis], self.reciprocal[axis]);
            for i in 0..WIDTH {
                let (into, out) = (lower[i] - o_in, upper[i] - o_out);
                // A product with either end of the interval; the smaller is early, the larger late.
                near[i] = max(min(into * r_small, into * r_large), near[i]);
                far[i] = min(max(out * r_small, out * r_large) * SLAB_SLACK, far[i]);
            }
        }
        let mut met = 0;
        for i in 0..WIDTH {
            entry[i] = near[i];
            met |= lane_if(near[i] <= far[i], i);
        }
        met
    }
}

/// Lanes whose segment meets one child's box; the same arithmetic as [`Beam::meets_children`] on a beam of one.
#[inline(always)]
pub(super) fn meets_box<const N: usize, const SHARED: bool>(b: &Bundle<N>, node: &Node, slot: usize) -> u32 {
    let mut met = 0;
    let limit = b.t_max * SLAB_SLACK;
    for i in 0..N {
        let reach = REACH_PER_ERROR * b.point_error[i];
        let o = b.start::<SHARED>(i);
        let (mut near, mut far) = (0.0f32, limit);
        for (axis, o) in o.into_iter().enumerate() {
            let r = b.reciprocal[axis][i];
            let lo = (node.lo[axis][slot] - (o + reach)) * r;
            let hi = (node.hi[axis][slot] - (o - reach)) * r;
            near = max(min(lo, hi), near);
            far = min(max(lo, hi) * SLAB_SLACK, far);
        }
        met |= lane_if(near <= far, i);
    }
    met
}

/// The bit of a lane, or nothing: a selection of constants, which vectorises where a shift by the lane does not.
#[inline(always)]
fn lane_if(yes: bool, lane: usize) -> u32 {
    if yes { 1 << lane } else { 0 }
}

/// Lanes whose segment a triangle blocks, by the two rules of [`accel`](crate::accel).
#[inline(always)]
fn meets_triangle<const N: usize, const SHARED: bool, const BOUNDED: bool>(
    b: &Bundle<N>,
    t: &Triangle,
) -> u32 {
    let planes = Planes::new(t);
    let mut hit = 0;
    if SHARED {
        // No lane can be blocked if the common end is not certainly off the plane.
        let a = sub(t.v[0], b.apex);
        if planes.volume(a).abs() <= planes.error(a, 0.0) {
            return 0;
        }
    }
    for i in 0..N {
        let o = b.start::<SHARED>(i);
        let (a, bb, c) = (sub(t.v[0], o), sub(t.v[1], o), sub(t.v[2], o));
        let d = [b.direction[0][i], b.direction[1][i], b.direction[2][i]];
        let start = planes.volume(a);
        let start_error = planes.error(a, b.point_error[i]);
        // Turned so that the start is on the positive side.
        let sign = 1.0f32.copysign(start);
        let (u, v, w) =
            (sign * dot(cross(bb, c), d), sign * dot(cross(c, a), d), sign * dot(cross(a, bb), d));
        let (end, end_error) = if BOUNDED {
            let e = sub(t.v[0], [b.target[0][i], b.target[1][i], b.target[2][i]]);
            (-sign * planes.volume(e), planes.error(e, b.point_error[i]))
        } else {
            (sign * planes.volume(d), planes.error(d, 0.0))
        };
        let inside = (u >= 0.0) & (v >= 0.0) & (w >= 0.0);
        hit |= lane_if(inside & (sign * start > start_error) & (end > end_error), i);
    }
    hit
}

/// Barycentric weights of the point at which the line of one lane passes a triangle.
pub(super) fn barycentric(origin: [f32; 3], direction: [f32; 3], t: &Triangle) -> [f32; 3] {
    let (a, b, c) = (sub(t.v[0], origin), sub(t.v[1], origin), sub(t.v[2], origin));
    let [u, v, w] = super::triangle::edges(a, b, c, direction);
    let sum = u + v + w;
    if sum == 0.0 || !sum.is_finite() { [1.0 / 3.0; 3] } else { [u / sum, v / sum, w / sum] }
}

/// What is asked where light may pass: `(instance of the triangle, triangle, barycentric weights, direction)` to the share that is
/// stopped.
pub(super) type Opacity<'a> = &'a dyn Fn(u32, u32, [f32; 3], [f32; 3]) -> f32;

/// Visits every triangle that may block a lane, in the tree's order.
///
/// `visible[i]` starts at what has passed so far and is multiplied by what passes here; lanes at zero
/// are no longer active.
#[inline(always)]
fn traverse<const N: usize, const SHARED: bool, const BOUNDED: bool>(
    nodes: &[Node],
    triangles: &[Triangle],
    bundle: &mut Bundle<N>,
    beam: &Beam,
    visible: &mut [f32; N],
    opacity: Opacity<'_>,
) {
    if nodes.is_empty() || bundle.active == 0 {
        return;
    }
    let mut waiting = [0u32; MAX_WAITING];
    let mut top = 1;
    let mut entry = [0.0; WIDTH];
    while top > 0 && bundle.active != 0 {
        top -= 1;
        let node = &nodes[waiting[top] as usize];
        let met = beam.meets_children(node, &mut entry);
        let mut inner = 0u32;
        let mut rest = met;
        while rest != 0 {
            let slot = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            // A wide beam meets what no lane does: near silhouettes the targets of a fan lie far apart.
            let lanes = bundle.active & meets_box::<N, SHARED>(bundle, node, slot);
            if lanes == 0 {
                continue;
            }
            if node.count[slot] == INNER {
                inner |= 1 << slot;
                continue;
            }
            let first = node.first[slot] as usize;
            for t in &triangles[first..first + node.count[slot] as usize] {
                let hit = lanes & bundle.active & meets_triangle::<N, SHARED, BOUNDED>(bundle, t);
                if hit != 0 {
                    block::<N, SHARED>(bundle, t, hit, visible, opacity);
                }
            }
        }
        // The first child is on top, so that leaves are met in the same order by every group.
        while inner != 0 {
            let slot = WIDTH - 1 - (inner << (u32::BITS - WIDTH as u32)).leading_zeros() as usize;
            inner &= !(1 << slot);
            waiting[top] = node.first[slot];
            top += 1;
        }
    }
}

/// Takes in that a triangle is in the way of the lanes `hit`.
#[inline(always)]
fn block<const N: usize, const SHARED: bool>(
    bundle: &mut Bundle<N>,
    t: &Triangle,
    mut hit: u32,
    visible: &mut [f32; N],
    opacity: Opacity<'_>,
) {
    while hit != 0 {
        let i = hit.trailing_zeros() as usize;
        hit &= hit - 1;
        let stopped = if t.flags & flag::TRANSPARENT == 0 {
            1.0
        } else {
            let d = [bundle.direction[0][i], bundle.direction[1][i], bundle.direction[2][i]];
            opacity(t.instance, t.index, barycentric(bundle.start::<SHARED>(i), d, t), d)
        };
        visible[i] *= 1.0 - stopped;
        if visible[i] <= 0.0 {
            bundle.active &= !(1 << i);
        }
    }
}

/// Everything that walks through a tree together.
pub(super) struct Walk<'a, const N: usize> {
    pub nodes: &'a [Node],
    pub triangles: &'a [Triangle],
    pub bundle: &'a mut Bundle<N>,
    pub visible: &'a mut [f32; N],
    pub opacity: Opacity<'a>,
}

impl<const N: usize> Walk<'_, N> {
    /// Walks together if the directions allow it; otherwise does nothing and says so.
    #[inline(always)]
    fn together<const SHARED: bool, const BOUNDED: bool>(&mut self) -> bool {
        let Some(beam) = Beam::of_bundle(self.bundle) else { return false };
        traverse::<N, SHARED, BOUNDED>(
            self.nodes,
            self.triangles,
            self.bundle,
            &beam,
            self.visible,
            self.opacity,
        );
        true
    }

    /// One lane after the other.
    #[inline(always)]
    fn alone<const SHARED: bool, const BOUNDED: bool>(&mut self) {
        let mut rest = self.bundle.active;
        while rest != 0 {
            let i = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let mut lane = self.bundle.lane(i);
            let mut visible = [self.visible[i]];
            let (origin, direction) = (lane.origin.map(|v| v[0]), lane.direction.map(|v| v[0]));
            let beam = Beam::of_ray(origin, direction, lane.t_max, lane.point_error[0]);
            traverse::<1, SHARED, BOUNDED>(
                self.nodes,
                self.triangles,
                &mut lane,
                &beam,
                &mut visible,
                self.opacity,
            );
            self.visible[i] = visible[0];
            if lane.active == 0 {
                self.bundle.active &= !(1 << i);
            }
        }
    }
}

/// Fans that meet in a point.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma",
    "x86_64+avx2+fma",
    "x86_64+sse4.2"
))]
pub(super) fn walk_from_point(mut walk: Walk<'_, LANES>) {
    if !walk.together::<true, true>() {
        walk.alone::<true, true>();
    }
}

/// Fans of parallel segments to infinity.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma",
    "x86_64+avx2+fma",
    "x86_64+sse4.2"
))]
pub(super) fn walk_to_infinity(mut walk: Walk<'_, LANES>) {
    if !walk.together::<false, false>() {
        walk.alone::<false, false>();
    }
}

/// A single segment between points.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma",
    "x86_64+avx2+fma",
    "x86_64+sse4.2"
))]
pub(super) fn walk_one_from_point(mut walk: Walk<'_, 1>) {
    walk.alone::<true, true>();
}

/// A single segment to infinity.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma",
    "x86_64+avx2+fma",
    "x86_64+sse4.2"
))]
pub(super) fn walk_one_to_infinity(mut walk: Walk<'_, 1>) {
    walk.alone::<false, false>();
}
