//! The tracer of a scene: one tree over what is placed once, and one a shared mesh below a tree of instances.

use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use super::bvh::{Bvh, INNER, WIDTH};
use super::closest::{TreeHit, closest_hit};
use super::kernel::{self, Beam, Bundle, LANES, Walk};
use super::segments::{Apex, Glass, SegmentBatch};
use super::triangle::{Triangle, flag};
use crate::math::{Aabb, GAMMA_4, Ray};
use crate::rng::{self, Purpose};
use crate::scene::{Instance, InstanceId, Scene, has_normal};

/// A surface met by a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter.
    pub t: f32,
    /// What was met.
    pub instance: InstanceId,
    /// Its triangle.
    pub triangle: u32,
    /// Barycentric weights of the triangle's corners, summing to 1.
    pub barycentric: [f32; 3],
}

/// What the tracer holds in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TracerSize {
    /// Triangles, counted once a tree that holds them.
    pub triangles: u64,
    /// Trees of shared meshes.
    pub shared_trees: u64,
    /// Bytes of nodes and triangles.
    pub bytes: u64,
}

/// Answers where rays and segments meet a scene.
#[derive(Debug)]
pub struct Tracer {
    scene: Arc<Scene>,
    world: Tree,
    /// Trees of meshes that are placed more than once.
    shared: Vec<Tree>,
    /// Leaves hold positions in `placed`.
    top: Bvh,
    placed: Vec<Placed>,
}

#[derive(Debug)]
struct Tree {
    bvh: Bvh,
    triangles: Vec<Triangle>,
}

/// An instance of a shared tree.
#[derive(Debug)]
struct Placed {
    instance: u32,
    tree: u32,
}

/// Lanes that enter an instance.
struct Entry<'a> {
    placed: &'a Placed,
    lanes: u32,
    glass: Glass,
}

impl Tree {
    fn build(triangles: Vec<Triangle>) -> Self {
        let boxes: Vec<Aabb> = triangles.par_iter().map(|t| Aabb::of_points(t.v)).collect();
        let (bvh, order) = Bvh::build(&boxes);
        Self { bvh, triangles: order.iter().map(|&i| triangles[i as usize]).collect() }
    }

    /// Multiplies what is visible along each active lane by what passes through this tree.
    fn walk<'a, const N: usize>(
        &'a self,
        apex: Apex,
        bundle: &'a mut Bundle<N>,
        visible: &'a mut [f32; N],
        opacity: kernel::Opacity<'a>,
    ) where
        Walk<'a, N>: Go,
    {
        let walk = Walk { nodes: &self.bvh.nodes, triangles: &self.triangles, bundle, visible, opacity };
        match apex {
            Apex::Point(_) => walk.go_from_point(),
            Apex::Direction(_) => walk.go_to_infinity(),
        }
    }
}

impl Tracer {
    /// Builds the trees of `scene`, in parallel on the current thread pool; the result does not depend on it.
    pub fn new(scene: Arc<Scene>) -> Self {
        let mut world = Vec::new();
        let mut tree_of_mesh = vec![u32::MAX; scene.meshes().len()];
        let mut shared = Vec::new();
        let mut placed = Vec::new();
        for (number, instance) in scene.instances().iter().enumerate() {
            let id = InstanceId(number as u32);
            let mesh = instance.mesh.index();
            let material = scene.material_of(id);
            let mut flags = 0;
            if scene.may_be_transparent(id) {
                flags |= flag::TRANSPARENT;
            }
            if material.has_holes() {
                flags |= flag::HOLES;
            }
            let count = scene.meshes()[mesh].triangles().len() as u32;
            if instance.is_baked() {
                // Rounding far from the origin may flatten what was a triangle.
                let corners = (0..count).map(|index| (index, scene.world_corners(id, index)));
                world.extend(corners.filter(|(_, v)| has_normal(v)).map(|(index, v)| Triangle {
                    v,
                    instance: id.0,
                    index,
                    flags,
                }));
                continue;
            }
            if tree_of_mesh[mesh] == u32::MAX {
                tree_of_mesh[mesh] = shared.len() as u32;
                let m = &scene.meshes()[mesh];
                let triangles = (0..count)
                    .map(|index| Triangle { v: m.corners(index), instance: u32::MAX, index, flags })
                    .collect();
                shared.push(Tree::build(triangles));
            }
            placed.push(Placed { instance: id.0, tree: tree_of_mesh[mesh] });
        }
        let boxes: Vec<Aabb> =
            placed.par_iter().map(|p| world_box(&scene.instances()[p.instance as usize], &scene)).collect();
        let (top, order) = Bvh::build(&boxes);
        let placed = order.iter().map(|&i| Placed { ..placed[i as usize] }).collect();
        Self { world: Tree::build(world), scene, shared, top, placed }
    }

