//! Paths of the neighbourhood of a pixel. They use separate random numbers and enter no estimate.
//!
//! Paths start at random pixels of each cell of the image. A pixel uses the paths of its cell and
//! of the surrounding cells. Light that one path in some thousands meets, such as light behind
//! glass, is either bright in a wide neighbourhood or nowhere. Lamps that the camera sees, directly
//! or over specular surfaces, end at their edges. Paths of the surrounding cells therefore count
//! without the light of these lamps.

use super::path::{Found, Start};
use super::stopping::PathStop;
use super::{PathTracer, PathView};
use crate::guidance::{Grid, cell_of, key_of, pixels_of};
use crate::integrator::Setting;
use crate::rng::{self, Purpose, Stream};
use crate::stats::Moments;

/// Number of paths of a cell.
const PATHS: u64 = 1024;

/// Paths of the cells of a view.
#[derive(Debug)]
pub(super) struct Neighbourhood {
    cells: Grid<OfCell>,
    /// Paths of each cell and its surrounding cells.
    around: Grid<Nearby>,
}

/// Paths of random pixels of a cell.
#[derive(Debug)]
struct OfCell {
    /// Moments of single paths, by part of the error metric.
    whole: Vec<Moments>,
    /// Moments without the lamps that the camera sees.
    scattered: Vec<Moments>,
    /// Luminances of the paths that met a surface or medium that scatters light.
    gathered: Moments,
    rays: u64,
}

/// Paths of a cell and its surrounding cells.
#[derive(Debug)]
pub(super) struct Nearby {
    moments: Vec<Moments>,
    gathered: Moments,
    rays: u64,
}

impl Nearby {
    /// Moments of single paths, by part of the error metric.
    pub fn moments(&self) -> &[Moments] {
        &self.moments
    }

    /// Approximate luminance of surfaces and media in the neighbourhood, zero if no path met any
    /// (W·m⁻²·sr⁻¹).
    pub fn importance_brightness(&self) -> f64 {
        self.gathered.mean()
    }

    /// Rays of the cell's own paths, divided among its pixels.
    pub fn rays_per_pixel(&self) -> u64 {
        self.rays.div_ceil(u64::from(Grid::<Self>::SIDE * Grid::<Self>::SIDE))
    }
}

impl Neighbourhood {
    /// Returns the empty neighbourhood of an image of `size` (pixels).
    pub fn new(size: [u32; 2]) -> Self {
        Self { cells: Grid::new(size), around: Grid::new(size) }
    }
}

impl PathView<'_> {
    /// Paths of the neighbourhood of a pixel; `None` if the stopping rule does not use them.
    pub fn nearby(&self, pixel: [u32; 2]) -> Option<&Nearby> {
        if !matches!(self.method.stop, PathStop::Calibrated { .. }) {
            return None;
        }
        let Neighbourhood { cells, around } = &self.neighbourhood;
        let center = cell_of(pixel);
        let of_cell = |cell| cells.at(cell, || self.method.follow_of_cell(&self.setting, cell));
        let join = || {
            let OfCell { whole, gathered, rays, .. } = of_cell(center);
            let (mut moments, mut gathered) = (whole.clone(), *gathered);
            for cell in cells.about(center).filter(|cell| *cell != center) {
                let theirs = of_cell(cell);
                moments.iter_mut().zip(&theirs.scattered).for_each(|(all, theirs)| all.merge(theirs));
                gathered.merge(&theirs.gathered);
            }
            Nearby { moments, gathered, rays: *rays }
        };
        Some(around.at(center, join))
    }

    /// Approximate luminance of surfaces that may be in a pixel though no path met one. Zero where
    /// no ray of the pixel can meet a surface.
    pub fn importance_unmet(&self, pixel: [u32; 2], nearby: &Nearby) -> f64 {
        let Setting { tracer, view } = &self.setting;
        if view.pyramid(pixel).is_some_and(|pyramid| tracer.is_empty_within(&pyramid)) {
            return 0.0;
        }
        let of_view = self.brightness.get_or_init(|| self.method.importance_brightness(&self.setting));
        nearby.importance_brightness().max(*of_view)
    }
}

impl PathTracer<'_> {
    fn follow_of_cell(&self, setting: &Setting<'_>, cell: [u32; 2]) -> OfCell {
        let window = pixels_of(cell, setting.view.size);
        let key = key_of(cell, setting.view.seed);
        let parts = self.stop.controlled().parts();
        let mut whole = vec![Moments::default(); parts.len()];
        let mut scattered = whole.clone();
        let mut gathered = Moments::default();
        let mut rays = 0;
        let mut tracing = self.tracing(setting);
        let moves = tracing.moves;
        let mut of_pixels = Stream::new(key, Purpose::Guidance, 0);
        let starts = (0..PATHS).map(|path| {
            let pixel = setting.view.random_pixel(&window, &mut of_pixels);
            Start::random(&setting.view, pixel, rng::key(key, Purpose::Guidance, 1 + path), moves)
        });
        tracing.follow(starts, |found| {
            let Found { radiance, seen, .. } = *found;
            if found.gathers {
                gathered.push(radiance.luminance().into());
            }
            for (part, (whole, scattered)) in parts.iter().zip(whole.iter_mut().zip(&mut scattered)) {
                whole.push(part.of(radiance));
                scattered.push(part.of(radiance - seen));
            }
            rays += found.rays;
        });
        OfCell { whole, scattered, gathered, rays }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::Tracer;
    use crate::bsdf::HenyeyGreenstein;
    use crate::color::Rgb;
    use crate::error::Location;
    use crate::gather::{GatherOptions, View};
    use crate::math::Vec3;
    use crate::scene::{Camera, Emitter, Medium, SceneBuilder};

    /// A point light and the camera are in fog, without surfaces. Light that the fog scatters to
    /// the camera counts as scattered, although it reached the fog directly.
    #[test]
    fn only_what_is_seen_straight_is_left_out() {
        let mut b = SceneBuilder::new("fog", Location::default());
        let phase = HenyeyGreenstein { asymmetry: 0.0 };
        let [absorption, scattering] = [0.5, 0.05].map(Rgb::gray);
        let fog = b.add_medium(Medium { name: "fog".into(), absorption, scattering, phase, variation: None });
        let camera = Camera::look_at("c", Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 0.7);
        b.add_camera(Camera { medium: Some(fog.unwrap()), ..camera }).unwrap();
        b.add_emitter(Emitter::Point { position: Vec3::new(0.0, 2.0, -1.0), intensity: Rgb::WHITE }).unwrap();
        let tracer = Tracer::new(Arc::new(b.build().unwrap()));
        let view = View {
            camera: &tracer.scene().cameras()[0],
            size: [8, 8],
            gather: GatherOptions::default(),
            seed: 1,
        };
        let method = PathTracer::new(&tracer, PathStop::Count(1), 4).unwrap();
        let OfCell { whole, scattered, .. } =
            method.follow_of_cell(&Setting { tracer: &tracer, view }, [0, 0]);
        assert!(whole[0].mean() > 0.0);
        assert_eq!(whole, scattered);
    }
}
