//! `Texture`, and parameters that may name one.
//!
//! pbrt's texture coordinates have `t` running up from an image's bottom row, for images of both
//! formats. The scene's `v` runs down. The loader therefore replaces `t` of each mesh by
//! `v = 1 − t`, and gives each texture the transform
//!
//! ```text
//! image:         (u, v) ↦ (s_u u + d_u,  s_v v + 1 − s_v − d_v)          = (s, 1 − t)
//! checkerboard:  (u, v) ↦ (s_u u + d_u,  −s_v v + s_v + d_v)             = (s, t)
//! ```
//!
//! | format | encoding of images of integers, for colours and numbers alike |
//! |---|---|
//! | v3 | sRGB if `gamma` is true; without `gamma`, sRGB for PNG, TGA and JPEG |
//! | v4 | `encoding` for PNG, by default sRGB; others sRGB |
//!
//! A number that is read from an image is the luminance of the colour; in pbrt-v4 it is the opacity
//! if the image has opacities other than 1. Textures of numbers and textures of colours may have
//! the same names. A texture type without a counterpart here is replaced by a constant, its mean,
//! and noted.
//!
//! Tested by `suite::pbrt_appearance::textures_*`.

use std::collections::BTreeMap;

use super::loading::Loading;
use super::names::Named;
use super::parameters::Parameters;
use super::spectra::{self, Quantity};
use super::version::Version;
use crate::color::Rgb;
use crate::error::{Location, Result};
use crate::io::images::Encoding;
use crate::io::mixes::GREY;
use crate::io::notes::excerpt;
use crate::io::textures::{self, number, product, scaled, upward};
use crate::io::udim::Picture;
use crate::scene::{Channel, ColorInput, FloatInput, ImageTexture, NoteKind, Texture, TextureId, Wrap};

/// Textures that the file has defined, by name.
#[derive(Clone, Debug, Default)]
pub(super) struct Textures {
    colors: BTreeMap<String, ColorInput>,
    floats: BTreeMap<String, FloatInput>,
}

impl Textures {
    /// Returns the names of all textures of numbers, or of colours.
    pub(super) fn names(&self, of_numbers: bool) -> Vec<String> {
        if of_numbers { self.floats.keys().cloned().collect() } else { self.colors.keys().cloned().collect() }
    }

    /// `Texture name type class`: defines a texture.
    pub(super) fn define(
        &mut self,
        loading: &mut Loading<'_>,
        [name, value_type, class]: [&str; 3],
        parameters: &Parameters,
    ) -> Result<()> {
        let at = parameters.at();
        loading.met("texture", class, "a constant grey of 0.5", &at)?;
        match value_type {
            "float" => {
                let value = self.float_texture(loading, class, parameters)?;
                self.floats.insert(name.to_owned(), value);
            }
            "color" | "spectrum" => {
                let value = self.color_texture(loading, class, parameters)?;
                self.colors.insert(name.to_owned(), value);
            }
            other => {
                let message = format!("texture of type {:?}: left out", excerpt(other, 40));
                loading.note_named(NoteKind::Ignored, message, "types of textures", at);
            }
        }
        if Loading::knows("texture", class) {
            loading.note_unused("texture", class, parameters)?;
        }
        Ok(())
    }

    /// Reads a colour or its texture, if the parameter exists.
    pub(super) fn color(
        &self,
        loading: &mut Loading<'_>,
        parameters: &Parameters,
        name: &str,
    ) -> Result<Option<ColorInput>> {
        if let Some(texture) = parameters.texture(name) {
            let found = self.colors.get(texture).copied();
            if found.is_none() {
                missing(loading, Named::Color, texture, parameters.place_of(name));
            }
            return Ok(found);
        }
        Ok(spectra::color(loading, parameters, name, Quantity::Factor)?.map(ColorInput::from))
    }

