//! Media as pbrt's and Mitsuba's files give them: their numbers, where they are, and what is told.

use tashika::bsdf::HenyeyGreenstein;
use tashika::color::Rgb;
use tashika::error::Error;
use tashika::scene::{Interface, Medium, NoteKind, Scene, Surface};

use crate::mitsuba;
use crate::pbrt::{Folder, TRIANGLE, V3, V4, noted, notes, refusal, scene};

fn close(a: Rgb, b: [f32; 3]) -> bool {
    a.to_array().into_iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-6 * b.abs())
}

#[track_caller]
fn assert_medium(medium: &Medium, absorption: [f32; 3], scattering: [f32; 3], asymmetry: f32) {
    let [a, s] = [medium.absorption, medium.scattering];
    assert!(close(a, absorption) && close(s, scattering), "{medium:?}");
    assert_eq!(medium.phase, HenyeyGreenstein { asymmetry });
}

/// The interface of the only mesh, as names; vacuum has none.
fn sides(scene: &Scene) -> Option<[Option<&str>; 2]> {
    let name =
        |medium: Option<tashika::scene::MediumId>| medium.map(|m| scene.media()[m.index()].name.as_str());
    let [mesh] = scene.meshes() else { panic!("{} meshes", scene.meshes().len()) };
    mesh.interface.map(|Interface { inside, outside }| [name(inside), name(outside)])
}

const FOG: &str = "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [.1 .2 .3] \
    \"rgb sigma_s\" [1 2 3] \"float scale\" 0.5 \"float g\" -0.3\n";

#[test]
fn media_of_pbrt_have_the_coefficients_of_their_file() {
    for (head, end) in [(V3, "WorldEnd"), (V4, "")] {
        let own = "MakeNamedMedium \"own\" \"string type\" \"homogeneous\"";
        let scene = scene(&format!("{head} {FOG} {own} {end}"));
        assert_eq!(notes(&scene), []);
        let [fog, own] = scene.media() else { panic!() };
        assert_eq!(fog.name, "fog");
        assert_medium(fog, [0.05, 0.1, 0.15], [0.5, 1.0, 1.5], -0.3);
        assert_medium(own, [0.0011, 0.0024, 0.014], [2.55, 3.21, 3.77], 0.0);
        assert!(!scene.has_media(), "nobody is in it");
    }
}

#[test]
fn interfaces_of_pbrt_are_those_of_the_shapes_that_follow() {
    let glass = |between: &str| scene(&format!("{V4} {FOG} {between} Material \"dielectric\" {TRIANGLE}"));
    assert_eq!(sides(&glass("MediumInterface \"fog\" \"\"")), Some([Some("fog"), None]));
    assert_eq!(sides(&glass("MediumInterface \"\" \"fog\"")), Some([None, Some("fog")]));
    // The same on both sides is none: what stands in fog changes nothing.
    assert_eq!(sides(&glass("MediumInterface \"fog\"")), None);
    assert_eq!(sides(&glass("AttributeBegin MediumInterface \"fog\" \"\" AttributeEnd")), None);
    let undefined = glass("MediumInterface \"mist\" \"\"");
    assert_eq!(sides(&undefined), None);
    assert!(noted(&undefined, NoteKind::Repaired, "medium \"mist\" is not defined: vacuum"));
    // Shapes of the same parameters are two meshes if they bound different media.
    let two = "Shape \"sphere\" MediumInterface \"fog\" \"\" Shape \"sphere\" Shape \"sphere\"";
    let scene = scene(&format!("{V4} {FOG} {two}"));
    assert_eq!((scene.meshes().len(), scene.instances().len()), (2, 3));
    assert_eq!(scene.meshes()[0].interface, None);
    assert!(scene.meshes()[1].interface.is_some() && scene.has_media());
}

