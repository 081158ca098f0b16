//! Materials; the table in the parent module says what becomes what.
//!
//! A dielectric's reflectance at normal incidence is
//!
//! ```text
//! F₀ = min( ((n − 1) / (n + 1))² · specularColorFactor , 1 ) · specularFactor
//! ```
//!
//! with `n` from `KHR_materials_ior` (default 1.5, so 0.04) and the factors from
//! `KHR_materials_specular` (default 1).
//!
//! # Limits
//! `specularFactor` also scales the reflectance at grazing angles in the extension; here only at normal
//! incidence. At zero on a dielectric, where nothing of the reflection is left, the surface is Lambertian.
//!
//! # Held to this by
//! `gltf::metallic_roughness_with_index_and_specular`, `gltf::transmission_unlit_and_diffuse_surfaces`,
//! `gltf::emission_is_factor_times_strength`, `gltf::alpha_modes`.

use gltf::json;
use gltf::json::material::AlphaMode as FileAlphaMode;
use gltf::json::validation::Checked;

use super::source::Source;
use super::textures::{Textures, UsedTexture};
use crate::color::Rgb;
use crate::error::{Error, Result};
use crate::io::images::Encoding;
use crate::scene::{
    Alpha, AlphaMode, Channel, ColorInput, Emission, FloatInput, Material, MaterialId, NoteKind,
    SceneBuilder, Surface,
};

/// Transmission from which a smooth surface becomes glass; below, it stays opaque.
const MIN_GLASS_TRANSMISSION: f32 = 0.5;

/// Roughness below which a transmitting surface becomes smooth glass.
const MAX_GLASS_ROUGHNESS: f32 = 0.1;

/// A material in use.
#[derive(Clone, Copy, Debug)]
pub(super) struct UsedMaterial {
    /// The material.
    pub id: MaterialId,
    /// The set of texture coordinates that it looks up, if it has a texture.
    pub uv_set: Option<u32>,
}

/// The materials read so far, by index; the last is glTF's default material.
pub(super) struct Materials {
    used: Vec<Option<UsedMaterial>>,
    textures: Textures,
}

impl Materials {
    /// None read yet.
    pub fn new(source: &Source<'_>) -> Self {
        Self { used: vec![None; source.root.materials.len() + 1], textures: Textures::default() }
    }

    /// The material of that index, or the default one.
    pub fn get(
        &mut self,
        source: &Source<'_>,
        builder: &mut SceneBuilder,
        index: Option<usize>,
    ) -> Result<UsedMaterial> {
        let place = index.unwrap_or(self.used.len() - 1);
        if let Some(used) = self.used[place] {
            return Ok(used);
        }
        let default = json::Material::default();
        let material = index.map_or(&default, |i| &source.root.materials[i]);
        let item = index.map_or_else(|| "default material".to_owned(), |i| format!("materials[{i}]"));
        let mut reader =
            Reader { source, builder, textures: &mut self.textures, material, item, uv_set: None };
        let material = reader.read()?;
        let used = UsedMaterial { uv_set: reader.uv_set, id: builder.add_material(material)? };
        self.used[place] = Some(used);
        Ok(used)
    }
}

/// One material being read.
struct Reader<'r, 's> {
    source: &'r Source<'s>,
    builder: &'r mut SceneBuilder,
    textures: &'r mut Textures,
    material: &'r json::Material,
    item: String,
    uv_set: Option<u32>,
}

impl Reader<'_, '_> {
    fn read(&mut self) -> Result<Material> {
        let material = self.material;
        let name = material.name.as_deref().filter(|n| !n.is_empty());
        let pbr = &material.pbr_metallic_roughness;
        let [r, g, b, a] = pbr.base_color_factor.0;
        let factor = self.color("pbrMetallicRoughness.baseColorFactor", [r, g, b], 1.0)?;
        let opacity = self.number("pbrMetallicRoughness.baseColorFactor[3]", a, 1.0)?;
        let base = self.texture(
            "pbrMetallicRoughness.baseColorTexture",
            pbr.base_color_texture.as_ref(),
            Encoding::Srgb,
        );
        let base_color = ColorInput { factor, texture: base.map(|t| t.texture) };
        let read = Material {
            surface: self.surface(base_color)?,
            emission: self.emission()?,
            alpha: self.alpha(opacity, base)?,
            name: name.map_or_else(|| self.item.clone(), super::shown),
        };
        for (field, present) in [
            ("normalTexture", material.normal_texture.is_some()),
            ("occlusionTexture", material.occlusion_texture.is_some()),
        ] {
            if present {
                self.note(NoteKind::Ignored, &format!("{field}: left out"), field);
            }
        }
        Ok(read)
    }

