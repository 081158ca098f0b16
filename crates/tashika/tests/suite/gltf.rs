//! The glTF loader. Each test loads a valid file with one feature and compares numbers of the
//! scene.
//!
//! The files are written here, byte by byte. Damaged ones are in `damaged_gltf`.

use std::path::Path;

use glam::{Vec2, Vec3};
use serde_json::{Value, json};
use tashika::color::Rgb;
use tashika::error::{Error, Result};
use tashika::io::{LoadOptions, load_scene};
use tashika::scene::{
    AlphaMode, Channel, Emitter, NoteKind, Pixels, Projection, Scene, Surface, Texture, TextureId, Wrap,
};

use crate::cases::lenient;

/// The corners of the triangle of [`Document::triangle`].
pub const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// A glTF document under construction, with its one buffer.
#[derive(Clone)]
pub struct Document {
    pub json: Value,
    pub buffer: Vec<u8>,
}

impl Document {
    /// A document without nodes and meshes.
    pub fn empty() -> Self {
        let json = json!({
            "asset": { "version": "2.0" },
            "buffers": [{ "byteLength": 0 }],
            "bufferViews": [], "accessors": [], "meshes": [], "nodes": [], "materials": [],
        });
        Self { json, buffer: Vec::new() }
    }

    /// One node with one triangle, which has an index buffer and the empty material 0.
    pub fn triangle() -> Self {
        let mut d = Self::empty();
        let positions = d.vec3(&CORNERS);
        let indices = d.view(&[0, 1, 2]);
        let indices = d.push(
            "accessors",
            json!({ "bufferView": indices, "componentType": 5121, "count": 3, "type": "SCALAR" }),
        );
        let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices, "material": 0 });
        d.push("meshes", json!({ "primitives": [primitive] }));
        d.push("nodes", json!({ "mesh": 0 }));
        d.push("materials", json!({}));
        d
    }

    /// Appends an item to a list; returns its index.
    pub fn push(&mut self, list: &str, item: Value) -> usize {
        if self.json[list].is_null() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().unwrap();
        list.push(item);
        list.len() - 1
    }

    /// Adds a buffer view of new bytes.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.buffer.len();
        self.buffer.extend_from_slice(bytes);
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    /// Adds an accessor of new vectors.
    pub fn vec3(&mut self, values: &[[f32; 3]]) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let count = values.len();
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": 5126, "count": count, "type": "VEC3" }),
        )
    }

    /// Adds texture coordinates of the triangle's corners: `x` and `y` of their positions.
    pub fn add_uvs(&mut self, attribute: &str) {
        let bytes: Vec<u8> = CORNERS.iter().flat_map(|c| &c[..2]).flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let uvs = self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": 5126, "count": 3, "type": "VEC2" }),
        );
        self.json["meshes"][0]["primitives"][0]["attributes"][attribute] = json!(uvs);
    }

    /// Adds a texture from an embedded 2 × 1 PNG with the given texels.
    pub fn add_texture(&mut self, texels: [[u8; 4]; 2]) -> usize {
        let view = self.view(&png(texels));
        let image =
            self.push("images", json!({ "bufferView": view, "mimeType": "image/png", "name": "two" }));
        self.push("textures", json!({ "source": image }))
    }

    /// The JSON text, with the buffer's length filled in.
    pub fn text(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"][0]["byteLength"] = json!(self.buffer.len());
        serde_json::to_vec(&json).unwrap()
    }

    /// The binary container.
    pub fn glb(&self) -> Vec<u8> {
        glb(&self.text(), &self.buffer)
    }

    pub fn load(&self) -> Result<Scene> {
        load(&self.glb())
    }
}

