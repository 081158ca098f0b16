//! Meshes that deform while the shutter is open.
//!
//! Such a mesh has one shape when the shutter opens and another when it closes, with the same
//! triangles. Vertices and normals are interpolated linearly in object space: after a share `s` of
//! the time, a vertex is at
//!
//! ```text
//! p(s) = (1 − s) p₀ + s p₁
//! ```
//!
//! Its instances count as [moving](super::motion): each has a [`Motion`](super::Motion), which may
//! be constant. Functions without a time argument use the shape in the middle, `s = ½`.
//!
//! # Guarantee
//! `p(s)` is always computed by [`between`], in single precision, so that equal arguments give
//! equal bits. The surface at a time consists of the triangles with these corners, and
//! [`Mesh::bounds`] contains it at all times. Every triangle has an area when the shutter opens, in
//! the middle of the time, or when it closes. At times at which a triangle has no area, no ray
//! meets it.
//!
//! # Held to this by
//! The tests below; `accel::tests`; the suite's `deforming` and `gltf_shapes`.

use glam::{DAffine3, Vec3};

use super::mesh::MeshRepairs;
use super::{MaterialId, Mesh, MeshData, MeshId, SceneBuilder};
use crate::error::{Error, Result};
use crate::math::Aabb;
use crate::math::motion::Track;

/// Shape of a mesh at a time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshShape {
    /// Vertex positions (m, object space).
    pub positions: Vec<Vec3>,
    /// Normals: none, or one a vertex, of any length.
    pub normals: Vec<Vec3>,
}

/// Shapes of a mesh while the shutter is open.
#[derive(Clone, Debug)]
pub(super) struct Deformation {
    /// Times at which the shutter opens and closes (s).
    pub shutter: [f64; 2],
    /// Shapes when the shutter opens and when it closes.
    pub ends: [MeshShape; 2],
}

/// Bound on the rounding error of an interpolated position, relative to the largest coordinate:
/// three roundings of weights and products, and one of the sum.
const ROUNDING: f32 = 2.0 * f32::EPSILON;

/// Returns the point at a share, 0 to 1, of the distance from one point to another; exact at both
/// ends.
#[inline(always)]
pub fn between(from: Vec3, to: Vec3, share: f32) -> Vec3 {
    from * (1.0 - share) + to * share
}

/// Returns a box around all straight paths from a point in `open` to a point in `close`, with a
/// margin for rounding.
pub fn box_between(open: Aabb, close: Aabb) -> Aabb {
    let all = open.union(close);
    if all.is_empty() {
        return all;
    }
    let margin = ROUNDING * all.lo.abs().max(all.hi.abs()).max_element();
    Aabb { lo: all.lo - margin, hi: all.hi + margin }
}

impl Deformation {
    /// Returns the shape in the middle of the time.
    fn middle(&self) -> MeshShape {
        let [open, close] = &self.ends;
        let mean = |a: &[Vec3], b: &[Vec3]| -> Vec<Vec3> {
            a.iter().zip(b).map(|(&a, &b)| between(a, b, 0.5)).collect()
        };
        let mut normals = mean(&open.normals, &close.normals);
        Mesh::repair_normals(&mut normals);
        MeshShape { positions: mean(&open.positions, &close.positions), normals }
    }

    /// Size of both shapes in memory (bytes).
    pub(super) fn bytes(&self) -> u64 {
        let of = |shape: &MeshShape| size_of_val(&shape.positions[..]) + size_of_val(&shape.normals[..]);
        self.ends.iter().map(of).sum::<usize>() as u64
    }
}

impl Mesh {
    /// Times at which the shutter opens and closes (s), if the mesh deforms in between.
    #[inline]
    pub fn deforms(&self) -> Option<[f64; 2]> {
        self.deformation.as_ref().map(|deformation| deformation.shutter)
    }

    /// Corners of a triangle (m, object space) after a share of the time that the shutter is open,
    /// 0 to 1.
    #[inline]
    pub fn corners_at(&self, share: f32, triangle: u32) -> [Vec3; 3] {
        let Some(deformation) = &self.deformation else { return self.corners(triangle) };
        let [open, close] = &deformation.ends;
        self.triangles[triangle as usize]
            .map(|i| between(open.positions[i as usize], close.positions[i as usize], share))
    }

