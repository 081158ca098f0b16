//! Participating media against closed forms, quadrature, the furnace and scenes without media.

use std::f64::consts::PI;
use std::sync::atomic::AtomicBool;

use tashika::Renderer;
use tashika::accel::Tracer;
use tashika::bsdf::HenyeyGreenstein;
use tashika::color::Rgb;
use tashika::film::{Film, Window, keys};
use tashika::gather::View;
use tashika::integrator::{PathStop, PathTracer, Setting, Truth};
use tashika::math::elementary::exp_f64;
use tashika::math::{Affine3A, Vec3};
use tashika::render::{RenderOptions, TileShare, render, with_threads};
use tashika::request::{ClaimName, MethodName};
use tashika::scene::{
    Camera, Emitter, Environment, Interface, Material, Medium, MediumId, MeshData, Scene, SceneBuilder,
    Surface,
};

use crate::cases::{
    add_ceiling_lamp, builder, cuboid, diffuse_room, film, film_of, glowing, lambert, parallelogram,
    paths_keep_what_the_default_promises, place, tracer, view,
};

fn rgb([r, g, b]: [f32; 3]) -> Rgb {
    Rgb::new(r, g, b)
}

pub fn add(b: &mut SceneBuilder, absorption: [f32; 3], scattering: [f32; 3], asymmetry: f32) -> MediumId {
    let [absorption, scattering] = [absorption, scattering].map(rgb);
    let phase = HenyeyGreenstein { asymmetry };
    b.add_medium(Medium { name: "fog".into(), absorption, scattering, phase, variation: None }).unwrap()
}

pub fn bounding(
    b: &mut SceneBuilder,
    mesh: MeshData,
    surface: Surface,
    [inside, outside]: [Option<MediumId>; 2],
) {
    let material = b.add_material(Material::new("boundary", surface)).unwrap();
    let mesh = b.add_mesh(mesh, material).unwrap();
    b.set_interface(mesh, Interface { inside, outside }).unwrap();
    b.add_instance(mesh, Affine3A::IDENTITY).unwrap();
}

/// A camera that looks along `−z`. Its film is so narrow that all rays are along the axis.
pub fn needle(eye: Vec3, medium: Option<MediumId>) -> Camera {
    Camera { medium, ..Camera::look_at("c", eye, eye + Vec3::NEG_Z, Vec3::Y, 1e-4) }
}

pub fn paths(tracer: &Tracer, count: u32, size: [u32; 2]) -> Film {
    film(tracer, &PathTracer::new(tracer, PathStop::Count(count), 1000).unwrap(), size, 1, 3)
}

/// Colours of the pixels.
pub fn colors(film: &Film) -> Vec<Rgb> {
    film.colors().unwrap().collect()
}

/// Mean of all pixels in each channel, and its standard error.
pub fn mean_of(film: &Film) -> [(f64, f64); 3] {
    let pixels = colors(film);
    [0, 1, 2].map(|k| {
        let mut m = tashika::stats::Moments::default();
        pixels.iter().for_each(|c| m.push(f64::from(c[k])));
        (m.mean(), m.standard_error())
    })
}

/// Two-sided level 10⁻⁵ of each comparison.
const Z: f64 = 4.42;

pub fn assert_means(film: &Film, expected: [f64; 3], slack: f64, sharp: f64, what: &str) {
    for ((mean, error), expected) in mean_of(film).into_iter().zip(expected) {
        assert!(error < sharp * expected, "{what}: not sharp: {mean} ± {error}");
        let bound = Z * error + slack * expected;
        assert!((mean - expected).abs() <= bound, "{what}: {mean} ± {error} for {expected}");
    }
}

const ABSORPTION: [f32; 3] = [0.2, 1.0, 3.0];

fn absorbed(metres: f64) -> [f64; 3] {
    ABSORPTION.map(|sigma| exp_f64(-f64::from(sigma) * metres))
}

