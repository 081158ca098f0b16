//! Lights that shine through an image: `projector`, and `spot` with a texture.
//!
//! ```text
//! projector   I(ω) = π · scale · irradiance(u, v) / cos³ θ       tan at the rim by fov, fov_axis, focal_length
//! spot        I(ω) = intensity · texture(u, v) · falloff(θ)      tan at the rim: that of cutoff_angle
//! ```
//!
//! Both look along their own `+z`. The columns of a projector's image go from `+x` to `−x` and its
//! rows from `+y` to `−y`, as a camera in its place would see it. The columns of a spot's image go
//! from `−x` to `+x` and its rows from `−y` to `+y`.
//!
//! A slide is a `bitmap`, with its filter and wrapping; other textures are approximated by a
//! constant, with a note. All slides together may hold at most as many bytes as one file
//! ([`LoadOptions::max_file_bytes`](crate::io::LoadOptions)).
//!
//! Held to this by `suite::light_images`, with intensities computed by Mitsuba 3.9.

use std::sync::Arc;

use glam::{DMat4, DVec3, Mat3, Vec3};

use super::Translation;
use super::inputs::{GREY, Quantity, encoding};
use super::lights::{rigid, unit};
use super::object::Object;
use crate::color::Rgb;
use crate::error::Result;
use crate::io::images::one_texel;
use crate::io::lights::{BYTES_OF_TEXEL, add_image_light};
use crate::math::elementary::tan;
use crate::scene::{
    Emitter, Falloff, Image, IntensityMap, Lookup, NoteKind, Sampling, SlideWeight, Spread, Wrap,
};

/// Largest cutoff angle of a spot that can shine through an image (degrees).
const WIDEST: f64 = 89.0;

impl Translation<'_> {
    /// Adds a projector, whose image shines as a slide.
    pub(super) fn projector(&mut self, object: &Object) -> Result<()> {
        let scale = object.float_in("scale", 0.0..=1e30).unwrap_or(1.0) as f32;
        let to_world = object.transform("to_world").unwrap_or(DMat4::IDENTITY);
        let (image, lookup) = self.slide(object, "irradiance")?;
        let (width, height) = (f64::from(image.width), f64::from(image.height));
        let half = tan(0.5 * self.vertical_fov(object, width, height)?);
        let tan = [half * (width / height) as f32, half];
        let intensity = Rgb::gray(std::f32::consts::PI * scale);
        let turned = Mat3::from_diagonal(Vec3::new(-1.0, -1.0, 1.0));
        let frame = rigid(&to_world, object) * turned;
        let spread = Spread::Slide { tan, weight: SlideWeight::Screen };
        let place = to_world.transform_point3(DVec3::ZERO);
        self.add_slide(object, IntensityMap::new(image, spread, lookup), place, intensity, frame)
    }

    /// Adds a spot that shines through the texture of that name.
    pub(super) fn spot_through(
        &mut self,
        object: &Object,
        texture: &str,
        (intensity, falloff): (Rgb, Falloff),
        cutoff: f64,
    ) -> Result<()> {
        let to_world = object.transform("to_world").unwrap_or(DMat4::IDENTITY);
        let place = to_world.transform_point3(DVec3::ZERO);
        if cutoff > WIDEST {
            let message = "textures of spots with a cutoff beyond 89°: left out";
            self.builder.note(NoteKind::Approximated, message, object.place_of("cutoff_angle"));
            let axis = unit(to_world.transform_vector3(DVec3::Z), object);
            let position = place.as_vec3();
            return self.builder.add_emitter_at(Emitter::Spot { position, axis, intensity, falloff }, place);
        }
        let (image, lookup) = self.slide(object, texture)?;
        let half = tan(cutoff.to_radians() as f32);
        let spread = Spread::Slide { tan: [half; 2], weight: SlideWeight::Spot(falloff) };
        let frame = rigid(&to_world, object);
        self.add_slide(object, IntensityMap::new(image, spread, lookup), place, intensity, frame)
    }

    fn add_slide(
        &mut self,
        object: &Object,
        map: Option<IntensityMap>,
        place: DVec3,
        intensity: Rgb,
        to_world: Mat3,
    ) -> Result<()> {
        // A black image has no map.
        let Some(map) = map.map(Arc::new) else { return Ok(()) };
        add_image_light(&mut self.builder, &map, (place, to_world), intensity, object.at.clone())
    }

    /// Image of a parameter, with its sampling and wrapping; a constant is one texel.
    fn slide(&mut self, object: &Object, name: &str) -> Result<(Image, Lookup)> {
        let document = self.document;
        let Some(texture) = document.texture(object, name).filter(|texture| texture.plugin == "bitmap")
        else {
            let color = self.constant_color(object, &[name], Quantity::Radiance, GREY)?;
            return Ok(constant(color));
        };
        self.meet("texture", texture, "grey of 0.5")?;
        let texture_lookup = self.lookup(texture)?;
        if texture.transform("to_uv").is_some() {
            let message = "to_uv of the images of lights: left out";
            self.builder.note(NoteKind::Approximated, message, texture.place_of("to_uv"));
        }
        texture.accept(&["accel", "format", "max_anisotropy", "cache", "filter", "channel", "gamma", "raw"]);
        let Some(reference) = texture.text("filename") else {
            let message = "bitmap without a file: grey of 0.5";
            self.builder.note(NoteKind::Repaired, message, texture.at.clone());
            return Ok(constant(GREY));
        };
        let reference = self.find(reference, texture);
        let encoding = encoding(texture);
        let image = self.images.read(&reference, encoding, texture.line_of("filename"), &mut self.builder)?;
        let Some(image) = image else { return Ok(constant(GREY)) };
        let bytes = image.pixels.len() as u64 * BYTES_OF_TEXEL;
        self.slides.take(bytes, &object.place())?;
        Ok((image, texture_lookup))
    }
}

fn constant(color: Rgb) -> (Image, Lookup) {
    (one_texel("constant", color), Lookup { sampling: Sampling::Nearest, wrap: [Wrap::Clamp; 2] })
}
