//! Estimates, by paths, of the light at a gather point that a set of VPLs does not carry.
//!
//! # A partition of path space
//! Light reaches a gather point `x` along paths `x, y, z, …` to an emitter. At `x` and at every
//! later surface, scattering is the sum of two kernels:
//!
//! ```text
//! f cos = c + g          after x:   c = ρ/π |n_s·ω|  what its VPLs send out (`vpl::carried_cos`),   g = the rest
//!                        at x:      c = what is summed over VPLs,                                   g = the rest
//! ```
//!
//! The sum over the VPLs of the set, with the clamped geometric term, estimates light that arrives
//! straight at `x` and is scattered there by `c`. This light has the following sources. The sum
//! includes the given share of the light of each:
//!
//! * the kernel `c` of a surface `y`: `κ(d) = min(1, d²/d_c²)` at the distance `d = |x − y|`, with
//!   the clamp distance `d_c`;
//! * an emitting surface or a point light: `κ(d)`;
//! * the environment and directional lights: 1.
//!
//! Every other path belongs to a row of this table, and each row has its own kind of step.
//! "Weighted" means by the balance heuristic. Directions for `c` and caustic directions are drawn
//! from one mixture density.
//!
//! | scattered at `x` by | arrives from | share | step |
//! |---|---|---|---|
//! | `c` | `c` of `y` | `1 − κ` | follow `c` of `x` to `y`; go on from `y` by `(1 − κ) c` |
//! | `c` | `g` of `y` | 1 | follow `c` of `x` to `y`; go on from `y` by `g` |
//! | `c` | an emitter | `1 − κ` | follow `c` of `x`, or draw from the emitters, weighted |
//! | `c` | infinity, through [panes] | 1 | follow `c` of `x`, or draw from the emitters, weighted |
//! | `c` | all else behind specular surfaces | 1 | follow `c` of `x`, or a [caustic] direction |
//! | `g` | anything | 1 | follow `g` of `x`, or draw from the emitters, weighted |
//!
//! "Go on from `y` by `c`" is the same problem again: the light that `y` receives is a sum over the
//! VPLs, of which one is drawn, plus the light that they do not carry, by the table above (Kollig,
//! Keller 2004, for the clamp). There `d_c` is `CLAMPED_BEYOND` times as long, since a nearby VPL
//! causes far more noise when it is drawn than as one term of a sum. The shares of every path sum
//! to one: `κ + (1 − κ)` for `c` after `c`, and 1 for all other paths, none of which VPLs carry.
//!
//! [panes]: crate::gather::through_panes
//! [caustic]: crate::guidance::Caustics
//!
//! Paths fly in media (`media::fly`), and may be scattered there before they meet a surface. At a
//! vertex in a medium, `c` is the whole phase function and `g` is zero. Media attenuate segments.
//!
//! Without a set of VPLs nothing is carried: only the last row applies, and the paths are those of
//! a path tracer.
//!
//! Where sums are too expensive, a few VPLs are [drawn](Draws) at gather points too. These VPLs
//! should represent the light of surfaces alone ([`VplSource`]), so that paths estimate the direct
//! light of emitters: one emitter sample causes far less noise than one of the many VPLs that
//! represent the emitters.
//!
//! # Guarantee
//! If the expectation of the sum over VPLs is the light by `c` (an unbiased trace, solid glass that
//! stops segments), then the expectation over sets and paths is light transport itself. There are
//! two exceptions: paths of more than `max_depth` surfaces, and point lights or directional lights
//! whose light arrives only over specular surfaces, since the sum and the paths both miss it. Held
//! to this by the suite's `light_transport` and `transport_in_media`.

mod choices;
mod descent;
mod drawn;
mod emitter_choice;
mod guided;
mod places;
mod trials;
mod vertex;
mod vpl_choice;

use glam::Vec3;

use crate::accel::{Glass, Tracer};
use crate::bsdf::Bsdf;
use crate::color::Rgb;
use crate::contribution::{ContributionKernel, Link};
use crate::gather::{GatherPoint, Passage, Scatter, through_panes};
use crate::guidance::{Caustics, Directions};
use crate::math::Ray;
use crate::media::{Leg, MAX_SURVIVAL_IN_MEDIUM, MOST_PASSED, Shadows};
use crate::rng::Stream;
use crate::tree::LightTree;
use crate::vpl::{EmitterSampler, LightSample, Vpl, VplKind};
use crate::warp::balance;

