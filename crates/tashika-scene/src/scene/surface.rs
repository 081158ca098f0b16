//! Points on surfaces, with a bound on the error of their position.

use glam::{Vec2, Vec3, Vec3A};

use super::faces::Face;
use super::facets::tangent;
use super::normal_map::{Corners, perturbed};
use super::part::SurfaceView;
use super::{AlphaMode, Back, Instance, InstanceId, Material, Part, Scene};
use crate::color::Rgb;
use crate::math::simd::prefetch;
use crate::math::{Frame, GAMMA_7, offset_from_surface};

/// Replacement of a shading normal that faces away from the viewer. Such normals occur at the
/// silhouettes of coarse meshes with smooth normals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TurnedAway {
    /// The geometric normal, as if the surface were flat.
    #[default]
    Flat,
    /// The opposite of the shading normal. Only light that arrives in front of the surface *and*
    /// behind its shading normal is reflected, so the surface is nearly black. Renderers that use
    /// the shading normal alone, such as Mitsuba 3 and pbrt-v4, have this result.
    Opposite,
}

/// A point on a triangle of an instance.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Position in the world (m), exact to within `error`.
    pub position: Vec3,
    /// Bound on the absolute error of each component of `position` (m).
    pub error: Vec3,
    /// Unit geometric normal, on the front side. The front is the side of the shading normals if
    /// the mesh has any, else the side on which the corners run counter-clockwise.
    pub geometric_normal: Vec3,
    /// Unit shading normal, in the hemisphere of the geometric one.
    pub shading_normal: Vec3,
    /// Unit tangent of brushed facets: the direction of the first of their two roughnesses, roughly
    /// in the surface. `None` if the material has no brushed facets.
    pub tangent: Option<Vec3>,
    /// Texture coordinates; zero if the mesh has none.
    pub uv: Vec2,
    /// Instance that contains the point.
    pub instance: InstanceId,
    /// Replacement of the shading normal where it faces away.
    pub turned_away: TurnedAway,
}

impl SurfacePoint {
    /// Returns the position moved off the surface to the side into which `direction` points: the
    /// origin of a ray or segment in that direction.
    #[inline]
    pub fn leave(&self, direction: Vec3) -> Vec3 {
        let n = self.geometric_normal;
        offset_from_surface(self.position, self.error, if direction.dot(n) < 0.0 { -n } else { n })
    }

    /// Frame in which the surface scatters, around a unit normal on either side.
    #[inline]
    pub fn frame(&self, normal: Vec3) -> Frame {
        match self.tangent {
            None => Frame::about(normal),
            Some(tangent) => Frame::along(normal, tangent),
        }
    }

    /// Geometric and shading normal, turned to the side of `direction`.
    #[inline]
    pub fn normals_towards(&self, direction: Vec3) -> (Vec3, Vec3) {
        if self.geometric_normal.dot(direction) < 0.0 {
            (-self.geometric_normal, -self.shading_normal)
        } else {
            (self.geometric_normal, self.shading_normal)
        }
    }

    /// Geometric and shading normal as seen from `direction`: a shading normal that faces away is
    /// [replaced](TurnedAway).
    #[inline]
    pub fn normals_seen_from(&self, direction: Vec3) -> (Vec3, Vec3) {
        let (ng, ns) = self.normals_towards(direction);
        let seen = match self.turned_away {
            _ if ns.dot(direction) > 0.0 => ns,
            TurnedAway::Flat => ng,
            TurnedAway::Opposite => -ns,
        };
        (ng, seen)
    }
}

/// Share of the shutter time that functions without a time argument use.
const MIDDLE: f32 = 0.5;

/// Smallest distance of a point from the edges of its triangle, in multiples of the length of the
/// point's error. Points nearer to an edge are moved inwards.
///
/// Suppose that a wall meets the triangle at an edge, at the angle `φ`. A point at the distance `δ`
/// from the edge is then `δ sin φ` from the wall. The origin of a ray is moved off the surface by
/// at most twice the error `ε`, hence towards the wall by at most `2 ε cos φ`. The point itself is
/// off by up to `ε`. So the origin stays in front of the wall if `δ sin φ ≥ 2 ε cos φ + ε`: with
/// `δ = 4 ε`, for angles of 40° and more.
const INSET: f32 = 4.0;

