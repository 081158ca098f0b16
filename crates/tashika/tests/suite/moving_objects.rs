//! Objects that move while the shutter is open: closed forms, comparisons with the mean of pictures
//! of static objects, and refusals.

use std::sync::atomic::AtomicBool;

use glam::{DAffine3, DMat3, DVec3};
use tashika::Renderer;
use tashika::accel::Tracer;
use tashika::bsdf::HenyeyGreenstein;
use tashika::color::Rgb;
use tashika::film::{Film, Window};
use tashika::integrator::{GuidedLights, PathSampler, PathStop, PathTracer, Setting, Truth};
use tashika::math::Vec3;
use tashika::math::elementary::{exp, sin_cos_f64};
use tashika::math::motion::Track;
use tashika::render::{RenderOptions, TileShare, render, with_threads};
use tashika::scene::{
    Alpha, AlphaMode, Camera, Emitter, Interface, Material, Medium, MeshData, Projection, Scene,
    SceneBuilder, Surface,
};
use tashika::stats::Moments;
use tashika::vpl::VplOptions;

use crate::cases::{
    add_ceiling_lamp, builder, cuboid, diffuse_room, film, glowing, lambert, luminances, parallelogram,
    paths_keep_what_the_default_promises, place, tracer, view,
};
use crate::sums::directly_lit;

/// Interval in which the shutter is open (s).
const SHUTTER: [f64; 2] = [1.0, 2.0];

/// A translation by `way` while the shutter is open.
pub fn pushed(way: DVec3) -> Track {
    let keys = [(1.0, DVec3::ZERO), (2.0, way)];
    Track::new(keys.map(|(t, way)| (t, DAffine3::from_translation(way)))).unwrap()
}

/// Places a mesh that moves.
pub fn send(b: &mut SceneBuilder, mesh: MeshData, material: Material, track: &Track) {
    let material = b.add_material(material).unwrap();
    let mesh = b.add_mesh(mesh, material).unwrap();
    b.add_moving_instance(mesh, track.clone(), SHUTTER).unwrap().expect("it can be placed");
}

fn paths(tracer: &Tracer, count: u32, size: [u32; 2], seed: u64) -> Film {
    film(tracer, &PathTracer::new(tracer, PathStop::Count(count), 1000).unwrap(), size, 1, seed)
}

/// A lamp moves to the left by `D` pixels; its edge starts at `e`. With the box filter, its share
/// of a pixel with centre `c` is
///
/// ```text
/// ∫₀¹ clamp(a − D s, 0, 1) ds = (H(a) − H(a − D)) / D      a = e − c + ½, H(t) = ∫₀ᵗ clamp(x, 0, 1) dx
/// ```
#[test]
fn a_lamp_that_crosses_a_pixel_is_seen_for_its_share_of_the_time() {
    const SIDE: u32 = 6;
    const EDGE: f32 = 4.3;
    const WAY: f64 = 2.5;
    const COUNT: u32 = 1024;
    let mut b = builder();
    let right = EDGE - 0.5 * SIDE as f32;
    let lamp = parallelogram(Vec3::new(-50.0, -50.0, 0.0), Vec3::X * (50.0 + right), Vec3::Y * 100.0);
    send(&mut b, lamp, glowing("lamp", lambert(0.0), 1.0), &pushed(DVec3::X * -WAY));
    let floor = parallelogram(Vec3::new(-60.0, -60.0, -1.0), Vec3::X * 120.0, Vec3::Y * 120.0);
    place(&mut b, floor, Material::new("dark", lambert(0.0)));
    let mut camera = Camera::look_at("above", Vec3::Z * 5.0, Vec3::ZERO, Vec3::Y, 1.0);
    camera.projection = Projection::Orthographic { height: SIDE as f32 };
    b.add_camera(camera).unwrap();
    let film = paths(&tracer(b), COUNT, [SIDE; 2], 3);
    assert_eq!(film.metadata().text("camera.shutter"), Some("1,2"));
    for ((x, y), found) in Window::full([SIDE; 2]).pixels().zip(luminances(&film)) {
        let all = |t: f64| if t < 1.0 { 0.5 * t.max(0.0) * t.max(0.0) } else { t - 0.5 };
        let a = f64::from(EDGE) - f64::from(x);
        let expected = (all(a) - all(a - WAY)) / WAY;
        // Five standard errors.
        let tolerance = 5.0 * (expected * (1.0 - expected) / f64::from(COUNT)).sqrt() + 1e-4;
        assert!((found - expected).abs() <= tolerance, "pixel {x},{y}: {found} for {expected}");
    }
}

