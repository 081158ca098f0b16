//! Properties of the objects of glTF 2.0 and of its extensions, and properties of a file that are
//! not among them.
//!
//! The schema permits properties that it does not define, so a file with a misspelt property is
//! valid. A property that is in no table is noted with its path, or refused if it looks like a
//! misspelt property of that object. The contents of `extras`, and of extensions without a table,
//! are not checked.
//!
//! Sources: the JSON schemas of glTF 2.0 and of the extensions.[^gltf] Held to this by
//! `suite::gltf_schema`.
//!
//! [^gltf]: Khronos Group. "glTF 2.0 Specification." ISO/IEC 12113:2022.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::{self, Write as _};

use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::features::{FEATURES, extension};
use crate::error::{Error, Location, Result, nearest_name};
use crate::io::features::Feature;
use crate::io::notes::{quoted, shown};
use crate::scene::{NoteKind, SceneBuilder};

/// Largest number of different names that are recorded; chosen.
const MAX_NAMES: usize = 100;

/// Properties of each type of object, without `extensions` and `extras`: `name`, `name=type` for an
/// object, `name*type` for a list of objects. The type of an extension is its name, or `name@host`
/// if its properties depend on the enclosing type.
const TYPES: &[(&str, &[&str])] = &[
    ("glTF", &["extensionsUsed", "extensionsRequired", "accessors*accessor", "animations*animation"]),
    ("glTF", &["asset=asset", "buffers*buffer", "bufferViews*bufferView", "cameras*camera", "images*image"]),
    ("glTF", &["materials*material", "meshes*mesh", "nodes*node", "samplers*sampler", "scene"]),
    ("glTF", &["scenes*scene", "skins*skin", "textures*texture"]),
    ("accessor", &["bufferView", "byteOffset", "componentType", "normalized", "count", "type", "max", "min"]),
    ("accessor", &["sparse=sparse accessor", "name"]),
    ("sparse accessor", &["count", "indices=sparse indices", "values=sparse values"]),
    ("sparse indices", &["bufferView", "byteOffset", "componentType"]),
    ("sparse values", &["bufferView", "byteOffset"]),
    ("animation", &["channels*channel", "samplers*animation sampler", "name"]),
    ("channel", &["sampler", "target=target"]),
    ("target", &["node", "path"]),
    ("animation sampler", &["input", "interpolation", "output"]),
    ("asset", &["copyright", "generator", "version", "minVersion"]),
    ("buffer", &["uri", "byteLength", "name"]),
    ("bufferView", &["buffer", "byteOffset", "byteLength", "byteStride", "target", "name"]),
    ("camera", &["orthographic=orthographic", "perspective=perspective", "type", "name"]),
    ("orthographic", &["xmag", "ymag", "zfar", "znear"]),
    ("perspective", &["aspectRatio", "yfov", "zfar", "znear"]),
    ("image", &["uri", "mimeType", "bufferView", "name"]),
    ("material", &["name", "pbrMetallicRoughness=pbrMetallicRoughness", "normalTexture=normalTexture"]),
    ("material", &["occlusionTexture=occlusionTexture", "emissiveTexture=texture info", "emissiveFactor"]),
    ("material", &["alphaMode", "alphaCutoff", "doubleSided"]),
    ("pbrMetallicRoughness", &["baseColorFactor", "baseColorTexture=texture info", "metallicFactor"]),
    ("pbrMetallicRoughness", &["roughnessFactor", "metallicRoughnessTexture=texture info"]),
    ("texture info", &["index", "texCoord"]),
    ("normalTexture", &["index", "texCoord", "scale"]),
    ("occlusionTexture", &["index", "texCoord", "strength"]),
    ("mesh", &["primitives*primitive", "weights", "name"]),
    ("primitive", &["attributes", "indices", "material", "mode", "targets"]),
    ("node", &["camera", "children", "skin", "matrix", "mesh", "rotation", "scale", "translation"]),
    ("node", &["weights", "name"]),
    ("sampler", &["magFilter", "minFilter", "wrapS", "wrapT", "name"]),
    ("scene", &["nodes", "name"]),
    ("skin", &["inverseBindMatrices", "skeleton", "joints", "name"]),
    ("texture", &["sampler", "source", "name"]),
    ("KHR_lights_punctual@glTF", &["lights*light"]),
    ("KHR_lights_punctual@node", &["light"]),
    ("light", &["color", "intensity", "type", "range", "spot=spot", "name"]),
    ("spot", &["innerConeAngle", "outerConeAngle"]),
    ("EXT_mesh_gpu_instancing", &["attributes"]),
    ("KHR_node_visibility", &["visible"]),
    ("KHR_texture_transform", &["offset", "rotation", "scale", "texCoord"]),
    ("KHR_materials_emissive_strength", &["emissiveStrength"]),
    ("KHR_materials_ior", &["ior"]),
    ("KHR_materials_specular", &["specularFactor", "specularTexture=texture info", "specularColorFactor"]),
    ("KHR_materials_specular", &["specularColorTexture=texture info"]),
    ("KHR_materials_transmission", &["transmissionFactor", "transmissionTexture=texture info"]),
    ("KHR_materials_volume", &["thicknessFactor", "thicknessTexture=texture info", "attenuationDistance"]),
    ("KHR_materials_volume", &["attenuationColor"]),
    ("KHR_materials_diffuse_transmission", &["diffuseTransmissionFactor", "diffuseTransmissionColorFactor"]),
    ("KHR_materials_diffuse_transmission", &["diffuseTransmissionTexture=texture info"]),
    ("KHR_materials_diffuse_transmission", &["diffuseTransmissionColorTexture=texture info"]),
    ("KHR_materials_clearcoat", &["clearcoatFactor", "clearcoatTexture=texture info"]),
    ("KHR_materials_clearcoat", &["clearcoatRoughnessFactor", "clearcoatRoughnessTexture=texture info"]),
    ("KHR_materials_clearcoat", &["clearcoatNormalTexture=normalTexture"]),
    ("KHR_materials_sheen", &["sheenColorFactor", "sheenColorTexture=texture info", "sheenRoughnessFactor"]),
    ("KHR_materials_sheen", &["sheenRoughnessTexture=texture info"]),
    ("KHR_materials_anisotropy", &["anisotropyStrength", "anisotropyRotation"]),
    ("KHR_materials_anisotropy", &["anisotropyTexture=texture info"]),
    ("KHR_materials_pbrSpecularGlossiness", &["diffuseFactor", "diffuseTexture=texture info"]),
    ("KHR_materials_pbrSpecularGlossiness", &["specularFactor", "glossinessFactor"]),
    ("KHR_materials_pbrSpecularGlossiness", &["specularGlossinessTexture=texture info"]),
    ("KHR_materials_unlit", &[]),
    ("KHR_materials_iridescence", &["iridescenceFactor", "iridescenceTexture=texture info"]),
    ("KHR_materials_iridescence", &["iridescenceIor", "iridescenceThicknessMinimum"]),
    ("KHR_materials_iridescence", &["iridescenceThicknessMaximum"]),
    ("KHR_materials_iridescence", &["iridescenceThicknessTexture=texture info"]),
    ("KHR_materials_dispersion", &["dispersion"]),
    ("EXT_lights_ies@glTF", &["lights*light profile"]),
    ("EXT_lights_ies@node", &["light", "multiplier", "color"]),
    ("light profile", &["uri", "mimeType", "bufferView", "name"]),
    ("EXT_lights_image_based@glTF", &["lights*image light"]),
    ("EXT_lights_image_based@scene", &["light"]),
    ("image light", &["rotation", "intensity", "irradianceCoefficients", "specularImages", "name"]),
    ("image light", &["specularImageSize"]),
];

