//! Unidirectional path tracing: an independent estimate of light transport, as a check of the
//! many-light sum.
//!
//! At each surface light is sampled in two ways, by drawing a point of the emitters and by
//! following the BSDF, weighted by the balance heuristic (Veach 1997, section 9.2). The emitters,
//! BSDFs and cameras are shared with the other integrators; the estimator is not. There is no
//! clamp. Thin glass does not bend light, and both strategies see through it; they also see light
//! from infinity through panes of solid glass ([`through_panes`](crate::gather::through_panes)).
//! Other light through solid glass is found by following paths only.
//!
//! Each path has one time within the shutter interval: the camera, moving instances and drawn
//! lights are placed as of that time.
//!
//! In a scene with [media](crate::scene::Medium), paths also scatter between surfaces (module
//! `in_media`). Scenes without media do not use that module.
//!
//! The estimate is the mean of independent paths. Its standard error is that of this mean.
//!
//! A [`PathStop`] decides when a pixel has enough paths.

mod groups;
mod in_media;
mod nearby;
mod samples;
mod stopping;

pub use self::stopping::PathStop;

use std::sync::OnceLock;

use self::groups::PathByGroup;
use self::nearby::{Nearby, Neighbourhood};
use self::stopping::{Looking, Next, Scattering};
use super::{Estimates, HalfWidths, Integrator, PixelRecord, PlaneBeside, Setting, Truth};
use crate::accel::{Glass, Hit, SegmentBatch, Tracer};
use crate::color::{Rgb, RgbSum};
use crate::contribution::ContributionKernel;
use crate::error::{Error, Result};
use crate::film::{Metadata, Window, keys};
use crate::gather::{Beginning, GatherPoint, Passage, Scatter, through_panes};
use crate::math::{Ray, Vec3};
use crate::media::Leg;
use crate::rng::{self, Purpose, Stream};
use crate::scene::{Abilities, Camera, LightGroups, LightId, MediumId, SurfacePoint};
use crate::stats::Moments;
use crate::vpl::{EmitterSampler, LightSample, Vpl, VplKind};
use crate::warp::balance;

/// Unidirectional path tracer of a scene.
#[derive(Debug)]
pub struct PathTracer<'s> {
    emitters: EmitterSampler<'s>,
    stop: PathStop,
    max_depth: u32,
    groups: Option<&'s LightGroups>,
}

/// Most camera samples from which the features of a pixel's first surfaces are computed.
const OF_FEATURES: u32 = 16;
/// Surfaces after which a path may end by Russian roulette.
const CERTAIN_DEPTH: u32 = 3;
/// Highest survival probability. Without this limit, paths in a closed white room would never end.
const MAX_SURVIVAL: f32 = 0.98;

impl<'s> PathTracer<'s> {
    /// Returns a path tracer whose paths meet at most `max_depth` surfaces.
    ///
    /// # Errors
    /// No paths, a first analysis at fewer than two, a `max_depth` of zero, options out of range.
    pub fn new(tracer: &'s Tracer, stop: PathStop, max_depth: u32) -> Result<Self> {
        stop.validate()?;
        if max_depth == 0 {
            return Err(Error::option("max_depth", max_depth, "at least 1"));
        }
        Ok(Self { emitters: EmitterSampler::new(tracer), stop, max_depth, groups: None })
    }

    /// Returns the path tracer with planes for each group of the scene's lights. Groups are
    /// estimated by the paths of the pixel, so that their planes add up to the radiance except for
    /// rounding. Each group also has a plane of standard errors.
    #[must_use]
    pub fn with_groups(self, groups: &'s LightGroups) -> Self {
        Self { groups: Some(groups), ..self }
    }
}

/// Random numbers of the paths of a pixel.
struct Draws {
    stream: Stream,
    /// Stream of times, unused in still scenes.
    shutter: Stream,
}

impl Draws {
    fn new(seed: u64, purpose: Purpose, index: u64) -> Self {
        Self {
            stream: Stream::new(seed, purpose, index),
            shutter: Stream::new(seed, Purpose::Shutter, index),
        }
    }
}

