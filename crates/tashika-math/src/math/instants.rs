//! Times at which light is summed while the shutter is open.
//!
//! ```text
//! L = ∫₀¹ L(t) dt ≈ 1/T Σ_k L(t_k)          t_k drawn in [k/T, (k+1)/T)
//! ```
//!
//! The light and the gather point of a term must be evaluated at the same time. Therefore only a
//! few times are used, the *instants* (Walter et al. 2006). Each light path and each camera sample
//! belongs to one instant, and a light contributes only to gather points of the same instant. Times
//! are shares of the exposure, from 0 to 1.
//!
//! # Guarantee
//! The expectation of the sum over [drawn](Instants::spread) instants is the integral over all
//! times.
//!
//! # Held to this by
//! The tests below; the suite's `moving_lights`.

/// The instants of a sum.
#[derive(Clone, Debug, PartialEq)]
pub struct Instants {
    /// Number of the first instant; zero unless it was chosen by [`Self::only`].
    first: u16,
    /// Times of the instants, in ascending order, each from 0 to 1; at least one.
    shares: Vec<f32>,
}

impl Default for Instants {
    /// The single instant of a scene that does not move.
    fn default() -> Self {
        Self { first: 0, shares: vec![Self::STILL] }
    }
}

impl Instants {
    /// Time of queries that do not specify one. In a scene that does not move, all times are
    /// equivalent.
    pub const STILL: f32 = 0.5;
    /// Largest number of instants.
    pub const MOST: u32 = 1024;

    /// Divides the exposure into `count` equal parts and places one instant in each. `uniform`
    /// returns a number in `[0, 1)`, the position of the instant within its part.
    ///
    /// # Panics
    /// If `count` is not 1 to [`Self::MOST`].
    pub fn spread(count: u32, mut uniform: impl FnMut() -> f64) -> Self {
        assert!((1..=Self::MOST).contains(&count), "1 to {} instants", Self::MOST);
        let share = |k: u32| (f64::from(k) + uniform()) / f64::from(count);
        Self { first: 0, shares: (0..count).map(share).map(|share| share as f32).collect() }
    }

    /// Instants at the given shares of the time: 1 to [`Self::MOST`] of them, each from 0 to 1, in
    /// ascending order; `None` otherwise.
    pub fn new(shares: Vec<f32>) -> Option<Self> {
        let can_be = (1..=Self::MOST as usize).contains(&shares.len())
            && shares.is_sorted()
            && shares.iter().all(|share| (0.0..=1.0).contains(share));
        can_be.then_some(Self { first: 0, shares })
    }

    /// Shares of the time, each from 0 to 1, in ascending order.
    pub fn shares(&self) -> &[f32] {
        &self.shares
    }

    /// Number of instants.
    #[expect(clippy::len_without_is_empty, reason = "there is at least one")]
    pub fn len(&self) -> usize {
        self.shares.len()
    }

    /// Returns true if there is one instant and its number is 0, as in a scene that does not move.
    pub fn is_single(&self) -> bool {
        self.first == 0 && self.len() == 1
    }

    /// Returns the number of the instant chosen by `u` (uniform in `[0, 1)`), and its share of the
    /// time.
    pub fn draw(&self, u: f32) -> (u16, f32) {
        let place = ((u * self.shares.len() as f32) as usize).min(self.shares.len() - 1);
        (self.first + place as u16, self.shares[place])
    }

    /// Returns a set that contains only the instant with this number. The instant keeps its number.
    #[must_use]
    pub fn only(&self, number: u16) -> Self {
        Self { first: number, shares: vec![self.shares[usize::from(number - self.first)]] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_part_of_the_time_has_one() {
        for count in [1, 2, 7, 32] {
            let mut sum = 0.0;
            for draw in 0..200 {
                let instants = Instants::spread(count, || (f64::from(draw) + 0.5) / 200.0);
                assert_eq!(instants.len(), count as usize);
                for (k, &share) in instants.shares().iter().enumerate() {
                    assert_eq!((share * count as f32).floor().min(count as f32 - 1.0), k as f32);
                    assert_eq!(instants.draw((k as f32 + 0.5) / count as f32), (k as u16, share));
                    assert_eq!(instants.only(k as u16).draw(0.99), (k as u16, share));
                    sum += share * share;
                }
                assert_eq!(Instants::new(instants.shares().to_vec()).unwrap(), instants);
            }
            // ∫ t² dt by the midpoint rule, with 200 parts for each instant.
            let mean = sum / (200 * count) as f32;
            assert!((mean - 1.0 / 3.0).abs() < 1e-5, "{count}: {mean}");
        }
        assert_eq!(Instants::default().draw(0.999), (0, 0.5));
    }

    #[test]
    fn what_is_no_time_is_refused() {
        for shares in [vec![], vec![-0.1], vec![0.5, 0.2], vec![f32::NAN], vec![0.0; 1025], vec![1.5]] {
            assert!(Instants::new(shares.clone()).is_none(), "{shares:?}");
        }
    }
}