/// Adds a camera that looks along `−z`. Its film is so narrow that all rays are along the axis.
fn needle(b: &mut SceneBuilder, eye: Vec3) {
    b.add_camera(Camera::look_at("c", eye, eye + Vec3::NEG_Z, Vec3::Y, 1e-4)).unwrap();
}

/// Compares the means of a camera along an axis with the expected value: the mean over 16,384
/// paths, and that of sums over the emitters at 32 instants with 20 seeds. 4.4 standard errors are
/// exceeded once in 10⁵; 7.5 by Student's t of 19 degrees of freedom once in 10⁶.
fn assert_axis(b: SceneBuilder, expected: f64, what: &str) {
    let tracer = tracer(b);
    let mean_of = |film: &Film| {
        let mut m = Moments::default();
        luminances(film).into_iter().for_each(|l| m.push(l));
        m
    };
    let by_paths = mean_of(&paths(&tracer, 64, [16, 16], 5));
    let mut by_sums = Moments::default();
    (1..=20).for_each(|seed| by_sums.push(mean_of(&directly_lit(&tracer, 6400, [4, 4], 64, seed)).mean()));
    for (what_else, m, errors) in [("paths", by_paths, 4.4), ("sums", by_sums, 7.5)] {
        let (mean, error) = (m.mean(), m.standard_error());
        assert!(error < 0.02 * expected, "{what}, {what_else}: not sharp: {mean} ± {error}");
        assert!(
            (mean - expected).abs() < errors * error + 1e-5 * expected,
            "{what}, {what_else}: {mean} ± {error} for {expected}"
        );
    }
}

/// A point of a white floor, 2 m below a point light: `ρ/π · I/d²`. A board passes between them for
/// three fifths of the time. An opaque board blocks all of the light in that time, a half-opaque
/// board half of it.
#[test]
fn a_board_before_a_lamp_stops_its_share_of_the_light() {
    for opacity in [1.0_f32, 0.5] {
        let mut b = builder();
        let floor = parallelogram(Vec3::new(-9.0, -9.0, 0.0), Vec3::X * 18.0, Vec3::Y * 18.0);
        place(&mut b, floor, Material::new("floor", lambert(0.8)));
        b.add_emitter(Emitter::Point { position: Vec3::Z * 2.0, intensity: Rgb::gray(5.0) }).unwrap();
        // The board is black, so that it reflects no light; the camera is below it.
        let board = parallelogram(Vec3::new(1.0, -1.0, 1.5), Vec3::X * 3.0, Vec3::Y * 2.0);
        let mut black = Material::new("board", lambert(0.0));
        black.alpha = (opacity < 1.0).then(|| Alpha { value: opacity.into(), mode: AlphaMode::Blend });
        send(&mut b, board, black, &pushed(DVec3::X * -5.0));
        needle(&mut b, Vec3::Z);
        let free = 0.8 / std::f64::consts::PI * 5.0 / 4.0;
        assert_axis(b, free * (1.0 - 0.6 * f64::from(opacity)), &format!("opacity {opacity}"));
    }
}

/// A lamp of half-width `a`, a metre above a floor, grows from 0.3 to 1.8 m. The radiance of the
/// floor below its centre is
///
/// ```text
/// ρ/π ∫₀¹ L ∫∫ 1/(1 + x² + y²)² dx dy du      |x|, |y| ≤ a(u) = 0.3 + 1.5 u
/// ```
///
/// While the lamp is small, mostly sampling it finds the light; while it is large, mostly hitting
/// it by BSDF samples does. Both densities must be those at the time of the path.
#[test]
fn a_lamp_that_grows_lights_by_its_size_at_each_time() {
    let mut b = builder();
    let floor = parallelogram(Vec3::new(-9.0, -9.0, 0.0), Vec3::X * 18.0, Vec3::Y * 18.0);
    place(&mut b, floor, Material::new("floor", lambert(0.8)));
    let lamp = parallelogram(Vec3::new(-0.3, -0.3, 1.0), Vec3::Y * 0.6, Vec3::X * 0.6);
    let grown = DAffine3::from_scale(DVec3::new(6.0, 6.0, 1.0));
    let track = Track::new([(1.0, DAffine3::IDENTITY), (2.0, grown)]).unwrap();
    send(&mut b, lamp, glowing("lamp", lambert(0.0), 1.0), &track);
    needle(&mut b, Vec3::Z * 0.5);
    let parts = |n: u32| (0..n).map(move |k| (f64::from(k) + 0.5) / f64::from(n));
    let of_size = |a: f64| {
        let over = parts(60).flat_map(|x| parts(60).map(move |y| [x, y].map(|x| a * (2.0 * x - 1.0))));
        let sum: f64 = over.map(|[x, y]| 1.0 + x * x + y * y).map(|q| 1.0 / (q * q)).sum();
        sum * 4.0 * a * a / 3600.0
    };
    let mean = parts(60).map(|u| of_size(0.3 + 1.5 * u)).sum::<f64>() / 60.0;
    assert_axis(b, 0.8 / std::f64::consts::PI * mean, "a lamp that grows");
}

