//! Tests of bounds of brushed facets, for single points and for sets.

use glam::DVec3;

use super::analytic::{climb, lights, merged};
use super::cases::*;
use super::many;
use crate::bounds::{Reflector, Towards, UpperAnalytic, UpperConstant, UpperCubeMap, UpperMaterial};
use crate::bsdf::{Bsdf, Conductor, ConductorFresnel, FacetModel, MAX_ALPHA, MIN_ALPHA, Microfacets};
use crate::math::{Cone, Frame, Vec3};
use crate::rng::{Purpose, Stream};

const KINDS: [Kind; 6] = [
    Kind::Plastic,
    Kind::Schlick,
    Kind::Coated,
    Kind::MetallicRoughness,
    Kind::AshikhminShirley,
    Kind::Principled,
];

/// Facets of two roughnesses up to the ends of their ranges; the larger may be along either axis.
fn facets(s: &mut Stream) -> Microfacets {
    let model = FacetModel::ALL[s.below(3) as usize];
    let most = if model == FacetModel::Beckmann || s.below(4) > 0 { 1.0 } else { MAX_ALPHA };
    let wide = log_uniform(s, 2.0 * MIN_ALPHA, most);
    let narrow = log_uniform(s, (wide * 0.03).max(MIN_ALPHA), wide.min(1.0));
    let alpha = if s.below(2) == 0 { [wide, narrow] } else { [narrow, wide] };
    Microfacets { alpha, model }
}

fn brushed(mut bsdf: Bsdf, s: &mut Stream) -> Bsdf {
    let facets = facets(s);
    match &mut bsdf {
        Bsdf::Plastic(b) => b.facets = facets,
        Bsdf::Conductor(b) => b.facets = facets,
        Bsdf::Coated(b) => b.facets = facets,
        Bsdf::MetallicRoughness(b) => b.facets = facets,
        Bsdf::AshikhminShirley(b) => b.facets.alpha = facets.alpha,
        Bsdf::Principled(b) => b.facets = facets,
        _ => unreachable!("has no facets"),
    }
    bsdf
}

/// A point whose frame has a random rotation around its normal.
fn turned(bsdf: Bsdf, normal: Vec3, seen_from: Vec3, s: &mut Stream) -> Reflector {
    let frame = Frame::along(normal, crate::warp::sphere(s.uniform_2()));
    Reflector { bsdf, frame, wo: frame.to_local(seen_from), geometric_normal: normal }
}

/// 1 to 8 points near the first one, all of one BSDF or each of a different one.
fn points(kind: Kind, s: &mut Stream) -> Vec<Reflector> {
    let first = random_point(kind, s);
    let (normal, seen_from) = (first.normal(), first.frame.to_world(first.wo));
    let material = brushed(first.bsdf, s);
    let mut points = vec![turned(material, normal, seen_from, s)];
    let (count, spread, alike) = ([1, 2, 8][s.below(3) as usize], 0.3 * s.uniform_f64(), s.below(2) == 0);
    while points.len() < count {
        let n = near(normal.as_dvec3(), spread, s).as_vec3().normalize();
        let viewer = near(seen_from.as_dvec3(), spread, s).as_vec3().normalize();
        let bsdf = if alike { material } else { brushed(bsdf(kind, s), s) };
        points.push(turned(bsdf, n, viewer, s));
    }
    points
}

/// The direction of a light whose half vector is along an axis of a point, `slope` from the normal.
/// There the lobe is longest or narrowest.
fn along_axis(point: &Reflector, axis: usize, slope: f32) -> DVec3 {
    let side = 1.0_f32.copysign(point.wo.z);
    let half = [Vec3::new(slope, 0.0, side), Vec3::new(0.0, slope, side)][axis].normalize();
    point.frame.to_world(half * (2.0 * point.wo.dot(half)) - point.wo).as_dvec3()
}