    /// Reads a number or its texture, if the parameter exists.
    pub(super) fn float(
        &self,
        loading: &mut Loading<'_>,
        parameters: &Parameters,
        name: &str,
    ) -> Option<FloatInput> {
        if let Some(texture) = parameters.texture(name) {
            let found = self.floats.get(texture).copied();
            if found.is_none() {
                missing(loading, Named::Float, texture, parameters.place_of(name));
            }
            return found;
        }
        parameters.float(name).map(FloatInput::from)
    }

    /// Reads a number that may be given as a colour: its luminance.
    pub(super) fn color_or_float(
        &self,
        loading: &mut Loading<'_>,
        parameters: &Parameters,
        name: &str,
    ) -> Result<Option<FloatInput>> {
        let is_float = match parameters.texture(name) {
            Some(texture) => self.floats.contains_key(texture) && !self.colors.contains_key(texture),
            None => parameters.float(name).is_some(),
        };
        if is_float {
            return Ok(self.float(loading, parameters, name));
        }
        Ok(self.color(loading, parameters, name)?.map(|color| number(color, Channel::Luminance)))
    }

    /// Combination of two textures, with numbers as greys; none if `class` is no combination.
    fn combination(
        &self,
        loading: &mut Loading<'_>,
        class: &str,
        p: &Parameters,
        of_numbers: bool,
    ) -> Result<Option<ColorInput>> {
        let mut operand = |name: &str, missing: f32| -> Result<ColorInput> {
            let missing = Rgb::gray(missing).into();
            if !of_numbers {
                return Ok(self.color(loading, p, name)?.unwrap_or(missing));
            }
            let number = self.float(loading, p, name);
            number.map_or(Ok(missing), |number| color_of_float(loading, number))
        };
        let (ends, amount) = match class {
            "mix" | "directionmix" => {
                p.accept(&["dir"]);
                let ends = [operand("tex1", 0.0)?, operand("tex2", 1.0)?];
                let amount = match self.float(loading, p, "amount") {
                    Some(amount) => color_of_float(loading, amount)?,
                    None if of_numbers => Rgb::gray(0.5).into(),
                    None => self.color(loading, p, "amount")?.unwrap_or(Rgb::gray(0.5).into()),
                };
                (ends, amount)
            }
            "checkerboard" => {
                let ends = [operand("tex1", 1.0)?, operand("tex2", 0.0)?];
                return checkerboard(loading, p, ends).map(Some);
            }
            "dots" => {
                let ends = [operand("inside", 1.0)?, operand("outside", 0.0)?];
                p.accept_known();
                (ends, Rgb::gray(0.5).into())
            }
            _ => return Ok(None),
        };
        textures::mix(&mut loading.builder, ends, amount).map(Some)
    }

    fn color_texture(&self, loading: &mut Loading<'_>, class: &str, p: &Parameters) -> Result<ColorInput> {
        if let Some(combination) = self.combination(loading, class, p, false)? {
            return Ok(combination);
        }
        let gray = |v: f32| ColorInput::from(Rgb::gray(v));
        Ok(match class {
            "constant" => self.color(loading, p, "value")?.unwrap_or(gray(1.0)),
            "imagemap" => {
                let (texture, factor) = image(loading, p)?;
                ColorInput { factor: Rgb::gray(factor), texture: Some(texture.0) }
            }
            "scale" => {
                let (a, b) = match self.color(loading, p, "tex1")? {
                    Some(first) => (first, self.color(loading, p, "tex2")?.unwrap_or(gray(1.0))),
                    None => {
                        let scale = self.float(loading, p, "scale").unwrap_or(1.0.into());
                        let scale = color_of_float(loading, scale)?;
                        let other = self.color(loading, p, "tex")?.or(self.color(loading, p, "tex2")?);
                        (other.unwrap_or(gray(1.0)), scale)
                    }
                };
                product(&mut loading.builder, a, b)?
            }
            "bilerp" => {
                let mut sum = Rgb::BLACK;
                for (name, default) in [("v00", 0.0), ("v01", 1.0), ("v10", 0.0), ("v11", 1.0)] {
                    let value = spectra::color(loading, p, name, Quantity::Factor)?;
                    sum += value.unwrap_or(Rgb::gray(default));
                }
                p.accept_known();
                (sum * 0.25).into()
            }
            "marble" => {
                p.accept_known();
                MARBLE.into()
            }
            _ => {
                p.accept_known();
                gray(GREY)
            }
        })
    }

