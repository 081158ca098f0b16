//! Virtual point lights: a finite set of lights that represents all light in the scene.
//!
//! A [`VplSet`] is traced from the emitters (Keller 1997) or loaded from a file, and is shared by
//! all methods. Its [`Provenance`] records its origin.

mod carried;
mod caustic;
mod clamp;
mod emitter_clusters;
mod emitters;
mod guide;
mod light;
mod options;
mod order;
mod reflect;
mod route;
mod rows;
mod trace;
mod walk;

#[cfg(test)]
mod tests;

pub use carried::carried_cos;
pub use caustic::{ArrivedLight, CausticPhoton};
pub use clamp::Clamp;
pub use emitter_clusters::EmitterClusters;
pub use emitters::{Choice, EmitterSampler, LightSample};
pub use guide::LightGuide;
pub use light::{Vpl, VplKind};
pub use options::{Emission, VplOptions};
pub use route::{Origin, Route, Way};
pub use rows::LightRows;
pub use trace::LightTracer;

use std::ops::Range;

use crate::error::{Error, Result};
use crate::math::{DVec3, Instants};
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// Origin and parameters of a set of VPLs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Name of the scene for which the set was traced.
    pub scene: String,
    /// Seed of the light paths.
    pub seed: u64,
    /// Requested number of VPLs; the set may have more or fewer.
    pub requested: u64,
    /// Number of VPLs on or towards emitters.
    pub direct: u64,
    /// Number of VPLs created by light paths, on surfaces and in media.
    pub indirect: u64,
    /// Number of light paths that were traced.
    pub paths: u64,
    /// Maximum number of surfaces on a light path.
    pub max_depth: u32,
    /// Distance below which the geometric term no longer grows (m); zero for no clamp.
    pub clamp_distance: f32,
    /// Share of glossy lobes in the flux that surfaces reflect. Light paths carry this flux to
    /// further surfaces. VPLs on surfaces have only cosine lobes and do not send it to receivers.
    pub glossy_share: f32,
    /// Origin of the positions, in the coordinates of the scene's file (m): see
    /// [`Scene::origin`].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub origin: [f64; 3],
}

fn is_zero(place: &[f64; 3]) -> bool {
    *place == [0.0; 3]
}

/// Finite set of lights, for one time or for each of several [`Instants`].
#[derive(Clone, Debug, PartialEq)]
pub struct VplSet {
    lights: Vec<Vpl>,
    instants: Instants,
    /// Index after the last light of each instant.
    ends: Vec<usize>,
    provenance: Provenance,
}

impl VplSet {
    /// Creates a set from existing lights, for a scene without motion.
    pub fn new(lights: Vec<Vpl>, provenance: Provenance) -> Self {
        Self { ends: vec![lights.len()], lights, instants: Instants::default(), provenance }
    }

    /// Creates a set from existing lights that are stored instant by instant. `counts` contains the
    /// number of lights of each instant. `None` if the number of counts differs from the number of
    /// instants, or if their sum differs from the number of lights.
    pub fn at_instants(
        lights: Vec<Vpl>,
        instants: Instants,
        counts: &[u64],
        provenance: Provenance,
    ) -> Option<Self> {
        let mut end = 0_u64;
        let ends = counts.iter().map(|count| {
            end = end.saturating_add(*count);
            end as usize
        });
        let ends: Vec<usize> = ends.collect();
        (end == lights.len() as u64 && ends.len() == instants.len()).then_some(Self {
            lights,
            instants,
            ends,
            provenance,
        })
    }

    /// Returns the lights, instant by instant. Within an instant, consecutive lights are close to
    /// each other in space.
    pub fn lights(&self) -> &[Vpl] {
        &self.lights
    }

    /// Returns the times of the lights.
    pub fn instants(&self) -> &Instants {
        &self.instants
    }

    /// Returns the range of the lights of an instant.
    pub fn at(&self, instant: usize) -> Range<usize> {
        let first = if instant == 0 { 0 } else { self.ends[instant - 1] };
        first..self.ends[instant]
    }

    /// Returns the origin and parameters of the set.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// Returns the origin of the positions, in the coordinates of the scene's file (m).
    pub fn origin(&self) -> DVec3 {
        self.provenance.origin.into()
    }

    /// Returns the lights with positions relative to another origin, given in the coordinates of
    /// the scene's file (m).
    #[must_use]
    pub fn relative_to(mut self, origin: DVec3) -> Self {
        let way = self.origin() - origin;
        if way != DVec3::ZERO {
            let placed = |light: &&mut Vpl| !matches!(light.kind, VplKind::Directional);
            for light in self.lights.iter_mut().filter(placed) {
                light.position = (light.position.as_dvec3() + way).as_vec3();
            }
            self.provenance.origin = origin.to_array();
        }
        self
    }

    /// Returns the set with its clamp distance multiplied by `times_as_far`.
    #[must_use]
    pub fn clamped(mut self, times_as_far: f32) -> Self {
        self.provenance.clamp_distance *= times_as_far;
        self
    }

    /// Checks that a scene contains the intensity maps that these lights use, since a set from a
    /// file may belong to another scene.
    ///
    /// # Errors
    /// Names the light whose map is not in the scene.
    pub fn validate_for(&self, scene: &Scene) -> Result<()> {
        let maps = scene.intensity_maps();
        let is_of_another = |light: &Vpl| match light.kind {
            VplKind::Image(beam) => {
                maps.get(beam.map as usize).is_none_or(|m| beam.cos_outer > m.map().cos_outer())
            }
            _ => false,
        };
        match self.lights.iter().position(is_of_another) {
            Some(number) => Err(Error::option(
                "lights",
                format!("VPL {number} by an image that this scene does not have"),
                "a set that was traced in this scene",
            )),
            None => Ok(()),
        }
    }

    /// Returns the number of lights.
    pub fn len(&self) -> usize {
        self.lights.len()
    }

    /// Returns true if there are no lights.
    pub fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }
}
