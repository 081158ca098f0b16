//! Rooms far from zero. A closed room with glowing walls is equally bright at any position and in
//! any format, and the program states positions as they are in the file.
//!
//! The walls of the room emit `L_e = 0.8` and reflect `ρ = 0.6`, so that the radiance is
//! `L_e / (1 − ρ) = 2` everywhere. Its half size is 1 m; numbers of single precision are half a
//! metre apart at 5·10⁶ m.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use tashika::accel::Tracer;
use tashika::integrator::{PathStop, PathTracer};
use tashika::io::{load_scene, load_vpls, save_vpls};
use tashika::math::motion::Track;
use tashika::math::{Affine3A, Vec3};
use tashika::scene::{Camera, Emitter, Material, NoteKind, Scene};
use tashika::vpl::{VplOptions, VplSet};
use tempfile::TempDir;

use crate::cases::{builder, cuboid, film, glowing, lambert, lenient, luminances, place};

const EXPECTED: f64 = 2.0;

/// Centres of rooms. Most coordinates are not representable in single precision.
const FAR: [DVec3; 3] =
    [DVec3::new(1e6, 1e6, 1e6), DVec3::new(5e6 + 0.3, -4.2e6 - 0.1, 12.7), DVec3::new(-0.2, 5e6 + 0.4, 3e5)];

/// Returns the corners of the room, and its faces with their normals inward.
fn corners(middle: DVec3) -> Vec<DVec3> {
    cuboid(-Vec3::ONE, Vec3::ONE, true).positions.iter().map(|p| middle + p.as_dvec3()).collect()
}

fn triangles() -> Vec<[u32; 3]> {
    cuboid(-Vec3::ONE, Vec3::ONE, true).triangles
}

/// Formats numbers, separated by blanks.
fn list<T: ToString>(numbers: impl IntoIterator<Item = T>) -> String {
    numbers.into_iter().map(|n| n.to_string()).collect::<Vec<_>>().join(" ")
}

fn numbers(places: &[DVec3]) -> String {
    list(places.iter().flat_map(|p| p.to_array()))
}

/// Loads the first of several files in a folder.
fn load(name: &str, files: &[(&str, &[u8])]) -> Scene {
    let folder = TempDir::new().unwrap();
    files.iter().for_each(|(name, bytes)| std::fs::write(folder.path().join(name), bytes).unwrap());
    load_scene(&folder.path().join(name), &lenient()).unwrap_or_else(|e| panic!("{e}"))
}

fn radiances(scene: Scene) -> Vec<f64> {
    let tracer = Tracer::new(Arc::new(scene));
    let paths = PathTracer::new(&tracer, PathStop::Count(64), 200).unwrap();
    luminances(&film(&tracer, &paths, [12, 8], 1, 1))
}

fn mean(of: &[f64]) -> f64 {
    of.iter().sum::<f64>() / of.len() as f64
}

/// Checks that a room far from zero has the same film as the room around zero, except for single
/// paths that rounding changes. There are 6,144 paths, each with about 30 random choices, and
/// rounding changes one choice in 10⁶. Two paths may differ by twice the radiance.
fn is_as_bright(what: &str, room: impl Fn(DVec3) -> Scene) {
    let near = room(DVec3::ZERO);
    assert_eq!(near.origin(), DVec3::ZERO, "{what}: bits near zero stay");
    let near = radiances(near);
    assert!((mean(&near) / EXPECTED - 1.0).abs() < 0.02, "{what}: {} near zero", mean(&near));
    for middle in FAR {
        let scene = room(middle);
        let [lo, hi] = scene.bounds_in_file();
        assert!((lo - middle + 1.0).abs().max_element() < 1e-6, "{what}: {lo} about {middle}");
        assert!((hi - middle - 1.0).abs().max_element() < 1e-6, "{what}: {hi} about {middle}");
        let camera = scene.place_in_file(scene.cameras()[0].position());
        assert!((camera - middle).length() < 1e-6, "{what}: {camera} in {middle}");
        for emitter in scene.emitters() {
            let lamp = scene.place_in_file(emitter.position().unwrap());
            assert!((lamp - middle).length() < 1e-6, "{what}: {lamp} in {middle}");
        }
        assert!(!scene.notes().iter().any(|note| note.message.contains("far from")), "{what}");
        let far = radiances(scene);
        let off = (mean(&far) / mean(&near) - 1.0).abs();
        assert!(off < 3e-4, "{what} at {middle}: {} for {}", mean(&far), mean(&near));
    }
}

