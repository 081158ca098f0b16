//! Interaction of a light path with a surface: the VPL that the path creates there, and its
//! continuation. [`trace`](super::trace) describes the purpose of both.

use std::f32::consts::PI;

use glam::Vec3;

use super::caustic::Arrival;
use super::walk::Trail;
use super::{Vpl, VplKind, Way, carried_cos};
use crate::bsdf::{Bsdf, Lobe};
use crate::color::Rgb;
use crate::math::Frame;
use crate::rng::Stream;
use crate::scene::SurfacePoint;
use crate::warp;

/// Creates a VPL for the flux that a part of a surface diffusely reflects or transmits.
///
/// * `flux`: flux, scaled to the basic radiance that viewers see ([`Scattered::basic`]).
/// * `way`, `caustic`: the way of the flux, and its arrival if it came only over specular surfaces.
pub(super) fn leave(
    point: &SurfacePoint,
    bsdf: &Bsdf,
    through: bool,
    incoming: Vec3,
    flux: Rgb,
    (way, caustic): (Way, Option<Arrival>),
    trail: &mut Trail,
) {
    let carried = carried_cos(point, bsdf, incoming);
    if carried.is_black() {
        return;
    }
    let (normal, _) = point.normals_towards(if through { -incoming } else { incoming });
    let intensity = flux * carried / normal.dot(incoming).abs();
    trail.diffuse += f64::from(intensity.luminance() * PI);
    trail.caustics.extend(caustic.map(|arrival| arrival.leaving(trail.lights.len() as u32)));
    let position = point.leave(normal);
    trail.push(Vpl { position, direction: normal, intensity, kind: VplKind::Oriented }, way);
}

/// Continuation of a light path beyond a surface.
pub(super) struct Scattered {
    /// Unit direction in which the path continues.
    pub(super) direction: Vec3,
    /// Factor by which the flux is multiplied.
    pub(super) factor: Rgb,
    /// Specular lobe that the path follows; `None` if the continuation is not specular.
    pub(super) specular: Option<Lobe>,
    /// Factor by which the ratio of basic radiance to flux changes at the surface.
    pub(super) basic: f64,
}

/// Returns [`Scattered::basic`]: `1/η²` for light that enters glass of index `η`, and the inverse
/// for light that leaves it. Viewers see *basic* radiance, `L/η²` (Nicodemus 1963), whereas flux
/// does not change ([`crate::bsdf::Glass`]).
fn basic_after(bsdf: &Bsdf, lobe: Lobe, is_entering: bool) -> f64 {
    match bsdf {
        Bsdf::Glass(glass) if lobe == Lobe::SpecularTransmission => glass.squared_ratio(!is_entering),
        _ => 1.0,
    }
}

/// Draws the continuation of a path at a part of a surface, from its complete scattering.
pub(super) fn goes_on(
    point: &SurfacePoint,
    bsdf: &Bsdf,
    through: bool,
    incoming: Vec3,
    s: &mut Stream,
) -> Option<Scattered> {
    if bsdf.is_specular() {
        reflected_or_bent(point, bsdf, incoming, s)
    } else {
        scattered(point, bsdf, through, incoming, s)
    }
}

/// Draws the continuation of a path at a mirror or glass.
fn reflected_or_bent(point: &SurfacePoint, bsdf: &Bsdf, incoming: Vec3, s: &mut Stream) -> Option<Scattered> {
    let (ng, ns) = (point.geometric_normal, point.shading_normal);
    // Light is reflected or refracted only if both normals are on the same side as the arriving
    // light.
    let (cos_ng, cos_ns) = (ng.dot(incoming), ns.dot(incoming));
    if cos_ng * cos_ns <= 0.0 {
        return None;
    }
    let frame = point.frame(ns);
    let sample = bsdf.sample(frame.to_local(incoming), s.uniform_3())?;
    let direction = frame.to_world(sample.wi).normalize();
    let (out_ng, out_ns) = (ng.dot(direction), ns.dot(direction));
    let adjoint = (cos_ns * out_ng) / (cos_ng * out_ns);
    (out_ng * out_ns > 0.0).then(|| Scattered {
        direction,
        factor: sample.weight * adjoint,
        specular: Some(sample.lobe),
        basic: basic_after(bsdf, sample.lobe, cos_ng > 0.0),
    })
}

/// Share of directions that are drawn by the cosine with the geometric normal if the shading normal
/// differs from it.
const BY_GEOMETRY: f32 = 0.5;

