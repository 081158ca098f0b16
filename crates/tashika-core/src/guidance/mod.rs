//! Guidance: what is learned about a picture before any estimate is made, and where it sends work.
//!
//! * [`learn_light_guide`]: which emission reaches what the camera sees.
//! * [`Caustics`]: light that comes to surfaces over specular ones, which neither sums
//!   nor undirected paths may find, and where it comes from.
//! * [`Photons`]: how much light reaches surfaces, by light paths alone.
//! * [`SeenLight`]: luminance of lamps and caustics in each pixel, however small they are.
//! * [`LightAccount`]: shares of the light in view by its way and by its emitters.
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
mod photons;
mod seen;

pub use caustics::{Caustics, Directions};
pub use correlation::importance_correlation;
pub use emission::{Guided, learn_light_guide};
pub use grid::{Grid, cell_of, key_of, pixels_of, random_pixel};
pub use photons::Photons;
pub use seen::{LightAccount, SeenLight};

use crate::gather::View;
use crate::vpl::{ArrivedLight, LightTracer, Vpl};

/// Paths for each pixel of an image from which guidance is learned.
const PATHS_OF_PIXEL: u64 = 64;
/// Fewest and most of these paths.
const PATHS: [u64; 2] = [1 << 14, 1 << 16];
/// Paths followed as one piece of parallel work.
const CHUNK: u64 = 1024;
/// Caustic photons after which no further pass looks for more.
const ENOUGH: usize = 1 << 14;

/// Number of paths from which guidance is learned: in proportion to the pixels, so that little is learned
/// for a small image, and limited, since the scene has no more to learn for a large one.
fn paths_for(view: &View<'_>) -> u64 {
    let pixels = u64::from(view.size[0]) * u64::from(view.size[1]);
    (PATHS_OF_PIXEL * pixels).clamp(PATHS[0], PATHS[1]).next_multiple_of(CHUNK)
}

/// Knowledge of light paths about the light on surfaces.
#[derive(Clone, Debug)]
pub struct LightOnSurfaces {
    /// All light.
    pub all: Photons,
    /// Light over specular surfaces, if there is any.
    pub caustics: Option<Caustics>,
    /// Light over specular surfaces in the pixels, if the camera sees any.
    pub seen_caustics: Option<SeenLight>,
    /// Account of the light in view.
    pub account: Option<LightAccount>,
}

impl LightOnSurfaces {
    /// Traces light paths; none if hardly any light reaches a diffuse surface. Runs on the current
    /// thread pool.
    pub fn learn(tracing: &LightTracer<'_>, view: &View<'_>, seed: u64) -> Option<Self> {
        let ArrivedLight { lights, routes, caustics } = tracing.arrived_light(paths_for(view), ENOUGH, seed);
        let bounds = tracing.tracer().scene().bounds();
        let (all, _) = Photons::new(&lights, &bounds, seed)?;
        let of_caustics: Vec<Vpl> = caustics.iter().map(|photon| photon.light).collect();
        let (seen_caustics, account) =
            SeenLight::on_surfaces(&lights, &routes, &of_caustics, tracing.tracer(), view);
        let caustics = Caustics::learn(&caustics, &lights, &bounds, seed);
        Some(Self { all, caustics, seen_caustics, account })
    }
}
