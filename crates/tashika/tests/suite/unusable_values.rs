//! Unusable values in pbrt, Mitsuba and glTF files. An object that does not affect the picture is
//! omitted; a value that does is repaired. Both give a note, and the rest of the scene is loaded.

use std::fs;

use serde_json::{Value, json};
use tashika::io::load_scene;
use tashika::scene::{NoteKind, Projection, Scene};

use super::pbrt::{TRIANGLE, V4};
use crate::cases::lenient;

/// Loads a scene with one placed triangle. Returns it with its only note and the note's line.
fn repair(name: &str, text: &str) -> (Scene, String, Option<u32>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    let scene = load_scene(&path, &lenient()).unwrap_or_else(|error| panic!("{error}\n{text}"));
    assert_eq!(scene.instances().len(), 1, "{text}: the rest is there");
    let notes: Vec<_> = scene.notes().iter().filter(|n| n.kind != NoteKind::Defaulted).collect();
    let [note] = &notes[..] else { panic!("{text}: {notes:?}") };
    assert_eq!((note.kind, note.count), (NoteKind::Repaired, 1), "{text}: {}", note.message);
    let (message, line) = (note.message.clone(), note.first.line);
    (scene, message, line)
}

#[test]
fn pbrt_goes_on_without_what_cannot_be_used() {
    for (unusable, expected) in [
        ("Shape \"sphere\" \"float radius\" 0", "left out"),
        ("Shape \"disk\" \"float radius\" 0", "left out"),
        ("Shape \"trianglemesh\" \"integer indices\" [0 1 2]", "without points \"P\": left out"),
        ("Shape \"bilinearmesh\"", "without points \"P\": left out"),
        ("Shape \"loopsubdiv\" \"integer indices\" [0 1 2]", "without points \"P\": left out"),
        ("AttributeBegin Scale 0 1 1 Shape \"sphere\" AttributeEnd", "cannot be inverted: left out"),
        ("LightSource \"point\" \"float scale\" -1", "negative scales of lights: 0"),
        ("LightSource \"point\" \"rgb I\" [-1 -1 -1]", "negative channels"),
    ] {
        let (scene, message, line) = repair("a.pbrt", &format!("{V4}{unusable}\n{TRIANGLE}"));
        assert!(message.contains(expected), "{unusable}: {message}");
        assert_eq!(line, Some(2));
        assert!(scene.emitters().is_empty());
    }
    let text = format!("Film \"rgb\" Camera \"perspective\" \"float fov\" 200 WorldBegin {TRIANGLE}");
    let (scene, message, _) = repair("a.pbrt", &text);
    assert!(message.contains("fields of view") && scene.cameras().len() == 1, "{message}");
}

