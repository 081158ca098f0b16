//! Conversion of faces to meshes: one mesh per material, in the order in which faces first use it.
//!
//! Corners with the same position, texture coordinate and normal become one vertex; vertices are
//! numbered in the order of the file, so that equal files give equal meshes. Texture coordinates
//! are flipped to run down: `v ↦ 1 − v`.
//!
//! Tested by `suite::obj`.

use std::collections::HashMap;
use std::path::Path;

use glam::{DVec3, Vec2, Vec3};

use super::parse::{Corner, Geometry, NONE};
use super::tally::Tally;
use crate::io::polygon::{Coverage, Triangulator};
use crate::scene::{MeshData, NoteKind, Notes};

/// The mesh of one material.
pub(super) struct MaterialMesh {
    /// Position in [`Geometry::materials`].
    pub(super) material: u32,
    pub(super) data: MeshData,
}

/// Builds the meshes of all faces. If some corners of a material have normals, the others get the
/// zero vector.
pub(super) fn build(geometry: &Geometry, file: &Path, notes: &mut Notes) -> Vec<MaterialMesh> {
    let mut tally = Tally::default();
    let mut triangulator = Triangulator::new();
    let mut builder = MeshBuilder::default();
    let meshes = faces_by_material(geometry)
        .into_iter()
        .map(|(material, faces)| {
            for face in faces {
                match builder.add(geometry, face, &mut triangulator) {
                    Coverage::Whole => {}
                    Coverage::Crossing => {
                        let message = "polygons that cross themselves: parts may be missing";
                        tally.add(NoteKind::Repaired, message, geometry.faces[face].line);
                    }
                    Coverage::Fan => {
                        let message = "polygons too large to triangulate exactly: cut into a fan";
                        tally.add(NoteKind::Approximated, message, geometry.faces[face].line);
                    }
                }
            }
            let name = match geometry.materials[material as usize].name.as_str() {
                "" => "without material",
                name => name,
            };
            MaterialMesh { material, data: builder.finish(name, geometry.origin) }
        })
        .collect();
    tally.report(file, notes);
    meshes
}

/// Materials in the order of their first face, each with its faces in the order of the file.
fn faces_by_material(geometry: &Geometry) -> Vec<(u32, Vec<usize>)> {
    let mut groups: Vec<(u32, Vec<usize>)> = Vec::new();
    let mut group_of = vec![None; geometry.materials.len()];
    for (i, face) in geometry.faces.iter().enumerate() {
        let group = *group_of[face.material as usize].get_or_insert_with(|| {
            groups.push((face.material, Vec::new()));
            groups.len() - 1
        });
        groups[group].1.push(i);
    }
    groups
}

#[derive(Default)]
struct MeshBuilder {
    data: MeshData,
    has_uvs: bool,
    has_normals: bool,
    vertices: HashMap<[u32; 3], u32>,
    points: Vec<Vec3>,
    /// Vertices of the current face.
    ids: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

impl MeshBuilder {
    fn add(&mut self, geometry: &Geometry, face: usize, triangulator: &mut Triangulator) -> Coverage {
        let corners = &geometry.corners[geometry.faces[face].range()];
        self.points.clear();
        self.points.extend(corners.iter().map(|c| geometry.positions[c.position as usize]));
        self.triangles.clear();
        let coverage = triangulator.triangulate(&self.points, &mut self.triangles);
        self.ids.clear();
        for corner in corners {
            let id = self.vertex(geometry, *corner);
            self.ids.push(id);
        }
        let ids = &self.ids;
        self.data.triangles.extend(self.triangles.iter().map(|t| t.map(|i| ids[i as usize])));
        coverage
    }

    fn vertex(&mut self, geometry: &Geometry, corner: Corner) -> u32 {
        let Corner { position, uv, normal } = corner;
        let data = &mut self.data;
        // There are no more vertices than corners, and the number of corners fits.
        let next = data.positions.len() as u32;
        let id = *self.vertices.entry([position, uv, normal]).or_insert(next);
        if id == next {
            data.positions.push(geometry.positions[position as usize]);
            self.has_uvs |= uv != NONE;
            self.has_normals |= normal != NONE;
            let uv = if uv == NONE { None } else { Some(geometry.uvs[uv as usize]) };
            data.uvs.push(uv.map_or(Vec2::ZERO, |uv| Vec2::new(uv.x, 1.0 - uv.y)));
            data.normals.push(if normal == NONE { Vec3::ZERO } else { geometry.normals[normal as usize] });
        }
        id
    }

    /// Returns the mesh of the faces added since the last one.
    fn finish(&mut self, name: &str, origin: DVec3) -> MeshData {
        let mut data = std::mem::take(&mut self.data);
        name.clone_into(&mut data.name);
        data.origin = origin;
        if !std::mem::take(&mut self.has_uvs) {
            data.uvs = Vec::new();
        }
        if !std::mem::take(&mut self.has_normals) {
            data.normals = Vec::new();
        }
        self.vertices.clear();
        data
    }
}
