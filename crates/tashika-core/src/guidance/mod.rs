//! Guidance: knowledge about a picture that is learned before any estimate is made, and that
//! directs work.
//!
//! * [`learn_light_guide`]: the emission that reaches surfaces in view.
//! * [`Caustics`]: light that reaches surfaces over specular ones, and its directions. Sums over
//!   VPLs and unguided paths may miss this light.
//! * [`Photons`]: the light that reaches surfaces, by light paths alone.
//! * [`SeenLight`]: luminance of lamps and caustics in each pixel, however small they are.
//! * [`Sky`]: luminance of the sky in a pixel, however small its bright parts are.
//! * [`LightAccount`]: shares of the light in view by its way, and by the kind of its emitter.
//! * [`importance_correlation`]: the ratio of the variance of a sum over VPLs to that over the same
//!   number of independent VPLs. One light path leaves several VPLs.
//! * [`Grid`]: the cells of an image, each with data learned in its neighbourhood.
//!
//! # Independence
//! Guidance is learned from separate random numbers
//! ([`Purpose::Guidance`](crate::rng::Purpose::Guidance)) that no estimate uses. Estimates are
//! therefore unbiased whatever was learned.

mod caustics;
mod correlation;
mod emission;
mod grid;
mod photons;
mod seen;
mod sky;

pub use caustics::{Caustics, Directions};
pub use correlation::importance_correlation;
pub use emission::{Guided, learn_light_guide};
pub use grid::{Grid, cell_of, key_of, pixels_of};
pub use photons::Photons;
pub use seen::{LightAccount, SeenLight};
pub use sky::Sky;

use crate::gather::View;
use crate::vpl::{ArrivedLight, LightTracer, Vpl};

/// Number of paths for each pixel of an image from which guidance is learned.
const PATHS_OF_PIXEL: u64 = 64;
/// Least and greatest number of these paths.
const PATHS: [u64; 2] = [1 << 14, 1 << 16];
/// Paths followed as one piece of parallel work.
const CHUNK: u64 = 1024;
/// Number of caustic photons after which no further pass looks for more.
const ENOUGH: usize = 1 << 14;

/// Returns the number of paths from which guidance is learned. It is proportional to the number of
/// pixels, so that a small image costs little. It is limited, since a larger image of a view shows
/// hardly more of the scene.
fn paths_for(view: &View<'_>) -> u64 {
    PATHS_OF_PIXEL.saturating_mul(view.guided_pixels()).clamp(PATHS[0], PATHS[1]).next_multiple_of(CHUNK)
}

/// Light on surfaces, as learned by light paths.
#[derive(Clone, Debug)]
pub struct LightOnSurfaces {
    /// Light that arrives on surfaces by any way.
    pub all: Photons,
    /// Light that arrives over specular surfaces, if there is any.
    pub caustics: Option<Caustics>,
    /// Light that arrives over specular surfaces, by pixel, if the camera sees any.
    pub seen_caustics: Option<SeenLight>,
    /// Shares of the light in view by its way, and by the kind of its emitter.
    pub account: Option<LightAccount>,
}

impl LightOnSurfaces {
    /// Traces light paths; `None` if hardly any light reaches a diffuse surface. Runs on the
    /// current thread pool.
    pub fn learn(tracing: &LightTracer<'_>, view: &View<'_>, seed: u64) -> Option<Self> {
        let ArrivedLight { lights, routes, caustics } = tracing.arrived_light(paths_for(view), ENOUGH, seed);
        let bounds = tracing.tracer().scene().bounds();
        let (all, _) = Photons::new(&lights, &bounds, seed)?;
        let of_caustics: Vec<Vpl> = caustics.iter().map(|photon| photon.light).collect();
        let seen_caustics = SeenLight::of(&of_caustics, tracing.tracer(), view);
        let account = LightAccount::of(&lights, &routes, tracing.tracer(), view);
        let caustics = Caustics::learn(&caustics, &lights, &bounds, seed);
        Some(Self { all, caustics, seen_caustics, account })
    }
}
