//! Morph targets and skins of glTF: positions of vertices against closed forms, and damaged files.

use glam::{Affine3A, Quat, Vec3};
use serde_json::{Value, json};
use tashika::error::{Error, Result};
use tashika::io::LoadOptions;
use tashika::scene::{NoteKind, Scene};

use super::gltf::{CORNERS, Document, load_in, notes, only_note};
use super::gltf_animations::{QUARTER, accessor, animate};

/// Displacements of the corners in two targets.
const MOVES: [[[f32; 3]; 3]; 2] =
    [[[0.0, 0.0, 2.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0]], [[0.0, 8.0, 0.0], [0.0; 3], [0.0, 0.0, -2.0]]];

fn load_at(d: &Document, at: Option<f64>) -> Result<Scene> {
    let folder = tempfile::tempdir().unwrap();
    load_in(folder.path(), "scene.glb", &d.glb(), &LoadOptions { at, ..LoadOptions::default() })
}

/// The triangle with two morph targets.
fn morphing() -> Document {
    let mut d = Document::triangle();
    let targets = MOVES.map(|moves| json!({ "POSITION": d.vec3(&moves) }));
    d.json["meshes"][0]["primitives"][0]["targets"] = json!(targets);
    d
}

/// Positions of the corners for these weights.
fn morphed(weights: [f32; 2]) -> [Vec3; 3] {
    [0, 1, 2].map(|v| {
        let [first, second] = MOVES.map(|moves| Vec3::from(moves[v]));
        Vec3::from(CORNERS[v]) + first * weights[0] + second * weights[1]
    })
}

#[track_caller]
fn assert_corners(scene: &Scene, mesh: usize, expected: [Vec3; 3], what: &str) {
    for (found, expected) in scene.meshes()[mesh].positions().iter().zip(expected) {
        assert!(
            (*found - expected).length() < 2e-6 * (1.0 + expected.length()),
            "{what}: {found} for {expected}"
        );
    }
}

#[test]
fn weights_are_those_of_the_node_or_else_of_the_mesh() {
    let of = |mesh: Value, node: Value| {
        let mut d = morphing();
        d.json["meshes"][0]["weights"] = mesh;
        d.json["nodes"][0]["weights"] = node;
        let scene = d.load().unwrap();
        assert_eq!(notes(&scene), []);
        scene
    };
    // Null stands for a missing value.
    assert_corners(&of(Value::Null, Value::Null), 0, CORNERS.map(Vec3::from), "none");
    assert_corners(&of(json!([0.5, 0.25]), Value::Null), 0, morphed([0.5, 0.25]), "the mesh's");
    assert_corners(&of(json!([0.5, 0.25]), json!([0, -1])), 0, morphed([0.0, -1.0]), "the node's");
    // Three nodes show one mesh. Two of them have equal weights, the third has others: two shapes.
    let mut d = morphing();
    d.json["meshes"][0]["weights"] = json!([1, 1]);
    d.push("nodes", json!({ "mesh": 0, "weights": [0, 0.5] }));
    d.push("nodes", json!({ "mesh": 0, "weights": [1, 1] }));
    let scene = d.load().unwrap();
    assert_eq!((scene.meshes().len(), scene.instances().len()), (2, 3));
    assert_corners(&scene, 0, morphed([1.0, 1.0]), "the mesh's");
    assert_corners(&scene, 1, morphed([0.0, 0.5]), "the second node's");
    let shown: Vec<usize> = scene.instances().iter().map(|i| i.mesh.index()).collect();
    assert_eq!(shown, [0, 1, 0]);
}

