//! The same scene in every format gives the same picture.
//!
//! The scene is a box without lid and front under a lamp. Its left wall is red, its right wall
//! green, the others grey. It is written as pbrt-v3, pbrt-v4, Mitsuba 0.6, Mitsuba 3, glTF and OBJ.
//! The pictures agree only if geometry, materials, light, camera and handedness do.

use std::fmt::Write as _;
use std::fs;
use std::sync::Arc;

use tashika::accel::Tracer;
use tashika::gather::{GatherOptions, View};
use tashika::integrator::{PathStop, PathTracer};
use tashika::io::{LoadOptions, load_scene};
use tashika::scene::{Camera, Scene};

use crate::cases::film_of;

/// A wall: corner, two edges, reflectance, radiance.
struct Wall {
    corner: [f32; 3],
    edges: [[f32; 3]; 2],
    reflectance: [f32; 3],
    radiance: [f32; 3],
}

const NOTHING: [f32; 3] = [0.0; 3];
const GREY: [f32; 3] = [0.6, 0.6, 0.6];

/// The normals of walls (first edge × second edge) point into the box; the normal of the lamp
/// points down.
const WALLS: [Wall; 5] = [
    Wall {
        corner: [-1.0, 0.0, -1.0],
        edges: [[0.0, 0.0, 2.0], [2.0, 0.0, 0.0]],
        reflectance: GREY,
        radiance: NOTHING,
    },
    Wall {
        corner: [-1.0, 0.0, -1.0],
        edges: [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]],
        reflectance: GREY,
        radiance: NOTHING,
    },
    Wall {
        corner: [-1.0, 0.0, -1.0],
        edges: [[0.0, 2.0, 0.0], [0.0, 0.0, 2.0]],
        reflectance: [0.7, 0.1, 0.1],
        radiance: NOTHING,
    },
    Wall {
        corner: [1.0, 0.0, -1.0],
        edges: [[0.0, 0.0, 2.0], [0.0, 2.0, 0.0]],
        reflectance: [0.1, 0.6, 0.1],
        radiance: NOTHING,
    },
    Wall {
        corner: [-0.5, 1.95, -0.5],
        edges: [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        reflectance: NOTHING,
        radiance: [6.0, 5.0, 4.0],
    },
];

/// Vertical field of view (degrees) of the square image; the camera is at (0, 1, 4) and looks at
/// (0, 1, 0).
const FOV: f32 = 35.0;

impl Wall {
    fn corners(&self) -> [[f32; 3]; 4] {
        let [a, b] = self.edges;
        let add = |p: [f32; 3], q: [f32; 3]| [p[0] + q[0], p[1] + q[1], p[2] + q[2]];
        [self.corner, add(self.corner, a), add(add(self.corner, a), b), add(self.corner, b)]
    }

    fn glows(&self) -> bool {
        self.radiance != NOTHING
    }
}

fn words(numbers: impl IntoIterator<Item = f32>) -> String {
    numbers.into_iter().map(|n| n.to_string()).collect::<Vec<_>>().join(" ")
}

/// pbrt is left-handed. The scene is mirrored, so that its picture is not.
fn pbrt(material: &str, parameter: &str, film: &str) -> String {
    let mut text = format!(
        "Scale -1 1 1\nLookAt 0 1 4  0 1 0  0 1 0\nCamera \"perspective\" \"float fov\" [{FOV}]\n\
         Film \"{film}\" \"integer xresolution\" [8] \"integer yresolution\" [8]\nWorldBegin\n"
    );
    for wall in &WALLS {
        let (reflectance, radiance) = (words(wall.reflectance), words(wall.radiance));
        writeln!(text, "AttributeBegin\nMaterial \"{material}\" \"rgb {parameter}\" [{reflectance}]")
            .unwrap();
        if wall.glows() {
            writeln!(text, "AreaLightSource \"diffuse\" \"rgb L\" [{radiance}]").unwrap();
        }
        let points = words(wall.corners().into_iter().flatten());
        writeln!(
            text,
            "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [{points}]\nAttributeEnd"
        )
        .unwrap();
    }
    text + if film == "image" { "WorldEnd\n" } else { "" }
}

