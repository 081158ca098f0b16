//! Bounds of the errors of floating-point arithmetic.
//!
//! With the unit roundoff `u = 2⁻²⁴` of `f32`, a sum or product of `n` rounded operations has a
//! relative error of at most `γ_n = n·u / (1 − n·u)` (Higham 2002, section 3.1).
//!
//! # How a segment leaves a surface
//! A point on a triangle is computed as `p = Σ bᵢ vᵢ` with an absolute error of at most
//! `γ₇ Σ |bᵢ vᵢ|` in each component (Pharr, Jakob, Humphreys 2023, section 6.8).
//! [`offset_from_surface`] moves `p` along the geometric normal, just far enough that the *true*
//! plane of the triangle is certainly behind it. `accel` (crate `tashika-core`) counts a hit only
//! if the two ends of the segment are certainly on opposite sides of the plane. Together, the two
//! rules guarantee that no segment is blocked by the surface on which it starts or ends. This holds
//! for any scale, any angle and any shape of triangle, and needs no chosen distance.

use glam::Vec3;

/// Unit roundoff of `f32` with rounding to nearest: half the distance from 1 to the next number.
pub const UNIT_ROUNDOFF: f32 = f32::EPSILON * 0.5;
/// `γ₄`: four rounded operations.
pub const GAMMA_4: f32 = gamma(4);
/// `γ₇`: seven rounded operations.
pub const GAMMA_7: f32 = gamma(7);

/// `γ_n = n·u / (1 − n·u)`, the bound of the relative error of `n` rounded operations.
pub const fn gamma(n: u32) -> f32 {
    let nu = n as f32 * UNIT_ROUNDOFF;
    nu / (1.0 - nu)
}

/// Factor on the offset that covers the error of the normal itself and of the addition.
///
/// If the computed normal is off by less than 60°, the offset along it has a component along the
/// true normal of at least half its length. Triangles with a less accurate normal are removed when
/// a scene is built.
const NORMAL_SLACK: f32 = 2.0;

/// Moves `p` off the plane with unit normal `n`, towards `n`.
///
/// * `p`: a point on the surface (m), wrong by at most `error` (m) in each component.
/// * `n`: unit geometric normal on the side to which the segment leaves.
///
/// The result lies on that side of the true plane to which `n` points: the shift is `2 Σ errorᵢ
/// |nᵢ|`, and each component is then rounded away from `p`. Tested by
/// `rounding::offset_points_are_in_front`.
#[inline]
pub fn offset_from_surface(p: Vec3, error: Vec3, n: Vec3) -> Vec3 {
    let distance = NORMAL_SLACK * error.dot(n.abs());
    let shifted = p + n * distance;
    let away = |s: f32, n: f32| {
        if n > 0.0 {
            s.next_up()
        } else if n < 0.0 {
            s.next_down()
        } else {
            s
        }
    };
    Vec3::new(away(shifted.x, n.x), away(shifted.y, n.y), away(shifted.z, n.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary::powf;

    #[test]
    fn gamma_matches_its_definition() {
        assert!((f64::from(GAMMA_4) - 4.0 * 2f64.powi(-24)).abs() < 1e-13);
        assert!((GAMMA_7 / GAMMA_4 - 7.0 / 4.0).abs() < 1e-5);
    }

    /// Random points of random triangles, at scales from 1e-3 to 1e6 m, are offset. In `f64`, each
    /// lies in front of its triangle.
    #[test]
    fn offset_points_are_in_front() {
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1u64 << 24) as f32
        };
        for round in 0..200_000 {
            let scale = powf(10.0, 9.0 * uniform() - 3.0);
            let center = Vec3::new(uniform() - 0.5, uniform() - 0.5, uniform() - 0.5) * scale;
            let size = scale * powf(10.0, -4.0 * uniform());
            let mut corner = || center + (Vec3::new(uniform(), uniform(), uniform()) - 0.5) * size;
            let v = [corner(), corner(), corner()];
            let n = (v[1] - v[0]).cross(v[2] - v[0]);
            // Slivers whose normal is noise are removed when a scene is built.
            if n.length() < 1e-4 * size * size {
                continue;
            }
            let n = n.normalize();
            let (r, s) = (uniform().sqrt(), uniform());
            let b = [1.0 - r, r * (1.0 - s), r * s];
            let p = v[0] * b[0] + v[1] * b[1] + v[2] * b[2];
            let error = GAMMA_7 * ((v[0] * b[0]).abs() + (v[1] * b[1]).abs() + (v[2] * b[2]).abs());
            let q = offset_from_surface(p, error, n).as_dvec3();
            let d = v.map(Vec3::as_dvec3);
            let exact = (d[1] - d[0]).cross(d[2] - d[0]);
            assert!((q - d[0]).dot(exact) > 0.0, "round {round}: behind its own plane");
        }
    }
}
