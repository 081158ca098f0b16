//! Maps between all directions and a rectangle, for environment maps and spherical cameras.
//!
//! A direction has a place `(u, v)`, `v` from the top:
//!
//! * latitude-longitude, with pole `+y`: polar angle `θ = π v`, azimuth `2π u`; `u = 0.5` looks
//!   along `−z`, `u = 0.75` along `+x`.
//! * equal-area, with pole `+z`: the octahedron of Clarberg 2008. The centre is `+z`, the corners
//!   `−z`, `+x` at `u = 1`, `+y` at `v = 1`.
//!
//! The solid angle of a small part of the rectangle is its area times
//!
//! ```text
//! 2π² sin θ   (latitude-longitude)          4π   (equal-area)          sr
//! ```
//!
//! # Held to this by
//! `tests` (axes, inverses), `scene::environment` (integrals over the sphere), `scene::projection`
//! (areas).

use std::f32::consts::PI;

use glam::Vec3;

use super::Wrap;
use crate::math::elementary::{atan2, sin_cos};

/// A layout of all directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SphereMap {
    /// Rows of equal latitude, columns of equal longitude. If the rectangle is twice as wide as
    /// high, shapes at the horizon are not distorted.
    LatLong,
    /// Equal areas for equal solid angles, in a square.
    EqualArea,
}

/// Lower limit of the sine of the polar angle, so that solid angles at the poles are above zero.
const SMALLEST_SINE: f32 = 1e-5;

impl SphereMap {
    /// Wrapping of an image with this layout beyond its sides, and beyond its top and bottom.
    pub(super) fn wrap(self) -> [Wrap; 2] {
        match self {
            Self::LatLong => [Wrap::Repeat, Wrap::Clamp],
            Self::EqualArea => [Wrap::Clamp; 2],
        }
    }

    /// Solid angle of a texel in row `row` of `rows`, up to a factor that is equal for all rows.
    pub(super) fn size_of_row(self, row: usize, rows: usize) -> f64 {
        match self {
            Self::LatLong => f64::from(sin_cos(PI * (row as f32 + 0.5) / rows as f32).0),
            Self::EqualArea => 1.0,
        }
    }

