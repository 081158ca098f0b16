//! Results are finite for every input, reciprocal, and equal on both sides; errors name the value
//! out of range.

use super::super::{Bsdf, BsdfSample, CoatModel, ConductorFresnel, MIN_ALPHA, MIN_COSINE};
use super::cases::{self, Case};
use super::{direction_above, stream};
use crate::color::Rgb;
use crate::math::Vec3;
use crate::rng::Stream;

/// Returns a random unit vector. One in three is degenerate: along an axis, in the surface, or
/// nearly so.
fn any_direction(stream: &mut Stream) -> Vec3 {
    let generic = crate::warp::sphere(stream.uniform_2());
    let tiny = [0.0, -0.0, 1e-38, 1e-20, MIN_COSINE, -MIN_COSINE, 1.1e-7, 1e-4];
    match stream.below(12) {
        0 => Vec3::Z,
        1 => Vec3::NEG_Z,
        2 => Vec3::X,
        3 => Vec3::new(generic.x, generic.y, tiny[stream.below(8) as usize]).normalize_or(Vec3::NEG_X),
        _ => generic,
    }
}

/// 100,000 random surfaces and pairs of directions: random, degenerate, equal, opposite, or
/// mirrored. All results are finite and not negative.
#[test]
fn everything_is_finite_and_not_negative() {
    let mut stream = stream(30);
    for round in 0..100_000 {
        let bsdf = cases::random(&mut stream);
        let wo = any_direction(&mut stream);
        let wi = match stream.below(8) {
            0 => wo,
            1 => -wo,
            2 => Vec3::new(-wo.x, -wo.y, wo.z),
            _ => any_direction(&mut stream),
        };
        let context = || format!("round {round}: {bsdf:?}, wo {wo:?}, wi {wi:?}");
        assert!(bsdf.eval(wo, wi).is_valid(), "eval, {}", context());
        assert!(bsdf.eval_cos(wo, wi).is_valid(), "eval_cos, {}", context());
        assert!(bsdf.vpl_reflectance(wo).is_valid(), "vpl_reflectance, {}", context());
        let pdf = bsdf.pdf(wo, wi);
        assert!(pdf.is_finite() && pdf >= 0.0, "pdf, {}", context());
        if wo.z * wi.z <= 0.0 {
            assert!(bsdf.eval(wo, wi).is_black() && pdf == 0.0, "other side, {}", context());
        }
        // Some numbers are the least and the largest that a stream can return.
        let end = 1.0 - f32::EPSILON / 2.0;
        let u = stream.uniform_3().map(|u| {
            if u < 0.02 {
                0.0
            } else if u > 0.98 {
                end
            } else {
                u
            }
        });
        if let Some(s) = bsdf.sample(wo, u) {
            assert!(s.pdf > 0.0 && s.pdf.is_finite(), "sample {s:?}, {}", context());
            assert!(s.weight.is_valid() && !s.weight.is_black(), "sample {s:?}, {}", context());
            assert!((s.wi.length() - 1.0).abs() < 1e-6, "sample {s:?}, {}", context());
        }
    }
}

/// `f(a, b) = f(b, a)`, to the rounding of products in another order.
#[test]
fn opaque_surfaces_are_reciprocal() {
    let mut stream = stream(31);
    for Case { name, bsdf } in cases::smooth() {
        // Layers are not reciprocal by definition: they reduce the light of their base by the share
        // that they reflect towards the viewer.
        if matches!(bsdf, Bsdf::Layered(b) if b.left(0.5) < 1.0) {
            continue;
        }
        for _ in 0..1000 {
            let a = direction_above(&mut stream);
            let mirror = Vec3::new(-a.x, -a.y, a.z);
            let near_mirror = (mirror + 0.01 * direction_above(&mut stream)).normalize();
            for b in [direction_above(&mut stream), near_mirror] {
                let (forth, back) = (bsdf.eval(a, b), bsdf.eval(b, a));
                let difference = (forth - back).map(f32::abs).max_channel();
                assert!(difference <= 1e-6 * forth.max_channel(), "{name}: {forth:?}, {back:?}");
            }
        }
    }
}

/// Both sides of an opaque surface are equal, and no light passes between them.
#[test]
fn opaque_surfaces_are_two_sided() {
    let below = |w: Vec3| Vec3::new(w.x, w.y, -w.z);
    let mut stream = stream(32);
    for Case { name, bsdf } in cases::smooth() {
        for _ in 0..200 {
            let (a, b) = (direction_above(&mut stream), direction_above(&mut stream));
            assert_eq!(bsdf.eval(a, b), bsdf.eval(below(a), below(b)), "{name}");
            assert_eq!(bsdf.pdf(a, b), bsdf.pdf(below(a), below(b)), "{name}");
            assert!(bsdf.eval(a, below(b)).is_black() && bsdf.eval(below(a), b).is_black(), "{name}");
            let u = stream.uniform_3();
            let (over, under) = (bsdf.sample(a, u), bsdf.sample(below(a), u));
            let parts = |s: BsdfSample| (s.weight, s.pdf, s.lobe);
            assert_eq!(over.map(parts), under.map(parts), "{name}");
            assert_eq!(over.map(|s| s.wi), under.map(|s| below(s.wi)), "{name}");
        }
    }
}

