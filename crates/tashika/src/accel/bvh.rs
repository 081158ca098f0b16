//! Binary trees of boxes, built by `obvhs` (PLOC with reinsertion) and laid out for traversal.

use glam::Vec3;
use obvhs::aabb::Aabb as BuilderAabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};

use crate::math::Aabb;

/// Most items of a leaf.
const LEAF_ITEMS: u32 = 4;

/// Below this depth items are split in halves: coincident boxes make the builder's tree as deep as there are boxes.
const BUILDER_DEPTH: usize = 64;

/// No tree is deeper: `BUILDER_DEPTH` and one level a bit of the number of items.
pub(super) const MAX_DEPTH: usize = BUILDER_DEPTH + 33;

/// [`Node::count`] of an inner child.
pub(super) const INNER: u32 = u32::MAX;

/// An inner node: the boxes of two children and where these are.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Boxes of the two children, grown by the build's margin.
    pub lo: [Vec3; 2],
    pub hi: [Vec3; 2],
    /// First item of a leaf, or number of an inner node.
    pub first: [u32; 2],
    /// Items of a leaf, or [`INNER`].
    pub count: [u32; 2],
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
        let items: Vec<Item> =
            boxes.iter().map(|b| Item(BuilderAabb::new(b.lo.into(), b.hi.into()))).collect();
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
            let children = match source {
                Source::Builder(n) => {
                    let first = tree.nodes[n as usize].first_index;
                    // The larger child is met first: it is the likelier blocker.
                    let area = |i: u32| tree.nodes[i as usize].aabb().half_area();
                    let (large, small) =
                        if area(first) < area(first + 1) { (first + 1, first) } else { (first, first + 1) };
                    [large, small].map(|c| {
                        let node = &tree.nodes[c as usize];
                        if node.is_leaf() || depth >= BUILDER_DEPTH {
                            Source::Items(items_below(&tree, c))
                        } else {
                            Source::Builder(c)
                        }
                    })
                }
                Source::Items(items) => halves(items, boxes).map(Source::Items),
            };
            let mut node = Node { lo: [Vec3::ZERO; 2], hi: [Vec3::ZERO; 2], first: [0; 2], count: [INNER; 2] };
            for (slot, child) in children.iter().enumerate() {
                let b = match child {
                    Source::Builder(c) => {
                        let b = tree.nodes[*c as usize].aabb();
                        Aabb { lo: b.min.into(), hi: b.max.into() }
                    }
                    Source::Items(items) => {
                        if items.len() <= LEAF_ITEMS as usize {
                            node.first[slot] = order.len() as u32;
                            node.count[slot] = items.len() as u32;
                            order.extend_from_slice(items);
                        }
                        items.iter().fold(Aabb::EMPTY, |all, &i| all.union(boxes[i as usize]))
                    }
                };
                (node.lo[slot], node.hi[slot]) = (b.lo - margin, b.hi + margin);
            }
            let inner = node.count.map(|c| c == INNER);
            bvh.nodes.push(node);
            for (slot, source) in children.into_iter().enumerate().rev() {
                if inner[slot] {
                    stack.push(Pending { source, parent: Some((number, slot)), depth: depth + 1 });
                }
            }
        }
        (bvh, order)
    }

    /// A root whose first child holds everything and whose second child is empty.
    fn single_leaf(items: u32, bounds: Aabb, margin: f32) -> (Self, Vec<u32>) {
        let nodes = if items == 0 {
            Vec::new()
        } else {
            let (lo, hi) = (bounds.lo - margin, bounds.hi + margin);
            vec![Node { lo: [lo; 2], hi: [hi; 2], first: [0; 2], count: [items, 0] }]
        };
        let depth = nodes.len();
        (Self { nodes, depth }, (0..items).collect())
    }
}

/// What becomes a node.
enum Source {
    /// An inner node of the builder's tree.
    Builder(u32),
    /// Items that are split in halves until they fit into leaves.
    Items(Vec<u32>),
}

struct Pending {
    source: Source,
    parent: Option<(u32, usize)>,
    depth: usize,
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
