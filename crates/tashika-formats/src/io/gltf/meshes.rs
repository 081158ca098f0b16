//! Meshes: each primitive becomes one mesh of the scene.
//!
//! Input: a mesh of the document and its shape. Output: the ids of the meshes of its primitives.
//! They are read once for each shape, even if several nodes show them. Only the range of vertices
//! between the smallest and the largest index is read, so that primitives that share one large
//! vertex buffer do not each copy all of it.
//!
//! Triangle `i` of a strip is `(i, i + 1 + i mod 2, i + 2 − i mod 2)`, of a fan `(i + 1, i + 2, 0)`
//! (glTF 2.0 section 3.7.2.1). Triangles of a strip that use a vertex twice only connect other
//! triangles. They are omitted without a note.
//!
//! The scene does not have vertex colours. Their mean over the corners in use multiplies the base
//! colour.
//!
//! # Held to this by
//! The tests below; `gltf_materials::vertex_colours_*`,
//! `gltf::a_mesh_is_read_once_and_placed_twice`, `gltf::strips_fans_and_ranges_of_vertices`.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ops::Range;

use glam::{Vec2, Vec3};
use gltf::json;
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Semantic};
use gltf::json::validation::Checked;

use super::extensions::refuse_compressed;
use super::features::met;
use super::materials::{Materials, NO_TINT, Tint};
use super::shapes::{Shape, ShapeKey, Wanted};
use super::source::Source;
use crate::error::{Error, Location, Result};
use crate::io::notes::shown;
use crate::scene::{MeshData, MeshId, MeshShape, NoteKind, SceneBuilder};

/// Largest texture coordinate. `f32` resolves texels only at far smaller ones, and a texture
/// transform of this one is still finite.
const FARTHEST_UV: Vec2 = Vec2::splat(1e9);

/// Mesh that was made from a primitive.
#[derive(Clone, Copy)]
pub(super) struct Part {
    pub mesh: MeshId,
    /// True if the mesh is in world space, as its joints placed it.
    pub is_placed: bool,
}

/// The meshes read so far.
pub(super) struct Meshes {
    read: BTreeMap<(usize, ShapeKey), Vec<Part>>,
    materials: Materials,
    /// Times at which the shutter opens and closes (s), if there is an exposure.
    shutter: Option<[f64; 2]>,
}

impl Meshes {
    /// Creates the store without meshes.
    pub fn new(shutter: Option<[f64; 2]>) -> Self {
        Self { read: BTreeMap::new(), materials: Materials::default(), shutter }
    }

    /// Meshes of the primitives of mesh `index` in a shape.
    pub fn get(
        &mut self,
        source: &Source<'_>,
        builder: &mut SceneBuilder,
        index: usize,
        shape: &Shape,
    ) -> Result<&[Part]> {
        let vacant = match self.read.entry((index, shape.key())) {
            Entry::Occupied(read) => return Ok(read.into_mut()),
            Entry::Vacant(vacant) => vacant,
        };
        let mut read = Vec::new();
        for primitive in 0..source.root.meshes[index].primitives.len() {
            read.extend(read_primitive(
                &mut self.materials,
                source,
                builder,
                (index, primitive),
                (shape, self.shutter),
            )?);
        }
        Ok(vacant.insert(read))
    }
}

