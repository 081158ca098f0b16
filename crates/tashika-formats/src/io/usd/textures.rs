//! Textures: `UsdUVTexture`, whose value is `scale · texel + bias`, and the images of MaterialX.
//!
//! Held to this by `usd_materials` and `usd_materialx` of the suite.

use std::collections::BTreeMap;

use glam::Mat3;

use super::Stage;
use super::features::met;
use super::layers::{LayerId, Layers, Place};
use super::network::Source;
use super::prim::Prim;
use super::value::Text;
use crate::color::Rgb;
use crate::error::{Location, Result};
use crate::io::assets::{decode, decode_colors, kind, reason, unreadable_image};
use crate::io::images::Encoding;
use crate::io::textures::between;
use crate::io::udim::Picture;
use crate::scene::{Channel, Image, NoteKind, TextureId, Wrap};

/// Images in archives, by place and encoding. For an unreadable image, the reason is stored.
pub(super) type Packed = BTreeMap<(Place, Encoding), Result<Picture, (NoteKind, String)>>;

/// Use of a texture's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    Color,
    Number,
    Normal,
}

/// A texture in use.
#[derive(Clone, Debug)]
pub(super) struct Lookup {
    pub texture: TextureId,
    /// Factors on red, green, blue and opacity.
    pub scale: [f32; 4],
    /// Channel that is connected, if the value is a number.
    pub channel: Channel,
    /// Name of the texture coordinates that it uses.
    pub uv: Text,
}

/// Channel that is read as a number from the output of a `UsdUVTexture` or a MaterialX node. If the
/// output has several channels, the first is read.
pub(super) fn channel_of(output: &str) -> Channel {
    match output {
        "g" | "outg" | "outy" => Channel::G,
        "b" | "outb" | "outz" => Channel::B,
        "a" | "outa" | "outw" => Channel::A,
        _ => Channel::R,
    }
}

/// Result of reading a texture.
pub(super) enum Found {
    Texture(Lookup),
    /// Value in place of a texture that could not be read.
    Fallback([f32; 4]),
}

