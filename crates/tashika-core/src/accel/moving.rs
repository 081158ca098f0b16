//! Geometry that moves while the shutter is open.
//!
//! Moving instances have a separate tree, whose boxes hold each instance at all times
//! ([`Scene::box_of`]). A ray or segment has a single time. If it meets the box of an instance, it
//! is transformed into the instance's space at that time. Static geometry is traced first, by code
//! that ignores time. For a ray, the nearer of the two hits is returned; for a segment, the product
//! of the two transmittances.
//!
//! In the tree of a deforming mesh, boxes hold the triangles at all times. The leaves store the
//! triangles at the opening and at the closing of the shutter; a traversal that reaches a leaf
//! interpolates [between](Block::towards) the two.
//!
//! Segments are traversed one by one here, since a path has few of them.
//!
//! Held to this by `accel::tests`.

use super::Hit;
use super::bvh::Bvh;
use super::segments::{Apex, SegmentBatch};
use super::single::{Instances, Nearest, Place, Segment, Waiting, pass_placed};
use super::trees::{Met, Placed, Tree, Trees};
use super::triangle::Block;
use crate::math::Ray;
use crate::math::simd::F32x8;
use crate::scene::{InstanceId, Scene};

/// Tree over the instances that move.
#[derive(Debug)]
pub(super) struct Moving {
    /// Tree over moving instances; each leaf is one of `movers`.
    pub top: Bvh,
    /// Moving instances, in the order of the leaves of `top`.
    pub movers: Vec<Mover>,
}

/// A moving instance of a shared tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mover {
    pub instance: InstanceId,
    pub tree: u32,
}

/// Moving instances at a time, given as a share of the time that the shutter is open.
struct Moved<'a> {
    trees: &'a Trees,
    scene: &'a Scene,
    share: f32,
}

impl Instances for Moved<'_> {
    type Placed = Placed;

    fn top(&self) -> &Bvh {
        &self.trees.moving.top
    }

    fn placed(&self, leaf: u32) -> Placed {
        let Mover { instance, tree } = self.trees.moving.movers[leaf as usize];
        let moved = self.scene.moved(instance, self.share);
        let moved = moved.unwrap_or_else(|| unreachable!("an instance that moves has a motion"));
        Placed::new(instance, &moved, tree)
    }

    fn tree(&self, number: u32) -> &Tree {
        &self.trees.shared[number as usize]
    }

    #[inline(always)]
    fn deformed<'t>(&self, tree: &'t Tree) -> Option<Deformed<'t>> {
        (!tree.closing.is_empty()).then_some(Deformed { tree, share: self.share })
    }
}

/// The tree of a deforming mesh at a time, given as a share of the time that the shutter is open.
pub(super) struct Deformed<'t> {
    tree: &'t Tree,
    share: f32,
}

impl Met for Deformed<'_> {
    type Block<'b>
        = Block
    where
        Self: 'b;

    #[inline(always)]
    fn tree(&self) -> &Tree {
        self.tree
    }

    #[inline(always)]
    fn block<F: F32x8>(&self, leaf: u32) -> Block {
        let leaf = leaf as usize;
        self.tree.blocks[leaf].towards::<F>(&self.tree.closing[leaf], self.share)
    }
}

/// Closest hit along a ray at a time, given as a share of the time that the shutter is open.
/// `standing` is the closest hit on static geometry.
#[inline(always)]
pub(super) fn closest_hit<F: F32x8>(
    trees: &Trees,
    scene: &Scene,
    (ray, key): (&Ray, u64),
    share: f32,
    standing: Option<Hit>,
    waiting: &mut Waiting,
) -> Option<Hit> {
    let s = Segment::towards(ray.origin, ray.direction);
    let t_max = standing.map_or(ray.t_max, |hit| hit.t);
    let mut nearest = Nearest { t_max, hit: standing, scene, key };
    nearest.look_at_placed::<F>(&Moved { trees, scene, share }, &s, waiting);
    nearest.hit
}

/// Multiplies the visibility of each segment of a batch by the transmittance of moving geometry at
/// a time, given as a share of the time that the shutter is open.
#[inline(always)]
pub(super) fn pass_batch<F: F32x8>(
    trees: &Trees,
    scene: &Scene,
    batch: &SegmentBatch,
    share: f32,
    visibility: &mut [f32],
    waiting: &mut Waiting,
) {
    let moved = Moved { trees, scene, share };
    let place = Place { scene, glass: batch.glass, instance: None, share };
    for fan in batch.fans() {
        let of_fan = fan.targets.start as usize..fan.targets.end as usize;
        for (visible, &target) in visibility[of_fan.clone()].iter_mut().zip(&batch.targets()[of_fan]) {
            if *visible <= 0.0 {
                continue;
            }
            *visible = match fan.apex {
                Apex::Point(apex) => {
                    let s = Segment::between(apex, target);
                    pass_placed::<F, true>(&moved, 0, &s, *visible, &place, waiting)
                }
                Apex::Direction(direction) => {
                    let s = Segment::towards(target, direction);
                    pass_placed::<F, false>(&moved, 0, &s, *visible, &place, waiting)
                }
            };
        }
    }
}
