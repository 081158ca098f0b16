//! The fields of one material: numbers brought into range, textures, extensions.

use gltf::json;
use serde::de::DeserializeOwned;

use super::Tint;
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::io::gltf::features::met;
use crate::io::gltf::source::Source;
use crate::io::gltf::textures::{Content, Textures, UsedTexture};
use crate::io::mixes;
use crate::io::notes::shown;
use crate::scene::{Channel, FloatInput, Material, MaterialId, NoteKind, SceneBuilder, Surface};

/// One material being read.
pub(super) struct Reader<'r, 's> {
    source: &'r Source<'s>,
    pub builder: &'r mut SceneBuilder,
    textures: &'r mut Textures,
    /// The material as it stands in the file.
    pub material: &'r json::Material,
    item: String,
    /// Colour of the vertices.
    pub tint: Tint,
    /// The set of texture coordinates of the first texture.
    pub uv_set: Option<u32>,
}

impl<'r, 's> Reader<'r, 's> {
    /// `item` is the place of the material in the file.
    pub fn new(
        source: &'r Source<'s>,
        builder: &'r mut SceneBuilder,
        textures: &'r mut Textures,
        material: &'r json::Material,
        item: String,
        tint: Tint,
    ) -> Self {
        Self { source, builder, textures, material, item, tint, uv_set: None }
    }

    /// The material's name, else its place in the file.
    pub fn name(&self) -> String {
        let name = self.material.name.as_deref().filter(|n| !n.is_empty());
        name.map_or_else(|| self.item.clone(), shown)
    }

    /// Location of a field.
    pub fn at(&self, field: &str) -> Location {
        self.source.at(format!("{}.{field}", self.item))
    }

    /// Reads an extension that the `gltf` crate does not know.
    pub fn extension<T: DeserializeOwned>(&self, name: &str) -> Result<Option<T>> {
        let Some(value) = self.material.extensions.as_ref().and_then(|e| e.others.get(name)) else {
            return Ok(None);
        };
        self.parse(value, &format!("extensions.{name}")).map(Some)
    }

    fn parse<T: DeserializeOwned>(&self, value: &serde_json::Value, field: &str) -> Result<T> {
        T::deserialize(value).map_err(|e| {
            let found = format!("JSON that is no such object ({})", shown(&e.to_string()));
            Error::invalid(self.at(field), found, "the fields that the extension defines")
        })
    }

    /// Reports an extension of this material as the table of features prescribes.
    pub fn met_extension(&mut self, name: &str) -> Result<()> {
        let at = self.at(&format!("extensions.{name}"));
        met("extension", name, at, self.builder)
    }

    /// Reports a field of an extension of this material as the table of features prescribes.
    pub fn met_field(&mut self, extension: &str, field: &str) -> Result<()> {
        let at = self.at(&format!("extensions.{extension}.{field}"));
        met(extension, field, at, self.builder)
    }

    /// Converts the reference to a normal texture to the common form. The `gltf` crate does not
    /// parse its extensions.
    pub fn normal_info(&self, map: &json::material::NormalTexture) -> Result<json::texture::Info> {
        let transform = map.extensions.as_ref().and_then(|e| e.others.get("KHR_texture_transform"));
        let transform = match transform {
            Some(value) => Some(self.parse(value, "normalTexture.extensions.KHR_texture_transform")?),
            None => None,
        };
        Ok(json::texture::Info {
            index: map.index,
            tex_coord: map.tex_coord,
            extensions: transform.map(|t| json::extensions::texture::Info {
                texture_transform: Some(t),
                others: serde_json::Map::new(),
            }),
            extras: None,
        })
    }

    /// A texture, if there is one and its image can be read.
    pub fn texture(
        &mut self,
        field: &str,
        info: Option<&json::texture::Info>,
        content: Content,
    ) -> Result<Option<UsedTexture>> {
        let Some(info) = info else { return Ok(None) };
        let (index, count) = (info.index.value(), self.source.root.textures.len());
        if index >= count {
            let at = self.at(&format!("{field}.index"));
            return Err(Error::invalid(at, format!("texture {index}"), format!("an index below {count}")));
        }
        let item = format!("{}.{field}", self.item);
        let used = self.textures.get(self.source, self.builder, info, content, &item);
        let Some(used) = used else { return Ok(None) };
        if *self.uv_set.get_or_insert(used.uv_set) != used.uv_set {
            met("texture", "texCoord", self.at(field), self.builder)?;
        }
        Ok(Some(used))
    }

    /// A number times a channel of a texture of numbers.
    pub fn textured(
        &mut self,
        factor: f32,
        field: &str,
        info: Option<&json::texture::Info>,
        channel: Channel,
    ) -> Result<FloatInput> {
        let texture = self.texture(field, info, Content::Numbers)?;
        Ok(FloatInput { factor, texture: texture.map(|t| (t.texture, channel)) })
    }

    /// Colour whose channels are brought into `[0, max]`.
    pub fn color(&mut self, field: &str, value: [f32; 3], max: f32) -> Result<Rgb> {
        let mut color = [0.0; 3];
        for (channel, value) in color.iter_mut().zip(value) {
            *channel = self.number(field, value, max)?;
        }
        Ok(color.into())
    }

    /// `value`, brought into `[0, max]` with a note.
    pub fn number(&mut self, field: &str, value: f32, max: f32) -> Result<f32> {
        if !value.is_finite() {
            return Err(Error::invalid(
                self.at(field),
                format!("{value}"),
                "a number that fits into 32 bits",
            ));
        }
        if !(0.0..=max).contains(&value) {
            let message = "factors of materials that are out of range: the nearest allowed is used";
            self.builder.note(NoteKind::Repaired, message, self.at(field));
        }
        Ok(value.clamp(0.0, max))
    }

    /// Adds the surface as a material of its own, below the layer `what`.
    pub fn below(&mut self, surface: Surface, what: &str) -> Result<MaterialId> {
        let name = format!("{} below its {what}", self.name());
        self.builder.add_material(Material::new(name, surface))
    }

    /// Mix of `first` and `second`, in which `second` has the share `amount`. A part with the share
    /// 0 is omitted. `what` names the second part.
    pub fn mix(
        &mut self,
        first: Surface,
        second: Surface,
        amount: FloatInput,
        what: &str,
    ) -> Result<Surface> {
        if amount.factor <= 0.0 {
            return Ok(first);
        }
        if amount.factor >= 1.0 && amount.texture.is_none() {
            return Ok(second);
        }
        let name = self.name();
        let parts = [(format!("{name} without {what}"), first), (format!("{name}, {what}"), second)];
        mixes::mix(self.builder, parts, amount)
    }
}
