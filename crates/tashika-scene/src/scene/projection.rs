//! Projections: the viewing direction of each film position, and the film position of a direction.
//!
//! `(x, y)` is the position on the film, in film heights from its centre, `x` to the right and `y`
//! up. In the frame of the camera, `−z` is the direction of view, `+y` is up and `+x` to the right.
//! The ray through `(x, y)` has the direction
//!
//! ```text
//! perspective     d ∝ (2 t x, 2 t y, −1)              t = tan(vertical_fov / 2)
//! orthographic    d = (0, 0, −1)  from  (h x, h y, 0)  h the height (m)
//! fisheye         θ = ρ · angle                       ρ = |(x, y)| in units of the smaller side
//!                 d = (sin θ x/|·|, sin θ y/|·|, −cos θ)
//! spherical       d by a [`SphereMap`] of the whole film
//! ```
//!
//! A pixel of side `s` covers, at the distance `r` and at right angles to the ray, the area (m²)
//!
//! ```text
//! perspective     s² (2 t z)² cos θ                   z = r cos θ, s in film heights
//! orthographic    s² h²
//! fisheye         r² s² angle² sin θ / θ              s in units of the smaller side
//! spherical       r² · solid angle of the film's area, over its pixels
//! ```
//!
//! # Held to this by
//! `tests`, and the suite's `pbrt` for the layouts of that format.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::SphereMap;
use crate::math::elementary::{atan2, sin_cos, tan};

/// Map from the world to the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// All rays pass through one point, and the film is flat.
    Perspective {
        /// Vertical field of view of a film that is centred on the axis (radians), between 0 and π.
        vertical_fov: f32,
    },
    /// All rays are parallel to the axis.
    Orthographic {
        /// Height of the film (m).
        height: f32,
    },
    /// The equidistant fisheye: the distance from the film's centre is proportional to the angle
    /// with the axis. The picture is a circle that touches the film's longer sides; the film
    /// outside of it is black.
    Fisheye {
        /// Angle across the circle (radians), above 0 and at most 2π.
        angle: f32,
    },
    /// All directions, laid out over the whole film. The latitude-longitude layout looks ahead at
    /// its centre. The equal-area layout looks up at its centre, ahead in the middle of its lower
    /// edge and down at its corners. The film must have no shift.
    Spherical {
        /// Layout of the sphere on the film.
        map: SphereMap,
    },
}

/// A film of `size` pixels whose centre is off the axis by `shift` (film widths and heights).
#[derive(Clone, Copy, Debug)]
pub(super) struct FilmFrame {
    pub(super) size: Vec2,
    pub(super) shift: Vec2,
}

impl FilmFrame {
    /// Converts a film position (pixels, from the top left) to film heights from the axis, x to the
    /// right and y up.
    fn off_axis(&self, film: Vec2) -> Vec2 {
        let Self { size, shift } = self;
        let x = (film.x - 0.5 * size.x + shift.x * size.x) / size.y;
        let y = 0.5 - film.y / size.y + shift.y;
        Vec2::new(x, y)
    }

    /// Inverse of [`Self::off_axis`].
    fn to_film(self, p: Vec2) -> Vec2 {
        let Self { size, shift } = self;
        Vec2::new(p.x * size.y + 0.5 * size.x - shift.x * size.x, (0.5 - p.y + shift.y) * size.y)
    }

    /// Length of the smaller side, in film heights.
    fn smaller_side(&self) -> f32 {
        (self.size.x / self.size.y).min(1.0)
    }
}

impl Projection {
    /// Returns true if the projection can have a lens with an extent. The others are pinholes or
    /// parallel.
    pub(super) fn has_lens(self) -> bool {
        matches!(self, Self::Perspective { .. })
    }

