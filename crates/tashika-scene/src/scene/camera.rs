//! The camera: a projection, a lens and a pose, which may move while the shutter is open.

use std::sync::Arc;

use glam::{Affine3A, Mat3, Vec2, Vec3};

use super::projection::FilmFrame;
use super::{Lens, MediumId, Motion, Projection, SensorGrid};
use crate::film::Window;
use crate::math::motion::Track;
use crate::math::{Aabb, Ray};

/// A camera looking along its own `−z`, with `+y` up and `+x` to the right.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name by which the user selects the camera.
    pub name: String,
    /// Transform from camera to world: a rotation and a translation, possibly with a reflection.
    /// For a moving camera, the transform in the middle of the time that its shutter is open.
    pub to_world: Affine3A,
    /// Pose while the shutter is open, if it moves: see [`Camera::moving`].
    pub motion: Option<Motion>,
    /// Map from the world to the film.
    pub projection: Projection,
    /// Offset of the film's centre from the axis, in film widths to the right and film heights up;
    /// spherical cameras have no shift.
    pub shift: Vec2,
    /// The lens; only perspective cameras have one.
    pub lens: Lens,
    /// Image size that the file specifies (pixels).
    pub resolution: Option<[u32; 2]>,
    /// Part of the image to render, if the file specifies one.
    pub crop: Option<Window>,
    /// Medium of the scene around the camera, if there is any.
    pub medium: Option<MediumId>,
    /// Index of refraction `n` of the medium around the camera, relative to the medium outside of
    /// all glass; 1 for cameras outside. The film shows `n²` times the basic radiance that camera
    /// paths carry ([`crate::bsdf::Glass`]).
    pub index: f32,
    /// Box that the camera must show entirely, if the file specifies no position: see
    /// [`Camera::of_size`].
    pub shows: Option<Aabb>,
    /// Sensors in the pixels, instead of the view of the camera: see
    /// [`with_sensors`](Self::with_sensors).
    pub sensors: Option<Arc<SensorGrid>>,
}

/// Film position, lens sample and time of a camera ray.
#[derive(Clone, Copy, Debug)]
pub struct CameraSample {
    /// Position on the film (pixels, from the top left). Positions outside of
    /// `[0, width] × [0, height]`, which wide pixel filters use, are valid as well.
    pub film: Vec2,
    /// Uniform numbers that select a point of the lens.
    pub lens: [f32; 2],
    /// Share of the time that the shutter is open, 0 to 1; ignored by a static camera.
    pub time: f32,
}

/// Object whose displacement on the film is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seen {
    /// A point that may move (m, world).
    Place {
        /// Position when the shutter opens.
        open: Vec3,
        /// Position when the shutter closes.
        close: Vec3,
    },
    /// A world direction, for objects infinitely far away.
    Direction(Vec3),
}

impl Camera {
    /// Creates a pinhole camera without motion, medium or image size, with the film centred on its
    /// axis.
    pub fn new(name: impl Into<String>, to_world: Affine3A, projection: Projection) -> Self {
        Self {
            name: name.into(),
            to_world,
            motion: None,
            projection,
            shift: Vec2::ZERO,
            lens: Lens::PINHOLE,
            resolution: None,
            crop: None,
            medium: None,
            index: 1.0,
            shows: None,
            sensors: None,
        }
    }

    /// Returns a camera whose pixels measure irradiance at sensors. It has no rays and no motion,
    /// and shows nothing else. The sensors are in the medium of this camera.
    #[must_use]
    pub fn with_sensors(&self, sensors: SensorGrid) -> Self {
        let pinhole = Self::new(&*self.name, self.to_world, self.projection);
        Self { medium: self.medium, sensors: Some(Arc::new(sensors)), ..pinhole }
    }

    /// Creates a pinhole camera at `eye` looking at `target`, with `up` upwards.
    pub fn look_at(name: impl Into<String>, eye: Vec3, target: Vec3, up: Vec3, vertical_fov: f32) -> Self {
        let back = (eye - target).normalize();
        let right = up.cross(back).normalize_or(back.any_orthonormal_vector());
        let axes = Mat3::from_cols(right, back.cross(right), back);
        let to_world = Affine3A::from_mat3_translation(axes, eye);
        Self::new(name, to_world, Projection::Perspective { vertical_fov })
    }

