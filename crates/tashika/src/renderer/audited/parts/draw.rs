//! Draw of the pixels that are audited in a picture in parts.

use super::super::looks::is_dear;
use super::super::truths::{drawn, seed_of};
use crate::film::Window;
use crate::integrator::SamplePaths;
use crate::request::AuditTerms;
use crate::rng::{self, Purpose};

/// Pixels from which the share that shows more than a constant background is estimated.
const PILOTS: u64 = 1024;
/// Least number of these counted as shown, so that an image that shows little is not drawn as a
/// whole.
const FEWEST_SHOWN: u64 = 16;
/// Paths of each of these pixels.
const PILOT_PATHS: u32 = 8;
/// Key of their draw; that of the audit is 0, and those of the stages of its truths follow.
const OF_PILOTS: u64 = 1 << 32;
/// Fewest rays of a pixel of a good picture, by which the size of an expensive picture is
/// estimated.
const RAYS_OF_PIXEL: u64 = 256;

/// Number of pixels to draw, so that about as many as the terms require are audited, or [more] of a
/// large picture.
///
/// [more]: AuditTerms::more_pixels
pub(super) fn count(sampler: &dyn SamplePaths, window: &Window, terms: &AuditTerms, seed: u64) -> u64 {
    let is_large = is_dear(terms, RAYS_OF_PIXEL.saturating_mul(window.area()));
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

/// First `count` pixels of a random order of those of a window.
pub(super) fn draw(window: &Window, count: u64, seed: u64) -> Vec<[u32; 2]> {
    drawn(all(window), count.min(window.area()), seed_of(seed))
}

fn all(window: &Window) -> Vec<[u32; 2]> {
    window.pixels().map(|(x, y)| [x, y]).collect()
}
