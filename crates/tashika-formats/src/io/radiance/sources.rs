//! Light from infinitely far away: `source`s of light materials.
//!
//! A source of the full angle `θ` fills the solid angle `2π (1 − cos θ/2)` around its direction.
//! Up to [`PARALLEL`] it is parallel light of the irradiance `L π sin² θ/2`, with shadows that are
//! sharp. Larger ones are painted into an image of the whole sphere and add up; the solid angle of
//! each is exact there. The pole of the image is at `+z`: a sky of 180° ends at a row of texels.
//!
//! Source: the Radiance reference manual, "Source". Held to this by the tests in `tests`.

use std::f64::consts::PI;

use glam::{DVec3, Mat3, Vec3};

use super::skies::SkyPattern;
use super::surfaces::check_count;
use super::transforms::Similarity;
use super::words::Primitive;
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::math::elementary::sin_cos_f64;
use crate::scene::{Emitter, Environment, Image, NoteKind, Pixels, SceneBuilder, SphereMap};

/// Largest full angle of parallel light (degrees); chosen. The sun has 0.53.
const PARALLEL: f64 = 2.0;

/// Columns and rows of the image.
const SIZE: [u32; 2] = [1024, 512];

/// Parts of a texel's sides at the rim of a source.
const PARTS: u32 = 4;

/// Angle of the rim in which texels are divided (rad): the diagonal of a texel and more.
const RIM: f64 = 0.01;

/// Most sources in the image.
const MAX_PAINTED: usize = 4096;

/// Light from all directions of a cone.
#[derive(Clone, Debug, PartialEq)]
struct Cone {
    axis: DVec3,
    cos_half: f64,
    radiance: Rgb,
    pattern: Option<SkyPattern>,
}

/// All sources of a scene that become its environment.
#[derive(Debug, Default)]
pub(super) struct Sources {
    cones: Vec<Cone>,
}

impl Sources {
    /// Adds a source of the radiance `radiance`.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a wrong number of arguments and for too many sources.
    pub(super) fn add(
        &mut self,
        (primitive, map, name): (&Primitive, &Similarity, &str),
        (radiance, pattern): (Rgb, Option<SkyPattern>),
        at: &Location,
        builder: &mut SceneBuilder,
    ) -> Result<()> {
        check_count(primitive, 4, at)?;
        let direction = map.direction(DVec3::from_slice(&primitive.reals)).try_normalize();
        let degrees = primitive.reals[3].min(360.0);
        let Some(axis) = direction.filter(|_| degrees > 0.0) else {
            let message = "sources without direction, or of an angle of 0: left out";
            builder.note(NoteKind::Repaired, message, at.clone());
            return Ok(());
        };
        let half = 0.5 * degrees.to_radians();
        if degrees <= PARALLEL {
            let sin = sin_cos_f64(half).0;
            let factor = pattern.map_or(1.0, |pattern| pattern.at(axis));
            let irradiance = radiance * ((PI * sin * sin * factor) as f32);
            builder.begin_light(name);
            let direction = (-axis).as_vec3().normalize();
            return builder.add_emitter(Emitter::Directional { direction, irradiance });
        }
        if self.cones.len() >= MAX_PAINTED {
            let expected = format!("at most {MAX_PAINTED} that are wider than {PARALLEL}°");
            return Err(Error::invalid(at.clone(), "one more source", expected));
        }
        let cos_half = if degrees == 360.0 { -2.0 } else { sin_cos_f64(half).1 };
        self.cones.push(Cone { axis, cos_half, radiance, pattern });
        Ok(())
    }

    /// Sets the environment of the scene, if there is one.
    pub(super) fn finish(self, builder: &mut SceneBuilder) -> Result<()> {
        if self.cones.is_empty() {
            return Ok(());
        }
        if self.cones.iter().all(|cone| cone.cos_half < -1.0 && cone.pattern.is_none()) {
            let sum = self.cones.iter().fold(Rgb::BLACK, |sum, cone| sum + cone.radiance);
            return builder.set_environment(Environment::constant(sum));
        }
        let [width, height] = SIZE;
        let mut texels = vec![Rgb::BLACK; (width * height) as usize];
        let center = |i: u32| {
            let place = [f64::from(i % width) + 0.5, f64::from(i / width) + 0.5];
            direction(place)
        };
        let centers: Vec<DVec3> = (0..width * height).map(center).collect();
        for cone in &self.cones {
            cone.paint(&centers, &mut texels);
        }
        let pixels = Pixels::Float(texels.into_iter().map(Rgb::to_array).collect());
        let image = Image { name: "sources".to_owned(), width, height, pixels };
        builder.set_environment(Environment::lat_long(image, Rgb::WHITE, upright()))
    }
}

/// Rotation from the frame of the image, with its pole at `+y`, to the world.
fn upright() -> Mat3 {
    Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y)
}

/// Direction in the world of a place of the image, in texels.
fn direction([x, y]: [f64; 2]) -> DVec3 {
    let [width, height] = SIZE.map(f64::from);
    let place = [(x / width) as f32, (y / height) as f32];
    (upright() * SphereMap::LatLong.direction(place)).as_dvec3()
}

impl Cone {
    /// Adds the radiance of the cone to an image whose texels have these directions.
    fn paint(&self, centers: &[DVec3], texels: &mut [Rgb]) {
        let [width, height] = SIZE.map(f64::from);
        let (mut covered, mut painted) = (Vec::new(), 0.0);
        for row in 0..SIZE[1] {
            let polar = |v: f64| sin_cos_f64(v / height * PI).1;
            let size = (polar(f64::from(row)) - polar(f64::from(row) + 1.0)) * 2.0 * PI / width;
            for column in 0..SIZE[0] {
                let texel = (row * SIZE[0] + column) as usize;
                let share = self.share(centers[texel], [column, row]);
                if share > 0.0 {
                    covered.push((texel, share));
                    painted += share * size;
                }
            }
        }
        // Shares of texels at the rim are estimates, so that their sum is corrected.
        let exact = 2.0 * PI * (1.0 - self.cos_half.max(-1.0));
        let correction = if painted > 0.0 { exact / painted } else { 0.0 };
        for (texel, share) in covered {
            let factor = self.pattern.as_ref().map_or(1.0, |pattern| pattern.at(centers[texel]));
            texels[texel] += self.radiance * ((share * correction * factor) as f32);
        }
    }

    /// Share of a texel that the cone covers.
    fn share(&self, center: DVec3, texel: [u32; 2]) -> f64 {
        let cos = center.dot(self.axis);
        if (cos - self.cos_half).abs() > RIM {
            return f64::from(u8::from(cos > self.cos_half));
        }
        let step = |texel: u32, part: u32| f64::from(texel) + (f64::from(part) + 0.5) / f64::from(PARTS);
        let parts = (0..PARTS * PARTS).filter(|i| {
            let place = [step(texel[0], i % PARTS), step(texel[1], i / PARTS)];
            direction(place).dot(self.axis) > self.cos_half
        });
        parts.count() as f64 / f64::from(PARTS * PARTS)
    }
}
