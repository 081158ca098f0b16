//! Scenes whose light is hard to sample, rendered as light transport. Claims hold, and images with
//! different sets of lights contradict each other no more often than stated.

use tashika::color::Rgb;
use tashika::film::{Film, Window};
use tashika::integrator::{
    ControlOptions, Estimator, GuidedLights, Integrator, LightTransport, PathSampler, PathSamples, PathStop,
    PathTracer, Setting, Stop, Truth,
};
use tashika::math::{Mat3, Vec3};
use tashika::scene::{Camera, Emitter, Environment, Image, Material, Pixels, SceneBuilder, Surface};
use tashika::vpl::VplOptions;

use crate::cases::{
    add_ceiling_lamp, builder, cuboid, diffuse_room, film, glowing, lambert, luminances, parallelogram,
    place, tracer, view,
};

const SIZE: [u32; 2] = [12, 9];
const PIXELS: usize = 108;
/// Number of sets of lights.
const SEEDS: u64 = 6;
/// Relative error requested of each pixel, at 95 %.
const ERROR: f64 = 0.1;

/// Result and claim of one pixel.
#[derive(Clone, Copy)]
struct Said {
    found: f64,
    /// None without a claim.
    half_width: Option<f64>,
    is_found: bool,
}

fn said(film: &Film) -> Vec<Said> {
    let numbers = |plane: &str| film.plane(plane).unwrap().u32_samples().unwrap().to_vec();
    let (claims, stops) = (numbers("claim"), numbers("stop"));
    let half_widths = film.plane("half_width").unwrap().f32_samples().unwrap();
    let of_pixel = |(i, found): (usize, f64)| Said {
        found,
        half_width: (claims[i] > 0).then(|| half_widths[i].into()),
        is_found: stops[i] != Stop::NotFound.id(),
    };
    luminances(film).into_iter().enumerate().map(of_pixel).collect()
}

/// Images of a scene, each with its own set of lights.
fn images(scene: &dyn Fn() -> SceneBuilder) -> Vec<Vec<Said>> {
    let tracer = tracer(scene());
    let image = |seed| {
        let lights = VplOptions { count: 50_000, seed, ..VplOptions::default() };
        let view = view(tracer.scene(), SIZE, 64, seed);
        let guided = GuidedLights::trace(&tracer, &lights, Truth::Transport, &view).unwrap();
        let options =
            ControlOptions { error: ERROR, seed, max_pairs: Some(4096), ..ControlOptions::default() };
        let film = film(&tracer, &LightTransport::new(&tracer, &guided, &options), SIZE, 64, seed);
        said(&film)
    };
    (1..=SEEDS).map(image).collect()
}

/// Largest share of claims that may be wrong. 5 % are expected, and errors of pixels of an image
/// are correlated.
const WRONG: f64 = 0.09;

/// Largest share of pairs of claims that may be disjoint.
const DISJOINT: f64 = 0.01;
/// Larger limit for scenes in which a spot that the pilot expects to be dark, or a lit edge on
/// black, covers so little of a pixel that most of its camera samples miss it.
const DISJOINT_BY_SLIVERS: f64 = 0.015;

/// Compares the claims of different images: two claims of a pixel can both be right only if they
/// overlap.
fn seeds_agree(images: &[Vec<Said>], most_disjoint: f64, what: &str) {
    let (mut pairs, mut disjoint) = (0.0, 0.0);
    for (k, one) in images.iter().enumerate() {
        for (a, b) in images[..k].iter().flat_map(|other| other.iter().zip(one)) {
            if let (Some(h), Some(i)) = (a.half_width, b.half_width) {
                pairs += 1.0;
                disjoint += f64::from((a.found - b.found).abs() > h + i);
            }
        }
    }
    assert!(
        disjoint <= most_disjoint * pairs,
        "{what}: {disjoint} of {pairs} pairs of intervals are disjoint"
    );
}

