//! Guides of emission: densities that place light paths and direct VPLs where they matter to a
//! picture.
//!
//! Emission is drawn from uniform numbers. Three numbers select the emitter and the position on it,
//! as used by [`EmitterSampler::sample`]. For a light path, two more select the direction, or for
//! light from infinity the point of the disk through which it enters, as used by [`Vpl::emit`]. A
//! guide is a density over these numbers. VPLs are drawn with this density and divided by it, so
//! their expectation does not change. A set is therefore unbiased for any guide that does not
//! depend on the set's random numbers. Held to this by `vpl::tests`.

use super::{EmitterSampler, LightSample, Origin, Vpl};
use crate::color::Rgb;
use crate::math::Ray;
use crate::rng::Stream;
use crate::stats::{AdaptiveDensity, Weighted};

/// Light that leaves an emitter along a ray.
pub(super) struct Emitted {
    pub(super) ray: Ray,
    /// Flux that the ray represents (W).
    pub(super) flux: Rgb,
    /// Kind of emitter. A ray from infinity begins at the sphere around the scene.
    pub(super) origin: Origin,
    /// Numbers from which the ray was drawn.
    pub(super) numbers: [f32; 5],
}

/// Densities over the numbers from which emission is drawn; uniform if nothing was learned.
#[derive(Clone, Debug, Default)]
pub struct LightGuide {
    direct: Option<AdaptiveDensity<3>>,
    emission: Option<AdaptiveDensity<5>>,
}

impl LightGuide {
    /// Learns both densities from contributions to a picture: those of positions on emitters and
    /// those of emitted rays, as functions of the numbers from which these are drawn.
    pub fn learn(direct: Vec<Weighted<3>>, emission: Vec<Weighted<5>>) -> Self {
        Self {
            direct: Some(AdaptiveDensity::learn(direct)),
            emission: Some(AdaptiveDensity::learn(emission)),
        }
    }

    /// Learns only the density of emitted rays; positions of direct VPLs are drawn uniformly.
    pub fn learn_emission(emission: Vec<Weighted<5>>) -> Self {
        Self { direct: None, emission: Some(AdaptiveDensity::learn(emission)) }
    }

    /// Returns the number of cells of the density of positions, and of the density of rays.
    pub fn cells(&self) -> [usize; 2] {
        [
            self.direct.as_ref().map_or(1, AdaptiveDensity::cells),
            self.emission.as_ref().map_or(1, AdaptiveDensity::cells),
        ]
    }

    /// Draws a direct VPL on the emitters that have an extent, or towards them. `share` is the time
    /// as a share of the shutter interval; `u` in `[0, 1)` is a stratified number.
    pub(super) fn place(
        &self,
        emitters: &EmitterSampler<'_>,
        share: f32,
        u: f64,
        s: &mut Stream,
    ) -> Option<Vpl> {
        let ([u, a, b], density) = match &self.direct {
            Some(direct) => direct.sample(u, s.uniform_3()),
            None => ([u, s.uniform().into(), s.uniform().into()], 1.0),
        };
        let mut light = emitters.sample_extended_at(share, u, [a as f32, b as f32])?.light;
        light.intensity = light.intensity / density as f32;
        Some(light)
    }

    /// Draws an emitted ray and the flux that it represents. `share` is the time as a share of the
    /// shutter interval; `u` in `[0, 1)` is a stratified number.
    pub(super) fn ray(
        &self,
        emitters: &EmitterSampler<'_>,
        share: f32,
        u: f64,
        s: &mut Stream,
    ) -> Option<Emitted> {
        let (numbers, density) = match &self.emission {
            Some(emission) => {
                let [a, b, c] = s.uniform_3();
                let [d, e] = s.uniform_2();
                emission.sample(u, [a, b, c, d, e])
            }
            None => {
                let ([a, b], [c, d]) = (s.uniform_2(), s.uniform_2());
                ([u, a.into(), b.into(), c.into(), d.into()], 1.0)
            }
        };
        let [u, rest @ ..] = numbers;
        let [a, b, c, d] = rest.map(|x| x as f32);
        let (_, LightSample { light, .. }) = emitters.sample_at(share, u, [a, b])?;
        let (center, radius) = emitters.sphere();
        let (ray, flux) = light.emit([c, d], center, radius, emitters.maps());
        let numbers = numbers.map(|x| x as f32);
        Some(Emitted { ray, flux: flux / density as f32, origin: Origin::of(light.kind), numbers })
    }
}
