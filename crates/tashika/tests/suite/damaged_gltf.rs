//! Damaged and hostile glTF files. Loading gives an error that names the fault and its place, or a
//! scene with a note. It never panics, and never takes more memory than the size of the file
//! justifies.
//!
//! A mutated file may still be valid, so the mutation tests only require that loading returns. They
//! do not prove that no other bytes cause a panic.

use serde_json::{Value, json};
use tashika::error::{Error, Result};
use tashika::io::LoadOptions;
use tashika::scene::{NoteKind, Scene, Surface};

use super::gltf::{CORNERS, Document, glb, load, load_in, notes, only_note, png, write};

use crate::cases::lenient;

/// A file that uses every feature that the loader reads.
fn rich() -> Document {
    let mut d = Document::triangle();
    d.add_uvs("TEXCOORD_0");
    let normals = d.vec3(&[[0.0, 0.0, 1.0]; 3]);
    d.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    let texture = d.add_texture([[255, 128, 0, 100], [0, 0, 255, 255]]);
    let sampler = d.push("samplers", json!({ "wrapS": 33071 }));
    d.json["textures"][texture]["sampler"] = json!(sampler);
    let (indices, values) = (d.view(&[1]), d.view(&[0; 12]));
    d.json["accessors"][0]["sparse"] = json!({
        "count": 1, "indices": { "bufferView": indices, "componentType": 5121 }, "values": { "bufferView": values },
    });
    let transform = json!({ "offset": [0.5, 0.25], "rotation": 1.0, "scale": [2, 2], "texCoord": 0 });
    d.json["materials"][0] = json!({
        "name": "m", "alphaMode": "MASK", "alphaCutoff": 0.5, "doubleSided": true, "emissiveFactor": [1, 0.5, 0],
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 0.5, 0.5, 0.5], "metallicFactor": 0.25, "roughnessFactor": 0.75,
            "baseColorTexture": { "index": texture, "extensions": { "KHR_texture_transform": transform } },
            "metallicRoughnessTexture": { "index": texture },
        },
        "extensions": {
            "KHR_materials_emissive_strength": { "emissiveStrength": 4 },
            "KHR_materials_ior": { "ior": 1.4 },
            "KHR_materials_specular": { "specularFactor": 0.5, "specularColorFactor": [1, 1, 1] },
            "KHR_materials_transmission": { "transmissionFactor": 0.25, "transmissionTexture": { "index": texture } },
            "KHR_materials_volume": { "thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [1, 0.5, 0] },
            "KHR_materials_clearcoat": { "clearcoatFactor": 0.5, "clearcoatTexture": { "index": texture } },
            "KHR_materials_anisotropy": { "anisotropyStrength": 0.5 },
            "KHR_materials_diffuse_transmission": { "diffuseTransmissionFactor": 0.5 },
        },
        "normalTexture": { "index": texture, "scale": 2, "extensions": { "KHR_texture_transform": { "scale": [2, 2] } } },
    });
    let glossy = json!({ "glossinessFactor": 0.5, "specularFactor": [0.5, 0.5, 0.5], "specularGlossinessTexture": { "index": texture } });
    d.push("materials", json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": glossy } }));
    let joints = d.view(&[0, 1, 0, 0].repeat(3));
    let joints = d.push(
        "accessors",
        json!({ "bufferView": joints, "componentType": 5121, "count": 3, "type": "VEC4" }),
    );
    let weights = d.view(&[200, 55, 0, 0].repeat(3));
    let weights = d.push(
        "accessors",
        json!({ "bufferView": weights, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC4" }),
    );
    let unit: Vec<u8> = (0..16).flat_map(|k| f32::from(u8::from(k % 5 == 0)).to_le_bytes()).collect();
    let binds = d.view(&unit.repeat(2));
    let binds = d
        .push("accessors", json!({ "bufferView": binds, "componentType": 5126, "count": 2, "type": "MAT4" }));
    d.push("skins", json!({ "joints": [1, 2], "inverseBindMatrices": binds, "skeleton": 1 }));
    let second = json!({
        "attributes": {
            "POSITION": 0, "NORMAL": normals, "TEXCOORD_0": 2, "COLOR_0": normals,
            "JOINTS_0": joints, "WEIGHTS_0": weights,
        },
        "targets": [{ "POSITION": normals, "NORMAL": normals }, { "POSITION": 0 }], "material": 1,
    });
    d.push("meshes", json!({ "primitives": [second], "weights": [0.5, 0.25] }));
    d.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 0.75, "znear": 0.1 } }]);
    d.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "spot", "intensity": 2, "range": 9, "spot": { "innerConeAngle": 0.25, "outerConeAngle": 0.5 } },
    ] } });
    d.json["nodes"] = json!([
        { "mesh": 0, "rotation": [0, 0, 0, 1], "scale": [1, 2, 3] },
        { "camera": 0, "children": [0], "translation": [0, 0, 4] },
        { "extensions": { "KHR_lights_punctual": { "light": 0 } }, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] },
    ]);
    d.push("nodes", json!({ "mesh": 1, "skin": 0, "weights": [0.5, 1.0], "camera": 1, "extensions": { "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": normals } } } }));
    d.push(
        "cameras",
        json!({ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "znear": 0.1, "zfar": 9 } }),
    );
    let bytes = |numbers: &[f32]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    let number = |view, count, kind| json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind });
    let (times, turns_view) = (d.view(&bytes(&[0.0, 1.0])), d.view(&bytes(&[0.5; 24])));
    let times = d.push("accessors", number(times, 2, "SCALAR"));
    let turns = d.push("accessors", number(turns_view, 6, "VEC4"));
    let places = d.push("accessors", number(turns_view, 2, "VEC3"));
    let amounts = d.view(&bytes(&[0.0, 0.25, 0.5, 1.0]));
    let amounts = d.push("accessors", number(amounts, 4, "SCALAR"));
    d.json["animations"] = json!([{
        "channels": [
            { "sampler": 0, "target": { "node": 1, "path": "rotation" } },
            { "sampler": 1, "target": { "node": 0, "path": "translation" } },
            { "sampler": 1, "target": { "node": 0, "path": "scale" } },
            { "sampler": 2, "target": { "node": 3, "path": "weights" } },
        ],
        "samplers": [
            { "input": times, "output": turns, "interpolation": "CUBICSPLINE" },
            { "input": times, "output": places },
            { "input": times, "output": amounts },
        ],
    }]);
    d.json["scenes"] = json!([{ "nodes": [1, 2, 3] }]);
    d.json["scene"] = json!(0);
    d.json["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_materials_iridescence"]);
    d
}

