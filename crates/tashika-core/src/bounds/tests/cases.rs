//! Random gather points, cones and directions, and the reflection of gather points as
//! `contribution` evaluates it.

use glam::DVec3;

use crate::bounds::Reflector;
use crate::bsdf::{
    AshikhminShirley, Bsdf, Clearcoat, CoatModel, Coated, Conductor, ConductorFresnel, FacetModel, Lambert,
    Layered, MAX_GTR1_ALPHA, MIN_ALPHA, MIN_SHEEN_ROUGHNESS, MetallicRoughness, Microfacets, Phong, Plastic,
    Principled, Sheen, TintedFresnel,
};
use crate::color::Rgb;
use crate::math::elementary::powf;
use crate::math::{Cone, Frame, Vec3};
use crate::rng::Stream;
use crate::warp;

/// Kinds of BSDFs with a diffuse part or a lobe of finite width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Lambert,
    Phong,
    Plastic,
    Schlick,
    Metal,
    Coated,
    MetallicRoughness,
    AshikhminShirley,
    Principled,
    Clearcoat,
    Passed,
    Sheen,
}

/// All kinds whose bounds are tight. Not included are [`Kind::Passed`], whose bound ignores that
/// hardly any light is transmitted at grazing angles, and [`Kind::Sheen`], whose bound ignores
/// directions.
pub const KINDS: [Kind; 10] = [
    Kind::Lambert,
    Kind::Phong,
    Kind::Plastic,
    Kind::Schlick,
    Kind::Metal,
    Kind::Coated,
    Kind::MetallicRoughness,
    Kind::Principled,
    Kind::Clearcoat,
    Kind::AshikhminShirley,
];

/// A number from `low` to `high` whose logarithm is uniform.
pub fn log_uniform(s: &mut Stream, low: f32, high: f32) -> f32 {
    (low * powf(high / low, s.uniform())).clamp(low, high)
}

/// A random BSDF of the kind; its parameters are sometimes at the ends of their ranges.
pub fn bsdf(kind: Kind, s: &mut Stream) -> Bsdf {
    let pick = s.below(8);
    let alpha = match pick {
        0 => MIN_ALPHA,
        1 => 1.0,
        _ => log_uniform(s, MIN_ALPHA, 1.0),
    };
    let facets = Microfacets::even(alpha, FacetModel::ALL[s.below(3) as usize]);
    let exponent = match pick {
        0 => 0.0,
        1 => 1e6,
        2 => 4.0 * s.uniform(),
        _ => log_uniform(s, 1.0, 1e6),
    };
    let ior = match pick {
        0 => 1.0001,
        1 => 5.0,
        _ => log_uniform(s, 1.0001, 5.0),
    };
    let (a, b, c) = (Rgb::from(s.uniform_3()), Rgb::from(s.uniform_3()), Rgb::from(s.uniform_3()));
    match kind {
        Kind::Lambert => Bsdf::Lambert(Lambert { reflectance: a }),
        Kind::Phong => Bsdf::Phong(Phong { diffuse: a * (Rgb::WHITE - b), specular: b, exponent }),
        Kind::Plastic => Bsdf::Plastic(Plastic { diffuse: a * (Rgb::WHITE - b), specular: b, ior, facets }),
        Kind::Schlick => {
            Bsdf::Conductor(Conductor { fresnel: ConductorFresnel::Schlick { f0: a }, specular: b, facets })
        }
        Kind::Passed => {
            Bsdf::Conductor(Conductor { fresnel: ConductorFresnel::Passed { f0: a }, specular: b, facets })
        }
        Kind::Metal => {
            let low = [1e-3, 0.05, 0.9][s.below(3) as usize];
            let eta = Rgb::gray(low) + a * a * 4.0;
            let k = if s.below(4) == 0 { c * 0.01 } else { c * 8.0 };
            let specular = b.map(f32::sqrt);
            Bsdf::Conductor(Conductor { fresnel: ConductorFresnel::Exact { eta, k }, specular, facets })
        }
        Kind::Coated => Bsdf::Coated(Coated { reflectance: a, specular: b, ior, facets }),
        Kind::MetallicRoughness => {
            let f0 = if s.below(2) == 0 { Rgb::gray(0.04) } else { b };
            Bsdf::MetallicRoughness(MetallicRoughness { diffuse: a, f0, dielectric_f0: f0, facets })
        }
        Kind::AshikhminShirley => {
            let f0 = if s.below(2) == 0 { Rgb::gray(0.04) } else { b };
            let facets = Microfacets { model: FacetModel::Ggx, ..facets };
            Bsdf::AshikhminShirley(AshikhminShirley { diffuse: a, f0, facets })
        }
        Kind::Principled => {
            let [roughness, schlick, cloth] = s.uniform_3();
            let sheen = if cloth < 0.5 { c } else { Rgb::BLACK };
            let fresnel = TintedFresnel { schlick, f0: b, ior };
            let flatness = if cloth > 0.8 { schlick } else { 0.0 };
            Bsdf::Principled(Principled { diffuse: a, roughness, flatness, sheen, fresnel, facets })
        }
        Kind::Clearcoat => {
            let below = [Kind::Lambert, Kind::MetallicRoughness, Kind::Principled][s.below(3) as usize];
            let layered = Layered::over(&bsdf(below, s)).expect("a surface that can have layers");
            let model = CoatModel::ALL[s.below(3) as usize];
            let widest = if model == CoatModel::Layer { 1.0 } else { MAX_GTR1_ALPHA };
            let alpha = match pick {
                0 => MIN_ALPHA,
                1 => widest,
                _ => log_uniform(s, MIN_ALPHA, widest),
            };
            let amount = if s.below(4) == 0 { 1.0 } else { s.uniform() };
            Bsdf::Layered(Layered { coat: Clearcoat { amount, alpha, model }, ..layered })
        }
        Kind::Sheen => {
            let below = [Kind::Lambert, Kind::MetallicRoughness, Kind::Clearcoat][s.below(3) as usize];
            let layered = Layered::over(&bsdf(below, s)).expect("a surface that can have layers");
            let roughness = if s.below(4) == 0 { 1.0 } else { log_uniform(s, MIN_SHEEN_ROUGHNESS, 1.0) };
            Bsdf::Layered(Layered { sheen: Sheen { color: c, roughness }, ..layered })
        }
    }
}