/// Compares claims with a reference, and requires claims for at least the share `least_claims` of
/// pixels.
fn claims_hold(scene: &dyn Fn() -> SceneBuilder, least_claims: f64, most_disjoint: f64, what: &str) {
    let images = images(scene);
    let tracer = tracer(scene());
    let reference =
        film(&tracer, &PathTracer::new(&tracer, PathStop::Count(20_000), 65).unwrap(), SIZE, 1, 1000);
    let errors = reference.plane("standard_error").unwrap().f32_samples().unwrap();
    let (mut claims, mut kept) = (0.0, 0.0);
    for (i, truth) in luminances(&reference).into_iter().enumerate() {
        for said in images.iter().map(|image| image[i]) {
            let Some(half_width) = said.half_width else { continue };
            claims += 1.0;
            // Allows for the error of the reference.
            let slack = 2.0 * f64::from(errors[i]);
            kept += f64::from((said.found - truth).abs() <= half_width + slack);
        }
    }
    let missing = images.iter().flatten().filter(|said| !said.is_found).count();
    assert!(missing * 100 <= images.len() * PIXELS, "{what}: light is missing in {missing}");
    assert!(kept >= (1.0 - WRONG) * claims, "{what}: {kept} of {claims} claims hold");
    let all = (SEEDS as usize * PIXELS) as f64;
    assert!(claims >= least_claims * all, "{what}: {claims} claims of {all}");
    seeds_agree(&images, most_disjoint, what);
}

fn add_camera(b: &mut SceneBuilder, eye: [f32; 3], target: [f32; 3]) {
    b.add_camera(Camera::look_at("main", eye.into(), target.into(), Vec3::Y, 0.8)).unwrap();
}

/// A room of 6 × 2 × 2 m, divided at `x = 0`.
fn long_room() -> SceneBuilder {
    let mut b = builder();
    let room = cuboid(Vec3::new(-3.0, 0.0, -1.0), Vec3::new(3.0, 2.0, 1.0), true);
    place(&mut b, room, Material::new("room", lambert(0.7)));
    add_camera(&mut b, [0.3, 1.0, 0.0], [3.0, 0.8, 0.0]);
    b
}

/// Adds a wall at `x = 0` between the given `z` and the given heights `y`.
fn add_wall(b: &mut SceneBuilder, from: f32, to: f32, y: [f32; 2]) {
    let corner = Vec3::new(0.0, y[0], from);
    let wall = parallelogram(corner, Vec3::Y * (y[1] - y[0]), Vec3::Z * (to - from));
    place(b, wall, Material::new("wall", lambert(0.7)));
}

fn add_lamp_at(b: &mut SceneBuilder, center: [f32; 3], side: f32, radiance: f32) {
    let corner = Vec3::from(center) - Vec3::new(0.5 * side, 0.0, 0.5 * side);
    let lamp = parallelogram(corner, Vec3::X * side, Vec3::Z * side);
    place(b, lamp, glowing("lamp", lambert(0.3), radiance));
}

/// Two rooms with a door that is ajar. All light in the visible room comes from the lamp in the
/// other.
#[test]
fn two_rooms_and_a_door() {
    let scene = || {
        let mut b = long_room();
        add_wall(&mut b, -1.0, 0.7, [0.0, 2.0]);
        add_lamp_at(&mut b, [-2.0, 1.9, 0.0], 0.5, 20.0);
        b
    };
    claims_hold(&scene, 0.9, DISJOINT, "two rooms");
}

/// Two rooms with a hole of 6 × 6 cm between them, so that most lights are occluded.
#[test]
fn a_key_hole() {
    let scene = || {
        let mut b = long_room();
        add_wall(&mut b, -1.0, -0.03, [0.0, 2.0]);
        add_wall(&mut b, 0.03, 1.0, [0.0, 2.0]);
        add_wall(&mut b, -0.03, 0.03, [0.0, 1.0]);
        add_wall(&mut b, -0.03, 0.03, [1.06, 2.0]);
        add_lamp_at(&mut b, [-2.0, 1.9, 0.0], 0.5, 2000.0);
        // The visible room also has a weak lamp, so that some pixels can be claimed.
        add_lamp_at(&mut b, [2.0, 1.95, 0.0], 0.1, 0.2);
        b
    };
    claims_hold(&scene, 0.5, DISJOINT_BY_SLIVERS, "key-hole");
}

/// A room that is lit through its open side, on a ground of 200 m.
#[test]
fn a_wide_ground_about_a_room() {
    let scene = || {
        let mut b = diffuse_room();
        b.set_environment(Environment::constant(Rgb::new(0.3, 0.5, 0.9))).unwrap();
        let ground = parallelogram(Vec3::new(-100.0, -0.01, -100.0), Vec3::Z * 200.0, Vec3::X * 200.0);
        place(&mut b, ground, Material::new("ground", lambert(0.5)));
        b
    };
    claims_hold(&scene, 0.9, DISJOINT, "wide ground");
}

