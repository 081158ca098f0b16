//! Visibility of up to [`LANES`] segments at once: one walk through the trees for all of them.
//!
//! Inner nodes are judged for the whole group: intervals around the segments' origins and reciprocal directions bound
//! the parameters at which any of them can be inside a box, for the eight children of a node at once. What is left, and
//! triangles, is judged lane by lane. Where only few lanes are left they walk on alone, and segments whose directions differ in sign
//! have no useful intervals and walk alone from the start.
//!
//! A lane is tested against the triangles of those leaves whose boxes it meets itself, in the order of the tree, however it walks
//! (`accel::tests::grouping_does_not_change_a_bit`).

use glam::Vec3;

use super::beam::{Beam, limit, meet_child, reciprocal, reciprocals};
use super::bvh::Node;
use super::occluders::Leaf;
use super::segments::Glass;
use super::single::{self, Place, Segment, Waiting};
use super::trees::{Placed, Tree, Trees};
use super::triangle::{Block, Lines, blocked};
use crate::math::Real;
use crate::math::simd::{F32x8, WIDTH, each, for_bits};
use crate::scene::Scene;

/// Segments that travel together.
pub(super) const LANES: usize = 2 * WIDTH;

/// Lanes up to which each walks on alone.
pub(super) const FEW: u32 = 3;

/// Eight segments as they are stored.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
struct Half {
    origin: [[f32; WIDTH]; 3],
    direction: [[f32; WIDTH]; 3],
    reciprocal: [[f32; WIDTH]; 3],
    target: [[f32; WIDTH]; 3],
    point_error: [f32; WIDTH],
}

impl Half {
    const NONE: Self = Self {
        origin: [[0.0; WIDTH]; 3],
        direction: [[0.0; WIDTH]; 3],
        reciprocal: [[0.0; WIDTH]; 3],
        target: [[0.0; WIDTH]; 3],
        point_error: [0.0; WIDTH],
    };

    /// The same in the space of an instance.
    #[inline(always)]
    fn in_space_of<F: F32x8, const BOUNDED: bool>(&self, placed: &Placed) -> Self {
        let (origin, error) = placed.points(each!(|axis| F::load(&self.origin[axis])));
        let (target, direction, error) = if BOUNDED {
            let (target, other) = placed.points(each!(|axis| F::load(&self.target[axis])));
            (target, each!(|axis| target[axis] - origin[axis]), error.max(other))
        } else {
            let direction = placed.directions(each!(|axis| F::load(&self.direction[axis])));
            (origin, direction, error)
        };
        Self {
            origin: each!(|axis| origin[axis].array()),
            direction: each!(|axis| direction[axis].array()),
            reciprocal: each!(|axis| reciprocals(direction[axis]).array()),
            target: each!(|axis| target[axis].array()),
            point_error: error.array(),
        }
    }
}

/// Segments that walk together, in the space of one tree.
pub(super) struct Packet {
    halves: [Half; 2],
}

impl Packet {
    /// Of at most [`LANES`] segments.
    #[inline(always)]
    fn new(segments: &[Segment]) -> Self {
        let mut packet = Self { halves: [Half::NONE; 2] };
        for (lane, s) in segments.iter().enumerate() {
            let (half, at) = (&mut packet.halves[lane / WIDTH], lane % WIDTH);
            for axis in 0..3 {
                half.origin[axis][at] = s.origin[axis];
                half.direction[axis][at] = s.direction[axis];
                half.reciprocal[axis][at] = reciprocal(s.direction[axis]);
                half.target[axis][at] = s.target[axis];
            }
            half.point_error[at] = s.point_error;
        }
        packet
    }

    /// The same in the space of an instance, as far as some lanes are concerned.
    #[inline(always)]
    fn in_space_of<F: F32x8, const BOUNDED: bool>(&self, placed: &Placed, lanes: u32) -> Self {
        let mut local = Self { halves: [Half::NONE; 2] };
        for half in 0..2 {
            if lanes >> (half * WIDTH) & 0xff != 0 {
                local.halves[half] = self.halves[half].in_space_of::<F, BOUNDED>(placed);
            }
        }
        local
    }

