//! Camera paths through media: a path draws on its way to each surface whether it is scattered before
//! ([`fly`]), and where it is, gathers there.
//!
//! ```text
//! L(x, ω) = T(d) L_surface + ∫₀^d T(t) σ_s ∫ p(ω·ω') L(x + t ω, ω') dω' dt          (W·m⁻²·sr⁻¹)
//! ```
//!
//! The gather point has a phase function in the place of a BSDF, and no cosine; its weight is that of
//! the flight, the coefficients and transmittances over the probability of what was drawn. Emission
//! that is seen directly is that of paths that get there. Boundaries that are nothing else are passed.
//!
//! Distances and what else a flight draws come from a stream of the sample's own.
//!
//! # Held to this by
//! The suite's `volume_lights`, against closed forms and the path tracer.

use super::{End, First, GatherPoint, MAX_CHAIN, Scatter};
use crate::accel::Tracer;
use crate::color::Rgb;
use crate::math::Ray;
use crate::media::{Flight, MOST_PASSED, fly};
use crate::rng::{Purpose, Stream};
use crate::scene::MediumId;

/// Follows a camera ray that begins in a medium, as [`super::follow`].
pub(super) fn follow(
    tracer: &Tracer,
    share: f32,
    (mut ray, mut medium): (Ray, Option<MediumId>),
    key: u64,
    choices: impl Fn(u32) -> [f32; 4],
) -> End {
    let scene = tracer.scene();
    let mut stream = Stream::new(key, Purpose::Gather, 0);
    let mut weight = Rgb::WHITE;
    let mut end = End::NOTHING;
    // Surfaces met, boundaries passed in all, and the way so far (m).
    let (mut bounce, mut passed, mut way) = (0, 0, 0.0);
    while bounce < MAX_CHAIN && passed < MOST_PASSED {
        let hit = tracer.closest_hit_at(&ray, key.wrapping_add(u64::from(bounce)), share);
        if let Some(id) = medium
            && let filling = &scene.media()[id.index()]
            && !filling.is_clear()
        {
            let distance = hit.map_or(f32::INFINITY, |hit| hit.t);
            match fly(filling, weight, &ray, distance, &mut stream) {
                Flight::Passed { weight: left } => weight = left,
                Flight::Scattered { after, weight } => {
                    let place = ray.at(after);
                    if !weight.is_black() {
                        let point = GatherPoint::in_medium(place, ray.direction, filling.phase, id, weight);
                        end.point = Some(point);
                    }
                    break;
                }
            }
            if weight.is_black() {
                break;
            }
        }
        let Some(hit) = hit else {
            if let Some(e) = scene.environment() {
                end.background += weight * e.radiance(ray.direction.normalize());
            }
            break;
        };
        way += hit.t;
        let surface = scene.surface_point_at(share, hit.instance, hit.triangle, hit.barycentric);
        let outgoing = -ray.direction;
        end.background += weight * scene.emitted(&surface, outgoing);
        if scene.is_boundary(&surface) {
            medium = scene.medium_beyond(&surface, ray.direction, medium);
            ray = Ray::new(surface.leave(ray.direction), ray.direction);
            passed += 1;
            continue;
        }
        if end.first.is_none() {
            let (_, normal) = surface.normals_seen_from(outgoing);
            end.first = Some(First { distance: way, normal });
        }
        let [a, b, c, choice] = choices(bounce);
        match Scatter::at(scene, &surface, outgoing, choice) {
            Scatter::Gathers(mut point) => {
                point.weight *= weight;
                point.medium = scene.medium_beyond(&surface, point.geometric_normal, medium);
                end.point = Some(point);
                break;
            }
            Scatter::Specular(specular) => {
                let Some((next, factor)) = specular.step([a, b, c]) else { break };
                weight *= factor;
                if weight.is_black() {
                    break;
                }
                medium = scene.medium_beyond(&surface, next.direction, medium);
                ray = next;
            }
        }
        bounce += 1;
    }
    end
}
