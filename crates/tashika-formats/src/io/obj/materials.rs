//! Conversion of MTL definitions to materials.
//!
//! The format dates from 1995: `illum` selects one of its lighting formulas, and exporters differ
//! in how they use them. The first rule that applies decides:
//!
//! 1. With `illum` 4, 6, 7 or 9, and `Tf` that is not black or, without `Tf`, an opacity below 1,
//!    and `Ni` > 1 (or none: 1.5): smooth glass of index `Ni`, transmittance `Tf` (or white);
//!    approximated.
//! 2. With `Pr`, `Pm` or a map of them: glTF's metallic-roughness, base `Kd`, `f₀` of `Ni`.
//! 3. With `illum` 5, or 3 without `Ns`, and `Ks` brighter than `Kd`: mirror of reflectance `Ks`
//!    beside Lambert of `Kd`; approximated.
//! 4. With `illum` 0 or 1, or `Ks` black or absent: Lambert of reflectance `Kd`.
//! 5. Otherwise Phong: diffuse `Kd`, specular `Ks`, exponent `Ns`.
//!
//! * `K*` is multiplied by `map_K*`, if that can be read; without `K*`, the factor is 1. A black
//!   `Kd` with a map counts as 1, because a map is never meant to be invisible.
//! * Opacity is `d`, or else `1 − Tr`, times `map_d` (its alpha channel if it has one, else red).
//!   It is the fraction of light that is stopped. For glass the opacity is `map_d` alone.
//! * `Ke` times `map_Ke` is the radiance emitted by both sides (W·m⁻²·sr⁻¹): the format does not
//!   distinguish sides, and the winding of its faces is arbitrary.
//! * `Ns` is taken as the exponent about the mirror direction. About the half vector of the
//!   specification, the same exponent makes a highlight twice as wide.
//! * `norm` is a normal map in tangent space, green up in the image.
//! * Materials that are used and not defined are grey, reflectance [`GREY`].
//!
//! # Guarantee
//! Any numbers give a material that [`SceneBuilder`] accepts; changes are noted.
//!
//! Source: the Wavefront MTL specification, version 4.2 (1995). Tested by
//! `suite::obj::materials_*`, `suite::damaged_obj::absurd_*`.

use std::ops::RangeInclusive;

use super::features::meaning;
use super::map::Map;
use super::mtl::Definition;
use super::references::{Content, Textures};
use crate::color::Rgb;
use crate::error::Location;
use crate::io::dielectrics::{IOR_RANGE, normal_reflectance};
use crate::io::mixes::{GREY, beside};
use crate::io::principled::metallic_roughness;
use crate::scene::{
    Alpha, AlphaMode, Channel, ColorInput, Emission, FloatInput, Material, NormalInput, NoteKind,
    SceneBuilder, Surface, TextureId,
};

/// Exponent of highlights that have none: chosen, a broad highlight.
const DEFAULT_EXPONENT: f32 = 10.0;

/// Roughness of physically based materials that have none: chosen, as in other renderers.
const DEFAULT_ROUGHNESS: f32 = 0.5;

/// Refractive index of materials that have none: window glass.
const DEFAULT_IOR: f32 = 1.5;

/// Largest radiance (W·m⁻²·sr⁻¹): far above the sun's 2·10⁷, far below overflow.
const MAX_RADIANCE: f32 = 1e12;

/// Adds the textures and parts that a definition refers to, and returns its material.
pub(super) fn convert(
    name: &str,
    definition: &Definition,
    textures: &mut Textures<'_>,
    builder: &mut SceneBuilder,
) -> Material {
    let mut converter = Converter { name, definition, textures, builder };
    let surface = converter.surface();
    let glass = matches!(surface, Surface::Glass { .. });
    let (emission, alpha) = (converter.emission(), converter.alpha(glass));
    Material { emission, alpha, normal: converter.normal(), ..Material::new(name, surface) }
}

struct Converter<'a, 'f> {
    name: &'a str,
    definition: &'a Definition,
    textures: &'a mut Textures<'f>,
    builder: &'a mut SceneBuilder,
}

impl Converter<'_, '_> {
    fn at(&self) -> Location {
        self.definition.at.clone()
    }

    fn note(&mut self, kind: NoteKind, message: impl Into<String>) {
        let at = self.at();
        self.builder.note(kind, message, at);
    }

