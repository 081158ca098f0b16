//! Parameters that several materials have.

use crate::bsdf::{ConductorFresnel, FacetModel};
use crate::color::Rgb;
use crate::color::metals::conductor_rgb;
use crate::error::Result;
use crate::io::dielectrics::{refractive_index, rendered};
use crate::io::images::Encoding;
use crate::io::pbrt::loading::Loading;
use crate::io::pbrt::parameters::{Kind, Parameters};
use crate::io::pbrt::roughness::{self, POWER_V3};
use crate::io::pbrt::spectra::{self, Quantity};
use crate::io::pbrt::textures::Textures;
use crate::io::pbrt::version::Version;
use crate::math::elementary::powf;
use crate::scene::{ColorInput, FacetInput, FloatInput, NormalInput, NoteKind, Texture};

/// Range of complex indices of refraction: real parts are at least `LEAST_ETA` (silver has 0.05),
/// all parts at most `MOST_INDEX`.
const LEAST_ETA: f32 = 1e-3;
const MOST_INDEX: f32 = 100.0;

/// Refractive index where the file gives none: glass.
const DEFAULT_IOR: f32 = 1.5;

/// The parameters of a material being defined.
pub(super) struct Maker<'a, 'f> {
    pub(super) loading: &'a mut Loading<'f>,
    pub(super) textures: &'a Textures,
    pub(super) parameters: &'a Parameters,
}

impl Maker<'_, '_> {
    /// Reads a colour in `[0, 1]`, by default a grey.
    pub(super) fn color(&mut self, name: &str, default: f32) -> Result<ColorInput> {
        Ok(self.color_if_there(name)?.unwrap_or(Rgb::gray(default).into()))
    }

    /// Reads a colour in `[0, 1]`, if the parameter exists.
    pub(super) fn color_if_there(&mut self, name: &str) -> Result<Option<ColorInput>> {
        let mut found = self.textures.color(self.loading, self.parameters, name)?;
        if let Some(ColorInput { factor, texture: None }) = &mut found
            && factor.max_channel() > 1.0
        {
            let message = "reflectances and transmittances above 1: set to 1";
            self.loading.note(NoteKind::Repaired, message, self.parameters.at());
            *factor = factor.map(|v| v.min(1.0));
        }
        Ok(found)
    }

    /// Reads a colour; a texture is replaced by its factor, with a note.
    pub(super) fn plain_color(&mut self, name: &str, default: f32) -> Result<Rgb> {
        let color = self.color(name, default)?;
        if color.texture.is_some() {
            let message = format!("textures of {name:?}: their factor is used alone");
            self.loading.note(NoteKind::Approximated, message, self.parameters.at());
        }
        Ok(color.factor)
    }

    /// Reads a number or its texture, at least 0.
    pub(super) fn float(&mut self, name: &str) -> Option<FloatInput> {
        let value = self.textures.float(self.loading, self.parameters, name)?;
        Some(FloatInput { factor: value.factor.max(0.0), ..value })
    }

    /// Reads facets from the parameters `roughness` or `uroughness` and `vroughness`, each with
    /// `prefix` before it.
    pub(super) fn facets(&mut self, prefix: &str, default: f32) -> Result<FacetInput> {
        let remap = self.parameters.boolean("remaproughness").unwrap_or(true);
        let both = self.float(&format!("{prefix}roughness")).unwrap_or(default.into());
        let u = self.float(&format!("{prefix}uroughness")).unwrap_or(both);
        let v = self.float(&format!("{prefix}vroughness")).unwrap_or(both);
        let alpha = self.alpha(u, remap)?;
        let across = if u == v { None } else { Some(self.alpha(v, remap)?) };
        Ok(FacetInput { alpha, across, model: FacetModel::Ggx })
    }

    /// Converts a roughness to `α`.
    fn alpha(&mut self, roughness: FloatInput, remap: bool) -> Result<FloatInput> {
        let version = self.loading.version;
        let Some((base, channel)) = roughness.texture else {
            return Ok(roughness::alpha(roughness.factor, remap, version).into());
        };
        if !remap {
            return Ok(roughness);
        }
        let (factor, exponent) = match version {
            Version::V4 => (1.0, 0.5),
            Version::V3 => {
                let message = "textures of remapped roughness: a power that follows the polynomial";
                self.loading.note(NoteKind::Approximated, message, self.parameters.at());
                POWER_V3
            }
        };
        let power = self.loading.builder.add_texture(Texture::Power { base, exponent })?;
        let factor = factor * powf(roughness.factor, exponent);
        Ok(FloatInput { factor, texture: Some((power, channel)) })
    }

    /// Reads facets that are smooth unless the file gives a roughness above 0. Without this case,
    /// remapping would turn a roughness of 0 into a rough surface.
    pub(super) fn facets_if_rough(&mut self) -> Result<FacetInput> {
        let facets = self.facets("", 0.0)?;
        let is_rough = ["uroughness", "vroughness", "roughness"]
            .iter()
            .any(|name| self.float(name).is_some_and(|r| r.factor > 0.0 || r.texture.is_some()));
        Ok(if is_rough { facets } else { 0.0.into() })
    }

