//! Integrators: from a tile of pixels to estimates, each saying how sure it is.

mod exact;
mod iwasaki2019;
mod light_transport;
mod lightcuts;
mod mdlc;
mod method;
mod nabata2016;
mod options;
mod path;
mod published;
mod sakai2018;
mod tashika;

pub use exact::Exact;
pub use iwasaki2019::Iwasaki2019;
pub use light_transport::{Estimator, GuidedLights, LightTransport};
pub use lightcuts::Lightcuts;
pub use mdlc::Mdlc;
pub use method::{LitBy, Method};
pub use nabata2016::Nabata2016;
pub use options::{ControlOptions, Lights, MANY_PAIRS, Truth};
pub use path::{Path, PathStop};
pub use sakai2018::Sakai2018;
pub use tashika::{Claim, Ingredient, Tashika};

use published::{Published, Scope};

use serde::{Deserialize, Serialize};

use crate::accel::Tracer;
use crate::color::Rgb;
use crate::film::{Metadata, Window};
use crate::gather::{Features, View};
use crate::vpl::Provenance;

/// What an estimate promises about its distance to the truth it estimates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum ErrorClaim {
    /// Nothing.
    #[default]
    None,
    /// It is the sum over the given VPLs and gather points, to rounding.
    Exact,
    /// The interval that a published method states: that sum is said to be within the half-width,
    /// with the confidence. Neither proven nor calibrated.
    Published {
        /// Half-width of the interval (W·m⁻²·sr⁻¹).
        half_width: f32,
        /// Confidence, in (0, 1).
        confidence: f32,
    },
    /// An interval that holds at least as often as its confidence says, on scenes at large;
    /// measured, not proven.
    Calibrated {
        /// Half-width of the interval (W·m⁻²·sr⁻¹).
        half_width: f32,
        /// Confidence, in (0, 1).
        confidence: f32,
    },
    /// An interval that holds with at least the confidence, for this pixel; proven.
    Certified {
        /// Half-width of the interval (W·m⁻²·sr⁻¹).
        half_width: f32,
        /// Confidence, in (0, 1).
        confidence: f32,
    },
}

impl ErrorClaim {
    /// Number of the claim in the plane `claim` of a film.
    pub fn id(&self) -> u32 {
        match self {
            Self::None => 0,
            Self::Exact => 1,
            Self::Published { .. } => 2,
            Self::Calibrated { .. } => 3,
            Self::Certified { .. } => 4,
        }
    }

    /// Half-width of the interval (W·m⁻²·sr⁻¹) of what is [controlled](crate::color::Controlled);
    /// zero if exact, or if nothing is claimed.
    pub fn half_width(&self) -> f32 {
        match self {
            Self::None | Self::Exact => 0.0,
            Self::Published { half_width, .. }
            | Self::Calibrated { half_width, .. }
            | Self::Certified { half_width, .. } => *half_width,
        }
    }
}

/// What a half-width is made of, where an estimate knows: what each source of error would make it
/// if it were all (W·m⁻²·sr⁻¹).
///
/// Errors of independent sources add up in squares, so the whole is less than the sum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HalfWidths {
    /// That few terms of the sums over VPLs were drawn.
    pub clustering: f32,
    /// That the VPLs, and the gather points, are some of all that there could be.
    pub lights: f32,
    /// That what VPLs do not carry is estimated by few paths.
    pub compensation: f32,
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
    /// The method's own rule says that it is accurate enough.
    RuleMet,
    /// It has cost as much as permitted.
    Budget,
    /// There is light that the method cannot find, too much of it for a claim.
    NotFound,
}

impl StopReason {
    /// Number of the reason in the plane `stop` of a film.
    pub fn id(&self) -> u32 {
        match self {
            Self::NotRendered => 0,
            Self::Complete => 1,
            Self::SampleCount => 2,
            Self::RuleMet => 3,
            Self::Budget => 4,
            Self::NotFound => 5,
        }
    }
}

/// What an integrator says of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelEstimate {
    /// Estimated radiance (W·m⁻²·sr⁻¹).
    pub radiance: Rgb,
    /// Standard error of what is controlled, luminance as a rule, as far as it is known
    /// (W·m⁻²·sr⁻¹); zero if the estimate is exact.
    pub standard_error: f32,
    /// What is promised.
    pub claim: ErrorClaim,
    /// What its half-width is made of.
    pub half_widths: HalfWidths,
    /// Why work ended.
    pub stop: StopReason,
    /// Terms of the sum that were looked at, or paths.
    pub pairs: u64,
    /// Rays and segments traced.
    pub rays: u64,
    /// For denoisers and compositing.
    pub features: Features,
}

/// Writes into a film's metadata where the lights come from.
fn describe_lights(p: &Provenance, metadata: &mut Metadata) {
    metadata.set("truth", Truth::Vpl.to_string());
    metadata.set("vpls", p.direct + p.indirect);
    metadata.set("vpls.requested", p.requested);
    metadata.set("vpls.direct", p.direct);
    metadata.set("vpls.indirect", p.indirect);
    metadata.set("vpls.paths", p.paths);
    metadata.set("vpls.seed", p.seed);
    metadata.set("vpls.max_depth", p.max_depth);
    metadata.set("vpls.scene", p.scene.as_str());
    metadata.set("vpls.clamp_distance_m", f64::from(p.clamp_distance));
    metadata.set("vpls.glossy_share", f64::from(p.glossy_share));
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
/// Called once a tile, since rays are fastest when the pixels of a tile trace theirs together. The
/// estimate of a pixel must be a function of the setting, the integrator and the pixel: neither its
/// tile nor threads may enter.
pub trait Integrator: Sync {
    /// Name on the command line and in files.
    fn name(&self) -> &'static str;

    /// Writes into a film's metadata what the result depends on beyond the setting.
    fn describe(&self, metadata: &mut Metadata);

    /// Estimates of the tile's pixels, row by row.
    fn estimate(&self, setting: &Setting<'_>, tile: &Window) -> Vec<PixelEstimate>;
}
