//! The opaque surface of a material.
//!
//! A dielectric's reflectance at normal incidence is, with `n` from `KHR_materials_ior` (default
//! 1.5, so 0.04) and the rest from `KHR_materials_specular` (default 1),
//!
//! ```text
//! F₀ = min( ((n − 1) / (n + 1))² · specularColorFactor , 1 ) · specularColorTexture
//! ```
//!
//! The factor `s = specularFactor · specularTexture` scales all of this reflection. The surface
//! therefore is a mix of a Lambert surface and a reflecting one. The latter is chosen with
//! probability `p = 1 − (1 − s)(1 − m)` and has the metalness `m / p`. If `m` is above zero and `m`
//! or `s` is textured, `s` scales `F₀` only.
//!
//! The extension dims the base by `1 − F` of the brightest channel of the reflection, but the
//! surface here dims it by `1 − F` of each channel. With a tint, the two differ by the factor
//! `(1 − max F₀) / (1 − F₀)` in each channel, which does not depend on the angle. The base colour
//! of a dielectric is multiplied by this factor; for a metalness above 0, the difference is only
//! noted.
//!
//! `KHR_materials_anisotropy` of strength `s` has the roughnesses `α_t = α + (1 − α) s²` along its
//! direction and `α_b = α` across.
//!
//! `KHR_materials_pbrSpecularGlossiness` becomes, with `s` its specular colour and `g` its
//! glossiness,
//!
//! ```text
//! base colour = diffuse · (1 − max s),   metalness = 0,   F₀ = s,   roughness = 1 − g
//! ```
//!
//! with `1 − s` channel by channel in place of `1 − max s` where `s` is textured.
//!
//! Sources: the extensions' specifications (Khronos). Held to this by
//! `gltf::metallic_roughness_with_index_and_specular`, `gltf_materials`.

use super::fields::{Anisotropy, SpecularGlossiness, Strength};
use super::reader::Reader;
use crate::bsdf::FacetModel;
use crate::color::Rgb;
use crate::error::{Error, Result};
use crate::io::dielectrics::normal_reflectance;
use crate::io::gltf::textures::{Content, UsedTexture};
use crate::io::principled::metallic_roughness;
use crate::io::textures::{between, product, whole};
use crate::scene::{Channel, ColorInput, FacetInput, FloatInput, NoteKind, Surface, TangentInput};

const SPECULAR_GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";
const SPECULAR: &str = "KHR_materials_specular";
const ANISOTROPY: &str = "KHR_materials_anisotropy";

/// Opaque surface of a material, and the values that its layers use.
pub(super) struct Opaque {
    /// Opaque surface, below all layers.
    pub surface: Surface,
    /// True if extensions may add layers; false for unlit and specular-glossiness surfaces.
    pub takes_layers: bool,
    pub base_color: ColorInput,
    pub metallic: FloatInput,
    pub roughness: FloatInput,
    /// Strength of the anisotropy, 0 to 1.
    pub anisotropy: FloatInput,
    /// Direction of the anisotropy, if its strength is not 0.
    pub tangent: Option<TangentInput>,
    /// Index of refraction; 0 reflects everything.
    pub ior: f32,
    /// Factor on a dielectric's reflection at normal incidence, 0 to 1.
    pub specular: Rgb,
    /// Factor on the opacity of `texture`.
    pub opacity: f32,
    /// The texture of the base colour.
    pub texture: Option<UsedTexture>,
    /// True if the base colour has a texture that could not be read.
    pub texture_lost: bool,
}

impl Opaque {
    /// Reads the opaque surface of the reader's material.
    pub fn read(reader: &mut Reader<'_, '_>) -> Result<Self> {
        let material = reader.material;
        if let Some(glossy) = reader.extension::<SpecularGlossiness>(SPECULAR_GLOSSINESS)? {
            return Self::specular_glossiness(reader, &glossy);
        }
        let pbr = &material.pbr_metallic_roughness;
        let [r, g, b, a] = pbr.base_color_factor.0;
        let factor = reader.color("pbrMetallicRoughness.baseColorFactor", [r, g, b], 1.0)?;
        let opacity = reader.number("pbrMetallicRoughness.baseColorFactor[3]", a, 1.0)?;
        let field = "pbrMetallicRoughness.baseColorTexture";
        let texture = reader.texture(field, pbr.base_color_texture.as_ref(), Content::Color)?;
        let [r, g, b, a] = reader.tint;
        let base_color =
            ColorInput { factor: factor * Rgb::new(r, g, b), texture: texture.map(|t| t.texture) };
        let mut opaque = Self {
            surface: Surface::Lambert { reflectance: base_color },
            takes_layers: false,
            base_color,
            metallic: 0.0.into(),
            roughness: 1.0.into(),
            anisotropy: 0.0.into(),
            tangent: None,
            ior: 1.5,
            specular: Rgb::WHITE,
            opacity: opacity * a,
            texture,
            texture_lost: texture.is_none() && pbr.base_color_texture.is_some(),
        };
        if material.extensions.as_ref().is_some_and(|e| e.unlit.is_some()) {
            reader.met_extension("KHR_materials_unlit")?;
            return Ok(opaque);
        }
        opaque.takes_layers = true;
        let metallic = reader.number("pbrMetallicRoughness.metallicFactor", pbr.metallic_factor.0, 1.0)?;
        let roughness = reader.number("pbrMetallicRoughness.roughnessFactor", pbr.roughness_factor.0, 1.0)?;
        let field = "pbrMetallicRoughness.metallicRoughnessTexture";
        let texture = reader.texture(field, pbr.metallic_roughness_texture.as_ref(), Content::Numbers)?;
        let textured =
            |factor, channel| FloatInput { factor, texture: texture.map(|t| (t.texture, channel)) };
        opaque.metallic = textured(metallic, Channel::B);
        opaque.roughness = textured(roughness, Channel::G);
        (opaque.anisotropy, opaque.tangent) = anisotropy(reader)?;
        opaque.ior = ior(reader)?;
        let (f0, strength) = opaque.f0(reader)?;
        opaque.surface = opaque.under(reader, f0, strength)?;
        for name in ["KHR_materials_iridescence", "KHR_materials_dispersion"] {
            if reader.extension::<Strength>(name)?.is_some_and(|s| s.is_there()) {
                reader.met_extension(name)?;
            }
        }
        Ok(opaque)
    }