    /// Reads a refractive index by number, or by the name of a glass.
    pub(super) fn ior(&mut self, names: &[&str]) -> Result<f32> {
        let mut ior = DEFAULT_IOR;
        for name in names {
            if let Some(value) = self.float(name) {
                if value.texture.is_some() {
                    let message = "textures of refractive indices: 1.5";
                    self.loading.note(NoteKind::Approximated, message, self.parameters.at());
                } else {
                    ior = value.factor;
                }
                break;
            }
            let Some(spectrum) = self.parameters.find(spectra::SPECTRAL, name) else { continue };
            ior = match spectrum.strings().first().and_then(|glass| refractive_index(glass)) {
                Some(known) => known,
                None => spectra::convert(self.loading, spectrum, Quantity::Factor)?.g,
            };
            break;
        }
        if ior != rendered(ior) {
            let message = "refractive indices outside 1 to 5: set to the nearer end";
            self.loading.note(NoteKind::Repaired, message, self.parameters.at());
        }
        Ok(rendered(ior))
    }

    /// Reads the Fresnel reflectance of a metal from `eta` and `k`, each with `prefix` before it;
    /// copper by default.
    pub(super) fn conductor(&mut self, prefix: &str) -> Result<ConductorFresnel> {
        let mut values = [Rgb::BLACK; 2];
        for (value, name) in values.iter_mut().zip(["eta", "k"]) {
            let name = format!("{prefix}{name}");
            let given = self
                .parameters
                .find(&[Kind::Float, Kind::Rgb, Kind::Xyz, Kind::Blackbody, Kind::Spectrum], &name);
            let metal = given.and_then(|p| p.strings().first()).map(|metal| metal_name(metal));
            let known = match (&given, metal) {
                (None, _) => conductor_rgb("Cu"),
                (_, Some(metal)) => conductor_rgb(metal),
                _ => None,
            };
            *value = match (given, known) {
                (_, Some((eta, k))) => {
                    if name.ends_with('k') {
                        k
                    } else {
                        eta
                    }
                }
                (Some(number), None) if number.kind == Kind::Float => {
                    Rgb::gray(number.numbers().first().copied().unwrap_or(1.0).max(0.0))
                }
                (Some(spectrum), None) => spectra::convert(self.loading, spectrum, Quantity::Factor)?,
                (None, None) => Rgb::WHITE,
            };
        }
        let [eta, k] = values;
        Ok(ConductorFresnel::Exact {
            eta: eta.map(|v| v.clamp(LEAST_ETA, MOST_INDEX)),
            k: k.map(|v| v.clamp(0.0, MOST_INDEX)),
        })
    }

    /// Reads the bump map or the normal map.
    pub(super) fn normal(&mut self) -> Result<Option<NormalInput>> {
        let version = self.loading.version;
        let name = if version == Version::V3 { "bumpmap" } else { "displacement" };
        let height = self.textures.float(self.loading, self.parameters, name);
        if version == Version::V4
            && let Some(name) = self.parameters.string("normalmap")
        {
            let (loading, at) = (&mut *self.loading, self.parameters.place_of("normalmap"));
            let image = loading.images.load(name, Encoding::Linear, &at, &mut loading.builder)?;
            let Some(image) = image else { return Ok(None) };
            let texture = loading.builder.add_texture(image.texture(|all| all))?;
            return Ok(Some(NormalInput::Map { texture, scale: 1.0 }));
        }
        Ok(height.filter(|h| h.texture.is_some()).map(|height| NormalInput::Bump { height }))
    }

    /// Notes a part of a material by its row in the features table.
    pub(super) fn met(&mut self, name: &str) -> Result<()> {
        self.loading.met("material", name, "left out", &self.parameters.at())
    }

    /// Adds a note at the material.
    pub(super) fn note(&mut self, kind: NoteKind, message: &str) {
        self.loading.note(kind, message, self.parameters.at());
    }
}

/// Returns `Au` for `metal-Au-eta`, `metal-Au-k`, `Au`, and for the file `spds/Au.eta.spd` of
/// pbrt-v3's scenes.
fn metal_name(name: &str) -> &str {
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let file = file.strip_suffix(".spd").unwrap_or(file);
    let file = file.strip_suffix(".eta").or(file.strip_suffix(".k")).unwrap_or(file);
    let metal = file.strip_prefix("metal-").unwrap_or(file);
    metal.strip_suffix("-eta").or(metal.strip_suffix("-k")).unwrap_or(metal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metals_are_found_under_all_their_names() {
        for name in ["metal-Au-eta", "metal-Au-k", "Au", "spds/Au.eta.spd", "spds\\Au.k.spd", "metal-Au"] {
            assert_eq!(metal_name(name), "Au");
        }
    }
}
