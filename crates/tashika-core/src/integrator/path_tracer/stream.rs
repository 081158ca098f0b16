//! Streams: paths that are followed together, one stage after the other.
//!
//! ```text
//! rays ─► closest hits ─► flights ─► surfaces ─► lights drawn ─► segments ─► directions drawn ─┐
//!   ▲                                                                                          │
//!   └───────────────── paths that go on (Russian roulette) ◄──────────────────────────────────┘
//! ```
//!
//! A stage does one thing for all paths of a stream, and first reads ahead for all of them:
//! triangles and their corners, the environment, the tables of its draws. The processor then waits
//! for many reads at once, where a single path would wait for each of its own (Áfra et al. 2016;
//! Lee et al. 2017). A stream is small enough to stay in the caches of a core.
//!
//! Each path has its own random numbers and its own sum, so that its radiance does not depend on
//! the stream in which it is followed.
//!
//! # Media
//! Paths may scatter between surfaces as well as at them:
//!
//! ```text
//! L(x, ω) = T(d) L_surface + ∫₀^d T(t) σ_s ∫ p(ω·ω') L(x + t ω, ω') dω' dt          (W·m⁻²·sr⁻¹)
//! ```
//!
//! [`Leg::fly`] draws whether a path is scattered before it reaches the next surface. If it is,
//! light is sampled as at a surface: from the emitters, along a segment with the transmittance of
//! the media, and by following the phase function of Henyey and Greenstein, weighted by the balance
//! heuristic over the two densities of a direction. Both densities omit the probability of reaching
//! the emitter. The weights nevertheless sum to one for every point of an emitter.
//!
//! The medium of a path is set by the last interface that the path passed, and at first by the
//! camera. Unoccluded segments are walked from interface to interface, with the transmittance of
//! each medium on the way. Light from infinity is black if it would cross a medium without end.
//!
//! Scattering in a medium and passing an invisible interface do not count as surfaces. Paths in
//! media end by Russian roulette. Its highest survival probability is near one, since light is
//! scattered hundreds of times in a white medium before it leaves.
//!
//! Samples of a point light *in* a scattering medium have unbounded variance, because of the factor
//! `1/d²`. The mean is correct, but single pixels may be too bright. Equiangular sampling of
//! distances would help.
//!
//! # Held to this by
//! `samples::tests` (streams do not enter), the suite's `media` and `moving_objects`.

use super::path::{Found, Path, Start, weight_of_light};
use super::tracing::Tracing;
use crate::accel::{Glass, Hit, SegmentBatch};
use crate::color::Rgb;
use crate::contribution::ContributionKernel;
use crate::gather::{Beginning, FirstSurface, GatherPoint, Scatter};
use crate::math::{Ray, Vec3};
use crate::media::{Leg, along_segment};
use crate::scene::{Environment, LightId};
use crate::vpl::{Choice, LightSample};

/// Paths of a stream: their state fills a part of the second cache of a core.
const PATHS: usize = 256;

/// A light drawn for a gather point.
struct Lit {
    /// Number of the gather point.
    point: usize,
    light: LightId,
    sample: LightSample,
    /// Radiance if the light is visible (W·m⁻²·sr⁻¹), without `weight`.
    unoccluded: Rgb,
    /// MIS weight, for basic radiance.
    weight: f32,
}

/// Paths that are followed together.
pub(super) struct Stream {
    paths: Vec<Path>,
    /// Light that each path found.
    found: Vec<Found>,
    /// Numbers of the paths that have a ray, and of those that get one in this step.
    with_ray: Vec<u32>,
    going_on: Vec<u32>,
    /// Closest hits of the rays, with the numbers of their paths.
    hits: Vec<(u32, Option<Hit>)>,
    /// Points at which light is gathered, with the numbers of their paths.
    points: Vec<(u32, GatherPoint)>,
    /// Emitters drawn for the points; `None` if the scene has none.
    choices: Vec<Option<Choice>>,
    lit: Vec<Lit>,
    segments: SegmentBatch,
    visibility: Vec<f32>,
}

impl Default for Stream {
    fn default() -> Self {
        Self {
            paths: Vec::new(),
            found: Vec::new(),
            with_ray: Vec::new(),
            going_on: Vec::new(),
            hits: Vec::new(),
            points: Vec::new(),
            choices: Vec::new(),
            lit: Vec::new(),
            segments: SegmentBatch::new(Glass::SolidStops),
            visibility: Vec::new(),
        }
    }
}

