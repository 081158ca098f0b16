//! Cones of directions.

use glam::Vec3;

use super::elementary::{acos, atan2, sin_cos};
use super::frame::Frame;

/// All directions within an angle `β` of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Axis of unit length, to the rounding of `f32`.
    pub axis: Vec3,
    /// `cos β`: 1 for the axis alone, −1 for all directions, above 1 for none.
    pub cos: f32,
}

impl Cone {
    /// No direction at all; the neutral element of [`Cone::union`].
    pub const EMPTY: Self = Self { axis: Vec3::Z, cos: f32::INFINITY };
    /// Every direction.
    pub const ALL: Self = Self { axis: Vec3::Z, cos: -1.0 };

    /// The unit vector `direction` alone.
    #[inline]
    pub fn of(direction: Vec3) -> Self {
        Self { axis: direction, cos: 1.0 }
    }

    /// Returns true if the cone holds no direction.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.cos > 1.0
    }

    /// Returns true if the cone holds every direction.
    #[inline]
    pub fn is_all(&self) -> bool {
        self.cos <= -1.0
    }

    /// Returns true if the direction of `v` (any length but zero) lies in the closed cone. Computed
    /// in `f64`, with a margin of 10⁻¹⁵ for its rounding.
    #[inline]
    pub fn contains(&self, v: Vec3) -> bool {
        let (a, v) = (self.axis.as_dvec3(), v.as_dvec3());
        self.is_all() || a.dot(v) >= (f64::from(self.cos) - 1e-15) * (a.length() * v.length())
    }

    /// `cos(β / 2)`, 1 for the empty cone.
    #[inline]
    pub fn cos_half(&self) -> f32 {
        (0.5 + 0.5 * self.cos.clamp(-1.0, 1.0)).sqrt()
    }

    /// `sin(β / 2)`, 0 for the empty cone.
    #[inline]
    pub fn sin_half(&self) -> f32 {
        (0.5 - 0.5 * self.cos.clamp(-1.0, 1.0)).sqrt()
    }

    /// The cone of the opposite directions.
    #[must_use]
    #[inline]
    pub fn reversed(self) -> Self {
        Self { axis: -self.axis, cos: self.cos }
    }

    /// Returns the smallest cone that holds both cones, to rounding.
    ///
    /// The axis is the middle of the arc from the far side of one cone to the far side of the
    /// other. The half-angle is the larger of the two sums `∠(axis, axisᵢ) + βᵢ`, computed in `f64`
    /// for the rounded axis and rounded up. The result therefore holds both cones, whatever the
    /// rounding of the axis. Tested by `cone::unions_hold_both_and_little_more`.
    #[must_use]
    #[inline]
    pub fn union(self, other: Self) -> Self {
        if other.is_empty() || self.is_all() {
            return self;
        }
        if self.is_empty() || other.is_all() {
            return other;
        }
        if self.axis == other.axis {
            return Self { axis: self.axis, cos: self.cos.min(other.cos) };
        }
        let (wide, narrow) = if self.cos <= other.cos { (self, other) } else { (other, self) };
        let between = angle(wide.axis, narrow.axis);
        let (wide_angle, narrow_angle) = (acos(wide.cos), acos(narrow.cos));
        let turn = 0.5 * (between + narrow_angle - wide_angle);
        let axis = if turn <= 0.0 { wide.axis } else { turned(wide.axis, narrow.axis, turn) };
        let cos = cos_of_sum(axis, wide).min(cos_of_sum(axis, narrow));
        if cos <= -1.0 {
            return Self::ALL;
        }
        // The rounding of the f64 arithmetic is far below that of the result.
        let rounded = cos as f32;
        let cos = if f64::from(rounded) + 1e-14 > cos { rounded.next_down() } else { rounded };
        Self { axis, cos: cos.max(-1.0) }
    }
}

/// The angle between unit vectors, precise for small ones.
#[inline]
fn angle(a: Vec3, b: Vec3) -> f32 {
    2.0 * atan2((a - b).length(), (a + b).length())
}