/// One target stores only its second vertex, one moves normals, and the indices begin at the second
/// vertex.
#[test]
fn sparse_targets_and_normals_of_the_vertices_in_use() {
    let mut d = Document::triangle();
    let four = [[7.0; 3], CORNERS[0], CORNERS[1], CORNERS[2]];
    let (positions, normals) = (d.vec3(&four), d.vec3(&[[0.0, 0.0, 1.0]; 4]));
    let indices = d.view(&[1, 2, 3]);
    d.json["accessors"][1]["bufferView"] = json!(indices);
    let (at, values) = (d.view(&[2]), d.view(&[1.0_f32, 2.0, 3.0].map(f32::to_le_bytes).concat()));
    let sparse = d.push(
        "accessors",
        json!({ "componentType": 5126, "count": 4, "type": "VEC3", "sparse": {
            "count": 1, "indices": { "bufferView": at, "componentType": 5121 }, "values": { "bufferView": values },
        } }),
    );
    let turned = d.vec3(&[[9.0; 3], [2.0, 0.0, 0.0], [0.0; 3], [0.0, -2.0, -2.0]]);
    let primitive = &mut d.json["meshes"][0]["primitives"][0];
    primitive["attributes"] = json!({ "POSITION": positions, "NORMAL": normals });
    primitive["targets"] = json!([{ "POSITION": sparse, "NORMAL": turned }]);
    d.json["meshes"][0]["weights"] = json!([0.5]);
    let scene = d.load().unwrap();
    assert_eq!(notes(&scene), []);
    let moved = Vec3::from(CORNERS[1]) + Vec3::new(0.5, 1.0, 1.5);
    assert_corners(&scene, 0, [Vec3::from(CORNERS[0]), moved, Vec3::from(CORNERS[2])], "sparse");
    let normals = [Vec3::new(1.0, 0.0, 1.0), Vec3::Z, Vec3::new(0.0, -1.0, 0.0)].map(Vec3::normalize);
    for (found, expected) in scene.meshes()[0].normals().iter().zip(normals) {
        assert!((*found - expected).length() < 1e-6, "{found} for {expected}");
    }
    // An accessor without bytes may have more zeros than the limit, but no more than there are
    // vertices.
    let mut d = Document::triangle();
    let many = (1 << 16) + 3;
    let corners: Vec<[f32; 3]> = (0..many).map(|i| CORNERS[i % 3]).collect();
    let positions = d.vec3(&corners);
    let target = d.push("accessors", json!({ "componentType": 5126, "count": many, "type": "VEC3" }));
    d.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(positions);
    d.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": target }]);
    d.json["meshes"][0]["weights"] = json!([1]);
    assert_corners(&d.load().unwrap(), 0, CORNERS.map(Vec3::from), "zeros");
    d.json["accessors"][target]["count"] = json!(many + 1);
    assert!(d.load().unwrap_err().to_string().contains(&format!("at most {many}")));
}

#[test]
fn weights_are_animated_by_every_interpolation() {
    let at = |interpolation: &str, values: &[[f32; 1]], seconds: f64| {
        let mut d = morphing();
        d.json["nodes"][0]["weights"] = json!([9, 9]);
        animate(&mut d, (0, "weights"), interpolation, &[1.0, 3.0], values);
        let scene = load_at(&d, Some(seconds)).unwrap();
        assert_eq!((notes(&scene), scene.animated_seconds()), (Vec::new(), Some([1.0, 3.0])));
        scene
    };
    let keys = [[0.25], [1.0], [0.75], [-1.0]];
    for (seconds, weights) in [(0.0, [0.25, 1.0]), (2.9, [0.25, 1.0]), (3.0, [0.75, -1.0])] {
        assert_corners(&at("STEP", &keys, seconds), 0, morphed(weights), "STEP");
    }
    for (seconds, weights) in [(0.0, [0.25, 1.0]), (1.5, [0.375, 0.5]), (9.0, [0.75, -1.0])] {
        assert_corners(&at("LINEAR", &keys, seconds), 0, morphed(weights), "LINEAR");
    }
    // Cubic splines whose tangents are their derivatives are reproduced exactly: t³/9 and t − t²/3.
    // Each key has the incoming tangents of both targets first, then both values.
    let f = |t: f32| [t * t * t / 9.0, t - t * t / 3.0];
    let slope = |t: f32| [t * t / 3.0, 1.0 - 2.0 * t / 3.0];
    let keys = [[1e6; 2], f(1.0), slope(1.0), slope(3.0), f(3.0), [1e6; 2]];
    let keys: Vec<[f32; 1]> = keys.iter().flatten().map(|&w| [w]).collect();
    for t in [1.0_f32, 1.25, 2.0, 3.0, 5.0] {
        let scene = at("CUBICSPLINE", &keys, f64::from(t));
        assert_corners(&scene, 0, morphed(f(t.min(3.0))), &format!("CUBICSPLINE at {t}"));
    }
    // Without a time the node's weights apply, and a note reports the motion.
    let mut d = morphing();
    animate(&mut d, (0, "weights"), "LINEAR", &[1.0, 3.0], &[[1.0]; 4]);
    let scene = load_at(&d, None).unwrap();
    assert!(only_note(&scene, NoteKind::Ignored, "without a time (`--at`) left out"));
    assert_corners(&scene, 0, CORNERS.map(Vec3::from), "without a time");
}

