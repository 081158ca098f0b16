//! Virtual point lights: the finite set of lights that stands for all light in the scene.
//!
//! A [`VplSet`] is traced from the emitters (Keller 1997) or loaded from a file; all methods share
//! it. It knows where it came from ([`Provenance`]).

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
pub use emitters::{EmitterSampler, LightSample};
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

/// Where a set of VPLs came from, and what belongs to it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Name of the scene.
    pub scene: String,
    /// Seed of the light paths.
    pub seed: u64,
    /// Number of VPLs that was asked for.
    pub requested: u64,
    /// VPLs on or towards emitters.
    pub direct: u64,
    /// VPLs left by light paths, on surfaces and in media.
    pub indirect: u64,
    /// Light paths traced.
    pub paths: u64,
    /// Longest light path, in surfaces met.
    pub max_depth: u32,
    /// Distance below which the geometric term no longer grows (m); zero for no clamp.
    pub clamp_distance: f32,
    /// Share of the flux reflected by surfaces that glossy lobes reflected: VPLs shine with cosine
    /// lobes only, so they carry this flux on to further surfaces, but not towards the eye's.
    pub glossy_share: f32,
    /// Origin of the positions, in the coordinates of the scene's file (m): see
    /// [`Scene::origin`].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub origin: [f64; 3],
}

fn is_zero(place: &[f64; 3]) -> bool {
    *place == [0.0; 3]
}

/// A finite set of lights: at one time, or at each of several [`Instants`] a set of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct VplSet {
    lights: Vec<Vpl>,
    instants: Instants,
    /// Where the lights of each instant end.
    ends: Vec<usize>,
    provenance: Provenance,
}

impl VplSet {
    /// A set made elsewhere, of a scene that stands.
    pub fn new(lights: Vec<Vpl>, provenance: Provenance) -> Self {
        Self { ends: vec![lights.len()], lights, instants: Instants::default(), provenance }
    }

    /// A set made elsewhere, of lights that stand instant by instant, so many at each; `None` if these are
    /// not as many numbers as instants, or more or fewer lights in all than there are.
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

    /// The lights, instant by instant. Neighbours of an instant are near each other in space.
    pub fn lights(&self) -> &[Vpl] {
        &self.lights
    }

    /// The times at which they are.
    pub fn instants(&self) -> &Instants {
        &self.instants
    }

    /// The places of the lights of an instant.
    pub fn at(&self, instant: usize) -> Range<usize> {
        let first = if instant == 0 { 0 } else { self.ends[instant - 1] };
        first..self.ends[instant]
    }

    /// Where they came from.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// Origin of the positions, in the coordinates of the scene's file (m).
    pub fn origin(&self) -> DVec3 {
        self.provenance.origin.into()
    }

    /// Returns the lights with positions relative to another point of the file (m).
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

    /// The same lights, clamped so many times as far away as their provenance says.
    #[must_use]
    pub fn clamped(mut self, times_as_far: f32) -> Self {
        self.provenance.clamp_distance *= times_as_far;
        self
    }

    /// Whether a scene has the maps that these lights shine by: sets from files may be of another.
    ///
    /// # Errors
    /// Names the light that is not of this scene.
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

    /// How many lights there are.
    pub fn len(&self) -> usize {
        self.lights.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }
}