/// Draws the continuation of a path at any other surface. The kernel is that of a viewer in the new
/// direction:
///
/// ```text
/// Φ' = Φ f(ω', ω) |n_s·ω| |n_g·ω'| / (|n_g·ω| p(ω'))
/// ```
///
/// (Veach 1997, section 5.3; `n_s` as [seen from](SurfacePoint::normals_seen_from) `ω'`).
/// Directions are drawn around both the shading normal *and* the geometric normal, since directions
/// in front of only one of the two carry light as well.
fn scattered(
    point: &SurfacePoint,
    bsdf: &Bsdf,
    through: bool,
    incoming: Vec3,
    s: &mut Stream,
) -> Option<Scattered> {
    let (ng, ns) = point.normals_towards(incoming);
    // Transmitted light is handled as reflected light, mirrored to the other side of the surface.
    let mirrored = Vec3::new(1.0, 1.0, if through { -1.0 } else { 1.0 });
    let by_geometry = Frame::about(if through { -ng } else { ng });
    let by_shading = point.frame(ns);
    let wo = by_shading.to_local(incoming);
    let share = match (matches!(bsdf, Bsdf::Lambert(_)) || wo.z <= 0.0, ng == ns) {
        (true, _) => 1.0,
        (false, true) => 0.0,
        (false, false) => BY_GEOMETRY,
    };
    let (choice, u) = (s.uniform(), s.uniform_3());
    let direction = if choice < share {
        by_geometry.to_world(warp::cosine_hemisphere([u[1], u[2]]))
    } else {
        by_shading.to_world(bsdf.sample(wo, u)?.wi * mirrored)
    };
    let direction = direction.normalize();
    let cos = by_geometry.n.dot(direction);
    if cos <= 0.0 {
        return None;
    }
    let mut density = share * warp::cosine_hemisphere_pdf(cos);
    if share < 1.0 {
        density += (1.0 - share) * bsdf.pdf(wo, by_shading.to_local(direction) * mirrored);
    }
    let (_, seen) = point.normals_seen_from(direction);
    let frame = point.frame(if through { -seen } else { seen });
    let viewer = frame.to_local(direction) * mirrored;
    let kernel = bsdf.eval_cos(viewer, frame.to_local(incoming));
    let factor = kernel * (cos / (ng.dot(incoming) * density));
    factor.is_valid().then_some(Scattered { direction, factor, specular: None, basic: 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Clearcoat, CoatModel, Lambert, Layered, Plastic, Sheen};
    use crate::rng::Purpose;
    use crate::scene::{InstanceId, TurnedAway};
    use crate::stats::Moments;

    /// Compares the light scattered into part of the directions with the integral of the kernel
    /// over that part. Both agree regardless of the sampling density. The parts are the directions
    /// in front of and behind the shading normal; light arrives in front of it or behind it, and is
    /// reflected or transmitted.
    #[test]
    fn scattered_light_is_what_viewers_see() {
        let ns = Vec3::new(0.8, 0.0, 0.6);
        let point = |turned_away| SurfacePoint {
            position: Vec3::ZERO,
            error: Vec3::ZERO,
            geometric_normal: Vec3::Z,
            shading_normal: ns,
            tangent: None,
            uv: glam::Vec2::ZERO,
            instance: InstanceId::at(0),
            turned_away,
        };
        let lambert = Bsdf::Lambert(Lambert { reflectance: Rgb::gray(0.7) });
        let plastic = Plastic { diffuse: Rgb::gray(0.6), specular: Rgb::WHITE, ior: 1.5, facets: 0.4.into() };
        let plastic = Bsdf::Plastic(plastic);
        // Kernels that are not reciprocal.
        let layered = Layered::over(&lambert).unwrap();
        let coat = Clearcoat { amount: 1.0, alpha: 0.4, model: CoatModel::Layer };
        let coat = Bsdf::Layered(Layered { coat, ..layered });
        let sheen = Sheen { color: Rgb::WHITE, roughness: 0.4 };
        let cloth = Bsdf::Layered(Layered { sheen, ..layered });
        let (flat, opposite) = ((TurnedAway::Flat, Vec3::Z), (TurnedAway::Opposite, -ns));
        for (bsdf, through, (rule, stand_in)) in [
            (lambert, false, flat),
            (lambert, true, flat),
            (plastic, false, flat),
            (lambert, false, opposite),
            (lambert, true, opposite),
            (plastic, true, flat),
            (plastic, false, opposite),
            (plastic, true, opposite),
            (coat, false, flat),
            (coat, false, opposite),
            (cloth, false, flat),
            (cloth, false, opposite),
        ] {
            let point = point(rule);
            for incoming in [Vec3::new(0.48, 0.64, 0.6), Vec3::new(-0.96, 0.0, 0.28)] {
                let side = if through { -1.0 } else { 1.0 };
                let is_behind = |direction: Vec3| direction.dot(ns) * side < 0.0;
                let (mut found, mut expected) = ([Moments::default(); 2], [Moments::default(); 2]);
                let mut s = Stream::new(3, Purpose::Test, 0);
                for _ in 0..200_000 {
                    let to = |behind: bool, direction: Vec3, value: f32| {
                        if is_behind(direction) == behind { f64::from(value) } else { 0.0 }
                    };
                    let drawn = scattered(&point, &bsdf, through, incoming, &mut s);
                    let (direction, factor) =
                        drawn.map_or((Vec3::Z, 0.0), |drawn| (drawn.direction, drawn.factor.r));
                    let even = warp::sphere(s.uniform_2());
                    let mut value = 0.0;
                    if even.z * side > 0.0 {
                        let seen = if is_behind(even) { stand_in * side } else { ns * side };
                        let frame = Frame::about(seen * side);
                        let viewer = frame.to_local(even) * Vec3::new(1.0, 1.0, side);
                        let kernel = bsdf.eval_cos(viewer, frame.to_local(incoming)).r;
                        value = kernel * even.z.abs() / incoming.z * 4.0 * PI;
                    }
                    for behind in [0, 1] {
                        found[behind].push(to(behind == 1, direction, factor));
                        expected[behind].push(to(behind == 1, even, value));
                    }
                }
                for (found, expected) in found.iter().zip(expected) {
                    let error = found.standard_error().hypot(expected.standard_error());
                    let difference = (found.mean() - expected.mean()).abs();
                    assert!(
                        difference <= 4.5 * error && error < 0.02,
                        "{bsdf:?} {through} {incoming}: {} ± {error} for {}",
                        found.mean(),
                        expected.mean()
                    );
                }
            }
        }
    }
}
