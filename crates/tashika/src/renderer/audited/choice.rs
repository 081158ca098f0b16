//! Choice of the paths of a picture: paths that draw VPLs, or paths alone.
//!
//! ```text
//! work to a tolerance   W = c r/n Σ_q σ_q²/t_q²      t_q = max(ε L_q, ε_abs)
//! ```
//!
//! The sum is over random pixels `q`, with the variance `σ_q²` of single paths and the luminance
//! `L_q`, the mean of both kinds of paths. `r/n` is the number of rays of a path and `c` the time
//! of a ray relative to one of paths alone. VPLs pay where surfaces light each other; they do not
//! where paths find the light themselves, as in rooms lit through windows.
//!
//! The choice is a function of the view, the lights and the seed. No estimate uses the paths of the
//! pilot, so that estimates stay unbiased.

use crate::film::Window;
use crate::integrator::{PathSampler, PathSamples};
use crate::picture::{Wanted, paths_of};
use crate::rng::{self, Purpose, Stream};
use crate::stats::Moments;

use super::Prepared;
use super::verdict::Tolerance;

/// Number of pixels of the pilot. Chosen.
const PILOT_PIXELS: usize = 1024;
/// Number of paths of each of these pixels, of either kind. Chosen.
const PILOT_PATHS: u32 = 8;
/// Time of a ray with its share of the draws, for paths that draw VPLs over paths alone. Measured
/// in the built-in room, the Cornell box and a staircase.
const COST_OF_VPL_RAY: f64 = 1.75;
/// Largest ratio of works at which paths alone are chosen. It is below 1, since few paths miss rare
/// bright light, and then seem cheap. Chosen.
const MAX_WORK_RATIO: f64 = 0.5;
/// Largest deficit of the light that paths alone found, in standard errors. Chosen.
const MAX_DEFICIT: f64 = 2.0;

/// Work of both kinds of paths to the tolerance, for comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Works {
    by_vpls: f64,
    alone: f64,
    /// True if paths alone found as much light as the others, within the errors of both.
    is_light_sampled: bool,
}

impl Works {
    /// Measures both by a pilot; `None` if cancelled.
    pub fn measure(
        prepared: &Prepared<'_>,
        by_vpls: &dyn PathSampler,
        alone: &dyn PathSampler,
        tolerance: &Tolerance,
    ) -> Option<Self> {
        let (key, cancel) = (prepared.pilot_key(), prepared.observer.cancel());
        let wanted = pilot_pixels(&prepared.window, key);
        let found = |sampler: &dyn PathSampler, number: u64| {
            paths_of(sampler, &wanted, rng::key(key, Purpose::Guidance, number), &|_| {}, cancel)
        };
        Some(Self::of(&found(by_vpls, 1)?, &found(alone, 2)?, tolerance))
    }

    /// Returns the work of both kinds, from their paths of the pilot's pixels.
    fn of(by_vpls: &[PathSamples], alone: &[PathSamples], tolerance: &Tolerance) -> Self {
        let mean = |k: usize| 0.5 * (by_vpls[k].luminance.mean() + alone[k].luminance.mean());
        let work = |found: &[PathSamples]| {
            let of_pixel = |(k, pixel): (usize, &PathSamples)| {
                // The square of this number is above zero.
                let error = tolerance.of(mean(k)).max(1e-150);
                pixel.luminance.variance() / (error * error)
            };
            let rays: u64 = found.iter().map(|pixel| pixel.rays).sum();
            rays as f64 * found.iter().enumerate().map(of_pixel).sum::<f64>()
        };
        let all = |found: &[PathSamples]| {
            let mut all = Moments::default();
            found.iter().for_each(|pixel| all.merge(&pixel.luminance));
            all
        };
        let [light_by_vpls, light_alone] = [all(by_vpls), all(alone)];
        let [a, b] = [light_by_vpls, light_alone].map(|light| light.standard_error());
        let error = (a * a + b * b).sqrt();
        let is_light_sampled = light_alone.mean() + MAX_DEFICIT * error >= light_by_vpls.mean();
        Self { by_vpls: COST_OF_VPL_RAY * work(by_vpls), alone: work(alone), is_light_sampled }
    }

