//! Trees of a scene: one over geometry that is placed once, one over static instances,
//! [one](super::moving) over moving instances, and one for each mesh with instances.

use std::borrow::Borrow;

use rayon::prelude::*;

use super::bvh::{Bvh, Node};
use super::moving::{Mover, Moving};
use super::split::Item;
use super::triangle::{Block, Triangle, flag};
use crate::math::simd::{F32x8, WIDTH, each};
use crate::math::{Aabb, Real};
use crate::scene::{Instance, InstanceId, Mesh, Scene, box_between, has_normal};

/// All trees of a scene.
#[derive(Debug)]
pub(super) struct Trees {
    /// Geometry that is placed once, in world space.
    pub world: Tree,
    /// Trees of meshes that are placed more than once or that move.
    pub shared: Vec<Tree>,
    /// Tree over static instances; each leaf is one of `placed`.
    pub top: Bvh,
    /// Static instances, in the order of the leaves of `top`.
    pub placed: Vec<Placed>,
    /// Moving instances and the tree over them.
    pub moving: Moving,
}

/// A tree over triangles: each leaf is one of `blocks`.
#[derive(Debug)]
pub(super) struct Tree {
    pub nodes: Vec<Node>,
    /// Triangles of the leaves; for a deforming mesh, at the opening of the shutter.
    pub blocks: Vec<Block>,
    /// Triangles of the leaves at the closing of the shutter; empty if the mesh does not deform.
    pub closing: Vec<Block>,
    triangles: u64,
}

/// An instance of a shared tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    /// Map from world to object space: three columns and the translation.
    to_object: [[f32; 3]; 4],
    pub instance: u32,
    pub tree: u32,
}

impl Placed {
    pub fn new(id: InstanceId, instance: &Instance, tree: u32) -> Self {
        let m = instance.to_object();
        let columns = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis, m.translation];
        Self { to_object: columns.map(|c| c.to_array()), instance: id.index() as u32, tree }
    }

    /// Transforms points from world to object space (m).
    #[inline(always)]
    pub fn points<R: Real>(&self, p: [R; 3]) -> [R; 3] {
        let [x, y, z, t] = &self.to_object;
        each!(|axis| p[0] * R::splat(x[axis])
            + p[1] * R::splat(y[axis])
            + p[2] * R::splat(z[axis])
            + R::splat(t[axis]))
    }

    /// Transforms directions from world to object space.
    #[inline(always)]
    pub fn directions<R: Real>(&self, d: [R; 3]) -> [R; 3] {
        let [x, y, z, _] = &self.to_object;
        each!(|axis| d[0] * R::splat(x[axis]) + d[1] * R::splat(y[axis]) + d[2] * R::splat(z[axis]))
    }
}

impl Tree {
    /// Builds a tree over items; `triangle` returns the triangle that belongs to the numbers of an
    /// item.
    fn build(items: Vec<Item>, triangle: impl Fn([u32; 2]) -> Triangle + Sync) -> Self {
        let sorted = Sorted::new(items);
        let blocks = sorted.blocks(triangle);
        Self { nodes: sorted.nodes, blocks, closing: Vec::new(), triangles: sorted.numbers.len() as u64 }
    }

    /// Builds a tree over items whose boxes hold their triangles at all times. `triangle` returns
    /// the triangle that belongs to the numbers of an item, at a time given as a share of the time
    /// that the shutter is open.
    fn build_deforming(items: Vec<Item>, triangle: impl Fn(f32, [u32; 2]) -> Triangle + Sync) -> Self {
        let sorted = Sorted::new(items);
        let [blocks, closing] = [0.0, 1.0].map(|share| sorted.blocks(|numbers| triangle(share, numbers)));
        Self { nodes: sorted.nodes, blocks, closing, triangles: sorted.numbers.len() as u64 }
    }

    /// Number of triangles in all leaves.
    pub fn triangles(&self) -> u64 {
        self.triangles
    }

    /// Memory of nodes and triangles (bytes).
    pub fn bytes(&self) -> u64 {
        let blocks = size_of_val(&self.blocks[..]) + size_of_val(&self.closing[..]);
        (size_of_val(&self.nodes[..]) + blocks) as u64
    }
}

/// Nodes and leaves of a tree, and the numbers of its items in the order of the leaves.
struct Sorted {
    nodes: Vec<Node>,
    /// First item and number of items of each leaf.
    leaves: Vec<(u32, u32)>,
    /// Numbers of the items, in the order of the leaves.
    numbers: Vec<[u32; 2]>,
}

impl Sorted {
    fn new(mut items: Vec<Item>) -> Self {
        let Bvh { nodes, leaves } = Bvh::build(&mut items, LEAF_TRIANGLES);
        // Items are reduced to their numbers: boxes and blocks would otherwise be in memory
        // together.
        let numbers = items.par_iter().map(Item::numbers).collect();
        Self { nodes, leaves, numbers }
    }

    fn blocks(&self, triangle: impl Fn([u32; 2]) -> Triangle + Sync) -> Vec<Block> {
        let block = |&(first, count): &(u32, u32)| {
            let numbers = &self.numbers[first as usize..][..count as usize];
            Block::new(numbers.iter().map(|&numbers| triangle(numbers)))
        };
        self.leaves.par_iter().map(block).collect()
    }
}