/// Returns the barycentric weights `b` of a point that is moved away from the edges of its
/// triangle: each weight is at least [`INSET`] times the length of the error, divided by the least
/// height of the triangle, but need not exceed a quarter.
#[inline]
fn inset(face: &Face, b: [f32; 3], error: Vec3) -> [f32; 3] {
    // Distance from the edges, relative to the least height of the triangle.
    let share = INSET * error.length() * face.per_height;
    let least = if share < 0.25 { share } else { 0.25 };
    if b[0] >= least && b[1] >= least && b[2] >= least {
        return b;
    }
    let largest = if b[0] >= b[1] && b[0] >= b[2] { 0 } else { 1 + usize::from(b[1] < b[2]) };
    let mut b = b.map(|weight| weight.max(least));
    b[largest] = 1.0 - b[(largest + 1) % 3] - b[(largest + 2) % 3];
    b
}

impl Scene {
    /// World corners of a triangle (m): the exact surface of a baked instance.
    #[inline]
    pub fn world_corners(&self, instance: InstanceId, triangle: u32) -> [Vec3; 3] {
        self.corners_of(&self.instances[instance.index()], MIDDLE, triangle)
    }

    /// World corners of a triangle (m) after a share of the time that the shutter is open, 0 to 1.
    pub fn world_corners_at(&self, share: f32, instance: InstanceId, triangle: u32) -> [Vec3; 3] {
        match self.moved(instance, share) {
            None => self.world_corners(instance, triangle),
            Some(placed) => self.corners_of(&placed, share, triangle),
        }
    }

    #[inline]
    fn corners_of(&self, placed: &Instance, share: f32, triangle: u32) -> [Vec3; 3] {
        placed.corners(self.meshes[placed.mesh.index()].corners_at(share, triangle))
    }

    /// Reads ahead the record of a triangle, which [`Self::read_corners_ahead`] needs.
    #[inline]
    pub fn read_triangle_ahead(&self, instance: InstanceId, triangle: u32) {
        prefetch(&self.mesh_of(instance).triangles[triangle as usize]);
        if let Some(face) = self.faces.get(instance.index(), triangle) {
            prefetch(face);
        }
    }

    /// Reads ahead the corners of a triangle, with their normals and texture coordinates.
    #[inline]
    pub fn read_corners_ahead(&self, instance: InstanceId, triangle: u32) {
        let mesh = self.mesh_of(instance);
        for corner in mesh.triangles[triangle as usize].map(|i| i as usize) {
            prefetch(&mesh.positions[corner]);
            mesh.normals.get(corner).iter().for_each(|normal| prefetch(*normal));
            mesh.uvs.get(corner).iter().for_each(|uv| prefetch(*uv));
        }
    }

    /// Returns the point with barycentric coordinates `b` (summing to 1) of a triangle. A point
    /// close to an edge is moved inwards, so that its error cannot put it behind a wall at that
    /// edge.
    ///
    /// The error bound is `γ₇ Σ |bᵢ wᵢ|` for the sum over world corners `wᵢ`. Unless the instance
    /// is [baked](Instance::is_baked), [`Instance::rounding`] is added for the corners themselves.
    pub fn surface_point(&self, instance: InstanceId, triangle: u32, b: [f32; 3]) -> SurfacePoint {
        self.point_on(&self.instances[instance.index()], MIDDLE, instance, triangle, b)
    }

    /// Like [`Self::surface_point`], after a share of the time that the shutter is open, 0 to 1.
    #[inline]
    pub fn surface_point_at(
        &self,
        share: f32,
        instance: InstanceId,
        triangle: u32,
        b: [f32; 3],
    ) -> SurfacePoint {
        match self.moved(instance, share) {
            None => self.surface_point(instance, triangle, b),
            Some(placed) => self.point_on(&placed, share, instance, triangle, b),
        }
    }

