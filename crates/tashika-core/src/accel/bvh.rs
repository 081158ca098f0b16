//! Bounding volume hierarchies with eight children per node: a ray is tested against all eight
//! boxes at once.
//!
//! Trees are built from the root, directly with eight children: the part of a node with the largest
//! area is [split](super::split) in two until there are eight parts. Items are sorted in place, and
//! a leaf is a range of them. The tree depends only on the items and their order, not on the number
//! of threads.

use rayon::prelude::*;

use super::split::{Bounds, Item, halve, split};
use crate::math::Aabb;
use crate::math::simd::WIDTH;

/// Depth beyond which items are halved, since the heuristic may split off a single item at each
/// level.
const UNEVEN_DEPTH: usize = 32;

/// Capacity of the stack of nodes that wait during a depth-first traversal. No tree is deeper than
/// `UNEVEN_DEPTH` plus one level for each bit of the number of items, and each level leaves at most
/// `WIDTH - 1` nodes waiting.
pub(super) const MAX_WAITING: usize = (UNEVEN_DEPTH + 33) * (WIDTH - 1) + 1;

/// Number of items of a node above which the subtrees of its children are built in parallel.
const PARALLEL: usize = 1 << 14;

/// An inner node: the boxes of up to [`WIDTH`] children, stored component by component, and the
/// indices of the children.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Boxes of the children, grown by the margin of [`Bvh::build`]. First the lower planes of the
    /// three axes, then the upper ones. Absent children have inverted boxes and no items.
    pub planes: [[f32; WIDTH]; 6],
    /// Index of each child: of a leaf in [`Bvh::leaves`], or of a node in [`Bvh::nodes`].
    pub first: [u32; WIDTH],
    /// Number of items of each child that is a leaf; zero for inner nodes.
    pub count: [u8; WIDTH],
    /// Mask of the children that are inner nodes.
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

    /// Returns true if a child is an inner node.
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
    /// First item and number of items of each leaf, in depth-first order.
    pub leaves: Vec<(u32, u32)>,
}

impl Bvh {
    /// Builds a tree over items with at most `most` items in a leaf (1 to [`WIDTH`]). Sorts the
    /// items so that each leaf is a range.
    ///
    /// Boxes are grown by 2⁻²² of the largest coordinate. Thus a segment that touches a face of a
    /// box counts as inside it, despite rounding.
    pub fn build(items: &mut [Item], most: usize) -> Self {
        let bounds = Bounds::of(items);
        let b = bounds.aabb();
        let margin = 2.0 * f32::EPSILON * b.lo.abs().max(b.hi.abs()).max_element();
        let mut bvh = Self::default();
        if !items.is_empty() {
            let all = Part { begin: 0, end: items.len(), bounds };
            Growth { most, margin }.grow(items, 0, all, 1, &mut bvh);
        }
        bvh.nodes.shrink_to_fit();
        bvh.leaves.shrink_to_fit();
        bvh
    }

    /// Appends another tree and returns the index that its root has in this one.
    fn append(&mut self, other: Self) -> u32 {
        let (nodes, leaves) = (self.nodes.len() as u32, self.leaves.len() as u32);
        self.leaves.extend(other.leaves);
        self.nodes.extend(other.nodes.into_iter().map(|mut node| {
            for slot in 0..WIDTH {
                node.first[slot] += if node.is_inner(slot) { nodes } else { leaves };
            }
            node
        }));
        nodes
    }
}

/// Range of items that becomes a child of a node.
#[derive(Clone, Copy)]
struct Part {
    begin: usize,
    end: usize,
    bounds: Bounds,
}

/// Parameters that all nodes of a tree share.
struct Growth {
    most: usize,
    margin: f32,
}

