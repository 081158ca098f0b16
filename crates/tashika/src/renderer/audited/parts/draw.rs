//! Random choice of the pixels to audit, for a picture in parts.

use super::super::looks::is_expensive;
use super::super::truths::{drawn, seed_of};
use crate::film::Window;
use crate::integrator::PathSampler;
use crate::request::AuditTerms;
use crate::rng::{self, Purpose};

/// Number of pilot pixels, from which the share of pixels that show more than a constant background
/// is estimated.
const PILOTS: u64 = 1024;
/// Lower bound on the number of pilots counted as showing something. Without it, every pixel of a
/// nearly empty image would be drawn.
const FEWEST_SHOWN: u64 = 16;
/// Number of paths of each pilot pixel.
const PILOT_PATHS: u32 = 8;
/// Key of the random draw of the pilots. The draw of the audit has the key 0, and the stages of its
/// truths have the keys 1, 2, ….
const OF_PILOTS: u64 = 1 << 32;
/// Smallest number of rays a pixel of a good picture. With this number, it follows from the size of
/// the image whether the picture will be expensive.
const RAYS_OF_PIXEL: u64 = 256;

/// Number of pixels to draw. About as many as the terms require, or [more] in a large picture, are
/// then audited; drawn pixels that show a constant background are not.
///
/// [more]: AuditTerms::more_pixels
pub(super) fn count(sampler: &dyn PathSampler, window: &Window, terms: &AuditTerms, seed: u64) -> u64 {
    let is_large = is_expensive(terms, RAYS_OF_PIXEL.saturating_mul(window.area()));
    let wanted = if is_large { terms.more_pixels() } else { terms.pixels };
    let seed = rng::key(seed, Purpose::Audit, OF_PILOTS);
    let pilots = drawn(all(window), PILOTS.min(window.area()), seed);
    let is_shown = |[x, y]: &[u32; 2]| {
        let pixel = Window { x: *x, y: *y, width: 1, height: 1 };
        let found = &sampler.tile(&pixel, seed, &|_| PILOT_PATHS)[0];
        found.features.coverage > 0.0 || found.luminance.standard_error() > 0.0
    };
    let of = pilots.len() as u64;
    let shown = pilots.iter().filter(|pixel| is_shown(pixel)).count() as u64;
    wanted.saturating_mul(of).div_ceil(shown.max(FEWEST_SHOWN.min(of))).min(window.area())
}

/// First `count` pixels of a random order of the window's pixels.
pub(super) fn draw(window: &Window, count: u64, seed: u64) -> Vec<[u32; 2]> {
    drawn(all(window), count.min(window.area()), seed_of(seed))
}

fn all(window: &Window) -> Vec<[u32; 2]> {
    window.pixels().map(|(x, y)| [x, y]).collect()
}
