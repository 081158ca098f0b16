//! Extremes of the angles that a BRDF depends on, over a row of texels at once.
//!
//! Let `a` be the axis and `β` the half-angle of a texel's bounding cone. As in `bounds::spans`,
//!
//! ```text
//! θ_n − β ≤ ∠(ω_i, n) ≤ θ_n + β,   ∠(ω_i, m) ≥ θ_m − β,   ∠(ω_i, ω_o) ≤ min(θ_o + β, ∠(n, ω_o) + π/2)
//! ∠(h, n) ≥ ½ ∠(ω_i, m)   and   ∠(h, n) ≥ ∠(ω_o + a, n) − arcsin(2 sin(β/2) / ‖ω_o + a‖)
//! ```
//!
//! for the normal `n`, the mirror direction `m`, the half vector `h`, and `θ` the angle between `a`
//! and the direction in its index. The computation uses `f32` and no branches, so that the compiler
//! vectorises a row.
//!
//! # Rounding
//! Scalar products are off by at most [`COSINE`]. A difference of angles is either cut off at zero,
//! or its larger angle is at least the half-angle of a texel. In the latter case its sine is at
//! least 1/20, and the angle is off by at most `20 COSINE`. Every texel is widened by [`SLACK`],
//! which is ten times that. In `∠(ω_o + a, n) − arcsin(2 sin(β/2) / ‖ω_o + a‖)` the error of the
//! first angle is at most `50 COSINE`. The widening increases the second angle by at least
//! `0.9 SLACK / 2`, nearly twice that error. The rest of the slack covers the rotation of
//! directions by rounding in `contribution` ([`TURN`]). Small differences are stored as sines,
//! since a cosine near 1 does not distinguish them from zero.
//!
//! # Held to this by
//! The tests below and those of `fill`.

use super::faces::{Faces, Row};
use crate::bounds::Reflector;
use crate::bsdf::MIN_COSINE;
use crate::math::Vec3;

/// Error of scalar products here. Directions are of unit length to 10⁻⁶, also after transformation
/// by frames; products are rounded by `3 · 2⁻²⁴`.
const COSINE: f32 = 2e-6;

/// `√(2 COSINE)`: the largest error of a sine that is computed from a cosine.
const SINE: f32 = 2e-3;

/// Upper bound, with some room, of two errors: the rotation of directions by rounding in
/// `contribution` (rad), and the error of half sums of unit vectors.
const TURN: f32 = 1e-5;

/// Widening of the half-angles of texels (rad). Chosen large enough for the roundings, and less
/// than a hundredth of a texel.
const SLACK: f32 = 4e-4;

/// Cosine of incidence below which the rounding of two directions (3·10⁻⁶) may turn the half vector
/// by more than `SLACK / 4`.
const SMALLEST_INCIDENCE: f32 = 0.02;

/// Unit directions to which the angles of a BRDF refer; the normals are on the side of the viewer.
#[derive(Clone, Copy)]
pub struct Directions {
    normal: Vec3,
    geometric_normal: Vec3,
    viewer: Vec3,
    mirror: Vec3,
    /// Scalar product of the normal and the viewer's direction.
    viewer_along_normal: f32,
    /// Least cosine of incidence of light above the horizon,
    /// `cos ½(θ + π/2) = cos θ / √(2 (1 + sin θ))` for `θ = ∠(n, ω_o)`.
    horizon_incidence: f32,
}

/// Position of the texels of a row relative to the planes of the two normals.
pub struct Horizon<const N: usize> {
    /// True if part of the texel is above both planes.
    pub above: [bool; N],
    /// Largest cosine with the normal; above zero for texels that are partly above both planes.
    pub max_cos_i: [f32; N],
}

/// Extremes of the angles that a lobe depends on.
pub struct Spans<const N: usize> {
    /// Least cosine with the normal, at least [`MIN_COSINE`].
    pub min_cos_i: [f32; N],
    /// Sine and cosine of the least angle with the mirror direction.
    pub from_mirror: [[f32; N]; 2],
    /// Least cosine of incidence on a facet.
    pub cos_incidence: [f32; N],
    /// Sine of the least angle of the half vector with the normal.
    pub half_sin: [f32; N],
}

