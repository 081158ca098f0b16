//! Animations of glTF: transforms of nodes, cameras and lights at a time, and damaged animations.

use glam::{Affine3A, Mat3, Quat, Vec3};
use serde_json::{Value, json};
use tashika::error::{Error, Result};
use tashika::io::LoadOptions;
use tashika::math::elementary::rotation;
use tashika::scene::{Emitter, NoteKind, Scene};

use super::gltf::{Document, load_in, notes, only_note};

/// A quarter turn about z.
pub const QUARTER: [f32; 4] = [0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2, std::f32::consts::FRAC_1_SQRT_2];

fn load_at(d: &Document, at: Option<f64>) -> Result<Scene> {
    let folder = tempfile::tempdir().unwrap();
    load_in(folder.path(), "scene.glb", &d.glb(), &LoadOptions { at, ..LoadOptions::default() })
}

fn at(d: &Document, seconds: f64) -> Scene {
    load_at(d, Some(seconds)).unwrap()
}

fn placed(scene: &Scene) -> Affine3A {
    scene.instances()[0].to_world
}

/// An accessor of numbers or vectors of `N` components.
pub fn accessor<const N: usize>(d: &mut Document, values: &[[f32; N]]) -> usize {
    let bytes: Vec<u8> = values.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    let view = d.view(&bytes);
    let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
    let mut json = json!({ "bufferView": view, "componentType": 5126, "count": values.len(), "type": kind });
    if let (1, Some(first), Some(last)) = (N, values.first(), values.last()) {
        (json["min"], json["max"]) = (json!([first[0]]), json!([last[0]]));
    }
    d.push("accessors", json)
}

/// Adds an animation that moves one property of a node.
pub fn animate<const N: usize>(
    d: &mut Document,
    (node, path): (usize, &str),
    interpolation: &str,
    times: &[f32],
    values: &[[f32; N]],
) -> Value {
    let times: Vec<[f32; 1]> = times.iter().map(|&t| [t]).collect();
    let (input, output) = (accessor(d, &times), accessor(d, values));
    let animation = json!({
        "channels": [{ "sampler": 0, "target": { "node": node, "path": path } }],
        "samplers": [{ "input": input, "output": output, "interpolation": interpolation }],
    });
    d.push("animations", animation.clone());
    animation
}

/// The triangle moves along x from 1 to 3 m, between 2 and 4 s.
fn walking() -> Document {
    let mut d = Document::triangle();
    d.json["nodes"][0]["translation"] = json!([0, 7, 0]);
    animate(&mut d, (0, "translation"), "LINEAR", &[2.0, 4.0], &[[1.0, 0.0, 0.0], [3.0, 0.0, 0.0]]);
    d
}

#[test]
fn a_scene_is_as_it_is_at_the_time_that_is_asked_for() {
    let d = walking();
    let place = |seconds: f64| Vec3::from(placed(&at(&d, seconds)).translation);
    for (seconds, x) in [(-1e9, 1.0), (2.0, 1.0), (2.5, 1.5), (3.0, 2.0), (4.0, 3.0), (1e9, 3.0)] {
        assert_eq!(place(seconds), Vec3::new(x, 0.0, 0.0), "at {seconds}");
    }
    let scene = at(&d, 3.0);
    assert_eq!(notes(&scene), []);
    assert_eq!((scene.animated_seconds(), scene.time()), (Some([2.0, 4.0]), Some(3.0)));
    // Without a time the transforms of the nodes apply, and a note reports the motion.
    let still = load_at(&d, None).unwrap();
    assert_eq!(Vec3::from(placed(&still).translation), Vec3::new(0.0, 7.0, 0.0));
    assert!(only_note(&still, NoteKind::Ignored, "without a time (`--at`) left out"));
    assert_eq!((still.animated_seconds(), still.time()), (Some([2.0, 4.0]), None));
    // Scenes at different times have different digests; without motion the time has no effect on
    // it.
    let digests = [still.digest(), at(&d, 3.0).digest(), at(&d, 3.5).digest()];
    assert!(digests[0] != digests[1] && digests[1] != digests[2] && digests[1] == at(&d, 3.0).digest());
    let unmoved = Document::triangle();
    assert_eq!(at(&unmoved, 3.0).digest(), load_at(&unmoved, None).unwrap().digest());
    assert_eq!(at(&unmoved, 3.0).time(), None);
    for wrong in [f64::NAN, f64::INFINITY] {
        let said = load_at(&d, Some(wrong)).unwrap_err();
        assert!(matches!(said, Error::Option { .. }), "{said}");
    }
}