#[test]
fn invisible_interfaces_of_pbrt_are_boundaries_where_there_is_a_medium() {
    for (head, material) in [(V4, "\"interface\""), (V4, "\"\""), (V3, "\"none\""), (V3, "\"\"")] {
        let bounding = |media: &str| {
            scene(&format!("Integrator \"volpath\" {head} {FOG} Material {material} {media} {TRIANGLE}"))
        };
        let fog = bounding("MediumInterface \"fog\" \"\"");
        assert_eq!(fog.materials()[0].surface, Surface::Boundary);
        assert_eq!(sides(&fog), Some([Some("fog"), None]));
        for nothing in ["", "MediumInterface \"fog\" \"fog\"", "MediumInterface \"\" \"\""] {
            assert!(bounding(nothing).instances().is_empty(), "{nothing}");
        }
    }
}

#[test]
fn cameras_of_pbrt_stand_in_what_is_outside_of_shapes() {
    let camera = |words: &str| {
        let scene =
            scene(&format!("{FOG} MediumInterface \"\" \"fog\" Camera {words} WorldBegin {TRIANGLE}"));
        scene.cameras()[0].medium.map(|m| scene.media()[m.index()].name.clone())
    };
    for words in ["\"perspective\"", "\"spherical\"", "\"orthographic\""] {
        assert_eq!(camera(words).as_deref(), Some("fog"));
    }
    let before =
        scene(&format!("Camera \"perspective\" {FOG} MediumInterface \"fog\" WorldBegin {TRIANGLE}"));
    assert_eq!(before.cameras()[0].medium, None);
}

#[test]
fn media_of_pbrt_that_cannot_be_are_errors_with_their_line() {
    let fog = |parameter: &str| {
        refusal(&format!(
            "{V4}MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\n {parameter} {TRIANGLE}"
        ))
    };
    let error = fog("\"rgb sigma_a\" [.1 -.2 .3]");
    assert!(error.starts_with("scene.pbrt:3:2: parameter \"rgb sigma_a\" with a negative number"), "{error}");
    for wrong in ["\"float g\" 1", "\"float g\" -1.5", "\"float scale\" -1", "\"rgb sigma_s\" [1e10 0 0]"] {
        let error = fog(wrong);
        assert!(error.starts_with("scene.pbrt:2:1: medium fog: absorption"), "{error}");
        assert!(error.contains("at most 1e9 m⁻¹ together, and g between -1 and 1"), "{error}");
    }
    let without = scene(&format!("{V4} MakeNamedMedium \"fog\" MediumInterface \"fog\" \"\" {TRIANGLE}"));
    assert!(noted(&without, NoteKind::Repaired, "media without type: vacuum"));
    let unknown = scene(&format!("{V4} MakeNamedMedium \"fog\" \"string type\" \"jelly\" {TRIANGLE}"));
    assert!(noted(&unknown, NoteKind::Ignored, "medium \"jelly\" is unknown: vacuum"));
}

/// A text of pbrt with something of every media directive, damaged at any place.
#[test]
fn damaged_media_of_pbrt_are_scenes_or_errors() {
    let whole = format!(
        "{FOG}MakeNamedMedium \"s\" \"string type\" \"uniformgrid\" \"integer nx\" 2 \"float density\" [1 2]\n\
         MediumInterface \"fog\" \"s\" Camera \"perspective\" WorldBegin\nMediumInterface \"s\" \"fog\"\n\
         Material \"interface\" Shape \"sphere\"\nAttribute \"medium\" \"float g\" 0.5\n\
         MakeNamedMedium \"t\" \"string type\" \"homogeneous\" \"blackbody sigma_s\" 3000 \"rgb Le\" [1 1 1]\n\
         MediumInterface \"t\" Shape \"disk\""
    );
    let folder = Folder::new();
    assert!(folder.load(&whole).is_ok());
    let words: Vec<&str> = whole.split_inclusive([' ', '\n']).collect();
    let mut errors = 0;
    for place in 0..words.len() {
        for hostile in ["", "-1", "1e38", "nan", "\"fog\"", "\"\"", "[", "MediumInterface", "\"float g\""] {
            let mut damaged = words.clone();
            damaged[place] = hostile;
            if let Err(error) = folder.load(&damaged.join(" ")) {
                errors += 1;
                let Error::Invalid { at, .. } = &error else { panic!("{error}") };
                assert!(at.line.is_some(), "{error}");
            }
        }
        let _ = folder.load(&words[..place].concat());
    }
    assert!(errors > 100, "{errors}");
}

