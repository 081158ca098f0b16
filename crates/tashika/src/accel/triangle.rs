//! The triangle test, written once for any number of lanes.

use glam::Vec3;

use crate::math::gamma;

/// Bits of [`Triangle::flags`].
pub(super) mod flag {
    /// Light may pass along segments: the material has to be asked.
    pub const TRANSPARENT: u32 = 1;
    /// Rays may pass as if nothing were there: the material has to be asked.
    pub const HOLES: u32 = 2;
}

/// A triangle as the tracer keeps it, in the order of the leaves.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
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

/// What the planes of a triangle need, without any segment.
///
/// # Error of the signed volume `(v₀ − p) · n`
/// With `M = ‖e₁‖_∞ ‖e₂‖_∞` a component of `n` is at most `2M` and computed with an error of at most
/// `2 γ₄ M` (differences of inputs, one product each, one difference). Multiplied by `v₀ − p` (one rounding), and
/// summed (three more), the error of the volume is at most
///
/// ```text
/// ‖v₀ − p‖₁ · M · (2 γ₄ + 2 γ₄ (1 + γ₄)) < 17 u ‖v₀ − p‖₁ M
/// ```
///
/// and for a point that is itself wrong by `e` in each component, `6 M e` more, as `‖n‖₁ ≤ 6 M`. The constants
/// below are rounded up, which pays for the rounding of the bound itself.
#[derive(Clone, Copy)]
pub(super) struct Planes {
    pub n: Vec3,
    /// `M · 20 u`, to be multiplied by `‖v₀ − p‖₁`.
    per_length: f32,
    /// `7 M`, to be multiplied by the error of the point.
    per_error: f32,
}

impl Planes {
    #[inline(always)]
    pub fn new(t: &Triangle) -> Self {
        let (e1, e2) = (t.v[1] - t.v[0], t.v[2] - t.v[0]);
        let n = Vec3::new(e1.y * e2.z - e1.z * e2.y, e1.z * e2.x - e1.x * e2.z, e1.x * e2.y - e1.y * e2.x);
        let m = largest(e1) * largest(e2);
        Self { n, per_length: m * gamma(20), per_error: m * 7.0 }
    }

    /// `(v₀ − p) · n` from `a = v₀ − p`.
    #[inline(always)]
    pub fn volume(&self, a: [f32; 3]) -> f32 {
        a[0] * self.n.x + a[1] * self.n.y + a[2] * self.n.z
    }

    /// Bound of the error of [`Planes::volume`]; `point_error` is that of each component of `p` (m).
    #[inline(always)]
    pub fn error(&self, a: [f32; 3], point_error: f32) -> f32 {
        (a[0].abs() + a[1].abs() + a[2].abs()) * self.per_length + self.per_error * point_error
    }
}

#[inline(always)]
fn largest(v: Vec3) -> f32 {
    let a = v.abs();
    let xy = if a.x > a.y { a.x } else { a.y };
    if xy > a.z { xy } else { a.z }
}

/// `a × b`; swapping the arguments negates every bit of the result.
#[inline(always)]
pub(super) fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
pub(super) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(super) fn sub(v: Vec3, o: [f32; 3]) -> [f32; 3] {
    [v.x - o[0], v.y - o[1], v.z - o[2]]
}

/// The edge functions `d·(b × c)`, `d·(c × a)`, `d·(a × b)`: barycentric weights of the three corners, up to a factor.
#[inline(always)]
pub(super) fn edges(a: [f32; 3], b: [f32; 3], c: [f32; 3], d: [f32; 3]) -> [f32; 3] {
    [dot(cross(b, c), d), dot(cross(c, a), d), dot(cross(a, b), d)]
}
