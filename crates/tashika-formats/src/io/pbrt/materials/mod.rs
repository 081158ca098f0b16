//! `Material`, `MakeNamedMaterial`, `NamedMaterial`.
//!
//! Emission and alpha belong to shapes in pbrt and to materials here. A material of the file
//! therefore becomes one material of the scene for each pair of light and alpha that it is used
//! with, in the order of first use.
//!
//! Held to this by `suite::pbrt_appearance::materials_*`. For the surface of each type see [`v3`]
//! and [`v4`].

mod disney;
mod maker;
mod v3;
mod v4;

use std::collections::BTreeMap;

use self::maker::Maker;
use super::loading::Loading;
use super::names::Named;
use super::parameters::Parameters;
use super::textures::Textures;
use super::version::Version;
use crate::color::Rgb;
use crate::error::Result;
use crate::io::mixes::grey;
use crate::io::notes::excerpt;
use crate::scene::{
    Alpha, AlphaMode, Channel, ColorInput, Emission, FloatInput, Material, MaterialId, NormalInput, NoteKind,
    Surface, TextureId,
};

/// A material as the file defines it.
#[derive(Clone, Debug)]
pub(super) struct Definition {
    name: String,
    /// None for an invisible interface, which becomes a boundary if it separates media.
    surface: Option<Surface>,
    normal: Option<NormalInput>,
    /// Opacity of the material itself.
    opacity: Option<FloatInput>,
    /// True if the material depends on texture coordinates.
    textured: bool,
}

/// Number of a definition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct DefinitionId(usize);

/// Keys of the scene's materials: definition, light and alpha. Numbers are stored as their bits,
/// which can be ordered.
type ColorKey = ([u32; 3], Option<TextureId>);
type FloatKey = (u32, Option<(TextureId, u8)>);
type Key = (DefinitionId, Option<(ColorKey, bool)>, Option<FloatKey>);

/// Definitions of the file, and materials made of them.
#[derive(Debug)]
pub(super) struct Materials {
    definitions: Vec<Definition>,
    named: BTreeMap<String, DefinitionId>,
    made: BTreeMap<Key, MaterialId>,
    boundary: Option<MaterialId>,
}

impl Materials {
    /// State with the material of shapes that precede any `Material`.
    pub(super) fn new() -> Self {
        let surface = Some(grey());
        let first =
            Definition { name: "default".to_owned(), surface, normal: None, opacity: None, textured: false };
        Self { definitions: vec![first], named: BTreeMap::new(), made: BTreeMap::new(), boundary: None }
    }

    /// Material of shapes that precede any `Material`.
    pub(super) fn default_id(&self) -> DefinitionId {
        DefinitionId(0)
    }

    /// `Material class`.
    pub(super) fn define(
        &mut self,
        loading: &mut Loading<'_>,
        textures: &Textures,
        class: &str,
        parameters: &Parameters,
    ) -> Result<DefinitionId> {
        self.add(loading, textures, class, class, parameters)
    }

    /// `MakeNamedMaterial name`.
    pub(super) fn define_named(
        &mut self,
        loading: &mut Loading<'_>,
        textures: &Textures,
        name: &str,
        parameters: &Parameters,
    ) -> Result<()> {
        let class = match parameters.string("type") {
            Some(class) => class.to_owned(),
            None => {
                let message = "named materials without type: taken as diffuse";
                loading.note(NoteKind::Repaired, message, parameters.at());
                if loading.version == Version::V3 { "matte" } else { "diffuse" }.to_owned()
            }
        };
        let id = self.add(loading, textures, name, &class, parameters)?;
        self.named.insert(name.to_owned(), id);
        Ok(())
    }

    /// Returns the names of all materials.
    pub(super) fn names(&self) -> Vec<String> {
        self.named.keys().cloned().collect()
    }

    /// Returns the material of that name.
    pub(super) fn named(&self, name: &str) -> Option<DefinitionId> {
        self.named.get(name).copied()
    }

    /// Returns true if the material is an invisible interface.
    pub(super) fn is_interface(&self, id: DefinitionId) -> bool {
        self.definitions[id.0].surface.is_none()
    }

    /// Material of surfaces that are only an interface.
    pub(super) fn boundary(&mut self, loading: &mut Loading<'_>) -> Result<MaterialId> {
        if let Some(known) = self.boundary {
            return Ok(known);
        }
        let made = loading.builder.add_material(Material::new("interface", Surface::Boundary))?;
        self.boundary = Some(made);
        Ok(made)
    }

    /// Returns true if the material depends on texture coordinates.
    pub(super) fn is_textured(&self, id: DefinitionId) -> bool {
        self.definitions[id.0].textured
    }

