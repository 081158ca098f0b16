//! Samples of points and directions on the scene's emitters, drawn in proportion to power.

use std::collections::BTreeMap;
use std::f32::consts::PI;

use glam::Vec3;

use super::{Vpl, VplKind};
use crate::accel::Tracer;
use crate::color::Rgb;
use crate::math::Instants;
use crate::scene::{AimedMap, Emitter, Environment, InstanceId, LightId, Scene};
use crate::stats::Discrete;
use crate::warp;

/// Light drawn from the emitters: one VPL that is an unbiased estimate of all light that they emit.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// The light; its intensity is already divided by the density.
    pub light: Vpl,
    /// Density: per area (m⁻²) on surfaces, per solid angle (sr⁻¹) for the environment; `None` if
    /// the probability that a ray hits the emitter is zero.
    pub pdf: Option<f32>,
}

/// A source that was drawn, before its position or direction.
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    /// Number of the source, for [`EmitterSampler::light_of`].
    pub source: usize,
    probability: f64,
    /// The rest of the number that selected the source.
    rest: f64,
    v: [f32; 2],
}

/// Approximate position and direction of a source.
#[derive(Clone, Copy, Debug)]
pub(super) enum About {
    /// Position, and unit direction; the latter is zero for light in all directions.
    Near(Vec3, Vec3),
    /// Direction of light from infinity.
    Far(Vec3),
    /// Light from infinity, from all directions.
    Everywhere,
}

#[derive(Clone, Copy, Debug)]
enum Source {
    Triangle { instance: InstanceId, triangle: u32, area: f32, two_sided: bool },
    Punctual(Emitter),
    Environment,
}

/// Distribution over all emitters of a scene, in proportion to power unless stated otherwise.
///
/// Power (W, luminance): `π A L` a side for triangles, `4π I` for points, `I ∫ falloff` for spots,
/// `∫ I dω` for images, `π R² E` for directional light and `4π · π R² L̄` for the environment, with
/// the radius `R` of the scene's sphere.
#[derive(Debug)]
pub struct EmitterSampler<'s> {
    tracer: &'s Tracer,
    scene: &'s Scene,
    sources: Vec<Source>,
    /// Weights of `sources`; probabilities are proportional to them.
    weights: Vec<f64>,
    /// Distribution over `sources`; `None` if no source shines.
    all: Option<Discrete>,
    /// Distribution over the `sources` that are neither points nor single directions.
    extended: Option<Discrete>,
    /// First source of each emissive instance.
    first: BTreeMap<InstanceId, usize>,
    environment: Option<usize>,
    center: Vec3,
    radius: f32,
}

/// Barycentric positions in a triangle at which a textured emission is looked up to estimate its
/// power: corners, centre and midpoints of the edges.
const PROBES: [[f32; 3]; 7] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.5],
    [0.5, 0.0, 0.5],
];

/// Least luminance that is assumed for the weight of a triangle, as a share of the luminance of the
/// brightest triangle of its mesh (or of the texture's factor if all are dark). It is not zero
/// because a texture may shine between the probes.
const DARK_TRIANGLE_SHARE: f32 = 0.02;

