//! Mattes of objects and materials: an edge in closed form, films with and without mattes, and the
//! names of objects in files.

use serde_json::json;
use tashika::Renderer;
use tashika::bsdf::HenyeyGreenstein;
use tashika::color::Rgb;
use tashika::film::{Film, MatteOf, Window, matte_id, planes};
use tashika::gather::{Filter, GatherOptions, View};
use tashika::integrator::{FullSum, Setting};
use tashika::io::load_scene;
use tashika::math::Vec3;
use tashika::render::{TileShare, add_mattes, with_threads};
use tashika::request::Request;
use tashika::scene::{
    Camera, Emitter, InstanceId, Interface, Material, Medium, MeshData, Projection, Scene, Surface, builtin,
};
use tashika::vpl::{VplOptions, VplSet};

use crate::cases::{builder, cuboid, film_of, lambert, lenient, parallelogram, place, tracer, view};
use crate::gltf::Document;
use crate::mitsuba;
use crate::pbrt;

/// Numbers and coverages in a pixel, of all ranks in use.
fn ranks(film: &Film, of: MatteOf, x: u32, y: u32) -> Vec<(u32, f32)> {
    let layers = (0..).map_while(|k| film.plane(format!("{}{k:02}", of.layer())));
    let samples: Vec<f32> = layers.flat_map(|plane| plane.f32_at(x, y)).copied().collect();
    let pairs = samples.chunks_exact(2).map(|pair| (pair[0].to_bits(), pair[1]));
    pairs.filter(|(_, share)| *share > 0.0).collect()
}

fn named(name: &str, mesh: MeshData) -> MeshData {
    MeshData { name: name.to_owned(), ..mesh }
}

const SIDE: u32 = 6;

/// Two adjacent squares whose border is a step at `x = 0.3`, both in the upper half of the image.
/// The camera looks straight down with pixels of 1 m. A box of fog in front is not an object.
fn steps() -> tashika::accel::Tracer {
    let mut b = builder();
    for (name, from, to) in [("left", -9.0, 0.3), ("right", 0.3, 9.0)] {
        let corner = Vec3::new(from, 0.0, 0.0);
        let mesh = parallelogram(corner, Vec3::X * (to - from), Vec3::Y * 9.0);
        place(&mut b, named(name, mesh), Material::new(format!("paint of {name}"), lambert(0.5)));
    }
    let fog = Medium {
        name: "fog".to_owned(),
        absorption: Rgb::BLACK,
        scattering: Rgb::gray(0.01),
        phase: HenyeyGreenstein::default(),
        variation: None,
    };
    let fog = b.add_medium(fog).unwrap();
    let boundary = b.add_material(Material::new("null", Surface::Boundary)).unwrap();
    let (lo, hi) = (Vec3::new(-9.0, -9.0, 1.0), Vec3::new(9.0, 9.0, 2.0));
    let mesh = b.add_mesh(named("fog", cuboid(lo, hi, false)), boundary).unwrap();
    b.set_interface(mesh, Interface { inside: Some(fog), outside: None }).unwrap();
    b.add_instance(mesh, glam::Affine3A::IDENTITY).unwrap();
    let (direction, irradiance) = (Vec3::NEG_Z, Rgb::gray(5.0));
    b.add_emitter(Emitter::Directional { direction, irradiance }).unwrap();
    let mut camera = Camera::look_at("above", Vec3::Z * 5.0, Vec3::ZERO, Vec3::Y, 1.0);
    camera.projection = Projection::Orthographic { height: SIDE as f32 };
    b.add_camera(camera).unwrap();
    tracer(b)
}