/// Heights of the bar's vertices (m), two vertices at each; the joints are at 0 and 1 m.
const HEIGHTS: [f32; 3] = [0.0, 1.0, 2.0];

/// A bar along y with two joints. Vertices at 0 m follow the first joint, vertices at 2 m the
/// second, and vertices at 1 m both. The root is at (0, 0, 5); the node of the mesh is elsewhere.
pub fn skinned() -> Document {
    let mut d = Document::empty();
    d.push("materials", json!({}));
    let vertices = HEIGHTS.map(|y| [[0.0, y, 0.0], [0.0, y, 1.0]]).concat();
    let positions = d.vec3(&vertices);
    let normals = d.vec3(&[[1.0, 0.0, 0.0]; 6]);
    let indices = d.view(&[0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 5]);
    let indices = d.push(
        "accessors",
        json!({ "bufferView": indices, "componentType": 5121, "count": 12, "type": "SCALAR" }),
    );
    let joints = d.view(&[[0_u8, 1, 0, 0]; 6].concat());
    let joints = d.push(
        "accessors",
        json!({ "bufferView": joints, "componentType": 5121, "count": 6, "type": "VEC4" }),
    );
    let shares = [[1.0, 0.0], [0.5, 0.5], [0.0, 1.0]];
    let weights = shares.map(|[first, second]| [[first, second, 0.0, 0.0]; 2]).concat();
    let weights = accessor(&mut d, &weights);
    let binds: Vec<u8> =
        [0.0, -1.0].iter().flat_map(|&y| bind(Vec3::Y * y)).flat_map(f32::to_le_bytes).collect();
    let binds = d.view(&binds);
    let binds = d
        .push("accessors", json!({ "bufferView": binds, "componentType": 5126, "count": 2, "type": "MAT4" }));
    let attributes =
        json!({ "POSITION": positions, "NORMAL": normals, "JOINTS_0": joints, "WEIGHTS_0": weights });
    d.push(
        "meshes",
        json!({ "primitives": [{ "attributes": attributes, "indices": indices, "material": 0 }] }),
    );
    d.push("skins", json!({ "joints": [2, 3], "inverseBindMatrices": binds }));
    d.json["nodes"] = json!([
        { "mesh": 0, "skin": 0, "translation": [50, 60, 70], "scale": [3, 3, 3] },
        { "translation": [0, 0, 5], "children": [2, 0] },
        { "children": [3] },
        { "translation": [0, 1, 0] },
    ]);
    d
}

/// A translation as a matrix, column by column.
fn bind(way: Vec3) -> [f32; 16] {
    let mut m = [0.0; 16];
    (0..4).for_each(|k| m[5 * k] = 1.0);
    way.write_to_slice(&mut m[12..15]);
    m
}