    /// Adds the note of the row `name` about the definition as a whole.
    fn meaning(&mut self, name: &str) {
        meaning(name, &self.definition.at, self.builder.notes_mut());
    }

    fn surface(&mut self) -> Surface {
        let d = self.definition;
        if let Some(glass) = self.glass() {
            return glass;
        }
        if d.pr.is_some() || d.pm.is_some() || d.map_pr.is_some() || d.map_pm.is_some() {
            return self.metallic_roughness();
        }
        let luminance = |c: Option<Rgb>| c.unwrap_or(Rgb::BLACK).luminance();
        let mirror = d.illum == Some(5) || (d.illum == Some(3) && d.ns.is_none());
        if mirror && luminance(d.ks) > luminance(d.kd) {
            self.meaning("illum 3, 5");
            return self.mirror();
        }
        let diffuse = self.diffuse();
        if matches!(d.illum, Some(0 | 1)) {
            if luminance(d.ks) > 0.0 {
                self.meaning("illum 0, 1 with Ks");
            }
            return Surface::Lambert { reflectance: diffuse };
        }
        let specular = self.specular();
        if specular.factor.is_black() {
            return Surface::Lambert { reflectance: diffuse };
        }
        if d.ns.is_none() {
            self.note(
                NoteKind::Defaulted,
                format!("materials with Ks but without Ns: exponent {DEFAULT_EXPONENT}"),
            );
        }
        Surface::Phong { diffuse, specular, exponent: self.number("Ns", d.ns, DEFAULT_EXPONENT, 0.0..=1e6) }
    }

    /// Mix of a mirror with the diffuse reflection, or the mirror alone if there is no diffuse
    /// part.
    fn mirror(&mut self) -> Surface {
        let specular = self.specular();
        let base = match self.definition.kd {
            Some(kd) if !kd.is_black() => self.diffuse(),
            _ => return Surface::Mirror { reflectance: specular },
        };
        let names = ["diffuse", "mirror"].map(|part| format!("{}: {part}", self.name));
        let mirror = |reflectance| Surface::Mirror { reflectance };
        beside(self.builder, names, [base, specular], mirror).unwrap_or(mirror(specular))
    }

    fn glass(&mut self) -> Option<Surface> {
        let d = self.definition;
        let transmits = d.tf.map_or(self.opacity() < 1.0, |tf| !tf.is_black());
        let bends = d.ni.is_none_or(|ni| ni > 1.0 || ni.is_nan());
        if !matches!(d.illum, Some(4 | 6 | 7 | 9)) || !transmits || !bends {
            return None;
        }
        self.meaning("illum 4, 6, 7, 9");
        Some(Surface::Glass {
            ior: self.number("Ni", d.ni, DEFAULT_IOR, 1.0_f32.next_up()..=IOR_RANGE[1]),
            reflectance: Rgb::WHITE,
            transmittance: self.reflectance("Tf", d.tf.unwrap_or(Rgb::WHITE), false),
            facets: 0.0.into(),
        })
    }

    fn metallic_roughness(&mut self) -> Surface {
        let d = self.definition;
        let default = |map: &Option<Map>, without| if map.is_some() { 1.0 } else { without };
        let metallic = self.number("Pm", d.pm, default(&d.map_pm, 0.0), 0.0..=1.0);
        let roughness = self.number("Pr", d.pr, default(&d.map_pr, DEFAULT_ROUGHNESS), 0.0..=1.0);
        let ior = self.number("Ni", d.ni.filter(|&ni| ni > 1.0), DEFAULT_IOR, 1.0..=IOR_RANGE[1]);
        let base_color = self.diffuse();
        let metallic = self.mapped_number(metallic, d.map_pm.as_ref());
        let roughness = self.mapped_number(roughness, d.map_pr.as_ref());
        metallic_roughness(base_color, metallic, roughness, Rgb::gray(normal_reflectance(ior)).into())
    }

    fn diffuse(&mut self) -> ColorInput {
        let d = self.definition;
        let texture = self.color_map(d.map_kd.as_ref());
        let mut factor = d.kd.unwrap_or(Rgb::gray(if texture.is_some() { 1.0 } else { GREY }));
        if d.kd.is_none() && texture.is_none() {
            self.note(NoteKind::Defaulted, format!("materials without Kd: reflectance {GREY}"));
        }
        if texture.is_some() && factor.is_black() {
            self.meaning("map_Kd with black Kd");
            factor = Rgb::WHITE;
        }
        ColorInput { factor: self.reflectance("Kd", factor, texture.is_some()), texture }
    }

