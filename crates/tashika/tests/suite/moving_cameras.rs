//! Cameras that move while the shutter is open, compared with a closed form and, for every kind of
//! method, with the mean of pictures by static cameras.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{Affine3A, DAffine3, DMat3, DVec3};
use tashika::Renderer;
use tashika::accel::Tracer;
use tashika::film::{Film, RenderFilm, Window};
use tashika::gather::{GatherOptions, View};
use tashika::integrator::{ControlOptions, FullSum, Integrator, PathStop, PathTracer, SumMethod};
use tashika::math::Vec3;
use tashika::math::elementary::{rotation, sin_cos_f64};
use tashika::math::motion::Track;
use tashika::render::{TileShare, with_threads};
use tashika::scene::{Camera, Material, Projection, builtin};
use tashika::stats::Moments;
use tashika::tree::LightSet;
use tashika::vpl::{Provenance, VplOptions, VplSet};

use crate::cases::{builder, film_of, glowing, lambert, luminances, parallelogram, place, tracer};

fn affine(pose: Affine3A) -> DAffine3 {
    DAffine3 { matrix3: pose.matrix3.as_dmat3(), translation: pose.translation.as_dvec3() }
}

fn view<'c>(camera: &'c Camera, size: [u32; 2], points: u32, seed: u64) -> View<'c> {
    View { camera, size, gather: GatherOptions { points, ..GatherOptions::default() }, seed }
}

/// An edge between light and nothing, seen by a camera that moves to the right by `D` pixels at
/// constant speed. With the box filter, a pixel with centre `c` has, for an edge at `e`, the share
/// of light
///
/// ```text
/// ∫₀¹ clamp(a − D s, 0, 1) ds = (H(a) − H(a − D)) / D      a = e − c + ½, H(t) = ∫₀ᵗ clamp(x, 0, 1) dx
/// ```
#[test]
fn an_edge_is_blurred_over_the_way_that_the_camera_goes() {
    const SIDE: u32 = 6;
    const EDGE: f32 = 4.3;
    const WAY: f64 = 2.5;
    const POINTS: u32 = 1024;
    let mut b = builder();
    let lamp = parallelogram(
        Vec3::new(-50.0, -50.0, 0.0),
        Vec3::X * (50.0 + EDGE - 0.5 * SIDE as f32),
        Vec3::Y * 100.0,
    );
    place(&mut b, lamp, glowing("lamp", lambert(0.0), 1.0));
    let floor = parallelogram(Vec3::new(-60.0, -60.0, -1.0), Vec3::X * 120.0, Vec3::Y * 120.0);
    place(&mut b, floor, Material::new("dark", lambert(0.0)));
    let mut camera = Camera::look_at("above", Vec3::Z * 5.0, Vec3::ZERO, Vec3::Y, 1.0);
    camera.projection = Projection::Orthographic { height: SIDE as f32 };
    let from = affine(camera.to_world);
    let to = DAffine3 { translation: from.translation + DVec3::X * WAY, ..from };
    // The camera moves twice as far; the shutter is open for the second half of the motion.
    let before = DAffine3 { translation: from.translation - DVec3::X * WAY, ..from };
    let camera = camera.moving(Track::new([(0.0, before), (2.0, to)]).unwrap(), [1.0, 2.0]);
    b.add_camera(camera.clone()).unwrap();
    let tracer = tracer(b);
    let none = VplSet::new(Vec::new(), Provenance::default());
    let paths = PathTracer::new(&tracer, PathStop::Count(POINTS), 2).unwrap();
    let sums = FullSum::new(&none);
    for (integrator, points) in [(&sums as &dyn Integrator, POINTS), (&paths, 1)] {
        let film = film_of(&tracer, integrator, view(&camera, [SIDE; 2], points, 3));
        assert_eq!(film.metadata().text("camera.shutter"), Some("1,2"));
        for ((x, y), found) in Window::full([SIDE; 2]).pixels().zip(luminances(&film)) {
            let all = |t: f64| if t < 1.0 { 0.5 * t.max(0.0) * t.max(0.0) } else { t - 0.5 };
            let a = f64::from(EDGE) - f64::from(x);
            let expected = (all(a) - all(a - WAY)) / WAY;
            // Five standard errors of independent samples; the samples are stratified and have
            // smaller errors.
            let tolerance = 5.0 * (expected * (1.0 - expected) / f64::from(POINTS)).sqrt() + 1e-4;
            assert!((found - expected).abs() <= tolerance, "pixel {x},{y}: {found} for {expected}");
        }
    }
}

