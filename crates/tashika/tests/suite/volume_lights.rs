//! Sums over VPLs in participating media: the whole sum against quadrature and against the path
//! tracer, which shares none of its estimators, and cuts against the whole sum.

use tashika::accel::Tracer;
use tashika::bsdf::HenyeyGreenstein;
use tashika::color::Rgb;
use tashika::integrator::FullSum;
use tashika::math::Vec3;
use tashika::scene::{Camera, Emitter, Environment, Material, MediumId, Scattered, SceneBuilder, Surface};
use tashika::stats::Moments;
use tashika::tree::LightSet;
use tashika::vpl::{Clamp, VplKind, VplOptions, VplSet};

use crate::cases::{
    add_ceiling_lamp, builder, cuboid, diffuse_room, diffuse_walls, film, glowing, lambert, parallelogram,
    place, room_camera, tracer,
};
use crate::grid_media;
use crate::media::{
    ALBEDO, EXTINCTION, add, assert_means, barely_scattering, bounding, colors, needle, scattered_once,
};
use crate::sums::{
    assert_cuts_keep_their_claims, assert_finest_cuts_are_whole, assert_same_bits,
    assert_sums_are_what_paths_find, directly_lit, set,
};

/// A point light beside the axis of a camera in fog, with gather points in the fog.
#[test]
fn light_that_is_scattered_once_is_that_of_quadrature() {
    let mut b = builder();
    let fog = barely_scattering(&mut b);
    b.add_emitter(Emitter::Point { position: Vec3::new(0.4, -0.3, -1.0), intensity: Rgb::WHITE }).unwrap();
    b.add_camera(needle(Vec3::ZERO, Some(fog))).unwrap();
    let expected = EXTINCTION.map(|sigma| {
        scattered_once(f64::from(sigma), 40.0 / f64::from(sigma), [0.4, -0.3, -1.0], |d, _| 1.0 / (d * d))
    });
    let found = directly_lit(&tracer(b), 1, [16, 16], 1000, 3);
    assert_means(&found, expected, f64::from(ALBEDO) + 1e-4, 0.01, "a point");
}

/// An area lamp beside the axis. VPLs on surfaces light points in media with the cosine at the
/// surface.
#[test]
fn a_lamp_in_fog_is_that_of_quadrature() {
    let mut b = builder();
    let fog = barely_scattering(&mut b);
    let lamp = parallelogram(Vec3::new(-0.25, -0.5, -1.5), Vec3::Y, Vec3::Z);
    place(&mut b, lamp, glowing("lamp", lambert(0.0), 1.0));
    let black = parallelogram(Vec3::new(-1.0, -1.0, -2.0), Vec3::X * 2.0, Vec3::Y * 2.0);
    place(&mut b, black, Material::new("end", lambert(0.0)));
    b.add_camera(needle(Vec3::ZERO, Some(fog))).unwrap();
    let cells = 24;
    let expected = EXTINCTION.map(|sigma| {
        let cell = |k: i32| (f64::from(k) + 0.5) / f64::from(cells);
        let from = |y: i32, z: i32| [-0.25, cell(y) - 0.5, cell(z) - 1.5];
        let of = |d: f64, cos: f64| cos.max(0.0) / (d * d);
        let all = (0..cells).flat_map(|y| (0..cells).map(move |z| (y, z)));
        all.map(|(y, z)| scattered_once(f64::from(sigma), 2.0, from(y, z), of)).sum::<f64>()
            / f64::from(cells * cells)
    });
    let found = directly_lit(&tracer(b), 2000, [16, 16], 200, 3);
    // Quadrature by midpoints of 1/24 m at a distance of 1/4 m. The lamp's VPLs are spread evenly
    // over its length and at random over its width: half a per cent.
    assert_means(&found, expected, f64::from(ALBEDO) + 1e-3 + 5e-3, 0.01, "a lamp");
}