    /// Facets of glass with the roughness of this surface.
    pub fn glass_facets(&self, reader: &mut Reader<'_, '_>) -> Result<FacetInput> {
        let alpha = reader.builder.power(self.roughness, 2.0)?;
        if self.anisotropy == 0.0.into() {
            return Ok(alpha.into());
        }
        if self.roughness.texture.is_some() || self.anisotropy.texture.is_some() {
            reader.met_field(ANISOTROPY, "anisotropyTexture")?;
            return Ok(alpha.into());
        }
        let along = alpha.factor + (1.0 - alpha.factor) * self.anisotropy.factor * self.anisotropy.factor;
        Ok(FacetInput { alpha: along.into(), across: Some(alpha), model: FacetModel::Ggx })
    }

    /// Surface of the base below a dielectric's reflection, which is scaled by `strength`.
    fn under(&self, reader: &mut Reader<'_, '_>, f0: ColorInput, strength: FloatInput) -> Result<Surface> {
        let of = |base_color, metallic, specular_f0| Surface::MetallicRoughness {
            base_color,
            metallic,
            roughness: self.roughness,
            specular_f0,
            anisotropy: self.anisotropy,
            model: FacetModel::Ggx,
        };
        let (metallic, whole) = (self.metallic, of(self.base_color, self.metallic, f0));
        let is_textured = metallic.texture.is_some() || strength.texture.is_some();
        if metallic == 1.0.into() {
            return Ok(whole);
        }
        if metallic.factor == 0.0 {
            let mut base = self.base_color;
            let most = f0.factor.max_channel();
            if f0.factor != Rgb::gray(most) {
                if f0.texture.is_some() {
                    reader.met_field(SPECULAR, "specularColorFactor")?;
                }
                base.factor =
                    base.factor.zip(f0.factor, |b, f| if f < 1.0 { b * (1.0 - most) / (1.0 - f) } else { b });
            }
            let below = Surface::Lambert { reflectance: self.base_color };
            return reader.mix(below, of(base, metallic, f0), strength, "reflection");
        }
        if f0.factor != Rgb::gray(f0.factor.max_channel()) {
            reader.met_field(SPECULAR, "specularColorFactor")?;
        }
        if strength == 1.0.into() {
            return Ok(whole);
        }
        if is_textured {
            reader.met_field(SPECULAR, "specularFactor")?;
            let factor = Rgb::gray(strength.factor);
            let strength = ColorInput { factor, texture: strength.texture.map(|(t, _)| t) };
            let f0 = product(reader.builder, f0, strength)?;
            return Ok(of(self.base_color, metallic, f0));
        }
        let amount = 1.0 - (1.0 - metallic.factor) * (1.0 - strength.factor);
        let below = Surface::Lambert { reflectance: self.base_color };
        let metal = FloatInput::from(metallic.factor / amount);
        reader.mix(below, of(self.base_color, metal, f0), amount.into(), "reflection")
    }

    /// A dielectric's reflectance at normal incidence, and the factor on all of its reflection.
    fn f0(&mut self, reader: &mut Reader<'_, '_>) -> Result<(ColorInput, FloatInput)> {
        let f0 = Rgb::gray(normal_reflectance(self.ior));
        let extensions = reader.material.extensions.as_ref();
        let Some(specular) = extensions.and_then(|e| e.specular.as_ref()) else {
            return Ok((f0.into(), 1.0.into()));
        };
        let field = |name: &str| format!("extensions.{SPECULAR}.{name}");
        let strength = reader.number(&field("specularFactor"), specular.specular_factor.0, 1.0)?;
        let tint = reader.color(&field("specularColorFactor"), specular.specular_color_factor.0, f32::MAX)?;
        let color = specular.specular_color_texture.as_ref();
        let color = reader.texture(&field("specularColorTexture"), color, Content::Color)?;
        let number = specular.specular_texture.as_ref();
        let number = reader.texture(&field("specularTexture"), number, Content::Spread(3))?;
        self.specular = tint.map(|v| v.min(1.0)) * strength;
        let f0 = ColorInput { factor: (f0 * tint).map(|v| v.min(1.0)), texture: color.map(|t| t.texture) };
        Ok((f0, FloatInput { factor: strength, texture: number.map(|t| (t.texture, Channel::R)) }))
    }

