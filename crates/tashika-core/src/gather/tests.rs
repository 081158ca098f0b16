//! Tests of gather points in scenes where their positions are known.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{Affine3A, DAffine3, DVec3, Vec3};

use super::{Filter, GatherOptions, GatherPoint, View};
use crate::accel::Tracer;
use crate::color::Rgb;
use crate::error::Location;
use crate::film::Window;
use crate::math::motion::Track;
use crate::rng::{Purpose, Stream};
use crate::scene::{
    Camera, CoatBase, Emission, Environment, Material, MeshData, Projection, SceneBuilder, Sensor,
    SensorGrid, Surface,
};

/// Returns a square of half-width 5 m around `center`, its normal along `a × b`.
fn square(center: Vec3, a: Vec3, b: Vec3) -> MeshData {
    let corner = |s: f32, t: f32| center + a * (5.0 * s) + b * (5.0 * t);
    MeshData {
        positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..MeshData::default()
    }
}

fn add(b: &mut SceneBuilder, mesh: MeshData, surface: Surface, radiance: f32) {
    let mut material = Material::new("m", surface);
    if radiance > 0.0 {
        material.emission = Some(Emission { radiance: Rgb::gray(radiance).into(), two_sided: true });
    }
    let material = b.add_material(material).unwrap();
    let mesh = b.add_mesh(mesh, material).unwrap();
    b.add_instance(mesh, Affine3A::IDENTITY).unwrap();
}

fn lambert() -> Surface {
    Surface::Lambert { reflectance: Rgb::gray(0.5).into() }
}

/// Returns a scene with a camera at the origin that looks along `−z`.
fn tracer(fill: impl FnOnce(&mut SceneBuilder)) -> Tracer {
    let mut b = SceneBuilder::new("gather", Location::default());
    fill(&mut b);
    b.add_camera(Camera::look_at("c", Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 0.4)).unwrap();
    Tracer::new(Arc::new(b.build().unwrap()))
}

fn view(tracer: &Tracer, points: u32) -> View<'_> {
    let gather = GatherOptions { points, filter: Filter::Box };
    View { camera: &tracer.scene().cameras()[0], size: [16, 16], gather, seed: 3 }
}

#[test]
fn a_mirror_shows_what_is_behind_the_camera() {
    let t = tracer(|b| {
        let mirror = Surface::Mirror { reflectance: Rgb::new(0.9, 0.5, 0.2).into() };
        add(b, square(Vec3::NEG_Z * 2.0, Vec3::X, Vec3::Y), mirror, 0.0);
        add(b, square(Vec3::Z * 3.0, Vec3::Y, Vec3::X), lambert(), 4.0);
    });
    for pixel in [[0, 0], [7, 8], [15, 3]] {
        let sum = view(&t, 8).pixel(&t, pixel);
        assert_eq!(sum.points.len(), 8);
        for p in &sum.points {
            assert!((p.position.z - 3.0).abs() < 1e-5 && p.position.z < 3.0, "on the wall, in front of it");
            assert!(p.geometric_normal.z < -0.999 && p.wo.z > 0.9, "seen from the front");
            assert!((p.weight * 8.0 - Rgb::new(0.9, 0.5, 0.2)).max_channel().abs() < 1e-5);
        }
        // Emission of the wall, reflected by the mirror.
        assert!((sum.background - Rgb::new(0.9, 0.5, 0.2) * 4.0).max_channel().abs() < 1e-4);
        assert!((sum.features.depth - 2.0).abs() < 0.1 && sum.features.coverage == 1.0);
    }
}

/// A rough pane transmits light from behind and reflects light from the front, with almost no loss.
#[test]
fn rough_panes_gather_from_both_sides() {
    let t = tracer(|b| {
        let pane = Surface::ThinGlass {
            ior: 1.5,
            reflectance: Rgb::WHITE.into(),
            transmittance: Rgb::WHITE.into(),
            facets: 0.02.into(),
        };
        add(b, square(Vec3::NEG_Z * 2.0, Vec3::X, Vec3::Y), pane, 0.0);
    });
    let n = 4096;
    let points = view(&t, n).pixel(&t, [8, 8]).points;
    assert_eq!(points.len() as u32, n);
    let mut s = Stream::new(1, Purpose::Test, 0);
    let mut arrives = [0.0; 2];
    for p in &points {
        let Some(sample) = p.bsdf.sample(p.wo, s.uniform_3()) else { continue };
        let is_before = p.frame.to_world(sample.wi).z > 0.0;
        assert_eq!(is_before, p.geometric_normal.z > 0.0);
        arrives[usize::from(is_before)] += f64::from((p.weight * sample.weight).r);
    }
    // The two faces reflect 0.077 at normal incidence, and masking by facets this smooth is
    // negligible. Standard error 0.005.
    let [behind, before] = arrives;
    assert!((behind - 0.923).abs() < 0.015 && (before - 0.077).abs() < 0.015, "{behind} {before}");
}