fn mitsuba(version: &str, to_world: &str, reflectance: &str, fov_axis: &str) -> String {
    let mut text = format!(
        "<scene version=\"{version}\"><sensor type=\"perspective\"><float name=\"fov\" value=\"{FOV}\"/>\
         <string name=\"{fov_axis}\" value=\"y\"/><transform name=\"{to_world}\">\
         <lookat origin=\"0,1,4\" target=\"0,1,0\" up=\"0,1,0\"/></transform>\
         <film type=\"hdrfilm\"><integer name=\"width\" value=\"8\"/><integer name=\"height\" value=\"8\"/></film></sensor>\n"
    );
    for wall in &WALLS {
        // Mitsuba's rectangle is the square [−1, 1]² in z = 0 and faces +z. The transformation maps
        // its sides to the edges of the wall.
        let [a, b] = wall.edges.map(|e| e.map(|v| 0.5 * v));
        let n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        let c = [0, 1, 2].map(|k| wall.corner[k] + a[k] + b[k]);
        let rows = [0, 1, 2].map(|k| words([a[k], b[k], n[k], c[k]])).join(" ");
        let color = words(wall.reflectance);
        write!(
            text,
            "<shape type=\"rectangle\"><transform name=\"{to_world}\"><matrix value=\"{rows} 0 0 0 1\"/></transform>\
             <bsdf type=\"diffuse\"><rgb name=\"{reflectance}\" value=\"{color}\"/></bsdf>"
        )
        .unwrap();
        if wall.glows() {
            let radiance = words(wall.radiance);
            write!(text, "<emitter type=\"area\"><rgb name=\"radiance\" value=\"{radiance}\"/></emitter>")
                .unwrap();
        }
        text.push_str("</shape>\n");
    }
    text + "</scene>\n"
}

fn gltf() -> String {
    let mut bytes = Vec::new();
    let (mut meshes, mut materials, mut views, mut accessors, mut nodes) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (i, wall) in WALLS.iter().enumerate() {
        let [p, q, r, s] = wall.corners();
        let triangles = [p, q, r, p, r, s];
        views.push(serde_json::json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": 72 }));
        bytes.extend(triangles.iter().flatten().flat_map(|v| v.to_le_bytes()));
        let bound =
            |f: fn(f32, f32) -> f32| [0, 1, 2].map(|k| triangles.iter().map(|t| t[k]).reduce(f).unwrap());
        accessors.push(serde_json::json!({
            "bufferView": i, "componentType": 5126, "count": 6, "type": "VEC3",
            "min": bound(f32::min), "max": bound(f32::max)
        }));
        meshes
            .push(serde_json::json!({ "primitives": [{ "attributes": { "POSITION": i }, "material": i }] }));
        nodes.push(serde_json::json!({ "mesh": i }));
        let strength = wall.radiance[0].max(1.0);
        materials.push(serde_json::json!({
            "pbrMetallicRoughness": {
                "baseColorFactor": [wall.reflectance[0], wall.reflectance[1], wall.reflectance[2], 1],
                "metallicFactor": 0
            },
            "emissiveFactor": wall.radiance.map(|v| v / strength),
            "extensions": {
                "KHR_materials_specular": { "specularFactor": 0 },
                "KHR_materials_emissive_strength": { "emissiveStrength": strength }
            }
        }));
    }
    nodes.push(serde_json::json!({ "camera": 0, "translation": [0, 1, 4] }));
    let hex: String = bytes.iter().map(|b| format!("%{b:02x}")).collect();
    serde_json::json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_materials_specular", "KHR_materials_emissive_strength"],
        "buffers": [{ "byteLength": bytes.len(), "uri": format!("data:application/octet-stream,{hex}") }],
        "bufferViews": views, "accessors": accessors, "meshes": meshes, "materials": materials,
        "cameras": [{ "type": "perspective", "perspective": { "yfov": FOV.to_radians(), "znear": 0.1 } }],
        "nodes": nodes, "scenes": [{ "nodes": [0, 1, 2, 3, 4, 5] }], "scene": 0
    })
    .to_string()
}

/// Returns the OBJ and the MTL file. In this format the lamp emits from both sides, but there is
/// nothing above it.
fn obj() -> (String, String) {
    let (mut geometry, mut materials) = ("mtllib scene.mtl\n".to_owned(), String::new());
    for (i, wall) in WALLS.iter().enumerate() {
        for corner in wall.corners() {
            writeln!(geometry, "v {}", words(corner)).unwrap();
        }
        writeln!(geometry, "usemtl m{i}\nf -4 -3 -2 -1").unwrap();
        writeln!(materials, "newmtl m{i}\nKd {}\nKe {}", words(wall.reflectance), words(wall.radiance))
            .unwrap();
    }
    (geometry, materials)
}

