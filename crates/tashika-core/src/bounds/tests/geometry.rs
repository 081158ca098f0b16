//! Tests of the geometric bounds against members: vectors, cosines and geometric terms, evaluated
//! by the `f32` formulas of `contribution` and in `f64`.
//!
//! Sides of clusters are between zero and the full size, and sizes are from 10⁻⁶ m to 10⁶ m.
//! Clusters lie apart, near each other, in touch, or inside one another, at the origin or far from
//! it. Members are corners, points between them, and the vectors of a box that a search finds to be
//! nearest to an axis. `f64` is treated as exact: its roundings are 10⁹ times smaller than those
//! that the bounds allow for.

use glam::DVec3;

use super::many;
use crate::bounds::{LightBounds, LightShape, Towards, upper_geometric};
use crate::math::elementary::{powf, sin_cos};
use crate::math::{Aabb, Cone, Vec3};
use crate::rng::{Purpose, Stream};
use crate::warp;

/// A cluster of lights and a box of points.
#[derive(Clone, Copy, Debug)]
struct Pair {
    lights: Aabb,
    points: Aabb,
}

/// Distance between two boxes.
#[derive(Clone, Copy, Debug)]
enum Apart {
    /// The distance of the centres is one to two times this multiple of their size.
    By(f32),
    /// In touch, in a common plane or at a corner.
    Touching,
    /// At a random distance.
    Any,
}

impl Pair {
    fn random(apart: Apart, s: &mut Stream) -> Self {
        let size = powf(10.0, 12.0 * s.uniform() - 6.0);
        let origin = match s.below(3) {
            0 => Vec3::ZERO,
            1 => warp::sphere(s.uniform_2()) * size * 10.0,
            _ => warp::sphere(s.uniform_2()) * size * 3e3,
        };
        let points = half(size, s);
        let lights = half(size, s);
        let direction = warp::sphere(s.uniform_2());
        let between = match apart {
            Apart::By(factor) => direction * size * factor * (1.0 + s.uniform()),
            Apart::Any => direction * size * powf(10.0, 5.0 * s.uniform() - 3.0),
            Apart::Touching => {
                let axis = s.below(4) as usize;
                let sum = points + lights;
                let along = |k: usize| if k == axis || axis == 3 { sum[k] } else { sum[k] * direction[k] };
                Vec3::new(along(0), along(1), along(2))
            }
        };
        let (p, l) = (origin, origin + between);
        let points = Aabb { lo: p - points, hi: p + points };
        let mut lights = Aabb { lo: l - lights, hi: l + lights };
        if matches!(apart, Apart::Touching) {
            // The boxes touch exactly, on the first axis.
            lights.lo.x = points.hi.x;
            lights.hi.x = lights.hi.x.max(lights.lo.x);
        }
        Self { lights, points }
    }

    /// Positions of a light and of a point; in one case of three, corners.
    fn member(&self, s: &mut Stream) -> (Vec3, Vec3) {
        let mut within = |b: &Aabb| {
            let at = if s.below(3) == 0 {
                Vec3::new(s.below(2) as f32, s.below(2) as f32, s.below(2) as f32)
            } else {
                Vec3::from(s.uniform_3())
            };
            (b.lo + (b.hi - b.lo) * at).clamp(b.lo, b.hi)
        };
        (within(&self.lights), within(&self.points))
    }

    fn towards(&self, shape: LightShape) -> Towards {
        Towards::between(&LightBounds { aabb: self.lights, shape }, &self.points)
    }
}

/// Half the sides of a box. Any of them may be zero or small.
fn half(size: f32, s: &mut Stream) -> Vec3 {
    let mut side = || match s.below(4) {
        0 => 0.0,
        1 => size * powf(10.0, -5.0 * s.uniform()),
        _ => size * s.uniform(),
    };
    0.5 * Vec3::new(side(), side(), side())
}

/// A cone, and directions in it as unit vectors in `f32`.
struct Directions {
    cone: Cone,
    members: Vec<Vec3>,
}

