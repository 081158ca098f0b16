//! Paths of single pixels, anywhere in the image.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use crate::film::{Claim, Stop, Window};
use crate::integrator::{PathSampler, PathSamples};
use crate::render::Progress;
use crate::rng::{self, Purpose};

/// Most camera samples of a pixel that are held in memory at once.
const AT_ONCE: u32 = 1 << 12;

/// A pixel, and the number of paths to draw for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// Position in the full image.
    pub pixel: [u32; 2],
    /// Number of paths to draw.
    pub paths: u32,
}

/// Draws the paths of each wanted pixel; `None` if cancelled. Runs on the current thread pool.
///
/// The result for a pixel is a function of the sampler, the seed, its position and the number of
/// its paths.
pub fn paths_of(
    sampler: &dyn PathSampler,
    wanted: &[Wanted],
    seed: u64,
    progress: &(dyn Fn(&Progress) + Sync),
    cancel: &AtomicBool,
) -> Option<Vec<PathSamples>> {
    let done = Mutex::new(Progress { of: wanted.len() as u64, ..Progress::default() });
    let of_pixel = |wanted: &Wanted| {
        let [x, y] = wanted.pixel;
        let mut found = PathSamples::default();
        for (number, first) in (0..).zip((0..wanted.paths).step_by(AT_ONCE as usize)) {
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let count = AT_ONCE.min(wanted.paths - first);
            let seed = rng::key(seed, Purpose::Audit, number);
            let part = sampler.tile(&Window { x, y, width: 1, height: 1 }, seed, &|_| count);
            found.merge(&part[0]);
        }
        let mut done = done.lock().expect("nothing panics with it");
        done.rays += found.rays;
        done.tally.count(Claim::None, Stop::SampleCount);
        progress(&done);
        Some(found)
    };
    wanted.par_iter().map(of_pixel).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::with_sampler;
    use super::*;

    /// The paths of a pixel do not depend on other wanted pixels. All wanted paths are drawn, even
    /// if they are more than `AT_ONCE`.
    #[test]
    fn pixels_are_told_apart() {
        with_sampler(|sampler| {
            let wanted = |pixel: [u32; 2], paths: u32| Wanted { pixel, paths };
            let of = |wanted: &[Wanted], seed| {
                paths_of(sampler, wanted, seed, &|_| {}, &AtomicBool::new(false)).unwrap()
            };
            let all = of(&[wanted([18, 9], 64), wanted([20, 9], AT_ONCE + 5), wanted([7, 7], 0)], 1);
            let counts: Vec<u64> = all.iter().map(|found| found.luminance.count()).collect();
            assert_eq!(counts, [64, u64::from(AT_ONCE) + 5, 0]);
            assert_eq!(of(&[wanted([18, 9], 64)], 1)[0].luminance, all[0].luminance);
            assert_ne!(of(&[wanted([18, 9], 64)], 2)[0].luminance, all[0].luminance);
            // Each batch has its own random numbers.
            let [one, two] = [AT_ONCE, 2 * AT_ONCE].map(|n| of(&[wanted([20, 9], n)], 1)[0]);
            assert!(one.luminance.mean() != two.luminance.mean() && one.rays < two.rays);
        });
    }

    #[test]
    fn what_is_cancelled_has_no_paths() {
        with_sampler(|sampler| {
            let wanted = [Wanted { pixel: [1, 1], paths: 8 }];
            assert!(paths_of(sampler, &wanted, 1, &|_| {}, &AtomicBool::new(true)).is_none());
        });
    }
}
