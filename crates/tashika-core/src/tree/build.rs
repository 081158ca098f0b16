//! Common parts of the builders of light trees: separation by kind, and nodes from ranges.
//!
//! Each kind of light has its own subtree, since bounds are useful only for lights of one kind. A
//! chain of mixed nodes joins these subtrees. A binary tree with one light per leaf has `2n − 1`
//! nodes. In depth-first order, the subtree at node `k` is nodes `k` to `k + 2 count − 2`. Its
//! left child is `k + 1`, its right child `k + 2 count(k + 1)`. A builder therefore only sorts
//! items and writes ranges: the slices of the arrays that a subtree fills are known in advance.
//! Ranges of one light are leaves, which are not stored as nodes.

use rayon::prelude::*;

use super::light_tree::{LightNode, LightTreeBuilder};
use super::saoh::Emission;
use super::{agglomerative, top_down};
use crate::bounds::{LightBounds, LightShape};
use crate::math::{Aabb, Cone, Vec3};
use crate::vpl::{LightRows, Vpl, VplKind};

/// Largest number of lights in a subtree that is merged as one parallel task.
const GRAIN: u32 = 1 << 12;

/// Data of a light that builders use.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    /// Position (m), then unit normal or axis; the latter is zero for lights that have none. A
    /// directional light has its unit direction of travel in place of a position.
    pub(super) key: [f32; 6],
    pub(super) luminance: f32,
    /// Index of the light in the slice passed to [`sort`].
    pub(super) light: u32,
}

impl Item {
    pub(super) fn position(&self) -> Vec3 {
        Vec3::new(self.key[0], self.key[1], self.key[2])
    }

    pub(super) fn direction(&self) -> Vec3 {
        Vec3::new(self.key[3], self.key[4], self.key[5])
    }
}

/// The items of a node: a range of the sorted order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Span {
    pub(super) first: u32,
    pub(super) count: u32,
}

/// Indices of lights in sorted order, and the nodes of the tree over them in depth-first order.
pub(super) struct Sorted {
    pub(super) order: Vec<u32>,
    pub(super) spans: Vec<Span>,
}

/// Sorts the lights of positive luminance into a tree. `begin` is the index of its first light in
/// the sorted order of all trees.
pub(super) fn sort(lights: &[Vpl], begin: u32, builder: LightTreeBuilder) -> Sorted {
    let groups: Vec<(Emission, Vec<Item>)> = (0..VplKind::COUNT)
        .map(|kind| (Emission::of_kind(kind, lights), items_of_kind(kind, lights)))
        .filter(|(_, items)| !items.is_empty())
        .collect();
    let total: usize = groups.iter().map(|(_, items)| items.len()).sum();
    let mut spans = vec![Span::default(); (2 * total).saturating_sub(1)];
    let mut order = Vec::with_capacity(total);
    let mut rest = spans.as_mut_slice();
    let last = groups.len().saturating_sub(1);
    for (group, (emission, mut items)) in groups.into_iter().enumerate() {
        let first = begin + order.len() as u32;
        if group < last {
            rest[0] = Span { first, count: (total - order.len()) as u32 };
            rest = &mut rest[1..];
        }
        let (own, others) = rest.split_at_mut(2 * items.len() - 1);
        match builder {
            LightTreeBuilder::TopDown => top_down::build(&mut items, own, first, &emission),
            LightTreeBuilder::Agglomerative => agglomerative::build(&mut items, own, first, &emission),
        }
        rest = others;
        order.extend(items.into_iter().map(|item| item.light));
    }
    Sorted { order, spans }
}

/// Returns the inner nodes of all trees, one tree after another, each in depth-first order.
pub(super) fn nodes(lights: &LightRows, spans: &[Span]) -> Vec<LightNode> {
    let inner: Vec<Inner> = spans
        .par_iter()
        .enumerate()
        .filter(|(_, span)| span.count > 1)
        .map(|(k, &span)| Inner { span, left: spans[k + 1].count })
        .collect();
    let unknown = LightNode {
        bounds: LightBounds { aabb: Aabb::EMPTY, shape: LightShape::Mixed { peak: 1.0 } },
        luminance: 0.0,
        left: 0,
    };
    let mut nodes = vec![unknown; inner.len()];
    merge_up(lights, &inner, &mut nodes);
    nodes
}

