//! The exact sum compared with formulas, for one light of each kind over a plane.

use std::f32::consts::PI;

use tashika::accel::Tracer;
use tashika::color::Rgb;
use tashika::film::Window;
use tashika::integrator::{Claim, FullSum, Integrator, PixelRecord, Setting};
use tashika::math::Vec3;
use tashika::scene::{Camera, Falloff, FalloffShape, Material};
use tashika::vpl::{Provenance, Vpl, VplKind, VplSet};

use crate::cases::{builder, cuboid, lambert, parallelogram, place, tracer, view};

const REFLECTANCE: f32 = 0.6;

/// The plane y = 0, seen from above; optionally with a block in the air.
fn plane(with_block: bool) -> Tracer {
    let mut b = builder();
    let floor = parallelogram(Vec3::new(-50.0, 0.0, -50.0), Vec3::Z * 100.0, Vec3::X * 100.0);
    place(&mut b, floor, Material::new("floor", lambert(REFLECTANCE)));
    if with_block {
        place(
            &mut b,
            cuboid(Vec3::new(-9.0, 1.0, -9.0), Vec3::new(0.0, 1.2, 9.0), false),
            Material::new("b", lambert(0.0)),
        );
    }
    b.add_camera(Camera::look_at("c", Vec3::new(0.0, 0.9, 0.0), Vec3::ZERO, Vec3::Z, 1.5)).unwrap();
    tracer(b)
}

fn light(kind: VplKind, direction: Vec3) -> Vpl {
    Vpl { position: Vec3::new(0.3, 2.0, -0.4), direction, intensity: Rgb::new(3.0, 5.0, 7.0), kind }
}

/// The estimate of each pixel of an 8×8 image, with the point on the floor that the pixel sees (one
/// gather point a pixel).
fn pixels(tracer: &Tracer, lights: Vec<Vpl>, clamp_distance: f32) -> Vec<(Vec3, PixelRecord)> {
    let set = VplSet::new(lights, Provenance { clamp_distance, ..Provenance::default() });
    let view = view(tracer.scene(), [8, 8], 1, 1);
    let setting = Setting { tracer, view };
    let estimates = FullSum::new(&set).estimate(&setting, &Window::full([8, 8]));
    let places = (0..64).map(|i| {
        // The camera ray is intersected with the plane by hand, rather than by the tracer.
        let ray = view.beginning([i % 8, i / 8], 0).0.ray().unwrap();
        ray.at(-ray.origin.y / ray.direction.y)
    });
    places.zip(estimates).collect()
}

fn assert_close(found: Rgb, expected: Rgb, what: &str) {
    for c in 0..3 {
        let error = (found[c] - expected[c]).abs();
        assert!(error <= 2e-5 * expected[c].abs(), "{what}: {found:?} for {expected:?}");
    }
}

#[test]
fn one_light_over_a_plane_follows_the_inverse_square_and_cosine_laws() {
    let tracer = plane(false);
    let down = Vec3::new(0.2, -1.0, 0.1).normalize();
    let falloff = Falloff { cos_inner: 0.97, cos_outer: 0.9, shape: FalloffShape::Squared };
    let kinds = [
        light(VplKind::Omni, Vec3::ZERO),
        light(VplKind::Oriented, down),
        light(VplKind::Spot(falloff), down),
        light(VplKind::Directional, down),
    ];
    let mut partly_lit_by_spot = 0;
    for clamp in [0.0, 2.1] {
        for l in kinds {
            for (x, e) in pixels(&tracer, vec![l], clamp) {
                let d = l.position - x;
                let (distance, cos_floor) = (d.length(), d.y / d.length());
                let cos_light = -d.dot(l.direction) / distance;
                let held = distance.max(clamp);
                let squared = held * held;
                let received = match l.kind {
                    VplKind::Omni => cos_floor / squared,
                    VplKind::Oriented => cos_light.max(0.0) * cos_floor / squared,
                    VplKind::Spot(_) => {
                        let s = ((cos_light - 0.9) / 0.07).clamp(0.0, 1.0);
                        partly_lit_by_spot += u32::from(s > 0.0 && s < 1.0);
                        s * s * cos_floor / squared
                    }
                    VplKind::Directional => -l.direction.y,
                    VplKind::Image(_) => unreachable!("in light_images"),
                    VplKind::Volume(_) => unreachable!("in volume_lights"),
                };
                let expected = l.intensity * (REFLECTANCE / PI * received);
                if expected.max_channel() < 1e-3 {
                    assert!(e.radiance.max_channel() < 2e-3);
                } else if matches!(l.kind, VplKind::Spot(_)) {
                    // The falloff amplifies rounding of the cosine by 1/0.07.
                    let error = (e.radiance.g - expected.g).abs();
                    assert!(error < 1e-3 * expected.g, "spot: {} for {}", e.radiance.g, expected.g);
                } else {
                    assert_close(e.radiance, expected, &format!("{:?}, clamp {clamp}", l.kind));
                }
                assert_eq!((e.claim, e.pairs), (Claim::Exact, 1));
            }
        }
    }
    assert!(partly_lit_by_spot > 5);
}

#[test]
fn light_from_behind_or_below_adds_nothing() {
    let tracer = plane(false);
    let mut below = light(VplKind::Omni, Vec3::ZERO);
    below.position.y = -1.0;
    let lights = vec![below, light(VplKind::Oriented, Vec3::Y), light(VplKind::Directional, Vec3::Y)];
    for (_, e) in pixels(&tracer, lights, 0.0) {
        assert_eq!(e.radiance, Rgb::BLACK);
        assert_eq!((e.pairs, e.rays), (3, 0), "what faces away costs no ray");
    }
}

#[test]
fn shadows_fall_where_geometry_says() {
    let tracer = plane(true);
    let lights = [
        light(VplKind::Omni, Vec3::ZERO),
        light(VplKind::Directional, Vec3::new(-0.3, -1.0, 0.0).normalize()),
    ];
    for l in lights {
        let mut counts = [0; 2];
        for (x, e) in pixels(&tracer, vec![l], 0.0) {
            let towards = if l.kind == VplKind::Directional { -l.direction } else { l.position - x };
            // `x` at the heights of the block's bottom and top, 1.0 and 1.2 m, on the way to the
            // light.
            let at = |y: f32| x.x + towards.x / towards.y * y;
            let (a, b) = (at(1.0), at(1.2));
            if a.min(b) > 1e-4 || (a.max(b) < -1e-4) {
                let blocked = a < 0.0;
                counts[usize::from(blocked)] += 1;
                assert_eq!(e.radiance == Rgb::BLACK, blocked, "at {x:?}");
            }
        }
        assert!(counts[0] > 5 && counts[1] > 5, "{counts:?}");
    }
}

#[test]
fn twice_the_light_is_twice_the_radiance_to_the_bit() {
    let tracer = plane(true);
    let lights: Vec<Vpl> = (0..50)
        .map(|i| Vpl {
            position: Vec3::new((i % 7) as f32 - 3.0, 1.5 + 0.1 * i as f32, (i % 5) as f32 - 2.0),
            ..light(VplKind::Oriented, Vec3::NEG_Y)
        })
        .collect();
    let doubled = lights.iter().map(|l| Vpl { intensity: l.intensity * 2.0, ..*l }).collect();
    for ((_, a), (_, b)) in pixels(&tracer, lights, 0.1).into_iter().zip(pixels(&tracer, doubled, 0.1)) {
        assert_eq!(a.radiance * 2.0, b.radiance);
    }
}
