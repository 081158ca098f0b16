//! Sums of the first `i` weights, from which an item of any range is drawn by a guess and a short search.
//!
//! ```text
//! S_i = Σ_{k<i} w_k        weight of [a, b) = S_b − S_a        draw: the i in [a, b) with S_i − S_a ≤ u (S_b − S_a) < S_{i+1} − S_a
//! ```
//!
//! Each `S_i` is the unevaluated sum of two `f64` (Higham 2002, section 4.3), so that the difference of two is accurate to a few units
//! of 2⁻⁵³ of *itself*, as long as it is above 2⁻¹⁰⁰ of the sum of all weights. With a single `f64`, the weights of dim
//! lights beside the sun would be lost in the rounding of the sun's.
//!
//! # Guarantee
//! An item of zero weight is never drawn from a range that holds another. Held to this by `tree::tests::drawing`.

/// Items in a line of the cache: the first step from a guess.
const NEXT_TO: usize = 4;

/// Sums of weights that are finite and not negative; one entry more than there are weights.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PrefixSums(Vec<[f64; 2]>);

impl PrefixSums {
    /// The sums of `weights`.
    pub(super) fn new(weights: impl ExactSizeIterator<Item = f32>) -> Self {
        let mut sums = Vec::with_capacity(weights.len() + 1);
        let mut sum = [0.0; 2];
        sums.push(sum);
        for weight in weights {
            sum = add(sum, f64::from(weight));
            sums.push(sum);
        }
        Self(sums)
    }

    /// How many weights there are.
    pub(super) fn len(&self) -> usize {
        self.0.len() - 1
    }

    /// Weight of `count` items from `first`.
    pub(super) fn weight(&self, first: u32, count: u32) -> f64 {
        difference(self.0[first as usize + count as usize], self.0[first as usize])
    }

    /// The item among `count` from `first` that `u` in `[0, 1)` falls into.
    pub(super) fn draw(&self, first: u32, count: u32, u: f64) -> u32 {
        let begin = first as usize;
        let total = self.weight(first, count);
        // Rounding can make u·total as large as total, which is beyond the last item.
        let x = (u * total).min(total.next_down());
        first + self.last_before(begin, count as usize, x, total) as u32
    }

    /// The last of `count` items from `begin` that begins at or before `x`, which is not negative and less than their weight.
    ///
    /// Weights are seldom very different, so that where it is can be guessed; each place that is looked at is likely to be a line of memory that is not
    /// in the cache.
    fn last_before(&self, begin: usize, count: usize, x: f64, total: f64) -> usize {
        let is_before = |item: usize| difference(self.0[begin + item], self.0[begin]) <= x;
        let items = count as f64 / total;
        let mut guess = (x * items) as usize;
        let off = x - difference(self.0[begin + guess.min(count)], self.0[begin]);
        guess = (guess as f64 + off * items).clamp(0.0, (count - 1) as f64) as usize;
        // Steps that double, until it is between two of them.
        let mut step = NEXT_TO;
        let (mut low, mut high) = (guess, guess);
        if is_before(guess) {
            high = count.min(guess + 1);
            while high < count && is_before(high) {
                (low, high) = (high, count.min(high + step));
                step *= 2;
            }
        } else {
            while !is_before(low) {
                (low, high) = (low.saturating_sub(step), low);
                step *= 2;
            }
        }
        low + self.0[begin + low + 1..begin + high]
            .partition_point(|&sum| difference(sum, self.0[begin]) <= x)
    }

    /// Memory (bytes).
    pub(super) fn bytes(&self) -> usize {
        self.0.capacity() * size_of::<[f64; 2]>()
    }
}

/// `sum + x`; the first number of the result is the sum rounded, the second what rounding took.
fn add(sum: [f64; 2], x: f64) -> [f64; 2] {
    let [high, low] = two_sum(sum[0], x);
    two_sum(high, low + sum[1])
}

/// `a + b` without error, as what rounds to the sum and what is left.
fn two_sum(a: f64, b: f64) -> [f64; 2] {
    let sum = a + b;
    let b_in_sum = sum - a;
    [sum, (a - (sum - b_in_sum)) + (b - b_in_sum)]
}

fn difference(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]) + (a[1] - b[1])
}
