//! Pixels of one integrator, with additional planes of another.
//!
//! Methods that state an interval cluster the light of all emitters, and do not separate the
//! contributions of light groups. The planes of groups are then estimated by separate paths. Their
//! sum and the radiance of the pixel have the same expectation, but independent errors.
//!
//! # Guarantee
//! Records are those of the first integrator, bit for bit. Held to this by the suite's
//! `light_groups`.

use super::{Estimates, Integrator, PixelRecord, PlaneBeside, Setting};
use crate::film::{Metadata, Window};
use crate::scene::Abilities;

/// Pixels of one integrator with the [additional planes](Integrator::planes_beside) of another.
pub struct WithPlanes<'a> {
    pixels: Box<dyn Integrator + 'a>,
    planes: Box<dyn Integrator + 'a>,
}

impl<'a> WithPlanes<'a> {
    /// Combines the pixels of `pixels` with the additional planes of `planes`, whose own pixels are
    /// ignored.
    pub fn new(pixels: impl Integrator + 'a, planes: impl Integrator + 'a) -> Self {
        Self { pixels: Box::new(pixels), planes: Box::new(planes) }
    }
}

impl Integrator for WithPlanes<'_> {
    fn name(&self) -> &'static str {
        self.pixels.name()
    }

    fn abilities(&self) -> Abilities {
        let [pixels, planes] = [self.pixels.abilities(), self.planes.abilities()];
        Abilities { motion: pixels.motion && planes.motion }
    }

    fn describe(&self, metadata: &mut Metadata) {
        self.pixels.describe(metadata);
    }

    fn planes_beside(&self) -> Vec<PlaneBeside> {
        self.planes.planes_beside()
    }

    fn begin<'v>(&'v self, setting: Setting<'v>) -> Box<dyn Estimates + 'v> {
        Box::new(ViewWithPlanes { pixels: self.pixels.begin(setting), planes: self.planes.begin(setting) })
    }
}

struct ViewWithPlanes<'v> {
    pixels: Box<dyn Estimates + 'v>,
    planes: Box<dyn Estimates + 'v>,
}

impl Estimates for ViewWithPlanes<'_> {
    fn tile(&self, tile: &Window) -> Vec<PixelRecord> {
        self.pixels.tile(tile)
    }

    fn tile_with_beside(&self, tile: &Window) -> (Vec<PixelRecord>, Vec<f32>) {
        (self.pixels.tile(tile), self.planes.tile_with_beside(tile).1)
    }
}
