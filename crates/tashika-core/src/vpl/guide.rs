//! Where emission matters to a picture: densities by which light paths and direct VPLs are drawn.
//!
//! What is emitted is drawn by uniform numbers: which emitter and where on it (three numbers, as
//! [`EmitterSampler::sample`] takes them), and for a light path in which direction, or through which
//! point of the disk that light from infinity enters by (two more, as [`Vpl::emit`] takes them). A
//! guide is a density over these numbers. Drawn by it and divided by it, every VPL is worth as
//! much in expectation as without it: a set is unbiased for any guide that does not depend on the
//! set's own random numbers. Held to this by `vpl::tests`.

use super::{EmitterSampler, LightSample, Origin, Vpl};
use crate::color::Rgb;
use crate::math::Ray;
use crate::rng::Stream;
use crate::stats::{AdaptiveDensity, Weighted};

/// Light that leaves an emitter along a ray.
pub(super) struct Emitted {
    pub(super) ray: Ray,
    /// What it stands for (W).
    pub(super) flux: Rgb,
    /// Kind of emitter. A ray from infinity begins at the sphere around the scene.
    pub(super) origin: Origin,
    /// The numbers that it was drawn by.
    pub(super) numbers: [f32; 5],
}

/// Densities over the numbers that emission is drawn by; none: uniform.
#[derive(Clone, Debug, Default)]
pub struct LightGuide {
    direct: Option<AdaptiveDensity<3>>,
    emission: Option<AdaptiveDensity<5>>,
}

impl LightGuide {
    /// Learned from what places and rays of emission give to a picture, as functions of the numbers
    /// that they are drawn by.
    pub fn learn(direct: Vec<Weighted<3>>, emission: Vec<Weighted<5>>) -> Self {
        Self {
            direct: Some(AdaptiveDensity::learn(direct)),
            emission: Some(AdaptiveDensity::learn(emission)),
        }
    }

    /// Learned from rays of emission alone; places of emission are drawn uniformly.
    pub fn learn_emission(emission: Vec<Weighted<5>>) -> Self {
        Self { direct: None, emission: Some(AdaptiveDensity::learn(emission)) }
    }

    /// Cells of the densities of places and of rays.
    pub fn cells(&self) -> [usize; 2] {
        [
            self.direct.as_ref().map_or(1, AdaptiveDensity::cells),
            self.emission.as_ref().map_or(1, AdaptiveDensity::cells),
        ]
    }

    /// A light on or towards the emitters that have an extent, after a `share` of the time that the
    /// shutter is open; `u` in `[0, 1)` is the stratum's.
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

    /// A ray of emission and the flux that it stands for, after a `share` of the time that the shutter is
    /// open; `u` in `[0, 1)` is the stratum's.
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
