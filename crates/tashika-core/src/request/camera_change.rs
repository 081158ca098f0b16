//! Options that replace the projection or the lens of the scene's camera.
//!
//! | unset | default |
//! |---|---|
//! | projection | the camera's |
//! | field of view | the camera's; with a new projection 40° (perspective) or 180° (fisheye) |
//! | lens radius, focus distance, blades | the camera's |
//! | rotation of the blades | the rotation of the camera's blades, or 0 if it has none |
//!
//! If the projection differs from the camera's, the film is centred and not cropped. If the caller
//! sets no image size, a perspective or a fisheye keeps the size of the camera. The other
//! projections keep the height of the camera, or use 360 if the camera sets none. Their width
//! avoids distortion: twice the height for `spherical`, the height for `equal-area`.
//!
//! # Held to this by
//! `tests`.

use std::f32::consts::PI;
use std::fmt;

use super::framing::SIZE;
use crate::error::{Error, Result};
use crate::film::{Metadata, keys};
use crate::scene::{Blades, Camera, Lens, Projection, SphereMap};

/// Default vertical field of view of a perspective (radians): 40°.
const PERSPECTIVE_FOV: f32 = 40.0 * PI / 180.0;

/// Default angle across a fisheye (radians): 180°.
const FISHEYE_ANGLE: f32 = PI;

/// A projection, as users name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProjectionName {
    /// Through a point onto a plane.
    Perspective,
    /// Equidistant, in a circle.
    Fisheye,
    /// All around, by latitude and longitude.
    Spherical,
    /// All around, in a square of equal areas.
    EqualArea,
}

impl ProjectionName {
    /// The projections, in order of declaration.
    pub const ALL: [Self; 4] = [Self::Perspective, Self::Fisheye, Self::Spherical, Self::EqualArea];
}

impl fmt::Display for ProjectionName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Perspective => "perspective",
            Self::Fisheye => "fisheye",
            Self::Spherical => "spherical",
            Self::EqualArea => "equal-area",
        })
    }
}

/// The given options; `None` keeps the camera's value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraChange {
    /// Mapping from film to directions.
    pub projection: Option<ProjectionName>,
    /// Field of view (degrees): vertical for a perspective, between 0 and 180; across the circle
    /// for a fisheye, above 0 and at most 360.
    pub fov: Option<f32>,
    /// Radius of the lens (m); 0 for a pinhole.
    pub lens_radius: Option<f32>,
    /// Distance at which the image is sharp (m).
    pub focus_distance: Option<f32>,
    /// Number of blades of the aperture.
    pub blades: Option<u32>,
    /// Rotation of the blades (degrees), as [`Blades::rotation`].
    pub blade_rotation: Option<f32>,
}

impl CameraChange {
    /// Returns the camera with the given options applied.
    ///
    /// # Errors
    /// [`Error::Option`] for a number out of range, or an option that has no effect on the
    /// projection or the lens.
    pub fn of(&self, camera: &Camera) -> Result<Camera> {
        let mut camera = camera.clone();
        self.project(&mut camera)?;
        self.put_lens(&mut camera)?;
        Ok(camera)
    }

    /// Writes the given options to the metadata of a film, so that it is not merged with parts of
    /// other views.
    pub fn describe(&self, metadata: &mut Metadata) {
        if let Some(projection) = self.projection {
            metadata.set(keys::CAMERA_PROJECTION, projection.to_string());
        }
        for (key, number) in [
            (keys::CAMERA_FOV, self.fov),
            (keys::CAMERA_LENS_RADIUS, self.lens_radius),
            (keys::CAMERA_FOCUS_DISTANCE, self.focus_distance),
            (keys::CAMERA_BLADE_ROTATION, self.blade_rotation),
        ] {
            if let Some(number) = number {
                metadata.set(key, f64::from(number));
            }
        }
        if let Some(blades) = self.blades {
            metadata.set(keys::CAMERA_BLADES, blades);
        }
    }

