//! Environments of glTF files (`EXT_lights_image_based`).

use serde_json::{Value, json};
use tashika::math::Vec3;
use tashika::scene::{NoteKind, Scene};

use super::gltf::{Document, notes, png};

/// Colours of the faces `+x −x +y −y +z −z`, made of 0 and 255. The last face has an opacity of a
/// fifth.
const FACES: [[u8; 4]; 6] = [
    [255, 0, 0, 255],
    [0, 255, 0, 255],
    [0, 0, 255, 255],
    [255, 255, 0, 255],
    [0, 255, 255, 255],
    [255, 255, 255, 51],
];

/// A triangle under a sky with these faces and the given fields.
pub fn under_sky(fields: Value) -> Document {
    let mut d = Document::triangle();
    let faces: Vec<usize> = FACES
        .iter()
        .map(|&color| {
            let view = d.view(&png([color; 2]));
            d.push("images", json!({ "bufferView": view, "mimeType": "image/png" }))
        })
        .collect();
    let mut light = json!({
        "specularImageSize": 2, "specularImages": [faces], "irradianceCoefficients": [],
    });
    light.as_object_mut().unwrap().extend(fields.as_object().unwrap().clone());
    d.json["extensions"] = json!({ "EXT_lights_image_based": { "lights": [light] } });
    let extensions = json!({ "EXT_lights_image_based": { "light": 0 } });
    d.json["scenes"] = json!([{ "nodes": [0], "extensions": extensions }]);
    d
}

/// The radiance from one direction.
fn radiance(scene: &Scene, d: [f32; 3]) -> [f32; 3] {
    scene.environment().unwrap().radiance(Vec3::from(d)).to_array()
}

/// Values of every type, which replace a value of a file.
pub fn junk() -> [Value; 9] {
    let huge = json!(u64::MAX);
    [json!(null), json!(true), json!(-1), json!(1e308), json!("x"), json!([]), json!({}), json!([[]]), huge]
}

const AXES: [[f32; 3]; 6] =
    [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];

#[test]
fn the_first_level_is_the_radiance_turned_and_scaled() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    // Expected radiance: the face's colour divided by its opacity; 51 is a fifth.
    let colors = FACES.map(|[r, g, b, a]| [r, g, b].map(|v| f32::from(v) / f32::from(a)));
    let scene = under_sky(json!({})).load().unwrap();
    assert!(notes(&scene).is_empty(), "{:?}", notes(&scene));
    let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5);
    for (axis, color) in AXES.into_iter().zip(colors) {
        assert!(near(radiance(&scene, axis), color), "{axis:?}: {:?}", radiance(&scene, axis));
    }
    // A quarter turn about +y takes the face at +z to +x.
    let turned = under_sky(json!({ "rotation": [0, half, 0, half], "intensity": 3 })).load().unwrap();
    for (axis, face) in [([1.0, 0.0, 0.0], 4), ([0.0, 0.0, -1.0], 0), ([0.0, 1.0, 0.0], 2)] {
        assert!(near(radiance(&turned, axis), colors[face].map(|v| 3.0 * v)), "{axis:?}");
    }
}

#[test]
fn only_the_scene_that_is_rendered_has_its_environment() {
    let mut d = under_sky(json!({}));
    d.json["scenes"].as_array_mut().unwrap().push(json!({ "nodes": [0] }));
    d.json["scene"] = json!(1);
    let scene = d.load().unwrap();
    assert!(!scene.has_light());
}

#[test]
fn environments_of_missing_or_damaged_faces_are_left_out_with_a_note() {
    for (image, kind, part) in [
        (json!({ "uri": "gone.png" }), NoteKind::Missing, "no such file"),
        (json!({ "bufferView": 0, "mimeType": "image/png" }), NoteKind::Repaired, "of unknown format"),
        (json!({}), NoteKind::Repaired, "neither uri nor bufferView"),
    ] {
        let mut d = under_sky(json!({}));
        d.json["images"][3] = image;
        let scene = d.load().unwrap();
        let told = notes(&scene);
        assert!(
            matches!(&told[..], [(k, m)] if *k == kind && m.contains("images[3]") && m.contains(part)),
            "{told:?}"
        );
        assert!(!scene.has_light());
    }
}

#[test]
fn environments_that_make_no_sense_are_refused_with_their_place() {
    for (fields, part) in [
        (json!({ "rotation": [0, 0, 0, 0] }), ".rotation: [0,0,0,0]"),
        (json!({ "rotation": [0, 0, 1] }), ".rotation: [0,0,1]"),
        (json!({ "rotation": [1e300, 0, 0, 0] }), ".rotation"),
        (json!({ "specularImages": [] }), ".specularImages: []"),
        (json!({ "specularImages": [[0, 1, 2, 3, 4]] }), "levels of six indices"),
        (json!({ "specularImages": [[0, 1, 2, 3, 4, 6]] }), "each of one of 6 images"),
        (json!({ "specularImages": null }), ".specularImages: null"),
    ] {
        let error = under_sky(fields).load().unwrap_err().to_string();
        assert!(error.contains("lights[0]") && error.contains(part), "{error}: {part}");
    }
    let mut d = under_sky(json!({}));
    d.json["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = json!(1);
    let error = d.load().unwrap_err().to_string();
    assert!(error.contains("scenes[0].extensions.EXT_lights_image_based.light: 1"), "{error}");
}

#[test]
fn no_value_in_place_of_another_does_harm() {
    let lights = "/extensions/EXT_lights_image_based";
    for place in
        ["", "/lights", "/lights/0", "/lights/0/intensity", "/lights/0/rotation", "/lights/0/rotation/3"]
            .iter()
            .chain(&[
                "/lights/0/specularImages",
                "/lights/0/specularImages/0",
                "/lights/0/specularImages/0/5",
            ])
            .map(|place| format!("{lights}{place}"))
            .chain(["", "/light"].map(|place| format!("/scenes/0{lights}{place}")))
    {
        for value in junk() {
            let mut d = under_sky(json!({ "rotation": [0, 0, 0, 1], "intensity": 1 }));
            *d.json.pointer_mut(&place).unwrap() = value.clone();
            match d.load() {
                Ok(scene) => {
                    assert!(scene.environment().is_none_or(|e| e.mean().is_valid()), "{place}: {value}")
                }
                Err(error) => assert!(error.to_string().contains("EXT_lights"), "{place}: {value}: {error}"),
            }
        }
    }
}
