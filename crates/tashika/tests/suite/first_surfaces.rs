//! Planes about the first surfaces of camera rays, compared with closed forms: the transmittance
//! between camera and surface, and the mean time at which the surface is visible.

use glam::{DAffine3, DVec3};
use tashika::Renderer;
use tashika::accel::Tracer;
use tashika::color::Rgb;
use tashika::film::{Film, Window, planes};
use tashika::integrator::Setting;
use tashika::math::Vec3;
use tashika::math::elementary::exp_f64;
use tashika::math::motion::Track;
use tashika::render::{TileShare, add_time, add_transmittance, with_threads};
use tashika::scene::{Camera, Material, MediumId, Projection, Scattered, SceneBuilder, Surface, builtin};
use tashika::stats::Moments;

use crate::cases::{builder, cuboid, lambert, parallelogram, place, tracer, view};
use crate::grid_media::{self, grid};
use crate::media::{add, bounding};

const SIZE: [u32; 2] = [12, 8];
/// Height of the camera above the floor (m).
const HEIGHT: f32 = 5.0;

/// Adds an orthographic camera that looks down from inside a medium. A pixel is one metre wide.
fn above(b: &mut SceneBuilder, medium: Option<MediumId>) {
    let camera = Camera::look_at("above", Vec3::Z * HEIGHT, Vec3::ZERO, Vec3::Y, 1.0);
    let projection = Projection::Orthographic { height: SIZE[1] as f32 };
    b.add_camera(Camera { projection, medium, ..camera }).unwrap();
}

/// Adds a floor that fills the left half of the film.
fn floor(b: &mut SceneBuilder) {
    let mesh = parallelogram(Vec3::new(-60.0, -60.0, 0.0), Vec3::X * 60.0, Vec3::Y * 120.0);
    place(b, mesh, Material::new("floor", lambert(0.5)));
}

