//! What paths of the neighbourhood found, before a pixel is begun.
//!
//! A pixel that has followed a hundred paths may not have met the bright one of a thousand. Its neighbours together have: the image is divided into
//! cells of [`CELL`] × [`CELL`] pixels, and [`PATHS`] paths of either [`Estimator`], of random pixels of the cell, are followed for no estimate.
//! Those from points that mirror sharply are kept apart from others: a glossy pixel among matt ones is as noisy as its like.
//!
//! # Independence
//! Pixels and paths come from streams of their own ([`Purpose::Guidance`]); a cell is a function of the image and its place.

use std::sync::OnceLock;

use super::estimate::{Common, Estimator, is_narrow, summed_with};
use crate::rng::{self, Purpose, Stream};
use crate::stats::Moments;
use crate::uncarried::Uncarried;

/// Side of a cell (pixels).
const CELL: u32 = 16;
/// Paths of a cell, of either estimator.
const PATHS: u64 = 1024;
/// Fewest paths of a kind that tell of it.
const FEWEST: u64 = 64;

/// Paths of one estimator from the pixels of a cell.
#[derive(Clone, Debug, Default)]
struct Paths {
    /// Of single paths, by part of what is controlled: from points that do not mirror sharply, from those that do, and of all.
    moments: [Vec<Moments>; 3],
    rays: u64,
}

/// What is known of a cell, for one clamp distance.
#[derive(Debug)]
pub(super) struct Nearby {
    place: [u32; 2],
    key: u64,
    uncarried: Paths,
    /// Few pixels ask for it.
    whole: OnceLock<Paths>,
}

impl Nearby {
    /// Paths of what VPLs do not carry, of pixels that are like one that mirrors sharply or does not.
    pub(super) fn uncarried(&self, is_narrow: bool) -> &[Moments] {
        let [matt, glossy, all] = &self.uncarried.moments;
        let of_kind = if is_narrow { glossy } else { matt };
        if of_kind.first().is_some_and(|moments| moments.count() >= FEWEST) { of_kind } else { all }
    }

    /// Paths of all there is.
    pub(super) fn whole(&self, common: &Common<'_>) -> &[Moments] {
        &self.whole.get_or_init(|| follow(Estimator::Paths, self.place, common, 0.0, self.key)).moments[2]
    }

    /// Rays of these that each pixel of the cell cost.
    pub(super) fn rays_per_pixel(&self, estimator: Estimator) -> u64 {
        let rays = match estimator {
            Estimator::Vpls => self.uncarried.rays,
            Estimator::Paths => self.whole.get().map_or(0, |paths| paths.rays),
        };
        rays.div_ceil(u64::from(CELL * CELL))
    }
}

/// The cells of an image.
#[derive(Debug)]
pub(super) struct Cells {
    cells: Vec<OnceLock<Nearby>>,
    columns: u32,
}

impl Cells {
    /// Of an image of that size; nothing is followed yet.
    pub(super) fn new(size: [u32; 2]) -> Self {
        let [columns, rows] = size.map(|side| side.div_ceil(CELL));
        Self { cells: (0..columns as usize * rows as usize).map(|_| OnceLock::new()).collect(), columns }
    }

    /// What is known about a pixel.
    pub(super) fn about(
        &self,
        pixel: [u32; 2],
        common: &Common<'_>,
        clamp_distance: f32,
        seed: u64,
    ) -> &Nearby {
        let place = pixel.map(|at| at / CELL);
        self.cells[(place[1] * self.columns + place[0]) as usize].get_or_init(|| {
            let key = rng::key(seed, Purpose::Guidance, u64::from(place[1]) << 32 | u64::from(place[0]));
            let uncarried = follow(Estimator::Vpls, place, common, clamp_distance, key);
            Nearby { place, key, uncarried, whole: OnceLock::new() }
        })
    }
}

fn follow(
    estimator: Estimator,
    place: [u32; 2],
    common: &Common<'_>,
    clamp_distance: f32,
    key: u64,
) -> Paths {
    let first = place.map(|at| at * CELL);
    let size = common.setting.view.size;
    let sides = [0, 1].map(|axis| size[axis].min(first[axis] + CELL) - first[axis]);
    let key = rng::key(key, Purpose::Guidance, 1 + estimator as u64);
    let mut stream = Stream::new(key, Purpose::Guidance, 0);
    let parts = common.controlled.parts();
    let mut uncarried = Uncarried::new(common.lit(estimator, clamp_distance));
    let mut moments = [(); 3].map(|()| vec![Moments::default(); parts.len()]);
    for path in 0..PATHS {
        let pixel = [0, 1].map(|axis| first[axis] + stream.below(u64::from(sides[axis])) as u32);
        let key = rng::key(key, Purpose::Guidance, path);
        let seen = common.samples(pixel, 1, key);
        let mut value = if estimator == Estimator::Paths { seen.background } else { Default::default() };
        let mut kind = 0;
        for point in &seen.points {
            let summed = summed_with(point, estimator);
            value += uncarried.estimate(point, &summed, key, &mut Stream::new(key, Purpose::Uncarried, 0));
            kind = usize::from(is_narrow(&point.bsdf));
        }
        for (number, part) in parts.iter().enumerate() {
            moments[kind][number].push(part.of(value));
            moments[2][number].push(part.of(value));
        }
    }
    Paths { moments, rays: PATHS + uncarried.rays() }
}
