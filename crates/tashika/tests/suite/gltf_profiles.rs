//! IES lamps at the nodes of glTF files (`EXT_lights_ies`).

use base64::Engine as _;
use serde_json::{Value, json};
use tashika::error::Error;
use tashika::io::LoadOptions;
use tashika::math::Vec3;
use tashika::scene::{Emitter, NoteKind, Scene};

use super::gltf::{Document, notes};
use super::gltf_environment::junk;
use super::textures;

/// A lamp of 8 cd down and 1 cd up. Horizontally it has 1, 2, 3, 4 cd at `C` = 0°, 90°, 180°, 270°.
pub const IES: &str = "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 3 5 1 2 0 0 0\n1 1 60\n0 90 180\n0 90 180 270 360\n\
    8 1 1\n8 2 1\n8 3 1\n8 4 1\n8 1 1\n";

/// A triangle, and a second node with a lamp of this profile.
pub fn with_lamp(profile: Value, lamp: Value, node: Value) -> Document {
    let mut d = Document::triangle();
    d.json["extensions"] = json!({ "EXT_lights_ies": { "lights": [profile] } });
    let mut node = node;
    node["extensions"] = json!({ "EXT_lights_ies": lamp });
    d.push("nodes", node);
    d
}

/// A profile as a data URI.
pub fn embedded(text: &str) -> Value {
    let data = base64::prelude::BASE64_STANDARD.encode(text);
    json!({ "uri": format!("data:application/x-ies-lm-63;base64,{data}") })
}

/// Position of the only emitter, and its intensity in a direction.
fn lamp(scene: &Scene) -> (Vec3, impl Fn([f32; 3]) -> [f32; 3]) {
    let [Emitter::Image { position, intensity, beam, .. }] = *scene.emitters() else {
        panic!("{:?}", scene.emitters())
    };
    let map = &scene.intensity_maps()[beam.map as usize];
    (position, move |d: [f32; 3]| (intensity * map.relative(Vec3::from(d).normalize())).to_array())
}

/// Tolerance of the map. Its texels are half a degree and a degree wide, and intensities change by
/// up to 7 cd and 1 cd in 90°.
fn near(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 0.1)
}

#[test]
fn lamps_point_down_the_axis_of_their_node_and_turn_with_it() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    // A quarter turn about +x takes −z to +y and +y to +z.
    for (node, [down, up, c0, c90, c180, c270]) in [
        (
            json!({ "translation": [1, 2, 3] }),
            [[0, 0, -1], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]],
        ),
        (
            json!({ "translation": [1, 2, 3], "scale": [3, 0.5, 2], "rotation": [half, 0, 0, half] }),
            [[0, 1, 0], [0, -1, 0], [1, 0, 0], [0, 0, 1], [-1, 0, 0], [0, 0, -1]],
        ),
        // In a mirrored lamp, C increases in the opposite direction.
        (
            json!({ "matrix": [1, 0, 0, 0, 0, -2, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1] }),
            [[0, 0, -1], [0, 0, 1], [1, 0, 0], [0, -1, 0], [-1, 0, 0], [0, 1, 0]],
        ),
    ] {
        let scene = with_lamp(embedded(IES), json!({ "light": 0 }), node.clone()).load().unwrap();
        assert!(notes(&scene).is_empty(), "{:?}", notes(&scene));
        let (position, intensity) = lamp(&scene);
        assert_eq!(position, Vec3::new(1.0, 2.0, 3.0));
        for (direction, candela) in [(down, 8.0), (up, 1.0), (c0, 1.0), (c90, 2.0), (c180, 3.0), (c270, 4.0)]
        {
            let found = intensity(direction.map(|v: i8| f32::from(v)));
            assert!(near(found, [candela; 3]), "{node}: {direction:?} {found:?} {candela}");
        }
    }
}

#[test]
fn lamps_have_their_multiplier_and_colour_and_share_their_profile() {
    let tinted = json!({ "light": 0, "multiplier": 2, "color": [0.5, 1, 7] });
    let mut d = with_lamp(embedded(IES), tinted, json!({}));
    let scene = d.load().unwrap();
    let (_, intensity) = lamp(&scene);
    let found = intensity([0.0, 0.0, -1.0]);
    assert!(near(found, [8.0, 16.0, 16.0]), "colours end at 1: {found:?}");
    // The same profile in a view of the buffer, at two nodes.
    let view = d.view(IES.as_bytes());
    d.json["extensions"]["EXT_lights_ies"]["lights"][0] =
        json!({ "bufferView": view, "mimeType": "application/x-ies-lm-63" });
    d.push("nodes", json!({ "extensions": { "EXT_lights_ies": { "light": 0 } } }));
    let scene = d.load().unwrap();
    assert_eq!((scene.emitters().len(), notes(&scene).len()), (2, 0));
    let [a, b] = scene.intensity_maps() else { panic!() };
    assert!(std::ptr::eq(a.map(), b.map()), "one map");
}

