//! The physically based surfaces of MaterialX: Standard Surface, OpenPBR and glTF's.
//!
//! All three have these layers, from the bottom up, under different names:
//!
//! ```text
//! base            base · base_color, and by `subsurface` its colour: diffuse, or by metalness a metal
//! gloss           F₀ = specular · specular_color · ((n − 1)/(n + 1))² of what is no metal, α = roughness²
//! sheen           sheen · sheen_color, as glTF has it
//! coat            coat, α = coat_roughness²
//! transmission    the share transmission · (1 − metalness) is glass
//! opacity         the share of light that the surface stops
//! ```
//!
//! Solid glass multiplies light by its tint at each crossing of its surface. If the tint is given
//! for a depth, each crossing multiplies by the square root, so that light that enters and leaves
//! the glass has the whole tint. OpenPBR's luminance is used as radiance, as in MaterialX's own
//! graph of OpenPBR.
//!
//! Sources: Georgiev et al. 2019; Andersson et al. 2024; [^materialx2024]. Held to this by
//! `usd_materialx` of the suite.

use super::Stage;
use super::features::met;
use super::inputs::Reading;
use super::materials::MeshAppearance;
use super::models::{Input, LeftOut, Model, Pane};
use super::network::Source;
use super::value::Value;
use crate::bsdf::CoatModel;
use crate::color::Rgb;
use crate::error::Result;
use crate::io::dielectrics::{normal_reflectance, rendered, single_face};
use crate::io::mixes::either;
use crate::io::principled::metallic_roughness;
use crate::io::textures::{mix, product};
use crate::scene::{
    Alpha, AlphaMode, Channel, ColorInput, Emission, FloatInput, Material, MaterialId, Surface,
};

