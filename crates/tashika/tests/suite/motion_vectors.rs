//! Motion vectors: closed forms for moving cameras and objects in every projection, and films with
//! and without the vectors.

use glam::{Affine3A, DAffine3, DVec3, Vec2};
use tashika::Renderer;
use tashika::accel::Tracer;
use tashika::film::{Film, Window, planes};
use tashika::integrator::Setting;
use tashika::math::Vec3;
use tashika::math::elementary::{atan2, rotation, sin_cos, tan};
use tashika::math::motion::Track;
use tashika::render::{TileShare, add_motion, with_threads};
use tashika::request::{MethodName, Request};
use tashika::scene::{Camera, Lens, Material, Projection, SceneBuilder, SphereMap, builtin};

use crate::cases::{builder, lambert, parallelogram, place, tracer, view};

const SHUTTER: [f64; 2] = [1.0, 2.0];
const SIZE: [u32; 2] = [12, 8];

fn affine(pose: Affine3A) -> DAffine3 {
    DAffine3 { matrix3: pose.matrix3.as_dmat3(), translation: pose.translation.as_dvec3() }
}

fn between(open: DAffine3, close: DAffine3) -> Track {
    Track::new([(SHUTTER[0], open), (SHUTTER[1], close)]).unwrap()
}

/// The camera moved by `way` (m, world) and turned by `angle` about its own vertical axis. Half of
/// both happens before the middle of its time, half after it.
fn sent(camera: Camera, way: Vec3, angle: f32) -> Camera {
    let end = |half: f32| {
        let turned = Affine3A::from_quat(rotation(Vec3::Y, half * angle));
        affine(Affine3A::from_translation(half * way) * camera.to_world * turned)
    };
    let track = between(end(-0.5), end(0.5));
    camera.moving(track, SHUTTER)
}

fn floor(b: &mut SceneBuilder) {
    let mesh = parallelogram(Vec3::new(-60.0, -60.0, 0.0), Vec3::X * 120.0, Vec3::Y * 120.0);
    place(b, mesh, Material::new("floor", lambert(0.5)));
}

fn above(projection: Projection) -> Camera {
    Camera { projection, ..Camera::look_at("above", Vec3::Z * 5.0, Vec3::ZERO, Vec3::Y, 1.0) }
}

/// Motion vector of each pixel, as the first camera of a scene sees it.
fn vectors(tracer: &Tracer) -> impl Fn(u32, u32) -> Vec2 + use<> {
    let mut film = Film::new(SIZE, Window::full(SIZE), &[planes::RADIANCE]).unwrap();
    add_motion(&Setting { tracer, view: view(tracer.scene(), SIZE, 1, 1) }, &mut film);
    move |x, y| Vec2::from_slice(film.plane(planes::MOTION).unwrap().f32_at(x, y))
}

fn of_camera(camera: Camera, with_floor: bool) -> impl Fn(u32, u32) -> Vec2 {
    let mut b = builder();
    if with_floor {
        floor(&mut b);
    } else {
        // An object out of sight, because a scene must not be empty.
        place(&mut b, parallelogram(Vec3::Z * 900.0, Vec3::X, Vec3::Y), Material::new("far", lambert(0.5)));
    }
    b.add_camera(camera).unwrap();
    vectors(&tracer(b))
}

#[track_caller]
fn near(found: Vec2, expected: Vec2, what: &str) {
    assert!((found - expected).length() < 2e-3, "{what}: {found} for {expected}");
}

/// A camera pans over a plane at right angles to its axis, at a distance of 5 m. The whole plane
/// moves in the opposite direction, by `way / (pixel's side there)`; right and up are positive.
#[test]
fn a_plane_goes_the_other_way_than_a_camera_that_pans() {
    let way = Vec3::new(2.5, 1.0, 0.0);
    let height = SIZE[1] as f32;
    for (projection, side) in [
        (Projection::Orthographic { height }, 1.0),
        (Projection::Perspective { vertical_fov: 0.9 }, 5.0 * 2.0 * tan(0.45) / height),
    ] {
        let mut camera = sent(above(projection), way, 0.0);
        // The vector is that through the centre of the lens, however wide the lens is.
        camera.lens = Lens::round(0.3, 2.0);
        let found = of_camera(camera, true);
        for (x, y) in Window::full(SIZE).pixels() {
            near(found(x, y), Vec2::new(-2.5, -1.0) / side, &format!("{projection:?} {x},{y}"));
        }
    }
}