#[test]
fn rooms_of_pbrt_are_as_bright_wherever_they_stand() {
    let text = |middle: DVec3, transform: &str, shape: &str| {
        let DVec3 { x, y, z } = middle;
        format!(
            "Film \"rgb\" LookAt {x} {y} {z}  {x} {y} {}  0 1 0 Camera \"perspective\" \"float fov\" 90\nWorldBegin\n\
             LightSource \"point\" \"point3 from\" [{x} {y} {z}] \"rgb I\" [1e-6 1e-6 1e-6]\n\
             {transform}\nMaterial \"diffuse\" \"rgb reflectance\" [.6 .6 .6]\n\
             AreaLightSource \"diffuse\" \"rgb L\" [.8 .8 .8]\n{shape}\n",
            z + 1.0
        )
    };
    let shape = |middle: DVec3| {
        let (p, i) = (numbers(&corners(middle)), list(triangles().into_iter().flatten()));
        format!("Shape \"trianglemesh\" \"integer indices\" [{i}] \"point3 P\" [{p}]")
    };
    let load = |text: String| load("s.pbrt", &[("s.pbrt", text.as_bytes())]);
    is_as_bright("points", |middle| load(text(middle, "", &shape(middle))));
    is_as_bright("a transform", |middle| {
        load(text(middle, &format!("Translate {}", numbers(&[middle])), &shape(DVec3::ZERO)))
    });
    is_as_bright("transforms that cancel", |middle| {
        let rest = numbers(&[middle - 1e7]);
        load(text(middle, &format!("Translate 1e7 1e7 1e7 Translate {rest}"), &shape(DVec3::ZERO)))
    });
    is_as_bright("points that a transform takes back", |middle| {
        let away = DVec3::new(-3e7 + 0.3, 2e6, 5.5);
        load(text(middle, &format!("Translate {}", numbers(&[middle - away])), &shape(away)))
    });
    is_as_bright("a file of points", |middle| {
        let ply = |type_: &str| {
            let mut text = format!(
                "ply\nformat ascii 1.0\nelement vertex 8\nproperty {type_} x\nproperty {type_} y\nproperty {type_} z\n\
                 element face 12\nproperty list uchar int vertex_indices\nend_header\n"
            );
            corners(middle).iter().for_each(|p| text.push_str(&(numbers(&[*p]) + "\n")));
            triangles().iter().for_each(|t| text.push_str(&format!("3 {}\n", list(*t))));
            text
        };
        let scene = text(middle, "", "Shape \"plymesh\" \"string filename\" \"r.ply\"");
        self::load("s.pbrt", &[("s.pbrt", scene.as_bytes()), ("r.ply", ply("double").as_bytes())])
    });
}

