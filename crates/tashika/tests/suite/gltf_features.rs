//! Every row of the glTF loader's table, each in a separate file.

use serde_json::{Value, json};
use tashika::error::Error;
use tashika::io::{Feature, LoadOptions, Support, features};
use tashika::scene::NoteKind;

use super::gltf::{Document, load_in, notes};
use super::{gltf_environment, gltf_profiles, gltf_shapes};
use crate::cases::lenient;

fn rows() -> &'static [Feature] {
    features().into_iter().find(|f| f.format == "glTF").expect("a table of glTF").rows
}

/// A triangle with texture coordinates. Texture 0 is opaque and not yet used by the material.
fn base() -> Document {
    let mut d = Document::triangle();
    d.add_uvs("TEXCOORD_0");
    d.add_texture([[255; 4], [128, 64, 32, 255]]);
    d
}

/// The base document with a material.
fn with_material(material: Value) -> Document {
    let mut d = base();
    d.json["materials"][0] = material;
    d
}

/// A smooth material with transmission and the extension `volume`.
fn glass(volume: Value, pbr: Value) -> Document {
    with_material(json!({ "pbrMetallicRoughness": pbr, "extensions": {
        "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_volume": volume,
    } }))
}

/// A file with the feature of a row, and nothing else that deserves a note.
fn example(kind: &str, name: &str) -> Document {
    let mut d = base();
    let smooth = json!({ "roughnessFactor": 0, "metallicFactor": 0 });
    match (kind, name) {
        ("file", "gltf" | "glb") | ("node", "mesh") | ("attribute", "POSITION") => {}
        ("primitive", "TRIANGLES") | ("material", "pbrMetallicRoughness") => {}
        ("scene", "scene") => {
            d.json["scenes"] = json!([{ "nodes": [0] }]);
            d.json["scene"] = json!(0);
        }
        ("scene", "scenes") => d.json["scenes"] = json!([{ "nodes": [0] }, { "nodes": [] }]),
        ("scene", "animations") => d.json["animations"] = json!([{ "channels": [], "samplers": [] }]),
        ("animation", path) => {
            let (values, times) = (d.view(&[255; 4]), d.view(&[0; 4]));
            let kind = match path {
                "rotation" => "VEC4",
                "weights" => "SCALAR",
                _ => "VEC3",
            };
            d.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 0 }]);
            let input = json!({ "bufferView": times, "componentType": 5126, "count": 1, "type": "SCALAR" });
            let output = json!({ "bufferView": values, "componentType": 5121, "normalized": true, "count": 1, "type": kind });
            let (input, output) = (d.push("accessors", input), d.push("accessors", output));
            d.json["animations"] = json!([{
                "channels": [{ "sampler": 0, "target": { "node": 0, "path": path } }],
                "samplers": [{ "input": input, "output": output }],
            }]);
        }
        ("node", "matrix") => {
            d.json["nodes"][0]["matrix"] = json!([2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]);
        }
        ("node", "rotation") => d.json["nodes"][0]["rotation"] = json!([0, 1, 0, 0]),
        ("node", "skin") | ("skin", _) | ("attribute", "JOINTS_0" | "WEIGHTS_0") => {
            d = gltf_shapes::skinned();
            d.json["skins"][0]["skeleton"] = json!(1);
        }
        ("primitive", "targets") | ("target", "POSITION") => {
            d.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 0 }]);
        }
        ("node" | "mesh", "weights") => {
            d.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 0 }]);
            let list = if kind == "node" { "nodes" } else { "meshes" };
            d.json[list][0]["weights"] = json!([1]);
        }
        ("target", "NORMAL") => {
            d = example("attribute", "NORMAL");
            d.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 0, "NORMAL": 0 }]);
        }
        ("target", "TEXCOORD_0" | "COLOR_0") => {
            d.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 0 }, { name: 0 }]);
        }
        ("target", "TANGENT") => {
            d.json["materials"][0]["normalTexture"] = json!({ "index": 0 });
            d.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "TANGENT": 0 }]);
        }
        ("primitive", mode) => {
            let modes =
                ["POINTS", "LINES", "LINE_LOOP", "LINE_STRIP", "TRIANGLES", "TRIANGLE_STRIP", "TRIANGLE_FAN"];
            let mode = modes.iter().position(|m| *m == mode).expect("a mode");
            d.json["meshes"][0]["primitives"][0]["mode"] = json!(mode);
        }
        ("attribute", "NORMAL") => {
            let normals = d.vec3(&[[0.0, 0.0, 1.0]; 3]);
            d.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
        }
        ("attribute", "TEXCOORD_0") => {
            d.json["materials"][0]["pbrMetallicRoughness"] = json!({ "baseColorTexture": { "index": 0 } });
        }
        ("attribute", "TANGENT") => {
            d.json["materials"][0]["normalTexture"] = json!({ "index": 0 });
            d.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = json!(0);
        }
        ("attribute", "COLOR_0") => {
            let colors = d.vec3(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
            d.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
        }
        ("accessor", "sparse") => {
            // The first corner, which is zero, is replaced by zeros.
            let (indices, values) = (d.view(&[0]), d.view(&[0; 12]));
            d.json["accessors"][0]["sparse"] = json!({
                "count": 1, "indices": { "bufferView": indices, "componentType": 5121 },
                "values": { "bufferView": values },
            });
        }
        ("accessor", "normalized") => {
            let view = d.view(&[0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0]);
            d.json["bufferViews"][view]["byteStride"] = json!(4);
            let normals = json!({ "bufferView": view, "componentType": 5120, "normalized": true, "count": 3, "type": "VEC3" });
            let normals = d.push("accessors", normals);
            d.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
        }
        ("camera", projection) => {
            let fields = match projection {
                "perspective" => json!({ "yfov": 1.0, "znear": 0.1, "aspectRatio": 1.5, "zfar": 9 }),
                _ => json!({ "xmag": 2, "ymag": 1, "znear": 0.1, "zfar": 9 }),
            };
            d.json["cameras"] = json!([{ "type": projection, projection: fields }]);
            d.push("nodes", json!({ "camera": 0 }));
        }
        ("material", texture @ ("normalTexture" | "occlusionTexture" | "emissiveTexture")) => {
            d.json["materials"][0] = json!({ texture: { "index": 0 }, "emissiveFactor": [1, 1, 1] });
        }
        ("material", "alphaMode") => d.json["materials"][0] = json!({ "alphaMode": "BLEND" }),
        ("material", "doubleSided") => d.json["materials"][0] = json!({ "doubleSided": true }),
        ("texture", "source" | "wrapS" | "magFilter") => {
            d = example("attribute", "TEXCOORD_0");
            d.json["samplers"] =
                json!([{ "wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9984 }]);
            d.json["textures"][0]["sampler"] = json!(0);
        }
        ("texture", "texCoord") => {
            d = example("attribute", "TEXCOORD_0");
            d.add_uvs("TEXCOORD_1");
            d.json["materials"][0]["normalTexture"] = json!({ "index": 0, "texCoord": 1 });
        }
        ("extension", "EXT_lights_image_based") => d = gltf_environment::under_sky(json!({})),
        ("extension", "EXT_lights_ies") => {
            d = gltf_profiles::with_lamp(
                gltf_profiles::embedded(gltf_profiles::IES),
                json!({ "light": 0 }),
                json!({}),
            );
        }
        ("extension" | "KHR_lights_punctual", "KHR_lights_punctual" | "range") => {
            let light = if name == "range" {
                json!({ "type": "point", "range": 3 })
            } else {
                json!({ "type": "point" })
            };
            d.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
            d.push("nodes", json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
        }
        ("KHR_materials_transmission", "thicknessFactor") => {
            d = glass(json!({}), smooth);
        }
        ("KHR_materials_transmission", "roughnessFactor") => {
            let rough = json!({ "roughnessFactor": 0.5, "metallicFactor": 0 });
            d = glass(json!({}), rough);
        }
        ("KHR_materials_specular", field) => {
            let fields = if field == "specularFactor" {
                json!({ "specularTexture": { "index": 0 } })
            } else {
                json!({ "specularColorFactor": [1, 0.5, 0] })
            };
            d = with_material(json!({
                "pbrMetallicRoughness": { "metallicFactor": 0.5 },
                "extensions": { "KHR_materials_specular": fields },
            }));
        }
        ("KHR_materials_volume", "attenuationDistance") => {
            let volume =
                json!({ "thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [1, 0.5, 1] });
            d = glass(volume, smooth);
        }
        ("KHR_materials_volume", "thicknessTexture") => {
            d = glass(json!({ "thicknessFactor": 1, "thicknessTexture": { "index": 0 } }), smooth);
        }
        ("KHR_materials_volume", "baseColorTexture") => {
            let textured =
                json!({ "roughnessFactor": 0, "metallicFactor": 0, "baseColorTexture": { "index": 0 } });
            d = glass(json!({ "thicknessFactor": 1 }), textured);
        }
        ("KHR_materials_anisotropy", "anisotropyTexture") => {
            d = glass(json!({ "thicknessFactor": 1 }), smooth);
            let brushed = json!({ "anisotropyStrength": 0.5, "anisotropyTexture": { "index": 0 } });
            d.json["materials"][0]["extensions"]["KHR_materials_anisotropy"] = brushed;
        }
        ("KHR_materials_sheen", field) => {
            let sheen = json!({ "sheenColorFactor": [1, 1, 1], "sheenRoughnessFactor": 0.5 });
            match field {
                "transmissionFactor" => {
                    d = glass(json!({ "thicknessFactor": 1 }), smooth);
                    d.json["materials"][0]["extensions"]["KHR_materials_sheen"] = sheen;
                }
                "emissiveFactor" => {
                    let sheen = json!({ "KHR_materials_sheen": sheen });
                    d = with_material(json!({ "emissiveFactor": [1, 1, 1], "extensions": sheen }));
                }
                _ => {
                    let fine = json!({ "KHR_materials_sheen": { "sheenColorFactor": [1, 1, 1] } });
                    d = with_material(json!({ "extensions": fine }));
                }
            }
        }
        ("KHR_materials_clearcoat", "clearcoatNormalTexture") => {
            let coat = json!({ "clearcoatFactor": 1, "clearcoatNormalTexture": { "index": 0 } });
            d = with_material(json!({ "extensions": { "KHR_materials_clearcoat": coat } }));
        }
        ("KHR_materials_clearcoat", "emissiveFactor") => {
            let coat = json!({ "KHR_materials_clearcoat": { "clearcoatFactor": 1 } });
            d = with_material(json!({ "emissiveFactor": [1, 1, 1], "extensions": coat }));
        }
        ("KHR_materials_clearcoat", "transmissionFactor") => {
            d = glass(json!({ "thicknessFactor": 1 }), smooth);
            d.json["materials"][0]["extensions"]["KHR_materials_clearcoat"] = json!({ "clearcoatFactor": 1 });
        }
        ("extension", "KHR_materials_transmission" | "KHR_materials_volume") => {
            d = glass(json!({ "thicknessFactor": 1 }), smooth);
        }
        ("extension", "KHR_texture_transform") => {
            let transform = json!({ "KHR_texture_transform": { "scale": [2, 2] } });
            d.json["materials"][0]["normalTexture"] = json!({ "index": 0, "extensions": transform });
        }
        ("extension", name) if name.starts_with("KHR_materials_") && !name.ends_with("variants") => {
            let fields = match name {
                "KHR_materials_emissive_strength" => json!({ "emissiveStrength": 2 }),
                "KHR_materials_ior" => json!({ "ior": 1.3 }),
                "KHR_materials_specular" => json!({
                    "specularFactor": 0.5, "specularTexture": { "index": 0 }, "specularColorTexture": { "index": 0 },
                }),
                "KHR_materials_diffuse_transmission" => json!({ "diffuseTransmissionFactor": 0.5 }),
                "KHR_materials_clearcoat" => json!({ "clearcoatFactor": 0.5 }),
                "KHR_materials_anisotropy" => json!({ "anisotropyStrength": 0.5 }),
                "KHR_materials_pbrSpecularGlossiness" => json!({ "glossinessFactor": 0.5 }),
                "KHR_materials_sheen" => json!({ "sheenColorFactor": [1, 1, 1], "sheenRoughnessFactor": 1 }),
                "KHR_materials_iridescence" => json!({ "iridescenceFactor": 1 }),
                "KHR_materials_dispersion" => json!({ "dispersion": 1 }),
                "KHR_materials_unlit" => json!({}),
                _ => panic!("no example of {name}"),
            };
            d = with_material(json!({ "extensions": { name: fields } }));
        }
        ("extension", "EXT_mesh_gpu_instancing") => {
            d.json["nodes"][0]["extensions"] = json!({ name: { "attributes": { "TRANSLATION": 0 } } });
        }
        ("extension", "KHR_node_visibility") => {
            d.json["nodes"][0]["extensions"] = json!({ name: { "visible": true } });
        }
        ("extension", "KHR_mesh_quantization") => d = example("accessor", "normalized"),
        ("extension", "KHR_draco_mesh_compression") => {
            d.json["meshes"][0]["primitives"][0]["extensions"] = json!({ name: { "bufferView": 0 } });
        }
        ("extension", "EXT_meshopt_compression" | "KHR_meshopt_compression") => {
            d.json["bufferViews"][0]["extensions"] = json!({ name: { "buffer": 0 } });
        }
        ("extension", name) if name.contains("_texture_") => {
            d = example("attribute", "TEXCOORD_0");
            d.json["textures"][0]["extensions"] = json!({ name: { "source": 0 } });
        }
        ("extension", _) => d.json["extensions"] = json!({ name: {} }),
        ("required extension", _) => d.json["extensionsRequired"] = json!([name]),
        _ => panic!("no example of {kind} {name}"),
    }
    if kind == "extension" {
        d.json["extensionsUsed"] = json!([name]);
    }
    d
}

fn message(row: &Feature) -> String {
    format!("{} {:?}: {}", row.kind, row.name, row.how)
}

#[test]
fn every_row_gives_its_note_and_no_other() {
    let folder = tempfile::tempdir().unwrap();
    for row in rows() {
        let document = example(row.kind, row.name);
        let result = if row.name == "gltf" {
            let mut d = document;
            std::fs::write(folder.path().join("b.bin"), &d.buffer).unwrap();
            d.json["buffers"][0]["uri"] = json!("b.bin");
            load_in(folder.path(), "s.gltf", &d.text(), &LoadOptions::default())
        } else {
            // Animations are read only if a time is requested.
            let at = (row.kind == "animation").then_some(0.0);
            load_in(folder.path(), "s.glb", &document.glb(), &LoadOptions { at, ..lenient() })
        };
        // A field of an extension also gives the note about the extension.
        let extension = rows().iter().find(|r| r.kind == "extension" && r.name == row.kind);
        let mut expected = Vec::new();
        for row in [Some(row), extension].into_iter().flatten() {
            match row.support {
                Support::Full => {}
                Support::Approximated => expected.push((NoteKind::Approximated, message(row))),
                Support::Ignored => expected.push((NoteKind::Ignored, message(row))),
                Support::Refused => {
                    let error = result.as_ref().unwrap_err();
                    assert!(matches!(error, Error::Unsupported { .. }), "{error}");
                    let text = error.to_string();
                    assert!(text.contains(row.name) && text.ends_with(row.how), "{text}");
                }
            }
        }
        if row.support == Support::Refused {
            continue;
        }
        expected.sort();
        let scene = result.unwrap_or_else(|e| panic!("{row:?}: {e}"));
        assert_eq!(notes(&scene), expected, "{row:?}");
    }
}

#[test]
fn extensions_without_effect_are_not_noted() {
    for (name, fields) in [
        ("KHR_materials_sheen", json!({ "sheenRoughnessFactor": 1 })),
        ("KHR_materials_iridescence", json!({ "iridescenceIor": 1.3 })),
        ("KHR_materials_dispersion", json!({})),
        ("KHR_materials_anisotropy", json!({ "anisotropyRotation": 1 })),
        ("KHR_materials_clearcoat", json!({ "clearcoatRoughnessFactor": 1 })),
        ("KHR_materials_diffuse_transmission", json!({ "diffuseTransmissionColorFactor": [1, 0, 0] })),
        ("KHR_materials_volume", json!({ "thicknessFactor": 0, "attenuationDistance": 1 })),
    ] {
        let mut d = with_material(json!({ "extensions": { name: fields } }));
        d.json["extensionsUsed"] = json!([name]);
        let scene = d.load().unwrap();
        assert_eq!(notes(&scene), [], "{name}");
        assert_eq!(scene.materials().len(), 1, "{name}");
        assert_eq!(scene.materials()[0].surface.kind(), "metallic-roughness", "{name}");
    }
}
