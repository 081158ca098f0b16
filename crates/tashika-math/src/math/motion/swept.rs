//! Boxes around moving objects.
//!
//! Between two keys a point `v` of an object is at
//!
//! ```text
//! x(u) = T(u) + R(u) S(u) v        T, S linear in u, R turning at a constant ω (rad per unit of u)
//! ‖x''(u)‖ ≤ ω² ‖S v‖ + 2 ω ‖S₁ v − S₀ v‖
//! ```
//!
//! Consider a part of the time, of length `h` in `u`. Along any axis, the point is then no further
//! than `h²/8 · max ‖x''‖` from the chord between its positions at the two ends. So the union of
//! the boxes at both ends, grown by that distance, contains the point at all times in between.
//! `‖S v‖` and `‖S₁ v − S₀ v‖` are convex in `v`, so both are largest at corners of the object's
//! box. `‖S v‖` is also convex in `u`, so it is largest at a key. `x` is affine in `v`, so a box
//! around the positions of the corners contains the whole object.
//!
//! If matrices were interpolated entry by entry, the boxes at both ends would suffice. A rotation
//! leaves them: if the two ends are a third of a turn apart, the arc rises above its chord by half
//! the radius.
//!
//! # Guarantee
//! The box contains every point of the object at every time, whether its position is computed in
//! `f64` or in `f32`.
//!
//! # Held to this by
//! The tests below.

use glam::{DVec3, Vec3};

use super::Track;
use crate::math::{Aabb, GAMMA_4};

/// Largest rotation between two examined times (radians); chosen: the box grows by a thousandth of
/// the radius.
const STEP: f64 = 0.1;

/// Bound of the rounding error of a position, relative to the largest sum of absolute terms. It
/// covers the rounding of the map to `f32`, and its application forwards and backwards.
const ROUNDING: f64 = 4.0 * GAMMA_4 as f64;

/// A box while it grows, in `f64`.
struct Growing {
    lo: DVec3,
    hi: DVec3,
    /// Largest sum of absolute terms of a coordinate.
    terms: f64,
}

impl Track {
    /// A box (m) around all positions, between two times (s), of an object inside `around`; empty
    /// stays empty.
    pub fn swept(&self, around: &Aabb, [from, to]: [f64; 2]) -> Aabb {
        if around.is_empty() {
            return Aabb::EMPTY;
        }
        let corners: [DVec3; 8] = std::array::from_fn(|k| {
            let pick = |axis: usize| if k >> axis & 1 == 0 { around.lo[axis] } else { around.hi[axis] };
            Vec3::new(pick(0), pick(1), pick(2)).as_dvec3()
        });
        let mut all = Growing { lo: DVec3::INFINITY, hi: DVec3::NEG_INFINITY, terms: 0.0 };
        for seconds in [from, to] {
            all.hold(self, seconds, &corners, 0.0);
        }
        for pair in self.keys.windows(2) {
            let [before, after] = pair else { unreachable!("windows of two") };
            let (begin, end) = (before.seconds.max(from), after.seconds.min(to));
            if begin > end || before.map == after.map {
                continue;
            }
            let whole = after.seconds - before.seconds;
            let turn = 2.0 * super::arc_between(before.parts.rotation, after.parts.rotation);
            let from_centre = corners.map(|v| v + self.about);
            let length = |v: DVec3| [before, after].map(|key| (key.parts.stretch * v).length());
            let stretched = from_centre.iter().flat_map(|&v| length(v)).fold(0.0, f64::max);
            let change = after.parts.stretch - before.parts.stretch;
            let changed = from_centre.iter().map(|&v| (change * v).length()).fold(0.0, f64::max);
            let bend = turn * turn * stretched + 2.0 * turn * changed;
            let share = (end - begin) / whole;
            let steps = (turn * share / STEP).ceil().max(1.0);
            let h = share / steps;
            for k in 0..=steps as u32 {
                let seconds = begin + f64::from(k) / steps * (end - begin);
                all.hold(self, seconds, &corners, 0.125 * h * h * bend);
            }
        }
        let margin = all.terms * ROUNDING;
        let outward = |v: DVec3, to: fn(f32) -> f32| Vec3::from_array(v.as_vec3().to_array().map(to));
        Aabb { lo: outward(all.lo - margin, f32::next_down), hi: outward(all.hi + margin, f32::next_up) }
    }
}

impl Growing {
    /// Adds the corners at a time, with a margin of `bulge` along each axis.
    fn hold(&mut self, track: &Track, seconds: f64, corners: &[DVec3; 8], bulge: f64) {
        let map = track.at(seconds);
        let [x, y, z] = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis].map(DVec3::abs);
        for &v in corners {
            let place = map.transform_point3(v);
            self.lo = self.lo.min(place - bulge);
            self.hi = self.hi.max(place + bulge);
            let a = v.abs();
            let terms = x * a.x + y * a.y + z * a.z + map.translation.abs();
            self.terms = self.terms.max(terms.max_element() + bulge);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DMat3, DQuat};

