//! Samples of pixels by given numbers of paths, from which pictures are reconstructed.

use super::Setting;
use crate::color::RgbSum;
use crate::film::Window;
use crate::gather::Features;
use crate::stats::Moments;

/// Statistics of the paths of a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub struct PathSamples {
    /// Sum of the radiances of the paths (W·m⁻²·sr⁻¹).
    pub sum: RgbSum,
    /// Moments of the luminance of single paths.
    pub luminance: Moments,
    /// Means over the first surfaces of the paths.
    pub features: Features,
    /// Number of rays and segments traced.
    pub rays: u64,
    /// Approximate variance of the mean luminance due to the choice of the set of VPLs, times the
    /// number of paths. The spread of the paths does not show this variance.
    pub importance_of_set: f64,
    /// Approximate luminance of unsampled light, summed over the paths.
    pub importance_not_found: f64,
}

impl PathSamples {
    /// Adds further paths of the same pixel; keeps the features.
    pub fn merge(&mut self, other: &Self) {
        self.sum.merge(&other.sum);
        self.luminance.merge(&other.luminance);
        self.rays += other.rays;
        self.importance_of_set += other.importance_of_set;
        self.importance_not_found += other.importance_not_found;
    }
}

/// A sampler of paths for the pixels of one view.
///
/// The mean of a pixel's paths is unbiased; paths of different seeds are independent. The result
/// for a pixel is a function of the view, the seed and the number of its paths. It does not depend
/// on tiles or threads.
pub trait PathSampler: Send + Sync {
    /// Scene and view of the paths.
    fn setting(&self) -> &Setting<'_>;

    /// Draws paths of the pixels of a tile, row by row: `count` of them for each pixel.
    fn tile(&self, tile: &Window, seed: u64, count: &dyn Fn([u32; 2]) -> u32) -> Vec<PathSamples>;

    /// Fewest paths of a pixel from which its unsampled light can be estimated.
    fn telling(&self) -> u32 {
        1
    }
}

impl<S: PathSampler + ?Sized> PathSampler for &S {
    fn setting(&self) -> &Setting<'_> {
        (**self).setting()
    }

    fn tile(&self, tile: &Window, seed: u64, count: &dyn Fn([u32; 2]) -> u32) -> Vec<PathSamples> {
        (**self).tile(tile, seed, count)
    }
}
