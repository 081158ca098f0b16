//! Emission that reaches surfaces in view, learned by camera paths.
//!
//! A camera path meets surfaces `x₁, x₂, …`, and at each of them an emitter sample is drawn. The
//! luminance that the sample contributes to the pixel by way of these surfaces is the importance of
//! the sampled emission. A sample at `x₁` gives the importance of its position on the emitter, a
//! sample at `x_k` (`k ≥ 2`) that of its ray towards `x_k`. Importance is relative to the
//! brightness of that part of the picture, so that a dark room counts as much as the meadow seen
//! through its window. The samples are points in the space of the uniform numbers by which emission
//! is drawn. From these points a [`LightGuide`] is learned. The guide finds light that enters by
//! windows, however large the world outside is, since camera paths start where the camera looks.
//!
//! If light enters only by a keyhole, camera paths hardly ever find it. Then light paths are traced
//! with the guide learned so far. If a light path leaves VPLs near the surfaces met by camera
//! paths, its emission ray is added to the samples. The guide is then learned again. This is
//! repeated, `MOST_PASSES` times at most, until there are enough samples.
//!
//! Segments pass straight through glass, even solid glass: approximate visibility is enough here.
//!
//! Held to this by the suite's `light_transport`: a room on a wide ground has its VPLs in the room.

use rayon::prelude::*;

use super::photons::{Side, side};
use super::{CHUNK, paths_for};
use crate::accel::{Glass, Tracer};
use crate::color::Rgb;
use crate::contribution::ContributionKernel;
use crate::film::Window;
use crate::gather::{Beginning, GatherPoint, Scatter, View};
use crate::math::{Ray, Vec3};
use crate::media::{Leg, MOST_PASSED, Shadows};
use crate::rng::{self, Purpose, Stream};
use crate::stats::{Moments, Weighted};
use crate::vpl::{EmitterSampler, LightGuide, LightSample, LightTracer, Vpl};

/// Maximum number of gathering surfaces of a path.
const MOST_SURFACES: u32 = 8;
/// Maximum number of specular surfaces between two of these.
const MOST_SPECULAR: u32 = 8;
/// Number of parts of the picture, across and down, whose brightness is estimated separately.
const PARTS: u32 = 12;
/// Number of emission rays from which a guide is learned well. Where camera paths find fewer, light
/// paths that reach their surroundings are added.
const ENOUGH_RAYS: usize = 512;
/// Maximum number of passes of light paths that look for more emission rays.
const MOST_PASSES: u64 = 4;
/// Spread of the surfaces that camera paths meet, in cells of the lattice that divides their
/// surroundings.
const CELLS_PER_SPREAD: f64 = 16.0;
/// Brightness that is added to each part of the picture, as a share of the mean over all paths.
const LEAST_BRIGHTNESS: f64 = 1e-3;

/// Guided light tracer for the VPLs of a view, and the brightness of the view.
#[derive(Debug)]
pub struct Guided<'s> {
    /// Tracer of light paths and direct VPLs, guided to surfaces in view.
    pub tracing: LightTracer<'s>,
    /// Approximate mean luminance of the view, without directly visible emission (W·m⁻²·sr⁻¹).
    pub importance_brightness: f64,
}

/// Learns a guide by which light paths and direct VPLs are drawn towards surfaces in view.
pub fn learn_light_guide<'s>(tracing: LightTracer<'s>, view: &View<'_>, seed: u64) -> Guided<'s> {
    let (tracer, emitters) = (tracing.tracer(), tracing.emitters());
    if emitters.is_empty() {
        return Guided { tracing, importance_brightness: 0.0 };
    }
    let paths = paths_for(view);
    let chunks: Vec<Learned> = (0..paths / CHUNK)
        .into_par_iter()
        .map(|chunk| {
            let mut learned = Learned::default();
            let mut walk = Walk { tracer, emitters, shadows: Shadows::new(Glass::Passes) };
            for path in chunk * CHUNK..(chunk + 1) * CHUNK {
                walk.follow(view, rng::key(seed, Purpose::Guidance, path), &mut learned);
            }
            learned
        })
        .collect();
    let mut brightness = vec![[0.0; 2]; (PARTS * PARTS) as usize];
    for (part, radiance) in chunks.iter().flat_map(|learned| &learned.paths) {
        let [sum, count] = &mut brightness[*part as usize];
        *sum += f64::from(*radiance);
        *count += 1.0;
    }
    let mean = brightness.iter().map(|[sum, _]| sum).sum::<f64>() / paths as f64;
    let scale: Vec<f32> = brightness
        .iter()
        .map(|[sum, count]| (1.0 / (sum / f64::max(*count, 1.0) + LEAST_BRIGHTNESS * mean)) as f32)
        .collect();
    fn scaled<const D: usize>(records: &[Record<D>], scale: &[f32]) -> Vec<Weighted<D>> {
        let weighted = |r: &Record<D>| (r.numbers, r.radiance * scale[r.part as usize]);
        records.iter().map(weighted).filter(|(_, weight)| weight.is_finite()).collect()
    }
    let direct: Vec<_> = chunks.iter().flat_map(|learned| scaled(&learned.direct, &scale)).collect();
    let mut emission: Vec<_> = chunks.iter().flat_map(|learned| scaled(&learned.emission, &scale)).collect();
    let mut guide = LightGuide::learn(direct.clone(), emission.clone());
    let places = Places::of(chunks.iter().flat_map(|learned| &learned.places));
    for pass in 0..MOST_PASSES {
        if emission.len() >= ENOUGH_RAYS {
            break;
        }
        let worth = |light: &Vpl| {
            if places.hold(light.position, light.direction) { light.intensity.luminance() } else { 0.0 }
        };
        let seed = rng::key(rng::key(seed, Purpose::Guidance, paths), Purpose::LightPath, pass);
        let light_paths = paths << (2 * pass);
        emission = of_equal_weight(emission, tracing.worth_of_emission(&guide, light_paths, seed, worth));
        guide = LightGuide::learn(direct.clone(), emission.clone());
    }
    Guided { tracing: tracing.guided(guide), importance_brightness: mean }
}