/// Rotates `from` by `angle` (radians) towards `to`.
#[inline]
fn turned(from: Vec3, to: Vec3, angle: f32) -> Vec3 {
    let across = to - from * from.dot(to);
    // Opposite vectors may be turned along any arc.
    let across = if across.length_squared() > 1e-12 { across.normalize() } else { Frame::about(from).t };
    let (sin, cos) = sin_cos(angle);
    (from * cos + across * sin).normalize()
}

/// `cos(∠(axis, cone.axis) + β)`; −1 beyond a half turn.
#[inline]
fn cos_of_sum(axis: Vec3, cone: Cone) -> f64 {
    let (a, b) = (axis.as_dvec3().normalize(), cone.axis.as_dvec3().normalize());
    let (cos_a, sin_a) = (a.dot(b), a.cross(b).length());
    let cos_b = f64::from(cone.cos);
    let sin_b = ((1.0 - cos_b) * (1.0 + cos_b)).max(0.0).sqrt();
    let sin_sum = sin_a * cos_b + cos_a * sin_b;
    if sin_sum < 0.0 { -1.0 } else { cos_a * cos_b - sin_a * sin_b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary::powf;
    use crate::rng::{Purpose, Stream};
    use crate::warp;

    fn cone(s: &mut Stream) -> Cone {
        let narrow = powf(10.0, -7.0 * s.uniform());
        Cone { axis: warp::sphere(s.uniform_2()), cos: 1.0 - 2.0 * narrow * s.uniform() }
    }

    /// Random direction in the cone; every second one lies on its rim. Computed in `f64`, since a
    /// cone may be narrower than the rounding of `f32`.
    fn member(cone: &Cone, s: &mut Stream) -> glam::DVec3 {
        let axis = cone.axis.as_dvec3().normalize();
        let t = axis.any_orthonormal_vector();
        let b = axis.cross(t);
        let rim = if s.uniform() < 0.5 { 1.0 } else { s.uniform_f64() };
        let cos = 1.0 - rim * (1.0 - f64::from(cone.cos));
        let (sin_phi, cos_phi) = sin_cos(std::f32::consts::TAU * s.uniform());
        let across = t * f64::from(cos_phi) + b * f64::from(sin_phi);
        axis * cos + across.normalize() * ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt()
    }

    #[test]
    fn unions_hold_both_and_little_more() {
        let mut s = Stream::new(1, Purpose::Test, 0);
        for round in 0..20_000 {
            let a = cone(&mut s);
            let b = match round % 4 {
                0 => Cone { axis: -a.axis, ..cone(&mut s) },
                1 => Cone { axis: (a.axis + warp::sphere(s.uniform_2()) * 1e-4).normalize(), ..cone(&mut s) },
                _ => cone(&mut s),
            };
            let union = a.union(b);
            for _ in 0..8 {
                for inner in [&a, &b] {
                    let v = member(inner, &mut s);
                    let cos = union.axis.as_dvec3().normalize().dot(v);
                    assert!(cos >= f64::from(union.cos) - 1e-14, "{a:?} {b:?} {union:?} {cos}");
                }
            }
            let sum = angle(a.axis, b.axis) + acos(a.cos) + acos(b.cos);
            let smallest = (0.5 * sum).max(acos(a.cos)).max(acos(b.cos)).min(std::f32::consts::PI);
            // The largest `f32` below 1 is the cosine of 3.5·10⁻⁴ rad, so a cosine in `f32` cannot
            // represent a smaller angle.
            assert!(acos(union.cos) <= smallest + 6e-4, "{a:?} {b:?} {union:?}");
        }
    }

    #[test]
    fn unions_have_their_neutral_and_absorbing_elements() {
        let a = Cone { axis: Vec3::X, cos: 0.5 };
        assert_eq!((a.union(Cone::EMPTY), Cone::EMPTY.union(a)), (a, a));
        assert_eq!((a.union(Cone::ALL), Cone::ALL.union(a)), (Cone::ALL, Cone::ALL));
        assert!(!Cone::EMPTY.contains(Vec3::X) && Cone::ALL.contains(-Vec3::X));
        let wide = Cone { axis: Vec3::X, cos: -0.1 };
        assert!(wide.union(wide.reversed()).is_all());
        assert_eq!(Cone::of(Vec3::Y).union(Cone::of(Vec3::Y)), Cone::of(Vec3::Y));
    }
}
