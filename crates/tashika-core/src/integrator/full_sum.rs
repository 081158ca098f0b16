//! The whole sum: every VPL against every gather point. The reference of all methods.
//!
//! ```text
//! L = B + Σ_j Σ_i w_j M_ji G_ji V_ji I_i
//! ```
//!
//! Summed in `f64`, in the order (VPL, gather point), so that the result does not depend on tiles.
//! Work goes VPL by VPL: all points of a tile make one fan of segments to it, the order in which
//! rays are fastest.

use super::{Claim, Estimates, Integrator, PixelRecord, Setting, Stop};
use crate::accel::SegmentBatch;
use crate::color::RgbSum;
use crate::contribution::{ContributionKernel, Receivers};
use crate::film::{Metadata, Window, keys};
use crate::gather::{GatherPoint, PixelSum};
use crate::media::Segments;
use crate::scene::Abilities;
use crate::vpl::VplSet;

/// The whole sum of each pixel.
#[derive(Clone, Copy, Debug)]
pub struct FullSum<'a> {
    lights: &'a VplSet,
}

/// Segments that are traced together. More need more memory, fewer cost calls.
const BATCH: usize = 8192;

impl<'a> FullSum<'a> {
    /// The exact sum over `lights`, clamped as these say.
    pub fn new(lights: &'a VplSet) -> Self {
        Self { lights }
    }
}

impl Integrator for FullSum<'_> {
    fn name(&self) -> &'static str {
        "exact"
    }

    fn abilities(&self) -> Abilities {
        Abilities::STILL_MEDIA
    }

    fn describe(&self, metadata: &mut Metadata) {
        super::describe_lights(self.lights.provenance(), metadata);
        metadata.set(keys::PAIRS_ARE, "terms of the sum");
    }

    fn begin<'v>(&'v self, setting: Setting<'v>) -> Box<dyn Estimates + 'v> {
        Box::new(move |tile: &Window| self.tile(&setting, tile))
    }
}

impl FullSum<'_> {
    fn tile(&self, setting: &Setting<'_>, tile: &Window) -> Vec<PixelRecord> {
        let pixels: Vec<PixelSum> =
            tile.pixels().map(|(x, y)| setting.view.pixel(setting.tracer, [x, y])).collect();
        let contribution =
            ContributionKernel::new(self.lights.provenance().clamp_distance).within(setting.tracer.scene());
        let mut sums = Sums::new(&pixels, tile.width as usize);
        let mut batch = SegmentBatch::default();
        // For each segment its gather point, and for each fan its light and its number of segments.
        let mut points: Vec<u32> = Vec::new();
        let mut fans: Vec<(u32, u32)> = Vec::new();
        let mut visibility = Vec::new();
        let mut in_media = Segments::default();
        for (number, light) in self.lights.lights().iter().enumerate() {
            let start = points.len();
            sums.receivers.facing(light, &mut points);
            // Lights that nobody faces leave no trace.
            if points.len() > start {
                batch.push_fan(
                    light.apex(),
                    points[start..].iter().map(|&j| sums.points[j as usize].position),
                );
                fans.push((number as u32, (points.len() - start) as u32));
                points[start..].iter().for_each(|&j| in_media.push(sums.points[j as usize].medium));
            }
            if batch.len() >= BATCH || number + 1 == self.lights.len() {
                setting.tracer.visibility(&batch, &mut visibility);
                let passing = in_media
                    .matter(setting.tracer)
                    .then(|| in_media.passing(setting.tracer, &batch, 0.0, &visibility));
                let mut segments = points.iter().zip(&visibility).enumerate();
                for &(light, count) in &fans {
                    let light = &self.lights.lights()[light as usize];
                    for (k, (&j, &v)) in segments.by_ref().take(count as usize) {
                        sums.rays[sums.pixel_of[j as usize] as usize] += 1;
                        if v > 0.0 {
                            let unoccluded = contribution.unoccluded(&sums.points[j as usize], light);
                            let term = passing.map_or(unoccluded * v, |passing| unoccluded * passing[k]);
                            sums.totals[sums.pixel_of[j as usize] as usize].add(term);
                        }
                    }
                }
                batch.clear();
                in_media.clear();
                points.clear();
                fans.clear();
            }
        }
        pixels
            .iter()
            .enumerate()
            .map(|(i, pixel)| {
                let mut total = sums.totals[i];
                total.add(pixel.background);
                PixelRecord {
                    radiance: total.total(),
                    claim: Claim::Exact,
                    stop: Stop::Complete,
                    pairs: self.lights.len() as u64 * pixel.points.len() as u64,
                    rays: sums.rays[i],
                    ..pixel.features.into()
                }
            })
            .collect()
    }
}

/// All gather points of a tile, and what has come to its pixels so far.
struct Sums {
    points: Vec<GatherPoint>,
    receivers: Receivers,
    pixel_of: Vec<u32>,
    totals: Vec<RgbSum>,
    rays: Vec<u64>,
}

/// Side of the blocks of pixels whose points follow each other: segments that are traced together
/// are then close in both directions.
const BLOCK: usize = 4;

impl Sums {
    /// Nothing yet, of pixels in rows of `width`.
    fn new(pixels: &[PixelSum], width: usize) -> Self {
        let mut order: Vec<usize> = (0..pixels.len()).collect();
        order.sort_by_key(|&i| (i / width / BLOCK, i % width / BLOCK, i));
        let mut points = Vec::new();
        let mut pixel_of = Vec::new();
        for i in order {
            points.extend_from_slice(&pixels[i].points);
            pixel_of.resize(points.len(), i as u32);
        }
        Self {
            receivers: Receivers::new(&points),
            points,
            pixel_of,
            totals: vec![RgbSum::default(); pixels.len()],
            rays: vec![0; pixels.len()],
        }
    }
}