    /// Returns the camera with the pose of a track. `shutter` is the times at which its shutter
    /// opens and closes (s). The camera moves if the track is not constant in between.
    pub fn moving(self, track: Track, shutter: [f64; 2]) -> Self {
        let [open, close] = shutter;
        let to_world = track.at(open + 0.5 * (close - open)).as_affine3a();
        let motion = Motion::between(track, shutter);
        Self { to_world, motion, ..self }
    }

    /// Returns the ratio `n²` of radiance to basic radiance at the camera.
    pub fn squared_index(&self) -> f32 {
        self.index * self.index
    }

    /// Returns the ratio of basic radiance to radiance for light from infinitely far away, at the
    /// end of a camera path.
    ///
    /// The ratio is 1 for light that comes from outside of all glass. A camera inside glass may
    /// have a path that leaves the scene without crossing a boundary, as under the surface of an
    /// infinite pond. The path then ends in the medium of the camera, and the ratio is `1/n²`.
    ///
    /// * `ratio`: product of [`squared_ratio`](crate::bsdf::Glass::squared_ratio) over the
    ///   boundaries that the path has crossed.
    pub fn basic_of_infinity(&self, ratio: f64) -> f32 {
        if self.index != 1.0 && ratio as f32 == 1.0 { self.squared_index().recip() } else { 1.0 }
    }

    /// Position of the lens' centre (m, world); for a moving camera, in the middle of the time that
    /// its shutter is open.
    pub fn position(&self) -> Vec3 {
        self.to_world.translation.into()
    }

    /// Returns the world ray through a point of a film of `size` pixels; its direction has unit
    /// length. `None` where the film shows nothing: outside the circle of a fisheye, and if the
    /// camera has sensors.
    pub fn ray(&self, sample: &CameraSample, size: [u32; 2]) -> Option<Ray> {
        if self.sensors.is_some() {
            return None;
        }
        let (mut origin, mut direction) = self.projection.ray(sample.film, &self.frame(size))?;
        if self.lens.radius > 0.0 && self.projection.has_lens() {
            let focus = direction * self.lens.focus_distance;
            origin = self.lens.point(sample.lens).extend(0.0);
            direction = focus - origin;
        }
        Some(self.placed(origin, direction, sample.time))
    }

    /// Returns the world ray through a point of the film and the lens' centre, after a share of the
    /// time that the shutter is open, 0 to 1.
    pub fn central_ray(&self, film: Vec2, share: f32, size: [u32; 2]) -> Option<Ray> {
        if self.sensors.is_some() {
            return None;
        }
        let (origin, direction) = self.projection.ray(film, &self.frame(size))?;
        Some(self.placed(origin, direction, share))
    }

    /// Returns the displacement of an object's image on a film of `size` pixels (pixels: to the
    /// right, down), from the time at which the shutter opens to the time at which it closes, as
    /// seen through the lens' centre. On a film that wraps around, it is the shorter displacement.
    ///
    /// `None` if one of the two positions is not shown, even by a film of unlimited size.
    pub fn way_on_film(&self, seen: Seen, size: [u32; 2]) -> Option<Vec2> {
        let frame = self.frame(size);
        let on_film = |share: f32, place: Vec3| {
            let to_camera = self.pose(share).inverse();
            let place = match seen {
                Seen::Place { .. } => to_camera.transform_point3(place),
                Seen::Direction(_) => to_camera.transform_vector3(place),
            };
            self.projection.project(place, &frame).map(|(film, _)| film)
        };
        let [open, close] = match seen {
            Seen::Place { open, close } => [open, close],
            Seen::Direction(_) if !self.projection.tells_directions_apart() => return Some(Vec2::ZERO),
            Seen::Direction(direction) => [direction; 2],
        };
        Some(self.projection.way(on_film(0.0, open)?, on_film(1.0, close)?, &frame))
    }

    /// Transforms a ray from the frame of the camera to the world.
    fn placed(&self, origin: Vec3, direction: Vec3, share: f32) -> Ray {
        let to_world = self.pose(share);
        Ray::new(to_world.transform_point3(origin), to_world.transform_vector3(direction).normalize())
    }