    /// Normals at the corners of a triangle after a share of the time; zero where there is no
    /// direction. The mesh must have normals.
    #[inline]
    pub(super) fn normals_at(&self, share: f32, triangle: u32) -> [Vec3; 3] {
        let indices = self.triangles[triangle as usize].map(|i| i as usize);
        let Some(deformation) = &self.deformation else { return indices.map(|i| self.normals[i]) };
        let [open, close] = &deformation.ends;
        indices.map(|i| between(open.normals[i], close.normals[i], share))
    }

    /// Like [`Mesh::repair`], for a mesh that deforms.
    fn repair_deforming(
        data: MeshData,
        closing: MeshShape,
        shutter: [f64; 2],
        material: MaterialId,
    ) -> (Self, MeshRepairs) {
        let MeshData { name, positions, origin, normals, uvs, triangles } = data;
        let mut ends = [MeshShape { positions, normals }, closing];
        let mut lost = [0; 2];
        for (shape, lost) in ends.iter_mut().zip(&mut lost) {
            *lost = Self::repair_normals(&mut shape.normals);
        }
        let deformation = Deformation { shutter, ends };
        let MeshShape { positions, normals } = deformation.middle();
        let of = |end: usize, t: &[u32; 3]| t.map(|i| deformation.ends[end].positions[i as usize]);
        let data = MeshData { name, positions, origin, normals, uvs, triangles };
        let (mut mesh, mut repairs) = Self::repair_with(data, material, |t| [of(0, t), of(1, t)]);
        repairs.normals = lost[0].max(lost[1]);
        let bounds = |end: usize| Aabb::of_points(mesh.triangles.iter().flat_map(|t| of(end, t)));
        mesh.bounds = box_between(bounds(0), bounds(1));
        mesh.deformation = Some(Box::new(deformation));
        (mesh, repairs)
    }
}

impl SceneBuilder {
    /// Adds a mesh that deforms while the shutter is open. `data` is its shape when the shutter
    /// opens, `closing` its shape when it closes, relative to the same origin. If both shapes are
    /// equal, a static [mesh](Self::add_mesh) is added.
    ///
    /// Wrong indices and counts are errors, as is a shutter that does not open at one finite time
    /// and close at a later one. Triangles that cannot be rendered are omitted; those that are not
    /// finite are noted.
    pub fn add_deforming_mesh(
        &mut self,
        mut data: MeshData,
        mut closing: MeshShape,
        shutter: [f64; 2],
        material: MaterialId,
    ) -> Result<MeshId> {
        let at = || self.origin.clone().item(format!("mesh {}", data.name));
        let counts = [&data.positions, &data.normals].map(Vec::len);
        let found = [&closing.positions, &closing.normals].map(Vec::len);
        if counts != found {
            let found = format!("{} positions and {} normals when the shutter closes", found[0], found[1]);
            let expected = format!("{} and {}, as when it opens", counts[0], counts[1]);
            return Err(Error::invalid(at(), found, expected));
        }
        let [open, close] = shutter;
        if !(open < close && open.is_finite() && close.is_finite()) {
            let found = format!("a shutter that is open from {open} to {close} s");
            return Err(Error::invalid(at(), found, "finite times, the first before the second"));
        }
        if data.positions == closing.positions && data.normals == closing.normals {
            return self.add_mesh(data, material);
        }
        self.check_mesh(&data, material)?;
        self.localize(&mut data, Some(&mut closing));
        let (name, origin) = (data.name.clone(), data.origin);
        let (mesh, repairs) = Mesh::repair_deforming(data, closing, shutter, material);
        Ok(self.push_mesh(mesh, repairs, (&name, origin)))
    }
}

/// Returns a track with a constant transform; `None` if it cannot be inverted.
pub(super) fn standing(to_world: DAffine3) -> Option<Track> {
    Track::new([(0.0, to_world)])
}

#[cfg(test)]
mod tests {
    use glam::Affine3A;

    use super::*;
    use crate::color::Rgb;
    use crate::error::Location;
    use crate::scene::{Material, Surface};

    const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