/// A room with black walls, in which only one block reflects light.
#[test]
fn black_walls() {
    let scene = || {
        let mut b = builder();
        place(&mut b, cuboid(Vec3::splat(-1.0), Vec3::ONE, true), Material::new("black", lambert(0.0)));
        let block = cuboid(Vec3::new(-0.4, -1.0, -0.4), Vec3::new(0.3, 0.0, 0.2), false);
        place(&mut b, block, Material::new("block", lambert(0.6)));
        add_lamp_at(&mut b, [0.2, 0.95, 0.3], 0.3, 10.0);
        add_camera(&mut b, [0.0, 0.2, 0.95], [0.0, -0.4, 0.0]);
        b
    };
    claims_hold(&scene, 0.99, DISJOINT_BY_SLIVERS, "black walls");
}

/// All lamps are above a slab of solid glass, which blocks every shadow segment to them.
#[test]
fn all_lights_behind_glass() {
    let scene = || {
        let mut b = diffuse_room();
        add_ceiling_lamp(&mut b, 5.0);
        let glass = Surface::Glass {
            ior: 1.5,
            reflectance: Rgb::WHITE,
            transmittance: Rgb::gray(0.95),
            facets: 0.0.into(),
        };
        let slab = cuboid(Vec3::new(-1.1, 1.7, -1.1), Vec3::new(1.1, 1.8, 1.1), false);
        place(&mut b, slab, Material::new("glass", glass));
        b
    };
    claims_hold(&scene, 0.5, DISJOINT, "behind glass");
}

/// A room that is a hundred times as large, with lamps of the same radiance, gives the same
/// picture.
#[test]
fn a_room_in_centimetres() {
    let room = |scale: f32| {
        let mut b = builder();
        let lo = Vec3::new(-1.0, 0.0, -1.0) * scale;
        let hi = Vec3::new(1.0, 2.0, 1.0) * scale;
        place(&mut b, cuboid(lo, hi, true), Material::new("room", lambert(0.7)));
        let block = cuboid(Vec3::new(-0.5, 0.0, -0.5) * scale, Vec3::new(0.0, 0.6, 0.2) * scale, false);
        place(&mut b, block, Material::new("block", lambert(0.4)));
        add_lamp_at(&mut b, [0.0, 1.9 * scale, 0.0], 0.4 * scale, 5.0);
        add_camera(&mut b, [0.0, scale, 0.9 * scale], [0.0, 0.7 * scale, 0.0]);
        b
    };
    let [metres, centimetres] = [1.0, 100.0].map(|scale| images(&|| room(scale)));
    let both: Vec<Vec<Said>> = metres.into_iter().chain(centimetres).collect();
    assert!(both.iter().flatten().all(|said| said.half_width.is_some()));
    seeds_agree(&both, DISJOINT, "centimetres");
}

/// A visible lamp covers a thousandth of a pixel and is much brighter than the rest of the pixel.
#[test]
fn a_lamp_in_a_thousandth_of_a_pixel() {
    let scene = || {
        let mut b = diffuse_room();
        add_ceiling_lamp(&mut b, 5.0);
        let lamp = parallelogram(Vec3::new(0.5, 1.2, -0.9), Vec3::X * 0.008, Vec3::Y * 0.008);
        place(&mut b, lamp, glowing("small", lambert(0.0), 50_000.0));
        b
    };
    claims_hold(&scene, 0.5, DISJOINT, "small lamp");
    let bright = |image: &Vec<Said>| image.iter().any(|said| said.found > 10.0);
    let pixel = images(&scene).into_iter().filter(bright).count();
    assert!(pixel as u64 * 4 > SEEDS * 3, "the lamp is seen by {pixel} of {SEEDS}");
}

