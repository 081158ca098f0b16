//! Paths of pixels, so many of each: what pictures are made of that are reconstructed.

use super::Setting;
use crate::color::RgbSum;
use crate::film::Window;
use crate::gather::Features;
use crate::stats::Moments;

/// What paths of a pixel found.
#[derive(Clone, Copy, Debug, Default)]
pub struct PathSamples {
    /// Sum of their radiance (W·m⁻²·sr⁻¹).
    pub sum: RgbSum,
    /// Of its luminance, path by path.
    pub luminance: Moments,
    /// Of their first surfaces.
    pub features: Features,
    /// Rays and segments traced.
    pub rays: u64,
}

/// What draws paths of the pixels of one view.
///
/// The mean of a pixel's paths is unbiased; with other seeds they are independent. What a pixel gets
/// is a function of the view, the seed and the number of its paths: neither tiles nor threads enter.
pub trait SamplePaths: Send + Sync {
    /// The view.
    fn setting(&self) -> &Setting<'_>;

    /// Paths of the pixels of a tile, row by row: as many as `count` says of each.
    fn tile(&self, tile: &Window, seed: u64, count: &dyn Fn([u32; 2]) -> u32) -> Vec<PathSamples>;
}
