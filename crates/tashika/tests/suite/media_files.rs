//! Media in files of pbrt and Mitsuba: coefficients, placement and notes.

use tashika::bsdf::HenyeyGreenstein;
use tashika::color::Rgb;
use tashika::error::Error;
use tashika::math::Vec3;
use tashika::scene::{Interface, Medium, NoteKind, Scattered, Scene, Surface, VolumeGrid};

use crate::mitsuba;
use crate::pbrt::{Folder, TRIANGLE, V3, V4, noted, notes, nvdb, refusal, scene};

fn close(a: Rgb, b: [f32; 3]) -> bool {
    a.to_array().into_iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-6 * b.abs())
}

#[track_caller]
fn assert_medium(medium: &Medium, absorption: [f32; 3], scattering: [f32; 3], asymmetry: f32) {
    let [a, s] = [medium.absorption, medium.scattering];
    assert!(close(a, absorption) && close(s, scattering), "{medium:?}");
    assert_eq!(medium.phase, HenyeyGreenstein { asymmetry });
}

/// Names of the media on both sides of the only mesh; none for vacuum.
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
    // The same medium on both sides is no interface: an object in fog changes nothing.
    assert_eq!(sides(&glass("MediumInterface \"fog\"")), None);
    assert_eq!(sides(&glass("AttributeBegin MediumInterface \"fog\" \"\" AttributeEnd")), None);
    let undefined = glass("MediumInterface \"mist\" \"\"");
    assert_eq!(sides(&undefined), None);
    assert!(noted(&undefined, NoteKind::Repaired, "medium \"mist\" is not defined: vacuum"));
    // Shapes with equal parameters become two meshes if they bound different media.
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
    let error = fog("\"rgb sigma_s\" [1e10 0 0]");
    assert!(error.starts_with("scene.pbrt:2:1: medium fog: absorption"), "{error}");
    assert!(error.contains("at most 1e9 m⁻¹ together, and g between -1 and 1"), "{error}");
    let without = scene(&format!("{V4} MakeNamedMedium \"fog\" MediumInterface \"fog\" \"\" {TRIANGLE}"));
    assert!(noted(&without, NoteKind::Repaired, "media without type: vacuum"));
    let unknown = scene(&format!("{V4} MakeNamedMedium \"fog\" \"string type\" \"jelly\" {TRIANGLE}"));
    assert!(noted(&unknown, NoteKind::Ignored, "medium \"jelly\" is unknown: vacuum"));
}

/// Negative coefficients become zero, and asymmetries beyond ±1 the nearest valid one; each with a
/// note at its line.
#[test]
fn values_of_media_out_of_range_are_moved_into_it() {
    let of_pbrt = |parameters: &str| {
        let text = format!(
            "{V4}MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [1 1 1]\n\
             {parameters} MediumInterface \"fog\" \"\" Material \"interface\" {TRIANGLE}"
        );
        scene(&text)
    };
    let of_mitsuba = |inside: &str| {
        mitsuba::load(&format!(
            "{VOLPATH}<shape type=\"cube\"><bsdf type=\"null\"/>\
             <medium type=\"homogeneous\" name=\"interior\">{inside}</medium></shape>"
        ))
    };
    let g = |value: f32| format!("<phase type=\"hg\"><float name=\"g\" value=\"{value}\"/></phase>");
    let most = 1.0_f32.next_down();
    for (scene, message, absorption, scattering, asymmetry) in [
        (of_pbrt("\"rgb sigma_a\" [.1 -.2 .3]"), "negative channels", [0.1, 0.0, 0.3], [1.0; 3], 0.0),
        (of_pbrt("\"rgb sigma_a\" [0 0 0] \"float scale\" -2"), "negative scales", [0.0; 3], [0.0; 3], 0.0),
        (of_pbrt("\"rgb sigma_a\" [0 0 0] \"float g\" 1.5"), "asymmetries", [0.0; 3], [1.0; 3], most),
        (of_pbrt("\"rgb sigma_a\" [0 0 0] \"float g\" -1"), "asymmetries", [0.0; 3], [1.0; 3], -most),
        (
            of_mitsuba("<rgb name=\"sigma_t\" value=\"4 -1 4\"/>"),
            "negative coefficients",
            [1.0, 0.0, 1.0],
            [3.0, 0.0, 3.0],
            0.0,
        ),
        (
            of_mitsuba("<rgb name=\"albedo\" value=\"1 1.5 0\"/>"),
            "albedos of media above 1",
            [0.0, 0.0, 1.0],
            [1.0, 1.0, 0.0],
            0.0,
        ),
        (of_mitsuba("<float name=\"scale\" value=\"-2\"/>"), "negative scales", [0.0; 3], [0.0; 3], 0.0),
        (of_mitsuba(&g(1.0)), "asymmetries", [0.25; 3], [0.75; 3], most),
        (of_mitsuba(&g(-7.0)), "asymmetries", [0.25; 3], [0.75; 3], -most),
    ] {
        let notes: Vec<_> = scene.notes().iter().filter(|n| n.kind == NoteKind::Repaired).collect();
        let [note] = &notes[..] else { panic!("{message}: {notes:?}") };
        assert!(note.message.contains(message) && note.first.line.is_some(), "{note:?}");
        assert_medium(&scene.media()[0], absorption, scattering, asymmetry);
    }
}