/// A container of two chunks.
pub fn glb(text: &[u8], binary: &[u8]) -> Vec<u8> {
    let mut bytes = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    for (chunk, kind, padding) in [(text, b"JSON", b' '), (binary, b"BIN\0", 0)] {
        bytes.extend_from_slice(&(chunk.len().next_multiple_of(4) as u32).to_le_bytes());
        bytes.extend_from_slice(kind);
        bytes.extend_from_slice(chunk);
        bytes.resize(bytes.len().next_multiple_of(4), padding);
    }
    let length = (bytes.len() as u32).to_le_bytes();
    bytes[8..12].copy_from_slice(&length);
    bytes
}

/// A PNG of two texels, left and right.
pub fn png(texels: [[u8; 4]; 2]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_raw(2, 1, texels.concat())
        .unwrap()
        .write_to(&mut bytes, image::ImageFormat::Png)
        .unwrap();
    bytes.into_inner()
}

/// Loads a file of these bytes.
pub fn load(bytes: &[u8]) -> Result<Scene> {
    let folder = tempfile::tempdir().unwrap();
    load_in(folder.path(), "scene.glb", bytes, &lenient())
}

/// Writes a file into a folder and loads it.
pub fn load_in(folder: &Path, name: &str, bytes: &[u8], options: &LoadOptions) -> Result<Scene> {
    let path = folder.join(name);
    write(&path, bytes);
    load_scene(&path, options)
}

/// Writes a new file. Overwriting one makes some file systems wait for the disk.
pub fn write(path: &Path, bytes: &[u8]) {
    let _ = std::fs::remove_file(path);
    std::fs::write(path, bytes).unwrap();
}

/// Kinds and messages of all notes except those about defaults.
pub fn notes(scene: &Scene) -> Vec<(NoteKind, String)> {
    let notes = scene.notes().iter().filter(|n| n.kind != NoteKind::Defaulted);
    notes.map(|n| (n.kind, n.message)).collect()
}

/// Returns true if there is exactly one note, of the given kind and with the given text in its
/// message.
pub fn only_note(scene: &Scene, kind: NoteKind, text: &str) -> bool {
    matches!(notes(scene).as_slice(), [(k, message)] if *k == kind && message.contains(text))
}

fn close(a: Vec3, b: [f32; 3]) -> bool {
    (a - Vec3::from_array(b)).length() < 1e-5
}

/// Surface and notes of the triangle with the given material.
pub fn surface_of(material: Value) -> (Surface, Vec<(NoteKind, String)>) {
    let mut d = Document::triangle();
    d.json["materials"][0] = material;
    let scene = d.load().unwrap();
    (scene.materials().last().unwrap().surface, notes(&scene))
}

#[test]
fn a_triangle_is_the_same_in_every_container() {
    let folder = tempfile::tempdir().unwrap();
    let d = Document::triangle();
    std::fs::write(folder.path().join("geo metry.bin"), &d.buffer).unwrap();
    let mut external = d.clone();
    external.json["buffers"][0]["uri"] = json!("geo%20metry.bin");
    let mut inline = d.clone();
    let percent: String = d.buffer.iter().map(|b| format!("%{b:02x}")).collect();
    inline.json["buffers"][0]["uri"] = json!(format!("data:application/octet-stream,{percent}"));
    let with_mark = [b"\xEF\xBB\xBF".as_slice(), &external.text()].concat();
    for (name, bytes) in [
        ("a.glb", d.glb()),
        ("a.GLTF", external.text()),
        ("b.gltf", inline.text()),
        ("c.gltf", with_mark),
        ("json-in-a.glb", external.text()),
    ] {
        let scene = load_in(folder.path(), name, &bytes, &LoadOptions::default()).unwrap();
        assert!(notes(&scene).is_empty(), "{name}: {:?}", notes(&scene));
        assert_eq!(scene.meshes().len(), 1, "{name}");
        assert_eq!(scene.meshes()[0].positions(), CORNERS.map(Vec3::from_array), "{name}");
        assert_eq!(scene.meshes()[0].triangles(), [[0, 1, 2]], "{name}");
        assert!(scene.meshes()[0].normals().is_empty(), "flat without NORMAL");
        assert_eq!(scene.instances().len(), 1, "{name}");
    }
}