    /// Returns the place of a unit direction in the frame of the layout.
    pub(super) fn place(self, d: Vec3) -> [f32; 2] {
        match self {
            Self::LatLong => {
                let u = atan2(d.x, -d.z) / (2.0 * PI) + 0.5;
                // The arc tangent is precise near the poles, where the arc cosine of a rounded
                // cosine is not.
                [u.rem_euclid(1.0), atan2(horizontal(d), d.y) / PI]
            }
            Self::EqualArea => {
                let (x, y) = (d.x.abs(), d.y.abs());
                // √(1 − |z|), without a subtraction of nearly equal numbers.
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

    /// Returns the unit direction of a place.
    pub fn direction(self, [u, v]: [f32; 2]) -> Vec3 {
        match self {
            Self::LatLong => {
                let (sin_theta, cos_theta) = sin_cos(PI * v);
                let sin_theta = sin_theta.max(SMALLEST_SINE);
                let (sin_phi, cos_phi) = sin_cos(2.0 * PI * (u - 0.5));
                Vec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)
            }
            Self::EqualArea => {
                let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
                let inside = 1.0 - (x.abs() + y.abs());
                let r = 1.0 - inside.abs();
                // The upper hemisphere is the inner half of each quadrant; the lower hemisphere is
                // folded outwards over the quadrant's diagonal.
                let (a, b) = if inside >= 0.0 { (x.abs(), y.abs()) } else { (1.0 - y.abs(), 1.0 - x.abs()) };
                let along = if r > 0.0 { b / (a + b) } else { 0.0 };
                let (sin, cos) = sin_cos(0.5 * PI * along);
                let ring = r * (2.0 - r * r).max(0.0).sqrt();
                let z = (1.0 - r * r).copysign(inside);
                Vec3::new((ring * cos).copysign(x), (ring * sin).copysign(y), z)
            }
        }
    }

    /// Solid angle per area of the rectangle, whose whole area is 1, at a direction (sr).
    pub(super) fn solid_angle(self, d: Vec3) -> f32 {
        match self {
            Self::LatLong => 2.0 * PI * PI * horizontal(d).max(SMALLEST_SINE),
            Self::EqualArea => 4.0 * PI,
        }
    }

    /// Maps a place a little beyond the edge of the rectangle to the place within it where the
    /// sphere continues.
    pub(super) fn wrapped(self, [mut u, mut v]: [f32; 2]) -> [f32; 2] {
        let beyond = |c: f32| !(0.0..=1.0).contains(&c);
        let mirrored = |c: f32| if c < 0.0 { -c } else { 2.0 - c };
        match self {
            Self::LatLong => {
                // Over a pole, and down on its other side.
                if beyond(v) {
                    (u, v) = (u + 0.5, mirrored(v));
                }
                [u.rem_euclid(1.0), v.clamp(0.0, 1.0)]
            }
            Self::EqualArea => {
                // Each edge is joined to itself: a point of the edge is the same direction as its
                // mirror image about the middle of the edge.
                if beyond(u) {
                    (u, v) = (mirrored(u), 1.0 - v);
                }
                if beyond(v) {
                    (u, v) = (1.0 - u, mirrored(v));
                }
                [u, v].map(|c| c.clamp(0.0, 1.0))
            }
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

    const ALL: [SphereMap; 2] = [SphereMap::LatLong, SphereMap::EqualArea];

    #[test]
    fn places_and_directions_are_each_others_inverse() {
        let mut s = Stream::new(7, Purpose::Test, 0);
        for map in ALL {
            for _ in 0..10_000 {
                let d = crate::warp::sphere(s.uniform_2());
                let back = map.direction(map.place(d));
                assert!((back - d).length() < 2e-6, "{map:?}: {d} {back}");
            }
            for d in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z] {
                let back = map.direction(map.place(d));
                assert!((back - d).length() < 2e-5, "{map:?}: {d} {back}");
            }
        }
    }

    #[test]
    fn the_octahedral_square_has_its_axes_where_the_convention_says() {
        let place = |d| SphereMap::EqualArea.place(d);
        let near = |a: [f32; 2], b: [f32; 2]| (a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 1e-6;
        assert!(near(place(Vec3::Z), [0.5, 0.5]) && near(place(Vec3::X), [1.0, 0.5]));
        assert!(near(place(Vec3::Y), [0.5, 1.0]) && near(place(-Vec3::X), [0.0, 0.5]));
        // By equal areas, the upper hemisphere is the inner diamond, and directions within 60° of
        // the pole fill half of it.
        let diagonal = Vec3::new(0.5f32.sqrt() * 0.75f32.sqrt(), 0.5f32.sqrt() * 0.75f32.sqrt(), 0.5);
        let [u, v] = place(diagonal);
        assert!(((2.0 * u - 1.0 + 2.0 * v - 1.0) - 0.5f32.sqrt()).abs() < 1e-6);
    }

    /// A small step over an edge of the rectangle is a small step on the sphere, and does not lead
    /// back to where it came from.
    #[test]
    fn the_sphere_goes_on_beyond_the_edges() {
        const STEP: f32 = 1e-3;
        for map in ALL {
            for along in [0.1, 0.3, 0.45, 0.7, 0.95] {
                for (edge, out) in [
                    ([0.0, along], [-STEP, 0.0]),
                    ([1.0, along], [STEP, 0.0]),
                    ([along, 0.0], [0.0, -STEP]),
                    ([along, 1.0], [0.0, STEP]),
                ] {
                    let at = |steps: f32| {
                        let place = [edge[0] + steps * out[0], edge[1] + steps * out[1]];
                        map.direction(map.wrapped(place))
                    };
                    let (inside, on, outside) = (at(-1.0), at(0.0), at(1.0));
                    let (before, after) = ((on - inside).length(), (outside - on).length());
                    assert!(after < 0.02, "{map:?} jumps at {edge:?}: {on} to {outside}");
                    // The step inside and the step outside have similar directions, so that their
                    // lengths nearly add up.
                    assert!(
                        (outside - inside).length() > 0.6 * (before + after),
                        "{map:?} turns back at {edge:?}: {inside}, {on}, {outside}"
                    );
                }
            }
        }
    }
}
