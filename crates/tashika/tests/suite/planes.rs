//! Tests of every plane of the schema for every method: a plane has its closed-form value, or is
//! absent. The scenes are in clear air, in fog and in motion. The films are whole images, parts and
//! merged parts; some have groups of lights.

use std::path::Path;

use glam::{DAffine3, DVec3};
use tashika::Renderer;
use tashika::accel::Tracer;
use tashika::color::Rgb;
use tashika::film::{Film, RenderFilm, SCHEMA, Stop, Window};
use tashika::math::Vec3;
use tashika::math::elementary::exp_f64;
use tashika::math::motion::Track;
use tashika::render::{Merger, TileShare};
use tashika::renderer::finish_merged;
use tashika::request::{ClaimName, MethodName};
use tashika::scene::{
    Camera, Environment, LightGrouping, Material, MeshData, Projection, SceneBuilder, Surface,
};

use crate::cases::{builder, cuboid, lambert, parallelogram, place, tracer};
use crate::media::{add, bounding};

const SIZE: [u32; 2] = [12, 8];
/// Height of the camera above the floor (m).
const HEIGHT: f32 = 5.0;
const ALBEDO: f32 = 0.5;
/// Relative tolerance of a mean of at most 2,048 samples, summed in single precision.
const ROUNDING: f32 = 2048.0 * f32::EPSILON / 2.0;

/// Absorption and scattering of the fog (m⁻¹), and its thickness (m).
const FOG: [f32; 3] = [0.3, 0.1, 1.5];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Air {
    Clear,
    Fog,
    /// The floor moves up by one metre, which is one pixel on the film.
    Motion,
}

/// Returns a floor under the left half of the film and a white sky. The camera looks down with
/// parallel rays, one metre per pixel.
fn scene(air: Air) -> Tracer {
    let mut b = builder();
    let floor = parallelogram(Vec3::new(-60.0, -60.0, 0.0), Vec3::X * 60.0, Vec3::Y * 120.0);
    let material = Material::new("floor", lambert(ALBEDO));
    if air == Air::Motion {
        place_moving(&mut b, floor, material);
    } else {
        place(&mut b, floor, material);
    }
    if air == Air::Fog {
        let [absorbs, scatters, thickness] = FOG;
        let fog = Some(add(&mut b, [absorbs; 3], [scatters; 3], 0.0));
        let slab = cuboid(Vec3::new(-90.0, -90.0, 1.0), Vec3::new(90.0, 90.0, 1.0 + thickness), false);
        bounding(&mut b, slab, Surface::Boundary, [fog, None]);
    }
    b.set_environment(Environment::constant(Rgb::WHITE)).unwrap();
    let camera = Camera::look_at("above", Vec3::Z * HEIGHT, Vec3::ZERO, Vec3::Y, 1.0);
    let projection = Projection::Orthographic { height: SIZE[1] as f32 };
    b.add_camera(Camera { projection, ..camera }).unwrap();
    tracer(b)
}

fn place_moving(b: &mut SceneBuilder, mesh: MeshData, material: Material) {
    let material = b.add_material(material).unwrap();
    let mesh = b.add_mesh(mesh, material).unwrap();
    let end = |y: f64| DAffine3::from_translation(y * DVec3::Y);
    let track = Track::new([(0.0, end(0.0)), (1.0, end(1.0))]).unwrap();
    b.add_moving_instance(mesh, track, [0.0, 1.0]).unwrap().unwrap();
}

