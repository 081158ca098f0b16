//! Guided VPLs that are stored for the next render of the same view.

use std::sync::{Arc, Mutex, PoisonError};

use crate::error::Result;
use crate::gather::{Filter, View};
use crate::integrator::{GuidedLights, Truth};
use crate::scene::Camera;
use crate::vpl::VplOptions;

/// Guided VPLs of the last render. A later render with the same options, truth, camera, size and
/// filter reuses them instead of tracing, and gives the same bits. A cache must be used for one
/// scene only, since scenes are not compared.
#[derive(Debug, Default)]
pub struct LightCache(Mutex<Option<Traced>>);

#[derive(Debug)]
struct Traced {
    by: Key,
    lights: Arc<GuidedLights>,
}

/// All inputs of guided VPLs, except for the scene.
type Key = (VplOptions, Truth, Camera, [u32; 2], Filter);

impl LightCache {
    /// Returns the stored lights for these inputs, or else calls `trace` and stores its lights.
    pub(super) fn lights(
        &self,
        options: &VplOptions,
        truth: Truth,
        view: &View<'_>,
        trace: impl FnOnce() -> Result<Arc<GuidedLights>>,
    ) -> Result<Arc<GuidedLights>> {
        let by = (options.clone(), truth, view.camera.clone(), view.size, view.gather.filter);
        let known = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(traced) = known().as_ref().filter(|traced| traced.by == by) {
            return Ok(Arc::clone(&traced.lights));
        }
        let lights = trace()?;
        *known() = Some(Traced { by, lights: Arc::clone(&lights) });
        Ok(lights)
    }
}