    fn add(
        &mut self,
        loading: &mut Loading<'_>,
        textures: &Textures,
        name: &str,
        class: &str,
        parameters: &Parameters,
    ) -> Result<DefinitionId> {
        loading.met("material", class, "grey", &parameters.at())?;
        let mut definition = if class == "mix" {
            self.mix(loading, textures, parameters)?
        } else {
            let mut maker = Maker { loading: &mut *loading, textures, parameters };
            let (surface, opacity) = match maker.loading.version {
                Version::V3 => v3::surface(&mut maker, class)?,
                Version::V4 => (v4::surface(&mut maker, class)?, None),
            };
            let brushed = surface.as_ref().is_some_and(|s| maker.loading.builder.is_brushed(s));
            let textured = brushed || parameters.has_textures() || parameters.string("normalmap").is_some();
            Definition { name: String::new(), surface, normal: maker.normal()?, opacity, textured }
        };
        definition.name = excerpt(name, 80);
        if Loading::knows("material", class) {
            loading.note_unused("material", class, parameters)?;
        }
        self.definitions.push(definition);
        Ok(DefinitionId(self.definitions.len() - 1))
    }

    /// Material `mix`. The share of the second material is `amount` in pbrt-v4 and `1 − amount` in
    /// pbrt-v3.
    fn mix(&mut self, loading: &mut Loading<'_>, textures: &Textures, p: &Parameters) -> Result<Definition> {
        let names: Vec<String> = match loading.version {
            Version::V3 => ["namedmaterial1", "namedmaterial2"]
                .iter()
                .filter_map(|name| p.string(name).map(str::to_owned))
                .collect(),
            Version::V4 => {
                let names = p.find(&[super::parameters::Kind::String], "materials");
                names.map(|names| names.strings().to_vec()).unwrap_or_default()
            }
        };
        for name in names.iter().filter(|name| self.named(name).is_none()) {
            let at = p.place_of(if loading.version == Version::V3 { "namedmaterial1" } else { "materials" });
            loading.names.miss(Named::Material, name, &at);
        }
        let ids: Vec<DefinitionId> = names.iter().filter_map(|name| self.named(name)).collect();
        let [first, second] = ids[..] else {
            let message = "mixes of materials that are not two defined ones: the first that is, else grey";
            loading.note(NoteKind::Repaired, message, p.at());
            p.accept_known();
            return Ok(self.definitions[ids.first().map_or(0, |id| id.0)].clone());
        };
        let textured = p.has_textures() || ids.iter().any(|id| self.is_textured(*id));
        let amount = textures.color_or_float(loading, p, "amount")?.unwrap_or(0.5.into());
        let (first, second) = match loading.version {
            Version::V3 => (second, first),
            Version::V4 => (first, second),
        };
        let first = self.plain(loading, first)?;
        let second = self.plain(loading, second)?;
        let surface = Some(Surface::Mix { first, second, amount });
        Ok(Definition { name: String::new(), surface, normal: None, opacity: None, textured })
    }

    /// Material of the scene for a definition without light and alpha.
    fn plain(&mut self, loading: &mut Loading<'_>, id: DefinitionId) -> Result<MaterialId> {
        self.material(loading, id, None, None)
    }

    /// Material of the scene for a definition with the given light and alpha.
    pub(super) fn material(
        &mut self,
        loading: &mut Loading<'_>,
        id: DefinitionId,
        emission: Option<Emission>,
        shape_alpha: Option<FloatInput>,
    ) -> Result<MaterialId> {
        let key = (id, emission.map(|e| (color_key(e.radiance), e.two_sided)), shape_alpha.map(float_key));
        if let Some(&known) = self.made.get(&key) {
            return Ok(known);
        }
        let definition = &self.definitions[id.0];
        let black = Surface::Lambert { reflectance: Rgb::BLACK.into() };
        let mut material = Material::new(definition.name.clone(), definition.surface.unwrap_or(black));
        material.emission = emission;
        material.normal = definition.normal;
        material.alpha = match (shape_alpha, definition.opacity) {
            (Some(value), _) => {
                // pbrt-v3 cuts holes where alpha is 0; pbrt-v4 lets light through at random.
                // An emitter of alpha 0 is invisible, and emits in full.
                let is_unseen = emission.is_some() && value.texture.is_none() && value.factor <= 0.0;
                let mode = match loading.version {
                    _ if is_unseen => AlphaMode::Unseen,
                    Version::V3 => AlphaMode::Mask { cutoff: f32::MIN_POSITIVE },
                    Version::V4 => AlphaMode::Blend,
                };
                Some(Alpha { value, mode })
            }
            (None, Some(value)) => Some(Alpha { value, mode: AlphaMode::Blend }),
            (None, None) => None,
        };
        let made = loading.builder.add_material(material)?;
        self.made.insert(key, made);
        Ok(made)
    }
}

fn color_key(color: ColorInput) -> ColorKey {
    (color.factor.to_array().map(f32::to_bits), color.texture)
}

fn float_key(value: FloatInput) -> FloatKey {
    let channel = |channel| match channel {
        Channel::R => 0,
        Channel::G => 1,
        Channel::B => 2,
        Channel::A => 3,
        Channel::Luminance => 4,
    };
    (value.factor.to_bits(), value.texture.map(|(texture, c)| (texture, channel(c))))
}