pub use choices::Choices;
pub use drawn::{Draws, Numbers};

use choices::Met;
use descent::Descent;
use drawn::Drawn;
use emitter_choice::EmittersAt;
use places::Receiver;
use vertex::{Kernel, Vertex};

/// Depth beyond which Russian roulette may end even the brightest path.
const CERTAIN_DEPTH: u32 = 3;
/// Depth beyond which Russian roulette may end a dark path if there are VPLs. If it began earlier,
/// the few surviving dark paths would be bright. Chosen.
const CERTAIN_BESIDE_VPLS: u32 = 2;
/// Clamp distance beyond the gather point, where one VPL is drawn, as a multiple of the clamp
/// distance at the gather point, where VPLs are summed.
const CLAMPED_BEYOND: f32 = 4.0;
/// Highest survival probability at surfaces beyond [`CERTAIN_DEPTH`].
const MAX_SURVIVAL: f32 = 0.98;

/// Sources of the light that VPLs represent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VplSource {
    /// Emitters and surfaces: the light of both is carried.
    EmittersAndSurfaces,
    /// Surfaces alone: direct light of emitters is not carried.
    Surfaces,
}

/// Scene, emitters and VPLs that light the paths, and the limits of these paths.
#[derive(Clone, Copy, Debug)]
pub struct LightingContext<'a> {
    /// Tracer of rays and segments.
    pub tracer: &'a Tracer,
    /// Distribution of samples on the emitters of the scene.
    pub emitters: &'a EmitterSampler<'a>,
    /// Tree over the VPLs; if `None`, nothing is carried, and paths estimate all light.
    pub lights: Option<&'a LightTree>,
    /// Sources of the light that the VPLs represent.
    pub vpl_source: VplSource,
    /// Learned distributions over `emitters` and `lights`. They must have been learned for the same
    /// emitters and lights, with the same plain probabilities.
    pub choices: Option<&'a Choices>,
    /// Contribution kernel of VPLs, with the clamp distance at gather points.
    pub contribution: ContributionKernel<'a>,
    /// Maximum number of surfaces of a path.
    pub max_depth: u32,
    /// Caustics that guide paths; without them, paths find little light over specular surfaces.
    pub caustics: Option<&'a Caustics>,
}

/// Estimator, by paths, of the light that VPLs do not carry.
#[derive(Debug)]
pub struct Compensation<'a> {
    lit: LightingContext<'a>,
    /// Contribution kernel of VPLs beyond the gather point, with the longer clamp distance there.
    beyond: ContributionKernel<'a>,
    shadows: Shadows,
    rays: u64,
    /// Caustic light of the last path.
    caustic: Caustic,
    /// Directions of caustics at the last vertex.
    directions: Directions,
    /// Approximate luminance of caustics at the last vertex, less two standard errors (W·m⁻²·sr⁻¹).
    importance_caustic: f64,
    /// Estimated sum of squared contributions of VPLs at the last gather point that drew VPLs
    /// (luminance²).
    squares_of_vpls: f64,
    /// Receivers met so far, if they are collected; no lights are drawn then.
    met: Option<Met>,
}

/// Light of emitters over specular surfaces on a path (luminance, W·m⁻²·sr⁻¹).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Caustic {
    /// Estimates from [`LightingContext::caustics`] at the first vertex, and at all later ones.
    pub expected: [f64; 2],
    /// Contribution that the path itself found.
    pub found: f64,
}

/// Last scattering of a path, as needed to weight the light that the path meets next.
struct Way<'a> {
    /// Position of the last vertex.
    from: Vec3,
    /// Unit direction into which the path was scattered.
    along: Vec3,
    /// Density with which this direction was drawn (sr⁻¹).
    density: f32,
    /// True if VPLs carry a share of the light that arrives straight.
    is_carried: bool,
    /// True if the last vertex is the gather point, whose light from VPLs is summed elsewhere.
    sums_vpls: bool,
    /// Distribution of emitter samples at the last vertex.
    emitters: EmittersAt<'a>,
    /// Number of emitter samples at the last vertex.
    drawn: f32,
}

/// Returns the largest channel by absolute value, since weights may be negative.
fn size(c: Rgb) -> f32 {
    c.map(f32::abs).max_channel()
}

