//! `<emitter>`s of the scene: point, spot, directional, environments.
//!
//! * Spots look along their own `+z`. They fade linearly in the angle from the axis, from
//!   `beam_width` to `cutoff_angle`. The default of `beam_width` is three quarters of
//!   `cutoff_angle`.
//! * An environment map has its pole at `+y`, with `−z` at `u = 0` and `+x` at `u = 0.25`. The
//!   frame of [`Environment::lat_long`] is half a turn from this. Mitsuba's first and last rows lie
//!   at the poles (`θ = π y / (h − 1)`). Here each row is the centre of a band of height `π / h`.
//!   The two conventions differ by up to half a row.
//! * `sky`, `sun`, `sunsky` become a [`Sky`]. Before Mitsuba 3 up is `+y`, east `+x`, south `+z`;
//!   since then up is `+z`, south `+x`, west `+y`. If place and time are given, [`sun`](super::sun)
//!   computes the sun's direction from them, in the frame of the light.
//!
//! Constant environments add up; of the other environments only the first is used.
//!
//! Held to this by `suite::mitsuba`; axes and falloff were compared with Mitsuba 3.9's own.

use glam::{DMat4, DVec3, Mat3, Vec3};

use super::inputs::Quantity;
use super::object::{Class, Object};
use super::sun::{self, PlaceAndTime};
use super::{Translation, transforms};
use crate::color::Rgb;
use crate::error::Result;
use crate::io::images::Encoding;
use crate::math::elementary::sin_cos;
use crate::scene::sky::{MAX_TURBIDITY, MIN_TURBIDITY, Sky};
use crate::scene::{Emitter, Environment, Falloff, FalloffShape, NoteKind};

/// Size of a sky's image (texels).
const SKY_RESOLUTION: [u32; 2] = [512, 256];

/// Least difference between the cosines of the two angles that a spot fades between.
const MIN_FADING: f32 = 1e-4;

impl<'a> Translation<'a> {
    /// Adds a light of the scene.
    pub(super) fn add_light(&mut self, object: &'a Object) -> Result<()> {
        if object.plugin == "area" {
            // Converted by the shapes that refer to it.
            object.accept_all();
            return Ok(());
        }
        if !self.meet("light", object, "left out")? {
            object.accept_all();
            return Ok(());
        }
        if self.is_left_out("light", object) {
            object.accept_known();
            return Ok(());
        }
        object.accept(&["sampling_weight", "shadow_rays"]);
        self.builder.begin_light(object.id.as_deref().unwrap_or_default());
        match object.plugin.as_str() {
            "point" => {
                let to_world = object.transform("to_world").unwrap_or(DMat4::IDENTITY);
                let position = object.vector("position").unwrap_or(DVec3::ZERO);
                let place = to_world.transform_point3(position);
                let position = place.as_vec3();
                let intensity = self.radiance(object, "intensity", Rgb::WHITE)?;
                self.builder.add_emitter_at(Emitter::Point { position, intensity }, place)
            }
            "spot" => self.spot(object),
            "projector" => self.projector(object),
            "directional" => {
                let to_world = object.transform("to_world").unwrap_or(DMat4::IDENTITY);
                let own = object.vector("direction");
                let direction = own.unwrap_or_else(|| to_world.transform_vector3(DVec3::Z));
                let direction = unit(direction, object);
                let irradiance = self.radiance(object, "irradiance", Rgb::WHITE)?;
                self.builder.add_emitter(Emitter::Directional { direction, irradiance })
            }
            "constant" => {
                let radiance = self.radiance(object, "radiance", Rgb::WHITE)?;
                self.environments.constant += radiance;
                Ok(())
            }
            "envmap" => self.environment_map(object),
            "sky" | "sun" | "sunsky" => self.daylight(object),
            _ => {
                object.accept_known();
                Ok(())
            }
        }
    }