    use super::*;
    use crate::math::elementary::sin_cos_f64;
    use crate::rng::{Purpose, Stream};

    fn quaternion(axis: DVec3, angle: f64) -> DQuat {
        let (sin, cos) = sin_cos_f64(0.5 * angle);
        let v = axis.normalize() * sin;
        DQuat::from_xyzw(v.x, v.y, v.z, cos)
    }

    /// Random objects that rotate by up to half a turn between keys, shear and grow; some are only
    /// translated, so that the margin covers nothing but rounding. The shutter may open and close
    /// between keys or beyond them. No position at any time is outside the box.
    #[test]
    fn nothing_ever_leaves_its_box() {
        let mut s = Stream::new(1, Purpose::Test, 7);
        for trial in 0..300 {
            let mut number = |scale: f64| scale * (2.0 * f64::from(s.uniform()) - 1.0);
            let mut vector = |scale: f64| DVec3::new(number(scale), number(scale), number(scale));
            let (a, b) = (vector(2.0).as_vec3(), vector(2.0).as_vec3());
            let around = Aabb { lo: a.min(b), hi: a.max(b) };
            let mut keys: Vec<_> = (0..3)
                .map(|k| {
                    let stretch = DMat3::from_diagonal(DVec3::ONE * 1.2 + vector(1.0));
                    let other = DMat3::from_quat(quaternion(vector(1.0), vector(3.0).x));
                    let turn = DMat3::from_quat(quaternion(vector(1.0), vector(3.1).x));
                    let matrix3 = turn * other * stretch * other.transpose();
                    (f64::from(k), DAffine3 { matrix3, translation: vector(5.0) })
                })
                .collect();
            if trial % 4 == 0 {
                let matrix3 = keys[0].1.matrix3;
                keys.iter_mut().for_each(|(_, map)| map.matrix3 = matrix3);
            }
            let track =
                Track::new(keys).unwrap().about(if trial % 5 == 0 { vector(9.0) } else { DVec3::ZERO });
            let shutter = match trial % 3 {
                0 => [0.0, 2.0],
                1 => [0.3, 1.6],
                _ => [-1.0, 0.1],
            };
            let swept = track.swept(&around, shutter);
            for _ in 0..200 {
                let [x, y, z] = s.uniform_3();
                // Translated objects touch the faces of their boxes when the shutter opens and
                // closes.
                let share = if trial % 4 == 0 { s.uniform().round() } else { s.uniform() };
                let seconds = shutter[0] + f64::from(share) * (shutter[1] - shutter[0]);
                let v = around.lo + Vec3::new(x, y, z).round() * (around.hi - around.lo);
                let exact = track.at(seconds).transform_point3(v.as_dvec3());
                let rounded = track.at(seconds).as_affine3a().transform_point3(v);
                let holds = swept.lo.as_dvec3().cmple(exact).all() && exact.cmple(swept.hi.as_dvec3()).all();
                assert!(holds && swept.contains(rounded), "{trial}: {exact} outside of {swept:?}");
            }
        }
    }

    /// A bar of length 2 that rotates by half a turn around its middle sweeps a disk, whose box is
    /// far larger than the boxes at both ends. A bar that is only translated sweeps the hull of
    /// these two boxes.
    #[test]
    fn the_box_is_tight() {
        let bar = Aabb { lo: Vec3::new(-1.0, -0.01, -0.01), hi: Vec3::new(1.0, 0.01, 0.01) };
        let map = |angle: f64, x: f64| DAffine3 {
            matrix3: DMat3::from_quat(quaternion(DVec3::Z, angle)),
            translation: DVec3::X * x,
        };
        let turns = Track::new([(0.0, map(0.0, 0.0)), (1.0, map(3.1, 0.0))]).unwrap();
        let swept = turns.swept(&bar, [0.0, 1.0]);
        assert!(swept.hi.y > 1.0 && swept.hi.y < 1.003, "{swept:?}");
        assert!(swept.lo.x < -1.0 && swept.lo.x > -1.003, "{swept:?}");
        // In a sixth of the time the bar rotates by a sixth of the angle.
        let part = turns.swept(&bar, [0.0, 1.0 / 6.0]);
        let expected = sin_cos_f64(3.1 / 6.0).0;
        assert!((f64::from(part.hi.y) - expected).abs() < 0.015, "{part:?} for {expected}");
        let pushed = Track::new([(0.0, map(0.3, 0.0)), (1.0, map(0.3, 4.0))]).unwrap();
        let ends = [0.0, 1.0].map(|t| bar.transformed(&pushed.at(t).as_affine3a()));
        let swept = pushed.swept(&bar, [0.0, 1.0]);
        let hull = ends[0].union(ends[1]);
        assert!((swept.lo - hull.lo).abs().max_element() < 1e-4, "{swept:?} for {hull:?}");
        assert!((swept.hi - hull.hi).abs().max_element() < 1e-4, "{swept:?} for {hull:?}");
        assert!(pushed.swept(&Aabb::EMPTY, [0.0, 1.0]).is_empty());
    }
}
