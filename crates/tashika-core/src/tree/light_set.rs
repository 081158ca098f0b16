//! A set of VPLs together with the tree over it.

use std::sync::OnceLock;

use super::{LightTree, LightTreeBuilder};
use crate::vpl::{Provenance, VplSet};

/// A set of VPLs and the tree over it. The tree is built on first use, since summing over all
/// lights needs none.
#[derive(Clone, Debug)]
pub struct LightSet {
    set: VplSet,
    tree: OnceLock<LightTree>,
}

impl LightSet {
    /// Wraps a set. The tree is not built yet.
    pub fn new(set: VplSet) -> Self {
        Self { set, tree: OnceLock::new() }
    }

    /// The VPLs, without the tree.
    pub fn set(&self) -> &VplSet {
        &self.set
    }

    /// Origin of the VPLs.
    pub fn provenance(&self) -> &Provenance {
        self.set.provenance()
    }

    /// The tree over the set, built by the default builder. The first call builds it on the current
    /// thread pool.
    pub fn tree(&self) -> &LightTree {
        self.tree.get_or_init(|| LightTree::build(&self.set, LightTreeBuilder::default()))
    }
}

impl From<VplSet> for LightSet {
    fn from(set: VplSet) -> Self {
        Self::new(set)
    }
}