fn load(name: &str, files: &[(&str, &str)]) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    for (file, text) in files {
        fs::write(folder.path().join(file), text).unwrap();
    }
    load_scene(&folder.path().join(files[0].0), &LoadOptions::default())
        .unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Path-traced colours, with the standard error of the luminance.
fn picture(scene: Scene, camera: &Camera, seed: u64) -> (Vec<[f64; 3]>, Vec<f64>) {
    let tracer = Tracer::new(Arc::new(scene));
    let view = View { camera, size: [8, 8], gather: GatherOptions::default(), seed };
    let film = film_of(&tracer, &PathTracer::new(&tracer, PathStop::Count(2000), 20).unwrap(), view);
    let errors = film.plane("standard_error").unwrap().f32_samples().unwrap();
    let colors = film.colors().unwrap().map(|c| c.to_array().map(f64::from)).collect();
    (colors, errors.iter().map(|e| f64::from(*e)).collect())
}

#[test]
fn the_same_box_in_every_format_gives_the_same_picture() {
    let (obj, mtl) = obj();
    // OBJ has no camera; the camera of pbrt's scene is used.
    let mut scenes = vec![
        ("pbrt-v3", load("pbrt-v3", &[("scene.pbrt", &pbrt("matte", "Kd", "image"))])),
        ("pbrt-v4", load("pbrt-v4", &[("scene.pbrt", &pbrt("diffuse", "reflectance", "rgb"))])),
        (
            "Mitsuba 0.6",
            load("Mitsuba 0.6", &[("scene.xml", &mitsuba("0.6.0", "toWorld", "reflectance", "fovAxis"))]),
        ),
        (
            "Mitsuba 3",
            load("Mitsuba 3", &[("scene.xml", &mitsuba("3.0.0", "to_world", "reflectance", "fov_axis"))]),
        ),
        ("glTF", load("glTF", &[("scene.gltf", &gltf())])),
    ];
    let borrowed = scenes[0].1.cameras()[0].clone();
    scenes.push(("OBJ", load("OBJ", &[("scene.obj", &obj), ("scene.mtl", &mtl)])));
    let mut others = Vec::new();
    for (seed, (name, scene)) in (1..).zip(scenes) {
        assert_eq!(scene.notes().first_departure(), None, "{name}");
        assert_eq!(scene.stored_triangles(), 10, "{name}");
        let camera = if name == "OBJ" { borrowed.clone() } else { scene.cameras()[0].clone() };
        others.push((name, picture(scene, &camera, seed)));
    }
    let luminance = |c: &[f64; 3]| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
    let (reference, errors) = others[0].1.clone();
    // At half height, the picture is red on the left and green on the right.
    assert!(
        reference[4 * 8][0] > 2.0 * reference[4 * 8][1]
            && reference[4 * 8 + 7][1] > 2.0 * reference[4 * 8 + 7][0]
    );
    for (name, (colors, own)) in &others[1..] {
        for i in 0..64 {
            let error = errors[i].hypot(own[i]);
            // Each of 325 comparisons has the two-sided level 10⁻⁵. The standard error of a channel
            // is at most three times that of the luminance.
            let (a, b) = (luminance(&colors[i]), luminance(&reference[i]));
            assert!((a - b).abs() <= 4.42 * error + 1e-9, "{name}, pixel {i}: {a} for {b} ± {error}");
            for channel in 0..3 {
                let (a, b) = (colors[i][channel], reference[i][channel]);
                assert!(
                    (a - b).abs() <= 3.0 * 4.42 * error + 1e-9,
                    "{name}, pixel {i}, channel {channel}: {a} for {b}"
                );
            }
        }
        let mean = |c: &[[f64; 3]]| c.iter().map(luminance).sum::<f64>() / 64.0;
        let (a, b) = (mean(colors), mean(&reference));
        let error = own.iter().chain(&errors).map(|e| e * e).sum::<f64>().sqrt() / 64.0;
        assert!(error < 0.01 * b, "the comparison is sharp: {error} of {b}");
        assert!((a - b).abs() < 4.42 * error, "{name}: {a} for {b} ± {error}");
    }
}
