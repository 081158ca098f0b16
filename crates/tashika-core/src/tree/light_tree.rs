//! The light tree: a binary tree over the lights. Every node is a range of one sorted array.

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
    /// Bottom-up: joins neighbours whose union is cheap by the metric of Walter 2005.
    #[default]
    Agglomerative,
}

/// A cluster of lights: a node of one [`LightTree`], valid only for that tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LightCluster {
    /// First light, in sorted order.
    pub first: u32,
    /// Number of lights; one in a leaf.
    pub count: u32,
    /// Index among all nodes: first the inner nodes in depth-first order, then the leaves in the
    /// order of their lights.
    node: u32,
}

impl LightCluster {
    /// Index among all clusters, less than [`LightTree::clusters`].
    pub fn number(&self) -> usize {
        self.node as usize
    }

    /// Range of the cluster's lights in the sorted order.
    pub fn lights(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    /// Returns true if the cluster contains the light at an index in the sorted order.
    pub fn holds(&self, light: u32) -> bool {
        // Differences below zero wrap to numbers above the count.
        light.wrapping_sub(self.first) < self.count
    }
}

/// Data of an inner node, in one cache line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub(super) struct LightNode {
    /// Bounds of the lights' positions and directions.
    pub(super) bounds: LightBounds,
    /// Sum of the luminances of the intensities; above zero.
    pub(super) luminance: f64,
    /// Number of lights below the first child.
    pub(super) left: u32,
}

/// A tree over the lights of a set. All lights of an instant are under one root; several instants
/// have one tree each.
///
/// Only nodes with several lights are stored. Nodes and lights together take about 120 bytes per
/// light.
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
    /// Builds the tree over those lights of `set` whose luminance is positive; other lights
    /// contribute nothing and are omitted.
    ///
    /// Runs on the current thread pool. The result does not depend on the pool. The set must have
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

    /// Cluster of all lights of an instant; `None` if it has no lights.
    pub fn root_at(&self, instant: u16) -> Option<LightCluster> {
        self.roots.get(usize::from(instant)).copied().flatten()
    }

    /// Cluster of all lights of the first instant, which is the only one if nothing moves; `None`
    /// if it has no lights.
    pub fn root(&self) -> Option<LightCluster> {
        self.root_at(0)
    }

    /// Cluster of all lights of each instant that has lights, with the number of the instant, in
    /// order.
    pub fn roots(&self) -> impl DoubleEndedIterator<Item = (u16, LightCluster)> {
        (0..=u16::MAX).zip(&self.roots).filter_map(|(instant, root)| Some((instant, (*root)?)))
    }

    /// Times of the instants to which the lights belong.
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
        // The subtree of the first child has one inner node less than it has lights.
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

    /// All clusters in depth-first order: each is followed by its first half, then by its second
    /// half.
    pub fn depth_first(&self) -> impl Iterator<Item = LightCluster> {
        let mut waiting: Vec<LightCluster> = self.roots().map(|(_, root)| root).rev().collect();
        std::iter::from_fn(move || {
            let next = waiting.pop()?;
            waiting.extend(self.children(&next).into_iter().flatten().rev());
            Some(next)
        })
    }

    /// Returns up to `most` clusters, but at least one for each instant. They contain every light
    /// once, and are in the order of the lights. The cluster of the largest importance is split
    /// first; importance must not be negative.
    pub fn split(&self, most: usize, importance: impl Fn(&LightCluster) -> f64) -> Vec<LightCluster> {
        let mut chosen = Vec::new();
        // The order of non-negative numbers is that of their bits.
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

    /// The light at an index in the sorted order.
    pub fn light(&self, sorted: u32) -> Vpl {
        self.lights.get(sorted as usize)
    }

    /// All lights in sorted order.
    pub fn lights(&self) -> &LightRows {
        &self.lights
    }

    /// Number of lights of the set that were omitted because their luminance is zero.
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// Draws a light of a cluster by the uniform number `u` in `[0, 1)`, and returns its index in
    /// the sorted order. The probability of a light is its luminance divided by the cluster's.
    pub fn draw(&self, from: &LightCluster, u: f64) -> u32 {
        self.sums.draw(from.first, from.count, u)
    }

    /// Memory of nodes, lights and sums (bytes).
    pub fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<LightNode>() + self.lights.bytes() + self.sums.bytes()
    }
}