    /// Returns origin and direction of the ray through a film position (pixels), in the frame of
    /// the camera. The direction is not normalised. `None` where the film shows nothing.
    pub(super) fn ray(self, film: Vec2, frame: &FilmFrame) -> Option<(Vec3, Vec3)> {
        let p = frame.off_axis(film);
        Some(match self {
            Self::Perspective { vertical_fov } => {
                let height = 2.0 * tan(0.5 * vertical_fov);
                (Vec3::ZERO, Vec3::new(p.x * height, p.y * height, -1.0))
            }
            Self::Orthographic { height } => (Vec3::new(p.x * height, p.y * height, 0.0), Vec3::NEG_Z),
            Self::Fisheye { angle } => {
                let distance = p.length();
                let theta = distance / frame.smaller_side() * angle;
                if theta > 0.5 * angle {
                    return None;
                }
                let (sin, cos) = sin_cos(theta);
                let across = if distance > 0.0 { p * (sin / distance) } else { Vec2::ZERO };
                (Vec3::ZERO, across.extend(-cos))
            }
            Self::Spherical { map } => {
                let place = map.wrapped((film / frame.size).into());
                (Vec3::ZERO, from_map(map, map.direction(place)))
            }
        })
    }

    /// Returns the film position (pixels) of a point in the frame of the camera, and the area at
    /// right angles to the ray that a pixel covers there (m²). `None` for points that the film does
    /// not show.
    pub(super) fn project(self, p: Vec3, frame: &FilmFrame) -> Option<(Vec2, f32)> {
        match self {
            Self::Perspective { .. } | Self::Orthographic { .. } => {
                if p.z >= 0.0 {
                    return None;
                }
                // Height of the area that the film shows at the depth of the point (m), and cosine
                // of the angle between ray and axis.
                let (height, cos) = match self {
                    Self::Perspective { vertical_fov } => {
                        (-p.z * 2.0 * tan(0.5 * vertical_fov), -p.z / p.length())
                    }
                    Self::Orthographic { height } => (height, 1.0),
                    Self::Fisheye { .. } | Self::Spherical { .. } => return None,
                };
                let side = height / frame.size.y;
                Some((frame.to_film(Vec2::new(p.x, p.y) / height), side * side * cos))
            }
            Self::Fisheye { angle } => {
                let across = p.truncate();
                let theta = atan2(across.length(), -p.z);
                let squared = p.length_squared();
                if theta > 0.5 * angle || squared == 0.0 {
                    return None;
                }
                let smaller = frame.smaller_side();
                let distance = theta / angle * smaller;
                let film = frame.to_film(across.normalize_or_zero() * distance);
                let sinc = if theta > 0.0 { sin_cos(theta).0 / theta } else { 1.0 };
                let side = angle / (smaller * frame.size.y);
                Some((film, squared * side * side * sinc))
            }
            Self::Spherical { map } => {
                let squared = p.length_squared();
                let d = to_map(map, p.try_normalize()?);
                let solid_angle = map.solid_angle(d) / (frame.size.x * frame.size.y);
                Some((Vec2::from(map.place(d)) * frame.size, squared * solid_angle))
            }
        }
    }

    /// Returns true if different directions have different film positions. The rays of an
    /// orthographic camera all share one direction.
    pub(super) fn tells_directions_apart(self) -> bool {
        !matches!(self, Self::Orthographic { .. })
    }

    /// Returns the displacement from one film position to another (pixels): the shorter one where
    /// the film wraps around.
    pub(super) fn way(self, from: Vec2, to: Vec2, frame: &FilmFrame) -> Vec2 {
        let mut way = to - from;
        if matches!(self, Self::Spherical { map: SphereMap::LatLong }) {
            way.x -= frame.size.x * (way.x / frame.size.x).round();
        }
        way
    }

    /// Returns true if its parameters are in range.
    pub(super) fn is_valid(self) -> bool {
        match self {
            Self::Perspective { vertical_fov } => vertical_fov > 0.0 && vertical_fov < PI,
            Self::Orthographic { height } => height > 0.0 && height.is_finite(),
            Self::Fisheye { angle } => angle > 0.0 && angle <= 2.0 * PI,
            Self::Spherical { .. } => true,
        }
    }
}

/// Transforms a direction from the frame of a layout to that of the camera. The pole of the layout
/// becomes the camera's up direction.
fn from_map(map: SphereMap, d: Vec3) -> Vec3 {
    match map {
        SphereMap::LatLong => d,
        SphereMap::EqualArea => Vec3::new(d.x, d.z, -d.y),
    }
}