/// A beam along the axis of the camera scatters in fog and lights a small white tile beside it.
/// VPLs in the fog carry this light. The irradiance of the tile is an integral over the beam:
/// transmittance to a point, phase function, and transmittance from there to the tile.
#[test]
fn a_beam_lights_a_tile_as_quadrature_says() {
    let mut b = builder();
    let fog = barely_scattering(&mut b);
    // A narrow spot at the origin shines along −z. A black wall ends the beam after 2 m.
    let falloff = tashika::scene::Falloff {
        cos_inner: 0.999_99,
        cos_outer: 0.999_98,
        shape: tashika::scene::FalloffShape::Squared,
    };
    let flux = f64::from(falloff.solid_angle());
    let axis = Vec3::NEG_Z;
    b.add_emitter(Emitter::Spot { position: Vec3::ZERO, axis, intensity: Rgb::WHITE, falloff }).unwrap();
    let black = parallelogram(Vec3::new(-1.0, -1.0, -2.0), Vec3::X * 2.0, Vec3::Y * 2.0);
    place(&mut b, black, Material::new("end", lambert(0.0)));
    // The tile at (0.5, 0, −1) faces the beam. The camera is 1 mm in front of it.
    let tile = parallelogram(Vec3::new(0.5, -0.1, -1.1), Vec3::Z * 0.2, Vec3::Y * 0.2);
    place(&mut b, tile, Material::new("tile", lambert(1.0)));
    let at = Vec3::new(0.5, 0.0, -1.0);
    let camera = Camera::look_at("c", at - Vec3::X * 1e-3, at, Vec3::Y, 1e-4);
    b.add_camera(Camera { medium: Some(fog), ..camera }).unwrap();
    let tracer = tracer(b);
    let mut means = [Moments::default(); 3];
    for seed in 1..=20 {
        let options =
            VplOptions { count: 5000, seed, direct_share: 0.0, clamp: Clamp::Off, ..VplOptions::default() };
        let lights = VplSet::trace(&tracer, &options).unwrap();
        assert!(lights.lights().iter().any(|light| matches!(light.kind, VplKind::Volume(_))));
        let found = film(&tracer, &FullSum::new(&lights), [2, 2], 4, seed);
        let found = colors(&found)[0];
        (0..3).for_each(|k| means[k].push(found[k].into()));
    }
    let steps = 4000;
    for (k, sigma) in EXTINCTION.map(f64::from).into_iter().enumerate() {
        let of_step = |i: i32| {
            let t = 2.0 * (f64::from(i) + 0.5) / f64::from(steps);
            // From the beam at (0, 0, −t) to the tile, whose normal is −x.
            let to = [0.5, 0.0, t - 1.0];
            let d = (to[0] * to[0] + to[2] * to[2]).sqrt();
            let (cos_turn, cos_tile) = (-to[2] / d, to[0] / d);
            let phase = f64::from(HenyeyGreenstein { asymmetry: 0.5 }.density(cos_turn as f32));
            let left = tashika::math::elementary::exp_f64(-sigma * (t + d));
            f64::from(ALBEDO) * sigma * left * phase * cos_tile / (d * d)
        };
        let integral = (0..steps).map(of_step).sum::<f64>() * 2.0 / f64::from(steps);
        let expected = flux * integral / std::f64::consts::PI;
        let (mean, error) = (means[k].mean(), means[k].standard_error());
        assert!(error < 0.03 * expected, "not sharp: {mean} ± {error}");
        let bound = 4.42 * error + 2e-3 * expected;
        assert!((mean - expected).abs() < bound, "{mean} ± {error} for {expected}");
    }
}

/// [`diffuse_walls`] with the objects that `add` places. The camera is in the medium that `add`
/// returns.
fn room_with(add: impl FnOnce(&mut SceneBuilder) -> Option<MediumId>) -> Tracer {
    let mut b = diffuse_walls();
    let medium = add(&mut b);
    b.add_camera(Camera { medium, ..room_camera() }).unwrap();
    tracer(b)
}

/// A lamp in a room full of fog, which has no boundary.
fn fog(b: &mut SceneBuilder) -> MediumId {
    add_ceiling_lamp(b, 5.0);
    add(b, [0.02; 3], [0.2, 0.4, 0.6], 0.4)
}

fn milk(b: &mut SceneBuilder) -> Option<MediumId> {
    Some(add(b, [0.0, 0.1, 0.2], [4.0; 3], 0.0))
}

/// A block of milk in the room; `outside` is the medium around it.
fn block_of_milk(b: &mut SceneBuilder, outside: Option<MediumId>) {
    let milk = milk(b);
    let block = cuboid(Vec3::new(-0.7, 0.2, 0.2), Vec3::new(0.0, 0.9, 0.9), false);
    bounding(b, block, Surface::Boundary, [milk, outside]);
}

/// Smoke in a part of the room, whose density increases upwards.
fn smoke(b: &mut SceneBuilder) -> MediumId {
    let box_ = [Vec3::new(-0.8, 0.1, -0.8), Vec3::new(0.8, 1.8, 0.8)];
    let density = grid_media::grid([2, 5, 3], box_, |[x, y, _]| [0.2 + 2.0 * y * y + x; 3]);
    grid_media::add(b, [[0.1, 0.2, 0.3], [0.8, 0.6, 0.4]], -0.3, Some(density), Scattered::Evenly)
}