impl<'s> EmitterSampler<'s> {
    /// Creates the sampler of the emitters of the tracer's scene.
    pub fn new(tracer: &'s Tracer) -> Self {
        let scene: &Scene = tracer.scene();
        let bounds = scene.bounds();
        let radius = 0.5 * bounds.diagonal();
        let mut sources = Vec::new();
        let mut weights = Vec::new();
        let mut first = BTreeMap::new();
        for (instance, emission) in scene.area_emitters() {
            if emission.radiance.factor.is_black() {
                continue;
            }
            first.insert(instance, sources.len());
            let count = scene.mesh_of(instance).triangles().len() as u32;
            let luminances: Vec<f32> = (0..count)
                .map(|t| {
                    let at = |b| {
                        let p = scene.surface_point(instance, t, b);
                        tracer.emitted(&p, p.geometric_normal).luminance()
                    };
                    if emission.radiance.texture.is_none() {
                        at(PROBES[3])
                    } else {
                        PROBES.iter().map(|&b| at(b)).sum::<f32>() / PROBES.len() as f32
                    }
                })
                .collect();
            let brightest = luminances.iter().copied().fold(0.0, f32::max);
            let whole = emission.radiance.factor.luminance();
            let floor = DARK_TRIANGLE_SHARE * if brightest > 0.0 { brightest } else { whole };
            for (triangle, luminance) in luminances.into_iter().enumerate() {
                let area = area(scene.world_corners(instance, triangle as u32));
                let sides = if emission.two_sided { 2.0 } else { 1.0 };
                let meanwhile = mean_area(scene, instance, triangle as u32).unwrap_or(area);
                weights.push(f64::from(PI * meanwhile * sides * luminance.max(floor)));
                let two_sided = emission.two_sided;
                sources.push(Source::Triangle { instance, triangle: triangle as u32, area, two_sided });
            }
        }
        for e in tracer.emitters() {
            weights.push(f64::from(match &e {
                Emitter::Point { intensity, .. } => 4.0 * PI * intensity.luminance(),
                Emitter::Spot { intensity, falloff, .. } => falloff.solid_angle() * intensity.luminance(),
                Emitter::Image { intensity, beam, .. } => {
                    let map = scene.intensity_maps()[beam.map as usize].map();
                    let full = intensity.zip(map.brightest(), |i, b| if b > 0.0 { i / b } else { 0.0 });
                    (full * map.integral()).luminance()
                }
                Emitter::Directional { irradiance, .. } => PI * radius * radius * irradiance.luminance(),
            }));
            sources.push(Source::Punctual(e));
        }
        let environment = scene.environment().map(|e| {
            weights.push(f64::from(4.0 * PI * PI * radius * radius * e.mean().luminance()));
            sources.push(Source::Environment);
            sources.len() - 1
        });
        let mut sampler = Self {
            tracer,
            scene,
            all: None,
            extended: None,
            sources,
            weights,
            first,
            environment,
            center: bounds.center(),
            radius,
        };
        sampler.distribute();
        sampler
    }

    /// Returns the sampler with the given weights of the two kinds of emitters: first emitters in
    /// the scene, then light from infinity. Within a kind, emitters are drawn in proportion to
    /// power. Both weights must be at least 0; a kind without emitters is never drawn.
    #[must_use]
    pub fn weighted(mut self, kinds: [f64; 2]) -> Self {
        let kind = |source: &Source| match source {
            Source::Environment | Source::Punctual(Emitter::Directional { .. }) => 1,
            Source::Triangle { .. } | Source::Punctual(_) => 0,
        };
        let mut power = [0.0; 2];
        for (source, weight) in self.sources.iter().zip(&self.weights) {
            power[kind(source)] += weight;
        }
        for (source, weight) in self.sources.iter().zip(&mut self.weights) {
            let kind = kind(source);
            if power[kind] > 0.0 {
                *weight *= kinds[kind] / power[kind];
            }
        }
        self.distribute();
        self
    }

    /// Returns the sampler with a probability of at least `share / n` for each of the `n` emitters,
    /// however weak. Emitters are emissive meshes, points, spots, single directions and an
    /// environment. A weak emitter may be the only one that lights some corner.
    ///
    /// * `share`: share of the draws that is distributed equally over the emitters, in `[0, 1]`.
    #[must_use]
    pub fn with_share_for_each(mut self, share: f64) -> Self {
        let mut starts: Vec<usize> = self.first.values().copied().collect();
        let is_one = |source: &Source| !matches!(source, Source::Triangle { .. });
        starts.extend((0..self.sources.len()).filter(|&i| is_one(&self.sources[i])));
        starts.sort_unstable();
        let ends = starts.iter().skip(1).copied().chain([self.sources.len()]);
        let emitters: Vec<_> = starts.iter().zip(ends).map(|(start, end)| *start..end).collect();
        let of = |weights: &[f64]| weights.iter().sum::<f64>();
        let all = of(&self.weights);
        let shining = emitters.iter().filter(|range| of(&self.weights[(*range).clone()]) > 0.0).count();
        for range in emitters {
            let weights = &mut self.weights[range];
            let own = of(weights);
            if own > 0.0 {
                let more = share * all / (shining as f64 * own);
                weights.iter_mut().for_each(|weight| *weight *= 1.0 - share + more);
            }
        }
        self.distribute();
        self
    }

