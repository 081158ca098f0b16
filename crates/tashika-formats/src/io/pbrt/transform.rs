//! Matrices of the transform directives.
//!
//! Points are columns; a directive multiplies the current matrix from the right, `C ← C · M`.
//! Camera space is left-handed in pbrt: `+x` right, `+y` up, `+z` forward. Products are formed in
//! `f64`.
//!
//! Source: Pharr et al. 2023, sections 3.9 and 5.2. Tested by the tests below.

use glam::{Affine3A, DAffine3, DMat4, DVec3, DVec4};

use crate::math::elementary::sin_cos;
use crate::math::motion::Track;

/// `LookAt`: world to camera. None if the three arguments give no frame.
pub(super) fn look_at(eye: DVec3, target: DVec3, up: DVec3) -> Option<DMat4> {
    let forward = (target - eye).try_normalize()?;
    let right = up.try_normalize()?.cross(forward).try_normalize()?;
    let up = forward.cross(right);
    let to_world = DMat4::from_cols(right.extend(0.0), up.extend(0.0), forward.extend(0.0), eye.extend(1.0));
    Some(to_world.inverse())
}

/// `Rotate`: by `angle` degrees about `axis`, counter-clockwise when looking against it (Rodrigues'
/// formula).
pub(super) fn rotate(angle: f64, axis: DVec3) -> Option<DMat4> {
    let a = axis.try_normalize()?;
    // Whole turns are subtracted in degrees, where they are exact.
    let (sin, cos) = sin_cos(((angle % 360.0).to_radians()) as f32);
    let (sin, cos) = (f64::from(sin), f64::from(cos));
    let column = |e: DVec3| (a * a.dot(e) + (e - a * a.dot(e)) * cos + a.cross(e) * sin).extend(0.0);
    Some(DMat4::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z), DVec4::W))
}

/// Matrix of the sixteen numbers of `Transform`, column by column.
pub(super) fn matrix(numbers: &[f64; 16]) -> DMat4 {
    DMat4::from_cols_array(numbers)
}

/// Affine part of a matrix; none if the last row is not `0 0 0 w` or the matrix is not finite.
pub(super) fn affine(m: &DMat4) -> Option<DAffine3> {
    let row = m.row(3);
    let largest = m.to_cols_array().iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    if !m.is_finite() || row.w == 0.0 || row.truncate().abs().max_element() > 1e-6 * largest {
        return None;
    }
    let column = |v: DVec4| v.truncate() / row.w;
    Some(DAffine3::from_cols(column(m.x_axis), column(m.y_axis), column(m.z_axis), column(m.w_axis)))
}

/// Number of time intervals in the product of two motions; chosen.
const STEPS: u32 = 32;

/// Motion of the product of an object's transform (outer) and the transform of a part in it
/// (inner); none if neither moves.
///
/// If only the outer transform moves, the inner one is applied before it at each key. If the outer
/// transform is the identity, the product is the inner motion. Otherwise the product is evaluated
/// at [`STEPS`] + 1 times from the first to the last key. A product of two even rotations is not an
/// even rotation, but nearly one over such a short interval.
pub(super) fn product([outer, inner]: [&DAffine3; 2], tracks: [Option<&Track>; 2]) -> Option<Track> {
    match tracks {
        [None, None] => None,
        [Some(outer), None] => outer.after(*inner),
        // The object's transform is the identity: the part keeps its own motion.
        [None, Some(inner)] if *outer == DAffine3::IDENTITY => Some(inner.clone()),
        [outer_track, Some(track)] => {
            let spans = [outer_track.unwrap_or(track).span(), track.span()];
            let (from, to) = (spans[0][0].min(spans[1][0]), spans[0][1].max(spans[1][1]));
            let time = |k: u32| from + f64::from(k) / f64::from(STEPS) * (to - from);
            let at = |seconds: f64| outer_track.map_or(*outer, |track| track.at(seconds)) * track.at(seconds);
            Track::new((0..=STEPS).map(|k| (time(k), at(time(k)))))
        }
    }
}

/// Returns the transform in `f32` if it and its inverse are finite, so that it can place something.
pub(super) fn placeable(t: &DAffine3) -> Option<Affine3A> {
    let t = t.as_affine3a();
    (t.is_finite() && t.inverse().is_finite() && t.matrix3.determinant() != 0.0).then_some(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn look_at_puts_the_target_ahead_and_keeps_the_sides() {
        let m = look_at(DVec3::new(1.0, 2.0, 3.0), DVec3::new(1.0, 2.0, 13.0), DVec3::Y).unwrap();
        assert!((m.transform_point3(DVec3::new(1.0, 2.0, 8.0)) - DVec3::new(0.0, 0.0, 5.0)).length() < 1e-12);
        // Looking along +z with +y up, +x is to the right: the frame is left-handed.
        assert!((m.transform_point3(DVec3::new(2.0, 2.0, 3.0)) - DVec3::X).length() < 1e-12);
        assert!(look_at(DVec3::ZERO, DVec3::ZERO, DVec3::Y).is_none());
        assert!(look_at(DVec3::ZERO, DVec3::Y, DVec3::Y).is_none());
    }

    #[test]
    fn rotations_turn_by_the_right_hand_in_degrees() {
        let m = rotate(90.0 + 360.0 * 1000.0, DVec3::new(0.0, 0.0, 2.0)).unwrap();
        assert!((m.transform_point3(DVec3::X) - DVec3::Y).length() < 1e-6);
        assert!(rotate(90.0, DVec3::ZERO).is_none());
    }

    #[test]
    fn matrices_are_columns_and_must_be_affine() {
        let mut numbers = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 5.0, 6.0, 7.0, 2.0];
        let t = affine(&matrix(&numbers)).unwrap();
        assert_eq!(t.translation, DVec3::new(2.5, 3.0, 3.5));
        numbers[3] = 0.5;
        assert!(affine(&matrix(&numbers)).is_none());
        assert!(placeable(&DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0))).is_none());
        assert!(placeable(&DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0))).is_some());
    }
}