/// A pbrt text with every media directive, damaged at each position. The result is a scene or an
/// error.
#[test]
fn damaged_media_of_pbrt_are_scenes_or_errors() {
    let whole = format!(
        "{FOG}MakeNamedMedium \"s\" \"string type\" \"uniformgrid\" \"integer nx\" 2 \"float density\" [1 2] \"point3 p1\" [2 2 2]\n\
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
    // Two cubes of the same material that bound different media are two meshes.
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
        ("<string name=\"sigma_t\" value=\"thick\"/>", "sigma_t that is no number and no colour"),
        ("<float name=\"scale\" value=\"1e12\"/>", "at most 1e9 m⁻¹ together"),
    ] {
        let error = inside(wrong);
        assert!(error.contains(says), "{error}");
    }
    let circle = "<medium type=\"homogeneous\" id=\"fog\"><ref id=\"fog\" name=\"albedo\"/></medium><shape type=\"cube\"><ref id=\"fog\" name=\"interior\"/></shape>";
    assert_eq!(mitsuba::load(circle).media().len(), 1, "a medium is no volume");
}

/// Media are ignored if the file's integrator ignores them; the default integrators of pbrt and
/// Mitsuba differ.
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

/// Extinction and scattering coefficients at a place (m⁻¹).
fn coefficients(medium: &Medium, place: Vec3) -> [Rgb; 2] {
    let place = place.as_dvec3();
    let in_box = |grid: &VolumeGrid| {
        let ([lo, hi], at) = (grid.bounds(), grid.to_cells().transform_point3(place));
        at.cmpge(lo).all() && at.cmple(hi).all()
    };
    let factor = medium.density().map_or(Rgb::WHITE, |density| {
        let grid = density.grid();
        if in_box(grid) { grid.at(grid.to_cells().transform_point3(place)) } else { Rgb::BLACK }
    });
    [medium.extinction() * factor, medium.scattering_at(place, factor)]
}

#[track_caller]
fn assert_at(medium: &Medium, place: [f32; 3], extinction: [f32; 3], scattering: [f32; 3]) {
    let [t, s] = coefficients(medium, place.into());
    assert!(
        close(t, extinction) && close(s, scattering),
        "{t:?} for {extinction:?}, {s:?} for {scattering:?}"
    );
}

const GRID: &str = "\"integer nx\" 2 \"integer ny\" 1 \"integer nz\" 3 \"float density\" [1 2 3 4 5 6] \
    \"point3 p0\" [-1 0 0] \"point3 p1\" [1 1 3] \"rgb sigma_a\" [.1 .2 .3] \"rgb sigma_s\" [1 2 3] \"float scale\" 2";

