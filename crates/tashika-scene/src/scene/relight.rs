//! Changes of a scene's light that the user requests: lights in addition to those of the file, or
//! in their place.

use std::sync::Arc;

use glam::{DVec3, Mat3, Vec3};

use super::{Emitter, Environment, IntensityMap, NoteKind, Scene, SceneBuilder};
use crate::color::Rgb;
use crate::error::{Location, Result};

/// A light to add.
#[derive(Clone, Debug)]
pub enum Lamp {
    /// An emitter that refers to no other data, such as an intensity map. Its position is rounded
    /// to single precision.
    Emitter(Emitter),
    /// An [`Emitter::Point`] with a position in double precision.
    Point {
        /// Position (m, of the file).
        position: DVec3,
        /// Intensity in every direction (W·sr⁻¹).
        intensity: Rgb,
    },
    /// An emitter with an intensity map: [`SceneBuilder::add_image_light`].
    Image {
        /// Relative intensity by direction.
        map: Arc<IntensityMap>,
        /// Position (m, of the file).
        position: DVec3,
        /// Intensity where the map has the value 1 (W·sr⁻¹).
        intensity: Rgb,
        /// Rotation (or reflection) from the map to the world.
        to_world: Mat3,
    },
}

/// Default light of a scene without light: radiance of the sky (W·m⁻²·sr⁻¹), and irradiance by the
/// sun (W·m⁻²).
const DEFAULT_LIGHT: [f32; 2] = [0.5, 3.0];

impl Scene {
    /// Returns the scene with `lamps` in addition to its lights. If an environment is given, it
    /// replaces that of the scene.
    ///
    /// * `words`: the request, for [`Self::changes`]; `digest`: a hash of the request, which is
    ///   combined with [`Self::digest`].
    ///
    /// # Errors
    /// As [`SceneBuilder::add_emitter`], [`SceneBuilder::add_image_light`] and
    /// [`SceneBuilder::set_environment`].
    pub fn relit(
        mut self,
        environment: Option<Environment>,
        lamps: Vec<Lamp>,
        words: Vec<String>,
        digest: u64,
    ) -> Result<Self> {
        if environment.is_none() && lamps.is_empty() {
            return Ok(self);
        }
        self.digest = Some(self.digest.unwrap_or(0).rotate_left(1).wrapping_add(digest));
        self.changes.extend(words);
        let origin = self.origin;
        let mut builder = SceneBuilder::of(self, Location::file("light that was asked for"));
        if let Some(environment) = environment {
            builder.set_environment(environment)?;
        }
        for (number, lamp) in (1..).zip(lamps) {
            builder.begin_light(format!("added {number}"));
            match lamp {
                Lamp::Emitter(emitter) => {
                    let place = emitter.position().unwrap_or(Vec3::ZERO).as_dvec3();
                    builder.add_emitter_at(emitter, place - origin)?;
                }
                Lamp::Point { position, intensity } => {
                    builder.add_emitter_at(
                        Emitter::Point { position: Vec3::ZERO, intensity },
                        position - origin,
                    )?;
                }
                Lamp::Image { map, position, intensity, to_world } => {
                    builder.add_image_light(&map, position - origin, intensity, to_world)?;
                }
            }
        }
        Ok(builder.into_scene())
    }

    /// Light changes that the user requested, in the user's words.
    pub fn changes(&self) -> &[String] {
        &self.changes
    }

    /// Returns true if anything emits light.
    pub fn has_light(&self) -> bool {
        !self.emitters.is_empty()
            || self.environment.is_some()
            || self.area_emitters().any(|(_, e)| !e.radiance.factor.is_black())
    }

    /// Returns the scene unchanged if it has light, if lights of its file are off at the time of
    /// the scene, or if the user requested light changes. Otherwise adds a white sky and a sun,
    /// with a note at `at`. Programs call this so that the image is not black.
    #[must_use]
    pub fn with_default_light(mut self, at: Location) -> Self {
        let is_off = self.is_dark_now && self.animated.is_some();
        if self.has_light() || is_off || !self.changes.is_empty() {
            return self;
        }
        let [radiance, irradiance] = DEFAULT_LIGHT;
        let what = format!(
            "no light: a white sky of radiance {radiance} and a sun of irradiance {irradiance} are used"
        );
        self.notes.push(NoteKind::Defaulted, what, at);
        self.has_default_light = true;
        self.environment = Some(Environment::constant(Rgb::gray(radiance)));
        let direction = Vec3::new(0.5, -1.0, -0.7).normalize();
        self.emitters.push(Emitter::Directional { direction, irradiance: Rgb::gray(irradiance) });
        self
    }

    /// Returns true if its light was added by [`Self::with_default_light`].
    pub fn has_default_light(&self) -> bool {
        self.has_default_light
    }
}
