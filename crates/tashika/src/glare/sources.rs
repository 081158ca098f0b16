//! Glare sources: groups of bright pixels.
//!
//! Pixels above the threshold belong to one source if a chain of such pixels connects them whose
//! neighbours are at most 0.1 rad apart. Pixels of at least 50,000 cd·m⁻² are sources of their own,
//! with chains of 0.05 rad inside a source. Both distances and the limit are the defaults of
//! Radiance's `evalglare` (which states twice the distances). A source has the mean luminance of
//! its pixels by solid angle, and the position index of the centre of its light.
//!
//! # Guarantee
//! The groups do not depend on the order of the pixels.
//!
//! # Held to this by
//! `glare::tests`.

use serde::Serialize;

use super::{ViewedPixel, position_index};
use crate::math::DVec3;
use crate::math::elementary::sin_cos_f64;

/// Largest angle between neighbours of a chain, in sources and in peaks (radians).
const SEPARATION: f64 = 0.1;
const PEAK_SEPARATION: f64 = 0.05;
/// Luminance from which pixels are peaks (cd·m⁻²).
const PEAK: f64 = 50_000.0;

/// Group of bright pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GlareSource {
    /// Mean of its pixels by solid angle (cd·m⁻²).
    pub luminance: f64,
    /// Mean luminance with all pixels at their lower or upper limits.
    pub limits: [f64; 2],
    /// Sum over the pixels (sr).
    pub solid_angle: f64,
    /// Position index of the centre.
    pub position_index: f64,
    /// Centre of the light on the image (pixels from the top left).
    pub center: [f64; 2],
    /// Number of pixels above the threshold.
    pub pixels: usize,
}

impl GlareSource {
    /// `L² ω / p²` for the lower limit, the mean and the upper limit of the luminance.
    pub(super) fn terms(&self) -> [f64; 3] {
        let factor = self.solid_angle / (self.position_index * self.position_index);
        [self.limits[0], self.luminance, self.limits[1]].map(|luminance| luminance * luminance * factor)
    }
}

/// Returns the glare sources, and for each pixel whether it belongs to one.
///
/// * `size`: width and height of the image; `angle`: angle across its smaller side (radians).
pub(super) fn glare_sources(
    pixels: &[ViewedPixel],
    size: [u32; 2],
    angle: f64,
    threshold: f64,
) -> (Vec<GlareSource>, Vec<bool>) {
    let step = angle / f64::from(size[0].min(size[1]));
    let is_source: Vec<bool> = pixels.iter().map(|pixel| pixel.luminance[1] > threshold).collect();
    let bright: Vec<usize> = (0..pixels.len()).filter(|k| is_source[*k]).collect();
    let mut sources = Vec::new();
    for group in linked(pixels, bright, SEPARATION, step) {
        let (peaks, rest): (Vec<usize>, Vec<usize>) =
            group.into_iter().partition(|k| pixels[*k].luminance[1] >= PEAK);
        sources.extend((!rest.is_empty()).then(|| source(pixels, &rest)));
        sources.extend(linked(pixels, peaks, PEAK_SEPARATION, step).iter().map(|peak| source(pixels, peak)));
    }
    sources.sort_by(|a, b| b.terms()[1].total_cmp(&a.terms()[1]));
    (sources, is_source)
}

/// Source that consists of some of the pixels.
fn source(pixels: &[ViewedPixel], group: &[usize]) -> GlareSource {
    let mut solid_angle = 0.0;
    let mut luminance = [0.0; 3];
    let mut center = [0.0; 2];
    let mut direction = DVec3::ZERO;
    for pixel in group.iter().map(|k| &pixels[*k]) {
        solid_angle += pixel.solid_angle;
        let light = pixel.luminance.map(|luminance| luminance * pixel.solid_angle);
        for (sum, light) in luminance.iter_mut().zip(light) {
            *sum += light;
        }
        for (sum, place) in center.iter_mut().zip(pixel.place) {
            *sum += light[1] * (f64::from(place) + 0.5);
        }
        direction += pixel.direction * light[1];
    }
    let [low, mean, high] = luminance.map(|light| light / solid_angle);
    GlareSource {
        luminance: mean,
        limits: [low, high],
        solid_angle,
        position_index: position_index(direction.normalize_or(DVec3::NEG_Z)),
        center: center.map(|sum| sum / luminance[1]),
        pixels: group.len(),
    }
}

/// Groups of pixels that chains of at most `separation` connect, each in the order of the pixels.
///
/// Pixels are sorted into square cells whose diagonal is `separation` on the image. A pixel is at
/// most `step` in angle from its neighbour, so that all pixels of a cell are linked. Conversely an
/// angle of `separation` is at most `π/2 · separation / step` pixels, less than 3 cells.
fn linked(pixels: &[ViewedPixel], chosen: Vec<usize>, separation: f64, step: f64) -> Vec<Vec<usize>> {
    let side = separation / step * std::f64::consts::FRAC_1_SQRT_2;
    let cell = |k: usize| pixels[k].place.map(|place| (f64::from(place) / side) as i64);
    let mut sorted: Vec<([i64; 2], usize)> = chosen.iter().map(|k| (cell(*k), *k)).collect();
    sorted.sort_unstable();
    // Cells with the range of their pixels.
    let mut cells: Vec<([i64; 2], std::ops::Range<usize>)> = Vec::new();
    for (at, (cell, _)) in sorted.iter().enumerate() {
        match cells.last_mut() {
            Some((last, range)) if last == cell => range.end = at + 1,
            _ => cells.push((*cell, at..at + 1)),
        }
    }
    let cos = sin_cos_f64(separation).1;
    let near = |a: usize, b: usize| {
        let pixel = |at: usize| pixels[sorted[at].1].direction;
        pixel(a).dot(pixel(b)) >= cos
    };
    let mut parents: Vec<usize> = (0..cells.len()).collect();
    for at in 0..cells.len() {
        let ([x, y], range) = (cells[at].0, cells[at].1.clone());
        for (dx, dy) in (0..=3).flat_map(|dx| (-3..=3).map(move |dy| (dx, dy))).filter(|d| *d > (0, 0)) {
            let Ok(other) = cells.binary_search_by_key(&[x + dx, y + dy], |(cell, _)| *cell) else {
                continue;
            };
            let (a, b) = (root(&mut parents, at), root(&mut parents, other));
            if a != b && range.clone().any(|a| cells[other].1.clone().any(|b| near(a, b))) {
                parents[a.max(b)] = a.min(b);
            }
        }
    }
    let mut groups: Vec<Vec<usize>> = vec![Vec::new(); cells.len()];
    for (at, (_, range)) in cells.iter().enumerate() {
        let group = root(&mut parents, at);
        groups[group].extend(sorted[range.clone()].iter().map(|(_, k)| *k));
    }
    groups.retain(|group| !group.is_empty());
    groups.iter_mut().for_each(|group| group.sort_unstable());
    groups.sort_unstable();
    groups
}

/// Representative of a set of cells, with path halving.
fn root(parents: &mut [usize], mut at: usize) -> usize {
    while parents[at] != at {
        parents[at] = parents[parents[at]];
        at = parents[at];
    }
    at
}