#[test]
fn every_interpolation_is_that_of_the_format() {
    let values = [[1.0_f32, 2.0, 0.0], [5.0, -2.0, 8.0]];
    let scale = |interpolation: &str, values: &[[f32; 3]]| {
        let mut d = Document::triangle();
        animate(&mut d, (0, "translation"), interpolation, &[1.0, 3.0], values);
        move |seconds: f64| Vec3::from(placed(&at(&d, seconds)).translation)
    };
    let step = scale("STEP", &values);
    assert_eq!([step(2.999), step(3.0)], values.map(Vec3::from));
    let linear = scale("LINEAR", &values);
    assert_eq!(linear(1.5), Vec3::new(2.0, 1.0, 2.0));
    // A cubic spline whose tangents are its derivatives is reproduced exactly: f = (t³, t², 1 − t).
    let f = |t: f32| [t * t * t, t * t, 1.0 - t];
    let tangent = |t: f32| [3.0 * t * t, 2.0 * t, -1.0];
    let unused = [1e6; 3];
    let keys = [unused, f(1.0), tangent(1.0), tangent(3.0), f(3.0), unused];
    let cubic = scale("CUBICSPLINE", &keys);
    for t in [1.0, 1.25, 2.0, 2.75, 3.0, 9.0_f32] {
        let (found, expected) = (cubic(f64::from(t)), Vec3::from(f(t.min(3.0))));
        assert!((found - expected).length() < 1e-5, "at {t}: {found}, not {expected}");
    }
}

#[test]
fn rotations_turn_at_constant_speed_by_the_shorter_way() {
    for (sign, interpolation) in [(1.0, "LINEAR"), (-1.0, "LINEAR"), (1.0, "STEP")] {
        let mut d = Document::triangle();
        let end = QUARTER.map(|x| sign * x);
        animate(&mut d, (0, "rotation"), interpolation, &[0.0, 3.0], &[[0.0, 0.0, 0.0, 1.0], end]);
        for t in [0.0, 1.0, 2.5, 3.0] {
            let share = if interpolation == "STEP" { f32::floor(t / 3.0) } else { t / 3.0 };
            let angle = std::f32::consts::FRAC_PI_2 * share;
            let expected = Affine3A::from_quat(rotation(Vec3::Z, angle));
            assert!(placed(&at(&d, f64::from(t))).abs_diff_eq(expected, 1e-6), "{sign} {interpolation} {t}");
        }
    }
    // A spline of quaternions is normalised.
    let mut d = Document::triangle();
    let (none, zero) = ([0.0, 0.0, 0.0, 1.0], [0.0; 4]);
    animate(&mut d, (0, "rotation"), "CUBICSPLINE", &[0.0, 1.0], &[zero, none, zero, zero, QUARTER, zero]);
    let half = placed(&at(&d, 0.5));
    let expected = Affine3A::from_quat(rotation(Vec3::Z, std::f32::consts::FRAC_PI_4));
    assert!(half.abs_diff_eq(expected, 1e-6), "{half:?}");
}

/// A parent node turns, its child grows, and a camera and a lamp are attached to the child. All are
/// at their positions at the requested time.
#[test]
fn what_hangs_on_a_node_moves_with_it() {
    let mut d = Document::triangle();
    d.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }]);
    d.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    d.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    d.json["nodes"][0]["translation"] = json!([1, 0, 0]);
    d.push("nodes", json!({ "children": [0, 2, 3] }));
    d.push("nodes", json!({ "camera": 0, "translation": [0, 0, 5] }));
    let lamp = json!({ "translation": [2, 0, 0], "extensions": { "KHR_lights_punctual": { "light": 0 } } });
    d.push("nodes", lamp);
    d.push("scenes", json!({ "nodes": [1] }));
    animate(&mut d, (1, "rotation"), "LINEAR", &[0.0, 1.0], &[[0.0, 0.0, 0.0, 1.0], QUARTER]);
    animate(&mut d, (0, "scale"), "LINEAR", &[0.0, 1.0], &[[1.0; 3], [3.0, 1.0, 1.0]]);
    let scene = at(&d, 1.0);
    let to_world = placed(&scene);
    // The corner at (2, 0, 0) is stretched to 6, moved to 7 and turned up.
    assert!((to_world.transform_point3(Vec3::new(2.0, 0.0, 0.0)) - Vec3::new(0.0, 7.0, 0.0)).length() < 1e-5);
    let camera = &scene.cameras()[0];
    assert!((camera.position() - Vec3::new(0.0, 0.0, 5.0)).length() < 1e-5);
    assert!((camera.to_world.transform_vector3(Vec3::X) - Vec3::Y).length() < 1e-5, "it is turned too");
    let Emitter::Point { position, .. } = scene.emitters()[0] else { panic!("a point") };
    assert!((position - Vec3::new(0.0, 2.0, 0.0)).length() < 1e-5, "{position}");
}