#[test]
fn rooms_of_mitsuba_are_as_bright_wherever_they_stand() {
    let text = |middle: DVec3, shape: &str| {
        let DVec3 { x, y, z } = middle;
        format!(
            "<scene version=\"3.0.0\"><sensor type=\"perspective\"><float name=\"fov\" value=\"90\"/>\
             <transform name=\"to_world\"><lookat origin=\"{x}, {y}, {z}\" target=\"{x}, {y}, {}\" up=\"0,1,0\"/></transform>\
             <film type=\"hdrfilm\"/></sensor>\
             <emitter type=\"point\"><point name=\"position\" x=\"{x}\" y=\"{y}\" z=\"{z}\"/>\
             <rgb name=\"intensity\" value=\"1e-6\"/></emitter>{shape}</scene>",
            z + 1.0
        )
    };
    let look = "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\".6\"/></bsdf>\
                <emitter type=\"area\"><rgb name=\"radiance\" value=\".8\"/></emitter>";
    is_as_bright("a cube", |middle| {
        let DVec3 { x, y, z } = middle;
        let shape = format!(
            "<shape type=\"cube\"><boolean name=\"flip_normals\" value=\"true\"/><transform name=\"to_world\">\
             <translate x=\"-3e7\"/><translate x=\"3e7\"/><translate x=\"{x}\" y=\"{y}\" z=\"{z}\"/></transform>{look}</shape>"
        );
        load("s.xml", &[("s.xml", text(middle, &shape).as_bytes())])
    });
    is_as_bright("a file", |middle| {
        let shape = format!(
            "<shape type=\"obj\"><string name=\"filename\" value=\"r.obj\"/><boolean name=\"face_normals\" value=\"true\"/>{look}</shape>"
        );
        load("s.xml", &[("s.xml", text(middle, &shape).as_bytes()), ("r.obj", obj(middle).as_bytes())])
    });
}

fn obj(middle: DVec3) -> String {
    let mut text = "mtllib r.mtl\nusemtl m\n".to_owned();
    corners(middle).iter().for_each(|p| text.push_str(&format!("v {}\n", numbers(&[*p]))));
    triangles().iter().for_each(|t| text.push_str(&format!("f {}\n", list(t.map(|i| i + 1)))));
    text
}

/// An object is placed and moved by transformations that are large and nearly cancel. Its corners
/// are still where its file has them.
#[test]
fn instances_of_objects_are_where_their_transforms_put_them() {
    for middle in FAR {
        let rest = numbers(&[middle - 2e7]);
        let text = format!(
            "Film \"rgb\" LookAt {} {} 0 1 0 Camera \"perspective\" WorldBegin\n\
             ObjectBegin \"o\" Translate -1e7 -1e7 -1e7 Shape \"trianglemesh\" \"point3 P\" \
             [1e7 1e7 1e7 10000001 1e7 1e7 1e7 10000000.5 1e7] ObjectEnd\n\
             Translate 2e7 2e7 2e7 Translate {rest} ObjectInstance \"o\"\n\
             Scale 2 2 2 ActiveTransform EndTime Translate 0.5 0 0 ActiveTransform All ObjectInstance \"o\"\n",
            numbers(&[middle]),
            numbers(&[middle + 1.0]),
        );
        let scene = load("s.pbrt", &[("s.pbrt", text.as_bytes())]);
        let ids: Vec<_> = scene.instance_ids().collect();
        for (share, id, scale, moved) in [(0.0, 0, 1.0, 0.0), (0.0, 1, 2.0, 0.0), (1.0, 1, 2.0, 1.0)] {
            let found = scene.world_corners_at(share, ids[id], 0).map(|corner| scene.place_in_file(corner));
            for (corner, local) in found.into_iter().zip([DVec3::ZERO, DVec3::X, DVec3::Y * 0.5]) {
                let expected = middle + local * scale + DVec3::X * moved;
                assert!((corner - expected).length() < 1e-5, "{corner} for {expected}");
            }
        }
    }
}

/// OBJ files have no camera. The default camera sees the whole room.
#[test]
fn rooms_of_obj_are_where_their_file_has_them() {
    for middle in FAR {
        let scene = load(
            "r.obj",
            &[("r.obj", obj(middle).as_bytes()), ("r.mtl", b"newmtl m\nKd .6 .6 .6\nKe .8 .8 .8\n")],
        );
        assert!((scene.origin() - middle).length() < 2.0);
        let [lo, hi] = scene.bounds_in_file();
        assert!((lo - middle + 1.0).length() < 1e-6 && (hi - middle - 1.0).length() < 1e-6, "{lo} {hi}");
        let eye = scene.cameras()[0].position();
        assert!(eye.length() < 20.0, "{eye}");
    }
}