#[test]
fn strided_normalized_and_sparse_accessors() {
    let mut d = Document::triangle();
    // Each vertex is 16 bytes: position (f32), normal (i8, normalized), padding. The first is at
    // byte 4.
    let mut bytes = vec![9_u8; 4];
    for corner in CORNERS {
        bytes.extend(corner.iter().flat_map(|v| v.to_le_bytes()));
        bytes.extend([0_u8, 0x81, 0, 77]);
    }
    let view = d.view(&bytes);
    d.json["bufferViews"][view]["byteStride"] = json!(16);
    let indices = d.view(&[1, 0]);
    let values = d.view(&[4.0_f32, 5.0, 6.0].iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>());
    let positions = d.push(
        "accessors",
        json!({ "bufferView": view, "byteOffset": 4, "componentType": 5126, "count": 3, "type": "VEC3", "sparse": {
            "count": 1,
            "indices": { "bufferView": indices, "componentType": 5123 },
            "values": { "bufferView": values },
        } }),
    );
    let normals = d.push(
        "accessors",
        json!({ "bufferView": view, "byteOffset": 16, "componentType": 5120, "normalized": true, "count": 3, "type": "VEC3" }),
    );
    let uv_bytes: Vec<u8> = [0_u16, 65535, 13107, 0, 0, 0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let uv_view = d.view(&uv_bytes);
    let uvs = d.push(
        "accessors",
        json!({ "bufferView": uv_view, "componentType": 5123, "normalized": true, "count": 3, "type": "VEC2" }),
    );
    d.json["meshes"][0]["primitives"][0]["attributes"] =
        json!({ "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs });
    let texture = d.add_texture([[255; 4]; 2]);
    d.json["materials"][0] = json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } });
    let scene = d.load().unwrap();
    assert!(notes(&scene).is_empty(), "{:?}", notes(&scene));
    let mesh = &scene.meshes()[0];
    assert_eq!(mesh.positions(), [CORNERS[0], [4.0, 5.0, 6.0], CORNERS[2]].map(Vec3::from_array));
    assert_eq!(mesh.normals(), [Vec3::NEG_Y; 3]);
    assert_eq!(mesh.uvs(), [Vec2::new(0.0, 1.0), Vec2::new(0.2, 0.0), Vec2::ZERO]);
}

#[test]
fn an_accessor_without_a_view_is_zero_but_for_its_sparse_part() {
    let mut d = Document::triangle();
    let indices = d.view(&[1, 2]);
    let bytes: Vec<u8> = CORNERS[1..].iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    let values = d.view(&bytes);
    d.json["accessors"][0] = json!({ "componentType": 5126, "count": 3, "type": "VEC3", "sparse": {
        "count": 2, "indices": { "bufferView": indices, "componentType": 5121 }, "values": { "bufferView": values },
    } });
    assert_eq!(d.load().unwrap().meshes()[0].positions(), CORNERS.map(Vec3::from_array));
}

#[test]
fn a_mesh_is_read_once_and_placed_twice() {
    let mut d = Document::triangle();
    d.json["meshes"][0]["name"] = json!("sail");
    d.push("nodes", json!({ "mesh": 0, "translation": [0, 0, 5] }));
    let scene = d.load().unwrap();
    assert_eq!((scene.meshes().len(), scene.instances().len()), (1, 2));
    assert_eq!((scene.stored_triangles(), scene.instanced_triangles()), (1, 2));
    assert_eq!(scene.meshes()[0].name(), "sail");
    assert_eq!(scene.bounds().hi, Vec3::new(2.0, 1.0, 5.0));
}

