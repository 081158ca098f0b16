//! Integrators: from a tile of pixels to estimates, each with a claim about its error.

mod full_sum;
mod iwasaki2019;
mod light_transport;
mod lightcuts;
mod looks;
mod mdlc;
mod method;
mod nabata2016;
mod options;
mod path_samples;
mod path_spread;
mod path_tracer;
mod published;
mod sakai2018;
mod tashika;
mod with_planes;

pub use crate::film::{Claim, HalfWidths, LuminanceParts, PixelRecord, Stop};
pub use full_sum::FullSum;
pub use light_transport::{Estimator, GuidedLights, LightTransport};
pub use method::SumMethod;
pub use options::{ControlOptions, MANY_PAIRS, Truth};
pub use path_samples::{PathSampler, PathSamples};
pub use path_tracer::{PathStop, PathTracer};
pub use tashika::{Ingredient, Promise};
pub use with_planes::WithPlanes;

use iwasaki2019::Iwasaki2019;
use lightcuts::Lightcuts;
use mdlc::Mdlc;
use nabata2016::Nabata2016;
use options::Lights;
use published::{Published, Scope};
use sakai2018::Sakai2018;
use tashika::Tashika;

use crate::accel::Tracer;
use crate::film::{Metadata, Window, keys};
use crate::gather::View;
use crate::math::Instants;
use crate::scene::Abilities;
use crate::vpl::Provenance;

/// Writes the origin of the lights to a film's metadata.
fn describe_lights(p: &Provenance, instants: &Instants, metadata: &mut Metadata) {
    metadata.set(keys::TRUTH, Truth::Vpl.to_string());
    metadata.set(keys::VPLS, p.direct + p.indirect);
    metadata.set(keys::VPLS_REQUESTED, p.requested);
    metadata.set(keys::VPLS_DIRECT, p.direct);
    metadata.set(keys::VPLS_INDIRECT, p.indirect);
    metadata.set(keys::VPLS_PATHS, p.paths);
    metadata.set(keys::VPLS_SEED, p.seed);
    metadata.set(keys::VPLS_MAX_DEPTH, p.max_depth);
    metadata.set(keys::VPLS_SCENE, p.scene.as_str());
    metadata.set(keys::VPLS_CLAMP_DISTANCE, f64::from(p.clamp_distance));
    metadata.set(keys::VPLS_GLOSSY_SHARE, f64::from(p.glossy_share));
    if !instants.is_single() {
        metadata.set(keys::VPLS_INSTANTS, instants.len() as u64);
    }
}

/// A plane that an integrator fills in addition to those of [`PixelRecord`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlaneBeside {
    /// Name of the plane, without a dot.
    pub name: String,
    /// Names of the channels, in order.
    pub channels: &'static [&'static str],
    /// Meaning and unit of the samples.
    pub doc: String,
}

/// Input of every integrator: a scene and a view of it.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a> {
    /// Scene, with trees for rays.
    pub tracer: &'a Tracer,
    /// Camera, image size and gather points.
    pub view: View<'a>,
}

/// Interface of all methods that estimate pixels. Other crates may implement it.
///
/// ```text
/// Integrator ── begin(setting) ─► Estimates ── tile(window) ─► PixelRecord of each pixel
/// ```
pub trait Integrator: Sync {
    /// Name on the command line and in files.
    fn name(&self) -> &'static str;

    /// Features of scenes that the integrator renders in addition to still surfaces.
    fn abilities(&self) -> Abilities {
        Abilities::STILL
    }

    /// Writes to a film's metadata the options that the result depends on beyond the setting.
    fn describe(&self, metadata: &mut Metadata);

    /// Planes of radiances (W·m⁻²·sr⁻¹) that films have in addition to those of [`PixelRecord`].
    /// [`Estimates::tile_with_beside`] returns their samples.
    fn planes_beside(&self) -> Vec<PlaneBeside> {
        Vec::new()
    }

    /// Begins with a view. The returned object keeps anything learned about the view from tile to
    /// tile.
    fn begin<'v>(&'v self, setting: Setting<'v>) -> Box<dyn Estimates + 'v>;

    /// Estimates of one tile alone, row by row.
    fn estimate(&self, setting: &Setting<'_>, tile: &Window) -> Vec<PixelRecord> {
        self.begin(*setting).tile(tile)
    }
}

/// The estimates of one view.
///
/// Each call covers one tile, since rays are fastest when those of all pixels of a tile are traced
/// together. The estimate of a pixel must be a function of the setting, the integrator and the
/// pixel. It must not depend on the tile or on threads.
pub trait Estimates: Sync {
    /// Estimates of the tile's pixels, row by row.
    fn tile(&self, tile: &Window) -> Vec<PixelRecord>;

    /// Estimates of the tile's pixels, and the samples of [`Integrator::planes_beside`]: pixel by
    /// pixel, and for each pixel the samples of all planes in their order.
    fn tile_with_beside(&self, tile: &Window) -> (Vec<PixelRecord>, Vec<f32>) {
        (self.tile(tile), Vec::new())
    }
}

impl<F: Fn(&Window) -> Vec<PixelRecord> + Sync> Estimates for F {
    fn tile(&self, tile: &Window) -> Vec<PixelRecord> {
        self(tile)
    }
}