    /// Returns true if paths alone take less work. Light that they miss makes them seem cheap.
    pub fn is_alone_better(&self) -> bool {
        self.is_light_sampled && self.alone < MAX_WORK_RATIO * self.by_vpls
    }
}

/// Random pixels of a window, each with the paths of the pilot. A pixel may be drawn twice.
fn pilot_pixels(window: &Window, key: u64) -> Vec<Wanted> {
    let mut stream = Stream::new(key, Purpose::Guidance, 0);
    let mut below = |side: u32| stream.below(side.into()) as u32;
    let pixel = |_| [window.x + below(window.width), window.y + below(window.height)];
    (0..PILOT_PIXELS).map(pixel).map(|pixel| Wanted { pixel, paths: PILOT_PATHS }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pixels of luminance 1 whose paths deviate by `deviation`.
    fn paths(deviation: f64, rays: u64) -> Vec<PathSamples> {
        let mut found = PathSamples { rays, ..PathSamples::default() };
        (0..PILOT_PATHS)
            .for_each(|k| found.luminance.push(1.0 + if k % 2 == 0 { deviation } else { -deviation }));
        vec![found; 10]
    }

    /// The work grows with the variance over the squared tolerance, and with the rays.
    #[test]
    fn work_is_variance_times_rays() {
        let works = |error| {
            let tolerance = Tolerance { error, absolute: 0.0 };
            Works::of(&paths(0.1, 8), &paths(0.2, 4), &tolerance)
        };
        let (coarse, fine) = (works(0.1), works(0.05));
        let ratio = coarse.alone / coarse.by_vpls;
        assert!(
            (ratio * COST_OF_VPL_RAY - 2.0).abs() < 1e-9,
            "four times the variance, half the rays: {ratio}"
        );
        assert!((fine.alone / coarse.alone - 4.0).abs() < 1e-9);
        // An absolute tolerance that is twice the relative one.
        let absolute = Tolerance { error: 0.1, absolute: 0.2 };
        let dark = Works::of(&paths(0.1, 8), &paths(0.2, 4), &absolute);
        assert!((dark.alone / coarse.alone - 0.25).abs() < 1e-9);
    }

    #[test]
    fn paths_alone_have_to_be_clearly_better() {
        let is_better = |alone| Works { by_vpls: 1.0, alone, is_light_sampled: true }.is_alone_better();
        assert!(is_better(0.9 * MAX_WORK_RATIO) && !is_better(1.1 * MAX_WORK_RATIO) && !is_better(f64::NAN));
    }

    /// Paths that miss light have no variance by it.
    #[test]
    fn paths_that_miss_light_are_not_chosen() {
        let tolerance = Tolerance { error: 0.1, absolute: 0.01 };
        let same = paths(0.0, 4);
        let mut dark = same.clone();
        for pixel in &mut dark {
            pixel.luminance = Moments::default();
            (0..PILOT_PATHS).for_each(|_| pixel.luminance.push(0.0));
        }
        assert!(Works::of(&paths(0.1, 8), &same, &tolerance).is_alone_better());
        assert!(!Works::of(&paths(0.1, 8), &dark, &tolerance).is_alone_better());
    }

    #[test]
    fn a_pilot_stays_in_the_window() {
        let window = Window { x: 5, y: 9, width: 3, height: 2 };
        let pixels = pilot_pixels(&window, 7);
        assert_eq!(pixels.len(), PILOT_PIXELS);
        let mut seen: Vec<[u32; 2]> = pixels.iter().map(|wanted| wanted.pixel).collect();
        seen.sort_unstable();
        seen.dedup();
        let all: Vec<[u32; 2]> = (5..8).flat_map(|x| [[x, 9], [x, 10]]).collect();
        assert_eq!(seen, all);
    }
}
