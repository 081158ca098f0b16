//! Cameras and lamps inside glass and water, compared with closed forms: inside, radiance is `n²`
//! times basic radiance.

use tashika::Renderer;
use tashika::accel::Tracer;
use tashika::bsdf::fresnel;
use tashika::color::Rgb;
use tashika::film::{Film, RenderFilm};
use tashika::math::Vec3;
use tashika::math::elementary::{exp_f64, sin_cos};
use tashika::request::MethodName;
use tashika::scene::{Camera, Emitter, Environment, Material, SceneBuilder, Surface};
use tashika::stats::Moments;

use crate::cases::{builder, cuboid, glowing, lambert, parallelogram, place, tracer};
use crate::media::{add, bounding, needle};

const WATER: f32 = 1.33;
const SIZE: [u32; 2] = [8, 8];
/// Permitted error of a mean in standard errors, exceeded by chance with probability 10⁻⁶.
const Z: f64 = 4.9;

fn glass(ior: f32) -> Surface {
    Surface::Glass { ior, reflectance: Rgb::WHITE, transmittance: Rgb::WHITE, facets: 0.0.into() }
}

/// Returns a very large water surface at height 0, under a sky of radiance 1.
fn pond() -> SceneBuilder {
    let mut b = builder();
    let surface = parallelogram(Vec3::new(-5e3, 0.0, -5e3), Vec3::Z * 1e4, Vec3::X * 1e4);
    place(&mut b, surface, Material::new("water", glass(WATER)));
    b.set_environment(Environment::constant(Rgb::WHITE)).unwrap();
    b
}

/// Returns a camera a metre below the surface, tilted by `angle` from straight up. All of its rays
/// have the same direction.
fn looking_up(angle: f32) -> Camera {
    let eye = Vec3::new(0.0, -1.0, 0.0);
    let (sin, cos) = sin_cos(angle);
    Camera::look_at("below", eye, eye + Vec3::new(sin, cos, 0.0), Vec3::Z, 1e-4)
}

/// Renders a picture by every method, and by the default method also with errors and with claims.
fn films(tracer: &Tracer) -> Vec<(String, Film)> {
    let plain = || Renderer::on(tracer).size(SIZE).vpls(200);
    let mut films: Vec<(String, Film)> = MethodName::all()
        .map(|method| {
            let renderer = plain().method(method);
            let renderer = match method.of_lights() {
                None => renderer.paths(64),
                Some(_) => renderer.gather_points(64),
            };
            (method.name().to_owned(), renderer.render().unwrap().film)
        })
        .collect();
    films.push(("transport".into(), plain().error(0.2).render().unwrap().film));
    films.push((
        "calibrated paths".into(),
        plain().method(MethodName::Path).error(0.2).render().unwrap().film,
    ));
    films
}

/// Returns the mean over the pixels, and its standard error.
fn mean(film: &Film) -> [f64; 2] {
    let mut moments = Moments::default();
    film.colors().unwrap().for_each(|color| moments.push(color.r.into()));
    [moments.mean(), moments.standard_error()]
}

/// A camera below water sees `n² (1 − R) + R`: the sky through the surface, and reflected light
/// from below, which crosses no boundary. Beyond the critical angle of 48.75° this is 1. A path
/// chooses between reflection and refraction, so its standard deviation is `(n² − 1) √(R (1 − R))`.
/// The mean is over 64 pixels of at least 8 paths.
#[test]
fn the_sky_from_below_water_is_brighter_by_the_squared_index() {
    for degrees in [0.0_f32, 40.0, 47.0, 52.0] {
        let angle = degrees.to_radians();
        let mut b = pond();
        b.add_camera(looking_up(angle)).unwrap();
        let tracer = tracer(b);
        let reflected = f64::from(fresnel::dielectric(sin_cos(angle).1, WATER.recip()));
        let squared = f64::from(WATER) * f64::from(WATER);
        let expected = squared * (1.0 - reflected) + reflected;
        let deviation = (squared - 1.0) * (reflected * (1.0 - reflected)).sqrt();
        for (method, film) in films(&tracer) {
            let [found, _] = mean(&film);
            let most = Z * deviation / (8.0 * 64.0_f64).sqrt() + 1e-4;
            assert!((found - expected).abs() < most, "{method}, {degrees}°: {found} for {expected} ± {most}");
        }
    }
}