/// Expected positions and normals of the bar. `second` transforms the second joint around itself.
fn bent(second: Affine3A) -> [(Vec3, Vec3); 6] {
    let about = Affine3A::from_translation(Vec3::Y) * second * Affine3A::from_translation(Vec3::NEG_Y);
    let root = Affine3A::from_translation(Vec3::Z * 5.0);
    [0, 1, 2, 3, 4, 5].map(|v| {
        let share = [0.0, 0.5, 1.0][v / 2];
        let map = root
            * Affine3A {
                matrix3: Affine3A::IDENTITY.matrix3 * (1.0 - share) + about.matrix3 * share,
                translation: about.translation * share,
            };
        let position = map.transform_point3(Vec3::new(0.0, HEIGHTS[v / 2], (v % 2) as f32));
        (position, (map.matrix3.inverse().transpose() * Vec3::X).normalize())
    })
}

#[track_caller]
fn assert_bent(scene: &Scene, expected: [(Vec3, Vec3); 6], what: &str) {
    assert_eq!(scene.instances().len(), 1);
    assert!(scene.instances()[0].is_identity(), "the node's own transform counts for nothing");
    let mesh = &scene.meshes()[0];
    for ((found, normal), (at, n)) in mesh.positions().iter().zip(mesh.normals()).zip(expected) {
        assert!((*found - at).length() < 2e-6, "{what}: {found} for {at}");
        assert!((*normal - n).length() < 2e-6, "{what}: normal {normal} for {n}");
    }
}