    fn float_texture(&self, loading: &mut Loading<'_>, class: &str, p: &Parameters) -> Result<FloatInput> {
        if let Some(combination) = self.combination(loading, class, p, true)? {
            return Ok(number(combination, Channel::Luminance));
        }
        Ok(match class {
            "constant" => self.float(loading, p, "value").unwrap_or(1.0.into()),
            "imagemap" => {
                let (texture, factor) = image(loading, p)?;
                FloatInput { factor, texture: Some(texture) }
            }
            "scale" => {
                let first = self.float(loading, p, "tex1").or(self.float(loading, p, "tex"));
                let second = self.float(loading, p, "tex2").or(self.float(loading, p, "scale"));
                match (first.unwrap_or(1.0.into()), second.unwrap_or(1.0.into())) {
                    (a, FloatInput { factor, texture: None }) | (FloatInput { factor, texture: None }, a) => {
                        FloatInput { factor: a.factor * factor, ..a }
                    }
                    (a, b) => {
                        let (a, b) = (color_of_float(loading, a)?, color_of_float(loading, b)?);
                        number(product(&mut loading.builder, a, b)?, Channel::Luminance)
                    }
                }
            }
            "bilerp" => {
                let corners = [("v00", 0.0), ("v01", 1.0), ("v10", 0.0), ("v11", 1.0)];
                let sum: f32 = corners.iter().map(|(name, default)| p.float(name).unwrap_or(*default)).sum();
                p.accept_known();
                (0.25 * sum).into()
            }
            _ => {
                p.accept_known();
                GREY.into()
            }
        })
    }
}

/// Mean of the colours in pbrt's marble.
const MARBLE: Rgb = Rgb::new(0.45, 0.44, 0.48);

fn missing(loading: &mut Loading<'_>, of: Named, name: &str, at: Location) {
    loading.names.miss(of, name, &at);
    let message = format!("texture {:?} is not defined: the default is used", excerpt(name, 60));
    loading.note_named(NoteKind::Repaired, message, "textures are not defined", at);
}

/// Converts a number to a grey.
fn color_of_float(loading: &mut Loading<'_>, input: FloatInput) -> Result<ColorInput> {
    let factor = Rgb::gray(input.factor);
    Ok(match input.texture {
        None => factor.into(),
        Some((texture, Channel::A)) => {
            let message = "opacities of images in textures made of others: their luminance is used";
            let at = Location::file(loading.files.path());
            loading.note(NoteKind::Approximated, message, at);
            ColorInput { factor, texture: Some(texture) }
        }
        Some((texture, _)) => ColorInput { factor, texture: Some(texture) },
    })
}

fn checkerboard(loading: &mut Loading<'_>, p: &Parameters, ends: [ColorInput; 2]) -> Result<ColorInput> {
    p.accept(&["aamode"]);
    if p.integer("dimension") == Some(3) {
        loading.note(NoteKind::Approximated, "checkerboards of three dimensions: their mean is used", p.at());
        p.accept_known();
        return textures::mix(&mut loading.builder, ends, Rgb::gray(0.5).into());
    }
    let ([su, sv], [du, dv]) = mapping(loading, p)?;
    let [even, odd] = ends;
    textures::checkerboard(&mut loading.builder, even, odd, scaled([su, -sv], [du, sv + dv]))
}

