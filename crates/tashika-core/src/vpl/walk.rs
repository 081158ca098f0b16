//! Light paths from the emitters over surfaces and through media, which create a VPL wherever light
//! is diffusely reflected or scattered. For purpose and guarantee see [`trace`](super::trace).
//!
//! A medium may scatter a path on its way to each surface ([`Leg::fly`]). The path then creates a
//! VPL of the scattered light and continues by the phase function. It starts in the medium that
//! [`Outside`] finds; from there on, interfaces determine the medium. Surfaces that are only
//! boundaries of media do not affect the direction. Neither scattering in media nor passing a
//! boundary counts as a surface. Paths in media end by Russian roulette by the remaining flux, with
//! a survival probability capped near one.
//!
//! # Held to this by
//! `vpl::tests`, and the suite's `furnace`, `volume_lights` and `moving_lights`.

use std::f32::consts::PI;

use rayon::prelude::*;

use super::caustic::{Arrival, SpecularChain};
use super::guide::Emitted;
use super::reflect::{Scattered, goes_on, leave};
use super::{EmitterSampler, LightGuide, Origin, Route, Vpl, VplKind, Way};
use crate::accel::Tracer;
use crate::color::Rgb;
use crate::math::Ray;
use crate::media::{Leg, MAX_SURVIVAL_IN_MEDIUM, MOST_PASSED, Outside};
use crate::rng::{self, Purpose, Stream};
use crate::scene::Part;

/// Number of light paths that one parallel task traces.
const CHUNK: u64 = 1024;

/// Inputs common to all light paths of a set.
#[derive(Clone, Copy)]
pub(super) struct LightPaths<'a> {
    pub(super) tracer: &'a Tracer,
    pub(super) emitters: &'a EmitterSampler<'a>,
    pub(super) guide: &'a LightGuide,
    /// Maximum number of surfaces that a path interacts with.
    pub(super) max_depth: u32,
    pub(super) seed: u64,
    /// Time of the paths as a share of the shutter interval, 0 to 1.
    pub(super) share: f32,
    /// True if the numbers of each path are stored in the trail.
    pub(super) keeps_numbers: bool,
}

/// VPLs of one or more paths, and totals of flux.
#[derive(Default)]
pub(super) struct Trail {
    pub(super) lights: Vec<Vpl>,
    /// Way of the light of each VPL.
    ways: Vec<Way>,
    /// Number of VPLs of each path.
    pub(super) counts: Vec<u32>,
    /// Emitter of each path.
    origins: Vec<Origin>,
    /// Numbers from which the emission of each path was drawn.
    pub(super) numbers: Vec<[f32; 5]>,
    /// Arrivals over specular surfaces only, in the order of the VPLs created there.
    pub(super) caustics: Vec<Arrival>,
    /// Flux that the VPLs emit (W, luminance).
    pub(super) diffuse: f64,
    /// Flux that surfaces other than mirrors and glass reflect (W, luminance).
    pub(super) reflected: f64,
}

impl Trail {
    /// Adds a VPL of a path, with the way of its light.
    pub(super) fn push(&mut self, light: Vpl, way: Way) {
        self.lights.push(light);
        self.ways.push(way);
    }

    /// Returns the route of the light of each VPL.
    pub(super) fn routes(&self) -> Vec<Route> {
        let of_path = |(origin, count): (&Origin, &u32)| std::iter::repeat_n(*origin, *count as usize);
        let origins = self.origins.iter().zip(&self.counts).flat_map(of_path);
        origins.zip(&self.ways).map(|(origin, way)| Route { origin, way: *way }).collect()
    }

    /// Appends the next trail to this one.
    pub(super) fn followed_by(mut self, next: Self) -> Self {
        let before = self.lights.len() as u32;
        self.caustics.extend(next.caustics.into_iter().map(|arrival| arrival.after(before)));
        self.lights.extend(next.lights);
        self.ways.extend(next.ways);
        self.counts.extend(next.counts);
        self.origins.extend(next.origins);
        self.numbers.extend(next.numbers);
        self.diffuse += next.diffuse;
        self.reflected += next.reflected;
        self
    }
}

/// A path as it starts at an emitter.
struct Begun {
    leg: Leg,
    /// Flux of the path (W).
    flux: Rgb,
    chain: SpecularChain,
}

