//! The triangle test, written once: eight triangles against a segment, or a triangle against
//! sixteen segments.

use glam::Vec3;

use crate::math::gamma;
use crate::math::simd::{F32x8, Vector, WIDTH, each};

/// Bits of [`Triangle::flags`].
pub(super) mod flag {
    /// Light may pass along segments: the material has to be asked.
    pub const TRANSPARENT: u32 = 1;
    /// Rays may pass as if nothing were there: the material has to be asked.
    pub const HOLES: u32 = 2;
}

/// A triangle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Triangle {
    /// Corners (m).
    pub v: [Vec3; 3],
    /// Instance it belongs to; not used inside instanced trees.
    pub instance: u32,
    /// Its number in the mesh.
    pub index: u32,
    /// See [`flag`].
    pub flags: u32,
}

/// The triangles of a leaf. Places beyond its count have no area, so that nothing meets them.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Block {
    /// By corner and axis (m).
    v: [[[f32; WIDTH]; 3]; 3],
    instance: [u32; WIDTH],
    index: [u32; WIDTH],
    flags: [u32; WIDTH],
}

/// Several numbers for each axis.
pub(super) type Vectors3<F> = [F; 3];

impl Block {
    /// Of at most [`WIDTH`] triangles.
    pub fn new(triangles: impl ExactSizeIterator<Item = Triangle>) -> Self {
        assert!(triangles.len() <= WIDTH, "more triangles than a leaf holds");
        let mut block =
            Self { v: [[[0.0; WIDTH]; 3]; 3], instance: [0; WIDTH], index: [0; WIDTH], flags: [0; WIDTH] };
        for (slot, t) in triangles.enumerate() {
            for (corner, v) in t.v.iter().enumerate() {
                for axis in 0..3 {
                    block.v[corner][axis][slot] = v[axis];
                }
            }
            (block.instance[slot], block.index[slot], block.flags[slot]) = (t.instance, t.index, t.flags);
        }
        block
    }

    /// One of the triangles.
    #[inline(always)]
    pub fn triangle(&self, slot: usize) -> Triangle {
        let v = [0, 1, 2].map(|corner| {
            let axes = &self.v[corner];
            Vec3::new(axes[0][slot], axes[1][slot], axes[2][slot])
        });
        Triangle { v, instance: self.instance[slot], index: self.index[slot], flags: self.flags[slot] }
    }

    /// All of them.
    #[inline(always)]
    pub fn corners<F: F32x8>(&self) -> [Vectors3<F>; 3] {
        each!(|corner| each!(|axis| F::load(&self.v[corner][axis])))
    }

    /// The same triangles with corners after a share of the way to those of another block, as
    /// [`between`](crate::scene::between) has them, to the same bits.
    #[inline(always)]
    pub fn towards<F: F32x8>(&self, other: &Self, share: f32) -> Self {
        let (of_self, of_other) = (F::splat(1.0 - share), F::splat(share));
        let mut block = *self;
        for corner in 0..3 {
            for axis in 0..3 {
                let (a, b) = (F::load(&self.v[corner][axis]), F::load(&other.v[corner][axis]));
                block.v[corner][axis] = (a * of_self + b * of_other).array();
            }
        }
        block
    }

    /// As often the same as a vector has places.
    #[inline(always)]
    pub fn corners_of<F: Vector>(&self, slot: usize) -> [Vectors3<F>; 3] {
        each!(|corner| each!(|axis| F::splat(self.v[corner][axis][slot])))
    }
}

/// Segments or rays, of which each has a place: all the same, or each its own.
#[derive(Clone, Copy)]
pub(super) struct Lines<F> {
    /// Where they start (m).
    pub origin: Vectors3<F>,
    /// From start to end, or the direction to infinity.
    pub direction: Vectors3<F>,
    /// Where they end (m); not used of those that go to infinity.
    pub target: Vectors3<F>,
    /// Error of each component of the ends (m), from transforming them into this space.
    pub point_error: F,
}

/// What the planes of triangles need, without any segment.
///
/// # Error of the signed volume `(v₀ − p) · n`
/// With `M = ‖e₁‖_∞ ‖e₂‖_∞` a component of `n` is at most `2M` and computed with an error of at
/// most `2 γ₄ M` (differences of inputs, one product each, one difference). Multiplied by `v₀ − p`
/// (one rounding), and summed (three more), the error of the volume is at most
///
/// ```text
/// ‖v₀ − p‖₁ · M · (2 γ₄ + 2 γ₄ (1 + γ₄)) < 17 u ‖v₀ − p‖₁ M
/// ```
///
/// and for a point that is itself wrong by `e` in each component, `6 M e` more, as `‖n‖₁ ≤ 6 M`.
/// The constants below are rounded up, which pays for the rounding of the bound itself.
#[derive(Clone, Copy)]
struct Planes<F> {
    n: Vectors3<F>,
    /// `M · 20 u`, to be multiplied by `‖v₀ − p‖₁`.
    per_length: F,
    /// `7 M`, to be multiplied by the error of the point.
    per_error: F,
}

