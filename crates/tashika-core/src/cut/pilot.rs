//! Visibility of clusters of lights from regions of the image, measured by pilot segments that no
//! estimate uses.
//!
//! The image is divided into cells ([`Grid`]), and the lights into up to [`CLUSTERS`] nodes of the
//! light tree. For every cell and cluster, [`TRIALS`] segments are traced from gather points of
//! random pixels of the cell to lights of the cluster. The lights are drawn once for the whole
//! image. Therefore they lie next to each other in memory, and the segments from one point form a
//! fan in which neighbours share most of their way. Points and lights belong to the same instant.
//! For a pixel, the trials of its cell and of the eight cells around it are counted. From the roots
//! of the light tree down,
//!
//! ```text
//! p_node = (s p_parent + Σ V) / (s + trials)          p above a root: ½
//! ```
//!
//! where `V` and the trials are those of all clusters under the node. Thus neighbouring lights
//! determine the visibility where trials are few.
//!
//! The cost is at most `CLUSTERS · TRIALS / 16²` = 256 segments per pixel. Cells are measured on
//! first use.
//!
//! # Independence
//! Pilot points, lights and pixels have separate random streams ([`Purpose::Guidance`]). A cell
//! depends on the image and the cell's position, not on the order of queries. The prior of a pixel
//! is therefore independent of all samples of the pixel's estimate.

use std::ops::Range;

use super::rank::VisibilityPrior;
use crate::accel::{Apex, SegmentBatch, Tracer};
use crate::bounds::LightShape;
use crate::contribution::ContributionKernel;
use crate::gather::{GatherPoint, View};
use crate::guidance::{Grid, key_of, pixels_of};
use crate::math::{Instants, Vec3};
use crate::media::Segments;
use crate::rng::{self, Purpose, Stream};
use crate::tree::{LightCluster, LightTree};
use crate::vpl::{Vpl, VplKind};

/// Maximum number of clusters of lights.
const CLUSTERS: usize = 8192;
/// Number of segments for each cell and cluster.
const TRIALS: u32 = 8;
/// Number of sets of lights drawn from the clusters: the four cells of a 2 × 2 block use different
/// sets.
const SETS: usize = 4;
/// `s`: weight of the parent's visibility, in trials.
const PARENT_WEIGHT: f32 = 2.0;
/// Number of points of the image that determine which clusters are important.
const PROBES: u64 = 256;
/// Number of steps in which the visibility of a segment is counted. The sum over `TRIALS` segments
/// fits into a byte.
const PARTS: f32 = 16.0;
/// Lower limit of squared distances, which keeps the importance of a cluster finite at a probe's
/// own position (m²).
const LEAST_SQUARED_DISTANCE: f32 = 1e-6;

/// Data needed to trace pilot segments.
#[derive(Clone, Copy, Debug)]
pub struct Pilot<'a> {
    /// Tracer of the pilot segments.
    pub tracer: &'a Tracer,
    /// View in whose pixels the gather points lie.
    pub view: View<'a>,
    /// Tree over the lights of the image.
    pub lights: &'a LightTree,
    /// Kernel that decides which lights can light a point.
    pub contribution: ContributionKernel<'a>,
}

/// Pilot visibility of an image.
#[derive(Debug)]
pub struct PilotVisibility {
    /// Index of the parent of each node that has a visibility, in depth-first order; roots are
    /// their own parents. These nodes are the clusters with trials and all their ancestors.
    parents: Vec<u32>,
    /// Clusters with trials, each with its index in `parents`.
    clusters: Vec<(u32, LightCluster)>,
    /// Range of `clusters` for each instant.
    of_instants: Vec<Range<usize>>,
    /// Lights drawn from each cluster, one for each gather point of a cell. Neighbouring cells use
    /// different sets.
    representatives: [Vec<[Vpl; TRIALS as usize]>; SETS],
    /// For the number of each cluster of the tree, the index of the smallest node that contains it
    /// and has a visibility.
    place_of: Vec<u32>,
    cells: Grid<Cell>,
    seed: u64,
}

/// Tallies of the pilot segments of a cell.
#[derive(Debug)]
struct Cell {
    /// One tally for each cluster.
    tallies: Vec<Tally>,
    /// Number of segments traced for the cell.
    segments: u64,
}

/// Trials of one cluster in one cell.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    /// Sum of the visibilities, in units of `1 /` [`PARTS`].
    visible: u8,
    trials: u8,
}

/// Visibility of the clusters of lights from the surroundings of one cell.
#[derive(Debug)]
pub struct CellVisibility<'a> {
    place_of: &'a [u32],
    visibility: Vec<f32>,
    /// Number of segments traced for the cell, per pixel of the cell.
    pub segments_per_pixel: u64,
}

