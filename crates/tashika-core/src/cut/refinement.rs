//! All pairs of a pixel's cuts, and the next pair to split: the one of the highest rank.
//!
//! Splits can be planned before any sample is drawn, since a [`Rank`] depends on no sample.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::clusters::{Clusters, Pair, RadianceBound};
use super::rank::Rank;
use super::table::{TableEntry, TermTable};
use crate::bounds::UpperMaterial;

/// Options that decide which pairs are split, and in which order.
#[derive(Clone, Copy, Debug)]
pub struct RefinementOptions<'a> {
    /// Rank that orders the pairs; the pair of the highest rank is split first.
    pub rank: Rank<'a>,
    /// Largest number of terms of a pair that is evaluated as a whole instead of being split. At
    /// least 1.
    pub finest: u64,
    /// Largest number of terms of a pair that is tabulated when it is split, so that its halves are
    /// drawn from the table; 0 for no tables. With larger tables fewer bounds and fewer segments
    /// are needed, but more terms are evaluated and searched.
    pub tabulated: u64,
}

impl RefinementOptions<'static> {
    /// Options of published methods: ranked by bounds alone, and split down to single terms.
    pub const PUBLISHED: Self = Self { rank: Rank::Upper, finest: 1, tabulated: 0 };
}

/// One refinement: pair `parent` is replaced by pairs `children` and `children + 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// Number of the pair that is split.
    pub parent: u32,
    /// Number of the first of its two children.
    pub children: u32,
    /// Rank of the parent, the highest in the cut before the split.
    pub rank: f64,
}

/// Data of a pair, which depends on no sample.
#[derive(Clone, Copy, Debug)]
pub struct PairInfo {
    /// `R`; zero if the pair contributes nothing.
    pub upper: RadianceBound,
    /// Approximate ratio to `R` of the root mean square of a drawn term if all terms were visible.
    /// Not guaranteed.
    pub importance_of_bound: f64,
    /// Entry in the table of terms; `None` if the pair is not tabulated.
    pub table: Option<TableEntry>,
    /// True if the pair is evaluated as a whole.
    pub is_finest: bool,
    /// True if the pair has been replaced by its halves.
    pub is_split: bool,
}

impl PairInfo {
    /// Approximate root mean square of a drawn term if all terms were visible (W·m⁻²·sr⁻¹). Not
    /// guaranteed.
    pub fn importance_size(&self) -> f64 {
        self.upper.0 * self.importance_of_bound
    }
}

/// All pairs created so far, and the queue of those that can be split next.
#[derive(Debug)]
pub struct Refinement<'a, B> {
    clusters: Clusters<'a, B>,
    options: RefinementOptions<'a>,
    memory: &'a mut RefinementMemory,
    roots: usize,
}

/// Memory of a [`Refinement`], reused by the next one.
#[derive(Clone, Debug, Default)]
pub struct RefinementMemory {
    table: TermTable,
    pairs: Vec<Pair>,
    infos: Vec<PairInfo>,
    /// Ranks as bits, whose order is that of the ranks since none is negative, and pair numbers.
    /// Among equal ranks the older pair is split first.
    waiting: BinaryHeap<(u64, Reverse<u32>)>,
}

impl<'a, B: UpperMaterial> Refinement<'a, B> {
    /// Creates the initial cut of a single pair, or one for each instant; `None` if the sum has no
    /// terms.
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

    /// The clusters that form the pairs.
    pub fn clusters(&self) -> &Clusters<'a, B> {
        &self.clusters
    }

    /// Number of pairs before any was split: one for each instant.
    pub fn roots(&self) -> usize {
        self.roots
    }

    /// All pairs ever created, by number; the roots come first.
    pub fn pairs(&self) -> &[Pair] {
        &self.memory.pairs
    }

    /// Data of a pair, by number.
    pub fn info(&self, pair: usize) -> &PairInfo {
        &self.memory.infos[pair]
    }

    /// Sum over a pair's terms of the measures to which their probabilities are proportional:
    /// `I_C W_G`, or `U` if the pair is tabulated. The contribution of a drawn term is its value
    /// divided by its measure, times this sum.
    pub fn weight(&self, pair: usize) -> f64 {
        let weight = || self.clusters.weight(&self.memory.pairs[pair]);
        self.memory.infos[pair].table.map_or_else(weight, |entry| entry.total)
    }

    /// The terms of tabulated pairs.
    pub fn table(&self) -> &TermTable {
        &self.memory.table
    }

    /// Splits the pair of the highest rank. `None` if every remaining pair contributes nothing or
    /// is evaluated as a whole.
    pub fn split_next(&mut self) -> Option<Split> {
        let (rank, Reverse(parent)) = self.memory.waiting.pop()?;
        self.memory.infos[parent as usize].is_split = true;
        let children = self.memory.pairs.len() as u32;
        let pair = &self.memory.pairs[parent as usize];
        let halves = self.clusters.split(pair);
        let is_small = self.clusters.terms(pair) <= self.options.tabulated;
        // Tables are made only when a small pair is split. Many small pairs are never split; a
        // table would serve only two draws.
        let new_table = || is_small.then(|| self.memory.table.add(&self.clusters, pair));
        if let Some(whole) = self.memory.infos[parent as usize].table.or_else(new_table) {
            // The sum of the table is the bound of a tabulated pair.
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