    /// Sets the environment of the scene.
    pub(super) fn finish_environments(&mut self) -> Result<()> {
        if self.environments.hides_constant() {
            let at = crate::error::Location::file(self.files.path());
            self.feature("light", "second environment", &at)?;
        }
        std::mem::take(&mut self.environments).finish(&mut self.builder)
    }

    fn radiance(&mut self, object: &Object, name: &str, missing: Rgb) -> Result<Rgb> {
        self.constant_color(object, &[name], Quantity::Radiance, missing)
    }

    fn spot(&mut self, object: &Object) -> Result<()> {
        let to_world = object.transform("to_world").unwrap_or(DMat4::IDENTITY);
        let intensity = self.radiance(object, "intensity", Rgb::WHITE)?;
        let cutoff = object.float_in("cutoff_angle", 0.0..=180.0).unwrap_or(20.0);
        let beam = object.float_in("beam_width", 0.0..=360.0).unwrap_or(cutoff * 0.75).min(cutoff);
        let cos = |degrees: f64| sin_cos(degrees.to_radians() as f32).1;
        let cos_outer = cos(cutoff).clamp(-1.0, 1.0 - MIN_FADING);
        let cos_inner = cos(beam).clamp(cos_outer + MIN_FADING, 1.0);
        let falloff = Falloff { cos_inner, cos_outer, shape: FalloffShape::LinearInAngle };
        if self.document.texture(object, "texture").is_some() {
            return self.spot_through(object, "texture", (intensity, falloff), cutoff);
        }
        let place = to_world.transform_point3(DVec3::ZERO);
        let position = place.as_vec3();
        let axis = unit(to_world.transform_vector3(DVec3::Z), object);
        self.builder.add_emitter_at(Emitter::Spot { position, axis, intensity, falloff }, place)
    }

    fn environment_map(&mut self, object: &Object) -> Result<()> {
        object.accept(&["cache", "mis_compensation", "gamma"]);
        let scale = object.float_in("scale", 0.0..=1e30).unwrap_or(1.0) as f32;
        let to_world = object.transform("to_world").unwrap_or(DMat4::IDENTITY);
        let reference = object.text("filename").or(object.text("bitmap"));
        let Some(reference) = reference else {
            let message = "environment map without a file: left out";
            self.builder.note(NoteKind::Repaired, message, object.at.clone());
            return Ok(());
        };
        if self.environments.map.is_some() {
            return self.feature("light", "second environment", &object.at).map(drop);
        }
        let reference = self.find(reference, object);
        let image =
            self.images.read(&reference, Encoding::Srgb, object.line_of("filename"), &mut self.builder)?;
        let Some(image) = image else { return Ok(()) };
        let half_turn = Mat3::from_diagonal(Vec3::new(-1.0, 1.0, -1.0));
        let frame = rigid(&to_world, object) * half_turn;
        self.environments.map = Some(Environment::lat_long(image, Rgb::gray(scale), frame));
        Ok(())
    }

