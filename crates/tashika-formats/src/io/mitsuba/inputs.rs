//! Parameters of materials and lights: colours, numbers, textures.
//!
//! | value | as a reflectance | as a radiance |
//! |---|---|---|
//! | `rgb` | itself, clamped to 0 to 1 | itself |
//! | `spectrum`, one number `c` | grey `c` | grey `c`; since version 3 equal energy |
//! | `spectrum`, samples | colour under equal energy, white adapted | integral, not adapted |
//! | `blackbody` | | Planck's law in W·m⁻²·sr⁻¹·nm⁻¹, as `spectrum` |
//!
//! Equal energy is `c (1.205, 0.948, 0.909)`; integrals use the CIE 1931 observer.
//!
//! Texture coordinates of Mitsuba run down from an image's top row, as they do here, so `to_uv`
//! needs no conversion. A checkerboard has two by two squares in the unit square; the first colour
//! fills the square `u, v < ½`.
//!
//! Held to this by `suite::mitsuba`.

use glam::{Mat3, Vec2};

use super::object::{Class, Object, Value};
use super::values::{self, Spectrum};
use super::{Translation, transforms};
use crate::color::Rgb;
use crate::color::spectrum::{blackbody, rgb_of_emission, rgb_of_reflectance};
use crate::error::{Error, Location, Result};
use crate::io::images::Encoding;
use crate::io::mixes;
use crate::io::notes::shown;
use crate::io::textures::{self, whole};
use crate::scene::{
    Channel, ColorInput, FloatInput, ImageTexture, Lookup, NoteKind, Sampling, Texture, UvTransform, Wrap,
};

/// Reflectance that replaces one that cannot be read.
pub(super) const GREY: Rgb = Rgb::gray(mixes::GREY);

/// Wavelengths at which Planck's law is sampled (nm): first, last, step.
const BLACKBODY_NM: [u16; 3] = [360, 830, 5];

/// Equal energy, `X = Y = Z = 1`, in linear Rec. 709 (ITU-R BT.709-6).
const EQUAL_ENERGY: Rgb = Rgb::new(1.204_784, 0.948_301, 0.908_843);

/// Physical meaning of a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Quantity {
    /// From 0 to 1.
    Reflectance,
    /// Emitted.
    Radiance,
    /// At least 0, such as an index of refraction.
    Number,
}

/// A converted texture or colour, with the channel from which numbers are read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Textured {
    pub(super) color: ColorInput,
    pub(super) channel: Channel,
}

impl From<ColorInput> for Textured {
    fn from(color: ColorInput) -> Self {
        Self { color, channel: Channel::Luminance }
    }
}

impl From<Rgb> for Textured {
    fn from(color: Rgb) -> Self {
        ColorInput::from(color).into()
    }
}

impl Textured {
    pub(super) fn number(self) -> FloatInput {
        textures::number(self.color, self.channel)
    }
}

