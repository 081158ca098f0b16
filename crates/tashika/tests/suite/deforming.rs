//! Meshes that deform while the shutter is open, compared with the same rigid motion by a
//! transformation, with closed forms, and with the mean of pictures of the intermediate shapes.

use glam::{Affine3A, DAffine3, DVec3, Vec2};
use tashika::accel::Tracer;
use tashika::film::{Film, Window, planes};
use tashika::integrator::{PathStop, PathTracer, Setting};
use tashika::math::motion::Track;
use tashika::math::{Ray, Vec3};
use tashika::render::{add_motion, with_threads};
use tashika::rng::{Purpose, Stream};
use tashika::scene::{
    Camera, Material, MeshData, MeshShape, Projection, Scene, SceneBuilder, Surface, between,
};
use tashika::stats::Moments;

use crate::cases::{
    add_ceiling_lamp, builder, cuboid, diffuse_room, film, glowing, lambert, luminances, parallelogram,
    paths_keep_what_the_default_promises, place, tracer, view,
};
use crate::moving_objects::assert_seen_as_the_mean;
use crate::sums::assert_sums_are_what_paths_find;

/// Interval in which the shutter is open (s).
const SHUTTER: [f64; 2] = [1.0, 2.0];

/// Adds a mesh whose vertices move to the positions given by `way` while the shutter is open.
fn deform(b: &mut SceneBuilder, mesh: MeshData, material: Material, way: impl Fn(Vec3) -> Vec3) {
    let material = b.add_material(material).unwrap();
    let positions = mesh.positions.iter().map(|&p| way(p)).collect();
    let closing = MeshShape { positions, normals: mesh.normals.clone() };
    let mesh = b.add_deforming_mesh(mesh, closing, SHUTTER, material).unwrap();
    b.add_instance(mesh, Affine3A::IDENTITY).unwrap().expect("it can be placed");
}

fn paths(tracer: &Tracer, count: u32, size: [u32; 2], seed: u64) -> Film {
    film(tracer, &PathTracer::new(tracer, PathStop::Count(count), 1000).unwrap(), size, 1, seed)
}

/// A room with a board and a lamp that move in different directions and grow. The motion is stored
/// as moving vertices if `by_vertices`, else as moving transformations.
fn pushed(by_vertices: bool) -> Scene {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 4.0);
    let mut add = |mesh: MeshData, material: Material, way: DVec3, growth: f64| {
        let end = DAffine3::from_translation(way) * DAffine3::from_scale(DVec3::splat(growth));
        if by_vertices {
            let map = end.as_affine3a();
            deform(&mut b, mesh, material, |p| map.transform_point3(p));
            return;
        }
        let material = b.add_material(material).unwrap();
        let mesh = b.add_mesh(mesh, material).unwrap();
        let track = Track::new([(1.0, DAffine3::IDENTITY), (2.0, end)]).unwrap();
        b.add_moving_instance(mesh, track, SHUTTER).unwrap().expect("it can be placed");
    };
    let board = cuboid(Vec3::new(-0.6, 0.9, -0.3), Vec3::new(0.2, 1.0, 0.3), false);
    add(board, Material::new("board", lambert(0.7)), DVec3::new(0.5, -0.3, 0.2), 1.3);
    let lamp = parallelogram(Vec3::new(-0.9, 0.9, -0.3), Vec3::Z * 0.2, Vec3::Y * -0.2);
    add(lamp, glowing("lamp", lambert(0.2), 20.0), DVec3::new(0.6, 0.1, 0.2), 1.8);
    b.build().unwrap()
}

