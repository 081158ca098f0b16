//! Our method for light transport: a cut over one large set of VPLs and many gather points,
//! compensation by paths for the light that VPLs do not carry, and an interval that accounts for
//! the choice of VPLs and points.
//!
//! ```text
//! L̂ = B + Σ_pairs ȳ_k + (1/m) Σ_paths          E L̂ = light transport
//! ```
//!
//! `B` is the emission seen directly. The first sum is a stratified estimate of the sum over all
//! VPLs ([`GuidedLights`]), by a cut that is guided by pilot visibility and does not depend on its
//! own samples ([`cut`](crate::cut)). The `m` paths estimate the light that VPLs do not carry
//! ([`compensation`](crate::compensation)).
//!
//! The cost of a cut is sublinear in the numbers of VPLs and points. These numbers are so large
//! that the choice of VPLs and points contributes only a small part of the half-width. The samples
//! of the cut estimate that part ([`Population`](crate::cut::Population)).
//!
//! Each interim analysis compares the half-width with `max(ε L̂ / (1 + ε), ε_abs)`. If the
//! half-width is larger, the numbers of pairs and of paths grow by predicted factors
//! ([`Finding::growth`](interval::Finding::growth)). If growth cannot help, the pixel is restarted:
//! with a longer clamp distance if the choice of VPLs dominates the error, with more gather points
//! if the choice of points does. If a restart is not enough, or paths of the neighbourhood show
//! that VPLs do not help or are not needed, the pixel is estimated by full paths alone
//! ([`Estimator`]). If the user sets no `ε_abs`, it is `ε` times a hundredth of the mean luminance
//! of the view.
//!
//! # Guarantee
//! For a given number of pairs and paths the estimate is unbiased over sets of VPLs, except for
//! paths longer than the longest light path. Intervals are calibrated: measured, not proven. Held
//! to this by the suite's `light_transport`; the record has the measurements.

mod estimate;
mod interval;
mod lights;
mod nearby;
mod paths;
mod pixel;

pub use estimate::Estimator;
pub use lights::GuidedLights;

use std::cell::OnceCell;
use std::sync::OnceLock;

use super::{Claim, ControlOptions, Estimates, Integrator, PixelRecord, Setting, Truth};
use crate::accel::{Glass, Tracer};
use crate::contribution::ContributionKernel;
use crate::cut::{CellVisibility, CutMemory, Pilot, PilotVisibility};
use crate::film::{Metadata, Window, keys};
use crate::guidance::cell_of;
use crate::math::Instants;
use crate::rng::{self, Purpose};
use crate::vpl::EmitterSampler;

use estimate::Common;
use nearby::{Cells, Nearby, about};
use pixel::Pixel;

/// Default for the most pairs and paths of a pixel.
const MOST_WORK: u64 = 1 << 16;
/// Number of clamp distances.
const CLAMPS: usize = CLAMP_FACTORS.len();
/// Clamp distances, as multiples of the first.
const CLAMP_FACTORS: [f32; 3] = [1.0, 4.0, 16.0];
/// Integrator that controls the error against light transport.
#[derive(Debug)]
pub struct LightTransport<'a> {
    lights: &'a GuidedLights,
    emitters: EmitterSampler<'a>,
    options: ControlOptions,
    only: Option<Estimator>,
}

impl<'a> LightTransport<'a> {
    /// Returns the method for these lights of the tracer's scene.
    pub fn new(tracer: &'a Tracer, lights: &'a GuidedLights, options: &ControlOptions) -> Self {
        let emitters = EmitterSampler::by_use(tracer, lights.options());
        let options = options.in_view_of(lights.importance_brightness());
        Self { lights, emitters, options, only: None }
    }

    /// Returns the method with one estimator for all pixels, to measure or test it. Has no effect
    /// unless the truth is light transport.
    #[must_use]
    pub fn only_by(mut self, estimator: Estimator) -> Self {
        self.only = Some(estimator);
        self
    }

    /// Absolute error that suffices in dark pixels (W·m⁻²·sr⁻¹): the given one, or a share of the
    /// mean luminance of the view.
    pub fn absolute_error(&self) -> f64 {
        self.options.absolute_error
    }

    /// Most pairs and paths of a pixel.
    fn most_work(&self) -> u64 {
        self.options.max_pairs.unwrap_or(MOST_WORK)
    }

    fn clamp_distance(&self, clamp: usize) -> f32 {
        self.lights.provenance().clamp_distance * CLAMP_FACTORS[clamp]
    }
}

