//! Tests of the bounds of scattering in media, at gather points and at lights. Random members are
//! evaluated by the `f32` formulas of `contribution`.

use super::cases::{KINDS, log_uniform, random_point, reflected};
use super::many;
use crate::bounds::{
    LightBounds, LightShape, Towards, UpperAnalytic, UpperMaterial, UpperScattering, upper_geometric,
    upper_transmittance,
};
use crate::bsdf::HenyeyGreenstein;
use crate::color::Rgb;
use crate::contribution::ContributionKernel;
use crate::gather::GatherPoint;
use crate::math::elementary::{exp, sin_cos};
use crate::math::{Aabb, Cone, Vec3};
use crate::media::Scattering;
use crate::rng::{Purpose, Stream};
use crate::scene::MediumId;
use crate::vpl::{Vpl, VplKind};
use crate::warp;

/// A unit vector within `angle` (rad) of `axis`.
fn near(axis: Vec3, angle: f32, s: &mut Stream) -> Vec3 {
    let (sin, cos) = sin_cos(angle * s.uniform());
    let across = warp::sphere(s.uniform_2()).cross(axis).normalize_or(axis.any_orthonormal_vector());
    (axis * cos + across * sin).normalize()
}

/// A box around `center` of roughly the given size; any side may be zero.
fn a_box(center: Vec3, size: f32, s: &mut Stream) -> Aabb {
    let mut side = || if s.below(4) == 0 { 0.0 } else { size * s.uniform() };
    let half = 0.5 * Vec3::new(side(), side(), side());
    Aabb { lo: center - half, hi: center + half }
}

fn inside(b: &Aabb, s: &mut Stream) -> Vec3 {
    (b.lo + (b.hi - b.lo) * Vec3::from(s.uniform_3())).clamp(b.lo, b.hi)
}

/// Phase function with an asymmetry near `about`, occasionally with a peak of up to 10⁴.
fn asymmetry(about: f32, s: &mut Stream) -> HenyeyGreenstein {
    HenyeyGreenstein { asymmetry: (about + 0.2 * (s.uniform() - 0.5)).clamp(-0.98, 0.98) }
}

/// Clusters of lights in media, and clusters of points in media and on surfaces. No term exceeds
/// the product of the bounds, and for a single pair the bounds are sharp.
#[test]
fn bounds_of_media_hold_and_are_sharp() {
    let mut s = Stream::new(11, Purpose::Test, 0);
    let (mut checked, mut ratios) = (0, Vec::new());
    for round in 0..many(20_000) {
        let single = round % 3 == 0;
        let (size, spread) =
            if single { (0.0, 0.0) } else { (log_uniform(&mut s, 1e-3, 3.0), s.uniform() * 2.0) };
        let between = warp::sphere(s.uniform_2()) * log_uniform(&mut s, 0.1, 30.0);
        let (lights_in, points_in) = (a_box(between, size, &mut s), a_box(Vec3::ZERO, size, &mut s));
        let (axis, before) =
            (warp::sphere(s.uniform_2()).normalize(), warp::sphere(s.uniform_2()).normalize());
        let (g, h) = (1.9 * s.uniform() - 0.95, 1.9 * s.uniform() - 0.95);
        let lights: Vec<Vpl> = (0..if single { 1 } else { 6 })
            .map(|_| Vpl {
                position: inside(&lights_in, &mut s),
                direction: near(axis, spread, &mut s),
                intensity: Rgb::WHITE,
                kind: VplKind::Volume(asymmetry(g, &mut s)),
            })
            .collect();
        let points: Vec<GatherPoint> = (0..lights.len())
            .map(|_| {
                let (place, before) = (inside(&points_in, &mut s), near(before, spread, &mut s));
                let phase = asymmetry(h, &mut s);
                let at = Scattering { place, before, medium: MediumId::at(0), phase };
                GatherPoint::in_medium(&at, Rgb::WHITE)
            })
            .collect();
        let of_light = |light: &Vpl| {
            let VplKind::Volume(phase) = light.kind else { unreachable!("all lie in media") };
            let directions = Cone::of(light.direction);
            let shape = LightShape::Volume { directions, asymmetry: [phase.asymmetry; 2] };
            LightBounds { aabb: Aabb { lo: light.position, hi: light.position }, shape }
        };
        let bounds = lights.iter().map(of_light).reduce(LightBounds::union).unwrap();
        let of_point = |point: &GatherPoint| {
            UpperScattering::<UpperAnalytic>::of_medium(point.before(), point.phase.unwrap())
        };
        let mut material = of_point(&points[0]);
        points[1..].iter().for_each(|point| material.merge(&of_point(point)));
        let towards = Towards::between(&bounds, &Aabb::of_points(points.iter().map(|p| p.position)));
        let clamp = [0.0, 0.5][round % 2];
        let upper = upper_geometric(&bounds, &towards, clamp) * material.upper_material(&towards);
        // A mixed cluster bounds the same lights at any position.
        let omni = LightBounds { shape: LightShape::Omni, ..bounds };
        let mixed = bounds.union(omni);
        let anywhere = Towards::between(&mixed, &Aabb::EMPTY);
        let of_mixed = upper_geometric(&mixed, &anywhere, 0.5) * material.upper_material(&anywhere);
        let kernel = ContributionKernel::new(clamp);
        let mut largest = 0.0_f32;
        for light in &lights {
            for point in &points {
                let value = kernel.unoccluded(point, light).r;
                assert!(value <= upper.next_up(), "{value} > {upper}: {light:?} {point:?}");
                let clamped = ContributionKernel::new(0.5).unoccluded(point, light).r;
                assert!(clamped <= of_mixed.next_up(), "{clamped} > {of_mixed}: {light:?} {point:?}");
                largest = largest.max(value);
                checked += 1;
            }
        }
        if single {
            ratios.push(f64::from(upper / largest));
        }
    }
    // Cosines have a slack of about 10⁻⁵, which changes the narrowest lobes, with an asymmetry of
    // 0.98, by a few per cent at their edges.
    ratios.sort_by(f64::total_cmp);
    let [median, most] = [ratios[ratios.len() / 2], ratios[ratios.len() - 1]];
    assert!(median < 1.001 && most < 1.2, "{median}, {most}");
    assert!(checked > 100_000, "{checked}");
}