#[test]
fn profiles_that_are_missing_or_damaged_are_noted_and_their_lamps_left_out() {
    let document = with_lamp(json!({ "uri": "lamp.ies" }), json!({ "light": 0 }), json!({}));
    let mut text = document.json.clone();
    // The node with the mesh is removed, because the mesh's buffer is not in this file.
    text["nodes"].as_array_mut().unwrap().remove(0);
    text["buffers"] = json!([]);
    for list in ["bufferViews", "accessors", "meshes"] {
        text[list] = json!([]);
    }
    let load = |files: &[(&str, &[u8])], options| textures::load("a.gltf", &text.to_string(), files, options);
    let strict = LoadOptions::default();
    let lenient = LoadOptions { allow_missing: true, ..LoadOptions::default() };
    assert_eq!(load(&[("lamp.ies", IES.as_bytes())], &strict).unwrap().emitters().len(), 1);
    let error = load(&[], &strict).unwrap_err();
    assert!(matches!(error, Error::Missing { .. }), "{error}");
    for (files, kind, part) in [
        (vec![], NoteKind::Missing, "no such file"),
        (vec![("lamp.ies", &IES.as_bytes()[..60])], NoteKind::Repaired, "the end of the file"),
        (vec![("lamp.ies", b"".as_slice())], NoteKind::Repaired, "no line TILT="),
    ] {
        let scene = load(&files, &lenient).unwrap();
        assert!(
            matches!(&notes(&scene)[..], [(k, m)] if *k == kind && m.starts_with("light profile 0") && m.contains(part)),
            "{:?}",
            notes(&scene)
        );
    }
    let dark = IES.replace("1 1000 1 3 5", "1 1000 0 3 5");
    let scene = with_lamp(embedded(&dark), json!({ "light": 0 }), json!({})).load().unwrap();
    assert!(scene.intensity_maps().is_empty());
}

#[test]
fn lamps_that_make_no_sense_are_refused_with_their_place() {
    for (lamp, node, part) in [
        (json!({}), json!({}), "nodes[1].extensions.EXT_lights_ies.light: nothing"),
        (json!({ "light": 1 }), json!({}), "the index of one of 1 light profiles"),
        (json!({ "light": -1 }), json!({}), "-1; expected the index"),
        (json!({ "light": "a" }), json!({}), "the index of one of 1"),
        (json!({ "light": 0, "multiplier": 1e300 }), json!({}), "finite numbers"),
        (json!({ "light": 0, "color": [1, 1] }), json!({}), ".color: [1,1]; expected three numbers"),
        (json!({ "light": 0, "color": [1, 1, null] }), json!({}), ".color: null"),
    ] {
        let error = with_lamp(embedded(IES), lamp, node).load().unwrap_err().to_string();
        assert!(error.contains(part), "{error}: {part}");
    }
    let flat = json!({ "scale": [1, 1, 0] });
    for (lamp, node, part) in [
        (json!({ "light": 0, "multiplier": -1 }), json!({}), "negative intensity or colour: 0"),
        (json!({ "light": 0 }), flat, "loses their place or direction: left out"),
    ] {
        let scene = with_lamp(embedded(IES), lamp, node).load().unwrap();
        assert!(notes(&scene)[0].1.contains(part) && scene.emitters().is_empty(), "{:?}", notes(&scene));
    }
    let scene = with_lamp(json!({ "bufferView": 99 }), json!({ "light": 0 }), json!({})).load().unwrap();
    assert!(notes(&scene)[0].1.contains("99; expected the index of one of"), "{:?}", notes(&scene));
    let scene = with_lamp(json!({}), json!({ "light": 0 }), json!({})).load().unwrap();
    assert!(notes(&scene)[0].1.contains("neither uri nor bufferView"), "{:?}", notes(&scene));
}

#[test]
fn no_value_in_place_of_another_does_harm() {
    for place in ["/extensions/EXT_lights_ies", "/extensions/EXT_lights_ies/lights"]
        .iter()
        .chain(&["/extensions/EXT_lights_ies/lights/0", "/extensions/EXT_lights_ies/lights/0/uri"])
        .chain(&["/nodes/1/extensions/EXT_lights_ies", "/nodes/1/extensions/EXT_lights_ies/light"])
        .chain(&["/nodes/1/extensions/EXT_lights_ies/multiplier", "/nodes/1/extensions/EXT_lights_ies/color"])
    {
        for value in junk() {
            let lamp = json!({ "light": 0, "multiplier": 1, "color": [1, 1, 1] });
            let mut d = with_lamp(embedded(IES), lamp, json!({}));
            *d.json.pointer_mut(place).unwrap() = value.clone();
            match d.load() {
                Ok(scene) => {
                    let sound =
                        |e: &Emitter| matches!(e, Emitter::Image { intensity, .. } if intensity.is_valid());
                    assert!(scene.emitters().iter().all(|e| sound(e) || scene.has_default_light()));
                }
                Err(error) => assert!(error.to_string().contains("EXT_lights"), "{place}: {value}: {error}"),
            }
        }
    }
}
