//! Integrators: from a tile of pixels to estimates, each saying how sure it is.

mod exact;
mod path;

pub use exact::Exact;
pub use path::Path;

use serde::{Deserialize, Serialize};

use crate::accel::Tracer;
use crate::color::Rgb;
use crate::film::{Metadata, Window};
use crate::gather::{Features, View};

/// What an estimate promises about its distance to the truth it estimates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum ErrorClaim {
    /// Nothing.
    #[default]
    None,
    /// It is the sum over the given VPLs and gather points, to rounding.
    Exact,
}

impl ErrorClaim {
    /// Number of the claim in the plane `claim` of a film.
    pub fn id(&self) -> u32 {
        match self {
            Self::None => 0,
            Self::Exact => 1,
        }
    }
}

/// Why work on a pixel ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum StopReason {
    /// It has not begun.
    #[default]
    NotRendered,
    /// There was nothing left to do.
    Complete,
    /// The number of samples that was asked for is reached.
    SampleCount,
}

impl StopReason {
    /// Number of the reason in the plane `stop` of a film.
    pub fn id(&self) -> u32 {
        match self {
            Self::NotRendered => 0,
            Self::Complete => 1,
            Self::SampleCount => 2,
        }
    }
}

/// What an integrator says of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelEstimate {
    /// Estimated radiance (W·m⁻²·sr⁻¹).
    pub radiance: Rgb,
    /// Standard error of the luminance, as far as it is known (W·m⁻²·sr⁻¹); zero if the estimate is exact.
    pub standard_error: f32,
    /// What is promised.
    pub claim: ErrorClaim,
    /// Why work ended.
    pub stop: StopReason,
    /// Terms of the sum that were looked at, or paths.
    pub pairs: u64,
    /// Rays and segments traced.
    pub rays: u64,
    /// For denoisers and compositing.
    pub features: Features,
}

/// What every integrator needs: the world and who looks at it.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a> {
    /// Rays.
    pub tracer: &'a Tracer,
    /// Gather points.
    pub view: View<'a>,
}

/// The one open seam: everything that turns pixels into estimates.
///
/// Called once a tile, since rays are fastest when the pixels of a tile trace theirs together. The estimate of a pixel must be a
/// function of the setting, the integrator and the pixel: neither its tile nor threads may enter.
pub trait Integrator: Sync {
    /// Name on the command line and in files.
    fn name(&self) -> &'static str;

    /// Writes into a film's metadata what the result depends on beyond the setting.
    fn describe(&self, metadata: &mut Metadata);

    /// Estimates of the tile's pixels, row by row.
    fn estimate(&self, setting: &Setting<'_>, tile: &Window) -> Vec<PixelEstimate>;
}
