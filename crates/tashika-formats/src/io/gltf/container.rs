//! From the bytes of a file to a checked glTF document.
//!
//! Input: the bytes of a `.gltf` (JSON) or `.glb` (binary container, glTF 2.0 section 4) file.
//! Output: the document as the `gltf` crate's plain data types, and the container's binary chunk.
//!
//! # Guarantee
//! No byte string makes this panic. In the returned document, all indices into other lists are in
//! range, except the sources of textures. All enumerated values are values of glTF 2.0, except
//! attribute names.
//!
//! # Differences from the `gltf` crate's own loader
//! * The container is split here: the crate's reader subtracts the header's size from a length that
//!   may be smaller.
//! * Version and required extensions are read first, so that an unsupported file is refused for
//!   that reason before any other fault is found.
//! * Animations are stored unparsed: they need to be valid only if a time is given.
//! * `POSITION` accessors are checked before the crate's validator, which indexes with them
//!   unchecked.
//! * Faults that do not affect this loader are accepted: missing or wrong `min` and `max`, missing
//!   `POSITION`, accessors without a buffer view, textures whose source is missing or out of range,
//!   unknown attribute names, scenes without nodes.
//!
//! # Held to this by
//! `damaged_gltf`: truncation at each length, mutations, deep nesting, indices out of range.

use std::collections::BTreeMap;

use gltf::json::mesh::Semantic;
use gltf::json::validation::{Checked, Error as Fault, Validate};
use gltf::json::{self, Index, Path, Root};
use serde::Deserialize;
use serde::de::{DeserializeOwned, IgnoredAny};

use super::extensions;
use super::schema::Unknown;
use crate::error::{Error, Location, Result};
use crate::io::notes::shown;

/// Contents of a file after parsing.
pub(super) struct Parsed<'a> {
    /// The document without its animations.
    pub root: Root,
    /// Positions of nodes in double precision, by node; empty if no node is far from its parent.
    pub places: Vec<WidePlace>,
    /// The animations, as JSON that is not parsed further.
    pub animations: Vec<serde_json::Value>,
    /// Attributes of morph targets other than positions, normals and tangents, each with the place
    /// where it occurs first.
    pub other_targets: BTreeMap<String, String>,
    /// Properties and extensions that are in no table.
    pub unknown: Unknown,
    /// The binary chunk of a `.glb`.
    pub binary: Option<&'a [u8]>,
}

/// Fields that decide whether the file can be read.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Head {
    asset: Asset,
    #[serde(default)]
    extensions_used: Vec<String>,
    #[serde(default)]
    extensions_required: Vec<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Asset {
    version: String,
    min_version: Option<String>,
}

/// Fields of the document that are not in `Head`.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
#[derive(Default)]
struct Body {
    accessors: Vec<json::Accessor>,
    animations: Vec<serde_json::Value>,
    buffers: Vec<json::Buffer>,
    buffer_views: Vec<json::buffer::View>,
    cameras: Vec<json::Camera>,
    extensions: Option<json::extensions::Root>,
    images: Vec<json::Image>,
    materials: Vec<json::Material>,
    meshes: Vec<json::Mesh>,
    nodes: Vec<json::Node>,
    samplers: Vec<json::texture::Sampler>,
    scene: Option<Index<json::Scene>>,
    scenes: Vec<SceneNodes>,
    skins: Vec<json::Skin>,
    textures: Vec<json::Texture>,
}

#[derive(Deserialize)]
struct SceneNodes {
    extensions: Option<json::extensions::scene::Scene>,
    #[serde(default)]
    nodes: Vec<Index<json::Node>>,
}

/// Positions of nodes, which the crate's types round to single precision.
#[derive(Deserialize)]
struct WidePlaces {
    nodes: Vec<WidePlace>,
}

/// Position of a node in its parent (m), in double precision.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct WidePlace {
    #[serde(default)]
    pub translation: Option<[f64; 3]>,
    #[serde(default)]
    pub matrix: Option<[f64; 16]>,
}

/// Smallest coordinate (m) that is read in double precision: there, neighbouring numbers of single
/// precision are 8 mm apart.
const FAR: f32 = 65536.0;

/// Returns true if a node is far from its parent.
fn is_far(node: &json::Node) -> bool {
    let of_matrix = node.matrix.iter().flat_map(|matrix| &matrix[12..15]);
    node.translation.iter().flatten().chain(of_matrix).any(|x| x.abs() >= FAR)
}

/// Names of the attributes of morph targets, which the crate's types do not keep.
#[derive(Deserialize)]
struct Targets {
    meshes: Vec<TargetsOfMesh>,
}