#[test]
fn grids_of_pbrt_vary_as_their_file_says() {
    let of = |head: &str, class: &str, grid: &str| {
        let scene = scene(&format!(
            "{head} Translate 10 0 0 MakeNamedMedium \"smoke\" \"string type\" \"{class}\" {grid} \"float g\" 0.4 {}",
            if head == V3 { "WorldEnd" } else { "" }
        ));
        assert_eq!(notes(&scene), [], "{class}");
        scene.media()[0].clone()
    };
    for (head, class) in [(V3, "heterogeneous"), (V4, "uniformgrid")] {
        let smoke = of(head, class, GRID);
        assert_eq!(smoke.phase, HenyeyGreenstein { asymmetry: 0.4 });
        let times = |f: f32| ([2.2, 4.4, 6.6].map(|c| c * f), [2.0, 4.0, 6.0].map(|c| c * f));
        // At the centre of cells; between them; at a face, where the density has fallen to a half;
        // and beyond.
        for (place, factor) in [
            ([9.5, 0.5, 0.5], 1.0),
            ([10.5, 0.5, 2.5], 6.0),
            ([10.0, 0.5, 1.0], 2.5),
            ([11.0, 0.5, 0.5], 1.0),
            ([11.1, 0.5, 0.5], 0.0),
        ] {
            let (extinction, scattering) = times(factor);
            assert_at(&smoke, place, extinction, scattering);
        }
    }
    let own = of(V4, "uniformgrid", "\"float density\" 3");
    assert_at(&own, [10.5, 0.5, 0.5], [6.0; 3], [3.0; 3]);
    let old = of(V3, "heterogeneous", "\"float density\" 3");
    assert_at(
        &old,
        [10.5, 0.5, 0.5],
        [2.5511, 3.2124, 3.784].map(|c| 3.0 * c),
        [2.55, 3.21, 3.77].map(|c| 3.0 * c),
    );
    let colors = "\"integer nx\" 2 \"rgb sigma_s\" [1 2 3 3 2 1] \"float scale\" 2";
    let colored = of(V4, "rgbgrid", &format!("{colors} \"rgb sigma_a\" [0 0 0 1 1 1]"));
    assert_at(&colored, [10.25, 0.5, 0.5], [2.0, 4.0, 6.0], [2.0, 4.0, 6.0]);
    assert_at(&colored, [10.5, 0.5, 0.5], [5.0; 3], [4.0; 3]);
    let half = of(V4, "rgbgrid", colors);
    assert_at(&half, [10.75, 0.5, 0.5], [8.0, 6.0, 4.0], [6.0, 4.0, 2.0]);
}

#[test]
fn files_of_nanovdb_are_placed_by_their_own_map_and_then_as_shapes_are() {
    let folder = Folder::new();
    folder.write("a.nvdb", nvdb());
    folder.write("b.nvdb", "NanoVDB0");
    let mut other = nvdb();
    other[16 + 168] = 2;
    folder.write("blosc.nvdb", other);
    let load = |file: &str| {
        let grid = format!("\"string filename\" \"{file}\" \"rgb sigma_s\" [1 2 3] \"float scale\" 2");
        let medium = format!("MakeNamedMedium \"smoke\" \"string type\" \"nanovdb\" {grid}");
        folder.load(&format!("{V4} Translate 10 0 0 {medium} MediumInterface \"smoke\" \"\" {TRIANGLE}"))
    };
    let scene = load("a.nvdb").unwrap();
    assert_eq!(notes(&scene), []);
    let smoke = &scene.media()[0];
    // Indices 0 and 1 are at 10 and 10.5. Index 2, at 11, and beyond are inactive.
    for (x, factor) in [(9.9, 0.0), (10.0, 3.0), (10.25, 3.0), (10.75, 3.0), (11.1, 0.0)] {
        assert_at(
            smoke,
            [x, 0.25, 0.25],
            [4.0, 6.0, 8.0].map(|c| c * factor),
            [2.0, 4.0, 6.0].map(|c| c * factor),
        );
    }
    let error = load("b.nvdb").unwrap_err().to_string();
    assert!(error.contains("b.nvdb: a NanoVDB file that ends too early"), "{error}");
    let missing = load("c.nvdb").unwrap();
    assert!(noted(&missing, NoteKind::Missing, "grid \"c.nvdb\" could not be read (no such file): vacuum"));
    let blosc = load("blosc.nvdb").unwrap();
    assert!(noted(
        &blosc,
        NoteKind::Repaired,
        "grid \"blosc.nvdb\" could not be read (a NanoVDB grid that is compressed by Blosc"
    ));
    assert!(blosc.media().is_empty() && !blosc.has_media());
}

