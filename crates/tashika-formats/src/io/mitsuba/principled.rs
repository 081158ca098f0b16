//! The principled BSDFs of Mitsuba 3.

use super::Translation;
use super::inputs::GREY;
use super::object::Object;
use crate::bsdf::CoatModel;
use crate::color::Rgb;
use crate::error::{Error, Result};
use crate::io::dielectrics::{IOR_RANGE, rendered, single_face};
use crate::io::principled::Principled;
use crate::scene::{ColorInput, FloatInput, SceneBuilder, Surface};

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
        // Thin sheets have no coat.
        let mut of_coat = |name| if is_thin { Ok(0.0.into()) } else { self.share(object, name, 0.0) };
        let (clearcoat, gloss) = (of_coat("clearcoat")?, of_coat("clearcoat_gloss")?);
        let material = Principled {
            name: "principled",
            base_color,
            metallic,
            roughness,
            // A thin sheet reflects specularly only in the share that transmits.
            ior: if is_thin { IOR_RANGE[0] } else { ior },
            specular_tint,
            sheen,
            sheen_tint,
            flatness,
            anisotropic,
            transmission,
            clearcoat,
            gloss,
            coat: CoatModel::Mitsuba,
        };
        if material.glass_share().factor > 0.0 {
            if clearcoat.factor > 0.0 {
                self.feature("material", "principled clearcoat", &object.place_of("clearcoat"))?;
            }
            if metallic.texture.is_some() {
                self.feature("material", "principled spec_trans", &object.place_of("spec_trans"))?;
            }
            if anisotropic.texture.is_some() && !is_thin {
                self.feature("material", "principled anisotropic", &object.place_of("anisotropic"))?;
            }
        }
        let opaque = |material: &Principled| match through > 0.0 {
            true => Surface::Translucent { reflectance: part(1.0 - through), transmittance: part(through) },
            false => material.opaque(),
        };
        let glass = |material: &Principled, builder: &mut SceneBuilder| match is_thin {
            true => {
                let (ior, reflectance) = (single_face(ior), Rgb::WHITE.into());
                Ok(Surface::ThinGlass { ior, reflectance, transmittance: base_color, facets: 0.0.into() })
            }
            false => material.glass(builder),
        };
        material.surface(&mut self.builder, opaque, glass)
    }

    /// Reads a number from 0 to 1.
    fn share(&mut self, object: &Object, name: &str, missing: f32) -> Result<FloatInput> {
        let share = self.float(object, name, missing)?;
        Ok(FloatInput { factor: share.factor.clamp(0.0, 1.0), ..share })
    }

    /// Refractive index of the dielectric part: `eta`, or the index that reflects `0.08 specular`
    /// at normal incidence.
    fn principled_ior(&mut self, object: &Object) -> Result<f32> {
        let eta = match object.float_in("eta", 0.1..=10.0) {
            Some(eta) => eta,
            None => {
                let specular = object.float_in("specular", 0.0..=1.0).unwrap_or(0.5);
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
        Ok(rendered(eta.max(1.0 / eta) as f32))
    }
}