#[test]
fn rooms_of_usd_are_as_bright_wherever_they_stand() {
    let tuples = |places: &[DVec3]| {
        let all: Vec<String> = places.iter().map(|p| format!("({}, {}, {})", p.x, p.y, p.z)).collect();
        all.join(", ")
    };
    let room = |middle: DVec3, points: DVec3, at: DVec3| {
        let counts = ["3"; 12].join(", ");
        let indices: Vec<String> = triangles().into_iter().flatten().map(|i| i.to_string()).collect();
        let text = format!(
            "#usda 1.0\n(\n metersPerUnit = 1\n defaultPrim = \"W\"\n)\ndef Xform \"W\" {{\n\
             def Material \"M\" {{ token outputs:surface.connect = </W/M/S.outputs:surface>\n\
             def Shader \"S\" {{ uniform token info:id = \"UsdPreviewSurface\"\ncolor3f inputs:diffuseColor = (0.6, 0.6, 0.6)\n\
             color3f inputs:emissiveColor = (0.8, 0.8, 0.8)\nfloat inputs:roughness = 1\nfloat inputs:ior = 1\n\
             token outputs:surface }} }}\n\
             def Xform \"A\" {{ double3 xformOp:translate = (3e7, 3e7, 3e7)\nuniform token[] xformOpOrder = [\"xformOp:translate\"]\n\
             def Mesh \"R\" {{ double3 xformOp:translate = {}\nuniform token[] xformOpOrder = [\"xformOp:translate\"]\n\
             uniform token subdivisionScheme = \"none\"\nint[] faceVertexCounts = [{counts}]\n\
             int[] faceVertexIndices = [{}]\npoint3f[] points = [{}]\nrel material:binding = </W/M> }} }}\n\
             def Camera \"C\" {{ double3 xformOp:translate = {}\nuniform token[] xformOpOrder = [\"xformOp:translate\"] }}\n\
             def SphereLight \"L\" {{ float inputs:radius = 0\nfloat inputs:intensity = 1e-6\nbool treatAsPoint = 1\ndouble3 xformOp:translate = {}\n\
             uniform token[] xformOpOrder = [\"xformOp:translate\"] }}\n}}\n",
            tuples(&[at - 3e7]),
            indices.join(", "),
            tuples(&corners(points)),
            tuples(&[middle]),
            tuples(&[middle]),
        );
        load("s.usda", &[("s.usda", text.as_bytes())])
    };
    is_as_bright("a transform", |middle| room(middle, DVec3::ZERO, middle));
    is_as_bright("points", |middle| room(middle, middle, DVec3::ZERO));
}

#[test]
fn rooms_of_gltf_are_as_bright_wherever_they_stand() {
    is_as_bright("nodes", |middle| {
        let mut d = super::gltf::Document::empty();
        let places: Vec<[f32; 3]> = corners(DVec3::ZERO).iter().map(|p| p.as_vec3().to_array()).collect();
        let positions = d.vec3(&places);
        let bytes: Vec<u8> = triangles().into_iter().flatten().map(|i| i as u8).collect();
        let view = d.view(&bytes);
        let indices =
            serde_json::json!({ "bufferView": view, "componentType": 5121, "count": 36, "type": "SCALAR" });
        let indices = d.push("accessors", indices);
        let primitive =
            serde_json::json!({ "attributes": { "POSITION": positions }, "indices": indices, "material": 0 });
        d.push("meshes", serde_json::json!({ "primitives": [primitive] }));
        d.push(
            "materials",
            serde_json::json!({ "emissiveFactor": [0.8, 0.8, 0.8],
                "pbrMetallicRoughness": { "baseColorFactor": [0.6, 0.6, 0.6, 1], "metallicFactor": 0 },
                "extensions": { "KHR_materials_specular": { "specularFactor": 0 } } }),
        );
        d.json["extensionsUsed"] = serde_json::json!(["KHR_materials_specular", "KHR_lights_punctual"]);
        d.json["cameras"] =
            serde_json::json!([{ "type": "perspective", "perspective": { "yfov": 1.5, "znear": 0.1 } }]);
        d.json["extensions"] = serde_json::json!({ "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": 1e-6 }] } });
        let rest = (middle - 3e7).to_array();
        let own = middle.to_array();
        d.push("nodes", serde_json::json!({ "translation": [3e7, 3e7, 3e7], "children": [1] }));
        d.push("nodes", serde_json::json!({ "translation": rest, "mesh": 0 }));
        d.push("nodes", serde_json::json!({ "translation": own, "camera": 0 }));
        d.push(
            "nodes",
            serde_json::json!({ "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, own[0], own[1], own[2], 1],
            "extensions": { "KHR_lights_punctual": { "light": 0 } } }),
        );
        d.load().unwrap()
    });
}

