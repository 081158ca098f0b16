//! Accessors, nodes and cameras of glTF files: every component type, sparse attributes, instancing,
//! orthographic views.

use glam::{Vec2, Vec3};
use serde_json::{Value, json};
use tashika::error::Error;
use tashika::scene::{NoteKind, Projection, Scene};

use super::gltf::{CORNERS, Document, notes};

/// Little-endian bytes of numbers of a component type. Each element has `size` numbers and starts
/// at a multiple of four bytes.
fn packed(component: u32, size: usize, values: &[f64]) -> (Vec<u8>, usize) {
    let mut bytes = Vec::new();
    for element in values.chunks(size) {
        for &v in element {
            match component {
                5120 => bytes.extend((v as i8).to_le_bytes()),
                5121 => bytes.extend((v as u8).to_le_bytes()),
                5122 => bytes.extend((v as i16).to_le_bytes()),
                5123 => bytes.extend((v as u16).to_le_bytes()),
                5125 => bytes.extend((v as u32).to_le_bytes()),
                5126 => bytes.extend((v as f32).to_le_bytes()),
                _ => panic!("{component}"),
            }
        }
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    let stride = bytes.len() / (values.len() / size);
    (bytes, stride)
}

/// Adds an accessor of such numbers.
fn accessor(d: &mut Document, component: u32, kind: &str, values: &[f64], normalized: bool) -> usize {
    let size = if kind == "VEC2" { 2 } else { 3 };
    let (bytes, stride) = packed(component, size, values);
    let view = d.view(&bytes);
    d.json["bufferViews"][view]["byteStride"] = json!(stride);
    let count = values.len() / size;
    d.push(
        "accessors",
        json!({ "bufferView": view, "componentType": component, "normalized": normalized, "count": count, "type": kind }),
    )
}

/// The triangle with the given additional attributes, and a texture that needs coordinates.
fn with_attributes(mut d: Document, attributes: &[(&str, usize)]) -> Scene {
    for (name, index) in attributes {
        d.json["meshes"][0]["primitives"][0]["attributes"][*name] = json!(index);
    }
    let texture = d.add_texture([[255; 4]; 2]);
    d.json["materials"][0]["pbrMetallicRoughness"] = json!({ "baseColorTexture": { "index": texture } });
    d.load().unwrap()
}

#[test]
fn attributes_have_any_component_type() {
    let corners = [0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    for (component, one) in [(5120, 127.0), (5121, 255.0), (5122, 32767.0), (5123, 65535.0), (5126, 1.0)] {
        let normalized = component != 5126;
        let mut d = Document::triangle();
        let positions = accessor(&mut d, component, "VEC3", &corners, false);
        let normals = accessor(&mut d, component, "VEC3", &[0.0, 0.0, one].repeat(3), normalized);
        let uvs = accessor(&mut d, component, "VEC2", &[0.0, one, one, one, 0.0, 0.0], normalized);
        let attributes = [("POSITION", positions), ("NORMAL", normals), ("TEXCOORD_0", uvs)];
        let scene = with_attributes(d, &attributes);
        assert!(notes(&scene).is_empty(), "{component}: {:?}", notes(&scene));
        let mesh = &scene.meshes()[0];
        assert_eq!(mesh.positions(), CORNERS.map(Vec3::from_array), "{component}");
        assert_eq!(mesh.normals(), [Vec3::Z; 3], "{component}");
        assert_eq!(mesh.uvs(), [Vec2::Y, Vec2::ONE, Vec2::ZERO], "{component}");
    }
}

#[test]
fn sparse_accessors_work_for_every_attribute_and_for_indices() {
    let mut d = Document::triangle();
    let sparse = |d: &mut Document, of: usize, element: &[u8]| {
        let (indices, values) = (d.view(&1_u32.to_le_bytes()), d.view(element));
        d.json["accessors"][of]["sparse"] = json!({
            "count": 1, "indices": { "bufferView": indices, "componentType": 5125 }, "values": { "bufferView": values },
        });
    };
    let floats = |v: &[f32]| v.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let four = d.vec3(&[CORNERS[0], CORNERS[1], CORNERS[2], [0.0, 0.0, 9.0]]);
    let normals = d.vec3(&[[0.0, 0.0, 1.0]; 4]);
    let uvs = accessor(&mut d, 5123, "VEC2", &[0.0; 8], true);
    sparse(&mut d, four, &floats(&[3.0, 4.0, 5.0]));
    sparse(&mut d, normals, &floats(&[1.0, 0.0, 0.0]));
    // Replacing elements are packed, whatever the stride of the others.
    sparse(&mut d, uvs, &[255, 255, 0x33, 0x33]);
    sparse(&mut d, 1, &[3]);
    let scene = with_attributes(d, &[("POSITION", four), ("NORMAL", normals), ("TEXCOORD_0", uvs)]);
    let mesh = &scene.meshes()[0];
    assert_eq!(mesh.triangles(), [[0, 3, 2]], "the second index is replaced");
    assert_eq!(mesh.positions()[1], Vec3::new(3.0, 4.0, 5.0));
    assert_eq!(mesh.normals()[1], Vec3::X);
    assert_eq!(mesh.uvs()[1], Vec2::new(1.0, 0.2));
}

#[test]
fn indices_of_every_unsigned_type_or_none() {
    for component in [Some(5121), Some(5123), Some(5125), None] {
        let mut d = Document::triangle();
        match component {
            Some(component) => {
                let bytes: Vec<u8> = match component {
                    5121 => vec![0, 1, 2],
                    5123 => [0_u16, 1, 2].iter().flat_map(|v| v.to_le_bytes()).collect(),
                    _ => [0_u32, 1, 2].iter().flat_map(|v| v.to_le_bytes()).collect(),
                };
                let view = d.view(&bytes);
                d.json["accessors"][1]["bufferView"] = json!(view);
                d.json["accessors"][1]["componentType"] = json!(component);
            }
            None => drop(d.json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("indices")),
        }
        assert_eq!(d.load().unwrap().meshes()[0].triangles(), [[0, 1, 2]], "{component:?}");
    }
}

/// The triangle at instances of a node that is moved by (10, 0, 0) and scaled by 2.
fn instanced(attributes: Value) -> Document {
    let mut d = Document::triangle();
    d.json["nodes"][0]["translation"] = json!([10, 0, 0]);
    d.json["nodes"][0]["scale"] = json!([2, 2, 2]);
    d.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    d.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    d
}

#[test]
fn instances_of_a_node_follow_its_transform() {
    let mut d = instanced(json!({}));
    let moves = d.vec3(&[[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]);
    let scales = d.vec3(&[[1.0, 1.0, 1.0], [1.0, 3.0, 1.0]]);
    // Two rotations in eight bits: none, and half a turn about z.
    let view = d.view(&[0, 0, 0, 127, 0, 0, 127, 0]);
    let turns = d.push(
        "accessors",
        json!({ "bufferView": view, "componentType": 5120, "normalized": true, "count": 2, "type": "VEC4" }),
    );
    let attributes = json!({ "TRANSLATION": moves, "ROTATION": turns, "SCALE": scales, "_ID": 0 });
    d.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = attributes;
    let scene = d.load().unwrap();
    assert!(notes(&scene).is_empty(), "{:?}", notes(&scene));
    assert_eq!((scene.meshes().len(), scene.instances().len()), (1, 2));
    let corner = |i: usize| scene.instances()[i].to_world.transform_point3(Vec3::new(2.0, 1.0, 0.0));
    assert!((corner(0) - Vec3::new(14.0, 2.0, 0.0)).length() < 1e-5, "{}", corner(0));
    // Scaled to (2, 3, 0), turned to (−2, −3, 0), moved to (−1, −1, 3), then by the node to (8, −2,
    // 6).
    assert!((corner(1) - Vec3::new(8.0, -2.0, 6.0)).length() < 1e-5, "{}", corner(1));
    assert_eq!(instanced(json!({})).load().unwrap().instances().len(), 1, "without attributes as without");
}

#[test]
fn instances_that_do_not_fit_together_are_refused() {
    let refused = |attributes: Value, text: &str| {
        let mut d = instanced(attributes);
        d.vec3(&[[0.0; 3]; 2]);
        match d.load() {
            Err(error @ Error::Invalid { .. }) => assert!(error.to_string().contains(text), "{error}"),
            other => panic!("{other:?}"),
        }
    };
    refused(json!({ "TRANSLATION": 0, "SCALE": 2 }), "SCALE: 2 elements; expected 3");
    refused(json!({ "TRANSLATION": 99 }), "TRANSLATION: accessor 99; expected an index below 3");
    refused(json!({ "ROTATION": 0 }), "expected Vec4");
    refused(json!({ "SCALE": "many" }), "cannot be read");
    refused(json!(7), "cannot be read");
    let mut d = instanced(json!({ "TRANSLATION": 0 }));
    d.json["accessors"][0]["count"] = json!(4_000_000_000_u64);
    assert!(d.load().is_err());
}

#[test]
fn hidden_nodes_are_left_out_with_all_below_them() {
    let mut d = Document::triangle();
    d.json["nodes"] = json!([
        { "mesh": 0 },
        { "children": [2], "extensions": { "KHR_node_visibility": { "visible": false } } },
        { "mesh": 0, "extensions": { "KHR_node_visibility": { "visible": true } } },
        { "mesh": 0, "extensions": { "KHR_node_visibility": { "visible": "what?" } } },
    ]);
    assert_eq!(d.load().unwrap().instances().len(), 2);
}

#[test]
fn orthographic_cameras_keep_their_height() {
    let camera = |ymag: Value| {
        let mut d = Document::triangle();
        let fields = json!({ "xmag": 3, "ymag": ymag, "zfar": 9, "znear": 1 });
        d.json["cameras"] = json!([{ "type": "orthographic", "orthographic": fields }]);
        d.push("nodes", json!({ "camera": 0, "translation": [1, 2, 3], "scale": [5, 5, 5] }));
        d.load()
    };
    for ymag in [1.5, -1.5] {
        let scene = camera(json!(ymag)).unwrap();
        assert!(notes(&scene).is_empty());
        let camera = &scene.cameras()[0];
        assert_eq!(camera.projection, Projection::Orthographic { height: 3.0 }, "not scaled with the node");
        assert_eq!((camera.name.as_str(), camera.position()), ("camera-0", Vec3::new(1.0, 2.0, 3.0)));
    }
    for ymag in [json!(0), json!(1e300)] {
        let scene = camera(ymag).unwrap();
        let repaired = "orthographic cameras of height 0 or without end: ymag 1";
        assert_eq!(notes(&scene), [(NoteKind::Repaired, repaired.to_owned())]);
        assert_eq!(scene.cameras()[0].projection, Projection::Orthographic { height: 2.0 });
    }
    let mut d = Document::triangle();
    let fields = json!({ "yfov": 1, "znear": 1 });
    d.json["cameras"] = json!([{ "type": "orthographic", "perspective": fields }]);
    d.push("nodes", json!({ "camera": 0 }));
    let scene = d.load().unwrap();
    assert!(scene.cameras()[0].shows.is_some(), "the camera of scenes that have none");
    let left_out = "cameras without the projection that their type names: left out";
    assert!(notes(&scene).contains(&(NoteKind::Repaired, left_out.to_owned())));
}

#[test]
fn compressed_data_without_anything_beside_them_are_refused_by_name() {
    let mut d = Document::triangle();
    d.json["meshes"][0]["primitives"][0]["extensions"] =
        json!({ "KHR_draco_mesh_compression": { "bufferView": 0 } });
    assert!(d.load().is_ok(), "the data are there");
    d.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    let error = d.load().unwrap_err();
    assert!(matches!(error, Error::Unsupported { .. }) && error.to_string().contains("draco"), "{error}");
    let mut d = Document::triangle();
    d.json["bufferViews"][0]["extensions"] = json!({ "EXT_meshopt_compression": { "buffer": 0 } });
    assert!(d.load().is_ok());
    d.push(
        "buffers",
        json!({ "byteLength": 36, "extensions": { "EXT_meshopt_compression": { "fallback": true } } }),
    );
    d.json["bufferViews"][0]["buffer"] = json!(1);
    let error = d.load().unwrap_err();
    assert!(matches!(error, Error::Unsupported { .. }) && error.to_string().contains("meshopt"), "{error}");
}
