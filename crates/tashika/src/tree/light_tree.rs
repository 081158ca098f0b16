//! The light tree: a binary tree over the lights, in which every node is a range of one sorted array.

use super::build;
use super::prefix::PrefixSums;
use crate::bounds::LightBounds;
use crate::color::Rgb;
use crate::vpl::{Vpl, VplSet};

/// How a light tree is built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum LightTreeBuilder {
    /// From the root, by the surface area orientation heuristic (Conty Estévez, Kulla 2018).
    TopDown,
    /// From the lights, always joining neighbours that cost little by the metric of Walter 2005.
    #[default]
    Agglomerative,
}

/// A cluster of lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightNode {
    /// Where the lights are, and where they shine.
    pub bounds: LightBounds,
    /// Sum of the intensities; added up in pairs in `f32`.
    pub intensity: Rgb,
    /// Sum of the luminances of the intensities; above zero.
    pub luminance: f64,
    /// First light, in sorted order.
    pub first: u32,
    /// How many lights; one in a leaf.
    pub count: u32,
    /// Children, of which the first holds the first lights; `None` in a leaf.
    pub children: Option<[u32; 2]>,
}

/// A tree over the lights of a set, all kinds under one root.
///
/// Nodes are in depth-first order: the root is the first, and children have larger numbers than their parent.
#[derive(Clone, Debug)]
pub struct LightTree {
    pub(super) nodes: Vec<LightNode>,
    pub(super) lights: Vec<Vpl>,
    pub(super) sums: PrefixSums,
    dropped: usize,
}

impl LightTree {
    /// The tree over those lights of `set` that have luminance; others add nothing to any image and are left out.
    ///
    /// Runs on the current thread pool; the result does not depend on it. The set must have fewer than 2³¹ lights.
    pub fn build(set: &VplSet, builder: LightTreeBuilder) -> Self {
        let build::Sorted { lights, spans } = build::sort(set.lights(), builder);
        let sums = PrefixSums::new(lights.iter().map(|light| light.intensity.luminance()));
        let nodes = build::nodes(&lights, &spans);
        Self { nodes, dropped: set.len() - lights.len(), lights, sums }
    }

    /// All nodes.
    pub fn nodes(&self) -> &[LightNode] {
        &self.nodes
    }

    /// Number of the root; `None` if there are no lights.
    pub fn root(&self) -> Option<u32> {
        (!self.nodes.is_empty()).then_some(0)
    }

    /// The light at a place in the sorted order.
    pub fn light(&self, sorted: u32) -> &Vpl {
        &self.lights[sorted as usize]
    }

    /// All lights in sorted order.
    pub fn lights(&self) -> &[Vpl] {
        &self.lights
    }

    /// How many lights of the set have no luminance and are not in the tree.
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// A light of a node for the uniform number `u` in `[0, 1)`, as its place in the sorted order; its probability is its luminance
    /// over the node's.
    pub fn draw(&self, node: u32, u: f64) -> u32 {
        let node = &self.nodes[node as usize];
        self.sums.draw(node.first, node.count, u)
    }

    /// Memory (bytes).
    pub fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<LightNode>()
            + self.lights.capacity() * size_of::<Vpl>()
            + self.sums.bytes()
    }
}