impl Translation<'_> {
    /// Colour of the first parameter among `names` that exists, else `missing`.
    pub(super) fn color(
        &mut self,
        object: &Object,
        names: &[&str],
        quantity: Quantity,
        missing: Rgb,
    ) -> Result<ColorInput> {
        Ok(self.textured(object, names, quantity)?.map_or(missing.into(), |t| t.color))
    }

    /// As [`Self::color`], for inputs that must be constant: a texture is replaced by half its
    /// factor, with a note.
    pub(super) fn constant_color(
        &mut self,
        object: &Object,
        names: &[&str],
        quantity: Quantity,
        missing: Rgb,
    ) -> Result<Rgb> {
        let input = self.color(object, names, quantity, missing)?;
        if input.texture.is_some() {
            let message = format!(
                "{} {:?}: the texture of {:?} is not used",
                object.class.name(),
                shown(&object.plugin),
                names[0]
            );
            self.builder.note(NoteKind::Approximated, message, object.at.clone());
            return Ok(GREY.zip(input.factor, |a, b| a * b));
        }
        Ok(input.factor)
    }

    /// Reads the number of a parameter, or its texture.
    pub(super) fn float(&mut self, object: &Object, name: &str, missing: f32) -> Result<FloatInput> {
        Ok(self.textured(object, &[name], Quantity::Number)?.map_or(missing.into(), Textured::number))
    }

    fn textured(&mut self, object: &Object, names: &[&str], quantity: Quantity) -> Result<Option<Textured>> {
        for name in names {
            if let Some(texture) = self.document.texture(object, name) {
                return self.texture(texture, quantity).map(Some);
            }
            let value = object.take(name, |value| rgb_of(value, quantity));
            if let Some(color) = value {
                return Ok(Some(self.in_range(color, quantity, &object.place_of(name)).into()));
            }
        }
        Ok(None)
    }

    /// Clamps a colour to the range of its quantity, with a note.
    fn in_range(&mut self, color: Rgb, quantity: Quantity, at: &Location) -> Rgb {
        let largest = if quantity == Quantity::Reflectance { 1.0 } else { f32::MAX };
        let clamped = color.map(|c| c.clamp(0.0, largest));
        // Rounding errors are not noted, and neither are radiances outside the gamut of Rec. 709.
        let moved = color.zip(clamped, |a, b| (a - b).abs()).max_channel();
        if moved > 0.01 && quantity != Quantity::Radiance || color.max_channel() < 0.0 {
            let message = "colours out of their range: moved into it";
            self.builder.note(NoteKind::Repaired, message, at.clone());
        }
        clamped
    }

    /// Converts a texture, once for each quantity.
    ///
    /// # Errors
    /// [`Error::Invalid`] if it refers to itself.
    pub(super) fn texture(&mut self, object: &Object, quantity: Quantity) -> Result<Textured> {
        let key = (object.index, quantity);
        if let Some(known) = self.textures.begin(key, object)? {
            return Ok(known);
        }
        let texture = self.nested(object, |inside| inside.convert_texture(object, quantity))?;
        Ok(self.textures.finish(key, texture))
    }

    fn convert_texture(&mut self, object: &Object, quantity: Quantity) -> Result<Textured> {
        if !self.meet("texture", object, "grey of 0.5")? {
            object.accept_all();
            return Ok(GREY.into());
        }
        Ok(match object.plugin.as_str() {
            "bitmap" => self.bitmap(object)?,
            "checkerboard" => {
                let even = self.color(object, &["color0"], quantity, Rgb::gray(0.4))?;
                let odd = self.color(object, &["color1"], quantity, Rgb::gray(0.2))?;
                let squares = Mat3::from_scale(Vec2::splat(2.0));
                let transform = UvTransform(squares * uv_transform(object).0);
                textures::checkerboard(&mut self.builder, even, odd, transform)?.into()
            }
            "gridtexture" | "wireframe" => {
                object.accept_known();
                let names = if object.plugin == "wireframe" {
                    ["interior_color", "color1"]
                } else {
                    ["color0", "background"]
                };
                self.color(object, &names, quantity, Rgb::gray(0.2))?.into()
            }
            "scale" => {
                let scale = self.color(object, &["scale", "value"], Quantity::Number, Rgb::WHITE)?;
                let Some(inner) =
                    self.document.children(object, Class::Texture).find(|(name, _)| *name != "scale")
                else {
                    return self.colour_of_scale(object, quantity, scale);
                };
                let inner = self.texture(inner.1, quantity)?;
                match (inner.color.texture, scale.texture) {
                    (texture, None) => {
                        let color = ColorInput { factor: inner.color.factor * scale.factor, texture };
                        Textured { color, ..inner }
                    }
                    _ => {
                        let builder = &mut self.builder;
                        let (a, b) = (textures::node(builder, inner.color)?, textures::node(builder, scale)?);
                        whole(builder.add_texture(Texture::Product(a, b))?).into()
                    }
                }
            }
            "uniform" => self.color(object, &["value"], quantity, Rgb::WHITE)?.factor.into(),
            "srgb" => self.color(object, &["color", "value"], quantity, GREY)?.factor.into(),
            "d65" => Rgb::gray(object.float("scale").unwrap_or(1.0).max(0.0) as f32).into(),
            "regular" | "irregular" => spectrum_object(object, quantity)?.into(),
            "blackbody" => {
                let temperature = object.float_in("temperature", 0.0..=1e6).unwrap_or(5000.0);
                let value = Value::Blackbody(temperature, object.float("scale").unwrap_or(1.0));
                rgb_of(&value, quantity).unwrap_or(GREY).into()
            }
            _ => {
                object.accept_known();
                GREY.into()
            }
        })
    }

    /// Product of two colours: the value of a `scale` without a nested texture.
    fn colour_of_scale(
        &mut self,
        object: &Object,
        quantity: Quantity,
        scale: ColorInput,
    ) -> Result<Textured> {
        let color = self.color(object, &["texture", "color"], quantity, Rgb::WHITE)?;
        Ok((color.factor * scale.factor).into())
    }

    fn bitmap(&mut self, object: &Object) -> Result<Textured> {
        object.accept(&["accel", "format", "max_anisotropy", "cache", "filter"]);
        let Some(reference) = object.text("filename") else {
            let message = "bitmap without a file: grey of 0.5";
            self.builder.note(NoteKind::Repaired, message, object.at.clone());
            return Ok(GREY.into());
        };
        let encoding = encoding(object);
        let transform = uv_transform(object);
        let Lookup { sampling, wrap } = self.lookup(object)?;
        let reference = self.find(reference, object);
        let at = object.line_of("filename");
        let Some(image) = self.images.load(&reference, encoding, at, &mut self.builder)? else {
            return Ok(GREY.into());
        };
        let channel = match object.text("channel") {
            Some("r") => Channel::R,
            Some("g") => Channel::G,
            Some("b") => Channel::B,
            Some("a") => Channel::A,
            _ => self.images.number_channel(image),
        };
        let node = image.texture(|all| ImageTexture { wrap, transform, sampling, ..all });
        Ok(Textured { color: whole(self.builder.add_texture(node)?), channel })
    }

    /// Sampling and wrapping of a bitmap.
    pub(super) fn lookup(&mut self, object: &Object) -> Result<Lookup> {
        let sampling = match object.text("filter_type").map(str::to_ascii_lowercase).as_deref() {
            Some("nearest") => Sampling::Nearest,
            Some("ewa") => {
                self.feature("texture", "filter ewa", &object.at)?;
                Sampling::Bilinear
            }
            _ => Sampling::Bilinear,
        };
        let both = object.text("wrap_mode");
        let (u, v) = (object.text("wrap_mode_u").or(both), object.text("wrap_mode_v").or(both));
        Ok(Lookup { sampling, wrap: [self.wrap(u, object)?, self.wrap(v, object)?] })
    }

    /// Returns true if a texture is an image with some opacity below 1, and the object selects no
    /// channel.
    pub(super) fn has_alpha(&mut self, object: &Object) -> Result<bool> {
        let reference =
            object.text("filename").filter(|_| object.plugin == "bitmap" && object.text("channel").is_none());
        let Some(reference) = reference else { return Ok(false) };
        let reference = self.find(reference, object);
        let image =
            self.images.load(&reference, encoding(object), object.line_of("filename"), &mut self.builder)?;
        Ok(image.is_some_and(|image| self.images.has_opacity(image)))
    }

    fn wrap(&mut self, mode: Option<&str>, object: &Object) -> Result<Wrap> {
        Ok(match mode.map(str::to_ascii_lowercase).as_deref() {
            Some("clamp") => Wrap::Clamp,
            Some("mirror") => Wrap::Mirror,
            Some("zero" | "black") => Wrap::Black,
            Some("one" | "white") => {
                self.feature("texture", "wrap one", &object.at)?;
                Wrap::Black
            }
            _ => Wrap::Repeat,
        })
    }
}