/// An inner node before its bounds are known.
#[derive(Clone, Copy)]
struct Inner {
    span: Span,
    /// Number of items of the first child.
    left: u32,
}

/// Bounds and luminance of a single light.
pub(super) fn leaf(light: &Vpl) -> (LightBounds, f64) {
    (bounds_of(light), f64::from(light.intensity.luminance()))
}

/// Bounds of a single light.
fn bounds_of(light: &Vpl) -> LightBounds {
    let at = Aabb { lo: light.position, hi: light.position };
    let cone = Cone::of(light.direction);
    match light.kind {
        VplKind::Omni => LightBounds { aabb: at, shape: LightShape::Omni },
        VplKind::Oriented => LightBounds { aabb: at, shape: LightShape::Oriented(cone) },
        VplKind::Spot(falloff) => {
            LightBounds { aabb: at, shape: LightShape::Spot { axes: cone, cos_outer: falloff.cos_outer } }
        }
        VplKind::Image(beam) => {
            LightBounds { aabb: at, shape: LightShape::Spot { axes: cone, cos_outer: beam.cos_outer } }
        }
        VplKind::Directional => LightBounds { aabb: Aabb::EMPTY, shape: LightShape::Directional(cone) },
        VplKind::Volume(phase) => {
            let asymmetry = [phase.asymmetry; 2];
            LightBounds { aabb: at, shape: LightShape::Volume { directions: cone, asymmetry } }
        }
    }
}

/// Merges the data of children into inner nodes: small subtrees in parallel, then the nodes above
/// them.
fn merge_up(lights: &LightRows, inner: &[Inner], nodes: &mut [LightNode]) {
    let mut above = Vec::new();
    let mut subtrees = Vec::new();
    let mut rest = &mut *nodes;
    let mut at = 0;
    while let Some(Inner { span, .. }) = inner.get(at) {
        let small = span.count <= GRAIN;
        let length = if small { span.count as usize - 1 } else { 1 };
        let (piece, others) = std::mem::take(&mut rest).split_at_mut(length);
        if small {
            subtrees.push((at, piece));
        } else {
            above.push(at);
        }
        at += length;
        rest = others;
    }
    subtrees.into_par_iter().for_each(|(offset, subtree)| {
        for k in (0..subtree.len()).rev() {
            merge(lights, &inner[offset + k], subtree, k);
        }
    });
    for k in above.into_iter().rev() {
        merge(lights, &inner[k], nodes, k);
    }
}

/// Sets node `k` to the union of its children's bounds and the sum of their luminances.
fn merge(lights: &LightRows, inner: &Inner, nodes: &mut [LightNode], k: usize) {
    let (left, right) = (inner.left as usize, (inner.span.count - inner.left) as usize);
    let first = inner.span.first as usize;
    let of = |node: usize, first: usize, count: usize| match count {
        1 => leaf(&lights.get(first)),
        _ => (nodes[node].bounds, nodes[node].luminance),
    };
    // The first child has `left` lights, so its subtree has `left − 1` inner nodes.
    let (a, b) = (of(k + 1, first, left), of(k + left, first + left, right));
    nodes[k] = LightNode { bounds: LightBounds::union(a.0, b.0), luminance: a.1 + b.1, left: inner.left };
}

fn items_of_kind(kind: usize, lights: &[Vpl]) -> Vec<Item> {
    lights
        .par_iter()
        .enumerate()
        .filter_map(|(i, light)| {
            let luminance = light.intensity.luminance();
            if light.kind.number() != kind || luminance <= 0.0 {
                return None;
            }
            let (p, d) = match light.kind {
                VplKind::Omni => (light.position, Vec3::ZERO),
                VplKind::Oriented | VplKind::Spot(_) | VplKind::Image(_) | VplKind::Volume(_) => {
                    (light.position, light.direction)
                }
                VplKind::Directional => (light.direction, Vec3::ZERO),
            };
            Some(Item { key: [p.x, p.y, p.z, d.x, d.y, d.z], luminance, light: i as u32 })
        })
        .collect()
}
