//! Conversion of `<bsdf>`s that contain others to materials.
//!
//! | Mitsuba | here |
//! |---|---|
//! | `twosided` | its material on both sides, or one for each side; backs of others are black |
//! | `mask` | [`Alpha`] |
//! | `bumpmap`, `normalmap` | [`NormalInput`] |
//! | `blendbsdf`, `mixturebsdf` | [`Surface::Mix`]; with `null`, opacity |
//! | `coating`, `roughcoating` | [`Surface::Coated`] over a Lambertian base |
//! | `null` | invisible |
//!
//! Each object is converted once, so that the work stays bounded if many objects refer to the same
//! one. If a part of a mix has an opacity, that is ignored. `surfaces` converts bsdfs that contain
//! no others.
//!
//! Held to this by `suite::mitsuba`.

use super::Translation;
use super::inputs::{GREY, Quantity};
use super::object::{Class, Object, Value};
use super::values;
use crate::color::Rgb;
use crate::error::{Error, Result};
use crate::io::mixes::grey;
use crate::io::notes::shown;
use crate::io::textures::between;
use crate::scene::{
    Alpha, AlphaMode, Back, Channel, CoatBase, ColorInput, Emission, FloatInput, Material, MaterialId,
    NormalInput, NoteKind, Surface,
};

/// Most parts of a mixture.
const MAX_PARTS: usize = 64;

/// Deviation of the sum of a mixture's weights from 1 above which it is noted.
const WEIGHT_TOLERANCE: f64 = 1e-3;