#[test]
fn cameras_move_while_the_shutter_is_open() {
    let mut d = walking();
    d.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }]);
    // One camera is attached to a node that turns; another camera stands still.
    d.push("nodes", json!({ "children": [2], "translation": [0, 0, 1] }));
    d.push("nodes", json!({ "camera": 0, "translation": [2, 0, 0], "scale": [3, 3, 3] }));
    d.push("nodes", json!({ "camera": 0 }));
    animate(&mut d, (1, "rotation"), "LINEAR", &[0.0, 1.0], &[[0.0, 0.0, 0.0, 1.0], QUARTER]);
    let exposed = |at: Option<f64>, shutter: [f64; 2]| {
        let folder = tempfile::tempdir().unwrap();
        let options = LoadOptions { at, shutter: Some(shutter), ..LoadOptions::default() };
        load_in(folder.path(), "scene.glb", &d.glb(), &options).unwrap()
    };
    let scene = exposed(Some(0.5), [-0.25, 0.5]);
    let motion = scene.cameras()[0].motion.as_ref().unwrap();
    assert_eq!(motion.shutter, [0.25, 1.0]);
    for share in [0.0, 0.3, 1.0_f32] {
        let turn =
            Affine3A::from_quat(rotation(Vec3::Z, std::f32::consts::FRAC_PI_2 * (0.25 + 0.75 * share)));
        let expected = Affine3A::from_translation(Vec3::Z) * turn * Affine3A::from_translation(Vec3::X * 2.0);
        // The motion is interpolated between 33 keys. The chord of a thirty-second of the turn is
        // off by at most 2 (1 − cos(0.375 π / 64)) = 3.4e-4.
        assert!(motion.pose(share).abs_diff_eq(expected, 4e-4), "{share}: {:?}", motion.pose(share));
    }
    assert!(scene.cameras()[1].motion.is_none());
    // The triangle begins to move after two seconds. Without a requested time, the middle of the
    // shutter's interval applies.
    assert_eq!((notes(&scene), scene.time()), (Vec::new(), Some(0.625)));
    assert!(!scene.moves());
    let walks = exposed(None, [2.5, 3.5]);
    assert!(walks.moves() && notes(&walks).is_empty());
    assert_eq!(placed(&walks).translation.x, 2.0);
    assert!(walks.cameras()[0].motion.is_none(), "it has turned before");
    assert!(exposed(Some(0.5), [0.0, 0.0]).cameras()[0].motion.is_none(), "closed at once");
    assert!(load_at(&d, None).unwrap().cameras()[0].motion.is_none(), "glTF has no shutter of its own");
}