/// Contents of a property.
#[derive(Clone, Copy)]
enum Holds {
    /// A value that is not searched.
    Value,
    /// An object of a type.
    Object(&'static str),
    /// A list of objects of a type.
    List(&'static str),
}

/// Returns the properties of a type, each with its contents.
fn properties(of: &str) -> impl Iterator<Item = (&'static str, Holds)> {
    TYPES.iter().filter(move |(name, _)| *name == of).flat_map(|(_, all)| all.iter()).map(|&property| {
        if let Some((name, of)) = property.split_once('=') {
            (name, Holds::Object(of))
        } else if let Some((name, of)) = property.split_once('*') {
            (name, Holds::List(of))
        } else {
            (property, Holds::Value)
        }
    })
}

/// Returns the type of an extension of an object of type `host`, if the table has that extension.
fn extension_type(name: &str, host: &str) -> Option<&'static str> {
    let matches = |key: &str| match key.split_once('@') {
        Some((of, place)) => of == name && place == host,
        None => key == name,
    };
    TYPES.iter().map(|(key, _)| *key).find(|key| matches(key))
}

/// Names in a file that are in no table.
#[derive(Debug, Default)]
pub(super) struct Unknown {
    /// Path of the first occurrence and number of occurrences, by type and name. The type of an
    /// extension is empty.
    names: BTreeMap<(&'static str, String), (String, u64)>,
    path: Vec<Step>,
}

#[derive(Debug)]
enum Step {
    Name(String),
    Index(usize),
}

impl Unknown {
    /// Searches the JSON of a file.
    pub(super) fn of(text: &[u8]) -> Self {
        let mut unknown = Self::default();
        let mut json = serde_json::Deserializer::from_slice(text);
        // Errors of syntax were reported by the reader of the scene.
        let _ = Object { of: "glTF", unknown: &mut unknown }.deserialize(&mut json);
        unknown
    }