impl Directions {
    /// Creates directions within `angle` (rad) of `axis`, and the union of their cones as light
    /// trees compute it.
    fn about(axis: Vec3, angle: f32, s: &mut Stream) -> Self {
        let mut members = vec![axis];
        for _ in 0..s.below(4) {
            let (sin, cos) = sin_cos(angle * s.uniform());
            let across = axis.any_orthonormal_vector() * (2.0 * s.uniform() - 1.0)
                + axis.cross(axis.any_orthonormal_vector()) * (2.0 * s.uniform() - 1.0);
            members.push((axis * cos + across.normalize_or_zero() * sin).normalize());
        }
        let cone = members.iter().fold(Cone::EMPTY, |cone, d| cone.union(Cone::of(*d)));
        Self { cone, members }
    }

    /// Creates a single direction, or a narrow, wide or nearly full cone.
    fn random(s: &mut Stream) -> Self {
        let axis = warp::sphere(s.uniform_2()).normalize();
        let angle = match s.below(4) {
            0 => 0.0,
            1 => 1e-3,
            2 => 0.5,
            _ => 3.2,
        };
        Self::about(axis, angle, s)
    }

    fn member(&self, s: &mut Stream) -> Vec3 {
        self.members[s.below(self.members.len() as u64) as usize]
    }
}

/// Unit direction from a point to a light, and the squared distance, as in `contribution`.
fn link(light: Vec3, point: Vec3) -> (Vec3, f32) {
    let d = light - point;
    let squared = d.length_squared();
    (d / squared.sqrt().max(f32::MIN_POSITIVE), squared)
}

/// `G` as in `contribution`. `shape` is a function of the cosine between the light's direction and
/// the direction to the point.
fn geometric(light: Vec3, direction: Vec3, point: Vec3, clamp: f32, shape: impl Fn(f32) -> f32) -> f32 {
    let (towards, squared) = link(light, point);
    shape(-direction.dot(towards)) / squared.max(clamp * clamp).max(1e-20)
}

/// The vector of a box that is nearest to an axis in angle, found by hill climbing from the best
/// corner and from the centre. `None` if the box may contain zero.
fn nearest_to_axis(b: &Aabb, axis: DVec3) -> Option<DVec3> {
    let (lo, hi) = (b.lo.as_dvec3(), b.hi.as_dvec3());
    if (lo.cmple(DVec3::ZERO) & hi.cmpge(DVec3::ZERO)).all() {
        return None;
    }
    let cos = |p: DVec3| p.dot(axis) / p.length();
    let best = |a: DVec3, b: DVec3| if cos(a) > cos(b) { a } else { b };
    let climb = |mut p: DVec3| {
        let mut step = 0.5;
        for _ in 0..60 {
            let gradient = (axis - p * (p.dot(axis) / p.length_squared())).normalize_or_zero();
            let along = |d: DVec3| (p + d * step * (hi - lo).length()).clamp(lo, hi);
            let tries = [gradient, DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z].map(along);
            let next = tries.into_iter().fold(p, best);
            if cos(next) > cos(p) {
                p = next;
            } else {
                step *= 0.25;
            }
        }
        p
    };
    Some(best(climb(corners(b).map(Vec3::as_dvec3).fold(lo, best)), climb(0.5 * (lo + hi))))
}

fn corners(b: &Aabb) -> impl Iterator<Item = Vec3> {
    let Aabb { lo, hi } = *b;
    (0..8).map(move |k| Vec3::select(glam::BVec3::new(k & 1 != 0, k & 2 != 0, k & 4 != 0), hi, lo))
}

/// `cos(max(0, arccos cos − β))` for the half-angle `β` of a cone.
fn cos_beyond(cos: f64, cone: &Cone) -> f64 {
    let beta = f64::from(cone.cos).max(-1.0);
    let sin = |c: f64| ((1.0 - c) * (1.0 + c)).max(0.0).sqrt();
    if cos >= beta { 1.0 } else { cos * beta + sin(cos) * sin(beta) }
}

fn median(mut v: Vec<f64>) -> f64 {
    v.sort_by(f64::total_cmp);
    v[v.len() / 2]
}