    fn distribute(&mut self) {
        let is_extended = |source: &Source| !matches!(source, Source::Punctual(_));
        let extended = self.sources.iter().zip(&self.weights);
        self.extended = Discrete::new(extended.map(|(s, &w)| if is_extended(s) { w } else { 0.0 }));
        self.all = Discrete::new(self.weights.iter().copied());
    }

    /// Returns true if no source shines.
    pub fn is_empty(&self) -> bool {
        self.all.is_none()
    }

    /// Returns the centre and radius of the sphere around the scene (m).
    pub fn sphere(&self) -> (Vec3, f32) {
        (self.center, self.radius)
    }

    /// Draws a sample from all emitters; `u` selects the emitter, `v` the position on it. `None` if
    /// no source shines.
    pub fn sample(&self, u: f64, v: [f32; 2]) -> Option<LightSample> {
        self.sample_source(u, v).map(|(_, sample)| sample)
    }

    /// Draws a sample from all emitters at a time: a `share`, from 0 to 1, of the shutter interval.
    /// Moving emitters are chosen in proportion to their mean power at the ends and in the middle
    /// of the interval. Also returns the number of the source, for [`light_of`](Self::light_of).
    pub fn sample_at(&self, share: f32, u: f64, v: [f32; 2]) -> Option<(usize, LightSample)> {
        let choice = self.choose(u, v)?;
        Some((choice.source, self.draw(share, &choice)))
    }

    /// Chooses the source of a sample of [`sample_at`](Self::sample_at), which
    /// [`draw`](Self::draw) then draws.
    #[inline]
    pub fn choose(&self, u: f64, v: [f32; 2]) -> Option<Choice> {
        let (source, probability, rest) = self.all.as_ref()?.sample(u);
        Some(Choice { source, probability, rest, v })
    }

    /// Reads ahead for [`draw`](Self::draw), in [`Environment::READS`] steps. A step needs the read
    /// of the step before.
    #[inline]
    pub fn read_ahead(&self, choice: &Choice, step: usize) {
        if let Some(e) = self.scene.environment()
            && self.environment == Some(choice.source)
        {
            e.read_ahead(choice.v, step);
        }
    }

    /// Draws the sample of a choice at a time.
    pub fn draw(&self, share: f32, &Choice { source, probability, rest, v }: &Choice) -> LightSample {
        self.draw_from_at(share, source, probability, rest, v)
    }

    /// Returns the light to which a source belongs.
    pub fn light_of(&self, source: usize) -> LightId {
        match self.sources[source] {
            Source::Triangle { instance, .. } => LightId::Instance(instance),
            Source::Punctual(_) => {
                let end = self.environment.unwrap_or(self.sources.len());
                LightId::Emitter((source + self.scene.emitters().len() - end) as u32)
            }
            Source::Environment => LightId::Environment,
        }
    }

    /// Draws a sample like [`sample`](Self::sample), and returns it with the number of its source.
    pub(super) fn sample_source(&self, u: f64, v: [f32; 2]) -> Option<(usize, LightSample)> {
        self.sample_at(Instants::STILL, u, v)
    }

    /// Draws a sample from emitting surfaces and the environment only.
    pub fn sample_extended(&self, u: f64, v: [f32; 2]) -> Option<LightSample> {
        self.sample_extended_at(Instants::STILL, u, v)
    }

    /// Draws a sample from emitting surfaces and the environment only, at a time as in
    /// [`sample_at`](Self::sample_at).
    pub fn sample_extended_at(&self, share: f32, u: f64, v: [f32; 2]) -> Option<LightSample> {
        let (source, probability, rest) = self.extended.as_ref()?.sample(u);
        Some(self.draw_from_at(share, source, probability, rest, v))
    }

