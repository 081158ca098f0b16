//! The camera: perspective with a pinhole or a thin lens, or orthographic.

use glam::{Affine3A, Mat3, Vec2, Vec3};

use crate::film::Window;
use crate::math::Ray;
use crate::math::elementary::tan;
use crate::warp;

/// A lens with an opening: what is not at the focus distance blurs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Radius of the opening (m); zero is a pinhole.
    pub radius: f32,
    /// Distance along the axis at which the image is sharp (m).
    pub focus_distance: f32,
}

/// How the world is projected onto the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Through a point.
    Perspective {
        /// Vertical field of view of a film that is centred on the axis (radians), between 0 and π.
        vertical_fov: f32,
    },
    /// Along the axis.
    Orthographic {
        /// Height of the film (m).
        height: f32,
    },
}

/// A camera looking along its own `−z`, with `+y` up and `+x` to the right.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name by which the user chooses it.
    pub name: String,
    /// Camera to world; a rigid motion, or one with a mirror.
    pub to_world: Affine3A,
    /// How the world is projected.
    pub projection: Projection,
    /// How far the film's centre is off the axis, in film widths to the right and film heights up.
    pub shift: Vec2,
    /// The lens; orthographic cameras have none.
    pub lens: Lens,
    /// Image size that the file asks for (pixels).
    pub resolution: Option<[u32; 2]>,
    /// Part of that image that the file asks for.
    pub crop: Option<Window>,
}

/// Where on the film and on the lens a camera ray starts.
#[derive(Clone, Copy, Debug)]
pub struct CameraSample {
    /// Position on the film (pixels, from the top left). Wide pixel filters go beyond `[0, width] × [0, height]`: the film has no edge.
    pub film: Vec2,
    /// Uniform numbers for the lens.
    pub lens: [f32; 2],
}

impl Camera {
    /// A pinhole at `eye` looking at `target`, `up` being up.
    pub fn look_at(name: impl Into<String>, eye: Vec3, target: Vec3, up: Vec3, vertical_fov: f32) -> Self {
        let back = (eye - target).normalize();
        let right = up.cross(back).normalize_or(back.any_orthonormal_vector());
        let axes = Mat3::from_cols(right, back.cross(right), back);
        Self {
            name: name.into(),
            to_world: Affine3A::from_mat3_translation(axes, eye),
            projection: Projection::Perspective { vertical_fov },
            shift: Vec2::ZERO,
            lens: Lens { radius: 0.0, focus_distance: 1.0 },
            resolution: None,
            crop: None,
        }
    }

    /// Position of the lens' centre (m, world).
    pub fn position(&self) -> Vec3 {
        self.to_world.translation.into()
    }

    /// The world ray through a point of a film of `size` pixels; its direction has unit length.
    pub fn ray(&self, sample: &CameraSample, size: [u32; 2]) -> Ray {
        let size = Vec2::new(size[0] as f32, size[1] as f32);
        // In film heights from the axis: x to the right, y up.
        let x = (sample.film.x - 0.5 * size.x + self.shift.x * size.x) / size.y;
        let y = 0.5 - sample.film.y / size.y + self.shift.y;
        let (mut origin, mut direction) = match self.projection {
            Projection::Perspective { vertical_fov } => {
                let height = 2.0 * tan(0.5 * vertical_fov);
                (Vec3::ZERO, Vec3::new(x * height, y * height, -1.0))
            }
            Projection::Orthographic { height } => (Vec3::new(x * height, y * height, 0.0), Vec3::NEG_Z),
        };
        if self.lens.radius > 0.0 && matches!(self.projection, Projection::Perspective { .. }) {
            let focus = direction * self.lens.focus_distance;
            origin = (warp::disk(sample.lens) * self.lens.radius).extend(0.0);
            direction = focus - origin;
        }
        Ray::new(
            self.to_world.transform_point3(origin),
            self.to_world.transform_vector3(direction).normalize(),
        )
    }