impl Directions {
    /// Directions of a gather point, in world space.
    pub fn of(point: &Reflector) -> Self {
        let Vec3 { x, y, z } = point.wo;
        let world = |local: Vec3| point.frame.to_world(local).normalize();
        let (normal, viewer) = (point.normal(), world(point.wo));
        let sin_o = (x * x + y * y).sqrt();
        Self {
            normal,
            geometric_normal: point.geometric_normal,
            viewer,
            mirror: world(Vec3::new(-x, -y, z)),
            viewer_along_normal: normal.dot(viewer),
            horizon_incidence: (z.abs() / (2.0 + 2.0 * sin_o).sqrt() - TURN).max(0.0),
        }
    }

    /// Components of the directions along the `u`, `v` and normal directions of a face, as used by
    /// the rows of texels.
    pub fn turned<const N: usize>(self, face: usize) -> Self {
        let turned = |w: Vec3| Faces::<N>::turned(face, w);
        Self {
            normal: turned(self.normal),
            geometric_normal: turned(self.geometric_normal),
            viewer: turned(self.viewer),
            mirror: turned(self.mirror),
            ..self
        }
    }

    /// Texels of a row from which light can arrive, and their largest cosines with the normal.
    pub fn horizon<const N: usize>(&self, row: &Row<N>) -> Horizon<N> {
        let mut horizon = Horizon { above: [false; N], max_cos_i: [0.0; N] };
        for u in 0..N {
            let (cos, sin) = widened(row, u);
            let cos_n = along(row, u, self.normal);
            horizon.above[u] = (cos_n > -sin) & (along(row, u, self.geometric_normal) > -sin);
            // θ_n − β.
            let nearest = (cos_n * cos + sin_of(cos_n) * sin).max(COSINE);
            horizon.max_cos_i[u] = if cos_n >= cos { 1.0 } else { nearest };
        }
        horizon
    }

    /// Extremes over the texels of a row, for light above the horizon.
    pub fn spans<const N: usize>(&self, row: &Row<N>) -> Spans<N> {
        let mut spans = Spans::NONE;
        for u in 0..N {
            let (cos, sin) = widened(row, u);
            let cos_n = along(row, u, self.normal);
            let (cos_o, cos_m) = (along(row, u, self.viewer), along(row, u, self.mirror));
            let (sin_n, sin_o, sin_m) = (sin_of(cos_n), sin_of(cos_o), sin_of(cos_m));
            // θ_n + β.
            spans.min_cos_i[u] = (cos_n * cos - (sin_n + SINE) * sin - 2.0 * COSINE).max(MIN_COSINE);
            // θ_m − β.
            let near_mirror = cos_m >= cos;
            let mirror_sin = if near_mirror { 0.0 } else { (sin_m * cos - cos_m * sin).max(0.0) };
            let mirror_cos = if near_mirror { 1.0 } else { cos_m * cos + sin_m * sin };
            (spans.from_mirror[0][u], spans.from_mirror[1][u]) = (mirror_sin, mirror_cos);
            // ½ (θ_o + β).
            let widest_cos = cos_o * cos - (sin_o + SINE) * sin;
            let beyond = sin_o * cos + cos_o * sin <= SINE;
            let within = if beyond { 0.0 } else { (0.5 + 0.5 * widest_cos).max(0.0).sqrt() };
            let cos_incidence = within.max(self.horizon_incidence);
            spans.cos_incidence[u] = cos_incidence;
            // ½ (θ_m − β).
            let half_cos = (0.5 + 0.5 * mirror_cos).max(0.0).sqrt();
            let wide_sin = (0.5 - 0.5 * mirror_cos).max(0.0).sqrt();
            let half_sin = if mirror_cos > 0.0 { 0.5 * mirror_sin / half_cos } else { wide_sin };
            let by_mirror = if cos_incidence < SMALLEST_INCIDENCE { 0.0 } else { half_sin };
            // ∠(ω_o + a, n) minus the angle of the ball. If the difference is beyond a right angle,
            // no half vector is possible.
            let length = (2.0 + 2.0 * cos_o).max(1e-12).sqrt();
            let ball_sin = sin / (0.5 + 0.5 * cos).sqrt() / length;
            let ball_cos = sin_of(ball_sin.min(1.0));
            let sum_cos = ((self.viewer_along_normal + cos_n) / length).clamp(-1.0, 1.0);
            let sum_sin = sin_of(sum_cos);
            let outside = (ball_sin < 1.0) & (sum_cos < ball_cos);
            let acute = sum_cos * ball_cos + sum_sin * ball_sin > 0.0;
            let difference = (sum_sin * ball_cos - sum_cos * ball_sin).max(0.0);
            let apart = if acute { difference } else { 1.0 };
            let by_ball = if outside { apart } else { 0.0 };
            spans.half_sin[u] = by_mirror.max(by_ball);
        }
        spans
    }
}

