//! Meshes: faces of any number of corners become triangles, in one mesh for each material.
//!
//! Mesh prims with the same opinions are read once. In left-handed meshes, the order of the corners
//! of each face is reversed. A subdivision surface is replaced by its control mesh.
//!
//! Held to this by `usd_meshes` of the suite.

use std::collections::BTreeMap;

use glam::{DVec3, Vec2, Vec3};

use super::Stage;
use super::features::met;
use super::layers::LayerId;
use super::materials::{MeshAppearance, UsedMaterial};
use super::prim::Prim;
use super::primvars::{Corner, Counts, Primvar};
use super::sites::Node;
use super::walk::State;
use crate::error::{Error, Location, Result};
use crate::io::polygon::{Coverage, Triangulator};
use crate::math::LocalPlaces;
use crate::scene::{MaterialId, MeshData, MeshId, NoteKind};

/// Largest texture coordinate; `f32` resolves texels only at far smaller ones.
const FARTHEST_UV: Vec2 = Vec2::splat(1e9);

/// Key of a mesh: the specs that define it, and the materials of its parts.
pub(super) type MeshKey = (Vec<(LayerId, u32)>, Vec<MaterialId>);

/// The faces of a mesh.
struct Faces {
    points: LocalPlaces,
    /// Number of corners of each face.
    counts: Vec<usize>,
    /// Index of the point at each corner, face by face.
    corners: Vec<u32>,
}

/// Some faces of a mesh, and their material.
struct Part {
    subset: Option<Prim>,
    material: UsedMaterial,
}

impl Stage<'_> {
    /// Meshes of a mesh prim, one for each material.
    pub fn meshes_of(&mut self, node: &Node, prim: &Prim, state: &State) -> Result<Vec<MeshId>> {
        let look = MeshAppearance { is_double_sided: self.is_true(prim, "doubleSided")?, shown: state.shown };
        let mut identity = prim.identity();
        let mut parts = Vec::new();
        for name in self.composer.children(prim) {
            let Some(child) = self.composer.child(node, &name, &mut self.builder)? else { continue };
            let subset = self.composer.flat(&child);
            if &*self.type_name(&subset) != "GeomSubset" {
                continue;
            }
            self.note_unread(&subset, "GeomSubset")?;
            let Some(path) = self.own_material(&subset, &state.bindings)? else { continue };
            if !self.is_of_faces(&subset)? {
                continue;
            }
            identity.extend(subset.identity());
            let material = self.material(Some(&path), look)?;
            parts.push(Part { subset: Some(subset), material });
        }
        let material = self.material(state.bindings.material(), look)?;
        parts.push(Part { subset: None, material });
        let key = (identity, parts.iter().map(|part| part.material.id).collect());
        if let Some(known) = self.meshes.get(&key) {
            return Ok(known.clone());
        }
        let meshes = self.read_mesh(prim, parts)?;
        self.meshes.insert(key, meshes.clone());
        Ok(meshes)
    }

    /// Returns true if a subset is a set of faces with a material; otherwise adds a note.
    fn is_of_faces(&mut self, subset: &Prim) -> Result<bool> {
        let row = if self.word(subset, "elementType")?.is_some_and(|word| &*word != "face") {
            "GeomSubset of other elements"
        } else if self.word(subset, "familyName")?.is_some_and(|w| !matches!(&*w, "" | "materialBind")) {
            "GeomSubset of another family"
        } else {
            return Ok(true);
        };
        met("prim", row, self.at(subset), &mut self.builder)?;
        Ok(false)
    }

    /// Returns the existing faces among those that an attribute names; a note is added for missing
    /// ones.
    fn listed_faces(&mut self, prim: &Prim, name: &str, count: usize) -> Result<Vec<usize>> {
        let faces = self.value(prim, name)?;
        let faces = faces.as_ref().and_then(|faces| faces.numbers()).unwrap_or_default();
        let is_there = |face: &f64| (0.0..count as f64).contains(face);
        if !faces.iter().all(is_there) {
            let message = "faces of subsets or holes that their mesh does not have: left out";
            let at = self.at_property(prim, name);
            self.builder.note(NoteKind::Repaired, message, at);
        }
        Ok(faces.iter().filter(|face| is_there(face)).map(|&face| face as usize).collect())
    }

    fn read_mesh(&mut self, prim: &Prim, parts: Vec<Part>) -> Result<Vec<MeshId>> {
        let at = self.at(prim);
        let Some(faces) = self.faces(prim, &at)? else {
            self.builder.note(NoteKind::Repaired, "meshes without points or faces: left out", at);
            return Ok(Vec::new());
        };
        let scheme = self.word(prim, "subdivisionScheme")?;
        if scheme.is_none_or(|scheme| &*scheme != "none") {
            met("mesh", "subdivisionScheme", at.clone(), &mut self.builder)?;
        }
        let is_left = self.word(prim, "orientation")?.is_some_and(|word| &*word == "leftHanded");
        let counts = Counts {
            faces: faces.counts.len(),
            points: faces.points.places.len(),
            corners: faces.corners.len(),
        };
        let mut normals = self.primvar::<3>(prim, "primvars:normals", "constant", counts)?;
        if normals.is_none() {
            normals = self.primvar::<3>(prim, "normals", "vertex", counts)?;
        }
        // Each face belongs to the first part that lists it.
        let mut part_of: Vec<Option<usize>> = vec![None; faces.counts.len()];
        let last = parts.len() - 1;
        // A hole belongs to no part.
        for face in self.listed_faces(prim, "holeIndices", counts.faces)? {
            part_of[face] = Some(parts.len());
        }
        for (i, part) in parts.iter().enumerate() {
            let Some(subset) = &part.subset else { continue };
            for face in self.listed_faces(subset, "indices", counts.faces)? {
                part_of[face].get_or_insert(i);
            }
        }
        let mut meshes = Vec::new();
        for (i, part) in parts.iter().enumerate() {
            let is_of = |face: usize| part_of[face].unwrap_or(last) == i;
            if !(0..counts.faces).any(is_of) {
                continue;
            }
            let uvs = match &part.material.uv {
                Some(name) => {
                    let uvs = self.primvar::<2>(prim, &format!("primvars:{name}"), "constant", counts)?;
                    if uvs.is_none() {
                        let message = "textured meshes without the texture coordinates that their material wants: one texel is used";
                        self.builder.note(NoteKind::Approximated, message, at.clone());
                    }
                    uvs
                }
                None => None,
            };
            let name = if parts.len() == 1 { prim.path.to_string() } else { format!("{}[{i}]", prim.path) };
            self.geometry_budget.take(44 * counts.corners as u64, &self.composer.layers, &at)?;
            let (mut data, is_crossing) = built(&faces, is_of, normals.as_ref(), uvs.as_ref());
            if is_crossing {
                let message = "faces that cross themselves: parts may be missing";
                self.builder.note(NoteKind::Approximated, message, at.clone());
            }
            data.name = name;
            if is_left {
                data.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            }
            meshes.push(self.builder.add_mesh(data, part.material.id)?);
        }
        Ok(meshes)
    }

    /// Points and faces, if there are any.
    fn faces(&mut self, prim: &Prim, at: &Location) -> Result<Option<Faces>> {
        let points = self.value(prim, "points")?;
        let points = points.as_ref().and_then(|value| value.array::<3>()).unwrap_or_default();
        let counts = self.value(prim, "faceVertexCounts")?;
        let counts = counts.as_ref().and_then(|value| value.numbers()).unwrap_or_default();
        let corners = self.value(prim, "faceVertexIndices")?;
        let corners = corners.as_ref().and_then(|value| value.numbers()).unwrap_or_default();
        if points.is_empty() || counts.is_empty() || corners.is_empty() {
            return Ok(None);
        }
        let item = |name: &str| at.clone().item(format!("{}.{name}", prim.path));
        if let Some(wrong) = corners.iter().find(|&&i| !(0.0..points.len() as f64).contains(&i)) {
            let expected = format!("an index from 0 to {}", points.len() - 1);
            return Err(Error::invalid(item("faceVertexIndices"), format!("point {wrong}"), expected));
        }
        let sum: f64 = counts.iter().sum();
        if counts.iter().any(|&n| n < 0.0) || sum > corners.len() as f64 || sum > f64::from(u32::MAX) {
            let found = format!("{sum} corners of {} faces", counts.len());
            let expected = format!("at most {}, as there are indices", corners.len());
            return Err(Error::invalid(item("faceVertexCounts"), found, expected));
        }
        Ok(Some(Faces {
            points: LocalPlaces::of(&points.iter().map(|&p| DVec3::from_array(p)).collect::<Vec<_>>()),
            counts: counts.iter().map(|&n| n as usize).collect(),
            corners: corners.iter().map(|&i| i as u32).collect(),
        }))
    }
}