/// The sun, of 0.2°, low above a plain, seen directly or through a pane. It covers a thousandth of
/// a pixel, and makes this pixel hundreds of times as bright as the rest of the sky: most sets of
/// camera samples miss it. No pixel claims an interval without the sun.
#[test]
fn a_sun_in_a_thousandth_of_a_pixel() {
    let scene = |has_pane: bool| {
        let mut b = builder();
        let plain = parallelogram(Vec3::new(-50.0, 0.0, -50.0), Vec3::Z * 100.0, Vec3::X * 100.0);
        place(&mut b, plain, Material::new("plain", lambert(0.7)));
        add_camera(&mut b, [0.0, 1.0, 0.0], [0.0, 1.1, -1.0]);
        let (w, h) = (2048, 1024);
        let mut texels = vec![[0.1; 3]; w * h];
        texels[470 * w + w / 2 + 20] = [1e6; 3];
        let image = Image { name: "sky".into(), width: 2048, height: 1024, pixels: Pixels::Float(texels) };
        b.set_environment(Environment::lat_long(image, Rgb::WHITE, Mat3::IDENTITY)).unwrap();
        if has_pane {
            let glass = Surface::Glass {
                ior: 1.5,
                reflectance: Rgb::WHITE,
                transmittance: Rgb::WHITE,
                facets: 0.0.into(),
            };
            let pane = cuboid(Vec3::new(-2.0, 0.5, -1.1), Vec3::new(2.0, 3.0, -1.0), false);
            place(&mut b, pane, Material::new("pane", glass));
        }
        b
    };
    for has_pane in [false, true] {
        let images = images(&|| scene(has_pane));
        let sees_sun = |said: &Said| said.found > 20.0;
        let brightest: Vec<usize> = (0..PIXELS).filter(|i| images.iter().any(|m| sees_sun(&m[*i]))).collect();
        let [pixel] = brightest[..] else { panic!("the sun is in {brightest:?}, pane: {has_pane}") };
        let seen = images.iter().filter(|image| sees_sun(&image[pixel])).count();
        assert!(seen as u64 * 4 > SEEDS * 3, "the sun is seen by {seen} of {SEEDS}, pane: {has_pane}");
        let missed = |image: &&Vec<Said>| !sees_sun(&image[pixel]) && image[pixel].half_width.is_some();
        assert_eq!(images.iter().filter(missed).count(), 0, "claims without the sun, pane: {has_pane}");
    }
}

/// A room half under water, without a lamp.
fn room_under_water() -> SceneBuilder {
    let mut b = builder();
    place(&mut b, cuboid(Vec3::splat(-1.0), Vec3::ONE, true), Material::new("room", lambert(0.5)));
    let water =
        Surface::Glass { ior: 1.33, reflectance: Rgb::WHITE, transmittance: Rgb::WHITE, facets: 0.0.into() };
    let volume = cuboid(Vec3::new(-1.1, -1.1, -1.1), Vec3::new(1.1, -0.5, 1.1), false);
    place(&mut b, volume, Material::new("water", water));
    add_camera(&mut b, [0.0, 0.6, 0.95], [0.0, -0.8, 0.0]);
    b
}

/// A point lamp above the water, which no path can hit.
fn add_point_lamp(b: &mut SceneBuilder) {
    let position = Vec3::new(0.1, 0.9, 0.0);
    b.add_emitter(Emitter::Point { position, intensity: Rgb::gray(0.5) }).unwrap();
}

/// Fraction of the pixels whose paths miss more than a tenth of the light.
fn missing_in_paths(scene: SceneBuilder) -> f64 {
    let tracer = tracer(scene);
    let view = view(tracer.scene(), SIZE, 1, 1);
    let lights = VplOptions { count: 50_000, ..VplOptions::default() };
    let lights = GuidedLights::to_audit(&tracer, &lights, &view).unwrap();
    let method = LightTransport::new(&tracer, &lights, &ControlOptions::default());
    let sampler = method.path_sampler(Setting { tracer: &tracer, view });
    let found = sampler.tile(&Window::full(SIZE), 1, &|_| sampler.telling());
    let is_missing = |pixel: &&PathSamples| {
        pixel.importance_not_found > 0.1 * pixel.luminance.mean() * pixel.luminance.count() as f64
    };
    found.iter().filter(is_missing).count() as f64 / PIXELS as f64
}

