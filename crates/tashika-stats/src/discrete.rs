//! Sampling from a list, or from a table, in proportion to weights.

use std::ops::Range;

use crate::math::simd::prefetch;

/// Average number of items for each part of the guide table.
const ITEMS_OF_PART: usize = 2;

/// A distribution over `0..len` in proportion to weights. An item is drawn in constant time on
/// average: a guide table gives the start of the search (Chen, Asau 1974).
#[derive(Clone, Debug)]
pub struct Discrete {
    /// `cumulative[i]` is the sum of weights below `i`; one entry more than there are weights.
    cumulative: Vec<f64>,
    /// The sum of all weights is divided into equal parts: the item that contains the start of each
    /// part.
    guide: Vec<u32>,
}

impl Discrete {
    /// The distribution of `weights`, which must be finite and not negative; `None` if they sum to
    /// zero.
    pub fn new(weights: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut cumulative = vec![0.0];
        let mut sum = 0.0;
        for w in weights {
            debug_assert!(w >= 0.0 && w.is_finite());
            sum += w;
            cumulative.push(sum);
        }
        (sum > 0.0).then(|| {
            let guide = guide(&cumulative);
            Self { cumulative, guide }
        })
    }

    /// Number of items.
    #[inline]
    pub fn len(&self) -> usize {
        self.cumulative.len() - 1
    }

    /// Returns true if there are no items: never, since weights sum to more than zero.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Sum of the weights.
    #[inline]
    pub fn total(&self) -> f64 {
        self.cumulative[self.len()]
    }

    /// Probability of drawing item `i`: its share of the sum of weights.
    #[inline]
    pub fn probability(&self, i: usize) -> f64 {
        (self.cumulative[i + 1] - self.cumulative[i]) / self.total()
    }

    /// Returns the item that `u` in `[0, 1)` falls into, its probability, and the position of `u`
    /// within the item. That position is uniform in `[0, 1)` and can be used as a random number
    /// again. Items of zero weight are never chosen.
    #[inline]
    pub fn sample(&self, u: f64) -> (usize, f64, f64) {
        let x = u * self.total();
        let mut i = self.guide[self.part_of(u)] as usize;
        // By rounding, `u` may have been assigned to the next part.
        while self.cumulative[i] > x {
            i -= 1;
        }
        while i + 1 < self.len() && self.cumulative[i + 1] <= x {
            i += 1;
        }
        self.item_at(x, i, 0)
    }

    /// Part of the guide table for a number in `[0, 1)`.
    #[inline]
    fn part_of(&self, u: f64) -> usize {
        let parts = self.guide.len();
        ((u * parts as f64) as usize).min(parts - 1)
    }

    /// Reads ahead the entry of the guide table that [`Self::sample`] reads first.
    #[inline]
    pub fn read_guide_ahead(&self, u: f64) {
        prefetch(&self.guide[self.part_of(u)]);
    }

    /// Reads ahead the sums at which the search of [`Self::sample`] starts, once the entry of the
    /// guide table has arrived.
    #[inline]
    pub fn read_items_ahead(&self, u: f64) {
        prefetch(&self.cumulative[self.guide[self.part_of(u)] as usize]);
    }

    /// Like [`Self::sample`], restricted to `items`, whose weights must not all be zero. The
    /// returned probability is that of drawing the item from the whole list.
    pub fn sample_within(&self, items: Range<usize>, u: f64) -> (usize, f64, f64) {
        let Range { start, end } = items;
        let below = self.cumulative[start];
        let x = below + u * (self.cumulative[end] - below);
        // Finds the last boundary that is not beyond x. A boundary beyond x follows it, since x is
        // below the last boundary.
        let boundaries = &self.cumulative[start..=end];
        let last = boundaries.partition_point(|&c| c <= x).saturating_sub(1);
        self.item_at(x, (start + last).min(end - 1), start)
    }

    /// Item `i`, in which the sum of weights reaches `x`, or the nearest item with weight before
    /// it, down to `first`.
    fn item_at(&self, x: f64, mut i: usize, first: usize) -> (usize, f64, f64) {
        while self.cumulative[i + 1] <= self.cumulative[i] && i > first {
            i -= 1;
        }
        let width = self.cumulative[i + 1] - self.cumulative[i];
        let rest = ((x - self.cumulative[i]) / width).clamp(0.0, 1.0 - f64::EPSILON);
        (i, width / self.total(), rest)
    }
}

/// Guide table of cumulative sums that end above zero.
fn guide(cumulative: &[f64]) -> Vec<u32> {
    let items = cumulative.len() - 1;
    let parts = items.div_ceil(ITEMS_OF_PART);
    let mut item = 0;
    let entry = |part: usize| {
        let x = part as f64 / parts as f64 * cumulative[items];
        while item + 1 < items && cumulative[item + 1] <= x {
            item += 1;
        }
        item as u32
    };
    (0..parts).map(entry).collect()
}