    /// Returns a point of an instance. `placed` is the instance in its pose after a share of the
    /// time; the share itself matters only for meshes that deform.
    fn point_on(
        &self,
        placed: &Instance,
        share: f32,
        instance: InstanceId,
        triangle: u32,
        b: [f32; 3],
    ) -> SurfacePoint {
        let mesh = self.mesh_of(instance);
        let indices = mesh.triangles[triangle as usize].map(|i| i as usize);
        let w = self.corners_of(placed, share, triangle);
        let at = |b: [f32; 3]| w[0] * b[0] + w[1] * b[1] + w[2] * b[2];
        let mut error = GAMMA_7 * ((w[0] * b[0]).abs() + (w[1] * b[1]).abs() + (w[2] * b[2]).abs());
        if !placed.baked {
            let [p, q, r] = mesh.corners_at(share, triangle).map(Vec3::abs);
            error += placed.rounding(p.max(q).max(r));
        }
        // The triangle in the world; an instance that is not baked has its normal from the mesh.
        let face = self.faces.get(instance.index(), triangle).copied().unwrap_or_else(|| Face::of(&w));
        let position = at(inset(&face, b, error));
        // Normals transform with the transposed inverse.
        let normal_to_world = |n: Vec3| Vec3::from(placed.to_object.matrix3.transpose() * Vec3A::from(n));
        // A mirroring transform reverses the cross product of transformed corners, but not a
        // transformed normal.
        let mut n = if placed.baked {
            face.normal * if placed.mirrored { -1.0 } else { 1.0 }
        } else {
            normal_to_world(Face::of(&mesh.corners_at(share, triangle)).normal).normalize_or(Vec3::Z)
        };
        let mut shading_normal = n;
        if !mesh.normals.is_empty() {
            let normals = mesh.normals_at(share, triangle);
            let object: Vec3 = normals.into_iter().zip(b).map(|(n, b)| n * b).sum();
            let unit = normal_to_world(object).normalize_or_zero();
            if unit != Vec3::ZERO {
                shading_normal = unit;
                if n.dot(unit) < 0.0 {
                    n = -n;
                }
            }
        }
        let uv = self.uv_at(instance, triangle, b);
        let material = self.material_of(instance);
        let corners =
            || (!mesh.uvs.is_empty()).then(|| Corners { positions: w, uvs: indices.map(|i| mesh.uvs[i]) });
        if let Some(input) = &material.normal
            && let Some(corners) = corners()
        {
            shading_normal = perturbed(input, self.textures(), uv, &corners, shading_normal, n);
        }
        let tangent = self.brushed[mesh.material.index()].then(|| {
            let input = material.tangent.as_ref();
            tangent(input, self.textures(), uv, corners().as_ref(), shading_normal, n)
        });
        SurfacePoint {
            position,
            error,
            geometric_normal: n,
            shading_normal,
            tangent,
            uv,
            instance,
            turned_away: self.turned_away,
        }
    }

    #[inline]
    fn uv_at(&self, instance: InstanceId, triangle: u32, b: [f32; 3]) -> Vec2 {
        let mesh = self.mesh_of(instance);
        if mesh.uvs.is_empty() {
            return Vec2::ZERO;
        }
        mesh.triangles[triangle as usize].iter().zip(b).map(|(&i, b)| mesh.uvs[i as usize] * b).sum()
    }

    /// Returns the part of the surface at a point, seen from the unit direction `outgoing`, that
    /// the uniform number `u` in `[0, 1)` selects.
    pub fn part(&self, point: &SurfacePoint, outgoing: Vec3, u: f32) -> Part {
        let material = self.material_of(point.instance);
        let is_back = point.geometric_normal.dot(outgoing) < 0.0;
        let material = match material.back {
            Back::Black if is_back => return Part::BLACK,
            Back::Material(back) if is_back => &self.materials[back.index()],
            _ => material,
        };
        let cos = point.shading_normal.dot(outgoing).abs();
        self.part_of(material, point.uv, cos, u)
    }