impl<const N: usize> Spans<N> {
    /// All zero, for BRDFs without a lobe.
    pub const NONE: Self =
        Self { min_cos_i: [0.0; N], from_mirror: [[0.0; N]; 2], cos_incidence: [0.0; N], half_sin: [0.0; N] };
}

/// Cosine and sine of the half-angle of a texel, widened by [`SLACK`].
#[inline]
fn widened<const N: usize>(row: &Row<N>, u: usize) -> (f32, f32) {
    let (cos, sin) = (row.cos[u], sin_of(row.cos[u]));
    (cos - SLACK * sin - SLACK * SLACK, sin + SLACK * cos)
}

/// Scalar product of the axis of a texel with a vector.
#[inline]
fn along<const N: usize>(row: &Row<N>, u: usize, w: Vec3) -> f32 {
    w.x * row.x[u] + w.y * row.y[u] + w.z * row.z[u]
}

/// Sine of an angle from its cosine, or cosine of an acute angle from its sine.
#[inline]
fn sin_of(cos: f32) -> f32 {
    ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::tests::cases::{Kind, half_angle, into_cone, mirror, near, random_point};
    use crate::rng::{Purpose, Stream};

    const N: usize = 8;

    /// Directions of a texel, by `k`: random; towards the mirror direction; just above the horizon
    /// near a random direction; just above the horizon opposite to the viewer.
    fn direction(point: &Reflector, face: usize, v: usize, u: usize, k: u32, s: &mut Stream) -> glam::DVec3 {
        let cone = Faces::<N>::cone(face, v, u);
        let axis = cone.axis.as_dvec3();
        let n = point.normal().as_dvec3().normalize();
        let along_horizon = |d: glam::DVec3| (d - n * d.dot(n)).normalize() + n * 1e-6;
        let anywhere = near(axis, half_angle(&cone), s);
        match k % 4 {
            0 => anywhere,
            1 => into_cone(&cone, mirror(point)),
            2 => into_cone(&cone, along_horizon(anywhere).normalize()),
            _ => into_cone(&cone, along_horizon(mirror(point)).normalize()),
        }
    }

    /// All extremes bound the angles of random directions, computed in `f64`.
    #[test]
    fn extremes_are_extremes() {
        let mut s = Stream::new(61, Purpose::Test, 0);
        let mut seen = [0; 4];
        for _ in 0..300 {
            let point = random_point(Kind::Phong, &mut s);
            let n = point.normal().as_dvec3().normalize();
            let viewer = point.frame.to_world(point.wo).as_dvec3().normalize();
            for texel in 0..6 * N * N {
                let (face, v, u) = (texel / (N * N), texel / N % N, texel % N);
                let directions = Directions::of(&point).turned::<N>(face);
                let row = &Faces::<N>::ROWS[v];
                let (horizon, spans) = (directions.horizon(row), directions.spans(row));
                for k in 0..8 {
                    let d = direction(&point, face, v, u, k, &mut s);
                    if d.dot(n) <= 1e-7 || d.dot(point.geometric_normal.as_dvec3()) <= 0.0 {
                        continue;
                    }
                    seen[k as usize % 4] += 1;
                    let what = || format!("texel {face} {v} {u}, {d:?}, {point:?}");
                    assert!(horizon.above[u], "{}", what());
                    assert!(d.dot(n) <= f64::from(horizon.max_cos_i[u]), "{}", what());
                    assert!(d.dot(n) >= f64::from(spans.min_cos_i[u]), "{}", what());
                    let [sin, cos] = spans.from_mirror.map(|lanes| f64::from(lanes[u]));
                    assert!(d.angle_between(mirror(&point)) >= sin.atan2(cos), "{}", what());
                    let sum = d + viewer;
                    assert!(0.5 * sum.length() >= f64::from(spans.cos_incidence[u]), "{}", what());
                    let half_sin = sum.cross(n).length() / sum.length();
                    assert!(half_sin >= f64::from(spans.half_sin[u]), "{}", what());
                }
            }
        }
        assert!(seen.iter().all(|&k| k > 10_000), "{seen:?}");
    }

    /// [`SLACK`] assumes that the sines of half-angles are at least 1/20.
    #[test]
    fn half_angles_of_texels_are_at_least_a_twentieth() {
        assert!(Faces::<16>::ROWS.iter().flat_map(|row| row.cos).all(|cos| sin_of(cos) > 0.05));
    }
}