    fn specular_glossiness(reader: &mut Reader<'_, '_>, glossy: &SpecularGlossiness) -> Result<Self> {
        reader.met_extension(SPECULAR_GLOSSINESS)?;
        let field = |name: &str| format!("extensions.{SPECULAR_GLOSSINESS}.{name}");
        let [r, g, b, a] = glossy.diffuse_factor;
        let diffuse = reader.color(&field("diffuseFactor"), [r, g, b], 1.0)?;
        let opacity = reader.number(&field("diffuseFactor[3]"), a, 1.0)?;
        let f0 = reader.color(&field("specularFactor"), glossy.specular_factor, 1.0)?;
        let glossiness = reader.number(&field("glossinessFactor"), glossy.glossiness_factor, 1.0)?;
        let diffuse_texture =
            reader.texture(&field("diffuseTexture"), glossy.diffuse_texture.as_ref(), Content::Color)?;
        let (name, info) = (field("specularGlossinessTexture"), glossy.specular_glossiness_texture.as_ref());
        let f0_texture = reader.texture(&name, info, Content::Color)?.map(|t| t.texture);
        let glossiness_texture = reader.texture(&name, info, Content::Spread(3))?.map(|t| t.texture);
        let [r, g, b, a] = reader.tint;
        let mut base_color =
            ColorInput { factor: diffuse * Rgb::new(r, g, b), texture: diffuse_texture.map(|t| t.texture) };
        match f0_texture {
            Some(f0_texture) => {
                let rest = between(reader.builder, [Rgb::WHITE, Rgb::WHITE - f0], f0_texture)?;
                base_color = product(reader.builder, base_color, whole(rest))?;
            }
            None => base_color.factor *= 1.0 - f0.max_channel(),
        }
        let roughness = match glossiness_texture {
            Some(texture) => {
                let ends = [Rgb::WHITE, Rgb::gray(1.0 - glossiness)];
                let texture = between(reader.builder, ends, texture)?;
                FloatInput { factor: 1.0, texture: Some((texture, Channel::R)) }
            }
            None => (1.0 - glossiness).into(),
        };
        let (metallic, specular_f0) = (0.0.into(), ColorInput { factor: f0, texture: f0_texture });
        Ok(Self {
            surface: metallic_roughness(base_color, metallic, roughness, specular_f0),
            takes_layers: false,
            base_color,
            metallic,
            roughness,
            anisotropy: 0.0.into(),
            tangent: None,
            ior: 1.5,
            specular: Rgb::WHITE,
            opacity: opacity * a,
            texture: diffuse_texture,
            texture_lost: diffuse_texture.is_none() && glossy.diffuse_texture.is_some(),
        })
    }
}

/// Strength and direction of the anisotropy.
fn anisotropy(reader: &mut Reader<'_, '_>) -> Result<(FloatInput, Option<TangentInput>)> {
    let even = (0.0.into(), None);
    let Some(anisotropy) = reader.extension::<Anisotropy>(ANISOTROPY)? else { return Ok(even) };
    let field = |name: &str| format!("extensions.{ANISOTROPY}.{name}");
    let strength = reader.number(&field("anisotropyStrength"), anisotropy.anisotropy_strength, 1.0)?;
    if strength == 0.0 {
        return Ok(even);
    }
    let rotation = anisotropy.anisotropy_rotation;
    if !rotation.is_finite() {
        let expected = "a number that fits into 32 bits";
        return Err(Error::invalid(reader.at(&field("anisotropyRotation")), format!("{rotation}"), expected));
    }
    let info = anisotropy.anisotropy_texture.as_ref();
    let texture = reader.texture(&field("anisotropyTexture"), info, Content::Numbers)?.map(|t| t.texture);
    let strength = FloatInput { factor: strength, texture: texture.map(|t| (t, Channel::B)) };
    Ok((strength, Some(TangentInput { rotation, direction: texture })))
}

/// Index of refraction. In the extension, 0 stands for a reflectance of one, which the formula
/// gives.
fn ior(reader: &mut Reader<'_, '_>) -> Result<f32> {
    let Some(ior) = reader.material.extensions.as_ref().and_then(|e| e.ior.as_ref()) else {
        return Ok(1.5);
    };
    let field = "extensions.KHR_materials_ior.ior";
    let ior = reader.number(field, ior.ior.0, 1e3)?;
    if ior > 0.0 && ior < 1.0 {
        let message = "indices of refraction between 0 and 1: 1 is used";
        reader.builder.note(NoteKind::Repaired, message, reader.at(field));
        return Ok(1.0);
    }
    Ok(ior)
}