    /// Returns true if any source shines that is neither a point nor a single direction.
    pub fn has_extended(&self) -> bool {
        self.extended.is_some()
    }

    /// Returns the intensity maps of emitters with an image.
    pub fn maps(&self) -> &[AimedMap] {
        self.scene.intensity_maps()
    }

    /// Returns the points, spots, images and directional lights. Each of them is exactly one VPL.
    pub fn punctual(&self) -> impl Iterator<Item = Vpl> + '_ {
        self.tracer.emitters().map(|emitter| punctual(&emitter))
    }

    /// Returns the density with which [`EmitterSampler::sample`] draws a point on one emitting side
    /// of a triangle (m⁻²).
    pub fn pdf_on_triangle(&self, instance: InstanceId, triangle: u32) -> f32 {
        self.pdf_on_triangle_at(Instants::STILL, instance, triangle)
    }

    /// Returns the density with which [`EmitterSampler::sample_at`] draws a point on one emitting
    /// side of a triangle (m⁻²) at that time.
    pub fn pdf_on_triangle_at(&self, share: f32, instance: InstanceId, triangle: u32) -> f32 {
        let (Some(all), Some(first)) = (&self.all, self.first.get(&instance)) else { return 0.0 };
        let i = first + triangle as usize;
        match self.sources[i] {
            Source::Triangle { area, two_sided, .. } => {
                let area = self.area_at(share, instance, triangle, area);
                all.probability(i) as f32 / (area * if two_sided { 2.0 } else { 1.0 })
            }
            Source::Punctual(_) | Source::Environment => 0.0,
        }
    }

    /// Returns the area of a triangle at a time (m²); this is `still` if the triangle does not
    /// move.
    fn area_at(&self, share: f32, instance: InstanceId, triangle: u32, still: f32) -> f32 {
        match self.scene.motion_of(instance) {
            None => still,
            Some(_) => area(self.scene.world_corners_at(share, instance, triangle)),
        }
    }

    /// Returns the density with which [`EmitterSampler::sample`] draws a direction of the
    /// environment (sr⁻¹).
    pub fn pdf_of_environment(&self, direction: Vec3) -> f32 {
        match (&self.all, self.environment, self.scene.environment()) {
            (Some(all), Some(i), Some(e)) => all.probability(i) as f32 * e.pdf(direction),
            _ => 0.0,
        }
    }

    /// Returns the probability with which [`EmitterSampler::sample`] draws each source: an emitting
    /// triangle, a point, a spot, a single direction, or the environment.
    pub(super) fn probabilities(&self) -> impl Iterator<Item = f64> + '_ {
        self.all.iter().flat_map(|all| (0..all.len()).map(|i| all.probability(i)))
    }

    /// Returns the approximate position and direction of a source.
    pub(super) fn about(&self, source: usize) -> About {
        match self.sources[source] {
            Source::Triangle { instance, triangle, .. } => {
                let [a, b, c] = self.scene.world_corners(instance, triangle);
                About::Near((a + b + c) / 3.0, (b - a).cross(c - a).normalize_or_zero())
            }
            Source::Punctual(Emitter::Point { position, .. }) => About::Near(position, Vec3::ZERO),
            Source::Punctual(
                Emitter::Spot { position, axis, .. } | Emitter::Image { position, axis, .. },
            ) => About::Near(position, axis),
            Source::Punctual(Emitter::Directional { direction, .. }) => About::Far(direction),
            Source::Environment => About::Everywhere,
        }
    }

    /// Returns the source of a triangle of an emissive instance.
    pub(super) fn source_of(&self, instance: InstanceId, triangle: u32) -> Option<usize> {
        self.first.get(&instance).map(|first| first + triangle as usize)
    }

    pub(super) fn environment(&self) -> Option<&Environment> {
        self.scene.environment()
    }

    /// Draws a sample from one source that was selected with the given probability. `rest` selects
    /// the side of a triangle, `v` the position.
    pub(super) fn draw_from(&self, source: usize, probability: f64, rest: f64, v: [f32; 2]) -> LightSample {
        self.draw_from_at(Instants::STILL, source, probability, rest, v)
    }

    fn draw_from_at(
        &self,
        share: f32,
        source: usize,
        probability: f64,
        rest: f64,
        v: [f32; 2],
    ) -> LightSample {
        let probability = probability as f32;
        match self.sources[source] {
            Source::Triangle { instance, triangle, area, two_sided } => {
                let b = warp::triangle(v);
                let area = self.area_at(share, instance, triangle, area);
                let p = self.scene.surface_point_at(share, instance, triangle, b);
                let is_unseen = self.scene.shines_unseen(instance);
                // The probability that a ray meets a partly transparent surface is its opacity.
                let opacity = if is_unseen { 1.0 } else { self.scene.opacity(instance, triangle, b) };
                let back = two_sided && rest < 0.5;
                let normal = if back { -p.geometric_normal } else { p.geometric_normal };
                let pdf = probability / (area * if two_sided { 2.0 } else { 1.0 });
                let light = Vpl {
                    position: p.leave(normal),
                    direction: normal,
                    intensity: self.tracer.emitted(&p, normal) * (opacity / pdf),
                    kind: VplKind::Oriented,
                };
                LightSample { light, pdf: (!is_unseen).then_some(pdf) }
            }
            Source::Punctual(e) => {
                let mut light = punctual(&e);
                light.intensity = light.intensity / probability;
                LightSample { light, pdf: None }
            }
            Source::Environment => {
                let e = self.scene.environment().expect("a source of this kind needs one");
                let (towards, pdf) = e.sample(v);
                towards_environment(e, towards, probability * pdf)
            }
        }
    }
}

