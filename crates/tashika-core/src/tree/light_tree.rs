//! The light tree: a binary tree over the lights, in which every node is a range of one sorted
//! array.

use std::collections::BinaryHeap;
use std::ops::Range;

use super::build;
use super::prefix::PrefixSums;
use crate::bounds::LightBounds;
use crate::math::Instants;
use crate::vpl::{LightRows, Vpl, VplSet};

/// Algorithms that build a light tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum LightTreeBuilder {
    /// Top-down, by the surface area orientation heuristic (Conty Estévez, Kulla 2018).
    TopDown,
    /// Bottom-up, always joining neighbours that are cheap by the metric of Walter 2005.
    #[default]
    Agglomerative,
}

/// A cluster of lights: a node of one [`LightTree`], and valid for that tree only.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LightCluster {
    /// First light, in sorted order.
    pub first: u32,
    /// Number of lights; one in a leaf.
    pub count: u32,
    /// Number among all nodes: inner ones in depth-first order, then the leaves in the order of
    /// their lights.
    node: u32,
}

impl LightCluster {
    /// Number among all clusters, below [`LightTree::clusters`].
    pub fn number(&self) -> usize {
        self.node as usize
    }

    /// The places of the cluster's lights in the sorted order.
    pub fn lights(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    /// Returns true if the cluster has the light at a place in the sorted order.
    pub fn holds(&self, light: u32) -> bool {
        // Numbers below the first wrap to numbers beyond the last.
        light.wrapping_sub(self.first) < self.count
    }
}

/// Data of an inner node: one cache line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub(super) struct LightNode {
    /// Bounds of the lights' positions and directions.
    pub(super) bounds: LightBounds,
    /// Sum of the luminances of the intensities; above zero.
    pub(super) luminance: f64,
    /// Number of lights of the first child.
    pub(super) left: u32,
}

/// A tree over the lights of a set, all kinds of an instant under one root. Several instants have a
/// tree each, side by side.
///
/// Only nodes of several lights are stored: about 120 bytes a light in all, with the lights.
#[derive(Clone, Debug, PartialEq)]
pub struct LightTree {
    pub(super) nodes: Vec<LightNode>,
    pub(super) lights: LightRows,
    pub(super) sums: PrefixSums,
    /// Cluster of all lights, by instant.
    roots: Vec<Option<LightCluster>>,
    instants: Instants,
    dropped: usize,
}

impl LightTree {
    /// Builds the tree over those lights of `set` that have luminance; others add nothing to any
    /// image and are omitted.
    ///
    /// Runs on the current thread pool; the result does not depend on the pool. The set must have
    /// fewer than 2³¹ lights.
    pub fn build(set: &VplSet, builder: LightTreeBuilder) -> Self {
        assert!(set.len() < 1 << 31, "light trees have fewer than 2³¹ lights");
        let instants = set.instants().clone();
        let mut lights = LightRows::with_capacity(set.len());
        let mut spans = Vec::new();
        let mut counts = Vec::with_capacity(instants.len());
        for instant in 0..instants.len() {
            let of_instant = &set.lights()[set.at(instant)];
            let first = lights.len();
            let sorted = build::sort(of_instant, first as u32, builder);
            lights.push_instant(sorted.order.iter().map(|light| of_instant[*light as usize]));
            if spans.is_empty() {
                spans = sorted.spans;
            } else {
                spans.extend(sorted.spans);
            }
            counts.push((lights.len() - first) as u32);
        }
        let nodes = build::nodes(&lights, &spans);
        drop(spans);
        let (mut first, mut inner) = (0, 0);
        let roots = counts.into_iter().map(|count| {
            let node = if count == 1 { nodes.len() as u32 + first } else { inner };
            let root = (count > 0).then_some(LightCluster { first, count, node });
            (first, inner) = (first + count, inner + count.saturating_sub(1));
            root
        });
        let roots = roots.collect();
        let sums = PrefixSums::new(lights.luminances(0..lights.len()));
        Self { nodes, dropped: set.len() - lights.len(), lights, sums, roots, instants }
    }

    /// The cluster of all lights of an instant; `None` if there are none.
    pub fn root_at(&self, instant: u16) -> Option<LightCluster> {
        self.roots.get(usize::from(instant)).copied().flatten()
    }

    /// The cluster of all lights of the first instant, the only one where nothing moves; `None` if
    /// there are none.
    pub fn root(&self) -> Option<LightCluster> {
        self.root_at(0)
    }