#[derive(Deserialize)]
struct TargetsOfMesh {
    primitives: Vec<TargetsOfPrimitive>,
}

#[derive(Deserialize)]
struct TargetsOfPrimitive {
    #[serde(default)]
    targets: Option<Vec<BTreeMap<String, IgnoredAny>>>,
}

impl Targets {
    fn others(self) -> BTreeMap<String, String> {
        let mut others = BTreeMap::new();
        for (m, mesh) in self.meshes.into_iter().enumerate() {
            for (p, primitive) in mesh.primitives.into_iter().enumerate() {
                for (t, target) in primitive.targets.into_iter().flatten().enumerate() {
                    let known = ["POSITION", "NORMAL", "TANGENT"];
                    for name in target.into_keys().filter(|name| !known.contains(&name.as_str())) {
                        let place = || format!("meshes[{m}].primitives[{p}].targets[{t}]");
                        others.entry(name).or_insert_with(place);
                    }
                }
            }
        }
        others
    }
}

/// Parses and checks a file.
pub(super) fn parse<'a>(bytes: &'a [u8], file: &Location) -> Result<Parsed<'a>> {
    let (text, binary) = if bytes.starts_with(b"glTF") { split_binary(bytes, file)? } else { (bytes, None) };
    let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
    let head: Head = from_json(text, file)?;
    check_version(&head.asset, file)?;
    extensions::refuse_unhandled(&head.extensions_required, file)?;
    let body: Body = from_json(text, file)?;
    let scenes = body.scenes.into_iter().map(|s| json::Scene {
        extensions: s.extensions,
        extras: None,
        name: None,
        nodes: s.nodes,
    });
    let root = Root {
        accessors: body.accessors,
        buffers: body.buffers,
        buffer_views: body.buffer_views,
        cameras: body.cameras,
        extensions: body.extensions,
        extensions_used: head.extensions_used,
        images: body.images,
        materials: body.materials,
        meshes: body.meshes,
        nodes: body.nodes,
        samplers: body.samplers,
        scene: body.scene,
        scenes: scenes.collect(),
        skins: body.skins,
        textures: body.textures,
        ..Root::default()
    };
    validate(&root, text, file)?;
    let has_targets = root.meshes.iter().flat_map(|mesh| &mesh.primitives).any(|p| p.targets.is_some());
    let other_targets =
        if has_targets { from_json::<Targets>(text, file)?.others() } else { BTreeMap::new() };
    let is_any_far = root.nodes.iter().any(is_far);
    let places = if is_any_far { from_json::<WidePlaces>(text, file)?.nodes } else { Vec::new() };
    let unknown = Unknown::of(text);
    Ok(Parsed { root, places, animations: body.animations, other_targets, unknown, binary })
}

/// The JSON and the binary chunk of a `.glb`; both lie inside `bytes`.
fn split_binary<'a>(bytes: &'a [u8], file: &Location) -> Result<(&'a [u8], Option<&'a [u8]>)> {
    const HEADER: usize = 12;
    let at = |item: &str| file.clone().item(item);
    let word = |offset: usize| {
        let word = bytes.get(offset..)?.first_chunk::<4>()?;
        Some(u32::from_le_bytes(*word))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        let found = format!("a truncated file of {} bytes", bytes.len());
        return Err(Error::invalid(at("GLB header"), found, format!("a header of {HEADER} bytes")));
    };
    if version != 2 {
        return Err(Error::unsupported(
            at("GLB header"),
            format!("version {version}"),
            "convert the file to glTF 2.0",
        ));
    }
    let length = length as usize;
    if length > bytes.len() {
        let found = format!("a truncated file: length = {length}, {} bytes are there", bytes.len());
        return Err(Error::invalid(at("GLB header"), found, "all bytes of the file"));
    }
    if length < HEADER {
        let expected = format!("{HEADER} to {}, the bytes that are there", bytes.len());
        return Err(Error::invalid(at("GLB header"), format!("length = {length}"), expected));
    }
    let mut chunks: [Option<&[u8]>; 2] = [None, None];
    let mut offset = HEADER;
    // Chunks after the first two, and chunks of unknown kind, are ignored.
    for (chunk, (kind, name)) in
        chunks.iter_mut().zip([(*b"JSON", "GLB JSON chunk"), (*b"BIN\0", "GLB BIN chunk")])
    {
        if offset == length {
            break;
        }
        let (Some(size), Some(found_kind)) = (word(offset), word(offset + 4)) else {
            let found = format!("{} bytes", length - offset);
            return Err(Error::invalid(at(name), found, "a chunk header of 8 bytes"));
        };
        let start = offset + 8;
        let end = start.checked_add(size as usize).filter(|&end| end <= length);
        let Some(end) = end else {
            let expected = format!("at most {}, the bytes that are left", length.saturating_sub(start));
            return Err(Error::invalid(at(name), format!("length = {size}"), expected));
        };
        if found_kind == u32::from_le_bytes(kind) {
            *chunk = Some(&bytes[start..end]);
        }
        offset = end;
    }
    match chunks {
        [Some(text), binary] => Ok((text, binary)),
        [None, _] => Err(Error::invalid(at("GLB"), "no JSON chunk", "JSON as the first chunk")),
    }
}