    fn surface(&mut self, base_color: ColorInput) -> Result<Surface> {
        let material = self.material;
        let extensions = material.extensions.as_ref();
        if extensions.is_some_and(|e| e.unlit.is_some()) {
            let message = "unlit materials: rendered as diffuse ones of the same colour";
            self.note(NoteKind::Approximated, message, "extensions.KHR_materials_unlit");
            return Ok(Surface::Lambert { reflectance: base_color });
        }
        let pbr = &material.pbr_metallic_roughness;
        let metallic = self.number("pbrMetallicRoughness.metallicFactor", pbr.metallic_factor.0, 1.0)?;
        let roughness = self.number("pbrMetallicRoughness.roughnessFactor", pbr.roughness_factor.0, 1.0)?;
        let ior = self.ior()?;
        if let Some(transmission) = extensions.and_then(|e| e.transmission.as_ref()) {
            let field = "extensions.KHR_materials_transmission";
            let factor =
                self.number(&format!("{field}.transmissionFactor"), transmission.transmission_factor.0, 1.0)?;
            if factor >= MIN_GLASS_TRANSMISSION && roughness < MAX_GLASS_ROUGHNESS {
                let message = "smooth transmitting materials: rendered as clear solid glass, with the base colour's factor as transmittance";
                self.note(NoteKind::Approximated, message, field);
                // An index of one would be no surface at all.
                let ior = ior.clamp(1.0001, 5.0);
                return Ok(Surface::Glass { ior, reflectance: Rgb::WHITE, transmittance: base_color.factor });
            }
            if factor > 0.0 {
                self.note(
                    NoteKind::Ignored,
                    "transmission that is rough or partial: rendered as opaque",
                    field,
                );
            }
        }
        let from_index = (ior - 1.0) / (ior + 1.0);
        let mut f0 = Rgb::gray(from_index * from_index);
        let mut strength = 1.0;
        if let Some(specular) = extensions.and_then(|e| e.specular.as_ref()) {
            let field = "extensions.KHR_materials_specular";
            strength = self.number(&format!("{field}.specularFactor"), specular.specular_factor.0, 1.0)?;
            let tint = self.color(
                &format!("{field}.specularColorFactor"),
                specular.specular_color_factor.0,
                f32::MAX,
            )?;
            f0 = (f0 * tint).map(|v| v.min(1.0)) * strength;
            if specular.specular_texture.is_some() || specular.specular_color_texture.is_some() {
                self.note(
                    NoteKind::Ignored,
                    "textures of KHR_materials_specular: their factors are used alone",
                    field,
                );
            }
        }
        if strength == 0.0 && metallic == 0.0 {
            return Ok(Surface::Lambert { reflectance: base_color });
        }
        let field = "pbrMetallicRoughness.metallicRoughnessTexture";
        let texture = self.texture(field, pbr.metallic_roughness_texture.as_ref(), Encoding::Linear);
        let textured =
            |factor, channel| FloatInput { factor, texture: texture.map(|t| (t.texture, channel)) };
        Ok(Surface::MetallicRoughness {
            base_color,
            metallic: textured(metallic, Channel::B),
            roughness: textured(roughness, Channel::G),
            dielectric_f0: f0,
        })
    }

    /// The index of refraction. Zero is the extension's way of asking for a reflectance of one, which the
    /// formula gives.
    fn ior(&mut self) -> Result<f32> {
        let Some(ior) = self.material.extensions.as_ref().and_then(|e| e.ior.as_ref()) else {
            return Ok(1.5);
        };
        let field = "extensions.KHR_materials_ior.ior";
        let ior = self.number(field, ior.ior.0, 1e3)?;
        if ior > 0.0 && ior < 1.0 {
            self.note(NoteKind::Repaired, "indices of refraction between 0 and 1: 1 is used", field);
            return Ok(1.0);
        }
        Ok(ior)
    }