impl<'a> Compensation<'a> {
    /// Returns an estimator for this light.
    pub fn new(lit: LightingContext<'a>) -> Self {
        let contribution = lit.contribution;
        let beyond = contribution.clamped(CLAMPED_BEYOND * contribution.clamp_distance());
        Self {
            lit,
            beyond,
            shadows: Shadows::new(Glass::SolidStops),
            rays: 0,
            caustic: Caustic::default(),
            directions: Directions::default(),
            importance_caustic: 0.0,
            squares_of_vpls: 0.0,
            met: None,
        }
    }

    /// Returns the number of rays and segments traced so far.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Returns the caustic light of the last path.
    pub fn caustic(&self) -> Caustic {
        self.caustic
    }

    /// Returns an unbiased estimate of the sum of squared contributions of all VPLs at the last
    /// gather point (luminance²), from the VPLs drawn there. This sum is at least the variance over
    /// sets of independent VPLs.
    pub fn squares_of_vpls(&self) -> f64 {
        self.squares_of_vpls
    }

    /// Returns an unbiased estimate of the light that the sum over VPLs omits at a gather point
    /// (W·m⁻²·sr⁻¹), times the weight of the point. Single estimates may be negative.
    ///
    /// * `summed`: the BSDF with which VPLs are summed there, if there are any.
    /// * `key`: key for the decisions of rays at partly opaque surfaces.
    pub fn estimate(&mut self, point: &GatherPoint, summed: &Bsdf, key: u64, stream: &mut Stream) -> Rgb {
        let first = Vertex::first(point, self.lit.lights.map(|_| summed));
        self.from(first, point, None, key, stream)
    }

    /// Returns an estimate by a path from a gather point, plus the contribution of the lights drawn
    /// there, if any.
    fn from(
        &mut self,
        first: Vertex,
        point: &GatherPoint,
        drawn: Option<Drawn>,
        key: u64,
        stream: &mut Stream,
    ) -> Rgb {
        let mut radiance = drawn.map_or(Rgb::BLACK, |drawn| drawn.straight + drawn.through_panes);
        let mut weight = Rgb::WHITE;
        let found = drawn.map_or(0.0, |drawn| f64::from(drawn.through_panes.luminance()));
        self.caustic = Caustic { found, ..Caustic::default() };
        let lights = self.lit.lights;
        let mut vertex = first;
        // Upper bound on the number of ray keys used so far.
        let mut decided = 0;
        let certain = if lights.is_some() { CERTAIN_BESIDE_VPLS } else { CERTAIN_DEPTH };
        // Survival is relative to the albedo of the first vertex: a path from a dark surface
        // matters as much to its pixel as a path from a bright one.
        let whole = vertex.importance_albedo();
        // Number of earlier vertices, and of surfaces among them.
        let (mut depth, mut surfaces) = (0_u32, 0);
        while surfaces < self.lit.max_depth {
            let Some(rest) = vertex.probability_of_rest() else { break };
            let receiver = vertex.receiver();
            if depth > 0 || drawn.is_none() {
                self.look_for_caustics(&receiver);
            }
            let amplitude = f64::from((weight * vertex.amplitude()).luminance());
            self.caustic.expected[usize::from(depth > 0)] += self.importance_caustic * amplitude;
            if depth > certain {
                let mut survival = (size(weight) / whole * vertex.importance_albedo()).min(1.0);
                if lights.is_some() {
                    // Chosen, like `CERTAIN_BESIDE_VPLS`. Without the root, few of these paths
                    // would survive.
                    survival = survival.sqrt();
                }
                if depth > CERTAIN_DEPTH {
                    let most = if vertex.is_in_medium() { MAX_SURVIVAL_IN_MEDIUM } else { MAX_SURVIVAL };
                    survival = survival.min(most);
                }
                if stream.uniform() >= survival {
                    break;
                }
                weight = weight / survival;
            }
            let drawn = drawn.filter(|_| depth == 0);
            let of_kernel = drawn.map_or_else(|| stream.uniform(), |drawn| drawn.of_path[3]);
            let (kernel, probability) =
                if of_kernel < rest { (Kernel::Rest, rest) } else { (Kernel::Carried, 1.0 - rest) };
            weight = weight / probability;
            let LightingContext { emitters, choices, .. } = self.lit;
            let choice = choices.map(|choices| &choices.emitters);
            let emitters = EmittersAt::new(emitters, choice, &receiver);
            let has_vpl = kernel == Kernel::Carried && !vertex.sums_vpls();
            if let Some(met) = &mut self.met {
                met.by_emitters.push(receiver);
                if has_vpl || (depth == 0 && met.draws_at_points) {
                    met.by_vpls.push(receiver);
                }
            } else if drawn.is_none() {
                if has_vpl {
                    radiance += weight * self.drawn_light(&vertex, &receiver, stream);
                }
                let [straight, through_panes] =
                    self.drawn_emitter(&vertex, kernel, &emitters, key.wrapping_add(decided), stream);
                radiance += weight * (straight + through_panes);
                self.caustic.found += f64::from((weight * through_panes).luminance());
            }
            let of_direction = match drawn {
                Some(Drawn { of_path: [a, b, c, _], .. }) => [a, b, c],
                None => stream.uniform_3(),
            };
            let Some((direction, density, factor)) = self.direction(&vertex, kernel, of_direction) else {
                break;
            };
            weight *= factor;
            if weight.is_black() {
                break;
            }
            let way = Way {
                from: vertex.position(),
                along: direction,
                density,
                is_carried: kernel == Kernel::Carried,
                sums_vpls: vertex.sums_vpls(),
                emitters,
                drawn: drawn.map_or(1.0, |drawn| drawn.draws.emitters as f32),
            };
            let path_key = key.wrapping_add(decided);
            let begun = Leg { ray: Ray::new(vertex.position(), direction), medium: vertex.medium() };
            let Some(next) = self.follow(begun, &way, path_key, &mut weight, &mut radiance, stream) else {
                break;
            };
            decided = decided.wrapping_add(self.lit.max_depth.into());
            surfaces += u32::from(!vertex.is_in_medium());
            depth = depth.saturating_add(1);
            vertex = next;
        }
        let of_point = f64::from(point.weight.luminance());
        self.caustic.found *= of_point;
        self.caustic.expected = self.caustic.expected.map(|expected| expected * of_point);
        point.weight * radiance
    }

