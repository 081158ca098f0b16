//! Sensors against closed forms (CIE 171:2006, section 5, by its formulas), by all claims and by
//! path tracing, seed against seed.

use std::f64::consts::PI;
use std::sync::Arc;

use tashika::accel::Tracer;
use tashika::color::Rgb;
use tashika::io::{LightChanges, LoadOptions};
use tashika::math::{DVec3, Mat3, Vec3};
use tashika::render::with_threads;
use tashika::renderer::Renderer;
use tashika::request::{ClaimName, MethodName};
use tashika::scene::{
    Camera, Emitter, Environment, Image, Material, MeshData, Pixels, SceneBuilder, SensorPoint, SensorShape,
    builtin,
};
use tashika::sensors::{GridSummary, Photometry, Reading, SensorSet, horizontal_irradiance};

use crate::cases::{builder, cuboid, glowing, lambert, parallelogram, place, tracer};

/// Readings of sensors by a renderer with the given options.
fn readings<'r>(
    tracer: &'r Tracer,
    points: &[SensorPoint],
    with: impl FnOnce(Renderer<'r>) -> Renderer<'r>,
) -> Vec<Reading> {
    let set = SensorSet::new(tracer.scene(), points.to_vec()).unwrap();
    let rendered = with(Renderer::on(tracer).error(0.02).sensors(&set)).render().unwrap();
    assert!(rendered.complete);
    set.readings(&rendered.film, Photometry::Scene)
}

/// Asserts that each interval covers the truth, and is as narrow as 2 % of it.
fn assert_covered(found: &[Reading], truths: &[f64], what: &str) {
    assert_within(0.02, found, truths, what);
}

/// Asserts that each interval covers the truth, and is as narrow as the relative error.
fn assert_within(error: f64, found: &[Reading], truths: &[f64], what: &str) {
    for (k, (reading, truth)) in found.iter().zip(truths).enumerate() {
        let [low, high] = reading.interval().unwrap_or_else(|| panic!("{what}: sensor {k} claims nothing"));
        let slack = 1e-5 * truth;
        assert!(low - slack <= *truth && *truth <= high + slack, "{what}, {k}: {reading:?} for {truth}");
        assert!(high - low <= 2.1 * error * truth + 1e-9, "{what}, {k}: {reading:?} is wide");
    }
}

fn up(x: f64, y: f64, z: f64) -> SensorPoint {
    SensorPoint::plane(DVec3::new(x, y, z), DVec3::Y)
}

fn quad(corner: [f32; 3], a: [f32; 3], b: [f32; 3]) -> MeshData {
    parallelogram(corner.into(), a.into(), b.into())
}

fn black() -> Material {
    Material::new("black", lambert(0.0))
}

/// A scene with a black floor far below, so that it has a surface, and a camera.
fn bare(light: impl FnOnce(&mut SceneBuilder)) -> Tracer {
    let mut b = builder();
    place(&mut b, quad([-9.0, -9.0, -9.0], [0.0, 0.0, 18.0], [18.0, 0.0, 0.0]), black());
    light(&mut b);
    b.add_camera(Camera::look_at("c", Vec3::new(0.0, 0.0, 9.0), Vec3::ZERO, Vec3::Y, 0.6)).unwrap();
    tracer(b)
}

/// Irradiance at the origin, with the normal `n`, of a polygon of radiance 1 that is wholly in
/// front (Lambert 1760): `½ Σ γ_k n·g_k`, with the angle `γ_k` that edge `k` subtends, and the unit
/// normal `g_k` of the plane through edge and origin.
fn of_polygon(corners: &[DVec3], normal: DVec3) -> f64 {
    let edge = |k: usize| {
        let [a, b] = [corners[k].normalize(), corners[(k + 1) % corners.len()].normalize()];
        let cross = a.cross(b);
        let angle = f64::atan2(cross.length(), a.dot(b));
        0.5 * angle * normal.dot(cross.normalize())
    };
    (0..corners.len()).map(edge).sum::<f64>().abs()
}

