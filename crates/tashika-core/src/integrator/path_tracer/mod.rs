//! Unidirectional path tracing: an independent estimate of light transport, as a check of the
//! many-light sum.
//!
//! At each surface light is sampled in two ways, by drawing a point of the emitters and by
//! following the BSDF, weighted by the balance heuristic (Veach 1997, section 9.2). The emitters,
//! BSDFs and cameras are shared with the other integrators; the estimator is not. There is no
//! clamp. Thin glass does not bend light, and both strategies see through it; they also see light
//! from infinity through panes of solid glass ([`through_panes`](crate::gather::through_panes)).
//! Other light through solid glass is found by following paths only.
//!
//! Each path has one time within the shutter interval: the camera, moving instances and drawn
//! lights are placed as of that time.
//!
//! In a scene with [media](crate::scene::Medium), paths also scatter between surfaces. Paths are
//! followed in streams (module `stream`).
//!
//! The estimate is the mean of independent paths. Its standard error is that of this mean.
//!
//! A [`PathStop`] decides when a pixel has enough paths.

mod groups;
mod nearby;
mod path;
mod pixel;
mod samples;
mod stopping;
mod stream;
mod tracing;

pub use self::stopping::PathStop;

use std::iter;
use std::sync::OnceLock;

use self::nearby::Neighbourhood;
use self::pixel::{Missing, PixelPaths};
use super::{Estimates, Integrator, PixelRecord, PlaneBeside, Setting, Truth};
use crate::accel::Tracer;
use crate::error::{Error, Result};
use crate::film::{Metadata, Window, keys};
use crate::scene::{Abilities, LightGroups};
use crate::vpl::EmitterSampler;

/// Unidirectional path tracer of a scene.
#[derive(Debug)]
pub struct PathTracer<'s> {
    emitters: EmitterSampler<'s>,
    stop: PathStop,
    max_depth: u32,
    groups: Option<&'s LightGroups>,
}

/// Most camera samples from which the features of a pixel's first surfaces are computed.
const OF_FEATURES: u32 = 16;

impl<'s> PathTracer<'s> {
    /// Returns a path tracer whose paths meet at most `max_depth` surfaces.
    ///
    /// # Errors
    /// No paths, a first analysis at fewer than two, a `max_depth` of zero, options out of range.
    pub fn new(tracer: &'s Tracer, stop: PathStop, max_depth: u32) -> Result<Self> {
        stop.validate()?;
        if max_depth == 0 {
            return Err(Error::option("max_depth", max_depth, "at least 1"));
        }
        Ok(Self { emitters: EmitterSampler::new(tracer), stop, max_depth, groups: None })
    }

    /// Returns the path tracer with planes for each group of the scene's lights. Groups are
    /// estimated by the paths of the pixel, so that their planes add up to the radiance except for
    /// rounding. Each group also has a plane of standard errors.
    #[must_use]
    pub fn with_groups(self, groups: &'s LightGroups) -> Self {
        Self { groups: Some(groups), ..self }
    }
}

impl Integrator for PathTracer<'_> {
    fn name(&self) -> &'static str {
        "path"
    }

    fn abilities(&self) -> Abilities {
        Abilities::ALL
    }

    fn describe(&self, metadata: &mut Metadata) {
        metadata.set(keys::TRUTH, Truth::Transport.to_string());
        metadata.set(keys::PAIRS_ARE, "paths");
        self.stop.describe(metadata);
        metadata.set(keys::MAX_DEPTH, self.max_depth);
    }

    fn begin<'v>(&'v self, setting: Setting<'v>) -> Box<dyn Estimates + 'v> {
        let neighbourhood = Neighbourhood::new(setting.view.size);
        Box::new(PathView { method: self, setting, neighbourhood, brightness: OnceLock::new() })
    }

    fn planes_beside(&self) -> Vec<PlaneBeside> {
        self.groups.map(groups::planes).unwrap_or_default()
    }
}

/// Estimates of one view by paths.
struct PathView<'v> {
    method: &'v PathTracer<'v>,
    setting: Setting<'v>,
    neighbourhood: Neighbourhood,
    /// Approximate mean luminance of the view.
    brightness: OnceLock<f64>,
}

impl Estimates for PathView<'_> {
    fn tile(&self, tile: &Window) -> Vec<PixelRecord> {
        self.tile_with_beside(tile).0
    }

    fn tile_with_beside(&self, tile: &Window) -> (Vec<PixelRecord>, Vec<f32>) {
        let mut tracing = self.method.tracing(&self.setting);
        let mut pixels: Vec<_> =
            tile.pixels().map(|(x, y)| PixelPaths::new(self, [x, y], tracing.has_media)).collect();
        loop {
            let missing: Vec<_> = pixels.iter().map(PixelPaths::missing).collect();
            if missing.iter().all(Missing::is_empty) {
                break;
            }
            let (view, moves) = (&self.setting.view, tracing.moves);
            let starts = missing.iter().flat_map(|missing| missing.starts(view, moves));
            let of_paths = |(index, missing): (usize, &Missing)| iter::repeat_n(index, missing.len());
            let mut of_paths = missing.iter().enumerate().flat_map(of_paths);
            tracing.follow(starts, |found| {
                let index = of_paths.next().expect("a path of a pixel");
                pixels[index].add(found);
            });
            pixels.iter_mut().for_each(PixelPaths::analyse);
        }
        let mut beside = Vec::new();
        pixels.iter().for_each(|pixel| pixel.samples_by_group(&mut beside));
        (pixels.iter().map(PixelPaths::record).collect(), beside)
    }
}
