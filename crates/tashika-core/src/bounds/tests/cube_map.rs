//! Tests of cube maps of single points and of clusters against random members.

use super::cases::*;
use super::many;
use crate::bounds::{Reflector, Towards, UpperCubeMap, UpperMaterial};
use crate::math::{Aabb, Cone, Vec3};
use crate::rng::{Purpose, Stream};
use crate::warp;

/// Maps as published, and maps whose texels include the cosine.
type Published = UpperCubeMap;
type Folded = UpperCubeMap<8, true>;

/// The points of a pixel: either all of one BSDF, with similar normals and viewers, or random
/// points of all `kinds`.
fn cluster(kinds: &[Kind], s: &mut Stream, size: usize) -> Vec<Reflector> {
    let one = |s: &mut Stream| kinds[s.below(kinds.len() as u64) as usize];
    let normal = warp::sphere(s.uniform_2()).normalize();
    let seen_from = viewer(normal, s);
    let spread = f64::from(log_uniform(s, 1e-3, 0.5));
    let alike = s.below(4) > 0;
    let common = bsdf(one(s), s);
    let mut points = Vec::new();
    while points.len() < size {
        if !alike {
            points.push(random_point(one(s), s));
            continue;
        }
        let normal = near(normal.as_dvec3(), spread, s).as_vec3().normalize();
        let seen_from = near(seen_from.as_dvec3(), 0.1 * spread, s).as_vec3().normalize();
        if normal.dot(seen_from) > 0.0 {
            points.push(point(common, normal, seen_from));
        }
    }
    points
}

fn map_of<B: UpperMaterial>(points: &[Reflector]) -> B {
    let mut map = B::of_point(&points[0]);
    points[1..].iter().for_each(|point| map.merge(&B::of_point(point)));
    map
}

/// Lights in random directions or towards the mirror direction of a point. Mostly boxes of vectors,
/// some of which are flat, touch the origin, or lie on an edge or a corner of the cube.
fn lights(points: &[Reflector], s: &mut Stream) -> Towards {
    let distance = log_uniform(s, 1e-3, 1e3);
    let direction = match s.below(3) {
        0 => mirror(&points[s.below(points.len() as u64) as usize]).as_vec3(),
        _ => warp::sphere(s.uniform_2()),
    };
    match s.below(30) {
        0 => return Towards::Any,
        1..5 => return Towards::Cone(Cone { axis: direction, cos: 1.0 - log_uniform(s, 1e-7, 2.0) }),
        _ => {}
    }
    let mut center = direction * distance;
    match s.below(12) {
        0 => center.y = center.x,
        1 => center = Vec3::splat(center.x.abs()).copysign(center),
        2 => center.z = 0.0,
        _ => {}
    }
    let mut half = Vec3::from(s.uniform_3()) * distance * log_uniform(s, 1e-6, 2.0);
    for axis in 0..3 {
        if s.below(6) == 0 {
            half[axis] = 0.0;
        }
    }
    if s.below(8) == 0 {
        let axis = s.below(3) as usize;
        half[axis] = center[axis].abs();
    }
    Towards::Box(Aabb { lo: center - half, hi: center + half })
}

/// A vector to one of the lights; in every second case the one nearest to the mirror direction of
/// the point. `None` if rounding moved it out of its cone.
fn member(lights: &Towards, point: &Reflector, s: &mut Stream) -> Option<Vec3> {
    let aim = near(mirror(point), f64::from(log_uniform(s, 1e-5, 1.0)), s);
    let aimed = s.below(2) == 0;
    let b = match lights {
        Towards::Any => return Some(aim.as_vec3()),
        Towards::Cone(cone) => {
            let anywhere = near(cone.axis.as_dvec3(), half_angle(cone), s);
            let d = into_cone(cone, if aimed { aim } else { anywhere }).as_vec3();
            return cone.contains(d).then_some(d);
        }
        Towards::Box(b) => b,
    };
    if aimed {
        let aim = aim.as_vec3();
        let along = (b.center().dot(aim) + (s.uniform() - 0.5) * b.diagonal()).max(0.0);
        return Some((aim * along).clamp(b.lo, b.hi));
    }
    let [x, y, z] = std::array::from_fn(|axis| match s.below(4) {
        0 => b.lo[axis],
        1 => b.hi[axis],
        _ => (b.lo[axis] + s.uniform() * (b.hi[axis] - b.lo[axis])).clamp(b.lo[axis], b.hi[axis]),
    });
    Some(Vec3::new(x, y, z))
}

/// Checks that the bounds of random clusters of a given size are at least the values of all members
/// tried. Returns the median ratio of bound to largest member, over clusters and lights for which
/// the latter is not zero.
fn bounds_hold<B: UpperMaterial>(size: usize, rounds: usize) -> f64 {
    bounds_of_kinds_hold::<B>(&KINDS[..7], size, rounds)
}

