//! Layers on the opaque surface.
//!
//! Sheen lies on the opaque surface ([`Sheen`](crate::bsdf::Sheen)), and a clear coat over both
//! ([`CoatModel::Layer`]). Each layer of the table then replaces a share of the surface below it,
//! from the lowest layer up, in the order of glTF. `m` is the metalness.
//!
//! | extension | share | of |
//! |---|---|---|
//! | diffuse transmission | `diffuseTransmissionFactor · (1 − m)` | diffuse, transmitting only |
//! | transmission | `transmissionFactor · (1 − m)` | glass, without thickness or solid |
//!
//! Glass is solid where `KHR_materials_volume` gives it a thickness. The tint of glass without
//! thickness, smooth or rough, is the base colour. Each time that light crosses the surface of
//! solid glass, it is multiplied by
//!
//! ```text
//! baseColorFactor · attenuationColor^(thicknessFactor / (2 · attenuationDistance))
//! ```
//!
//! which is Lambert–Beer's law over the thickness for light that crosses the surface twice.
//!
//! # Limits
//! The tint of solid glass has no texture. Transmitting surfaces have no sheen and no coat. Sheen
//! and coat do not dim the emission below them.
//!
//! Held to this by `gltf_materials::transmission_*`, `gltf_materials::clear_coats_*`,
//! `gltf_materials::sheen_*`,
//! `gltf_materials::leaves_*`.

use super::fields::{Clearcoat, DiffuseTransmission, Sheen, Volume};
use super::opaque::Opaque;
use super::reader::Reader;
use crate::bsdf::{CoatModel, MIN_SHEEN_ROUGHNESS};
use crate::color::Rgb;
use crate::error::Result;
use crate::io::dielectrics::{rendered, single_face};
use crate::io::gltf::textures::Content;
use crate::io::textures::{between, product, whole};
use crate::math::elementary::powf;
use crate::scene::{Channel, ColorInput, FloatInput, NoteKind, Surface};

/// Largest roughness at which a pane counts as smooth; chosen. The blur at this roughness is not
/// visible through a window.
const SMOOTH_ROUGHNESS: f32 = 0.1;

const SHEEN: &str = "KHR_materials_sheen";
const COAT: &str = "KHR_materials_clearcoat";
const LEAF: &str = "KHR_materials_diffuse_transmission";
const GLASS: &str = "KHR_materials_transmission";
const VOLUME: &str = "KHR_materials_volume";

/// The surface of a material with all its layers.
pub(super) fn surface(reader: &mut Reader<'_, '_>, opaque: &Opaque) -> Result<Surface> {
    if !opaque.takes_layers {
        return Ok(opaque.surface);
    }
    let surface = sheen(reader, opaque)?;
    let surface = coat(reader, surface)?;
    let surface = leaf(reader, opaque, surface)?;
    glass(reader, opaque, surface)
}

fn sheen(reader: &mut Reader<'_, '_>, opaque: &Opaque) -> Result<Surface> {
    let Some(sheen) = reader.extension::<Sheen>(SHEEN)? else { return Ok(opaque.surface) };
    let field = |name: &str| format!("extensions.{SHEEN}.{name}");
    let factor = reader.color(&field("sheenColorFactor"), sheen.sheen_color_factor, 1.0)?;
    if factor.is_black() {
        return Ok(opaque.surface);
    }
    if reader.material.emissive_factor.0 != [0.0; 3] {
        reader.met_field(SHEEN, "emissiveFactor")?;
    }
    let name = "sheenRoughnessFactor";
    let roughness = reader.number(&field(name), sheen.sheen_roughness_factor, 1.0)?;
    if roughness < MIN_SHEEN_ROUGHNESS {
        reader.met_field(SHEEN, name)?;
    }
    let (name, info) = (field("sheenRoughnessTexture"), sheen.sheen_roughness_texture.as_ref());
    let roughness = reader.textured(roughness, &name, info, Channel::A)?;
    let (name, info) = (field("sheenColorTexture"), sheen.sheen_color_texture.as_ref());
    let texture = reader.texture(&name, info, Content::Color)?.map(|t| t.texture);
    let base = reader.below(opaque.surface, "sheen")?;
    Ok(Surface::Sheen { base, color: ColorInput { factor, texture }, roughness })
}