/// A slab of an absorbing medium crosses the axis for three fifths of the time.
#[test]
fn a_medium_that_passes_absorbs_for_its_share_of_the_time() {
    let mut b = builder();
    let medium = Medium {
        name: "gel".into(),
        absorption: Rgb::gray(2.0),
        scattering: Rgb::BLACK,
        phase: HenyeyGreenstein::default(),
        variation: None,
    };
    let gel = b.add_medium(medium).unwrap();
    let slab = cuboid(Vec3::new(1.0, -1.0, -1.0), Vec3::new(4.0, 1.0, -0.5), false);
    let material = b.add_material(Material::new("boundary", Surface::Boundary)).unwrap();
    let mesh = b.add_mesh(slab, material).unwrap();
    b.set_interface(mesh, Interface { inside: Some(gel), outside: None }).unwrap();
    b.add_moving_instance(mesh, pushed(DVec3::X * -5.0), SHUTTER).unwrap();
    let lamp = parallelogram(Vec3::new(-9.0, -9.0, -2.0), Vec3::X * 18.0, Vec3::Y * 18.0);
    place(&mut b, lamp, glowing("lamp", lambert(0.0), 1.0));
    needle(&mut b, Vec3::ZERO);
    assert_axis(b, 0.4 + 0.6 * f64::from(exp(-2.0 * 0.5)), "absorbed");
}

/// Track over the shutter's interval: a rotation by `turn` around an axis through `about`, a
/// translation along `way`, and growth by the factor `growth`.
fn spun(about: DVec3, turn: f64, way: DVec3, growth: f64) -> Track {
    let key = |u: f64| {
        let (sin, cos) = sin_cos_f64(turn * u);
        let turned = DMat3::from_cols(DVec3::new(cos, 0.0, -sin), DVec3::Y, DVec3::new(sin, 0.0, cos));
        let linear = DAffine3::from_mat3(turned * (1.0 + u * (growth - 1.0)));
        let at = DAffine3::from_translation;
        (1.0 + u, at(way * u) * at(about) * linear * at(-about))
    };
    Track::new([key(0.0), key(1.0)]).unwrap()
}

/// A room in which a blade turns, a lamp swings and grows, a pane slides in front of the scene and,
/// with fog, a cloud shrinks. The objects are in motion, or static at a given time.
pub fn workshop(at: Option<f64>, fog: bool) -> Scene {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 4.0);
    let mut add = |mesh: MeshData, material: Material, track: Track| {
        let material = b.add_material(material).unwrap();
        let mesh = b.add_mesh(mesh, material).unwrap();
        let placed = match at {
            None => b.add_moving_instance(mesh, track, SHUTTER).unwrap(),
            Some(t) => b.add_instance(mesh, track.at(t).as_affine3a()).unwrap(),
        };
        placed.expect("it can be placed");
        mesh
    };
    let blade = cuboid(Vec3::new(-0.6, 1.3, -0.1), Vec3::new(0.6, 1.35, 0.1), false);
    add(blade, Material::new("blade", lambert(0.7)), spun(DVec3::ZERO, 2.2, DVec3::ZERO, 1.0));
    let lamp = parallelogram(Vec3::new(-0.9, 0.9, -0.3), Vec3::Z * 0.2, Vec3::Y * -0.2);
    let lamp = (lamp, glowing("lamp", lambert(0.2), 20.0));
    add(lamp.0, lamp.1, spun(DVec3::new(-0.9, 0.8, -0.2), 0.5, DVec3::new(0.5, 0.1, 0.2), 2.5));
    let pane = parallelogram(Vec3::new(0.2, 0.1, 0.4), Vec3::X * 0.4, Vec3::Y * 1.2);
    let glass = Surface::ThinGlass {
        ior: 1.5,
        reflectance: Rgb::WHITE.into(),
        transmittance: Rgb::new(0.9, 0.5, 0.3).into(),
        facets: 0.0.into(),
    };
    add(pane, Material::new("pane", glass), spun(DVec3::ZERO, 0.4, DVec3::X * -0.6, 1.5));
    if fog {
        let cloud = cuboid(Vec3::new(0.1, 0.8, -0.8), Vec3::new(0.6, 1.2, -0.2), false);
        let track = spun(DVec3::new(0.3, 1.0, -0.5), 0.8, DVec3::new(-0.4, 0.1, 0.0), 0.7);
        let cloud = add(cloud, Material::new("boundary", Surface::Boundary), track);
        let phase = HenyeyGreenstein::default();
        let [absorption, scattering] = [0.2, 3.0].map(Rgb::gray);
        let fog = b
            .add_medium(Medium { name: "fog".into(), absorption, scattering, phase, variation: None })
            .unwrap();
        b.set_interface(cloud, Interface { inside: Some(fog), outside: None }).unwrap();
    }
    b.build().unwrap()
}