fn assert_equal(found: Rgb, expected: [f64; 3], what: &str) {
    for (found, expected) in found.to_array().into_iter().zip(expected) {
        // Each of four crossings moves a ray off its surface by about 10⁻⁶ m. With 6 m⁻¹ this
        // changes the transmittance by 6·10⁻⁶; distances are rounded, too.
        let off = (f64::from(found) - expected).abs();
        assert!(off < 3e-5 * expected, "{what}: {found} for {expected}");
    }
}

/// Fog around the camera, in front of a lamp. In the fog are a clear bubble and a slab of gel
/// without a surface. The transmittance follows from the lengths in each, for paths and for shadow
/// segments.
#[test]
fn what_absorbs_only_follows_the_law_of_beer_and_lambert() {
    let mut b = builder();
    let fog = Some(add(&mut b, ABSORPTION, [0.0; 3], 0.0));
    let gel = Some(add(&mut b, ABSORPTION.map(|s| 2.0 * s), [0.0; 3], 0.0));
    let across = |from: f32, to: f32| cuboid(Vec3::new(-1.0, -1.0, to), Vec3::new(1.0, 1.0, from), false);
    bounding(&mut b, across(-0.5, -0.75), Surface::Boundary, [None, fog]);
    bounding(&mut b, across(-1.0, -1.125), Surface::Boundary, [gel, fog]);
    place(
        &mut b,
        parallelogram(Vec3::new(-1.0, -1.0, -2.0), Vec3::X * 2.0, Vec3::Y * 2.0),
        glowing("lamp", lambert(0.0), 1.0),
    );
    b.add_camera(needle(Vec3::ZERO, fog)).unwrap();
    // The distance is 2 m; the bubble is subtracted, and the gel counts twice.
    for c in colors(&paths(&tracer(b), 2, [2, 2])) {
        assert_equal(c, absorbed(2.0 - 0.25 + 0.125), "a lamp seen");
    }
}

/// Light from above passes an absorbing slab on its way to a floor. The camera is below the slab.
#[test]
fn shadow_segments_lose_what_media_absorb_on_the_way() {
    let sun = |direction: Vec3| Emitter::Directional { direction, irradiance: Rgb::WHITE };
    let lamp = Emitter::Point { position: Vec3::new(0.0, 3.0, 0.0), intensity: Rgb::WHITE };
    let slanted = Vec3::new(0.6, -0.8, 0.0);
    let lights = [
        (sun(Vec3::NEG_Y), 0.5, 1.0 / PI),
        (sun(slanted), 0.5 / 0.8, 0.8 / PI),
        (lamp, 0.5, 1.0 / (9.0 * PI)),
    ];
    for (light, metres, unshadowed) in lights {
        for is_fog in [false, true] {
            let mut b = builder();
            let gel = Some(add(&mut b, ABSORPTION, [0.0; 3], 0.0));
            if !is_fog {
                let slab = cuboid(Vec3::new(-9.0, 1.0, -9.0), Vec3::new(9.0, 1.5, 9.0), false);
                bounding(&mut b, slab, Surface::Boundary, [gel, None]);
            }
            let floor = parallelogram(Vec3::new(-9.0, 0.0, -9.0), Vec3::Z * 18.0, Vec3::X * 18.0);
            place(&mut b, floor, Material::new("floor", lambert(1.0)));
            b.add_emitter(light).unwrap();
            let camera = Camera::look_at("c", Vec3::Y * 0.5, Vec3::ZERO, Vec3::Z, 1e-4);
            b.add_camera(Camera { medium: gel.filter(|_| is_fog), ..camera }).unwrap();
            let found = colors(&paths(&tracer(b), 2, [1, 1]))[0];
            let expected = match (is_fog, light) {
                (false, _) => absorbed(metres).map(|t| t * unshadowed),
                (true, Emitter::Point { .. }) => absorbed(0.5 + 3.0).map(|t| t * unshadowed),
                // Unbounded fog transmits nothing from infinity.
                (true, _) => [0.0; 3],
            };
            if expected == [0.0; 3] {
                assert_eq!(found, Rgb::BLACK);
            } else {
                assert_equal(found, expected, "a floor");
            }
        }
    }
}