impl Stage<'_> {
    /// Reads a material of one of these models.
    pub fn read_model(&mut self, r: &mut Reading, model: &Model, look: MeshAppearance) -> Result<Material> {
        let at = self.at(&r.shader);
        met("MaterialX", model.row, at, &mut self.builder)?;
        self.note_left_out(r, model)?;
        let base_color = self.base_color(r, model)?;
        let metalness = self.float(r, model.metalness.0, model.metalness.1, 1.0)?;
        let roughness = self.float(r, model.roughness.0, model.roughness.1, 1.0)?;
        let ior = rendered(self.input_number(&r.shader, &format!("inputs:{}", model.ior), 1.5)? as f32);
        let specular = self.float(r, model.specular, 1.0, f32::MAX)?.factor;
        let mut specular_f0 = self.color(r, "specular_color", Rgb::WHITE, 1.0)?;
        specular_f0.factor = specular_f0.factor.map(|c| (c * specular * normal_reflectance(ior)).min(1.0));
        let surface = metallic_roughness(base_color, metalness, roughness, specular_f0);
        let surface = self.fuzzy(r, model, surface)?;
        let surface = self.coated(r, model, surface)?;
        let surface = self.transmitting(r, model, surface, (base_color, metalness, roughness, ior))?;
        let radiance = self.emitted(r, model)?;
        let two_sided = look.is_double_sided;
        let emission = (!radiance.factor.is_black()).then_some(Emission { radiance, two_sided });
        let alpha = self.stopped(r, model)?;
        let normal = self.normal(r, model.normal)?;
        Ok(Material { emission, alpha, normal, ..Material::new(r.name.clone(), surface) })
    }

    /// Notes ignored inputs that would have an effect.
    fn note_left_out(&mut self, r: &Reading, model: &Model) -> Result<()> {
        for LeftOut { input, fallback, neutral, row, of } in model.left_out {
            let weight = match of {
                Some(name) => self.source(&r.shader, &format!("inputs:{name}"))?,
                None => Some(Source::Value(Value::Number(1.0))),
            };
            if !differs(weight.as_ref(), 0.0, 0.0) {
                continue;
            }
            let input = format!("inputs:{input}");
            if differs(self.source(&r.shader, &input)?.as_ref(), *fallback, *neutral) {
                let at = self.at_property(&r.shader, &input);
                met("MaterialX", row, at, &mut self.builder)?;
            }
        }
        Ok(())
    }

    fn base_color(&mut self, r: &mut Reading, model: &Model) -> Result<ColorInput> {
        let color = self.color(r, model.base_color.0, Rgb::gray(model.base_color.1), 1.0)?;
        let mut color = match model.base {
            Some(weight) => self.weighted(r, weight, color, 1.0)?,
            None => color,
        };
        if let Some([weight, below]) = model.subsurface {
            let amount = self.float(r, weight.0, weight.1, 1.0)?;
            if amount.factor > 0.0 {
                let at = self.at_property(&r.shader, &format!("inputs:{}", weight.0));
                met("MaterialX", "subsurface", at, &mut self.builder)?;
                let below = self.color(r, below.0, Rgb::gray(below.1), 1.0)?;
                let amount = self.as_color(r, amount)?;
                color = mix(&mut self.builder, [color, below], amount)?;
            }
        }
        Ok(color)
    }

    /// Product of a colour and its weight. The weight is clamped to the range from 0 to `most`.
    fn weighted(
        &mut self,
        r: &mut Reading,
        (name, fallback): Input,
        color: ColorInput,
        most: f32,
    ) -> Result<ColorInput> {
        let weight = self.float(r, name, fallback, most)?;
        let weight = self.as_color(r, weight)?;
        product(&mut self.builder, color, weight)
    }

    /// Converts a number to a colour that has it in all channels. A texture keeps its own channels.
    fn as_color(&mut self, r: &Reading, FloatInput { factor, texture }: FloatInput) -> Result<ColorInput> {
        if texture.is_some_and(|(_, channel)| channel != Channel::R) {
            let at = self.at(&r.shader);
            met("UsdUVTexture", "one channel as a colour", at, &mut self.builder)?;
        }
        Ok(ColorInput { factor: Rgb::gray(factor), texture: texture.map(|(texture, _)| texture) })
    }

    fn fuzzy(&mut self, r: &mut Reading, model: &Model, below: Surface) -> Result<Surface> {
        let color = self.color(r, model.sheen_color.0, Rgb::gray(model.sheen_color.1), 1.0)?;
        let color = match model.sheen {
            Some(weight) => self.weighted(r, (weight, 0.0), color, 1.0)?,
            None => color,
        };
        if color.factor.is_black() {
            return Ok(below);
        }
        let roughness = self.float(r, model.sheen_roughness.0, model.sheen_roughness.1, 1.0)?;
        let base = self.below(r, "sheen", below)?;
        Ok(Surface::Sheen { base, color, roughness })
    }

    fn coated(&mut self, r: &mut Reading, model: &Model, below: Surface) -> Result<Surface> {
        let amount = self.float(r, model.coat, 0.0, 1.0)?;
        if amount.factor <= 0.0 {
            return Ok(below);
        }
        let roughness = self.float(r, model.coat_roughness.0, model.coat_roughness.1, 1.0)?;
        let alpha = self.builder.power(roughness, 2.0)?;
        let base = self.below(r, "coat", below)?;
        Ok(Surface::Clearcoat { base, amount, alpha, model: CoatModel::Layer })
    }

    fn below(&mut self, r: &Reading, layer: &str, surface: Surface) -> Result<MaterialId> {
        self.builder.add_material(Material::new(format!("{} below its {layer}", r.name), surface))
    }

    /// Mixes in glass for the share that transmits light.
    fn transmitting(
        &mut self,
        r: &mut Reading,
        model: &Model,
        surface: Surface,
        (base_color, metalness, roughness, ior): (ColorInput, FloatInput, FloatInput, f32),
    ) -> Result<Surface> {
        let share = self.float(r, model.transmission, 0.0, 1.0)?;
        let metal = if metalness.texture.is_some() { 0.0 } else { metalness.factor };
        let share = FloatInput { factor: share.factor * (1.0 - metal), ..share };
        if share.factor <= 0.0 {
            return Ok(surface);
        }
        let tint = match model.transmission_color {
            Some(name) => self.color(r, name, Rgb::WHITE, 1.0)?,
            None => base_color,
        };
        let facets = self.builder.power(roughness, 2.0)?.into();
        let (Pane::Where(name) | Pane::Without(name)) = model.pane;
        let said = self.input_number(&r.shader, &format!("inputs:{name}"), 0.0)?;
        let pane = match model.pane {
            Pane::Where(_) => (said != 0.0).then_some(ior),
            Pane::Without(_) => (said == 0.0).then(|| single_face(ior)),
        };
        let glass = if let Some(ior) = pane {
            Surface::ThinGlass { ior, reflectance: Rgb::WHITE.into(), transmittance: tint, facets }
        } else {
            if tint.texture.is_some() {
                let at = self.at(&r.shader);
                met("MaterialX", "textures of the tint of solid glass", at, &mut self.builder)?;
            }
            let depth = match model.transmission_depth {
                Some(name) => self.input_number(&r.shader, &format!("inputs:{name}"), 0.0)?,
                None => 0.0,
            };
            let transmittance = if depth > 0.0 {
                let at = self.at(&r.shader);
                met("MaterialX", "transmission depth", at, &mut self.builder)?;
                tint.factor.map(f32::sqrt)
            } else {
                tint.factor
            };
            Surface::Glass { ior, reflectance: Rgb::WHITE, transmittance, facets }
        };
        if share == 1.0.into() {
            return Ok(glass);
        }
        either(&mut self.builder, &r.name, [surface, glass], share)
    }

    fn emitted(&mut self, r: &mut Reading, model: &Model) -> Result<ColorInput> {
        let (name, fallback) = model.emission_color;
        let color = self.color(r, name, Rgb::gray(fallback), f32::MAX)?;
        let mut radiance = self.weighted(r, model.emission, color, f32::MAX)?;
        radiance.factor = radiance.factor.map(|v| v.min(f32::MAX));
        Ok(radiance)
    }

    /// Opacity of the surface; none if it is 1 everywhere.
    fn stopped(&mut self, r: &mut Reading, model: &Model) -> Result<Option<Alpha>> {
        let mode = match model.alpha_mode.map(|inputs| inputs.map(|name| format!("inputs:{name}"))) {
            None => AlphaMode::Blend,
            Some([mode, cutoff]) => match self.input_number(&r.shader, &mode, 0.0)? {
                1.0 => {
                    let cutoff = self.input_number(&r.shader, &cutoff, 0.5)?;
                    AlphaMode::Mask { cutoff: cutoff.clamp(0.0, 1e3) as f32 }
                }
                2.0 => AlphaMode::Blend,
                _ => return Ok(None),
            },
        };
        let value = self.float(r, model.opacity, 1.0, 1.0)?;
        Ok((value != 1.0.into()).then_some(Alpha { value, mode }))
    }
}

/// Returns true if an input differs from its neutral value.
fn differs(source: Option<&Source>, fallback: f64, neutral: f64) -> bool {
    match source {
        Some(Source::Output(..)) => true,
        Some(Source::Value(value)) => match (value.number(), value.tuple::<3>()) {
            (Some(n), _) => n != neutral,
            (None, Some(all)) => all != [neutral; 3],
            (None, None) => fallback != neutral,
        },
        None => fallback != neutral,
    }
}