/// Joins two sets after scaling each to a mean weight of 1, since the units of their weights
/// differ.
fn of_equal_weight<const D: usize>(one: Vec<Weighted<D>>, other: Vec<Weighted<D>>) -> Vec<Weighted<D>> {
    let scaled = |set: Vec<Weighted<D>>| {
        let mean = set.iter().map(|(_, weight)| weight).sum::<f32>() / set.len().max(1) as f32;
        set.into_iter().map(move |(numbers, weight)| (numbers, weight / mean))
    };
    scaled(one).chain(scaled(other)).collect()
}

/// Surroundings of the surfaces that camera paths meet, on the side that the paths meet.
struct Places {
    /// Sides of the surfaces, sorted.
    sides: Vec<Side>,
    size: f32,
}

impl Places {
    /// Returns the surroundings of surfaces with these positions and unit normals.
    fn of<'p>(met: impl Iterator<Item = &'p [Vec3; 2]> + Clone) -> Self {
        let mut moments = [Moments::default(); 3];
        for [position, _] in met.clone() {
            (0..3).for_each(|axis| moments[axis].push(position[axis].into()));
        }
        let spread = moments.iter().map(Moments::variance).sum::<f64>().sqrt();
        let size = (spread / CELLS_PER_SPREAD).max(f64::from(f32::MIN_POSITIVE)) as f32;
        let mut sides: Vec<Side> = met.map(|[position, normal]| side(*position, *normal, size)).collect();
        sides.sort_unstable();
        sides.dedup();
        Self { sides, size }
    }

    fn hold(&self, position: Vec3, normal: Vec3) -> bool {
        self.sides.binary_search(&side(position, normal, self.size)).is_ok()
    }
}

/// Luminance that an emitter sample contributed to a part of the picture, with the uniform numbers
/// by which the sample was drawn.
#[derive(Clone, Copy)]
struct Record<const D: usize> {
    numbers: [f32; D],
    part: u32,
    /// Luminance (W·m⁻²·sr⁻¹).
    radiance: f32,
}

#[derive(Default)]
struct Learned {
    direct: Vec<Record<3>>,
    emission: Vec<Record<5>>,
    /// Positions and unit normals of the surfaces that the paths met.
    places: Vec<[Vec3; 2]>,
    /// Part of the picture and luminance of each path.
    paths: Vec<(u32, f32)>,
}

struct Walk<'a> {
    tracer: &'a Tracer,
    emitters: &'a EmitterSampler<'a>,
    shadows: Shadows,
}

