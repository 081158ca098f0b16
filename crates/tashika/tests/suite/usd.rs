//! USD: the same scene in all encodings, and prims that are composed from layers.
//!
//! Files of `usd/` were written by Pixar's own library, and `composed.json` has the result of that
//! library for them (`scripts/usd_samples.py`). Damaged files are in `damaged_usd`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::Vec3;
use serde_json::{Value, json};
use tashika::color::Rgb;
use tashika::error::{Error, Result};
use tashika::integrator::{PathStop, PathTracer};
use tashika::io::{LoadOptions, load_scene};
use tashika::scene::{Emitter, NoteKind, Scene, Surface};

use super::gltf::{Document, notes, write};
use crate::cases::{film, luminances};

/// The folder with the files.
pub const SAMPLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/suite/usd");

/// Loads a file of the folder [`SAMPLES`].
pub fn sample(name: &str) -> Scene {
    load_scene(&Path::new(SAMPLES).join(name), &LoadOptions::default())
        .unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Loads a text in a separate folder, in metres, with `+y` up.
pub fn load(text: &str) -> Result<Scene> {
    load_with(text, &[], &LoadOptions::default())
}

/// Loads a text as [`load`] does, beside other files.
pub fn load_with(text: &str, others: &[(&str, &[u8])], options: &LoadOptions) -> Result<Scene> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in others {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        write(&path, bytes);
    }
    let path = folder.path().join("s.usda");
    write(&path, whole(text).as_bytes());
    load_scene(&path, options)
}

/// A complete layer in metres with the given prims.
pub fn whole(text: &str) -> String {
    if text.starts_with("#usda") {
        return text.to_owned();
    }
    format!("#usda 1.0\n(\n    metersPerUnit = 1\n    defaultPrim = \"W\"\n)\n{text}")
}

/// A quad in the plane `z = 0`; `more` is added to its prim.
pub fn quad(name: &str, more: &str) -> String {
    format!(
        "def Mesh \"{name}\" {{
    uniform token subdivisionScheme = \"none\"
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    {more}
}}\n"
    )
}

/// World corners of all instances, by the names of their objects.
pub fn corners(scene: &Scene) -> BTreeMap<String, Vec<Vec3>> {
    let mut all: BTreeMap<String, Vec<Vec3>> = BTreeMap::new();
    for (instance, id) in scene.instances().iter().zip(scene.instance_ids()) {
        let points = scene.mesh_of(id).positions().iter().map(|p| instance.to_world.transform_point3(*p));
        all.entry(scene.object_name(id).to_owned()).or_default().extend(points);
    }
    all
}

fn base_color(scene: &Scene, object: &str) -> Rgb {
    let id = scene.instance_ids().find(|id| scene.object_name(*id) == object);
    match scene.material_of(id.unwrap_or_else(|| panic!("no {object}"))).surface {
        Surface::MetallicRoughness { base_color, .. } => base_color.factor,
        Surface::Lambert { reflectance } => reflectance.factor,
        other => panic!("{other:?}"),
    }
}

/// The scene of `simple.usda` as glTF.
fn as_gltf(folder: &Path) -> PathBuf {
    let mut d = Document::empty();
    let mut quad = |points: &[[f32; 3]], uvs: Option<&[[f32; 2]]>, material: usize| {
        let mut attributes = json!({ "POSITION": d.vec3(points) });
        if let Some(uvs) = uvs {
            let bytes: Vec<u8> = uvs.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
            let view = d.view(&bytes);
            let accessor = json!({ "bufferView": view, "componentType": 5126, "count": 4, "type": "VEC2" });
            attributes["TEXCOORD_0"] = json!(d.push("accessors", accessor));
        }
        let indices = d.view(&[0, 1, 2, 0, 2, 3]);
        let indices = json!({ "bufferView": indices, "componentType": 5121, "count": 6, "type": "SCALAR" });
        let indices = d.push("accessors", indices);
        let primitive = json!({ "attributes": attributes, "indices": indices, "material": material });
        let mesh = d.push("meshes", json!({ "primitives": [primitive] }));
        d.push("nodes", json!({ "mesh": mesh }));
    };
    // In glTF, texture coordinates run down.
    let uvs = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    quad(&[[-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0], [-2.0, 0.0, -2.0]], Some(&uvs), 0);
    quad(&[[-2.0, 0.0, -2.0], [2.0, 0.0, -2.0], [2.0, 3.0, -2.0], [-2.0, 3.0, -2.0]], None, 1);
    d.json["images"] = json!([{ "uri": "chess.png" }]);
    d.json["textures"] = json!([{ "source": 0 }]);
    d.json["materials"] = json!([
        { "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "metallicFactor": 0, "roughnessFactor": 0.5 } },
        { "pbrMetallicRoughness": { "baseColorFactor": [0.9, 0.6, 0.3, 1], "metallicFactor": 1, "roughnessFactor": 0.5 } },
    ]);
    // A normalized sphere of strength 40 emits 40 / 4 in each direction.
    d.json["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": 10 }] } });
    d.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    d.push(
        "nodes",
        json!({ "translation": [0.5, 2.5, 0.5], "extensions": { "KHR_lights_punctual": { "light": 0 } } }),
    );
    let fov = 2.0 * (12.0_f64 / 30.0).atan();
    d.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": fov, "znear": 0.1 } }]);
    d.push("nodes", json!({ "camera": 0, "translation": [0, 1.2, 5] }));
    std::fs::copy(Path::new(SAMPLES).join("chess.png"), folder.join("chess.png")).unwrap();
    let path = folder.join("simple.glb");
    write(&path, &d.glb());
    path
}

