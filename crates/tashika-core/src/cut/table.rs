//! Tables of small pairs: the unoccluded contribution of every term.
//!
//! ```text
//! u_ij = luminance of w_j M_ji G_ji I_i          U = Σ u_ij over the terms of the pair
//! ```
//!
//! A term is drawn with probability `u_ij / U` and divided by that probability. Its luminance is
//! then `U V_ij`, which is in `[0, U]` and varies by visibility alone. `U` is the smallest bound of
//! a pair that needs no ray. Bounds of clusters are several times larger, and cost as much as
//! evaluating a hundred terms.
//!
//! Terms are evaluated once, when a sufficiently small pair is split. All its descendants read
//! their values from the table.

use smallvec::SmallVec;

use super::clusters::{Clusters, Pair, RadianceBound};
use super::terms::Term;
use crate::bounds::UpperMaterial;

/// Factor larger than the relative rounding error of `f32` products of a dozen factors. It keeps
/// `U` above the sum of the exact terms.
const ROUNDING: f64 = 1.0 + 1.0 / 262_144.0;

/// If a remainder is a smaller share than this of the sum that was computed by addition, it is
/// computed by addition, too, instead of by subtraction. Parts and remainders have the rounding
/// errors of that original sum: a few 2⁻⁵³ of it for each level. Relative to a share of 2⁻¹⁶ this
/// is far less than [`ROUNDING`] allows.
const LEAST_SHARE: f64 = 1.0 / 65_536.0;

/// Location of the terms of a tabulated pair, and their sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableEntry {
    block: u32,
    /// Number of terms above zero.
    pub lit: u32,
    /// `U` (W·m⁻²·sr⁻¹).
    pub total: f64,
    /// The sum from which `total` was obtained by subtraction; `total` itself if it was computed by
    /// addition.
    added_up: f64,
}

impl TableEntry {
    /// `U`, rounded up.
    pub fn upper(&self) -> RadianceBound {
        RadianceBound(self.total * ROUNDING)
    }
}

/// Location of the values of a tabulated pair and its descendants: point by point, and for each
/// point all lights.
#[derive(Clone, Copy, Debug)]
struct Block {
    values: u32,
    first_light: u32,
    first_point: u32,
    lights: u32,
}

/// Values of all pairs that have been tabulated.
#[derive(Clone, Debug, Default)]
pub struct TermTable {
    values: Vec<f32>,
    blocks: Vec<Block>,
}

impl TermTable {
    /// Removes all pairs; keeps the allocated memory.
    pub fn clear(&mut self) {
        self.values.clear();
        self.blocks.clear();
    }

    /// Evaluates and stores all terms of a pair.
    pub fn add<B: UpperMaterial>(&mut self, clusters: &Clusters<'_, B>, pair: &Pair) -> TableEntry {
        let (points, lights) = clusters.members(pair);
        let (block, values) = (self.blocks.len() as u32, self.values.len() as u32);
        let members = &clusters.points.points()[points.clone()];
        clusters.contribution.list(members, clusters.lights.lights(), lights.clone(), &mut self.values);
        self.blocks.push(Block {
            values,
            first_light: lights.start as u32,
            first_point: points.start as u32,
            lights: lights.len() as u32,
        });
        self.sum(clusters, pair, block)
    }

    /// Returns the entries of the halves of a tabulated pair.
    pub fn halves<B: UpperMaterial>(
        &self,
        clusters: &Clusters<'_, B>,
        halves: &[Pair; 2],
        whole: &TableEntry,
    ) -> [TableEntry; 2] {
        let smaller = usize::from(clusters.terms(&halves[1]) < clusters.terms(&halves[0]));
        let one = self.sum(clusters, &halves[smaller], whole.block);
        let lit = whole.lit - one.lit;
        let total = if lit > 0 { whole.total - one.total } else { 0.0 };
        let mut other = TableEntry { block: whole.block, lit, total, added_up: whole.added_up };
        // If the difference is small, cancellation could make it less than the sum of its terms.
        if lit > 0 && total < LEAST_SHARE * whole.added_up {
            other = self.sum(clusters, &halves[1 - smaller], whole.block);
        }
        if smaller == 0 { [one, other] } else { [other, one] }
    }

    fn sum<B: UpperMaterial>(&self, clusters: &Clusters<'_, B>, pair: &Pair, block: u32) -> TableEntry {
        let (mut total, mut lit) = (0.0, 0);
        for (_, row) in self.rows(clusters, pair, block) {
            let (of_row, above) = sum_of(row);
            total += of_row;
            lit += above;
        }
        TableEntry { block, lit, total, added_up: total }
    }

