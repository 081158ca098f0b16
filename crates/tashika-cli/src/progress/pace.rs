//! Estimate of the remaining time from the recent pace.
//!
//! The time per pixel differs between tiles: sky is fast, glass is slow, and neighbouring tiles are
//! similar. The estimate therefore uses the time per pixel of recent pixels. With `Δpₖ` pixels
//! finished in `Δtₖ` seconds between two observations,
//!
//! ```text
//! T ← e^(−Δp / m) T + Δt      P ← e^(−Δp / m) P + Δp      seconds left = (T / P) · (pixels left)
//! ```
//!
//! The memory `m` is a tenth of all pixels: pixels that were finished a tenth of the work ago have
//! about a third of the weight of the latest. The estimate assumes that the recent pace continues;
//! it cannot know the cost of later tiles.
//!
//! # Guarantee
//! If every pixel takes the same time, the estimate is exact up to rounding, however the
//! observations are spaced.
//!
//! # Held to this by
//! The tests below.

/// Share of all pixels after which the weight of an observation falls to 1/e, about a third.
const MEMORY: f64 = 0.1;

/// The pace of one run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pace {
    pixels: u64,
    of: u64,
    seconds: f64,
    recent_seconds: f64,
    recent_pixels: f64,
}

impl Pace {
    /// Records that `pixels` of `of` pixels were finished after `seconds`. If `pixels` is smaller
    /// than before, or `of` differs, a new run begins.
    pub fn observe(&mut self, pixels: u64, of: u64, seconds: f64) {
        if pixels < self.pixels || of != self.of {
            // The first run begins at time zero, a later run at the last observation of the
            // previous run.
            let begun = if self.of == 0 { 0.0 } else { self.seconds };
            *self = Self { of, seconds: begun, ..Self::default() };
        }
        let more = (pixels - self.pixels) as f64;
        let kept = (-more / (MEMORY * of.max(1) as f64)).exp();
        self.recent_pixels = kept * self.recent_pixels + more;
        self.recent_seconds = kept * self.recent_seconds + (seconds - self.seconds).max(0.0);
        self.pixels = pixels;
        self.seconds = seconds;
    }

    /// Seconds that the remaining pixels take at the recent pace; `None` before any pixel is
    /// finished.
    pub fn seconds_left(&self) -> Option<f64> {
        let left = self.of.saturating_sub(self.pixels) as f64;
        (self.recent_pixels > 0.0).then(|| self.recent_seconds / self.recent_pixels * left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Estimates of the remaining seconds after each observation (pixels, seconds) of a run of 1000
    /// pixels.
    fn left(observed: impl IntoIterator<Item = (u64, f64)>) -> Vec<f64> {
        let mut pace = Pace::default();
        assert_eq!(pace.seconds_left(), None, "nothing is known yet");
        observed
            .into_iter()
            .map(|(pixels, seconds)| {
                pace.observe(pixels, 1000, seconds);
                pace.seconds_left().unwrap()
            })
            .collect()
    }

    #[test]
    fn a_constant_pace_is_carried_on_exactly() {
        // Steps of different sizes, and a step of zero pixels.
        let pixels = [1, 16, 272, 272, 273, 600, 999, 1000];
        let said = left(pixels.map(|p| (p, p as f64 * 0.25)));
        for (pixels, said) in pixels.into_iter().zip(said) {
            let expected = (1000 - pixels) as f64 * 0.25;
            assert!((said - expected).abs() <= 1e-12 * 250.0, "{pixels}: {said}, expected {expected}");
        }
    }

    #[test]
    fn a_pace_that_slows_is_followed() {
        // The first half takes a second a pixel, the second half nine.
        let clock = |p: u64| if p <= 500 { p as f64 } else { 500.0 + 9.0 * (p - 500) as f64 };
        let steps: Vec<u64> = (1..=100).map(|i| 10 * i).collect();
        let said = left(steps.iter().map(|&p| (p, clock(p))));
        assert!((said[49] - 500.0).abs() < 1e-9, "as observed so far");
        for (&pixels, said) in steps.iter().zip(&said).filter(|(p, _)| **p >= 700) {
            // From 700 pixels on, at most e⁻² of the weight belongs to the first half. There, a
            // pixel takes eight seconds less, so the estimate is at most 8 e⁻²/9 = 12 % too low.
            let truth = clock(1000) - clock(pixels);
            assert!(*said <= truth && truth - *said <= 0.125 * truth, "{pixels}: {said}, truth {truth}");
            // An estimate from the mean pace since the beginning would be much worse.
            let mean = clock(pixels) / pixels as f64 * (1000 - pixels) as f64;
            assert!(pixels == 1000 || truth - mean > 3.0 * (truth - *said), "{pixels}: {said}, mean {mean}");
        }
    }

    #[test]
    fn another_run_begins_anew() {
        let mut pace = Pace::default();
        pace.observe(100, 100, 50.0);
        pace.observe(10, 100, 51.0);
        assert_eq!(pace.seconds_left(), Some(9.0), "ten in one second, not in 51");
        pace.observe(10, 40, 53.0);
        assert_eq!(pace.seconds_left(), Some(6.0));
        let mut first = Pace::default();
        first.observe(0, 10, 3.0);
        assert_eq!(first.seconds_left(), None);
    }
}
