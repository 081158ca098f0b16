//! The whole sum: every VPL at every gather point. The reference of all methods.
//!
//! ```text
//! L = B + Σ_j Σ_i w_j M_ji G_ji V_ji I_i
//! ```
//!
//! over VPLs and gather points of the same instant. Summed in `f64`, in the order (instant, VPL,
//! gather point), so that the result does not depend on tiles. VPLs are processed one by one: the
//! segments from a VPL to all points of a tile form one fan. Rays are fastest in this order.

use std::ops::Range;

use super::{Claim, Estimates, Integrator, PixelRecord, Setting, Stop};
use crate::accel::{SegmentBatch, Tracer};
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

/// Segments that are traced together. Larger batches need more memory, smaller ones more calls.
const BATCH: usize = 8192;

impl<'a> FullSum<'a> {
    /// Returns the exact sum over `lights`, with their clamp.
    pub fn new(lights: &'a VplSet) -> Self {
        Self { lights }
    }
}

impl Integrator for FullSum<'_> {
    fn name(&self) -> &'static str {
        "exact"
    }

    fn abilities(&self) -> Abilities {
        Abilities::ALL
    }

    fn describe(&self, metadata: &mut Metadata) {
        super::describe_lights(self.lights.provenance(), self.lights.instants(), metadata);
        metadata.set(keys::PAIRS_ARE, "terms of the sum");
    }

    fn begin<'v>(&'v self, setting: Setting<'v>) -> Box<dyn Estimates + 'v> {
        Box::new(move |tile: &Window| self.tile(&setting, tile))
    }
}

impl FullSum<'_> {
    fn tile(&self, setting: &Setting<'_>, tile: &Window) -> Vec<PixelRecord> {
        let instants = self.lights.instants();
        let pixels: Vec<PixelSum> =
            tile.pixels().map(|(x, y)| setting.view.pixel_at(setting.tracer, [x, y], instants)).collect();
        let mut sums = vec![Sum::default(); pixels.len()];
        for (instant, &share) in (0..).zip(instants.shares()) {
            let points = Points::new(&pixels, tile.width as usize, instant);
            if !points.all.is_empty() {
                self.add(setting.tracer, &points, self.lights.at(instant.into()), share, &mut sums);
            }
        }
        pixels
            .iter()
            .zip(sums)
            .map(|(pixel, Sum { mut total, pairs, rays })| {
                total.add(pixel.background);
                PixelRecord {
                    radiance: total.total(),
                    claim: Claim::Exact,
                    stop: Stop::Complete,
                    pairs,
                    rays,
                    ..pixel.features.into()
                }
            })
            .collect()
    }

    /// Adds the contributions of `lights` to `points`, all of one instant, at the time `share` of
    /// the shutter interval.
    fn add(&self, tracer: &Tracer, points: &Points, lights: Range<usize>, share: f32, sums: &mut [Sum]) {
        let contribution =
            ContributionKernel::new(self.lights.provenance().clamp_distance).within(tracer.scene());
        let mut batch = SegmentBatch::default();
        // Gather point of each segment; light and number of segments of each fan.
        let mut facing: Vec<u32> = Vec::new();
        let mut fans: Vec<(u32, u32)> = Vec::new();
        let mut visibility = Vec::new();
        let mut in_media = Segments::default();
        for &pixel in &points.pixel_of {
            sums[pixel as usize].pairs += lights.len() as u64;
        }
        for number in lights.clone() {
            let light = &self.lights.lights()[number];
            let start = facing.len();
            points.receivers.facing(light, &mut facing);
            // Lights that no point faces have no fan.
            if facing.len() > start {
                let places = facing[start..].iter().map(|&j| points.all[j as usize].position);
                batch.push_fan(light.apex(), places);
                fans.push((number as u32, (facing.len() - start) as u32));
                facing[start..].iter().for_each(|&j| in_media.push(points.all[j as usize].medium));
            }
            if batch.len() >= BATCH || number + 1 == lights.end {
                tracer.visibility_at(&batch, share, &mut visibility);
                let passing =
                    in_media.matter(tracer).then(|| in_media.passing(tracer, &batch, share, &visibility));
                let mut segments = facing.iter().zip(&visibility).enumerate();
                for &(light, count) in &fans {
                    let light = &self.lights.lights()[light as usize];
                    for (k, (&j, &v)) in segments.by_ref().take(count as usize) {
                        let sum = &mut sums[points.pixel_of[j as usize] as usize];
                        sum.rays += 1;
                        if v > 0.0 {
                            let unoccluded = contribution.unoccluded(&points.all[j as usize], light);
                            sum.total.add(passing.map_or(unoccluded * v, |passing| unoccluded * passing[k]));
                        }
                    }
                }
                batch.clear();
                in_media.clear();
                facing.clear();
                fans.clear();
            }
        }
    }
}

/// Sums of a pixel so far.
#[derive(Clone, Copy, Default)]
struct Sum {
    total: RgbSum,
    pairs: u64,
    rays: u64,
}

/// All gather points of a tile at one instant.
struct Points {
    all: Vec<GatherPoint>,
    receivers: Receivers,
    pixel_of: Vec<u32>,
}

/// Side of the blocks of pixels whose points are consecutive: segments that are traced together are
/// then close to each other across and down the image.
const BLOCK: usize = 4;

impl Points {
    /// Points of pixels in rows of `width`.
    fn new(pixels: &[PixelSum], width: usize, instant: u16) -> Self {
        let mut order: Vec<usize> = (0..pixels.len()).collect();
        order.sort_by_key(|&i| (i / width / BLOCK, i % width / BLOCK, i));
        let mut all = Vec::new();
        let mut pixel_of = Vec::new();
        for i in order {
            all.extend(pixels[i].points.iter().filter(|point| point.instant == instant));
            pixel_of.resize(all.len(), i as u32);
        }
        Self { receivers: Receivers::new(&all), all, pixel_of }
    }
}
