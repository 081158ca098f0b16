//! Lamps of alpha 0: they are invisible, and emit fully.

use tashika::color::Rgb;
use tashika::integrator::{PathStop, PathTracer};
use tashika::math::Vec3;
use tashika::scene::{Alpha, AlphaMode, Camera, Material, SceneBuilder};

use super::light_transport::agree;
use super::pbrt::{V3, V4, notes, scene};
use crate::cases::{builder, diffuse_room, film, glowing, lambert, luminances, parallelogram, place, tracer};

/// Adds an invisible square of 0.8 m a side that emits downward.
fn add_unseen_lamp(b: &mut SceneBuilder, height: f32, radiance: f32) {
    let lamp = parallelogram(Vec3::new(-0.4, height, -0.4), Vec3::X * 0.8, Vec3::Z * 0.8);
    let alpha = Some(Alpha { value: 0.0.into(), mode: AlphaMode::Unseen });
    place(b, lamp, Material { alpha, ..glowing("lamp", lambert(0.3), radiance) });
}

#[test]
fn what_is_below_is_lit_in_full_and_seen_through_the_lamp() {
    let mut b = builder();
    let floor = parallelogram(Vec3::new(-9.0, 0.0, -9.0), Vec3::Z * 18.0, Vec3::X * 18.0);
    place(&mut b, floor, Material::new("floor", lambert(0.6)));
    add_unseen_lamp(&mut b, 1.0, 10.0);
    // The camera looks down through the lamp. Its view is so narrow that the whole film is the
    // point below the lamp's centre.
    b.add_camera(Camera::look_at("c", Vec3::new(0.0, 2.0, 0.0), Vec3::ZERO, Vec3::Z, 1e-3)).unwrap();
    let tracer = tracer(b);
    let path = PathTracer::new(&tracer, PathStop::Count(20_000), 8).unwrap();
    let film = film(&tracer, &path, [1, 1], 1, 3);
    let error = f64::from(film.plane("standard_error").unwrap().f32_samples().unwrap()[0]);
    // Expected radiance `ρ L F`, with the form factor of a square over an element below its middle
    // (Howell, B-3).
    let x = 0.4_f64;
    let root = (1.0 + x * x).sqrt();
    let factor = 4.0 * 2.0 * (x / root) * (x / root).atan() / (2.0 * std::f64::consts::PI);
    let expected = 0.6 * 10.0 * factor;
    let found = luminances(&film)[0];
    assert!(error < 0.005 * expected, "{error}: the comparison is sharp");
    // Tolerance at a two-sided level of 10⁻⁶.
    assert!((found - expected).abs() < 4.9 * error, "{found} ± {error} for {expected}");
}

#[test]
fn vpls_and_paths_of_an_unseen_lamp_agree() {
    let mut b = diffuse_room();
    add_unseen_lamp(&mut b, 1.9, 5.0);
    agree(b, "a lamp that is not seen");
}

#[test]
fn lamps_of_pbrt_with_alpha_0_are_unseen_and_others_are_as_opaque_as_they_say() {
    let lamp = |head: &str, alpha: &str| {
        let end = if head == V3 { "WorldEnd" } else { "" };
        scene(&format!("{head} AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] Shape \"sphere\" {alpha} {end}"))
    };
    for head in [V3, V4] {
        let dark = lamp(head, "\"float alpha\" 0");
        assert_eq!(notes(&dark), []);
        let material = &dark.materials()[dark.meshes()[0].material.index()];
        assert_eq!(material.alpha.unwrap().mode, AlphaMode::Unseen);
        assert_eq!(material.emission.unwrap().radiance.factor, Rgb::WHITE);
    }
    let half = lamp(V4, "\"float alpha\" 0.5");
    let material = &half.materials()[half.meshes()[0].material.index()];
    assert_eq!((material.alpha.unwrap().mode, material.alpha.unwrap().value.factor), (AlphaMode::Blend, 0.5));
    // A shape of alpha 0 that does not emit is omitted.
    assert!(scene(&format!("{V4} Shape \"sphere\" \"float alpha\" 0")).instances().is_empty());
}