impl<F: Vector> Planes<F> {
    #[inline(always)]
    fn new(v: &[Vectors3<F>; 3]) -> Self {
        let (e1, e2) = (sub(v[1], v[0]), sub(v[2], v[0]));
        let m = largest(e1) * largest(e2);
        Self { n: cross(e1, e2), per_length: m * F::splat(gamma(20)), per_error: m * F::splat(7.0) }
    }

    /// `(v₀ − p) · n` from `a = v₀ − p`.
    #[inline(always)]
    fn volume(&self, a: Vectors3<F>) -> F {
        a[0] * self.n[0] + a[1] * self.n[1] + a[2] * self.n[2]
    }

    /// Bound of the error of [`Planes::volume`]; `point_error` is that of each component of `p`
    /// (m).
    #[inline(always)]
    fn error(&self, a: Vectors3<F>, point_error: F) -> F {
        (a[0].abs() + a[1].abs() + a[2].abs()) * self.per_length + self.per_error * point_error
    }
}

/// Places whose segment is blocked, by the two rules of [`accel`](crate::accel).
#[inline(always)]
pub(super) fn blocked<F: Vector, const BOUNDED: bool>(v: &[Vectors3<F>; 3], s: &Lines<F>) -> u32 {
    let planes = Planes::new(v);
    let (a, b, c) = (sub(v[0], s.origin), sub(v[1], s.origin), sub(v[2], s.origin));
    let start = planes.volume(a);
    // Turned so that the start is on the positive side.
    let (end, end_error) = if BOUNDED {
        let e = sub(v[0], s.target);
        (F::splat(0.0) - planes.volume(e).flipped_by(start), planes.error(e, s.point_error))
    } else {
        (planes.volume(s.direction).flipped_by(start), planes.error(s.direction, F::splat(0.0)))
    };
    let across = F::and(start.abs().gt(planes.error(a, s.point_error)), end.gt(end_error));
    if F::bits(across) == 0 {
        return 0;
    }
    F::bits(F::and(across, inside(edges(a, b, c, s.direction), start)))
}

/// Places whose ray meets a triangle, and the parameters: the origin is certainly off the plane,
/// the direction certainly towards it, and the line passes inside.
#[inline(always)]
pub(super) fn met<F: Vector>(v: &[Vectors3<F>; 3], s: &Lines<F>) -> (u32, F) {
    let planes = Planes::new(v);
    let (a, b, c) = (sub(v[0], s.origin), sub(v[1], s.origin), sub(v[2], s.origin));
    let start = planes.volume(a);
    let slope = planes.volume(s.direction);
    let off = start.abs().gt(planes.error(a, s.point_error));
    let towards = slope.flipped_by(start).gt(planes.error(s.direction, F::splat(0.0)));
    let inside = inside(edges(a, b, c, s.direction), start);
    (F::bits(F::and(F::and(off, towards), inside)), start / slope)
}

/// Places where all three have the sign of `start`, or are zero.
#[inline(always)]
fn inside<F: Vector>(edges: [F; 3], start: F) -> F::Mask {
    // NaN is outside, as it must be: the smallest of three that hold one could be another.
    let [u, v, w] = each!(|edge| F::splat(0.0).le(edges[edge].flipped_by(start)));
    F::and(F::and(u, v), w)
}

/// The edge functions `d·(b × c)`, `d·(c × a)`, `d·(a × b)`: barycentric weights of the three
/// corners, up to a factor.
#[inline(always)]
fn edges<F: Vector>(a: Vectors3<F>, b: Vectors3<F>, c: Vectors3<F>, d: Vectors3<F>) -> [F; 3] {
    [dot(cross(b, c), d), dot(cross(c, a), d), dot(cross(a, b), d)]
}

/// Barycentric weights of the point at which a line passes a triangle.
pub(super) fn barycentric(origin: Vec3, direction: Vec3, t: &Triangle) -> [f32; 3] {
    let [a, b, c] = t.v.map(|v| v - origin);
    let edge = |p: Vec3, q: Vec3| {
        let n = [p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x];
        n[0] * direction.x + n[1] * direction.y + n[2] * direction.z
    };
    let [u, v, w] = [edge(b, c), edge(c, a), edge(a, b)];
    let sum = u + v + w;
    if sum == 0.0 || !sum.is_finite() { [1.0 / 3.0; 3] } else { [u / sum, v / sum, w / sum] }
}

#[inline(always)]
fn largest<F: Vector>(v: Vectors3<F>) -> F {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}

/// `a × b`; swapping the arguments negates every bit of the result.
#[inline(always)]
fn cross<F: Vector>(a: Vectors3<F>, b: Vectors3<F>) -> Vectors3<F> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn dot<F: Vector>(a: Vectors3<F>, b: Vectors3<F>) -> F {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn sub<F: Vector>(a: Vectors3<F>, b: Vectors3<F>) -> Vectors3<F> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
