//! Light of an image by estimator, and by its route to the surfaces in view.

use std::fmt;

use serde::Serialize;

use super::{RenderFilm, keys, planes};
use crate::film::{Film, Key};

/// Light of the rendered pixels by estimator, as shares of 1. In addition, shares by route, which
/// light paths estimate on their own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FoundLight {
    /// Share of emission that the camera sees, straight or over specular surfaces, 0 to 1.
    pub emission: f64,
    /// Share of the sums over VPLs, 0 to 1.
    pub vpls: f64,
    /// Share of the means of paths, 0 to 1.
    pub paths: f64,
    /// Approximate share that estimates lack, 0 to 1.
    pub missing: f64,
    /// Shares by route, from light paths; `None` if the camera has a lens or moves.
    pub by_light_paths: Option<Routes>,
}

/// Light that surfaces in view send to the camera, estimated by light paths alone. All fields are
/// shares of 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Routes {
    /// Share that reaches the surfaces in view straight from emitters.
    pub straight: f64,
    /// Share that reaches them over mirrors or through glass only.
    pub specular: f64,
    /// Share that surfaces or media scattered before it reached the surfaces in view.
    pub scattered: f64,
    /// Share that surfaces emit.
    pub of_surfaces: f64,
    /// Share that point lights emit.
    pub of_points: f64,
    /// Share that environments and directional lights emit.
    pub of_infinity: f64,
}

impl FoundLight {
    /// Reads the planes and the metadata of a film; `None` if its method has only one estimator, or
    /// if no pixel has a known luminance above zero.
    pub fn of(film: &Film) -> Option<Self> {
        let plane = film.plane(planes::LUMINANCE_PARTS)?.f32_samples()?;
        let read = RenderFilm::of(film);
        let mut sums = [0.0; 4];
        let rendered = plane.chunks_exact(4).enumerate().filter(|(pixel, _)| read.is_rendered(*pixel));
        for (_, parts) in rendered.filter(|(_, parts)| parts.iter().all(|part| part.is_finite())) {
            sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += f64::from(*part));
        }
        let whole: f64 = sums.iter().sum();
        let [emission, vpls, paths, missing] = sums.map(|sum| sum / whole);
        (whole > 0.0).then(|| Self { emission, vpls, paths, missing, by_light_paths: Routes::of(film) })
    }
}

impl Routes {
    fn of(film: &Film) -> Option<Self> {
        let share = |key: Key| film.metadata().number(key);
        Some(Self {
            straight: share(keys::LIGHT_STRAIGHT)?,
            specular: share(keys::LIGHT_SPECULAR)?,
            scattered: share(keys::LIGHT_SCATTERED)?,
            of_surfaces: share(keys::LIGHT_OF_SURFACES)?,
            of_points: share(keys::LIGHT_OF_POINTS)?,
            of_infinity: share(keys::LIGHT_OF_INFINITY)?,
        })
    }
}

/// Formats the shares in per cent; those below 0.05 % are omitted.
fn shares(parts: &[(&str, f64)]) -> String {
    let there = parts.iter().filter(|(_, share)| *share >= 5e-4);
    there.map(|(name, share)| format!("{name} {:.1} %", 100.0 * share)).collect::<Vec<_>>().join(", ")
}

impl fmt::Display for FoundLight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { emission, vpls, paths, missing, .. } = *self;
        let parts = [
            ("sums over VPLs", vpls),
            ("paths", paths),
            ("emission in view", emission),
            ("missing", missing),
        ];
        f.write_str(&shares(&parts))
    }
}

impl fmt::Display for Routes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ways = [
            ("straight", self.straight),
            ("over mirrors or through glass", self.specular),
            ("scattered", self.scattered),
        ];
        let origins = [
            ("surfaces", self.of_surfaces),
            ("points", self.of_points),
            ("sky and directional lights", self.of_infinity),
        ];
        write!(f, "by light paths alone: {}; from {}", shares(&ways), shares(&origins))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{LuminanceParts, PixelRecord, Stop, Window};

    /// Pixels that are not rendered or not finite have no share.
    #[test]
    fn shares_are_those_of_the_rendered_pixels() {
        let size = [4, 1];
        let mut film = Film::new(size, Window::full(size), PixelRecord::PLANES).unwrap();
        assert_eq!(FoundLight::of(&film), None);
        let record = |[emission, vpls, paths, missing]: [f32; 4]| PixelRecord {
            luminance_parts: LuminanceParts { emission, vpls, paths, missing },
            stop: Stop::RuleMet,
            ..PixelRecord::default()
        };
        record([0.0, 3.0, 1.0, 0.0]).store(&mut film, 0, 0);
        record([1.0, 2.0, 1.0, 2.0]).store(&mut film, 1, 0);
        record([1.0, f32::NAN, 1.0, 1.0]).store(&mut film, 2, 0);
        PixelRecord { stop: Stop::NotRendered, ..record([9.0; 4]) }.store(&mut film, 3, 0);
        let found = FoundLight::of(&film).unwrap();
        let FoundLight { emission, vpls, paths, missing, by_light_paths } = found;
        assert_eq!(([emission, vpls, paths, missing], by_light_paths), ([0.1, 0.5, 0.2, 0.2], None));
        let expected = "sums over VPLs 50.0 %, paths 20.0 %, emission in view 10.0 %, missing 20.0 %";
        assert_eq!(found.to_string(), expected);
    }
}