/// Options that read animations, too.
fn moving() -> LoadOptions {
    LoadOptions { at: Some(0.5), ..LoadOptions::default() }
}

/// Options that read shapes at both ends of the shutter's time.
fn exposed() -> LoadOptions {
    LoadOptions { shutter: Some([-0.25, 0.25]), ..moving() }
}

/// Returns the opaque surface of the first mesh, below all of its layers.
fn opaque(scene: &Scene) -> Surface {
    let mut material = scene.meshes()[0].material;
    loop {
        material = match scene.materials()[material.index()].surface {
            Surface::Mix { first, second, .. } => {
                // A surface with a weaker reflection is read as a mix: with the same surface
                // without reflection.
                let is_below = matches!(scene.materials()[first.index()].surface, Surface::Lambert { .. });
                if is_below { second } else { first }
            }
            Surface::Sheen { base, .. } | Surface::Clearcoat { base, .. } => base,
            surface => return surface,
        }
    }
}

/// The rich document with one value replaced.
fn with(path: &str, value: Value) -> Document {
    let mut d = rich();
    let place = d.json.pointer_mut(path).unwrap_or_else(|| panic!("{path}"));
    *place = value;
    d
}

/// The message of an error of kind `Invalid`.
#[track_caller]
fn invalid(result: Result<Scene>) -> String {
    match result {
        Err(error @ Error::Invalid { .. }) => error.to_string(),
        other => panic!("{other:?}"),
    }
}

/// Pseudorandom numbers; the same in every run.
struct Numbers(u64);

impl Numbers {
    /// Returns a number from 0 to `n` − 1.
    fn below(&mut self, n: usize) -> usize {
        // Steele, Lea, Flood. "Fast Splittable Pseudorandom Number Generators." OOPSLA 2014.
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n as u64) as usize
    }
}

#[test]
fn the_undamaged_file_is_sound() {
    let folder = tempfile::tempdir().unwrap();
    let scene = load_in(folder.path(), "m.glb", &rich().glb(), &moving()).unwrap();
    assert_eq!(scene.time(), Some(0.5));
    // The second mesh has three instances. There is one image each for colours, numbers, red and
    // opacity.
    assert_eq!((scene.meshes().len(), scene.instances().len(), scene.images().len()), (2, 4, 4));
    assert_eq!((scene.cameras().len(), scene.emitters().len(), scene.area_emitters().count()), (2, 1, 1));
    let exposed = load_in(folder.path(), "m.glb", &rich().glb(), &exposed()).unwrap();
    assert!(exposed.meshes().iter().any(|mesh| mesh.deforms().is_some()));
    let material = &scene.materials()[scene.meshes()[0].material.index()];
    assert!(material.alpha.is_some() && material.normal.is_some());
    assert!(matches!(material.surface, Surface::Mix { .. }));
}

