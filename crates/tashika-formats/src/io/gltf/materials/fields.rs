//! Fields of the material extensions that the `gltf` crate does not know, with the defaults of
//! their specifications.
//!
//! Numbers are as they stand in the file; their ranges are checked where they are used.

use gltf::json::texture::Info;
use serde::Deserialize;
use serde::de::IgnoredAny;

/// `KHR_materials_anisotropy`.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Anisotropy {
    pub anisotropy_strength: f32,
    /// Counter-clockwise (rad).
    pub anisotropy_rotation: f32,
    /// Direction in red and green, strength in blue.
    pub anisotropy_texture: Option<Info>,
}

/// `KHR_materials_clearcoat`.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Clearcoat {
    pub clearcoat_factor: f32,
    /// Factor in red.
    pub clearcoat_texture: Option<Info>,
    pub clearcoat_roughness_factor: f32,
    /// Factor in green.
    pub clearcoat_roughness_texture: Option<Info>,
    pub clearcoat_normal_texture: Option<IgnoredAny>,
}

/// `KHR_materials_diffuse_transmission`.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct DiffuseTransmission {
    pub diffuse_transmission_factor: f32,
    /// Factor in the alpha channel.
    pub diffuse_transmission_texture: Option<Info>,
    pub diffuse_transmission_color_factor: [f32; 3],
    pub diffuse_transmission_color_texture: Option<Info>,
}

impl Default for DiffuseTransmission {
    fn default() -> Self {
        Self {
            diffuse_transmission_factor: 0.0,
            diffuse_transmission_texture: None,
            diffuse_transmission_color_factor: [1.0; 3],
            diffuse_transmission_color_texture: None,
        }
    }
}

/// `KHR_materials_pbrSpecularGlossiness`.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct SpecularGlossiness {
    pub diffuse_factor: [f32; 4],
    pub diffuse_texture: Option<Info>,
    pub specular_factor: [f32; 3],
    pub glossiness_factor: f32,
    /// Reflectance in the colour, glossiness in the alpha channel.
    pub specular_glossiness_texture: Option<Info>,
}

impl Default for SpecularGlossiness {
    fn default() -> Self {
        Self {
            diffuse_factor: [1.0; 4],
            diffuse_texture: None,
            specular_factor: [1.0; 3],
            glossiness_factor: 1.0,
            specular_glossiness_texture: None,
        }
    }
}

/// `KHR_materials_volume`.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Volume {
    /// In the units of the mesh.
    pub thickness_factor: f32,
    pub thickness_texture: Option<IgnoredAny>,
    /// Distance (m); infinite if absent.
    pub attenuation_distance: Option<f32>,
    pub attenuation_color: [f32; 3],
}

impl Default for Volume {
    fn default() -> Self {
        Self {
            thickness_factor: 0.0,
            thickness_texture: None,
            attenuation_distance: None,
            attenuation_color: [1.0; 3],
        }
    }
}

/// `KHR_materials_sheen`.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Sheen {
    pub sheen_color_factor: [f32; 3],
    pub sheen_color_texture: Option<Info>,
    pub sheen_roughness_factor: f32,
    /// Factor in the alpha channel.
    pub sheen_roughness_texture: Option<Info>,
}

/// Strength of `KHR_materials_iridescence` or `KHR_materials_dispersion`; at zero they have no
/// effect.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Strength {
    iridescence_factor: f32,
    dispersion: f32,
}

impl Strength {
    /// Returns true if the extension has an effect.
    pub(super) fn is_there(&self) -> bool {
        self.iridescence_factor != 0.0 || self.dispersion != 0.0
    }
}
