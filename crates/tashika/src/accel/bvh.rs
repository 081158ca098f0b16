//! Trees of boxes, built by `obvhs` (PLOC with reinsertion) and collapsed to eight children a node: what their boxes have to do with
//! a ray is decided for all eight at once.

use obvhs::aabb::Aabb as BuilderAabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};

use crate::math::Aabb;
use crate::rng::{self, Purpose};

/// Most items of a leaf.
const LEAF_ITEMS: u32 = 4;

/// Below this depth items are split in halves: coincident boxes make the builder's tree as deep as there are boxes.
const BUILDER_DEPTH: usize = 32;

/// Room for the nodes that wait while a tree is traversed depth first: no tree is deeper than `BUILDER_DEPTH` and one level a bit
/// of the number of items, and each level leaves at most `WIDTH - 1` nodes behind.
pub(super) const MAX_WAITING: usize = (BUILDER_DEPTH + 33) * (WIDTH - 1) + 1;

/// Children of a node.
pub(super) const WIDTH: usize = 8;

/// [`Node::count`] of an inner child.
pub(super) const INNER: u32 = u32::MAX;

/// An inner node: the boxes of up to [`WIDTH`] children, component by component, and where these are.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Boxes of the children, grown by the build's margin. Absent ones are inverted and have no items.
    pub lo: [[f32; WIDTH]; 3],
    pub hi: [[f32; WIDTH]; 3],
    /// First item of a leaf, or number of an inner node.
    pub first: [u32; WIDTH],
    /// Items of a leaf, or [`INNER`].
    pub count: [u32; WIDTH],
}

impl Node {
    const EMPTY: Self = Self {
        lo: [[f32::INFINITY; WIDTH]; 3],
        hi: [[f32::NEG_INFINITY; WIDTH]; 3],
        first: [0; WIDTH],
        count: [0; WIDTH],
    };

    fn set_box(&mut self, slot: usize, b: &Aabb, margin: f32) {
        for axis in 0..3 {
            self.lo[axis][slot] = b.lo[axis] - margin;
            self.hi[axis][slot] = b.hi[axis] + margin;
        }
    }
}

/// A tree over items, which its owner keeps in the order that the build returned.
#[derive(Debug, Default)]
pub(super) struct Bvh {
    /// Nodes, the root first; empty if there are no items.
    pub nodes: Vec<Node>,
    /// Inner nodes above the deepest leaf.
    pub depth: usize,
}

struct Item(BuilderAabb);

impl Boundable for Item {
    fn aabb(&self) -> BuilderAabb {
        self.0
    }
}

impl Bvh {
    /// A tree over `boxes`, and the order in which its leaves want their items.
    ///
    /// Boxes are grown by 2⁻²² of the largest coordinate: a segment that touches a box's face is inside it,
    /// whatever rounding says.
    pub fn build(boxes: &[Aabb]) -> (Self, Vec<u32>) {
        let items: Vec<Item> = (0u64..).zip(boxes).map(|(i, b)| Item(unequal(i, b))).collect();
        let bounds = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(*b));
        let margin = 2.0 * f32::EPSILON * bounds.lo.abs().max(bounds.hi.abs()).max_element();
        if boxes.len() <= LEAF_ITEMS as usize {
            return Self::single_leaf(boxes.len() as u32, bounds, margin);
        }
        let mut params = BvhBuildParams::medium_build();
        params.max_prims_per_leaf = LEAF_ITEMS;
        let tree = build_bvh2(&items, params, &mut std::time::Duration::default());
        let mut bvh = Self { nodes: Vec::with_capacity(tree.nodes.len() / 2), depth: 0 };
        let mut order = Vec::with_capacity(boxes.len());
        if tree.nodes[0].is_leaf() {
            return Self::single_leaf(boxes.len() as u32, bounds, margin);
        }
        // Depth first, children before siblings, so that a path lies together in memory.
        let mut stack = vec![Pending { source: Source::Builder(0), parent: None, depth: 1 }];
        while let Some(Pending { source, parent, depth }) = stack.pop() {
            bvh.depth = bvh.depth.max(depth);
            let number = bvh.nodes.len() as u32;
            if let Some((parent, slot)) = parent {
                bvh.nodes[parent as usize].first[slot] = number;
            }
            let mut node = Node::EMPTY;
            let mut inner = Vec::new();
            for (slot, child) in opened(source, &tree, boxes, depth).into_iter().enumerate() {
                node.set_box(slot, &child.bounds(&tree, boxes), margin);
                match child {
                    Source::Items(items) if items.len() <= LEAF_ITEMS as usize => {
                        node.first[slot] = order.len() as u32;
                        node.count[slot] = items.len() as u32;
                        order.extend(items);
                    }
                    source => {
                        node.count[slot] = INNER;
                        inner.push(Pending { source, parent: Some((number, slot)), depth: depth + 1 });
                    }
                }
            }
            bvh.nodes.push(node);
            stack.extend(inner.into_iter().rev());
        }
        (bvh, order)
    }

    /// A root whose first child holds everything.
    fn single_leaf(items: u32, bounds: Aabb, margin: f32) -> (Self, Vec<u32>) {
        let mut nodes = Vec::new();
        if items > 0 {
            let mut root = Node::EMPTY;
            root.set_box(0, &bounds, margin);
            root.count[0] = items;
            nodes.push(root);
        }
        let depth = nodes.len();
        (Self { nodes, depth }, (0..items).collect())
    }
}