#[test]
fn truncated_at_every_length() {
    let whole = rich().glb();
    let folder = tempfile::tempdir().unwrap();
    for length in 0..whole.len() {
        let result = load_in(folder.path(), "t.glb", &whole[..length], &LoadOptions::default());
        let said = result.expect_err("the header promises more bytes than are there").to_string();
        // Files shorter than the signature have no known format.
        assert!(length < 4 || said.contains("truncated"), "{length} of {} bytes: {said}", whole.len());
        // If the length in the header is corrected, a chunk or the JSON is truncated.
        if length >= 12 {
            let mut corrected = whole[..length].to_vec();
            corrected[8..12].copy_from_slice(&(length as u32).to_le_bytes());
            assert!(
                load_in(folder.path(), "t.glb", &corrected, &LoadOptions::default()).is_err(),
                "{length}"
            );
        }
    }
    let text = rich().text();
    for length in 0..text.len() {
        assert!(
            load_in(folder.path(), "t.gltf", &text[..length], &LoadOptions::default()).is_err(),
            "{length}"
        );
    }
}

#[test]
fn mutated_bytes_do_not_panic() {
    let whole = rich().glb();
    let folder = tempfile::tempdir().unwrap();
    let mut numbers = Numbers(1);
    let mut errors = 0;
    for round in 0..4000 {
        let mut mutated = whole.clone();
        for _ in 0..=numbers.below(4) {
            let place = numbers.below(mutated.len());
            mutated[place] = match numbers.below(3) {
                0 => mutated[place] ^ (1 << numbers.below(8)),
                1 => numbers.below(256) as u8,
                _ => b"0123456789-{}[]\",:"[numbers.below(18)],
            };
        }
        let options = if round % 2 == 0 { moving() } else { exposed() };
        errors += usize::from(load_in(folder.path(), "m.glb", &mutated, &options).is_err());
    }
    assert!((400..3990).contains(&errors), "{errors}: the mutations are neither harmless nor all fatal");
}

#[test]
fn mutated_values_do_not_panic() {
    let mut document = rich();
    document.json["buffers"][0]["byteLength"] = json!(document.buffer.len());
    let folder = tempfile::tempdir().unwrap();
    let mut numbers = Numbers(2);
    let mut errors = 0;
    for _ in 0..4000 {
        let mut d = document.clone();
        for _ in 0..=numbers.below(2) {
            mutate(&mut d.json, &mut numbers);
        }
        let bytes = glb(&serde_json::to_vec(&d.json).unwrap(), &d.buffer);
        errors += usize::from(load_in(folder.path(), "m.glb", &bytes, &moving()).is_err());
    }
    assert!((400..3990).contains(&errors), "{errors}");
}

/// Replaces, removes or doubles one value somewhere.
fn mutate(value: &mut Value, numbers: &mut Numbers) {
    let go_down = numbers.below(8) != 0;
    match value {
        Value::Object(map) if !map.is_empty() && go_down => {
            let key = map.keys().nth(numbers.below(map.len())).unwrap().clone();
            if numbers.below(12) == 0 {
                map.remove(&key);
            } else {
                mutate(&mut map[&key], numbers);
            }
        }
        Value::Array(items) if !items.is_empty() && go_down => {
            let index = numbers.below(items.len());
            match numbers.below(12) {
                0 => drop(items.remove(index)),
                1 => items.push(items[index].clone()),
                _ => mutate(&mut items[index], numbers),
            }
        }
        leaf => {
            let hostile = [
                json!(0),
                json!(1),
                json!(2),
                json!(5123),
                json!(5126),
                json!(-1),
                json!(255),
                json!(u32::MAX),
                json!(1_u64 << 32),
                json!(u64::MAX),
                json!(i64::MIN),
                json!(1e300),
                json!(-1e-300),
                json!(4_000_000_000_u32),
                json!(null),
                json!(""),
                json!("VEC3"),
                json!([]),
                json!({}),
                json!(true),
            ];
            *leaf = hostile[numbers.below(hostile.len())].clone();
        }
    }
}