#[test]
fn glass_is_seen_through_and_no_light_is_made() {
    let t = tracer(|b| {
        let glass = || Surface::Glass {
            ior: 1.5,
            reflectance: Rgb::WHITE,
            transmittance: Rgb::gray(0.9),
            facets: 0.0.into(),
        };
        // The two faces of a pane, with outward normals.
        add(b, square(Vec3::NEG_Z * 2.0, Vec3::X, Vec3::Y), glass(), 0.0);
        add(b, square(Vec3::NEG_Z * 2.1, Vec3::Y, Vec3::X), glass(), 0.0);
        add(b, square(Vec3::NEG_Z * 4.0, Vec3::X, Vec3::Y), lambert(), 0.0);
        b.set_environment(Environment::constant(Rgb::gray(1.0))).unwrap();
    });
    let n = 1024;
    let sum = view(&t, n).pixel(&t, [8, 8]);
    let behind = sum.points.iter().filter(|p| (p.position.z + 4.0).abs() < 1e-4).count();
    assert_eq!(
        behind,
        sum.points.len(),
        "what gathers is the wall; reflections see the sky behind the camera"
    );
    // Two boundaries of reflectance 0.04 reflect 8 % of the samples, including all orders of
    // internal reflection. Standard error 0.9 %.
    let share = f64::from(sum.points.len() as u32) / f64::from(n);
    assert!((share - 0.923).abs() < 0.03, "{share}");
    let weight: Rgb = sum.points.iter().map(|p| p.weight).sum();
    assert!((weight.r / share as f32 - 0.81).abs() < 0.02, "two passages of 0.9: {}", weight.r);
    // Transmission through the parallel faces does not change the direction of the ray.
    let ray = view(&t, n).beginning([8, 8], 0).0.ray().unwrap();
    assert!(sum.points.iter().any(|p| (p.position.x - ray.at(4.0).x).abs() < 0.1));
}

/// Each sample selects either the coat, which mirrors the sky, or the base below. Both
/// contributions have the correct mean.
#[test]
fn a_smooth_coat_mirrors_the_sky_over_a_base_that_gathers() {
    let t = tracer(|b| {
        let (reflectance, specular) = (Rgb::gray(0.6).into(), Rgb::new(1.0, 0.5, 0.25).into());
        let coat = Surface::Coated {
            reflectance,
            base: CoatBase::Saturating,
            specular,
            ior: 1.5,
            facets: 0.0.into(),
        };
        add(b, square(Vec3::NEG_Z * 2.0, Vec3::X, Vec3::Y), coat, 0.0);
        b.set_environment(Environment::constant(Rgb::gray(1.0))).unwrap();
    });
    let n = 1024;
    let sum = view(&t, n).pixel(&t, [8, 8]);
    // At nearly normal incidence the coat reflects 0.04. Each sample adds 0.04 / p with probability
    // p ≥ 0.1, so the standard error of the mean is below 0.04 √(9 / 1024). Stratified random
    // numbers make it far smaller.
    let mirrored = sum.background;
    assert!((mirrored.r - 0.04).abs() < 0.002, "{mirrored:?}");
    assert!((mirrored.g / mirrored.r - 0.5).abs() < 1e-5 && (mirrored.b / mirrored.r - 0.25).abs() < 1e-5);
    // The weights of the base's points sum to 1 on average. Its BSDF has no specular lobe.
    let weight: Rgb = sum.points.iter().map(|p| p.weight).sum();
    assert!((weight.r - 1.0).abs() < 0.02 && sum.points.len() < n as usize, "{weight:?}");
    let p = &sum.points[0];
    let (mirror, beside) = (Vec3::new(-p.wo.x, -p.wo.y, p.wo.z), Vec3::new(0.3, 0.0, 0.91f32.sqrt()));
    let ratio = p.bsdf.eval(p.wo, mirror).g / p.bsdf.eval(p.wo, beside).g;
    assert!((0.95..1.05).contains(&ratio), "no peak in the mirror direction: {ratio}");
}