impl Growth {
    /// Appends the node over all `items` and the subtree below it. `first` is the index of the
    /// first of them among the items of the whole tree.
    fn grow(&self, items: &mut [Item], first: usize, all: Part, depth: usize, bvh: &mut Bvh) {
        let mut parts = [all; WIDTH];
        let parts = self.parts(items, all, depth, &mut parts);
        let number = bvh.nodes.len();
        let mut node = Node::EMPTY;
        for (slot, part) in parts.iter().enumerate() {
            node.set_box(slot, &part.bounds.aabb(), self.margin);
            let count = part.end - part.begin;
            if count <= self.most {
                node.first[slot] = bvh.leaves.len() as u32;
                node.count[slot] = count as u8;
                bvh.leaves.push(((first + part.begin) as u32, count as u32));
            } else {
                node.inner |= 1 << slot;
            }
        }
        bvh.nodes.push(node);
        // Children come before siblings, so that the nodes of a path are close together in memory.
        let inner = (0..parts.len()).filter(|&slot| node.is_inner(slot));
        if items.len() <= PARALLEL {
            for slot in inner {
                let part = parts[slot];
                bvh.nodes[number].first[slot] = bvh.nodes.len() as u32;
                let below = &mut items[part.begin..part.end];
                self.grow(below, first + part.begin, part, depth + 1, bvh);
            }
            return;
        }
        let mut pieces: Vec<(usize, Part, &mut [Item], Bvh)> = Vec::new();
        let (mut rest, mut at) = (items, 0);
        let mut in_order: Vec<usize> = inner.collect();
        in_order.sort_by_key(|&slot| parts[slot].begin);
        for slot in in_order {
            let part = parts[slot];
            let (_, behind) = std::mem::take(&mut rest).split_at_mut(part.begin - at);
            let (piece, behind) = behind.split_at_mut(part.end - part.begin);
            pieces.push((slot, part, piece, Bvh::default()));
            (rest, at) = (behind, part.end);
        }
        pieces.par_iter_mut().with_max_len(1).for_each(|(_, part, piece, below)| {
            self.grow(piece, first + part.begin, *part, depth + 1, below);
        });
        pieces.sort_by_key(|(slot, ..)| *slot);
        for (slot, .., below) in pieces {
            bvh.nodes[number].first[slot] = bvh.append(below);
        }
    }