/// A plate of tinted glass in front of a lamp, seen head-on. The light reflected between its faces
/// adds up to `(1 − F)² T / (1 − F² T²)`.
#[test]
fn glass_absorbs_by_the_medium_in_it() {
    let mut b = builder();
    let tint = Some(add(&mut b, ABSORPTION, [0.0; 3], 0.0));
    let glass =
        Surface::Glass { ior: 1.5, reflectance: Rgb::WHITE, transmittance: Rgb::WHITE, facets: 0.0.into() };
    let plate = cuboid(Vec3::new(-1.0, -1.0, -1.5), Vec3::new(1.0, 1.0, -1.0), false);
    bounding(&mut b, plate, glass, [tint, None]);
    let lamp = parallelogram(Vec3::new(-1.0, -1.0, -2.0), Vec3::X * 2.0, Vec3::Y * 2.0);
    place(&mut b, lamp, glowing("lamp", lambert(0.0), 1.0));
    b.add_camera(needle(Vec3::ZERO, None)).unwrap();
    let face = 0.04_f64;
    let expected = absorbed(0.5).map(|t| (1.0 - face).powi(2) * t / (1.0 - (face * t).powi(2)));
    assert_means(&paths(&tracer(b), 100, [16, 16]), expected, 1e-5, 0.01, "a plate");
}

/// Albedo of [`barely_scattering`]. Light that is scattered twice is at most this fraction of light
/// that is scattered once.
pub const ALBEDO: f32 = 1e-3;
pub const EXTINCTION: [f32; 3] = [0.3, 0.6, 1.2];
const ASYMMETRY: f64 = 0.5;

pub fn barely_scattering(b: &mut SceneBuilder) -> MediumId {
    let absorption = EXTINCTION.map(|s| s * (1.0 - ALBEDO));
    add(b, absorption, EXTINCTION.map(|s| s * ALBEDO), ASYMMETRY as f32)
}

fn phase(cos: f64) -> f64 {
    let g = ASYMMETRY;
    let squared = 1.0 + g * g - 2.0 * g * cos;
    (1.0 - g * g) / (4.0 * PI * squared * squared.sqrt())
}

/// `∫ σ_s exp(−σ (t + d)) p(cos) of(d, cos φ) dt` along the axis of a [`needle`] at the origin, up
/// to `end` metres, for light from `from`. `φ` is the angle at the light from `+x`.
pub fn scattered_once(sigma: f64, end: f64, from: [f64; 3], of: impl Fn(f64, f64) -> f64) -> f64 {
    let steps = 4000;
    let step = end / f64::from(steps);
    let at = |k: i32| {
        let t = (f64::from(k) + 0.5) * step;
        // Vector from the point (0, 0, −t) to the light.
        let to = [from[0], from[1], from[2] + t];
        let d = to.iter().map(|v| v * v).sum::<f64>().sqrt();
        let cos = -to[2] / d;
        f64::from(ALBEDO) * sigma * exp_f64(-sigma * (t + d)) * phase(cos) * of(d, -to[0] / d)
    };
    (0..steps).map(at).sum::<f64>() * step
}

/// A point light beside the axis of a camera in fog.
#[test]
fn light_that_is_scattered_once_is_that_of_quadrature() {
    let mut b = builder();
    let fog = barely_scattering(&mut b);
    b.add_emitter(Emitter::Point { position: Vec3::new(0.4, -0.3, -1.0), intensity: Rgb::WHITE }).unwrap();
    b.add_camera(needle(Vec3::ZERO, Some(fog))).unwrap();
    let film = paths(&tracer(b), 1000, [16, 16]);
    let expected = EXTINCTION.map(|sigma| {
        scattered_once(f64::from(sigma), 40.0 / f64::from(sigma), [0.4, -0.3, -1.0], |d, _| 1.0 / (d * d))
    });
    assert_means(&film, expected, f64::from(ALBEDO) + 1e-4, 0.01, "a point");
}

