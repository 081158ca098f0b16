//! Paths that scatter between surfaces as well as at them.
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
//! The maximum number of surfaces is the same as without media. Scattering in a medium and passing
//! an invisible interface do not count as surfaces. Paths in media end by Russian roulette. Its
//! highest survival probability is near one, since light is scattered hundreds of times in a white
//! medium before it leaves.
//!
//! # Limits
//! Samples of a point light *in* a scattering medium have unbounded variance, because of the factor
//! `1/d²`. The mean is correct, but single pixels may be too bright. Equiangular sampling of
//! distances would help.
//!
//! # Held to this by
//! The suite's `media`.

use super::path::{CERTAIN_DEPTH, DrawnDirection, Found, MAX_SURVIVAL, Start, weight_of_light};
use super::tracing::Tracing;
use crate::color::Rgb;
use crate::contribution::ContributionKernel;
use crate::gather::{GatherPoint, Scatter};
use crate::math::{Ray, Vec3};
use crate::media::{Leg, MAX_SURVIVAL_IN_MEDIUM, MOST_PASSED, Scattering, along_segment};
use crate::rng::Stream;
use crate::scene::{LightId, MediumId};
use crate::vpl::Vpl;

/// A path in progress, with its medium.
struct Path {
    leg: Leg,
    /// Weight of basic radiance, by channel.
    weight: Rgb,
    /// Product of `SpecularPoint::squared_ratio` over the boundaries of glass that the path has
    /// crossed.
    ratio: f64,
    /// Last drawn direction; `None` at first.
    drawn: Option<DrawnDirection>,
}

impl Path {
    /// Applies Russian roulette. Returns true if the path survives.
    fn survives(&mut self, most: f32, stream: &mut Stream) -> bool {
        let survival = self.weight.max_channel().min(most);
        let goes_on = stream.uniform() < survival;
        if goes_on {
            self.weight = self.weight / survival;
        }
        goes_on
    }
}