impl Stream {
    /// Begins the next paths. Returns false if there are none.
    pub fn fill(&mut self, tracing: &Tracing<'_>, starts: &mut impl Iterator<Item = Start>) -> bool {
        self.paths.clear();
        self.with_ray.clear();
        self.points.clear();
        for (number, Start { beginning, key, share, stream }) in (0..PATHS as u32).zip(starts) {
            let ray = match beginning {
                Beginning::Nothing => Ray::new(Vec3::ZERO, Vec3::Z),
                Beginning::Ray(ray) => {
                    self.with_ray.push(number);
                    ray
                }
                Beginning::Sensor(sensor) => {
                    self.points.push((number, GatherPoint::on_sensor(&sensor, tracing.camera.medium)));
                    Ray::new(sensor.position, sensor.normal)
                }
            };
            self.paths.push(Path::new(tracing.camera, ray, key, share, stream));
        }
        if self.found.len() < self.paths.len() {
            self.found.resize_with(self.paths.len(), Found::default);
        }
        self.found[..self.paths.len()].iter_mut().for_each(|found| found.clear(tracing.groups));
        !self.paths.is_empty()
    }

    /// Light that each path found, in the order of their beginnings.
    pub fn found(&self) -> impl Iterator<Item = &Found> {
        self.found[..self.paths.len()].iter()
    }

    /// Follows all paths to their ends.
    pub fn follow(&mut self, tracing: &mut Tracing<'_>) {
        while !self.with_ray.is_empty() || !self.points.is_empty() {
            self.going_on.clear();
            self.closest_hits(tracing);
            if tracing.has_media {
                self.flights(tracing);
            }
            self.surfaces(tracing);
            self.lights(tracing);
            self.shadows(tracing);
            self.directions();
            std::mem::swap(&mut self.with_ray, &mut self.going_on);
        }
    }

    /// Traces the rays.
    fn closest_hits(&mut self, tracing: &Tracing<'_>) {
        self.hits.clear();
        for &number in &self.with_ray {
            let path = &self.paths[number as usize];
            self.hits.push((number, tracing.tracer.closest_hit_at(&path.leg.ray, path.key(), path.share)));
            self.found[number as usize].rays += 1;
        }
    }

    /// Scatters paths in media before they reach their hits.
    fn flights(&mut self, tracing: &Tracing<'_>) {
        let scene = tracing.tracer.scene();
        self.hits.retain(|(number, hit)| {
            let path = &mut self.paths[*number as usize];
            let (weight, scattering) = path.leg.fly(scene, hit.as_ref(), path.weight, &mut path.stream);
            path.weight = weight;
            if let Some(at) = &scattering {
                self.points.push((*number, GatherPoint::in_medium(at, Rgb::WHITE)));
            }
            scattering.is_none()
        });
    }

    /// Adds the light of emitters that the rays met, and draws a part of each surface: specular
    /// parts send their path on, others gather light.
    fn surfaces(&mut self, tracing: &Tracing<'_>) {
        let scene = tracing.tracer.scene();
        let environment = scene.environment();
        for hit in self.hits.iter().filter_map(|(_, hit)| hit.as_ref()) {
            scene.read_triangle_ahead(hit.instance, hit.triangle);
        }
        for (number, hit) in &self.hits {
            match (hit, environment) {
                (Some(hit), _) => scene.read_corners_ahead(hit.instance, hit.triangle),
                (None, Some(e)) => {
                    e.read_ahead_at(self.paths[*number as usize].leg.ray.direction.normalize());
                }
                (None, None) => {}
            }
        }
        for &(number, ref hit) in &self.hits {
            let path = &mut self.paths[number as usize];
            let found = &mut self.found[number as usize];
            let Some(hit) = hit else {
                let given =
                    tracing.light_of_environment(&path.leg.ray, path.drawn.as_ref(), path.weight, path.ratio);
                found.add(tracing.groups, LightId::Environment, given);
                continue;
            };
            let surface = scene.surface_point_at(path.share, hit.instance, hit.triangle, hit.barycentric);
            let outgoing = -path.leg.ray.direction;
            let at = (&surface, hit, path.share);
            let given = tracing.light_of_surface(at, outgoing, path.drawn.as_ref(), path.weight);
            found.add(tracing.groups, LightId::Instance(hit.instance), given);
            if scene.is_boundary(&surface) {
                path.leg = path.leg.beyond(scene, &surface);
                if path.passes() {
                    self.going_on.push(number);
                }
                continue;
            }
            if path.depth == 0 {
                let (_, normal) = surface.normals_seen_from(outgoing);
                found.first = Some(FirstSurface { distance: hit.t, normal });
            }
            if path.depth == tracing.max_depth {
                continue;
            }
            match Scatter::at(scene, &surface, outgoing, path.stream.uniform()) {
                Scatter::Specular(specular) => {
                    let Some((next, factor)) = specular.step(path.stream.uniform_3()) else { continue };
                    if let Some(drawn) = &mut path.drawn {
                        drawn.passage = drawn.passage.beyond(&specular, next.direction);
                    }
                    path.weight *= factor;
                    path.ratio *= specular.squared_ratio(next.direction);
                    path.leg = path.leg.onward(scene, &surface, next);
                    if path.goes_on_from_surface() {
                        self.going_on.push(number);
                    }
                }
                Scatter::Gathers(mut point) => {
                    point.medium = scene.medium_beyond(&surface, point.geometric_normal, path.leg.medium);
                    self.points.push((number, point));
                }
            }
        }
    }

