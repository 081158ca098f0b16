//! Unusable USD prims: those that are invisible and emit no light are omitted, with a note.

use tashika::error::Result;
use tashika::io::{LightChanges, LoadOptions, open_scene};
use tashika::scene::{NoteKind, Scene};

use super::gltf::{notes, write};
use super::usd::{load, quad, whole};

/// A quad beside other prims.
fn beside(text: &str) -> Scene {
    load(&(quad("Q", "") + text)).unwrap_or_else(|e| panic!("{text}: {e}"))
}

#[test]
fn shapes_and_lights_without_a_size_are_left_out() {
    for (prim, property) in [
        ("Sphere \"W\" { double radius = 0 }", "radius"),
        ("Sphere \"W\" { double radius = -1 }", "radius"),
        ("Cube \"W\" { double size = 0 }", "size"),
        ("Cylinder \"W\" { double height = 0 }", "height"),
        ("Cone \"W\" { double radius = 0 }", "radius"),
        ("Plane \"W\" { double length = 0 }", "length"),
        ("RectLight \"W\" { float inputs:width = 0 }", "inputs:width"),
        ("DiskLight \"W\" { float inputs:radius = -2 }", "inputs:radius"),
        ("CylinderLight \"W\" { float inputs:length = 0 }", "inputs:length"),
    ] {
        let scene = beside(&format!("def {prim}"));
        assert_eq!((scene.instances().len(), scene.has_light()), (1, false), "{prim}");
        let all: Vec<_> = scene.notes().iter().filter(|note| note.kind == NoteKind::Repaired).collect();
        assert_eq!(all.len(), 1, "{prim}: {:?}", notes(&scene));
        let place = all[0].first.to_string();
        // The header has five lines, and the quad seven.
        assert!(place.contains(&format!("s.usda:13: /W.{property}")), "{prim}: {place}");
        assert!(scene.notes().first_departure().is_some(), "a strict run refuses it");
    }
}

#[test]
fn lights_that_cannot_shine_are_left_out_and_colours_are_repaired() {
    for kind in ["SphereLight", "RectLight", "DistantLight", "DomeLight"] {
        for (input, is_left) in [
            ("float inputs:intensity = -3", false),
            ("float inputs:exposure = 500", false),
            ("color3f inputs:color = (-1, 0, 0)", false),
            ("color3f inputs:color = (-1, 0.5, 0)", true),
        ] {
            let scene = beside(&format!("def {kind} \"W\" {{ {input} }}"));
            assert_eq!(scene.has_light(), is_left, "{kind} {input}");
            let said = notes(&scene);
            assert!(said.iter().any(|(k, _)| *k == NoteKind::Repaired), "{kind} {input}: {said:?}");
        }
    }
    let flat = "float3 xformOp:scale = (0, 0, 0)\nuniform token[] xformOpOrder = [\"xformOp:scale\"]";
    for kind in ["SphereLight", "RectLight", "DistantLight", "Camera", "Cube"] {
        let scene = beside(&format!("def {kind} \"W\" {{ {flat} }}"));
        assert_eq!((scene.instances().len(), scene.has_light()), (1, false), "{kind}");
        let said = notes(&scene);
        assert!(said.iter().any(|(k, _)| *k == NoteKind::Repaired), "{kind}: {said:?}");
    }
}

#[test]
fn cameras_without_a_picture_are_left_out() {
    for input in ["focalLength = 0", "horizontalAperture = -1", "verticalAperture = 0"] {
        let bad = format!("def Camera \"Bad\" {{ float {input} }}\n");
        let scene = beside(&(bad.clone() + "def Camera \"Good\" { }"));
        let names: Vec<_> = scene.cameras().iter().map(|camera| camera.name.clone()).collect();
        assert_eq!(names, ["Good"], "{input}");
        let said = notes(&scene);
        assert!(said.iter().any(|(k, m)| *k == NoteKind::Repaired && m.contains("cameras")), "{said:?}");
        assert_eq!(beside(&bad).cameras().len(), 1, "the one that sees all");
    }
}

#[test]
fn inverses_that_are_not_there_leave_out_what_they_move() {
    let op = "float3 xformOp:scale = (0, 1, 1)\nuniform token[] xformOpOrder = [\"!invert!xformOp:scale\"]";
    let scene = beside(&format!("def Xform \"W\" {{ {op}\n{} }}", quad("R", "")));
    assert_eq!(scene.instances().len(), 1);
    assert!(notes(&scene).iter().any(|(k, m)| *k == NoteKind::Repaired && m.contains("inverses")));
}

/// Opens a scene as the program does for a user.
fn opened(text: &str, at: Option<f64>) -> Result<Scene> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.usda");
    write(&path, whole(text).as_bytes());
    open_scene(&path, &LightChanges::default(), &LoadOptions { at, ..LoadOptions::default() })
}

#[test]
fn moments_at_which_nothing_is_there_show_the_background() {
    let samples = "token visibility.timeSamples = { 0: \"inherited\", 12: \"invisible\", 20: \"inherited\" }";
    let text = quad("Q", samples) + "def DomeLight \"D\" { }";
    for (frame, count) in [(0, 1), (12, 0), (19, 0), (20, 1)] {
        let scene = opened(&text, Some(f64::from(frame) / 24.0)).unwrap();
        assert_eq!(scene.instances().len(), count, "{frame}");
        assert!(scene.environment().is_some(), "{frame}");
    }
    // A quad that is always invisible: there is nothing to render, with or without a time.
    let never = quad("Q", "token visibility = \"invisible\"") + "def DomeLight \"D\" { }";
    for at in [None, Some(0.5)] {
        assert!(opened(&never, at).is_err(), "{at:?}");
    }
}

#[test]
fn lamps_that_are_off_at_a_time_leave_the_scene_dark() {
    for lamp in [
        "float inputs:intensity.timeSamples = { 0: 0, 24: 10 }",
        "token visibility.timeSamples = { 0: \"invisible\", 24: \"inherited\" }",
    ] {
        let text = quad("Q", "") + &format!("def SphereLight \"D\" {{ {lamp} }}");
        for (seconds, shines) in [(0.0, false), (1.0, true)] {
            let scene = opened(&text, Some(seconds)).unwrap();
            assert_eq!(
                (scene.has_light(), scene.has_default_light()),
                (shines, false),
                "{lamp} at {seconds}"
            );
        }
    }
}