impl Stage<'_> {
    /// A decoded picture for callers that store it; none, with a note, if it cannot be read.
    pub fn picture_itself(&mut self, file: &str, layer: LayerId, at: &Location) -> Result<Option<Image>> {
        let place = self.composer.layers.place(file, layer);
        let bytes = self.composer.layers.read(&place, at);
        let options = self.composer.layers.files.options().clone();
        let decoded =
            bytes.and_then(|b| decode_colors(b.get(), file, Encoding::Srgb, &options, at, &mut self.builder));
        Ok(match decoded {
            Ok(image) => Some(image),
            Err(error) => {
                let message = unreadable_image(file, &reason(&error), "left out");
                self.builder.note(kind(&error), message, at.clone());
                None
            }
        })
    }

    /// A whole picture as a texture; none, with a note, if it cannot be read.
    pub fn whole_texture(
        &mut self,
        file: &str,
        layer: LayerId,
        encoding: Encoding,
        at: &Location,
    ) -> Result<Option<TextureId>> {
        match self.picture(file, layer, encoding, at)? {
            Ok(picture) => self.builder.add_texture(picture.texture(|how| how)).map(Some),
            Err((kind, why)) => {
                self.builder.note(kind, unreadable_image(file, &why, "left out"), at.clone());
                Ok(None)
            }
        }
    }

    /// A picture of the scene, decoded once for each encoding.
    fn picture(
        &mut self,
        file: &str,
        layer: LayerId,
        encoding: Encoding,
        at: &Location,
    ) -> Result<Result<Picture, (NoteKind, String)>> {
        let place = self.composer.layers.place(file, layer);
        if !Layers::is_packed(&place) {
            return self.images.find(&place.name, encoding, at, &mut self.builder);
        }
        let key = (place, encoding);
        if let Some(known) = self.packed.get(&key) {
            return Ok(known.clone());
        }
        let options = self.composer.layers.files.options().clone();
        let bytes = self.composer.layers.read(&key.0, at);
        let decoded = bytes.and_then(|b| decode(b.get(), file, encoding, &options, at, &mut self.builder));
        let found = match decoded {
            Ok(decoded) => {
                self.image_budget.take(decoded.image.bytes() as u64, at)?;
                Ok(Picture::Image(self.builder.add_image(decoded.image)?))
            }
            Err(error) => Err((kind(&error), reason(&error))),
        };
        self.packed.insert(key, found.clone());
        Ok(found)
    }

    /// Value of an output of a `UsdUVTexture`.
    pub fn texture(&mut self, shader: &Prim, output: &str, content: Content) -> Result<Found> {
        let fallback = self.input_tuple(shader, "inputs:fallback", [0.0, 0.0, 0.0, 1.0])?.map(|n| n as f32);
        let Some(picture) = self.picture_of(shader, content)? else { return Ok(Found::Fallback(fallback)) };
        let at = self.at_property(shader, "inputs:file");
        // The default of USD is the mode that the image file states. Image files state none, which
        // means black. The default of MaterialX is to repeat.
        let wrap = if self.shader(shader)?.starts_with("ND_") { Wrap::Repeat } else { Wrap::Black };
        let wrap = [self.wrap(shader, "inputs:wrapS", wrap)?, self.wrap(shader, "inputs:wrapT", wrap)?];
        let (uv, transform) = self.coordinates(shader, "inputs:st", Mat3::IDENTITY)?;
        let mut texture = self.builder.add_texture(picture.texture(|mut how| {
            (how.wrap, how.transform) = (wrap, transform);
            how
        }))?;
        let scale = self.input_tuple(shader, "inputs:scale", [1.0; 4])?.map(|n| n as f32);
        let bias = self.input_tuple(shader, "inputs:bias", [0.0; 4])?.map(|n| n as f32);
        let channel = channel_of(output);
        let rgb = |v: [f32; 4]| Rgb::new(v[0], v[1], v[2]);
        if content == Content::Normal {
            let is_usual = scale[..3] == [2.0; 3] && bias[..3] == [-1.0; 3];
            let is_plain = scale[..3] == [1.0; 3] && bias[..3] == [0.0; 3];
            if is_plain && !picture.has_values_below_zero(&self.builder) {
                // The texels are from 0 to 1, and the map to the range from −1 to 1 is missing.
                met("UsdUVTexture", "scale and bias of normals", at, &mut self.builder)?;
            } else if !is_usual {
                // The normal is `scale · texel + bias`, but the scene decodes `2 · texel − 1`. Each
                // texel is therefore replaced so that `2 · new texel − 1 = scale · texel + bias`.
                let ends = [rgb(bias), rgb(bias) + rgb(scale)];
                let ends = ends.map(|end| (end + Rgb::WHITE) * 0.5);
                texture = between(&mut self.builder, ends, texture)?;
            }
            return Ok(Found::Texture(Lookup { texture, scale: [1.0; 4], channel, uv }));
        }
        let mut factor = scale;
        if bias[..3] != [0.0; 3] || scale[..3].iter().any(|s| *s < 0.0) {
            let ends = [rgb(bias), rgb(bias) + rgb(scale)];
            let is_valid = |end: &Rgb| end.is_valid() || (content == Content::Number && end.is_finite());
            if channel != Channel::A && ends.iter().all(is_valid) {
                texture = between(&mut self.builder, ends, texture)?;
                factor = [1.0; 4];
            } else {
                met("UsdUVTexture", "bias below 0 or of opacity", at, &mut self.builder)?;
            }
        } else if channel == Channel::A && bias[3] != 0.0 {
            met("UsdUVTexture", "bias below 0 or of opacity", at, &mut self.builder)?;
        }
        Ok(Found::Texture(Lookup { texture, scale: factor.map(|s| s.max(0.0)), channel, uv }))
    }

    /// Value of a MaterialX texture node: `image`, `tiledimage` or glTF's image.
    pub fn image(&mut self, shader: &Prim, content: Content) -> Result<Found> {
        let fallback = self.plain_input(shader, "inputs:default")?;
        let fallback = fallback.and_then(|value| match (value.tuple::<3>(), value.number()) {
            (Some([r, g, b]), _) => Some([r, g, b, 1.0]),
            (None, Some(n)) => Some([n, n, n, 1.0]),
            (None, None) => value.tuple::<4>(),
        });
        let fallback = fallback.unwrap_or([0.0, 0.0, 0.0, 1.0]).map(|n| n as f32);
        let Some(picture) = self.picture_of(shader, content)? else { return Ok(Found::Fallback(fallback)) };
        let wrap = [
            self.wrap(shader, "inputs:uaddressmode", Wrap::Repeat)?,
            self.wrap(shader, "inputs:vaddressmode", Wrap::Repeat)?,
        ];
        let placed = self.placed(shader)?;
        let (uv, transform) = self.coordinates(shader, "inputs:texcoord", placed)?;
        let texture = self.builder.add_texture(picture.texture(|mut how| {
            (how.wrap, how.transform) = (wrap, transform);
            how
        }))?;
        Ok(Found::Texture(Lookup { texture, scale: [1.0; 4], channel: Channel::R, uv }))
    }

    /// Picture of a texture shader; none, with a note, if there is no file or it cannot be read.
    fn picture_of(&mut self, shader: &Prim, content: Content) -> Result<Option<Picture>> {
        let (owner, name) = self.owner(shader, "inputs:file")?;
        let at = self.at_property(&owner, &name);
        let file = match self.source(shader, "inputs:file")? {
            Some(Source::Value(value)) => value.text().cloned().filter(|file| !file.is_empty()),
            _ => None,
        };
        let layer = self.asset(&owner, &name)?.map(|(_, layer)| layer);
        let layer = layer.or_else(|| shader.opinions().first().map(|opinion| opinion.0));
        let (Some(file), Some(layer)) = (file, layer) else {
            self.builder.note(NoteKind::Repaired, "textures without a file: their fallback is used", at);
            return Ok(None);
        };
        let encoding = match self.color_space(shader)?.as_deref() {
            Some("raw") => Encoding::Linear,
            Some("sRGB") => Encoding::Srgb,
            _ if content == Content::Color => Encoding::Srgb,
            _ => {
                if content == Content::Number && !self.shader(shader)?.starts_with("ND_") {
                    met("UsdUVTexture", "sourceColorSpace auto", at.clone(), &mut self.builder)?;
                }
                Encoding::Linear
            }
        };
        match self.picture(&file, layer, encoding, &at)? {
            Ok(picture) => Ok(Some(picture)),
            Err((kind, why)) => {
                self.builder.note(kind, unreadable_image(&file, &why, "its fallback is used"), at);
                Ok(None)
            }
        }
    }

    /// Colour space of an image: the one that the texture shader states, or else the one that the
    /// input `file` states.
    fn color_space(&mut self, shader: &Prim) -> Result<Option<Text>> {
        let said = self.input_word(shader, "inputs:sourceColorSpace")?.filter(|word| &**word != "auto");
        if said.is_some() {
            return Ok(said);
        }
        let (owner, name) = self.owner(shader, "inputs:file")?;
        let of_file = self.field(&owner, &name, |property| property.color_space.clone());
        Ok(of_file.map(|space| {
            let is_raw =
                matches!(&*space, "raw" | "Raw" | "data" | "identity" | "none") || space.starts_with("lin");
            if is_raw { Text::from("raw") } else { Text::from("sRGB") }
        }))
    }

    fn wrap(&mut self, shader: &Prim, name: &str, fallback: Wrap) -> Result<Wrap> {
        Ok(match self.input_word(shader, name)?.as_deref() {
            None => fallback,
            Some("clamp") => Wrap::Clamp,
            Some("mirror") => Wrap::Mirror,
            Some("repeat" | "periodic") => Wrap::Repeat,
            // `black`, `constant`, and `useMetadata`, because image files have no such metadata.
            Some(_) => Wrap::Black,
        })
    }
}
