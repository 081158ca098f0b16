//! Affine maps at keys of time, and their interpolation.
//!
//! A map is decomposed into `T · R · S`: a translation, a rotation and a symmetric stretch, by the
//! polar decomposition of its linear part. The parts are interpolated and multiplied again
//! (Shoemake and Duff 1992):
//!
//! ```text
//! T = (1 − u) T₀ + u T₁     R = turned_between(R₀, R₁, u)     S = (1 − u) S₀ + u S₁     u = (t − t₀)/(t₁ − t₀)
//! turned_between(q₀, q₁, u) = (sin((1 − u) θ) q₀ + sin(u θ) q₁) / sin θ                 cos θ = q₀ · q₁ ≥ 0
//! ```
//!
//! with the sign of `q₁` for which the rotation takes the shorter way (Shoemake 1985). `R` is the
//! limit of `R ← (R + R⁻ᵀ)/2`, starting from the linear part. If the linear part mirrors, `−R` is
//! the rotation and `−S` the stretch. pbrt moves objects in this way (Pharr et al. 2016, section
//! 2.9); motions that consist of rotations and translations stay rigid.
//!
//! # Guarantee
//! At a key, [`Track::at`] returns the map of that key, bit for bit; before the first key it
//! returns the first map, after the last key the last. The bits are the same on every machine.
//!
//! # Held to this by
//! The tests below.

mod swept;

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::elementary::{atan2_f64, sin_cos_f64};

/// Largest number of steps of the polar decomposition. A step halves stretches that are far above
/// 1, and squares the error once it is below 1.
const MOST_STEPS: usize = 100;

/// An affine map in parts, applied in the order stretch, rotation, translation.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Parts {
    translation: DVec3,
    rotation: DQuat,
    stretch: DMat3,
}

impl Parts {
    /// Decomposes a map; `None` if it cannot be inverted, or is not finite.
    fn of(map: &DAffine3) -> Option<Self> {
        let linear = map.matrix3;
        let mut r = linear;
        for _ in 0..MOST_STEPS {
            let next = (r + r.inverse().transpose()) * 0.5;
            if !next.is_finite() || r.determinant() == 0.0 {
                return None;
            }
            let step = next - r;
            r = next;
            let change = step.to_cols_array().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            if change < 1e-14 {
                break;
            }
        }
        let r = if r.determinant() < 0.0 { r * -1.0 } else { r };
        let stretch = r.transpose() * linear;
        let rotation = DQuat::from_mat3(&r).normalize();
        let parts = Self { translation: map.translation, rotation, stretch };
        (map.is_finite() && rotation.is_finite() && stretch.is_finite()).then_some(parts)
    }

    /// Interpolates between this map, at `u = 0`, and another, at `u = 1`.
    fn towards(&self, other: &Self, u: f64) -> DAffine3 {
        let rotation = turned_between(self.rotation, other.rotation, u);
        DAffine3 {
            matrix3: DMat3::from_quat(rotation) * (self.stretch * (1.0 - u) + other.stretch * u),
            translation: self.translation.lerp(other.translation, u),
        }
    }
}

/// Interpolates between two unit quaternions, by the shorter way and at constant speed.
pub fn turned_between(from: DQuat, to: DQuat, u: f64) -> DQuat {
    let to = if from.dot(to) < 0.0 { -to } else { to };
    let angle = arc_between(from, to);
    let (a, b) = (sin_cos_f64((1.0 - u) * angle).0, sin_cos_f64(u * angle).0);
    // For nearly equal rotations, the quotients `0/0` are replaced by linear weights.
    let (a, b) = if angle < 1e-9 { (1.0 - u, u) } else { (a, b) };
    (from * a + to * b).normalize()
}

/// The angle between two unit quaternions on the shorter way (radians): half the angle of the
/// rotation from one to the other.
fn arc_between(from: DQuat, to: DQuat) -> f64 {
    let to = if from.dot(to) < 0.0 { -to } else { to };
    // Both lengths are precise for angles of any size; the arc cosine is not.
    2.0 * atan2_f64((to - from).length(), (to + from).length())
}

/// A map that changes with time.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    keys: Vec<Key>,
    /// Origin that the coordinates before the map are relative to (m).
    about: DVec3,
}

#[derive(Clone, Debug, PartialEq)]
struct Key {
    seconds: f64,
    map: DAffine3,
    parts: Parts,
}

