//! What a set of VPLs does not carry of the light that a gather point receives, estimated by paths.
//!
//! # A partition of path space
//! Light reaches a gather point `x` along paths `x, y, z, …` to an emitter. At every surface after
//! `x` scattering is a sum of two kernels, at `x` of two as well:
//!
//! ```text
//! f cos = c + g          after x:   c = ρ/π |n_s·ω|  what its VPLs send out (`vpl::carried_cos`),   g = the rest
//!                        at x:      c = what is summed over VPLs,                                   g = the rest
//! ```
//!
//! The sum over VPLs of the set, with the clamped geometric term, is the light that is scattered at
//! `x` by `c` and comes straight from
//!
//! * the `c` of a surface `y`: its share `κ(d) = min(1, d²/d_c²)` at the distance `d = |x − y|`;
//!   `d_c` is the clamp distance;
//! * an emitting surface or a point: the same share; the environment and directional lights: all of
//!   it.
//!
//! Every other path is one of these, and each is estimated by its own kind of step:
//!
//! | scattered at `x` by | arrives from | share | step |
//! |---|---|---|---|
//! | `c` | `c` of `y` | `1 − κ` | follow `c` of `x` to `y`; go on from `y` by `(1 − κ) c` |
//! | `c` | `g` of `y` | 1 | follow `c` of `x` to `y`; go on from `y` by `g` |
//! | `c` | an emitter | `1 − κ` | follow `c` of `x`, or draw from the emitters; weighted by the balance heuristic |
//! | `c` | light from infinity through [panes](crate::gather::through_panes) | 1 | follow `c` of `x`, or draw from the emitters, weighted |
//! | `c` | anything else behind specular surfaces | 1 | follow `c` of `x`, or a [direction of caustics](crate::guidance::Caustics), as one density |
//! | `g` | anything | 1 | follow `g` of `x`, or draw from the emitters, weighted |
//!
//! "Go on from `y` by `c`" is the same problem again: what `y` receives is a sum over the VPLs, of
//! which one is drawn, and what they do not carry, with the table above (Kollig, Keller 2004, for
//! the clamp). There `d_c` is a few times longer: one drawn VPL near by is far noisier than a sum
//! that holds it. So shares sum to one over every path: `κ + (1 − κ)` for `c` after `c`, and 1 for
//! all else, which VPLs do not carry.
//!
//! Paths fly in media (`media::fly`), and may be scattered there before they meet a surface: of a place
//! in a medium the phase function is `c`, and `g` is nothing. Segments lose what media take.
//!
//! Where there is no set of VPLs, nothing is carried: the last row is all there is, and the paths
//! are those of a path tracer.
//!
//! Where sums are too dear, a few VPLs are [drawn](Draws) at gather points, too. They are best those
//! of surfaces alone ([`VplSource`]), so that what comes straight from emitters is not carried: one
//! drawn emitter is far less noisy than one drawn VPL of many that stand for it.
//!
//! # Guarantee
//! With the sum over a set of VPLs whose expectation is the light by `c` (an unbiased trace, solid
//! glass that stops segments), the expectation over sets and paths is light transport itself, but
//! for paths longer than the most surfaces, and for what neither can find: a point or a single
//! direction of light seen by a bent way only. Held to this by the suite's `light_transport` and
//! `transport_in_media`.

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

/// Surfaces after which a path may end however bright it is.
const CERTAIN_DEPTH: u32 = 3;
/// The same beside VPLs. Were dark paths ended before, the few left would be bright. Chosen.
const CERTAIN_BESIDE_VPLS: u32 = 2;
/// How many times as far as at the gather point, where VPLs are summed, they are clamped beyond it,
/// where one of them is drawn.
const CLAMPED_BEYOND: f32 = 4.0;
/// Highest probability of going on beyond these.
const MAX_SURVIVAL: f32 = 0.98;

/// Whose light VPLs stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VplSource {
    /// That of emitters and of surfaces: both are carried.
    EmittersAndSurfaces,
    /// That of surfaces alone.
    Surfaces,
}

/// The light in which paths are followed.
#[derive(Clone, Copy, Debug)]
pub struct LightingContext<'a> {
    /// Rays.
    pub tracer: &'a Tracer,
    /// The emitters of its scene.
    pub emitters: &'a EmitterSampler<'a>,
    /// The VPLs; if there are none, nothing is carried, and paths have all that there is to do.
    pub lights: Option<&'a LightTree>,
    /// Whose light they stand for.
    pub vpl_source: VplSource,
    /// What was learned about which emitters and which VPLs to draw: of these `emitters` and
    /// `lights`, drawn with the same probabilities.
    pub choices: Option<&'a Choices>,
    /// How they are clamped.
    pub contribution: ContributionKernel<'a>,
    /// Most surfaces of a path.
    pub max_depth: u32,
    /// Caustics, which guide paths; of paths without them little light over specular surfaces is found.
    pub caustics: Option<&'a Caustics>,
}

/// Paths of what VPLs do not carry.
#[derive(Debug)]
pub struct Compensation<'a> {
    lit: LightingContext<'a>,
    /// How VPLs are clamped beyond the gather point.
    beyond: ContributionKernel<'a>,
    shadows: Shadows,
    rays: u64,
    /// Of the last path.
    caustic: Caustic,
    /// Directions of caustics at the last vertex, and about their radiance there.
    directions: Directions,
    importance_caustic: f64,
    /// Of the last gather point at which VPLs were drawn.
    squares_of_vpls: f64,
    /// Where surfaces are noted, for which no light is drawn then.
    met: Option<Met>,
}