/// Water that absorbs has `n² (1 − R) T` towards its surface. The reflection adds nothing, since
/// the water has no floor.
#[test]
fn media_take_their_share_on_the_way_to_the_surface() {
    let mut b = builder();
    let water = Some(add(&mut b, [0.5; 3], [0.0; 3], 0.0));
    let surface = parallelogram(Vec3::new(-5e3, -5e3, 0.0), Vec3::X * 1e4, Vec3::Y * 1e4);
    bounding(&mut b, surface, glass(WATER), [water, None]);
    b.set_environment(Environment::constant(Rgb::WHITE)).unwrap();
    let eye = Vec3::NEG_Z * 2.0;
    b.add_camera(Camera { medium: water, ..Camera::look_at("c", eye, Vec3::ZERO, Vec3::Y, 1e-4) }).unwrap();
    let film = Renderer::on(&tracer(b)).size(SIZE).paths(256).render().unwrap().film;
    let reflected = f64::from(fresnel::dielectric(1.0, WATER.recip()));
    let brightest = f64::from(WATER).powi(2) * exp_f64(-1.0);
    let [found, _] = mean(&film);
    let most = Z * brightest * (reflected * (1.0 - reflected)).sqrt() / 128.0 + 1e-4;
    let expected = brightest * (1.0 - reflected);
    assert!((found - expected).abs() < most, "{found} for {expected} ± {most}");
}

/// A lamp in a block of glass, seen head-on, without other light. A camera inside the block sees
/// the lamp's radiance; a camera outside sees `(1 − R)/n²` of it. From outside, each sample is
/// either as bright as the lamp or black.
#[test]
fn a_lamp_in_glass_is_as_it_shines_from_inside_and_dimmer_from_outside() {
    const RADIANCE: f32 = 3.0;
    let of = |camera: Camera| {
        let mut b = builder();
        let block = cuboid(Vec3::new(-2.0, -2.0, -2.0), Vec3::new(2.0, 2.0, 2.0), false);
        place(&mut b, block, Material::new("glass", glass(1.5)));
        let lamp = parallelogram(Vec3::new(-1.0, -1.0, -1.0), Vec3::X * 2.0, Vec3::Y * 2.0);
        place(&mut b, lamp, glowing("lamp", lambert(0.0), RADIANCE));
        b.add_camera(camera).unwrap();
        films(&tracer(b))
    };
    for (method, film) in of(needle(Vec3::Z, None)) {
        let [found, spread] = mean(&film);
        assert!((found / f64::from(RADIANCE) - 1.0).abs() < 1e-6 && spread < 1e-6, "{method}: {found}");
    }
    let passed = 1.0 - f64::from(fresnel::dielectric(1.0, 1.5));
    let brightest = f64::from(RADIANCE) / 2.25;
    let most = Z * brightest * (passed * (1.0 - passed)).sqrt() / (8.0 * 64.0_f64).sqrt();
    for (method, film) in of(needle(Vec3::Z * 5.0, None)) {
        let [found, _] = mean(&film);
        let expected = brightest * passed;
        assert!((found - expected).abs() < most, "{method}: {found} for {expected} ± {most}");
    }
}

