//! Cameras: focal length and apertures, a lens where there is an f-stop.
//!
//! With the focal length `f` and the apertures `w`, `h` in tenths of the scene's unit,
//!
//! ```text
//! vertical field of view = 2 atan(h / 2f)     radius of the lens = f / (20 fStop) units
//! ```
//!
//! An orthographic camera sees `h` tenths of a unit. The aperture's width gives the horizontal
//! offset its scale; the picture's own shape is that of its pixels. Clipping is not used.
//!
//! Held to this by `usd_materials::cameras_have_their_field_of_view_lens_and_offset`.

use glam::Vec2;

use super::Stage;
use super::prim::Prim;
use super::walk::State;
use crate::error::{Error, Result};
use crate::io::cameras::{rigid, unique};
use crate::io::notes::shown;
use crate::math::elementary::atan2_f64;
use crate::scene::{Camera, Lens, Projection};

impl Stage<'_> {
    /// Adds a camera; those of prototypes are none of the scene.
    pub fn add_camera(&mut self, prim: &Prim, state: &State) -> Result<()> {
        if state.is_prototype {
            return Ok(());
        }
        let number = |stage: &mut Self, name: &str, fallback: f64| -> Result<f64> {
            let number = stage.number_or(prim, name, fallback)?;
            if number > 0.0 {
                return Ok(number);
            }
            Err(Error::invalid(stage.at_property(prim, name), format!("{number}"), "a number above 0"))
        };
        let focal = number(self, "focalLength", 50.0)?;
        let width = number(self, "horizontalAperture", 20.955)?;
        let height = number(self, "verticalAperture", 15.2908)?;
        let is_flat = self.word(prim, "projection")?.is_some_and(|word| &*word == "orthographic");
        // In metres.
        let tenth = 0.1 * self.meters_per_unit;
        let projection = if is_flat {
            Projection::Orthographic { height: (height * tenth) as f32 }
        } else {
            Projection::Perspective { vertical_fov: (2.0 * atan2_f64(0.5 * height, focal)) as f32 }
        };
        let to_world = rigid(&state.to_world).ok_or_else(|| {
            Error::invalid(
                self.at(prim),
                "a camera with a transform of rank below 2",
                "one that keeps directions",
            )
        })?;
        // As the program's users know it: its own name, unless another camera has it.
        let name = unique(shown(prim.name()), &mut self.camera_names);
        let mut camera = Camera::new(name, to_world.as_affine3a(), projection);
        let offsets = [
            self.number_or(prim, "horizontalApertureOffset", 0.0)? / width,
            self.number_or(prim, "verticalApertureOffset", 0.0)? / height,
        ];
        camera.shift = Vec2::from(offsets.map(|offset| offset as f32));
        let (stop, focus) =
            (self.number_or(prim, "fStop", 0.0)?, self.number_or(prim, "focusDistance", 0.0)?);
        if stop > 0.0 && focus > 0.0 && !is_flat {
            let radius = 0.5 * focal * tenth / stop;
            camera.lens = Lens::round(radius as f32, (focus * self.meters_per_unit) as f32);
        }
        self.builder.add_camera_at(camera, to_world)
    }
}