fn film(tracer: &Tracer, samples: u32, add: impl Fn(&Setting<'_>, &mut Film, u32)) -> Film {
    let mut film = Film::new(SIZE, Window::full(SIZE), &[planes::RADIANCE]).unwrap();
    add(&Setting { tracer, view: view(tracer.scene(), SIZE, 1, 1) }, &mut film, samples);
    film
}

/// A floor is seen through two media, whose boundary has no material, and partly through glass. The
/// transmittance is `exp(−Σ σ d)` along the way to the floor, or to infinity where there is no
/// floor. At glass, the way ends at the surface of the glass.
#[test]
fn transmittance_is_that_of_the_way_to_the_first_surface() {
    let (air, gel) = ([[0.1, 0.02, 0.0], [0.1, 0.2, 0.0]], [[0.3, 0.0, 0.2], [0.0, 0.7, 0.2]]);
    let mut b = builder();
    floor(&mut b);
    let [air_id, gel_id] = [air, gel].map(|[absorbs, scatters]| Some(add(&mut b, absorbs, scatters, 0.3)));
    let slab = cuboid(Vec3::new(-80.0, -80.0, 1.0), Vec3::new(80.0, 0.0, 2.5), false);
    bounding(&mut b, slab, Surface::Boundary, [gel_id, air_id]);
    let block = cuboid(Vec3::new(-80.0, 3.0, 3.0), Vec3::new(80.0, 80.0, 4.0), false);
    let glass =
        Surface::Glass { ior: 1.5, reflectance: Rgb::WHITE, transmittance: Rgb::WHITE, facets: 0.0.into() };
    bounding(&mut b, block, glass, [gel_id, air_id]);
    above(&mut b, air_id);
    let film = film(&tracer(b), 4, add_transmittance);
    let found = film.plane(planes::TRANSMITTANCE).unwrap();
    let of = |way: f32, channel: usize, medium: [[f32; 3]; 2]| {
        f64::from(medium[0][channel] + medium[1][channel]) * f64::from(way)
    };
    // The filter is wider than a pixel, so pixels beside an edge are skipped.
    for (x, y) in Window::full(SIZE).pixels().filter(|(x, y)| ![5, 6].contains(x) && [0, 2, 5, 6].contains(y))
    {
        for channel in 0..3 {
            let depth = match (y, x < 6) {
                (0, _) => of(HEIGHT - 4.0, channel, air),
                (5.., true) => of(HEIGHT - 1.5, channel, air) + of(1.5, channel, gel),
                (_, true) => of(HEIGHT, channel, air),
                (5.., false) => of(f32::MAX, channel, air) + of(1.5, channel, gel),
                (_, false) => of(f32::MAX, channel, air),
            };
            let (found, expected) = (f64::from(found.f32_at(x, y)[channel]), exp_f64(-depth));
            assert!((found - expected).abs() < 1e-5, "{x},{y},{channel}: {found} for {expected}");
        }
    }
}

/// The floor is seen through a medium whose density is a ramp `D`. The mean over all pixels is
/// `exp(−σ ∫ D)`, within 4.4 of its standard errors.
#[test]
fn transmittance_of_smoke_is_unbiased() {
    let mut b = builder();
    let mesh = parallelogram(Vec3::new(-60.0, -60.0, 0.0), Vec3::X * 120.0, Vec3::Y * 120.0);
    place(&mut b, mesh, Material::new("floor", lambert(0.5)));
    let whole = [Vec3::new(-80.0, -80.0, 1.0), Vec3::new(80.0, 80.0, 3.0)];
    let density = grid([1, 1, 2], whole, |[.., z]| [if z < 0.5 { 0.2 } else { 1.0 }; 3]);
    let smoke = grid_media::add(&mut b, [[0.3, 0.0, 0.1], [0.2; 3]], 0.0, Some(density), Scattered::Evenly);
    bounding(&mut b, cuboid(whole[0], whole[1], false), Surface::Boundary, [Some(smoke), None]);
    above(&mut b, None);
    let film = film(&tracer(b), 64, add_transmittance);
    let found = film.plane(planes::TRANSMITTANCE).unwrap();
    for (channel, sigma) in [0.5, 0.2, 0.3].into_iter().enumerate() {
        let mut moments = Moments::default();
        for (x, y) in Window::full(SIZE).pixels() {
            moments.push(f64::from(found.f32_at(x, y)[channel]));
        }
        // The density is linear between the centres of the two cells, and its mean is 0.6.
        let expected = exp_f64(-sigma * 0.6 * 2.0);
        assert!(
            (moments.mean() - expected).abs() < 4.4 * moments.standard_error(),
            "{} ± {} for {expected}",
            moments.mean(),
            moments.standard_error()
        );
        assert!(moments.standard_error() < 0.01);
    }
}

/// A square moves to the right across the film, above a floor that ends in the middle. In pixels
/// that the square crosses, the time is the middle of the interval in which the square is there. On
/// the floor, which is visible all the time, it is 0.5; elsewhere it is 0. About 240 samples fall
/// into the interval, a quarter of the time, so the standard deviation of the mean is at most
/// 0.0043. The times of neighbouring pixels differ by 0.056.
#[test]
fn time_in_front_is_that_of_what_passes() {
    let mut b = builder();
    floor(&mut b);
    let square = parallelogram(Vec3::new(-2.0, -2.0, 1.0), Vec3::X * 4.0, Vec3::Y * 4.0);
    let material = b.add_material(Material::new("square", lambert(0.5))).unwrap();
    let mesh = b.add_mesh(square, material).unwrap();
    let shutter = [1.0, 3.0];
    let end = |x: f64| DAffine3::from_translation(x * DVec3::X);
    let track = Track::new([(shutter[0], end(-9.0)), (shutter[1], end(9.0))]).unwrap();
    b.add_moving_instance(mesh, track, shutter).unwrap().unwrap();
    above(&mut b, None);
    let film = film(&tracer(b), 1024, add_time);
    for (x, y) in Window::full(SIZE).pixels().filter(|(x, y)| ![5, 6].contains(x) && [0, 3, 4, 7].contains(y))
    {
        let found = film.plane(planes::TIME).unwrap().f32_at(x, y)[0];
        let expected = match (y, x < 6) {
            (3 | 4, _) => (x as f32 + 0.5 - 6.0 + 9.0) / 18.0,
            (_, true) => 0.5,
            (_, false) => 0.0,
        };
        let most = if matches!(y, 3 | 4) { 0.018 } else { 0.0 };
        assert!((found - expected).abs() <= most, "{x},{y}: {found} for {expected}");
    }
}

/// Without motion and media, films do not have these planes. Otherwise all films have them, with
/// the same values for any number of threads and shares.
#[test]
fn films_have_the_planes_that_tell_something() {
    let renderer = || Renderer::new(builtin::tiny()).size([24, 18]).paths(2);
    let names = |film: &Film| [planes::TIME, planes::TRANSMITTANCE].map(|plane| film.plane(plane).is_some());
    assert_eq!(names(&renderer().render().unwrap().film), [false; 2]);

    let mut camera = builtin::tiny().cameras()[0].clone();
    let end = |x: f64| DAffine3::from_translation(DVec3::X * x) * affine(&camera);
    let track = Track::new([(0.0, end(0.0)), (1.0, end(0.1))]).unwrap();
    camera = camera.moving(track, [0.0, 1.0]);
    assert_eq!(names(&renderer().camera(camera).render().unwrap().film), [true, false]);

    let mut b = builder();
    floor(&mut b);
    let fog = Some(add(&mut b, [0.1; 3], [0.2; 3], 0.0));
    above(&mut b, fog);
    let tracer = tracer(b);
    let foggy = || Renderer::on(&tracer).size([24, 18]).paths(2);
    let [one, three] =
        [1, 3].map(|threads| with_threads(threads, || foggy().render().unwrap().film).unwrap());
    assert_eq!((names(&one), &one), ([false, true], &three));
    let whole = one.plane(planes::TRANSMITTANCE).unwrap();
    for number in 1..=2 {
        let part = foggy().tiles(TileShare::new(number, 2).unwrap()).render().unwrap().film;
        for (x, y) in part.window().pixels() {
            let is_there = part.plane(planes::STOP).unwrap().u32_at(x, y) != [0];
            let expected = if is_there { whole.f32_at(x, y) } else { &[0.0; 3] };
            assert_eq!(part.plane(planes::TRANSMITTANCE).unwrap().f32_at(x, y), expected, "{x},{y}");
        }
    }
}

fn affine(camera: &Camera) -> DAffine3 {
    let pose = camera.to_world;
    DAffine3 { matrix3: pose.matrix3.as_dmat3(), translation: pose.translation.as_dvec3() }
}