impl Walk<'_> {
    fn follow(&mut self, view: &View<'_>, key: u64, learned: &mut Learned) {
        let mut s = Stream::new(key, Purpose::Guidance, 0);
        let pixel = view.random_pixel(&Window::full(view.size), &mut s);
        let part = [0, 1].map(|axis| pixel[axis] * PARTS / view.size[axis].max(1));
        let part = part[1].min(PARTS - 1) * PARTS + part[0].min(PARTS - 1);
        let ([a, b], [c, d]) = (s.uniform_2(), s.uniform_2());
        let time = || Stream::new(key, Purpose::Shutter, 0).uniform();
        let medium = view.camera.medium;
        let (mut on_sensor, mut begun) = match view.beginning_of(pixel, [a, b, c, d], time) {
            Beginning::Ray(ray) => (None, Leg { ray, medium }),
            Beginning::Sensor(sensor) => {
                let away = Ray::new(sensor.position, sensor.normal);
                (Some(GatherPoint::on_sensor(&sensor, medium)), Leg { ray: away, medium })
            }
            Beginning::Nothing => {
                learned.paths.push((part, 0.0));
                return;
            }
        };
        let mut weight = Rgb::WHITE;
        let mut radiance = 0.0;
        for depth in 0..MOST_SURFACES {
            let key = key.wrapping_add(depth.into());
            let next = || self.next_point(begun, key, &mut weight, &mut s);
            let Some(point) = on_sensor.take().or_else(next) else { break };
            learned.places.push([point.position, point.geometric_normal]);
            if depth == 0 {
                // Point and directional lights are one VPL each: only emitters with an extent are
                // drawn.
                let numbers = (s.uniform_f64(), s.uniform_2());
                let sample = self.emitters.sample_extended(numbers.0, numbers.1);
                if let Some((_, given)) = sample.and_then(|sample| self.given(&point, weight, &sample)) {
                    let numbers = [numbers.0 as f32, numbers.1[0], numbers.1[1]];
                    learned.direct.push(Record { numbers, part, radiance: given });
                }
            }
            let (u, v) = (s.uniform_f64(), s.uniform_2());
            let sample = self.emitters.sample(u, v);
            if let Some((light, given)) = sample.and_then(|sample| self.given(&point, weight, &sample)) {
                radiance += given;
                if depth > 0 {
                    let (center, radius) = self.emitters.sphere();
                    let [c, d] = light.emission_through(point.position, center, radius, self.emitters.maps());
                    learned.emission.push(Record {
                        numbers: [u as f32, v[0], v[1], c, d],
                        part,
                        radiance: given,
                    });
                }
            }
            let (direction, factor) = if let Some(phase) = point.phase {
                (phase.sample(point.before(), s.uniform_2()).0, Rgb::WHITE)
            } else {
                let Some(next) = point.bsdf.sample(point.wo, s.uniform_3()) else { break };
                let direction = point.frame.to_world(next.wi).normalize();
                if point.geometric_normal.dot(direction) <= 0.0 {
                    break;
                }
                let survival = next.weight.max_channel().min(1.0);
                if s.uniform() >= survival {
                    break;
                }
                (direction, next.weight / survival)
            };
            weight *= factor;
            begun = Leg { ray: Ray::new(point.position, direction), medium: point.medium };
        }
        learned.paths.push((part, radiance));
    }

    /// Returns the next gather point of a path.
    fn next_point(&self, mut leg: Leg, key: u64, weight: &mut Rgb, s: &mut Stream) -> Option<GatherPoint> {
        let scene = self.tracer.scene();
        let (mut step, mut passed) = (0, 0);
        while step < MOST_SPECULAR && passed < MOST_PASSED {
            let hit = self.tracer.closest_hit(&leg.ray, rng::key(key, Purpose::Opacity, step.into()));
            let (left, scattering) = leg.fly(scene, hit.as_ref(), *weight, s);
            *weight = left;
            if let Some(at) = scattering {
                return Some(GatherPoint::in_medium(&at, Rgb::WHITE));
            }
            let hit = hit?;
            let surface = scene.surface_point(hit.instance, hit.triangle, hit.barycentric);
            if scene.is_boundary(&surface) {
                leg = leg.beyond(scene, &surface);
                passed += 1;
                continue;
            }
            match Scatter::at(scene, &surface, -leg.ray.direction, s.uniform()) {
                Scatter::Gathers(point) => {
                    *weight *= point.weight;
                    let medium = scene.medium_beyond(&surface, point.geometric_normal, leg.medium);
                    return Some(GatherPoint { weight: Rgb::WHITE, medium, ..point });
                }
                Scatter::Specular(specular) => {
                    let (next, factor) = specular.step(s.uniform_3())?;
                    *weight *= factor;
                    leg = leg.onward(scene, &surface, next);
                    step += 1;
                }
            }
        }
        None
    }

    /// Returns a drawn light, and the luminance that it contributes to the pixel by way of `point`;
    /// `None` if the luminance is zero.
    fn given(&mut self, point: &GatherPoint, weight: Rgb, sample: &LightSample) -> Option<(Vpl, f32)> {
        let light = sample.light;
        let given = (weight
            * ContributionKernel::default().within(self.tracer.scene()).unoccluded(point, &light))
        .luminance();
        if given <= 0.0 {
            return None;
        }
        let passing = self.shadows.trace_one(self.tracer, (point.position, point.medium), light.apex());
        let given = given * passing.max_channel();
        (given > 0.0).then_some((light, given))
    }
}