    /// Draws a light for each gather point.
    fn lights(&mut self, tracing: &Tracing<'_>) {
        let contribution = ContributionKernel::default().within(tracing.tracer.scene());
        self.lit.clear();
        self.segments.clear();
        self.choices.clear();
        for (number, _) in &self.points {
            let stream = &mut self.paths[*number as usize].stream;
            self.choices.push(tracing.emitters.choose(stream.uniform_f64(), stream.uniform_2()));
        }
        for step in 0..Environment::READS {
            self.choices.iter().flatten().for_each(|choice| tracing.emitters.read_ahead(choice, step));
        }
        for (index, ((number, point), choice)) in self.points.iter_mut().zip(&self.choices).enumerate() {
            let path = &mut self.paths[*number as usize];
            let found = &mut self.found[*number as usize];
            if !found.gathers {
                found.albedo = Some(point.albedo());
            }
            found.gathers = true;
            path.weight *= point.weight;
            point.weight = path.weight;
            let Some(choice) = choice else { continue };
            let sample = tracing.emitters.draw(path.share, choice);
            let unoccluded = contribution.unoccluded(point, &sample.light);
            if unoccluded.is_black() {
                continue;
            }
            let mis = weight_of_light(&sample, point.position, |towards| match point.phase {
                None => point.bsdf.pdf(point.wo, point.frame.to_local(towards)),
                Some(phase) => phase.density(point.before().dot(towards)),
            });
            let weight = mis * tracing.basic_of(&sample.light, path.ratio);
            self.segments.push_fan(sample.light.apex(), [point.position]);
            found.rays += 1;
            let light = tracing.emitters.light_of(choice.source);
            self.lit.push(Lit { point: index, light, sample, unoccluded, weight });
        }
    }

    /// Traces the segments to the drawn lights, and adds their light.
    fn shadows(&mut self, tracing: &mut Tracing<'_>) {
        if tracing.moves {
            // Each segment has a time of its own.
            let visible = |lit: &Lit| {
                let (number, point) = &self.points[lit.point];
                let share = self.paths[*number as usize].share;
                tracing.visible(lit.sample.light.apex(), point.position, share)
            };
            self.visibility.clear();
            self.visibility.extend(self.lit.iter().map(visible));
        } else {
            tracing.tracer.visibility(&self.segments, &mut self.visibility);
        }
        for (Lit { point, light, sample, unoccluded, weight }, &free) in self.lit.iter().zip(&self.visibility)
        {
            let (number, GatherPoint { position, medium, .. }) = self.points[*point];
            let path = &mut self.paths[number as usize];
            let found = &mut self.found[number as usize];
            let (key, share) = (path.key(), path.share);
            let mut given = *unoccluded * (weight * free);
            if tracing.has_media && free > 0.0 {
                let (from, to) = ((position, medium), sample.light.apex());
                let (left, rays) = along_segment(tracing.tracer, from, to, (key, share), &mut path.stream);
                found.rays += rays;
                given *= left;
            }
            found.add(tracing.groups, *light, given);
            let begun = Leg { ray: Ray::new(position, -sample.light.direction), medium };
            let at = (key, share, path.depth);
            let light_of = &sample.light;
            let beside = tracing.through_panes(free, begun, light_of, at, &mut path.stream, &mut found.rays);
            found.add(tracing.groups, *light, *unoccluded * beside * *weight);
        }
    }

    /// Draws the directions in which the paths leave the gather points.
    fn directions(&mut self) {
        for (number, point) in self.points.drain(..) {
            let path = &mut self.paths[number as usize];
            let survives = if let Some(phase) = point.phase {
                let (direction, density) = phase.sample(point.before(), path.stream.uniform_2());
                path.turn(&point, direction, density);
                path.goes_on_from_medium()
            } else {
                let Some(next) = point.bsdf.sample(point.wo, path.stream.uniform_3()) else { continue };
                let direction = point.frame.to_world(next.wi).normalize();
                if point.geometric_normal.dot(direction) <= 0.0 {
                    continue;
                }
                path.weight *= next.weight;
                path.turn(&point, direction, next.pdf);
                path.goes_on_from_surface()
            };
            if survives {
                self.going_on.push(number);
            }
        }
    }
}