impl Translation<'_> {
    /// Material of a shape: its bsdf, with the emission of its area light. Without a bsdf it is
    /// grey, or black if it emits.
    pub(super) fn shape_material(
        &mut self,
        bsdf: Option<&Object>,
        light: Option<(&Object, Emission)>,
    ) -> Result<MaterialId> {
        let key = (bsdf.map(|b| b.index), light.as_ref().map(|l| l.0.index));
        if let Some(&id) = self.shape_materials.get(&key) {
            return Ok(id);
        }
        let mut material = match bsdf {
            Some(bsdf) => self.material(bsdf)?,
            None => {
                let reflectance = if light.is_some() { Rgb::BLACK } else { GREY };
                let surface = Surface::Lambert { reflectance: reflectance.into() };
                Material { back: Back::Black, ..Material::new("without material", surface) }
            }
        };
        if let Some((_, emission)) = light {
            // As in Mitsuba, a surface that emits is black, not invisible.
            if is_invisible(&material) {
                material = Material::new(material.name, Surface::Lambert { reflectance: Rgb::BLACK.into() });
            }
            material.emission = Some(emission);
        }
        let id = self.builder.add_material(material)?;
        self.shape_materials.insert(key, id);
        Ok(id)
    }

    /// Material of shapes that only bound a medium.
    pub(super) fn boundary(&mut self) -> Result<MaterialId> {
        if let Some(known) = self.boundary {
            return Ok(known);
        }
        let made = self.builder.add_material(Material::new("null", Surface::Boundary))?;
        self.boundary = Some(made);
        Ok(made)
    }

    /// Converts a bsdf to a material.
    ///
    /// # Errors
    /// [`Error::Invalid`] if it refers to itself.
    pub(super) fn material(&mut self, object: &Object) -> Result<Material> {
        if let Some(known) = self.materials.begin(object.index, object)? {
            return Ok(known);
        }
        let mut material = self.nested(object, |inside| inside.convert(object))?;
        if let Some(id) = &object.id {
            material.name = shown(id);
        }
        Ok(self.materials.finish(object.index, material))
    }

    fn convert(&mut self, object: &Object) -> Result<Material> {
        let name = shown(object.label());
        if !self.meet("material", object, "grey of reflectance 0.5")? {
            object.accept_all();
            return Ok(Material::new(name, grey()));
        }
        let document = self.document;
        let mut nested = document.children(object, Class::Bsdf).map(|(_, o)| o);
        match object.plugin.as_str() {
            "twosided" => {
                let front = self.inner(object, nested.next())?;
                let back = match nested.next() {
                    Some(back) => {
                        let back = self.material(back)?;
                        Back::Material(self.part(back, "the material of the other side")?)
                    }
                    None => Back::Same,
                };
                Ok(Material { back, ..front })
            }
            "mask" => {
                let mut inner = self.inner(object, nested.next())?;
                let mut value = self.float(object, "opacity", 0.5)?;
                if let Some((_, channel)) = &mut value.texture
                    && let Some(opacity) = document.texture(object, "opacity")
                    && self.has_alpha(opacity)?
                {
                    self.feature("texture", "opacity of an image with alpha", &opacity.at)?;
                    *channel = Channel::A;
                }
                value.factor = value.factor.clamp(0.0, 1.0);
                inner.alpha = Some(Alpha { value, mode: AlphaMode::Blend });
                Ok(inner)
            }
            "bumpmap" => {
                let mut inner = self.inner(object, nested.next())?;
                if let Some(texture) = document.any_texture(object) {
                    let scale = object.float("scale").unwrap_or(1.0) as f32;
                    let texture = self.texture(texture, Quantity::Number)?;
                    // A constant height has no slope.
                    let mut height = texture.number();
                    if height.texture.is_some() {
                        height.factor *= scale;
                        inner.normal = Some(NormalInput::Bump { height });
                    }
                }
                Ok(inner)
            }
            "normalmap" => {
                let mut inner = self.inner(object, nested.next())?;
                if let Some(texture) = document.any_texture(object) {
                    let texture = self.texture(texture, Quantity::Number)?;
                    inner.normal =
                        texture.color.texture.map(|texture| NormalInput::Map { texture, scale: 1.0 });
                }
                Ok(inner)
            }
            "blendbsdf" => {
                let weight =
                    if document.texture(object, "weight").is_none() && object.float("weight").is_none() {
                        self.texture_weight(object)?
                    } else {
                        self.float(object, "weight", 0.5)?
                    };
                let (first, second) =
                    (self.inner(object, nested.next())?, self.inner(object, nested.next())?);
                self.mix(name, first, second, weight)
            }
            "mixturebsdf" => {
                let parts = nested.map(|o| self.material(o)).collect::<Result<Vec<_>>>()?;
                self.mixture(object, name, parts)
            }
            "coating" | "roughcoating" => {
                let inner = self.inner(object, nested.next())?;
                self.coat(object, inner)
            }
            "null" | "polarizer" | "retarder" | "circular" => {
                object.accept_known();
                Ok(invisible(name))
            }
            plugin => {
                let surface = self.surface(object)?;
                let back = match &surface {
                    Surface::Glass { .. } | Surface::ThinGlass { .. } | Surface::Translucent { .. } => {
                        Back::Same
                    }
                    _ if matches!(plugin, "principledthin" | "hair") => Back::Same,
                    _ => Back::Black,
                };
                Ok(Material { back, ..Material::new(name, surface) })
            }
        }
    }

    /// Weight of a mix, from the nested texture of any name; ½ without a texture.
    fn texture_weight(&mut self, object: &Object) -> Result<FloatInput> {
        let Some(texture) = self.document.any_texture(object) else { return Ok(0.5.into()) };
        Ok(self.texture(texture, Quantity::Number)?.number())
    }

    /// Converts the nested material; grey, with a note, if there is none.
    fn inner(&mut self, object: &Object, nested: Option<&Object>) -> Result<Material> {
        if let Some(nested) = nested {
            return self.material(nested);
        }
        let message = format!("bsdf {:?} without a nested bsdf: grey of reflectance 0.5", object.plugin);
        self.builder.note(NoteKind::Repaired, message, object.at.clone());
        Ok(Material::new(shown(object.label()), grey()))
    }

    /// Mix of two materials. If one of them is invisible, its share makes the other one
    /// transparent.
    fn mix(
        &mut self,
        name: String,
        first: Material,
        second: Material,
        mut amount: FloatInput,
    ) -> Result<Material> {
        amount.factor = amount.factor.clamp(0.0, 1.0);
        match (is_invisible(&first), is_invisible(&second)) {
            (true, true) => Ok(invisible(name)),
            (true, false) => {
                let alpha = Some(Alpha { value: amount, mode: AlphaMode::Blend });
                Ok(Material { name, alpha, ..second })
            }
            (false, true) => {
                let value = self.complement(amount)?;
                Ok(Material { name, alpha: Some(Alpha { value, mode: AlphaMode::Blend }), ..first })
            }
            (false, false) => {
                let normal = if first.normal == second.normal { first.normal } else { None };
                if normal.is_none() && (first.normal.is_some() || second.normal.is_some()) {
                    self.note_of_part("normals of the parts of a mix: not used");
                }
                let back = if first.back == second.back { first.back } else { Back::Same };
                let [first, second] = [first, second].map(|part| self.part(part, "the parts of a mix"));
                let surface = Surface::Mix { first: first?, second: second?, amount };
                Ok(Material { normal, back, ..Material::new(name, surface) })
            }
        }
    }

    /// Adds the surface of a material as a part of another one.
    fn part(&mut self, material: Material, what: &str) -> Result<MaterialId> {
        if material.alpha.is_some() {
            self.note_of_part(&format!("opacity of {what}: not used"));
        }
        self.builder.add_material(Material { emission: None, alpha: None, normal: None, ..material })
    }

    fn note_of_part(&mut self, message: &str) {
        let at = crate::error::Location::file(self.files.path());
        self.builder.note(NoteKind::Ignored, message, at);
    }

    /// `1 − amount`.
    fn complement(&mut self, amount: FloatInput) -> Result<FloatInput> {
        let Some((texture, channel)) = amount.texture else { return Ok((1.0 - amount.factor).into()) };
        let ends = [Rgb::WHITE, Rgb::gray(1.0 - amount.factor)];
        let texture = between(&mut self.builder, ends, texture)?;
        // The ends are constants of opacity 1, so the alpha of the blend is 1 everywhere.
        let channel = if channel == Channel::A { Channel::Luminance } else { channel };
        Ok(FloatInput { factor: 1.0, texture: Some((texture, channel)) })
    }

    /// Mixture of materials by weights, as mixes of two at a time.
    fn mixture(&mut self, object: &Object, name: String, parts: Vec<Material>) -> Result<Material> {
        let weights = object.take("weights", |value| match value {
            Value::Text(text) => values::numbers(text),
            Value::Float(one) => Some(vec![*one]),
            Value::Vector(v) => Some(v.to_array().to_vec()),
            _ => None,
        });
        let weights = weights.unwrap_or_else(|| vec![1.0; parts.len()]);
        let sum: f64 = weights.iter().sum();
        let counts = weights.len() == parts.len() && (1..=MAX_PARTS).contains(&parts.len());
        let sound = counts && weights.iter().all(|w| *w >= 0.0) && sum > 0.0 && sum.is_finite();
        if !sound {
            let found = format!("{} weights {weights:?} for {} materials", weights.len(), parts.len());
            let expected = format!("a weight of at least 0 for each of 1 to {MAX_PARTS} materials");
            return Err(Error::invalid(object.place(), found, expected));
        }
        let mut all: Vec<_> = parts.into_iter().zip(weights).collect();
        if sum > 1.0 + WEIGHT_TOLERANCE {
            let message = "weights of a mixture that add up to more than 1: divided by their sum";
            self.builder.note(NoteKind::Approximated, message, object.at.clone());
        } else if sum < 1.0 - WEIGHT_TOLERANCE {
            let black = Surface::Lambert { reflectance: Rgb::BLACK.into() };
            all.push((Material::new("the rest of a mixture", black), 1.0 - sum));
        }
        let mut all = all.into_iter();
        let Some((mut mixed, mut total)) = all.next() else { return Ok(invisible(name)) };
        for (part, weight) in all {
            total += weight;
            let share = if total > 0.0 { weight / total } else { 0.0 };
            mixed = self.mix(name.clone(), mixed, part, FloatInput::from(share as f32))?;
        }
        Ok(Material { name, ..mixed })
    }

    fn coat(&mut self, object: &Object, inner: Material) -> Result<Material> {
        object.accept(&["thickness", "sampling_weight", "specular_sampling_weight"]);
        if !self.constant_color(object, &["sigma_a"], Quantity::Number, Rgb::BLACK)?.is_black() {
            self.feature("material", "coating sigma_a", &object.place_of("sigma_a"))?;
        }
        let ior = self.ior(object)?;
        let facets = if object.plugin == "coating" { 0.0.into() } else { self.facets(object)? };
        let white = Rgb::WHITE;
        let specular = self.color(object, &["specular_reflectance"], Quantity::Reflectance, white)?;
        let surface = match inner.surface {
            Surface::Lambert { reflectance } => {
                Surface::Coated { reflectance, base: CoatBase::Lossy, specular, ior, facets }
            }
            other => {
                self.feature("material", "coating over no diffuse", &object.at)?;
                other
            }
        };
        Ok(Material { surface, ..inner })
    }

    /// Reads the emission of an area light.
    pub(super) fn emission(&mut self, light: &Object) -> Result<Emission> {
        light.accept(&["sampling_weight"]);
        let radiance = self.color(light, &["radiance", "intensity"], Quantity::Radiance, Rgb::WHITE)?;
        Ok(Emission { radiance, two_sided: false })
    }
}

/// Returns true if the opacity of a material is zero everywhere.
pub(super) fn is_invisible(material: &Material) -> bool {
    let none = FloatInput::from(0.0);
    material.alpha.is_some_and(|alpha| alpha.value == none)
}

fn invisible(name: String) -> Material {
    let surface = Surface::Lambert { reflectance: ColorInput::from(Rgb::BLACK) };
    let alpha = Some(Alpha { value: 0.0.into(), mode: AlphaMode::Blend });
    Material { alpha, ..Material::new(name, surface) }
}
