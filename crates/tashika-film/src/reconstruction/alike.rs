//! Means of similar pixels.

use std::ops::Range;

use rayon::prelude::*;

use super::kernel;
use super::outliers::ClampedPixel;
use super::pixels::Pixels;
use crate::color::Rgb;

/// Farthest pixel that enters a mean, along a row or column (pixels).
const RADIUS: isize = 9;
/// Pixels from the middle of a compared patch to its edge.
const PATCH: usize = 2;
/// Rows that share the distances of their pixels.
const BAND: usize = 16;
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
    let guide = Guide::new(pixels, guide);
    let bands = (0..pixels.height.div_ceil(BAND)).into_par_iter();
    bands
        .flat_map_iter(|band| {
            let rows = band * BAND..((band + 1) * BAND).min(pixels.height);
            let albedo = &pixels.albedo[rows.start * pixels.width..rows.end * pixels.width];
            let of_pixel = |(sums, albedo): (Sums, &Rgb)| {
                let of_luminance = albedo.luminance() / sums.weight;
                let variance = sums.variance * of_luminance * of_luminance;
                (sums.weight > 0.0).then(|| Mean { radiance: *albedo * mean(&sums), variance })
            };
            guide.sums(averaged, rows).into_iter().zip(albedo).map(of_pixel)
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

/// Luminance and variance of the pixels that determine the weights.
struct Guide<'a> {
    pixels: &'a Pixels,
    luminance: Vec<f32>,
    variance: Vec<f32>,
}

impl<'a> Guide<'a> {
    fn new(pixels: &'a Pixels, guide: &[ClampedPixel]) -> Self {
        let luminance = guide.iter().map(|pixel| pixel.luminance).collect();
        Self { pixels, luminance, variance: guide.iter().map(|pixel| pixel.variance).collect() }
    }

    /// Sums of the pixels of a band of rows.
    fn sums(&self, averaged: &[ClampedPixel], rows: Range<usize>) -> Vec<Sums> {
        let Pixels { width, height, .. } = *self.pixels;
        let mut sums = vec![Sums::default(); rows.len() * width];
        // Distances of single pixels in the rows of all patches of the band.
        let above = rows.start.saturating_sub(PATCH);
        let mut distances = vec![0.0; ((rows.end + PATCH).min(height) - above) * width];
        // Sums of these over the columns of the patches of one row.
        let mut columns = vec![0.0; width];
        for dy in -RADIUS..=RADIUS {
            // Rows that have a neighbour at this offset.
            let inside = (-dy).max(0) as usize..height.saturating_sub(dy.max(0) as usize);
            for dx in -RADIUS..=RADIUS {
                let nearness = 1.0 - (dx * dx + dy * dy) as f32 / ((RADIUS + 1) * (RADIUS + 1)) as f32;
                let across = (-dx).max(0) as usize..width.saturating_sub(dx.max(0) as usize);
                if nearness <= 0.0 || across.is_empty() {
                    continue;
                }
                let offset = dy * width as isize + dx;
                let patch_rows = |rows: Range<usize>| {
                    rows.start.saturating_sub(PATCH).max(inside.start)..(rows.end + PATCH).min(inside.end)
                };
                for y in patch_rows(rows.clone()) {
                    let to = (y - above) * width;
                    self.distances(y * width, across.clone(), offset, &mut distances[to..to + width]);
                }
                for y in rows.start.max(inside.start)..rows.end.min(inside.end) {
                    let compared_rows = patch_rows(y..y + 1);
                    columns[across.clone()].fill(0.0);
                    for y in compared_rows.clone() {
                        let row = &distances[(y - above) * width..][across.clone()];
                        columns[across.clone()].iter_mut().zip(row).for_each(|(sum, d)| *sum += d);
                    }
                    for x in across.clone() {
                        let near = x.saturating_sub(PATCH).max(across.start)..(x + PATCH + 1).min(across.end);
                        let compared = (near.len() * compared_rows.len()) as f32;
                        let of_patch = (columns[near].iter().sum::<f32>() / compared).max(0.0);
                        // Patches that differ need no comparison of features.
                        if kernel(of_patch) > 0.0 {
                            let p = y * width + x;
                            let q = p.wrapping_add_signed(offset);
                            let sums = &mut sums[p - rows.start * width];
                            self.add(sums, [p, q], of_patch, nearness, &averaged[q]);
                        }
                    }
                }
            }
        }
        sums
    }

    /// Distances of the pixels of a row, of which `row` is the first, from those at an offset.
    ///
    /// * `across`: columns that have a pixel at the offset.
    fn distances(&self, row: usize, across: Range<usize>, offset: isize, found: &mut [f32]) {
        let own = row + across.start..row + across.end;
        let others = own.start.wrapping_add_signed(offset)..own.end.wrapping_add_signed(offset);
        let luminances = self.luminance[own.clone()].iter().zip(&self.luminance[others.clone()]);
        let variances = self.variance[own].iter().zip(&self.variance[others]);
        for ((found, (a, b)), (v, w)) in found[across].iter_mut().zip(luminances).zip(variances) {
            let difference = a - b;
            let both = v + w;
            let noise = v + if v < w { v } else { w };
            *found = (difference * difference - noise) / (BANDWIDTH * both + LEAST_VARIANCE);
        }
    }

    /// Adds pixel `q` to the sums of pixel `p`.
    fn add(
        &self,
        sums: &mut Sums,
        [p, q]: [usize; 2],
        of_patch: f32,
        nearness: f32,
        averaged: &ClampedPixel,
    ) {
        let weight = kernel(of_patch + self.pixels.distance(p, q));
        if weight > 0.0 {
            let (own, variance) = (self.variance[p], self.variance[q]);
            let surer = 2.0 * own / (own + variance).max(f32::MIN_POSITIVE);
            let weight = weight * nearness * if p == q { 1.0 } else { surer.min(1.0) };
            sums.irradiance += averaged.irradiance * weight;
            sums.excess += averaged.excess * weight;
            sums.weight += weight;
            sums.variance += weight * weight * averaged.variance;
        }
    }
}