impl Track {
    /// Track of maps at times (s), in any order; of two maps at one time the last one counts.
    ///
    /// `None` without maps, if a time is not finite, or if a map cannot be inverted.
    pub fn new(keys: impl IntoIterator<Item = (f64, DAffine3)>) -> Option<Self> {
        let key = |(seconds, map): (f64, DAffine3)| {
            let parts = Parts::of(&map).filter(|_| seconds.is_finite())?;
            Some(Key { seconds, map, parts })
        };
        let mut keys = keys.into_iter().map(key).collect::<Option<Vec<_>>>()?;
        keys.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        keys.dedup_by(|later, earlier| {
            let same = later.seconds == earlier.seconds;
            if same {
                std::mem::swap(later, earlier);
            }
            same
        });
        (!keys.is_empty()).then_some(Self { keys, about: DVec3::ZERO })
    }

    /// The map at a time (s): the first one before the first key, the last one after the last key.
    pub fn at(&self, seconds: f64) -> DAffine3 {
        self.placed(self.between_keys(seconds))
    }

    fn between_keys(&self, seconds: f64) -> DAffine3 {
        let after = self.keys.partition_point(|key| key.seconds <= seconds);
        let Some(before) = after.checked_sub(1) else { return self.keys[0].map };
        let before = &self.keys[before];
        match self.keys.get(after) {
            Some(after) if before.seconds < seconds && before.map != after.map => {
                let u = (seconds - before.seconds) / (after.seconds - before.seconds);
                before.parts.towards(&after.parts, u)
            }
            _ => before.map,
        }
    }

    /// Returns the map of coordinates relative to [`Self::about`].
    fn placed(&self, map: DAffine3) -> DAffine3 {
        // Returned bit for bit for a zero origin: adding zero could change the sign of a zero.
        if self.about == DVec3::ZERO {
            return map;
        }
        DAffine3 { translation: map.transform_point3(self.about), ..map }
    }

    /// The track of `map · first`: the constant map `first` is applied first.
    ///
    /// `None` if a product cannot be inverted.
    pub fn after(&self, first: DAffine3) -> Option<Self> {
        Self::new(self.keys.iter().map(|key| (key.seconds, self.placed(key.map) * first)))
    }

    /// Returns the motion of objects whose coordinates are relative to `origin` (m, before the
    /// map). Unlike [`Self::after`] with a translation, it keeps the centres of rotation between
    /// keys.
    #[must_use]
    pub fn about(self, origin: DVec3) -> Self {
        Self { about: self.about + origin, ..self }
    }

    /// Returns the motion in coordinates relative to `origin` (m, after the map).
    #[must_use]
    pub fn relative_to(mut self, origin: DVec3) -> Self {
        for key in &mut self.keys {
            key.map.translation -= origin;
            key.parts.translation -= origin;
        }
        self
    }

    /// Returns true if there is only one key: the map is then constant.
    #[inline]
    pub fn is_still(&self) -> bool {
        self.keys.len() == 1
    }

    /// Memory of the keys (bytes).
    pub fn bytes(&self) -> u64 {
        size_of_val(&self.keys[..]) as u64
    }

    /// The times of the first and the last key (s).
    pub fn span(&self) -> [f64; 2] {
        [self.keys[0].seconds, self.keys[self.keys.len() - 1].seconds]
    }

    /// Returns true if the map changes between these times (s).
    pub fn moves_between(&self, [from, to]: [f64; 2]) -> bool {
        let first = self.at(from);
        let between = self.keys.iter().filter(|key| from < key.seconds && key.seconds < to);
        self.at(to) != first || between.into_iter().any(|key| self.placed(key.map) != first)
    }

    /// Returns true if all maps, at any time, and their inverses are finite in single precision.
    ///
    /// The stretches of two neighbouring keys are definite matrices. If the map [keeps
    /// sides](Self::keeps_sides), both are positive, or both are negative. The stretch between the
    /// keys is their linear interpolation. The least absolute value of its eigenvalues is concave
    /// in time, so it is no smaller than at the worse of the two keys. Hence no inverse between
    /// keys is larger than the largest inverse at a key.
    pub fn can_place(&self) -> bool {
        let norm = |m: &DMat3| m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
        let most = |f: &dyn Fn(&Key) -> f64| self.keys.iter().map(f).fold(0.0, f64::max);
        let inverse = most(&|key| norm(&key.map.matrix3.inverse()));
        let linear = most(&|key| norm(&key.map.matrix3));
        let away = most(&|key| key.map.translation.length());
        let largest = inverse.max(linear).max(away).max(inverse * away);
        self.keeps_sides() && largest < f64::from(f32::MAX)
    }