/// CIE 171, 5.2: a point source of 1000 cd, 3 m above a plane.
#[test]
fn point_sources_follow_the_inverse_square_law() {
    let position = Vec3::new(0.0, 3.0, 0.0);
    let tracer = bare(|b| b.add_emitter(Emitter::Point { position, intensity: Rgb::gray(1000.0) }).unwrap());
    let places: Vec<f64> = (0..6).map(|k| 0.8 * f64::from(k)).collect();
    let points: Vec<SensorPoint> = places.iter().map(|x| up(*x, 0.0, 0.0)).collect();
    let truths: Vec<f64> = places.iter().map(|x| 1000.0 * 3.0 / (9.0 + x * x).powf(1.5)).collect();
    for claim in [ClaimName::Calibrated, ClaimName::Certified] {
        assert_covered(&readings(&tracer, &points, |r| r.claim(claim)), &truths, "point source");
    }
    let by_paths = readings(&tracer, &points, |r| r.method(MethodName::Path).claim(ClaimName::Calibrated));
    assert_covered(&by_paths, &truths, "point source by paths");
}

/// CIE 171, 5.3: a diffuse square source of 2 m, facing down, 2.5 m above a plane; the sensors lie
/// on the plane, on a wall, and one is turned away.
#[test]
fn area_sources_are_those_of_lamberts_formula() {
    let corners = [[-1.0, 2.5, -1.0], [1.0, 2.5, -1.0], [1.0, 2.5, 1.0], [-1.0, 2.5, 1.0]];
    let tracer = bare(|b| {
        let source = quad([-1.0, 2.5, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
        place(b, source, glowing("source", lambert(0.0), 40.0));
    });
    let wall = SensorPoint::plane(DVec3::new(2.5, 1.0, 0.3), DVec3::NEG_X);
    let points = [up(0.0, 0.0, 0.0), up(1.0, 0.0, 0.5), up(3.0, 0.0, -2.0), wall];
    let truth = |p: &SensorPoint| {
        40.0 * of_polygon(&corners.map(|corner| DVec3::from(corner) - p.position), p.normal)
    };
    let truths = points.each_ref().map(truth);
    for claim in [ClaimName::Calibrated, ClaimName::Certified] {
        // A certificate is about the sum over one set of VPLs, whose own error the set's size
        // limits.
        let found = readings(&tracer, &points, |r| {
            if claim == ClaimName::Certified {
                r.claim(claim).error(0.01).vpls(400_000)
            } else {
                r.claim(claim)
            }
        });
        assert_covered(&found, &truths, "area source");
    }
    // At a confidence of 95 %, one of the four intervals misses the truth in a fifth of all seeds.
    let by_paths = readings(&tracer, &points, |r| {
        r.method(MethodName::Path).claim(ClaimName::Calibrated).confidence(0.999)
    });
    assert_covered(&by_paths, &truths, "area source by paths");
    let away = [SensorPoint::plane(DVec3::ZERO, DVec3::NEG_Y)];
    assert_eq!(readings(&tracer, &away, |r| r)[0].illuminance, 0.0);
}

/// CIE 171, 5.10: sky of radiance 1 through an opening of 1 m × 1 m in the black roof of a closed
/// room.
#[test]
fn skies_through_an_opening_are_those_of_lamberts_formula() {
    let mut b = builder();
    // A roof of four rectangles about the opening, and walls that are wider than the room.
    for (corner, size) in [
        ([-4.0, 3.0, -4.0], [3.5, 8.0]),
        ([0.5, 3.0, -4.0], [3.5, 8.0]),
        ([-0.5, 3.0, -4.0], [1.0, 3.5]),
        ([-0.5, 3.0, 0.5], [1.0, 3.5]),
    ] {
        place(&mut b, quad(corner, [size[0], 0.0, 0.0], [0.0, 0.0, size[1]]), black());
    }
    for (corner, along) in [
        ([-4.0, -1.0, -4.0], [8.0, 0.0, 0.0]),
        ([4.0, -1.0, -4.0], [0.0, 0.0, 8.0]),
        ([4.0, -1.0, 4.0], [-8.0, 0.0, 0.0]),
        ([-4.0, -1.0, 4.0], [0.0, 0.0, -8.0]),
    ] {
        place(&mut b, quad(corner, along, [0.0, 4.0, 0.0]), black());
    }
    place(&mut b, quad([-4.0, -1.0, -4.0], [8.0, 0.0, 0.0], [0.0, 0.0, 8.0]), black());
    b.set_environment(Environment::lat_long(even(2, |_| 1.0), Rgb::WHITE, Mat3::IDENTITY)).unwrap();
    b.add_camera(Camera::look_at("c", Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, Vec3::Y, 0.6)).unwrap();
    let tracer = tracer(b);
    let corners = [[-0.5, 3.0, -0.5], [0.5, 3.0, -0.5], [0.5, 3.0, 0.5], [-0.5, 3.0, 0.5]];
    let points = [up(0.0, 0.0, 0.0), up(1.5, 0.0, 0.0), up(2.0, 0.8, -1.0)];
    let truth =
        |p: &SensorPoint| of_polygon(&corners.map(|corner| DVec3::from(corner) - p.position), p.normal);
    let found = readings(&tracer, &points, |r| r.error(0.05));
    assert_within(0.05, &found, &points.each_ref().map(truth), "opening");
}

/// An image of a sky whose rows have the radiance of a function of the row.
fn even(rows: u32, radiance: impl Fn(u32) -> f32) -> Image {
    let texels = (0..rows).flat_map(|row| [[radiance(row); 3]; 4]).collect();
    Image { name: "sky".into(), width: 4, height: rows, pixels: Pixels::Float(texels) }
}

/// CIE 171, 5.9: unobstructed sensors under skies of ISO 15469. Of the horizontal illuminance `E`,
/// an upright plane has `(3π + 8)/(14π)` under the overcast sky, and half under the uniform sky.
/// The clear sky is brighter on the side of the sun.
#[test]
fn skies_of_the_trade_give_their_illuminance() {
    let under = |sky: &str| {
        let changes = LightChanges { environment: Some(sky.parse().unwrap()), lights: Vec::new() };
        let mut b = builder();
        place(&mut b, quad([-9.0, -9.0, -9.0], [0.0, 0.0, 18.0], [18.0, 0.0, 0.0]), black());
        b.add_camera(Camera::look_at("c", Vec3::new(0.0, 0.0, 9.0), Vec3::ZERO, Vec3::Y, 0.6)).unwrap();
        let scene = changes.apply(b.build().unwrap(), &LoadOptions::default()).unwrap();
        Tracer::new(Arc::new(scene))
    };
    let points = [DVec3::Y, DVec3::X, DVec3::NEG_X].map(|n| SensorPoint::plane(DVec3::new(0.0, 1.0, 0.0), n));
    for (sky, upright) in [("cie:overcast", (3.0 * PI + 8.0) / (14.0 * PI)), ("cie:uniform", 0.5)] {
        let tracer = under(sky);
        let outdoors = horizontal_irradiance(tracer.scene().environment().unwrap(), DVec3::Y)[1];
        assert!((outdoors / 10_000.0 - 1.0).abs() < 2e-3, "{sky}: {outdoors} lx");
        let found = readings(&tracer, &points, |r| r);
        for (reading, part) in found.iter().zip([1.0, upright, upright]) {
            // An image of 256 rows is interpolated across the horizon.
            let off = (reading.illuminance - part * 10_000.0).abs();
            assert!(off <= reading.half_width.unwrap() + 40.0, "{sky}: {reading:?} for {part}");
        }
    }
    let found = readings(&under("cie:clear,elevation=30,azimuth=90"), &points, |r| r);
    assert!(found[1].illuminance > 2.0 * found[2].illuminance, "the sun is in the east: {found:?}");
    assert!((found[0].illuminance - 10_000.0).abs() < 250.0);
}

/// An upper half of the sphere of radiance 1: `π` on a plane that looks up, half of it on upright
/// planes, cylinders and spheres. The formulas are those of the fluence over shapes.
#[test]
fn shapes_measure_their_part_of_half_a_sky() {
    const ROWS: u32 = 512;
    let half = even(ROWS, |row| if row < ROWS / 2 { 1.0 } else { 0.0 });
    let tracer =
        bare(|b| b.set_environment(Environment::lat_long(half, Rgb::WHITE, Mat3::IDENTITY)).unwrap());
    let of = |shape, normal| SensorPoint { shape, ..SensorPoint::plane(DVec3::new(0.0, 1.0, 0.0), normal) };
    let points = [
        of(SensorShape::Plane, DVec3::Y),
        of(SensorShape::Plane, DVec3::X),
        of(SensorShape::Cylinder, DVec3::Y),
        of(SensorShape::Sphere, DVec3::Y),
    ];
    let truths = [PI, PI / 2.0, PI / 2.0, PI / 2.0];
    for method in [MethodName::default(), MethodName::Path] {
        let found = readings(&tracer, &points, |r| r.method(method).claim(ClaimName::Calibrated));
        // The last row above the horizon is interpolated with the first below it.
        for (k, (reading, truth)) in found.iter().zip(truths).enumerate() {
            let off = (reading.illuminance - truth).abs();
            assert!(off <= reading.half_width.unwrap() + 0.01 * truth, "{k}: {reading:?} for {truth}");
        }
    }
    assert!(readings(&tracer, &[of(SensorShape::Plane, DVec3::NEG_Y)], |r| r)[0].illuminance < 0.01);
}

/// In a closed room whose walls emit `L_e` and reflect `ρ`, every sensor of every shape measures
/// `π L_e / (1 − ρ)`.
#[test]
fn sensors_in_a_furnace_measure_its_radiance() {
    let mut b = builder();
    place(&mut b, cuboid(Vec3::NEG_ONE, Vec3::ONE, true), glowing("wall", lambert(0.5), 1.0));
    b.add_camera(Camera::look_at("c", Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 0.6)).unwrap();
    let tracer = tracer(b);
    let at = DVec3::new(0.3, -0.2, 0.1);
    let shapes = [SensorShape::Plane, SensorShape::Cylinder, SensorShape::Sphere];
    let points =
        shapes.map(|shape| SensorPoint { shape, ..SensorPoint::plane(at, DVec3::new(1.0, 2.0, 0.5)) });
    let truths = [2.0 * PI; 3];
    assert_covered(&readings(&tracer, &points, |r| r.error(0.02)), &truths, "furnace");
    let by_paths = readings(&tracer, &points, |r| r.method(MethodName::Path).claim(ClaimName::Calibrated));
    assert_covered(&by_paths, &truths, "furnace by paths");
}

/// Sensors in the built-in scene: intervals of two seeds, and of paths, overlap; threads and shares
/// do not change a bit, and neither does the order of the sensors.
#[test]
fn seeds_agree_and_bits_do_not_depend_on_threads_or_order() {
    let tracer = Tracer::new(Arc::new(builtin::tiny()));
    let bounds = tracer.scene().bounds();
    let at = |k: u32| {
        let share = (k as f32 + 0.5) / 12.0;
        let place = bounds.lo + bounds.size() * Vec3::new(share, 0.4, 0.9 - 0.7 * share);
        SensorPoint::plane(place.as_dvec3(), DVec3::Y)
    };
    let points: Vec<SensorPoint> = (0..12).map(at).collect();
    let by = |seed: u64| readings(&tracer, &points, |r| r.error(0.05).vpls(100_000).seed(seed));
    let [one, two] = [1, 2].map(by);
    let paths = readings(&tracer, &points, |r| {
        r.method(MethodName::Path).claim(ClaimName::Calibrated).error(0.03).seed(3)
    });
    let mut disjoint = 0;
    for other in [&two, &paths] {
        for (a, b) in one.iter().zip(other) {
            let [a, b] = [a, b].map(|reading| reading.interval().unwrap());
            disjoint += usize::from(a[0] > b[1] || b[0] > a[1]);
        }
    }
    // 24 pairs of intervals of 95 %: two independent ones are disjoint in 0.6 % of cases.
    assert!(disjoint <= 1, "{disjoint} disjoint: {one:?} {two:?} {paths:?}");
    assert_eq!(with_threads(1, || by(1)).unwrap(), one);
    let mut turned: Vec<SensorPoint> = points.clone();
    turned.reverse();
    let mut found = readings(&tracer, &turned, |r| r.error(0.05).vpls(100_000).seed(1));
    found.reverse();
    assert_eq!(found, one);
    let summary = GridSummary::of(&one, 0.95, false).unwrap();
    let [low, high] = summary.uniformity.interval.unwrap();
    assert!(low <= summary.uniformity.value && summary.uniformity.value <= high && low > 0.0);
}