/// Specular lobes have no value and no density, only samples.
#[test]
fn specular_surfaces_have_no_density() {
    let specular: Vec<Case> = cases::all().into_iter().filter(|case| case.bsdf.is_specular()).collect();
    assert!(specular.len() >= 2);
    let wo = super::outgoing(0.6);
    for Case { name, bsdf } in specular {
        let sample = bsdf.sample(wo, [0.0, 0.5, 0.5]).expect("reflects");
        assert!(sample.lobe.is_specular(), "{name}");
        assert!(bsdf.eval(wo, sample.wi).is_black() && bsdf.pdf(wo, sample.wi) == 0.0, "{name}");
    }
}

#[test]
fn black_surfaces_end_paths() {
    let metal = ConductorFresnel::Exact { eta: Rgb::WHITE, k: Rgb::BLACK };
    let black = [
        cases::lambert(Rgb::BLACK),
        cases::phong(Rgb::BLACK, Rgb::BLACK, 10.0),
        cases::conductor(metal, 0.5),
        cases::coated(Rgb::BLACK, Rgb::BLACK, 1.5, 0.5),
        cases::glass(1.5, Rgb::BLACK, Rgb::BLACK),
    ];
    let mut stream = stream(33);
    for bsdf in black {
        for _ in 0..100 {
            let wo = super::outgoing(0.3 + 0.7 * stream.uniform());
            let sample = bsdf.sample(wo, stream.uniform_3());
            // A conductor of index 1 leaves a rounding of F.
            assert!(sample.is_none_or(|s| s.weight.max_channel() < 1e-6), "{bsdf:?}: {sample:?}");
        }
    }
}

/// Each parameter is accepted just inside its range and rejected just outside. The message names
/// field, value and range.
#[test]
fn validation_names_field_value_and_range() {
    let half = Rgb::gray(0.5);
    let schlick = |f0| ConductorFresnel::Schlick { f0 };
    let exact = |eta, k| ConductorFresnel::Exact { eta: Rgb::gray(eta), k: Rgb::gray(k) };
    let refused: [(Bsdf, &str); 20] = [
        (cases::lambert(Rgb::new(0.5, 1.5, 0.5)), "reflectance.g = 1.5; expected 0 to 1"),
        (cases::lambert(Rgb::new(0.5, 0.5, f32::NAN)), "reflectance.b = NaN; expected 0 to 1"),
        (cases::phong(half, Rgb::gray(-0.1), 1.0), "specular.r = -0.1; expected 0 to 1"),
        (cases::phong(half, Rgb::gray(0.75), 1.0), "(diffuse + specular).r = 1.25; expected 0 to 1"),
        (cases::phong(half, half, -1.0), "exponent = -1; expected 0 to 1000000"),
        (cases::phong(half, half, f32::INFINITY), "exponent = inf; expected 0 to 1000000"),
        (cases::conductor(schlick(Rgb::gray(2.0)), 0.5), "f0.r = 2; expected 0 to 1"),
        (cases::conductor(exact(0.0, 1.0), 0.5), "eta.r = 0; expected 0.001 to 100"),
        (cases::conductor(exact(1.0, -1.0), 0.5), "k.r = -1; expected 0 to 100"),
        (cases::conductor(schlick(half), 0.5 * MIN_ALPHA), "alpha = 0.0005; expected 0.001 to 1"),
        (cases::coated(half, half, 1.0, 0.5), "ior = 1; expected 1.0001 to 5"),
        (cases::coated(half, half, 1.5, 1.1), "alpha = 1.1; expected 0.001 to 1"),
        (cases::metallic_roughness(half, Rgb::gray(f32::INFINITY), 0.5), "f0.r = inf; expected 0 to 1"),
        (
            cases::clearcoat(cases::lambert(half), 1.5, 0.1, CoatModel::Layer),
            "amount of the coat = 1.5; expected 0 to 1",
        ),
        (
            cases::clearcoat(cases::lambert(half), 1.0, 0.2, CoatModel::Disney),
            "alpha of the coat = 0.2; expected 0.001 to 0.1",
        ),
        (
            cases::clearcoat(cases::lambert(half), 1.0, f32::NAN, CoatModel::Layer),
            "alpha of the coat = NaN; expected 0.001 to 1",
        ),
        (
            cases::clearcoat(cases::lambert(Rgb::gray(2.0)), 1.0, 0.1, CoatModel::Mitsuba),
            "reflectance.r = 2; expected 0 to 1",
        ),
        (
            cases::sheen(cases::lambert(half), Rgb::gray(1.5), 0.5),
            "colour of the sheen.r = 1.5; expected 0 to 1",
        ),
        (cases::sheen(cases::lambert(half), half, 0.05), "roughness of the sheen = 0.05; expected 0.1 to 1"),
        (cases::glass(5.5, half, half), "ior = 5.5; expected 1.0001 to 5"),
    ];
    for (bsdf, message) in refused {
        assert_eq!(bsdf.validate().expect_err(message), message);
    }
    let accepted = [
        cases::phong(Rgb::gray(0.1), Rgb::gray(0.9), 1e6),
        cases::conductor(exact(0.001, 100.0), MIN_ALPHA),
        cases::coated(Rgb::BLACK, Rgb::WHITE, 1.0001, 1.0),
        cases::glass(5.0, Rgb::BLACK, Rgb::WHITE),
    ];
    for bsdf in accepted {
        assert_eq!(bsdf.validate(), Ok(()), "{bsdf:?}");
    }
}
