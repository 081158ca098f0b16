//! Textures in UDIM tiles, in every format that supports them.

use tashika::color::Rgb;
use tashika::error::{Error, Result};
use tashika::io::LoadOptions;
use tashika::math::Vec2;
use tashika::scene::{NoteKind, Scene, Surface};

use super::cases::lenient;
use super::mitsuba::png;
use super::textures;

const FORMATS: [&str; 3] = ["Mitsuba", "pbrt", "OBJ"];

/// An image of one colour whose channels are 0 or 255.
fn plain(color: [u8; 3]) -> Vec<u8> {
    png([[color[0], color[1], color[2], 255]; 4])
}

/// Image of tile 1001: green above, blue below.
fn halves() -> Vec<u8> {
    let (green, blue) = ([0, 255, 0, 255], [0, 0, 255, 255]);
    png([green, green, blue, blue])
}

/// A triangle with the texture `pattern`. The middle of its texture coordinates is at `(u, v)`,
/// with `v` up.
fn scene(
    format: &str,
    pattern: &str,
    [u, v]: [f32; 2],
    tiles: &[(&str, &[u8])],
    options: &LoadOptions,
) -> Result<Scene> {
    let corners = [[u, v - 0.1], [u - 0.1, v + 0.05], [u + 0.1, v + 0.05]];
    let uvs = |separator: &str| corners.map(|[u, v]| format!("{u} {v}")).join(separator);
    let obj = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt {}\nusemtl m\nf 1/1 2/2 3/3\n", uvs("\nvt "));
    match format {
        "Mitsuba" => {
            let text = format!(
                "<scene version=\"3.0.0\"><shape type=\"obj\"><string name=\"filename\" value=\"m.obj\"/>\
                 <bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\">\
                 <string name=\"filename\" value=\"{pattern}\"/></texture></bsdf></shape></scene>"
            )
            .replace("<UDIM>", "&lt;UDIM&gt;");
            textures::load("a.xml", &text, &[tiles, &[("m.obj", obj.as_bytes())]].concat(), options)
        }
        "pbrt" => {
            let text = format!(
                "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"{pattern}\"\n\
                 Material \"diffuse\" \"texture reflectance\" \"t\"\n\
                 Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]\n\
                 \"point2 uv\" [{}]",
                uvs(" ")
            );
            textures::load("a.pbrt", &text, tiles, options)
        }
        _ => {
            let mtl = format!("newmtl m\nKd 1 1 1\nmap_Kd {pattern}\n");
            let obj = format!("mtllib a.mtl\n{obj}");
            textures::load("a.obj", &obj, &[tiles, &[("a.mtl", mtl.as_bytes())]].concat(), options)
        }
    }
}

/// Reflectance of the triangle at `(u, v)`, `v` up.
fn color(scene: &Scene, u: f32, v: f32) -> Rgb {
    let mesh = &scene.meshes()[0];
    let Surface::Lambert { reflectance } = scene.materials()[mesh.material.index()].surface else { panic!() };
    reflectance.at(scene.textures(), Vec2::new(u, 1.0 - v))
}

/// Notes about missing or damaged files.
fn faults(scene: &Scene) -> Vec<(NoteKind, String)> {
    let notes = scene.notes().iter().filter(|n| n.kind <= NoteKind::Repaired);
    notes.map(|n| (n.kind, n.message)).collect()
}

