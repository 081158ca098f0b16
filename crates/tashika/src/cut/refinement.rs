//! The order in which a cut is refined: always the pair of the highest rank.
//!
//! Ranks are given by an [`Order`], which sees clusters and none of the samples that estimates are made of. The order of splits can
//! therefore be planned ahead of any sample, and samples drawn in pairs of the cut are independent of which pairs these are.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::clusters::{Clusters, Pair};
use super::listed::{Listed, ListedTerms, Listing};
use crate::bounds::UpperMaterial;

/// A pair that is to be ranked.
#[derive(Clone, Copy, Debug)]
pub struct Candidate<'a> {
    /// The pair.
    pub pair: &'a Pair,
    /// `R`: no drawn term has a higher luminance (W·m⁻²·sr⁻¹). Above zero.
    pub upper: f64,
    /// About the root mean square of a drawn term over `R`, were all of them visible; not proven.
    pub importance_of_bound: f64,
    /// Whether its terms are [listed](super::ListedTerms), so that visibility alone makes them differ.
    pub is_listed: bool,
}

/// Ranks pairs for refinement.
///
/// It is given no way to the samples of an estimate: that is what makes the partition independent of them.
pub trait Order {
    /// What is expected of a pair that can be split.
    fn expect(&mut self, candidate: &Candidate<'_>) -> Expectation;

    /// Terms up to which a pair is not split any more, but evaluated as a whole. At least 1.
    fn finest(&self) -> u64;
}

/// What an [`Order`] expects of a pair.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Expectation {
    /// The higher, the earlier the pair is split; not negative.
    pub rank: f64,
    /// About the share of the pair that is visible, in `[0, 1]`; not proven.
    pub importance_visibility: f64,
}

/// By upper bound `R`: the order of all published methods, and of certificates, which the largest bounds decide.
#[derive(Clone, Copy, Debug)]
pub struct ByUpper {
    /// Terms up to which a pair is not split any more. At least 1, which is what published methods do.
    pub finest: u64,
}

impl Order for ByUpper {
    fn expect(&mut self, candidate: &Candidate<'_>) -> Expectation {
        Expectation { rank: candidate.upper, importance_visibility: 1.0 }
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

/// What is known of a pair before anything is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// `R`, the luminance that no drawn term exceeds (W·m⁻²·sr⁻¹); zero if the pair contributes nothing.
    pub upper: f64,
    /// About the root mean square of a drawn term over `R`, were all of them visible; not proven.
    pub importance_of_bound: f64,
    /// Its terms, if they are listed.
    pub listed: Option<Listed>,
    /// Whether it is evaluated as a whole.
    pub is_finest: bool,
    /// What the order expects of it; nothing if it is not split.
    pub expectation: Expectation,
}

/// All pairs that have been made so far, and those that can be split next.
#[derive(Debug)]
pub struct Refinement<'a, B, O> {
    clusters: Clusters<'a, B>,
    order: O,
    listing: Option<Listing>,
    memory: &'a mut RefinementMemory,
}

/// Memory of a [`Refinement`], which the next one uses again.
#[derive(Clone, Debug, Default)]
pub struct RefinementMemory {
    terms: ListedTerms,
    pairs: Vec<Pair>,
    known: Vec<Known>,
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
    /// The cut of a single pair; `None` if the sum has no terms. Without `listing`, pairs are known by their bounds alone.
    pub fn new(
        clusters: Clusters<'a, B>,
        order: O,
        listing: Option<Listing>,
        memory: &'a mut RefinementMemory,
    ) -> Option<Self> {
        let root = clusters.root()?;
        memory.terms.clear();
        memory.pairs.clear();
        memory.known.clear();
        memory.waiting.clear();
        let mut refinement = Self { clusters, order, listing, memory };
        refinement.add_large(root);
        Some(refinement)
    }

    /// What the pairs are pairs of.
    pub fn clusters(&self) -> &Clusters<'a, B> {
        &self.clusters
    }

    /// All pairs ever made, by number; the first is the root.
    pub fn pairs(&self) -> &[Pair] {
        &self.memory.pairs
    }

    /// What is known of a pair, by number.
    pub fn known(&self, pair: usize) -> &Known {
        &self.memory.known[pair]
    }

    /// The terms of listed pairs.
    pub fn terms(&self) -> &ListedTerms {
        &self.memory.terms
    }

    /// Splits the pair of the highest rank; `None` if all that is left are pairs that are evaluated as a whole, or contribute nothing.
    pub fn split_next(&mut self) -> Option<Split> {
        let Waiting { rank, pair: parent } = self.memory.waiting.pop()?;
        let children = self.memory.pairs.len() as u32;
        let halves = self.clusters.split(&self.memory.pairs[parent as usize]);
        if let Some(whole) = self.memory.known[parent as usize].listed {
            // What is listed needs no other bound.
            let listed = self.memory.terms.halves(&self.clusters, &halves, &whole);
            for (half, listed) in halves.into_iter().zip(listed) {
                self.add(half, Some(listed));
            }
        } else {
            for half in halves {
                self.add_large(self.clusters.bounded(half));
            }
        }
        Some(Split { parent, children, rank })
    }

    /// Rank of the pair that would be split next; `None` if there is none.
    pub fn highest_rank(&self) -> Option<f64> {
        self.memory.waiting.peek().map(|w| w.rank)
    }

    /// Adds a pair that is not part of a listed one.
    fn add_large(&mut self, pair: Pair) {
        let listed = match &self.listing {
            Some(listing) if pair.upper > 0.0 => self.memory.terms.list(listing, &self.clusters, &pair),
            _ => None,
        };
        self.add(pair, listed);
    }

    fn add(&mut self, pair: Pair, listed: Option<Listed>) {
        let (upper, terms) = match &listed {
            Some(listed) => (listed.upper(), u64::from(listed.lit)),
            None => (self.clusters.upper(&pair), self.clusters.terms(&pair)),
        };
        let is_finest = terms <= self.order.finest();
        let mut known =
            Known { upper, importance_of_bound: 1.0, listed, is_finest, expectation: Expectation::default() };
        if upper > 0.0 && !is_finest {
            if listed.is_none() {
                known.importance_of_bound = self.clusters.importance_of_bound(&pair);
            }
            let importance_of_bound = known.importance_of_bound;
            let candidate =
                Candidate { pair: &pair, upper, importance_of_bound, is_listed: listed.is_some() };
            known.expectation = self.order.expect(&candidate);
            let waiting = Waiting { rank: known.expectation.rank, pair: self.memory.pairs.len() as u32 };
            self.memory.waiting.push(waiting);
        }
        self.memory.known.push(known);
        self.memory.pairs.push(pair);
    }
}
