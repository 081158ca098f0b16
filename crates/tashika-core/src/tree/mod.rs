//! Trees over lights and over gather points: clusters that are bounded as one, and drawn from as
//! one.
//!
//! A pair of a light cluster `C` and a gather cluster `G` stands for
//! `Σ_{j∈G} Σ_{i∈C} w_j M_ji G_ji V_ji I_i`; it is either sampled, with `i` and `j` drawn in
//! proportion to `I_i` and `w_j`, or split into pairs of children. For this every node is a *range*
//! of one sorted array: a draw is a short search in sums of weights, whatever the size of the node.
//!
//! * [`LightTree`]: one for an image, over 1 to 10⁸ lights of all kinds, by one of two builders
//!   ([`LightTreeBuilder`]).
//! * [`LightSet`]: a set of lights with the tree over it.
//! * [`GatherTree`]: one for a pixel, over 1 to 1024 points, with a bound of the material at each
//!   node.
//!
//! # Guarantee
//! The properties that `validate()` of each checks hold for any input with finite positions; the
//! tree is the same for any number of threads; no recursion is deeper than 100 calls. Lights and
//! points of zero weight are omitted, so that every node has weight.
//!
//! # Held to this by
//! `tree::tests`.

mod agglomerative;
mod build;
mod gather_tree;
mod light_set;
mod light_tree;
mod partners;
mod prefix;
mod saoh;
mod top_down;
mod validate;

#[cfg(test)]
mod tests;

pub use gather_tree::{GatherNode, GatherTree};
pub use light_set::LightSet;
pub use light_tree::{LightCluster, LightTree, LightTreeBuilder};
