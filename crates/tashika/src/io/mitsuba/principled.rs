//! The principled BSDFs of Mitsuba 3.

use super::Translation;
use super::inputs::GREY;
use super::object::Object;
use super::surfaces::IOR_RANGE;
use crate::bsdf::FacetModel;
use crate::color::Rgb;
use crate::error::{Error, Result};
use crate::scene::{ColorInput, FacetInput, FloatInput, Surface};

/// Transmission from which a principled material is glass.
const MOSTLY_TRANSMITTING: f32 = 0.5;

/// Shares whose effect is left out, by the row of the table that says so.
const LEFT_OUT: [(&str, &str); 2] =
    [("clearcoat", "principled clearcoat"), ("flatness", "principled flatness")];

impl Translation<'_> {
    /// `principled` and `principledthin`.
    pub(super) fn principled(&mut self, object: &Object) -> Result<Surface> {
        let is_thin = object.plugin == "principledthin";
        object.accept(&[
            "diffuse_reflectance_sampling_rate",
            "main_specular_sampling_rate",
            "clearcoat_sampling_rate",
            "clearcoat_gloss",
        ]);
        for (share, row) in LEFT_OUT {
            if self.float(object, share, 0.0)? != 0.0.into() {
                self.feature("material", row, &object.place_of(share))?;
            }
        }
        let base_color = self.reflectance(object, "base_color", GREY)?;
        let roughness = self.share(object, "roughness", 0.5)?;
        let metallic = self.share(object, "metallic", 0.0)?;
        let specular_tint = self.share(object, "spec_tint", 0.0)?;
        let (sheen, sheen_tint) = (self.share(object, "sheen", 0.0)?, self.share(object, "sheen_tint", 0.0)?);
        let anisotropic = self.share(object, "anisotropic", 0.0)?;
        let ior = self.principled_ior(object)?;
        let transmission = self.share(object, "spec_trans", 0.0)?.factor;
        if transmission > 0.0 && transmission < 1.0 {
            self.feature("material", "principled spec_trans", &object.place_of("spec_trans"))?;
        }
        let through =
            if is_thin { self.float(object, "diff_trans", 0.0)?.factor.clamp(0.0, 2.0) * 0.5 } else { 0.0 };
        if transmission >= MOSTLY_TRANSMITTING {
            if is_thin {
                let reflectance = Rgb::WHITE.into();
                return Ok(Surface::ThinGlass { ior, reflectance, transmittance: base_color });
            }
            // Light crosses two interfaces of a solid, each with the square root of the colour.
            let transmittance = base_color.factor.map(f32::sqrt);
            if anisotropic.texture.is_some() {
                self.feature("material", "principled anisotropic", &object.place_of("anisotropic"))?;
            }
            let alpha = self.builder.power(roughness, 2.0)?;
            let aspect = (1.0 - 0.9 * anisotropic.factor).sqrt();
            let by = |factor: f32| FloatInput { factor: alpha.factor * factor, ..alpha };
            let across = (aspect < 1.0).then(|| by(aspect));
            let facets = FacetInput { alpha: by(1.0 / aspect), across, model: FacetModel::GgxIndependent };
            return Ok(Surface::Glass { ior, reflectance: Rgb::WHITE, transmittance, facets });
        }
        if through > 0.0 {
            let share = |part: f32| ColorInput { factor: base_color.factor * part, ..base_color };
            return Ok(Surface::Translucent {
                reflectance: share(1.0 - through),
                transmittance: share(through),
            });
        }
        Ok(Surface::Principled {
            base_color,
            metallic,
            roughness,
            ior,
            specular_tint,
            sheen,
            sheen_tint,
            anisotropic,
        })
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
