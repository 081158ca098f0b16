//! Dispatch of each query to code for the machine's instruction set.

use std::cell::RefCell;

use super::Hit;
use super::moving;
use super::occluders::Occluders;
use super::packet::{self, FEW, LANES};
use super::segments::{Apex, SegmentBatch};
use super::single::{self, Segment, Waiting};
use super::trees::Trees;
use crate::math::simd::{Level, Vectors, Work};
use crate::math::{Ray, Vec3};
use crate::scene::Scene;

thread_local! {
    static WAITING: RefCell<Waiting> = RefCell::new(Waiting::new(Some(Occluders::new())));
}

/// Appends the transmittance of static geometry along each segment of `batch` to `visibility`.
pub(super) fn visibility(
    level: Level,
    trees: &Trees,
    scene: &Scene,
    batch: &SegmentBatch,
    visibility: &mut Vec<f32>,
) {
    WAITING.with_borrow_mut(|waiting| level.run(Visibility { trees, scene, batch, waiting, visibility }));
}

/// Scalar counterpart of [`visibility`], without vector instructions and without remembered
/// occluders.
pub(super) fn plain_visibility(
    trees: &Trees,
    scene: &Scene,
    batch: &SegmentBatch,
    visibility: &mut Vec<f32>,
) {
    let waiting = &mut Waiting::new(None);
    Level::PORTABLE.run(Visibility { trees, scene, batch, waiting, visibility });
}

/// Closest hit on static geometry along a ray.
pub(super) fn closest_hit(level: Level, trees: &Trees, scene: &Scene, ray: &Ray, key: u64) -> Option<Hit> {
    WAITING.with_borrow_mut(|waiting| level.run(ClosestHit { trees, scene, ray, key, waiting }))
}

/// Closest hit along a ray at a time, given as a share of the time that the shutter is open.
/// `standing` is the closest hit on static geometry.
pub(super) fn closest_moving_hit(
    level: Level,
    trees: &Trees,
    scene: &Scene,
    (ray, key): (&Ray, u64),
    share: f32,
    standing: Option<Hit>,
) -> Option<Hit> {
    WAITING.with_borrow_mut(|waiting| {
        level.run(ClosestMovingHit { trees, scene, ray, key, share, standing, waiting })
    })
}

/// Multiplies the visibility of each segment of `batch` by the transmittance of moving geometry, at
/// a time given as a share of the time that the shutter is open.
pub(super) fn pass_moving(
    level: Level,
    trees: &Trees,
    scene: &Scene,
    batch: &SegmentBatch,
    share: f32,
    visibility: &mut [f32],
) {
    WAITING
        .with_borrow_mut(|waiting| level.run(PassMoving { trees, scene, batch, share, waiting, visibility }));
}

struct ClosestMovingHit<'a> {
    trees: &'a Trees,
    scene: &'a Scene,
    ray: &'a Ray,
    key: u64,
    share: f32,
    standing: Option<Hit>,
    waiting: &'a mut Waiting,
}

impl Work for ClosestMovingHit<'_> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn run<V: Vectors>(self) -> Option<Hit> {
        let Self { trees, scene, ray, key, share, standing, waiting } = self;
        moving::closest_hit::<V::Eight>(trees, scene, (ray, key), share, standing, waiting)
    }
}

struct PassMoving<'a> {
    trees: &'a Trees,
    scene: &'a Scene,
    batch: &'a SegmentBatch,
    share: f32,
    waiting: &'a mut Waiting,
    visibility: &'a mut [f32],
}

impl Work for PassMoving<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vectors>(self) {
        let Self { trees, scene, batch, share, waiting, visibility } = self;
        moving::pass_batch::<V::Eight>(trees, scene, batch, share, visibility, waiting);
    }
}

struct Visibility<'a> {
    trees: &'a Trees,
    scene: &'a Scene,
    batch: &'a SegmentBatch,
    waiting: &'a mut Waiting,
    visibility: &'a mut Vec<f32>,
}

impl Work for Visibility<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vectors>(self) {
        let Self { trees, scene, batch, waiting, visibility } = self;
        trace::<V>(trees, scene, batch, waiting, visibility);
    }
}

struct ClosestHit<'a> {
    trees: &'a Trees,
    scene: &'a Scene,
    ray: &'a Ray,
    key: u64,
    waiting: &'a mut Waiting,
}

impl Work for ClosestHit<'_> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn run<V: Vectors>(self) -> Option<Hit> {
        let Self { trees, scene, ray, key, waiting } = self;
        single::closest_hit::<V::Eight>(trees, scene, ray, key, waiting)
    }
}

/// Traces all fans of a batch: in packets of up to [`LANES`] segments, or one by one in packets of
/// at most [`FEW`].
#[inline(always)]
fn trace<V: Vectors>(
    trees: &Trees,
    scene: &Scene,
    batch: &SegmentBatch,
    waiting: &mut Waiting,
    visibility: &mut Vec<f32>,
) {
    for fan in batch.fans() {
        let targets = &batch.targets()[fan.targets.start as usize..fan.targets.end as usize];
        match fan.apex {
            Apex::Point(apex) => {
                let segment = |target: Vec3| Segment::between(apex, target);
                trace_fan::<V, true>(trees, scene, batch, targets, segment, waiting, visibility);
            }
            Apex::Direction(direction) => {
                let segment = |target: Vec3| Segment::towards(target, direction);
                trace_fan::<V, false>(trees, scene, batch, targets, segment, waiting, visibility);
            }
        }
    }
}

#[inline(always)]
fn trace_fan<V: Vectors, const BOUNDED: bool>(
    trees: &Trees,
    scene: &Scene,
    batch: &SegmentBatch,
    targets: &[Vec3],
    segment: impl Fn(Vec3) -> Segment,
    waiting: &mut Waiting,
    visibility: &mut Vec<f32>,
) {
    for group in targets.chunks(LANES) {
        if group.len() <= FEW as usize {
            for &target in group {
                let s = segment(target);
                visibility.push(single::visible::<V::Eight, BOUNDED>(trees, scene, batch.glass, &s, waiting));
            }
            continue;
        }
        let mut segments = [segment(group[0]); LANES];
        for (s, &target) in segments.iter_mut().zip(group) {
            *s = segment(target);
        }
        let segments = &segments[..group.len()];
        let v = packet::visible::<V, BOUNDED>(trees, scene, batch.glass, segments, waiting);
        visibility.extend_from_slice(&v[..group.len()]);
    }
}