/// The built-in box with a camera that moves to the right and forward and turns by 0.25 while its
/// shutter is open, from 0 to 1 s. The function returns the static camera at a time.
fn swung() -> (Tracer, Camera, impl Fn(f32) -> Camera) {
    let scene = builtin::tiny();
    let still = scene.cameras()[0].clone();
    let at = {
        let still = still.clone();
        move |time: f32| {
            let moved = Affine3A::from_translation(Vec3::new(0.5, 0.1, -0.8) * time);
            let turned = Affine3A::from_quat(rotation(Vec3::Y, 0.25 * time));
            Camera { to_world: moved * still.to_world * turned, ..still.clone() }
        }
    };
    let [open, close] = [at(0.0), at(1.0)].map(|camera| affine(camera.to_world));
    let moving = still.moving(Track::new([(0.0, open), (1.0, close)]).unwrap(), [0.0, 1.0]);
    (Tracer::new(Arc::new(scene)), moving, at)
}

const SIZE: [u32; 2] = [12, 12];

/// Size of images of which many are rendered (pixels).
const STILL_SIZE: [u32; 2] = [8, 8];

/// Number of static cameras, at the midpoints of equal parts of the shutter's interval.
const TIMES: u32 = 12;

/// Asserts over several seeds that each pixel of a moving camera equals the mean over static
/// cameras at many of its poses, within the common error.
fn assert_mean_of_stills(what: &str, render: impl Fn(&Camera, u64) -> Film) {
    const SEEDS: u64 = 12;
    const SIZE: [u32; 2] = STILL_SIZE;
    let (_, moving, at) = swung();
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let mut differences = vec![Moments::default(); pixels];
    let mut image = Moments::default();
    let mut mean = 0.0;
    for seed in 0..SEEDS {
        let mut difference = luminances(&render(&moving, seed));
        mean += difference.iter().sum::<f64>() / (SEEDS as f64 * pixels as f64);
        for k in 0..TIMES {
            let camera = at((k as f32 + 0.5) / TIMES as f32);
            let still = luminances(&render(&camera, 1000 + seed * u64::from(TIMES) + u64::from(k)));
            difference.iter_mut().zip(still).for_each(|(d, l)| *d -= l / f64::from(TIMES));
        }
        image.push(difference.iter().sum::<f64>() / pixels as f64);
        differences.iter_mut().zip(difference).for_each(|(m, d)| m.push(d));
    }
    // Student's t of 11 degrees of freedom exceeds 7.5 with probability 1.2·10⁻⁵, and in one of 64
    // pixels with 8·10⁻⁴; the seeds are fixed. 0.2 % of the mean allow for the use of 12 midpoints
    // instead of all times.
    let off = |m: &Moments| m.mean().abs() / (m.standard_error() + 2e-3 * mean);
    let worst = differences.iter().map(off).fold(0.0, f64::max);
    assert!(worst < 7.5, "{what}: a pixel is {worst} standard errors off");
    assert!(off(&image) < 7.5, "{what}: the image is {} standard errors off", off(&image));
    // The image differs from one without motion.
    let middle = luminances(&render(&at(0.5), 7));
    let blurred = luminances(&render(&moving, 7));
    let far = middle.iter().zip(&blurred).filter(|(a, b)| (*a - *b).abs() > 0.15 * mean).count();
    assert!(far > pixels / 20, "{what}: {far} pixels differ from those of a camera that stands");
}

#[test]
fn a_moving_camera_sees_the_mean_of_what_standing_ones_see() {
    let (tracer, ..) = swung();
    let paths = PathTracer::new(&tracer, PathStop::Count(32), 16).unwrap();
    assert_mean_of_stills("path", |camera, seed| film_of(&tracer, &paths, view(camera, STILL_SIZE, 1, seed)));
    // All images use the same VPLs, so that these cause no difference.
    let lights = VplOptions { count: 200, seed: 9, ..VplOptions::default() };
    let lights = VplSet::trace(&tracer, &lights).unwrap();
    let sums = FullSum::new(&lights);
    assert_mean_of_stills("sum", |camera, seed| film_of(&tracer, &sums, view(camera, STILL_SIZE, 32, seed)));
}