/// Both ways of storing the motion give the same picture up to rounding: rays meet the same
/// objects.
#[test]
fn what_goes_straight_is_the_same_by_its_vertices_as_by_a_map() {
    const SIZE: [u32; 2] = [16, 12];
    let [rigid, deforming] = [false, true].map(|by_vertices| Tracer::new(pushed(by_vertices).into()));
    assert!(deforming.scene().moves() && deforming.scene().shutter() == Some(SHUTTER));
    let ids: Vec<_> = rigid.scene().instance_ids().collect();
    for (a, b) in [(&rigid, &deforming), (&deforming, &rigid)] {
        let mut stream = Stream::new(1, Purpose::Test, 0);
        let mut met = [0; 3];
        for k in 0..20_000 {
            let share = [0.0, 0.25, 0.5, 0.8, 1.0][k % 5];
            let direction = Vec3::from(stream.uniform_3()) - 0.5;
            let ray = Ray::new(Vec3::new(-0.5, 1.25, 0.1), direction);
            let (Some(one), Some(other)) =
                (a.closest_hit_at(&ray, 0, share), b.closest_hit_at(&ray, 0, share))
            else {
                continue;
            };
            // Rays that pass close to an edge may differ.
            let edge = one.barycentric.iter().chain(&other.barycentric).any(|b| *b < 1e-3);
            if edge && one.instance != other.instance {
                continue;
            }
            assert_eq!(one.instance, other.instance, "{ray:?} at {share}");
            assert!((one.t - other.t).abs() < 2e-5 * one.t, "{one:?} for {other:?} at {share}");
            let moving = ids.iter().rev().position(|id| *id == one.instance).unwrap();
            met[moving.min(2)] += 1;
        }
        assert!(met.iter().all(|count| *count > 40), "all are met: {met:?}");
    }
    let [a, b] = [&rigid, &deforming].map(|tracer| luminances(&paths(tracer, 256, SIZE, 7)));
    let mean = a.iter().sum::<f64>() / a.len() as f64;
    // A few paths that pass close to an edge have other values.
    let worst = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let off = (a.iter().sum::<f64>() - b.iter().sum::<f64>()).abs() / a.len() as f64;
    assert!(worst < 0.02 * mean && off < 2e-4 * mean, "{worst} and {off} of {mean}");
    let plain = luminances(&paths(&Tracer::new(pushed(true).into()).plain(), 64, SIZE, 7));
    let threads = with_threads(3, || luminances(&paths(&deforming, 64, SIZE, 7))).unwrap();
    assert_eq!(plain, threads, "the same bits without vector instructions and by other threads");
}

/// Adds a camera that looks along `−z`. Its field of view is so narrow that all rays are nearly its
/// axis.
fn needle(b: &mut SceneBuilder, eye: Vec3) {
    b.add_camera(Camera::look_at("c", eye, eye + Vec3::NEG_Z, Vec3::Y, 1e-4)).unwrap();
}

/// A lamp is a metre above a floor, and two of its corners move outward. At `y = 0.3` its
/// half-width along x grows from `0.3` to `1.8`; at `y = −0.3` it stays. At intermediate times the
/// lamp is a trapezium. The radiance of the floor below its middle is
/// ```text
/// ρ/π ∫₀¹ L ∫∫ 1/(1 + x² + y²)² dx dy du     |y| ≤ 0.3, |x| ≤ 0.3 + 1.5 u (y + 0.3)/0.6
/// ```
#[test]
fn a_lamp_that_deforms_lights_by_its_shape_at_each_time() {
    let mut b = builder();
    let floor = parallelogram(Vec3::new(-9.0, -9.0, 0.0), Vec3::X * 18.0, Vec3::Y * 18.0);
    place(&mut b, floor, Material::new("floor", lambert(0.8)));
    // The lamp consists of strips, so that its sides stay straight.
    const STRIPS: u32 = 24;
    let row = |k: u32| -0.3 + 0.6 * k as f32 / STRIPS as f32;
    let mut lamp = MeshData::default();
    for k in 0..=STRIPS {
        lamp.positions.extend([-0.3, 0.3].map(|x| Vec3::new(x, row(k), 1.0)));
    }
    for k in 0..STRIPS {
        let first = 2 * k;
        lamp.triangles.extend([[first, first + 2, first + 1], [first + 1, first + 2, first + 3]]);
    }
    let grown = |p: Vec3| Vec3::new(p.x * (1.0 + 5.0 * (p.y + 0.3) / 0.6), p.y, p.z);
    deform(&mut b, lamp, glowing("lamp", lambert(0.0), 1.0), grown);
    needle(&mut b, Vec3::Z * 0.5);
    let parts = |n: u32| (0..n).map(move |k| (f64::from(k) + 0.5) / f64::from(n));
    let of_time = |u: f64| {
        let of_row = |v: f64| {
            let (y, half) = (0.6 * v - 0.3, 0.3 + 1.5 * u * v);
            let of_place = |w: f64| 1.0 / (1.0 + y * y + (half * (2.0 * w - 1.0)).powi(2)).powi(2);
            2.0 * half * parts(60).map(of_place).sum::<f64>() / 60.0
        };
        0.6 * parts(60).map(of_row).sum::<f64>() / 60.0
    };
    let expected = 0.8 / std::f64::consts::PI * parts(60).map(of_time).sum::<f64>() / 60.0;
    let mut m = Moments::default();
    luminances(&paths(&tracer(b), 64, [16, 16], 5)).into_iter().for_each(|l| m.push(l));
    let (mean, error) = (m.mean(), m.standard_error());
    assert!(error < 0.02 * expected, "not sharp: {mean} ± {error}");
    // An error exceeds 4.4 standard errors once in 10⁵.
    assert!((mean - expected).abs() < 4.4 * error + 1e-4 * expected, "{mean} ± {error} for {expected}");
}