/// Encoding of an image with integer samples.
pub(super) fn encoding(object: &Object) -> Encoding {
    let raw = object.boolean("raw").unwrap_or(false) | (object.float("gamma") == Some(1.0));
    if raw { Encoding::Linear } else { Encoding::Srgb }
}

/// Colour of a value; `None` if the value is of a type without colour.
pub(super) fn rgb_of(value: &Value, quantity: Quantity) -> Option<Rgb> {
    let samples = |samples: &[(f32, f32)]| match quantity {
        Quantity::Radiance => rgb_of_emission(samples),
        Quantity::Reflectance | Quantity::Number => rgb_of_reflectance(samples),
    };
    match value {
        Value::Rgb(c) => Some(*c),
        Value::Integer(i) => Some(Rgb::gray(*i as f32)),
        Value::Spectrum(Spectrum::Uniform(f)) if quantity == Quantity::Radiance => {
            Some(EQUAL_ENERGY * *f as f32)
        }
        Value::Float(f) | Value::Spectrum(Spectrum::Constant(f) | Spectrum::Uniform(f)) => {
            Some(Rgb::gray(*f as f32))
        }
        Value::Spectrum(Spectrum::Samples(all)) => samples(all),
        Value::Blackbody(temperature, scale) => {
            let [first, last, step] = BLACKBODY_NM;
            let all: Vec<(f32, f32)> = (first..=last)
                .step_by(usize::from(step))
                .map(|nm| (f32::from(nm), blackbody(f32::from(nm), *temperature as f32) * *scale as f32))
                .collect();
            samples(&all)
        }
        Value::Text(text) => values::rgb(text),
        Value::Vector(_) | Value::Boolean(_) | Value::Transform(_) | Value::Animation(..) => None,
    }
    .filter(|c| c.is_finite())
}