/// Reads scales and offsets of the coordinates.
fn mapping(loading: &mut Loading<'_>, p: &Parameters) -> Result<([f32; 2], [f32; 2])> {
    let mapping = p.string("mapping").unwrap_or("uv").to_owned();
    loading.met("mapping", &mapping, "uv is used", &p.at())?;
    if mapping != "uv" {
        p.accept(&["v1", "v2", "udelta", "vdelta", "uscale", "vscale"]);
        return Ok(([1.0; 2], [0.0; 2]));
    }
    let number = |name, default| p.float(name).unwrap_or(default);
    Ok(([number("uscale", 1.0), number("vscale", 1.0)], [number("udelta", 0.0), number("vdelta", 0.0)]))
}

/// Reads an image map; returns it with the channel of its numbers, and its scale.
fn image(loading: &mut Loading<'_>, p: &Parameters) -> Result<((TextureId, Channel), f32)> {
    let scale = p.float("scale").unwrap_or(1.0);
    // Filtering has no counterpart: images are looked up at points.
    p.accept(&["filter", "maxanisotropy", "trilinear"]);
    let wrap = match p.string("wrap").unwrap_or("repeat") {
        "repeat" => Wrap::Repeat,
        "clamp" => Wrap::Clamp,
        "black" => Wrap::Black,
        other => {
            if other != "octahedralsphere" {
                let message = format!("wrap {:?} is unknown: repeat", excerpt(other, 40));
                loading.note_named(NoteKind::Ignored, message, "wraps", p.at());
            }
            Wrap::Repeat
        }
    };
    let (scale_uv, offset) = mapping(loading, p)?;
    let transform = upward(scale_uv, offset);
    let invert = p.boolean("invert").unwrap_or(false);
    let name = p.string("filename").unwrap_or_default().to_owned();
    let encoding = encoding(loading, p, &name);
    let image = match name.as_str() {
        "" => {
            let message = "image maps without filename: a grey of 0.5 is used";
            loading.note(NoteKind::Repaired, message, p.at());
            None
        }
        name => loading.images.load(name, encoding, &p.place_of("filename"), &mut loading.builder)?,
    };
    let Some(image) = image else {
        let grey = loading.builder.add_texture(Texture::Constant(Rgb::gray(GREY)))?;
        return Ok(((grey, Channel::Luminance), 1.0));
    };
    let texture = image.texture(|all| ImageTexture { wrap: [wrap; 2], transform, ..all });
    let mut texture = loading.builder.add_texture(texture)?;
    let channel = number_channel(loading, image);
    let mut factor = scale;
    if invert {
        // 1 − scale · t, as a blend from white to 1 − scale.
        let ends = [Rgb::WHITE, Rgb::gray(1.0 - scale)];
        texture = textures::between(&mut loading.builder, ends, texture)?;
        factor = 1.0;
    }
    Ok(((texture, if invert { Channel::Luminance } else { channel }), factor))
}

/// Reads the encoding of an image of integers.
fn encoding(loading: &mut Loading<'_>, p: &Parameters, name: &str) -> Encoding {
    let lower = name.to_ascii_lowercase();
    let ends = |endings: &[&str]| endings.iter().any(|ending| lower.ends_with(ending));
    let srgb = match loading.version {
        Version::V3 => p.boolean("gamma").unwrap_or(ends(&[".png", ".tga", ".jpg", ".jpeg"])),
        Version::V4 => match p.string("encoding") {
            Some("linear") => !ends(&[".png"]),
            Some("sRGB") | None => true,
            Some(other) => {
                if !other.starts_with("gamma") {
                    let message = format!("encoding {:?} is unknown: sRGB", excerpt(other, 40));
                    loading.note_named(NoteKind::Ignored, message, "encodings", p.at());
                } else {
                    loading.note(NoteKind::Approximated, "encodings by a gamma: sRGB", p.at());
                }
                true
            }
        },
    };
    if srgb { Encoding::Srgb } else { Encoding::Linear }
}

/// Channel of an image that holds its numbers.
fn number_channel(loading: &Loading<'_>, image: Picture) -> Channel {
    if loading.version == Version::V4 && loading.images.has_opacity(image) {
        Channel::A
    } else {
        loading.images.number_channel(image)
    }
}
