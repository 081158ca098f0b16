//! Rays.

use glam::Vec3;

/// A half-line `origin + t · direction`, `0 < t < t_max`.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Start (m). If it lies on a surface it has already been moved off it, see
    /// [`offset_from_surface`](super::offset_from_surface).
    pub origin: Vec3,
    /// Direction, not necessarily of unit length; `t` is in units of its length.
    pub direction: Vec3,
    /// Hits at or beyond this parameter are ignored.
    pub t_max: f32,
}

impl Ray {
    /// An unbounded ray.
    #[inline]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_max: f32::INFINITY }
    }

    /// The point at parameter `t` (m).
    #[inline]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}