/// A moving object has its own vector; a static object behind it has none.
#[test]
fn a_square_that_moves_has_its_own_vector() {
    let mut b = builder();
    floor(&mut b);
    let square = parallelogram(Vec3::new(-2.0, -2.0, 1.0), Vec3::X * 4.0, Vec3::Y * 4.0);
    let material = b.add_material(Material::new("square", lambert(0.5))).unwrap();
    let mesh = b.add_mesh(square, material).unwrap();
    let end = |half: f64| DAffine3::from_translation(half * DVec3::new(2.0, 0.6, 0.0));
    b.add_moving_instance(mesh, between(end(-0.5), end(0.5)), SHUTTER).unwrap().unwrap();
    b.add_camera(above(Projection::Orthographic { height: SIZE[1] as f32 })).unwrap();
    let found = vectors(&tracer(b));
    for (x, y) in Window::full(SIZE).pixels() {
        let inside = (4..8).contains(&x) && (2..6).contains(&y);
        let expected = if inside { Vec2::new(2.0, 0.6) } else { Vec2::ZERO };
        near(found(x, y), expected, &format!("{x},{y}"));
        assert!(inside || found(x, y) == Vec2::ZERO, "nothing moves at {x},{y}");
    }
}

/// A turning wheel: the vector of each point is the chord of its own arc.
#[test]
fn places_of_a_wheel_have_vectors_of_their_own() {
    const ANGLE: f32 = 0.7;
    let mut b = builder();
    let wheel = parallelogram(Vec3::new(-9.0, -9.0, 0.0), Vec3::X * 18.0, Vec3::Y * 18.0);
    let material = b.add_material(Material::new("wheel", lambert(0.5))).unwrap();
    let mesh = b.add_mesh(wheel, material).unwrap();
    let end = |half: f32| affine(Affine3A::from_quat(rotation(Vec3::Z, half * ANGLE)));
    b.add_moving_instance(mesh, between(end(-0.5), end(0.5)), SHUTTER).unwrap().unwrap();
    b.add_camera(above(Projection::Orthographic { height: SIZE[1] as f32 })).unwrap();
    let found = vectors(&tracer(b));
    for (x, y) in Window::full(SIZE).pixels() {
        let place = Vec2::new(x as f32 + 0.5 - 6.0, 4.0 - (y as f32 + 0.5));
        // Half of the angle lies before and half after: the chord is 2 sin(θ/2), to the left as
        // seen from the hub.
        let expected = 2.0 * sin_cos(0.5 * ANGLE).0 * place.perp();
        near(found(x, y), expected, &format!("{x},{y}"));
    }
}

/// The environment moves by the camera's rotation alone. Let a point in a perspective view be at
/// `x, y` from the middle, in focal lengths, with `φ = atan x`. If the camera turns to the left by
/// `α`, the point goes from `φ − α/2` to `φ + α/2`, and its height at `φ′` is `y cos φ / cos φ′`.
#[test]
fn the_environment_follows_the_turning_of_the_camera() {
    const ANGLE: f32 = 0.2;
    let camera = above(Projection::Perspective { vertical_fov: 0.9 });
    let found = of_camera(sent(camera.clone(), Vec3::X * 3.0, ANGLE), false);
    let focal = 0.5 * SIZE[1] as f32 / tan(0.45);
    for (x, y) in Window::full(SIZE).pixels() {
        let [u, v] = [x as f32 + 0.5 - 6.0, 4.0 - (y as f32 + 0.5)].map(|v| v / focal);
        let phi = atan2(u, 1.0);
        let at = |phi_then: f32| Vec2::new(tan(phi_then), v * sin_cos(phi).1 / sin_cos(phi_then).1);
        let expected = focal * (at(phi + 0.5 * ANGLE) - at(phi - 0.5 * ANGLE));
        near(found(x, y), expected, &format!("{x},{y}"));
    }
    let pushed = of_camera(sent(camera, Vec3::new(3.0, 1.0, -2.0), 0.0), false);
    let parallel = of_camera(sent(above(Projection::Orthographic { height: 8.0 }), Vec3::X, ANGLE), false);
    for (x, y) in Window::full(SIZE).pixels() {
        near(pushed(x, y), Vec2::ZERO, "infinitely far away");
        assert_eq!(parallel(x, y), Vec2::ZERO, "parallel rays show one direction alone");
    }
}