impl CellVisibility<'_> {
    /// Expected visibility of the lights from the surroundings of the cell.
    pub fn prior(&self) -> VisibilityPrior<'_> {
        VisibilityPrior::new(self.place_of, &self.visibility)
    }
}

impl PilotVisibility {
    /// Chooses clusters for the image of `pilot`. No segments are traced yet.
    pub fn new(pilot: &Pilot<'_>, seed: u64) -> Self {
        let lights = pilot.lights;
        // The clusters that could light the probes most are split first.
        let probes = probes(pilot, seed);
        let mut chosen =
            lights.split(CLUSTERS, |cluster| importance(lights, cluster, &probes)).into_iter().peekable();
        let mut place_of = vec![u32::MAX; lights.clusters()];
        let (mut parents, mut clusters) = (Vec::new(), Vec::new());
        let mut of_instants = vec![0..0; lights.instants().len()];
        // Clusters with the index of their parent; roots have none.
        let mut waiting = Vec::new();
        for (instant, root) in lights.roots() {
            let first = clusters.len();
            waiting.push((None, root));
            while let Some((above, cluster)) = waiting.pop() {
                let place = parents.len() as u32;
                parents.push(above.unwrap_or(place));
                if chosen.next_if_eq(&cluster).is_some() {
                    clusters.push((place, cluster));
                    fill(lights, cluster, place, &mut place_of);
                } else {
                    place_of[cluster.number()] = place;
                    let children = lights.children(&cluster).into_iter().flatten();
                    waiting.extend(children.rev().map(|child| (Some(place), child)));
                }
            }
            of_instants[usize::from(instant)] = first..clusters.len();
        }
        let mut stream = Stream::new(seed, Purpose::Guidance, 2);
        let mut draw = |cluster| lights.light(lights.draw(cluster, stream.uniform_f64()));
        let representatives = [(); SETS].map(|()| {
            clusters.iter().map(|(_, cluster)| [(); TRIALS as usize].map(|()| draw(cluster))).collect()
        });
        let cells = Grid::new(pilot.view.size);
        Self { parents, clusters, of_instants, representatives, place_of, cells, seed }
    }

    /// Visibility of the lights from a cell and the cells around it.
    pub fn about(&self, pilot: &Pilot<'_>, cell: [u32; 2]) -> CellVisibility<'_> {
        let mut sums = vec![[0.0_f32; 2]; self.parents.len()];
        for near in self.cells.about(cell) {
            for ((place, _), tally) in self.clusters.iter().zip(&self.cell(pilot, near).tallies) {
                let [visible, trials] = &mut sums[*place as usize];
                *visible += f32::from(tally.visible) / PARTS;
                *trials += f32::from(tally.trials);
            }
        }
        let parent_of = |place: usize| Some(self.parents[place] as usize).filter(|&parent| parent < place);
        for place in (1..sums.len()).rev() {
            let [visible, trials] = sums[place];
            let Some(parent) = parent_of(place) else { continue };
            let parent = &mut sums[parent];
            *parent = [parent[0] + visible, parent[1] + trials];
        }
        let mut visibility: Vec<f32> = Vec::with_capacity(sums.len());
        for (place, [visible, trials]) in sums.into_iter().enumerate() {
            let above = parent_of(place).map_or(0.5, |parent| visibility[parent]);
            visibility.push((PARENT_WEIGHT * above + visible) / (PARENT_WEIGHT + trials));
        }
        let pixels = pixels_of(cell, pilot.view.size).area();
        let segments_per_pixel = self.cell(pilot, cell).segments.div_ceil(pixels);
        CellVisibility { place_of: &self.place_of, visibility, segments_per_pixel }
    }

    fn cell(&self, pilot: &Pilot<'_>, cell: [u32; 2]) -> &Cell {
        self.cells.at(cell, || self.measure(pilot, cell))
    }

    fn measure(&self, pilot: &Pilot<'_>, [column, row]: [u32; 2]) -> Cell {
        let window = pixels_of([column, row], pilot.view.size);
        let key = key_of([column, row], self.seed);
        let mut stream = Stream::new(key, Purpose::Guidance, 0);
        let representatives = &self.representatives[(column % 2 + 2 * (row % 2)) as usize];
        let mut seen = vec![(0.0_f32, 0); self.clusters.len()];
        let mut segments = 0;
        for (instant, clusters) in (0..).zip(&self.of_instants) {
            let instants = pilot.lights.instants().only(instant);
            let mut points = Vec::new();
            for trial in 0..TRIALS {
                let pixel = pilot.view.random_pixel(&window, &mut stream);
                let number = u64::from(instant) * u64::from(TRIALS) + u64::from(trial);
                points.extend(one_point(pilot, pixel, &instants, key.wrapping_add(number)));
            }
            // Points that reflect nothing are ignored.
            points.retain(|point| !point.albedo().is_black());
            let trials = pilot.look(&points, instants.shares()[0], |trial| {
                clusters.clone().map(move |cluster| (cluster as u32, &representatives[cluster][trial]))
            });
            for &(cluster, v) in &trials {
                let (visible, trials) = &mut seen[cluster as usize];
                *visible += v;
                *trials += 1;
            }
            segments += trials.len() as u64;
        }
        let tally = |(visible, trials): (f32, u8)| Tally { visible: (visible * PARTS).round() as u8, trials };
        Cell { tallies: seen.into_iter().map(tally).collect(), segments }
    }
}

impl Pilot<'_> {
    /// Visibility of lights from points, at a time given as a share of the time that the shutter is
    /// open.
    ///
    /// * `lights`: for the index of a point in `points`, returns the lights to test, each with a
    ///   number that the caller chooses.
    ///
    /// Returns the number and the visibility of each light that can light its point.
    fn look<'l, L: Iterator<Item = (u32, &'l Vpl)>>(
        &self,
        points: &[GatherPoint],
        share: f32,
        lights: impl Fn(usize) -> L,
    ) -> Vec<(u32, f32)> {
        let mut batch = SegmentBatch::new(self.contribution.glass());
        let mut in_media = Segments::default();
        let has_media = self.tracer.scene().has_media() || points.iter().any(|point| point.medium.is_some());
        // Numbers of the segments, in the order of the batch.
        let mut numbers: Vec<u32> = Vec::new();
        let mut targets = Vec::new();
        for (trial, point) in points.iter().enumerate() {
            for (number, light) in
                lights(trial).filter(|(_, light)| self.contribution.is_facing(point, light))
            {
                // Fans around the point are faster, but the code for media needs the point as the
                // target.
                if light.kind == VplKind::Directional || has_media {
                    batch.push_fan(light.apex(), [point.position]);
                    in_media.push(point.medium);
                    numbers.push(number);
                } else {
                    targets.push((number, light.position));
                }
            }
            numbers.extend(targets.iter().map(|(number, _)| number));
            batch.push_fan(Apex::Point(point.position), targets.drain(..).map(|(_, position)| position));
        }
        let mut visibility = Vec::new();
        self.tracer.visibility_at(&batch, share, &mut visibility);
        if has_media {
            let passing = in_media.passing(self.tracer, &batch, share, &visibility);
            visibility = passing.iter().map(|passing| passing.luminance()).collect();
        }
        numbers.into_iter().zip(visibility).collect()
    }
}