    /// Follows a ray to the next vertex, a surface that is not specular or a place in a medium, and
    /// adds the emission met on the way.
    fn follow(
        &mut self,
        mut leg: Leg,
        way: &Way<'_>,
        key: u64,
        weight: &mut Rgb,
        radiance: &mut Rgb,
        stream: &mut Stream,
    ) -> Option<Vertex> {
        let LightingContext { tracer, max_depth, .. } = self.lit;
        let scene = tracer.scene();
        let mut passage = Passage::Straight;
        // Specular surfaces met so far, and boundaries passed since the last of them.
        let (mut step, mut passed) = (0, 0);
        while step < max_depth && passed < MOST_PASSED {
            self.rays += 1;
            let hit = tracer.closest_hit(&leg.ray, key.wrapping_add(step.into()));
            if leg.medium.is_some() {
                // Weights may be negative; the probabilities of a flight depend on their
                // magnitudes.
                let (left, scattering) = leg.fly(scene, hit.as_ref(), weight.map(f32::abs), stream);
                if left.is_black() {
                    return None;
                }
                *weight = left.zip(*weight, f32::copysign);
                if let Some(at) = scattering {
                    let carried = self.carried(way, passage, at.place);
                    let point = GatherPoint::in_medium(&at, Rgb::WHITE);
                    return Some(Vertex::next_in_medium(&point, self.lit.lights.map(|_| 1.0 - carried)));
                }
            }
            let Some(hit) = hit else {
                if let Some(e) = scene.environment() {
                    let d = leg.ray.direction.normalize();
                    let is_straight = passage.is_straight();
                    let share = if is_straight && way.is_carried && self.carries_emitters() {
                        0.0
                    } else if is_straight || passage.is_through_panes(way.along, d) {
                        balance(way.density, way.drawn * way.emitters.pdf_of_environment(d))
                    } else {
                        1.0
                    };
                    *radiance += *weight * e.radiance(d) * share;
                    if !is_straight {
                        self.caustic.found += f64::from((*weight * e.radiance(d)).luminance());
                    }
                }
                return None;
            };
            let surface = scene.surface_point(hit.instance, hit.triangle, hit.barycentric);
            let outgoing = -leg.ray.direction;
            let carried = self.carried(way, passage, surface.position);
            let emitted = self.lit.tracer.emitted(&surface, outgoing);
            if !emitted.is_black() {
                let on_area = way.drawn * way.emitters.pdf_on_triangle(hit.instance, hit.triangle);
                let carried = if self.carries_emitters() { carried } else { 0.0 };
                let share = if passage.is_straight() && on_area > 0.0 {
                    let cos = surface.geometric_normal.dot(outgoing).abs();
                    let squared = way.from.distance_squared(surface.position);
                    (1.0 - carried) * balance(way.density, on_area * squared / cos.max(f32::MIN_POSITIVE))
                } else {
                    1.0
                };
                *radiance += *weight * emitted * share;
                if !passage.is_straight() {
                    self.caustic.found += f64::from((*weight * emitted).luminance());
                }
            }
            if scene.is_boundary(&surface) {
                leg = leg.beyond(scene, &surface);
                passed += 1;
                continue;
            }
            match Scatter::at(scene, &surface, outgoing, stream.uniform()) {
                Scatter::Specular(specular) => {
                    let (next, factor) = specular.step(stream.uniform_3())?;
                    passage = passage.beyond(&specular, next.direction);
                    *weight *= factor;
                    leg = leg.onward(scene, &surface, next);
                    step += 1;
                    passed = 0;
                }
                Scatter::Gathers(mut point) => {
                    *weight *= point.weight;
                    point.medium = scene.medium_beyond(&surface, point.geometric_normal, leg.medium);
                    let left = self.lit.lights.map(|_| 1.0 - carried);
                    return Some(Vertex::next(&point, &surface, left));
                }
            }
        }
        None
    }