/// Returns the mean area of a moving triangle (m²); `None` if it does not move. A triangle may have
/// no area at one time and shine at others.
fn mean_area(scene: &Scene, instance: InstanceId, triangle: u32) -> Option<f32> {
    scene.motion_of(instance)?;
    let times = [0.0, Instants::STILL, 1.0];
    let sum: f32 = times.map(|share| area(scene.world_corners_at(share, instance, triangle))).iter().sum();
    Some(sum / times.len() as f32)
}

/// Returns the area of a triangle (m²), computed in double precision. The fourth power of a length
/// leaves the range of `f32`: the area would be zero below 10⁻¹² m and infinite above 10⁹ m.
fn area(w: [Vec3; 3]) -> f32 {
    let [e1, e2] = [w[1] - w[0], w[2] - w[0]].map(Vec3::as_dvec3);
    (0.5 * e1.cross(e2).length()) as f32
}

/// Returns light of the environment from a unit direction that was drawn with density `pdf` (sr⁻¹).
pub(super) fn towards_environment(e: &Environment, towards: Vec3, pdf: f32) -> LightSample {
    let intensity = if pdf > 0.0 { e.radiance(towards) / pdf } else { Rgb::BLACK };
    let light = Vpl { position: Vec3::ZERO, direction: -towards, intensity, kind: VplKind::Directional };
    LightSample { light, pdf: Some(pdf) }
}

fn punctual(e: &Emitter) -> Vpl {
    match *e {
        Emitter::Point { position, intensity } => {
            Vpl { position, direction: Vec3::ZERO, intensity, kind: VplKind::Omni }
        }
        Emitter::Spot { position, axis, intensity, falloff } => {
            Vpl { position, direction: axis, intensity, kind: VplKind::Spot(falloff) }
        }
        Emitter::Image { position, axis, intensity, beam } => {
            Vpl { position, direction: axis, intensity, kind: VplKind::Image(beam) }
        }
        Emitter::Directional { direction, irradiance } => {
            Vpl { position: Vec3::ZERO, direction, intensity: irradiance, kind: VplKind::Directional }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_of_all_sizes_have_an_area() {
        for size in [1e-18_f32, 1e-12, 1.0, 1e12, 1e18] {
            let found = area([Vec3::ZERO, Vec3::X * size, Vec3::Y * size]);
            // Each number is rounded once.
            assert!((found / (0.5 * size * size) - 1.0).abs() < 4.0 * f32::EPSILON, "{size:e}: {found:e}");
        }
    }
}