    fn builder() -> (SceneBuilder, MaterialId) {
        let mut b = SceneBuilder::new("s", Location::file("s.gltf"));
        let material = Material::new("m", Surface::Lambert { reflectance: Rgb::gray(0.5).into() });
        let material = b.add_material(material).unwrap();
        (b, material)
    }

    fn data(positions: &[Vec3], normals: &[Vec3]) -> MeshData {
        MeshData {
            positions: positions.to_vec(),
            normals: normals.to_vec(),
            triangles: vec![[0, 1, 2]],
            ..MeshData::default()
        }
    }

    fn shape(positions: &[Vec3], normals: &[Vec3]) -> MeshShape {
        MeshShape { positions: positions.to_vec(), normals: normals.to_vec() }
    }

    #[test]
    fn vertices_and_normals_go_in_straight_lines_wherever_the_instance_is() {
        let (mut b, material) = builder();
        let end = [Vec3::Z * 2.0, Vec3::new(3.0, 0.0, 2.0), Vec3::new(0.0, 1.0, 4.0)];
        let normals = [[Vec3::Z; 3], [Vec3::X * 7.0; 3]];
        let mesh = b
            .add_deforming_mesh(data(&CORNERS, &normals[0]), shape(&end, &normals[1]), [1.0, 2.0], material)
            .unwrap();
        let still = b.add_instance(mesh, Affine3A::from_translation(Vec3::Y * 5.0)).unwrap().unwrap();
        let key = |x: f64| DAffine3::from_translation(glam::DVec3::X * x);
        let track = Track::new([(1.0, key(0.0)), (2.0, key(8.0))]).unwrap();
        let moving = b.add_moving_instance(mesh, track, [1.0, 2.0]).unwrap().unwrap();
        let scene = b.build().unwrap();
        assert!(scene.moves() && scene.shutter() == Some([1.0, 2.0]));
        assert_eq!(scene.meshes()[0].deforms(), Some([1.0, 2.0]));
        for share in [0.0, 0.25, 0.5, 1.0_f32] {
            for (id, way) in [(still, Vec3::Y * 5.0), (moving, Vec3::X * 8.0 * share)] {
                let expected = [0, 1, 2].map(|v| CORNERS[v].lerp(end[v], share) + way);
                let found = scene.world_corners_at(share, id, 0);
                assert!(
                    found.iter().zip(expected).all(|(f, e)| (*f - e).length() < 1e-6),
                    "{share}: {found:?}"
                );
                let point = scene.surface_point_at(share, id, 0, [0.5, 0.25, 0.25]);
                let at = expected[0] * 0.5 + expected[1] * 0.25 + expected[2] * 0.25;
                assert!((point.position - at).length() < 1e-6);
                let normal = (Vec3::Z * (1.0 - share) + Vec3::X * share).normalize();
                assert!((point.shading_normal - normal).length() < 1e-6, "{}", point.shading_normal);
                let flat = (expected[1] - expected[0]).cross(expected[2] - expected[0]).normalize();
                let flat = if flat.dot(normal) < 0.0 { -flat } else { flat };
                assert!((point.geometric_normal - flat).length() < 1e-6);
                if share == 0.5 {
                    assert_eq!(scene.world_corners(id, 0), found, "the middle without a time");
                    assert_eq!(scene.surface_point(id, 0, [0.5, 0.25, 0.25]).position, point.position);
                }
                for corner in found {
                    assert!(scene.bounds().contains(corner), "{corner} in {:?}", scene.bounds());
                }
            }
        }
        assert_eq!(scene.mesh_bytes(), 3 * 3 * 2 * 12 + 12, "three shapes and a triangle");
    }

    #[test]
    fn boxes_hold_places_on_the_way_whatever_rounding_does() {
        let mut s = crate::rng::Stream::new(1, crate::rng::Purpose::Test, 0);
        for _ in 0..20_000 {
            let mut place = || (Vec3::from(s.uniform_3()) - 0.5) * 3.0 + 1000.0;
            let (from, mut to) = (place(), place());
            // Equal coordinates are tested as well: their interpolation is not exact.
            to.y = from.y;
            let held = box_between(Aabb::of_points([from]), Aabb::of_points([to]));
            let share = s.uniform();
            assert!(held.contains(between(from, to, share)), "{from} to {to} at {share}");
            assert_eq!([0.0, 1.0].map(|share| between(from, to, share)), [from, to]);
        }
        assert!(box_between(Aabb::EMPTY, Aabb::EMPTY).is_empty());
    }