    fn project(&self, camera: &mut Camera) -> Result<()> {
        if let Some(name) = self.projection {
            let other = match (name, camera.projection) {
                (ProjectionName::Perspective, Projection::Perspective { .. })
                | (ProjectionName::Fisheye, Projection::Fisheye { .. })
                | (ProjectionName::Spherical, Projection::Spherical { map: SphereMap::LatLong })
                | (ProjectionName::EqualArea, Projection::Spherical { map: SphereMap::EqualArea }) => None,
                (ProjectionName::Perspective, _) => {
                    Some(Projection::Perspective { vertical_fov: PERSPECTIVE_FOV })
                }
                (ProjectionName::Fisheye, _) => Some(Projection::Fisheye { angle: FISHEYE_ANGLE }),
                (ProjectionName::Spherical, _) => Some(Projection::Spherical { map: SphereMap::LatLong }),
                (ProjectionName::EqualArea, _) => Some(Projection::Spherical { map: SphereMap::EqualArea }),
            };
            if let Some(projection) = other {
                let height = camera.resolution.unwrap_or(SIZE)[1];
                camera.projection = projection;
                camera.shift = glam::Vec2::ZERO;
                camera.crop = None;
                camera.lens = Lens::PINHOLE;
                match name {
                    ProjectionName::Spherical => camera.resolution = Some([height.saturating_mul(2), height]),
                    ProjectionName::EqualArea => camera.resolution = Some([height; 2]),
                    ProjectionName::Perspective | ProjectionName::Fisheye => {}
                }
            }
        }
        let Some(degrees) = self.fov else { return Ok(()) };
        let angle = degrees * (PI / 180.0);
        match &mut camera.projection {
            Projection::Perspective { vertical_fov } if degrees > 0.0 && degrees < 180.0 => {
                *vertical_fov = angle;
            }
            Projection::Perspective { .. } => {
                return Err(Error::option("fov", degrees, "degrees above 0 and below 180 for a perspective"));
            }
            Projection::Fisheye { angle: across } if degrees > 0.0 && degrees <= 360.0 => {
                *across = angle.min(2.0 * PI);
            }
            Projection::Fisheye { .. } => {
                return Err(Error::option("fov", degrees, "degrees above 0 and at most 360 for a fisheye"));
            }
            Projection::Orthographic { .. } | Projection::Spherical { .. } => {
                let expected =
                    "nothing with this camera: only a perspective and a fisheye have a field of view";
                return Err(Error::option("fov", degrees, expected));
            }
        }
        Ok(())
    }

