//! Trees of boxes, built by `obvhs` (PLOC with reinsertion) and collapsed to eight children a node: what their boxes have to do with
//! a ray is decided for all eight at once.

use obvhs::aabb::Aabb as BuilderAabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};

use crate::math::Aabb;
use crate::math::simd::WIDTH;
use crate::rng::{self, Purpose};

/// Below this depth items are split in halves: coincident boxes make the builder's tree as deep as there are boxes.
const BUILDER_DEPTH: usize = 32;

/// Room for the nodes that wait while a tree is traversed depth first: no tree is deeper than `BUILDER_DEPTH` and one level a bit
/// of the number of items, and each level leaves at most `WIDTH - 1` nodes behind.
pub(super) const MAX_WAITING: usize = (BUILDER_DEPTH + 33) * (WIDTH - 1) + 1;

/// An inner node: the boxes of up to [`WIDTH`] children, component by component, and where these are.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Boxes of the children, grown by the build's margin: the lower planes of the three axes, then the upper ones. Absent ones are
    /// inverted and have no items.
    pub planes: [[f32; WIDTH]; 6],
    /// Number of a leaf or of an inner node.
    pub first: [u32; WIDTH],
    /// Items of a leaf; none of an inner node.
    pub count: [u8; WIDTH],
    /// Bits of the children that are inner nodes.
    pub inner: u32,
}

impl Node {
    const EMPTY: Self = Self {
        planes: {
            let (lower, upper) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
            [lower, lower, lower, upper, upper, upper]
        },
        first: [0; WIDTH],
        count: [0; WIDTH],
        inner: 0,
    };

    /// Whether a child is an inner node.
    #[inline(always)]
    pub fn is_inner(&self, slot: usize) -> bool {
        self.inner >> slot & 1 != 0
    }

    fn set_box(&mut self, slot: usize, b: &Aabb, margin: f32) {
        for axis in 0..3 {
            self.planes[axis][slot] = b.lo[axis] - margin;
            self.planes[axis + 3][slot] = b.hi[axis] + margin;
        }
    }
}

/// A tree over items.
#[derive(Debug, Default)]
pub(super) struct Bvh {
    /// Nodes, the root first; empty if there are no items.
    pub nodes: Vec<Node>,
}

/// The items of each leaf, in the order in which a depth-first walk meets them.
#[derive(Debug, Default)]
pub(super) struct Leaves {
    items: Vec<u32>,
    ends: Vec<u32>,
}

impl Leaves {
    fn push(&mut self, items: &[u32]) -> u32 {
        self.items.extend_from_slice(items);
        self.ends.push(self.items.len() as u32);
        self.ends.len() as u32 - 1
    }

    /// Leaf by leaf.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let mut begin = 0;
        self.ends.iter().map(move |&end| {
            let items = &self.items[begin as usize..end as usize];
            begin = end;
            items
        })
    }
}

struct Item(BuilderAabb);

impl Boundable for Item {
    fn aabb(&self) -> BuilderAabb {
        self.0
    }
}

