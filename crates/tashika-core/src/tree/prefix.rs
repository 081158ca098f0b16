//! Sums of weights over ranges of items, and draws from a range in proportion to weight.
//!
//! ```text
//! weight of [a, b) = Σ_{a≤k<b} w_k        draw: the i in [a, b) with Σ_{a≤k<i} w_k ≤ u · weight < Σ_{a≤k≤i} w_k
//! ```
//!
//! Items are grouped in blocks of [`BLOCK`]. The sum of all weights before each block is stored as
//! the unevaluated sum of two `f64` (Higham 2002, section 4.3). The difference of two such sums is
//! accurate to a few units of 2⁻⁵³ of the difference *itself*, as long as it is above 2⁻¹⁰⁰ of the
//! sum of all weights. With a single `f64`, rounding of the sun's weight would swallow the weights
//! of dim lights. Within a block, weights are added up on demand. They lie in one cache line, and
//! the block sums of a million items fit into the cache of a core.
//!
//! # Guarantee
//! An item of zero weight is never drawn from a range that contains an item with weight. Held to
//! this by `tree::tests::drawing`.

use std::ops::Range;

/// Number of items in a block.
const BLOCK: usize = 16;

/// Weights, and their sums by blocks. Weights must be finite and not negative.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PrefixSums {
    weights: Vec<f32>,
    /// Sum of all weights before each block. There is one more entry than there are full blocks.
    below: Vec<[f64; 2]>,
}

/// A range of items, divided into the part before its first whole block, its whole blocks, and the
/// part after them.
struct Parts {
    head: Range<usize>,
    blocks: Range<usize>,
    tail: Range<usize>,
}

impl Parts {
    fn of(first: u32, count: u32) -> Self {
        let (begin, end) = (first as usize, first as usize + count as usize);
        if begin / BLOCK == end / BLOCK {
            return Self { head: begin..end, blocks: 0..0, tail: end..end };
        }
        let blocks = begin.div_ceil(BLOCK)..end / BLOCK;
        Self { head: begin..blocks.start * BLOCK, tail: blocks.end * BLOCK..end, blocks }
    }
}

impl PrefixSums {
    /// Sums up `weights`.
    pub(super) fn new(weights: impl Iterator<Item = f32>) -> Self {
        let weights: Vec<f32> = weights.collect();
        let mut sum = [0.0; 2];
        let below_block = |block: &[f32]| {
            let below = sum;
            sum = block.iter().fold(sum, |sum, weight| add(sum, f64::from(*weight)));
            below
        };
        // If the last block is full, an empty block follows, whose entry is the sum of all weights.
        let blocks = weights.chunks(BLOCK).chain(weights.len().is_multiple_of(BLOCK).then_some(&[][..]));
        Self { below: blocks.map(below_block).collect(), weights }
    }

    /// Number of weights.
    pub(super) fn len(&self) -> usize {
        self.weights.len()
    }

    /// Weights in the order of the items.
    pub(super) fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// Sum of the weights of `count` items, starting at `first`.
    pub(super) fn weight(&self, first: u32, count: u32) -> f64 {
        let Parts { head, blocks, tail } = Parts::of(first, count);
        self.of_items(head) + self.of_blocks(&blocks) + self.of_items(tail)
    }

    /// Draws one of `count` items, starting at `first`: the one into whose share of the weight `u`
    /// in `[0, 1)` falls.
    pub(super) fn draw(&self, first: u32, count: u32, u: f64) -> u32 {
        let Parts { head, blocks, tail } = Parts::of(first, count);
        let [of_head, of_blocks] = [self.of_items(head.clone()), self.of_blocks(&blocks)];
        let mut x = u * (of_head + of_blocks + self.of_items(tail.clone()));
        if x < of_head {
            return self.item_at(head, x).expect("what is above zero was reached") as u32;
        }
        x -= of_head;
        if x < of_blocks {
            let base = self.below[blocks.start];
            let is_before = |below: &[f64; 2]| difference(*below, base) <= x;
            let guess = (x / of_blocks * blocks.len() as f64) as usize;
            let block = blocks.start + last_before(&self.below[blocks], guess, is_before);
            x -= difference(self.below[block], base);
            let items = block * BLOCK..(block + 1) * BLOCK;
            return self.item_at(items, x).expect("a block that sums grow over has weight") as u32;
        }
        x -= of_blocks;
        // Because of rounding, `x` may be beyond the last item that has weight.
        let or_before = || (first as usize..tail.start).rfind(|item| self.weights[*item] > 0.0);
        self.item_at(tail.clone(), x).or_else(or_before).unwrap_or(first as usize) as u32
    }