/// Triangles of the wanted faces. The second value is true if a face crosses itself.
fn built(
    faces: &Faces,
    is_wanted: impl Fn(usize) -> bool,
    normals: Option<&Primvar<3>>,
    uvs: Option<&Primvar<2>>,
) -> (MeshData, bool) {
    let mut data = MeshData {
        name: String::new(),
        positions: Vec::new(),
        origin: faces.points.origin,
        normals: Vec::new(),
        uvs: Vec::new(),
        triangles: Vec::new(),
    };
    let mut vertices: BTreeMap<[u32; 3], u32> = BTreeMap::new();
    let mut triangulator = Triangulator::new();
    let (mut local, mut positions, mut own) = (Vec::new(), Vec::new(), Vec::new());
    let (mut first, mut is_crossing) = (0, false);
    for (face, &count) in faces.counts.iter().enumerate() {
        let corners = first..first + count;
        first += count;
        if count < 3 || !is_wanted(face) {
            continue;
        }
        own.clear();
        for corner in corners {
            let point = faces.corners[corner];
            let at = Corner { face, point: point as usize, corner };
            let normal = normals.map_or(0, |normals| normals.index(at));
            let uv = uvs.map_or(0, |uvs| uvs.index(at));
            let next = data.positions.len() as u32;
            own.push(*vertices.entry([point, normal, uv]).or_insert_with(|| {
                data.positions.push(faces.points.places[point as usize]);
                data.normals.extend(normals.map(|normals| Vec3::from_array(normals.value(normal))));
                let place = |uvs: &Primvar<2>| {
                    let [u, v] = uvs.value(uv);
                    Vec2::new(u, 1.0 - v).clamp(-FARTHEST_UV, FARTHEST_UV)
                };
                data.uvs.extend(uvs.map(place));
                next
            }));
        }
        positions.clear();
        positions.extend(own.iter().map(|&vertex| data.positions[vertex as usize]));
        local.clear();
        is_crossing |= triangulator.triangulate(&positions, &mut local) != Coverage::Whole;
        data.triangles.extend(local.iter().map(|t| t.map(|i| own[i as usize])));
    }
    (data, is_crossing)
}
