//! Motion in files of pbrt and Mitsuba, at a requested time or while the shutter is open.

use glam::{Affine3A, Vec3};
use tashika::error::Result;
use tashika::io::{LoadOptions, load_scene};
use tashika::math::elementary::rotation;
use tashika::scene::{NoteKind, Scene};

use super::pbrt::{TRIANGLE, V3, V4};

fn load(name: &str, text: &str, at: Option<f64>) -> Result<Scene> {
    load_with(name, text, (at, None))
}

fn load_with(name: &str, text: &str, (at, shutter): (Option<f64>, Option<[f64; 2]>)) -> Result<Scene> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    load_scene(&path, &LoadOptions { at, shutter, ..LoadOptions::default() })
}

/// Interval in which the shutter of the first camera is open, and the camera's position at its
/// start, middle and end.
fn exposed(scene: &Scene) -> ([f64; 2], [Vec3; 3]) {
    let camera = &scene.cameras()[0];
    let motion = camera.motion.as_ref().expect("it moves");
    let place = |share| Vec3::from(motion.pose(share).translation);
    assert!((place(0.5) - camera.position()).length() < 1e-6);
    (motion.shutter, [place(0.0), place(0.5), place(1.0)])
}

fn pbrt(text: &str, at: Option<f64>) -> Scene {
    load("scene.pbrt", text, at).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn mitsuba(body: &str, at: Option<f64>) -> Scene {
    let text = format!("<scene version=\"3.0.0\">\n{body}\n</scene>\n");
    load("scene.xml", &text, at).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn has(scene: &Scene, kind: NoteKind, start: &str) -> bool {
    scene.notes().iter().any(|note| note.kind == kind && note.message.starts_with(start))
}

fn turned(degrees: f32) -> Affine3A {
    Affine3A::from_quat(rotation(Vec3::Z, degrees.to_radians()))
}

/// Motion from `1 0 0` to `1 0 4`, with a rotation by a right angle and growth from 1 to 3.
const MOVES: &str = "Translate 1 0 0 ActiveTransform EndTime Translate 0 0 4 Rotate 90 0 0 1 Scale 3 3 3 ActiveTransform All ";

#[test]
fn pbrt_moves_things_between_its_two_transforms() {
    let expected_at = |u: f32| {
        Affine3A::from_translation(Vec3::new(1.0, 0.0, 4.0 * u))
            * turned(90.0 * u)
            * Affine3A::from_scale(Vec3::splat(1.0 + 2.0 * u))
    };
    for begin in [V3, V4] {
        for (times, shift) in [("", 0.0), ("TransformTimes 2 4 ", 2.0)] {
            let text = format!("{}{begin}{MOVES}{TRIANGLE}", times);
            let length = if times.is_empty() { 1.0 } else { 2.0 };
            for u in [-1.0, 0.0, 0.25, 0.5, 1.0, 3.0_f32] {
                let scene = pbrt(&text, Some(shift + f64::from(u) * length));
                let (found, expected) = (scene.instances()[0].to_world, expected_at(u.clamp(0.0, 1.0)));
                assert!(found.abs_diff_eq(expected, 2e-6), "{times} {u}: {found:?}");
                assert!(!has(&scene, NoteKind::Approximated, "things that move"));
                assert_eq!(scene.animated_seconds(), Some([shift, shift + length]));
            }
            // The shutter is open for a second, from `shift` on.
            let open = format!("Camera \"perspective\" \"float shutteropen\" {shift} \"float shutterclose\"");
            let until = |close: f64| text.replace("Camera \"perspective\"", &format!("{open} {close}"));
            let moving = pbrt(&until(shift + 1.0), None);
            assert!(!has(&moving, NoteKind::Approximated, "things that move"));
            assert_eq!(moving.shutter(), Some([shift, shift + 1.0]));
            for share in [0.0, 0.5, 1.0_f32] {
                let id = moving.instance_ids().next().unwrap();
                let found = moving.moved(id, share).unwrap().to_world;
                assert!(found.abs_diff_eq(expected_at(share / length as f32), 2e-6), "{share}: {found:?}");
            }
            let still = pbrt(&until(shift), None);
            assert_eq!(still.instances()[0].to_world, Affine3A::from_translation(Vec3::X));
            assert!(has(&still, NoteKind::Approximated, "things that move: where they are first"));
            assert_eq!(still.animated_seconds(), Some([shift, shift + length]));
        }
    }
    // Motion inside an object and by named transforms. If a transform cancels the motion there is
    // no note.
    let text = format!(
        "{V4}ObjectBegin \"o\" {MOVES}{TRIANGLE} ObjectEnd AttributeBegin Translate 0 8 0 ObjectInstance \"o\" AttributeEnd"
    );
    let placed = pbrt(&text, Some(0.5)).instances()[0].to_world;
    assert!(
        placed.abs_diff_eq(Affine3A::from_translation(Vec3::Y * 8.0) * expected_at(0.5), 1e-5),
        "{placed:?}"
    );
    let text = format!("{V4}{MOVES}CoordinateSystem \"c\" Identity CoordSysTransform \"c\" {TRIANGLE}");
    assert!(pbrt(&text, Some(0.5)).instances()[0].to_world.abs_diff_eq(expected_at(0.5), 1e-5));
    let scene = pbrt(&format!("{V4}{MOVES}Identity {TRIANGLE}"), None);
    assert!(!has(&scene, NoteKind::Approximated, "things") && scene.animated_seconds().is_none());
    let scene = pbrt(&format!("TransformTimes 3 3 {V4}{MOVES}{TRIANGLE}"), Some(0.5));
    assert!(has(&scene, NoteKind::Repaired, "TransformTimes that do not rise"));
    assert!(scene.instances()[0].to_world.abs_diff_eq(expected_at(0.5), 1e-5));
    let scene = pbrt(&format!("{V4}ActiveTransform EndTime Scale 0 1 1 {TRIANGLE}"), Some(0.5));
    assert!(has(&scene, NoteKind::Repaired, "shapes and lights with") && scene.instances().is_empty());
}

/// A moving part of a moving object: its transform is the product at each time. If only one of the
/// two moves, the other is applied before or after it.
#[test]
fn parts_of_objects_of_pbrt_move_with_them() {
    let part = "ActiveTransform EndTime Translate 0 0 4 ActiveTransform All Scale 2 1 1 ";
    let whole = "ActiveTransform EndTime Rotate 90 0 0 1 ActiveTransform All Scale 1 3 1 ";
    let moved = |part: &str, whole: &str, share: f32| {
        let text = format!(
            "{V4}ObjectBegin \"o\" {part}{TRIANGLE} ObjectEnd AttributeBegin {whole}ObjectInstance \"o\" AttributeEnd"
        );
        let scene = pbrt(&text, None);
        assert_eq!((scene.shutter(), scene.notes().iter().count()), (Some([0.0, 1.0]), 0));
        scene.moved(scene.instance_ids().next().unwrap(), share).unwrap().to_world
    };
    let scale = |x, y| Affine3A::from_scale(Vec3::new(x, y, 1.0));
    for share in [0.0, 0.4, 1.0] {
        let slides = Affine3A::from_translation(Vec3::Z * 4.0 * share) * scale(2.0, 1.0);
        let turns = turned(90.0 * share) * scale(1.0, 3.0);
        let found = moved(part, "Scale 1 3 1 ", share);
        assert!(found.abs_diff_eq(scale(1.0, 3.0) * slides, 1e-5), "{share}: {found:?}");
        let found = moved("Scale 2 1 1 ", whole, share);
        assert!(found.abs_diff_eq(turns * scale(2.0, 1.0), 1e-5), "{share}: {found:?}");
        // Interpolated between 33 times of each product.
        let found = moved(part, whole, share);
        assert!(found.abs_diff_eq(turns * slides, 2e-3), "{share}: {found:?}");
    }
    // Lights, and objects that become their mirror image, stand still, with a note.
    let light = "ActiveTransform EndTime Translate 0 0 4 LightSource \"point\"";
    let scene = pbrt(&format!("{V4}{light} ActiveTransform All Identity {TRIANGLE}"), None);
    assert!(has(&scene, NoteKind::Approximated, "lights that move: where they are first"));
    assert!(!scene.moves());
    let scene = pbrt(&format!("{V4}ActiveTransform EndTime Scale -1 1 1 {TRIANGLE}"), None);
    assert!(has(&scene, NoteKind::Approximated, "things that turn into their mirror image, or flat: where"));
    assert!(!scene.moves() && scene.instances()[0].to_world == Affine3A::IDENTITY);
}

/// A pbrt camera moves between the inverses of its two transforms.
#[test]
fn cameras_of_pbrt_move_as_rigidly_as_their_file_says() {
    let text = format!(
        "ActiveTransform StartTime LookAt 0 0 0 0 0 1 0 1 0 \
         ActiveTransform EndTime LookAt 4 0 0 5 0 0 0 1 0 ActiveTransform All {V4}{TRIANGLE}"
    );
    let ahead = |at: Option<f64>| {
        // The shutter is closed explicitly: by default it is open during the whole motion.
        let text = text.replace("\"perspective\"", "\"perspective\" \"float shutterclose\" 0");
        let scene = pbrt(&text, at);
        let camera = &scene.cameras()[0];
        (camera.position(), camera.to_world.transform_vector3(Vec3::NEG_Z))
    };
    let (place, direction) = ahead(Some(0.5));
    let diagonal = std::f32::consts::FRAC_1_SQRT_2;
    assert!(
        (place - Vec3::X * 2.0).length() < 1e-6
            && (direction - Vec3::new(diagonal, 0.0, diagonal)).length() < 1e-6
    );
    assert_eq!(ahead(None), (Vec3::ZERO, Vec3::Z));
    assert!((ahead(Some(7.0)).0 - Vec3::X * 4.0).length() < 1e-6);
    let still = "cameras that move: where they are first";
    let closed = text.replace("\"perspective\"", "\"perspective\" \"float shutterclose\" 0");
    assert!(has(&pbrt(&closed, None), NoteKind::Approximated, still));
    // With the file's own shutter, from 0 to 1 s, nothing is approximated.
    let own = pbrt(&text, None);
    assert!(!has(&own, NoteKind::Approximated, "cameras"));
    let x = |x| Vec3::X * x;
    let (shutter, places) = exposed(&own);
    assert_eq!(shutter, [0.0, 1.0]);
    for (found, expected) in places.into_iter().zip([x(0.0), x(2.0), x(4.0)]) {
        assert!((found - expected).length() < 1e-6, "{found}");
    }
    let ahead = own.cameras()[0].motion.as_ref().unwrap().pose(0.5).transform_vector3(Vec3::NEG_Z);
    assert!((ahead - direction).length() < 1e-6, "it turns evenly, and is no mirror image meanwhile");
    // At a requested time nothing is blurred, unless a shutter is requested, too. Its interval is
    // then relative to that time.
    assert!(pbrt(&text, Some(0.5)).cameras()[0].motion.is_none());
    let (shutter, places) = exposed(&load_with("s.pbrt", &text, (Some(0.5), Some([-0.25, 0.25]))).unwrap());
    assert_eq!((shutter, places[1].x.round()), ([0.25, 0.75], 2.0));
    let text = text
        .replace("\"perspective\"", "\"perspective\" \"float shutteropen\" .75 \"float shutterclose\" .25");
    let turned = pbrt(&text, None);
    assert!(has(&turned, NoteKind::Repaired, "shutters that close before they open"));
    assert_eq!(exposed(&turned).0, [0.25, 0.75]);
    // The transform is a reflection at one end only.
    let text = format!("ActiveTransform EndTime Scale -1 1 1 ActiveTransform All {V4}{TRIANGLE}");
    let mirrored = pbrt(&text, None);
    assert!(mirrored.cameras()[0].motion.is_none());
    assert!(has(&mirrored, NoteKind::Approximated, "cameras that turn into their mirror image"));
    for spherical in ["\"spherical\" \"string mapping\" \"equirectangular\"", "\"spherical\""] {
        let text = format!(
            "ActiveTransform EndTime Translate 0 0 -2 ActiveTransform All Film \"rgb\" Camera {spherical} WorldBegin {TRIANGLE}"
        );
        let scene = pbrt(&text, None);
        let camera = &scene.cameras()[0];
        let motion = camera.motion.as_ref().unwrap();
        assert!((motion.pose(1.0).translation.z - 2.0).abs() < 1e-6);
        let without = pbrt(&text, Some(0.0)).cameras()[0].to_world;
        assert!(motion.pose(0.0).abs_diff_eq(without, 1e-6), "{spherical}: its own axes");
    }
}

const RECTANGLE: &str = "<shape type=\"rectangle\"><animation name=\"to_world\">\
    <transform time=\"5\"><rotate z=\"1\" angle=\"90\"/><translate x=\"3\"/></transform>\
    <transform time=\"1\"><translate x=\"1\"/></transform></animation></shape>";

#[test]
fn mitsuba_moves_things_between_its_keys() {
    let placed = |at: Option<f64>| mitsuba(RECTANGLE, at).instances()[0].to_world;
    for (seconds, u) in [(-3.0, 0.0), (1.0, 0.0), (2.0, 0.25), (3.0, 0.5), (5.0, 1.0), (8.0, 1.0)] {
        let expected = Affine3A::from_translation(Vec3::X * (1.0 + 2.0 * u)) * turned(90.0 * u);
        assert!(placed(Some(seconds)).abs_diff_eq(expected, 1e-6), "{seconds}: {:?}", placed(Some(seconds)));
    }
    let (still, at) = (mitsuba(RECTANGLE, None), mitsuba(RECTANGLE, Some(3.0)));
    assert!(placed(None).abs_diff_eq(Affine3A::from_translation(Vec3::X * 3.0) * turned(90.0), 1e-6));
    assert!(has(&still, NoteKind::Approximated, "animations: the first key is shown"));
    assert!(!has(&at, NoteKind::Approximated, "animations"));
    assert_eq!((still.animated_seconds(), at.animated_seconds()), (Some([1.0, 5.0]), Some([1.0, 5.0])));
    assert_ne!(still.digest(), at.digest());
}

#[test]
fn sensors_of_mitsuba_move_while_their_shutter_is_open() {
    let sensor = |shutter: &str| {
        format!(
            "<sensor type=\"perspective\">{shutter}<animation name=\"to_world\">\
             <transform time=\"0\"><translate x=\"1\"/></transform>\
             <transform time=\"2\"><translate x=\"5\"/></transform></animation></sensor>{RECTANGLE}"
        )
    };
    let open = "<float name=\"shutter_open\" value=\"0.5\"/><float name=\"shutter_close\" value=\"1.5\"/>";
    let count = |scene: &Scene, start: &str| {
        scene
            .notes()
            .iter()
            .filter(|note| note.message.starts_with(start))
            .map(|note| note.count)
            .sum::<u64>()
    };
    let own = mitsuba(&sensor(open), None);
    let (shutter, places) = exposed(&own);
    assert_eq!((shutter, places), ([0.5, 1.5], [2.0, 3.0, 4.0].map(|x| Vec3::X * x)));
    assert_eq!(count(&own, "animations"), 0);
    let rectangle = |scene: &Scene, share| scene.moved(scene.instance_ids().next().unwrap(), share);
    for (share, u) in [(0.0, 0.0), (0.75, 0.0625), (1.0, 0.125)] {
        let expected = Affine3A::from_translation(Vec3::X * (1.0 + 2.0 * u)) * turned(90.0 * u);
        let found = rectangle(&own, share).unwrap().to_world;
        assert!(found.abs_diff_eq(expected, 1e-6), "{share}: {found:?}");
    }
    let closed = mitsuba(&sensor(""), None);
    assert_eq!(closed.cameras()[0].position(), Vec3::X);
    assert_eq!(count(&closed, "animations: the first key is shown"), 2);
    assert!(!closed.moves());
    // With a requested shutter, both cameras are blurred.
    let xml = format!("<scene version=\"3.0.0\">{}</scene>", sensor(open));
    let asked = |at, shutter| load_with("s.xml", &xml, (at, Some(shutter))).unwrap();
    let blurred = asked(Some(1.0), [0.0, 1.0]);
    assert_eq!(exposed(&blurred).0, [1.0, 2.0]);
    assert_eq!((count(&blurred, "animations"), blurred.shutter()), (0, Some([1.0, 2.0])));
    let expected = Affine3A::from_translation(Vec3::X * 1.25) * turned(11.25);
    assert!(blurred.instances()[0].to_world.abs_diff_eq(expected, 1e-6));
    assert_eq!(blurred.time(), Some(1.5));
    let instant = asked(Some(1.0), [0.0, 0.0]);
    assert!(instant.cameras()[0].motion.is_none() && count(&instant, "animations") == 0);
    assert_eq!(instant.cameras()[0].position(), Vec3::X * 3.0);
    assert_ne!(blurred.digest(), asked(Some(1.0), [0.25, 0.75]).digest(), "the same middle");
    let wrong =
        sensor("<float name=\"shutter_open\" value=\"2\"/><float name=\"shutter_close\" value=\"1\"/>");
    let turned_around = mitsuba(&wrong, None);
    assert_eq!(exposed(&turned_around).0, [1.0, 2.0]);
    assert_eq!(count(&turned_around, "shutters that close before they open"), 1);
    for shutter in [[1.0, 0.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
        let said = load_with("s.xml", &xml, (None, Some(shutter))).unwrap_err().to_string();
        assert!(said.contains("shutter = "), "{said}");
    }
}

/// An instance of a shape group moves. Parts that move within the group stand still, with a note.
#[test]
fn instances_of_mitsuba_move_and_parts_of_groups_do_not() {
    let way = "<animation name=\"to_world\"><transform time=\"0\"><translate x=\"1\"/></transform>\
               <transform time=\"1\"><translate x=\"3\"/></transform></animation>";
    let text = |part: &str, whole: &str| {
        format!(
            "<scene version=\"3.0.0\"><shape type=\"shapegroup\" id=\"g\"><shape type=\"rectangle\">{part}</shape></shape>\
             <shape type=\"instance\"><ref id=\"g\"/>{whole}</shape></scene>"
        )
    };
    let shown = |text: &str| load_with("s.xml", text, (None, Some([0.0, 1.0]))).unwrap();
    let up = "<transform name=\"to_world\"><translate y=\"5\"/></transform>";
    let scene = shown(&text(up, way));
    let found = scene.moved(scene.instance_ids().next().unwrap(), 0.5).unwrap().to_world;
    assert_eq!(Vec3::from(found.translation), Vec3::new(2.0, 5.0, 0.0));
    assert!(!has(&scene, NoteKind::Approximated, "animations"));
    let scene = shown(&text(way, up));
    assert!(!scene.moves() && has(&scene, NoteKind::Approximated, "animations: shown in the middle"));
    assert_eq!(Vec3::from(scene.instances()[0].to_world.translation), Vec3::new(2.0, 5.0, 0.0));
}

#[test]
fn keys_that_mean_nothing_are_noted_or_refused_with_their_place() {
    let key = |time: &str, step: &str| format!("<transform {time}>{step}</transform>");
    let of = |keys: &str| {
        format!("<shape type=\"rectangle\"><animation name=\"to_world\">{keys}</animation></shape>")
    };
    let (a, b) = (key("time=\"0\"", "<translate x=\"1\"/>"), key("time=\"1\"", "<translate x=\"3\"/>"));
    let untimed = mitsuba(&of(&format!("{a}{}{b}", key("", "<translate x=\"9\"/>"))), Some(0.5));
    assert!(has(&untimed, NoteKind::Repaired, "keys of animations without a time"));
    assert_eq!(untimed.instances()[0].to_world.translation.x, 2.0);
    let flat = mitsuba(&of(&format!("{a}{}", key("time=\"1\"", "<scale x=\"0\"/>"))), Some(0.5));
    assert!(has(&flat, NoteKind::Repaired, "animations with a key that cannot be inverted"));
    assert_eq!(flat.instances()[0].to_world.translation.x, 1.0);
    let none = mitsuba(&of(""), Some(0.5));
    assert_eq!(none.instances()[0].to_world, Affine3A::IDENTITY);
    for time in ["nan", "soon", "inf", ""] {
        let text =
            format!("<scene version=\"3.0.0\">\n{}\n</scene>", of(&key(&format!("time=\"{time}\""), "")));
        let said = load("scene.xml", &text, Some(0.5)).unwrap_err().to_string();
        assert!(said.contains("scene.xml:2:") && said.contains("a finite number"), "{said}");
    }
}