/// An area lamp beside the axis. Paths reach it by sampling the lamp and by scattering towards it.
/// Only correct weights of both give the quadrature over its area.
#[test]
fn both_ways_to_a_lamp_in_fog_sum_to_that_of_quadrature() {
    let mut b = builder();
    let fog = barely_scattering(&mut b);
    // Radiance 1, facing the axis from −x.
    let lamp = parallelogram(Vec3::new(-0.25, -0.5, -1.5), Vec3::Y, Vec3::Z);
    place(&mut b, lamp, glowing("lamp", lambert(0.0), 1.0));
    let black = parallelogram(Vec3::new(-1.0, -1.0, -2.0), Vec3::X * 2.0, Vec3::Y * 2.0);
    place(&mut b, black, Material::new("end", lambert(0.0)));
    b.add_camera(needle(Vec3::ZERO, Some(fog))).unwrap();
    let film = paths(&tracer(b), 1000, [16, 16]);
    let cells = 24;
    let expected = EXTINCTION.map(|sigma| {
        let cell = |k: i32| (f64::from(k) + 0.5) / f64::from(cells);
        let from = |y: i32, z: i32| [-0.25, cell(y) - 0.5, cell(z) - 1.5];
        let of = |d: f64, cos: f64| cos.max(0.0) / (d * d);
        let all = (0..cells).flat_map(|y| (0..cells).map(move |z| (y, z)));
        all.map(|(y, z)| scattered_once(f64::from(sigma), 2.0, from(y, z), of)).sum::<f64>()
            / f64::from(cells * cells)
    });
    // Quadrature by midpoints of 1/24 m, at a distance of 1/4 m.
    assert_means(&film, expected, f64::from(ALBEDO) + 1e-3, 0.01, "a lamp");
}

/// A medium without absorption is invisible if the incident radiance is equal from all sides: under
/// a sky, with the camera outside the medium, behind glass, and in a room whose walls emit.
#[test]
fn white_media_are_invisible_in_a_furnace() {
    let white = [0.5, 2.0, 6.0];
    let eye = Vec3::new(0.1, 0.2, 3.0);
    let camera = |medium| Camera {
        medium,
        ..Camera::look_at("c", if medium.is_some() { eye * 0.2 } else { eye }, Vec3::ZERO, Vec3::Y, 0.4)
    };
    let block = || cuboid(Vec3::new(-1.0, -1.1, -0.9), Vec3::new(1.0, 0.9, 1.2), false);
    let glass = |alpha: f32| Surface::Glass {
        ior: 1.5,
        reflectance: Rgb::WHITE,
        transmittance: Rgb::WHITE,
        facets: alpha.into(),
    };
    for (surface, g, inside) in [
        (Surface::Boundary, 0.0, false),
        (Surface::Boundary, 0.8, true),
        (Surface::Boundary, -0.6, false),
        (glass(0.0), 0.3, false),
    ] {
        let mut b = builder();
        let milk = Some(add(&mut b, [0.0; 3], white, g));
        let what = format!("{}, g = {g}", surface.kind());
        bounding(&mut b, block(), surface, [milk, None]);
        b.set_environment(Environment::constant(Rgb::WHITE)).unwrap();
        b.add_camera(camera(milk.filter(|_| inside))).unwrap();
        let tracer = tracer(b);
        assert_means(&paths(&tracer, 40, [16, 16]), [1.0; 3], 1e-5, 0.02, &what);
        if surface == Surface::Boundary {
            // A length limit of 1 changes nothing: no surface is met, and boundaries and scattering
            // do not count.
            let path = PathTracer::new(&tracer, PathStop::Count(40), 1).unwrap();
            assert_means(&film(&tracer, &path, [16, 16], 1, 4), [1.0; 3], 1e-5, 0.02, &what);
        }
    }
    // Walls that emit 0.4 and reflect 0.6.
    let mut b = builder();
    let milk = add(&mut b, [0.0; 3], white, 0.5);
    let room = cuboid(Vec3::splat(-4.0), Vec3::splat(4.0), true);
    place(&mut b, room, glowing("wall", lambert(0.6), 0.4));
    b.add_camera(camera(Some(milk))).unwrap();
    assert_means(&paths(&tracer(b), 60, [16, 16]), [1.0; 3], 1e-5, 0.03, "a room");
}