fn coat(reader: &mut Reader<'_, '_>, below: Surface) -> Result<Surface> {
    let Some(coat) = reader.extension::<Clearcoat>(COAT)? else { return Ok(below) };
    let field = |name: &str| format!("extensions.{COAT}.{name}");
    let factor = reader.number(&field("clearcoatFactor"), coat.clearcoat_factor, 1.0)?;
    if factor == 0.0 {
        return Ok(below);
    }
    if coat.clearcoat_normal_texture.is_some() {
        reader.met_field(COAT, "clearcoatNormalTexture")?;
    }
    if reader.material.emissive_factor.0 != [0.0; 3] {
        reader.met_field(COAT, "emissiveFactor")?;
    }
    let name = "clearcoatRoughnessFactor";
    let roughness = reader.number(&field(name), coat.clearcoat_roughness_factor, 1.0)?;
    let (name, info) = (field("clearcoatTexture"), coat.clearcoat_texture.as_ref());
    let amount = reader.textured(factor, &name, info, Channel::R)?;
    let (name, info) = (field("clearcoatRoughnessTexture"), coat.clearcoat_roughness_texture.as_ref());
    let roughness = reader.textured(roughness, &name, info, Channel::G)?;
    let alpha = reader.builder.power(roughness, 2.0)?;
    let base = reader.below(below, "coat")?;
    Ok(Surface::Clearcoat { base, amount, alpha, model: CoatModel::Layer })
}

fn leaf(reader: &mut Reader<'_, '_>, opaque: &Opaque, below: Surface) -> Result<Surface> {
    let Some(leaf) = reader.extension::<DiffuseTransmission>(LEAF)? else { return Ok(below) };
    let field = |name: &str| format!("extensions.{LEAF}.{name}");
    let name = field("diffuseTransmissionFactor");
    let factor = reader.number(&name, leaf.diffuse_transmission_factor, 1.0)?;
    if factor == 0.0 {
        return Ok(below);
    }
    reader.met_extension(LEAF)?;
    bare(reader, below)?;
    let name = field("diffuseTransmissionColorFactor");
    let color = reader.color(&name, leaf.diffuse_transmission_color_factor, 1.0)?;
    let name = field("diffuseTransmissionColorTexture");
    let texture = reader.texture(&name, leaf.diffuse_transmission_color_texture.as_ref(), Content::Color)?;
    let transmittance = ColorInput { factor: color, texture: texture.map(|t| t.texture) };
    let through = Surface::Translucent { reflectance: Rgb::BLACK.into(), transmittance };
    let (name, info) = (field("diffuseTransmissionTexture"), leaf.diffuse_transmission_texture.as_ref());
    let amount = share(reader, opaque, factor, &name, info, Channel::A)?;
    reader.mix(below, through, amount, "diffuse transmission")
}

fn glass(reader: &mut Reader<'_, '_>, opaque: &Opaque, below: Surface) -> Result<Surface> {
    let extensions = reader.material.extensions.as_ref();
    let Some(glass) = extensions.and_then(|e| e.transmission.as_ref()) else { return Ok(below) };
    let field = |name: &str| format!("extensions.{GLASS}.{name}");
    let factor = reader.number(&field("transmissionFactor"), glass.transmission_factor.0, 1.0)?;
    if factor == 0.0 || opaque.ior == 0.0 {
        return Ok(below);
    }
    bare(reader, below)?;
    let info = glass.transmission_texture.as_ref();
    let amount = share(reader, opaque, factor, &field("transmissionTexture"), info, Channel::R)?;
    let ior = rendered(opaque.ior);
    let reflectance = opaque.specular;
    let surface = match absorption(reader)? {
        Some(absorption) => {
            if opaque.base_color.texture.is_some() {
                reader.met_field(VOLUME, "baseColorTexture")?;
            }
            let transmittance = opaque.base_color.factor * absorption;
            let facets = opaque.glass_facets(reader)?;
            Surface::Glass { ior, reflectance, transmittance, facets }
        }
        None => {
            let is_rough = opaque.roughness.factor > SMOOTH_ROUGHNESS;
            let facets = if is_rough {
                opaque.glass_facets(reader)?
            } else {
                reader.met_field(GLASS, "thicknessFactor")?;
                0.0.into()
            };
            let (ior, reflectance) = (single_face(ior), reflectance.into());
            Surface::ThinGlass { ior, reflectance, transmittance: opaque.base_color, facets }
        }
    };
    reader.mix(below, surface, amount, "glass")
}