/// Glass in a white furnace: basic radiance is 1 everywhere. A camera in a block of glass, or in
/// water in a tank of glass, therefore sees `n²`. A camera in the hollow of a bottle, between two
/// panes, before a block, or over a pond sees 1. All paths carry the same radiance.
#[test]
fn a_furnace_is_as_bright_as_the_squared_index_around_the_camera() {
    let cube = |half: f32, inward| cuboid(Vec3::splat(-half), Vec3::splat(half), inward);
    type Build = fn(&mut SceneBuilder, &dyn Fn(f32, bool) -> tashika::scene::MeshData);
    let block: Build = |b, cube| place(b, cube(2.0, false), Material::new("glass", glass(1.5)));
    let tank: Build = |b, cube| {
        place(b, cube(2.0, false), Material::new("glass", glass(1.5)));
        place(b, cube(1.5, true), Material::new("wall", glass(1.5 / WATER)));
    };
    let bottle: Build = |b, cube| {
        place(b, cube(2.0, false), Material::new("outside", glass(1.5)));
        place(b, cube(1.5, true), Material::new("inside", glass(1.5)));
    };
    let panes: Build = |b, _| {
        for z in [-2.0, 2.0] {
            let pane = cuboid(Vec3::new(-9.0, -9.0, z - 0.1), Vec3::new(9.0, 9.0, z + 0.1), false);
            place(b, pane, Material::new("pane", glass(1.5)));
        }
    };
    let pond: Build = |b, _| {
        let surface = parallelogram(Vec3::new(-99.0, 0.0, -99.0), Vec3::Z * 198.0, Vec3::X * 198.0);
        place(b, surface, Material::new("water", glass(WATER)));
    };
    for (build, eye, index) in [
        (pond, Vec3::Y, 1.0),
        (block, Vec3::ZERO, 1.5),
        (block, Vec3::Z * 5.0, 1.0),
        (tank, Vec3::ZERO, WATER),
        (tank, Vec3::Z * 1.7, 1.5),
        (bottle, Vec3::ZERO, 1.0),
        (panes, Vec3::ZERO, 1.0),
    ] {
        let mut b = builder();
        build(&mut b, &cube);
        b.set_environment(Environment::constant(Rgb::WHITE)).unwrap();
        b.add_camera(needle(eye, None)).unwrap();
        let renderer = Renderer::on(&tracer(b)).size(SIZE).paths(16);
        let prepared = renderer.prepare().unwrap();
        let around = prepared.setting().view.camera.index;
        assert!((around / index - 1.0).abs() < 1e-6, "{around} for {index}");
        let [found, _] = mean(&prepared.render().unwrap().film);
        let expected = f64::from(index).powi(2);
        assert!((found / expected - 1.0).abs() < 1e-5, "{found} for {expected} at {eye}");
    }
}

/// The floor of a pond, lit by lamps in the water alone and seen from the water. Sums, light
/// transport and paths agree within their errors, since no light that is seen leaves its medium,
/// except by reflection at the surface.
#[test]
fn methods_agree_on_what_is_lit_below_water() {
    let mut b = pond();
    b.set_environment(Environment::constant(Rgb::BLACK)).unwrap();
    let floor = parallelogram(Vec3::new(-3.0, -4.0, -3.0), Vec3::Z * 6.0, Vec3::X * 6.0);
    place(&mut b, floor, Material::new("floor", lambert(0.6)));
    let lamp = parallelogram(Vec3::new(-0.5, -1.0, 1.0), Vec3::X, Vec3::Z * 0.5);
    place(&mut b, lamp, glowing("lamp", lambert(0.0), 20.0));
    let position = Vec3::new(1.0, -2.0, -1.0);
    b.add_emitter(Emitter::Point { position, intensity: Rgb::gray(3.0) }).unwrap();
    let eye = Vec3::new(0.0, -1.5, 0.0);
    b.add_camera(Camera::look_at("c", eye, eye + Vec3::NEG_Y, Vec3::Z, 0.5)).unwrap();
    let tracer = tracer(b);
    let truth = Renderer::on(&tracer).size(SIZE).method(MethodName::Path).paths(4096).render().unwrap().film;
    let transport = Renderer::on(&tracer).size(SIZE).error(0.03).vpls(3000).render().unwrap().film;
    let (truth, transport) = (RenderFilm::of(&truth), RenderFilm::of(&transport));
    let (mut off, mut squared, mut sum) = (0.0, 0.0, 0.0);
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            let [of_paths, found] = [truth.at(x, y), transport.at(x, y)];
            off += f64::from(found.radiance.r) - f64::from(of_paths.radiance.r);
            squared += f64::from(found.half_width).powi(2) + f64::from(of_paths.standard_error).powi(2);
            sum += f64::from(of_paths.radiance.r);
        }
    }
    // A half-width at 95 % is larger than a standard error.
    assert!(off.abs() < Z * squared.sqrt(), "{} of {}", off, sum);
    assert!(Z * squared.sqrt() < 0.05 * sum, "sharp: {} of {sum}", squared.sqrt());
}