#[test]
fn mutated_images_do_not_panic() {
    let picture = image::DynamicImage::from(image::RgbaImage::from_fn(5, 4, |x, y| {
        image::Rgba([x as u8, y as u8, 9, 200])
    }));
    let folder = tempfile::tempdir().unwrap();
    let mut numbers = Numbers(3);
    for format in ["png", "jpg", "bmp", "tiff", "tga", "hdr"] {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let picture = match format {
            "jpg" => image::DynamicImage::from(picture.to_rgb8()),
            "hdr" => image::DynamicImage::from(picture.to_rgb32f()),
            _ => picture.clone(),
        };
        picture.write_to(&mut bytes, image::ImageFormat::from_extension(format).unwrap()).unwrap();
        let bytes = bytes.into_inner();
        let mut d = rich();
        d.json["images"][0] = json!({ "uri": format!("i.{format}") });
        let text = d.glb();
        for round in 0..300 {
            let mut mutated = bytes.clone();
            if round > 0 {
                mutated.truncate(1 + numbers.below(2 * bytes.len()));
                for _ in 0..numbers.below(6) {
                    let place = numbers.below(mutated.len());
                    mutated[place] = numbers.below(256) as u8;
                }
            }
            write(&folder.path().join(format!("i.{format}")), &mutated);
            let options = LoadOptions { max_image_texels: 1 << 20, ..LoadOptions::default() };
            let scene = load_in(folder.path(), "m.glb", &text, &options).unwrap();
            assert!(round > 0 || scene.images().len() == 4, "{format} is decoded");
        }
    }
}

#[test]
fn indices_out_of_range_name_their_place_and_value() {
    for (path, item) in [
        ("/meshes/0/primitives/0/attributes/POSITION", "meshes[0].primitives[0].attributes.POSITION"),
        ("/meshes/0/primitives/0/attributes/NORMAL", "meshes[0].primitives[0].attributes[\"NORMAL\"]"),
        ("/meshes/0/primitives/0/indices", "meshes[0].primitives[0].indices"),
        ("/meshes/0/primitives/0/material", "meshes[0].primitives[0].material"),
        ("/nodes/0/mesh", "nodes[0].mesh"),
        ("/nodes/1/camera", "nodes[1].camera"),
        ("/nodes/1/children/0", "nodes[1].children[0]"),
        ("/scenes/0/nodes/0", "scenes[0].nodes[0]"),
        ("/scene", "scene"),
        ("/accessors/0/bufferView", "accessors[0].bufferView"),
        ("/accessors/0/sparse/indices/bufferView", "accessors[0].sparse.indices.bufferView"),
        ("/bufferViews/0/buffer", "bufferViews[0].buffer"),
        ("/textures/0/sampler", "textures[0].sampler"),
        ("/images/0/bufferView", "images[0].bufferView"),
        ("/materials/0/pbrMetallicRoughness/baseColorTexture/index", "baseColorTexture.index"),
    ] {
        let text = invalid(with(path, json!(99)).load());
        assert!(text.contains(item) && text.contains("99"), "{path}: {text}");
        assert!(with(path, json!(4_294_967_294_u32)).load().is_err(), "{path}");
    }
    assert!(with("/nodes/2/extensions/KHR_lights_punctual/light", json!(99)).load().is_err());
    let text = invalid(with("/accessors/0/type", json!("VEC2")).load());
    assert!(text.contains("attributes.POSITION: accessors[0] of type Vec2; expected Vec3"), "{text}");
}

#[test]
fn vertex_indices_out_of_range_are_refused() {
    let mut d = Document::triangle();
    let offset = d.json["bufferViews"][1]["byteOffset"].as_u64().unwrap() as usize;
    d.buffer[offset + 1] = 3;
    let text = invalid(d.load());
    assert!(
        text.ends_with("meshes[0].primitives[0].indices: vertex index 3; expected an index below 3"),
        "{text}"
    );
    d.json["accessors"][1]["componentType"] = json!(5120);
    assert!(invalid(d.load()).contains("indices of type I8"));
    let mut d = rich();
    let sparse = d.json["accessors"][0]["sparse"]["indices"]["bufferView"].as_u64().unwrap() as usize;
    let offset = d.json["bufferViews"][sparse]["byteOffset"].as_u64().unwrap() as usize;
    d.buffer[offset] = 3;
    assert!(invalid(d.load()).contains("attributes.POSITION: sparse index 3"));
    let text = invalid(with("/accessors/3/count", json!(2)).load());
    assert!(text.contains("attributes.NORMAL: 2 elements; expected 3, one for each POSITION"), "{text}");
}

