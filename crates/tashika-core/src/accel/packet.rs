//! Visibility of up to [`LANES`] segments at once, by one traversal of the trees.
//!
//! Inner nodes are tested for the whole group: intervals around the origins and reciprocal
//! directions of the segments bound the parameters at which any segment can be inside a box, for
//! the eight children of a node at once. The boxes that pass, and triangles, are tested lane by
//! lane. When at most [`FEW`] lanes are left, each is traversed alone. Segments whose directions
//! differ in sign have no useful intervals and are traversed alone from the start.
//!
//! However a lane is traversed, it is tested against the triangles of exactly those leaves whose
//! boxes it meets itself, in the order of the tree
//! (`accel::tests::grouping_does_not_change_a_bit`).

use glam::Vec3;

use super::beam::{Beam, limit, meet_child, reciprocal, reciprocals};
use super::bvh::Node;
use super::occluders::Leaf;
use super::segments::Glass;
use super::single::{self, Place, Segment, Standing, Waiting};
use super::trees::{Placed, Tree, Trees};
use super::triangle::{Lines, Met, Planes, blocked};
use crate::math::Real;
use crate::math::simd::{F32x16, Vector, Vectors, WIDTH, each, for_bits};
use crate::scene::Scene;

/// Maximum number of segments in a packet.
pub(super) const LANES: usize = 2 * WIDTH;

/// Number of lanes up to which each lane is traversed alone.
pub(super) const FEW: u32 = 3;

/// One number for each lane.
type Lanes = [f32; LANES];

/// Segments that are traversed together, in the space of one tree.
#[repr(C, align(64))]
pub(super) struct Packet {
    origin: [Lanes; 3],
    direction: [Lanes; 3],
    reciprocal: [Lanes; 3],
    target: [Lanes; 3],
}

impl Packet {
    /// Creates a packet of at most [`LANES`] segments.
    #[inline(always)]
    fn new(segments: &[Segment]) -> Self {
        let none = [[0.0; LANES]; 3];
        let mut packet = Self { origin: none, direction: none, reciprocal: none, target: none };
        for (lane, s) in segments.iter().enumerate() {
            for axis in 0..3 {
                packet.origin[axis][lane] = s.origin[axis];
                packet.direction[axis][lane] = s.direction[axis];
                packet.reciprocal[axis][lane] = reciprocal(s.direction[axis]);
                packet.target[axis][lane] = s.target[axis];
            }
        }
        packet
    }

    /// Transforms the segments into the space of an instance.
    #[inline(always)]
    fn in_space_of<F: F32x16, const BOUNDED: bool>(&self, placed: &Placed) -> Self {
        let origin = placed.points(each!(|axis| F::load(&self.origin[axis])));
        let (target, direction) = if BOUNDED {
            let target = placed.points(each!(|axis| F::load(&self.target[axis])));
            (target, each!(|axis| target[axis] - origin[axis]))
        } else {
            (origin, placed.directions(each!(|axis| F::load(&self.direction[axis]))))
        };
        Self {
            origin: each!(|axis| origin[axis].array()),
            direction: each!(|axis| direction[axis].array()),
            reciprocal: each!(|axis| reciprocals(direction[axis]).array()),
            target: each!(|axis| target[axis].array()),
        }
    }