/// A room in a medium of zero coefficients, seen by the code that handles media.
#[test]
fn a_medium_of_zero_coefficients_changes_no_bit() {
    let room = |with: bool| {
        let mut b = diffuse_room();
        add_ceiling_lamp(&mut b, 5.0);
        if with {
            let nothing = add(&mut b, [0.0; 3], [0.0; 3], 0.5);
            let far = cuboid(Vec3::splat(50.0), Vec3::splat(51.0), false);
            // Interfaces that no path crosses, so that segments are traversed by the code for
            // media.
            bounding(&mut b, far, Surface::Boundary, [Some(nothing), None]);
        }
        b
    };
    let plain = tracer(room(false));
    let clear = tracer(room(true));
    assert!(!clear.scene().has_media() && clear.scene().has_interfaces());
    let camera = Camera { medium: Some(MediumId::at(0)), ..plain.scene().cameras()[0].clone() };
    let path = |tracer: &Tracer, camera: &Camera| {
        let path = PathTracer::new(tracer, PathStop::Count(8), 16).unwrap();
        let scene = plain.scene().clone();
        colors(&film_of(tracer, &path, View { camera, ..view(&scene, [24, 16], 1, 3) }))
    };
    let expected = path(&plain, &plain.scene().cameras()[0]);
    assert_eq!(path(&clear, &camera), expected);
    assert!(expected.iter().filter(|c| !c.is_black()).count() > 100);
}

/// A boundary with vacuum on both sides, across every path and every segment.
#[test]
fn a_boundary_of_nothing_is_not_seen() {
    let room = |with_boundary: bool| {
        let mut b = diffuse_room();
        add_ceiling_lamp(&mut b, 5.0);
        let nothing = Some(add(&mut b, [0.0; 3], [0.0; 3], 0.5));
        if with_boundary {
            let about = cuboid(Vec3::new(-0.9, 0.05, -0.9), Vec3::new(0.9, 1.85, 0.9), false);
            bounding(&mut b, about, Surface::Boundary, [nothing, None]);
        }
        tracer(b)
    };
    let (plain, bounded) = (room(false), room(true));
    let expected = paths(&plain, 64, [24, 16]);
    let errors = expected.plane("standard_error").unwrap().f32_samples().unwrap().to_vec();
    for medium in [None, Some(MediumId::at(0))] {
        let path = PathTracer::new(&bounded, PathStop::Count(64), 1000).unwrap();
        let camera = Camera { medium, ..bounded.scene().cameras()[0].clone() };
        let scene = bounded.scene().clone();
        let film = film_of(&bounded, &path, View { camera: &camera, ..view(&scene, [24, 16], 1, 3) });
        for ((a, b), error) in colors(&film).into_iter().zip(colors(&expected)).zip(&errors) {
            let off = (a.luminance() - b.luminance()).abs();
            // The means have this standard error in both pictures.
            assert!(off <= 7.0 * error + 1e-6, "{a:?} and {b:?} ± {error}");
        }
        let [(a, e), ..] = mean_of(&film);
        let [(b, _), ..] = mean_of(&expected);
        assert!((a - b).abs() < 0.02 * b, "{a} ± {e} and {b}");
    }
}