#[test]
fn counts_beyond_the_bytes_present_are_refused() {
    for count in [4, 4_000_000_000_u64, u64::MAX] {
        let text = invalid(with("/accessors/0/count", json!(count)).load());
        assert!(text.contains("attributes.POSITION") && text.contains(&count.to_string()), "{text}");
        assert!(text.contains("the 36 bytes of their buffer view"), "{text}");
        assert!(with("/accessors/1/count", json!(count)).load().is_err(), "indices");
        assert!(with("/accessors/0/sparse/count", json!(count)).load().is_err(), "sparse");
    }
    for (path, value) in [
        ("/accessors/0/count", json!(4_000_000_000_u64)),
        ("/accessors/0/sparse/count", json!(u64::MAX)),
        ("/bufferViews/0/byteLength", json!(u64::MAX)),
        ("/bufferViews/0/byteLength", json!(4_000_000_000_u64)),
        ("/bufferViews/0/byteOffset", json!(u64::MAX)),
    ] {
        invalid(with(path, value).load());
    }
    let mut d = rich();
    d.json["accessors"][0]["byteOffset"] = json!(u64::MAX);
    invalid(d.load());
    d = rich();
    d.json["bufferViews"][0]["byteStride"] = json!(8);
    assert!(invalid(d.load()).contains("each 8 after the last"));
    // An accessor without a buffer view is all zeros and needs no bytes, so a file could claim any
    // number of elements.
    let mut d = rich();
    d.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    d.json["accessors"][0]["count"] = json!(4_000_000_000_u64);
    assert!(invalid(d.load()).contains("4000000000 elements without a buffer view; expected at most 65536"));
    // A buffer that claims more than the chunk holds.
    let mut json = rich().json;
    json["buffers"][0]["byteLength"] = json!(1_u64 << 40);
    let text = invalid(load(&glb(&serde_json::to_vec(&json).unwrap(), &rich().buffer)));
    assert!(text.contains("buffers[0]: byteLength = 1099511627776"), "{text}");
}

#[test]
fn naming_the_same_vertices_many_times_does_not_fill_the_memory() {
    let folder = tempfile::tempdir().unwrap();
    let options = LoadOptions { max_file_bytes: 1 << 20, ..LoadOptions::default() };
    let mut d = Document::empty();
    let corners: Vec<[f32; 3]> = CORNERS.iter().copied().cycle().take(3000).collect();
    let positions = d.vec3(&corners);
    let primitive = json!({ "attributes": { "POSITION": positions } });
    d.push("meshes", json!({ "primitives": vec![primitive.clone(); 1000] }));
    d.push("nodes", json!({ "mesh": 0 }));
    let text = invalid(load_in(folder.path(), "p.glb", &d.glb(), &options));
    assert!(text.contains("bytes of geometry; expected at most 1048576 bytes in the whole scene"), "{text}");
    assert!(text.contains("primitives[21]"), "48 kB each: {text}");

    d.json["meshes"][0]["primitives"] = json!(vec![primitive; 4]);
    d.json["nodes"] = json!(vec![json!({ "mesh": 0 }); 10_000]);
    let text = invalid(load_in(folder.path(), "n.glb", &d.glb(), &options));
    assert!(text.contains("bytes of geometry"), "{text}");

    let mut d = Document::triangle();
    std::fs::write(folder.path().join("b.bin"), vec![0; 300_000]).unwrap();
    d.json["buffers"] = json!(vec![json!({ "byteLength": 300_000, "uri": "b.bin" }); 5]);
    d.json["accessors"][0]["sparse"] = json!({
        "count": 1, "indices": { "bufferView": 2, "componentType": 5121 }, "values": { "bufferView": 3 },
    });
    d.json["bufferViews"] = json!([0, 1, 2, 3].map(|b| json!({ "buffer": b, "byteLength": 300_000 })));
    let text = invalid(load_in(folder.path(), "b.gltf", &serde_json::to_vec(&d.json).unwrap(), &options));
    assert!(text.contains("buffers[1]") && text.contains("bytes of buffers"), "{text}");
}