/// Reads a primitive. Returns none, with a note, if it forms no triangles.
fn read_primitive(
    materials: &mut Materials,
    source: &Source<'_>,
    builder: &mut SceneBuilder,
    (mesh, index): (usize, usize),
    (shape, shutter): (&Shape, Option<[f64; 2]>),
) -> Result<Option<Part>> {
    let document = &source.root.meshes[mesh];
    let primitive = &document.primitives[index];
    let item = format!("meshes[{mesh}].primitives[{index}]");
    let at = |field: &str| source.at(format!("{item}{field}"));
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let Some(assembly) = Assembly::of(primitive.mode) else {
        met("primitive", mode_name(primitive.mode), at(".mode"), builder)?;
        return Ok(None);
    };
    let Some(positions) = attribute(Semantic::Positions) else {
        let message = "primitives without POSITION: left out";
        builder.note(NoteKind::Repaired, message, at(".attributes"));
        return Ok(None);
    };
    if let Some(extensions) = &primitive.extensions
        && source.root.accessors[positions.value()].buffer_view.is_none()
    {
        refuse_compressed(&extensions.others, &at(".extensions"))?;
    }
    let positions = source.accessor(positions, Type::Vec3, at(".attributes.POSITION"))?;
    let indices = match primitive.indices {
        Some(i) => Some(source.accessor(i, Type::Scalar, at(".indices"))?.indices()?),
        None => None,
    };
    let corners = indices.as_ref().map_or(positions.count(), Vec::len);
    if u32::try_from(corners).is_err() {
        return Err(Error::invalid(at(""), format!("{corners} corners"), "less than 2³²"));
    }
    if assembly.triangles(corners) == 0 {
        builder.note(NoteKind::Repaired, "primitives without a triangle: left out", at(""));
        return Ok(None);
    }
    if assembly == Assembly::Separate && !corners.is_multiple_of(3) {
        builder.note(NoteKind::Repaired, "corners after the last whole triangle: left out", at(""));
    }
    let range = vertex_range(indices.as_deref(), corners);
    if range.end > positions.count() {
        let found = format!("vertex index {}", range.end - 1);
        return Err(Error::invalid(at(".indices"), found, format!("an index below {}", positions.count())));
    }

    let tint = match attribute(Semantic::Colors(0)) {
        Some(colors) => {
            let at = at(".attributes.COLOR_0");
            let colors = read_colors(source, colors, positions.count(), range.clone(), &at)?;
            let used: Box<dyn Iterator<Item = usize>> = match &indices {
                Some(indices) => Box::new(indices.iter().map(|&i| i as usize - range.start)),
                None => Box::new(0..corners),
            };
            tint(&colors, used, &at, builder)?
        }
        None => NO_TINT,
    };
    let wanted = primitive.material.map(|m| m.value());
    let material = materials.get(source, builder, wanted, tint)?;
    let has_map = wanted.is_some_and(|i| source.root.materials[i].normal_texture.is_some());
    if (has_map || material.is_brushed) && attribute(Semantic::Tangents).is_some() {
        met("attribute", "TANGENT", at(".attributes.TANGENT"), builder)?;
    }
    let moves_tangents = primitive.targets.iter().flatten().any(|target| target.tangents.is_some());
    if (has_map || material.is_brushed) && moves_tangents {
        met("target", "TANGENT", at(".targets"), builder)?;
    }
    let uvs = material.uv_set.and_then(|set| attribute(Semantic::TexCoords(set)).map(|uvs| (set, uvs)));
    if material.uv_set.is_some() && uvs.is_none() {
        let message = "textured or brushed primitives without the texture coordinates that their material wants: one texel, or any direction, is used";
        builder.note(NoteKind::Approximated, message, at(".attributes"));
    }
    let normals = attribute(Semantic::Normals);
    let floats = 3 + if normals.is_some() { 3 } else { 0 } + if uvs.is_some() { 2 } else { 0 };
    let numbers = range.len() as u64 * floats + assembly.triangles(corners) as u64 * 3;
    source.geometry_budget.take(numbers * 4, &at(""))?;

    let count = positions.count();
    let normals = match normals {
        Some(normals) => {
            let normals = source.accessor(normals, Type::Vec3, at(".attributes.NORMAL"))?;
            normals.expect_count(count)?.vectors(range.clone())?
        }
        None => Vec::new(),
    };
    let uvs = match uvs {
        Some((set, uvs)) => {
            let uvs = source.accessor(uvs, Type::Vec2, at(&format!(".attributes.TEXCOORD_{set}")))?;
            uvs.expect_count(count)?.vectors(range.clone())?
        }
        None => Vec::new(),
    };
    let first = range.start as u32;
    let triangles = match &indices {
        Some(indices) => assembly.assemble(corners, |i| indices[i] - first),
        None => assembly.assemble(corners, |i| i as u32),
    };
    let vectors = |of: Vec<[f32; 3]>| of.into_iter().map(Vec3::from_array).collect();
    let vertices =
        MeshShape { positions: vectors(positions.vectors(range.clone())?), normals: vectors(normals) };
    let wanted = Wanted { primitive, item: &item, count, range };
    let (shapes, origin, is_placed) = shape.applied(source, &wanted, vertices, builder)?;
    let mut shapes = shapes.into_iter();
    let MeshShape { positions, normals } = shapes.next().unwrap_or_default();
    let data = MeshData {
        name: name_of_part(document, mesh, index),
        positions,
        origin,
        normals,
        uvs: uvs
            .into_iter()
            .map(|uv: [f32; 2]| Vec2::from_array(uv).clamp(-FARTHEST_UV, FARTHEST_UV))
            .collect(),
        triangles,
    };
    let mesh = match (shapes.next(), shutter) {
        (Some(closing), Some(shutter)) => builder.add_deforming_mesh(data, closing, shutter, material.id)?,
        _ => builder.add_mesh(data, material.id)?,
    };
    Ok(Some(Part { mesh, is_placed }))
}

