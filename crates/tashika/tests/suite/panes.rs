//! Light from infinity through panes of solid glass, compared with closed forms.
//!
//! A face reflects `F`. The transmittance of `n` faces is `(1 − F)ⁿ` without interreflection, and
//! `(1 − F) / (1 + (n − 1) F)` with all interreflections between them (Stokes 1862).

use std::f64::consts::{PI, TAU};

use tashika::Renderer;
use tashika::accel::Tracer;
use tashika::bsdf::fresnel;
use tashika::color::Rgb;
use tashika::film::Film;
use tashika::math::elementary::sin_cos;
use tashika::math::{Mat3, Vec3};
use tashika::request::{ClaimName, MethodName};
use tashika::scene::{
    Camera, Emitter, Environment, Image, Material, MeshData, Pixels, SceneBuilder, Surface,
};
use tashika::stats::Moments;

use crate::cases::{builder, cuboid, lambert, parallelogram, place, tracer};

const SIZE: [u32; 2] = [6, 6];
const REFLECTANCE: f64 = 0.5;
const IOR: f32 = 1.5;
/// Relative error requested for each pixel.
const ERROR: f64 = 0.1;
/// Permitted error of a mean in standard errors, exceeded by chance with probability 10⁻⁶.
const Z: f64 = 4.9;

/// Returns a tile of one centimetre that fills the picture of a camera a metre above it.
fn tile() -> SceneBuilder {
    let mut b = builder();
    let tile = parallelogram(Vec3::new(-5e-3, 0.0, -5e-3), Vec3::Z * 1e-2, Vec3::X * 1e-2);
    place(&mut b, tile, Material::new("tile", lambert(REFLECTANCE as f32)));
    let eye = Vec3::new(0.2, 0.9, 0.3);
    b.add_camera(Camera::look_at("main", eye, Vec3::ZERO, Vec3::Y, 1e-3)).unwrap();
    b
}

fn add_glass(b: &mut SceneBuilder, mesh: MeshData) {
    let glass =
        Surface::Glass { ior: IOR, reflectance: Rgb::WHITE, transmittance: Rgb::WHITE, facets: 0.0.into() };
    place(b, mesh, Material::new("pane", glass));
}

/// Adds a pane of glass, ten centimetres thick, above camera and tile.
fn add_pane(b: &mut SceneBuilder, height: f32) {
    add_glass(b, cuboid(Vec3::new(-50.0, height, -50.0), Vec3::new(50.0, height + 0.1, 50.0), false));
}

/// Renders a picture by path tracing, with and without claims, by the default method, and with an
/// audit.
fn films(tracer: &Tracer) -> Vec<(&'static str, Film)> {
    let plain = || Renderer::on(tracer).size(SIZE).vpls(2000);
    [
        ("paths", plain().method(MethodName::Path).paths(64)),
        ("calibrated paths", plain().method(MethodName::Path).error(ERROR)),
        ("transport", plain().error(ERROR)),
        ("audited", plain().error(ERROR).claim(ClaimName::Audited)),
    ]
    .into_iter()
    .map(|(name, renderer)| (name, renderer.render().unwrap().film))
    .collect()
}

/// Asserts the mean of the pixels, and an upper bound on the relative standard deviation of pixels
/// of 64 paths.
fn assert_mean(tracer: &Tracer, expected: f64, most_deviation: f64) {
    for (name, film) in films(tracer) {
        let mut pixels = Moments::default();
        film.colors().unwrap().for_each(|color| pixels.push(color.r.into()));
        let (mean, error) = (pixels.mean(), pixels.standard_error());
        // Error that the standard error does not include. In `paths` it is the rounding of a
        // radiance that is equal in all pixels. Pixels with a claim may end before they have
        // sampled rare light, and pixels of audited pictures share samples: both have a smaller
        // error than requested.
        let own = if name == "paths" { 1e-5 } else { 0.5 * ERROR };
        let tolerance = Z * error + own * expected;
        assert!((mean - expected).abs() <= tolerance, "{name}: {mean} ± {error} for {expected}");
        if name == "paths" {
            let deviation = pixels.variance().sqrt();
            assert!(deviation <= most_deviation * expected, "{deviation} of {expected}");
        }
    }
}

