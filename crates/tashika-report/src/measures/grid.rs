//! Numbers in rows, and weighted sums over the neighbourhood of each number.
//!
//! ```text
//! out(x, y) = Σ_i Σ_j  along_x(i) along_y(j) in(x + i, y + j)          −r ≤ i, j ≤ r
//! ```
//!
//! Beyond its edges a grid continues with its edge values. Sums run from the first weight to the
//! last, in double precision.

/// A grid of numbers, in rows.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub width: usize,
    pub height: usize,
    pub values: Vec<f64>,
}

/// `2r + 1` weights for the pixels at distances `−r` to `r`.
#[derive(Clone, Debug)]
pub(super) struct Weights(Vec<f64>);

impl Weights {
    /// Weights given by a function of the distance, from −r to r (pixels).
    pub(super) fn of(radius: usize, weight: impl Fn(f64) -> f64) -> Self {
        Self((0..=2 * radius).map(|i| weight(i as f64 - radius as f64)).collect())
    }

    pub(super) fn sum(&self) -> f64 {
        self.0.iter().sum()
    }

    /// Scales the weights to the sum 1.
    pub(super) fn normalized(self) -> Self {
        let sum = self.sum();
        Self(self.0.into_iter().map(|w| w / sum).collect())
    }

    /// Scales the positive weights to the sum 1, and the negative weights to the sum −1.
    pub(super) fn balanced(self) -> Self {
        let positive: f64 = self.0.iter().filter(|w| **w > 0.0).sum();
        let negative: f64 = -self.0.iter().filter(|w| **w < 0.0).sum::<f64>();
        Self(self.0.into_iter().map(|w| if w > 0.0 { w / positive } else { w / negative }).collect())
    }
}

impl Grid {
    /// A grid with `width` columns.
    pub(super) fn new(width: usize, values: impl Iterator<Item = f64>) -> Self {
        let values: Vec<f64> = values.collect();
        Self { width, height: values.len() / width, values }
    }

    /// A grid of other values, with this shape.
    fn filled(&self, values: Vec<f64>) -> Self {
        Self { width: self.width, height: self.height, values }
    }

    /// Combines two grids number by number.
    pub(super) fn with(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let values = self.values.iter().zip(&other.values).map(|(a, b)| f(*a, *b)).collect();
        self.filled(values)
    }

    /// Weighted sum over the neighbourhood of each number; see the module.
    pub(super) fn weighed(&self, along_x: &Weights, along_y: &Weights) -> Self {
        self.weighed_along_x(along_x).weighed_along_y(along_y)
    }

    fn weighed_along_x(&self, weights: &Weights) -> Self {
        let radius = weights.0.len() / 2;
        let mut values = vec![0.0; self.values.len()];
        let mut beyond = vec![0.0; self.width + 2 * radius];
        for (out, row) in values.chunks_exact_mut(self.width).zip(self.values.chunks_exact(self.width)) {
            beyond[..radius].fill(row[0]);
            beyond[radius..][..self.width].copy_from_slice(row);
            beyond[radius + self.width..].fill(row[self.width - 1]);
            for (i, weight) in weights.0.iter().enumerate() {
                add(out, *weight, &beyond[i..]);
            }
        }
        self.filled(values)
    }

    fn weighed_along_y(&self, weights: &Weights) -> Self {
        let radius = weights.0.len() / 2;
        let mut values = vec![0.0; self.values.len()];
        for (y, out) in values.chunks_exact_mut(self.width).enumerate() {
            for (i, weight) in weights.0.iter().enumerate() {
                let row = (y + i).saturating_sub(radius).min(self.height - 1);
                add(out, *weight, &self.values[row * self.width..]);
            }
        }
        self.filled(values)
    }
}

/// Adds `weight` times each number to its sum, for as many numbers as there are sums.
fn add(sums: &mut [f64], weight: f64, numbers: &[f64]) {
    for (sum, number) in sums.iter_mut().zip(numbers) {
        *sum += weight * number;
    }
}
