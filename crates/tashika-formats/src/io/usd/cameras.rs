//! Cameras: field of view from focal length and apertures, and a thin lens if an f-stop is set.
//!
//! With the focal length `f` and the apertures `w`, `h` in tenths of the scene's unit,
//!
//! ```text
//! vertical field of view = 2 atan(h / 2f)     radius of the lens = f / (20 fStop) units
//! ```
//!
//! The view of an orthographic camera is `h` tenths of a unit high. The width `w` only scales the
//! horizontal offset, because the aspect ratio is that of the image in pixels. Clipping planes are
//! ignored.
//!
//! Held to this by `usd_materials::cameras_have_their_field_of_view_lens_and_offset`.

use glam::Vec2;

use super::Stage;
use super::prim::Prim;
use super::walk::State;
use crate::error::Result;
use crate::io::cameras::{rigid, unique};
use crate::io::notes::shown;
use crate::math::elementary::atan2_f64;
use crate::scene::{Camera, Lens, NoteKind, Projection};

/// Note on cameras that cannot make a picture.
const UNUSABLE: &str =
    "cameras whose focal length or aperture is not above 0, or whose transform loses directions: left out";

impl Stage<'_> {
    /// Adds a camera; cameras of prototypes are ignored.
    pub fn add_camera(&mut self, prim: &Prim, state: &State) -> Result<()> {
        if state.is_prototype {
            return Ok(());
        }
        let focal = self.number_or(prim, "focalLength", 50.0)?;
        let width = self.number_or(prim, "horizontalAperture", 20.955)?;
        let height = self.number_or(prim, "verticalAperture", 15.2908)?;
        let to_world = rigid(&state.to_world);
        let (Some(to_world), true) = (to_world, [focal, width, height].iter().all(|n| *n > 0.0)) else {
            let at = self.at(prim);
            self.builder.note(NoteKind::Repaired, UNUSABLE, at);
            return Ok(());
        };
        let is_flat = self.word(prim, "projection")?.is_some_and(|word| &*word == "orthographic");
        // A tenth of a unit (m).
        let tenth = 0.1 * self.meters_per_unit;
        let projection = if is_flat {
            Projection::Orthographic { height: (height * tenth) as f32 }
        } else {
            Projection::Perspective { vertical_fov: (2.0 * atan2_f64(0.5 * height, focal)) as f32 }
        };
        let mut camera = Camera::new(String::new(), to_world.as_affine3a(), projection);
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
        // Name by which users select the camera: that of the prim, made unique.
        camera.name = unique(shown(prim.name()), &mut self.camera_names);
        if self.builder.add_camera_at(camera, to_world).is_err() {
            let at = self.at(prim);
            self.builder.note(NoteKind::Repaired, UNUSABLE, at);
        }
        Ok(())
    }
}