/// Returns the reflectance of a face for light with the given cosine of the angle of incidence.
fn reflected(cos: f64) -> f64 {
    fresnel::dielectric(cos as f32, IOR).into()
}

/// Panes in light of radiance 1 from everywhere. They change nothing, because they reflect as much
/// light as they block.
#[test]
fn panes_in_even_light_change_nothing() {
    for panes in [1, 2] {
        let mut b = tile();
        (0..panes).for_each(|k| add_pane(&mut b, 1.0 + k as f32));
        b.set_environment(Environment::constant(Rgb::WHITE)).unwrap();
        assert_mean(&tracer(b), REFLECTANCE, 1.0);
    }
}

/// A sky with one bright texel, 5.6° wide, above panes. Directions from the BSDF hit it once in 800
/// times, so pixels of 64 paths would vary by 350 % without other sampling. The deviation is much
/// smaller.
#[test]
fn a_small_sun_is_found_through_panes() {
    let (width, height) = (64, 32);
    let at = 8 * width + 20;
    let pixels = Pixels::Float((0..width * height).map(|k| [if k == at { 1e3 } else { 0.0 }; 3]).collect());
    let image = Image { name: "sun".into(), width, height, pixels };
    let environment = Environment::lat_long(image, Rgb::WHITE, Mat3::IDENTITY);
    // Midpoints in `(cos θ, φ)`, with the vertical as axis.
    const STEPS: [u32; 2] = [2000, 4000];
    let mut irradiance = [0.0; 3];
    for step in 0..STEPS[0] {
        let cos = (f64::from(step) + 0.5) / f64::from(STEPS[0]);
        let sin = (1.0 - cos * cos).sqrt();
        let face = reflected(cos);
        let around: f64 = (0..STEPS[1])
            .map(|k| {
                let (sin_phi, cos_phi) = sin_cos((TAU * f64::from(k) / f64::from(STEPS[1])) as f32);
                let direction = Vec3::new(sin as f32 * cos_phi, cos as f32, sin as f32 * sin_phi);
                f64::from(environment.radiance(direction).r)
            })
            .sum();
        let of_step = around * TAU / f64::from(STEPS[1]) * cos / f64::from(STEPS[0]);
        for (panes, sum) in irradiance.iter_mut().enumerate() {
            // Transmittance of these faces with all interreflections between them.
            let faces = 2.0 * panes as f64;
            *sum += of_step * (1.0 - face) / (1.0 + (faces - 1.0) * face);
        }
    }
    for panes in [0, 1, 2] {
        let mut b = tile();
        (0..panes).for_each(|k| add_pane(&mut b, 1.0 + k as f32));
        b.set_environment(environment.clone()).unwrap();
        assert_mean(&tracer(b), REFLECTANCE / PI * irradiance[panes], 0.4);
    }
}

/// A sun without extent above panes, which no path can hit. It is sampled, and the tile receives
/// the part that the faces do not reflect.
#[test]
fn a_single_direction_is_found_through_panes() {
    let irradiance = Rgb::gray(10.0);
    let direction = Vec3::new(0.6, -0.8, 0.0);
    for (panes, turned) in [(1, false), (2, false), (1, true)] {
        let mut b = tile();
        (0..panes).for_each(|k| add_pane(&mut b, 1.0 + k as f32));
        if turned {
            // A wedge deflects all light, so that none arrives.
            let faces = cuboid(Vec3::new(-50.0, 3.0, -50.0), Vec3::new(50.0, 4.0, 50.0), false);
            let lean = |p: &Vec3| if p.y > 3.5 { *p + Vec3::Y * 0.01 * p.x } else { *p };
            let positions = faces.positions.iter().map(lean).collect();
            add_glass(&mut b, MeshData { positions, ..faces });
        }
        b.add_emitter(Emitter::Directional { direction, irradiance }).unwrap();
        let passed = (1.0 - reflected(0.8)).powi(2 * panes);
        let expected = if turned { 0.0 } else { REFLECTANCE / PI * 10.0 * 0.8 * passed };
        assert_mean(&tracer(b), expected, 1e-4);
    }
}
