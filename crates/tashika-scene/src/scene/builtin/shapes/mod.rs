//! Solids and sheets made by formula, the parts of the built-in scenes.
//!
//! A [`Shape`] is a triangle mesh with a unit normal and texture coordinates at every vertex.
//! Lengths in metres, `y` up.
//!
//! # Guarantee
//! * Triangles run counter-clockwise when seen from outside (closed shapes), or from the side named
//!   by the generator (sheets), and every vertex normal lies on that side of the triangles around
//!   it.
//! * No two corners of a triangle coincide.
//!
//! # Held to this by
//! `tests::solids_have_the_volume_of_their_formula`, `tests::normals_agree_with_the_winding`.

mod flat;
mod grid;
mod round;
mod sweep;
#[cfg(test)]
mod tests;

pub use flat::{bevelled_box, box_between, quad};
pub use grid::{Ends, grid};
pub use round::{creased, cylinder, disk, lathe, sphere, superellipsoid, torus};
pub use sweep::{Section, sweep, torus_knot, tube};

use glam::{Affine3A, DVec3, Quat, Vec2, Vec3};

use crate::scene::MeshData;

/// A triangle mesh with one unit normal and one pair of texture coordinates a vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// Positions of the vertices (m).
    pub positions: Vec<Vec3>,
    /// Unit normals of the vertices.
    pub normals: Vec<Vec3>,
    /// Texture coordinates of the vertices.
    pub uvs: Vec<Vec2>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Shape {
    /// Joins all of `parts` into one shape.
    pub fn merged(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut all = Self::default();
        for part in parts {
            all.append(part);
        }
        all
    }

    /// Adds the triangles of `other`.
    pub fn append(&mut self, other: Self) {
        let first = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        self.uvs.extend(other.uvs);
        self.triangles.extend(other.triangles.into_iter().map(|t| t.map(|i| i + first)));
    }

    /// Applies an affine map; a mirror reverses the triangles, so that outside stays outside.
    #[must_use]
    pub fn moved(mut self, map: Affine3A) -> Self {
        // Normals transform with the transposed inverse.
        let normal_map = map.matrix3.inverse().transpose();
        for p in &mut self.positions {
            *p = map.transform_point3(*p);
        }
        for n in &mut self.normals {
            *n = Vec3::from(normal_map * glam::Vec3A::from(*n)).normalize();
        }
        if map.matrix3.determinant() < 0.0 {
            for t in &mut self.triangles {
                t.swap(1, 2);
            }
        }
        self
    }

    /// Shifts the shape by `offset` (m).
    #[must_use]
    pub fn at(self, offset: Vec3) -> Self {
        self.moved(Affine3A::from_translation(offset))
    }

    /// Rotates the shape around the origin.
    #[must_use]
    pub fn turned(self, rotation: Quat) -> Self {
        self.moved(Affine3A::from_quat(rotation))
    }

    /// Replaces the texture coordinates by a function of positions and normals.
    #[must_use]
    pub fn mapped(mut self, uv: impl Fn(Vec3, Vec3) -> Vec2) -> Self {
        self.uvs = self.positions.iter().zip(&self.normals).map(|(&p, &n)| uv(p, n)).collect();
        self
    }

    /// Returns the mesh to be added to a scene.
    pub fn into_mesh(self, name: impl Into<String>) -> MeshData {
        MeshData {
            name: name.into(),
            positions: self.positions,
            origin: DVec3::ZERO,
            normals: self.normals,
            uvs: self.uvs,
            triangles: self.triangles,
        }
    }
}
