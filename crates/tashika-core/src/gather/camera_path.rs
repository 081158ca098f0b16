//! Camera paths: through specular surfaces and media to where light is gathered.
//!
//! A path draws on its way to each surface whether a medium scatters it before ([`Leg::fly`]), and where one
//! does, gathers there:
//!
//! ```text
//! L(x, ω) = T(d) L_surface + ∫₀^d T(t) σ_s ∫ p(ω·ω') L(x + t ω, ω') dω' dt          (W·m⁻²·sr⁻¹)
//! ```
//!
//! Such a gather point has a phase function in the place of a BSDF, and no cosine; its weight is that of
//! the flight, the coefficients and transmittances over the probability of what was drawn. Emission
//! that is seen directly is that of paths that get there. Boundaries that are nothing else are passed.
//!
//! Distances and what else a flight draws come from a stream of the sample's own.
//!
//! # Held to this by
//! `gather::tests`; the suite's `volume_lights`, against closed forms and the path tracer.

use glam::Vec3;

use super::{GatherPoint, Scatter};
use crate::accel::Tracer;
use crate::color::Rgb;
use crate::media::{Leg, MOST_PASSED};
use crate::rng::{Purpose, Stream};
use crate::scene::Camera;

/// Specular surfaces after which a camera path is given up; what it would have seen is missing from
/// the image.
const MAX_CHAIN: u32 = 32;

/// What media do to camera paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Media {
    /// They scatter and absorb.
    Count,
    /// Nothing: what is behind them is looked for.
    SeenThrough,
}

/// What a camera path meets first.
pub(super) struct First {
    /// Length of the way there (m).
    pub distance: f32,
    /// Shading normal on the side of the viewer.
    pub normal: Vec3,
}

/// Where a camera path ends, and what it has seen on the way.
pub(super) struct End {
    pub point: Option<GatherPoint>,
    /// Emission seen, as basic radiance (W·m⁻²·sr⁻¹).
    pub background: Rgb,
    pub first: Option<First>,
}

impl End {
    /// Of a sample that sees nothing.
    pub const NOTHING: Self = Self { point: None, background: Rgb::BLACK, first: None };
}

/// What a camera path is followed with.
#[derive(Clone, Copy)]
pub(super) struct CameraPath<'a> {
    pub tracer: &'a Tracer,
    pub camera: &'a Camera,
    /// When it is: a share of the time that the shutter is open, 0 to 1.
    pub share: f32,
    pub media: Media,
    /// Of the random decisions.
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
        // Product over the boundaries of glass that the path has crossed.
        let mut ratio = 1.0;
        let mut end = End::NOTHING;
        // Surfaces met, boundaries passed in all, and the way so far (m).
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
                    let basic = e.radiance(leg.ray.direction.normalize()) * camera.basic_of_infinity(ratio);
                    end.background += weight * basic;
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
                end.first = Some(First { distance: way, normal });
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