#[test]
fn strips_fans_and_ranges_of_vertices() {
    let mut d = Document::empty();
    d.push("nodes", json!({ "mesh": 0 }));
    let square = [[9.0; 3], [9.0; 3], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let positions = d.vec3(&square);
    let mut indices = |list: &[u16]| {
        let view = d.view(&list.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>());
        d.push(
            "accessors",
            json!({ "bufferView": view, "componentType": 5123, "count": list.len(), "type": "SCALAR" }),
        )
    };
    let (strip, fan) = (indices(&[2, 3, 4, 5]), indices(&[2, 3, 5, 4]));
    let lines = json!({ "attributes": { "POSITION": positions }, "mode": 1 });
    d.push(
        "meshes",
        json!({ "primitives": [
            { "attributes": { "POSITION": positions }, "indices": strip, "mode": 5 },
            { "attributes": { "POSITION": positions }, "indices": fan, "mode": 6 },
            lines,
            { "attributes": {} },
        ] }),
    );
    let scene = d.load().unwrap();
    let [strip, fan] = scene.meshes() else { panic!("{} meshes", scene.meshes().len()) };
    assert_eq!(strip.positions().len(), 4, "only the vertices in use");
    assert_eq!(strip.triangles(), [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(fan.triangles(), [[1, 3, 0], [3, 2, 0]]);
    for mesh in [strip, fan] {
        for t in 0..2 {
            let [a, b, c] = mesh.corners(t);
            assert_eq!((b - a).cross(c - a), Vec3::Z, "all face the same way");
        }
    }
    let left_out: Vec<String> = notes(&scene).into_iter().map(|(_, message)| message).collect();
    assert_eq!(left_out, ["primitives without POSITION: left out", "primitive \"LINES\": left out"]);
}

#[test]
fn nodes_multiply_from_the_root_down() {
    let mut d = Document::triangle();
    // A quarter turn about z, then the parent's scale and translation.
    d.json["nodes"] = json!([
        { "mesh": 0, "matrix": [0, 1, 0, 0,  -1, 0, 0, 0,  0, 0, 1, 0,  0, 0, 3, 1] },
        { "children": [0], "scale": [2, 4, 1], "translation": [10, 20, 30] },
        { "children": [1], "rotation": [0, 0, 2, 0] },
    ]);
    let scene = d.load().unwrap();
    let m = scene.instances()[0].to_world;
    // (2, 0, 0) is turned to (0, 2, 3), scaled and moved to (10, 28, 33), and by the half turn
    // about z goes to (−10, −28, 33).
    assert!(close(m.transform_point3(Vec3::new(2.0, 0.0, 0.0)), [-10.0, -28.0, 33.0]));
    assert!(close(m.transform_point3(Vec3::new(0.0, 1.0, 0.0)), [-8.0, -20.0, 33.0]));
}

#[test]
fn the_default_scene_is_loaded_else_the_first_else_all_roots() {
    let mut d = Document::triangle();
    d.push("nodes", json!({ "mesh": 0, "translation": [0, 0, 1] }));
    let heights = |d: &Document| -> Vec<f32> {
        d.load().unwrap().instances().iter().map(|i| i.to_world.translation.z).collect()
    };
    assert_eq!(heights(&d), [0.0, 1.0]);
    d.json["scenes"] = json!([{ "nodes": [1] }, { "nodes": [0] }, { "name": "empty" }]);
    assert_eq!(heights(&d), [1.0]);
    d.json["scene"] = json!(1);
    assert_eq!(heights(&d), [0.0]);
    let scene = d.load().unwrap();
    assert!(only_note(&scene, NoteKind::Ignored, "other than the default one"));
    assert_eq!(scene.notes().iter().find(|n| n.kind == NoteKind::Ignored).map(|n| n.count), Some(2));
}

#[test]
fn cameras_keep_position_direction_and_field_of_view() {
    let mut d = Document::triangle();
    d.json["cameras"] = json!([
        { "type": "perspective", "name": "eye", "perspective": { "yfov": 0.75, "znear": 0.1, "aspectRatio": 2.0 } },
        { "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } },
    ]);
    let quarter = std::f32::consts::FRAC_1_SQRT_2;
    // A quarter turn about y, which takes −z to −x.
    d.push("nodes", json!({ "camera": 0, "translation": [1, 2, 3], "rotation": [0, quarter, 0, quarter], "scale": [3, -5, 7] }));
    d.push("nodes", json!({ "camera": 0 }));
    d.push("nodes", json!({ "camera": 1, "name": "from the node" }));
    d.push("nodes", json!({ "camera": 1 }));
    let scene = d.load().unwrap();
    let names: Vec<&str> = scene.cameras().iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["eye", "eye-2", "from the node", "camera-1"]);
    let eye = &scene.cameras()[0];
    assert_eq!((eye.projection, eye.lens.radius), (Projection::Perspective { vertical_fov: 0.75 }, 0.0));
    assert_eq!(eye.position(), Vec3::new(1.0, 2.0, 3.0));
    let m = eye.to_world.matrix3;
    assert!(close(-Vec3::from(m.z_axis), [-1.0, 0.0, 0.0]), "looks along −x");
    assert!((m.determinant() - 1.0).abs() < 1e-5, "without scale and mirror");
    assert!(notes(&scene).is_empty());
}

#[test]
fn lights_have_position_direction_and_intensity() {
    let mut d = Document::triangle();
    d.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "point", "color": [1, 0.5, 0.25], "intensity": 8 },
        { "type": "directional" },
        { "type": "spot", "intensity": 2, "spot": { "innerConeAngle": 0.2, "outerConeAngle": 0.6 } },
        { "type": "point", "intensity": 0 },
    ] } });
    d.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    d.json["extensionsRequired"] = json!(["KHR_lights_punctual"]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    for light in 0..4 {
        // A quarter turn about x takes −z to +y; then the camera is stretched.
        d.push(
            "nodes",
            json!({
                "extensions": { "KHR_lights_punctual": { "light": light } },
                "translation": [light, 2, 3], "rotation": [half, 0, 0, half], "scale": [1, 5, 9],
            }),
        );
    }
    let scene = d.load().unwrap();
    assert!(notes(&scene).is_empty());
    let [Emitter::Point { position, intensity }, directional, spot] = scene.emitters() else {
        panic!("{:?}: black lights are dropped", scene.emitters())
    };
    assert_eq!((*position, *intensity), (Vec3::new(0.0, 2.0, 3.0), Rgb::new(8.0, 4.0, 2.0)));
    let Emitter::Directional { direction, irradiance } = directional else { panic!("{directional:?}") };
    assert!(close(*direction, [0.0, 1.0, 0.0]) && *irradiance == Rgb::WHITE);
    let Emitter::Spot { position, axis, intensity, falloff } = spot else { panic!("{spot:?}") };
    assert!(close(*axis, [0.0, 1.0, 0.0]) && *intensity == Rgb::gray(2.0) && position.x == 2.0);
    assert!((falloff.cos_inner - 0.2_f64.cos() as f32).abs() < 1e-6);
    assert!((falloff.cos_outer - 0.6_f64.cos() as f32).abs() < 1e-6);
}