fn fog(inside: &str) -> String {
    format!("<medium type=\"homogeneous\" id=\"fog\">{inside}</medium>")
}

const GLASS: &str = "<bsdf type=\"dielectric\"/>";
const VOLPATH: &str = "<integrator type=\"volpath\"/>";

#[test]
fn media_of_mitsuba_have_the_coefficients_of_their_file() {
    let numbers = "<rgb name=\"sigma_t\" value=\"0.2 0.4 1\"/><rgb name=\"albedo\" value=\"0.5 0.75 1\"/><float name=\"scale\" value=\"10\"/>";
    let hg = "<phase type=\"hg\"><float name=\"g\" value=\"-0.4\"/></phase>";
    let volumes = "<volume type=\"constvolume\" name=\"albedo\"><rgb name=\"value\" value=\"0.5 0.75 1\"/></volume>\
        <rgb name=\"sigma_t\" value=\"2 4 10\"/>";
    let both = "<rgb name=\"sigmaS\" value=\"1 3 10\"/><rgb name=\"sigmaA\" value=\"1 1 0\"/>";
    for (inside, g) in [
        (format!("{numbers}{hg}"), -0.4),
        (format!("{numbers}<phase type=\"isotropic\"/>"), 0.0),
        (volumes.to_owned(), 0.0),
        (both.to_owned(), 0.0),
        (format!("{both}<phase type=\"hg\"/>"), 0.8),
    ] {
        let medium = fog(&inside).replace("id=\"fog\"", "id=\"fog\" name=\"interior\"");
        let scene = mitsuba::load(&format!("{VOLPATH}<shape type=\"cube\">{GLASS}{medium}</shape>"));
        assert_eq!(mitsuba::notes(&scene), [], "{inside}");
        assert_eq!(scene.media()[0].name, "fog");
        assert_medium(&scene.media()[0], [1.0, 1.0, 0.0], [1.0, 3.0, 10.0], g);
    }
    let plain =
        mitsuba::load("<shape type=\"cube\"><medium type=\"homogeneous\" name=\"interior\"/></shape>");
    assert_medium(&plain.media()[0], [0.25; 3], [0.75; 3], 0.0);
}

#[test]
fn media_of_mitsuba_are_in_shapes_about_them_and_about_cameras() {
    let shape = |bsdf: &str, media: &str| {
        let text = format!("{VOLPATH}{}<shape type=\"cube\">{bsdf}{media}</shape>", fog(""));
        let scene = mitsuba::load(&text);
        assert_eq!(mitsuba::notes(&scene), [], "{text}");
        scene
    };
    let interior = "<ref name=\"interior\" id=\"fog\"/>";
    let exterior = "<ref name=\"exterior\" id=\"fog\"/>";
    assert_eq!(sides(&shape(GLASS, interior)), Some([Some("fog"), None]));
    assert_eq!(sides(&shape(GLASS, exterior)), Some([None, Some("fog")]));
    assert_eq!(sides(&shape(GLASS, "")), None);
    let null = "<bsdf type=\"null\"/>";
    let bounding = shape(null, interior);
    assert_eq!(
        (sides(&bounding), bounding.materials()[0].surface),
        (Some([Some("fog"), None]), Surface::Boundary)
    );
    assert!(shape(null, "").instances().is_empty());
    // Two cubes of one material that bound different media are two meshes.
    let two = format!(
        "{VOLPATH}{}<shape type=\"cube\"/><shape type=\"cube\">{interior}</shape><shape type=\"cube\">{interior}</shape>",
        fog("")
    );
    let two = mitsuba::load(&two);
    assert_eq!((two.meshes().len(), two.instances().len()), (2, 3));
    let camera = mitsuba::load(&format!(
        "{VOLPATH}{}<sensor type=\"perspective\"><ref id=\"fog\"/></sensor>",
        fog("")
    ));
    assert!(camera.cameras()[0].medium.is_some() && camera.has_media());
    assert_eq!(mitsuba::notes(&camera), []);
}