    /// The scene that is traced.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// What is held in memory.
    pub fn size(&self) -> TracerSize {
        let trees = || self.shared.iter().chain([&self.world]);
        let bytes = |t: &Tree| size_of_val(&t.bvh.nodes[..]) + size_of_val(&t.triangles[..]);
        TracerSize {
            triangles: trees().map(|t| t.triangles.len() as u64).sum(),
            shared_trees: self.shared.len() as u64,
            bytes: trees().map(|t| bytes(t) as u64).sum::<u64>() + size_of_val(&self.top.nodes[..]) as u64,
        }
    }

    /// The first surface along `ray`.
    ///
    /// A surface of opacity `o < 1` is met with probability `o`; the decision is a function of `key`, the instance and
    /// the triangle alone, so equal keys see the same holes.
    pub fn closest_hit(&self, ray: &Ray, key: u64) -> Option<Hit> {
        let mut ray = *ray;
        let mut best: Option<Hit> = None;
        let hit_of = |h: TreeHit, instance: u32, t: &Triangle| Hit {
            t: h.t,
            instance: InstanceId(instance),
            triangle: t.index,
            barycentric: h.barycentric,
        };
        let tree = &self.world;
        let accept = |t: &Triangle, b| self.stops(t, t.instance, b, key);
        if let Some(h) = closest_hit(&tree.bvh.nodes, &tree.triangles, ray, 0.0, accept) {
            ray.t_max = h.t;
            let t = &tree.triangles[h.slot as usize];
            best = Some(hit_of(h, t.instance, t));
        }
        self.for_placed(&ray, &mut |number, t_max| {
            let p = &self.placed[number];
            let instance = &self.scene.instances()[p.instance as usize];
            let (origin, error) = to_object(instance, ray.origin);
            let direction = instance.to_object.transform_vector3(ray.direction);
            let local = Ray { origin, direction, t_max };
            let tree = &self.shared[p.tree as usize];
            let accept = |t: &Triangle, b| self.stops(t, p.instance, b, key);
            let hit = closest_hit(&tree.bvh.nodes, &tree.triangles, local, error, accept)?;
            best = Some(hit_of(hit, p.instance, &tree.triangles[hit.slot as usize]));
            Some(hit.t)
        });
        best
    }

    /// Whether a surface that a ray with `key` meets is there for it.
    fn stops(&self, t: &Triangle, instance: u32, b: [f32; 3], key: u64) -> bool {
        if t.flags & flag::HOLES == 0 {
            return true;
        }
        let opacity = self.scene.opacity(InstanceId(instance), t.index, b);
        let place = u64::from(instance) << 32 | u64::from(t.index);
        let u = (rng::key(key, Purpose::Opacity, place) >> 40) as f32 * (1.0 / (1 << 24) as f32);
        u < opacity
    }

    /// Calls `visit(position in placed, t_max)` for instances that the ray may meet; it returns a smaller `t_max`.
    fn for_placed(&self, ray: &Ray, visit: &mut dyn FnMut(usize, f32) -> Option<f32>) {
        if self.placed.is_empty() {
            return;
        }
        let mut beam = Beam::of_ray(ray.origin.to_array(), ray.direction.to_array(), ray.t_max, 0.0);
        let mut t_max = ray.t_max;
        let mut entry = [0.0; WIDTH];
        let mut waiting = vec![0u32];
        while let Some(number) = waiting.pop() {
            let node = &self.top.nodes[number as usize];
            let met = beam.meets_children(node, &mut entry);
            for slot in (0..WIDTH).filter(|slot| met & 1 << slot != 0) {
                let first = node.first[slot];
                if node.count[slot] == INNER {
                    waiting.push(first);
                    continue;
                }
                for item in first..first + node.count[slot] {
                    if let Some(nearer) = visit(item as usize, t_max) {
                        t_max = nearer;
                        beam.set_t_max(t_max);
                    }
                }
            }
        }
    }

    /// The share of light that passes along each segment of `batch`, in order: 0 blocked, 1 free, between where
    /// surfaces are partly transparent. `visibility` is overwritten.
    pub fn visibility(&self, batch: &SegmentBatch, visibility: &mut Vec<f32>) {
        visibility.clear();
        visibility.reserve(batch.len());
        for fan in batch.fans() {
            let targets = &batch.targets()[fan.targets.start as usize..fan.targets.end as usize];
            for group in targets.chunks(LANES) {
                if let [target] = group {
                    visibility.push(self.visible::<1>(fan.apex, &[*target], batch.glass)[0]);
                } else {
                    let v = self.visible::<LANES>(fan.apex, group, batch.glass);
                    visibility.extend_from_slice(&v[..group.len()]);
                }
            }
        }
    }