#[test]
fn emission_is_factor_times_strength() {
    let mut d = Document::triangle();
    d.add_uvs("TEXCOORD_0");
    let texture = d.add_texture([[255; 4], [188, 0, 0, 255]]);
    d.json["materials"][0] = json!({
        "name": "lamp", "emissiveFactor": [1, 0.5, 0], "emissiveTexture": { "index": texture }, "doubleSided": true,
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 12 } },
    });
    let scene = d.load().unwrap();
    let material = &scene.materials()[0];
    let emission = material.emission.unwrap();
    assert_eq!((material.name.as_str(), emission.two_sided), ("lamp", true));
    assert_eq!(emission.radiance.factor, Rgb::new(12.0, 6.0, 0.0));
    let right = emission.radiance.at(scene.textures(), Vec2::new(0.75, 0.5));
    assert!((right.r - 12.0 * 0.5029).abs() < 0.01 && right.g == 0.0, "sRGB is decoded: {right:?}");
    assert_eq!(scene.area_emitters().count(), 1);

    d.json["materials"][0]["emissiveFactor"] = json!([0, 0, 0]);
    assert!(d.load().unwrap().materials()[0].emission.is_none());
    d.json["materials"][0] = json!({ "emissiveFactor": [3, 3, 3] });
    let emission = d.load().unwrap().materials()[0].emission.unwrap();
    assert_eq!((emission.radiance.factor, emission.two_sided), (Rgb::gray(3.0), false));
}

