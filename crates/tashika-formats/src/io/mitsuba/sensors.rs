//! Conversion of `<sensor>`s to cameras.
//!
//! Mitsuba's cameras look along their own `+z`, `+y` up, with `+x` to the *left*; those here look
//! along `−z`, with `+x` to the right. Half a turn about `y` converts one to the other. The field
//! of view belongs to the axis of `fov_axis`:
//!
//! ```text
//!   tan(fov_y / 2) = tan(fov / 2) · h / e      e = w (x), h (y), √(w² + h²) (diagonal), min or max of w and h
//! ```
//!
//! `focal_length` is relative to the diagonal of a film of 36 mm × 24 mm. A crop of the film
//! (`crop_*`) becomes a [`Window`]; the field of view remains that of the whole film. An
//! orthographic film is two units wide before `to_world`.
//!
//! A camera whose `to_world` is an `<animation>` is blurred while its shutter is open, from
//! `shutter_open` to `shutter_close` (s), unless another time is requested.
//!
//! `spherical` (0.6) looks along `(sin φ sin θ, cos θ, −cos φ sin θ)` with `φ = 2π u`, `θ = π v`,
//! where `v` is counted from the top. After half a turn about `y`, these are the directions of
//! [`Projection::Spherical`].
//!
//! Held to this by `suite::mitsuba`; directions, axes, offsets and windows were compared with
//! Mitsuba 3.9's own.

use std::f64::consts::PI;

use glam::{DAffine3, DMat4, DVec3, Vec2};

use super::Translation;
use super::object::{Class, Object};
use super::transforms;
use super::values::number;
use crate::error::{Error, Result};
use crate::film::Window;
use crate::io::notes::shown;
use crate::math::elementary::{atan2, tan};
use crate::math::motion::Track;
use crate::scene::{Camera, Lens, NoteKind, Projection, SphereMap};

/// Diagonal of a film of 36 mm × 24 mm (mm).
const FULL_FRAME_DIAGONAL: f64 = 43.266_615_305_567_87;

/// Mitsuba's default size of a film (pixels).
const DEFAULT_SIZE: [u32; 2] = [768, 576];

/// Largest size of a film (pixels).
const MAX_SIZE: i64 = 1 << 20;

impl<'a> Translation<'a> {
    /// Adds a sensor.
    pub(super) fn add_sensor(&mut self, object: &'a Object) -> Result<()> {
        if !self.meet("camera", object, "a pinhole")? {
            object.accept_all();
        }
        let document = self.document;
        if self.is_left_out("camera", object) {
            object.accept_known();
            return Ok(());
        }
        if object.plugin == "batch" {
            object.accept_known();
            return self.nested(object, |inside| {
                for (_, nested) in document.children(object, Class::Sensor) {
                    inside.add_sensor(nested)?;
                }
                Ok(())
            });
        }
        object.accept(&["near_clip", "far_clip", "kc", "x", "y", "srf", "radial_distortion"]);
        for (_, sampler) in document.children(object, Class::Sampler) {
            self.without_effect(sampler)?;
        }
        let medium = self.medium_about(object)?;
        let ([width, height], crop) = self.film(object)?;
        let (width_f, height_f) = (f64::from(width), f64::from(height));
        let to_world = object.transform("to_world").unwrap_or(DMat4::IDENTITY);
        if to_world.determinant() == 0.0 {
            let message = "cameras with a transform that flattens space: left out";
            self.builder.note(NoteKind::Repaired, message, object.line_of("to_world").clone());
            object.accept_known();
            return Ok(());
        }
        let half_turn = DMat4::from_scale(DVec3::new(-1.0, 1.0, -1.0));
        let to_world = transforms::affine_f64(&(to_world * half_turn));
        let is_orthographic = matches!(object.plugin.as_str(), "orthographic" | "telecentric");
        let projection = if is_orthographic {
            object.accept(&["fov", "fov_axis", "focus_distance", "aperture_radius"]);
            Projection::Orthographic { height: (2.0 * height_f / width_f) as f32 }
        } else if object.plugin == "spherical" {
            Projection::Spherical { map: SphereMap::LatLong }
        } else {
            Projection::Perspective { vertical_fov: self.vertical_fov(object, width_f, height_f)? }
        };
        let offset = |name: &str| object.float_in(name, -1e3..=1e3).unwrap_or(0.0) as f32;
        let shift = Vec2::new(offset("principal_point_offset_x"), -offset("principal_point_offset_y"));
        let lens = self.lens(object)?;
        let name = self.camera_name(object);
        let resolution = Some([width, height]);
        let camera = Camera {
            shift,
            lens,
            resolution,
            crop,
            medium,
            ..Camera::new(name, to_world.as_affine3a(), projection)
        };
        let camera = self.exposed(object, camera, &transforms::affine_f64(&half_turn))?;
        self.builder.add_camera_at(camera, to_world)
    }

    /// Sets the motion of a camera while its shutter is open. The shutter times are those that the
    /// user requests, or else those in the file. `axes` maps the axes of cameras here to Mitsuba's.
    fn exposed(&mut self, object: &Object, camera: Camera, axes: &DAffine3) -> Result<Camera> {
        let time = |name: &str| object.float_in(name, -1e30..=1e30).unwrap_or(0.0);
        let mut own = [time("shutter_open"), time("shutter_close")];
        if own[0] > own[1] {
            let message = "shutters that close before they open: the other way around";
            object.repaired("shutter_close", message.to_owned());
            own.reverse();
        }
        let (Some((track, at)), Some(shutter)) =
            (object.track("to_world"), self.files.options().exposure(Some(own)))
        else {
            return Ok(camera);
        };
        match track.after(*axes).filter(Track::keeps_sides) {
            Some(track) => {
                self.blurred.push(at.clone());
                Ok(camera.moving(track, shutter))
            }
            None => Ok(camera),
        }
    }