fn from_json<T: DeserializeOwned>(text: &[u8], file: &Location) -> Result<T> {
    json::deserialize::from_slice(text).map_err(|e| {
        let mut at = file.clone();
        at.line = u32::try_from(e.line()).ok().filter(|&line| line > 0);
        Error::invalid(at, format!("JSON that is no glTF ({e})"), "a glTF 2.0 document")
    })
}

fn check_version(asset: &Asset, file: &Location) -> Result<()> {
    let needed = asset.min_version.as_deref().unwrap_or(&asset.version);
    let (major, minor) = needed.split_once('.').unwrap_or((needed, "0"));
    if major == "2" && (asset.min_version.is_none() || minor == "0") {
        return Ok(());
    }
    let what = format!("glTF {}", shown(needed));
    Err(Error::unsupported(file.clone().item("asset"), what, "convert the file to glTF 2.0"))
}

fn validate(root: &Root, text: &[u8], file: &Location) -> Result<()> {
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let index = primitive.attributes.get(&Checked::Valid(Semantic::Positions)).map(Index::value);
            if let Some(index) = index.filter(|&i| i >= root.accessors.len()) {
                let at = file.clone().item(format!("meshes[{m}].primitives[{p}].attributes.POSITION"));
                let expected = format!("an index below {}", root.accessors.len());
                return Err(Error::invalid(at, format!("accessor {index}"), expected));
            }
        }
    }
    let mut first: Option<(Path, Fault)> = None;
    root.validate(root, Path::new, &mut |path, fault| {
        if first.is_none() {
            let path = path();
            if !is_forgiven(path.as_str(), fault) {
                first = Some((path, fault));
            }
        }
    });
    let Some((path, fault)) = first else { return Ok(()) };
    let (found, expected) = match fault {
        Fault::IndexOutOfBounds => ("an index out of range", "the index of something in this file"),
        Fault::Invalid => ("a value that glTF 2.0 does not know", "one that it knows"),
        Fault::Missing => ("nothing", "a value: the field is required"),
        Fault::Oversize => ("a size beyond this machine's memory", "a smaller one"),
        Fault::Unsupported => ("an extension that is not supported", "another file"),
    };
    let found =
        value_at(text, path.as_str()).map_or_else(|| found.to_owned(), |value| format!("{value}, {found}"));
    Err(Error::invalid(file.clone().item(path.to_string()), found, expected))
}

/// Returns true for a fault that does not matter to this loader; see the module's list.
fn is_forgiven(path: &str, fault: Fault) -> bool {
    match fault {
        // Required extensions have been checked by name.
        Fault::Unsupported => true,
        Fault::Missing => {
            path.contains(".attributes[\"POSITION\"]")
                || path.starts_with("accessors[") && path.ends_with(".bufferView")
                || is_texture_source(path)
        }
        Fault::Invalid => {
            path.ends_with(".attributes[\"POSITION\"].min")
                || path.ends_with(".attributes[\"POSITION\"].max")
                || path.ends_with(".attributes[\"<invalid semantic name>\"]")
        }
        Fault::IndexOutOfBounds => is_texture_source(path),
        Fault::Oversize => false,
    }
}

/// Returns true for `textures[i].source`, which is checked where it is used: a texture without an
/// image is only noted.
fn is_texture_source(path: &str) -> bool {
    path.starts_with("textures[") && path.ends_with(".source")
}

/// Value at a path such as `nodes[0].mesh`, if it is a number, a string or a boolean.
fn value_at(text: &[u8], path: &str) -> Option<String> {
    let document: serde_json::Value = json::deserialize::from_slice(text).ok()?;
    let mut value = &document;
    for step in path.split(['.', '[', ']', '"']).filter(|s| !s.is_empty()) {
        value = match value {
            serde_json::Value::Array(items) => items.get(step.parse::<usize>().ok()?)?,
            other => other.get(step)?,
        };
    }
    (value.is_number() || value.is_string() || value.is_boolean()).then(|| shown(&value.to_string()))
}