#[test]
fn mitsuba_goes_on_without_what_cannot_be_used() {
    let transform = |step: &str| {
        format!(
            "<emitter type=\"point\">\n<transform name=\"to_world\"><scale value=\"1\"/>{step}</transform></emitter>"
        )
    };
    for (unusable, expected, line) in [
        (
            "<shape type=\"sphere\">\n<float name=\"radius\" value=\"0\"/></shape>",
            "without extent: left out",
            2,
        ),
        ("<shape type=\"disk\"><float name=\"radius\" value=\"0\"/></shape>", "without extent: left out", 2),
        (
            "<shape type=\"cylinder\"><point name=\"p1\" value=\"0 0 0\"/></shape>",
            "without extent: left out",
            2,
        ),
        (&*transform("<rotate angle=\"9\"/>"), "rotations without axis: left out", 3),
        (&*transform("<lookat origin=\"1 1 1\" target=\"1 1 1\"/>"), "lookat without direction: left out", 3),
        (
            "<emitter type=\"directional\">\n<vector name=\"direction\" value=\"0 0 0\"/></emitter>",
            "lights without direction: along +z",
            2,
        ),
        (
            "<emitter type=\"envmap\"><string name=\"filename\" value=\"e.pfm\"/>\n<float name=\"scale\" value=\"-1\"/></emitter>",
            "scale = -1 is out of range: 0",
            3,
        ),
        (
            "<sensor type=\"perspective\">\n<float name=\"fov\" value=\"180\"/></sensor>",
            "fov = 180 is out of range: 179.999",
            3,
        ),
        (
            "<sensor type=\"perspective\">\n<transform name=\"to_world\"><scale z=\"0\"/></transform></sensor>",
            "cameras with a transform that flattens space: left out",
            3,
        ),
        (
            "<sensor type=\"perspective\">\n<float name=\"shutter_open\" value=\"1\"/></sensor>",
            "shutters that close before they open",
            2,
        ),
        (
            "<sensor type=\"perspective\"><film type=\"hdrfilm\">\n<integer name=\"width\" value=\"0\"/></film></sensor>",
            "width = 0 is out of range: 1",
            3,
        ),
        (
            "<sensor type=\"perspective\"><film type=\"hdrfilm\">\n<integer name=\"crop_width\" value=\"9000\"/></film></sensor>",
            "reaches beyond the film",
            3,
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let text = format!("<scene version=\"3.0.0\">\n{unusable}\n<shape type=\"rectangle\"/></scene>");
        let path = folder.path().join("a.xml");
        fs::write(&path, &text).unwrap();
        let mut bytes = b"PF\n2 1\n-1.0\n".to_vec();
        bytes.extend([1.0_f32; 6].iter().flat_map(|v| v.to_le_bytes()));
        fs::write(folder.path().join("e.pfm"), bytes).unwrap();
        let scene = load_scene(&path, &lenient()).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let notes: Vec<_> = scene.notes().iter().filter(|n| n.kind != NoteKind::Defaulted).collect();
        let [note] = &notes[..] else { panic!("{text}: {notes:?}") };
        assert_eq!(
            (note.kind, note.first.line),
            (NoteKind::Repaired, Some(line)),
            "{text}: {}",
            note.message
        );
        assert!(note.message.contains(expected), "{unusable}: {}", note.message);
        assert_eq!(scene.instances().len(), 1, "{text}");
    }
}

#[test]
fn gltf_goes_on_without_what_cannot_be_used() {
    let light =
        |light: Value| (json!({ "lights": [light] }), json!({ "KHR_lights_punctual": { "light": 0 } }));
    let file = |change: &dyn Fn(&mut Value)| {
        let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let bytes: Vec<u8> = corners.iter().flat_map(|v| v.to_le_bytes()).collect();
        let mut json = json!({
            "asset": { "version": "2.0" },
            "buffers": [{ "byteLength": 36, "uri": format!("data:application/octet-stream;base64,{}", base64(&bytes)) }],
            "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
            "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                "min": [0, 0, 0], "max": [1, 1, 0] }],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
            "nodes": [{ "mesh": 0 }, {}],
            "scenes": [{ "nodes": [0, 1] }],
        });
        change(&mut json);
        json.to_string()
    };
    let camera = |camera: Value| {
        move |json: &mut Value| {
            json["cameras"] = json!([camera]);
            json["nodes"][1]["camera"] = json!(0);
        }
    };
    let lamp = |(root, node): (Value, Value), scale: [f32; 3]| {
        move |json: &mut Value| {
            json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
            json["extensions"]["KHR_lights_punctual"] = root.clone();
            json["nodes"][1]["extensions"] = node.clone();
            json["nodes"][1]["scale"] = json!(scale);
        }
    };
    let perspective =
        |yfov: f32| json!({ "type": "perspective", "perspective": { "yfov": yfov, "znear": 0.1 } });
    for (text, expected) in [
        (file(&camera(perspective(0.0))), "fields of view outside 0 to π"),
        (file(&camera(perspective(4.0))), "fields of view outside 0 to π"),
        (
            file(&camera(json!({ "type": "orthographic", "perspective": { "yfov": 1, "znear": 1 } }))),
            "left out",
        ),
        (file(&lamp(light(json!({ "type": "point", "intensity": -5 })), [1.0; 3])), "negative intensity"),
        (
            file(&lamp(light(json!({ "type": "directional" })), [1.0, 1.0, 0.0])),
            "loses their place or direction: left out",
        ),
    ] {
        let (scene, message, _) = repair("a.gltf", &text);
        assert!(message.contains(expected), "{text}: {message}");
        assert!(scene.emitters().is_empty());
        for camera in scene.cameras() {
            let Projection::Perspective { vertical_fov } = camera.projection else { panic!() };
            assert!(vertical_fov > 0.0 && vertical_fov < std::f32::consts::PI);
        }
    }
}

/// Encodes bytes in base64 (RFC 4648).
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in bytes.chunks(3) {
        let bits = three.iter().fold(0_u32, |all, &b| all << 8 | u32::from(b)) << (8 * (3 - three.len()));
        for place in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * place) & 63) as usize];
            text.push(if place <= three.len() { char::from(letter) } else { '=' });
        }
    }
    text
}
