//! Materials: the core of metallic-roughness, and the layers that extensions put on it.
//!
//! | module | purpose |
//! |---|---|
//! | [`reader`] | fields of one material, brought into range; textures |
//! | [`fields`] | fields of extensions |
//! | [`opaque`] | the opaque surface: metallic-roughness, specular-glossiness, unlit |
//! | [`layers`] | sheen, clear coat, diffuse transmission, transmission |
//!
//! A material is read when a primitive first uses it. If primitives use it with different vertex
//! colours, it is read once for each of these colours. The vertex colour multiplies the base colour
//! and the opacity.
//!
//! # Limits
//! A material uses one set of texture coordinates, that of its first texture; others are noted. The
//! frame of a normal map is that of the mesh's texture coordinates: a `KHR_texture_transform` that
//! turns or mirrors the map does not turn the frame.
//!
//! # Held to this by
//! `gltf::metallic_roughness_with_index_and_specular`, `gltf::emission_is_factor_times_strength`,
//! `gltf::alpha_modes`, `gltf_materials`.

mod fields;
mod layers;
mod opaque;
mod reader;

use std::collections::BTreeMap;

use gltf::json;
use gltf::json::material::AlphaMode as FileAlphaMode;
use gltf::json::validation::Checked;

use self::opaque::Opaque;
use self::reader::Reader;
use super::features::met;
use super::source::Source;
use super::textures::{Content, Textures, UsedTexture};
use crate::error::{Error, Result};
use crate::scene::{
    Alpha, AlphaMode, Channel, ColorInput, Emission, FloatInput, Material, MaterialId, NormalInput,
    SceneBuilder,
};

/// Factors of a vertex colour on the red, green, blue and opacity of a material.
pub(super) type Tint = [f32; 4];

/// Tint without effect.
pub(super) const NO_TINT: Tint = [1.0; 4];

/// A material in use.
#[derive(Clone, Copy, Debug)]
pub(super) struct UsedMaterial {
    /// Id of the material in the scene.
    pub id: MaterialId,
    /// Set of texture coordinates for its textures, or for the direction of its brushed facets;
    /// none if it has neither.
    pub uv_set: Option<u32>,
    /// True if its facets are brushed.
    pub is_brushed: bool,
}

/// The materials read so far, by index (none is glTF's default material) and tint.
#[derive(Default)]
pub(super) struct Materials {
    used: BTreeMap<(Option<usize>, [u32; 4]), UsedMaterial>,
    textures: Textures,
}

impl Materials {
    /// The material of that index, or the default one, with the finite `tint`.
    pub fn get(
        &mut self,
        source: &Source<'_>,
        builder: &mut SceneBuilder,
        index: Option<usize>,
        tint: Tint,
    ) -> Result<UsedMaterial> {
        let key = (index, tint.map(f32::to_bits));
        if let Some(used) = self.used.get(&key) {
            return Ok(*used);
        }
        let default = json::Material::default();
        let material = index.map_or(&default, |i| &source.root.materials[i]);
        let item = index.map_or_else(|| "default material".to_owned(), |i| format!("materials[{i}]"));
        let mut reader = Reader::new(source, builder, &mut self.textures, material, item, tint);
        let material = read(&mut reader)?;
        let is_brushed = material.tangent.is_some();
        let uv_set = reader.uv_set.or(is_brushed.then_some(0));
        let used = UsedMaterial { uv_set, is_brushed, id: builder.add_material(material)? };
        self.used.insert(key, used);
        Ok(used)
    }
}

fn read(reader: &mut Reader<'_, '_>) -> Result<Material> {
    let opaque = Opaque::read(reader)?;
    let surface = layers::surface(reader, &opaque)?;
    let material = Material {
        emission: emission(reader)?,
        alpha: alpha(reader, opaque.opacity, opaque.texture, opaque.texture_lost)?,
        normal: normal(reader)?,
        tangent: opaque.tangent,
        ..Material::new(reader.name(), surface)
    };
    if reader.material.occlusion_texture.is_some() {
        met("material", "occlusionTexture", reader.at("occlusionTexture"), reader.builder)?;
    }
    Ok(material)
}

fn emission(reader: &mut Reader<'_, '_>) -> Result<Option<Emission>> {
    let material = reader.material;
    let extension = material.extensions.as_ref().and_then(|e| e.emissive_strength.as_ref());
    let strength = match extension {
        Some(e) => {
            let field = "extensions.KHR_materials_emissive_strength.emissiveStrength";
            reader.number(field, e.emissive_strength.0, f32::MAX)?
        }
        None => 1.0,
    };
    // glTF forbids factors above 1, but files from before `KHR_materials_emissive_strength` have
    // them.
    let factor = reader.color("emissiveFactor", material.emissive_factor.0, f32::MAX)? * strength;
    if !factor.is_finite() {
        return Err(Error::invalid(
            reader.at("emissiveFactor"),
            "an emission beyond all numbers",
            "a finite product of factor and strength",
        ));
    }
    if factor.is_black() {
        return Ok(None);
    }
    let texture = reader.texture("emissiveTexture", material.emissive_texture.as_ref(), Content::Color)?;
    let radiance = ColorInput { factor, texture: texture.map(|t| t.texture) };
    Ok(Some(Emission { radiance, two_sided: material.double_sided }))
}

/// Opacity `factor · A(texture)`; none if it is one everywhere, if the file declares the material
/// opaque, or if the texture could not be read (`lost`).
fn alpha(
    reader: &mut Reader<'_, '_>,
    factor: f32,
    texture: Option<UsedTexture>,
    lost: bool,
) -> Result<Option<Alpha>> {
    let material = reader.material;
    let mode = match material.alpha_mode {
        Checked::Valid(FileAlphaMode::Mask) => {
            let cutoff = material.alpha_cutoff.map_or(0.5, |c| c.0);
            AlphaMode::Mask { cutoff: reader.number("alphaCutoff", cutoff, f32::MAX)? }
        }
        Checked::Valid(FileAlphaMode::Blend) => AlphaMode::Blend,
        Checked::Valid(FileAlphaMode::Opaque) | Checked::Invalid => return Ok(None),
    };
    let texture = texture.filter(|t| !t.opaque).map(|t| (t.texture, Channel::A));
    let everywhere = match mode {
        AlphaMode::Mask { cutoff } => factor >= cutoff,
        AlphaMode::Blend | AlphaMode::Unseen => factor >= 1.0,
    };
    if lost || (texture.is_none() && everywhere) {
        return Ok(None);
    }
    Ok(Some(Alpha { value: FloatInput { factor, texture }, mode }))
}

/// The normal map. glTF's `+y` is up in the image, where `v` runs down, as in [`NormalInput::Map`].
fn normal(reader: &mut Reader<'_, '_>) -> Result<Option<NormalInput>> {
    let Some(map) = &reader.material.normal_texture else { return Ok(None) };
    if !map.scale.is_finite() {
        let at = reader.at("normalTexture.scale");
        return Err(Error::invalid(at, format!("{}", map.scale), "a number that fits into 32 bits"));
    }
    let info = reader.normal_info(map)?;
    let texture = reader.texture("normalTexture", Some(&info), Content::Numbers)?;
    Ok(texture.map(|t| NormalInput::Map { texture: t.texture, scale: map.scale }))
}