/// Name of a mesh, or its place in the file if it has none.
pub(super) fn name(mesh: &json::Mesh, index: usize) -> String {
    let name = mesh.name.as_deref().filter(|n| !n.is_empty());
    name.map_or_else(|| format!("meshes[{index}]"), shown)
}

fn name_of_part(mesh: &json::Mesh, index: usize, primitive: usize) -> String {
    let name = name(mesh, index);
    if mesh.primitives.len() == 1 { name } else { format!("{name}.primitives[{primitive}]") }
}

/// Largest difference between a vertex colour and the mean that is not noted: one step of an 8-bit
/// colour.
const COLOR_STEP: f32 = 1.0 / 255.0;

/// The vertex colours of `range`, with opacity.
fn read_colors(
    source: &Source<'_>,
    colors: json::Index<json::Accessor>,
    count: usize,
    range: Range<usize>,
    at: &Location,
) -> Result<Vec<Tint>> {
    if source.root.accessors[colors.value()].type_ == Checked::Valid(Type::Vec4) {
        return source.accessor(colors, Type::Vec4, at.clone())?.expect_count(count)?.vectors(range);
    }
    let colors = source.accessor(colors, Type::Vec3, at.clone())?.expect_count(count)?;
    Ok(colors.vectors(range)?.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())
}

/// Mean of the colours at the corners in use; noted if any differs by more than `COLOR_STEP`.
fn tint(
    colors: &[Tint],
    used: impl Iterator<Item = usize>,
    at: &Location,
    builder: &mut SceneBuilder,
) -> Result<Tint> {
    let (mut sum, mut corners) = ([0.0_f64; 4], 0_u64);
    let (mut least, mut most) = ([f32::INFINITY; 4], [f32::NEG_INFINITY; 4]);
    for color in used.map(|i| colors[i]) {
        corners += 1;
        for c in 0..4 {
            sum[c] += f64::from(color[c]);
            least[c] = least[c].min(color[c]);
            most[c] = most[c].max(color[c]);
        }
    }
    let mean = sum.map(|s| (s / corners as f64) as f32);
    if !mean.iter().all(|m| (0.0..=MAX_TINT).contains(m)) {
        let message = "vertex colours that are negative, huge or not finite: left out";
        builder.note(NoteKind::Repaired, message, at.clone());
        return Ok(NO_TINT);
    }
    if (0..4).any(|c| most[c] - mean[c] > COLOR_STEP || mean[c] - least[c] > COLOR_STEP) {
        met("attribute", "COLOR_0", at.clone(), builder)?;
    }
    Ok(mean)
}