#[test]
fn metallic_roughness_with_index_and_specular() {
    let f0 = |extensions: Value| {
        let (surface, notes) = surface_of(json!({ "extensions": extensions }));
        assert!(notes.is_empty(), "{notes:?}");
        let Surface::MetallicRoughness { specular_f0, .. } = surface else { panic!("{surface:?}") };
        specular_f0.factor
    };
    let near = |a: Rgb, b: [f32; 3]| close(Vec3::from_array(a.to_array()), b);
    assert!(near(f0(json!({})), [0.04; 3]));
    assert!(near(f0(json!({ "KHR_materials_ior": { "ior": 2.0 } })), [1.0 / 9.0; 3]));
    assert!(near(f0(json!({ "KHR_materials_ior": { "ior": 0.0 } })), [1.0; 3]), "zero asks for one");
    let specular = json!({ "specularFactor": 0.5, "specularColorFactor": [2, 1, 100] });
    assert!(
        near(f0(json!({ "KHR_materials_specular": specular })), [0.08, 0.04, 1.0]),
        "limited; the strength is that of all that a dielectric reflects"
    );

    let mut d = Document::triangle();
    d.add_uvs("TEXCOORD_0");
    let texture = d.add_texture([[51, 102, 204, 255]; 2]);
    d.json["materials"][0]["pbrMetallicRoughness"] = json!({
        "baseColorFactor": [0.1, 0.2, 0.3, 1.0], "metallicFactor": 0.5, "roughnessFactor": 0.25,
        "metallicRoughnessTexture": { "index": texture },
    });
    let scene = d.load().unwrap();
    let Surface::MetallicRoughness { base_color, metallic, roughness, .. } = scene.materials()[0].surface
    else {
        panic!("{:?}", scene.materials()[0])
    };
    assert_eq!(base_color.factor, Rgb::new(0.1, 0.2, 0.3));
    assert_eq!((metallic.factor, metallic.texture.unwrap().1), (0.5, Channel::B));
    assert_eq!((roughness.factor, roughness.texture.unwrap().1), (0.25, Channel::G));
    let at = |input: tashika::scene::FloatInput| input.at(scene.textures(), Vec2::splat(0.5));
    assert!((at(metallic) - 0.5 * 0.8).abs() < 1e-6 && (at(roughness) - 0.25 * 0.4).abs() < 1e-6, "linear");
    let (default, _) = surface_of(json!({}));
    let Surface::MetallicRoughness { base_color, metallic, roughness, .. } = default else {
        panic!("{default:?}")
    };
    assert_eq!((base_color.factor, metallic.factor, roughness.factor), (Rgb::WHITE, 1.0, 1.0));
}