impl Integrator for PathTracer<'_> {
    fn name(&self) -> &'static str {
        "path"
    }

    fn abilities(&self) -> Abilities {
        Abilities::ALL
    }

    fn describe(&self, metadata: &mut Metadata) {
        metadata.set(keys::TRUTH, Truth::Transport.to_string());
        metadata.set(keys::PAIRS_ARE, "paths");
        self.stop.describe(metadata);
        metadata.set(keys::MAX_DEPTH, self.max_depth);
    }

    fn begin<'v>(&'v self, setting: Setting<'v>) -> Box<dyn Estimates + 'v> {
        let neighbourhood = Neighbourhood::new(setting.view.size);
        Box::new(PathView { method: self, setting, neighbourhood, brightness: OnceLock::new() })
    }

    fn planes_beside(&self) -> Vec<PlaneBeside> {
        self.groups.map(groups::planes).unwrap_or_default()
    }
}

/// Estimates of one view by paths.
struct PathView<'v> {
    method: &'v PathTracer<'v>,
    setting: Setting<'v>,
    neighbourhood: Neighbourhood,
    /// Approximate mean luminance of the view.
    brightness: OnceLock<f64>,
}

impl Estimates for PathView<'_> {
    fn tile(&self, tile: &Window) -> Vec<PixelRecord> {
        self.tile_with_beside(tile).0
    }

    fn tile_with_beside(&self, tile: &Window) -> (Vec<PixelRecord>, Vec<f32>) {
        let mut tracing = self.method.tracing(&self.setting);
        tracing.groups = self.method.groups.map(PathByGroup::new);
        let mut beside = Vec::new();
        let mut of_pixel = |(x, y)| {
            let record = self.pixel([x, y], &mut tracing);
            if let Some(groups) = &tracing.groups {
                groups.samples(&mut beside);
            }
            record
        };
        let records = tile.pixels().map(&mut of_pixel).collect();
        (records, beside)
    }
}

impl PathView<'_> {
    /// Estimates a pixel by paths, until the stopping rule ends it.
    fn pixel(&self, pixel: [u32; 2], tracing: &mut Tracing<'_>) -> PixelRecord {
        let (method, setting) = (self.method, &self.setting);
        let nearby = self.nearby(pixel);
        let parts = method.stop.controlled().parts();
        let mut sum = RgbSum::default();
        if let Some(groups) = &mut tracing.groups {
            groups.begin_pixel();
        }
        let mut moments = vec![Moments::default(); parts.len()];
        (tracing.rays, tracing.gathers) = (0, false);
        let index = u64::from(pixel[1]) << 32 | u64::from(pixel[0]);
        let mut draws = Draws::new(setting.view.seed, Purpose::CameraPath, index);
        let pixel_key = rng::key(setting.view.seed, Purpose::CameraPath, index);
        let (mut looking, mut wanted) = Looking::new(method.stop, nearby.map_or(&[], Nearby::moments));
        let (mut done, mut unmet) = (0, None);
        let (claim, half_width, stop) = loop {
            for k in done..wanted {
                let key = rng::key(pixel_key, Purpose::CameraPath, u64::from(k));
                let radiance = tracing.through(setting, pixel, key, &mut draws);
                sum.add(radiance);
                if let Some(groups) = &mut tracing.groups {
                    groups.end_path();
                }
                parts.iter().zip(&mut moments).for_each(|(part, m)| m.push(part.of(radiance)));
            }
            done = wanted;
            // Outside the film's image no ray leaves the camera.
            let scattering = match nearby {
                Some(nearby) if !tracing.gathers && tracing.rays > 0 => {
                    Scattering::Unmet(*unmet.get_or_insert_with(|| self.importance_unmet(pixel, nearby)))
                }
                _ if tracing.gathers => Scattering::Met,
                _ => Scattering::Unmet(0.0),
            };
            match looking.look(&moments, &sum.scaled(1.0 / f64::from(done)), scattering) {
                Next::Follow(more) => wanted = more,
                Next::End { claim, half_width, stop } => break (claim, half_width, stop),
            }
        };
        let of_features = OF_FEATURES.min(done);
        let features = setting.view.features(setting.tracer, pixel, of_features, pixel_key);
        let of_nearby = nearby.map_or(0, Nearby::rays_per_pixel);
        let half_width = claim.stated(half_width);
        let standard_error = match done {
            // A single path has no estimate of its error.
            1 => f64::NAN,
            _ => moments.iter().map(Moments::standard_error).fold(0.0, f64::max),
        };
        PixelRecord {
            radiance: sum.scaled(1.0 / f64::from(done)).total(),
            standard_error: standard_error as f32,
            claim,
            half_width,
            half_widths: HalfWidths { compensation: half_width, ..HalfWidths::default() },
            stop,
            pairs: u64::from(done),
            rays: tracing.rays + u64::from(of_features) + of_nearby,
            ..features.into()
        }
    }
}

