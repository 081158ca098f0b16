//! Guidance: what is learned about a picture before any estimate is made, and where it sends work.
//!
//! * [`learn_light_guide`]: which emission reaches what the camera sees.
//! * [`Caustics`]: light that comes to surfaces over specular ones, which neither sums
//!   nor undirected paths may find, and where it comes from.
//! * [`Photons`]: how much light reaches surfaces, by light paths alone.
//! * [`SeenLamps`]: how bright lamps that are seen make a pixel, however small they are.
//! * [`importance_correlation`]: how much more VPLs that light paths leave together vary than as
//!   many that are independent.
//! * [`Grid`]: the cells of an image, each with what was learned of its neighbourhood.
//!
//! # Independence
//! What guides is learned from random numbers of its own
//! ([`Purpose::Guidance`](crate::rng::Purpose::Guidance)), which no estimate uses: estimates are
//! unbiased whatever was learned.

mod caustics;
mod correlation;
mod emission;
mod grid;
mod lamps;
mod photons;

pub use caustics::{Caustics, Directions};
pub use correlation::importance_correlation;
pub use emission::{Guided, learn_light_guide};
pub use grid::{Grid, cell_of, key_of, pixels_of, random_pixel};
pub use lamps::SeenLamps;
pub use photons::Photons;

use crate::vpl::LightTracer;

/// Light paths of a pass.
const PATHS: u64 = 1 << 16;
/// Caustic photons after which no further pass looks for more.
const ENOUGH: usize = 1 << 14;

/// Knowledge of light paths about the light on surfaces.
#[derive(Clone, Debug)]
pub struct LightOnSurfaces {
    /// All light.
    pub all: Photons,
    /// Light over specular surfaces, if there is any.
    pub caustics: Option<Caustics>,
}

impl LightOnSurfaces {
    /// Traces light paths; none if hardly any light reaches a diffuse surface. Runs on the current
    /// thread pool.
    pub fn learn(tracing: &LightTracer<'_>, seed: u64) -> Option<Self> {
        let (photons, lights) = tracing.caustic_photons(PATHS, ENOUGH, seed);
        let bounds = tracing.tracer().scene().bounds();
        let (all, _) = Photons::new(&lights, &bounds, seed)?;
        Some(Self { all, caustics: Caustics::learn(&photons, &lights, &bounds, seed) })
    }
}