#[test]
fn alpha_modes() {
    let mut d = Document::triangle();
    d.add_uvs("TEXCOORD_0");
    let texture = d.add_texture([[255, 255, 255, 102], [255; 4]]);
    let opaque = d.add_texture([[255; 4]; 2]);
    let alpha = |mode: &str, factor: f32, texture: Option<usize>| {
        let mut d = d.clone();
        d.json["materials"][0] = json!({
            "alphaMode": mode, "alphaCutoff": 0.3, "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, factor] },
        });
        if let Some(texture) = texture {
            d.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": texture });
        }
        let scene = d.load().unwrap();
        let at = |a: &tashika::scene::Alpha| [0.25, 0.75].map(|u| a.at(scene.textures(), Vec2::new(u, 0.5)));
        scene.materials()[0].alpha.as_ref().map(|a| (a.mode, at(a)))
    };
    let mask = AlphaMode::Mask { cutoff: 0.3 };
    assert_eq!(alpha("MASK", 0.5, Some(texture)), Some((mask, [0.0, 1.0])), "0.2 and 0.5 against 0.3");
    assert_eq!(alpha("BLEND", 0.5, Some(texture)), Some((AlphaMode::Blend, [0.2, 0.5])));
    assert_eq!(alpha("BLEND", 0.5, None), Some((AlphaMode::Blend, [0.5, 0.5])));
    assert_eq!(alpha("MASK", 0.2, None), Some((mask, [0.0, 0.0])));
    for (mode, factor, texture) in [
        ("OPAQUE", 0.5, Some(texture)),
        ("MASK", 1.0, None),
        ("BLEND", 1.0, None),
        ("BLEND", 1.0, Some(opaque)),
    ] {
        assert_eq!(alpha(mode, factor, texture), None, "{mode}: nothing to see through");
    }
}

#[test]
fn textures_are_decoded_once_for_each_encoding() {
    let mut d = Document::triangle();
    d.add_uvs("TEXCOORD_0");
    let plain = d.add_texture([[10, 20, 30, 255]; 2]);
    let sampler = d.push("samplers", json!({ "wrapS": 33071, "wrapT": 33648 }));
    let clamped = d.push("textures", json!({ "source": 0, "sampler": sampler }));
    d.add_texture([[1; 4]; 2]);
    let transform = json!({ "offset": [0.25, 0.5], "scale": [2, 3] });
    d.json["materials"][0] = json!({
        "pbrMetallicRoughness": {
            "baseColorTexture": { "index": plain },
            "metallicRoughnessTexture": { "index": plain },
        },
        "emissiveFactor": [1, 1, 1],
        "emissiveTexture": { "index": clamped, "extensions": { "KHR_texture_transform": transform } },
    });
    let scene = d.load().unwrap();
    assert!(notes(&scene).is_empty());
    let [srgb, linear] = scene.images() else {
        panic!("{} images: unused ones are not decoded", scene.images().len())
    };
    assert!(matches!(&srgb.pixels, Pixels::Srgb8(p) if p[1] == [10, 20, 30, 255]));
    assert!(matches!(&linear.pixels, Pixels::Linear8(p) if p[1] == [10, 20, 30, 255]));
    assert_eq!((srgb.name.as_str(), srgb.width, srgb.height), ("two", 2, 1));
    let Surface::MetallicRoughness { base_color, roughness, .. } = scene.materials()[0].surface else {
        panic!()
    };
    let image = |texture: TextureId| match scene.textures().nodes[texture.index()] {
        Texture::Image(lookup) => lookup,
        other => panic!("{other:?}"),
    };
    let base = image(base_color.texture.unwrap());
    assert_eq!((base.image.index(), base.wrap), (0, [Wrap::Repeat; 2]));
    assert_eq!(image(roughness.texture.unwrap().0).image.index(), 1);
    let emission = image(scene.materials()[0].emission.unwrap().radiance.texture.unwrap());
    assert_eq!((emission.image.index(), emission.wrap), (0, [Wrap::Clamp, Wrap::Mirror]));
    assert_eq!(emission.transform.0.transform_point2(Vec2::new(0.5, 0.25)), Vec2::new(1.25, 1.25));
}