#[test]
fn values_that_are_not_finite_are_repaired_or_refused() {
    let mut d = Document::triangle();
    let [a, b, _] = CORNERS;
    let positions = d.vec3(&[CORNERS, [a, b, [f32::NAN, 0.0, 0.0]], [a, b, b]].concat());
    d.json["meshes"][0]["primitives"] = json!([{ "attributes": { "POSITION": positions } }]);
    let scene = d.load().unwrap();
    assert_eq!(scene.meshes()[0].triangles(), [[0, 1, 2]]);
    let repaired: Vec<String> = notes(&scene).into_iter().map(|(_, message)| message).collect();
    assert_eq!(repaired, ["triangles with vertices that are not finite: left out"]);
    assert_eq!(scene.triangles_without_area(), 1);

    // JSON has no infinity, but it has numbers that are infinite in 32 bits.
    for (path, item) in [
        ("/materials/0/emissiveFactor/0", "materials[0].emissiveFactor"),
        ("/materials/0/pbrMetallicRoughness/roughnessFactor", "roughnessFactor"),
        ("/materials/0/alphaCutoff", "materials[0].alphaCutoff"),
        ("/extensions/KHR_lights_punctual/lights/0/intensity", "lights[0]"),
    ] {
        let text = invalid(with(path, json!(1e300)).load());
        assert!(text.contains(item), "{text}");
    }
    for (path, message) in [
        ("/nodes/0/scale/0", "transform that cannot be inverted"),
        ("/nodes/0/rotation/0", "rotations that are no quaternion"),
        ("/cameras/0/perspective/yfov", "fields of view outside 0 to π"),
        ("/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle", "brought into order"),
    ] {
        let scene = with(path, json!(1e300)).load().unwrap();
        let repaired = |(kind, m): &(NoteKind, String)| *kind == NoteKind::Repaired && m.contains(message);
        assert!(notes(&scene).iter().any(repaired), "{:?}", notes(&scene));
    }
    let scene = with("/materials/0/pbrMetallicRoughness/metallicFactor", json!(-3)).load().unwrap();
    assert!(notes(&scene).iter().any(|(k, m)| *k == NoteKind::Repaired && m.contains("out of range")));
    let Surface::MetallicRoughness { metallic, .. } = opaque(&scene) else { panic!() };
    assert_eq!(metallic.factor, 0.0);
    // Finite coordinates times a finite transform stay finite.
    let mut d = with(
        "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/scale",
        json!([1e6, 1e6]),
    );
    let offset = d.json["bufferViews"][2]["byteOffset"].as_u64().unwrap() as usize;
    d.buffer[offset..offset + 4].copy_from_slice(&f32::MAX.to_le_bytes());
    d.buffer[offset + 4..offset + 8].copy_from_slice(&f32::NAN.to_le_bytes());
    let scene = d.load().unwrap();
    let Surface::MetallicRoughness { base_color, .. } = opaque(&scene) else { panic!() };
    for &uv in scene.meshes()[0].uvs() {
        assert!(base_color.at(scene.textures(), uv).is_valid(), "{uv}");
    }
    let scene = with("/nodes/0/scale/0", json!(0)).load().unwrap();
    assert_eq!(scene.instances().len(), 3, "those of the other mesh");
}

#[test]
fn nodes_that_form_no_forest_are_refused() {
    let load = |nodes: Value, scenes: Value| {
        let mut d = Document::triangle();
        d.json["nodes"] = nodes;
        d.json["scenes"] = scenes;
        d.load()
    };
    let cycle = json!([{ "mesh": 0 }, { "children": [2] }, { "children": [1] }]);
    let text = invalid(load(cycle.clone(), json!([{ "nodes": [0] }])));
    assert!(text.contains("nodes[1]: a node on or below a cycle"), "{text}");
    invalid(load(cycle, json!([{ "nodes": [1] }])));
    invalid(load(json!([{ "children": [0] }]), json!([{ "nodes": [0] }])));
    let text =
        invalid(load(json!([{ "children": [1, 2] }, { "children": [2] }, {}]), json!([{ "nodes": [0] }])));
    assert!(text.contains("nodes[2]: a child of node 0 and again of node 1"), "{text}");
    invalid(load(json!([{ "children": [1, 1] }, {}]), json!([{ "nodes": [0] }])));
    let text = invalid(load(json!([{ "children": [1] }, { "mesh": 0 }]), json!([{ "nodes": [0, 1] }])));
    assert!(text.contains("scenes[0].nodes[1]: 1, a child of node 0"), "{text}");
    let text = invalid(load(json!([{ "mesh": 0 }]), json!([{ "nodes": [0, 0] }])));
    assert!(text.contains("scenes[0].nodes[1]: 0, listed before"), "{text}");
}

#[test]
fn a_deep_chain_of_nodes_is_no_problem() {
    const DEPTH: usize = 40_000;
    let mut d = Document::triangle();
    let step = |i: usize| json!({ "children": [i + 1], "translation": [0.0009765625, 0, 0] });
    let mut nodes: Vec<Value> = (0..DEPTH).map(step).collect();
    nodes.push(json!({ "mesh": 0 }));
    d.json["nodes"] = json!(nodes);
    let scene = d.load().unwrap();
    assert_eq!(scene.instances()[0].to_world.translation.x, DEPTH as f32 / 1024.0);
}