/// How far a box is grown for the builder, as a share of its diagonal: at most this.
const GROWTH: f32 = 1e-3;

/// The box that the builder sees of item `i`: grown a little, each by another amount.
///
/// The builder joins boxes that are each other's nearest. Along a row of equal things at equal distances every box is as near to one
/// side as to the other, and the builder would join one pair after the other, in quadratic time.
fn unequal(i: u64, b: &Aabb) -> BuilderAabb {
    let share = (rng::key(i, Purpose::Build, 0) >> 40) as f32 * (1.0 / (1 << 24) as f32);
    let growth = GROWTH * share * b.diagonal();
    BuilderAabb::new((b.lo - growth).into(), (b.hi + growth).into())
}

/// What becomes a child.
enum Source {
    /// An inner node of the builder's tree.
    Builder(u32),
    /// Items: a leaf if they are few, else to be split in halves.
    Items(Vec<u32>),
}

struct Pending {
    source: Source,
    parent: Option<(u32, usize)>,
    depth: usize,
}

impl Source {
    fn bounds(&self, tree: &Bvh2, boxes: &[Aabb]) -> Aabb {
        match self {
            Self::Builder(n) => {
                let b = tree.nodes[*n as usize].aabb();
                Aabb { lo: b.min.into(), hi: b.max.into() }
            }
            Self::Items(items) => items.iter().fold(Aabb::EMPTY, |all, &i| all.union(boxes[i as usize])),
        }
    }

    fn is_leaf(&self) -> bool {
        matches!(self, Self::Items(items) if items.len() <= LEAF_ITEMS as usize)
    }

    /// The two parts of what is not a leaf.
    fn parts(self, tree: &Bvh2, boxes: &[Aabb], depth: usize) -> [Self; 2] {
        match self {
            Self::Items(items) => halves(items, boxes).map(Self::Items),
            Self::Builder(n) => {
                let first = tree.nodes[n as usize].first_index;
                [first, first + 1].map(|c| {
                    if tree.nodes[c as usize].is_leaf() || depth >= BUILDER_DEPTH {
                        Self::Items(items_below(tree, c))
                    } else {
                        Self::Builder(c)
                    }
                })
            }
        }
    }
}

/// The children of a node: the largest part is opened until there are [`WIDTH`], and the larger come first, since they are the
/// likelier blockers.
fn opened(source: Source, tree: &Bvh2, boxes: &[Aabb], depth: usize) -> Vec<Source> {
    let half_area = |s: &Source| {
        let e = s.bounds(tree, boxes).size();
        e.x * e.y + e.y * e.z + e.z * e.x
    };
    let mut children: Vec<(f32, Source)> =
        source.parts(tree, boxes, depth).into_iter().map(|s| (half_area(&s), s)).collect();
    while children.len() < WIDTH {
        let open = (0..children.len()).filter(|&i| !children[i].1.is_leaf());
        let Some(largest) = open.max_by(|&a, &b| children[a].0.total_cmp(&children[b].0)) else { break };
        let (_, source) = children.swap_remove(largest);
        children.extend(source.parts(tree, boxes, depth).into_iter().map(|s| (half_area(&s), s)));
    }
    children.sort_by(|a, b| b.0.total_cmp(&a.0));
    children.into_iter().map(|(_, s)| s).collect()
}

/// All items below a node of the builder's tree.
fn items_below(tree: &Bvh2, node: u32) -> Vec<u32> {
    let mut items = Vec::new();
    let mut stack = vec![node];
    while let Some(n) = stack.pop() {
        let n = &tree.nodes[n as usize];
        if n.is_leaf() {
            let first = n.first_index as usize;
            items.extend_from_slice(&tree.primitive_indices[first..first + n.prim_count as usize]);
        } else {
            stack.extend([n.first_index + 1, n.first_index]);
        }
    }
    items
}

/// Items in two halves, along the axis in which their centres spread most.
fn halves(mut items: Vec<u32>, boxes: &[Aabb]) -> [Vec<u32>; 2] {
    let center = |i: &u32| boxes[*i as usize].center();
    let size = Aabb::of_points(items.iter().map(center)).size();
    let axis = size.max_position();
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| center(a)[axis].total_cmp(&center(b)[axis]).then(a.cmp(b)));
    let second = items.split_off(middle);
    [items, second]
}