impl Tracing<'_> {
    /// Follows a path along a camera ray, or from a gather point on a sensor.
    pub(super) fn follow_in_media(
        &mut self,
        ray: Ray,
        mut on_sensor: Option<GatherPoint>,
        start: &mut Start,
        found: &mut Found,
    ) {
        let Start { key, share, ref mut stream, .. } = *start;
        let scene = self.tracer.scene();
        let contribution = ContributionKernel::default().within(scene);
        let mut path = Path {
            leg: Leg { ray, medium: self.medium() },
            weight: Rgb::gray(self.camera.squared_index()),
            ratio: 1.0,
            drawn: None,
        };
        // Numbers of surfaces that the path has met, of all its scatterings, and of boundaries
        // passed since the last of these.
        let (mut depth, mut scattered, mut passed) = (0, 0_u32, 0);
        while !path.weight.is_black() {
            // The key is the same along a straight line, and so are the holes in surfaces.
            let key = key.wrapping_add(u64::from(scattered));
            // The surface is `None` for a sensor.
            let (scatter, surface) = if let Some(point) = on_sensor.take() {
                (Scatter::Gathers(point), None)
            } else {
                found.rays += 1;
                let hit = self.tracer.closest_hit_at(&path.leg.ray, key, share);
                let (weight, scattering) = path.leg.fly(scene, hit.as_ref(), path.weight, stream);
                path.weight = weight;
                if let Some(at) = scattering {
                    found.gathers = true;
                    self.light_in_medium(found, (weight, path.ratio), &at, (key, share, depth), stream);
                    let (direction, density) = at.phase.sample(at.before, stream.uniform_2());
                    path.leg.ray = Ray::new(at.place, direction);
                    path.drawn = Some(DrawnDirection::new(&path.leg.ray, density));
                    scattered = scattered.saturating_add(1);
                    passed = 0;
                    if scattered > CERTAIN_DEPTH && !path.survives(MAX_SURVIVAL_IN_MEDIUM, stream) {
                        break;
                    }
                    continue;
                }
                let Some(hit) = hit else {
                    let given =
                        self.from_environment(&path.leg.ray, path.drawn.as_ref(), path.weight, path.ratio);
                    found.add(self.groups, LightId::Environment, given);
                    break;
                };
                let surface = scene.surface_point_at(share, hit.instance, hit.triangle, hit.barycentric);
                let outgoing = -path.leg.ray.direction;
                let at = (&surface, &hit, share);
                let given = self.from_surface(at, outgoing, path.drawn.as_ref(), path.weight);
                found.add(self.groups, LightId::Instance(hit.instance), given);
                if scene.is_boundary(&surface) {
                    path.leg = path.leg.beyond(scene, &surface);
                    passed += 1;
                    if passed > MOST_PASSED {
                        break;
                    }
                    continue;
                }
                if depth == self.max_depth {
                    break;
                }
                (Scatter::at(scene, &surface, outgoing, stream.uniform()), Some(surface))
            };
            let about = path.leg.medium;
            let beyond =
                |direction| surface.map_or(about, |surface| scene.medium_beyond(&surface, direction, about));
            match scatter {
                Scatter::Specular(specular) => {
                    let Some((next, factor)) = specular.step(stream.uniform_3()) else { break };
                    if let Some(drawn) = &mut path.drawn {
                        drawn.passage = drawn.passage.beyond(&specular, next.direction);
                    }
                    path.weight *= factor;
                    path.ratio *= specular.squared_ratio(next.direction);
                    path.leg = Leg { medium: beyond(next.direction), ray: next };
                }
                Scatter::Gathers(mut point) => {
                    found.gathers = true;
                    path.weight *= point.weight;
                    point.weight = path.weight;
                    if let Some((source, sample)) = self.light(share, stream) {
                        let light = &sample.light;
                        let unoccluded = contribution.unoccluded(&point, light);
                        if !unoccluded.is_black() {
                            let mis = weight_of_light(&sample, point.position, |towards| {
                                point.bsdf.pdf(point.wo, point.frame.to_local(towards))
                            });
                            let mis = mis * self.basic_of(light, path.ratio);
                            let medium = beyond(contribution.link(point.position, light).towards_light);
                            let given = unoccluded
                                * self.passing(
                                    found,
                                    (point.position, medium),
                                    light,
                                    (key, share, depth),
                                    mis,
                                    stream,
                                );
                            let light = self.emitters.light_of(source);
                            found.add(self.groups, light, given);
                        }
                    }
                    let Some(next) = point.bsdf.sample(point.wo, stream.uniform_3()) else { break };
                    let direction = point.frame.to_world(next.wi).normalize();
                    if point.geometric_normal.dot(direction) <= 0.0 {
                        break;
                    }
                    path.weight *= next.weight;
                    path.leg = Leg { medium: beyond(direction), ray: Ray::new(point.position, direction) };
                    path.drawn = Some(DrawnDirection::new(&path.leg.ray, next.pdf));
                }
            }
            depth += 1;
            scattered = scattered.saturating_add(1);
            passed = 0;
            if depth > CERTAIN_DEPTH && !path.survives(MAX_SURVIVAL, stream) {
                break;
            }
        }
    }

    /// Adds the contribution of one light, drawn from the emitters, at a scattering point in a
    /// medium.
    fn light_in_medium(
        &mut self,
        found: &mut Found,
        (weight, ratio): (Rgb, f64),
        &Scattering { place, before, medium, phase }: &Scattering,
        at @ (_, share, _): (u64, f32, u32),
        stream: &mut Stream,
    ) {
        let Some((source, sample)) = self.light(share, stream) else { return };
        let light = &sample.light;
        let link = ContributionKernel::default().within(self.tracer.scene()).link(place, light);
        let density = |towards: Vec3| phase.density(before.dot(towards));
        let scattered = density(link.towards_light) * link.geometric;
        let unoccluded = weight * (light.intensity * link.tint) * scattered;
        if unoccluded.is_black() {
            return;
        }
        let mis = weight_of_light(&sample, place, density);
        let mis = mis * self.basic_of(light, ratio);
        let given = unoccluded * self.passing(found, (place, Some(medium)), light, at, mis, stream);
        let light = self.emitters.light_of(source);
        found.add(self.groups, light, given);
    }

    /// Transmittance by channel from a light to a point, times `mis`. `medium` is the medium on the
    /// side of the point that faces the light.
    fn passing(
        &mut self,
        found: &mut Found,
        (place, medium): (Vec3, Option<MediumId>),
        light: &Vpl,
        (key, share, depth): (u64, f32, u32),
        mis: f32,
        stream: &mut Stream,
    ) -> Rgb {
        found.rays += 1;
        let free = self.visible(light.apex(), place, share);
        let mut passing = Rgb::BLACK;
        if free > 0.0 {
            let (left, rays) =
                along_segment(self.tracer, (place, medium), light.apex(), (key, share), stream);
            found.rays += rays;
            passing = left * (mis * free);
        }
        let begun = Leg { ray: Ray::new(place, -light.direction), medium };
        let beside = self.through_panes(free, begun, light, (key, share, depth), stream, &mut found.rays);
        if beside.is_black() { passing } else { passing + beside * mis }
    }
}