/// Paths with drawn lights report unsampled light for a point lamp above water, and none for lamps
/// with an area, which they can hit.
#[test]
fn paths_tell_what_they_do_not_find() {
    let with = |add: &dyn Fn(&mut SceneBuilder)| {
        let mut b = room_under_water();
        add(&mut b);
        missing_in_paths(b)
    };
    let point = with(&add_point_lamp);
    let [small, large] = [(0.005, 20_000.0), (1.0, 0.5)]
        .map(|(side, radiance)| with(&|b| add_lamp_at(b, [0.1, 0.9, 0.0], side, radiance)));
    assert!(point > 0.5 && small == 0.0 && large == 0.0, "{point} of a point, {small} and {large} of lamps");
}

/// A point lamp lights the bottom of the water through its surface. VPLs and paths cannot sample
/// this light, and the pixels report that.
#[test]
fn a_point_above_water() {
    let images = images(&|| {
        let mut b = room_under_water();
        add_point_lamp(&mut b);
        b
    });
    seeds_agree(&images, DISJOINT, "point");
    let missing = images.iter().flatten().filter(|said| !said.is_found).count();
    let all = images.len() * PIXELS;
    assert!(missing > all / 2, "light is missing in {missing} of {all} pixels");
}

/// A lamp of a few millimetres in place of the point. Paths sample it by directions towards
/// caustics.
#[test]
fn a_lamp_of_millimetres_above_water() {
    let images = images(&|| {
        let mut b = room_under_water();
        add_lamp_at(&mut b, [0.1, 0.9, 0.0], 0.005, 20_000.0);
        b
    });
    seeds_agree(&images, DISJOINT, "water");
    let claims = images.iter().flatten().filter(|said| said.half_width.is_some()).count();
    let all = images.len() * PIXELS;
    assert!(claims * 10 >= all * 9, "{claims} claims of {all}");
}

/// A lamp behind the camera, whose mirror image covers a two-thousandth of the pixel and is much of
/// its light. A hundred camera samples mostly miss it, so the larger number of samples that paths
/// begin with has to include it.
#[test]
fn a_mirrored_lamp_in_a_thousandth_of_a_pixel() {
    let mut b = builder();
    let room = cuboid(Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 2.0, 5.0), true);
    place(&mut b, room, Material::new("room", lambert(0.5)));
    let smooth = Surface::Mirror { reflectance: Rgb::WHITE.into() };
    let facet = parallelogram(Vec3::new(-0.0025, 1.2975, 0.3), Vec3::X * 0.005, Vec3::Y * 0.005);
    place(&mut b, facet, Material::new("facet", smooth));
    let lamp = parallelogram(Vec3::new(-0.1, 1.6, 4.5), Vec3::Y * 0.2, Vec3::X * 0.2);
    place(&mut b, lamp, glowing("lamp", lambert(0.0), 2000.0));
    let (eye, target) = (Vec3::new(0.0, 1.0, 3.6), Vec3::new(0.0, 1.3, 0.3));
    b.add_camera(Camera::look_at("main", eye, target, Vec3::Y, 0.06)).unwrap();
    let tracer = tracer(b);
    let pixel = |integrator: &dyn Integrator, seed: u64| {
        let film = film(&tracer, integrator, [1, 1], 64, seed);
        let error = film.plane("standard_error").unwrap().f32_samples().unwrap()[0];
        (luminances(&film)[0], f64::from(error))
    };
    let (truth, its_error) = pixel(&PathTracer::new(&tracer, PathStop::Count(200_000), 65).unwrap(), 1000);
    let (mut mean, mut variance) = (0.0, its_error * its_error);
    for seed in 1..=SEEDS {
        let lights = VplOptions { count: 50_000, seed, ..VplOptions::default() };
        let view = view(tracer.scene(), [1, 1], 64, seed);
        let guided = GuidedLights::trace(&tracer, &lights, Truth::Transport, &view).unwrap();
        // The request needs more than the permitted work. Otherwise an estimate could stop at a
        // narrow interval because no sample met the lamp.
        let options =
            ControlOptions { error: 1e-3, seed, max_pairs: Some(16_384), ..ControlOptions::default() };
        let method = LightTransport::new(&tracer, &guided, &options).only_by(Estimator::Vpls);
        let (found, error) = pixel(&method, seed);
        mean += found / SEEDS as f64;
        variance += (error / SEEDS as f64).powi(2);
    }
    let error = variance.sqrt();
    assert!((mean - truth).abs() < 4.0 * error, "{mean} ± {error} of {truth} ± {its_error}");
    assert!(error < 0.25 * truth, "{error} of {truth}");
}
