//! Many lights against an independent path tracer: the mean over VPL sets, unclamped, on diffuse scenes with every kind of
//! emitter, pixel by pixel.

use tashika::color::Rgb;
use tashika::integrator::{Exact, Path};
use tashika::math::{Mat3, Vec3};
use tashika::scene::{
    Alpha, AlphaMode, Emitter, Environment, Falloff, FalloffShape, Image, Material, Pixels, SceneBuilder,
    Surface,
};
use tashika::stats::Moments;
use tashika::vpl::{Clamp, VplOptions, VplSet};

use crate::cases::{
    add_ceiling_lamp, cuboid, diffuse_room, film, lambert, luminances, parallelogram, place, tracer,
};

const SIZE: [u32; 2] = [6, 6];

fn sky() -> Environment {
    let (w, h) = (32, 16);
    let mut pixels = vec![[0.3, 0.5, 0.9]; w * h];
    pixels[5 * w + 17] = [90.0, 80.0, 60.0];
    let image =
        Image { name: "sky".into(), width: w as u32, height: h as u32, pixels: Pixels::Float(pixels) };
    Environment::lat_long(image, Rgb::WHITE, Mat3::from_rotation_y(1.4))
}

/// Each pixel of both estimates within their common error, and the whole image more sharply.
fn agree(b: SceneBuilder, what: &str) {
    let tracer = tracer(b);
    let sets = 80;
    let mut many = vec![Moments::default(); 36];
    let mut image = Moments::default();
    for seed in 0..sets {
        let options = VplOptions { count: 600, seed, clamp: Clamp::Off, ..VplOptions::default() };
        let set = VplSet::trace(&tracer, &options).unwrap();
        let l = luminances(&film(&tracer, &Exact::new(&set), SIZE, 4, seed));
        image.push(l.iter().sum::<f64>() / 36.0);
        many.iter_mut().zip(l).for_each(|(m, l)| m.push(l));
    }
    let reference = film(&tracer, &Path::new(&tracer, 4000, 65).unwrap(), SIZE, 1, 1000);
    let errors = reference.plane("standard_error").unwrap().f32_samples().unwrap();
    let expected = luminances(&reference);
    // Two-sided level 10⁻⁵ for each of 36 pixels and the image. Every set comes with gather points of its own.
    for (i, (m, (l, e))) in many.iter().zip(expected.iter().zip(errors)).enumerate() {
        let error = m.standard_error().hypot(f64::from(*e));
        let found = (m.mean(), m.standard_error());
        assert!((m.mean() - l).abs() < 4.42 * error, "{what}, pixel {i}: {found:?} for {l} ± {e}");
    }
    let mean = expected.iter().sum::<f64>() / 36.0;
    let error =
        image.standard_error().hypot(errors.iter().map(|e| f64::from(*e).powi(2)).sum::<f64>().sqrt() / 36.0);
    assert!(error < 0.03 * mean, "{what}: the comparison is sharp: {error} of {mean}");
    assert!((image.mean() - mean).abs() < 4.42 * error, "{what}: {} ± {error} for {mean}", image.mean());
}

#[test]
fn an_area_light_in_a_diffuse_room() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    agree(b, "area light");
}

#[test]
fn point_spot_and_directional_lights() {
    let mut b = diffuse_room();
    b.add_emitter(Emitter::Point { position: Vec3::new(-0.5, 1.6, 0.5), intensity: Rgb::new(0.5, 0.4, 0.3) })
        .unwrap();
    b.add_emitter(Emitter::Spot {
        position: Vec3::new(0.5, 1.8, 0.6),
        axis: Vec3::new(-0.3, -1.0, -0.4).normalize(),
        intensity: Rgb::new(1.0, 2.0, 1.0),
        falloff: Falloff { cos_inner: 0.9, cos_outer: 0.6, shape: FalloffShape::Squared },
    })
    .unwrap();
    b.add_emitter(Emitter::Directional {
        direction: Vec3::new(0.2, -0.4, -1.0).normalize(),
        irradiance: Rgb::new(1.0, 0.9, 0.7),
    })
    .unwrap();
    agree(b, "punctual lights");
}

#[test]
fn an_environment_with_a_sun_through_the_open_side() {
    let mut b = diffuse_room();
    b.set_environment(sky()).unwrap();
    agree(b, "environment");
}

/// Surfaces of several parts: a leaf under the lamp, a pane with a grey tint in the open side, a half-transparent sheet, and a block
/// of two materials. The pane reflects nothing, for what a mirror reflects onto a surface is not in the sum over VPLs.
#[test]
fn light_through_leaves_panes_and_holes() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    b.set_environment(sky()).unwrap();
    let leaf = Surface::Translucent {
        reflectance: Rgb::new(0.2, 0.5, 0.1).into(),
        transmittance: Rgb::new(0.5, 0.4, 0.1).into(),
    };
    let sheet = |y: f32, x: f32| parallelogram(Vec3::new(x, y, -0.6), Vec3::X * 0.8, Vec3::Z * 1.2);
    place(&mut b, sheet(1.5, -0.9), Material::new("leaf", leaf));
    let alpha = Some(Alpha { value: 0.4.into(), mode: AlphaMode::Blend });
    place(&mut b, sheet(1.4, 0.1), Material { alpha, ..Material::new("gauze", lambert(0.8)) });
    let pane =
        Surface::ThinGlass { ior: 1.5, reflectance: Rgb::BLACK.into(), transmittance: Rgb::gray(0.8).into() };
    let front = parallelogram(Vec3::new(-1.0, 0.0, 1.0), Vec3::X * 2.0, Vec3::Y * 2.0);
    place(&mut b, front, Material::new("pane", pane));
    let first = b.add_material(Material::new("a", lambert(0.9))).unwrap();
    let second = b.add_material(Material::new("b", lambert(0.1))).unwrap();
    let mix = Surface::Mix { first, second, amount: 0.3.into() };
    let block = cuboid(Vec3::new(-0.8, 0.0, -0.2), Vec3::new(-0.4, 0.4, 0.3), false);
    place(&mut b, block, Material::new("mixed", mix));
    agree(b, "several parts");
}