    /// Returns the segment of one lane.
    #[inline(always)]
    fn segment(&self, lane: usize) -> Segment {
        let vector = |v: &[Lanes; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
        Segment {
            origin: vector(&self.origin),
            direction: vector(&self.direction),
            target: vector(&self.target),
        }
    }

    #[inline(always)]
    fn lines<F: F32x16>(&self) -> Lines<F> {
        Lines {
            origin: each!(|axis| F::load(&self.origin[axis])),
            direction: each!(|axis| F::load(&self.direction[axis])),
            target: each!(|axis| F::load(&self.target[axis])),
        }
    }

    /// Returns the beam around the given lanes; `None` if their directions differ in sign.
    #[inline(always)]
    fn beam<V: Vectors>(&self, lanes: u32) -> Option<Beam<V::Eight>> {
        let own = V::Sixteen::mask(lanes);
        let origins = each!(|axis| hull::<V::Sixteen>(&self.origin[axis], own));
        let reciprocals = each!(|axis| hull::<V::Sixteen>(&self.reciprocal[axis], own));
        Beam::new(origins, reciprocals)
    }

    /// Returns the lanes that meet the box of a child.
    #[inline(always)]
    fn meets_child<F: F32x16>(&self, limit: f32, node: &Node, slot: usize, lanes: u32) -> u32 {
        let r = each!(|axis| F::load(&self.reciprocal[axis]));
        meet_child::<F>(&self.lines(), &r, limit, node, slot) & lanes
    }

    /// Returns the lanes that a triangle blocks.
    #[inline(always)]
    fn blocked<F: F32x16, const BOUNDED: bool>(&self, planes: &Planes<F>) -> Met {
        blocked::<F, BOUNDED>(planes, &self.lines())
    }
}

/// Returns the least and largest of the values of the lanes in `own`.
#[inline(always)]
fn hull<F: F32x16>(values: &Lanes, own: F::Mask) -> [f32; 2] {
    let values = F::load(values);
    let low = F::select(own, values, F::splat(f32::INFINITY)).array();
    let high = F::select(own, values, F::splat(f32::NEG_INFINITY)).array();
    let mut interval = [low[0], high[0]];
    for i in 1..LANES {
        interval = [Real::min(interval[0], low[i]), Real::max(interval[1], high[i])];
    }
    interval
}

/// Transmittance of static geometry along each of at most [`LANES`] segments.
#[inline(always)]
pub(super) fn visible<V: Vectors, const BOUNDED: bool>(
    trees: &Trees,
    scene: &Scene,
    glass: Glass,
    segments: &[Segment],
    waiting: &mut Waiting,
) -> [f32; LANES] {
    let mut visible = [1.0; LANES];
    let place = Place { scene, glass, instance: None, share: 0.0 };
    let packet = Packet::new(segments);
    let all = ((1u64 << segments.len()) - 1) as u32;
    let left = pass::<V, BOUNDED>(&trees.world, &packet, all, &mut visible, &place, waiting);
    if left != 0 && !trees.placed.is_empty() {
        pass_placed::<V, BOUNDED>(trees, &packet, left, &mut visible, &place, waiting);
    }
    visible
}

/// Multiplies `visible` by the transmittance of static instances.
#[inline(always)]
fn pass_placed<V: Vectors, const BOUNDED: bool>(
    trees: &Trees,
    packet: &Packet,
    mut active: u32,
    visible: &mut [f32; LANES],
    place: &Place<'_>,
    waiting: &mut Waiting,
) {
    let standing = Standing(trees);
    let beam = if active.count_ones() > FEW { packet.beam::<V>(active) } else { None };
    let Some(beam) = beam else {
        for_bits!(active, below LANES, |lane| {
            let s = &packet.segment(lane);
            visible[lane] =
                single::pass_placed::<V::Eight, BOUNDED>(&standing, 0, s, visible[lane], place, waiting);
        });
        return;
    };
    let limit = limit(if BOUNDED { 1.0 } else { f32::INFINITY });
    waiting.packets_top[0] = (0, active);
    let mut top = 1;
    while top > 0 {
        top -= 1;
        let (number, lanes) = waiting.packets_top[top];
        let lanes = lanes & active;
        if lanes == 0 {
            continue;
        }
        if lanes.count_ones() <= FEW {
            for_bits!(lanes, below LANES, |lane| {
                let s = &packet.segment(lane);
                visible[lane] =
                    single::pass_placed::<V::Eight, BOUNDED>(&standing, number, s, visible[lane], place, waiting);
                if visible[lane] <= 0.0 {
                    active &= !(1 << lane);
                }
            });
            continue;
        }
        let node = &trees.top.nodes[number as usize];
        let base = top;
        for_bits!(beam.meets_children(node, limit), below WIDTH, |slot| {
            let lanes = packet.meets_child::<V::Sixteen>(limit, node, slot, lanes & active);
            if lanes == 0 {
                continue;
            }
            if node.is_inner(slot) {
                waiting.packets_top[top] = (node.first[slot], lanes);
                top += 1;
                continue;
            }
            let p = &trees.placed[node.first[slot] as usize];
            let place = Place { instance: Some(p.instance), ..*place };
            let tree = &trees.shared[p.tree as usize];
            let local = packet.in_space_of::<V::Sixteen, BOUNDED>(p);
            let left = pass::<V, BOUNDED>(tree, &local, lanes, visible, &place, waiting);
            active &= left | !lanes;
        });
        waiting.packets_top[base..top].reverse();
    }
}

/// Product of `visible` and the transmittance of the triangles below a node, for a single segment.
#[inline(always)]
fn pass_alone<V: Vectors, const BOUNDED: bool>(
    tree: &Tree,
    root: u32,
    s: &Segment,
    visible: f32,
    place: &Place<'_>,
    waiting: &mut Waiting,
) -> f32 {
    let mut occluder = Leaf::default();
    single::pass::<V::Eight, BOUNDED>(tree, root, s, visible, place, &mut waiting.below, &mut occluder)
}

/// Multiplies `visible` by the transmittance of the triangles of a tree; returns the lanes that are
/// not fully blocked.
#[inline(always)]
fn pass<V: Vectors, const BOUNDED: bool>(
    tree: &Tree,
    packet: &Packet,
    mut active: u32,
    visible: &mut [f32; LANES],
    place: &Place<'_>,
    waiting: &mut Waiting,
) -> u32 {
    if tree.nodes.is_empty() {
        return active;
    }
    let beam = if active.count_ones() > FEW { packet.beam::<V>(active) } else { None };
    let Some(beam) = beam else {
        for_bits!(active, below LANES, |lane| {
            let s = &packet.segment(lane);
            visible[lane] = pass_alone::<V, BOUNDED>(tree, 0, s, visible[lane], place, waiting);
            if visible[lane] <= 0.0 {
                active &= !(1 << lane);
            }
        });
        return active;
    };
    let limit = limit(if BOUNDED { 1.0 } else { f32::INFINITY });
    waiting.packets_below[0] = (0, active);
    let mut top = 1;
    while top > 0 {
        top -= 1;
        let (number, lanes) = waiting.packets_below[top];
        let lanes = lanes & active;
        if lanes == 0 {
            continue;
        }
        if lanes.count_ones() <= FEW {
            for_bits!(lanes, below LANES, |lane| {
                let s = &packet.segment(lane);
                visible[lane] = pass_alone::<V, BOUNDED>(tree, number, s, visible[lane], place, waiting);
                if visible[lane] <= 0.0 {
                    active &= !(1 << lane);
                }
            });
            continue;
        }
        let node = &tree.nodes[number as usize];
        let base = top;
        for_bits!(beam.meets_children(node, limit), below WIDTH, |slot| {
            // A wide beam meets boxes that no lane meets: near silhouettes the targets of a fan are
            // far apart.
            let mut lanes = packet.meets_child::<V::Sixteen>(limit, node, slot, lanes & active);
            if lanes == 0 {
                continue;
            }
            if node.is_inner(slot) {
                waiting.packets_below[top] = (node.first[slot], lanes);
                top += 1;
                continue;
            }
            let block = &tree.blocks[node.first[slot] as usize];
            if lanes.count_ones() < u32::from(node.count[slot]) {
                for_bits!(lanes, below LANES, |lane| {
                    let s = &packet.segment(lane);
                    visible[lane] =
                        single::pass_block::<V::Eight, BOUNDED>(block, &s.lines(), s, visible[lane], place);
                    if visible[lane] <= 0.0 {
                        active &= !(1 << lane);
                    }
                });
                continue;
            }
            let planes = block.planes::<V::Eight>().arrays();
            for triangle in 0..node.count[slot] as usize {
                let met = packet.blocked::<V::Sixteen, BOUNDED>(&planes.of(triangle));
                for_bits!(met.any() & lanes, below LANES, |lane| {
                    let s = &packet.segment(lane);
                    if met.is_doubtful_at(lane) && !s.meets::<BOUNDED>(&block.triangle(triangle)) {
                        continue;
                    }
                    visible[lane] *= 1.0 - place.stopped(block, triangle, s.origin, s.direction);
                    if visible[lane] <= 0.0 {
                        active &= !(1 << lane);
                    }
                });
                lanes &= active;
                if lanes == 0 {
                    break;
                }
            }
        });
        // The first child is pushed last, so that all traversals reach leaves in the same order.
        waiting.packets_below[base..top].reverse();
    }
    active
}