impl Bvh {
    /// A tree over `boxes` with at most `most` items in a leaf, 1 to [`WIDTH`].
    ///
    /// Boxes are grown by 2⁻²² of the largest coordinate: a segment that touches a box's face is inside it,
    /// whatever rounding says.
    pub fn build(boxes: &[Aabb], most: usize) -> (Self, Leaves) {
        let items: Vec<Item> = (0u64..).zip(boxes).map(|(i, b)| Item(unequal(i, b))).collect();
        let bounds = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(*b));
        let margin = 2.0 * f32::EPSILON * bounds.lo.abs().max(bounds.hi.abs()).max_element();
        if boxes.len() <= most {
            return Self::single_leaf(boxes.len() as u32, bounds, margin);
        }
        let mut params = BvhBuildParams::medium_build();
        params.max_prims_per_leaf = most as u32;
        let tree = build_bvh2(&items, params, &mut std::time::Duration::default());
        let mut bvh = Self { nodes: Vec::with_capacity(tree.nodes.len() / 2) };
        let mut leaves = Leaves::default();
        let opening = Opening { tree: &tree, boxes, most };
        if tree.nodes[0].is_leaf() {
            return Self::single_leaf(boxes.len() as u32, bounds, margin);
        }
        // Depth first, children before siblings, so that a path lies together in memory.
        let mut stack = vec![Pending { source: Source::Builder(0), parent: None, depth: 1 }];
        while let Some(Pending { source, parent, depth }) = stack.pop() {
            let number = bvh.nodes.len() as u32;
            if let Some((parent, slot)) = parent {
                bvh.nodes[parent as usize].first[slot] = number;
            }
            let mut node = Node::EMPTY;
            let mut inner = Vec::new();
            for (slot, child) in opening.children(source, depth).into_iter().enumerate() {
                node.set_box(slot, &opening.bounds(&child), margin);
                match child {
                    Source::Items(items) if items.len() <= most => {
                        node.first[slot] = leaves.push(&items);
                        node.count[slot] = items.len() as u8;
                    }
                    source => {
                        node.inner |= 1 << slot;
                        inner.push(Pending { source, parent: Some((number, slot)), depth: depth + 1 });
                    }
                }
            }
            bvh.nodes.push(node);
            stack.extend(inner.into_iter().rev());
        }
        (bvh, leaves)
    }

    /// A root whose first child holds everything.
    fn single_leaf(items: u32, bounds: Aabb, margin: f32) -> (Self, Leaves) {
        let (mut nodes, mut leaves) = (Vec::new(), Leaves::default());
        if items > 0 {
            let mut root = Node::EMPTY;
            root.set_box(0, &bounds, margin);
            root.first[0] = leaves.push(&(0..items).collect::<Vec<_>>());
            root.count[0] = items as u8;
            nodes.push(root);
        }
        (Self { nodes }, leaves)
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

/// What decides which parts of the builder's tree become the children of a node.
struct Opening<'a> {
    tree: &'a Bvh2,
    boxes: &'a [Aabb],
    /// Items of a leaf, at most.
    most: usize,
}

impl Opening<'_> {
    fn bounds(&self, source: &Source) -> Aabb {
        match source {
            Source::Builder(n) => {
                let b = self.tree.nodes[*n as usize].aabb();
                Aabb { lo: b.min.into(), hi: b.max.into() }
            }
            Source::Items(items) => {
                items.iter().fold(Aabb::EMPTY, |all, &i| all.union(self.boxes[i as usize]))
            }
        }
    }

    fn is_leaf(&self, source: &Source) -> bool {
        matches!(source, Source::Items(items) if items.len() <= self.most)
    }

    /// The two parts of what is not a leaf, each with half the area of its box.
    fn parts(&self, source: Source, depth: usize) -> [(f32, Source); 2] {
        let parts = match source {
            Source::Items(items) => halves(items, self.boxes).map(Source::Items),
            Source::Builder(n) => {
                let first = self.tree.nodes[n as usize].first_index;
                [first, first + 1].map(|c| {
                    if self.tree.nodes[c as usize].is_leaf() || depth >= BUILDER_DEPTH {
                        Source::Items(items_below(self.tree, c))
                    } else {
                        Source::Builder(c)
                    }
                })
            }
        };
        parts.map(|part| {
            let e = self.bounds(&part).size();
            (e.x * e.y + e.y * e.z + e.z * e.x, part)
        })
    }

    /// The children of a node: the largest part is opened until there are [`WIDTH`], and the larger come first, since they are the
    /// likelier blockers.
    fn children(&self, source: Source, depth: usize) -> Vec<Source> {
        let mut children: Vec<(f32, Source)> = self.parts(source, depth).into();
        while children.len() < WIDTH {
            let open = (0..children.len()).filter(|&i| !self.is_leaf(&children[i].1));
            let Some(largest) = open.max_by(|&a, &b| children[a].0.total_cmp(&children[b].0)) else { break };
            let (_, source) = children.swap_remove(largest);
            children.extend(self.parts(source, depth));
        }
        children.sort_by(|a, b| b.0.total_cmp(&a.0));
        children.into_iter().map(|(_, s)| s).collect()
    }
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