#[test]
fn a_leaf_gathers_on_both_sides() {
    let t = tracer(|b| {
        let (reflectance, transmittance) = (Rgb::gray(0.3).into(), Rgb::gray(0.3).into());
        let leaf = Surface::Translucent { reflectance, transmittance };
        add(b, square(Vec3::NEG_Z * 2.0, Vec3::X, Vec3::Y), leaf, 0.0);
    });
    let sum = view(&t, 64).pixel(&t, [8, 8]);
    type Points<'a> = Vec<&'a GatherPoint>;
    let (near, far): (Points<'_>, Points<'_>) = sum.points.iter().partition(|p| p.geometric_normal.z > 0.0);
    assert!(near.iter().all(|p| p.position.z > -2.0 && p.frame.n.z > 0.0 && p.wo.z > 0.0));
    assert!(far.iter().all(|p| p.position.z < -2.0 && p.frame.n.z < 0.0 && p.wo.z > 0.0));
    let weight = |points: &[&GatherPoint]| points.iter().map(|p| p.weight.r).sum::<f32>();
    assert!((weight(&near) - 1.0).abs() < 0.05 && (weight(&far) - 1.0).abs() < 0.05, "one a side");
}

#[test]
fn pixels_have_samples_of_their_own() {
    let t = tracer(|b| add(b, square(Vec3::NEG_Z, Vec3::X, Vec3::Y), lambert(), 0.0));
    let v = View { size: [64, 64], ..view(&t, 1) };
    let mut keys = BTreeSet::new();
    for y in 0..64 {
        for x in 0..64 {
            let (_, key) = v.beginning([x, y], 0);
            assert!(keys.insert(key), "pixel {x}, {y} repeats another's random numbers");
        }
    }
    let (_, other) = View { seed: 4, ..v }.beginning([0, 0], 0);
    assert!(keys.insert(other), "and seeds too");
}

/// The camera moves from `x = 0` to `x = 1` while the shutter is open, so the `x` of a ray's origin
/// is the ray's time as a fraction of that interval.
#[test]
fn times_fill_the_shutters_evenly_and_leave_all_else_as_it_is() {
    let t = tracer(|b| add(b, square(Vec3::NEG_Z, Vec3::X, Vec3::Y), lambert(), 0.0));
    let still = view(&t, 64);
    let at = |x: f64| DAffine3::from_translation(DVec3::X * x);
    let moving =
        still.camera.clone().moving(Track::new([(2.0, at(0.0)), (3.0, at(1.0))]).unwrap(), [2.0, 3.0]);
    let moving = View { camera: &moving, ..still };
    let mut pixels = BTreeSet::new();
    for pixel in [[5, 9], [6, 9], [5, 10]] {
        let (mut parts, mut order, mut with_place) = (BTreeSet::new(), Vec::new(), 0.0);
        for index in 0..64 {
            let (ray, key) = moving.beginning(pixel, index);
            let (same, same_key) = still.beginning(pixel, index);
            let (ray, same) = (ray.ray().unwrap(), same.ray().unwrap());
            assert_eq!((ray.direction, key), (same.direction, same_key), "film and lens are as they were");
            parts.insert((ray.origin.x * 64.0) as u32);
            order.push((ray.origin.x * 64.0) as u32);
            let place =
                (ray.direction.x / -ray.direction.z) / (2.0 * crate::math::elementary::tan(0.2) / 16.0);
            with_place += (place + 8.0 - pixel[0] as f32 - 0.5) * (ray.origin.x - 0.5);
        }
        assert_eq!(parts.len(), 64, "one in each of 64 equal parts");
        assert!(pixels.insert(order), "pixels have times of their own");
        // Times are independent of positions on the film: their sample covariance has mean 0 and
        // standard deviation 1/12 / √64.
        assert!((with_place / 64.0).abs() < 0.04, "{with_place}");
    }
}

#[test]
fn points_fill_the_pixel_evenly() {
    let t = tracer(|b| add(b, square(Vec3::NEG_Z, Vec3::X, Vec3::Y), lambert(), 0.0));
    let v = view(&t, 64);
    let sum = v.pixel(&t, [5, 9]);
    // Width of a pixel on the plane z = −1. Below, `x` and `y` are measured in pixels from the top
    // left corner of the pixel.
    let width = 2.0 * crate::math::elementary::tan(0.2) / 16.0;
    let mut cells = BTreeSet::new();
    for p in &sum.points {
        let (x, y) = ((p.position.x / width + 8.0) - 5.0, (8.0 - p.position.y / width) - 9.0);
        assert!((-1e-3..1.001).contains(&x) && (-1e-3..1.001).contains(&y), "{x} {y}");
        cells.insert(((x * 8.0) as i32, (y * 8.0) as i32));
    }
    // 64 Sobol' points place one in each of the 8 × 8 cells.
    assert!(cells.len() >= 62, "{} cells", cells.len());
}