    /// Notes the unknown names.
    ///
    /// # Errors
    /// If a name is probably a misspelling of a known name of the same type of object.
    pub(super) fn tell(&self, listed: &[String], file: &Location, builder: &mut SceneBuilder) -> Result<()> {
        for ((of, name), (path, count)) in &self.names {
            let at = file.clone().item(path);
            if of.is_empty() {
                Feature::refuse_slip(FEATURES, ["extension", name], &at)?;
                // Extensions in `extensionsUsed` have their own notes.
                if !listed.contains(name) {
                    let message = Feature::unknown(["extension", name], "left out");
                    builder.notes_mut().push_many(NoteKind::Ignored, message, at, *count);
                }
                continue;
            }
            let is_name = TYPES.iter().any(|(of, _)| properties(of).any(|(known, _)| known == name));
            let near =
                if is_name { None } else { nearest_name(name, properties(of).map(|(known, _)| known)) };
            if let Some(near) = near {
                return Err(Error::misspelt(at, &format!("property of {of}"), &shown(name), near));
            }
            let message = format!("property {} of {of} is unknown: left out", quoted(name));
            builder.notes_mut().push_many(NoteKind::Ignored, message, at, *count);
        }
        Ok(())
    }

    fn add(&mut self, of: &'static str, name: &str) {
        let key = (of, name.to_owned());
        if let Some((_, count)) = self.names.get_mut(&key) {
            *count += 1;
        } else if self.names.len() < MAX_NAMES {
            let mut path = String::new();
            for step in &self.path {
                match step {
                    Step::Name(name) if path.is_empty() => path.push_str(name),
                    Step::Name(name) => path.extend([".", name]),
                    // Writing to a string cannot fail.
                    Step::Index(index) => write!(path, "[{index}]").unwrap_or_default(),
                }
            }
            let dot = if path.is_empty() { "" } else { "." };
            self.names.insert(key, (format!("{path}{dot}{}", shown(name)), 1));
        }
    }
}

/// Visitor of an object of the type `of`.
struct Object<'a> {
    of: &'static str,
    unknown: &'a mut Unknown,
}

/// Visitor of the extensions of an object of the type `host`.
struct Extensions<'a> {
    host: &'static str,
    unknown: &'a mut Unknown,
}