#[test]
fn deep_json_is_refused_or_skipped() {
    const DEPTH: usize = 100_000;
    let text = String::from_utf8(rich().text()).unwrap();
    let buffer = rich().buffer;
    let load = |text: &str| load(&glb(text.as_bytes(), &buffer));
    let lists = format!("{}{}", "[".repeat(DEPTH), "]".repeat(DEPTH));
    let objects = format!("{}0{}", "{\"a\":".repeat(DEPTH), "}".repeat(DEPTH));
    for nested in [lists, objects] {
        assert!(load(&nested).is_err());
        assert!(load(&nested[..DEPTH]).is_err(), "never closed");
        let first = |field: &str| format!("{{\"{field}\":{nested},{}", &text[1..]);
        assert!(load(&first("nobody-knows")).is_ok() && load(&first("extras")).is_ok(), "skipped");
        for field in ["asset", "nodes", "extensions", "scene"] {
            assert!(load(&first(field)).is_err(), "{field}");
        }
        let after = |item: &str, field: &str| text.replacen(item, &format!("{item},\"{field}\":{nested}"), 1);
        assert!(load(&after("\"mesh\":0", "extras")).is_ok(), "skipped");
        assert!(load(&after("\"mesh\":0", "extensions")).is_err());
        assert!(load(&after("\"count\":3", "min")).is_err());
    }
}

#[test]
fn bytes_that_are_no_gltf_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let load = |name: &str, bytes: &[u8]| load_in(folder.path(), name, bytes, &LoadOptions::default());
    for bytes in [
        b"".as_slice(),
        b"glTF",
        b"glTF\x02\0\0\0\x0c\0\0\0",
        b"glTF\x02\0\0\0\0\0\0\0",
        b"glTF\x02\0\0\0\xff\xff\xff\xff",
        b"glTF\x02\0\0\0\x14\0\0\0\xff\xff\xff\xffJSON",
        b"glTF\x02\0\0\0\x14\0\0\0\0\0\0\0BIN\0",
        b"{\"asset\":{\"version\":\"2.0\xff\"}}",
        b"{}",
        b"null",
        b"\xff\xfe{\0}\0",
        b"v 0 0 0\nf 1 1 1\n",
    ] {
        for name in ["b.glb", "b.gltf"] {
            assert!(load(name, bytes).is_err(), "{bytes:?}");
        }
    }
    assert!(matches!(load("b.glb", b"glTF\x01\0\0\0\x14\0\0\0"), Err(Error::Unsupported { .. })));
    let text = invalid(load("b.gltf", b"{\n\"asset\": 3\n}"));
    assert!(text.contains("b.gltf:2: JSON that is no glTF"), "{text}");
    // The smallest valid files.
    assert!(load("b.gltf", b"{\"asset\":{\"version\":\"2.0\"}}").is_ok());
    let scene = load("b.glb", &glb(b"{\"asset\":{\"version\":\"2.0\"}}", b"")).unwrap();
    assert_eq!(scene.instanced_triangles(), 0);
}

#[test]
fn a_buffer_that_is_missing_or_short_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let mut d = Document::triangle();
    d.json["buffers"][0]["uri"] = json!("gone.bin");
    let load = |d: &Document| load_in(folder.path(), "s.gltf", &d.text(), &LoadOptions::default());
    let error = load(&d).unwrap_err();
    assert!(matches!(error, Error::Io { .. }), "{error}");
    assert!(error.to_string().contains("gone.bin") && error.to_string().contains("buffers[0]"), "{error}");
    std::fs::write(folder.path().join("gone.bin"), &d.buffer[1..]).unwrap();
    assert!(invalid(load(&d)).contains("the bytes that are there"));
    d.json["buffers"][0]["uri"] = json!("data:;base64,!!!!");
    assert!(invalid(load(&d)).contains("buffers[0]: a data: URI with damaged base64"));
    d.json["buffers"][0].as_object_mut().unwrap().remove("uri");
    assert!(invalid(load(&d)).contains("buffers[0]: no uri"));
    // A buffer that nothing refers to may be missing.
    let mut d = Document::triangle();
    d.push("buffers", json!({ "byteLength": 8, "uri": "nobody-needs-it.bin" }));
    assert!(d.load().is_ok());
}