const ALL_DISTANCES: [Apart; 5] =
    [Apart::By(5.0), Apart::By(1.5), Apart::By(0.7), Apart::Touching, Apart::Any];

#[test]
fn differences_hold_in_f32_and_exactly() {
    let mut s = Stream::new(1, Purpose::Test, 0);
    for round in 0..many(200_000) {
        let pair = Pair::random(ALL_DISTANCES[round % 5], &mut s);
        let Towards::Box(b) = pair.towards(LightShape::Omni) else { panic!("omni lights are in a box") };
        for _ in 0..4 {
            let (light, point) = pair.member(&mut s);
            let exact = light.as_dvec3() - point.as_dvec3();
            let holds = b.lo.as_dvec3().cmple(exact).all() && exact.cmple(b.hi.as_dvec3()).all();
            assert!(holds && b.contains(light - point), "{pair:?} {light} {point} {b:?}");
        }
        // The box is wider than exact by at most two roundings on each side.
        let rounding = 1.3e-7 * (b.lo.abs() + b.hi.abs());
        let width = (pair.lights.hi.as_dvec3() - pair.lights.lo.as_dvec3())
            + (pair.points.hi.as_dvec3() - pair.points.lo.as_dvec3());
        assert!(
            (b.hi.as_dvec3() - b.lo.as_dvec3()).cmple(width + 2.0 * rounding.as_dvec3()).all(),
            "{pair:?}"
        );
    }
}

/// Any vector of a box, including those nearest to the axis, against any axis of a cone.
#[test]
fn cosines_of_boxes_hold() {
    let mut s = Stream::new(2, Purpose::Test, 0);
    for round in 0..many(200_000) {
        let pair = Pair::random(ALL_DISTANCES[round % 5], &mut s);
        let towards = pair.towards(LightShape::Omni);
        let Towards::Box(b) = towards else { panic!("omni lights are in a box") };
        let axes = match round % 4 {
            // Grazing and opposite angles, where a rounding of the cosine is a large angle.
            0 => Directions::about(b.center().normalize_or(Vec3::X).any_orthonormal_vector(), 1.0, &mut s),
            1 => Directions::about(-b.center().normalize_or(Vec3::X), 3.0, &mut s),
            _ => Directions::random(&mut s),
        };
        let upper = towards.upper_cos(&axes.cone);
        for _ in 0..6 {
            let (light, point) = pair.member(&mut s);
            let (direction, _) = link(light, point);
            let cos = direction.dot(axes.member(&mut s));
            assert!(cos.min(1.0) <= upper, "{pair:?} {:?} {light} {point} {cos} {upper}", axes.cone);
        }
        let axis = axes.cone.axis.as_dvec3().normalize();
        if round % 7 == 0
            && let Some(d) = nearest_to_axis(&b, axis)
        {
            let cos = cos_beyond(d.dot(axis) / d.length(), &axes.cone);
            assert!(cos <= f64::from(upper), "{pair:?} {:?} {d} {cos} {upper}", axes.cone);
        }
    }
}

/// A published, cheaper form uses the component orthogonal to the axis of the vector nearest to the
/// origin, not the least component of all vectors. The samples of these tests show that this form
/// is not a bound.
#[test]
fn the_unsound_form_is_found_out() {
    let unsound = |b: &Aabb, axis: Vec3| {
        let near = b.lo.max(Vec3::ZERO) + b.hi.min(Vec3::ZERO);
        let across = near - axis * near.dot(axis);
        let high = axis.dot(b.center()) + axis.abs().dot(b.size() * 0.5);
        high / (across.length_squared() + high * high).sqrt()
    };
    let mut s = Stream::new(2, Purpose::Test, 40);
    let (mut exceeded, mut worst) = (0, 0.0_f32);
    for round in 0..20_000 {
        let pair = Pair::random(ALL_DISTANCES[round % 5], &mut s);
        let Towards::Box(b) = pair.towards(LightShape::Omni) else { panic!("omni lights are in a box") };
        let axis = warp::sphere(s.uniform_2());
        for _ in 0..6 {
            let (light, point) = pair.member(&mut s);
            let (direction, _) = link(light, point);
            let over = direction.dot(axis) - unsound(&b, axis);
            if direction.dot(axis) > 0.0 && over > 1e-3 {
                exceeded += 1;
                worst = worst.max(over);
            }
        }
    }
    assert!(exceeded > 20 && worst > 0.05, "{exceeded} members of 120 000, by up to {worst}");
}