#[test]
fn a_bar_of_two_joints_bends_by_a_right_angle() {
    assert_bent(&skinned().load().unwrap(), bent(Affine3A::IDENTITY), "straight");
    let mut d = skinned();
    d.json["nodes"][3]["rotation"] = json!(QUARTER);
    let scene = d.load().unwrap();
    assert_eq!(notes(&scene), []);
    // In numbers: the tip goes from (0, 2) to (−1, 1), the middle stays; all are at z = 5 m.
    let tip = scene.meshes()[0].positions()[4];
    assert!((tip - Vec3::new(-1.0, 1.0, 5.0)).length() < 1e-6, "{tip}");
    assert!((scene.meshes()[0].normals()[4] - Vec3::Y).length() < 1e-6);
    let quarter = Affine3A::from_quat(Quat::from_array(QUARTER));
    assert_bent(&scene, bent(quarter), "a quarter turn");
    // A bar that is stretched along its normal, sheared by the blend, or mirrored: normals stay
    // perpendicular to the surface.
    for scale in [Vec3::new(4.0, 1.0, 0.5), Vec3::new(-1.0, 1.0, 1.0) * 2.0] {
        let mut d = skinned();
        d.json["nodes"][3]["rotation"] = json!([0.0, 0.0, 0.6, 0.8]);
        d.json["nodes"][3]["scale"] = json!(scale.to_array());
        let turn = Quat::from_xyzw(0.0, 0.0, 0.6, 0.8);
        let expected = bent(Affine3A::from_scale_rotation_translation(scale, turn, Vec3::ZERO));
        assert_bent(&d.load().unwrap(), expected, &format!("scaled by {scale}"));
    }
    // Without inverse bind matrices, vertices are bound at their own positions.
    let mut d = skinned();
    d.json["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    let tip = d.load().unwrap().meshes()[0].positions()[4];
    assert!((tip - Vec3::new(0.0, 3.0, 5.0)).length() < 1e-6, "{tip}");
}

#[test]
fn joints_follow_the_animation_and_morphs_come_before_skins() {
    let mut d = skinned();
    animate(&mut d, (3, "rotation"), "LINEAR", &[0.0, 2.0], &[[0.0, 0.0, 0.0, 1.0], QUARTER]);
    for (seconds, angle) in [(0.0, 0.0), (1.0, 0.5), (5.0, 1.0_f32)] {
        let turn = Quat::from_array(QUARTER);
        let turn = Affine3A::from_quat(Quat::IDENTITY.slerp(turn, angle));
        assert_bent(&load_at(&d, Some(seconds)).unwrap(), bent(turn), &format!("at {seconds} s"));
    }
    // A hidden skeleton moves its vertices, too.
    d.json["nodes"][3]["extensions"] = json!({ "KHR_node_visibility": { "visible": false } });
    let hidden = load_at(&d, Some(5.0)).unwrap();
    assert_bent(&hidden, bent(Affine3A::from_quat(Quat::from_array(QUARTER))), "hidden");
    // A morph target moves the tip by 3 m along x before the joint turns it up.
    let moves = d.vec3(&[[0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3], [3.0, 0.0, 0.0], [0.0; 3]]);
    d.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": moves }]);
    d.json["nodes"][0]["weights"] = json!([1]);
    let tip = load_at(&d, Some(5.0)).unwrap().meshes()[0].positions()[4];
    assert!((tip - Vec3::new(-1.0, 4.0, 5.0)).length() < 2e-6, "{tip}");
}

/// Vertices follow six joints by a sixth each. The joints are in two sets with 16-bit numbers, and
/// the weights add up to two.
#[test]
fn further_sets_count_and_weights_add_up_to_one() {
    let mut d = skinned();
    d.json["nodes"] = json!([{ "mesh": 0, "skin": 0 }]);
    let joints: Vec<usize> = (0..6).map(|k| d.push("nodes", json!({ "translation": [k, 0, 0] }))).collect();
    d.json["skins"][0] = json!({ "joints": joints });
    let numbers = |d: &mut Document, four: [u16; 4]| {
        let view = d.view(&[four; 6].concat().iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>());
        d.push("accessors", json!({ "bufferView": view, "componentType": 5123, "count": 6, "type": "VEC4" }))
    };
    let (first, second) = (numbers(&mut d, [0, 1, 2, 3]), numbers(&mut d, [4, 5, 0, 0]));
    let weights = |d: &mut Document, four: [u8; 4]| {
        let view = d.view(&[four; 6].concat());
        let json = json!({ "bufferView": view, "componentType": 5121, "normalized": true, "count": 6, "type": "VEC4" });
        d.push("accessors", json)
    };
    let (all, half) = (weights(&mut d, [85; 4]), weights(&mut d, [85, 85, 0, 0]));
    let attributes = &mut d.json["meshes"][0]["primitives"][0]["attributes"];
    (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (json!(first), json!(all));
    (attributes["JOINTS_1"], attributes["WEIGHTS_1"]) = (json!(second), json!(half));
    let scene = d.load().unwrap();
    assert_eq!(notes(&scene), []);
    let tip = scene.meshes()[0].positions()[4];
    assert!((tip - Vec3::new(2.5, 2.0, 0.0)).length() < 1e-6, "the mean of 0 to 5: {tip}");
}

fn exposed(d: &Document, shutter: [f64; 2]) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let options = LoadOptions { shutter: Some(shutter), ..LoadOptions::default() };
    load_in(folder.path(), "scene.glb", &d.glb(), &options).unwrap()
}

/// World corners of the first triangle of an instance at a fraction of the shutter's time.
fn corners_at(scene: &Scene, instance: usize, share: f32) -> [Vec3; 3] {
    scene.world_corners_at(share, scene.instance_ids().nth(instance).unwrap(), 0)
}

#[track_caller]
fn assert_close(found: [Vec3; 3], expected: [Vec3; 3], what: &str) {
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            (*found - expected).length() < 5e-6 * (1.0 + expected.length()),
            "{what}: {found} for {expected}"
        );
    }
}

