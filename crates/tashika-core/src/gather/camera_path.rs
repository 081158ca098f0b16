//! Camera paths: through specular surfaces and media to a gather point.
//!
//! A path may be scattered by a medium on its way to each surface ([`Leg::fly`]), and then gathers
//! there:
//!
//! ```text
//! L(x, ω) = T(d) L_surface + ∫₀^d T(t) σ_s ∫ p(ω·ω') L(x + t ω, ω') dω' dt          (W·m⁻²·sr⁻¹)
//! ```
//!
//! Such a gather point has a phase function instead of a BSDF, and no cosine. Its weight is that of
//! the flight: the scattering coefficient times the transmittance, over the probability of the
//! draw. Directly visible emission is added by the paths that reach it without being scattered.
//! Surfaces that are only boundaries of media are passed.
//!
//! Distances and other draws of a flight come from a separate stream for each sample.
//!
//! # Held to this by
//! `gather::tests`; the suite's `volume_lights`, against closed forms and the path tracer.

use super::{FirstSurface, GatherPoint, Scatter, SkySample};
use crate::accel::Tracer;
use crate::color::Rgb;
use crate::media::{Leg, MOST_PASSED};
use crate::rng::{self, Purpose, Stream};
use crate::scene::Camera;

/// Number of specular surfaces after which a camera path ends; the light beyond is missing from the
/// image.
const MAX_CHAIN: u32 = 32;

/// Effect of media on camera paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Media {
    /// They scatter and absorb.
    Count,
    /// No effect: paths go on to the surfaces behind media.
    SeenThrough,
}

/// End of a camera path, and the emission seen on the way.
pub(super) struct End {
    pub point: Option<GatherPoint>,
    /// Emission seen, as basic radiance (W·m⁻²·sr⁻¹).
    pub background: Rgb,
    pub first: Option<FirstSurface>,
    /// End in the sky, whose throughput is that of basic radiance.
    pub sky: Option<SkySample>,
}

impl End {
    /// End of a sample that sees nothing.
    pub const NOTHING: Self = Self { point: None, background: Rgb::BLACK, first: None, sky: None };
}

/// Inputs of a camera path.
#[derive(Clone, Copy)]
pub(super) struct CameraPath<'a> {
    pub tracer: &'a Tracer,
    pub camera: &'a Camera,
    /// Time as a share of the shutter interval, 0 to 1.
    pub share: f32,
    pub media: Media,
    /// Key of the random decisions.
    pub key: u64,
}

impl CameraPath<'_> {
    /// Follows a camera ray.
    ///
    /// * `choices`: four uniform numbers for each surface.
    pub fn follow(self, mut leg: Leg, choices: impl Fn(u32) -> [f32; 4]) -> End {
        let Self { tracer, camera, share, media, key } = self;
        let scene = tracer.scene();
        let mut stream = Stream::new(key, Purpose::Gather, 0);
        let mut weight = Rgb::WHITE;
        // Product of the squared index ratios at the boundaries of glass that the path has crossed.
        let mut ratio = 1.0;
        let mut specular_way = 0;
        let mut end = End::NOTHING;
        // Surfaces met, boundaries passed in all, and length of the path so far (m).
        let (mut bounce, mut passed, mut way) = (0, 0, 0.0);
        while bounce < MAX_CHAIN && passed < MOST_PASSED {
            let hit = tracer.closest_hit_at(&leg.ray, key.wrapping_add(u64::from(bounce)), share);
            if media == Media::Count {
                let (left, scattering) = leg.fly(scene, hit.as_ref(), weight, &mut stream);
                if left.is_black() {
                    break;
                }
                if let Some(at) = scattering {
                    end.point = Some(GatherPoint::in_medium(&at, left));
                    break;
                }
                weight = left;
            }
            let Some(hit) = hit else {
                if let Some(e) = scene.environment() {
                    let direction = leg.ray.direction.normalize();
                    let of_infinity = camera.basic_of_infinity(ratio);
                    end.background += weight * (e.radiance(direction) * of_infinity);
                    let throughput = weight.luminance() * of_infinity;
                    end.sky = Some(SkySample { direction, throughput, way: specular_way });
                }
                break;
            };
            way += hit.t;
            let surface = scene.surface_point_at(share, hit.instance, hit.triangle, hit.barycentric);
            let outgoing = -leg.ray.direction;
            end.background += weight * tracer.emitted(&surface, outgoing);
            if scene.is_boundary(&surface) {
                leg = leg.beyond(scene, &surface);
                passed += 1;
                continue;
            }
            if end.first.is_none() {
                let (_, normal) = surface.normals_seen_from(outgoing);
                end.first = Some(FirstSurface { distance: way, normal });
            }
            let [a, b, c, choice] = choices(bounce);
            match Scatter::at(scene, &surface, outgoing, choice) {
                Scatter::Gathers(mut point) => {
                    point.weight *= weight;
                    point.medium = scene.medium_beyond(&surface, point.geometric_normal, leg.medium);
                    end.point = Some(point);
                    break;
                }
                Scatter::Specular(specular) => {
                    let Some((next, factor)) = specular.step([a, b, c]) else { break };
                    weight *= factor;
                    ratio *= specular.squared_ratio(next.direction);
                    let normal = surface.geometric_normal;
                    let transmits = normal.dot(outgoing) * normal.dot(next.direction) < 0.0;
                    let step = (hit.instance.index() as u64) << 1 | u64::from(transmits);
                    specular_way = rng::key(specular_way, Purpose::Gather, step);
                    if weight.is_black() {
                        break;
                    }
                    leg = leg.onward(scene, &surface, next);
                }
            }
            bounce += 1;
        }
        end
    }
}