/// A point with the given BSDF and viewer, whose shading and geometric normals are `normal`.
pub fn point(bsdf: Bsdf, normal: Vec3, viewer: Vec3) -> Reflector {
    let frame = Frame::about(normal);
    Reflector { bsdf, frame, wo: frame.to_local(viewer), geometric_normal: normal }
}

/// A random viewer above `normal`: uniform in solid angle, or in one case of four close to the
/// horizon.
pub fn viewer(normal: Vec3, s: &mut Stream) -> Vec3 {
    let mut local = warp::cone(s.uniform_2(), 0.0);
    if s.below(4) == 0 {
        local.z *= log_uniform(s, 1e-4, 0.3);
    }
    Frame::about(normal).to_world(local.normalize()).normalize()
}

/// A random point of the kind.
pub fn random_point(kind: Kind, s: &mut Stream) -> Reflector {
    let normal = warp::sphere(s.uniform_2()).normalize();
    let seen_from = viewer(normal, s);
    let mut point = point(bsdf(kind, s), normal, seen_from);
    if s.below(2) == 0 {
        point.geometric_normal = near(normal.as_dvec3(), 0.3, s).as_vec3().normalize();
    }
    if s.below(16) == 0 {
        // Seen from the other side; surfaces are two-sided.
        point.frame = Frame::about(-normal);
        point.wo = point.frame.to_local(seen_from);
    }
    point
}

/// The mirror direction of a point in world space.
pub fn mirror(point: &Reflector) -> DVec3 {
    let Vec3 { x, y, z } = point.wo;
    point.frame.to_world(Vec3::new(-x, -y, z)).as_dvec3().normalize()
}

/// The direction at `angle` from `axis`, rotated around the axis by `phi`.
pub fn at(axis: DVec3, angle: f64, phi: f64) -> DVec3 {
    let axis = axis.normalize();
    let t = axis.any_orthonormal_vector();
    let b = axis.cross(t);
    (axis * angle.cos() + (t * phi.cos() + b * phi.sin()) * angle.sin()).normalize()
}

/// A direction at most `angle` from `axis`, uniform in angle.
pub fn near(axis: DVec3, angle: f64, s: &mut Stream) -> DVec3 {
    at(axis, angle * s.uniform_f64(), std::f64::consts::TAU * s.uniform_f64())
}

/// Half-angle of a cone (rad).
pub fn half_angle(cone: &Cone) -> f64 {
    let cos = f64::from(cone.cos).clamp(-1.0, 1.0);
    ((1.0 - cos) * (1.0 + cos)).sqrt().atan2(cos)
}

/// Returns `v`, or the direction of the cone nearest to it.
pub fn into_cone(cone: &Cone, v: DVec3) -> DVec3 {
    let (axis, widest) = (cone.axis.as_dvec3().normalize(), half_angle(cone));
    let across = v - axis * v.dot(axis);
    if across.length() < 1e-14 {
        return axis;
    }
    let angle = across.length().atan2(v.dot(axis));
    if angle <= widest {
        return v;
    }
    axis * widest.cos() + across.normalize() * widest.sin()
}

/// The largest channels of `f_r` and of `M` (sr⁻¹) for light from the direction `d`, as evaluated
/// by `contribution`.
pub fn reflected(point: &Reflector, d: Vec3) -> [f32; 2] {
    let towards_light = d / d.length_squared().sqrt().max(f32::MIN_POSITIVE);
    if point.geometric_normal.dot(towards_light) <= 0.0 {
        return [0.0; 2];
    }
    let wi = point.frame.to_local(towards_light);
    let bsdf = &point.bsdf;
    [bsdf.eval(point.wo, wi).max_channel(), bsdf.eval_cos(point.wo, wi).max_channel()]
}

/// The median of the values, which are sorted in place.
pub fn median(values: &mut [f64]) -> f64 {
    quantile(values, 0.5)
}

/// The quantile of the values at `share`; the values are sorted in place.
pub fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[(values.len() as f64 * share) as usize]
}