#[test]
fn a_pixel_that_sees_nothing_is_the_background() {
    let t = tracer(|b| b.set_environment(Environment::constant(Rgb::new(0.1, 0.2, 0.3))).unwrap());
    let sum = view(&t, 4).pixel(&t, [1, 1]);
    assert!(sum.points.is_empty() && sum.features.coverage == 0.0 && sum.features.depth == 0.0);
    assert!((sum.background - Rgb::new(0.1, 0.2, 0.3)).max_channel().abs() < 1e-6);
}

/// Outside the circle of a fisheye there are no gather points and no sky. A pixel that straddles
/// the circle shows the sky in proportion to its area inside.
#[test]
fn a_film_is_black_where_it_shows_nothing() {
    let t = tracer(|b| {
        add(b, square(Vec3::NEG_Z * 2.0, Vec3::X, Vec3::Y), lambert(), 0.0);
        b.set_environment(Environment::constant(Rgb::WHITE)).unwrap();
    });
    let angle = std::f32::consts::PI;
    let camera = Camera { projection: Projection::Fisheye { angle }, ..t.scene().cameras()[0].clone() };
    let view = View { camera: &camera, ..view(&t, 1024) };
    let outside = view.pixel(&t, [0, 0]);
    assert!(outside.points.is_empty() && outside.background.is_black() && outside.samples.len() == 1024);
    assert_eq!(view.pixel(&t, [8, 8]).points.len(), 1024);
    // The circle of radius 8 around (8, 8) crosses pixel (2, 2), on the diagonal. The wall does not
    // reach that far, so this pixel sees only sky.
    let inside = (0..10_000).filter(|k| {
        let (x, y) = (2.0 + ((k % 100) as f32 + 0.5) / 100.0, 2.0 + ((k / 100) as f32 + 0.5) / 100.0);
        (x - 8.0) * (x - 8.0) + (y - 8.0) * (y - 8.0) < 64.0
    });
    let share = inside.count() as f32 / 1e4;
    let seen = view.pixel(&t, [2, 2]).background.r;
    assert!(share > 0.2 && share < 0.8 && (seen - share).abs() < 0.02, "{seen} for {share}");
}

/// Random pixels are all of a window; of a window with sensors, those that have one.
#[test]
fn random_pixels_are_all_of_the_window() {
    let t = tracer(|b| add(b, square(Vec3::NEG_Z, Vec3::X, Vec3::Y), lambert(), 0.0));
    let view = view(&t, 1);
    let mut stream = Stream::new(1, Purpose::Test, 0);
    let mut met = |view: &View<'_>, window: Window| {
        let mut met: Vec<[u32; 2]> = (0..200).map(|_| view.random_pixel(&window, &mut stream)).collect();
        met.sort_unstable();
        met.dedup();
        met
    };
    let window = Window { x: 5, y: 9, width: 3, height: 2 };
    assert_eq!(met(&view, window), [[5, 9], [5, 10], [6, 9], [6, 10], [7, 9], [7, 10]]);
    let sensor = Some(Sensor::plane(Vec3::ZERO, Vec3::Y));
    let mut cells = vec![None; 2048];
    (cells[6], cells[7 + 2 * 16], cells[2047]) = (sensor, sensor, sensor);
    let camera = view.camera.with_sensors(SensorGrid::new(16, cells));
    let view = View { camera: &camera, size: [16, 128], ..view };
    assert_eq!(met(&view, Window::full([16, 16])), [[6, 0], [7, 2]]);
    // A sensor that random draws hardly meet is found.
    assert_eq!(met(&view, Window { x: 0, y: 3, width: 16, height: 125 }), [[15, 127]]);
}

/// The gather point of a sensor is white, in front of it, and the same for all samples; other
/// pixels have none.
#[test]
fn sensors_are_gather_points() {
    let t = tracer(|b| add(b, square(Vec3::NEG_Z, Vec3::X, Vec3::Y), lambert(), 0.0));
    let view = view(&t, 4);
    let sensor = Sensor::plane(Vec3::new(0.5, -1.0, 2.0), Vec3::Y);
    let camera = view.camera.with_sensors(SensorGrid::new(2, vec![None, Some(sensor)]));
    let view = View { camera: &camera, size: [2, 1], ..view };
    let sum = view.pixel(&t, [1, 0]);
    assert_eq!(sum.points.len(), 4);
    assert!(sum.background.is_black());
    for point in &sum.points {
        assert!((point.position - sensor.position).length() < 1e-5 && point.position.y > -1.0);
        assert_eq!(
            (point.geometric_normal, point.albedo(), point.weight),
            (Vec3::Y, Rgb::WHITE, Rgb::gray(0.25))
        );
    }
    let none = view.pixel(&t, [0, 0]);
    assert!(none.points.is_empty() && none.background.is_black());
    assert!(view.first_instance(&t, [1, 0], 0).is_none() && view.pyramid([1, 0]).is_none());
}