#[test]
fn grids_of_pbrt_that_cannot_be_are_errors_with_their_line() {
    let said = |class: &str, grid: &str| {
        refusal(&format!("{V4}MakeNamedMedium \"smoke\" \"string type\" \"{class}\"\n {grid} {TRIANGLE}"))
    };
    for (grid, says) in [
        ("", "0 values for a grid of 1×1×1; expected one value for each"),
        (
            "\"integer nx\" 2000000000 \"integer ny\" 2000000000 \"float density\" 1",
            "1 values for a grid of 2000000000×",
        ),
        ("\"integer nz\" 0 \"float density\" 1", "1 values for a grid of 1×1×0"),
        ("\"integer nz\" -3 \"float density\" 1", "a grid of [1, 1, -3] cells; expected at least one"),
        (
            "\"integer ny\" 2 \"float density\" [1 -2]",
            "a grid with -2 in cell (0, 1, 0); expected finite values of at least 0",
        ),
        ("\"float density\" 1e30", "mean free paths across its grid; expected at most 1e9 m⁻¹"),
    ] {
        let error = said("uniformgrid", grid);
        assert!(error.starts_with("scene.pbrt:") && error.contains(says), "{error}");
    }
    let colors = said("rgbgrid", "\"rgb sigma_a\" [1 1 1 2 2 2] \"rgb sigma_s\" [1 1 1]");
    assert!(
        colors.contains("2 colours for absorption and 1 for scattering; expected as many of each"),
        "{colors}"
    );
    assert!(said("rgbgrid", "").contains("0 values for a grid"));

    let vacuum = |class: &str, grid: &str| {
        let smoke = format!("MakeNamedMedium \"smoke\" \"string type\" \"{class}\" {grid}");
        scene(&format!("{V4} {smoke} MediumInterface \"smoke\" \"\" {TRIANGLE}"))
    };
    let flat = vacuum("uniformgrid", "\"float density\" 1 \"point3 p1\" [1 0 1]");
    assert!(noted(&flat, NoteKind::Repaired, "grids of media in a box without volume: vacuum"));
    assert!(flat.media().is_empty());
    let dark = vacuum("rgbgrid", "\"rgb sigma_s\" [1 1 -1]");
    assert!(noted(&dark, NoteKind::Repaired, "colours with negative channels"));
    assert_eq!(dark.media().len(), 1);
}

fn smoke(medium: &str, version: &str, file: &[u8]) -> Scene {
    let text = format!("{VOLPATH}<shape type=\"cube\">{medium}</shape>");
    mitsuba::load_version(version, &text, &[("a.vol", file)])
}

fn heterogeneous(inside: &str) -> String {
    format!("<medium type=\"heterogeneous\" id=\"smoke\" name=\"interior\">{inside}</medium>")
}

fn gridvolume(name: &str, inside: &str) -> String {
    format!("<volume type=\"gridvolume\" name=\"{name}\">{}{inside}</volume>", mitsuba::VOL)
}

