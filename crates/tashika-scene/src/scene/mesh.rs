//! Triangle meshes and their instances.

use glam::{Affine3A, DVec3, Vec2, Vec3, Vec3A};

use super::deformation::Deformation;
use super::{Interface, MaterialId, MeshId};
use crate::math::{Aabb, LocalPlaces, gamma};

/// Mesh as a loader creates it, before any check.
#[derive(Clone, Debug, Default)]
pub struct MeshData {
    /// Name that identifies it in messages.
    pub name: String,
    /// Vertex positions (m, object space), relative to `origin`.
    pub positions: Vec<Vec3>,
    /// Origin of the positions in object space (m), see [`MeshData::place`].
    pub origin: DVec3,
    /// Vertex normals: none, or one a vertex. Need not be unit vectors; zero or non-finite ones are
    /// replaced by the normal of the face.
    pub normals: Vec<Vec3>,
    /// Texture coordinates: none, or one a vertex.
    pub uvs: Vec<Vec2>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl MeshData {
    /// Sets the positions to points of object space (m), relative to zero unless they are far from
    /// it.
    pub fn place(&mut self, places: &[DVec3]) {
        LocalPlaces { origin: self.origin, places: self.positions } = LocalPlaces::of(places);
    }

    /// Turns the mesh inside out.
    pub fn turn_around(&mut self) {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        self.normals.iter_mut().for_each(|n| *n = -*n);
    }

    /// Replaces each `v` by `1 − v`.
    pub fn flip_v(&mut self) {
        self.uvs.iter_mut().for_each(|uv| uv.y = 1.0 - uv.y);
    }
}

/// Validated mesh: finite vertices, indices in range, no degenerate triangle, unit normals.
#[derive(Clone, Debug)]
pub struct Mesh {
    pub(super) name: String,
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
    pub(super) uvs: Vec<Vec2>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) bounds: Aabb,
    /// Deformation while the shutter is open, if any. `positions` and `normals` are then those in
    /// the middle of that time.
    pub(super) deformation: Option<Box<Deformation>>,
    /// Material of all its triangles.
    pub material: MaterialId,
    /// Media on its two sides, if the file specifies them.
    pub interface: Option<Interface>,
}

/// Numbers of items that [`Mesh::repair`] omitted or replaced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct MeshRepairs {
    /// Triangles with a vertex that is not finite.
    pub not_finite: u64,
    /// Triangles without a usable area.
    pub degenerate: u64,
    /// Vertex normals that are zero or not finite.
    pub normals: u64,
    /// Texture coordinates that are not finite.
    pub uvs: u64,
}

/// Smallest sine of the angle at a corner, `‖e₁ × e₂‖ / (‖e₁‖·‖e₂‖)`, at which the direction of the
/// normal `e₁ × e₂`, computed in `f32`, is off by less than 60°. The rounding error of the normal
/// is below `8 γ₄ ‖e₁‖·‖e₂‖`.
const MIN_SINE: f32 = 16.0 * crate::math::GAMMA_4;

/// Returns true if a triangle's normal is accurate enough to distinguish its sides.
pub fn has_normal(v: &[Vec3; 3]) -> bool {
    let (e1, e2) = (v[1] - v[0], v[2] - v[0]);
    // Edges are scaled to lengths around 1, so that no square leaves the range of `f32`.
    let (m1, m2) = (e1.abs().max_element(), e2.abs().max_element());
    let (a, b) = (e1 / m1, e2 / m2);
    // The products of lengths that the tracer computes, of up to three factors, must be in that
    // range.
    let in_range = (m1 * m2).is_normal() && (m1.max(m2) * m1 * m2).is_finite();
    in_range && a.cross(b).length() >= MIN_SINE * a.length() * b.length()
}

impl Mesh {
    /// Vertex positions (m, object space).
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Unit vertex normals; empty if the mesh is flat-shaded.
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// Texture coordinates; empty if there are none.
    pub fn uvs(&self) -> &[Vec2] {
        &self.uvs
    }

    /// Vertex indices of each triangle.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Size of the mesh in memory (bytes).
    pub fn bytes(&self) -> u64 {
        let bytes = size_of_val(&self.positions[..])
            + size_of_val(&self.normals[..])
            + size_of_val(&self.uvs[..])
            + size_of_val(&self.triangles[..]);
        bytes as u64 + self.deformation.as_ref().map_or(0, |deformation| deformation.bytes())
    }

    /// Name of the mesh for messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Bounding box of the vertices that triangles use (m, object space), at all times.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Corners of a triangle (m, object space).
    #[inline]
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|i| self.positions[i as usize])
    }

    /// Creates the mesh from `data` without the triangles that cannot be rendered; indices must be
    /// in range.
    pub(super) fn repair(data: MeshData, material: MaterialId) -> (Self, MeshRepairs) {
        Self::repair_with(data, material, |_| [])
    }

    /// Like [`Self::repair`], for a mesh that deforms: `others` returns the corners of a triangle
    /// at other times, from its vertex indices. A triangle is omitted if a corner is not finite at
    /// any of the times, or if it has no area at all of them.
    pub(super) fn repair_with<const N: usize>(
        data: MeshData,
        material: MaterialId,
        others: impl Fn(&[u32; 3]) -> [[Vec3; 3]; N],
    ) -> (Self, MeshRepairs) {
        let mut repairs = MeshRepairs::default();
        let MeshData { name, positions, origin: _, mut normals, mut uvs, mut triangles } = data;
        triangles.retain(|t| {
            let v = t.map(|i| positions[i as usize]);
            let others = others(t);
            if !v.iter().chain(others.iter().flatten()).all(|p| p.is_finite()) {
                repairs.not_finite += 1;
                return false;
            }
            let has_area = has_normal(&v) || others.iter().any(has_normal);
            repairs.degenerate += u64::from(!has_area);
            has_area
        });
        repairs.normals = Self::repair_normals(&mut normals);
        for uv in &mut uvs {
            if !uv.is_finite() {
                repairs.uvs += 1;
                *uv = Vec2::ZERO;
            }
        }
        let bounds = Aabb::of_points(triangles.iter().flatten().map(|&i| positions[i as usize]));
        let (deformation, interface) = (None, None);
        (Self { name, positions, normals, uvs, triangles, bounds, deformation, material, interface }, repairs)
    }

    /// Normalises all normals. Normals that are zero or not finite are set to zero; returns their
    /// number.
    pub(super) fn repair_normals(normals: &mut [Vec3]) -> u64 {
        let mut lost = 0;
        for n in normals {
            let unit = n.normalize_or_zero();
            lost += u64::from(unit == Vec3::ZERO || !unit.is_finite());
            // A zero normal stands for the face normal, see `Scene::surface_point`.
            *n = if unit.is_finite() { unit } else { Vec3::ZERO };
        }
        lost
    }
}