/// A mesh makes two whole turns, so that its pose is the same at both ends and in the middle of the
/// time. Between them it moves.
#[test]
fn meshes_move_while_the_shutter_is_open() {
    let mut d = Document::triangle();
    d.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    d.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    d.json["nodes"][0]["translation"] = json!([1, 0, 0]);
    d.push("nodes", json!({ "children": [0, 2], "scale": [2, 2, 2] }));
    d.push("nodes", json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
    d.push("nodes", json!({ "mesh": 0 }));
    d.push("scenes", json!({ "nodes": [1, 3] }));
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let quarters =
        [[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, half, half], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, half, -half]];
    let turns: Vec<[f32; 4]> = (0..9).map(|k| quarters[k % 4]).collect();
    let times: Vec<f32> = (0..9).map(|k| 0.125 * k as f32).collect();
    animate(&mut d, (1, "rotation"), "LINEAR", &times, &turns);
    let exposed = |d: &Document, shutter: [f64; 2]| {
        let folder = tempfile::tempdir().unwrap();
        let options = LoadOptions { shutter: Some(shutter), ..LoadOptions::default() };
        load_in(folder.path(), "scene.glb", &d.glb(), &options).unwrap()
    };
    let scene = exposed(&d, [0.0, 1.0]);
    assert_eq!(scene.shutter(), Some([0.0, 1.0]));
    let ids: Vec<_> = scene.instance_ids().collect();
    assert!(scene.motion_of(ids[0]).is_some() && scene.motion_of(ids[1]).is_none());
    for share in [0.0, 0.3, 0.5, 1.0_f32] {
        let turn = Affine3A::from_quat(rotation(Vec3::Z, 4.0 * std::f32::consts::PI * share));
        let expected = turn * Affine3A::from_scale(Vec3::splat(2.0)) * Affine3A::from_translation(Vec3::X);
        let found = scene.moved(ids[0], share).unwrap().to_world;
        // The chord of a sixteenth of a turn is off by at most 2 (1 − cos(π/16)) = 0.0385.
        assert!(found.abs_diff_eq(expected, 0.039), "{share}: {found:?}");
        assert!(Mat3::from(found.matrix3).abs_diff_eq(Mat3::from(expected.matrix3), 1e-5), "{found:?}");
    }
    assert!(only_note(&scene, NoteKind::Approximated, "lights that move: where they are in the middle"));
    assert!(!exposed(&d, [0.5, 0.5]).moves() && !exposed(&d, [2.0, 3.0]).moves());
    // An object that shrinks to zero keeps the pose at the middle of the time.
    let mut d = Document::triangle();
    animate(&mut d, (0, "scale"), "LINEAR", &[0.0, 1.0], &[[1.0; 3], [0.0; 3]]);
    let scene = exposed(&d, [0.0, 1.0]);
    assert!(!scene.moves() && placed(&scene).abs_diff_eq(Affine3A::from_scale(Vec3::splat(0.5)), 1e-6));
    assert!(only_note(&scene, NoteKind::Approximated, "meshes that cannot be inverted at all times"));
}

