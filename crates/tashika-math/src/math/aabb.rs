//! Axis-aligned boxes.

use glam::{Affine3A, Vec3};

/// An axis-aligned box `[lo, hi]` (m). Empty if `lo > hi` in any component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest corner.
    pub lo: Vec3,
    /// Largest corner.
    pub hi: Vec3,
}

impl Aabb {
    /// The box that holds nothing; the neutral element of [`Aabb::union`].
    pub const EMPTY: Self = Self { lo: Vec3::INFINITY, hi: Vec3::NEG_INFINITY };

    /// The smallest box around `points`; [`Aabb::EMPTY`] if there are none.
    pub fn of_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::with_point)
    }

    /// The smallest box around `self` and `p`.
    #[must_use]
    #[inline]
    pub fn with_point(self, p: Vec3) -> Self {
        Self { lo: self.lo.min(p), hi: self.hi.max(p) }
    }

    /// The smallest box around both.
    #[must_use]
    #[inline]
    pub fn union(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// Returns true if the box holds no point.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.lo.cmpgt(self.hi).any()
    }

    /// Centre of the box (m).
    #[inline]
    pub fn center(&self) -> Vec3 {
        0.5 * self.lo + 0.5 * self.hi
    }

    /// Edge lengths (m); zero for an empty box.
    #[inline]
    pub fn size(&self) -> Vec3 {
        (self.hi - self.lo).max(Vec3::ZERO)
    }

    /// Length of the diagonal (m); zero for an empty box.
    #[inline]
    pub fn diagonal(&self) -> f32 {
        if self.is_empty() { 0.0 } else { (self.hi - self.lo).length() }
    }

    /// The smallest box around the eight transformed corners; empty stays empty.
    #[must_use]
    #[inline]
    pub fn transformed(&self, m: &Affine3A) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        Self::of_points((0..8).map(|k| {
            let corner = Vec3::select(glam::BVec3::new(k & 1 != 0, k & 2 != 0, k & 4 != 0), self.hi, self.lo);
            m.transform_point3(corner)
        }))
    }

    /// Returns true if `p` lies in the closed box.
    #[inline]
    pub fn contains(&self, p: Vec3) -> bool {
        self.lo.cmple(p).all() && p.cmple(self.hi).all()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn union_with_empty_changes_nothing() {
        let b = Aabb { lo: Vec3::new(-1.0, 0.0, 2.0), hi: Vec3::new(1.0, 3.0, 5.0) };
        assert_eq!(b.union(Aabb::EMPTY), b);
        assert!(Aabb::EMPTY.is_empty() && !b.is_empty());
        assert_eq!(Aabb::EMPTY.diagonal(), 0.0);
        assert!(b.contains(b.center()) && !b.contains(Vec3::new(1.1, 0.0, 2.0)));
    }
}