/// The pixel at the border has both squares, with the integral of the pixel filter on either side
/// as coverage.
#[test]
fn an_edge_between_objects_has_both_by_the_pixel_filter() {
    const SAMPLES: u32 = 1024;
    let t = steps();
    let size = [SIDE; 2];
    let tent = |x: f32| 1.0 - 0.5 * (1.0 - x) * (1.0 - x);
    for (filter, left_of_step) in [(Filter::Box, 0.3), (Filter::Tent, 1.0 - tent(0.2))] {
        let gather = GatherOptions { points: 4, filter };
        let view = View { gather, ..view(t.scene(), size, 4, 1) };
        let mut film = Film::new(size, Window::full(size), &[planes::RADIANCE]).unwrap();
        add_mattes(&Setting { tracer: &t, view }, &mut film, SAMPLES, 6);
        for (of, [left, right]) in
            [(MatteOf::Objects, ["left", "right"]), (MatteOf::Materials, ["paint of left", "paint of right"])]
        {
            let [left, right] = [left, right].map(matte_id);
            // Sobol' points fill the pixel so evenly that a coverage is off by one or two samples.
            let close = |share: f32, expected: f32| (share - expected).abs() < 4.0 / SAMPLES as f32;
            let found = ranks(&film, of, 3, 1);
            assert_eq!((found[0].0, found[1].0, found.len()), (right, left, 2), "{of:?} {filter}");
            assert!(close(found[1].1, left_of_step), "{of:?} {filter}: {found:?}");
            assert_eq!(found[0].1 + found[1].1, 1.0);
            assert_eq!(ranks(&film, of, 0, 1), [(left, 1.0)]);
            assert_eq!(ranks(&film, of, 1, 5), [], "below the squares there is nothing but fog");
        }
        assert_eq!(film.plane(planes::OBJECT_ID).unwrap().u32_at(3, 1), [matte_id("right")]);
        assert_eq!(film.plane(planes::OBJECT_ID).unwrap().u32_at(1, 5), [0]);
    }
}

/// Mattes use the samples of the gather points. Coverages add up to the coverage of the pixel, and
/// the first ranks belong to the surfaces that the depth shows.
#[test]
fn samples_are_those_of_the_features() {
    let t = tracer(mirror_and_ball());
    let lights = VplSet::trace(&t, &VplOptions { count: 20, ..VplOptions::default() }).unwrap();
    let view = view(t.scene(), [24, 18], 5, 3);
    let mut film = film_of(&t, &FullSum::new(&lights), view);
    add_mattes(&Setting { tracer: &t, view }, &mut film, 5, 6);
    let (mut seen, mut edges) = (0, 0);
    for (x, y) in film.window().pixels() {
        let coverage = film.plane(planes::COVERAGE).unwrap().f32_at(x, y)[0];
        let found = ranks(&film, MatteOf::Objects, x, y);
        let samples: f32 = found.iter().map(|(_, share)| (share * 5.0).round()).sum();
        assert_eq!(samples / 5.0, coverage, "{x},{y}: {found:?}");
        assert!(found.is_sorted_by(|a, b| a.1 >= b.1));
        seen += u32::from(coverage > 0.0);
        edges += u32::from(found.len() > 1 || coverage > 0.0 && coverage < 1.0);
        // A mirror counts as itself, not as its reflection.
        assert!(found.iter().all(|(number, _)| [matte_id("mirror"), matte_id("ball")].contains(number)));
    }
    assert!(seen > 100 && edges > 10, "{seen} {edges}");
}

/// A mirror in front of nothing, and a box beside it.
fn mirror_and_ball() -> tashika::scene::SceneBuilder {
    let mut b = builder();
    let mirror = Surface::Mirror { reflectance: Rgb::gray(0.9).into() };
    let (corner, a, c) = (Vec3::new(-3.0, -2.0, -1.0), Vec3::X * 3.0, Vec3::Y * 4.0);
    place(&mut b, named("mirror", parallelogram(corner, a, c)), Material::new("silver", mirror));
    let ball = cuboid(Vec3::new(0.5, -1.0, -1.0), Vec3::new(2.0, 1.0, 0.5), false);
    place(&mut b, named("ball", ball), Material::new("clay", lambert(0.5)));
    b.add_emitter(Emitter::Point { position: Vec3::Z * 4.0, intensity: Rgb::gray(10.0) }).unwrap();
    b.add_camera(Camera::look_at("c", Vec3::new(0.3, 0.2, 6.0), Vec3::ZERO, Vec3::Y, 0.9)).unwrap();
    b
}

fn without_mattes(film: &Film) -> Vec<&tashika::film::Plane> {
    let is_of_mattes = |name: &str| name.starts_with("Crypto") || name.ends_with("_id");
    film.planes().iter().filter(|plane| !is_of_mattes(plane.name())).collect()
}

