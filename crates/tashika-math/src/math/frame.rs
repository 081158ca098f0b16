//! Orthonormal frames around a direction.

use glam::Vec3;

/// A right-handed orthonormal frame whose third axis is `n`.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// First tangent.
    pub t: Vec3,
    /// Second tangent.
    pub b: Vec3,
    /// The third axis, around which the frame was built.
    pub n: Vec3,
}

impl Frame {
    /// A frame around the unit vector `n`, without branches on its direction (Duff et al. 2017).
    #[inline]
    pub fn about(n: Vec3) -> Self {
        let sign = 1.0_f32.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Self {
            t: Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            b: Vec3::new(b, sign + n.y * n.y * a, -n.y),
            n,
        }
    }

    /// A frame around the unit vector `n` whose first axis is `direction` made orthogonal to `n`;
    /// the frame of [`Frame::about`] if `direction` is parallel to `n`.
    #[inline]
    pub fn along(n: Vec3, direction: Vec3) -> Self {
        let t = direction - n * n.dot(direction);
        if t.length_squared() <= 1e-12 * direction.length_squared() {
            return Self::about(n);
        }
        let t = t.normalize();
        // Removes the component along `n` that rounding leaves for nearly parallel directions.
        let t = (t - n * n.dot(t)).normalize();
        Self { t, b: n.cross(t), n }
    }

    /// World direction to local coordinates.
    #[inline]
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.t), v.dot(self.b), v.dot(self.n))
    }

    /// Local coordinates to world direction.
    #[inline]
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.t * v.x + self.b * v.y + self.n * v.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_in_every_octant_and_at_the_poles() {
        for v in [[1.0, 2.0, 3.0], [-1.0, 0.5, -2.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1e-4, -1e-4, -1.0]]
        {
            let n = Vec3::from(v).normalize();
            let f = Frame::about(n);
            assert!(f.t.dot(f.b).abs() < 1e-6 && f.t.dot(f.n).abs() < 1e-6 && f.b.dot(f.n).abs() < 1e-6);
            assert!((f.t.cross(f.b) - f.n).length() < 1e-6, "right-handed");
            let w = Vec3::new(0.3, -0.2, 0.9);
            assert!((f.to_local(f.to_world(w)) - w).length() < 1e-6);
            // An arbitrary direction; one that is nearly parallel to the normal and longer; the
            // normal itself; and zero.
            for direction in [w, 1e3 * (n + 2e-6 * f.b), n, Vec3::ZERO] {
                let f = Frame::along(n, direction);
                assert!(f.t.dot(f.b).abs() < 1e-6 && f.t.dot(f.n).abs() < 1e-6 && f.b.dot(f.n).abs() < 1e-6);
                assert!((f.t.length() - 1.0).abs() < 1e-6 && (f.t.cross(f.b) - f.n).length() < 1e-6);
            }
            let f = Frame::along(n, w);
            assert!(f.to_local(w).y.abs() < 1e-6 && f.to_local(w).x > 0.0, "in the plane of both");
        }
    }
}