/// Visitor of a list of objects of the type `of`.
struct List<'a> {
    of: &'static str,
    unknown: &'a mut Unknown,
}

/// Methods of a visitor that ignore all other kinds of values.
macro_rules! lenient {
    ($($visit:ident: $value:ty;)+) => {
        $(fn $visit<E>(self, _: $value) -> std::result::Result<(), E> {
            Ok(())
        })+

        fn visit_unit<E>(self) -> std::result::Result<(), E> {
            Ok(())
        }

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("anything")
        }
    };
    () => {
        lenient! { visit_bool: bool; visit_i64: i64; visit_u64: u64; visit_f64: f64; visit_str: &str; }
    };
}

impl<'de> DeserializeSeed<'de> for Object<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, json: D) -> std::result::Result<(), D::Error> {
        json.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Object<'_> {
    type Value = ();

    lenient! {}

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> std::result::Result<(), A::Error> {
        while list.next_element::<IgnoredAny>()?.is_some() {}
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<(), A::Error> {
        let Self { of, unknown } = self;
        while let Some(name) = map.next_key::<Cow<'de, str>>()? {
            if name == "extras" {
                map.next_value::<IgnoredAny>()?;
                continue;
            }
            let holds = properties(of).find(|(known, _)| *known == name).map(|(_, holds)| holds);
            if holds.is_none() && name != "extensions" {
                unknown.add(of, &name);
            }
            match holds {
                _ if name == "extensions" => {
                    unknown.path.push(Step::Name(name.into_owned()));
                    map.next_value_seed(Extensions { host: of, unknown: &mut *unknown })?;
                    unknown.path.pop();
                }
                Some(Holds::Object(of)) => {
                    unknown.path.push(Step::Name(name.into_owned()));
                    map.next_value_seed(Object { of, unknown: &mut *unknown })?;
                    unknown.path.pop();
                }
                Some(Holds::List(of)) => {
                    unknown.path.push(Step::Name(name.into_owned()));
                    map.next_value_seed(List { of, unknown: &mut *unknown })?;
                    unknown.path.pop();
                }
                Some(Holds::Value) | None => {
                    map.next_value::<IgnoredAny>()?;
                }
            }
        }
        Ok(())
    }
}

impl<'de> DeserializeSeed<'de> for Extensions<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, json: D) -> std::result::Result<(), D::Error> {
        json.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Extensions<'_> {
    type Value = ();

    lenient! {}

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> std::result::Result<(), A::Error> {
        while list.next_element::<IgnoredAny>()?.is_some() {}
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<(), A::Error> {
        let Self { host, unknown } = self;
        while let Some(name) = map.next_key::<Cow<'de, str>>()? {
            if extension(&name).is_none() {
                unknown.add("", &name);
            }
            match extension_type(&name, host) {
                Some(of) => {
                    unknown.path.push(Step::Name(name.into_owned()));
                    map.next_value_seed(Object { of, unknown: &mut *unknown })?;
                    unknown.path.pop();
                }
                None => {
                    map.next_value::<IgnoredAny>()?;
                }
            }
        }
        Ok(())
    }
}

impl<'de> DeserializeSeed<'de> for List<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, json: D) -> std::result::Result<(), D::Error> {
        json.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for List<'_> {
    type Value = ();

    lenient! {}

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> std::result::Result<(), A::Error> {
        let Self { of, unknown } = self;
        for index in 0.. {
            unknown.path.push(Step::Index(index));
            let element = list.next_element_seed(Object { of, unknown: &mut *unknown })?;
            unknown.path.pop();
            if element.is_none() {
                break;
            }
        }
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<(), A::Error> {
        while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(())
    }
}
