//! Trees over lights and over gather points. Their nodes are clusters, each with a common bound,
//! from which members can be drawn.
//!
//! A pair of a light cluster `C` and a gather cluster `G` stands for
//! `Σ_{j∈G} Σ_{i∈C} w_j M_ji G_ji V_ji I_i`. It is either sampled, with `i` and `j` drawn in
//! proportion to `I_i` and `w_j`, or split into pairs of children. To support draws, every node is
//! a *range* of one sorted array: a draw is a short search in sums of weights, independent of the
//! size of the node.
//!
//! * [`LightTree`]: one per image, over 1 to 10⁸ lights of all kinds, built by one of two builders
//!   ([`LightTreeBuilder`]).
//! * [`LightSet`]: a set of lights with the tree over it.
//! * [`GatherTree`]: one per pixel, over 1 to 1024 points, with a bound of the material at each
//!   node.
//!
//! # Guarantee
//! The properties that the `validate()` method of each tree checks hold for any input with finite
//! positions. The tree is the same for any number of threads. No recursion is deeper than 100
//! calls. Lights and points of zero weight are omitted, so that every node has weight.
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