/// A density over `[0, 1]²`, constant in each cell of a table.
#[derive(Clone, Debug)]
pub struct Piecewise2d {
    rows: Discrete,
    /// Distribution inside each row; `None` for rows of zero weight.
    columns: Vec<Option<Discrete>>,
    width: usize,
}

/// A rectangle of cells of a [`Piecewise2d`].
#[derive(Clone, Debug)]
pub struct Block {
    columns: Range<usize>,
    first_row: usize,
    by_row: Discrete,
    probability: f64,
}

impl Block {
    /// Probability that a point of the whole table lies in the block.
    #[inline]
    pub fn probability(&self) -> f64 {
        self.probability
    }
}

impl Piecewise2d {
    /// The density in proportion to `weights`, row by row; `None` if they sum to zero.
    pub fn new(weights: &[f64], width: usize) -> Option<Self> {
        let columns: Vec<Option<Discrete>> =
            weights.chunks(width).map(|row| Discrete::new(row.iter().copied())).collect();
        let rows = Discrete::new(columns.iter().map(|c| c.as_ref().map_or(0.0, Discrete::total)))?;
        Some(Self { rows, columns, width })
    }

    /// A point of `[0, 1)²` as `(x, y)`, and its density.
    pub fn sample(&self, u: [f64; 2]) -> ([f64; 2], f64) {
        let (y, row_probability, in_row) = self.rows.sample(u[1]);
        let row = self.columns[y].as_ref().expect("a chosen row has weight");
        let (x, probability, in_column) = row.sample(u[0]);
        let height = self.columns.len() as f64;
        let point = [(x as f64 + in_column) / self.width as f64, (y as f64 + in_row) / height];
        (point, row_probability * probability * self.width as f64 * height)
    }

    /// Row that [`Self::sample`] draws.
    #[inline]
    fn row_of(&self, u: f64) -> &Discrete {
        self.columns[self.rows.sample(u).0].as_ref().expect("a chosen row has weight")
    }

    /// Reads ahead like [`Discrete::read_guide_ahead`], in the row that [`Self::sample`] draws.
    #[inline]
    pub fn read_guide_ahead(&self, u: [f64; 2]) {
        self.row_of(u[1]).read_guide_ahead(u[0]);
    }

    /// Reads ahead like [`Discrete::read_items_ahead`], in the row that [`Self::sample`] draws.
    #[inline]
    pub fn read_items_ahead(&self, u: [f64; 2]) {
        self.row_of(u[1]).read_items_ahead(u[0]);
    }

    /// Reads ahead for [`Self::pdf`] at a point.
    #[inline]
    pub fn read_ahead_at(&self, point: [f64; 2]) {
        let [x, y] = self.cell_of(point);
        if let Some(row) = &self.columns[y] {
            prefetch(&row.cumulative[x]);
        }
    }

    /// Column and row of the cell that contains a point of `[0, 1]²`.
    #[inline]
    fn cell_of(&self, point: [f64; 2]) -> [usize; 2] {
        let cell = |v: f64, n: usize| ((v * n as f64) as usize).min(n - 1);
        [cell(point[0], self.width), cell(point[1], self.columns.len())]
    }