/// A single direction opposite to an axis, and a cone around that axis that is almost the whole
/// sphere.
#[test]
fn cosines_hold_opposite_to_wide_cones() {
    let mut s = Stream::new(3, Purpose::Test, 0);
    for _ in 0..many(200_000) {
        let axis = warp::sphere(s.uniform_2()).normalize();
        let tilt = powf(10.0, -7.0 * s.uniform());
        let d = (axis + warp::sphere(s.uniform_2()) * tilt) * -powf(10.0, 6.0 * s.uniform() - 3.0);
        let cone = Cone { axis, cos: -s.uniform() };
        let b = Towards::Box(Aabb { lo: d, hi: d });
        let unit = Towards::Cone(Cone::of(d.normalize()));
        let cos = cos_beyond(d.as_dvec3().normalize().dot(axis.as_dvec3().normalize()), &cone);
        let upper = b.upper_cos(&cone).min(unit.upper_cos(&cone));
        assert!(cos <= f64::from(upper), "{d} {cone:?} {cos} {upper}");
        // The angle may be off by the square root of a few roundings.
        assert!(f64::from(upper) <= cos.max(0.0) + 4e-3, "{d} {cone:?} {cos} {upper}");
    }
}

#[test]
fn cosines_between_cones_hold() {
    let mut s = Stream::new(4, Purpose::Test, 0);
    let (mut slack, mut compared) = (0.0_f64, 0);
    for round in 0..many(200_000) {
        let travelling = Directions::random(&mut s);
        let axes = match round % 3 {
            0 => Directions::about(-travelling.cone.axis, 1e-3, &mut s),
            1 => Directions::about(travelling.cone.axis, 1e-3, &mut s),
            _ => Directions::random(&mut s),
        };
        let lights = LightBounds { aabb: Aabb::EMPTY, shape: LightShape::Directional(travelling.cone) };
        let towards = Towards::between(&lights, &Aabb { lo: Vec3::ZERO, hi: Vec3::ONE });
        let upper = towards.upper_cos(&axes.cone);
        for d in &travelling.members {
            for axis in &axes.members {
                let cos = (-*d).dot(*axis);
                assert!(cos.min(1.0) <= upper, "{:?} {:?} {cos} {upper}", travelling.cone, axes.cone);
            }
        }
        assert_eq!(towards.cone(), travelling.cone.reversed());
        assert_eq!(upper_geometric(&lights, &towards, 0.5), 1.0);
        // The exact bound, computed from angles.
        let unit = |v: Vec3| v.as_dvec3().normalize();
        let between = (-unit(travelling.cone.axis)).dot(unit(axes.cone.axis));
        let exact = cos_beyond(between, &travelling.cone);
        if exact < 1.0 {
            let exact = cos_beyond(exact, &axes.cone);
            assert!(exact <= f64::from(upper), "{:?} {:?} {exact} {upper}", travelling.cone, axes.cone);
            slack += f64::from(upper) - exact.max(0.0);
            compared += 1;
        }
    }
    assert!(compared > 5_000 && slack / f64::from(compared) < 1e-4, "{compared} {slack}");
}