/// Builds the room at a position, with a camera in it.
fn built(middle: DVec3) -> tashika::scene::SceneBuilder {
    let mut b = builder();
    let material = b.add_material(glowing("wall", lambert(0.6), 0.8)).unwrap();
    let mesh = b.add_mesh(cuboid(-Vec3::ONE, Vec3::ONE, true), material).unwrap();
    b.add_instance(mesh, DAffine3::from_translation(middle)).unwrap();
    let camera = Camera::look_at("c", Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.0);
    let axes = camera.to_world.matrix3.as_dmat3();
    b.add_camera_at(camera, DAffine3 { matrix3: axes, translation: middle }).unwrap();
    b
}

#[test]
fn rooms_of_builders_and_things_that_move_in_them_are_as_bright() {
    is_as_bright("a builder", |middle| built(middle).build().unwrap());
    is_as_bright("motion", |middle| {
        let mut b = built(middle);
        let material = b.add_material(glowing("ball", lambert(0.6), 0.8)).unwrap();
        // The mesh is far from the origin of its object space.
        let away = DVec3::new(0.0, 0.0, 2e6);
        let mut ball = cuboid(Vec3::splat(-0.2), Vec3::splat(0.2), false);
        ball.place(&ball.positions.iter().map(|p| p.as_dvec3() + away).collect::<Vec<_>>());
        let mesh = b.add_mesh(ball, material).unwrap();
        let key = |way: f64| DAffine3::from_translation(middle - away + DVec3::new(0.5 * way, -0.6, -0.5));
        let track = Track::new([(0.0, key(0.0)), (1.0, key(1.0))]).unwrap();
        b.add_moving_instance(mesh, track, [0.0, 1.0]).unwrap().unwrap();
        let standing = b.build().unwrap();
        let id = standing.instance_ids().last().unwrap();
        for share in [0.0, 0.5, 1.0_f32] {
            let at = standing.moved(id, share).unwrap().to_world.translation;
            let place = standing.place_in_file(Vec3::from(at));
            let expected = middle + DVec3::new(f64::from(0.5 * share), -0.6, -0.5);
            assert!((place - expected).length() < 1e-5, "{share}: {place} for {expected}");
        }
        standing
    });
    let moving = |middle: DVec3| {
        let at = |x: f64| DAffine3::from_translation(middle + DVec3::X * x);
        let track = Track::new([(0.0, at(-0.1)), (1.0, at(0.1))]).unwrap();
        let mut b = built(middle);
        let camera = Camera::look_at("m", Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.0);
        b.add_camera(camera.moving(track, [0.0, 1.0])).unwrap();
        b.build().unwrap()
    };
    for middle in FAR {
        let scene = moving(middle);
        let ray = |share: f32| {
            scene.cameras()[1].central_ray(glam::Vec2::splat(4.0), share, [8, 8]).unwrap().origin
        };
        let off = scene.place_in_file(ray(1.0)) - middle;
        assert!((off - DVec3::X * 0.1).length() < 1e-6, "{off}");
    }
}