/// Four nodes: one morphs and moves, one stands and morphs, one has constant weights, and one has a
/// skin whose joint turns. Each has its expected corners at several times.
#[test]
fn shapes_change_while_the_shutter_is_open() {
    let mut d = morphing();
    d.json["meshes"][0]["weights"] = json!([0.5, 0.5]);
    d.push("nodes", json!({ "mesh": 0, "translation": [0, 0, 9] }));
    d.push("nodes", json!({ "mesh": 0 }));
    let weights = [[0.0], [1.0], [1.0], [-1.0]];
    animate(&mut d, (0, "weights"), "LINEAR", &[0.0, 4.0], &weights);
    animate(&mut d, (0, "translation"), "LINEAR", &[0.0, 4.0], &[[0.0; 3], [8.0, 0.0, 0.0]]);
    animate(&mut d, (1, "weights"), "LINEAR", &[0.0, 4.0], &weights);
    let at = |seconds: f32| morphed([0.25 * seconds, 1.0 - 0.5 * seconds]);
    let scene = exposed(&d, [1.0, 3.0]);
    assert_eq!((scene.shutter(), notes(&scene)), (Some([1.0, 3.0]), Vec::new()));
    // The mesh has two shapes: one for the first two nodes, one for the third.
    assert_eq!((scene.meshes().len(), scene.instances().len()), (2, 3));
    let deform: Vec<bool> = scene.meshes().iter().map(|mesh| mesh.deforms().is_some()).collect();
    assert_eq!(deform, [true, false]);
    for share in [0.0, 0.25, 0.5, 1.0_f32] {
        let (seconds, what) = (1.0 + 2.0 * share, format!("after {share}"));
        assert_close(corners_at(&scene, 0, share), at(seconds).map(|v| v + Vec3::X * 2.0 * seconds), &what);
        assert_close(corners_at(&scene, 1, share), at(seconds).map(|v| v + Vec3::Z * 9.0), &what);
        assert_close(corners_at(&scene, 2, share), morphed([0.5, 0.5]), &what);
    }
    assert_eq!(scene.time(), Some(2.0));
    // After the last key nothing moves. A shutter that closes at once shows no motion, either.
    for still in [exposed(&d, [4.0, 5.0]), exposed(&d, [2.0, 2.0]), load_at(&d, Some(2.0)).unwrap()] {
        assert!(!still.moves());
    }
    assert_corners(&exposed(&d, [4.0, 5.0]), 0, at(4.0), "at the end");
    assert_corners(&exposed(&d, [2.0, 2.0]), 0, at(2.0), "closed at once");

    let mut d = skinned();
    animate(&mut d, (3, "rotation"), "LINEAR", &[0.0, 2.0], &[[0.0, 0.0, 0.0, 1.0], QUARTER]);
    // A motion of the mesh's own node has no effect on a skin.
    animate(&mut d, (0, "translation"), "LINEAR", &[0.0, 2.0], &[[0.0; 3], [9.0; 3]]);
    let scene = exposed(&d, [0.0, 1.0]);
    assert!(notes(&scene).is_empty() && scene.instances().len() == 1 && scene.moves());
    let eighth = Affine3A::from_quat(Quat::IDENTITY.slerp(Quat::from_array(QUARTER), 0.5));
    let (open, close) = (bent(Affine3A::IDENTITY), bent(eighth));
    let id = scene.instance_ids().next().unwrap();
    for share in [0.0, 0.3, 1.0_f32] {
        // The last triangle has the vertices 4, 3 and 5.
        let expected = [4, 3, 5].map(|v| open[v].0.lerp(close[v].0, share));
        assert_close(scene.world_corners_at(share, id, 3), expected, &format!("bent after {share}"));
        let tip = scene.surface_point_at(share, id, 3, [1.0, 0.0, 0.0]);
        let normal = open[4].1.lerp(close[4].1, share).normalize();
        assert!((tip.shading_normal - normal).length() < 1e-5, "{}", tip.shading_normal);
    }
}