    /// One of the segments.
    #[inline(always)]
    fn segment(&self, lane: usize) -> Segment {
        let (half, at) = (&self.halves[lane / WIDTH], lane % WIDTH);
        let vector = |v: &[[f32; WIDTH]; 3]| Vec3::new(v[0][at], v[1][at], v[2][at]);
        Segment {
            origin: vector(&half.origin),
            direction: vector(&half.direction),
            target: vector(&half.target),
            point_error: half.point_error[at],
        }
    }

    #[inline(always)]
    fn lines<F: F32x8>(&self, half: usize) -> Lines<F> {
        let half = &self.halves[half];
        Lines {
            origin: each!(|axis| F::load(&half.origin[axis])),
            direction: each!(|axis| F::load(&half.direction[axis])),
            target: each!(|axis| F::load(&half.target[axis])),
            point_error: F::load(&half.point_error),
        }
    }

    /// The beam around some lanes; `None` if their directions differ in sign.
    #[inline(always)]
    fn beam<F: F32x8>(&self, lanes: u32) -> Option<Beam<F>> {
        let mut origins = [[f32::INFINITY, f32::NEG_INFINITY]; 3];
        let mut reciprocals = origins;
        let mut error = 0.0f32;
        for (half, own) in self.halves.iter().zip([lanes & 0xff, lanes >> WIDTH]) {
            if own == 0 {
                continue;
            }
            let own = F::mask(own);
            for axis in 0..3 {
                origins[axis] = widened::<F>(origins[axis], &half.origin[axis], own);
                reciprocals[axis] = widened::<F>(reciprocals[axis], &half.reciprocal[axis], own);
            }
            error = widened::<F>([0.0, error], &half.point_error, own)[1];
        }
        Beam::new(origins, reciprocals, error)
    }

    /// Which lanes meet the box of a child.
    #[inline(always)]
    fn meets_child<F: F32x8>(&self, limit: f32, node: &Node, slot: usize, lanes: u32) -> u32 {
        let mut met = 0;
        for half in 0..2 {
            if lanes >> (half * WIDTH) & 0xff != 0 {
                let r = each!(|axis| F::load(&self.halves[half].reciprocal[axis]));
                met |= meet_child(&self.lines::<F>(half), &r, limit, node, slot) << (half * WIDTH);
            }
        }
        met & lanes
    }

    /// Which lanes a triangle blocks.
    #[inline(always)]
    fn blocked<F: F32x8, const BOUNDED: bool>(&self, block: &Block, slot: usize, lanes: u32) -> u32 {
        let v = block.corners_of::<F>(slot);
        let mut hit = 0;
        for half in 0..2 {
            if lanes >> (half * WIDTH) & 0xff != 0 {
                hit |= blocked::<F, BOUNDED>(&v, &self.lines(half)) << (half * WIDTH);
            }
        }
        hit & lanes
    }
}

/// An interval, and those of eight numbers that are meant.
#[inline(always)]
fn widened<F: F32x8>([least, largest]: [f32; 2], values: &[f32; WIDTH], own: F::Mask) -> [f32; 2] {
    let values = F::load(values);
    let low = F::select(own, values, F::splat(least)).array();
    let high = F::select(own, values, F::splat(largest)).array();
    let mut interval = [least, largest];
    for i in 0..WIDTH {
        interval = [Real::min(interval[0], low[i]), Real::max(interval[1], high[i])];
    }
    interval
}