    /// Number of cells of a row and of a column.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.columns.len()]
    }

    /// Block of the given columns and rows; `None` if its cells have zero weight.
    pub fn block(&self, [columns, rows]: [Range<usize>; 2]) -> Option<Block> {
        let row = |y: usize| {
            let of_cells = |row: &Discrete| row.cumulative[columns.end] - row.cumulative[columns.start];
            self.columns[y].as_ref().map_or(0.0, of_cells)
        };
        let by_row = Discrete::new(rows.clone().map(row))?;
        let probability = by_row.total() / self.rows.total();
        Some(Block { columns, first_row: rows.start, by_row, probability })
    }

    /// Like [`Piecewise2d::sample`], restricted to a block. The returned density is that of the
    /// whole table.
    pub fn sample_in(&self, block: &Block, u: [f64; 2]) -> ([f64; 2], f64) {
        let (row, _, in_row) = block.by_row.sample(u[1]);
        let y = block.first_row + row;
        let row = self.columns[y].as_ref().expect("a chosen row has weight");
        let (x, probability, in_column) = row.sample_within(block.columns.clone(), u[0]);
        let [width, height] = self.size().map(|side| side as f64);
        let point = [(x as f64 + in_column) / width, (y as f64 + in_row) / height];
        (point, self.rows.probability(y) * probability * width * height)
    }

    /// Inverse of [`Piecewise2d::sample`]: the numbers for a point of `[0, 1)²`; arbitrary where
    /// the density is zero.
    pub fn inverse(&self, point: [f64; 2]) -> [f64; 2] {
        let [width, height] = self.size().map(|side| side as f64);
        let within = |d: &Discrete, at: f64| {
            let i = (at as usize).min(d.len() - 1);
            let part = (at - i as f64).clamp(0.0, 1.0) * (d.cumulative[i + 1] - d.cumulative[i]);
            ((d.cumulative[i] + part) / d.total()).min(1.0f64.next_down())
        };
        let row = &self.columns[((point[1] * height) as usize).min(self.columns.len() - 1)];
        [row.as_ref().map_or(0.0, |row| within(row, point[0] * width)), within(&self.rows, point[1] * height)]
    }

    /// Density at a point of `[0, 1)²`.
    pub fn pdf(&self, point: [f64; 2]) -> f64 {
        let height = self.columns.len();
        let [x, y] = self.cell_of(point);
        self.columns[y]
            .as_ref()
            .map_or(0.0, |row| self.rows.probability(y) * row.probability(x) * (self.width * height) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary;
    use crate::rng::{Purpose, Stream};

    #[test]
    fn items_are_chosen_in_proportion_and_empty_ones_never() {
        let d = Discrete::new([0.0, 1.0, 0.0, 3.0, 0.0]).unwrap();
        let n = 4000;
        let mut counts = [0; 5];
        for k in 0..n {
            let (i, p, rest) = d.sample((f64::from(k) + 0.5) / f64::from(n));
            assert!((0.0..1.0).contains(&rest));
            assert_eq!(p, d.probability(i));
            counts[i] += 1;
        }
        assert_eq!(counts, [0, 1000, 0, 3000, 0]);
        assert_eq!(d.sample(1.0).0, 3, "a rounded-up u stays inside");
        assert!(Discrete::new([0.0]).is_none() && Discrete::new([]).is_none());
    }

    /// Random weights that differ by orders of magnitude; many are zero. A search that starts from
    /// the guide table finds the same item as a search of the whole list.
    #[test]
    fn items_are_found_where_a_search_finds_them() {
        let mut s = Stream::new(1, Purpose::Test, 0);
        for round in 0..300 {
            let count = 1 + s.below(1 << (round % 10)) as usize;
            let mut weight =
                || if s.below(3) == 0 { 0.0 } else { elementary::exp_f64(20.0 * s.uniform_f64()) };
            let weights: Vec<f64> = (0..count).map(|_| weight()).collect();
            let Some(d) = Discrete::new(weights) else { continue };
            for _ in 0..200 {
                let u = s.uniform_f64();
                assert_eq!(d.sample(u), d.sample_within(0..count, u), "{u} of {count}");
            }
            // Numbers exactly at the boundaries of items, and their neighbours.
            for i in 0..count {
                let at = d.cumulative[i] / d.total();
                for u in [at.next_down().max(0.0), at, at.next_up()] {
                    assert_eq!(d.sample(u), d.sample_within(0..count, u), "{u} of {count}");
                }
            }
        }
    }

    /// Points sampled in a block lie in the block, with the density of the whole table. Each cell
    /// of the block receives its share of the points.
    #[test]
    fn blocks_are_sampled_with_the_density_of_the_table() {
        let t = Piecewise2d::new(&[1.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0, 1.0, 1.0], 3).unwrap();
        let block = t.block([1..3, 1..3]).unwrap();
        assert_eq!(block.probability(), 2.0 / 8.0);
        let mut on_the_left = 0;
        for k in 0..100 {
            let (point, pdf) = t.sample_in(&block, [(f64::from(k) + 0.5) / 100.0, 0.37]);
            assert!((point[0] > 1.0 / 3.0 && point[1] > 2.0 / 3.0) && (pdf - t.pdf(point)).abs() < 1e-12);
            on_the_left += u32::from(point[0] < 2.0 / 3.0);
        }
        assert_eq!(on_the_left, 50);
        assert!(t.block([0..3, 1..2]).is_none(), "nothing in the middle row");
    }

    #[test]
    fn a_table_is_sampled_with_its_own_density() {
        let t = Piecewise2d::new(&[1.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0, 1.0, 1.0], 3).unwrap();
        let mut mass = 0.0;
        let n = 300;
        for a in 0..n {
            for b in 0..n {
                let u = [(f64::from(a) + 0.5) / f64::from(n), (f64::from(b) + 0.5) / f64::from(n)];
                let (p, pdf) = t.sample(u);
                assert!((t.pdf(p) - pdf).abs() < 1e-12 && pdf > 0.0);
                mass += t.pdf(u) / f64::from(n * n);
            }
        }
        assert!((mass - 1.0).abs() < 1e-9, "the density integrates to one");
        for u in [[0.1, 0.7], [0.5, 0.1], [0.99, 0.99]] {
            let back = t.inverse(t.sample(u).0);
            assert!((0..2).all(|k| (back[k] - u[k]).abs() < 1e-12), "{u:?} {back:?}");
        }
        assert!(t.inverse([0.5, 0.5]).iter().all(|u| (0.0..1.0).contains(u)), "nothing is drawn there");
    }
}