#[test]
fn what_is_wrong_with_weights_and_joints_is_said() {
    // One weight more than there are targets, and one weight less.
    for (weights, expected) in [(json!([0.5, 0.25, 7]), [0.5, 0.25]), (json!([0.5]), [0.5, 0.0])] {
        let mut d = morphing();
        d.json["nodes"][0]["weights"] = weights;
        let scene = d.load().unwrap();
        assert!(
            only_note(&scene, NoteKind::Repaired, "not as many as the morph targets"),
            "{:?}",
            notes(&scene)
        );
        assert_corners(&scene, 0, morphed(expected), "as far as there are");
    }
    // A primitive without joints has the transform of its node.
    let mut d = skinned();
    d.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("WEIGHTS_0");
    let scene = d.load().unwrap();
    let said: Vec<String> = notes(&scene).into_iter().map(|(_, message)| message).collect();
    assert!(said.len() == 2 && said[0].contains("joints without weights"), "{said:?}");
    assert!(said[1].contains("where their node is"), "{said:?}");
    assert_eq!(Vec3::from(scene.instances()[0].to_world.translation), Vec3::new(50.0, 60.0, 75.0));
    // With invalid weights the tip follows the first joint; the other vertices are unchanged.
    for wrong in [[0.0, 0.0], [f32::NAN, -1.0]] {
        let mut d = skinned();
        d.json["nodes"][3]["rotation"] = json!(QUARTER);
        let weights = [[1.0, 0.0], [1.0, 0.0], [0.5, 0.5], [0.5, 0.5], wrong, [0.0, 1.0]];
        let weights = accessor(&mut d, &weights.map(|[a, b]| [a, b, 0.0, 0.0]));
        d.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
        let scene = d.load().unwrap();
        let said: Vec<String> = notes(&scene).into_iter().map(|(_, message)| message).collect();
        assert_eq!(said.len(), if wrong[0] == 0.0 { 1 } else { 2 }, "{said:?}");
        assert!(said.last().unwrap().contains("they follow the first"), "{said:?}");
        let positions = scene.meshes()[0].positions();
        assert!((positions[4] - Vec3::new(0.0, 2.0, 5.0)).length() < 1e-6, "{}", positions[4]);
        assert!((positions[5] - Vec3::new(-1.0, 1.0, 6.0)).length() < 1e-6, "{}", positions[5]);
    }
    // A matrix whose last row is a projection is repaired.
    let mut d = skinned();
    let end = d.buffer.len();
    d.buffer[end - 4..].copy_from_slice(&2.0_f32.to_le_bytes());
    let scene = d.load().unwrap();
    assert!(only_note(&scene, NoteKind::Repaired, "inverse bind matrices whose last row"));
    assert_bent(&scene, bent(Affine3A::IDENTITY), "affine");
}

