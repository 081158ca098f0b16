//! Sums of the first `i` weights, from which an item of any range is drawn by a guess and a short search among landmarks, then among what is next to one.
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

/// Items from one landmark to the next.
const STRIDE: usize = 16;
/// Items among which landmarks are not worth a look.
const FEW: usize = 4 * STRIDE;

/// Sums of weights that are finite and not negative; one entry more than there are weights.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PrefixSums {
    sums: Vec<[f64; 2]>,
    /// Every [`STRIDE`]th sum, rounded: of a million items they stay in the cache, where the sums themselves do not.
    landmarks: Vec<f64>,
}

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
        let landmarks = sums.iter().step_by(STRIDE).map(|sum| sum[0]).collect();
        Self { sums, landmarks }
    }

    /// How many weights there are.
    pub(super) fn len(&self) -> usize {
        self.sums.len() - 1
    }

    /// Weight of `count` items from `first`.
    pub(super) fn weight(&self, first: u32, count: u32) -> f64 {
        difference(self.sums[first as usize + count as usize], self.sums[first as usize])
    }

    /// The item among `count` from `first` that `u` in `[0, 1)` falls into.
    pub(super) fn draw(&self, first: u32, count: u32, u: f64) -> u32 {
        let (begin, count) = (first as usize, count as usize);
        let (base, end) = (self.sums[begin], self.sums[begin + count]);
        let total = difference(end, base);
        // Rounding can make u·total as large as total, which is beyond the last item.
        let x = (u * total).min(total.next_down());
        let sums = &self.sums[begin..begin + count];
        let is_before = |sum: &[f64; 2]| difference(*sum, base) <= x;
        let guess = if count > FEW {
            // The landmarks after the first item and before the last.
            let after = begin / STRIDE + 1;
            let landmarks = &self.landmarks[after..(begin + count).div_ceil(STRIDE)];
            let at = base[0] + x;
            let guess = (x / total * landmarks.len() as f64) as usize;
            let passed = last_before(landmarks, guess, |landmark| *landmark <= at);
            passed.map_or(0, |passed| (after + passed) * STRIDE - begin)
        } else {
            count / 2
        };
        first + last_before(sums, guess, is_before).expect("the first begins at zero") as u32
    }

    /// Memory (bytes).
    pub(super) fn bytes(&self) -> usize {
        self.sums.capacity() * size_of::<[f64; 2]>() + self.landmarks.capacity() * size_of::<f64>()
    }
}

/// The last of numbers, in ascending order, that is before something; none if the first is not.
///
/// Looked for in steps that double from a guess, then by halves: what is near is likely to be in the cache.
fn last_before<T>(numbers: &[T], guess: usize, is_before: impl Fn(&T) -> bool) -> Option<usize> {
    let last = numbers.len().checked_sub(1)?;
    let guess = guess.min(last);
    let mut step = 1;
    // Of all from `low` on to `high` some may be before.
    let (mut low, mut high) = (guess, guess);
    if is_before(&numbers[guess]) {
        high = guess + 1;
        while high <= last && is_before(&numbers[high]) {
            (low, high) = (high, high + step);
            step *= 2;
        }
    } else {
        while !is_before(&numbers[low]) {
            if low == 0 {
                return None;
            }
            (low, high) = (low.saturating_sub(step), low);
            step *= 2;
        }
    }
    let high = high.min(last + 1);
    Some(low + numbers[low + 1..high].partition_point(is_before))
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