#[test]
fn media_of_mitsuba_that_cannot_be_are_errors_with_their_place() {
    let inside = |medium: &str| {
        let text = mitsuba::xml(
            "3.0.0",
            &format!(
                "<shape type=\"cube\">\n<medium type=\"homogeneous\" name=\"interior\">{medium}</medium></shape>"
            ),
        );
        let error = mitsuba::load_in(&[("scene.xml", text.as_bytes())]).1.unwrap_err();
        assert!(matches!(error, Error::Invalid { .. }), "{error}");
        let error = error.to_string();
        assert!(error.contains("scene.xml:3:"), "{error}");
        error
    };
    for (wrong, says) in [
        (
            "<rgb name=\"sigma_t\" value=\"1 -1 1\"/>",
            "sigma_t = [1.0, -1.0, 1.0]; expected finite numbers of at least 0",
        ),
        ("<string name=\"sigma_t\" value=\"thick\"/>", "sigma_t that is no number and no colour"),
        (
            "<rgb name=\"albedo\" value=\"1 1.5 1\"/>",
            "albedo = [1.0, 1.5, 1.0]; expected an albedo from 0 to 1",
        ),
        ("<float name=\"scale\" value=\"-2\"/>", "absorption"),
        ("<float name=\"scale\" value=\"1e12\"/>", "at most 1e9 m⁻¹ together"),
        (
            "<phase type=\"hg\"><float name=\"g\" value=\"1\"/></phase>",
            "g = 1; expected a number between -1 and 1",
        ),
    ] {
        let error = inside(wrong);
        assert!(error.contains(says), "{error}");
    }
    let circle = "<medium type=\"homogeneous\" id=\"fog\"><ref id=\"fog\" name=\"albedo\"/></medium><shape type=\"cube\"><ref id=\"fog\" name=\"interior\"/></shape>";
    assert_eq!(mitsuba::load(circle).media().len(), 1, "a medium is no volume");
}

/// As in pbrt and in Mitsuba, whose default integrators differ.
#[test]
fn media_are_left_out_where_the_integrator_of_the_file_does() {
    let of_pbrt = |head: &str, integrator: &str| {
        let fog = "MediumInterface \"fog\" \"\" Material \"none\"";
        scene(&format!("{integrator} {head} {FOG} {fog} {TRIANGLE}"))
    };
    let of_mitsuba = |integrator: &str| {
        let medium = "<medium type=\"homogeneous\" name=\"interior\"/>";
        mitsuba::load(&format!("{integrator}<shape type=\"cube\">{GLASS}{medium}</shape>"))
    };
    let nested = "<integrator type=\"aov\"><integrator type=\"volpathmis\"/></integrator>";
    for (scene, has_media) in [
        (of_pbrt(V3, ""), false),
        (of_pbrt(V3, "Integrator \"volpath\""), true),
        (of_pbrt(V4, ""), true),
        (of_pbrt(V4, "Integrator \"path\""), false),
        (of_mitsuba(""), false),
        (of_mitsuba("<integrator type=\"path\"/>"), false),
        (of_mitsuba(VOLPATH), true),
        (of_mitsuba(nested), true),
    ] {
        assert_eq!(scene.has_media(), has_media);
        let is_told = noted(&scene, NoteKind::Ignored, "media: left out, as the integrator of the file does");
        assert_eq!(is_told, !has_media);
    }
}