/// The method on one view.
struct LightTransportView<'v> {
    method: &'v LightTransport<'v>,
    setting: Setting<'v>,
    visibility: OnceLock<PilotVisibility>,
    /// Cells of the image, by clamp distance.
    cells: [Cells; CLAMPS],
}

impl LightTransportView<'_> {
    /// Paths of the neighbourhood of a pixel, with the given clamp distance.
    fn nearby(&self, common: &Common<'_>, pixel: [u32; 2], clamp: usize) -> &Nearby {
        let seed = rng::key(self.method.options.seed, Purpose::Guidance, clamp as u64);
        let (distance, options) = (self.method.clamp_distance(clamp), &self.method.options);
        about(&self.cells[clamp], pixel, common, distance, options, seed)
    }
}

/// Visibility of the lights from a cell: measured when a pixel of the cell first sums over them.
struct Visibility<'a> {
    of_view: &'a LightTransportView<'a>,
    pilot: Pilot<'a>,
    cell: [u32; 2],
    known: OnceCell<CellVisibility<'a>>,
}

impl Visibility<'_> {
    fn get(&self) -> &CellVisibility<'_> {
        let of_image = || PilotVisibility::new(&self.pilot, self.of_view.method.options.seed);
        let of_cell = || self.of_view.visibility.get_or_init(of_image).about(&self.pilot, self.cell);
        self.known.get_or_init(of_cell)
    }
}

impl Integrator for LightTransport<'_> {
    fn name(&self) -> &'static str {
        "tashika"
    }

    fn describe(&self, metadata: &mut Metadata) {
        super::describe_lights(self.lights.provenance(), &Instants::default(), metadata);
        let o = &self.options;
        metadata.set(keys::TRUTH, self.lights.truth().to_string());
        metadata.set(keys::ERROR, o.error);
        metadata.set(keys::CONTROL, o.controlled.to_string());
        metadata.set(keys::ERROR_ABSOLUTE, o.absolute_error);
        metadata.set(keys::CONFIDENCE, o.confidence);
        metadata.set(keys::CLAIM, Claim::Calibrated.code().name);
        metadata.set(keys::MAX_PAIRS, self.most_work());
        metadata.set(keys::PAIRS_ARE, "pairs of clusters, and paths");
        metadata.set(keys::CUT_SEED, o.seed);
        if let Some(account) = self.lights.account() {
            let [straight, specular, scattered] = account.by_way;
            metadata.set(keys::LIGHT_STRAIGHT, straight);
            metadata.set(keys::LIGHT_SPECULAR, specular);
            metadata.set(keys::LIGHT_SCATTERED, scattered);
            let [surfaces, points, infinity] = account.by_origin;
            metadata.set(keys::LIGHT_OF_SURFACES, surfaces);
            metadata.set(keys::LIGHT_OF_POINTS, points);
            metadata.set(keys::LIGHT_OF_INFINITY, infinity);
        }
    }

    fn begin<'v>(&'v self, setting: Setting<'v>) -> Box<dyn Estimates + 'v> {
        let cells = [(); CLAMPS].map(|()| Cells::new(setting.view.size));
        Box::new(LightTransportView { method: self, setting, visibility: OnceLock::new(), cells })
    }
}

impl Estimates for LightTransportView<'_> {
    fn tile(&self, tile: &Window) -> Vec<PixelRecord> {
        let Self { method, setting, .. } = self;
        let Setting { tracer, view } = *setting;
        let contribution = ContributionKernel::new(method.clamp_distance(0))
            .with_glass(Glass::SolidStops)
            .within(tracer.scene());
        let pilot = Pilot { tracer, view, lights: method.lights.tree(), contribution };
        let common = Common {
            setting,
            emitters: &method.emitters,
            lights: method.lights,
            compensates: method.lights.truth() == Truth::Transport,
            controlled: method.options.controlled,
        };
        let mut cells: Vec<Visibility<'_>> = Vec::new();
        let mut memory = CutMemory::default();
        let mut estimate = |pixel: [u32; 2]| {
            let cell = cell_of(pixel);
            let place = cells.iter().position(|known| known.cell == cell).unwrap_or_else(|| {
                cells.push(Visibility { of_view: self, pilot, cell, known: OnceCell::new() });
                cells.len() - 1
            });
            Pixel::new(self, common, &cells[place], pixel).estimate(&mut memory)
        };
        tile.pixels().map(|(x, y)| estimate([x, y])).collect()
    }
}