/// A room full of fog, and a block of milk in it.
pub fn foggy_room() -> Scene {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    let fog = Some(add(&mut b, [0.02; 3], [0.1, 0.2, 0.3], 0.4));
    let milk = Some(add(&mut b, [0.0, 0.1, 0.2], [4.0; 3], 0.0));
    let block = cuboid(Vec3::new(-0.7, 0.0, 0.2), Vec3::new(-0.2, 0.5, 0.7), false);
    bounding(&mut b, block, Surface::Boundary, [milk, fog]);
    b.build().unwrap()
}

#[test]
fn threads_and_windows_change_no_bit_in_media() {
    let size = [23, 17];
    let run = |threads: usize, window: Window| {
        with_threads(threads, || {
            let tracer = Tracer::new(foggy_room().into());
            let scene = tracer.scene().clone();
            let camera = Camera { medium: Some(MediumId::at(0)), ..scene.cameras()[0].clone() };
            let view = View { camera: &camera, ..view(&scene, size, 1, 5) };
            let path = PathTracer::new(&tracer, PathStop::Count(4), 16).unwrap();
            let options = RenderOptions { window, share: TileShare::default() };
            render(&Setting { tracer: &tracer, view }, &path, &options, &|_| (), &AtomicBool::new(false))
                .unwrap()
                .film
        })
        .unwrap()
    };
    let one = run(1, Window::full(size));
    assert_eq!(run(3, Window::full(size)), one);
    let part = Window { x: 5, y: 3, width: 9, height: 7 };
    let cut = colors(&run(2, part));
    let whole = colors(&one);
    for ((x, y), color) in part.pixels().zip(cut) {
        assert_eq!(color, whole[(y * size[0] + x) as usize], "{x}, {y}");
    }
}

/// The default method makes its claims about light transport by paths where media scatter, and by
/// VPLs where they only absorb. All methods render both.
#[test]
fn every_method_renders_media() {
    let absorbing = || {
        let mut b = diffuse_room();
        add_ceiling_lamp(&mut b, 5.0);
        let tint = Some(add(&mut b, [0.3, 1.0, 2.0], [0.0; 3], 0.0));
        bounding(&mut b, cuboid(Vec3::splat(-0.4), Vec3::splat(0.4), false), Surface::Boundary, [tint, None]);
        tracer(b)
    };
    let renderer = |tracer: &Tracer| Renderer::on(tracer).size([4, 4]).vpls(200);
    let method =
        renderer(&absorbing()).render().unwrap().film.metadata().text(keys::METHOD).map(str::to_owned);
    assert_eq!(method.as_deref(), Some("tashika"));
    let tracer = Tracer::new(foggy_room().into());
    paths_keep_what_the_default_promises(&tracer);
    for (truth, name) in [(Truth::Clamped, "clamped"), (Truth::Transport, "transport")] {
        let image = renderer(&tracer).truth(truth).render().unwrap();
        let said = |key| image.film.metadata().text(key);
        assert_eq!([said(keys::METHOD), said(keys::TRUTH)], [Some("tashika"), Some(name)]);
    }
    let certified = Renderer::on(&tracer).size([4, 4]).claim(ClaimName::Certified).prepare().unwrap();
    assert!(certified.job().is_of_a_sum());
    for method in MethodName::all().filter(|method| method.of_lights().is_some()) {
        let image = renderer(&tracer).method(method).truth(Truth::Vpl).render().unwrap();
        assert!(image.complete, "{method}");
    }
    let stranger = Camera { medium: Some(MediumId::at(7)), ..tracer.scene().cameras()[0].clone() };
    let path = Renderer::on(&tracer).size([4, 4]).method(MethodName::Path).camera(stranger);
    let said = path.render().expect_err("refused").to_string();
    assert!(said.contains("camera medium = 7"), "{said}");
}