    /// Upper bound of `u_ij / (I_i w_j)` in a tabulated pair. It equals the largest value, except
    /// for rounding (m⁻²·sr⁻¹).
    pub fn largest_share<B: UpperMaterial>(
        &self,
        clusters: &Clusters<'_, B>,
        pair: &Pair,
        entry: &TableEntry,
    ) -> f64 {
        let luminances = &clusters.lights.luminances()[clusters.members(pair).1];
        let inverse: SmallVec<[f32; 64]> = luminances.iter().map(|luminance| 1.0 / luminance).collect();
        let mut largest = 0.0_f64;
        for (point, row) in self.rows(clusters, pair, entry.block) {
            let weight = f64::from(clusters.points.point(point).weight.max_channel());
            largest = largest.max(f64::from(largest_product(row, &inverse)) / weight);
        }
        largest * ROUNDING
    }

    /// Values of a pair that is part of a block: for each point, its index and a slice with one
    /// value per light.
    fn rows<B: UpperMaterial>(
        &self,
        clusters: &Clusters<'_, B>,
        pair: &Pair,
        block: u32,
    ) -> impl Iterator<Item = (u32, &[f32])> {
        let block = &self.blocks[block as usize];
        let (points, lights) = clusters.members(pair);
        points.map(move |point| {
            let row = block.values as usize + (point - block.first_point as usize) * block.lights as usize;
            let first = row + lights.start - block.first_light as usize;
            (point as u32, &self.values[first..first + lights.len()])
        })
    }

    /// Unoccluded value `u` of one term of a tabulated pair (W·m⁻²·sr⁻¹).
    pub fn unoccluded(&self, entry: &TableEntry, term: Term) -> f64 {
        let block = &self.blocks[entry.block as usize];
        let row = block.values + (term.point - block.first_point) * block.lights;
        let place = row + term.light - block.first_light;
        f64::from(self.values[place as usize])
    }

    /// Draws a term of a pair by the uniform number `x` in `[0, 1)`. At least one term of the pair
    /// must be above zero. The probability of a term is `u / Σ u`.
    pub fn draw<B: UpperMaterial>(
        &self,
        clusters: &Clusters<'_, B>,
        pair: &Pair,
        entry: &TableEntry,
        x: f64,
    ) -> Term {
        let first_light = clusters.members(pair).1.start as u32;
        let mut left = x * entry.total;
        let mut last = None;
        for (point, row) in self.rows(clusters, pair, entry.block) {
            for (some, first) in row.chunks(SKIPPED).zip((first_light..).step_by(SKIPPED)) {
                let (sum, lit) = sum_of(some);
                if lit == 0 {
                    continue;
                }
                last = Some((point, first, some));
                if left < sum {
                    return drawn_of(point, first, some, left);
                }
                left -= sum;
            }
        }
        // If rounding makes the draw exceed the sum, the term is taken from the last chunk that has
        // terms above zero.
        let (point, first, some) = last.expect("something of the pair is above zero");
        drawn_of(point, first, some, f64::INFINITY)
    }
}

/// Number of values that a draw skips at a time.
const SKIPPED: usize = 32;

/// The largest of the elementwise products of two slices; zero if none is positive.
fn largest_product(a: &[f32], b: &[f32]) -> f32 {
    let mut largest = [0.0_f32; 8];
    let ((a, rest_of_a), (b, rest_of_b)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    for (a, b) in a.iter().zip(b) {
        for i in 0..8 {
            largest[i] = if a[i] * b[i] > largest[i] { a[i] * b[i] } else { largest[i] };
        }
    }
    let rest = rest_of_a.iter().zip(rest_of_b).map(|(a, b)| a * b);
    largest.into_iter().chain(rest).fold(0.0, f32::max)
}

/// Sum of values, and the number of values above zero.
fn sum_of(values: &[f32]) -> (f64, u32) {
    // Eight independent sums, which can be computed in parallel.
    let mut sums = [0.0; 8];
    let (eights, rest) = values.as_chunks::<8>();
    for eight in eights {
        for i in 0..8 {
            sums[i] += f64::from(eight[i]);
        }
    }
    for (sum, &value) in sums.iter_mut().zip(rest) {
        *sum += f64::from(value);
    }
    let lit = values.iter().map(|&value| u32::from(value > 0.0)).sum();
    (((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7])), lit)
}

/// Term at which the running sum of `values` exceeds `left`, or the last term above zero if none
/// does. The first value belongs to light `first`.
fn drawn_of(point: u32, first: u32, values: &[f32], mut left: f64) -> Term {
    let mut drawn = first;
    for (light, &value) in (first..).zip(values) {
        if value > 0.0 {
            drawn = light;
            left -= f64::from(value);
            if left < 0.0 {
                break;
            }
        }
    }
    Term { light: drawn, point }
}