    fn daylight(&mut self, object: &Object) -> Result<()> {
        object.accept(&[
            "albedo",
            "resolution",
            "stretch",
            "sun_radius_scale",
            "sun_aperture",
            "complex_sun",
            "extend",
        ]);
        let turbidity = object.float_in("turbidity", 0.0..=100.0).unwrap_or(3.0) as f32;
        if !(MIN_TURBIDITY..=MAX_TURBIDITY).contains(&turbidity) {
            let message = format!("turbidity outside of {MIN_TURBIDITY} to {MAX_TURBIDITY}: moved into it");
            self.builder.note(NoteKind::Approximated, message, object.place_of("turbidity"));
        }
        let scale = |name: &str| {
            let all = object.float_in("scale", 0.0..=1e30).unwrap_or(1.0);
            (object.float_in(name, 0.0..=1e30).unwrap_or(1.0) * all) as f32
        };
        let (sky_scale, sun_scale) = (scale("sky_scale"), scale("sun_scale"));
        let to_world = object.transform("to_world").unwrap_or(DMat4::IDENTITY);
        let frame = rigid(&to_world, object) * self.upright();
        let direction = match object.vector("sun_direction") {
            Some(world) => frame.transpose() * unit(world, object),
            None => self.by_place_and_time(sun::direction(&place_and_time(object)).as_vec3()),
        };
        if direction.y < 0.0 {
            let message = "the sun is below the horizon: moved up to it";
            self.builder.note(NoteKind::Approximated, message, object.at.clone());
        }
        let sky = Sky::new(turbidity, direction);
        if object.plugin != "sun" && sky_scale > 0.0 {
            if self.environments.map.is_some() {
                self.feature("light", "second environment", &object.at)?;
            } else {
                let image = sky.image(SKY_RESOLUTION[0], SKY_RESOLUTION[1]);
                self.environments.map = Some(Environment::lat_long(image, Rgb::gray(sky_scale), frame));
            }
        }
        if object.plugin != "sky" {
            let direction = -(frame * sky.to_sun()).normalize();
            let irradiance = sky.sun_irradiance() * sun_scale;
            self.builder.add_emitter(Emitter::Directional { direction, irradiance })?;
        }
        Ok(())
    }

    /// Converts a direction (east, up, south) that was computed from place and time to the frame of
    /// [`Sky`], whose azimuth is arbitrary.
    fn by_place_and_time(&self, d: Vec3) -> Vec3 {
        // South, west, up is a left-handed frame, so azimuths run the other way round.
        if self.document.version.0 >= 3 { Vec3::new(d.z, d.y, d.x) } else { d }
    }

    /// Rotation from the frame of [`Sky`], with `+y` up, to the file's frame of daylight.
    fn upright(&self) -> Mat3 {
        if self.document.version.0 >= 3 {
            Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y)
        } else {
            Mat3::IDENTITY
        }
    }

    /// Returns true for a light that shapes may have.
    pub(super) fn is_shape_light(object: &Object) -> bool {
        object.class == Class::Emitter && matches!(object.plugin.as_str(), "area" | "directionalarea")
    }
}

fn place_and_time(object: &Object) -> PlaceAndTime {
    let d = sun::DEFAULT;
    let whole = |name: &str, missing: i64| object.integer(name).unwrap_or(missing);
    let hour = object.float_in("hour", 0.0..=24.0).unwrap_or(d.hour);
    let minute = object.float_in("minute", 0.0..=60.0).unwrap_or(0.0);
    let second = object.float_in("second", 0.0..=60.0).unwrap_or(0.0);
    PlaceAndTime {
        latitude: object.float_in("latitude", -90.0..=90.0).unwrap_or(d.latitude),
        longitude: object.float_in("longitude", -360.0..=360.0).unwrap_or(d.longitude),
        timezone: object.float_in("timezone", -24.0..=24.0).unwrap_or(d.timezone),
        year: whole("year", d.year).clamp(-4000, 10_000),
        month: whole("month", d.month).clamp(1, 12),
        day: whole("day", d.day).clamp(1, 31),
        hour: hour + minute / 60.0 + second / 3600.0,
    }
}

/// Returns the unit vector along `v`; `+z`, with a note, if `v` has no direction.
pub(super) fn unit(v: DVec3, object: &Object) -> Vec3 {
    v.try_normalize().map(|v| v.as_vec3().normalize()).unwrap_or_else(|| {
        object.repaired("to_world", "lights without direction: along +z".to_owned());
        Vec3::Z
    })
}

/// Returns the rotation (or reflection) of a transform, without its scale; the identity, with a
/// note, if the transform flattens space.
pub(super) fn rigid(m: &DMat4, object: &Object) -> Mat3 {
    transforms::orthonormal(m).unwrap_or_else(|| {
        object.repaired("to_world", "lights with a transform that flattens space: not turned".to_owned());
        Mat3::IDENTITY
    })
}