/// Compares the picture of moving objects with the mean of pictures of static objects. `standing`
/// returns the scene at a fraction of the shutter's time. Each pixel agrees over several seeds,
/// within the common error.
pub fn assert_seen_as_the_mean(what: &str, moving: Scene, standing: impl Fn(f64) -> Scene) {
    const SEEDS: u64 = 12;
    const TIMES: u32 = 12;
    const SIZE: [u32; 2] = [8, 8];
    let moving = Tracer::new(moving.into());
    let at = |k: u32| (f64::from(k) + 0.5) / f64::from(TIMES);
    let still: Vec<Tracer> = (0..TIMES).map(|k| Tracer::new(standing(at(k)).into())).collect();
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let mut differences = vec![Moments::default(); pixels];
    let mut image = Moments::default();
    let mut mean = 0.0;
    for seed in 0..SEEDS {
        let mut difference = luminances(&paths(&moving, 480, SIZE, seed));
        mean += difference.iter().sum::<f64>() / (SEEDS as f64 * pixels as f64);
        for (k, tracer) in (0..).zip(&still) {
            let still = luminances(&paths(tracer, 40, SIZE, 1000 + seed * u64::from(TIMES) + k));
            difference.iter_mut().zip(still).for_each(|(d, l)| *d -= l / f64::from(TIMES));
        }
        image.push(difference.iter().sum::<f64>() / pixels as f64);
        differences.iter_mut().zip(difference).for_each(|(m, d)| m.push(d));
    }
    // Student's t of 11 degrees of freedom exceeds 7.5 with probability 1.2·10⁻⁵, and in one of 130
    // numbers with 2·10⁻³; the seeds are fixed. 0.5 % of the mean allow for the use of 12 midpoints
    // instead of all times.
    let off = |m: &Moments| m.mean().abs() / (m.standard_error() + 5e-3 * mean);
    let worst = differences.iter().map(off).fold(0.0, f64::max);
    assert!(image.standard_error() < 0.01 * mean, "not sharp: {} of {mean}", image.standard_error());
    assert!(worst < 7.5, "{what}: a pixel is {worst} standard errors off");
    assert!(off(&image) < 7.5, "{what}: the image is {} standard errors off", off(&image));
    // The picture differs from one without motion.
    let middle = luminances(&paths(&Tracer::new(standing(0.5).into()), 500, SIZE, 1));
    let blurred = luminances(&paths(&moving, 500, SIZE, 1));
    let far = middle.iter().zip(&blurred).filter(|(a, b)| (*a - *b).abs() > 0.1 * mean).count();
    assert!(far > pixels / 10, "{what}: {far} pixels differ from those of things that stand");
}

#[test]
fn what_moves_is_seen_as_the_mean_of_where_it_stands() {
    for fog in [false, true] {
        let standing = |share: f64| workshop(Some(1.0 + share), fog);
        assert_seen_as_the_mean(&format!("fog {fog}"), workshop(None, fog), standing);
    }
}