    /// Splits the part of largest area until there are [`WIDTH`] parts. The parts are returned by
    /// decreasing area, since larger ones are more likely to block.
    fn parts<'a>(
        &self,
        items: &mut [Item],
        all: Part,
        depth: usize,
        parts: &'a mut [Part; WIDTH],
    ) -> &'a [Part] {
        let mut areas = [0.0; WIDTH];
        parts[0] = Part { begin: 0, end: items.len(), ..all };
        areas[0] = all.bounds.half_area();
        let mut count = 1;
        while count < WIDTH {
            let open = (0..count).filter(|&i| parts[i].end - parts[i].begin > self.most);
            let Some(largest) = open.max_by(|&a, &b| areas[a].total_cmp(&areas[b])) else { break };
            let Part { begin, end, .. } = parts[largest];
            let range = &mut items[begin..end];
            let (middle, [left, right]) = if depth > UNEVEN_DEPTH { halve(range) } else { split(range) };
            parts[largest] = Part { begin, end: begin + middle, bounds: left };
            parts[count] = Part { begin: begin + middle, end, bounds: right };
            (areas[largest], areas[count]) = (left.half_area(), right.half_area());
            count += 1;
        }
        let parts = &mut parts[..count];
        parts.sort_by(|a, b| b.bounds.half_area().total_cmp(&a.bounds.half_area()));
        parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::rng::{Purpose, Stream};

    fn items(boxes: &[Aabb]) -> Vec<Item> {
        (0..).zip(boxes).map(|(i, b)| Item::new(b, [i, 0])).collect()
    }

    fn scattered(count: usize) -> Vec<Aabb> {
        let mut s = Stream::new(1, Purpose::Test, 0);
        let mut scattered = || {
            let at = Vec3::from(s.uniform_3()) * 9.0;
            Aabb { lo: at, hi: at + 0.2 * Vec3::from(s.uniform_3()) }
        };
        (0..count).map(|_| scattered()).collect()
    }

    /// Checks the properties that traversals rely on; returns the depth of the tree.
    fn check(boxes: &[Aabb], most: usize) -> usize {
        let mut items = items(boxes);
        let bvh = Bvh::build(&mut items, most);
        let (mut seen, mut next_leaf, mut deepest) = (vec![false; boxes.len()], 0, 0);
        let mut waiting = vec![(0, 1, Aabb { lo: Vec3::NEG_INFINITY, hi: Vec3::INFINITY })];
        let mut nodes = 0;
        while let Some((number, depth, around)) = waiting.pop() {
            assert_eq!(number, nodes, "depth first");
            (nodes, deepest) = (nodes + 1, deepest.max(depth));
            let node = &bvh.nodes[number as usize];
            let base = waiting.len();
            for slot in 0..WIDTH {
                let plane =
                    |side: usize| Vec3::from_array([0, 1, 2].map(|axis| node.planes[side + axis][slot]));
                let b = Aabb { lo: plane(0), hi: plane(3) };
                assert!(b.is_empty() || b.union(around) == around, "children are inside");
                if node.is_inner(slot) {
                    waiting.push((node.first[slot], depth + 1, b));
                } else if node.count[slot] > 0 {
                    assert_eq!(node.first[slot], next_leaf, "leaves are in the order of the walk");
                    let (first, count) = bvh.leaves[next_leaf as usize];
                    assert!(count as usize <= most && count == u32::from(node.count[slot]));
                    next_leaf += 1;
                    for item in &items[first as usize..][..count as usize] {
                        let [item, _] = item.numbers();
                        assert!(!std::mem::replace(&mut seen[item as usize], true), "{item} twice");
                        assert_eq!(b.union(boxes[item as usize]), b, "leaves hold their items");
                    }
                } else {
                    assert!(b.is_empty(), "what is absent is met by nothing");
                }
            }
            waiting[base..].reverse();
        }
        assert_eq!((nodes as usize, next_leaf as usize), (bvh.nodes.len(), bvh.leaves.len()));
        assert!(seen.iter().all(|seen| *seen));
        deepest
    }

    #[test]
    fn trees_hold_every_item_once_and_inside_all_boxes_above() {
        for count in [1, 2, 8, 9, 64, 65, 1000, 3 * PARALLEL] {
            for most in [1, WIDTH] {
                check(&scattered(count), most);
            }
        }
        assert!(Bvh::build(&mut [], WIDTH).nodes.is_empty());
    }

    #[test]
    fn no_tree_is_deeper_than_walks_have_room_for() {
        let same = vec![Aabb { lo: Vec3::ZERO, hi: Vec3::ONE }; 5000];
        // Each box is larger than all boxes before it together, so the heuristic splits off one at
        // a time.
        let grown: Vec<Aabb> = (0..120)
            .map(|k| 2.0_f32.powi(k - 60))
            .map(|x| Aabb { lo: Vec3::splat(x), hi: Vec3::splat(1.5 * x) })
            .collect();
        for boxes in [same, grown] {
            for most in [1, WIDTH] {
                let depth = check(&boxes, most);
                assert!(depth * (WIDTH - 1) < MAX_WAITING && depth < UNEVEN_DEPTH, "{depth}");
            }
        }
    }

    #[test]
    fn threads_do_not_change_the_tree() {
        let boxes = scattered(5 * PARALLEL);
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut items = items(&boxes);
            let bvh = pool.install(|| Bvh::build(&mut items, WIDTH));
            let numbers: Vec<[u32; 2]> = items.iter().map(Item::numbers).collect();
            (format!("{:?}", bvh), numbers)
        };
        assert!(with(1) == with(5));
    }
}
