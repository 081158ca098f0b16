//! The principled BSDFs of Mitsuba 3.

use super::Translation;
use super::inputs::GREY;
use super::object::Object;
use super::surfaces::IOR_RANGE;
use crate::bsdf::{CoatModel, FacetModel};
use crate::color::Rgb;
use crate::error::{Error, Result};
use crate::io::clear_coats::alpha_of_gloss;
use crate::io::dielectrics::single_face;
use crate::scene::{ColorInput, FacetInput, FloatInput, Material, Surface};

impl Translation<'_> {
    /// `principled` and `principledthin`.
    pub(super) fn principled(&mut self, object: &Object) -> Result<Surface> {
        let is_thin = object.plugin == "principledthin";
        object.accept(&[
            "diffuse_reflectance_sampling_rate",
            "main_specular_sampling_rate",
            "clearcoat_sampling_rate",
        ]);
        let base_color = self.reflectance(object, "base_color", GREY)?;
        let roughness = self.share(object, "roughness", 0.5)?;
        let metallic = self.share(object, "metallic", 0.0)?;
        let specular_tint = self.share(object, "spec_tint", 0.0)?;
        let (sheen, sheen_tint) = (self.share(object, "sheen", 0.0)?, self.share(object, "sheen_tint", 0.0)?);
        let anisotropic = self.share(object, "anisotropic", 0.0)?;
        let flatness = self.share(object, "flatness", 0.0)?;
        let ior = self.principled_ior(object)?;
        let transmission = self.share(object, "spec_trans", 0.0)?;
        let through =
            if is_thin { self.float(object, "diff_trans", 0.0)?.factor.clamp(0.0, 2.0) * 0.5 } else { 0.0 };
        let part = |share: f32| ColorInput { factor: base_color.factor * share, ..base_color };
        // Sheets have none.
        let mut of_coat = |name| if is_thin { Ok(0.0.into()) } else { self.share(object, name, 0.0) };
        let (clearcoat, gloss) = (of_coat("clearcoat")?, of_coat("clearcoat_gloss")?);
        let opaque = |metallic| match through > 0.0 {
            true => Surface::Translucent { reflectance: part(1.0 - through), transmittance: part(through) },
            false => {
                // Sheets have gloss only where they transmit.
                let ior = if is_thin { IOR_RANGE[0] as f32 } else { ior };
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
        };
        let amount = FloatInput { factor: transmission.factor * (1.0 - metallic.factor), ..transmission };
        if amount.factor <= 0.0 {
            return self.clear_coat(opaque(metallic), clearcoat, gloss);
        }
        if clearcoat.factor > 0.0 {
            self.feature("material", "principled clearcoat", &object.place_of("clearcoat"))?;
        }
        if metallic.texture.is_some() {
            self.feature("material", "principled spec_trans", &object.place_of("spec_trans"))?;
        }
        let glass = if is_thin {
            let ior = single_face(ior);
            Surface::ThinGlass { ior, reflectance: Rgb::WHITE.into(), transmittance: base_color }
        } else {
            // Light crosses two interfaces of a solid, each with the square root of the colour.
            let transmittance = base_color.factor.map(f32::sqrt);
            if anisotropic.texture.is_some() {
                self.feature("material", "principled anisotropic", &object.place_of("anisotropic"))?;
            }
            let alpha = self.builder.power(roughness, 2.0)?;
            let facets = FacetInput::of_aspect(alpha, anisotropic.factor, FacetModel::GgxIndependent);
            Surface::Glass { ior, reflectance: Rgb::WHITE, transmittance, facets }
        };
        if amount == 1.0.into() {
            return Ok(glass);
        }
        // Both parts have the same gloss; what is not glass has all of the metal.
        let rest = (1.0 - amount.factor).max(metallic.factor).max(f32::MIN_POSITIVE);
        let rest = FloatInput { factor: metallic.factor / rest, ..metallic };
        let opaque = self.clear_coat(opaque(rest), clearcoat, gloss)?;
        self.either("principled", opaque, glass, amount)
    }

    /// The surface under a clear coat, if there is one.
    fn clear_coat(&mut self, base: Surface, amount: FloatInput, gloss: FloatInput) -> Result<Surface> {
        if amount.factor <= 0.0 {
            return Ok(base);
        }
        let alpha = alpha_of_gloss(&mut self.builder, gloss)?;
        let base = self.builder.add_material(Material::new("principled: below its coat", base))?;
        Ok(Surface::Clearcoat { base, amount, alpha, model: CoatModel::Mitsuba })
    }

    /// A number from 0 to 1.
    fn share(&mut self, object: &Object, name: &str, missing: f32) -> Result<FloatInput> {
        let share = self.float(object, name, missing)?;
        Ok(FloatInput { factor: share.factor.clamp(0.0, 1.0), ..share })
    }

    /// Refractive index of the dielectric part: `eta`, or that which reflects `0.08 specular` at
    /// normal incidence.
    fn principled_ior(&mut self, object: &Object) -> Result<f32> {
        let eta = match object.float_in("eta", 0.1..=10.0)? {
            Some(eta) => eta,
            None => {
                let specular = object.float_in("specular", 0.0..=1.0)?.unwrap_or(0.5);
                let amplitude = (0.08 * specular).sqrt();
                (1.0 + amplitude) / (1.0 - amplitude)
            }
        };
        if !eta.is_finite() {
            return Err(Error::invalid(
                object.place(),
                "a refractive index that is infinite",
                "a finite one",
            ));
        }
        Ok(eta.max(1.0 / eta).clamp(IOR_RANGE[0], IOR_RANGE[1]) as f32)
    }
}