/// For every method, the other planes equal those of a render without mattes bit by bit. Mattes do
/// not depend on the number of threads or on the division into parts.
#[test]
fn mattes_change_nothing_else_and_are_the_same_for_threads_and_shares() {
    let size = [24, 18];
    let of_sum = Request { vpls: Some(300), gather: Some(3), ..Request::of_a_sum() };
    let requests = [
        ("tashika", of_sum.clone()),
        ("lightcuts", of_sum),
        ("tashika", Request { vpls: Some(2000), max_pairs: Some(64), ..Request::default() }),
        ("path", Request { paths: Some(2), ..Request::default() }),
    ];
    for (method, request) in requests {
        let renderer = || {
            Renderer::new(builtin::tiny())
                .request(request.clone())
                .size(size)
                .method(method.parse::<tashika::request::MethodName>().unwrap())
        };
        let plain = renderer().render().unwrap().film;
        let [one, three] = [1, 3]
            .map(|threads| with_threads(threads, || renderer().mattes(6).render().unwrap().film).unwrap());
        assert_eq!(without_mattes(&one), without_mattes(&plain), "{method}");
        assert_eq!(one, three, "{method}");
        assert_eq!(one.planes().len(), plain.planes().len() + 8, "{method}");
        let shown = one.plane(planes::OBJECT_ID).unwrap().u32_samples().unwrap();
        assert!(shown.iter().any(|number| *number != 0));
        for number in 1..=2 {
            let share = TileShare::new(number, 2).unwrap();
            let part = renderer().mattes(6).tiles(share).render().unwrap().film;
            let stops = part.plane(planes::STOP).unwrap();
            for (x, y) in part.window().pixels() {
                let is_there = stops.u32_at(x, y) != [0];
                for of in MatteOf::ALL {
                    let expected = if is_there { ranks(&one, of, x, y) } else { Vec::new() };
                    assert_eq!(ranks(&part, of, x, y), expected, "{method} {number} {x},{y}");
                }
            }
        }
    }
    for wrong in [0, 33] {
        let said = Renderer::new(builtin::tiny()).mattes(wrong).render().unwrap_err().to_string();
        assert!(said.starts_with(&format!("cryptomatte = {wrong}; expected 1 to 32 ranks")), "{said}");
    }
}

/// Objects and materials of all instances, in order.
fn names(scene: &Scene) -> Vec<(&str, &str)> {
    let of = |instance: InstanceId| (scene.object_name(instance), scene.material_of(instance).name.as_str());
    scene.instance_ids().map(of).collect()
}

#[test]
fn objects_are_called_as_files_call_them() {
    let mut d = Document::triangle();
    d.json["meshes"][0]["name"] = json!("plate");
    d.json["materials"][0]["name"] = json!("china");
    let long = "a name that is longer than what messages repeat of it ".repeat(3);
    d.json["nodes"] = json!([{ "mesh": 0, "name": long }, { "mesh": 0 }, { "mesh": 0, "name": "" }]);
    d.json["scenes"] = json!([{ "nodes": [0, 1, 2] }]);
    let scene = d.load().unwrap();
    assert_eq!(names(&scene), [(&*long, "china"), ("plate 1", "china"), ("plate 2", "china")]);

    let scene = mitsuba::load(
        r#"<bsdf type="diffuse" id="oak"/>
        <shape type="rectangle" id="table"><ref id="oak"/></shape>
        <shape type="rectangle"/><shape type="rectangle"/><shape type="cube"/>"#,
    );
    let objects: Vec<&str> = names(&scene).into_iter().map(|(object, _)| object).collect();
    assert_eq!(objects, ["table", "rectangle 1", "rectangle 2", "cube 1"]);
    assert_eq!(names(&scene)[0].1, "oak");

    let (head, triangle) = (pbrt::V4, pbrt::TRIANGLE);
    let scene = pbrt::scene(&format!(
        "{head} MakeNamedMaterial \"oak\" \"string type\" \"diffuse\" NamedMaterial \"oak\" {triangle} {triangle} \
         ObjectBegin \"tree\" {triangle} Shape \"sphere\" ObjectEnd ObjectInstance \"tree\" ObjectInstance \"tree\" {triangle}"
    ));
    let expected =
        ["trianglemesh 1", "trianglemesh 2", "tree 1", "tree 1", "tree 2", "tree 2", "trianglemesh 3"];
    assert_eq!(names(&scene), expected.map(|object| (object, "oak")));

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    let faces = "usemtl tin\nf 1 2 3\nusemtl oak\nf 1 3 2\nusemtl tin\nf 2 1 3\n";
    std::fs::write(&path, format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}")).unwrap();
    assert_eq!(names(&load_scene(&path, &lenient()).unwrap()), [("tin", "tin"), ("oak", "oak")]);
}