/// A gather point of a pixel at one of `instants`; `None` if the pixel's path gathers nothing.
fn one_point(pilot: &Pilot<'_>, pixel: [u32; 2], instants: &Instants, seed: u64) -> Option<GatherPoint> {
    pilot.view.by(1, seed).pixel_at(pilot.tracer, pixel, instants).points.into_iter().next()
}

/// Positions of gather points of random pixels of the whole image.
fn probes(pilot: &Pilot<'_>, seed: u64) -> Vec<Vec3> {
    let mut stream = Stream::new(seed, Purpose::Guidance, 1);
    let point = |number: u64| {
        let pixel = pilot.view.size.map(|side| stream.below(side.into()) as u32);
        one_point(pilot, pixel, pilot.lights.instants(), rng::key(seed, Purpose::Guidance, number))
            .map(|point| point.position)
    };
    (0..PROBES).filter_map(point).collect()
}

/// Sets the index of a cluster and of all its descendants.
fn fill(lights: &LightTree, cluster: LightCluster, place: u32, place_of: &mut [u32]) {
    let mut waiting = vec![cluster];
    while let Some(next) = waiting.pop() {
        place_of[next.number()] = place;
        waiting.extend(lights.children(&next).into_iter().flatten());
    }
}

/// Approximate irradiance of the probes by a cluster (W·m⁻²), with lights that may be anywhere in
/// its box.
fn importance(lights: &LightTree, cluster: &LightCluster, probes: &[Vec3]) -> f64 {
    let bounds = lights.bounds(cluster);
    let geometric = match bounds.shape {
        LightShape::Directional(_) => probes.len() as f64,
        _ if bounds.reaches_infinity() => return f64::INFINITY,
        _ => {
            let aabb = &bounds.aabb;
            let size = aabb.diagonal() * aabb.diagonal();
            let of = |x: &Vec3| {
                let squared = x.clamp(aabb.lo, aabb.hi).distance_squared(*x);
                f64::from(1.0 / squared.max(size).max(LEAST_SQUARED_DISTANCE))
            };
            probes.iter().map(of).sum()
        }
    };
    lights.luminance(cluster) * geometric
}
