//! Clamping of pixels that are far brighter or darker than similar ones because of a rare path.
//!
//! ```text
//! bounds of pixel p:   Q_¾ + 2 (Q_¾ − Q_½) + 0.05 |Q_½|      Q_¼ − 2 (Q_½ − Q_¼) − 0.05 |Q_½|
//! ```
//!
//! with the weighted quartiles `Q` of the irradiance of 7 × 7 pixels, weighted by the similarity of
//! their first surfaces. For normal noise the bounds are two standard deviations from the median. A
//! pixel beyond a bound is moved to it, but by no more than three of its own standard errors. A
//! small lamp has a small standard error and so stays bright; a pixel that is bright because of one
//! lucky path has a large standard error and is clamped.
//!
//! The variance of a pixel is replaced by the weighted median of the variances in the
//! neighbourhood, because a pixel that missed a rare bright path underestimates its variance. It
//! grows by no more than a factor of four, unless it is zero because the pixel is black.
//!
//! If most pixels of the neighbourhood are black, the median and the first quartile are zero, and
//! give no bounds. Pixels then keep their values, and their variance is replaced by the weighted
//! mean of the variances in the neighbourhood.

use rayon::prelude::*;

use super::kernel;
use super::pixels::Pixels;
use crate::color::Rgb;

/// Farthest neighbour (pixels).
const RADIUS: isize = 3;
const NEIGHBOURS: usize = (2 * RADIUS as usize + 1) * (2 * RADIUS as usize + 1);
/// Sum of weights below which a pixel has too few similar ones and stays unchanged.
const MIN_SIMILAR_WEIGHT: f32 = 6.0;
/// Distance of a bound from its quartile, in units of that quartile's distance from the median.
const RANGES: f32 = 2.0;
/// Share of the median that is added to the distance of a bound.
const SLACK: f32 = 0.05;
/// Largest change of a pixel, in its own standard errors.
const ERRORS: f32 = 3.0;
/// Largest factor by which a pixel's variance may grow.
const MOST_VARIANCE: f32 = 4.0;

/// A pixel after clamping.
#[derive(Clone, Copy, Debug, Default)]
pub struct ClampedPixel {
    /// Irradiance after clamping (radiance over albedo).
    pub irradiance: Rgb,
    /// Luminance of `irradiance`, and the variance of that luminance.
    pub luminance: f32,
    pub variance: f32,
    /// Part of the irradiance that was removed.
    pub excess: Rgb,
}

/// Clamps all pixels, row by row.
pub fn clamp_all(pixels: &Pixels) -> Vec<ClampedPixel> {
    let rows = (0..pixels.height).into_par_iter();
    rows.flat_map_iter(|y| (0..pixels.width).map(move |x| tamed(pixels, [x, y]))).collect()
}

fn tamed(pixels: &Pixels, [x, y]: [usize; 2]) -> ClampedPixel {
    let p = y * pixels.width + x;
    let (irradiance, variance) = (pixels.irradiance[p], pixels.variance[p]);
    let luminance = irradiance.luminance();
    let unchanged = ClampedPixel { irradiance, luminance, variance, excess: Rgb::BLACK };
    // A black pixel is exact only if its neighbours are.
    if variance <= 0.0 && luminance != 0.0 {
        return unchanged;
    }
    let mut values = [(0.0, 0.0); NEIGHBOURS];
    let mut variances = [(0.0, 0.0); NEIGHBOURS];
    let (mut count, mut total) = (0, 0.0);
    for dy in -RADIUS..=RADIUS {
        for dx in -RADIUS..=RADIUS {
            if !pixels.has([x, y], [dx, dy]) {
                continue;
            }
            let q = p.wrapping_add_signed(dy * pixels.width as isize + dx);
            let weight = kernel(pixels.distance(p, q));
            if weight > 0.0 {
                values[count] = (pixels.irradiance[q].luminance(), weight);
                variances[count] = (pixels.variance[q], weight);
                count += 1;
                total += weight;
            }
        }
    }
    if total < MIN_SIMILAR_WEIGHT {
        return unchanged;
    }
    let [low, middle, high] = quantiles(&mut values[..count], total, [0.25, 0.5, 0.75]);
    if middle == 0.0 {
        let sum: f32 = variances[..count].iter().map(|(variance, weight)| variance * weight).sum();
        return ClampedPixel { variance: sum / total, ..unchanged };
    }
    let slack = SLACK * middle.abs();
    let error = ERRORS * variance.sqrt();
    let most = (high + RANGES * (high - middle) + slack).max(luminance - error);
    let least = (low - RANGES * (middle - low) - slack).min(luminance + error);
    let moved = luminance.max(least).min(most);
    let [of_neighbours] = quantiles(&mut variances[..count], total, [0.5]);
    let share = if luminance == 0.0 { 1.0 } else { moved / luminance };
    ClampedPixel {
        irradiance: irradiance * share,
        luminance: moved,
        variance: if variance > 0.0 { of_neighbours.min(MOST_VARIANCE * variance) } else { of_neighbours },
        excess: irradiance * (1.0 - share),
    }
}

/// Quantiles of values with weights, given as pairs. `shares`: shares of the total weight, in
/// ascending order.
fn quantiles<const N: usize>(values: &mut [(f32, f32)], total: f32, shares: [f32; N]) -> [f32; N] {
    values.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let (mut below, mut k) = (values[0].1, 0);
    shares.map(|share| {
        while below < share * total && k + 1 < values.len() {
            k += 1;
            below += values[k].1;
        }
        values[k].0
    })
}