    /// Like [`Self::part`], for the front of one of the scene's materials.
    ///
    /// * `cos`: absolute cosine between the shading normal and the direction of view, 0 to 1.
    #[inline]
    pub fn part_of(&self, material: &Material, uv: Vec2, cos: f32, u: f32) -> Part {
        self.look(uv, cos).part(material, u)
    }

    #[inline]
    fn look(&self, uv: Vec2, cos: f32) -> SurfaceView<'_> {
        SurfaceView { materials: &self.materials, textures: self.textures(), uv, cos: cos.min(1.0) }
    }

    /// Radiance emitted from a point in direction `outgoing` (W·m⁻²·sr⁻¹).
    #[inline]
    pub fn emitted(&self, point: &SurfacePoint, outgoing: Vec3) -> Rgb {
        match &self.material_of(point.instance).emission {
            Some(e) if e.two_sided || point.geometric_normal.dot(outgoing) > 0.0 => {
                e.radiance.at(self.textures(), point.uv)
            }
            _ => Rgb::BLACK,
        }
    }

    /// Returns true if light may pass straight through the surface, by holes or glass.
    #[inline]
    pub fn may_be_transparent(&self, instance: InstanceId) -> bool {
        let material = self.mesh_of(instance).material;
        self.materials[material.index()].has_holes() || self.glassy[material.index()]
    }

    /// Returns true if the surface is invisible to rays but emits its full radiance
    /// ([`AlphaMode::Unseen`]).
    #[inline]
    pub fn shines_unseen(&self, instance: InstanceId) -> bool {
        self.material_of(instance).alpha.is_some_and(|alpha| alpha.mode == AlphaMode::Unseen)
    }

    /// Opacity of a surface at a point, 0 to 1: 0 in holes.
    #[inline]
    pub fn opacity(&self, instance: InstanceId, triangle: u32, b: [f32; 3]) -> f32 {
        match &self.material_of(instance).alpha {
            None => 1.0,
            Some(alpha) => alpha.at(self.textures(), self.uv_at(instance, triangle, b)),
        }
    }

    /// Fraction of the light along a straight segment that a surface blocks at a point, 0 to 1.
    ///
    /// * `direction`: direction of the segment in the world, of any length.
    /// * `solid_glass`: true if solid glass transmits straight the light that it would refract;
    ///   false if it blocks all light.
    pub fn stopped(
        &self,
        instance: InstanceId,
        triangle: u32,
        b: [f32; 3],
        direction: Vec3,
        solid_glass: bool,
    ) -> f32 {
        let corners = || self.world_corners(instance, triangle);
        self.stopped_between(corners, instance, triangle, b, direction, solid_glass)
    }

    /// Like [`Self::stopped`], after a share of the time that the shutter is open, 0 to 1, with the
    /// direction in the space of the instance.
    pub fn stopped_at(
        &self,
        share: f32,
        instance: InstanceId,
        triangle: u32,
        b: [f32; 3],
        local_direction: Vec3,
        solid_glass: bool,
    ) -> f32 {
        let moved = self.moved(instance, share);
        let placed = moved.as_ref().unwrap_or(&self.instances[instance.index()]);
        let direction = placed.to_world.transform_vector3(local_direction);
        let corners = || self.corners_of(placed, share, triangle);
        self.stopped_between(corners, instance, triangle, b, direction, solid_glass)
    }

    #[inline]
    fn stopped_between(
        &self,
        corners: impl FnOnce() -> [Vec3; 3],
        instance: InstanceId,
        triangle: u32,
        b: [f32; 3],
        direction: Vec3,
        solid_glass: bool,
    ) -> f32 {
        let opacity = self.opacity(instance, triangle, b);
        let mesh = self.mesh_of(instance);
        if !self.glassy[mesh.material.index()] {
            return opacity;
        }
        let w = corners();
        let n = (w[1] - w[0]).cross(w[2] - w[0]).normalize_or_zero();
        let cos = n.dot(direction.normalize_or_zero()).abs();
        let uv = self.uv_at(instance, triangle, b);
        opacity * (1.0 - self.look(uv, cos).straight_through(self.material_of(instance), solid_glass))
    }
}