/// Fog with blocks of milk and smoke, with lamps inside and outside, and with light from infinity.
/// The sum over VPLs equals the result of paths. Means over the image and several sets agree within
/// 4.4 standard errors, and within the share of light that a clamp of 2 cm takes from VPLs in the
/// medium. Of the light that is scattered twice there, that share is `σ_s` times two thirds of 2
/// cm, 5 % in the milk.
#[test]
fn sums_over_vpls_are_what_paths_find() {
    let sky = |b: &mut SceneBuilder| b.set_environment(Environment::constant(Rgb::gray(0.5))).unwrap();
    let scenes: [(&str, Tracer, f64); 6] = [
        ("fog", room_with(|b| Some(fog(b))), 0.01),
        (
            "milk in fog",
            room_with(|b| {
                let fog = Some(fog(b));
                block_of_milk(b, fog);
                fog
            }),
            0.02,
        ),
        (
            "milk under a sky",
            room_with(|b| {
                block_of_milk(b, None);
                sky(b);
                None
            }),
            0.02,
        ),
        (
            "a lamp in milk",
            room_with(|b| {
                block_of_milk(b, None);
                let lamp = cuboid(Vec3::new(-0.45, 0.45, 0.45), Vec3::new(-0.25, 0.65, 0.65), false);
                place(b, lamp, glowing("lamp", lambert(0.3), 5.0));
                None
            }),
            0.02,
        ),
        (
            "smoke",
            room_with(|b| {
                add_ceiling_lamp(b, 5.0);
                let sun = Vec3::new(0.3, -0.4, -0.85).normalize();
                b.add_emitter(Emitter::Directional { direction: sun, irradiance: Rgb::WHITE }).unwrap();
                Some(smoke(b))
            }),
            0.01,
        ),
        (
            "a camera in milk",
            room_with(|b| {
                add_ceiling_lamp(b, 5.0);
                let milk = Some(add(b, [0.05; 3], [0.5; 3], 0.7));
                let about = cuboid(Vec3::new(-5.0, -5.0, 1.2), Vec3::new(5.0, 5.0, 9.0), false);
                bounding(b, about, Surface::Boundary, [milk, None]);
                milk
            }),
            0.01,
        ),
    ];
    for (name, tracer, taken_away) in &scenes {
        assert_sums_are_what_paths_find(name, tracer, *taken_away, 6);
    }
}

/// Fog with milk and smoke: three media, an interface, and drawn transmittances.
fn all_media() -> Tracer {
    room_with(|b| {
        let fog = Some(fog(b));
        block_of_milk(b, fog);
        let smoke = Some(smoke(b));
        let cell = cuboid(Vec3::new(0.2, 0.5, -0.6), Vec3::new(0.8, 1.5, 0.6), false);
        bounding(b, cell, Surface::Boundary, [smoke, fog]);
        fog
    })
}

/// In part of the scene transmittances are drawn.
#[test]
fn the_finest_cut_is_the_whole_sum() {
    let tracer = all_media();
    let lights = LightSet::new(set(&tracer, 150, 4, Clamp::Auto));
    let in_media = lights.set().lights().iter().filter(|l| matches!(l.kind, VplKind::Volume(_))).count();
    assert!(in_media > 30, "{in_media}");
    assert_finest_cuts_are_whole(&tracer, &lights);
}

#[test]
fn cuts_estimate_the_sum_and_keep_their_claims() {
    let tracer = all_media();
    assert_cuts_keep_their_claims(&tracer, &LightSet::new(set(&tracer, 20_000, 4, Clamp::Auto)));
}

#[test]
fn threads_and_tiles_change_no_bit() {
    assert_same_bits(all_media);
}

/// Unbounded fog blocks light from infinity, and light paths that start there create no VPLs.
#[test]
fn nothing_comes_from_infinity_through_endless_fog() {
    let tracer = room_with(|b| {
        b.set_environment(Environment::constant(Rgb::WHITE)).unwrap();
        b.add_emitter(Emitter::Directional { direction: Vec3::NEG_Y, irradiance: Rgb::WHITE }).unwrap();
        Some(add(b, [0.02; 3], [0.2; 3], 0.4))
    });
    let lights = set(&tracer, 500, 1, Clamp::Auto);
    assert!(lights.lights().iter().all(|light| light.kind == VplKind::Directional));
    let image = film(&tracer, &FullSum::new(&lights), [4, 4], 4, 1);
    assert!(colors(&image).into_iter().all(|c| c.is_black()));
}

/// The medium in which light from infinity starts follows from interfaces and cameras. If they
/// disagree, the scene is refused with their names.
#[test]
fn cameras_that_disagree_about_the_outside_are_refused_by_name() {
    let mut b = diffuse_room();
    let fog = fog(&mut b);
    b.add_camera(Camera { name: "other".into(), medium: Some(fog), ..room_camera() }).unwrap();
    let tracer = tracer(b);
    let said = VplSet::trace(&tracer, &VplOptions::default()).unwrap_err().to_string();
    assert!(
        said.contains("main") && said.contains("other") && said.contains("the same medium outside"),
        "{said}"
    );
}