#[test]
fn damaged_shapes_are_refused_with_their_place() {
    type Damage = fn(&mut Document);
    fn attributes(d: &mut Document) -> &mut Value {
        &mut d.json["meshes"][0]["primitives"][0]["attributes"]
    }
    let damages: [(bool, Damage, &str, &str); 15] = [
        (
            true,
            |d| {
                let second = end_of_joints(d) - 3;
                d.buffer[second] = 2;
            },
            "JOINTS_0",
            "joint 2 of a skin of 2",
        ),
        (true, |d| d.json["skins"][0]["joints"] = json!([2, 9]), "skins[0].joints[1]", "out of range"),
        (true, |d| d.json["skins"][0]["joints"] = json!([]), "JOINTS_0", "below 0"),
        (true, |d| d.json["skins"][0]["joints"] = json!([2, 3, 1]), "inverseBindMatrices", "3, one for each"),
        (true, |d| d.json["skins"][0]["inverseBindMatrices"] = json!(0), "inverseBindMatrices", "Mat4"),
        (true, |d| d.json["nodes"][0]["skin"] = json!(1), "nodes[0].skin", "out of range"),
        (
            true,
            |d| {
                let end = d.buffer.len();
                d.buffer[end - 16..end - 12].copy_from_slice(&f32::INFINITY.to_le_bytes());
            },
            "inverseBindMatrices",
            "finite numbers",
        ),
        (true, |d| attributes(d)["JOINTS_0"] = json!(0), "JOINTS_0", "Vec4"),
        (true, |d| attributes(d)["JOINTS_0"] = attributes(d)["WEIGHTS_0"].clone(), "JOINTS_0", "U8"),
        (true, |d| d.json["accessors"][4]["count"] = json!(5), "WEIGHTS_0", "6, one for each POSITION"),
        (true, |d| d.json["accessors"][4]["count"] = json!(4_000_000_000_u32), "WEIGHTS_0", "fit into"),
        (false, |d| d.json["nodes"][0]["weights"] = json!([1e300, 0]), "nodes[0].weights", "finite"),
        (false, |d| d.json["meshes"][0]["weights"] = json!([1e300, 0]), "meshes[0].weights", "finite"),
        (false, |d| d.json["accessors"][2]["count"] = json!(2), "targets[0].POSITION", "3, one for each"),
        (
            false,
            |d| {
                let targets = &mut d.json["meshes"][0]["primitives"][0]["targets"];
                targets[0]["POSITION"] = json!(99);
            },
            "targets[0]",
            "out of range",
        ),
    ];
    for (i, (has_skin, damage, place, said)) in damages.into_iter().enumerate() {
        let mut d = if has_skin { skinned() } else { morphing() };
        if !has_skin {
            d.json["meshes"][0]["weights"] = json!([1, 1]);
        }
        damage(&mut d);
        let error = load_at(&d, None).unwrap_err();
        assert!(matches!(error, Error::Invalid { .. }), "{i}: {error}");
        let text = error.to_string();
        assert!(text.contains("scene.glb: ") && text.contains(place) && text.contains(said), "{i}: {text}");
    }
    // Weights of animations must be finite, and their number must match the keys and targets.
    for (values, said) in [(vec![[1.0]; 3], "4, as the keys need"), (vec![[f32::NAN]; 4], "finite numbers")] {
        let mut d = morphing();
        animate(&mut d, (0, "weights"), "LINEAR", &[1.0, 3.0], &values);
        let text = load_at(&d, Some(2.0)).unwrap_err().to_string();
        assert!(text.contains("animations[0].channels[0].sampler") && text.contains(said), "{text}");
        assert!(load_at(&d, None).is_ok(), "nobody asked");
    }
}

/// End of the bytes that store the bar's joints.
fn end_of_joints(d: &Document) -> usize {
    let view = &d.json["bufferViews"][3];
    (view["byteOffset"].as_u64().unwrap() + view["byteLength"].as_u64().unwrap()) as usize
}

/// A thousand nodes refer to a thousand targets of the same vertices, each node in another shape.
/// The reader stays within its budget.
#[test]
fn naming_the_same_targets_many_times_does_not_take_for_ever() {
    let mut d = morphing();
    let vertices = 3 * 10_000;
    let corners: Vec<[f32; 3]> = (0..vertices).map(|i| CORNERS[i % 3]).collect();
    let positions = d.vec3(&corners);
    d.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(positions);
    d.json["meshes"][0]["primitives"][0]["targets"] = json!(vec![json!({ "POSITION": positions }); 1000]);
    for k in 1..1000 {
        d.push("nodes", json!({ "mesh": 0, "weights": vec![k; 1000] }));
    }
    let folder = tempfile::tempdir().unwrap();
    let options = LoadOptions { max_file_bytes: 1 << 24, ..LoadOptions::default() };
    let text = load_in(folder.path(), "scene.glb", &d.glb(), &options).unwrap_err().to_string();
    assert!(text.contains("targets[") && text.contains("geometry"), "{text}");
}