/// Largest factor on a base colour, so that products stay finite.
const MAX_TINT: f32 = 1e6;

/// The name of a mode in the specification.
fn mode_name(mode: Checked<Mode>) -> &'static str {
    match mode {
        Checked::Valid(Mode::Points) => "POINTS",
        Checked::Valid(Mode::Lines) => "LINES",
        Checked::Valid(Mode::LineLoop) => "LINE_LOOP",
        Checked::Valid(Mode::LineStrip) => "LINE_STRIP",
        Checked::Valid(Mode::Triangles) => "TRIANGLES",
        Checked::Valid(Mode::TriangleStrip) => "TRIANGLE_STRIP",
        Checked::Valid(Mode::TriangleFan) => "TRIANGLE_FAN",
        Checked::Invalid => "mode",
    }
}

/// Range from the smallest to the largest vertex in use.
fn vertex_range(indices: Option<&[u32]>, corners: usize) -> Range<usize> {
    let Some(indices) = indices else { return 0..corners };
    let (first, last) = indices.iter().fold((u32::MAX, 0), |(lo, hi), &i| (lo.min(i), hi.max(i)));
    first as usize..last as usize + 1
}

/// Rule by which corners form triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Assembly {
    Separate,
    Strip,
    Fan,
}

impl Assembly {
    fn of(mode: Checked<Mode>) -> Option<Self> {
        match mode {
            Checked::Valid(Mode::Triangles) => Some(Self::Separate),
            Checked::Valid(Mode::TriangleStrip) => Some(Self::Strip),
            Checked::Valid(Mode::TriangleFan) => Some(Self::Fan),
            Checked::Valid(Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip)
            | Checked::Invalid => None,
        }
    }

    /// Number of triangles of `corners` corners.
    fn triangles(self, corners: usize) -> usize {
        match self {
            Self::Separate => corners / 3,
            Self::Strip | Self::Fan => corners.saturating_sub(2),
        }
    }

    /// Triangles of `corners` corners; `vertex(i)` is the vertex of corner `i`.
    fn assemble(self, corners: usize, vertex: impl Fn(usize) -> u32) -> Vec<[u32; 3]> {
        let triangles = (0..self.triangles(corners)).map(|i| match self {
            Self::Separate => [3 * i, 3 * i + 1, 3 * i + 2],
            Self::Strip => [i, i + 1 + i % 2, i + 2 - i % 2],
            Self::Fan => [i + 1, i + 2, 0],
        });
        let triangles = triangles.map(|corners| corners.map(&vertex));
        let steers = |[a, b, c]: &[u32; 3]| a == b || b == c || c == a;
        triangles.filter(|t| self != Self::Strip || !steers(t)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_of_a_strip_face_the_same_way() {
        assert_eq!(Assembly::Strip.assemble(5, |i| i as u32), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        let steering = [0, 1, 2, 2, 3, 3, 3, 4, 5];
        assert_eq!(Assembly::Strip.assemble(9, |i| steering[i]), [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(Assembly::Fan.assemble(5, |i| i as u32), [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
        assert_eq!(Assembly::Separate.assemble(7, |i| i as u32), [[0, 1, 2], [3, 4, 5]]);
        for assembly in [Assembly::Separate, Assembly::Strip, Assembly::Fan] {
            assert_eq!([0, 1, 2].map(|corners| assembly.assemble(corners, |i| i as u32).len()), [0; 3]);
        }
    }

    #[test]
    fn the_range_holds_the_vertices_in_use() {
        assert_eq!(vertex_range(Some(&[7, 5, 9]), 3), 5..10);
        assert_eq!(vertex_range(None, 3), 0..3);
    }
}