/// Returns a renderer for each method, and for each kind of claim of the default method and of path
/// tracing.
fn renderers(tracer: &Tracer) -> Vec<(String, Renderer<'static>)> {
    let plain = || Renderer::on(tracer).size(SIZE).vpls(300).gather_points(16).mattes(2).motion_vectors();
    let mut all: Vec<(String, Renderer<'static>)> = MethodName::all()
        .map(|method| {
            let renderer = plain().method(method);
            let renderer = if method == MethodName::Path { renderer.paths(32) } else { renderer };
            (method.name().to_owned(), renderer)
        })
        .collect();
    let paths = || plain().method(MethodName::Path);
    all.push(("one path".into(), paths().paths(1)));
    all.push(("paths with an error".into(), paths().error(0.3)));
    all.push(("paths in groups".into(), paths().paths(8).light_groups(LightGrouping::Each)));
    all.push(("transport".into(), plain().error(0.3)));
    all.push(("audited".into(), plain().error(0.3).claim(ClaimName::Audited)));
    all
}

/// Checks a film against the schema.
fn check(film: &Film, air: Air, asked: &str) {
    let in_fog = air == Air::Fog;
    for row in SCHEMA {
        let Some(plane) = film.plane(row.spec) else {
            let may_lack = match row.key {
                "TIME" => air != Air::Motion,
                "TRANSMITTANCE" => !in_fog,
                "AUDITED" | "HALVES" | "TRUTH" | "REFERENCE" | "REFERENCE_HALF_WIDTH" => true,
                _ => false,
            };
            assert!(may_lack, "{asked}: no plane {}", row.key);
            continue;
        };
        for (x, y) in film.window().pixels() {
            if RenderFilm::of(film).at(x, y).stop == Stop::NotRendered {
                continue;
            }
            let is_floor = x < SIZE[0] / 2;
            let sees = |value: f32| if is_floor { value } else { 0.0 };
            let at = format!("{asked}, plane {} at {x},{y}", row.key);
            if plane.u32_samples().is_some() {
                let numbers = plane.u32_at(x, y);
                match row.key {
                    "OBJECT_ID" | "MATERIAL_ID" => assert_eq!(numbers[0] != 0, is_floor, "{at}"),
                    _ => assert!(numbers[0] <= 5, "{at}"),
                }
                continue;
            }
            let found = plane.f32_at(x, y);
            let is = |expected: &[f32], most: f32| {
                let far = found.iter().zip(expected).map(|(f, e)| (f - e).abs()).fold(0.0, f32::max);
                assert!(far <= most && found.len() == expected.len(), "{at}: {found:?} for {expected:?}");
            };
            match row.key {
                // Camera paths that scatter in fog have no first surface.
                "DEPTH" if !in_fog || found[0] > 0.0 => is(&[sees(HEIGHT)], ROUNDING * HEIGHT),
                "NORMAL" if !in_fog || found[2] > 0.0 => is(&[0.0, 0.0, sees(1.0)], ROUNDING),
                "COVERAGE" if !in_fog => is(&[sees(1.0)], ROUNDING),
                "ALBEDO" if !in_fog => is(&[sees(ALBEDO); 3], ROUNDING * ALBEDO),
                "PAIRS" | "RAYS" => assert!(found[0] > 0.0 || !is_floor, "{at}"),
                // The fog may absorb all paths of a pixel.
                "RADIANCE" => {
                    let is_lit = |c: &f32| c.is_finite() && (*c > 0.0 || in_fog && *c == 0.0);
                    assert!(found.iter().all(is_lit), "{at}: {found:?}");
                }
                // Zero means that the value is exact; an unknown error is NaN.
                "STANDARD_ERROR" => assert!(found[0].is_nan() || found[0] >= 0.0, "{at}: {found:?}"),
                "MOTION" => is(&[0.0, if is_floor && air == Air::Motion { 1.0 } else { 0.0 }], 1e-4),
                // Mean time of at least 16 samples, within four of its standard deviations.
                "TIME" => is(&[sees(0.5)], 4.0 / (12.0 * 16.0_f32).sqrt()),
                "TRANSMITTANCE" => {
                    let [absorbs, scatters, thickness] = FOG;
                    let left = exp_f64(-f64::from((absorbs + scatters) * thickness)) as f32;
                    is(&[left; 3], ROUNDING);
                }
                _ => assert!(found.iter().all(|value| value.is_nan() || *value >= 0.0), "{at}: {found:?}"),
            }
        }
    }
}

/// Merges the two parts of an image.
fn merged(parts: &[Film; 2]) -> Film {
    let mut merger = Merger::new(Path::new("first"), &parts[0]).unwrap();
    merger.add(Path::new("second"), &parts[1]).unwrap();
    let mut merged = merger.finish().unwrap();
    finish_merged(&mut merged, None).unwrap();
    merged.film
}

fn hold_all_methods(air: Air) {
    for (asked, renderer) in renderers(&scene(air)) {
        check(&renderer.render().unwrap().film, air, &asked);
        let parts = [1, 2]
            .map(|number| renderer.clone().tiles(TileShare::new(number, 2).unwrap()).render().unwrap().film);
        parts.iter().for_each(|part| check(part, air, &format!("{asked}, a part")));
        let merged = merged(&parts);
        check(&merged, air, &format!("{asked}, merged"));
        let rendered = RenderFilm::of(&merged).tally().rendered();
        assert_eq!(rendered, Window::full(SIZE).area(), "{asked}");
    }
}

#[test]
fn each_plane_is_filled_by_each_method_or_absent() {
    hold_all_methods(Air::Clear);
}

#[test]
fn each_plane_is_filled_in_fog_or_absent() {
    hold_all_methods(Air::Fog);
}

#[test]
fn each_plane_is_filled_in_motion_or_absent() {
    hold_all_methods(Air::Motion);
}