#[test]
fn tiles_are_chosen_by_the_floor_of_the_coordinates() {
    let (red, white, halves) = (plain([255, 0, 0]), plain([255; 3]), halves());
    let tiles: &[(&str, &[u8])] = &[
        ("w.1001.png", &halves),
        ("W.1002.PNG", &red),
        ("w.1011.png", &white),
        // Files that are not tiles: one without a number, and one whose number is out of range.
        ("w.10a2.png", b"no picture"),
        ("w.0999.png", b"no picture"),
        ("w.10011.png", b"no picture"),
        ("w.<UDIM>.png", b"no picture"),
    ];
    for format in FORMATS {
        let scene = scene(format, "w.<UDIM>.png", [0.5, 1.5], tiles, &LoadOptions::default()).unwrap();
        assert!(faults(&scene).is_empty(), "{format}: {:?}", faults(&scene));
        assert_eq!(scene.images().len(), 3, "{format}");
        let at = |u, v| color(&scene, u, v).to_array();
        assert_eq!(at(0.5, 0.9), [0.0, 1.0, 0.0], "{format}: the upper half");
        assert_eq!(at(0.5, 0.1), [0.0, 0.0, 1.0], "{format}: the lower half, up to its edge");
        assert_eq!(at(0.99, 0.01), [0.0, 0.0, 1.0], "{format}");
        assert_eq!([at(1.0, 0.5), at(1.99, 0.01)], [[1.0, 0.0, 0.0]; 2], "{format}");
        assert_eq!([at(0.01, 1.0), at(0.5, 1.99)], [[1.0; 3]; 2], "{format}");
    }
}

#[test]
fn missing_tiles_are_missing_files() {
    let red = plain([255, 0, 0]);
    let strict = LoadOptions::default();
    for format in FORMATS {
        // A set without tiles, and a set without the tile that the triangle uses.
        for (tiles, part) in [
            (vec![], "w.<UDIM>.png"),
            (vec![("w.1001.png", &red[..])], "image \"w.<UDIM>.png\" has no tile 1023: grey of 0.5"),
        ] {
            let error = scene(format, "w.<UDIM>.png", [2.5, 2.5], &tiles, &strict).unwrap_err();
            let Error::Missing { files, .. } = &error else { panic!("{format}: {error}") };
            assert!(matches!(&files[..], [file] if file.contains(part)), "{format}: {files:?}");
            let scene = scene(format, "w.<UDIM>.png", [2.5, 2.5], &tiles, &lenient()).unwrap();
            assert!(matches!(&faults(&scene)[..], [(NoteKind::Missing, m)] if m.contains(part)));
            if !tiles.is_empty() {
                assert_eq!(color(&scene, 2.5, 2.5), Rgb::gray(0.5), "{format}");
            }
        }
        // Outside the range of tile numbers, no tile counts as missing.
        let scene = scene(format, "w.<UDIM>.png", [-0.5, 0.5], &[("w.1001.png", &red)], &strict).unwrap();
        assert_eq!(color(&scene, -0.5, 0.5), Rgb::gray(0.5), "{format}");
    }
}

#[test]
fn damaged_tiles_are_grey_and_the_others_are_not() {
    let red = plain([255, 0, 0]);
    for format in FORMATS {
        for damaged in [&red[..40], b"", b"P"] {
            let tiles = [("w1001.png", damaged), ("w1002.png", &red[..])];
            let scene = scene(format, "w<UDIM>.png", [0.5, 0.5], &tiles, &LoadOptions::default()).unwrap();
            let faults = faults(&scene);
            assert!(
                matches!(&faults[..], [(NoteKind::Repaired, m)] if m.starts_with("image \"w1001.png\" could not be read")),
                "{format}: {faults:?}"
            );
            assert_eq!(
                [color(&scene, 0.5, 0.5), color(&scene, 1.5, 0.5)],
                [Rgb::gray(0.5), Rgb::new(1.0, 0.0, 0.0)]
            );
        }
    }
}

#[test]
fn tiles_out_of_the_folder_are_not_looked_for() {
    for format in FORMATS {
        let scene = scene(format, "../w.<UDIM>.png", [0.5, 0.5], &[], &lenient()).unwrap();
        let faults = faults(&scene);
        assert!(
            faults.iter().any(|(kind, m)| *kind == NoteKind::Missing && m.contains("allow-outside")),
            "{format}: {faults:?}"
        );
    }
}