/// The share of light that passes along each of at most [`LANES`] segments.
#[inline(always)]
pub(super) fn visible<F: F32x8, const BOUNDED: bool>(
    trees: &Trees,
    scene: &Scene,
    glass: Glass,
    segments: &[Segment],
    waiting: &mut Waiting,
) -> [f32; LANES] {
    let mut visible = [1.0; LANES];
    let place = Place { scene, glass, instance: None };
    let packet = Packet::new(segments);
    let all = ((1u64 << segments.len()) - 1) as u32;
    let left = pass::<F, BOUNDED>(&trees.world, &packet, all, &mut visible, &place, waiting);
    if left != 0 && !trees.placed.is_empty() {
        pass_placed::<F, BOUNDED>(trees, &packet, left, &mut visible, &place, waiting);
    }
    visible
}

/// Multiplies what is visible by what passes the instances.
#[inline(always)]
fn pass_placed<F: F32x8, const BOUNDED: bool>(
    trees: &Trees,
    packet: &Packet,
    mut active: u32,
    visible: &mut [f32; LANES],
    place: &Place<'_>,
    waiting: &mut Waiting,
) {
    let beam = if active.count_ones() > FEW { packet.beam::<F>(active) } else { None };
    let Some(beam) = beam else {
        for_bits!(active, below LANES, |lane| {
            let s = &packet.segment(lane);
            visible[lane] = single::pass_placed::<F, BOUNDED>(trees, 0, s, visible[lane], place, waiting);
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
                    single::pass_placed::<F, BOUNDED>(trees, number, s, visible[lane], place, waiting);
                if visible[lane] <= 0.0 {
                    active &= !(1 << lane);
                }
            });
            continue;
        }
        let node = &trees.top.nodes[number as usize];
        let base = top;
        for_bits!(beam.meets_children(node, limit), below WIDTH, |slot| {
            let lanes = packet.meets_child::<F>(limit, node, slot, lanes & active);
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
            let local = packet.in_space_of::<F, BOUNDED>(p, lanes);
            let left = pass::<F, BOUNDED>(tree, &local, lanes, visible, &place, waiting);
            active &= left | !lanes;
        });
        waiting.packets_top[base..top].reverse();
    }
}

/// What passes the triangles below a node for a segment that walks on alone.
#[inline(always)]
fn pass_alone<F: F32x8, const BOUNDED: bool>(
    tree: &Tree,
    root: u32,
    s: &Segment,
    visible: f32,
    place: &Place<'_>,
    waiting: &mut Waiting,
) -> f32 {
    let mut occluder = Leaf::default();
    single::pass::<F, BOUNDED>(tree, root, s, visible, place, &mut waiting.below, &mut occluder)
}

/// Multiplies what is visible by what passes the triangles of a tree; the lanes of which something is left.
#[inline(always)]
fn pass<F: F32x8, const BOUNDED: bool>(
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
    let beam = if active.count_ones() > FEW { packet.beam::<F>(active) } else { None };
    let Some(beam) = beam else {
        for_bits!(active, below LANES, |lane| {
            let s = &packet.segment(lane);
            visible[lane] = pass_alone::<F, BOUNDED>(tree, 0, s, visible[lane], place, waiting);
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
                visible[lane] = pass_alone::<F, BOUNDED>(tree, number, s, visible[lane], place, waiting);
                if visible[lane] <= 0.0 {
                    active &= !(1 << lane);
                }
            });
            continue;
        }
        let node = &tree.nodes[number as usize];
        let base = top;
        for_bits!(beam.meets_children(node, limit), below WIDTH, |slot| {
            // A wide beam meets what no lane does: near silhouettes the targets of a fan lie far apart.
            let mut lanes = packet.meets_child::<F>(limit, node, slot, lanes & active);
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
                        single::pass_block::<F, BOUNDED>(block, &s.lines(), s, visible[lane], place);
                    if visible[lane] <= 0.0 {
                        active &= !(1 << lane);
                    }
                });
                continue;
            }
            for triangle in 0..node.count[slot] as usize {
                for_bits!(packet.blocked::<F, BOUNDED>(block, triangle, lanes), below LANES, |lane| {
                    let s = &packet.segment(lane);
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
        // The first child comes on top, so that leaves are met in the same order by all.
        waiting.packets_below[base..top].reverse();
    }
    active
}