#[test]
fn what_cannot_be_shown_is_said() {
    let mut d = walking();
    // A second animation of the same property, one of morph targets that do not exist, one with a
    // pointer, and a channel without a target.
    animate(&mut d, (0, "translation"), "STEP", &[0.0], &[[9.0; 3]]);
    animate(&mut d, (0, "weights"), "LINEAR", &[0.0, 1.0], &[[0.0], [1.0]]);
    animate(&mut d, (0, "weights"), "LINEAR", &[0.0, 1.0], &[[0.0], [1.0]]);
    let mut pointer = animate(&mut d, (0, "pointer"), "STEP", &[0.0], &[[1.0]]);
    pointer["channels"][0]["target"] = json!({ "path": "rotation" });
    d.push("animations", pointer);
    d.push("nodes", json!({ "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1], "mesh": 0 }));
    animate(&mut d, (1, "translation"), "STEP", &[0.0], &[[9.0; 3]]);
    let scene = at(&d, 3.0);
    let told: Vec<String> =
        scene.notes().iter().map(|n| format!("{} {}x {}", n.first, n.count, n.message)).collect();
    let has = |part: &str| told.iter().any(|line| line.contains(part));
    assert!(
        has("animations[1].channels[0].target 1x animations of what another one moves already"),
        "{told:?}"
    );
    assert!(has("animations[2].channels[0].target.node 2x animated weights of nodes without"), "{told:?}");
    assert!(has("1x animation \"pointer\": what it moves stays as it is"), "{told:?}");
    assert!(has("animations[6].channels[0].target.node 1x animations of nodes with a matrix"), "{told:?}");
    let places: Vec<f32> = scene.instances().iter().map(|i| i.to_world.translation.x).collect();
    assert_eq!(places, [2.0, 5.0]);
}

#[test]
fn times_that_do_not_rise_are_sorted_and_missing_keys_left_out() {
    let mut d = Document::triangle();
    let values = [[3.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [7.0, 0.0, 0.0]];
    animate(&mut d, (0, "translation"), "LINEAR", &[4.0, 0.0, 2.0, 2.0], &values);
    for (seconds, x) in [(1.0, 1.5), (2.0, 7.0), (3.0, 5.0), (9.0, 3.0)] {
        let scene = at(&d, seconds);
        assert!(only_note(&scene, NoteKind::Repaired, "times do not rise"), "{:?}", notes(&scene));
        assert_eq!(placed(&scene).translation.x, x, "at {seconds}");
    }
    let mut d = Document::triangle();
    animate::<3>(&mut d, (0, "translation"), "LINEAR", &[], &[]);
    d.json["accessors"].as_array_mut().unwrap().iter_mut().skip(2).for_each(|accessor| {
        accessor.as_object_mut().unwrap().remove("bufferView");
    });
    let scene = at(&d, 1.0);
    assert!(only_note(&scene, NoteKind::Repaired, "animations without keys"), "{:?}", notes(&scene));
    assert_eq!(placed(&scene), Affine3A::IDENTITY);
    // A rotation of zero length is ignored.
    let mut d = Document::triangle();
    animate(&mut d, (0, "rotation"), "LINEAR", &[0.0, 1.0], &[[0.0; 4]; 2]);
    let scene = at(&d, 0.5);
    assert!(only_note(&scene, NoteKind::Repaired, "no quaternion"), "{:?}", notes(&scene));
    assert_eq!(placed(&scene), Affine3A::from_quat(Quat::IDENTITY));
    // An object that is scaled to zero has no instance.
    let mut d = Document::triangle();
    animate(&mut d, (0, "scale"), "LINEAR", &[0.0, 1.0], &[[1.0; 3], [0.0; 3]]);
    assert_eq!((at(&d, 0.9).instances().len(), at(&d, 1.0).instances().len()), (1, 0));
}

#[test]
fn damaged_animations_are_refused_with_their_place_if_a_time_is_asked_for() {
    type Damage = fn(&mut Document);
    let damages: [(Damage, &str, &str); 12] = [
        (|d| d.json["animations"][0] = json!("none"), "animations[0]", "cannot be read"),
        (|d| d.json["animations"][0]["channels"][0]["sampler"] = json!(1), ".sampler", "below 1"),
        (
            |d| d.json["animations"][0]["channels"][0]["sampler"] = json!(-1),
            "animations[0]",
            "cannot be read",
        ),
        (|d| d.json["animations"][0]["channels"][0]["target"]["node"] = json!(5), ".target.node", "below 1"),
        (|d| d.json["animations"][0]["samplers"][0]["input"] = json!(99), ".sampler", "below 4"),
        (
            |d| d.json["animations"][0]["samplers"][0]["output"] = json!(4_000_000_000_u32),
            ".sampler",
            "below 4",
        ),
        (
            |d| d.json["animations"][0]["samplers"][0]["interpolation"] = json!("SINE"),
            "animations[0]",
            "SINE",
        ),
        (|d| d.json["animations"][0]["samplers"][0]["interpolation"] = json!("CUBICSPLINE"), ".sampler", "6"),
        (|d| d.json["accessors"][3]["count"] = json!(1), ".sampler", "expected 2"),
        (|d| d.json["accessors"][3]["type"] = json!("VEC4"), ".sampler", "Vec3"),
        (
            |d| {
                let end = d.buffer.len();
                d.buffer[end - 24..end - 20].copy_from_slice(&f32::NAN.to_le_bytes());
            },
            ".sampler",
            "finite numbers",
        ),
        (
            |d| {
                let end = d.buffer.len();
                d.buffer[end - 32..end - 28].copy_from_slice(&f32::INFINITY.to_le_bytes());
            },
            ".sampler",
            "finite times",
        ),
    ];
    for (i, (damage, place, said)) in damages.into_iter().enumerate() {
        let mut d = walking();
        damage(&mut d);
        let error = load_at(&d, Some(3.0)).unwrap_err();
        assert!(matches!(error, Error::Invalid { .. }), "{i}: {error}");
        let text = error.to_string();
        assert!(text.contains("scene.glb: animations[0]") && text.contains(place), "{i}: {text}");
        assert!(text.contains(said), "{i}: {text}");
        assert!(load_at(&d, None).is_ok(), "{i}: nobody asked");
    }
}

/// Ten thousand channels refer to the same ten thousand keys. The reader stays within its budget.
#[test]
fn naming_the_same_keys_many_times_does_not_take_for_ever() {
    let mut d = Document::triangle();
    let times: Vec<f32> = (0..10_000_u16).map(f32::from).collect();
    let values: Vec<[f32; 3]> = times.iter().map(|&t| [t, 0.0, 0.0]).collect();
    let mut animation = animate(&mut d, (0, "translation"), "LINEAR", &times, &values);
    for node in 1..10_000 {
        d.push("nodes", json!({}));
        let channel = json!({ "sampler": 0, "target": { "node": node, "path": "translation" } });
        animation["channels"].as_array_mut().unwrap().push(channel);
    }
    d.json["animations"] = json!([animation]);
    let folder = tempfile::tempdir().unwrap();
    let options = LoadOptions { at: Some(0.5), max_file_bytes: 1 << 22, ..LoadOptions::default() };
    let error = load_in(folder.path(), "s.glb", &d.glb(), &options).unwrap_err().to_string();
    assert!(error.contains("animations[0].channels[") && error.contains("geometry"), "{error}");
}