/// Light of emitters over specular surfaces, on a path (luminance, W·m⁻²·sr⁻¹).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Caustic {
    /// Estimate by [`LightingContext::caustics`], at the first surface and at those beyond.
    pub expected: [f64; 2],
    /// Contribution that the path found.
    pub found: f64,
}

/// How a path came to where it is.
struct Way<'a> {
    /// Where it was scattered last.
    from: Vec3,
    /// The unit direction in which it was scattered.
    along: Vec3,
    /// Density of its direction then (sr⁻¹).
    density: f32,
    /// Whether VPLs carry a share of what comes straight.
    is_carried: bool,
    /// Whether that was the gather point, whose light from VPLs is summed elsewhere.
    sums_vpls: bool,
    /// How emitters were drawn there.
    emitters: EmittersAt<'a>,
    /// And how many.
    drawn: f32,
}

/// Largest channel in size: weights of differences have signs.
fn size(c: Rgb) -> f32 {
    c.map(f32::abs).max_channel()
}

impl<'a> Compensation<'a> {
    /// Paths in this light.
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

    /// Rays and segments traced.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Caustic light of the last path.
    pub fn caustic(&self) -> Caustic {
        self.caustic
    }

    /// An unbiased estimate, by what was drawn at the last gather point, of the sum of the squares of
    /// what each VPL gives there (luminance²): the variance over sets of independent VPLs, at most.
    pub fn squares_of_vpls(&self) -> f64 {
        self.squares_of_vpls
    }

    /// An unbiased estimate of what the sum over VPLs leaves out at a gather point (W·m⁻²·sr⁻¹),
    /// with its weight; single estimates may be negative.
    ///
    /// * `summed`: the BSDF that the VPLs are summed with there, if there are any.
    /// * `key`: of the decisions of rays.
    pub fn estimate(&mut self, point: &GatherPoint, summed: &Bsdf, key: u64, stream: &mut Stream) -> Rgb {
        let first = Vertex::first(point, self.lit.lights.map(|_| summed));
        self.from(first, point, None, key, stream)
    }

    /// An estimate by a path from a gather point, and by what was drawn there, if anything was.
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
        // Decisions of rays so far, at most.
        let mut decided = 0;
        let certain = if lights.is_some() { CERTAIN_BESIDE_VPLS } else { CERTAIN_DEPTH };
        // A path from a dark surface is worth as much to its pixel as one from a bright one.
        let whole = vertex.importance_albedo();
        // Where the path was scattered before, and how many surfaces are among these.
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
                    // Chosen, as that: by the weight itself few of these paths go on.
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

    /// Follows a ray to where it is scattered, at a surface that is not specular or before, and adds what
    /// is emitted on the way.
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
        // Specular surfaces that it has met, and boundaries passed since.
        let (mut step, mut passed) = (0, 0);
        while step < max_depth && passed < MOST_PASSED {
            self.rays += 1;
            let hit = tracer.closest_hit(&leg.ray, key.wrapping_add(step.into()));
            if leg.medium.is_some() {
                // Weights have signs, chances have none.
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

    /// The share that VPLs carry of light that comes to where a way began from a place on it.
    fn carried(&self, way: &Way<'_>, passage: Passage, place: Vec3) -> f32 {
        if passage.is_straight() && way.is_carried {
            self.contribution(way.sums_vpls).share(way.from.distance_squared(place))
        } else {
            0.0
        }
    }

    /// Whether VPLs stand for light of emitters, too.
    fn carries_emitters(&self) -> bool {
        self.lit.vpl_source == VplSource::EmittersAndSurfaces
    }

    /// How the VPLs that light a vertex are clamped.
    fn contribution(&self, sums_vpls: bool) -> ContributionKernel<'a> {
        if sums_vpls { self.lit.contribution } else { self.beyond }
    }

    /// What one VPL, drawn for the vertex, gives by what is carried.
    fn drawn_light(&mut self, vertex: &Vertex, receiver: &Receiver, stream: &mut Stream) -> Rgb {
        let u = stream.uniform_f64();
        let arrives = self.vpl(vertex, receiver, u);
        arrives.map_or(Rgb::BLACK, |arrives| arrives.value * self.passing(&arrives, vertex))
    }

    /// The same, were nothing in its way, of the VPL that a uniform number draws.
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

    /// Light of one sample of the emitters, straight, as far as VPLs do not carry it, and through
    /// panes, weighted against following the kernel.
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

    /// Light of one of `drawn` samples of the emitters that arrives through panes (W·m⁻²·sr⁻¹), scattered
    /// by these kernels and weighted against directions drawn from them.
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

    /// The same by these kernels, were nothing in its way, of one sample of so many.
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

    /// The share of it that arrives.
    fn passing(&mut self, arrives: &Arrives, vertex: &Vertex) -> Rgb {
        self.rays += 1;
        let place = (vertex.position(), vertex.medium());
        self.shadows.trace_one(self.lit.tracer, place, arrives.light.apex())
    }
}

/// What a light gives to where a path is scattered if nothing is in its way (W·m⁻²·sr⁻¹).
#[derive(Clone, Copy, Debug)]
struct Arrives {
    light: Vpl,
    value: Rgb,
    /// With which it was drawn of the VPLs, if it is one.
    probability: f64,
}
