//! Means of similar pixels.

use rayon::prelude::*;

use super::kernel;
use super::outliers::ClampedPixel;
use super::pixels::Pixels;
use crate::color::Rgb;

/// Farthest pixel that enters a mean, along a row or column (pixels).
const RADIUS: isize = 9;
/// Pixels from the middle of a compared patch to its edge.
const PATCH: usize = 2;
/// `k²`: scale of squared differences relative to the variances. A choice, as the radii are.
const BANDWIDTH: f32 = 1.5 * 1.5;
/// Keeps the difference of two exact pixels finite.
const LEAST_VARIANCE: f32 = 1e-12;
/// Bound of the light that a pixel receives from outliers, as a share of its own mean.
const MAX_OUTLIER_SHARE: f32 = 0.1;

/// Weighted sums over similar pixels.
#[derive(Clone, Copy, Default)]
struct Sums {
    irradiance: Rgb,
    excess: Rgb,
    weight: f32,
    /// `Σ w² v`.
    variance: f32,
}

/// Reconstruction of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Mean {
    /// Mean radiance (W·m⁻²·sr⁻¹) of similar pixels.
    pub radiance: Rgb,
    /// Variance of the luminance due to the noise of the averaged pixels; 0 if unknown.
    pub variance: f32,
}

/// Reconstructed pixels; `None` for a pixel that is not finite, since it is similar to no pixel,
/// itself included.
///
/// * `guide`: pixels that determine the weights.
/// * `averaged`: pixels that enter the means, equal to `guide` or independent of it.
pub fn means(pixels: &Pixels, guide: &[ClampedPixel], averaged: &[ClampedPixel]) -> Vec<Option<Mean>> {
    let rows = (0..pixels.height).into_par_iter();
    rows.flat_map_iter(|y| {
        let albedo = &pixels.albedo[y * pixels.width..][..pixels.width];
        let sums = sums_of_row(pixels, guide, averaged, y);
        let of_pixel = |(sums, albedo): (Sums, &Rgb)| {
            let of_luminance = albedo.luminance() / sums.weight;
            let variance = sums.variance * of_luminance * of_luminance;
            (sums.weight > 0.0).then(|| Mean { radiance: *albedo * mean(&sums), variance })
        };
        sums.into_iter().zip(albedo).map(of_pixel)
    })
    .collect()
}

fn mean(sums: &Sums) -> Rgb {
    let mean = sums.irradiance / sums.weight;
    let glow = sums.excess / sums.weight;
    // A small excess is added almost whole; a large one approaches a share of the mean.
    let most = MAX_OUTLIER_SHARE * mean.luminance().abs();
    let size = glow.luminance().abs();
    if size > 0.0 { mean + glow * (most / (most + size)) } else { mean }
}

fn sums_of_row(pixels: &Pixels, guide: &[ClampedPixel], averaged: &[ClampedPixel], y: usize) -> Vec<Sums> {
    let mut sums = vec![Sums::default(); pixels.width];
    let mut columns = vec![Column::default(); pixels.width];
    for dy in -RADIUS..=RADIUS {
        for dx in -RADIUS..=RADIUS {
            let nearness = 1.0 - (dx * dx + dy * dy) as f32 / ((RADIUS + 1) * (RADIUS + 1)) as f32;
            if nearness <= 0.0 || y.checked_add_signed(dy).is_none_or(|y| y >= pixels.height) {
                continue;
            }
            let offset = dy * pixels.width as isize + dx;
            // Columns that have a neighbour at this offset.
            let first = (-dx).max(0) as usize;
            let end = pixels.width.saturating_sub(dx.max(0) as usize);
            if first >= end {
                continue;
            }
            for (x, column) in (first..end).zip(&mut columns[first..]) {
                *column = of_column(pixels, guide, [x, y], [dx, dy]);
            }
            for (x, sums) in sums.iter_mut().enumerate().take(end).skip(first) {
                let p = y * pixels.width + x;
                let q = p.wrapping_add_signed(offset);
                let near = x.saturating_sub(PATCH).max(first)..(x + PATCH + 1).min(end);
                let patch = columns[near].iter().fold(Column::default(), |sum, column| Column {
                    distance: sum.distance + column.distance,
                    pixels: sum.pixels + column.pixels,
                });
                let of_patch = (patch.distance / patch.pixels).max(0.0);
                // Most pairs of patches are not similar, and need no comparison of features.
                if kernel(of_patch) <= 0.0 {
                    continue;
                }
                let weight = kernel(of_patch + pixels.distance(p, q));
                if weight > 0.0 {
                    let (own, variance) = (guide[p].variance, guide[q].variance);
                    let surer = 2.0 * own / (own + variance).max(f32::MIN_POSITIVE);
                    let weight = weight * nearness * if p == q { 1.0 } else { surer.min(1.0) };
                    sums.irradiance += averaged[q].irradiance * weight;
                    sums.excess += averaged[q].excess * weight;
                    sums.weight += weight;
                    sums.variance += weight * weight * averaged[q].variance;
                }
            }
        }
    }
    sums
}

/// Sum of the distances between a column of a patch and the column at an offset from it, and the
/// number of pixels in the sum.
#[derive(Clone, Copy, Default)]
struct Column {
    distance: f32,
    pixels: f32,
}

fn of_column(pixels: &Pixels, tamed: &[ClampedPixel], [x, y]: [usize; 2], [dx, dy]: [isize; 2]) -> Column {
    let mut column = Column::default();
    for y in y.saturating_sub(PATCH)..(y + PATCH + 1).min(pixels.height) {
        if y.checked_add_signed(dy).is_some_and(|y| y < pixels.height) {
            let p = y * pixels.width + x;
            let (a, b) = (&tamed[p], &tamed[p.wrapping_add_signed(dy * pixels.width as isize + dx)]);
            let difference = a.luminance - b.luminance;
            let both = a.variance + b.variance;
            let noise = a.variance + a.variance.min(b.variance);
            column.distance += (difference * difference - noise) / (BANDWIDTH * both + LEAST_VARIANCE);
            column.pixels += 1.0;
        }
    }
    column
}