#[test]
fn cones_about_boxes_hold() {
    let mut s = Stream::new(5, Purpose::Test, 0);
    let mut ratios = Vec::new();
    for round in 0..many(200_000) {
        let apart = ALL_DISTANCES[round % 5];
        let pair = Pair::random(apart, &mut s);
        let towards = pair.towards(LightShape::Omni);
        let Towards::Box(b) = towards else { panic!("omni lights are in a box") };
        let cone = towards.cone();
        assert!((cone.axis.length() - 1.0).abs() < 4.0 * f32::EPSILON, "{cone:?}");
        let mut lowest = 1.0_f64;
        for _ in 0..12 {
            let (light, point) = pair.member(&mut s);
            let d = light - point;
            if d != Vec3::ZERO {
                assert!(cone.contains(d), "{pair:?} {cone:?} {d}");
                lowest = lowest.min(d.as_dvec3().normalize().dot(cone.axis.as_dvec3().normalize()));
            }
        }
        for d in corners(&b) {
            assert!(d == Vec3::ZERO || cone.contains(d), "{pair:?} {cone:?} {d}");
            if d != Vec3::ZERO {
                lowest = lowest.min(d.as_dvec3().normalize().dot(cone.axis.as_dvec3().normalize()));
            }
        }
        if matches!(apart, Apart::By(f) if f > 1.0) {
            // Ratio of the solid angle of the cone to that of the narrowest cone around this axis.
            // Cosines cannot resolve differences below 10⁻⁷.
            ratios.push((1.0 - f64::from(cone.cos) + 1e-6) / (1.0 - lowest + 1e-6));
        }
    }
    assert!(median(ratios) < 1.01);
}

/// A light's factor at a cosine, as in `contribution`.
type Shape = fn(f32) -> f32;

/// Fall-offs of spots that vanish below the cosine 0.6.
const FALL_OFFS: [Shape; 2] = [
    |cos| {
        let s = ((cos - 0.6) / (0.9 - 0.6)).clamp(0.0, 1.0);
        s * s * (3.0 - 2.0 * s)
    },
    |cos| if cos > 0.6 { 1.0 } else { 0.0 },
];

#[test]
fn geometric_terms_hold() {
    let mut s = Stream::new(6, Purpose::Test, 0);
    for round in 0..many(200_000) {
        let pair = Pair::random(ALL_DISTANCES[round % 5], &mut s);
        let size = pair.lights.union(pair.points).diagonal();
        let clamp = [0.0, 1e-3 * size, size][round % 3];
        let normals = match round % 4 {
            0 => {
                let to_points = (pair.points.center() - pair.lights.center()).normalize_or(Vec3::X);
                Directions::about(to_points.any_orthonormal_vector(), 1.0, &mut s)
            }
            _ => Directions::random(&mut s),
        };
        let (oriented, spot) =
            (LightShape::Oriented(normals.cone), LightShape::Spot { axes: normals.cone, cos_outer: 0.6 });
        let shapes: [(LightShape, &[Shape]); 4] = [
            (LightShape::Omni, &[|_| 1.0]),
            (oriented, &[|cos| cos.max(0.0)]),
            (spot, &FALL_OFFS),
            (LightShape::Mixed { peak: 1.0 }, &[|_| 1.0, |cos| cos.max(0.0)]),
        ];
        for (shape, factors) in shapes {
            let bounds = LightBounds { aabb: pair.lights, shape };
            let upper = upper_geometric(&bounds, &pair.towards(shape), clamp);
            assert!(
                upper.is_finite() && (!matches!(shape, LightShape::Mixed { .. }) || upper >= 1.0),
                "{pair:?} {upper}"
            );
            for _ in 0..4 {
                let (light, point) = pair.member(&mut s);
                for factor in factors {
                    let direction = normals.member(&mut s);
                    let value = geometric(light, direction, point, clamp, factor);
                    assert!(value <= upper, "{pair:?} {shape:?} {clamp} {light} {point} {value} {upper}");
                }
            }
        }
    }
}