    /// Where a place of the world lies on a film of `size` pixels (pixels, from the top left), as seen through the lens' centre, and the area at right angles to the ray that a pixel
    /// covers there (m²). `None` for what is not in front of the camera.
    pub fn project(&self, place: Vec3, size: [u32; 2]) -> Option<(Vec2, f32)> {
        let size = Vec2::new(size[0] as f32, size[1] as f32);
        let p = self.to_world.inverse().transform_point3(place);
        if p.z >= 0.0 {
            return None;
        }
        // Of the film where the place is (m), and the cosine at which the ray meets it.
        let (height, cos) = match self.projection {
            Projection::Perspective { vertical_fov } => {
                (-p.z * 2.0 * tan(0.5 * vertical_fov), -p.z / p.length())
            }
            Projection::Orthographic { height } => (height, 1.0),
        };
        let on_film = Vec2::new(p.x, p.y) / height;
        let film = Vec2::new(
            on_film.x * size.y + 0.5 * size.x - self.shift.x * size.x,
            (0.5 - on_film.y + self.shift.y) * size.y,
        );
        let side = height / size.y;
        Some((film, side * side * cos))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a camera ray meets lies on the film where the ray came from, and all pixels together cover what the film sees.
    #[test]
    fn places_are_projected_to_where_their_rays_come_from() {
        let mut c = camera();
        c.shift = Vec2::new(0.1, -0.2);
        for projection in [c.projection, Projection::Orthographic { height: 3.0 }] {
            c.projection = projection;
            for (x, y) in [(100.0, 50.0), (3.5, 7.25), (-20.0, 90.0)] {
                let film = Vec2::new(x, y);
                let ray = |film| c.ray(&CameraSample { film, lens: [0.5; 2] }, [200, 100]);
                let at = |film| ray(film).at(4.0);
                let (found, area) = c.project(at(film), [200, 100]).unwrap();
                assert!((found - film).length() < 1e-2, "{projection:?}: {found} for {film}");
                let sides = [Vec2::X, Vec2::Y].map(|step| at(film + 0.5 * step) - at(film - 0.5 * step));
                let expected = sides[0].cross(sides[1]).length();
                assert!((area / expected - 1.0).abs() < 1e-3, "{projection:?}: {area} for {expected}");
            }
        }
        assert!(c.project(c.position() + Vec3::Z, [200, 100]).is_none());
    }

    fn camera() -> Camera {
        Camera::look_at("c", Vec3::new(1.0, 2.0, 3.0), Vec3::new(1.0, 2.0, -7.0), Vec3::Y, 1.0)
    }

    #[test]
    fn corners_of_the_film_see_the_field_of_view() {
        let c = camera();
        let ray = |x, y| c.ray(&CameraSample { film: Vec2::new(x, y), lens: [0.5; 2] }, [200, 100]).direction;
        assert!((ray(100.0, 50.0) - Vec3::NEG_Z).length() < 1e-6);
        let (top, bottom) = (ray(100.0, 0.0), ray(100.0, 100.0));
        assert!((top.angle_between(bottom) - 1.0).abs() < 1e-5, "vertical field of view");
        assert!(top.y > 0.0 && ray(200.0, 50.0).x > 0.0, "y down on the film, x to the right");
    }

    #[test]
    fn a_shifted_film_shows_what_a_larger_one_would() {
        let mut c = camera();
        let sample = |x, y| CameraSample { film: Vec2::new(x, y), lens: [0.5; 2] };
        // The right half of the upper half of a film of twice the size.
        let large = c.ray(&sample(150.0, 20.0), [200, 100]);
        c.projection = Projection::Perspective {
            vertical_fov: 2.0 * crate::math::elementary::atan2(0.5 * tan(0.5), 1.0),
        };
        c.shift = Vec2::new(0.5, 0.5);
        let small = c.ray(&sample(50.0, 20.0), [100, 50]);
        assert!((large.direction - small.direction).length() < 1e-6, "{large:?} {small:?}");
    }

    #[test]
    fn orthographic_rays_are_parallel() {
        let mut c = camera();
        c.projection = Projection::Orthographic { height: 4.0 };
        let ray = |x, y| c.ray(&CameraSample { film: Vec2::new(x, y), lens: [0.5; 2] }, [200, 100]);
        let (corner, centre) = (ray(200.0, 0.0), ray(100.0, 50.0));
        assert_eq!(corner.direction, centre.direction);
        assert!((corner.origin - centre.origin - Vec3::new(4.0, 2.0, 0.0)).length() < 1e-6);
    }

    #[test]
    fn all_rays_of_a_lens_meet_at_the_focus() {
        let mut c = camera();
        c.lens = Lens { radius: 0.2, focus_distance: 4.0 };
        let at_focus = |lens| {
            let r = c.ray(&CameraSample { film: Vec2::new(30.0, 20.0), lens }, [200, 100]);
            r.at((3.0 - 4.0 - r.origin.z) / r.direction.z)
        };
        let p = at_focus([0.5, 0.5]);
        for lens in [[0.0, 0.0], [0.9, 0.1], [0.3, 1.0]] {
            assert!((at_focus(lens) - p).length() < 1e-5);
        }
    }
}