    /// The item of a range at which the running sum of weights exceeds `x`, or the last item that
    /// has weight; `None` if no item has weight.
    fn item_at(&self, items: Range<usize>, x: f64) -> Option<usize> {
        let mut first = items.start;
        let mut sum = 0.0;
        // Skips four items at a time while the sum stays at most `x`.
        for four in self.weights[items.clone()].chunks_exact(4) {
            let next = sum + sum_of(four);
            if next > x {
                break;
            }
            (first, sum) = (first + 4, next);
        }
        for item in first..items.end {
            sum += f64::from(self.weights[item]);
            if sum > x && self.weights[item] > 0.0 {
                return Some(item);
            }
        }
        items.into_iter().rfind(|item| self.weights[*item] > 0.0)
    }

    fn of_items(&self, items: Range<usize>) -> f64 {
        self.weights[items].chunks(4).fold(0.0, |sum, four| sum + sum_of(four))
    }

    fn of_blocks(&self, blocks: &Range<usize>) -> f64 {
        if blocks.is_empty() { 0.0 } else { difference(self.below[blocks.end], self.below[blocks.start]) }
    }

    /// Memory of weights and sums (bytes).
    pub(super) fn bytes(&self) -> usize {
        self.weights.capacity() * size_of::<f32>() + self.below.capacity() * size_of::<[f64; 2]>()
    }
}

/// Sum of a few numbers; four numbers are added as two independent pairs.
fn sum_of(weights: &[f32]) -> f64 {
    match *weights {
        [a, b, c, d] => (f64::from(a) + f64::from(b)) + (f64::from(c) + f64::from(d)),
        _ => weights.iter().fold(0.0, |sum, weight| sum + f64::from(*weight)),
    }
}

/// Index of the last of ascending numbers for which `is_before` is true; it must be true for the
/// first.
///
/// Searches from a guess in doubling steps, and then by bisection. Numbers near the guess are
/// likely to be in the cache.
fn last_before<T>(numbers: &[T], guess: usize, is_before: impl Fn(&T) -> bool) -> usize {
    let guess = guess.min(numbers.len() - 1);
    let (mut low, mut high) = (guess, guess);
    let mut step = 1;
    if is_before(&numbers[guess]) {
        high = guess + 1;
        while high < numbers.len() && is_before(&numbers[high]) {
            (low, high) = (high, high + step);
            step *= 2;
        }
    } else {
        while low > 0 && !is_before(&numbers[low]) {
            (low, high) = (low.saturating_sub(step), low);
            step *= 2;
        }
    }
    low + numbers[low + 1..high.min(numbers.len())].partition_point(is_before)
}

/// Adds `x` to an unevaluated sum. The first number of the result is the rounded sum, the second
/// its rounding error.
fn add(sum: [f64; 2], x: f64) -> [f64; 2] {
    let [high, low] = two_sum(sum[0], x);
    two_sum(high, low + sum[1])
}

/// `a + b` without error: the rounded sum and its rounding error.
fn two_sum(a: f64, b: f64) -> [f64; 2] {
    let sum = a + b;
    let b_in_sum = sum - a;
    [sum, (a - (sum - b_in_sum)) + (b - b_in_sum)]
}

fn difference(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]) + (a[1] - b[1])
}