/// A room with a curtain that swings, a lamp that bends and turns over, and a pane that is
/// stretched while the shutter is open. With `at`, the shapes are fixed as they are after that
/// share of the time.
fn stage(at: Option<f32>) -> Scene {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 4.0);
    let mut add =
        |mesh: MeshData, material: Material, way: &dyn Fn(Vec3) -> Vec3, turn: &dyn Fn(Vec3) -> Vec3| {
            let material = b.add_material(material).unwrap();
            let closing = MeshShape {
                positions: mesh.positions.iter().map(|&p| way(p)).collect(),
                normals: mesh.normals.iter().map(|&n| turn(n)).collect(),
            };
            let mesh = match at {
                None => b.add_deforming_mesh(mesh, closing, SHUTTER, material).unwrap(),
                Some(share) => {
                    let mut mesh = mesh;
                    let all = mesh.positions.iter_mut().zip(&closing.positions);
                    all.chain(mesh.normals.iter_mut().zip(&closing.normals)).for_each(|(a, b)| {
                        *a = between(*a, *b, share);
                    });
                    b.add_mesh(mesh, material).unwrap()
                }
            };
            b.add_instance(mesh, Affine3A::IDENTITY).unwrap().expect("it can be placed");
        };
    let mut curtain = MeshData::default();
    for (i, j) in (0..5).flat_map(|i| (0..5).map(move |j| (i, j))) {
        curtain.positions.push(Vec3::new(-0.7 + 0.2 * i as f32, 0.3 + 0.3 * j as f32, -0.2));
        curtain.normals.push(Vec3::Z);
    }
    for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
        let corner = 5 * i + j;
        curtain.triangles.extend([[corner, corner + 5, corner + 1], [corner + 1, corner + 5, corner + 6]]);
    }
    let swung = |p: Vec3| {
        let low = 1.5 - p.y;
        p + Vec3::new(0.4 * low, 0.2 * low * low, 0.6 * low)
    };
    let turned = |_: Vec3| Vec3::new(-0.4, 0.5, 0.8).normalize();
    add(curtain, Material::new("curtain", lambert(0.8)), &swung, &turned);
    let lamp = parallelogram(Vec3::new(0.5, 0.9, -0.3), Vec3::Z * 0.3, Vec3::Y * -0.3);
    let bent = |p: Vec3| Vec3::new(1.2 - p.x + p.z * p.z, p.y + p.z, -p.z);
    add(lamp, glowing("lamp", lambert(0.2), 20.0), &bent, &|n| n);
    let pane = parallelogram(Vec3::new(0.2, 0.1, 0.4), Vec3::X * 0.4, Vec3::Y * 1.2);
    let glass = Surface::ThinGlass {
        ior: 1.5,
        reflectance: tashika::color::Rgb::WHITE.into(),
        transmittance: tashika::color::Rgb::new(0.9, 0.5, 0.3).into(),
        facets: 0.0.into(),
    };
    add(pane, Material::new("pane", glass), &|p| Vec3::new(2.0 * p.x - 1.0, p.y, p.z + 0.3 * p.y), &|n| n);
    b.build().unwrap()
}

#[test]
fn what_deforms_is_seen_as_the_mean_of_its_shapes() {
    assert_seen_as_the_mean("shapes", stage(None), |share| stage(Some(share as f32)));
}

/// Sums over instants agree with path tracing: lights and gather points of an instant lie on the
/// mesh as it is at that instant.
#[test]
fn sums_over_instants_are_what_paths_find() {
    let tracer = Tracer::new(stage(None).into());
    assert_sums_are_what_paths_find("deforming", &tracer, 0.02, 128);
    paths_keep_what_the_default_promises(&tracer);
}

/// A floor, seen from above, is stretched along x to three times its width, around its middle. A
/// point that is at `x` half-way through moves from `x/2` to `3x/2`.
#[test]
fn motion_vectors_are_those_of_the_vertices() {
    let mut b = builder();
    let floor = parallelogram(Vec3::new(-60.0, -60.0, 0.0), Vec3::X * 120.0, Vec3::Y * 120.0);
    deform(&mut b, floor, Material::new("floor", lambert(0.5)), |p| Vec3::new(3.0 * p.x, p.y, p.z));
    let camera = Camera::look_at("above", Vec3::Z * 5.0, Vec3::ZERO, Vec3::Y, 1.0);
    b.add_camera(Camera { projection: Projection::Orthographic { height: 8.0 }, ..camera }).unwrap();
    let (tracer, size) = (tracer(b), [12, 8]);
    let mut film = Film::new(size, Window::full(size), &[planes::RADIANCE]).unwrap();
    add_motion(&Setting { tracer: &tracer, view: view(tracer.scene(), size, 1, 1) }, &mut film);
    for (x, y) in Window::full(size).pixels() {
        let found = Vec2::from_slice(film.plane(planes::MOTION).unwrap().f32_at(x, y));
        let expected = Vec2::new(x as f32 + 0.5 - 6.0, 0.0);
        assert!((found - expected).length() < 2e-3, "{x},{y}: {found} for {expected}");
    }
}