impl LightPaths<'_> {
    /// Follows `paths` paths, in parallel on the current thread pool.
    pub(super) fn follow(&self, purpose: Purpose, paths: u64) -> Trail {
        let outside = self.tracer.scene().has_media().then(|| Outside::new(self.tracer));
        let chunks: Vec<Trail> = (0..paths.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let mut trail = Trail::default();
                for i in chunk * CHUNK..((chunk + 1) * CHUNK).min(paths) {
                    let mut s = Stream::new(self.seed, purpose, i);
                    // Paths are stratified over the emitters.
                    let u = (i as f64 + s.uniform_f64()) / paths as f64;
                    if let Some(mut emitted) = self.guide.ray(self.emitters, self.share, u, &mut s) {
                        let key = rng::key(self.seed, purpose, i);
                        let before = trail.lights.len();
                        emitted.flux = emitted.flux / paths as f32;
                        if self.keeps_numbers {
                            trail.numbers.push(emitted.numbers);
                        }
                        trail.origins.push(emitted.origin);
                        self.walk(self.begun(emitted, outside, key, &mut s), key, &mut s, &mut trail);
                        trail.counts.push((trail.lights.len() - before) as u32);
                    }
                }
                trail
            })
            .collect();
        // The order is that of the paths, regardless of the threads that traced them.
        let lights = chunks.iter().map(|t| t.lights.len()).sum();
        let all = Trail { lights: Vec::with_capacity(lights), ..Trail::default() };
        chunks.into_iter().fold(all, Trail::followed_by)
    }

    /// Determines the first medium of a path. The medium outside attenuates light from infinity.
    fn begun(&self, emitted: Emitted, outside: Option<Outside>, key: u64, s: &mut Stream) -> Begun {
        let Emitted { ray, flux, origin, .. } = emitted;
        let chain = SpecularChain::from_emitter(&emitted);
        match outside {
            None => Begun { leg: Leg { ray, medium: None }, flux, chain },
            Some(outside) if origin == Origin::Infinity => Begun {
                leg: Leg { ray, medium: outside.medium() },
                flux: flux * outside.arriving(self.tracer, &ray, s),
                chain,
            },
            Some(outside) => {
                let medium = outside.medium_at(self.tracer, &ray, key, self.share);
                Begun { leg: Leg { ray, medium }, flux, chain }
            }
        }
    }

    /// Follows one path, and adds its VPLs to the trail.
    fn walk(&self, begun: Begun, key: u64, s: &mut Stream, trail: &mut Trail) {
        let Begun { mut leg, mut flux, chain } = begun;
        let scene = self.tracer.scene();
        // Ratio of basic radiance to flux along the path. Outside of all glass it returns to
        // exactly 1.
        let mut basic = 1.0_f64;
        let mut caustic = Some(chain);
        // Number of surfaces met; of vertices on surfaces and in media; and of boundaries passed
        // since the last vertex.
        let (mut depth, mut turned, mut passed) = (0, 0_u32, 0);
        while !flux.is_black() {
            // Each straight part of the path has one key, so that it sees consistent holes.
            let key = key.wrapping_add(u64::from(turned));
            let hit = self.tracer.closest_hit_at(&leg.ray, key, self.share);
            let (left, scattering) = leg.fly(scene, hit.as_ref(), flux, s);
            if let Some(at) = scattering {
                let light = Vpl {
                    position: at.place,
                    direction: at.before,
                    intensity: left / (4.0 * PI) * basic as f32,
                    kind: VplKind::Volume(at.phase),
                };
                trail.push(light, way(caustic.as_ref()));
                let survival = (left.max_channel() / flux.max_channel()).min(MAX_SURVIVAL_IN_MEDIUM);
                if s.uniform() >= survival {
                    return;
                }
                flux = left / survival;
                leg.ray = Ray::new(at.place, at.phase.sample(at.before, s.uniform_2()).0);
                caustic = None;
                turned = turned.saturating_add(1);
                passed = 0;
                continue;
            }
            flux = left;
            let Some(hit) = hit else { return };
            let point = scene.surface_point_at(self.share, hit.instance, hit.triangle, hit.barycentric);
            if scene.is_boundary(&point) {
                leg = leg.beyond(scene, &point);
                passed += 1;
                if passed > MOST_PASSED {
                    return;
                }
                continue;
            }
            if depth == self.max_depth {
                return;
            }
            let incoming = -leg.ray.direction;
            let Part { bsdf, weight, through } = scene.part(&point, incoming, s.uniform());
            flux *= weight;
            let arrival = caustic.as_ref().and_then(|chain| chain.arrival(&leg.ray, point.position));
            let arrived = (way(caustic.as_ref()), arrival);
            leave(&point, &bsdf, through, incoming, flux * basic as f32, arrived, trail);
            let Some(next) = goes_on(&point, &bsdf, through, incoming, s) else { return };
            let Scattered { direction, factor, specular, .. } = next;
            basic *= next.basic;
            let next = flux * factor;
            if specular.is_none() {
                trail.reflected += f64::from(next.luminance()) * basic;
            }
            caustic =
                caustic.zip(specular).map(|(chain, lobe)| chain.beyond(&leg.ray, &hit, &point, &bsdf, lobe));
            let survival = (next.max_channel() / flux.max_channel()).min(1.0);
            if s.uniform() >= survival {
                return;
            }
            flux = next / survival;
            leg = leg.onward(scene, &point, Ray::new(point.leave(direction), direction));
            depth += 1;
            turned = turned.saturating_add(1);
            passed = 0;
        }
    }
}

/// Returns the way of light after a chain of specular surfaces. `None` means that the light was
/// scattered.
fn way(chain: Option<&SpecularChain>) -> Way {
    match chain {
        None => Way::Scattered,
        Some(chain) if chain.is_deflected() => Way::Specular,
        Some(_) => Way::Straight,
    }
}
