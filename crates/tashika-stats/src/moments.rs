//! Running mean and variance.

/// Mean and variance of a stream of numbers in one pass (Welford 1962), in `f64`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    count: u64,
    mean: f64,
    /// Sum of squared deviations from the mean.
    deviation: f64,
    /// Largest of the absolute values.
    largest: f64,
}

impl Moments {
    /// Adds one number.
    #[inline]
    pub fn push(&mut self, x: f64) {
        self.count += 1;
        self.largest = self.largest.max(x.abs());
        let d = x - self.mean;
        self.mean += d / self.count as f64;
        self.deviation += d * (x - self.mean);
    }

    /// Adds the numbers of another `Moments` (Chan, Golub, LeVeque 1979).
    #[inline]
    pub fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        let count = self.count + other.count;
        let (own, theirs) = (self.count as f64, other.count as f64);
        let d = other.mean - self.mean;
        self.mean += d * theirs / count as f64;
        self.deviation += other.deviation + d * d * own * theirs / count as f64;
        self.count = count;
        self.largest = self.largest.max(other.largest);
    }

    /// Largest of the absolute values; zero without numbers.
    #[inline]
    pub fn largest(&self) -> f64 {
        self.largest
    }

    /// Count of the added numbers.
    #[inline]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Mean of the added numbers; zero without numbers.
    #[inline]
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Unbiased sample variance; zero for fewer than two numbers.
    #[inline]
    pub fn variance(&self) -> f64 {
        if self.count < 2 { 0.0 } else { self.deviation / (self.count - 1) as f64 }
    }

    /// Standard error of the mean; zero for fewer than two numbers.
    #[inline]
    pub fn standard_error(&self) -> f64 {
        if self.count < 2 { 0.0 } else { (self.variance() / self.count as f64).sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_two_pass_formula_far_from_zero() {
        let data = [1e9 + 4.0, 1e9 + 7.0, 1e9 + 13.0, 1e9 + 16.0];
        let mut m = Moments::default();
        data.iter().for_each(|&x| m.push(x));
        assert_eq!(m.mean(), 1e9 + 10.0);
        assert!((m.variance() - 30.0).abs() < 1e-6);
        assert!((m.standard_error() - (30.0f64 / 4.0).sqrt()).abs() < 1e-6);
        assert_eq!(Moments::default().standard_error(), 0.0);
    }

    #[test]
    fn halves_merge_to_the_whole() {
        let data = [3.0, -1.0, 4.5, 8.0, 0.25, 2.0, 7.5];
        let of = |numbers: &[f64]| {
            let mut m = Moments::default();
            numbers.iter().for_each(|&x| m.push(x));
            m
        };
        for cut in 0..=data.len() {
            let mut merged = of(&data[..cut]);
            merged.merge(&of(&data[cut..]));
            let whole = of(&data);
            assert_eq!((merged.count(), merged.largest()), (whole.count(), 8.0));
            assert!((merged.mean() - whole.mean()).abs() < 1e-14, "{cut}");
            assert!((merged.variance() - whole.variance()).abs() < 1e-13, "{cut}");
        }
    }
}