/// [`bounds_hold`] for some kinds.
fn bounds_of_kinds_hold<B: UpperMaterial>(kinds: &[Kind], size: usize, rounds: usize) -> f64 {
    let mut s = Stream::new(41, Purpose::Test, size as u64);
    let mut quotients = Vec::new();
    for _ in 0..many(rounds) {
        let points = cluster(kinds, &mut s, size);
        let map: B = map_of(&points);
        for _ in 0..20 {
            let lights = lights(&points, &mut s);
            let bound = map.upper_material(&lights);
            assert!(bound >= 0.0 && bound.is_finite(), "{bound} {lights:?}");
            let mut largest = 0.0_f32;
            for k in 0..100.max(2 * size) {
                let point = &points[k % size];
                let Some(d) = member(&lights, point, &mut s) else { continue };
                let [_, value] = reflected(point, d);
                assert!(value <= bound, "{value:e} > {bound:e} for {d:?} of {lights:?}, {point:?}");
                largest = largest.max(value);
            }
            if largest > 0.0 {
                quotients.push(f64::from(bound) / f64::from(largest));
            }
        }
    }
    assert!(quotients.len() > 8 * rounds, "only {} of {} were lit", quotients.len(), 20 * rounds);
    median(&mut quotients)
}

// The limits are the medians measured in the slow suite plus a tenth of their excess over 1, at
// least 0.01. Clusters include the narrowest lobes.

#[test]
fn bounds_of_single_points_hold_and_are_tight() {
    let published = bounds_hold::<Published>(1, 600);
    assert!(published < 1.29, "{published}");
    let folded = bounds_hold::<Folded>(1, 600);
    assert!(folded < 1.12, "{folded}");
}

#[test]
fn bounds_of_clusters_hold_and_are_tight() {
    for (size, rounds, limits) in [(2, 200, [1.63, 1.28]), (8, 200, [2.14, 1.56]), (64, 200, [3.5, 1.66])] {
        let medians = [bounds_hold::<Published>(size, rounds), bounds_hold::<Folded>(size, rounds)];
        assert!(medians[0] < limits[0] && medians[1] < limits[1], "{size} points: {medians:?}");
    }
}

/// The bounds of sheen hold, but need not be tight.
#[test]
fn bounds_of_sheen_hold() {
    for size in [1, 8] {
        let medians = [
            bounds_of_kinds_hold::<Published>(&[Kind::Sheen], size, 200),
            bounds_of_kinds_hold::<Folded>(&[Kind::Sheen], size, 200),
        ];
        assert!(medians[1] < 10.0 && medians[1] < medians[0], "{size} points: {medians:?}");
    }
}

/// Principled surfaces and coats have several lobes, each of which is bounded separately. The
/// limits are medians measured here.
#[test]
fn bounds_of_several_lobes_hold_and_are_tight() {
    for (size, limits) in [(1, [1.67, 1.37]), (8, [2.6, 1.85])] {
        let kinds = &[Kind::Principled, Kind::Clearcoat];
        let medians = [
            bounds_of_kinds_hold::<Published>(kinds, size, 200),
            bounds_of_kinds_hold::<Folded>(kinds, size, 200),
        ];
        assert!(medians[0] < limits[0] && medians[1] < limits[1], "{size} points: {medians:?}");
    }
}

#[test]
fn bounds_of_all_resolutions_hold_and_finer_ones_are_tighter() {
    let medians = [
        bounds_hold::<UpperCubeMap<16>>(4, 200),
        bounds_hold::<UpperCubeMap<8>>(4, 200),
        bounds_hold::<UpperCubeMap<4>>(4, 200),
        bounds_hold::<UpperCubeMap<3>>(4, 200),
    ];
    assert!(medians.is_sorted() && medians[0] < 1.64 && medians[3] < 2.86, "{medians:?}");
}

/// Compares the map of a single point with the point's bound over the cone around the same lights.
/// The ratio is the price of texels.
#[test]
fn a_map_is_hardly_larger_than_the_bound_that_it_is_made_of() {
    let mut s = Stream::new(42, Purpose::Test, 0);
    let mut quotients = [Vec::new(), Vec::new()];
    for _ in 0..600 {
        let points = cluster(&KINDS[..7], &mut s, 1);
        let (published, folded) = (Published::of_point(&points[0]), Folded::of_point(&points[0]));
        for _ in 0..20 {
            let lights = lights(&points, &mut s);
            let alone = f64::from(points[0].upper_brdf_cos(&lights.cone()));
            if alone > 0.0 {
                quotients[0].push(f64::from(published.upper_material(&lights)) / alone);
                quotients[1].push(f64::from(folded.upper_material(&lights)) / alone);
            }
        }
    }
    let medians = quotients.each_mut().map(|q| median(q));
    assert!(medians[0] < 1.07 && medians[1] < 1.02, "{medians:?}");
}