/// A moving camera, rendered by every method. Sums over VPLs are compared with the exact sum at the
/// same gather points, light transport with path tracing. Claims hold.
#[test]
fn every_method_sees_the_camera_move() {
    let (tracer, moving, _) = swung();
    let lights = VplOptions { count: 3000, seed: 9, ..VplOptions::default() };
    let lights = LightSet::new(VplSet::trace(&tracer, &lights).unwrap());
    let seen = view(&moving, SIZE, 16, 5);
    let exact = luminances(&film_of(&tracer, &FullSum::new(lights.set()), seen));
    let options = ControlOptions { error: 0.05, ..ControlOptions::default() };
    for method in SumMethod::ALL {
        let integrator = method.integrator(&lights, &options).unwrap();
        let found = luminances(&film_of(&tracer, &*integrator, seen));
        // The bounds of the first two methods are based on estimates of their cut that ignore
        // shadows.
        let tolerance = if method.name() == "mdlc" || method.name() == "lightcuts" { 0.3 } else { 0.1 };
        let near = found.iter().zip(&exact).filter(|(f, e)| (*f - *e).abs() <= tolerance * *e + 1e-9).count();
        assert!(near >= 137, "{}: {near} of 144 pixels within {tolerance}", method.name());
    }
    let reference = PathTracer::new(&tracer, PathStop::Count(6000), 65).unwrap();
    let reference = film_of(&tracer, &reference, view(&moving, SIZE, 1, 77));
    let errors = reference.plane("standard_error").unwrap().f32_samples().unwrap();
    let truth = luminances(&reference);
    let renderer = Renderer::on(&tracer).camera(moving.clone()).size(SIZE).error(0.05).vpls(100_000);
    let film = renderer.render().unwrap().film;
    let records = RenderFilm::of(&film);
    let found = luminances(&film);
    let mut kept = 0;
    for (i, (x, y)) in Window::full(SIZE).pixels().enumerate() {
        let half_width = f64::from(records.at(x, y).half_width);
        kept += usize::from((found[i] - truth[i]).abs() <= half_width + 3.0 * f64::from(errors[i]));
    }
    // If each interval holds with 95 %, fewer than 126 of 144 hold with probability below 10⁻⁴.
    assert!(kept >= 126, "{kept} of 144 intervals hold the truth");
    let off: f64 = found.iter().zip(&truth).map(|(f, t)| f - t).sum::<f64>() / truth.iter().sum::<f64>();
    assert!(off.abs() < 0.01, "the image is {off} off");
}

#[test]
fn threads_and_shares_do_not_change_a_bit() {
    let render = |threads: usize, share: TileShare| {
        with_threads(threads, || {
            let (tracer, moving, _) = swung();
            ["tashika", "path", "mdlc"].map(|method| {
                let renderer = Renderer::on(&tracer).camera(moving.clone()).size([37, 23]);
                let renderer = renderer.method(method.parse::<tashika::request::MethodName>().unwrap());
                let renderer =
                    if method == "path" { renderer.paths(8) } else { renderer.vpls(2000).error(0.3) };
                renderer.tiles(share.clone()).render().unwrap().film
            })
        })
        .unwrap()
    };
    let one = render(1, TileShare::default());
    assert_eq!(render(3, TileShare::default()), one);
    let mut covered = 0;
    for number in [1, 2] {
        let parts = render(2, TileShare::new(number, 2).unwrap());
        for (part, whole) in parts.iter().zip(&one) {
            let at = |f: &Film, x, y| f.plane("").unwrap().f32_at(x, y).to_vec();
            for (x, y) in part.window().pixels() {
                if part.plane("stop").unwrap().u32_at(x, y) != [0] {
                    covered += 1;
                    assert_eq!(at(part, x, y), at(whole, x, y), "at {x}, {y}");
                }
            }
        }
    }
    assert_eq!(covered, 3 * 37 * 23);
}

/// A camera makes a whole turn, and a lamp covers a quarter of the ring that it sees. Each pixel
/// has the mean over the ring.
#[test]
fn a_whole_turn_sees_the_mean_around() {
    let mut b = builder();
    // A lamp over a quarter of the ring, from −45° to 45° of the direction ahead.
    let lamp = parallelogram(Vec3::new(-1.0, -50.0, -1.0), Vec3::X * 2.0, Vec3::Y * 100.0);
    place(&mut b, lamp, glowing("lamp", lambert(0.0), 1.0));
    let turned = |quarters: f64| {
        let (sin, cos) = sin_cos_f64(0.5 * PI * quarters);
        DAffine3::from_mat3(DMat3::from_cols(DVec3::new(cos, 0.0, -sin), DVec3::Y, DVec3::new(sin, 0.0, cos)))
    };
    let camera = Camera::look_at("c", Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1e-3);
    let keys = [0.0, 1.0, 2.0, 3.0, 4.0].map(|k| (k, turned(k)));
    let camera = camera.moving(Track::new(keys).unwrap(), [0.0, 4.0]);
    b.add_camera(camera.clone()).unwrap();
    let tracer = tracer(b);
    let none = VplSet::new(Vec::new(), Provenance::default());
    let film = film_of(&tracer, &FullSum::new(&none), view(&camera, [3, 3], 1024, 1));
    for found in luminances(&film) {
        // If the lamp does not emit towards the camera, the result is 0. Otherwise it is visible
        // for a quarter of the time. The field of view is 1e-3, so that each end of that quarter
        // affects only one point of a stratified sequence.
        assert!((found - 0.25).abs() <= 3.0 / 1024.0 || found == 0.0, "{found}");
    }
    assert!(luminances(&film).iter().all(|l| *l > 0.0), "the lamp shines towards the camera");
}