    /// Transform from camera to world after a share of the time that the shutter is open.
    fn pose(&self, share: f32) -> Affine3A {
        self.motion.as_ref().map_or(self.to_world, |motion| motion.pose(share))
    }

    /// Projects a point of the world (m) onto a film of `size` pixels, as seen through the lens'
    /// centre; for a moving camera, in the middle of the time that its shutter is open. Returns the
    /// film position (pixels, from the top left) and the area at right angles to the ray that a
    /// pixel covers there (m²). `None` for points that even a film of unlimited size does not show:
    /// points behind most cameras, points outside the circle of a fisheye, and all points if the
    /// camera has sensors.
    pub fn project(&self, place: Vec3, size: [u32; 2]) -> Option<(Vec2, f32)> {
        if self.sensors.is_some() {
            return None;
        }
        self.projection.project(self.to_world.inverse().transform_point3(place), &self.frame(size))
    }

    fn frame(&self, size: [u32; 2]) -> FilmFrame {
        FilmFrame { size: Vec2::new(size[0] as f32, size[1] as f32), shift: self.shift }
    }

    /// Returns true if its parameters are in range.
    pub(super) fn is_valid(&self) -> bool {
        self.to_world.is_finite()
            && self.to_world.matrix3.determinant().abs() > 0.0
            && self.projection.is_valid()
            && self.shift.is_finite()
            && self.lens.is_valid()
            && self.index > 0.0
            && self.index.is_finite()
            && self.motion.as_ref().is_none_or(Motion::is_valid)
            && self.sensors.as_ref().is_none_or(|sensors| sensors.is_valid())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DAffine3, Quat};

    use crate::math::elementary::{rotation, tan};
    use crate::scene::Blades;

    /// A point on the ray through a film position is projected back to that position. Points behind
    /// the camera are not shown.
    #[test]
    fn places_of_the_world_are_projected_to_where_their_rays_come_from() {
        let mut c = camera();
        c.to_world *= Affine3A::from_rotation_x(0.4);
        c.shift = Vec2::new(0.1, -0.2);
        let film = Vec2::new(30.0, 70.0);
        let ray = c.ray(&CameraSample { film, lens: [0.5; 2], time: 0.5 }, [200, 100]).unwrap();
        let (found, area) = c.project(ray.at(4.0), [200, 100]).unwrap();
        assert!((found - film).length() < 1e-2 && area > 0.0, "{found} for {film}");
        assert!(c.project(ray.at(-4.0), [200, 100]).is_none());
    }

    /// Each ray of a moving camera is the ray of a static camera with the pose at the ray's time.
    #[test]
    fn a_camera_that_moves_is_where_its_track_is() {
        let ends = [
            Affine3A::from_rotation_translation(Quat::IDENTITY, Vec3::X),
            Affine3A::from_rotation_translation(rotation(Vec3::Y, 1.0), Vec3::new(3.0, 0.0, 0.0)),
        ];
        let key = |k: usize| DAffine3 {
            matrix3: ends[k].matrix3.as_dmat3(),
            translation: ends[k].translation.as_dvec3(),
        };
        let track = Track::new([(1.0, key(0)), (2.0, key(1))]).unwrap();
        let still = camera();
        let c = still.clone().moving(track.clone(), [1.0, 1.5]);
        for time in [0.0, 0.25, 1.0] {
            let sample = CameraSample { film: Vec2::new(20.0, 70.0), lens: [0.5; 2], time };
            let turned = Affine3A::from_rotation_translation(
                rotation(Vec3::Y, 0.5 * time),
                Vec3::new(1.0 + time, 0.0, 0.0),
            );
            let stands = Camera { to_world: turned, ..still.clone() };
            let (a, b) = (c.ray(&sample, [200, 100]).unwrap(), stands.ray(&sample, [200, 100]).unwrap());
            assert!((a.origin - b.origin).length() < 1e-6 && (a.direction - b.direction).length() < 1e-6);
            let other = still.ray(&CameraSample { time: 0.5, ..sample }, [200, 100]).unwrap();
            let same = still.ray(&sample, [200, 100]).unwrap();
            assert_eq!((same.origin, same.direction), (other.origin, other.direction));
        }
        assert!((c.position() - Vec3::new(1.5, 0.0, 0.0)).length() < 1e-6, "the middle of its time");
        assert!(c.is_valid());
        // While the shutter is open, the track is constant: the camera is static, with the track's
        // pose at that time.
        let later = still.clone().moving(track.clone(), [2.0, 5.0]);
        assert_eq!((later.motion, later.to_world), (None, ends[1]));
        for shutter in [[1.5, 1.0], [f64::NAN, 2.0], [1.0, f64::INFINITY]] {
            let motion = Some(Motion { track: track.clone(), shutter });
            assert!(!Camera { motion, ..still.clone() }.is_valid());
        }
        let mirrored = DAffine3 { matrix3: key(1).matrix3 * -1.0, ..key(1) };
        let turns_over = Track::new([(1.0, key(0)), (2.0, mirrored)]).unwrap();
        assert!(!still.moving(turns_over, [1.0, 2.0]).is_valid());
    }

