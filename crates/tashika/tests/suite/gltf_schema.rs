//! Properties and extensions of glTF files that no schema has.

use std::fs;

use serde_json::{Value, json};
use tashika::error::{Error, Result};
use tashika::io::load_scene;
use tashika::scene::{NoteKind, Scene};

use crate::cases::lenient;

fn load(json: &Value) -> Result<Scene> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    fs::write(&path, json.to_string()).unwrap();
    load_scene(&path, &lenient())
}

/// Returns a file with an object of every type at the pointers of [`PLACES`].
fn file() -> Value {
    let info = || json!({ "index": 0, "extensions": { "KHR_texture_transform": { "scale": [1, 1] } } });
    json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_clearcoat", "KHR_texture_transform"],
        "buffers": [{ "byteLength": 36, "uri": format!("data:application/octet-stream;base64,{}", "A".repeat(48)) }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "sparse": { "count": 1, "indices": { "bufferView": 0, "componentType": 5125 },
                "values": { "bufferView": 0 } } }],
        "animations": [{ "channels": [{ "sampler": 0, "target": { "node": 0, "path": "scale" } }],
            "samplers": [{ "input": 0, "output": 0 }] }],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 1.0, "znear": 0.1 } },
            { "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "zfar": 2, "znear": 0.1 } }],
        "images": [{ "uri": "a.png" }],
        "samplers": [{ "wrapS": 10497 }],
        "textures": [{ "source": 0, "sampler": 0 }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": info() }, "normalTexture": { "index": 0 },
            "occlusionTexture": { "index": 0 },
            "extensions": { "KHR_materials_clearcoat": { "clearcoatFactor": 1.0 } } }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
        "skins": [{ "joints": [0] }],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "spot", "spot": { "outerConeAngle": 0.5 } }] } },
        "nodes": [{ "mesh": 0, "extensions": { "KHR_lights_punctual": { "light": 0 } } }],
        "scenes": [{ "nodes": [0] }],
    })
}

/// Pointers to the objects, with the paths that notes have for them.
const PLACES: &[(&str, &str)] = &[
    ("", ""),
    ("/asset", "asset."),
    ("/buffers/0", "buffers[0]."),
    ("/bufferViews/0", "bufferViews[0]."),
    ("/accessors/0", "accessors[0]."),
    ("/accessors/0/sparse", "accessors[0].sparse."),
    ("/accessors/0/sparse/indices", "accessors[0].sparse.indices."),
    ("/accessors/0/sparse/values", "accessors[0].sparse.values."),
    ("/animations/0", "animations[0]."),
    ("/animations/0/channels/0", "animations[0].channels[0]."),
    ("/animations/0/channels/0/target", "animations[0].channels[0].target."),
    ("/animations/0/samplers/0", "animations[0].samplers[0]."),
    ("/cameras/0", "cameras[0]."),
    ("/cameras/0/perspective", "cameras[0].perspective."),
    ("/cameras/1/orthographic", "cameras[1].orthographic."),
    ("/images/0", "images[0]."),
    ("/samplers/0", "samplers[0]."),
    ("/textures/0", "textures[0]."),
    ("/materials/0", "materials[0]."),
    ("/materials/0/pbrMetallicRoughness", "materials[0].pbrMetallicRoughness."),
    (
        "/materials/0/pbrMetallicRoughness/baseColorTexture",
        "materials[0].pbrMetallicRoughness.baseColorTexture.",
    ),
    (
        "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform",
        "materials[0].pbrMetallicRoughness.baseColorTexture.extensions.KHR_texture_transform.",
    ),
    ("/materials/0/normalTexture", "materials[0].normalTexture."),
    ("/materials/0/occlusionTexture", "materials[0].occlusionTexture."),
    ("/materials/0/extensions/KHR_materials_clearcoat", "materials[0].extensions.KHR_materials_clearcoat."),
    ("/meshes/0", "meshes[0]."),
    ("/meshes/0/primitives/0", "meshes[0].primitives[0]."),
    ("/skins/0", "skins[0]."),
    ("/extensions/KHR_lights_punctual", "extensions.KHR_lights_punctual."),
    ("/extensions/KHR_lights_punctual/lights/0", "extensions.KHR_lights_punctual.lights[0]."),
    ("/extensions/KHR_lights_punctual/lights/0/spot", "extensions.KHR_lights_punctual.lights[0].spot."),
    ("/nodes/0", "nodes[0]."),
    ("/nodes/0/extensions/KHR_lights_punctual", "nodes[0].extensions.KHR_lights_punctual."),
    ("/scenes/0", "scenes[0]."),
];