/// Notes that the layer that replaces a share of `below` does not have the sheen and the coat of
/// `below`.
fn bare(reader: &mut Reader<'_, '_>, below: Surface) -> Result<()> {
    if matches!(below, Surface::Clearcoat { .. }) {
        reader.met_field(COAT, "transmissionFactor")?;
    }
    // Sheen may lie below the coat.
    if reader.extension::<Sheen>(SHEEN)?.is_some_and(|sheen| sheen.sheen_color_factor != [0.0; 3]) {
        reader.met_field(SHEEN, "transmissionFactor")?;
    }
    Ok(())
}

/// Transmittance of each crossing of the surface of a solid; none for a surface without thickness.
fn absorption(reader: &mut Reader<'_, '_>) -> Result<Option<Rgb>> {
    let Some(volume) = reader.extension::<Volume>(VOLUME)? else { return Ok(None) };
    let field = |name: &str| format!("extensions.{VOLUME}.{name}");
    let thickness = reader.number(&field("thicknessFactor"), volume.thickness_factor, f32::MAX)?;
    if thickness == 0.0 {
        return Ok(None);
    }
    if volume.thickness_texture.is_some() {
        reader.met_field(VOLUME, "thicknessTexture")?;
    }
    let color = reader.color(&field("attenuationColor"), volume.attenuation_color, 1.0)?;
    let Some(distance) = volume.attenuation_distance.filter(|_| color != Rgb::WHITE) else {
        return Ok(Some(Rgb::WHITE));
    };
    let distance = reader.number(&field("attenuationDistance"), distance, f32::MAX)?;
    if distance == 0.0 {
        let message = "attenuation distances that are not above 0: nothing is absorbed";
        reader.builder.note(NoteKind::Repaired, message, reader.at(&field("attenuationDistance")));
        return Ok(Some(Rgb::WHITE));
    }
    reader.met_field(VOLUME, "attenuationDistance")?;
    // A finite exponent keeps powers of 0 and 1 exact.
    let exponent = (0.5 * thickness / distance).min(f32::MAX);
    Ok(Some(color.map(|c| powf(c, exponent))))
}

/// `factor · texture · (1 − metalness)`, with the given channel of `info` as the texture.
fn share(
    reader: &mut Reader<'_, '_>,
    opaque: &Opaque,
    factor: f32,
    field: &str,
    info: Option<&gltf::json::texture::Info>,
    channel: Channel,
) -> Result<FloatInput> {
    let metallic = opaque.metallic;
    let Some((metal, metal_channel)) = metallic.texture.filter(|_| metallic.factor > 0.0) else {
        return reader.textured(factor * (1.0 - metallic.factor), field, info, channel);
    };
    let rest = between(reader.builder, [Rgb::WHITE, Rgb::gray(1.0 - metallic.factor)], metal)?;
    let content = Content::Spread(if channel == Channel::A { 3 } else { 0 });
    let texture = reader.texture(field, info, content)?.map(|t| t.texture);
    let product = product(reader.builder, ColorInput { factor: Rgb::WHITE, texture }, whole(rest))?;
    Ok(FloatInput { factor, texture: product.texture.map(|t| (t, metal_channel)) })
}
