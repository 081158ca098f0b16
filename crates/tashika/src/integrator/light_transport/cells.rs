//! What paths of the neighbourhood say of the variance of a pixel's paths.
//!
//! A pixel that has followed a hundred paths may not have met the bright one of a thousand. Its neighbours together have: the image is divided into
//! cells of [`CELL`] × [`CELL`] pixels, and [`PATHS`] paths of random pixels of the cell are followed for no estimate.
//!
//! # Independence
//! Pixels and paths come from streams of their own ([`Purpose::Guidance`]), their VPLs are those of the set that only plans; a cell is a function of the
//! image and its place.

use std::sync::OnceLock;

use super::super::Setting;
use super::replicate::Repetition;
use super::sets::LightSets;
use crate::color::Controlled;
use crate::gather::{GatherOptions, View};
use crate::rng::{self, Purpose, Stream};
use crate::stats::Moments;
use crate::vpl::EmitterSampler;

/// Side of a cell (pixels).
const CELL: u32 = 16;
/// Paths of a cell.
const PATHS: u64 = 4096;

/// The cells of an image.
#[derive(Debug)]
pub(super) struct Cells {
    cells: Vec<OnceLock<Cell>>,
    columns: u32,
}

/// What the paths of a cell say.
#[derive(Clone, Debug, Default)]
pub(super) struct Cell {
    /// Of single paths, by part of what is controlled.
    pub paths: Vec<Moments>,
    /// Rays that each pixel of the cell cost.
    pub rays_per_pixel: u64,
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
        let [column, row] = pixel.map(|at| at / CELL);
        self.cells[(row * self.columns + column) as usize].get_or_init(|| {
            let key = rng::key(seed, Purpose::Guidance, u64::from(row) << 32 | u64::from(column));
            let view = View { gather: GatherOptions { points: 1, ..setting.view.gather }, ..setting.view };
            let setting = Setting { view, ..*setting };
            let [width, height] = setting.view.size;
            let mut stream = Stream::new(key, Purpose::Guidance, 2);
            let mut within =
                |first: u32, end: u32| first + stream.below(u64::from(end.min(first + CELL) - first)) as u32;
            let mut cell =
                Cell { paths: vec![Moments::default(); controlled.parts().len()], rays_per_pixel: 0 };
            let mut rays = 0;
            for path in 0..PATHS {
                let pixel = [within(column * CELL, width), within(row * CELL, height)];
                let key = rng::key(key, Purpose::Guidance, path);
                let repetition = Repetition::new(&setting, emitters, sets.planning(), pixel, key, true);
                let mut met = false;
                rays += 1 + repetition.paths(1, |value, _| {
                    met = true;
                    for (part, moments) in controlled.parts().iter().zip(&mut cell.paths) {
                        moments.push(part.of(value));
                    }
                });
                if !met {
                    cell.paths.iter_mut().for_each(|moments| moments.push(0.0));
                }
            }
            let across = width.min((column + 1) * CELL) - column * CELL;
            let down = height.min((row + 1) * CELL) - row * CELL;
            cell.rays_per_pixel = rays.div_ceil(u64::from(across) * u64::from(down));
            cell
        })
    }
}