/// A latitude-longitude picture moves as a whole, also across its edge. In a fisheye, a point moves
/// by the change of the angle between its direction and the axis.
#[test]
fn all_around_ways_are_the_shorter_ones() {
    const ANGLE: f32 = 1.1;
    let up = Camera::look_at("c", Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.0);
    let all = Camera { projection: Projection::Spherical { map: SphereMap::LatLong }, ..up };
    let found = of_camera(sent(all, Vec3::ZERO, ANGLE), false);
    let expected = Vec2::new(ANGLE / (2.0 * std::f32::consts::PI) * SIZE[0] as f32, 0.0);
    for (x, y) in Window::full(SIZE).pixels() {
        near(found(x, y), expected, &format!("{x},{y}"));
    }
    let fisheye = above(Projection::Fisheye { angle: 2.0 });
    let found = of_camera(sent(fisheye, Vec3::ZERO, 0.3), false);
    for (x, y) in Window::full(SIZE).pixels() {
        let place = Vec2::new(x as f32 + 0.5 - 6.0, 4.0 - (y as f32 + 0.5));
        // The edge is 4 pixels, or 1 radian, from the axis. A point that enters across the edge has
        // no vector.
        let theta = place.length() / 4.0;
        let at = |angle: f32| {
            let across = place.normalize() * sin_cos(theta).0;
            let ((sin, cos), ahead) = (sin_cos(angle), sin_cos(theta).1);
            let turned = Vec2::new(across.x * cos + ahead * sin, across.y);
            let theta = atan2(turned.length(), ahead * cos - across.x * sin);
            (theta <= 1.0).then(|| 4.0 * theta * turned.normalize())
        };
        let way = at(-0.15).zip(at(0.15)).map(|(open, close)| close - open).filter(|_| theta <= 1.0);
        near(found(x, y), way.unwrap_or(Vec2::ZERO), &format!("fisheye {x},{y}"));
    }
    assert_eq!(found(0, 0), Vec2::ZERO, "nothing is shown there");
}

/// A point that is behind the camera when the shutter opens has no vector.
#[test]
fn what_comes_from_behind_the_camera_has_no_vector() {
    let camera = sent(above(Projection::Perspective { vertical_fov: 0.9 }), Vec3::Z * 12.0, 0.0);
    let found = of_camera(camera, true);
    assert!(Window::full(SIZE).pixels().all(|(x, y)| found(x, y) == Vec2::ZERO));
}

/// For every method, vectors of static objects are 0 and the other planes equal those of a render
/// without vectors. Threads and the division into parts have no effect.
#[test]
fn vectors_change_nothing_else_and_are_the_same_for_threads_and_shares() {
    let of_sum = Request { vpls: Some(300), gather: Some(3), ..Request::of_a_sum() };
    let requests = [("tashika", of_sum.clone()), ("lightcuts", of_sum), ("path", Request::default())];
    for (method, request) in requests {
        let request = Request { paths: (method == "path").then_some(2), ..request };
        let renderer = || {
            let name = method.parse::<MethodName>().unwrap();
            Renderer::new(builtin::tiny()).request(request.clone()).size([24, 18]).method(name)
        };
        let still = renderer().motion_vectors().render().unwrap().film;
        assert!(still.plane(planes::MOTION).unwrap().f32_samples().unwrap().iter().all(|v| v.to_bits() == 0));
        let camera = sent(builtin::tiny().cameras()[0].clone(), Vec3::X * 0.1, 0.05);
        let moving = || renderer().camera(camera.clone());
        let plain = moving().render().unwrap().film;
        let [one, three] = [1, 3].map(|threads| {
            with_threads(threads, || moving().motion_vectors().render().unwrap().film).unwrap()
        });
        assert_eq!(one, three, "{method}");
        assert_eq!(one.planes().len(), plain.planes().len() + 1, "{method}");
        assert!(plain.planes().iter().all(|plane| one.plane(plane.name()) == Some(plane)), "{method}");
        let whole = one.plane(planes::MOTION).unwrap();
        assert!(whole.f32_samples().unwrap().iter().filter(|v| **v != 0.0).count() > 800, "{method}");
        for number in 1..=2 {
            let part = moving().motion_vectors().tiles(TileShare::new(number, 2).unwrap());
            let part = part.render().unwrap().film;
            for (x, y) in part.window().pixels() {
                let is_there = part.plane(planes::STOP).unwrap().u32_at(x, y) != [0];
                let expected = if is_there { whole.f32_at(x, y) } else { &[0.0; 2] };
                assert_eq!(part.plane(planes::MOTION).unwrap().f32_at(x, y), expected, "{method} {x},{y}");
            }
        }
    }
}