    /// Returns true if the map mirrors space at every key or at no key. Otherwise it is singular at
    /// some time between keys.
    pub fn keeps_sides(&self) -> bool {
        let mirrors = |key: &Key| key.map.matrix3.determinant() < 0.0;
        self.keys.iter().all(|key| mirrors(key) == mirrors(&self.keys[0]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    fn turned(axis: DVec3, angle: f64) -> DMat3 {
        let (sin, cos) = sin_cos_f64(0.5 * angle);
        let v = axis.normalize() * sin;
        DMat3::from_quat(DQuat::from_xyzw(v.x, v.y, v.z, cos))
    }

    #[test]
    fn a_turn_goes_on_at_constant_speed_by_the_shorter_way() {
        let axis = DVec3::new(1.0, -2.0, 0.5);
        // A quaternion and its negative represent the same rotation.
        for sign in [1.0, -1.0] {
            for angle in [1e-12, 1e-4, 1.0, 3.0] {
                let quat = |a: f64| DQuat::from_mat3(&turned(axis, a));
                for u in [0.0, 0.1, 0.5, 0.9, 1.0] {
                    let between = turned_between(quat(0.3), quat(0.3 + angle) * sign, u);
                    let expected = quat(0.3 + u * angle);
                    assert!(between.dot(expected).abs() > 1.0 - 1e-15, "{angle} {u}");
                }
            }
        }
    }

    #[test]
    fn maps_are_taken_apart_and_put_together_again() {
        let mut s = Stream::new(1, Purpose::Test, 0);
        for i in 0..200 {
            let mut number = || 6.0 * f64::from(s.uniform()) - 3.0;
            let mut column = || DVec3::new(number(), number(), number());
            let linear = DMat3::from_cols(column(), column(), column());
            let map = DAffine3 { matrix3: linear, translation: column() };
            let parts = Parts::of(&map).unwrap();
            let again = parts.towards(&parts, 0.5);
            assert!(again.abs_diff_eq(map, 1e-10), "{i}: {map:?} {again:?}");
            assert!(parts.stretch.abs_diff_eq(parts.stretch.transpose(), 1e-10), "a symmetric stretch");
        }
        let huge = DAffine3::from_scale(DVec3::new(1e12, -1e-9, 1.0));
        assert!(Parts::of(&huge).unwrap().stretch.abs_diff_eq(huge.matrix3 * -1.0, 1e-3));
        for flat in [DVec3::new(1.0, 0.0, 1.0), DVec3::splat(f64::NAN), DVec3::splat(f64::INFINITY)] {
            assert!(Parts::of(&DAffine3::from_scale(flat)).is_none());
        }
    }

    #[test]
    fn between_keys_turns_stay_rigid_and_stretches_go_straight() {
        let map = |angle, scale: f64, x| DAffine3 {
            matrix3: turned(DVec3::Y, angle) * scale,
            translation: DVec3::new(x, 1.0, 0.0),
        };
        let track = Track::new([(4.0, map(2.0, 3.0, 5.0)), (2.0, map(0.0, 1.0, 1.0))]).unwrap();
        assert_eq!(track.span(), [2.0, 4.0]);
        assert!(track.at(2.5).abs_diff_eq(map(0.5, 1.5, 2.0), 1e-12));
        assert_eq!(track.at(2.0), map(0.0, 1.0, 1.0), "bit for bit");
        assert_eq!(track.at(-7.0), map(0.0, 1.0, 1.0));
        assert_eq!(track.at(4.0), map(2.0, 3.0, 5.0));
        assert_eq!(track.at(f64::INFINITY), map(2.0, 3.0, 5.0));
        // Both keys mirror, and the second is rotated by 2 rad: the map in between mirrors too, and
        // is rotated by the share of the angle.
        let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
        let mirrored = |angle| DAffine3 { matrix3: turned(DVec3::Y, angle) * mirror, ..DAffine3::IDENTITY };
        let track = Track::new([(0.0, mirrored(0.0)), (1.0, mirrored(2.0))]).unwrap();
        assert!(track.at(0.25).abs_diff_eq(mirrored(0.5), 1e-12), "{:?}", track.at(0.25));
    }

    /// Interpolation between a mirrored and an unmirrored key passes through a singular map.
    #[test]
    fn maps_on_the_way_can_be_inverted_where_no_key_mirrors_alone() {
        let map = |angle, scale| DAffine3 {
            matrix3: turned(DVec3::new(1.0, 1.0, 0.0), angle) * DMat3::from_diagonal(scale),
            ..DAffine3::IDENTITY
        };
        let (one, mirror) = (DVec3::new(1.0, 2.0, 0.1), DVec3::new(-1.0, 2.0, 0.1));
        for (ends, keeps) in [([one, one], true), ([mirror, mirror], true), ([one, mirror], false)] {
            let track = Track::new([(0.0, map(0.0, ends[0])), (1.0, map(3.0, ends[1]))]).unwrap();
            assert_eq!((track.keeps_sides(), track.can_place()), (keeps, keeps));
            let least = (0..=100).map(|k| track.at(f64::from(k) / 100.0).matrix3.determinant().abs());
            let least = least.fold(f64::INFINITY, f64::min);
            assert_eq!(least > 0.1, keeps, "{least}");
        }
        for scale in [1e-39, 1e39] {
            let keys = [(0.0, map(0.0, one)), (1.0, map(1.0, one * scale))];
            assert!(!Track::new(keys).unwrap().can_place(), "{scale} is none of single precision");
        }
        let turn = DAffine3::from_mat3(turned(DVec3::X, 1.0) * -1.0);
        let track = Track::new([(0.0, map(0.0, one)), (1.0, map(2.0, mirror * -1.0))]).unwrap();
        let after = track.after(turn).unwrap();
        assert!(after.at(0.3).abs_diff_eq(track.at(0.3) * turn, 1e-12), "what is before it does not matter");
    }

    /// The positions before and after the map are millions of metres from zero. A track with
    /// origins near them gives the same positions.
    #[test]
    fn a_track_about_another_origin_places_things_at_the_same_places() {
        let far = DVec3::new(5e6, -3e6, 1e6);
        let map = |angle: f64, x: f64| {
            let matrix3 =
                turned(DVec3::new(1.0, 1.0, 0.3), angle) * DMat3::from_diagonal(DVec3::new(1.0, 2.0, 0.5));
            DAffine3 { matrix3, translation: DVec3::X * x }
        };
        let track = Track::new([(0.0, map(0.0, 0.0)), (1.0, map(2.0, 4.0)), (2.0, map(2.5, 4.0))]).unwrap();
        let world = track.at(0.4).transform_point3(far).round();
        let moved = track.clone().about(far).relative_to(world);
        for seconds in [-1.0, 0.0, 0.4, 1.0, 1.7] {
            let local = DVec3::new(0.3, 0.1, -0.2);
            let expected = track.at(seconds).transform_point3(far + local) - world;
            let found = moved.at(seconds).transform_point3(local);
            assert!((found - expected).length() < 1e-8, "{seconds}: {found} {expected}");
        }
        assert!(moved.moves_between([0.0, 2.0]) && !moved.moves_between([2.0, 3.0]));
        let still = Track::new([(0.0, map(0.1, 0.0))]).unwrap().about(far);
        assert!(!still.moves_between([0.0, 1.0]));
        assert_eq!(track.clone().about(DVec3::ZERO).at(0.4), track.at(0.4), "bit for bit");
    }

    #[test]
    fn keys_out_of_order_are_sorted_and_the_last_of_a_time_counts() {
        let at = |x: f64| DAffine3::from_translation(DVec3::new(x, 0.0, 0.0));
        let track = Track::new([(1.0, at(9.0)), (0.0, at(0.0)), (1.0, at(2.0))]).unwrap();
        assert_eq!((track.at(0.5), track.at(1.0)), (at(1.0), at(2.0)));
        // The map moves there and back: it is equal at times 0 and 2, but not in between.
        let track = Track::new([(0.0, at(1.0)), (1.0, at(2.0)), (2.0, at(1.0)), (3.0, at(1.0))]).unwrap();
        assert!(track.moves_between([0.0, 2.0]) && track.moves_between([0.5, 0.6]));
        assert!(!track.moves_between([2.0, 9.0]) && !track.moves_between([-1.0, 0.0]));
        assert!(!track.moves_between([0.5, 0.5]));
        assert!(Track::new([]).is_none() && Track::new([(f64::NAN, at(0.0))]).is_none());
    }
}