/// For a single light and a single point the bounds are tight, as no box or cone enlarges them.
#[test]
fn single_members_have_tight_bounds() {
    let mut s = Stream::new(7, Purpose::Test, 0);
    for _ in 0..many(100_000) {
        let point = warp::sphere(s.uniform_2()) * powf(10.0, 12.0 * s.uniform() - 6.0);
        let light = point + warp::sphere(s.uniform_2()) * point.length();
        let direction = warp::sphere(s.uniform_2()).normalize();
        let pair = Pair { lights: Aabb { lo: light, hi: light }, points: Aabb { lo: point, hi: point } };
        let shape = LightShape::Oriented(Cone::of(direction));
        let towards = pair.towards(shape);
        let bounds = LightBounds { aabb: pair.lights, shape };
        let value = geometric(light, direction, point, 0.0, |cos| cos.max(0.0));
        let upper = upper_geometric(&bounds, &towards, 0.0);
        let cos = -direction.dot(link(light, point).0);
        let upper_cos = towards.upper_cos(&Cone::of(-direction));
        // Cosines have a slack of about 2⁻¹⁸, from the 48 roundings of a cosine and 24 of a sum
        // with factors of up to 3.
        if cos > 1e-3 {
            assert!(value <= upper && upper <= 1.01 * value, "{pair:?} {direction} {value} {upper}");
        } else if cos < -1e-5 {
            assert_eq!(upper, 0.0, "{pair:?} {direction}");
        }
        assert!(upper_cos - cos.clamp(0.0, 1.0) < 1e-5, "{pair:?} {direction} {cos} {upper_cos}");
        // The largest cosine below 1 corresponds to 4.9·10⁻⁴ rad.
        assert!(towards.cone().cos >= 1.0f32.next_down().next_down(), "{pair:?}");
    }
}

/// A pair that differs little from its parent has a separate bound. Members of the child are below
/// both bounds.
#[test]
fn children_have_bounds_of_their_own() {
    let mut s = Stream::new(8, Purpose::Test, 0);
    for round in 0..many(100_000) {
        let pair = Pair::random(ALL_DISTANCES[round % 5], &mut s);
        let normals = Directions::random(&mut s);
        let mut cut = |b: &Aabb| {
            let at = Vec3::from(s.uniform_3()) * [0.0, 1e-6, 0.1][s.below(3) as usize];
            Aabb { lo: (b.lo + (b.hi - b.lo) * at).min(b.hi), hi: b.hi }
        };
        let child = Pair { lights: cut(&pair.lights), points: cut(&pair.points) };
        let fewer = Directions::about(normals.member(&mut s), 0.0, &mut s);
        let upper = |pair: &Pair, cone: Cone| {
            let shape = LightShape::Oriented(cone);
            upper_geometric(&LightBounds { aabb: pair.lights, shape }, &pair.towards(shape), 0.0)
        };
        let (parent_upper, child_upper) = (upper(&pair, normals.cone), upper(&child, fewer.cone));
        for _ in 0..4 {
            let (light, point) = child.member(&mut s);
            let value = geometric(light, fewer.member(&mut s), point, 0.0, |cos| cos.max(0.0));
            assert!(value <= parent_upper.min(child_upper), "{pair:?} {child:?} {light} {point} {value}");
        }
    }
}

/// Median ratio of the bound to the largest value found, for clusters at moderate distance.
#[test]
fn bounds_are_tight() {
    let mut s = Stream::new(9, Purpose::Test, 0);
    let (mut cosines, mut terms, mut spots, mut dark) = (Vec::new(), Vec::new(), 0, 0);
    for _ in 0..10_000 {
        let pair = Pair::random(Apart::By(1.5), &mut s);
        let normals = Directions::random(&mut s);
        let shape = LightShape::Oriented(normals.cone);
        let towards = pair.towards(shape);
        let Towards::Box(b) = towards else { panic!("oriented lights are in a box") };
        let axes = normals.cone.reversed();
        let axis = axes.axis.as_dvec3().normalize();
        let d = nearest_to_axis(&b, axis).expect("boxes are apart");
        let cos = cos_beyond(d.dot(axis) / d.length(), &axes);
        if cos > 0.01 {
            cosines.push(f64::from(towards.upper_cos(&axes)) / cos);
        }
        let upper = upper_geometric(&LightBounds { aabb: pair.lights, shape }, &towards, 0.0);
        let value = |s: &mut Stream| {
            let (light, point) = pair.member(s);
            geometric(light, normals.member(s), point, 0.0, |cos| cos.max(0.0))
        };
        let largest = (0..200).map(|_| value(&mut s)).fold(0.0, f32::max);
        if largest > 0.0 {
            terms.push(f64::from(upper / largest));
        }
        // A spot is dark if the exact cosine is beyond the rim.
        let shape = LightShape::Spot { axes: normals.cone, cos_outer: 0.6 };
        if cos < 0.59 {
            dark += 1;
            let upper = upper_geometric(&LightBounds { aabb: pair.lights, shape }, &towards, 0.0);
            spots += i32::from(upper == 0.0);
        }
    }
    assert!(terms.len() > 1_000 && cosines.len() > 1_000 && dark > 1_000);
    let (cosines, terms) = (median(cosines), median(terms));
    assert!(cosines < 1.005 && terms < 1.3 && spots > dark * 9 / 10, "{cosines} {terms} {spots} of {dark}");
}