/// Pixels of a picture of 24 × 18, as bits.
fn picture(scene: Scene) -> Vec<u64> {
    let tracer = tashika::accel::Tracer::new(std::sync::Arc::new(scene));
    let integrator = PathTracer::new(&tracer, PathStop::Count(8), 4).unwrap();
    let film = film(&tracer, &integrator, [24, 18], 8, 3);
    luminances(&film).iter().map(|l| l.to_bits()).collect()
}

#[test]
fn all_encodings_give_the_picture_of_the_same_scene_as_gltf() {
    let folder = tempfile::tempdir().unwrap();
    let gltf = load_scene(&as_gltf(folder.path()), &LoadOptions::default()).unwrap();
    let expected = picture(gltf);
    assert!(expected.iter().filter(|l| **l != 0).count() > 100, "a picture of something");
    for name in ["simple.usda", "simple.usdc", "simple.usdz", "packed.usdz"] {
        let scene = sample(name);
        assert_eq!(notes(&scene), [], "{name}");
        assert!(picture(scene) == expected, "{name}");
    }
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn vector(value: &Value) -> Vec3 {
    let [x, y, z] = numbers(value)[..] else { panic!("{value}") };
    Vec3::new(x as f32, y as f32, z as f32)
}

/// A scene with references, payloads, variants, a class, a sublayer, overs, instances, a strong
/// binding, pivots and a reset of the transform stack. All objects have the world positions that
/// Pixar's library computes.
#[test]
fn composed_scenes_are_what_pixars_library_reads() {
    let scene = sample("composed.usda");
    let text = std::fs::read_to_string(Path::new(SAMPLES).join("composed.json")).unwrap();
    let expected: Value = serde_json::from_str(&text).unwrap();
    let mut found = corners(&scene);
    let mut points: BTreeMap<String, Vec<Vec3>> = BTreeMap::new();
    for mesh in expected["meshes"].as_array().unwrap() {
        let path = mesh["path"].as_str().unwrap();
        let all = mesh["points"].as_array().unwrap().iter().map(vector);
        points.entry(path.to_owned()).or_default().extend(all);
        if mesh["color"].is_null() {
            continue;
        }
        let color = vector(&mesh["color"]);
        assert!((Vec3::from(base_color(&scene, path).to_array()) - color).length() < 1e-6, "{path}");
        let id = scene.instance_ids().find(|id| scene.object_name(*id) == path).unwrap();
        let Surface::MetallicRoughness { roughness, .. } = scene.material_of(id).surface else { panic!() };
        assert!((f64::from(roughness.factor) - mesh["roughness"].as_f64().unwrap()).abs() < 1e-6, "{path}");
    }
    let lamp = found.remove("/World/Lamp").expect("a lamp");
    assert_eq!(found.keys().collect::<Vec<_>>(), points.keys().collect::<Vec<_>>());
    for (path, expected) in &points {
        assert_eq!(found[path].len(), expected.len(), "{path}");
        for point in expected {
            let nearest = found[path].iter().map(|p| (*p - *point).length()).fold(f32::MAX, f32::min);
            assert!(nearest < 1e-5, "{path}: {point} is not among {:?}", found[path]);
        }
    }
    let lights = &expected["lights"];
    let light = |name: &str| lights.as_array().unwrap().iter().find(|l| l["path"] == name).unwrap();
    let (_, emission) = scene.area_emitters().next().unwrap();
    let radiance = Vec3::from(emission.radiance.factor.to_array());
    assert!((radiance - vector(&light("/World/Lamp")["radiance"])).length() < 1e-5);
    let middle = lamp.iter().sum::<Vec3>() / lamp.len() as f32;
    assert!((middle - vector(&light("/World/Lamp")["position"])).length() < 1e-5);
    let [Emitter::Directional { direction, irradiance }] = scene.emitters() else { panic!() };
    assert!((*direction - vector(&light("/World/Sun")["axis"])).length() < 1e-5);
    assert!((Vec3::from(irradiance.to_array()) - vector(&light("/World/Sun")["radiance"])).length() < 1e-5);
    // Two instances of one chair share their meshes.
    let mesh = |path: &str| {
        let index = scene.instance_ids().position(|id| scene.object_name(id) == path).unwrap();
        scene.instances()[index].mesh
    };
    assert_eq!(mesh("/World/Twin_0/Seat"), mesh("/World/Twin_1/Seat"));
}

#[test]
fn layers_are_stronger_in_their_order_and_lists_are_edited() {
    let files: [(&str, &[u8]); 2] = [
        ("a.usda", b"#usda 1.0\ndef Xform \"W\" { color3f[] primvars:displayColor = [(1, 0, 0)]\n double3 xformOp:translate = (1, 0, 0)\n uniform token[] xformOpOrder = [\"xformOp:translate\"] }"),
        ("b.usda", b"#usda 1.0\ndef Xform \"W\" { color3f[] primvars:displayColor = [(0, 1, 0)]\n double3 xformOp:translate = (0, 5, 0) }\ndef Xform \"B\" { def Xform \"Only\" { } }"),
    ];
    let text = format!(
        "#usda 1.0\n(\n metersPerUnit = 1\n subLayers = [@./a.usda@, @b.usda@]\n)\nover \"W\" {{ {} }}",
        quad("Q", "")
    );
    let scene = load_with(&text, &files, &LoadOptions::default()).unwrap();
    assert_eq!(base_color(&scene, "/W/Q"), Rgb::new(1.0, 0.0, 0.0));
    assert_eq!(corners(&scene)["/W/Q"][0], Vec3::new(1.0, 0.0, 0.0));
    // A stronger layer removes a reference that a weaker layer added.
    let weak = b"#usda 1.0\ndef Xform \"W\" ( prepend references = [</P>, </R>] ) { }".as_slice();
    let [p, r] = ["P", "R"].map(|name| format!("class Xform \"{name}\" {{ {} }}\n", quad(name, "")));
    let head = "#usda 1.0\n(\n metersPerUnit = 1\n subLayers = [@weak.usda@]\n)\n";
    for (edit, expected) in [
        ("", vec!["/W/P", "/W/R"]),
        ("delete references = </P>", vec!["/W/R"]),
        ("references = None", vec![]),
    ] {
        let edit = if edit.is_empty() { String::new() } else { format!("( {edit} )") };
        let text = format!("{head}over \"W\" {edit} {{ }}\n{p}{r}");
        let scene = load_with(&text, &[("weak.usda", weak)], &LoadOptions::default()).unwrap();
        assert_eq!(corners(&scene).keys().collect::<Vec<_>>(), expected, "{edit}");
    }
}

#[test]
fn strengths_follow_the_kinds_of_arcs() {
    // In order of strength: local, class, variant, reference, payload, specialised class.
    let colors = ["(1,0,0)", "(0,1,0)", "(0,0,1)", "(1,1,0)", "(0,1,1)", "(1,0,1)"];
    let color = |i: usize| format!("color3f[] primvars:displayColor = [{}]", colors[i]);
    for (strongest, expected) in colors.iter().enumerate() {
        let said = |i: usize| if i >= strongest { color(i) } else { String::new() };
        let text = format!(
            "class \"C\" {{ {} }}\nclass \"R\" {{ {} }}\nclass \"P\" {{ {} }}\nclass \"S\" {{ {} }}
def Mesh \"W\" (
    inherits = </C>
    prepend references = </R>
    payload = </P>
    specializes = </S>
    variants = {{ string v = \"x\" }}
    prepend variantSets = \"v\"
) {{
    {}
    uniform token subdivisionScheme = \"none\"
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]
    variantSet \"v\" = {{ \"x\" {{ {} }} \"y\" {{ {} }} }}
}}",
            said(1),
            said(3),
            said(4),
            said(5),
            said(0),
            said(2),
            color(0)
        );
        let scene = load(&text).unwrap();
        let numbers = expected.replace('(', "[").replace(')', "]");
        let expected = vector(&serde_json::from_str(&numbers).unwrap());
        assert_eq!(Vec3::from(base_color(&scene, "/W").to_array()), expected, "{strongest}");
    }
}

#[test]
fn cycles_are_refused_and_what_is_missing_is_listed() {
    let refused = |text: &str| {
        let error = load(text).unwrap_err();
        assert!(matches!(error, Error::Invalid { .. }), "{error}");
        error.to_string()
    };
    for text in [
        "def \"W\" ( references = </W> ) { }",
        "def \"W\" { def \"B\" ( references = </W> ) { } }",
        "def \"W\" ( references = </B> ) { }\ndef \"B\" ( payload = </W> ) { }",
        "def \"W\" ( inherits = </B> ) { }\nclass \"B\" ( specializes = </W> ) { }",
        "def \"W\" ( references = @s.usda@ ) { }",
        "def \"W\" ( variants = { string v = \"x\" } ) { variantSet \"v\" = { \"x\" ( references = </W> ) { } } }",
    ] {
        let message = refused(text);
        assert!(message.contains("made of each other") && message.contains("s.usda:"), "{text}: {message}");
    }
    let message = refused("#usda 1.0\n( subLayers = [@s.usda@] )");
    assert!(message.contains("contains itself"), "{message}");
    let text = format!("def Xform \"W\" ( references = @gone.usda@ ) {{ {} }}", quad("Q", ""));
    let error = load(&text).unwrap_err();
    let Error::Missing { files, .. } = &error else { panic!("{error}") };
    assert!(files.len() == 1 && files[0].contains("s.usda:6: /W: layer \"gone.usda\""), "{files:?}");
    let lenient = LoadOptions { allow_missing: true, ..LoadOptions::default() };
    let scene = load_with(&text, &[], &lenient).unwrap();
    assert_eq!((corners(&scene).len(), notes(&scene)[0].0), (1, NoteKind::Missing));
    // A damaged layer is an error that names it.
    let error = load_with(&text, &[("gone.usda", b"#usda 1.0\ndef {")], &LoadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("gone.usda:2: "), "{error}");
    let outside = load_with(
        "def \"W\" ( references = @d/a.usda@ ) { }",
        &[("d/a.usda", b"#usda 1.0\n( subLayers = [@/x.usda@] )\ndef \"A\" { }")],
        &LoadOptions::default(),
    );
    assert!(outside.unwrap_err().to_string().contains("\"/x.usda\" could not be read (outside"));
    let outside = load("def \"W\" ( references = @../x.usda@ ) { }").unwrap_err();
    assert!(outside.to_string().contains("allow-outside"), "{outside}");
}

/// Each level references the one below it ten times. Eight levels would have more prims than a
/// scene may have.
#[test]
fn references_in_references_do_not_fill_the_memory() {
    let mut text = String::from("class \"L0\" { def Xform \"X\" { } }\n");
    for level in 1..9 {
        text += &format!("class \"L{level}\" {{\n");
        for i in 0..10 {
            text += &format!("def \"C{i}\" ( references = </L{}> ) {{ }}\n", level - 1);
        }
        text += "}\n";
    }
    text += "def \"W\" ( references = </L8> ) { }\n";
    let error = load(&text).unwrap_err().to_string();
    assert!(error.contains("times, by references"), "{error}");
}

#[test]
fn times_choose_among_samples() {
    let text = format!(
        "#usda 1.0\n(\n metersPerUnit = 1\n timeCodesPerSecond = 10\n)\ndef Xform \"W\" {{
    double3 xformOp:translate.timeSamples = {{ 10: (1, 0, 0), 20: (3, 0, 0) }}
    uniform token[] xformOpOrder = [\"xformOp:translate\"]
    {}
}}",
        quad("Q", "token visibility.timeSamples = { 0: \"inherited\", 15: \"invisible\" }")
    );
    let at = |seconds: Option<f64>| {
        load_with(&text, &[], &LoadOptions { at: seconds, ..LoadOptions::default() }).unwrap()
    };
    let place = |scene: &Scene| corners(scene).get("/W/Q").map(|all| all[0].x);
    let first = at(None);
    assert_eq!(place(&first), Some(1.0));
    assert_eq!(first.animated_seconds(), Some([0.0, 2.0]));
    let said = notes(&first);
    assert!(said.len() == 1 && said[0].1.contains("timeSamples"), "{said:?}");
    for (seconds, expected) in [(0.0, Some(1.0)), (1.25, Some(1.5)), (1.5, None), (9.0, None)] {
        let scene = at(Some(seconds));
        assert_eq!(place(&scene), expected, "{seconds}");
        assert!(notes(&scene).iter().all(|(kind, _)| *kind != NoteKind::Approximated));
    }
}

#[test]
fn units_and_axes_become_metres_and_y_up() {
    let mesh = quad("Q", "");
    let scene = load(&format!("#usda 1.0\n( upAxis = \"Z\" )\n{mesh}")).unwrap();
    // The file is in centimetres, and its y becomes −z.
    assert!((corners(&scene)["/Q"][2] - Vec3::new(0.01, 0.0, -0.01)).length() < 1e-7);
    let scene = load(&format!("#usda 1.0\n( metersPerUnit = 2 )\n{mesh}")).unwrap();
    assert_eq!(corners(&scene)["/Q"][2], Vec3::new(2.0, 2.0, 0.0));
    let error = load(&format!("#usda 1.0\n( metersPerUnit = 0 )\n{mesh}")).unwrap_err().to_string();
    assert!(error.contains("metersPerUnit: 0; expected a finite number above 0"), "{error}");
}
