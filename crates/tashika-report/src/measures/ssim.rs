//! Structural similarity: similarity of brightness, contrast and structure of two pictures.
//!
//! With means `µ`, variances `σ²` and the covariance `σ_xr` of the luma in the window around a
//! pixel (Wang et al. 2004, eq. 13),
//!
//! ```text
//! SSIM = (2 µ_x µ_r + C₁)(2 σ_xr + C₂) / ((µ_x² + µ_r² + C₁)(σ_x² + σ_r² + C₂))
//! C₁ = 0.01²   C₂ = 0.03²         of numbers in 0 to 1
//! ```
//!
//! The window has 11 × 11 pixels, weighted by a Gaussian of the standard deviation 1.5 pixels with
//! weights that add up to 1; variances are those of the weighted population. The luma is
//! `0.2126 R′ + 0.7152 G′ + 0.0722 B′` of the encoded channels. The mean is over the pixels whose
//! window is inside of the picture.
//!
//! Around omitted pixels the weights of the others add up to 1: `µ = Σ w m x / Σ w m`, with `m` 1
//! for present pixels and 0 for omitted ones.
//!
//! Held to this by `tests::ssim_is_that_of_scikit_image`.

use super::Pictures;
use super::grid::{Grid, Weights};
use crate::color::LUMINANCE_WEIGHTS;
use crate::math::elementary::exp_f64;

/// Pixels from the middle of a window to its edge.
const RADIUS: usize = 5;
/// Standard deviation of the window (pixels).
const DEVIATION: f64 = 1.5;
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// Mean of the map over pixels whose window is inside; `None` if no such pixel is present.
pub(super) fn mean(pictures: &Pictures) -> Option<f64> {
    let map = map(pictures);
    let (mut sum, mut count) = (0.0, 0_u64);
    for y in RADIUS..map.height.saturating_sub(RADIUS) {
        for x in RADIUS..map.width.saturating_sub(RADIUS) {
            if pictures.is_there[y * map.width + x] {
                sum += map.values[y * map.width + x];
                count += 1;
            }
        }
    }
    (count > 0).then(|| sum / count as f64)
}

/// Similarity at each pixel; meaningless if the pixel is omitted or near an edge.
pub(super) fn map(pictures: &Pictures) -> Grid {
    let window = Weights::of(RADIUS, |x| exp_f64(-x * x / (2.0 * DEVIATION * DEVIATION))).normalized();
    let there = Grid::new(pictures.width, pictures.is_there.iter().map(|there| f64::from(*there)));
    let shares = there.weighed(&window, &window);
    let mean = |values: &Grid| {
        let present = values.with(&there, |value, there| value * there);
        present.weighed(&window, &window).with(&shares, |sum, share| sum / share)
    };
    let [x, r] = [0, 1].map(|picture| Grid::new(pictures.width, pictures.encoded(picture).map(luma)));
    let [mean_x, mean_r] = [&x, &r].map(mean);
    let product = |a: &Grid, b: &Grid, mean_a: &Grid, mean_b: &Grid| {
        mean(&a.with(b, |a, b| a * b)).with(&mean_a.with(mean_b, |a, b| a * b), |whole, means| whole - means)
    };
    let variances = product(&x, &x, &mean_x, &mean_x).with(&product(&r, &r, &mean_r, &mean_r), |a, b| a + b);
    let covariance = product(&x, &r, &mean_x, &mean_r);
    let brightness = mean_x.with(&mean_r, |x, r| (2.0 * x * r + C1) / (x * x + r * r + C1));
    let structure = covariance.with(&variances, |both, each| (2.0 * both + C2) / (each + C2));
    brightness.with(&structure, |a, b| a * b)
}

fn luma(encoded: [f64; 3]) -> f64 {
    encoded.iter().zip(LUMINANCE_WEIGHTS).map(|(v, weight)| v * f64::from(weight)).sum()
}
