//! What moves while the shutter is open.
//!
//! Instances that move have a tree of their own, over boxes that hold each of them at all times
//! ([`Scene::box_of`]). A ray or a segment has one time, and enters an instance whose box it meets by the
//! transform of that time. What stands is walked through before, by code that knows no time: of what
//! a ray meets, the nearer of both counts; of what a segment passes, the product.
//!
//! The tree of a mesh that deforms has boxes that hold its triangles at all times, and leaves with
//! those of both ends of the time: where a walk comes to a leaf, its triangles are put
//! [between](Block::towards).
//!
//! Segments walk alone here: those of a path are few.
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

/// The tree over what moves.
#[derive(Debug)]
pub(super) struct Moving {
    /// Each leaf is one of `movers`.
    pub top: Bvh,
    /// In the order of the leaves of `top`.
    pub movers: Vec<Mover>,
}

/// An instance of a shared tree that moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mover {
    pub instance: InstanceId,
    pub tree: u32,
}

/// Those that move, after a share of the time that the shutter is open.
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

/// The tree of a mesh that deforms, after a share of the time.
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

/// The first surface along a ray after a share of the time, `standing` being the first of those that
/// stand.
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

/// Multiplies what is visible along each segment of a batch by what passes that which moves, after
/// a share of the time.
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