    /// Times at which the shutter of the first sensor opens and closes (s); they apply to all
    /// moving shapes.
    pub(super) fn shutter(&self) -> [f64; 2] {
        let document = self.document;
        let mut sensors = document.roots.iter().map(|&root| &document.objects[root]);
        let Some(first) = sensors.find(|object| object.class == Class::Sensor) else {
            return [0.0; 2];
        };
        let time = |name: &str| first.float(name).filter(|seconds| seconds.abs() <= 1e30).unwrap_or(0.0);
        let [open, close] = [time("shutter_open"), time("shutter_close")];
        [open.min(close), open.max(close)]
    }

    fn lens(&mut self, object: &Object) -> Result<Lens> {
        let pinhole = Lens::PINHOLE;
        let focus_distance = object.float_in("focus_distance", 1e-30..=1e30);
        if object.plugin != "thinlens" {
            object.accept(&["aperture_radius"]);
            return Ok(pinhole);
        }
        let radius = object.float_in("aperture_radius", 0.0..=1e30).unwrap_or(0.0) as f32;
        match focus_distance {
            Some(distance) => Ok(Lens::round(radius, distance as f32)),
            None if radius == 0.0 => Ok(pinhole),
            None => {
                let message = "thin lens without focus_distance: a pinhole";
                self.builder.note(NoteKind::Repaired, message, object.at.clone());
                Ok(pinhole)
            }
        }
    }

    /// The vertical field of view (radians) of a camera or projector with an image of this size.
    pub(super) fn vertical_fov(&mut self, object: &Object, width: f64, height: f64) -> Result<f32> {
        let diagonal = (width * width + height * height).sqrt();
        let (half, extent) = match (object.float_in("fov", 1e-3..=179.999), object.text("focal_length")) {
            (Some(degrees), _) => {
                let extent = match object.text("fov_axis").unwrap_or("x") {
                    "y" => height,
                    "diagonal" => diagonal,
                    "smaller" => width.min(height),
                    "larger" => width.max(height),
                    "x" => width,
                    other => {
                        let message = format!("fov_axis {:?} is unknown: x", shown(other));
                        self.builder.note(NoteKind::Repaired, message, object.place_of("fov_axis"));
                        width
                    }
                };
                (f64::from(tan((degrees * PI / 360.0) as f32)), extent)
            }
            (None, text) => {
                object.accept(&["fov_axis"]);
                let text = text.unwrap_or("50mm");
                let length = number(text.trim().trim_end_matches("mm")).filter(|l| (1e-3..=1e6).contains(l));
                let length = length.ok_or_else(|| {
                    let found = format!("focal_length = {:?}", shown(text));
                    Error::invalid(object.place_of("focal_length"), found, "a length such as \"50mm\"")
                })?;
                (FULL_FRAME_DIAGONAL / (2.0 * length), diagonal)
            }
        };
        Ok(2.0 * atan2((half * height / extent) as f32, 1.0))
    }

    /// Reads size and window of the film.
    fn film(&mut self, object: &Object) -> Result<([u32; 2], Option<Window>)> {
        let document = self.document;
        let Some((_, film)) = document.children(object, Class::Film).next() else {
            return Ok((DEFAULT_SIZE, None));
        };
        self.meet("film", film, "its size and window")?;
        let size = |name: &str, missing: i64, least: i64| {
            let value = film.integer(name).unwrap_or(missing);
            let moved = value.clamp(least, MAX_SIZE);
            if moved != value {
                film.repaired(name, format!("film: {name} = {value} is out of range: {moved}"));
            }
            moved as u32
        };
        let [width, height] = DEFAULT_SIZE.map(i64::from);
        let (width, height) = (size("width", width, 1), size("height", height, 1));
        let window = Window {
            x: size("crop_offset_x", 0, 0),
            y: size("crop_offset_y", 0, 0),
            width: size("crop_width", i64::from(width), 1),
            height: size("crop_height", i64::from(height), 1),
        };
        let whole = Window { x: 0, y: 0, width, height };
        let is_inside = window.x + window.width <= width && window.y + window.height <= height;
        let window = if is_inside { window } else { whole };
        if !is_inside {
            film.repaired("crop_width", "film: the crop reaches beyond the film: the whole film".to_owned());
        }
        // The other parameters of films describe image files, which the user chooses here.
        for (_, filter) in document.children(film, Class::Filter) {
            self.without_effect(filter)?;
        }
        self.without_effect(film)?;
        Ok(([width, height], (window != whole).then_some(window)))
    }

    /// Name of a camera: its id, or a number, made unique.
    fn camera_name(&mut self, object: &Object) -> String {
        let count = self.camera_names.len();
        let mut name = object.id.as_deref().map_or_else(|| format!("camera-{count}"), shown);
        while self.camera_names.contains(&name) {
            name.push_str(&format!("-{count}"));
        }
        self.camera_names.insert(name.clone());
        name
    }
}