/// Inverse of [`from_map`].
fn to_map(map: SphereMap, d: Vec3) -> Vec3 {
    match map {
        SphereMap::LatLong => d,
        SphereMap::EqualArea => Vec3::new(d.x, -d.z, d.y),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: FilmFrame = FilmFrame { size: Vec2::new(200.0, 100.0), shift: Vec2::ZERO };
    const LAT_LONG: Projection = Projection::Spherical { map: SphereMap::LatLong };
    const EQUAL_AREA: Projection = Projection::Spherical { map: SphereMap::EqualArea };

    fn assert_looks(projection: Projection, film: [f32; 2], along: Vec3) {
        let found = projection.ray(film.into(), &FRAME).expect("a ray").1;
        assert!((found - along.normalize()).length() < 2e-5, "{projection:?} at {film:?}: {found}");
    }

    #[test]
    fn latitude_and_longitude_look_ahead_at_the_centre_and_right_on_the_right() {
        assert_looks(LAT_LONG, [100.0, 50.0], Vec3::NEG_Z);
        assert_looks(LAT_LONG, [150.0, 50.0], Vec3::X);
        assert_looks(LAT_LONG, [50.0, 50.0], Vec3::NEG_X);
        assert_looks(LAT_LONG, [0.0, 50.0], Vec3::Z);
        assert_looks(LAT_LONG, [77.0, 0.0], Vec3::Y);
        assert_looks(LAT_LONG, [100.0, 25.0], Vec3::new(0.0, 1.0, -1.0));
        // Positions beyond the top edge, which wide filters use, continue over the pole and down on
        // its other side.
        assert_looks(LAT_LONG, [100.0, -25.0], Vec3::new(0.0, 1.0, 1.0));
    }

    #[test]
    fn equal_areas_look_up_at_the_centre_and_ahead_at_the_lower_edge() {
        assert_looks(EQUAL_AREA, [100.0, 50.0], Vec3::Y);
        assert_looks(EQUAL_AREA, [100.0, 100.0], Vec3::NEG_Z);
        assert_looks(EQUAL_AREA, [200.0, 50.0], Vec3::X);
        assert_looks(EQUAL_AREA, [0.0, 0.0], Vec3::NEG_Y);
    }

    #[test]
    fn a_fisheye_is_a_circle_of_equal_angles_and_nothing_outside() {
        let at = |angle: f32, x: f32, y: f32| Projection::Fisheye { angle }.ray(Vec2::new(x, y), &FRAME);
        let half = |x: f32, y: f32| at(PI, x, y).map(|(_, d)| d);
        let near = |d: Option<Vec3>, e: Vec3| (d.expect("a ray") - e.normalize()).length() < 1e-5;
        assert!(near(half(100.0, 50.0), Vec3::NEG_Z));
        // 50 pixels are 90°, 25 are 45°, in all directions.
        assert!(near(half(100.0, 0.001), Vec3::new(0.0, 1.0, -3e-5)));
        assert!(near(half(125.0, 50.0), Vec3::new(1.0, 0.0, -1.0)));
        assert!(near(half(100.0, 75.0), Vec3::new(0.0, -1.0, -1.0)));
        assert!(half(151.0, 50.0).is_none() && half(137.0, 87.0).is_none() && half(100.0, -1.0).is_none());
        // At 360° the whole circle shows the direction behind; 0.01 pixels are 0.036°.
        let behind = at(2.0 * PI, 149.99, 50.0).expect("a ray").1;
        assert!((behind - Vec3::Z).length() < 1e-3, "{behind}");
        // On a film that is higher than wide, the diameter of the circle is the width.
        let high = FilmFrame { size: Vec2::new(100.0, 200.0), ..FRAME };
        let d = Projection::Fisheye { angle: PI }.ray(Vec2::new(75.0, 100.0), &high).unwrap().1;
        assert!(near(Some(d), Vec3::new(1.0, 0.0, -1.0)), "{d}");
    }

    #[test]
    fn a_shift_moves_the_circle_of_a_fisheye() {
        let frame = FilmFrame { shift: Vec2::new(0.25, -0.5), ..FRAME };
        let (_, d) = Projection::Fisheye { angle: 2.0 }.ray(Vec2::new(50.0, 0.0), &frame).unwrap();
        assert!((d - Vec3::NEG_Z).length() < 1e-6, "{d}");
    }

    /// A point on the ray through a film position is projected back to that position. The area that
    /// a pixel covers there agrees with finite differences of rays.
    #[test]
    fn places_are_projected_to_where_their_rays_come_from() {
        let cases = [
            (Projection::Perspective { vertical_fov: 1.0 }, Vec2::new(0.1, -0.2)),
            (Projection::Orthographic { height: 3.0 }, Vec2::new(0.1, -0.2)),
            (Projection::Fisheye { angle: 2.0 }, Vec2::new(0.1, -0.2)),
            (Projection::Fisheye { angle: 6.2 }, Vec2::ZERO),
            (LAT_LONG, Vec2::ZERO),
            (EQUAL_AREA, Vec2::ZERO),
        ];
        for (projection, shift) in cases {
            for size in [[200.0, 100.0], [90.0, 130.0]] {
                let frame = FilmFrame { size: size.into(), shift };
                let mut seen = 0;
                for (x, y) in [(0.52, 0.46), (0.02, 0.07), (0.3, 0.9), (0.47, 0.55), (0.61, 0.33), (0.9, 0.8)]
                {
                    let film = Vec2::new(x, y) * frame.size;
                    let at = |film| {
                        let (origin, direction) = projection.ray(film, &frame)?;
                        Some(origin + 4.0 * direction.normalize())
                    };
                    let Some(place) = at(film) else { continue };
                    seen += 1;
                    let (found, area) = projection.project(place, &frame).expect("it is seen");
                    assert!((found - film).length() < 1e-2, "{projection:?}: {found} for {film}");
                    let step = 0.1;
                    let side = |axis: Vec2| Some(at(film + step * axis)? - at(film - step * axis)?);
                    let (Some(a), Some(b)) = (side(Vec2::X), side(Vec2::Y)) else { continue };
                    let expected = a.cross(b).length() / (4.0 * step * step);
                    assert!((area / expected - 1.0).abs() < 2e-3, "{projection:?}: {area} for {expected}");
                }
                assert!(seen >= 3, "{projection:?} shows {seen}");
            }
        }
    }

    #[test]
    fn what_the_film_does_not_show_has_no_place_on_it() {
        let behind = Vec3::new(0.1, 0.2, 1.0);
        let shows = |projection: Projection| projection.project(behind, &FRAME).is_some();
        assert!(!shows(Projection::Perspective { vertical_fov: 1.0 }));
        assert!(!shows(Projection::Orthographic { height: 3.0 }));
        assert!(!shows(Projection::Fisheye { angle: 3.5 }) && shows(Projection::Fisheye { angle: 6.0 }));
        assert!(shows(LAT_LONG) && shows(EQUAL_AREA));
        for projection in [LAT_LONG, EQUAL_AREA, Projection::Fisheye { angle: 3.0 }] {
            assert!(projection.project(Vec3::ZERO, &FRAME).is_none(), "the camera itself");
        }
    }

    /// The solid angles of all pixels of a film that shows all directions sum to the whole sphere,
    /// and those of a 180° fisheye to half of it.
    #[test]
    fn pixels_cover_the_sphere_once() {
        let fisheye = |angle: f32| Projection::Fisheye { angle };
        for (projection, expected) in
            [(LAT_LONG, 4.0), (EQUAL_AREA, 4.0), (fisheye(2.0 * PI), 4.0), (fisheye(PI), 2.0)]
        {
            let mut sum = 0.0;
            for pixel in 0..200 * 100 {
                let film = Vec2::new((pixel % 200) as f32 + 0.5, (pixel / 200) as f32 + 0.5);
                let Some((_, direction)) = projection.ray(film, &FRAME) else { continue };
                sum += f64::from(projection.project(direction, &FRAME).unwrap().1);
            }
            let found = sum / std::f64::consts::PI;
            assert!((found / expected - 1.0).abs() < 2e-3, "{projection:?}: {found} π for {expected} π");
        }
    }
}
