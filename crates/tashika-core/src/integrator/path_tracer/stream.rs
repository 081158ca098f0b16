//! Streams: paths that are followed together, one stage after the other.
//!
//! ```text
//! rays ─► closest hits ─► surfaces ─► lights drawn ─► segments ─► directions drawn ─┐
//!   ▲                                                                               │
//!   └───────────────── paths that go on (Russian roulette) ◄───────────────────────┘
//! ```
//!
//! A stage does one thing for all paths of a stream, and first reads ahead for all of them:
//! triangles and their corners, the environment, the tables of its draws. The processor then waits
//! for many reads at once, where a single path would wait for each of its own (Áfra et al. 2016;
//! Lee et al. 2017). A stream is small enough to stay in the caches of a core.
//!
//! Each path has its own random numbers and its own sum, so that its radiance does not depend on
//! the stream in which it is followed.

use super::path::{CERTAIN_DEPTH, DrawnDirection, Found, MAX_SURVIVAL, Start, weight_of_light};
use super::tracing::Tracing;
use crate::accel::{Glass, Hit, SegmentBatch};
use crate::color::Rgb;
use crate::contribution::ContributionKernel;
use crate::gather::{FirstSurface, GatherPoint, Scatter};
use crate::math::{Ray, Vec3};
use crate::media::Leg;
use crate::rng;
use crate::scene::{Environment, LightId};
use crate::vpl::{Choice, LightSample};

/// Paths of a stream: their state fills a part of the second cache of a core.
const PATHS: usize = 256;

/// A path between two surfaces.
struct Path {
    ray: Ray,
    /// Key of the decisions at partly opaque surfaces.
    key: u64,
    /// Time, as a share of the time that the shutter is open.
    share: f32,
    stream: rng::Stream,
    /// Throughput, for basic radiance.
    weight: Rgb,
    /// Product of `SpecularPoint::squared_ratio` over the boundaries of glass that the path has
    /// crossed.
    ratio: f64,
    /// Last drawn direction; `None` at first.
    drawn: Option<DrawnDirection>,
}

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
    hits: Vec<Option<Hit>>,
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
        let weight = Rgb::gray(tracing.camera.squared_index());
        for (number, Start { beginning, key, share, stream }) in (0..PATHS as u32).zip(starts) {
            let ray = match tracing.first_leg(beginning) {
                None => Ray::new(Vec3::ZERO, Vec3::Z),
                Some((ray, None)) => {
                    self.with_ray.push(number);
                    ray
                }
                Some((ray, Some(point))) => {
                    self.points.push((number, point));
                    ray
                }
            };
            self.paths.push(Path { ray, key, share, stream, weight, ratio: 1.0, drawn: None });
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
        for depth in 0..=tracing.max_depth {
            self.closest_hits(tracing, depth);
            self.surfaces(tracing, depth);
            self.lights(tracing);
            self.shadows(tracing, depth);
            self.directions();
            self.points.clear();
            self.roulette(depth);
            if self.with_ray.is_empty() {
                break;
            }
        }
    }

    /// Traces the rays.
    fn closest_hits(&mut self, tracing: &Tracing<'_>, depth: u32) {
        self.hits.clear();
        for &number in &self.with_ray {
            let Path { ray, key, share, .. } = &self.paths[number as usize];
            self.hits.push(tracing.tracer.closest_hit_at(ray, key.wrapping_add(depth.into()), *share));
            self.found[number as usize].rays += 1;
        }
    }

    /// Adds the light of emitters that the rays met, and draws a part of each surface: specular
    /// parts send their path on, others gather light.
    fn surfaces(&mut self, tracing: &Tracing<'_>, depth: u32) {
        let scene = tracing.tracer.scene();
        let environment = scene.environment();
        for hit in self.hits.iter().flatten() {
            scene.read_triangle_ahead(hit.instance, hit.triangle);
        }
        for (&number, hit) in self.with_ray.iter().zip(&self.hits) {
            match (hit, environment) {
                (Some(hit), _) => scene.read_corners_ahead(hit.instance, hit.triangle),
                (None, Some(e)) => e.read_ahead_at(self.paths[number as usize].ray.direction.normalize()),
                (None, None) => {}
            }
        }
        self.going_on.clear();
        for (&number, hit) in self.with_ray.iter().zip(&self.hits) {
            let path = &mut self.paths[number as usize];
            let found = &mut self.found[number as usize];
            let Some(hit) = hit else {
                let given = tracing.from_environment(&path.ray, path.drawn.as_ref(), path.weight, path.ratio);
                found.add(tracing.groups, LightId::Environment, given);
                continue;
            };
            let surface = scene.surface_point_at(path.share, hit.instance, hit.triangle, hit.barycentric);
            let outgoing = -path.ray.direction;
            let at = (&surface, hit, path.share);
            let given = tracing.from_surface(at, outgoing, path.drawn.as_ref(), path.weight);
            found.add(tracing.groups, LightId::Instance(hit.instance), given);
            if depth == 0 {
                let (_, normal) = surface.normals_seen_from(outgoing);
                found.first = Some(FirstSurface { distance: hit.t, normal });
            }
            if depth == tracing.max_depth {
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
                    path.ray = next;
                    self.going_on.push(number);
                }
                Scatter::Gathers(point) => self.points.push((number, point)),
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
            let mis = weight_of_light(&sample, point.position, |towards| {
                point.bsdf.pdf(point.wo, point.frame.to_local(towards))
            });
            let weight = mis * tracing.basic_of(&sample.light, path.ratio);
            self.segments.push_fan(sample.light.apex(), [point.position]);
            found.rays += 1;
            let light = tracing.emitters.light_of(choice.source);
            self.lit.push(Lit { point: index, light, sample, unoccluded, weight });
        }
    }

    /// Traces the segments to the drawn lights, and adds their light.
    fn shadows(&mut self, tracing: &mut Tracing<'_>, depth: u32) {
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
            let (number, point) = &self.points[*point];
            let Path { key, share, stream, .. } = &mut self.paths[*number as usize];
            let found = &mut self.found[*number as usize];
            let begun = Leg { ray: Ray::new(point.position, -sample.light.direction), medium: None };
            let at = (key.wrapping_add(depth.into()), *share, depth);
            let beside = tracing.through_panes(free, begun, &sample.light, at, stream, &mut found.rays);
            found.add(tracing.groups, *light, *unoccluded * (weight * free));
            if !beside.is_black() {
                found.add(tracing.groups, *light, *unoccluded * beside * *weight);
            }
        }
    }

    /// Draws the directions in which the paths leave the gather points.
    fn directions(&mut self) {
        for (number, point) in &self.points {
            let path = &mut self.paths[*number as usize];
            let Some(next) = point.bsdf.sample(point.wo, path.stream.uniform_3()) else { continue };
            let direction = point.frame.to_world(next.wi).normalize();
            if point.geometric_normal.dot(direction) <= 0.0 {
                continue;
            }
            path.weight *= next.weight;
            path.ray = Ray::new(point.position, direction);
            path.drawn = Some(DrawnDirection::new(&path.ray, next.pdf));
            self.going_on.push(*number);
        }
    }

    /// Ends paths by Russian roulette; the others have a ray in the next step.
    fn roulette(&mut self, depth: u32) {
        self.with_ray.clear();
        for &number in &self.going_on {
            let path = &mut self.paths[number as usize];
            if depth >= CERTAIN_DEPTH {
                let survival = path.weight.max_channel().min(MAX_SURVIVAL);
                if path.stream.uniform() >= survival {
                    continue;
                }
                path.weight = path.weight / survival;
            }
            self.with_ray.push(number);
        }
    }
}
