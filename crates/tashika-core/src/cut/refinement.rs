//! All pairs of a pixel's cuts, and the next pair to split: always the one of the highest rank.
//!
//! Splits can be planned ahead of any sample, since a [`Rank`] sees none.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::clusters::{Clusters, Pair, RadianceBound};
use super::rank::Rank;
use super::table::{TableEntry, TermTable};
use crate::bounds::UpperMaterial;

/// Options that decide which pairs are split, and in which order.
#[derive(Clone, Copy, Debug)]
pub struct RefinementOptions<'a> {
    /// The pair of the highest rank is split first.
    pub rank: Rank<'a>,
    /// Number of terms up to which a pair is not split, but evaluated as a whole. At least 1.
    pub finest: u64,
    /// Number of terms up to which a pair is tabulated when it is split, so that its halves are
    /// drawn from the table; 0 for no tables. Higher values need fewer bounds and fewer segments,
    /// but more terms to evaluate and to search.
    pub tabulated: u64,
}

impl RefinementOptions<'static> {
    /// Options of published methods: by bounds alone, down to single terms.
    pub const PUBLISHED: Self = Self { rank: Rank::Upper, finest: 1, tabulated: 0 };
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

/// Data of a pair, none of it from samples.
#[derive(Clone, Copy, Debug)]
pub struct PairInfo {
    /// `R`; zero if the pair contributes nothing.
    pub upper: RadianceBound,
    /// Approximate root mean square of a drawn term over `R`, if all terms were visible; not
    /// proven.
    pub importance_of_bound: f64,
    /// Place of the terms, if they are tabulated.
    pub table: Option<TableEntry>,
    /// True if the pair is evaluated as a whole.
    pub is_finest: bool,
    /// True if the pair gave way to its halves.
    pub is_split: bool,
}

impl PairInfo {
    /// Approximate root mean square of a drawn term, if all terms were visible; not proven
    /// (W·m⁻²·sr⁻¹).
    pub fn importance_size(&self) -> f64 {
        self.upper.0 * self.importance_of_bound
    }
}

/// All pairs that have been made so far, and those that can be split next.
#[derive(Debug)]
pub struct Refinement<'a, B> {
    clusters: Clusters<'a, B>,
    options: RefinementOptions<'a>,
    memory: &'a mut RefinementMemory,
    roots: usize,
}

/// Memory of a [`Refinement`], which the next one reuses.
#[derive(Clone, Debug, Default)]
pub struct RefinementMemory {
    table: TermTable,
    pairs: Vec<Pair>,
    infos: Vec<PairInfo>,
    /// Ranks as bits, which have the order of the ranks since none is negative, and numbers: of
    /// equal ranks, that of the older pair is the greater.
    waiting: BinaryHeap<(u64, Reverse<u32>)>,
}

impl<'a, B: UpperMaterial> Refinement<'a, B> {
    /// Creates the cut of a single pair, or one for each instant; `None` if the sum has no terms.
    pub fn new(
        clusters: Clusters<'a, B>,
        options: RefinementOptions<'a>,
        memory: &'a mut RefinementMemory,
    ) -> Option<Self> {
        memory.table.clear();
        memory.pairs.clear();
        memory.infos.clear();
        memory.waiting.clear();
        let mut refinement = Self { clusters, options, memory, roots: 0 };
        clusters.roots().for_each(|root| refinement.add(root, None));
        refinement.roots = refinement.memory.pairs.len();
        (refinement.roots > 0).then_some(refinement)
    }

    /// Clusters of which the pairs consist.
    pub fn clusters(&self) -> &Clusters<'a, B> {
        &self.clusters
    }

    /// Number of pairs before any was split: one for each instant.
    pub fn roots(&self) -> usize {
        self.roots
    }

    /// All pairs ever made, by number; the first are the roots.
    pub fn pairs(&self) -> &[Pair] {
        &self.memory.pairs
    }

    /// Data of a pair, by number.
    pub fn info(&self, pair: usize) -> &PairInfo {
        &self.memory.infos[pair]
    }

    /// Sum of the measures to which the probabilities of a pair's terms are proportional:
    /// `I_C W_G`, or `U` if the pair is tabulated. A drawn term contributes its value over its
    /// measure, times this weight.
    pub fn weight(&self, pair: usize) -> f64 {
        let weight = || self.clusters.weight(&self.memory.pairs[pair]);
        self.memory.infos[pair].table.map_or_else(weight, |entry| entry.total)
    }

    /// The terms of tabulated pairs.
    pub fn table(&self) -> &TermTable {
        &self.memory.table
    }

    /// Splits the pair of the highest rank; `None` if all pairs that are left are evaluated as a
    /// whole, or contribute nothing.
    pub fn split_next(&mut self) -> Option<Split> {
        let (rank, Reverse(parent)) = self.memory.waiting.pop()?;
        self.memory.infos[parent as usize].is_split = true;
        let children = self.memory.pairs.len() as u32;
        let pair = &self.memory.pairs[parent as usize];
        let halves = self.clusters.split(pair);
        let is_small = self.clusters.terms(pair) <= self.options.tabulated;
        // Many small pairs are never split: their tables would serve two terms.
        let new_table = || is_small.then(|| self.memory.table.add(&self.clusters, pair));
        if let Some(whole) = self.memory.infos[parent as usize].table.or_else(new_table) {
            // Tabulated pairs need no other bound.
            let entries = self.memory.table.halves(&self.clusters, &halves, &whole);
            for (half, entry) in halves.into_iter().zip(entries) {
                self.add(half, Some(entry));
            }
        } else {
            for half in halves {
                self.add(self.clusters.bounded(half), None);
            }
        }
        Some(Split { parent, children, rank: f64::from_bits(rank) })
    }

    /// Rank of the pair that would be split next; `None` if there is none.
    pub fn highest_rank(&self) -> Option<f64> {
        self.memory.waiting.peek().map(|(rank, _)| f64::from_bits(*rank))
    }

    fn add(&mut self, pair: Pair, table: Option<TableEntry>) {
        let (upper, terms) = match &table {
            Some(entry) => (entry.upper(), u64::from(entry.lit)),
            None => (self.clusters.upper(&pair), self.clusters.terms(&pair)),
        };
        let is_finest = terms <= self.options.finest;
        let mut info = PairInfo { upper, importance_of_bound: 1.0, table, is_finest, is_split: false };
        if upper.0 > 0.0 && !is_finest {
            if table.is_none() {
                info.importance_of_bound = self.clusters.importance_of_bound(&pair);
            }
            let rank = self.options.rank.of(&pair, &info);
            debug_assert!(rank >= 0.0);
            self.memory.waiting.push((rank.to_bits(), Reverse(self.memory.pairs.len() as u32)));
        }
        self.memory.infos.push(info);
        self.memory.pairs.push(pair);
    }
}