#[test]
fn the_set_of_texture_coordinates_is_the_one_that_the_material_wants() {
    let mut d = Document::triangle();
    d.add_uvs("TEXCOORD_1");
    let texture = d.add_texture([[255; 4]; 2]);
    d.json["materials"][0]["pbrMetallicRoughness"] =
        json!({ "baseColorTexture": { "index": texture, "texCoord": 1 } });
    let scene = d.load().unwrap();
    assert!(notes(&scene).is_empty());
    assert_eq!(scene.meshes()[0].uvs()[1], Vec2::new(2.0, 0.0));

    d.json["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"] = json!({ "index": texture });
    let scene = d.load().unwrap();
    assert!(only_note(&scene, NoteKind::Approximated, "texture \"texCoord\""), "{:?}", notes(&scene));
    assert_eq!(scene.meshes()[0].uvs().len(), 3, "still those of the base colour");

    let texture = json!({ "index": texture, "extensions": { "KHR_texture_transform": { "texCoord": 7 } } });
    d.json["materials"][0]["pbrMetallicRoughness"] = json!({ "baseColorTexture": texture });
    let scene = d.load().unwrap();
    assert!(
        only_note(&scene, NoteKind::Approximated, "without the texture coordinates"),
        "{:?}",
        notes(&scene)
    );
    assert!(scene.meshes()[0].uvs().is_empty());
}

#[test]
fn what_is_left_out_is_noted_once() {
    let mut d = Document::triangle();
    d.json["extensionsUsed"] = json!(["KHR_materials_clearcoat", "KHR_lights_punctual", "EXT_nobody_knows"]);
    d.json["animations"] =
        json!([{ "channels": [{ "target": { "path": "pointer" } }] }, "not even an object"]);
    let texture = d.add_texture([[128, 128, 255, 255]; 2]);
    d.json["materials"][0] = json!({ "occlusionTexture": { "index": texture } });
    let primitive = &mut d.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["UNKNOWN"] = json!(0);
    let scene = d.load().unwrap();
    let messages: Vec<String> =
        scene.notes().iter().filter(|n| n.kind == NoteKind::Ignored).map(|n| n.message).collect();
    let expected = [
        "extension \"EXT_nobody_knows\" is unknown: left out",
        "material \"occlusionTexture\": left out, light transport computes occlusion",
        "scene \"animations\": without a time (`--at`) left out, nodes stay where they are",
    ];
    assert_eq!(messages, expected);
    assert!(scene.images().is_empty(), "images that nothing looks up are not decoded");
    assert_eq!(scene.instanced_triangles(), 1);
}

#[test]
fn extensions_that_a_file_requires_are_read_or_refused_by_name() {
    let mut d = Document::triangle();
    for name in ["KHR_materials_specular", "KHR_mesh_quantization", "KHR_texture_transform"] {
        d.json["extensionsRequired"] = json!([name]);
        assert!(d.load().is_ok(), "{name}");
    }
    // The advice to the user comes even if data of such a file are missing.
    d.json["accessors"] = json!("compressed away");
    for (name, advice) in [
        ("KHR_draco_mesh_compression", "without mesh compression"),
        ("EXT_meshopt_compression", "without mesh compression"),
        ("KHR_texture_basisu", "PNG or JPEG"),
        ("EXT_nobody_knows", "without it"),
    ] {
        d.json["extensionsRequired"] = json!(["KHR_lights_punctual", name]);
        let error = d.load().unwrap_err();
        let text = error.to_string();
        assert!(matches!(error, Error::Unsupported { .. }), "{text}");
        assert!(
            text.contains("extensionsRequired[1]") && text.contains(name) && text.contains(advice),
            "{text}"
        );
    }
    d.json["asset"]["version"] = json!("1.0");
    assert!(d.load().unwrap_err().to_string().contains("glTF 1.0 is not supported"));
    let mut later = Document::triangle();
    later.json["asset"] = json!({ "version": "2.1" });
    assert!(later.load().is_ok(), "minor versions are compatible unless they say otherwise");
    later.json["asset"]["minVersion"] = json!("2.1");
    assert!(matches!(later.load(), Err(Error::Unsupported { .. })));
}