    /// Returns the share that VPLs carry of the light from a place to the last vertex.
    fn carried(&self, way: &Way<'_>, passage: Passage, place: Vec3) -> f32 {
        if passage.is_straight() && way.is_carried {
            self.contribution(way.sums_vpls).share(way.from.distance_squared(place))
        } else {
            0.0
        }
    }

    /// Returns true if VPLs represent the light of emitters too.
    fn carries_emitters(&self) -> bool {
        self.lit.vpl_source == VplSource::EmittersAndSurfaces
    }

    /// Returns the contribution kernel of VPLs, with the clamp distance at the gather point or
    /// beyond.
    fn contribution(&self, sums_vpls: bool) -> ContributionKernel<'a> {
        if sums_vpls { self.lit.contribution } else { self.beyond }
    }

    /// Draws one VPL for a vertex, and returns the light that the vertex scatters from it by `c`.
    fn drawn_light(&mut self, vertex: &Vertex, receiver: &Receiver, stream: &mut Stream) -> Rgb {
        let u = stream.uniform_f64();
        let arrives = self.vpl(vertex, receiver, u);
        arrives.map_or(Rgb::BLACK, |arrives| arrives.value * self.passing(&arrives, vertex))
    }

    /// Returns the unoccluded light, scattered by `c`, of the VPL that a uniform number draws.
    fn vpl(&self, vertex: &Vertex, receiver: &Receiver, u: f64) -> Option<Arrives> {
        let lights = self.lit.lights?;
        let contribution = self.contribution(vertex.sums_vpls());
        let descent = Descent { lights, clamp_distance: contribution.clamp_distance(), receiver };
        let choice = self.lit.choices.and_then(|choices| choices.vpls.as_ref());
        let (light, probability) =
            choice.map_or_else(|| descent.draw(u), |choice| choice.draw(&descent, u))?;
        let light = lights.light(light);
        let link = contribution.link(vertex.position(), &light);
        let value = vertex.carried_cos(link.towards_light) * (light.intensity * link.tint) * link.geometric;
        (!value.is_black()).then(|| Arrives { light, value: value / probability as f32, probability })
    }

    /// Returns the light of one emitter sample that arrives straight, as far as VPLs do not carry
    /// it, and the light that arrives through panes. Both are weighted against directions drawn
    /// from the kernel.
    fn drawn_emitter(
        &mut self,
        vertex: &Vertex,
        kernel: Kernel,
        emitters: &EmittersAt<'_>,
        key: u64,
        stream: &mut Stream,
    ) -> [Rgb; 2] {
        let (u, v) = (stream.uniform_f64(), stream.uniform_2());
        let Some(sample) = emitters.sample(u, v) else { return [Rgb::BLACK; 2] };
        let arrives = self.emitter(vertex, &[kernel], &sample, 1.0);
        let free = arrives.as_ref().map_or(Rgb::BLACK, |arrives| self.passing(arrives, vertex));
        let straight = arrives.map_or(Rgb::BLACK, |arrives| arrives.value * free);
        let through_panes = match free {
            Rgb::WHITE => Rgb::BLACK,
            _ => self.through_panes(vertex, &[kernel], &sample, 1.0, key, stream),
        };
        [straight, through_panes]
    }

    /// Returns the light of one of `drawn` emitter samples that arrives through panes (W·m⁻²·sr⁻¹).
    /// It is scattered by the given kernels, and weighted against directions drawn from them.
    fn through_panes(
        &mut self,
        vertex: &Vertex,
        kernels: &[Kernel],
        sample: &LightSample,
        drawn: f32,
        key: u64,
        stream: &mut Stream,
    ) -> Rgb {
        let LightingContext { tracer, max_depth, .. } = self.lit;
        let light = &sample.light;
        if !tracer.scene().refracts() || light.kind != VplKind::Directional {
            return Rgb::BLACK;
        }
        let towards = -light.direction;
        let of_kernel = |kernel: &Kernel| {
            let weight =
                sample.pdf.map_or(1.0, |pdf| balance(drawn * pdf, self.density(vertex, *kernel, towards)));
            vertex.value(*kernel, towards) * light.intensity * weight
        };
        let value = kernels.iter().map(of_kernel).fold(Rgb::BLACK, |sum, value| sum + value);
        if value.is_black() {
            return value;
        }
        let leg = Leg { ray: Ray::new(vertex.position(), towards), medium: vertex.medium() };
        let passing = through_panes(tracer, leg, (key, 0.0), max_depth, stream, &mut self.rays);
        passing.map_or(Rgb::BLACK, |passing| value * passing)
    }

    /// Returns the unoccluded light of one of `drawn` emitter samples that arrives straight, as far
    /// as VPLs do not carry it. It is scattered by the given kernels, and weighted against
    /// directions drawn from them.
    fn emitter(
        &self,
        vertex: &Vertex,
        kernels: &[Kernel],
        sample: &LightSample,
        drawn: f32,
    ) -> Option<Arrives> {
        let light = sample.light;
        // Unclamped.
        let Link { towards_light, geometric, tint, squared_distance } =
            self.lit.contribution.clamped(0.0).link(vertex.position(), &light);
        let intensity = light.intensity * tint;
        let of_kernel = |kernel: &Kernel| {
            let carried = if *kernel == Kernel::Carried && self.carries_emitters() {
                self.contribution(vertex.sums_vpls()).share(squared_distance)
            } else {
                0.0
            };
            if carried >= 1.0 {
                return Rgb::BLACK;
            }
            let value = vertex.value(*kernel, towards_light) * intensity * (geometric * (1.0 - carried));
            if value.is_black() {
                return Rgb::BLACK;
            }
            let weight = sample.pdf.map_or(1.0, |pdf| {
                let jacobian = if light.kind == VplKind::Directional {
                    1.0
                } else {
                    squared_distance / -light.direction.dot(towards_light)
                };
                balance(drawn * pdf * jacobian, self.density(vertex, *kernel, towards_light))
            });
            value * weight
        };
        let value = kernels.iter().map(of_kernel).fold(Rgb::BLACK, |sum, value| sum + value);
        (!value.is_black()).then_some(Arrives { light, value, probability: 0.0 })
    }

    /// Traces the segment to a light, and returns its transmittance.
    fn passing(&mut self, arrives: &Arrives, vertex: &Vertex) -> Rgb {
        self.rays += 1;
        let place = (vertex.position(), vertex.medium());
        self.shadows.trace_one(self.lit.tracer, place, arrives.light.apex())
    }
}

/// Unoccluded radiance from a light at a vertex (W·m⁻²·sr⁻¹).
#[derive(Clone, Copy, Debug)]
struct Arrives {
    light: Vpl,
    value: Rgb,
    /// Probability with which a VPL was drawn among all VPLs; 0 for emitters.
    probability: f64,
}