    fn put_lens(&self, camera: &mut Camera) -> Result<()> {
        let said = [
            ("lens_radius", self.lens_radius),
            ("focus_distance", self.focus_distance),
            ("blades", self.blades.map(|blades| blades as f32)),
            ("blade_rotation", self.blade_rotation),
        ];
        let Some((name, value)) = said.into_iter().find_map(|(name, v)| v.map(|v| (name, v))) else {
            return Ok(());
        };
        if !matches!(camera.projection, Projection::Perspective { .. }) {
            return Err(Error::option(
                name,
                value,
                "nothing with this camera: only a perspective has a lens",
            ));
        }
        let lens = &mut camera.lens;
        let had_none = lens.radius == 0.0;
        if let Some(radius) = self.lens_radius {
            if !(radius >= 0.0 && radius.is_finite()) {
                return Err(Error::option("lens_radius", radius, "a length of at least 0 (m)"));
            }
            lens.radius = radius;
        }
        if let Some(distance) = self.focus_distance {
            if !(distance > 0.0 && distance.is_finite()) {
                return Err(Error::option("focus_distance", distance, "a distance above 0 (m)"));
            }
            lens.focus_distance = distance;
        } else if had_none && lens.radius > 0.0 {
            let expected = "it with a focus distance: this camera has no lens that says where it is sharp";
            return Err(Error::option("lens_radius", lens.radius, expected));
        }
        if let Some(count) = self.blades {
            if !(Blades::FEWEST..=Blades::MOST).contains(&count) {
                let expected = format!("{} to {}", Blades::FEWEST, Blades::MOST);
                return Err(Error::option("blades", count, expected));
            }
            let rotation = lens.blades.map_or(0.0, |blades| blades.rotation);
            lens.blades = Some(Blades { count, rotation });
        }
        if let Some(degrees) = self.blade_rotation {
            let Some(blades) = lens.blades.as_mut().filter(|_| degrees.is_finite()) else {
                let expected = "a finite number of degrees, with blades";
                return Err(Error::option("blade_rotation", degrees, expected));
            };
            blades.rotation = degrees * (PI / 180.0);
        }
        let shapes = self.blades.is_some() || self.blade_rotation.is_some() || self.focus_distance.is_some();
        if shapes && lens.radius == 0.0 && self.lens_radius.is_none() {
            let expected = "it with a lens radius: this camera is a pinhole";
            return Err(Error::option(name, value, expected));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::*;
    use crate::film::Window;

    fn camera() -> Camera {
        let camera = Camera::look_at("c", Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.0);
        let crop = Some(Window { x: 1, y: 2, width: 3, height: 4 });
        Camera { shift: Vec2::new(0.1, 0.2), resolution: Some([300, 100]), crop, ..camera }
    }

    fn with(lens: Lens) -> Camera {
        Camera { lens, ..camera() }
    }

    const NOTHING: CameraChange = CameraChange {
        projection: None,
        fov: None,
        lens_radius: None,
        focus_distance: None,
        blades: None,
        blade_rotation: None,
    };

    #[test]
    fn nothing_said_changes_nothing() {
        let lens = Lens { blades: Some(Blades { count: 5, rotation: 1.0 }), ..Lens::round(0.1, 3.0) };
        assert_eq!(NOTHING.of(&with(lens)).unwrap(), with(lens));
        let own = CameraChange { projection: Some(ProjectionName::Perspective), ..NOTHING };
        assert_eq!(own.of(&with(lens)).unwrap(), with(lens), "its own projection");
        let mut metadata = Metadata::default();
        NOTHING.describe(&mut metadata);
        assert_eq!(metadata, Metadata::default());
    }

    #[test]
    fn another_projection_has_a_film_of_its_own() {
        let change = |name| CameraChange { projection: Some(name), ..NOTHING };
        let of = |name| change(name).of(&with(Lens::round(0.1, 3.0))).unwrap();
        let sphere = of(ProjectionName::Spherical);
        assert_eq!(sphere.projection, Projection::Spherical { map: SphereMap::LatLong });
        assert_eq!((sphere.resolution, sphere.crop, sphere.shift), (Some([200, 100]), None, Vec2::ZERO));
        assert_eq!(sphere.lens, Lens::PINHOLE);
        assert_eq!(of(ProjectionName::EqualArea).resolution, Some([100, 100]));
        let unsaid = Camera { resolution: None, ..camera() };
        let sphere = change(ProjectionName::Spherical).of(&unsaid).unwrap();
        assert_eq!(sphere.resolution, Some([720, 360]));
        let fisheye = of(ProjectionName::Fisheye);
        assert_eq!(
            (fisheye.projection, fisheye.resolution),
            (Projection::Fisheye { angle: PI }, Some([300, 100]))
        );
        let back = change(ProjectionName::Perspective).of(&fisheye).unwrap();
        assert_eq!(back.projection, Projection::Perspective { vertical_fov: PERSPECTIVE_FOV });
    }

    #[test]
    fn fields_of_view_are_of_perspectives_and_fisheyes() {
        let fov = |projection, fov| CameraChange { projection, fov: Some(fov), ..NOTHING }.of(&camera());
        let vertical = |degrees| match fov(None, degrees).unwrap().projection {
            Projection::Perspective { vertical_fov } => vertical_fov,
            other => panic!("{other:?}"),
        };
        assert!((vertical(90.0) - 0.5 * PI).abs() < 1e-6);
        let fisheye = Some(ProjectionName::Fisheye);
        assert_eq!(fov(fisheye, 360.0).unwrap().projection, Projection::Fisheye { angle: 2.0 * PI });
        for (projection, degrees) in [(None, 180.0), (None, 0.0), (None, f32::NAN), (fisheye, 361.0)] {
            let said = fov(projection, degrees).unwrap_err().to_string();
            assert!(said.contains("fov") && said.contains("degrees above 0"), "{said}");
        }
        let said = fov(Some(ProjectionName::Spherical), 90.0).unwrap_err().to_string();
        assert!(said.contains("only a perspective and a fisheye"), "{said}");
    }

    #[test]
    fn lenses_are_of_perspectives_and_say_where_they_are_sharp() {
        let lens = |change: CameraChange, before: Lens| change.of(&with(before)).map(|c| c.lens);
        let all = CameraChange {
            lens_radius: Some(0.2),
            focus_distance: Some(3.0),
            blades: Some(6),
            blade_rotation: Some(90.0),
            ..NOTHING
        };
        let found = lens(all, Lens::PINHOLE).unwrap();
        assert_eq!((found.radius, found.focus_distance), (0.2, 3.0));
        let blades = found.blades.unwrap();
        assert!(blades.count == 6 && (blades.rotation - 0.5 * PI).abs() < 1e-6);
        let wider = CameraChange { lens_radius: Some(0.4), ..NOTHING };
        assert_eq!(lens(wider, Lens::round(0.1, 7.0)).unwrap(), Lens::round(0.4, 7.0), "as sharp as before");
        for (change, before, expected) in [
            (wider, Lens::PINHOLE, "with a focus distance"),
            (CameraChange { lens_radius: Some(-1.0), ..NOTHING }, Lens::PINHOLE, "at least 0"),
            (CameraChange { focus_distance: Some(0.0), ..all }, Lens::PINHOLE, "above 0"),
            (CameraChange { blades: Some(2), ..all }, Lens::PINHOLE, "3 to 100"),
            (CameraChange { blades: Some(6), ..NOTHING }, Lens::PINHOLE, "with a lens radius"),
            (CameraChange { blade_rotation: Some(1.0), ..NOTHING }, Lens::round(0.1, 1.0), "with blades"),
            (CameraChange { blade_rotation: Some(f32::NAN), ..all }, Lens::PINHOLE, "finite"),
            (
                CameraChange { projection: Some(ProjectionName::Fisheye), ..all },
                Lens::PINHOLE,
                "only a perspective",
            ),
        ] {
            let said = lens(change, before).unwrap_err().to_string();
            assert!(said.contains(expected), "{said}");
        }
    }

    #[test]
    fn films_name_what_was_said() {
        let change = CameraChange { projection: Some(ProjectionName::Fisheye), fov: Some(200.0), ..NOTHING };
        let mut metadata = Metadata::default();
        change.describe(&mut metadata);
        assert_eq!(metadata.text(keys::CAMERA_PROJECTION), Some("fisheye"));
        assert_ne!(metadata, Metadata::default());
        let mut other = Metadata::default();
        CameraChange { fov: Some(190.0), ..change }.describe(&mut other);
        assert_ne!(metadata, other, "another view is not the same film");
    }
}
