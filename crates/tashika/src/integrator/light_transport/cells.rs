//! What is known of the neighbourhood of a pixel before it is begun.
//!
//! A pixel that has followed a hundred paths may not have met the bright one of a thousand. Its neighbours together have: the image is divided into
//! cells of [`CELL`] × [`CELL`] pixels, and [`PATHS`] paths of either [`Estimator`], of random pixels of the cell, are followed for no estimate. How far sets of
//! VPLs differ is told by repetitions of [`PIXELS`] random pixels with each of the sets that plan.
//!
//! # Independence
//! Pixels and paths come from streams of their own ([`Purpose::Guidance`]), their VPLs are those of the sets that only plan; a cell is a function of the
//! image and its place.

use std::sync::OnceLock;

use super::super::Setting;
use super::replicate::{Estimator, Recipe, Repetition};
use super::sets::LightSets;
use crate::color::Controlled;
use crate::cut::CutMemory;
use crate::gather::{GatherOptions, View};
use crate::rng::{self, Purpose, Stream};
use crate::stats::Moments;
use crate::vpl::EmitterSampler;

/// Side of a cell (pixels).
const CELL: u32 = 16;
/// Paths of a cell, of either estimator.
const PATHS: u64 = 4096;
/// Pixels of a cell that are repeated with each of the sets that plan.
const PIXELS: u64 = 24;
/// How these are repeated.
const SUM: Recipe = Recipe { estimator: Estimator::Vpls, pairs: 64, paths: 0 };

/// The cells of an image.
#[derive(Debug)]
pub(super) struct Cells {
    cells: Vec<OnceLock<Cell>>,
    columns: u32,
}

/// Paths of one estimator.
#[derive(Clone, Debug, Default)]
pub(super) struct Paths {
    /// Of single paths, by part of what is controlled.
    pub moments: Vec<Moments>,
    /// Rays of all of them.
    pub rays: u64,
}

/// What is known of a cell.
#[derive(Clone, Debug, Default)]
pub(super) struct Cell {
    /// Paths of what VPLs do not carry.
    uncarried: Paths,
    /// Paths of all there is.
    whole: Paths,
    /// Variance of the sum over the VPLs of a set, from set to set, over its square; of the first part of what is controlled.
    pub relative_variance_of_sets: f64,
    /// Rays that each pixel of the cell cost.
    pub rays_per_pixel: u64,
}

impl Paths {
    /// Rays of a path, on average.
    pub(super) fn rays_per_path(&self) -> f64 {
        self.rays as f64 / self.moments.first().map_or(0, Moments::count).max(1) as f64
    }
}

impl Cell {
    pub(super) fn paths(&self, estimator: Estimator) -> &Paths {
        match estimator {
            Estimator::Vpls => &self.uncarried,
            Estimator::Paths => &self.whole,
        }
    }
}

impl Cells {
    /// Of an image of that size; nothing is followed yet.
    pub(super) fn new(size: [u32; 2]) -> Self {
        let [columns, rows] = size.map(|side| side.div_ceil(CELL));
        Self { cells: (0..columns as usize * rows as usize).map(|_| OnceLock::new()).collect(), columns }
    }

    /// The cell of a pixel.
    pub(super) fn of(
        &self,
        pixel: [u32; 2],
        setting: &Setting<'_>,
        emitters: &EmitterSampler<'_>,
        sets: &LightSets,
        controlled: Controlled,
        seed: u64,
    ) -> &Cell {
        let place = pixel.map(|at| at / CELL);
        self.cells[(place[1] * self.columns + place[0]) as usize].get_or_init(|| {
            let key = rng::key(seed, Purpose::Guidance, u64::from(place[1]) << 32 | u64::from(place[0]));
            Pilot { setting, emitters, sets, controlled, key }.cell(place)
        })
    }
}

/// What a cell is looked at with.
struct Pilot<'a> {
    setting: &'a Setting<'a>,
    emitters: &'a EmitterSampler<'a>,
    sets: &'a LightSets,
    controlled: Controlled,
    key: u64,
}

impl Pilot<'_> {
    fn cell(&self, place: [u32; 2]) -> Cell {
        let first = place.map(|at| at * CELL);
        let size = self.setting.view.size;
        let sides = [0, 1].map(|axis| size[axis].min(first[axis] + CELL) - first[axis]);
        let mut stream = Stream::new(self.key, Purpose::Guidance, 0);
        let mut pixel = || [0, 1].map(|axis| first[axis] + stream.below(u64::from(sides[axis])) as u32);
        let uncarried = self.paths(Estimator::Vpls, &mut pixel);
        let whole = self.paths(Estimator::Paths, &mut pixel);
        let (relative_variance_of_sets, rays) = self.sets_differ(&mut pixel);
        let rays = uncarried.rays + whole.rays + rays;
        let rays_per_pixel = rays.div_ceil(u64::from(sides[0]) * u64::from(sides[1]));
        Cell { uncarried, whole, relative_variance_of_sets, rays_per_pixel }
    }

    fn paths(&self, estimator: Estimator, pixel: &mut impl FnMut() -> [u32; 2]) -> Paths {
        let parts = self.controlled.parts();
        let mut paths = Paths { moments: vec![Moments::default(); parts.len()], rays: 0 };
        let view =
            View { gather: GatherOptions { points: 1, ..self.setting.view.gather }, ..self.setting.view };
        let setting = Setting { view, ..*self.setting };
        let key = rng::key(self.key, Purpose::Guidance, 1 + estimator as u64);
        for path in 0..PATHS {
            let key = rng::key(key, Purpose::Guidance, path);
            let set = &self.sets.planning()[0];
            let repetition = Repetition::new(&setting, self.emitters, set, pixel(), key, true);
            let mut met = false;
            paths.rays += 1 + repetition.paths(estimator, 1, |value, _| {
                met = true;
                for (part, moments) in parts.iter().zip(&mut paths.moments) {
                    moments.push(part.of(value));
                }
            });
            if !met {
                paths.moments.iter_mut().for_each(|moments| moments.push(0.0));
            }
        }
        paths
    }

    /// The relative variance of sums from set to set, and the rays that it took.
    fn sets_differ(&self, pixel: &mut impl FnMut() -> [u32; 2]) -> (f64, u64) {
        let (mut variance, mut squares, mut rays) = (0.0, 0.0, 0);
        let mut memory = CutMemory::default();
        for number in 0..PIXELS {
            let pixel = pixel();
            let mut sums = Moments::default();
            let mut clustering = 0.0;
            for (set, of_set) in (0..).zip(self.sets.planning()) {
                let key = rng::key(self.key, Purpose::Replicate, number << 32 | set);
                let repetition = Repetition::new(self.setting, self.emitters, of_set, pixel, key, true);
                let repeated = repetition.estimate(self.controlled, &SUM, &mut memory);
                let known = &repeated.known[0];
                sums.push(known.value.mean());
                clustering += known.clustering / self.sets.planning().len() as f64;
                rays += repeated.rays;
            }
            variance += sums.variance() - clustering;
            squares += sums.mean() * sums.mean();
        }
        (if squares > 0.0 { (variance / squares).max(0.0) } else { 0.0 }, rays)
    }
}