    fn visible<const N: usize>(&self, apex: Apex, targets: &[Vec3], glass: Glass) -> [f32; N]
    where
        for<'a> Walk<'a, N>: Go,
    {
        let mut visible = [1.0; N];
        let mut bundle = match apex {
            Apex::Point(p) => Bundle::from_point(p, targets, [0.0; N]),
            Apex::Direction(d) => Bundle::to_infinity(d, targets, [0.0; N]),
        };
        let opacity = |instance: u32, triangle: u32, b, d: [f32; 3]| {
            self.scene.stopped(InstanceId(instance), triangle, b, d.into(), glass == Glass::Passes)
        };
        self.world.walk(apex, &mut bundle, &mut visible, &opacity);
        if self.placed.is_empty() || bundle.active == 0 {
            return visible;
        }
        let mut entry = [0.0; WIDTH];
        for (beam, lanes) in bundle.beams() {
            let mut waiting = vec![0u32];
            while let Some(number) = waiting.pop() {
                let node = &self.top.nodes[number as usize];
                let met = beam.meets_children(node, &mut entry);
                for slot in (0..WIDTH).rev().filter(|slot| met & 1 << slot != 0) {
                    let first = node.first[slot];
                    if node.count[slot] == INNER {
                        waiting.push(first);
                        continue;
                    }
                    for p in &self.placed[first as usize..(first + node.count[slot]) as usize] {
                        let own = kernel::meets_box::<N, false>(&bundle, node, slot);
                        let entered = lanes & bundle.active & own;
                        if entered != 0 {
                            let placed = Entry { placed: p, lanes: entered, glass };
                            self.pass_placed(apex, targets, &placed, &mut bundle, &mut visible);
                        }
                    }
                }
            }
        }
        visible
    }

    /// What one instance lets pass of some lanes.
    fn pass_placed<const N: usize>(
        &self,
        apex: Apex,
        targets: &[Vec3],
        entry: &Entry<'_>,
        bundle: &mut Bundle<N>,
        visible: &mut [f32; N],
    ) where
        for<'a> Walk<'a, N>: Go,
    {
        let Entry { placed: p, lanes, glass } = *entry;
        let instance = &self.scene.instances()[p.instance as usize];
        let mut local = [Vec3::ZERO; N];
        let mut error = [0.0f32; N];
        for ((l, error), t) in local.iter_mut().zip(&mut error).zip(targets) {
            (*l, *error) = to_object(instance, *t);
        }
        let local = &local[..targets.len()];
        let mut inside = match apex {
            Apex::Point(a) => {
                let (q, e) = to_object(instance, a);
                Bundle::from_point(q, local, error.map(|own| own.max(e)))
            }
            Apex::Direction(d) => Bundle::to_infinity(instance.to_object.transform_vector3(d), local, error),
        };
        inside.active = lanes;
        let opacity = |_, triangle: u32, b, d: [f32; 3]| {
            let direction = instance.to_world.transform_vector3(d.into());
            self.scene.stopped(InstanceId(p.instance), triangle, b, direction, glass == Glass::Passes)
        };
        self.shared[p.tree as usize].walk(apex, &mut inside, visible, &opacity);
        bundle.active &= !(lanes & !inside.active);
    }
}

/// The walks for each number of lanes.
trait Go {
    fn go_from_point(self);
    fn go_to_infinity(self);
}

impl Go for Walk<'_, LANES> {
    fn go_from_point(self) {
        kernel::walk_from_point(self);
    }

    fn go_to_infinity(self) {
        kernel::walk_to_infinity(self);
    }
}

impl Go for Walk<'_, 1> {
    fn go_from_point(self) {
        kernel::walk_one_from_point(self);
    }

    fn go_to_infinity(self) {
        kernel::walk_one_to_infinity(self);
    }
}

/// A world point in object space (m), and the bound of the error of its components, `γ₄ (|M⁻¹| |p| + |t|)`.
fn to_object(instance: &Instance, p: Vec3) -> (Vec3, f32) {
    let m = instance.to_object;
    let columns = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis].map(|c| Vec3::from(c).abs());
    let a = p.abs();
    let largest = columns[0] * a.x + columns[1] * a.y + columns[2] * a.z + Vec3::from(m.translation).abs();
    (m.transform_point3(p), GAMMA_4 * largest.max_element())
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