#[test]
fn a_texture_that_cannot_be_read_is_left_out() {
    for (image, why) in [
        (json!({ "uri": "gone.png" }), "image \"gone.png\" could not be read (no such file)"),
        (json!({ "uri": "data:image/png;base64,AAAA" }), "unknown format"),
        (json!({ "uri": "https://example.org/a.png" }), "not supported"),
        (json!({}), "neither uri nor bufferView"),
        (json!({ "bufferView": 0, "name": "corners" }), "image \"corners\" could not be read"),
    ] {
        let mut d = rich();
        d.json["images"][0] = image;
        d.json["materials"][0]["emissiveTexture"] = json!({ "index": 0 });
        let scene = d.load().unwrap();
        let found = notes(&scene);
        let kind = if why.contains("gone") { NoteKind::Missing } else { NoteKind::Repaired };
        assert!(found.iter().any(|(k, m)| *k == kind && m.contains(why)), "{found:?}");
        let material = &scene.materials()[scene.meshes()[0].material.index()];
        assert!(material.alpha.is_none(), "opaque");
        assert!(material.emission.is_some_and(|e| e.radiance.texture.is_none()));
        let Surface::MetallicRoughness { base_color, roughness, .. } = opaque(&scene) else { panic!() };
        assert!(base_color.texture.is_none() && roughness.texture.is_none());
        assert!(scene.images().is_empty());
    }
    let mut without = rich();
    without.json["textures"][0].as_object_mut().unwrap().remove("source");
    for d in [without, with("/textures/0/source", json!(99))] {
        let scene = d.load().unwrap();
        assert!(notes(&scene).iter().any(|(_, m)| m.contains("without an image")), "{:?}", notes(&scene));
    }
}

#[test]
fn an_image_that_claims_to_be_huge_is_refused() {
    let mut bytes = png([[255; 4]; 2]);
    // Signature, length, "IHDR", then width and height, big-endian; the checksum of type and data
    // follows.
    for place in [16, 20] {
        bytes[place..place + 4].copy_from_slice(&60_000_u32.to_be_bytes());
    }
    let checksum = !bytes[12..29].iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 == 1 { c >> 1 ^ 0xedb8_8320 } else { c >> 1 })
    });
    bytes[29..33].copy_from_slice(&checksum.to_be_bytes());
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bomb.png"), bytes).unwrap();
    let mut d = Document::triangle();
    d.push("images", json!({ "uri": "bomb.png" }));
    d.push("textures", json!({ "source": 0 }));
    d.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
    let scene = load_in(folder.path(), "s.glb", &d.glb(), &lenient()).unwrap();
    assert!(only_note(&scene, NoteKind::Repaired, "60000×60000 texels"), "{:?}", notes(&scene));
}

#[test]
fn references_out_of_the_folder_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("scene");
    std::fs::create_dir(&inside).unwrap();
    let mut d = Document::triangle();
    let secret = folder.path().join("secret.bin");
    std::fs::write(&secret, &d.buffer).unwrap();
    let mut references =
        vec!["../secret.bin", "%2E%2E/secret.bin", "..\\secret.bin", secret.to_str().unwrap()];
    if cfg!(unix) {
        #[cfg(unix)]
        std::os::unix::fs::symlink(&secret, inside.join("link.bin")).unwrap();
        references.push("link.bin");
    }
    for reference in references {
        d.json["buffers"][0]["uri"] = json!(reference);
        let error = load_in(&inside, "s.gltf", &d.text(), &LoadOptions::default()).unwrap_err();
        let text = error.to_string();
        assert!(matches!(error, Error::Outside { .. }), "{text}");
        assert!(text.contains("buffers[0]") && text.contains("allow-outside"), "{text}");
        let free = LoadOptions { allow_outside: true, ..LoadOptions::default() };
        assert!(load_in(&inside, "s.gltf", &d.text(), &free).is_ok(), "{reference}");
    }
    // An image outside the folder is not read either; it counts as missing.
    let mut d = rich();
    std::fs::write(folder.path().join("secret.png"), png([[255; 4]; 2])).unwrap();
    d.json["images"][0] = json!({ "uri": "../secret.png" });
    let error = load_in(&inside, "s.glb", &d.glb(), &LoadOptions::default()).unwrap_err();
    assert!(matches!(error, Error::Missing { .. }) && error.to_string().contains("allow-outside"), "{error}");
    let scene = load_in(&inside, "s.glb", &d.glb(), &lenient()).unwrap();
    assert!(scene.images().is_empty());
    assert!(notes(&scene).iter().any(|(_, m)| m.contains("allow-outside")));
}