/// Compares every bound with the largest values found, which are also searched along both axes of
/// the lobe.
#[test]
fn bounds_of_brushed_points_hold() {
    let mut lit = 0;
    for (index, kind) in KINDS.into_iter().enumerate() {
        let mut s = Stream::new(71, Purpose::Test, index as u64);
        for round in 0..many(1000) {
            let points = points(kind, &mut s);
            let axis = along_axis(&points[0], s.below(2) as usize, s.uniform());
            let towards = match s.below(3) {
                0 => Towards::Cone(Cone {
                    axis: axis.as_vec3().normalize(),
                    cos: 1.0 - log_uniform(&mut s, 1e-6, 0.5),
                }),
                _ => lights(&points[0], &mut s),
            };
            let bounds = [
                merged::<UpperConstant>(&points).upper_material(&towards),
                merged::<UpperAnalytic>(&points).upper_material(&towards),
                merged::<UpperCubeMap<8, false>>(&points).upper_material(&towards),
                merged::<UpperCubeMap<8, true>>(&points).upper_material(&towards),
            ];
            let holds = |value: f32| {
                let all = bounds.iter().all(|bound| value <= *bound);
                assert!(all, "round {round}: {value} above {bounds:?}, {towards:?} {points:?}");
            };
            let mut largest = climb(&points, &towards, &mut s, holds);
            for point in &points {
                for step in 0..40 {
                    let d = along_axis(point, step % 2, (step / 2) as f32 * 0.05).as_vec3();
                    if let Towards::Cone(cone) = towards
                        && cone.contains(d)
                    {
                        let value = reflected(point, d)[1];
                        holds(value);
                        largest = largest.max(value);
                    }
                }
            }
            lit += usize::from(largest > 0.0);
        }
    }
    assert!(lit > 2000, "{lit}");
}

/// Bounds of one point over cones, with and without the cosine. For a narrow cone along the wide
/// axis of the lobe, the bound equals the largest value found, except for masking and shadowing.
///
/// With cosines above 0.6 and `α_w ≤ 0.3` the factors of `α_n` are at most 1.08 times those of
/// `α_w`. The half-angle of 4·10⁻⁴ changes `ln D` for `α_w ≥ 0.05` by less than 0.04 up to the
/// slope `2 α_w`.
#[test]
fn bounds_over_cones_hold_and_are_tight_along_the_wide_axis() {
    let mut s = Stream::new(72, Purpose::Test, 0);
    let mut tight = 0;
    for round in 0..many(20_000) {
        let kind = if s.below(2) == 0 { Kind::Schlick } else { KINDS[s.below(5) as usize] };
        let first = random_point(kind, &mut s);
        let material = brushed(first.bsdf, &mut s);
        let mut point = turned(material, first.normal(), first.frame.to_world(first.wo), &mut s);
        point.geometric_normal = first.geometric_normal;
        let (axis, slope) = (s.below(2) as usize, s.uniform() * s.uniform());
        let d = along_axis(&point, axis, slope).as_vec3().normalize();
        let versine = if s.below(2) == 0 { 6e-8 } else { log_uniform(&mut s, 6e-8, 0.3) };
        let cone = Cone { axis: d, cos: 1.0 - versine };
        let bounds = [point.upper_brdf(&cone), point.upper_brdf_cos(&cone)];
        let mut largest = 0.0_f32;
        for step in 0..40 {
            let d = if step == 0 { d } else { near(d.as_dvec3(), half_angle(&cone), &mut s).as_vec3() };
            let values = reflected(&point, into_cone(&cone, d.as_dvec3()).as_vec3());
            let holds = values.iter().zip(bounds).all(|(value, bound)| *value <= bound);
            assert!(holds, "round {round}: {values:?} above {bounds:?} {d} {cone:?} {point:?}");
            largest = largest.max(values[1]);
        }
        let Bsdf::Conductor(Conductor { facets, fresnel: ConductorFresnel::Schlick { .. }, .. }) = material
        else {
            continue;
        };
        let (widest, cos_i) = (facets.widest(), d.dot(point.normal()));
        let is_along = facets.alpha[axis] == widest && slope < 2.0 * widest;
        let is_clear = (0.05..0.3).contains(&widest) && point.wo.z.abs() > 0.6 && cos_i > 0.6;
        if is_along && is_clear && half_angle(&cone) < 4e-4 && largest > 0.0 {
            tight += 1;
            assert!(bounds[1] <= 1.14 * largest, "round {round}: {} for {largest}, {point:?}", bounds[1]);
        }
    }
    assert!(tight > 50, "{tight}");
}
