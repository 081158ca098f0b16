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
    /// About how much the sum of their luminance varies by which set of VPLs there is, which their
    /// own spread does not show: a variance, over the number of paths.
    pub importance_of_set: f64,
    /// About how much light they do not find that is there (luminance), summed over the paths.
    pub importance_not_found: f64,
}

impl PathSamples {
    /// Takes in others of the same pixel; features stay those of the first.
    pub fn merge(&mut self, other: &Self) {
        self.sum.merge(&other.sum);
        self.luminance.merge(&other.luminance);
        self.rays += other.rays;
        self.importance_of_set += other.importance_of_set;
        self.importance_not_found += other.importance_not_found;
    }
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

    /// Paths of a pixel that tell about how much light they do not find.
    fn telling(&self) -> u32 {
        1
    }
}

impl<S: SamplePaths + ?Sized> SamplePaths for &S {
    fn setting(&self) -> &Setting<'_> {
        (**self).setting()
    }

    fn tile(&self, tile: &Window, seed: u64, count: &dyn Fn([u32; 2]) -> u32) -> Vec<PathSamples> {
        (**self).tile(tile, seed, count)
    }
}