    fn camera() -> Camera {
        Camera::look_at("c", Vec3::new(1.0, 2.0, 3.0), Vec3::new(1.0, 2.0, -7.0), Vec3::Y, 1.0)
    }

    #[test]
    fn corners_of_the_film_see_the_field_of_view() {
        let c = camera();
        let ray = |x, y| {
            c.ray(&CameraSample { film: Vec2::new(x, y), lens: [0.5; 2], time: 0.5 }, [200, 100])
                .unwrap()
                .direction
        };
        assert!((ray(100.0, 50.0) - Vec3::NEG_Z).length() < 1e-6);
        let (top, bottom) = (ray(100.0, 0.0), ray(100.0, 100.0));
        assert!((top.angle_between(bottom) - 1.0).abs() < 1e-5, "vertical field of view");
        assert!(top.y > 0.0 && ray(200.0, 50.0).x > 0.0, "y down on the film, x to the right");
    }

    #[test]
    fn a_shifted_film_shows_what_a_larger_one_would() {
        let mut c = camera();
        let sample = |x, y| CameraSample { film: Vec2::new(x, y), lens: [0.5; 2], time: 0.5 };
        // A camera whose film is the upper right quarter of this film has the same rays.
        let large = c.ray(&sample(150.0, 20.0), [200, 100]).unwrap();
        c.projection = Projection::Perspective {
            vertical_fov: 2.0 * crate::math::elementary::atan2(0.5 * tan(0.5), 1.0),
        };
        c.shift = Vec2::new(0.5, 0.5);
        let small = c.ray(&sample(50.0, 20.0), [100, 50]).unwrap();
        assert!((large.direction - small.direction).length() < 1e-6, "{large:?} {small:?}");
    }

    #[test]
    fn orthographic_rays_are_parallel() {
        let mut c = camera();
        c.projection = Projection::Orthographic { height: 4.0 };
        let ray = |x, y| {
            c.ray(&CameraSample { film: Vec2::new(x, y), lens: [0.5; 2], time: 0.5 }, [200, 100]).unwrap()
        };
        let (corner, centre) = (ray(200.0, 0.0), ray(100.0, 50.0));
        assert_eq!(corner.direction, centre.direction);
        assert!((corner.origin - centre.origin - Vec3::new(4.0, 2.0, 0.0)).length() < 1e-6);
    }

    #[test]
    fn all_rays_of_a_lens_meet_at_the_focus() {
        let mut c = camera();
        for blades in [None, Some(Blades { count: 5, rotation: 0.2 })] {
            c.lens = Lens { blades, ..Lens::round(0.2, 4.0) };
            let ray = |lens| {
                c.ray(&CameraSample { film: Vec2::new(30.0, 20.0), lens, time: 0.5 }, [200, 100]).unwrap()
            };
            let at_focus = |r: Ray| r.at((3.0 - 4.0 - r.origin.z) / r.direction.z);
            let p = at_focus(ray([0.5, 0.5]));
            for lens in [[0.0, 0.0], [0.9, 0.1], [0.3, 1.0]] {
                let r = ray(lens);
                assert!((at_focus(r) - p).length() < 1e-5);
                let from_centre = r.origin - c.position();
                assert!((from_centre.truncate() - c.lens.point(lens)).length() < 1e-6);
            }
        }
    }
}