/// No transmittance between members of two clusters exceeds the bound. For a single pair the bound
/// is sharp.
#[test]
fn bounds_of_transmittance_hold_and_are_sharp() {
    let mut s = Stream::new(13, Purpose::Test, 0);
    let mut dimmed = 0;
    for round in 0..many(20_000) {
        let single = round % 3 == 0;
        let size = if single { 0.0 } else { log_uniform(&mut s, 1e-3, 3.0) };
        let between = warp::sphere(s.uniform_2()) * log_uniform(&mut s, 1e-3, 1e3);
        let (lights, points) = (a_box(between, size, &mut s), a_box(Vec3::ZERO, size, &mut s));
        let sigma = log_uniform(&mut s, 1e-4, 1e2);
        let bounds = LightBounds { aabb: lights, shape: LightShape::Omni };
        let upper = upper_transmittance(sigma, &Towards::between(&bounds, &points));
        assert!(upper <= 1.0);
        for _ in 0..4 {
            let metres = inside(&points, &mut s).distance(inside(&lights, &mut s));
            let left = exp(-sigma * metres);
            assert!(left <= upper, "{left} > {upper}: {lights:?}, {points:?}, {sigma}");
            // For an optical thickness of up to 80, the bound is off by 80 times the allowance.
            assert!(!single || upper <= left * 1.001 + f32::MIN_POSITIVE, "{upper} for {left}");
            dimmed += u32::from((0.1..0.9).contains(&upper));
        }
    }
    assert!(dimmed > 5_000, "{dimmed}");
    assert_eq!(upper_transmittance(3.0, &Towards::Any), 1.0);
}

/// The bound of points on surfaces and in media together is the larger of the two bounds. The bound
/// of points on surfaces alone is the same as without media.
#[test]
fn surfaces_and_media_are_bounded_together() {
    let mut s = Stream::new(12, Purpose::Test, 0);
    for round in 0..many(4_000) {
        let reflector = random_point(KINDS[round % KINDS.len()], &mut s);
        let before = warp::sphere(s.uniform_2()).normalize();
        let phase = asymmetry(1.8 * s.uniform() - 0.9, &mut s);
        let cone = Cone::of(warp::sphere(s.uniform_2()).normalize());
        let cone = cone.union(Cone::of(near(cone.axis, 0.5, &mut s)));
        let towards = Towards::Cone(cone);
        let surface = UpperScattering::<UpperAnalytic>::of_surface(&reflector);
        let alone = UpperAnalytic::of_point(&reflector).upper_material(&towards);
        assert_eq!(surface.upper_material(&towards), alone);
        let medium = UpperScattering::<UpperAnalytic>::of_medium(before, phase);
        let of_medium = medium.upper_material(&towards);
        for (mut one, other) in [(surface, medium), (medium, surface)] {
            one.merge(&other);
            assert_eq!(one.upper_material(&towards), alone.max(of_medium));
        }
        let direction = cone.axis;
        let [_, value] = reflected(&reflector, direction);
        assert!(value <= alone, "{value} > {alone}");
        assert!(phase.density(before.dot(direction)) <= of_medium);
    }
}
