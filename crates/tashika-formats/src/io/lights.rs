//! Emission shared by several formats: lights that shine by an image, and the environment.
//!
//! Held to this by the suite's `light_images` and by the formats' tests.

use std::sync::Arc;

use glam::{DVec3, Mat3};

use crate::color::Rgb;
use crate::error::{Location, Result};
use crate::scene::{Environment, IntensityMap, NoteKind, SceneBuilder};

/// Memory of one texel of a light's map (bytes): colours, and their density with its guide.
pub(super) const BYTES_OF_TEXEL: u64 = 12 + 8 + 2;

/// Note about a light with a place or a colour that is not finite.
pub(super) const NOT_FINITE: &str = "lights that are not finite: left out";

/// Adds a light whose intensity is `intensity` where the map has 1. A light that is not finite is
/// ignored, with a note.
pub(super) fn add_image_light(
    builder: &mut SceneBuilder,
    map: &Arc<IntensityMap>,
    (place, to_world): (DVec3, Mat3),
    intensity: Rgb,
    at: Location,
) -> Result<()> {
    if place.as_vec3().is_finite() && (intensity * map.brightest()).is_finite() {
        return builder.add_image_light(map, place, intensity, to_world);
    }
    builder.note(NoteKind::Repaired, NOT_FINITE, at);
    Ok(())
}

/// Environment of a file: constants add up, and there is one map at most.
#[derive(Debug, Default)]
pub(super) struct Surroundings {
    pub(super) constant: Rgb,
    pub(super) map: Option<Environment>,
}

impl Surroundings {
    /// Returns true if a map replaces a constant that is not black.
    pub(super) fn hides_constant(&self) -> bool {
        self.map.is_some() && !self.constant.is_black()
    }

    /// Sets the environment of the scene: the map, or else the constant.
    pub(super) fn finish(self, builder: &mut SceneBuilder) -> Result<()> {
        builder.set_environment(self.map.unwrap_or_else(|| Environment::constant(self.constant)))
    }
}