impl PathTracer<'_> {
    fn tracing<'a>(&'a self, setting: &Setting<'a>) -> Tracing<'a> {
        let camera = setting.view.camera;
        let Camera { medium, ref motion, .. } = *camera;
        let scene = setting.tracer.scene();
        Tracing {
            tracer: setting.tracer,
            camera,
            emitters: &self.emitters,
            max_depth: self.max_depth,
            has_media: scene.has_media() || medium.is_some(),
            medium,
            moves: scene.moves() || motion.is_some(),
            batch: SegmentBatch::new(Glass::SolidStops),
            visibility: Vec::new(),
            share: 0.0,
            rays: 0,
            gathers: false,
            seen: Rgb::BLACK,
            groups: None,
        }
    }
}

struct Tracing<'a> {
    tracer: &'a Tracer,
    camera: &'a Camera,
    emitters: &'a EmitterSampler<'a>,
    max_depth: u32,
    has_media: bool,
    /// Medium around the camera, if any.
    medium: Option<MediumId>,
    /// True if the scene depends on time.
    moves: bool,
    batch: SegmentBatch,
    visibility: Vec<f32>,
    /// Time of the path, as a share of the time that the shutter is open.
    share: f32,
    rays: u64,
    /// True if the path met a surface or medium that scatters light.
    gathers: bool,
    /// Radiance found before the path first scattered.
    seen: Rgb,
    /// Radiance by group of lights, if requested.
    groups: Option<PathByGroup<'a>>,
}

