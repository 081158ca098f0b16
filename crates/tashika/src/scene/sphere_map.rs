//! How the sphere of directions is laid out in an image: for environments and for lights.

use std::f32::consts::PI;

use glam::Vec3;

use super::Wrap;
use crate::math::elementary::{atan2, sin_cos};

/// The solid angle of a texel at the poles does not quite vanish.
const SMALLEST_SINE: f32 = 1e-5;

/// How the sphere is laid out in an image.
///
/// | layout | frame | texel `(u, v)`, `v` from the top row |
/// |---|---|---|
/// | latitude-longitude | pole `+y` | polar angle `θ = π v`, azimuth `2π u`; `u = 0.5` looks along `−z`, `u = 0.75` along `+x` |
/// | octahedral | pole `+z` | equal areas (Clarberg 2008): the centre is `+z`, the corners `−z`, `+x` at `u = 1`, `+y` at `v = 1` |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mapping {
    LatLong,
    Octahedral,
}

impl Mapping {
    /// How the image goes on beyond its sides and beyond its top and bottom.
    pub(super) fn wrap(self) -> [Wrap; 2] {
        match self {
            Self::LatLong => [Wrap::Repeat, Wrap::Clamp],
            Self::Octahedral => [Wrap::Clamp; 2],
        }
    }

    /// Solid angle of the texels of a row of `rows`, up to a factor.
    pub(super) fn size_of_row(self, row: usize, rows: usize) -> f64 {
        match self {
            Self::LatLong => f64::from(sin_cos(PI * (row as f32 + 0.5) / rows as f32).0),
            Self::Octahedral => 1.0,
        }
    }

    /// The place of a unit direction, in the frame of the image.
    pub(super) fn place(self, d: Vec3) -> [f32; 2] {
        match self {
            Self::LatLong => {
                let u = atan2(d.x, -d.z) / (2.0 * PI) + 0.5;
                // Near the poles the arc cosine of a rounded cosine would be noise.
                [u.rem_euclid(1.0), atan2(horizontal(d), d.y) / PI]
            }
            Self::Octahedral => {
                let (x, y) = (d.x.abs(), d.y.abs());
                // √(1 − |z|) without its cancellation.
                let r = ((x * x + y * y) / (1.0 + d.z.abs())).sqrt();
                let along = atan2(y, x) * (2.0 / PI);
                let (mut u, mut v) = (r * (1.0 - along), r * along);
                if d.z < 0.0 {
                    (u, v) = (1.0 - v, 1.0 - u);
                }
                [0.5 + 0.5 * u.copysign(d.x), 0.5 + 0.5 * v.copysign(d.y)].map(|c| c.clamp(0.0, 1.0))
            }
        }
    }

    /// The unit direction of a place.
    pub(super) fn direction(self, [u, v]: [f32; 2]) -> Vec3 {
        match self {
            Self::LatLong => {
                let (sin_theta, cos_theta) = sin_cos(PI * v);
                let sin_theta = sin_theta.max(SMALLEST_SINE);
                let (sin_phi, cos_phi) = sin_cos(2.0 * PI * (u - 0.5));
                Vec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)
            }
            Self::Octahedral => {
                let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
                let inside = 1.0 - (x.abs() + y.abs());
                let r = 1.0 - inside.abs();
                // Within the square's half of this octant, or folded over its diagonal.
                let (a, b) = if inside >= 0.0 { (x.abs(), y.abs()) } else { (1.0 - y.abs(), 1.0 - x.abs()) };
                let along = if r > 0.0 { b / (a + b) } else { 0.0 };
                let (sin, cos) = sin_cos(0.5 * PI * along);
                let ring = r * (2.0 - r * r).max(0.0).sqrt();
                let z = (1.0 - r * r).copysign(inside);
                Vec3::new((ring * cos).copysign(x), (ring * sin).copysign(y), z)
            }
        }
    }

    /// Solid angle of the sphere over the area of the image, at a direction (sr).
    pub(super) fn solid_angle(self, d: Vec3) -> f32 {
        match self {
            Self::LatLong => 2.0 * PI * PI * horizontal(d).max(SMALLEST_SINE),
            Self::Octahedral => 4.0 * PI,
        }
    }
}

/// Distance from the polar axis.
fn horizontal(d: Vec3) -> f32 {
    (d.x * d.x + d.z * d.z).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    #[test]
    fn places_and_directions_are_each_others_inverse() {
        let mut s = Stream::new(7, Purpose::Test, 0);
        for mapping in [Mapping::LatLong, Mapping::Octahedral] {
            for _ in 0..10_000 {
                let d = crate::warp::sphere(s.uniform_2());
                let back = mapping.direction(mapping.place(d));
                assert!((back - d).length() < 2e-6, "{mapping:?}: {d} {back}");
            }
            for d in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z] {
                let back = mapping.direction(mapping.place(d));
                assert!((back - d).length() < 2e-5, "{mapping:?}: {d} {back}");
            }
        }
    }

    #[test]
    fn the_octahedral_square_has_its_axes_where_the_convention_says() {
        let place = |d| Mapping::Octahedral.place(d);
        let near = |a: [f32; 2], b: [f32; 2]| (a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 1e-6;
        assert!(near(place(Vec3::Z), [0.5, 0.5]) && near(place(Vec3::X), [1.0, 0.5]));
        assert!(near(place(Vec3::Y), [0.5, 1.0]) && near(place(-Vec3::X), [0.0, 0.5]));
        // Equal areas: the upper hemisphere is the inner diamond, and 60° about the pole a half of it.
        let diagonal = Vec3::new(0.5f32.sqrt() * 0.75f32.sqrt(), 0.5f32.sqrt() * 0.75f32.sqrt(), 0.5);
        let [u, v] = place(diagonal);
        assert!(((2.0 * u - 1.0 + 2.0 * v - 1.0) - 0.5f32.sqrt()).abs() < 1e-6);
    }
}