/// A mesh placed in the world.
#[derive(Clone, Copy, Debug)]
pub struct Instance {
    /// The mesh that is placed.
    pub mesh: MeshId,
    /// Transform from object to world; for a moving instance, in the middle of the time that the
    /// shutter is open.
    pub to_world: Affine3A,
    /// Inverse of `to_world`.
    pub(crate) to_object: Affine3A,
    /// True if `to_world` reverses the orientation of triangles.
    pub(crate) mirrored: bool,
    /// See [`Instance::is_baked`].
    pub(crate) baked: bool,
    /// Index of its motion among the scene's, if it moves.
    pub(crate) motion: Option<u32>,
}

impl Instance {
    /// Returns true if object and world coordinates are equal.
    #[inline]
    pub fn is_identity(&self) -> bool {
        self.to_world == Affine3A::IDENTITY
    }

    /// Transforms the corners of a triangle to the world (m).
    #[inline]
    pub(super) fn corners(&self, corners: [Vec3; 3]) -> [Vec3; 3] {
        if self.is_identity() { corners } else { corners.map(|v| self.to_world.transform_point3(v)) }
    }

    /// Returns true if the surface is defined by corners in world space, each transformed and
    /// rounded once. Otherwise rays are transformed into the space of the mesh. Static instances of
    /// meshes that are placed once are always baked, and others if their copies are small.
    pub fn is_baked(&self) -> bool {
        self.baked
    }

    /// Transform from world to object, the inverse of [`Self::to_world`].
    #[inline]
    pub fn to_object(&self) -> Affine3A {
        self.to_object
    }

    /// Upper bound on the rounding error (m, by component) of points that are transformed to the
    /// world and back.
    ///
    /// Rays are transformed into the space of an instance, so that its surface in the world is
    /// defined by the inverse transform. Let `x ↦ M x + t` be the transform, `x ↦ M′ x + t′` its
    /// inverse, and `y = |M| size + |t|`. The bound is `γ₆ (y + |M| (|M′| y + |t′|))`: an entry of
    /// a matrix, a product and three sums are at most six roundings.
    ///
    /// * `size`: upper bounds on the absolute components of the object's points (m).
    pub fn rounding(&self, size: Vec3) -> Vec3 {
        let absolute = |map: &Affine3A| {
            let [x, y, z] = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis].map(Vec3A::abs);
            (move |v: Vec3| x * v.x + y * v.y + z * v.z, map.translation.abs())
        };
        let (forth, moved) = absolute(&self.to_world);
        let (back, moved_back) = absolute(&self.to_object);
        let world = forth(size) + moved;
        Vec3::from(world + forth(Vec3::from(back(world.into()) + moved_back))) * gamma(6)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn data(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> MeshData {
        MeshData {
            positions: positions.iter().map(|&p| p.into()).collect(),
            triangles: triangles.to_vec(),
            ..MeshData::default()
        }
    }

    #[test]
    fn meshes_are_turned_with_their_normals_and_coordinates() {
        let mut data = data(&[[0.0; 3]; 3], &[[0, 1, 2]]);
        (data.normals, data.uvs) = (vec![Vec3::Z, Vec3::ZERO], vec![Vec2::new(0.25, 0.25)]);
        data.turn_around();
        data.flip_v();
        assert_eq!((data.triangles[0], data.normals[0]), ([0, 2, 1], Vec3::NEG_Z));
        assert_eq!(data.uvs, [Vec2::new(0.25, 0.75)]);
    }

    #[test]
    fn unusable_triangles_are_left_out_and_counted() {
        let positions =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [f32::NAN, 0.0, 0.0], [2.0, 0.0, 0.0]];
        let d = data(&positions, &[[0, 1, 2], [0, 1, 3], [0, 1, 4], [2, 2, 1]]);
        let (mesh, repairs) = Mesh::repair(d, MaterialId(0));
        assert_eq!(mesh.triangles(), [[0, 1, 2]]);
        assert_eq!(repairs, MeshRepairs { not_finite: 1, degenerate: 2, ..MeshRepairs::default() });
        assert_eq!(mesh.bounds().hi, Vec3::new(1.0, 1.0, 0.0), "unused vertices do not count");
    }

    #[test]
    fn tiny_and_huge_triangles_are_sound() {
        for scale in [1e-6_f32, 1.0, 1e6, 1e10] {
            let s = scale;
            let d = data(&[[0.0, 0.0, 0.0], [s, 0.0, 0.0], [0.0, 1e-3 * s, 0.0]], &[[0, 1, 2]]);
            let (mesh, _) = Mesh::repair(d, MaterialId(0));
            assert_eq!(mesh.triangles().len(), 1, "scale {scale}");
        }
    }
}
