//! Matrices of the steps of a `<transform>`.
//!
//! Steps are applied in the order of the file: `M = Mₙ … M₂ M₁`, to column vectors, in `f64`.
//! Angles are in degrees; quarter turns are exact. `lookat` has its third axis towards the target
//! and its first to the *left* of it: Mitsuba's cameras look along `+z` with `+x` to the left.
//!
//! Held to this by the tests below and `suite::mitsuba::transforms_apply_in_the_order_of_the_file`.

use glam::{Affine3A, DAffine3, DMat3, DMat4, DVec3, Mat3A, Vec3A};

use crate::math::elementary::sin_cos;

/// Largest coefficient of a matrix: its square stays in the range of `f32`.
const MAX_COEFFICIENT: f64 = 1e18;

/// Largest deviation of the last row of a matrix from `0 0 0 1`.
const MAX_PROJECTION: f64 = 1e-5;

/// The rotation by `degrees` about `axis`; `None` if the axis has no direction.
pub(super) fn rotation(axis: DVec3, degrees: f64) -> Option<DMat4> {
    let axis = axis.try_normalize()?;
    let turn = degrees.rem_euclid(360.0);
    let (sin, cos) = if turn % 90.0 == 0.0 {
        [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][(turn / 90.0) as usize % 4]
    } else {
        let (sin, cos) = sin_cos(turn.to_radians() as f32);
        (f64::from(sin), f64::from(cos))
    };
    // Rodrigues: R v = v cos + (a × v) sin + a (a·v) (1 − cos).
    let column = |v: DVec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
    Some(DMat4::from_mat3(DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))))
}

/// The frame at `origin` that looks at `target`; `None` if they are one point. The second value is
/// true if `up` is along the view and was replaced.
pub(super) fn look_at(origin: DVec3, target: DVec3, up: DVec3) -> Option<(DMat4, bool)> {
    let forward = (target - origin).try_normalize()?;
    let left = up.normalize_or_zero().cross(forward);
    let usable = left.length() > 1e-6;
    let left = if usable { left.normalize() } else { forward.any_orthonormal_vector() };
    let axes = DMat3::from_cols(left, forward.cross(left), forward);
    Some((DMat4::from_translation(origin) * DMat4::from_mat3(axes), !usable))
}

/// Sixteen or nine numbers, row by row.
pub(super) fn matrix(rows: &[f64]) -> Option<DMat4> {
    match rows.len() {
        16 => Some(DMat4::from_cols_slice(rows).transpose()),
        9 => Some(DMat4::from_mat3(DMat3::from_cols_slice(rows).transpose())),
        _ => None,
    }
}

/// Returns true for an affine map with coefficients of at most `MAX_COEFFICIENT`.
pub(super) fn is_affine(m: &DMat4) -> bool {
    let row = m.row(3);
    let projects = row.x.abs().max(row.y.abs()).max(row.z.abs()).max((row.w - 1.0).abs());
    m.is_finite()
        && projects <= MAX_PROJECTION
        && m.to_cols_array().iter().all(|c| c.abs() <= MAX_COEFFICIENT)
}

/// Converts a map to `f32`.
pub(super) fn affine(m: &DMat4) -> Affine3A {
    let column = |i: usize| -> Vec3A { m.col(i).truncate().as_vec3a() };
    Affine3A { matrix3: Mat3A::from_cols(column(0), column(1), column(2)), translation: column(3) }
}

/// Converts a map to three rows: the last one is `0 0 0 1` except for rounding.
pub(super) fn affine_f64(m: &DMat4) -> DAffine3 {
    let column = |i: usize| -> DVec3 { m.col(i).truncate() };
    DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
}

/// Axes of a map, made orthonormal starting with the third; `None` if they lie in a plane.
pub(super) fn orthonormal(m: &DMat4) -> Option<glam::Mat3> {
    let axis = |i: usize| m.col(i).truncate();
    let z = axis(2).try_normalize()?;
    let y = (axis(1) - z * axis(1).dot(z)).try_normalize()?;
    let x = axis(0) - z * axis(0).dot(z) - y * axis(0).dot(y);
    let x = x.try_normalize()?;
    Some(glam::Mat3::from_cols(x.as_vec3(), y.as_vec3(), z.as_vec3()))
}

/// Map of `(u, v, 1)` from a 4 × 4 matrix. The third column, the third row and the last row of the
/// matrix are ignored.
pub(super) fn planar(m: &DMat4) -> glam::Mat3 {
    let column = |i: usize, last: f32| m.col(i).truncate().truncate().as_vec2().extend(last);
    glam::Mat3::from_cols(column(0, 0.0), column(1, 0.0), column(3, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_turn_by_the_right_hand_and_quarters_are_exact() {
        let quarter = rotation(DVec3::new(0.0, 2.0, 0.0), 90.0).unwrap();
        assert_eq!(quarter.transform_vector3(DVec3::Z), DVec3::X);
        assert_eq!(rotation(DVec3::Z, -450.0).unwrap().transform_vector3(DVec3::X), DVec3::NEG_Y);
        let seventh = rotation(DVec3::X, 360.0 / 7.0).unwrap();
        assert!((0..7).fold(DMat4::IDENTITY, |m, _| seventh * m).abs_diff_eq(DMat4::IDENTITY, 1e-6));
        assert!(rotation(DVec3::ZERO, 10.0).is_none());
    }

    #[test]
    fn look_at_has_the_target_ahead_and_its_first_axis_to_the_left() {
        let eye = DVec3::new(1.0, 2.0, 3.0);
        let (m, replaced) = look_at(eye, eye + DVec3::Z * 5.0, DVec3::Y).unwrap();
        assert!(!replaced);
        assert!(m.transform_point3(DVec3::Z * 5.0).abs_diff_eq(eye + DVec3::Z * 5.0, 1e-12));
        // Seen along +z with y up, +x is on the left.
        assert!(m.transform_vector3(DVec3::X).abs_diff_eq(DVec3::X, 1e-12));
        assert!(look_at(eye, eye, DVec3::Y).is_none());
        assert!(look_at(eye, eye + DVec3::Y, DVec3::Y).unwrap().1);
    }

    #[test]
    fn scales_are_taken_out_and_mirrors_kept() {
        let mirror = DMat4::from_scale(DVec3::new(-2.0, 3.0, 4.0));
        assert_eq!(orthonormal(&mirror).unwrap(), glam::Mat3::from_diagonal(glam::Vec3::new(-1.0, 1.0, 1.0)));
        assert!(orthonormal(&DMat4::from_scale(DVec3::new(1.0, 0.0, 1.0))).is_none());
    }

    #[test]
    fn matrices_are_read_row_by_row() {
        let m = matrix(&[1.0, 0.0, 0.0, 5.0, 0.0, 1.0, 0.0, 6.0, 0.0, 0.0, 1.0, 7.0, 0.0, 0.0, 0.0, 1.0])
            .unwrap();
        assert_eq!(affine(&m).translation, Vec3A::new(5.0, 6.0, 7.0));
        assert!(is_affine(&m) && !is_affine(&(m * 2.0)) && !is_affine(&(DMat4::IDENTITY * f64::NAN)));
        let turn = matrix(&[0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]).unwrap();
        assert_eq!(turn.transform_vector3(DVec3::X), DVec3::Y);
        assert_eq!(planar(&m).transform_point2(glam::Vec2::ZERO), glam::Vec2::new(5.0, 6.0));
    }
}