/// A tree whose triangles are accessed leaf by leaf.
pub(super) trait Met {
    type Block<'b>: Borrow<Block>
    where
        Self: 'b;

    fn tree(&self) -> &Tree;

    /// The triangles of a leaf.
    fn block<F: F32x8>(&self, leaf: u32) -> Self::Block<'_>;
}

impl Met for Tree {
    type Block<'b> = &'b Block;

    #[inline(always)]
    fn tree(&self) -> &Tree {
        self
    }

    #[inline(always)]
    fn block<F: F32x8>(&self, leaf: u32) -> &Block {
        &self.blocks[leaf as usize]
    }
}

/// Maximum number of triangles in a leaf.
const LEAF_TRIANGLES: usize = WIDTH;

impl Trees {
    /// Builds the trees, in parallel on the current thread pool; the result does not depend on the
    /// pool.
    pub fn new(scene: &Scene) -> Self {
        let mut baked = Vec::new();
        let mut baked_triangles = 0;
        let mut tree_of_mesh = vec![u32::MAX; scene.meshes().len()];
        let mut shared = Vec::new();
        let (mut placed, mut moving) = (Vec::new(), Vec::new());
        let flags: Vec<u32> = scene.instance_ids().map(|id| flags(scene, id)).collect();
        for (id, instance) in scene.instance_ids().zip(scene.instances()) {
            let mesh = &scene.meshes()[instance.mesh.index()];
            if instance.is_baked() {
                baked.push((baked_triangles, id));
                baked_triangles += mesh.triangles().len();
                continue;
            }
            let tree = &mut tree_of_mesh[instance.mesh.index()];
            if *tree == u32::MAX {
                *tree = shared.len() as u32;
                shared.push((mesh, flags[id.index()]));
            }
            match scene.motion_of(id) {
                None => placed.push(Placed::new(id, instance, *tree)),
                Some(_) => moving.push(Mover { instance: id, tree: *tree }),
            }
        }
        let world = || {
            let item = |k: usize| {
                let (first, id) = baked[baked.partition_point(|(first, _)| *first <= k) - 1];
                let index = (k - first) as u32;
                let v = scene.world_corners(id, index);
                // Rounding far from the origin may flatten a triangle.
                let b = if has_normal(&v) { Aabb::of_points(v) } else { Aabb::EMPTY };
                Item::new(&b, [id.index() as u32, index])
            };
            let mut items: Vec<Item> = (0..baked_triangles).into_par_iter().map(item).collect();
            items.retain(|item| !item.is_empty());
            Tree::build(items, |[instance, index]| Triangle {
                v: scene.world_corners(InstanceId::at(instance), index),
                instance,
                index,
                flags: flags[instance as usize],
            })
        };
        let build = |(mesh, flags): &(&Mesh, u32)| {
            let number = 0..mesh.triangles().len() as u32;
            let triangle = |v, [instance, index]: [u32; 2]| Triangle { v, instance, index, flags: *flags };
            if mesh.deforms().is_some() {
                let around = |share, index| Aabb::of_points(mesh.corners_at(share, index));
                let item =
                    |index| Item::new(&box_between(around(0.0, index), around(1.0, index)), [0, index]);
                let items = number.into_par_iter().map(item).collect();
                return Tree::build_deforming(items, |share, numbers| {
                    triangle(mesh.corners_at(share, numbers[1]), numbers)
                });
            }
            let item = |index| Item::new(&Aabb::of_points(mesh.corners(index)), [0, index]);
            let items = number.into_par_iter().map(item).collect();
            Tree::build(items, |numbers| triangle(mesh.corners(numbers[1]), numbers))
        };
        let of_moving = |mover: &Mover| scene.box_of(&scene.instances()[mover.instance.index()]);
        let of_placed = |p: &Placed| world_box(&scene.instances()[p.instance as usize], scene);
        let ((world, shared), (top, placed)) = rayon::join(
            || rayon::join(world, || shared.par_iter().map(build).collect()),
            || over(&placed, of_placed),
        );
        let (over_moving, moving) = over(&moving, of_moving);
        Self { world, shared, top, placed, moving: Moving { top: over_moving, movers: moving } }
    }
}

/// Builds a tree over instances; returns it with the instances in the order of its leaves.
fn over<T: Copy + Sync>(instances: &[T], world_box: impl Fn(&T) -> Aabb + Sync) -> (Bvh, Vec<T>) {
    let item = |(number, instance): (usize, &T)| Item::new(&world_box(instance), [number as u32; 2]);
    let mut items: Vec<Item> = instances.par_iter().enumerate().map(item).collect();
    let bvh = Bvh::build(&mut items, 1);
    let sorted = bvh.leaves.iter().map(|&(first, _)| instances[items[first as usize].numbers()[0] as usize]);
    let sorted = sorted.collect();
    (bvh, sorted)
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

/// World box of an instance (m): the box around the transformed corners of its mesh's box, grown by
/// the rounding errors of the transform and of its inverse.
fn world_box(instance: &Instance, scene: &Scene) -> Aabb {
    let b = scene.meshes()[instance.mesh.index()].bounds();
    let grown = b.transformed(&instance.to_world);
    let margin = 2.0 * instance.rounding(b.lo.abs().max(b.hi.abs()));
    Aabb { lo: grown.lo - margin, hi: grown.hi + margin }
}