impl Tracing<'_> {
    /// Radiance of one path through a pixel, at a time drawn for this path.
    fn through(&mut self, setting: &Setting<'_>, pixel: [u32; 2], key: u64, draws: &mut Draws) -> Rgb {
        let Draws { stream, shutter } = draws;
        let [u, v] = stream.uniform_2();
        let [s, t] = stream.uniform_2();
        self.share = if self.moves { shutter.uniform() } else { 0.0 };
        let beginning = setting.view.beginning_of(pixel, [u, v, s, t], || self.share);
        self.seen(beginning, key, stream)
    }

    /// Radiance of a path from the camera; black where the film shows nothing.
    fn seen(&mut self, beginning: Beginning, key: u64, stream: &mut Stream) -> Rgb {
        let (ray, on_sensor) = match beginning {
            Beginning::Nothing => return Rgb::BLACK,
            Beginning::Ray(ray) => (ray, None),
            Beginning::Sensor(sensor) => {
                let away = Ray::new(sensor.position, sensor.normal);
                (away, Some(GatherPoint::on_sensor(&sensor, self.medium)))
            }
        };
        if self.has_media {
            self.radiance_in_media(ray, on_sensor, key, stream)
        } else {
            self.radiance(ray, on_sensor, key, stream)
        }
    }

    /// Radiance along a camera ray, or of a gather point on a sensor, at which the path then
    /// begins.
    fn radiance(
        &mut self,
        mut ray: Ray,
        mut on_sensor: Option<GatherPoint>,
        key: u64,
        stream: &mut Stream,
    ) -> Rgb {
        let scene = self.tracer.scene();
        let contribution = ContributionKernel::default().within(scene);
        let mut radiance = Rgb::BLACK;
        // Weight of basic radiance.
        let mut weight = Rgb::gray(self.camera.squared_index());
        // Product over the boundaries of glass that the path has crossed.
        let mut ratio = 1.0;
        // Last drawn direction; `None` at first.
        let mut drawn: Option<DrawnDirection> = None;
        for depth in 0..=self.max_depth {
            let key = key.wrapping_add(u64::from(depth));
            let scatter = if let Some(point) = on_sensor.take() {
                Scatter::Gathers(point)
            } else {
                self.rays += 1;
                let Some(hit) = self.tracer.closest_hit_at(&ray, key, self.share) else {
                    if let Some(e) = scene.environment() {
                        let d = ray.direction.normalize();
                        let mis = drawn.map_or(1.0, |drawn| drawn.weight_of_environment(self.emitters, d));
                        let basic = e.radiance(d) * self.camera.basic_of_infinity(ratio);
                        self.found(&mut radiance, LightId::Environment, weight * basic * mis);
                    }
                    break;
                };
                let surface = self.surface(&hit);
                let outgoing = -ray.direction;
                let emitted = self.tracer.emitted(&surface, outgoing);
                if !emitted.is_black() {
                    let mis = drawn.map_or(1.0, |drawn| self.weight_of_hit(&drawn, &surface, &hit, outgoing));
                    self.found(&mut radiance, LightId::Instance(hit.instance), weight * emitted * mis);
                }
                if depth == self.max_depth {
                    break;
                }
                Scatter::at(scene, &surface, outgoing, stream.uniform())
            };
            match scatter {
                Scatter::Specular(specular) => {
                    let Some((next, factor)) = specular.step(stream.uniform_3()) else { break };
                    if let Some(drawn) = &mut drawn {
                        drawn.passage = drawn.passage.beyond(&specular, next.direction);
                    }
                    weight *= factor;
                    ratio *= specular.squared_ratio(next.direction);
                    ray = next;
                }
                Scatter::Gathers(mut point) => {
                    self.gathers = true;
                    weight *= point.weight;
                    point.weight = weight;
                    if let Some((source, sample)) = self.light(stream) {
                        let light = &sample.light;
                        let unoccluded = contribution.unoccluded(&point, light);
                        if !unoccluded.is_black() {
                            let mis = weight_of_light(&sample, point.position, |towards| {
                                point.bsdf.pdf(point.wo, point.frame.to_local(towards))
                            });
                            let free = self.visible(light.apex(), point.position);
                            let begun = Leg { ray: Ray::new(point.position, -light.direction), medium: None };
                            let weight = mis * self.basic_of(light, ratio);
                            let beside = self.through_panes(free, begun, light, (key, depth), stream);
                            let light = self.emitters.light_of(source);
                            self.found(&mut radiance, light, unoccluded * (weight * free));
                            if !beside.is_black() {
                                self.found(&mut radiance, light, unoccluded * beside * weight);
                            }
                        }
                    }
                    let Some(next) = point.bsdf.sample(point.wo, stream.uniform_3()) else { break };
                    let direction = point.frame.to_world(next.wi).normalize();
                    if point.geometric_normal.dot(direction) <= 0.0 {
                        break;
                    }
                    weight *= next.weight;
                    ray = Ray::new(point.position, direction);
                    drawn = Some(DrawnDirection::new(&ray, next.pdf));
                }
            }
            if depth >= CERTAIN_DEPTH {
                let survival = weight.max_channel().min(MAX_SURVIVAL);
                if stream.uniform() >= survival {
                    break;
                }
                weight = weight / survival;
            }
        }
        radiance
    }

    /// Surface point of a hit.
    fn surface(&self, hit: &Hit) -> SurfacePoint {
        self.tracer.scene().surface_point_at(self.share, hit.instance, hit.triangle, hit.barycentric)
    }

    /// Adds the contribution of a light to a path.
    #[inline]
    fn found(&mut self, radiance: &mut Rgb, light: LightId, given: Rgb) {
        *radiance += given;
        if !self.gathers {
            self.seen += given;
        }
        if let Some(groups) = &mut self.groups {
            groups.add(light, given);
        }
    }

    /// Returns basic radiance over radiance of a sampled light: 1 except for light from infinitely
    /// far away.
    fn basic_of(&self, light: &Vpl, ratio: f64) -> f32 {
        if light.kind == VplKind::Directional { self.camera.basic_of_infinity(ratio) } else { 1.0 }
    }

    /// Draws a light from the emitters at the time of the path. Returns the index of its source as
    /// well.
    fn light(&self, stream: &mut Stream) -> Option<(usize, LightSample)> {
        self.emitters.sample_at(self.share, stream.uniform_f64(), stream.uniform_2())
    }

    /// Transmittance by channel from a light through panes, in addition to the straight visibility
    /// `free`; black unless the light is infinitely far away.
    ///
    /// * `begun`: ray from the point to the light.
    /// * `depth`: number of surfaces that the path has met before the point.
    fn through_panes(
        &mut self,
        free: f32,
        begun: Leg,
        light: &Vpl,
        (key, depth): (u64, u32),
        stream: &mut Stream,
    ) -> Rgb {
        if free >= 1.0 || light.kind != VplKind::Directional || !self.tracer.scene().refracts() {
            return Rgb::BLACK;
        }
        let most = self.max_depth.saturating_sub(depth);
        let passing = through_panes(self.tracer, begun, (key, self.share), most, stream, &mut self.rays);
        passing.unwrap_or(Rgb::BLACK)
    }

    /// MIS weight of an emitter that was met along a drawn direction, against drawing it from the
    /// emitters.
    fn weight_of_hit(
        &self,
        drawn: &DrawnDirection,
        surface: &SurfacePoint,
        hit: &Hit,
        outgoing: Vec3,
    ) -> f32 {
        if !drawn.passage.is_straight() {
            return 1.0;
        }
        let distance = drawn.at.distance_squared(surface.position);
        let cos = surface.geometric_normal.dot(outgoing).abs();
        let on_area = self.emitters.pdf_on_triangle_at(self.share, hit.instance, hit.triangle);
        balance(drawn.density, on_area * distance / cos.max(f32::MIN_POSITIVE))
    }

    fn visible(&mut self, apex: crate::accel::Apex, target: Vec3) -> f32 {
        self.rays += 1;
        self.batch.clear();
        self.batch.push_fan(apex, [target]);
        self.tracer.visibility_at(&self.batch, self.share, &mut self.visibility);
        self.visibility[0]
    }
}

