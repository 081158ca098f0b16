//! The trees of a scene: one over what is placed once, and one a shared mesh below a tree of instances.

use glam::Vec3;
use rayon::prelude::*;

use super::bvh::{Bvh, Node};
use super::triangle::{Block, Triangle, flag};
use crate::math::simd::WIDTH;
use crate::math::simd::each;
use crate::math::{Aabb, GAMMA_4, Real};
use crate::scene::{Instance, InstanceId, Scene, has_normal};

/// Everything that is walked through.
#[derive(Debug)]
pub(super) struct Trees {
    /// What is placed once, in world space.
    pub world: Tree,
    /// Trees of meshes that are placed more than once.
    pub shared: Vec<Tree>,
    /// Each leaf is one of `placed`.
    pub top: Bvh,
    /// In the order of the leaves of `top`.
    pub placed: Vec<Placed>,
}

/// A tree over triangles: each leaf is one of `blocks`.
#[derive(Debug)]
pub(super) struct Tree {
    pub nodes: Vec<Node>,
    pub blocks: Vec<Block>,
    triangles: u64,
}

/// An instance of a shared tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    /// From world to object space: three columns and what is added.
    to_object: [[f32; 3]; 4],
    pub instance: u32,
    pub tree: u32,
}

impl Placed {
    fn new(id: InstanceId, instance: &Instance, tree: u32) -> Self {
        let m = instance.to_object;
        let columns = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis, m.translation];
        Self { to_object: columns.map(|c| c.to_array()), instance: id.index() as u32, tree }
    }

    /// World points in object space (m), and the bound of the error of their components, `γ₄ (|M⁻¹| |p| + |t|)`.
    #[inline(always)]
    pub fn points<R: Real>(&self, p: [R; 3]) -> ([R; 3], R) {
        let [x, y, z, t] = &self.to_object;
        let a = each!(|axis| p[axis].abs());
        let points = each!(|axis| p[0] * R::splat(x[axis])
            + p[1] * R::splat(y[axis])
            + p[2] * R::splat(z[axis])
            + R::splat(t[axis]));
        let sizes = each!(|axis| a[0] * R::splat(x[axis].abs())
            + a[1] * R::splat(y[axis].abs())
            + a[2] * R::splat(z[axis].abs())
            + R::splat(t[axis].abs()));
        (points, R::splat(GAMMA_4) * sizes[0].max(sizes[1]).max(sizes[2]))
    }

    /// World directions in object space.
    #[inline(always)]
    pub fn directions<R: Real>(&self, d: [R; 3]) -> [R; 3] {
        let [x, y, z, _] = &self.to_object;
        each!(|axis| d[0] * R::splat(x[axis]) + d[1] * R::splat(y[axis]) + d[2] * R::splat(z[axis]))
    }
}

impl Tree {
    fn build(triangles: &[Triangle]) -> Self {
        let boxes: Vec<Aabb> = triangles.par_iter().map(|t| Aabb::of_points(t.v)).collect();
        let (bvh, leaves) = Bvh::build(&boxes, LEAF_TRIANGLES);
        let block = |items: &[u32]| Block::new(items.iter().map(|&i| triangles[i as usize]));
        let blocks = leaves.iter().map(block).collect();
        Self { nodes: bvh.nodes, blocks, triangles: triangles.len() as u64 }
    }

    /// How many triangles there are.
    pub fn triangles(&self) -> u64 {
        self.triangles
    }

    /// Memory (bytes).
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self.nodes[..]) + size_of_val(&self.blocks[..])) as u64
    }
}

/// Most triangles of a leaf.
const LEAF_TRIANGLES: usize = WIDTH;

impl Trees {
    /// Builds the trees, in parallel on the current thread pool; the result does not depend on it.
    pub fn new(scene: &Scene) -> Self {
        let mut world = Vec::new();
        let mut tree_of_mesh = vec![u32::MAX; scene.meshes().len()];
        let mut shared = Vec::new();
        let mut placed = Vec::new();
        for (id, instance) in scene.instance_ids().zip(scene.instances()) {
            let flags = flags(scene, id);
            let mesh = &scene.meshes()[instance.mesh.index()];
            let count = mesh.triangles().len() as u32;
            if instance.is_baked() {
                // Rounding far from the origin may flatten what was a triangle.
                let corners = (0..count).map(|index| (index, scene.world_corners(id, index)));
                let instance = id.index() as u32;
                world.extend(corners.filter(|(_, v)| has_normal(v)).map(|(index, v)| Triangle {
                    v,
                    instance,
                    index,
                    flags,
                }));
                continue;
            }
            let tree = &mut tree_of_mesh[instance.mesh.index()];
            if *tree == u32::MAX {
                *tree = shared.len() as u32;
                shared.push((mesh, flags));
            }
            placed.push(Placed::new(id, instance, *tree));
        }
        let build = |(mesh, flags): &(&crate::scene::Mesh, u32)| {
            let count = mesh.triangles().len() as u32;
            let corners = (0..count).map(|index| (index, mesh.corners(index)));
            let of = |(index, v)| Triangle { v, instance: u32::MAX, index, flags: *flags };
            Tree::build(&corners.map(of).collect::<Vec<_>>())
        };
        let ((world, shared), (top, placed)) = rayon::join(
            || rayon::join(|| Tree::build(&world), || shared.par_iter().map(build).collect()),
            || top(scene, &placed),
        );
        Self { world, shared, top, placed }
    }
}

/// The tree over instances.
fn top(scene: &Scene, placed: &[Placed]) -> (Bvh, Vec<Placed>) {
    let instance = |p: &Placed| &scene.instances()[p.instance as usize];
    let boxes: Vec<Aabb> = placed.par_iter().map(|p| world_box(instance(p), scene)).collect();
    let (bvh, leaves) = Bvh::build(&boxes, 1);
    (bvh, leaves.iter().flatten().map(|&i| placed[i as usize]).collect())
}

fn flags(scene: &Scene, id: InstanceId) -> u32 {
    let mut flags = 0;
    if scene.may_be_transparent(id) {
        flags |= flag::TRANSPARENT;
    }
    if scene.material_of(id).has_holes() {
        flags |= flag::HOLES;
    }
    flags
}

/// World box of an instance (m): around the transformed corners of its mesh's box, grown by the rounding of the transform,
/// forth and back.
fn world_box(instance: &Instance, scene: &Scene) -> Aabb {
    let b = scene.meshes()[instance.mesh.index()].bounds();
    let grown = b.transformed(&instance.to_world);
    let m = instance.to_world;
    let columns = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis].map(|c| Vec3::from(c).abs());
    let a = b.lo.abs().max(b.hi.abs());
    let largest = columns[0] * a.x + columns[1] * a.y + columns[2] * a.z + Vec3::from(m.translation).abs();
    let margin = 4.0 * GAMMA_4 * largest.max_element();
    Aabb { lo: grown.lo - margin, hi: grown.hi + margin }
}