#[test]
fn grids_of_mitsuba_vary_as_their_files_say() {
    let of = |version: &str, inside: &str, file: &[u8]| {
        let scene = smoke(&heterogeneous(inside), version, file);
        assert_eq!(mitsuba::notes(&scene), [], "{inside}");
        scene.media()[0].clone()
    };
    let numbers = mitsuba::vol([2, 1, 3], 1, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let shares = mitsuba::vol([2, 1, 1], 3, &[0.2, 0.4, 0.6, 1.0, 0.0, 0.5]);
    let scale = "<float name=\"scale\" value=\"10\"/>";
    let placed =
        "<transform name=\"to_world\"><scale x=\"2\" y=\"1\" z=\"3\"/><translate x=\"-1\"/></transform>";
    let albedo = "<rgb name=\"albedo\" value=\"0.5 0.75 1\"/>";

    let density = of("3.0.0", &format!("{}{albedo}{scale}", gridvolume("sigma_t", placed)), &numbers);
    let times = |f: f32| ([10.0 * f; 3], [5.0, 7.5, 10.0].map(|c| c * f));
    for (place, factor) in [
        ([-0.5, 0.5, 0.5], 1.0),
        ([0.5, 0.1, 2.5], 6.0),
        ([0.0, 0.5, 1.0], 2.5),
        ([1.0, 0.5, 0.2], 2.0),
        ([1.1, 0.5, 0.2], 0.0),
    ] {
        let (extinction, scattering) = times(factor);
        assert_at(&density, place, extinction, scattering);
    }
    // The albedo extends beyond its box.
    let colored = of(
        "3.0.0",
        &format!("{}<rgb name=\"sigma_t\" value=\"1 2 3\"/>", gridvolume("albedo", placed)),
        &shares,
    );
    assert!(colored.density().is_none());
    assert_at(&colored, [-0.5, 0.5, 0.5], [1.0, 2.0, 3.0], [0.2, 0.8, 1.8]);
    assert_at(&colored, [7.0, 0.5, 0.5], [1.0, 2.0, 3.0], [1.0, 0.0, 1.5]);
    let both = format!("{}{}{scale}", gridvolume("albedo", ""), gridvolume("sigma_t", ""));
    assert_at(&of("3.0.0", &both, &shares), [0.75, 0.1, 0.1], [10.0, 0.0, 5.0], [10.0, 0.0, 2.5]);
    // The grid fills the box of the file.
    let own_box = gridvolume("sigma_t", "<boolean name=\"use_grid_bbox\" value=\"true\"/>");
    assert_at(&of("3.0.0", &own_box, &numbers), [1.25, 3.0, 3.5], [1.0; 3], [0.75; 3]);
    // As in version 0.6: the outermost values lie in the faces.
    let old = of("0.6.0", &format!("{}{albedo}{scale}", gridvolume("density", "")), &numbers);
    assert_at(&old, [1.0, 3.0, 3.0], [10.0; 3], [5.0, 7.5, 10.0]);
    assert_at(&old, [2.0, 2.5, 6.0], [60.0; 3], [30.0, 45.0, 60.0]);
    assert_at(&old, [1.5, 3.0, 3.75], [25.0; 3], [12.5, 18.75, 25.0]);
    assert!(matches!(old.variation.as_ref().unwrap().scattered(), Scattered::Evenly));
}

#[test]
fn grids_of_mitsuba_that_cannot_be_are_errors_or_notes_with_their_place() {
    let said = |inside: &str, file: &[u8]| {
        let text =
            mitsuba::xml("3.0.0", &format!("<shape type=\"cube\">\n{}</shape>", heterogeneous(inside)));
        mitsuba::load_in(&[("scene.xml", text.as_bytes()), ("a.vol", file)]).1.unwrap_err().to_string()
    };
    let ones = mitsuba::vol([1, 1, 1], 1, &[1.0]);
    let density = gridvolume("sigma_t", "");
    for (file, says) in [
        (b"VOL".as_slice(), "a volume of 3 bytes; expected a header of 48 bytes"),
        (
            &mitsuba::vol([1, 2, 1], 1, &[1.0, -3.0]),
            "a grid with -3 in cell (0, 1, 0); expected finite values",
        ),
        (&mitsuba::vol([1, 2, 1], 1, &[1.0, f32::NAN]), "a grid with NaN in cell (0, 1, 0)"),
        (&mitsuba::vol([5000, 5000, 5000], 1, &[1.0]), "5000×5000×5000 cells with 1 channels in 4 bytes"),
        (&mitsuba::vol([1, 1, 1], 2, &[1.0; 2]), "2 channels is not supported"),
    ] {
        let error = said(&density, file);
        assert!(error.contains("a.vol: ") && error.contains(says), "{error}");
    }
    let bright = said(&gridvolume("albedo", ""), &mitsuba::vol([1, 1, 1], 1, &[1.25]));
    assert!(
        bright.contains("scene.xml:3:") && bright.contains("an albedo of 1.25; expected albedos from 0 to 1"),
        "{bright}"
    );
    let thick = said(&density, &mitsuba::vol([1, 1, 1], 1, &[1e7]));
    assert!(thick.contains("scene.xml:3:") && thick.contains("mean free paths across its grid"), "{thick}");
    for scale in ["x=\"0\"", "value=\"1e-30\""] {
        let flat = format!("<transform name=\"to_world\"><scale {scale}/></transform>");
        let scene = smoke(&heterogeneous(&gridvolume("sigma_t", &flat)), "3.0.0", &ones);
        let message = "grids of media in a box without volume: nothing is there";
        assert!(noted(&scene, NoteKind::Repaired, message) && !scene.has_media());
    }
    let other = said(&gridvolume("sigma_s", ""), &ones);
    assert!(other.contains("a grid for sigma_s; expected grids for sigma_t and albedo"), "{other}");

    // A missing density is noted, and the medium is omitted. A missing albedo is replaced by the
    // medium's default.
    let missing = smoke(&heterogeneous(&density.replace("a.vol", "b.vol")), "3.0.0", &ones);
    assert!(noted(
        &missing,
        NoteKind::Missing,
        "volume \"b.vol\" could not be read (no such file): nothing is there"
    ));
    assert!(!missing.has_media());
    let missing = smoke(&heterogeneous(&gridvolume("albedo", "").replace("a.vol", "b.vol")), "3.0.0", &ones);
    assert!(noted(
        &missing,
        NoteKind::Missing,
        "volume \"b.vol\" could not be read (no such file): the medium's own"
    ));
    assert_medium(&missing.media()[0], [0.25; 3], [0.75; 3], 0.0);
    let nameless = "<volume type=\"gridvolume\" name=\"sigma_t\"/>";
    let nameless = smoke(&heterogeneous(nameless), "3.0.0", &ones);
    assert!(noted(&nameless, NoteKind::Repaired, "volume \"gridvolume\" without a file: nothing is there"));
}

/// A file that many media name is read again for each of them. Together they may not read more
/// bytes than one file may have.
#[test]
fn a_file_of_a_volume_that_is_named_again_and_again_is_bounded() {
    let file = mitsuba::vol([64, 64, 4], 1, &[0.5; 64 * 64 * 4]);
    let shapes: String = (0..40)
        .map(|i| {
            format!(
                "<shape type=\"cube\">{}</shape>",
                heterogeneous(&gridvolume("sigma_t", "")).replace("smoke", &format!("s{i}"))
            )
        })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.vol"), &file).unwrap();
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, mitsuba::xml("3.0.0", &format!("{VOLPATH}{shapes}"))).unwrap();
    let load = |max_file_bytes| {
        tashika::io::load_scene(
            &path,
            &tashika::io::LoadOptions { max_file_bytes, ..crate::cases::lenient() },
        )
    };
    assert_eq!(load(1 << 30).unwrap().media().len(), 40);
    let error = load(20 * file.len() as u64).unwrap_err().to_string();
    assert!(error.contains("more bytes of volumes; expected at most"), "{error}");
}