/// A direction in which a path was scattered.
#[derive(Clone, Copy, Debug)]
struct DrawnDirection {
    /// Origin of the direction.
    at: Vec3,
    direction: Vec3,
    /// Density of the direction (sr⁻¹).
    density: f32,
    /// Passage of the path since the direction was drawn.
    passage: Passage,
}

impl DrawnDirection {
    /// Direction of a ray, with its density (sr⁻¹).
    fn new(ray: &Ray, density: f32) -> Self {
        Self { at: ray.origin, direction: ray.direction, density, passage: Passage::Straight }
    }

    /// MIS weight of the environment in the direction `met`, against drawing it from the emitters.
    fn weight_of_environment(&self, emitters: &EmitterSampler<'_>, met: Vec3) -> f32 {
        let is_drawn = self.passage.is_straight() || self.passage.is_through_panes(self.direction, met);
        if is_drawn { balance(self.density, emitters.pdf_of_environment(met)) } else { 1.0 }
    }
}

/// MIS weight of a light drawn from the emitters, against meeting it along a direction from
/// `position` of density `pdf` (sr⁻¹).
fn weight_of_light(sample: &LightSample, position: Vec3, pdf: impl FnOnce(Vec3) -> f32) -> f32 {
    let light = &sample.light;
    sample.pdf.map_or(1.0, |of_light| {
        let (towards, jacobian) = if light.kind == VplKind::Directional {
            (-light.direction, 1.0)
        } else {
            let d = light.position - position;
            let towards = d.normalize();
            (towards, d.length_squared() / -light.direction.dot(towards))
        };
        balance(of_light * jacobian, pdf(towards))
    })
}