/// The colour of a `regular` or `irregular` spectrum.
fn spectrum_object(object: &Object, quantity: Quantity) -> Result<Rgb> {
    let list = |name: &str| object.text(name).and_then(values::numbers);
    let invalid = |found: &str| Error::invalid(object.place(), found, "as many wavelengths (nm) as values");
    let values = list("values").ok_or_else(|| invalid("a spectrum without values"))?;
    let wavelengths = if object.plugin == "regular" {
        let bound = |a: &str, b: &str| object.float(a).or(object.float(b));
        let first = bound("wavelength_min", "lambda_min").unwrap_or(360.0);
        let last = bound("wavelength_max", "lambda_max").unwrap_or(830.0);
        let steps = values.len().saturating_sub(1).max(1) as f64;
        (0..values.len()).map(|i| first + (last - first) * i as f64 / steps).collect()
    } else {
        list("wavelengths").ok_or_else(|| invalid("a spectrum without wavelengths"))?
    };
    if wavelengths.len() != values.len() {
        return Err(invalid(&format!("{} wavelengths for {} values", wavelengths.len(), values.len())));
    }
    let samples = wavelengths.iter().zip(&values).map(|(&w, &v)| (w as f32, v as f32)).collect();
    let samples =
        values::sorted(samples).ok_or_else(|| invalid("a spectrum that is empty or has wavelengths of 0"))?;
    rgb_of(&Value::Spectrum(Spectrum::Samples(samples)), quantity)
        .map(|c| c.map(|v| v.max(0.0)))
        .ok_or_else(|| invalid("a spectrum without colour"))
}

/// `to_uv`, or the scales and offsets of Mitsuba 0.6.
fn uv_transform(object: &Object) -> UvTransform {
    if let Some(matrix) = object.transform("to_uv") {
        return UvTransform(transforms::planar(&matrix));
    }
    let both = object.float("uvscale").unwrap_or(1.0);
    let value = |name: &str, missing: f64| object.float(name).unwrap_or(missing) as f32;
    let offset = [value("uoffset", 0.0), value("voffset", 0.0)];
    textures::scaled([value("uscale", both), value("vscale", both)], offset)
}
