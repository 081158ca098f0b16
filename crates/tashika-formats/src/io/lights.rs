//! Lights as formats describe them: those that shine by an image, and what is seen where no surface
//! is.
//!
//! Held to this by the suite's `light_images` and by the formats' tests.

use std::sync::Arc;

use glam::{DVec3, Mat3};

use crate::color::Rgb;
use crate::error::{Location, Result};
use crate::scene::{Environment, IntensityMap, NoteKind, SceneBuilder};

/// Bytes that a map of a light holds for each texel: colours, and their density with its guide.
pub(super) const BYTES_OF_TEXEL: u64 = 12 + 8 + 2;

/// What a note says of a light with a place or a colour that is no number.
pub(super) const NOT_FINITE: &str = "lights that are not finite: left out";

/// Adds a light of that intensity where the map has 1; left out, with a note, if it is not finite.
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

/// What is seen where no surface is: constants add up, and there is one map.
#[derive(Debug, Default)]
pub(super) struct Surroundings {
    pub(super) constant: Rgb,
    pub(super) map: Option<Environment>,
}

impl Surroundings {
    /// Whether there is a map beside which the constant is not seen.
    pub(super) fn hides_constant(&self) -> bool {
        self.map.is_some() && !self.constant.is_black()
    }

    /// Hands it to the scene.
    pub(super) fn finish(self, builder: &mut SceneBuilder) -> Result<()> {
        builder.set_environment(self.map.unwrap_or_else(|| Environment::constant(self.constant)))
    }
}
