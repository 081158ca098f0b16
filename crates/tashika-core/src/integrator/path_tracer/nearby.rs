//! What paths of the neighbourhood of a pixel found: followed for no estimate, by random numbers of
//! their own.

use super::stopping::PathStop;
use super::{Draws, OfView};
use crate::guidance::{Grid, cell_of, key_of, pixels_of, random_pixel};
use crate::rng::{self, Purpose, Stream};
use crate::stats::Moments;

/// Paths of a cell.
const PATHS: u64 = 1024;

/// Paths of random pixels of a cell of the image.
#[derive(Debug)]
pub(super) struct Nearby {
    moments: Vec<Moments>,
    rays: u64,
}

impl Nearby {
    /// Of single paths, by part of what is controlled.
    pub fn moments(&self) -> &[Moments] {
        &self.moments
    }

    /// Rays that each pixel of the cell cost.
    pub fn rays_per_pixel(&self) -> u64 {
        self.rays.div_ceil(u64::from(Grid::<Self>::SIDE * Grid::<Self>::SIDE))
    }
}

impl OfView<'_> {
    /// Paths of the neighbourhood of a pixel, where it is decided by them.
    pub fn nearby(&self, pixel: [u32; 2]) -> Option<&Nearby> {
        let PathStop::Calibrated { options, .. } = &self.method.stop else { return None };
        let cell = cell_of(pixel);
        let learn = || {
            let window = pixels_of(cell, self.setting.view.size);
            let key = key_of(cell, self.setting.view.seed);
            let parts = options.controlled.parts();
            let mut moments = vec![Moments::default(); parts.len()];
            let mut tracing = self.method.tracing(&self.setting);
            let mut of_pixels = Stream::new(key, Purpose::Guidance, 0);
            for path in 0..PATHS {
                let pixel = random_pixel(&window, &mut of_pixels);
                let of_path = rng::key(key, Purpose::Guidance, 1 + path);
                let mut draws = Draws::new(of_path, Purpose::Guidance, 0);
                let radiance = tracing.through(&self.setting, pixel, of_path, &mut draws);
                parts.iter().zip(&mut moments).for_each(|(part, m)| m.push(part.of(radiance)));
            }
            Nearby { moments, rays: tracing.rays }
        };
        Some(self.cells.at(cell, learn))
    }
}