    fn specular(&mut self) -> ColorInput {
        let d = self.definition;
        let texture = self.color_map(d.map_ks.as_ref());
        let factor = d.ks.unwrap_or(if texture.is_some() { Rgb::WHITE } else { Rgb::BLACK });
        ColorInput { factor: self.reflectance("Ks", factor, texture.is_some()), texture }
    }

    fn emission(&mut self) -> Option<Emission> {
        let d = self.definition;
        let texture = self.color_map(d.map_ke.as_ref());
        let factor = d.ke.unwrap_or(if texture.is_some() { Rgb::WHITE } else { Rgb::BLACK });
        let factor = self.color("Ke", factor, MAX_RADIANCE);
        if factor.is_black() {
            return None;
        }
        Some(Emission { radiance: ColorInput { factor, texture }, two_sided: true })
    }

    fn normal(&mut self) -> Option<NormalInput> {
        let map = self.definition.norm.as_ref()?;
        let (texture, _) = self.textures.load(map, self.definition, Content::Number, self.builder)?;
        Some(NormalInput::Map { texture, scale: 1.0 })
    }

    fn alpha(&mut self, glass: bool) -> Option<Alpha> {
        let d = self.definition;
        let factor = if glass {
            1.0
        } else if d.d.is_some() {
            self.number("d", d.d, 1.0, 0.0..=1.0)
        } else {
            self.number("Tr", d.tr.map(|tr| 1.0 - tr), 1.0, 0.0..=1.0)
        };
        let texture = d.map_d.as_ref().and_then(|map| {
            let content = if matches!(map.channel, None | Some(Channel::A)) {
                Content::Opacity
            } else {
                Content::Number
            };
            let (texture, has_alpha) = self.textures.load(map, d, content, self.builder)?;
            Some((texture, map.channel.unwrap_or(if has_alpha { Channel::A } else { Channel::R })))
        });
        if factor == 0.0 {
            self.meaning("d 0");
        }
        let value = FloatInput { factor, texture };
        (value != FloatInput::from(1.0)).then_some(Alpha { value, mode: AlphaMode::Blend })
    }

    /// Returns `d`, else `1 − Tr`, else 1.
    fn opacity(&self) -> f32 {
        let d = self.definition;
        d.d.or(d.tr.map(|tr| 1.0 - tr)).unwrap_or(1.0)
    }

    fn color_map(&mut self, map: Option<&Map>) -> Option<TextureId> {
        let loaded = self.textures.load(map?, self.definition, Content::Color, self.builder)?;
        Some(loaded.0)
    }

    fn mapped_number(&mut self, factor: f32, map: Option<&Map>) -> FloatInput {
        let texture = map.and_then(|map| {
            let loaded = self.textures.load(map, self.definition, Content::Number, self.builder)?;
            Some((loaded.0, map.channel.unwrap_or(Channel::R)))
        });
        FloatInput { factor, texture }
    }

    /// Limits a number to `range`; returns `default` if it is absent or not a number.
    fn number(&mut self, keyword: &str, value: Option<f32>, default: f32, range: RangeInclusive<f32>) -> f32 {
        let Some(value) = value else { return default };
        if range.contains(&value) {
            return value;
        }
        let (least, most) = (*range.start(), *range.end());
        self.note(NoteKind::Repaired, format!("{keyword} outside {least} to {most}: limited to that"));
        if value.is_nan() { default } else { value.clamp(least, most) }
    }

    /// Limits a reflectance or transmittance to 1. Under a texture it may exceed 1, because the
    /// product with the texture is limited later.
    fn reflectance(&mut self, keyword: &str, color: Rgb, textured: bool) -> Rgb {
        self.color(keyword, color, if textured { f32::MAX } else { 1.0 })
    }

    /// Limits the channels of a colour to 0 to `most`.
    fn color(&mut self, keyword: &str, color: Rgb, most: f32) -> Rgb {
        // NaN becomes 0.
        let limited = color.map(|c| if c > 0.0 { c.min(most) } else { 0.0 });
        if limited != color {
            let message = if most == f32::MAX {
                format!("{keyword} with channels below 0 or not finite: limited")
            } else {
                format!("{keyword} with channels outside 0 to {most}: limited to that")
            };
            self.note(NoteKind::Repaired, message);
        }
        limited
    }
}