    /// The clusters of all lights of an instant, in the order of their lights, each with the number
    /// of the instant.
    pub fn roots(&self) -> impl DoubleEndedIterator<Item = (u16, LightCluster)> {
        (0..=u16::MAX).zip(&self.roots).filter_map(|(instant, root)| Some((instant, (*root)?)))
    }

    /// Times to which the lights belong.
    pub fn instants(&self) -> &Instants {
        &self.instants
    }

    /// The two halves of a cluster, in the order of their lights; `None` for a single light.
    pub fn children(&self, of: &LightCluster) -> Option<[LightCluster; 2]> {
        if of.count == 1 {
            return None;
        }
        let left = self.nodes[of.node as usize].left;
        let child = |inner: u32, first: u32, count: u32| {
            let node = if count == 1 { self.nodes.len() as u32 + first } else { inner };
            LightCluster { first, count, node }
        };
        // The first child's subtree has one inner node less than it has lights.
        Some([child(of.node + 1, of.first, left), child(of.node + left, of.first + left, of.count - left)])
    }

    /// Bounds of the positions and directions of a cluster's lights.
    pub fn bounds(&self, of: &LightCluster) -> LightBounds {
        match self.nodes.get(of.number()) {
            Some(node) => node.bounds,
            None => build::leaf(&self.light(of.first)).0,
        }
    }

    /// Sum of the luminances of the intensities of a cluster; above zero.
    pub fn luminance(&self, of: &LightCluster) -> f64 {
        match self.nodes.get(of.number()) {
            Some(node) => node.luminance,
            None => self.luminance_of(of.first),
        }
    }

    /// Luminance of the intensity of the light at a place in the sorted order; above zero.
    pub fn luminance_of(&self, sorted: u32) -> f64 {
        f64::from(self.sums.weights()[sorted as usize])
    }

    /// Luminances of the intensities of all lights, in sorted order.
    pub fn luminances(&self) -> &[f32] {
        self.sums.weights()
    }

    /// Number of clusters, leaves included.
    pub fn clusters(&self) -> usize {
        self.nodes.len() + self.lights.len()
    }

    /// All clusters, each followed by those in its first half, then by those in its second.
    pub fn depth_first(&self) -> impl Iterator<Item = LightCluster> {
        let mut waiting: Vec<LightCluster> = self.roots().map(|(_, root)| root).rev().collect();
        std::iter::from_fn(move || {
            let next = waiting.pop()?;
            waiting.extend(self.children(&next).into_iter().flatten().rev());
            Some(next)
        })
    }

    /// Up to `most` clusters, but at least one for each instant, that hold every light once, in the
    /// order of the lights. The cluster of the greatest importance, which must not be negative, is
    /// split first.
    pub fn split(&self, most: usize, importance: impl Fn(&LightCluster) -> f64) -> Vec<LightCluster> {
        let mut chosen = Vec::new();
        // Numbers that are not negative are in the order of their bits.
        let entry = |cluster: LightCluster| (importance(&cluster).to_bits(), cluster);
        let mut waiting: BinaryHeap<_> = self.roots().map(|(_, root)| entry(root)).collect();
        while waiting.len() + chosen.len() < most {
            let Some((_, cluster)) = waiting.pop() else { break };
            match self.children(&cluster) {
                Some(children) => waiting.extend(children.map(entry)),
                None => chosen.push(cluster),
            }
        }
        chosen.extend(waiting.into_iter().map(|(_, cluster)| cluster));
        chosen.sort_unstable();
        chosen
    }

    /// The light at a place in the sorted order.
    pub fn light(&self, sorted: u32) -> Vpl {
        self.lights.get(sorted as usize)
    }

    /// All lights in sorted order.
    pub fn lights(&self) -> &LightRows {
        &self.lights
    }

    /// Number of lights of the set that have no luminance and are not in the tree.
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// Draws a light of a cluster by the uniform number `u` in `[0, 1)`, and returns its place in
    /// the sorted order. Its probability is its luminance over the cluster's.
    pub fn draw(&self, from: &LightCluster, u: f64) -> u32 {
        self.sums.draw(from.first, from.count, u)
    }

    /// Memory of nodes, lights and sums (bytes).
    pub fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<LightNode>() + self.lights.bytes() + self.sums.bytes()
    }
}
