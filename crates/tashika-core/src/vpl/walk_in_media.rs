//! Light paths that are scattered between surfaces as well as at them: the counterpart of the path
//! tracer's, from the emitters.
//!
//! A path begins in the medium that [`Outside`] tells, and draws on its way to each surface whether it
//! is scattered before ([`fly`]). Where it is, it leaves a VPL of what is scattered and goes on by the
//! phase function. Interfaces tell which medium it is in from there on; boundaries that are nothing
//! else are passed. Being scattered, and passing such a boundary, do not count as surfaces: Russian
//! roulette by the flux that is left ends paths in media, with a cap near one.
//!
//! # Held to this by
//! The suite's `volume_lights`.

use std::f32::consts::PI;

use super::walk::{Scattered, Trail, goes_on, leave};
use super::{Vpl, VplKind};
use crate::accel::Tracer;
use crate::bsdf::{Bsdf, Lobe};
use crate::color::Rgb;
use crate::math::Ray;
use crate::media::{Flight, MOST_PASSED, Outside, fly};
use crate::rng::Stream;
use crate::scene::{MediumId, Part};

/// Highest probability of going on after being scattered.
const MAX_SURVIVAL_IN_MEDIUM: f32 = 0.999;

/// A path that leaves an emitter.
pub(super) struct Begun {
    ray: Ray,
    flux: Rgb,
    medium: Option<MediumId>,
}

impl Begun {
    /// With so much flux along a ray, or what media leave of it where that comes from infinity.
    pub(super) fn new(
        tracer: &Tracer,
        outside: Outside,
        ray: Ray,
        flux: Rgb,
        from_infinity: bool,
        key: u64,
        s: &mut Stream,
    ) -> Self {
        if from_infinity {
            Self { ray, flux: flux * outside.arriving(tracer, &ray, s), medium: outside.medium() }
        } else {
            Self { ray, flux, medium: outside.medium_at(tracer, &ray, key, 0.0) }
        }
    }
}

/// Follows one light path and leaves VPLs.
pub(super) fn walk_in_media(
    tracer: &Tracer,
    Begun { mut ray, mut flux, mut medium }: Begun,
    max_depth: u32,
    key: u64,
    s: &mut Stream,
    trail: &mut Trail,
) {
    let scene = tracer.scene();
    // Of the way since the emitter.
    let (mut is_specular, mut is_bent) = (true, false);
    // Surfaces that the path has met; times that it was scattered, anywhere; boundaries passed since.
    let (mut depth, mut turned, mut passed) = (0, 0_u32, 0);
    while !flux.is_black() {
        // Holes are the same along a straight line.
        let key = key.wrapping_add(u64::from(turned));
        let hit = tracer.closest_hit(&ray, key);
        if let Some(medium) = medium.map(|m| &scene.media()[m.index()]).filter(|m| !m.is_clear()) {
            let distance = hit.map_or(f32::INFINITY, |hit| hit.t);
            match fly(medium, flux, &ray, distance, s) {
                Flight::Passed { weight } => flux = weight,
                Flight::Scattered { after, weight } => {
                    let position = ray.at(after);
                    trail.lights.push(Vpl {
                        position,
                        direction: ray.direction,
                        intensity: weight / (4.0 * PI),
                        kind: VplKind::Volume(medium.phase),
                    });
                    let survival = (weight.max_channel() / flux.max_channel()).min(MAX_SURVIVAL_IN_MEDIUM);
                    if s.uniform() >= survival {
                        return;
                    }
                    flux = weight / survival;
                    ray = Ray::new(position, medium.phase.sample(ray.direction, s.uniform_2()).0);
                    is_specular = false;
                    turned = turned.saturating_add(1);
                    passed = 0;
                    continue;
                }
            }
        }
        let Some(hit) = hit else { return };
        let point = scene.surface_point(hit.instance, hit.triangle, hit.barycentric);
        if scene.is_boundary(&point) {
            medium = scene.medium_beyond(&point, ray.direction, medium);
            ray = Ray::new(point.leave(ray.direction), ray.direction);
            passed += 1;
            if passed > MOST_PASSED {
                return;
            }
            continue;
        }
        if depth == max_depth {
            return;
        }
        let incoming = -ray.direction;
        let Part { bsdf, weight, through } = scene.part(&point, incoming, s.uniform());
        flux *= weight;
        leave(&point, &bsdf, through, incoming, flux, is_specular && is_bent, trail);
        let Some(Scattered { direction, factor, specular }) = goes_on(&point, &bsdf, through, incoming, s)
        else {
            return;
        };
        let next = flux * factor;
        if specular.is_none() {
            trail.reflected += f64::from(next.luminance());
        }
        is_specular &= specular.is_some();
        let is_pane = matches!(bsdf, Bsdf::ThinGlass(_)) && specular == Some(Lobe::SpecularTransmission);
        is_bent |= !is_pane;
        let survival = (next.max_channel() / flux.max_channel()).min(1.0);
        if s.uniform() >= survival {
            return;
        }
        flux = next / survival;
        medium = scene.medium_beyond(&point, direction, medium);
        ray = Ray::new(point.leave(direction), direction);
        depth += 1;
        turned = turned.saturating_add(1);
        passed = 0;
    }
}
