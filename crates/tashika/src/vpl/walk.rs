//! Light paths: from the emitters over the surfaces, leaving a VPL wherever light is reflected diffusely. What they are for and what they guarantee is in
//! [`trace`](super::trace).

use std::f32::consts::PI;

use rayon::prelude::*;

use super::{EmitterSampler, LightGuide, Vpl, VplKind, VplOptions, carried_cos};
use crate::accel::Tracer;
use crate::bsdf::{Bsdf, Lobe};
use crate::color::Rgb;
use crate::math::{Frame, Ray};
use crate::rng::{self, Purpose, Stream};
use crate::scene::Part;

/// Light paths traced as one piece of parallel work.
const CHUNK: u64 = 1024;

/// VPLs of one or more paths, and what became of the flux.
#[derive(Default)]
pub(super) struct Trail {
    pub(super) lights: Vec<Vpl>,
    /// How many of these each path left.
    pub(super) counts: Vec<u32>,
    /// Numbers of those that are the first of their path, which came from the emitter by a bent way.
    pub(super) bent: Vec<u32>,
    /// Flux that VPLs send out (W, luminance).
    pub(super) diffuse: f64,
    /// Flux that surfaces reflect, but for mirrors and glass.
    pub(super) reflected: f64,
}

/// Follows so many light paths, in parallel on the current thread pool.
pub(super) fn trace_paths(
    tracer: &Tracer,
    emitters: &EmitterSampler<'_>,
    guide: &LightGuide,
    options: &VplOptions,
    purpose: Purpose,
    paths: u64,
) -> Trail {
    let chunks: Vec<Trail> = (0..paths.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut trail = Trail::default();
            for i in chunk * CHUNK..((chunk + 1) * CHUNK).min(paths) {
                let mut s = Stream::new(options.seed, purpose, i);
                // Stratified over the emitters.
                let u = (i as f64 + s.uniform_f64()) / paths as f64;
                if let Some((ray, flux)) = guide.ray(emitters, u, &mut s) {
                    let key = rng::key(options.seed, purpose, i);
                    let before = trail.lights.len();
                    walk(tracer, ray, flux / paths as f32, options.max_depth, key, &mut s, &mut trail);
                    trail.counts.push((trail.lights.len() - before) as u32);
                }
            }
            trail
        })
        .collect();
    // In the order of the paths, whichever thread traced them.
    let lights = chunks.iter().map(|t| t.lights.len()).sum();
    let all = Trail { lights: Vec::with_capacity(lights), ..Trail::default() };
    chunks.into_iter().fold(all, |mut all, t| {
        all.bent.extend(t.bent.iter().map(|number| number + all.lights.len() as u32));
        all.lights.extend(t.lights);
        all.counts.extend(t.counts);
        all.diffuse += t.diffuse;
        all.reflected += t.reflected;
        all
    })
}

/// Follows one light path and leaves VPLs.
fn walk(
    tracer: &Tracer,
    mut ray: Ray,
    mut flux: Rgb,
    max_depth: u32,
    key: u64,
    s: &mut Stream,
    trail: &mut Trail,
) {
    let scene = tracer.scene();
    // Of the way since the emitter.
    let (mut is_specular, mut is_bent) = (true, false);
    for depth in 0..max_depth {
        if flux.is_black() {
            return;
        }
        let Some(hit) = tracer.closest_hit(&ray, key.wrapping_add(u64::from(depth))) else { return };
        let point = scene.surface_point(hit.instance, hit.triangle, hit.barycentric);
        let incoming = -ray.direction;
        let Part { bsdf, weight, through } = scene.part(&point, incoming, s.uniform());
        flux *= weight;
        let (ng, ns) = (point.geometric_normal, point.shading_normal);
        let (cos_ng, cos_ns) = (ng.dot(incoming), ns.dot(incoming));
        // Light that arrives at the back of the shading normal is reflected by neither normal's rule.
        if cos_ng * cos_ns <= 0.0 {
            return;
        }
        let frame = Frame::about(ns);
        let mut wo = frame.to_local(incoming);
        if through {
            // As if the light had come from the other side.
            wo.z = -wo.z;
        }
        let adjoint = cos_ns / cos_ng;
        let carried = carried_cos(&point, &bsdf, incoming);
        if !carried.is_black() {
            let normal = if (cos_ng > 0.0) != through { ng } else { -ng };
            let intensity = flux * carried / cos_ng.abs();
            trail.diffuse += f64::from(intensity.luminance() * PI);
            if is_specular && is_bent {
                trail.bent.push(trail.lights.len() as u32);
            }
            trail.lights.push(Vpl {
                position: point.leave(normal),
                direction: normal,
                intensity,
                kind: VplKind::Oriented,
            });
        }
        let Some(sample) = bsdf.sample(wo, s.uniform_3()) else { return };
        let direction = frame.to_world(sample.wi).normalize();
        let (out_ng, out_ns) = (ng.dot(direction), ns.dot(direction));
        if out_ng * out_ns <= 0.0 {
            return;
        }
        let next = flux * sample.weight * (adjoint * out_ng / out_ns);
        if !sample.lobe.is_specular() {
            trail.reflected += f64::from(next.luminance());
        }
        is_specular &= sample.lobe.is_specular();
        let is_pane = matches!(bsdf, Bsdf::ThinGlass(_)) && sample.lobe == Lobe::SpecularTransmission;
        is_bent |= !is_pane;
        let survival = (next.max_channel() / flux.max_channel()).min(1.0);
        if s.uniform() >= survival {
            return;
        }
        flux = next / survival;
        ray = Ray::new(point.leave(direction), direction);
    }
}
