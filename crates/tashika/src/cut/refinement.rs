//! The order in which a cut is refined: always the pair of the highest rank.
//!
//! Ranks are given by an [`Order`], which sees clusters and none of the samples that estimates are made of. The order of splits can
//! therefore be planned ahead of any sample, and samples drawn in pairs of the cut are independent of which pairs these are.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::clusters::{Clusters, Pair};
use crate::bounds::UpperMaterial;

/// Ranks pairs for refinement.
///
/// It is given no way to the samples of an estimate: that is what makes the partition independent of them.
pub trait Order {
    /// What is expected of a pair that can be split and has a positive bound.
    fn expect<B: UpperMaterial>(&mut self, clusters: &Clusters<'_, B>, pair: &Pair) -> Expectation;

    /// Terms up to which a pair is not split any more, but evaluated as a whole. At least 1.
    fn finest(&self) -> u64;
}

/// What an [`Order`] expects of a pair.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Expectation {
    /// The higher, the earlier the pair is split; not negative.
    pub rank: f64,
    /// About the largest luminance of a drawn term (W·m⁻²·sr⁻¹); at most the upper bound `R`, and unlike that not proven.
    pub importance_range: f64,
}

/// By upper bound `R`: the order of all published methods, and of certificates, which the largest bounds decide.
#[derive(Clone, Copy, Debug)]
pub struct ByUpper {
    /// Terms up to which a pair is not split any more. At least 1, which is what published methods do.
    pub finest: u64,
}

impl Order for ByUpper {
    fn expect<B: UpperMaterial>(&mut self, clusters: &Clusters<'_, B>, pair: &Pair) -> Expectation {
        let upper = clusters.upper(pair);
        Expectation { rank: upper, importance_range: upper }
    }

    fn finest(&self) -> u64 {
        self.finest
    }
}

/// One refinement: pair `parent` gives way to pairs `children` and `children + 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// Number of the pair that is split.
    pub parent: u32,
    /// Number of the first of its two children.
    pub children: u32,
    /// Rank of the parent: the highest of the cut before the split.
    pub rank: f64,
}

/// All pairs that have been made so far, and those that can be split next.
#[derive(Debug)]
pub struct Refinement<'a, B, O> {
    clusters: Clusters<'a, B>,
    order: O,
    pairs: Vec<Pair>,
    expectations: Vec<Expectation>,
    waiting: BinaryHeap<Waiting>,
}

/// A pair that can be split.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    rank: f64,
    pair: u32,
}

impl Ord for Waiting {
    /// By rank; of equals, the older pair is the greater.
    fn cmp(&self, other: &Self) -> Ordering {
        self.rank.total_cmp(&other.rank).then(other.pair.cmp(&self.pair))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Waiting {}

impl<'a, B: UpperMaterial, O: Order> Refinement<'a, B, O> {
    /// The cut of a single pair; `None` if the sum has no terms.
    pub fn new(clusters: Clusters<'a, B>, order: O) -> Option<Self> {
        let root = clusters.root()?;
        let mut refinement =
            Self { clusters, order, pairs: Vec::new(), expectations: Vec::new(), waiting: BinaryHeap::new() };
        refinement.add(root);
        Some(refinement)
    }

    /// What the pairs are pairs of.
    pub fn clusters(&self) -> &Clusters<'a, B> {
        &self.clusters
    }

    /// All pairs ever made, by number; the first is the root.
    pub fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// What is expected of a pair, by number; nothing of those that are not split.
    pub fn expectation(&self, pair: usize) -> &Expectation {
        &self.expectations[pair]
    }

    /// Whether a pair is evaluated as a whole.
    pub fn is_finest(&self, pair: &Pair) -> bool {
        self.clusters.terms(pair) <= self.order.finest()
    }

    /// Splits the pair of the highest rank; `None` if all that is left are pairs that are evaluated as a whole, or contribute nothing.
    pub fn split_next(&mut self) -> Option<Split> {
        let Waiting { rank, pair: parent } = self.waiting.pop()?;
        let children = self.pairs.len() as u32;
        for child in self.clusters.split(&self.pairs[parent as usize]) {
            self.add(child);
        }
        Some(Split { parent, children, rank })
    }

    /// Rank of the pair that would be split next; `None` if there is none.
    pub fn highest_rank(&self) -> Option<f64> {
        self.waiting.peek().map(|w| w.rank)
    }

    fn add(&mut self, pair: Pair) {
        let mut expectation = Expectation::default();
        if self.clusters.upper(&pair) > 0.0 && !self.is_finest(&pair) {
            expectation = self.order.expect(&self.clusters, &pair);
            self.waiting.push(Waiting { rank: expectation.rank, pair: self.pairs.len() as u32 });
        }
        self.expectations.push(expectation);
        self.pairs.push(pair);
    }
}
