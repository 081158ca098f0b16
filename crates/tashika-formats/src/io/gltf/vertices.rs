//! The vertices of a primitive that triangles use: what is moved by [`morphs`](super::morphs) and
//! [`skins`](super::skins).

use std::ops::Range;

use glam::Vec3;
use gltf::json;

/// Which vertices are wanted.
pub(super) struct Wanted<'w> {
    pub primitive: &'w json::mesh::Primitive,
    /// Where the primitive stands in the file.
    pub item: &'w str,
    /// How many there are.
    pub count: usize,
    /// Those that triangles use.
    pub range: Range<usize>,
}

/// Positions and normals.
#[derive(Clone, PartialEq)]
pub(super) struct Vertices {
    pub positions: Vec<Vec3>,
    /// None, or one for each.
    pub normals: Vec<Vec3>,
}