/// A room and a large or distant object, such as a sky dome or a sun, at several positions. The
/// origin of the scene must be near the room.
#[test]
fn far_objects_do_not_spoil_a_room() {
    let with = |middle: DVec3, other: DVec3, half: f64| {
        let mut b = built(middle);
        let material = b.add_material(Material::new("other", lambert(0.5))).unwrap();
        let mesh = b.add_mesh(cuboid(-Vec3::ONE, Vec3::ONE, half > 1e6), material).unwrap();
        let to_world = DAffine3 { matrix3: DMat3::from_diagonal(DVec3::splat(half)), translation: other };
        b.add_instance(mesh, to_world).unwrap();
        b.build().unwrap()
    };
    for (middle, other, half) in [
        (DVec3::ZERO, DVec3::new(1e8, 3e7, 0.0), 7e5),
        (FAR[1], DVec3::new(1e8, 3e7, 0.0), 7e5),
        (FAR[1], DVec3::ZERO, 3e7),
        (FAR[0], DVec3::ZERO, 1.0),
    ] {
        let scene = with(middle, other, half);
        assert!((scene.origin() - middle).length() < 2.0, "{} for {middle}", scene.origin());
        let mean = mean(&radiances(scene));
        assert!((mean / EXPECTED - 1.0).abs() < 0.02, "{mean} at {middle} beside {other}");
    }
}

#[test]
fn a_wide_scene_is_noted_with_what_is_lost() {
    let mut b = built(DVec3::ZERO);
    let material = b.add_material(glowing("other", lambert(0.6), 0.8)).unwrap();
    let mesh = b.add_mesh(cuboid(-Vec3::ONE, Vec3::ONE, true), material).unwrap();
    b.add_instance(mesh, Affine3A::from_translation(Vec3::X * 1e6)).unwrap();
    let scene = b.build().unwrap();
    let note = scene.notes().iter().find(|note| note.message.contains("so far from zero")).expect("a note");
    assert!(note.kind == NoteKind::Approximated && note.message.contains("0.0625 m"), "{}", note.message);
    // Positions that are given in single precision are stored exactly, but neighbouring numbers are
    // far apart; a note says so.
    let mut b = builder();
    let mut mesh = cuboid(-Vec3::ONE, Vec3::ONE, true);
    mesh.positions.iter_mut().for_each(|p| *p += 1e6);
    place(&mut b, mesh, glowing("wall", lambert(0.6), 0.8));
    let scene = b.build().unwrap();
    let note = scene.notes().iter().find(|note| note.message.contains("single precision")).expect("a note");
    assert!(note.message.contains("0.0625 m apart"), "{}", note.message);
    assert_eq!(scene.bounds_in_file(), [DVec3::splat(1e6 - 1.0), DVec3::splat(1e6 + 1.0)]);
}

/// A set of lights was traced in a scene with another origin. It is moved to the origin of this
/// scene.
#[test]
fn lights_of_a_file_are_where_the_scene_has_them() {
    let trace = |scene: &Arc<Scene>| {
        let options = VplOptions { count: 50, ..VplOptions::default() };
        VplSet::trace(&Tracer::new(Arc::clone(scene)), &options).unwrap()
    };
    let scene = Arc::new(built(FAR[1]).build().unwrap());
    let set = trace(&scene);
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("l.vpl");
    save_vpls(&path, &set).unwrap();
    let read = load_vpls(&path).unwrap();
    assert_eq!(read, set);
    assert_eq!(read.origin(), scene.origin());
    let about = DVec3::splat(0.5);
    let moved = read.clone().relative_to(scene.origin() + about);
    for (a, b) in moved.lights().iter().zip(set.lights()) {
        assert!((a.position.as_dvec3() + about - b.position.as_dvec3()).length() < 1e-6);
    }
    assert_eq!(read.clone().relative_to(scene.origin()), read, "bit for bit");
    let lamps = |scene: &Scene| scene.emitters().iter().filter_map(Emitter::position).count();
    assert_eq!(lamps(&scene), 0);
}
