//! Every plane of the schema from every method: filled with its value, which is known in closed form, or
//! absent. Of whole images, of parts and of parts that are merged; with groups of lights.

use std::path::Path;

use tashika::Renderer;
use tashika::accel::Tracer;
use tashika::color::Rgb;
use tashika::film::{Film, RenderFilm, SCHEMA, Stop, Window};
use tashika::math::Vec3;
use tashika::render::{Merger, TileShare};
use tashika::renderer::finish_merged;
use tashika::request::MethodName;
use tashika::scene::{Camera, Environment, LightGrouping, Material, Projection};

use crate::cases::{builder, lambert, parallelogram, place, tracer};

const SIZE: [u32; 2] = [12, 8];
/// Of the camera above the floor (m).
const HEIGHT: f32 = 5.0;
const ALBEDO: f32 = 0.5;
/// How far a mean may be off, as a share: of 2,048 samples at most, summed in single precision.
const ROUNDING: f32 = 2048.0 * f32::EPSILON / 2.0;

/// A floor under the left half of the film, seen from above by parallel rays, a metre to the pixel, under
/// a white sky.
fn scene() -> Tracer {
    let mut b = builder();
    let floor = parallelogram(Vec3::new(-60.0, -60.0, 0.0), Vec3::X * 60.0, Vec3::Y * 120.0);
    place(&mut b, floor, Material::new("floor", lambert(ALBEDO)));
    b.set_environment(Environment::constant(Rgb::WHITE)).unwrap();
    let camera = Camera::look_at("above", Vec3::Z * HEIGHT, Vec3::ZERO, Vec3::Y, 1.0);
    let projection = Projection::Orthographic { height: SIZE[1] as f32 };
    b.add_camera(Camera { projection, ..camera }).unwrap();
    tracer(b)
}

/// A renderer for each method, and for the ways in which ours and paths make promises.
fn renderers(tracer: &Tracer) -> Vec<(String, Renderer<'static>)> {
    let plain = || Renderer::on(tracer).size(SIZE).vpls(300).mattes(2).motion_vectors();
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
    all
}

/// Holds a film to the schema.
fn check(film: &Film, asked: &str) {
    for row in SCHEMA {
        let Some(plane) = film.plane(row.spec) else {
            let may_lack = [
                "TIME",
                "TRANSMITTANCE",
                "RECONSTRUCTION",
                "AUDITED",
                "HALVES",
                "TRUTH",
                "REFERENCE",
                "REFERENCE_HALF_WIDTH",
            ];
            assert!(may_lack.contains(&row.key), "{asked}: no plane {}", row.key);
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
                "DEPTH" => is(&[sees(HEIGHT)], ROUNDING * HEIGHT),
                "NORMAL" => is(&[0.0, 0.0, sees(1.0)], ROUNDING),
                "COVERAGE" => is(&[sees(1.0)], ROUNDING),
                "ALBEDO" => is(&[sees(ALBEDO); 3], ROUNDING * ALBEDO),
                "PAIRS" | "RAYS" => assert!(found[0] > 0.0 || !is_floor, "{at}"),
                "RADIANCE" => assert!(found.iter().all(|c| c.is_finite() && *c > 0.0), "{at}: {found:?}"),
                // Zero means exact: what is not known is no number.
                "STANDARD_ERROR" => assert!(found[0].is_nan() || found[0] >= 0.0, "{at}: {found:?}"),
                "MOTION" => is(&[0.0; 2], 0.0),
                _ => assert!(found.iter().all(|value| value.is_nan() || *value >= 0.0), "{at}: {found:?}"),
            }
        }
    }
}

#[test]
fn each_plane_is_filled_by_each_method_or_absent() {
    for (asked, renderer) in renderers(&scene()) {
        check(&renderer.render().unwrap().film, &asked);
        let parts =
            [1, 2].map(|number| renderer.clone().tiles(TileShare::new(number, 2).unwrap()).render().unwrap());
        let mut merger = Merger::new(Path::new("first"), &parts[0].film).unwrap();
        merger.add(Path::new("second"), &parts[1].film).unwrap();
        parts.iter().for_each(|part| check(&part.film, &format!("{asked}, a part")));
        let mut merged = merger.finish().unwrap();
        finish_merged(&mut merged, None).unwrap();
        check(&merged.film, &format!("{asked}, merged"));
        let rendered = RenderFilm::of(&merged.film).tally().rendered();
        assert_eq!(rendered, Window::full(SIZE).area(), "{asked}");
    }
}