    fn emission(&mut self) -> Result<Option<Emission>> {
        let material = self.material;
        let extension = material.extensions.as_ref().and_then(|e| e.emissive_strength.as_ref());
        let strength = match extension {
            Some(e) => {
                let field = "extensions.KHR_materials_emissive_strength.emissiveStrength";
                self.number(field, e.emissive_strength.0, f32::MAX)?
            }
            None => 1.0,
        };
        // Files from before that extension have factors above 1, although glTF forbids it.
        let factor = self.color("emissiveFactor", material.emissive_factor.0, f32::MAX)? * strength;
        if !factor.is_finite() {
            let at = self.source.at(format!("{}.emissiveFactor", self.item));
            return Err(Error::invalid(
                at,
                "an emission beyond all numbers",
                "a finite product of factor and strength",
            ));
        }
        if factor.is_black() {
            return Ok(None);
        }
        let texture = self.texture("emissiveTexture", material.emissive_texture.as_ref(), Encoding::Srgb);
        let radiance = ColorInput { factor, texture: texture.map(|t| t.texture) };
        Ok(Some(Emission { radiance, two_sided: material.double_sided }))
    }

    /// Opacity `factor · A(texture)`; none if that is one everywhere or the file says not to look.
    fn alpha(&mut self, factor: f32, texture: Option<UsedTexture>) -> Result<Option<Alpha>> {
        let material = self.material;
        let mode = match material.alpha_mode {
            Checked::Valid(FileAlphaMode::Mask) => {
                let cutoff =
                    self.number("alphaCutoff", material.alpha_cutoff.map_or(0.5, |c| c.0), f32::MAX)?;
                AlphaMode::Mask { cutoff }
            }
            Checked::Valid(FileAlphaMode::Blend) => AlphaMode::Blend,
            Checked::Valid(FileAlphaMode::Opaque) | Checked::Invalid => return Ok(None),
        };
        // A texture that could not be read tells nothing about opacity.
        let lost = texture.is_none() && material.pbr_metallic_roughness.base_color_texture.is_some();
        let texture = texture.filter(|t| !t.opaque).map(|t| (t.texture, Channel::A));
        let everywhere = match mode {
            AlphaMode::Mask { cutoff } => factor >= cutoff,
            AlphaMode::Blend => factor >= 1.0,
        };
        if lost || (texture.is_none() && everywhere) {
            return Ok(None);
        }
        Ok(Some(Alpha { value: FloatInput { factor, texture }, mode }))
    }

    fn texture(
        &mut self,
        field: &str,
        info: Option<&json::texture::Info>,
        encoding: Encoding,
    ) -> Option<UsedTexture> {
        let item = format!("{}.{field}", self.item);
        let used = self.textures.get(self.source, self.builder, info?, encoding, &item)?;
        if *self.uv_set.get_or_insert(used.uv_set) != used.uv_set {
            let message = "textures of one material with different sets of texture coordinates: those of the first are used";
            self.note(NoteKind::Approximated, message, field);
        }
        Some(used)
    }

    fn color(&mut self, field: &str, value: [f32; 3], max: f32) -> Result<Rgb> {
        let mut color = [0.0; 3];
        for (channel, value) in color.iter_mut().zip(value) {
            *channel = self.number(field, value, max)?;
        }
        Ok(color.into())
    }

    /// `value`, brought into `[0, max]` with a note.
    fn number(&mut self, field: &str, value: f32, max: f32) -> Result<f32> {
        if !value.is_finite() {
            let at = self.source.at(format!("{}.{field}", self.item));
            return Err(Error::invalid(at, format!("{value}"), "a number that fits into 32 bits"));
        }
        if !(0.0..=max).contains(&value) {
            self.note(
                NoteKind::Repaired,
                "factors of materials that are out of range: the nearest allowed is used",
                field,
            );
        }
        Ok(value.clamp(0.0, max))
    }

    fn note(&mut self, kind: NoteKind, message: &str, field: &str) {
        self.builder.note(kind, message, self.source.at(format!("{}.{field}", self.item)));
    }
}