/// In reconstructed pictures, paths see objects in motion. So do the features that determine which
/// pixels are similar.
#[test]
fn paths_of_pictures_are_those_of_the_integrator() {
    const SEEDS: u64 = 12;
    const SIZE: [u32; 2] = [8, 8];
    for fog in [false, true] {
        let moving = Tracer::new(workshop(None, fog).into());
        let standing = Tracer::new(workshop(Some(1.0), fog).into());
        let method = PathTracer::new(&moving, PathStop::Count(1), 1000).unwrap();
        let setting = |tracer| Setting { tracer, view: view(moving.scene(), SIZE, 1, 1) };
        let window = Window::full(SIZE);
        let mut differences = vec![Moments::default(); window.area() as usize];
        let mut image = Moments::default();
        let mut mean = 0.0;
        for seed in 0..SEEDS {
            let of_integrator = luminances(&paths(&moving, 400, SIZE, seed));
            let found = method.path_sampler(setting(&moving)).tile(&window, 7 + seed, &|_| 400);
            let difference = found.iter().zip(&of_integrator).map(|(a, b)| a.luminance.mean() - b);
            let difference: Vec<f64> = difference.collect();
            mean += of_integrator.iter().sum::<f64>() / (SEEDS as f64 * differences.len() as f64);
            image.push(difference.iter().sum::<f64>() / differences.len() as f64);
            differences.iter_mut().zip(difference).for_each(|(m, d)| m.push(d));
        }
        // The same rule as in `what_moves_is_seen_as_the_mean_of_where_it_stands`.
        let off = |m: &Moments| m.mean().abs() / m.standard_error();
        let worst = differences.iter().map(off).fold(0.0, f64::max);
        assert!(image.standard_error() < 0.01 * mean, "not sharp: {} of {mean}", image.standard_error());
        assert!(worst < 7.5 && off(&image) < 7.5, "fog {fog}: {worst}, the image {}", off(&image));
        let depths = |tracer: &Tracer| {
            let method = PathTracer::new(tracer, PathStop::Count(1), 1000).unwrap();
            let setting = Setting { tracer, view: view(tracer.scene(), SIZE, 1, 1) };
            let found = method.path_sampler(setting).tile(&window, 7, &|_| 64);
            found.iter().map(|pixel| pixel.features.depth).collect::<Vec<f32>>()
        };
        let pairs = depths(&moving).into_iter().zip(depths(&standing));
        let differ = pairs.filter(|(a, b)| (a - b).abs() > 0.02 * b).count();
        assert!(differ > 5, "{differ} pixels see what moves");
    }
}

#[test]
fn threads_and_windows_change_no_bit_of_what_moves() {
    let size = [23, 17];
    let run = |threads: usize, window: Window| {
        with_threads(threads, || {
            let tracer = Tracer::new(workshop(None, false).into());
            let scene = tracer.scene().clone();
            let setting = Setting { tracer: &tracer, view: view(&scene, size, 1, 5) };
            let path = PathTracer::new(&tracer, PathStop::Count(4), 16).unwrap();
            let options = RenderOptions { window, share: TileShare::default() };
            render(&setting, &path, &options, &|_| (), &AtomicBool::new(false)).unwrap().film
        })
        .unwrap()
    };
    let one = run(1, Window::full(size));
    assert_eq!(run(3, Window::full(size)), one);
    let part = Window { x: 5, y: 3, width: 9, height: 7 };
    let whole = luminances(&one);
    for ((x, y), found) in part.pixels().zip(luminances(&run(2, part))) {
        assert_eq!(found, whole[(y * size[0] + x) as usize], "{x}, {y}");
    }
}

/// Light transport by VPLs does not support motion. It refuses moving objects at the start; the
/// message names the methods that render them, and a time at which everything stands still. The
/// default method makes its claims by paths.
#[test]
fn what_knows_no_time_refuses_what_moves_and_says_what_renders_it() {
    let tracer = Tracer::new(workshop(None, false).into());
    paths_keep_what_the_default_promises(&tracer);
    let view = view(tracer.scene(), [4, 4], 1, 1);
    let lights = GuidedLights::trace(&tracer, &VplOptions::default(), Truth::Transport, &view);
    let said = lights.expect_err("refused").to_string();
    for expected in ["expected path, or truth vpl", "(1 to 2 s)", "at one time all stands still"] {
        assert!(said.contains(expected), "{said}");
    }
    let still = Tracer::new(workshop(Some(1.5), false).into());
    assert!(Renderer::on(&still).size([4, 4]).vpls(100).error(0.5).render().is_ok());
}