    #[test]
    fn triangles_without_area_throughout_are_left_out_and_others_stay() {
        let (mut b, material) = builder();
        let grown =
            b.add_deforming_mesh(data(&[Vec3::ONE; 3], &[]), shape(&CORNERS, &[]), [0.0, 1.0], material);
        // This triangle is turned inside out; in the middle of the time it has no area.
        let turned = [Vec3::ZERO, Vec3::X, Vec3::NEG_Y];
        let turned = b.add_deforming_mesh(data(&CORNERS, &[]), shape(&turned, &[]), [0.0, 1.0], material);
        let line = [Vec3::ZERO, Vec3::X, Vec3::X * 2.0];
        let flat = line.map(|v| v + Vec3::Y);
        let flat = b.add_deforming_mesh(data(&line, &[]), shape(&flat, &[]), [0.0, 1.0], material);
        let broken = [Vec3::ZERO, Vec3::X, Vec3::splat(f32::NAN)];
        let broken = b.add_deforming_mesh(data(&CORNERS, &[]), shape(&broken, &[]), [0.0, 1.0], material);
        let triangles = [grown, turned, flat, broken].map(|mesh| {
            let mesh = mesh.unwrap();
            b.add_instance(mesh, Affine3A::IDENTITY).unwrap();
            b.scene.meshes[mesh.index()].triangles().len()
        });
        assert_eq!(triangles, [1, 1, 0, 0]);
        let scene = b.build().unwrap();
        assert_eq!(scene.triangles_without_area(), 1);
        assert!(scene.notes().iter().any(|note| note.message.contains("vertices that are not finite")));
        let id = scene.instance_ids().nth(1).unwrap();
        let point = scene.surface_point_at(0.5, id, 0, [1.0 / 3.0; 3]);
        assert!(point.geometric_normal.is_normalized() && point.position.is_finite(), "whatever it is");
    }

    #[test]
    fn what_does_not_fit_together_is_refused_and_what_does_not_deform_stands() {
        let (mut b, material) = builder();
        let mut refused = |closing: MeshShape, shutter: [f64; 2]| {
            b.add_deforming_mesh(data(&CORNERS, &[]), closing, shutter, material).unwrap_err().to_string()
        };
        let said = refused(shape(&CORNERS[..2], &[]), [0.0, 1.0]);
        assert!(said.contains("2 positions and 0 normals") && said.contains("3 and 0"), "{said}");
        assert!(refused(shape(&CORNERS, &CORNERS), [0.0, 1.0]).contains("3 normals"));
        for shutter in [[1.0, 1.0], [1.0, 0.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
            let said = refused(shape(&CORNERS, &[]), shutter);
            assert!(said.contains("s.gltf") && said.contains("finite times"), "{said}");
        }
        let same = b.add_deforming_mesh(data(&CORNERS, &[]), shape(&CORNERS, &[]), [0.0, 1.0], material);
        let other = shape(&CORNERS.map(|v| v * 2.0), &[]);
        let deforms = b.add_deforming_mesh(data(&CORNERS, &[]), other, [0.0, 1.0], material).unwrap();
        b.add_instance(same.unwrap(), Affine3A::IDENTITY).unwrap();
        assert!(!b.scene.moves());
        // Instances of a mesh that deforms need the shutter times of the mesh, and a transform that
        // can be inverted.
        let track = Track::new([(0.0, DAffine3::IDENTITY)]).unwrap();
        let said = b.add_moving_instance(deforms, track, [0.0, 2.0]).unwrap_err().to_string();
        assert!(said.contains("0 to 2 s") && said.contains("0 to 1 s, as the mesh"), "{said}");
        let flat = Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0));
        assert!(b.add_instance(deforms, flat).unwrap().is_none() && !b.scene.moves());
        assert!(b.add_instance(deforms, Affine3A::IDENTITY).unwrap().is_some() && b.scene.moves());
    }
}
