//! Angles in `[0, π]` as pairs of sine and cosine, in `f64`. Sums and differences need no inverse
//! functions.
//!
//! ```text
//! sin(a ± b) = sin a cos b ± cos a sin b        cos(a ± b) = cos a cos b ∓ sin a sin b
//! ```
//!
//! A sum is cut off at `π` and a difference at zero, like the extremes of an angle over a cone.
//! Both numbers are stored because each alone is imprecise at one end: a cosine does not
//! distinguish 10⁻⁹ rad from zero. Vectors that are rounded to `f32` are not exactly of length 1.
//! Sine and cosine of an angle between them may therefore have a common factor that differs from 1
//! by 10⁻⁶; sums and differences of angles do not depend on this factor.
//!
//! # Guarantee
//! Angles are exact to a few roundings of `f64`; sines and cosines are exact up to the common
//! factor.
//!
//! # Held to this by
//! The tests below.

use glam::DVec3;

use crate::math::Cone;

/// Largest angle by which `f32` arithmetic turns a direction between a cone and the BSDF (rad).
///
/// In [`contribution`](crate::contribution) a unit direction is rounded (2·10⁻⁷), transformed to a
/// frame whose axes are orthonormal to 5·10⁻⁷, and rounded again (3·10⁻⁷). Axes of cones are
/// directions that were transformed from such a frame and rounded (10⁻⁶). The constant is chosen
/// above the sum of these.
pub(super) const TURN: Angle = Angle { sin: 3e-6, cos: 1.0 - 4.5e-12 };

/// Sine and cosine of an angle in `[0, π]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Angle {
    /// Sine, not negative.
    pub(super) sin: f64,
    /// Cosine, with its sign.
    pub(super) cos: f64,
}

impl Angle {
    /// Angle of 0 rad.
    pub(super) const ZERO: Self = Self { sin: 0.0, cos: 1.0 };
    /// Half a turn.
    pub(super) const PI: Self = Self { sin: 0.0, cos: -1.0 };

    /// Angle between two unit vectors.
    pub(super) fn between(a: DVec3, b: DVec3) -> Self {
        Self { sin: a.cross(b).length(), cos: a.dot(b) }
    }

    /// Half-angle of a cone.
    pub(super) fn half_angle(cone: &Cone) -> Self {
        Self::of_cos(f64::from(cone.cos))
    }

    /// The angle of cosine `cos`, clamped to `[−1, 1]`.
    pub(super) fn of_cos(cos: f64) -> Self {
        let cos = cos.clamp(-1.0, 1.0);
        Self { sin: ((1.0 - cos) * (1.0 + cos)).sqrt(), cos }
    }

    /// The acute angle of sine `sin` in `[0, 1]`.
    pub(super) fn of_sin(sin: f64) -> Self {
        Self { sin, cos: ((1.0 - sin) * (1.0 + sin)).max(0.0).sqrt() }
    }

    /// `min(π, self + other)`.
    #[must_use]
    pub(super) fn plus(self, other: Self) -> Self {
        let sin = self.sin * other.cos + self.cos * other.sin;
        if sin < 0.0 { Self::PI } else { Self { sin, cos: self.cos * other.cos - self.sin * other.sin } }
    }

    /// `max(0, self − other)`.
    #[must_use]
    pub(super) fn minus(self, other: Self) -> Self {
        let sin = self.sin * other.cos - self.cos * other.sin;
        if sin <= 0.0 { Self::ZERO } else { Self { sin, cos: self.cos * other.cos + self.sin * other.sin } }
    }

    /// `self / 2`.
    #[must_use]
    pub(super) fn half(self) -> Self {
        // sin a = 2 sin(a/2) cos(a/2) gives the smaller of the two: 1 ± cos a cancels.
        if self.cos >= 0.0 {
            let cos = (0.5 + 0.5 * self.cos).sqrt();
            Self { sin: 0.5 * self.sin / cos, cos }
        } else {
            let sin = (0.5 - 0.5 * self.cos).sqrt();
            Self { sin, cos: 0.5 * self.sin / sin }
        }
    }

    /// Twice the sine of half the angle: the distance between two unit vectors at this angle.
    pub(super) fn chord(self) -> f64 {
        2.0 * self.half().sin
    }

    /// The smaller of two angles.
    #[must_use]
    pub(super) fn min(self, other: Self) -> Self {
        if self.cos >= other.cos { self } else { other }
    }

    /// The larger of two angles.
    #[must_use]
    pub(super) fn max(self, other: Self) -> Self {
        if self.cos <= other.cos { self } else { other }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Frame;
    use crate::rng::{Purpose, Stream};
    use crate::warp;

    fn radians(a: Angle) -> f64 {
        a.sin.atan2(a.cos)
    }

    fn angle(radians: f64) -> Angle {
        Angle { sin: radians.sin(), cos: radians.cos() }
    }

    const ANGLES: [f64; 9] = [0.0, 1e-9, 1e-6, 1e-3, 0.4, 1.5, 1.6, 3.0, 3.13];

    #[test]
    fn sums_and_differences_stop_at_the_ends() {
        for a in ANGLES {
            for b in ANGLES {
                let sum = radians(angle(a).plus(angle(b)));
                assert!((sum - (a + b).min(std::f64::consts::PI)).abs() < 1e-15, "{a} + {b}: {sum}");
                // Angles between rounded vectors have such common factors.
                let (x, y) = (angle(a), angle(b));
                let x = Angle { sin: x.sin * 1.000_001, cos: x.cos * 1.000_001 };
                let difference = radians(x.minus(y));
                assert!((difference - (a - b).max(0.0)).abs() < 1e-15, "{a} - {b}: {difference}");
            }
        }
    }

    #[test]
    fn halves_and_chords_keep_small_angles() {
        for a in ANGLES {
            assert!((radians(angle(a).half()) - 0.5 * a).abs() <= 1e-15 * a, "{a}");
            assert!((angle(a).chord() - 2.0 * (0.5 * a).sin()).abs() <= 1e-15 * a, "{a}");
            // The other end: angles near π, whose half has a small cosine.
            let small = angle(std::f64::consts::PI - a).half().cos;
            assert!((small - (0.5 * a).sin()).abs() <= 1e-15 + 1e-7 * a, "{a}");
        }
    }

    /// Rows of frames are orthonormal to 5·10⁻⁷, as [`TURN`] assumes.
    #[test]
    fn frames_are_as_orthonormal_as_turn_allows() {
        let mut s = Stream::new(34, Purpose::Test, 0);
        for _ in 0..100_000 {
            let f = Frame::about(warp::sphere(s.uniform_2()).normalize());
            let rows = [f.t, f.b, f.n].map(|v| v.as_dvec3());
            let mut squares = 0.0;
            for (i, a) in rows.iter().enumerate() {
                for (j, b) in rows.iter().enumerate() {
                    let error = a.dot(*b) - f64::from(u8::from(i == j));
                    squares += error * error;
                }
            }
            // Half of F Fᵀ − 1 is the stretch by F. Its norm is at most the root of its sum of
            // squares.
            assert!(0.5 * squares.sqrt() < 5e-7, "{f:?}: {squares:e}");
        }
    }
}
