//! Light paths: from the emitters over the surfaces and through media, leaving a VPL wherever light is
//! reflected diffusely or scattered. What they are for and what they guarantee is in
//! [`trace`](super::trace).
//!
//! A path draws on its way to each surface whether it is scattered before ([`Leg::fly`]). Where it is, it
//! leaves a VPL of what is scattered and goes on by the phase function. It begins in the medium that
//! [`Outside`] tells; interfaces tell which one it is in from there on, and boundaries that are nothing
//! else are passed. Being scattered, and passing such a boundary, do not count as surfaces: Russian
//! roulette by the flux that is left ends paths in media, with a cap near one.
//!
//! # Held to this by
//! `vpl::tests`, and the suite's `furnace`, `volume_lights` and `moving_lights`.

use std::f32::consts::PI;

use rayon::prelude::*;

use super::guide::Emitted;
use super::reflect::{Scattered, goes_on, leave};
use super::{EmitterSampler, LightGuide, Vpl, VplKind};
use crate::accel::Tracer;
use crate::bsdf::{Bsdf, Lobe};
use crate::color::Rgb;
use crate::math::Ray;
use crate::media::{Leg, MAX_SURVIVAL_IN_MEDIUM, MOST_PASSED, Outside};
use crate::rng::{self, Purpose, Stream};
use crate::scene::Part;

/// Light paths traced as one piece of parallel work.
const CHUNK: u64 = 1024;

/// What light paths are followed with.
#[derive(Clone, Copy)]
pub(super) struct LightPaths<'a> {
    pub(super) tracer: &'a Tracer,
    pub(super) emitters: &'a EmitterSampler<'a>,
    pub(super) guide: &'a LightGuide,
    /// Surfaces that a path meets at most.
    pub(super) max_depth: u32,
    pub(super) seed: u64,
    /// When they are: a share of the time that the shutter is open, 0 to 1.
    pub(super) share: f32,
}

/// VPLs of one or more paths, and what became of the flux.
#[derive(Default)]
pub(super) struct Trail {
    pub(super) lights: Vec<Vpl>,
    /// How many of these each path left.
    pub(super) counts: Vec<u32>,
    /// Numbers of those that are the first of their path, which came from the emitter by a bent
    /// way.
    pub(super) bent: Vec<u32>,
    /// Flux that VPLs send out (W, luminance).
    pub(super) diffuse: f64,
    /// Flux that surfaces reflect, but for mirrors and glass.
    pub(super) reflected: f64,
}

impl Trail {
    /// With what others left after it.
    fn followed_by(mut self, next: Self) -> Self {
        let before = self.lights.len() as u32;
        self.bent.extend(next.bent.iter().map(|number| number + before));
        self.lights.extend(next.lights);
        self.counts.extend(next.counts);
        self.diffuse += next.diffuse;
        self.reflected += next.reflected;
        self
    }
}

/// A path that leaves an emitter.
struct Begun {
    leg: Leg,
    /// W.
    flux: Rgb,
}

impl LightPaths<'_> {
    /// Follows so many paths, in parallel on the current thread pool.
    pub(super) fn follow(&self, purpose: Purpose, paths: u64) -> Trail {
        let outside = self.tracer.scene().has_media().then(|| Outside::new(self.tracer));
        let chunks: Vec<Trail> = (0..paths.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let mut trail = Trail::default();
                for i in chunk * CHUNK..((chunk + 1) * CHUNK).min(paths) {
                    let mut s = Stream::new(self.seed, purpose, i);
                    // Stratified over the emitters.
                    let u = (i as f64 + s.uniform_f64()) / paths as f64;
                    if let Some(mut emitted) = self.guide.ray(self.emitters, self.share, u, &mut s) {
                        let key = rng::key(self.seed, purpose, i);
                        let before = trail.lights.len();
                        emitted.flux = emitted.flux / paths as f32;
                        self.walk(self.begun(emitted, outside, key, &mut s), key, &mut s, &mut trail);
                        trail.counts.push((trail.lights.len() - before) as u32);
                    }
                }
                trail
            })
            .collect();
        // In the order of the paths, whichever thread traced them.
        let lights = chunks.iter().map(|t| t.lights.len()).sum();
        let all = Trail { lights: Vec::with_capacity(lights), ..Trail::default() };
        chunks.into_iter().fold(all, Trail::followed_by)
    }

    /// A path in its first medium, with what media leave of light that comes from infinity.
    fn begun(&self, emitted: Emitted, outside: Option<Outside>, key: u64, s: &mut Stream) -> Begun {
        let Emitted { ray, flux, from_infinity } = emitted;
        match outside {
            None => Begun { leg: Leg { ray, medium: None }, flux },
            Some(outside) if from_infinity => Begun {
                leg: Leg { ray, medium: outside.medium() },
                flux: flux * outside.arriving(self.tracer, &ray, s),
            },
            Some(outside) => {
                let medium = outside.medium_at(self.tracer, &ray, key, self.share);
                Begun { leg: Leg { ray, medium }, flux }
            }
        }
    }

    /// Follows one path and leaves VPLs.
    fn walk(&self, begun: Begun, key: u64, s: &mut Stream, trail: &mut Trail) {
        let Begun { mut leg, mut flux } = begun;
        let scene = self.tracer.scene();
        // What flux is worth of basic radiance here; exactly 1 again outside of all glass.
        let mut basic = 1.0_f64;
        // Of the way since the emitter.
        let (mut is_specular, mut is_bent) = (true, false);
        // Surfaces that the path has met; times that it was scattered, anywhere; boundaries passed since.
        let (mut depth, mut turned, mut passed) = (0, 0_u32, 0);
        while !flux.is_black() {
            // Holes are the same along a straight line.
            let key = key.wrapping_add(u64::from(turned));
            let hit = self.tracer.closest_hit_at(&leg.ray, key, self.share);
            let (left, scattering) = leg.fly(scene, hit.as_ref(), flux, s);
            if let Some(at) = scattering {
                trail.lights.push(Vpl {
                    position: at.place,
                    direction: at.before,
                    intensity: left / (4.0 * PI) * basic as f32,
                    kind: VplKind::Volume(at.phase),
                });
                let survival = (left.max_channel() / flux.max_channel()).min(MAX_SURVIVAL_IN_MEDIUM);
                if s.uniform() >= survival {
                    return;
                }
                flux = left / survival;
                leg.ray = Ray::new(at.place, at.phase.sample(at.before, s.uniform_2()).0);
                is_specular = false;
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
            leave(&point, &bsdf, through, incoming, flux * basic as f32, is_specular && is_bent, trail);
            let Some(next) = goes_on(&point, &bsdf, through, incoming, s) else { return };
            let Scattered { direction, factor, specular, .. } = next;
            basic *= next.basic;
            let next = flux * factor;
            if specular.is_none() {
                trail.reflected += f64::from(next.luminance()) * basic;
            }
            is_specular &= specular.is_some();
            let is_pane = matches!(bsdf, Bsdf::ThinGlass(_)) && specular == Some(Lobe::SpecularTransmission);
            is_bent |= !is_pane;
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