/// Returns messages, paths and counts of the notes on unknown names.
fn unknown(scene: &Scene) -> Vec<(String, Option<String>, u64)> {
    let notes =
        scene.notes().iter().filter(|n| n.kind == NoteKind::Ignored && n.message.contains("is unknown"));
    notes.map(|n| (n.message, n.first.item, n.count)).collect()
}

#[test]
fn a_property_that_its_object_does_not_have_is_noted_with_its_place() {
    assert_eq!(unknown(&load(&file()).unwrap()), []);
    for (pointer, place) in PLACES {
        let mut json = file();
        json.pointer_mut(pointer).unwrap()["quuxFlavour"] = json!(1);
        json.pointer_mut(pointer).unwrap()["extras"] = json!({ "anything": [1, { "at": "all" }] });
        let found = unknown(&load(&json).unwrap());
        let [(message, Some(item), 1)] = &found[..] else { panic!("{pointer}: {found:?}") };
        assert!(message.starts_with("property \"quuxFlavour\" of "), "{message}");
        assert_eq!(*item, format!("{place}quuxFlavour"));
    }
    // If a name occurs several times, the note has the place of the first.
    let mut json = file();
    json["nodes"] = json!([{ "mesh": 0, "quux": 1 }, { "quux": 2 }]);
    let found = unknown(&load(&json).unwrap());
    assert_eq!(
        found,
        [("property \"quux\" of node is unknown: left out".into(), Some("nodes[0].quux".into()), 2)]
    );
}

#[test]
fn an_extension_that_is_not_listed_is_noted_where_it_stands() {
    let mut json = file();
    json["materials"][0]["extensions"]["ACME_materials_velvet"] = json!({ "any": "thing" });
    let found = unknown(&load(&json).unwrap());
    let place = "materials[0].extensions.ACME_materials_velvet";
    assert_eq!(
        found,
        [("extension \"ACME_materials_velvet\" is unknown: left out".into(), Some(place.into()), 1)]
    );
    // An extension in `extensionsUsed` gives one note, with the place in that list.
    json["extensionsUsed"] = json!(["ACME_materials_velvet"]);
    assert_eq!(unknown(&load(&json).unwrap())[0].1.as_deref(), Some("extensionsUsed[0]"));
    assert_eq!(unknown(&load(&json).unwrap()).len(), 1);
}

#[test]
fn a_slip_is_refused_with_the_name_that_was_meant() {
    let refusal = |change: &dyn Fn(&mut Value)| {
        let mut json = file();
        change(&mut json);
        let error = load(&json).unwrap_err();
        assert!(matches!(error, Error::Invalid { .. }));
        error.to_string()
    };
    let said = refusal(&|json| json["materials"][0]["emisiveFactor"] = json!([1, 1, 1]));
    let expected = "a.gltf: materials[0].emisiveFactor: property of material \"emisiveFactor\"; expected a known name: did you mean \"emissiveFactor\"?";
    assert!(said.ends_with(expected), "{said}");
    let said = refusal(&|json| json["materials"][0]["extensions"]["KHR_material_ior"] = json!({}));
    assert!(said.contains("did you mean \"KHR_materials_ior\"?"), "{said}");
    // A property of another type of object is not taken for a slip.
    let mut json = file();
    json["nodes"][0]["nodes"] = json!([]);
    assert_eq!(unknown(&load(&json).unwrap()).len(), 1);
}

#[test]
fn values_of_other_types_are_no_panic() {
    for value in [json!(null), json!(1), json!("x"), json!([1, [2]]), json!({ "a": { "b": 1 } }), json!(true)]
    {
        for pointer in ["/materials/0/extensions/KHR_materials_clearcoat", "/extensions", "/animations"] {
            let mut json = file();
            *json.pointer_mut(pointer).unwrap() = value.clone();
            let _ = load(&json);
        }
    }
}