#[test]
fn boxes_with_a_common_point_have_the_bound_of_the_clamp() {
    let at = |x: f32| Aabb { lo: Vec3::splat(x), hi: Vec3::splat(x + 1.0) };
    let lights = LightBounds { aabb: at(0.5), shape: LightShape::Oriented(Cone::of(Vec3::Z)) };
    let towards = Towards::between(&lights, &at(0.0));
    assert_eq!(towards.cone(), Cone::ALL);
    assert_eq!(towards.upper_cos(&Cone::of(Vec3::X)), 1.0);
    let upper = upper_geometric(&lights, &towards, 0.5);
    assert!((4.0..4.0001).contains(&upper), "{upper}");
    let unclamped = upper_geometric(&lights, &towards, 0.0);
    assert!((1e20..1.0001e20).contains(&unclamped), "{unclamped}");
}

/// A long box beside the origin: its directions fill almost half a turn, and some corners are
/// behind the plane orthogonal to the vector to its centre.
#[test]
fn cones_of_wide_boxes_are_narrower_than_half_of_all() {
    let b = Aabb { lo: Vec3::new(-3.0, 0.1, 0.0), hi: Vec3::new(10.0, 0.2, 0.0) };
    let cone = Towards::Box(b).cone();
    assert!(cone.axis.abs_diff_eq(Vec3::Y, f32::EPSILON), "{cone:?}");
    // The widest direction is the corner (10, 0.1, 0).
    assert!((cone.cos - 0.1 / 100.01f32.sqrt()).abs() < 1e-4, "{cone:?}");
    assert!(corners(&b).all(|d| cone.contains(d)));
}

#[test]
fn what_is_known_of_nothing_and_of_everything() {
    let unit = Aabb { lo: Vec3::ZERO, hi: Vec3::ONE };
    let far =
        LightBounds { aabb: Aabb { lo: Vec3::splat(5.0), hi: Vec3::splat(6.0) }, shape: LightShape::Omni };
    let boxed = Towards::between(&far, &unit);
    for towards in [boxed, Towards::Cone(Cone::of(Vec3::X)), Towards::Any] {
        assert_eq!(towards.upper_cos(&Cone::ALL), 1.0);
        assert_eq!(towards.upper_cos(&Cone::EMPTY), 0.0);
    }
    assert_eq!(Towards::Cone(Cone::EMPTY).upper_cos(&Cone::of(Vec3::X)), 0.0);
    assert_eq!(Towards::Cone(Cone::ALL).upper_cos(&Cone::of(Vec3::X)), 1.0);
    assert_eq!(Towards::Any.cone(), Cone::ALL);
    let mixed = LightBounds { shape: LightShape::Mixed { peak: 1.0 }, ..far };
    assert_eq!(Towards::between(&mixed, &unit), Towards::Any);
    // The bound of a directional light is 1; only the clamp bounds the nearest of the other lights.
    assert_eq!(upper_geometric(&mixed, &Towards::Any, 10.0), 1.0);
    assert_eq!(upper_geometric(&mixed, &Towards::Any, 0.5), 4.0);
    assert_eq!(
        upper_geometric(&LightBounds { shape: LightShape::Oriented(Cone::EMPTY), ..far }, &boxed, 0.0),
        0.0
    );
}
