//! Physically based materials that several formats share.
//!
//! Disney's material, `disney` in pbrt-v3 and `principled` in Mitsuba 3, is a mix of the opaque
//! principled surface and of glass. The share of glass is the product of the transmission and one
//! minus the metalness. The transmittance of the glass at each boundary is the square root of the
//! colour. Both parts have the same facets and the same Fresnel reflectance. The opaque part lies
//! under the clear coat, which has `α = 0.1 + (0.001 − 0.1) gloss`.
//!
//! Sources: Burley 2012, section 5.4; Burley 2015. Held to this by `mitsuba::clear_coats_*` and the
//! suite's `mitsuba_materials` and `formula_materials`.

use super::mixes::either;
use super::textures::between;
use crate::bsdf::{CoatModel, FacetModel, MAX_GTR1_ALPHA, MIN_ALPHA};
use crate::color::Rgb;
use crate::error::Result;
use crate::scene::{ColorInput, FacetInput, FloatInput, Material, SceneBuilder, Surface};

/// Parameters of Disney's material. All numbers except `ior` are from 0 to 1.
pub(super) struct Principled {
    /// Prefix of the names of the material's parts.
    pub(super) name: &'static str,
    pub(super) base_color: ColorInput,
    pub(super) metallic: FloatInput,
    pub(super) roughness: FloatInput,
    pub(super) ior: f32,
    pub(super) specular_tint: FloatInput,
    pub(super) sheen: FloatInput,
    pub(super) sheen_tint: FloatInput,
    pub(super) flatness: FloatInput,
    pub(super) anisotropic: FloatInput,
    /// Share of the dielectric part that transmits light.
    pub(super) transmission: FloatInput,
    pub(super) clearcoat: FloatInput,
    pub(super) gloss: FloatInput,
    /// Model of clear coats in the format.
    pub(super) coat: CoatModel,
}

impl Principled {
    /// Share of glass in the mix.
    pub(super) fn glass_share(&self) -> FloatInput {
        FloatInput { factor: self.transmission.factor * (1.0 - self.metallic.factor), ..self.transmission }
    }

    /// Surface of the opaque part.
    pub(super) fn opaque(&self) -> Surface {
        let Self { base_color, metallic, roughness, ior, specular_tint, .. } = *self;
        let Self { sheen, sheen_tint, flatness, anisotropic, .. } = *self;
        Surface::Principled {
            base_color,
            metallic,
            roughness,
            ior,
            specular_tint,
            sheen,
            sheen_tint,
            flatness,
            anisotropic,
        }
    }

    /// Glass with the material's facets.
    pub(super) fn glass(&self, builder: &mut SceneBuilder) -> Result<Surface> {
        let alpha = builder.power(self.roughness, 2.0)?;
        Ok(Surface::Glass {
            ior: self.ior,
            reflectance: Rgb::WHITE,
            transmittance: self.base_color.factor.map(f32::sqrt),
            facets: FacetInput::of_aspect(alpha, self.anisotropic.factor, FacetModel::GgxIndependent),
        })
    }

    /// Mix of the surfaces that `opaque` and `glass` return, under the clear coat.
    pub(super) fn surface(
        mut self,
        builder: &mut SceneBuilder,
        opaque: impl FnOnce(&Self) -> Surface,
        glass: impl FnOnce(&Self, &mut SceneBuilder) -> Result<Surface>,
    ) -> Result<Surface> {
        let amount = self.glass_share();
        if amount.factor <= 0.0 {
            return self.coated(builder, opaque(&self));
        }
        let glass = glass(&self, builder)?;
        if amount == 1.0.into() {
            return Ok(glass);
        }
        // The metal is entirely in the opaque part, so its share there is larger than in the whole.
        let rest = (1.0 - amount.factor).max(self.metallic.factor).max(f32::MIN_POSITIVE);
        self.metallic.factor /= rest;
        let opaque = self.coated(builder, opaque(&self))?;
        either(builder, self.name, [opaque, glass], amount)
    }

    /// Puts the surface under the clear coat, if there is one.
    fn coated(&self, builder: &mut SceneBuilder, base: Surface) -> Result<Surface> {
        let amount = self.clearcoat;
        if amount.factor <= 0.0 {
            return Ok(base);
        }
        let alpha = alpha_of_gloss(builder, self.gloss)?;
        let base = builder.add_material(Material::new(format!("{}: below its coat", self.name), base))?;
        Ok(Surface::Clearcoat { base, amount, alpha, model: self.coat })
    }
}

/// Returns `α` of a clear coat by its gloss; a texture if the gloss has one.
fn alpha_of_gloss(builder: &mut SceneBuilder, gloss: FloatInput) -> Result<FloatInput> {
    let alpha = |gloss: f32| MAX_GTR1_ALPHA + (MIN_ALPHA - MAX_GTR1_ALPHA) * gloss.clamp(0.0, 1.0);
    let Some((amount, channel)) = gloss.texture else { return Ok(alpha(gloss.factor).into()) };
    let ends = [0.0, gloss.factor].map(|gloss| Rgb::gray(alpha(gloss)));
    Ok(FloatInput { factor: 1.0, texture: Some((between(builder, ends, amount)?, channel)) })
}

/// Isotropic metallic-roughness surface; `specular_f0` is the reflectance of its dielectric part at
/// normal incidence.
pub(super) fn metallic_roughness(
    base_color: ColorInput,
    metallic: FloatInput,
    roughness: FloatInput,
    specular_f0: ColorInput,
) -> Surface {
    Surface::MetallicRoughness {
        base_color,
        metallic,
        roughness,
        specular_f0,
        anisotropy: 0.0.into(),
        model: FacetModel::Ggx,
    }
}
