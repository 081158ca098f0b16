//! OBJ and MTL files: every statement has the meaning that the format gives it, tested by numbers.

use std::fs;

use tashika::color::Rgb;
use tashika::error::{Error, Result};
use tashika::io::load_scene;
use tashika::math::{Vec2, Vec3};
use tashika::scene::{
    AlphaMode, Channel, ColorInput, FloatInput, Material, Mesh, Note, NoteKind, Scene, Surface, Texture, Wrap,
};
use tempfile::TempDir;

use crate::cases::lenient;

/// Creates a folder with `files` and loads its `scene.obj`.
fn load_in(files: &[(&str, &[u8])]) -> (TempDir, Result<Scene>) {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    let scene = load_scene(&folder.path().join("scene.obj"), &lenient());
    (folder, scene)
}

fn load(files: &[(&str, &[u8])]) -> Scene {
    load_in(files).1.unwrap()
}

pub fn load_obj(text: &str) -> Scene {
    load(&[("scene.obj", text.as_bytes())])
}

/// A triangle with the material `m`, described by `mtl`.
pub fn load_material(mtl: &str, images: &[(&str, &[u8])]) -> Scene {
    let obj = b"mtllib scene.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
    let text = format!("newmtl m\n{mtl}");
    let mut files: Vec<(&str, &[u8])> = vec![("scene.obj", obj), ("scene.mtl", text.as_bytes())];
    files.extend_from_slice(images);
    load(&files)
}

fn material(mtl: &str) -> Material {
    load_material(mtl, &[]).materials()[0].clone()
}

/// A PNG with `width` texels per row.
pub fn png(width: u32, texels: &[[u8; 4]]) -> Vec<u8> {
    let raw: Vec<u8> = texels.concat();
    let picture = image::RgbaImage::from_raw(width, texels.len() as u32 / width, raw).unwrap();
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn note(scene: &Scene, part: &str) -> Option<Note> {
    scene.notes().iter().find(|n| n.message.contains(part))
}

fn messages(scene: &Scene) -> Vec<String> {
    scene.notes().iter().map(|n| n.message).collect()
}

fn corners(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    (0..mesh.triangles().len() as u32).map(|i| mesh.corners(i)).collect()
}

fn double_area([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a)
}

const POINTS: &str =
    "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nvt 0.25 0.75\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\nvn 1 0 0\n";

#[test]
fn every_form_of_index_finds_its_elements() {
    for (face, has_uvs, has_normals) in [
        ("f 1 2 3", false, false),
        ("f 1/1 2/2 3/3", true, false),
        ("f 1//1 2//1 3//1", false, true),
        ("f 1/1/1 2/2/1 3/3/1", true, true),
        ("f -4/-4/-2 -3/-3/-2 -2/-2/-2", true, true),
        ("f 1/1/ 2/2/ 3/3/", true, false),
        ("f +1 2// -2/", false, false),
    ] {
        let scene = load_obj(&format!("{POINTS}{face}"));
        let mesh = &scene.meshes()[0];
        assert_eq!(corners(mesh), [[Vec3::ZERO, Vec3::X * 2.0, Vec3::new(2.0, 2.0, 0.0)]], "{face}");
        let uvs: &[Vec2] =
            if has_uvs { &[Vec2::new(0.25, 0.25), Vec2::new(1.0, 1.0), Vec2::new(1.0, 0.0)] } else { &[] };
        assert_eq!(mesh.uvs(), uvs, "{face}: v is turned to run down");
        let normals: &[Vec3] = if has_normals { &[Vec3::Z; 3] } else { &[] };
        assert_eq!(mesh.normals(), normals, "{face}");
    }
}

#[test]
fn corners_of_one_face_may_take_different_forms() {
    let scene = load_obj(&format!("{POINTS}f 1/1/2 2//2 3"));
    let mesh = &scene.meshes()[0];
    assert_eq!(mesh.uvs(), [Vec2::new(0.25, 0.25), Vec2::ZERO, Vec2::ZERO]);
    assert_eq!(mesh.normals(), [Vec3::X, Vec3::X, Vec3::Z], "the third is the face's");
}

#[test]
fn relative_indices_count_from_the_elements_so_far_and_positive_ones_may_point_forward() {
    let scene =
        load_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nf 4 5 6\nv 0 0 5\nv 1 0 5\nv 0 1 5\nf -3 -2 -1");
    let heights: Vec<f32> = corners(&scene.meshes()[0]).iter().map(|t| t[0].z).collect();
    assert_eq!(heights, [0.0, 5.0, 5.0]);
    assert_eq!(scene.meshes()[0].positions().len(), 6, "equal corners are one vertex");
}

#[test]
fn corners_are_one_vertex_only_if_all_their_parts_agree() {
    let faces = "f 1//1 2//1 3//1\nf 1//1 3//1 4//1\nf 1//2 3//1 4//1\n";
    assert_eq!(load_obj(&format!("{POINTS}{faces}")).meshes()[0].positions().len(), 5);
}

#[test]
fn concave_polygons_keep_their_area_and_direction() {
    // A letter C in a tilted plane: x axis (3, 4, 0)/5, y axis (0, 0, 1).
    let outline = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (3, 2), (3, 3), (0, 3)];
    let mut text = String::new();
    for (x, y) in outline {
        text += &format!("v {} {} {y}\n", 0.6 * x as f32, 0.8 * x as f32);
    }
    let normal = Vec3::new(0.8, -0.6, 0.0);
    for (face, normal) in [("f 1 2 3 4 5 6 7 8", normal), ("f 8 7 6 5 4 3 2 1", -normal)] {
        let scene = load_obj(&format!("{text}{face}"));
        let triangles = corners(&scene.meshes()[0]);
        let areas: Vec<f32> = triangles.iter().map(|t| 0.5 * double_area(*t).dot(normal)).collect();
        assert!(areas.iter().all(|&a| a > 0.0), "{areas:?}");
        // A fan would cover 9 − 2 plus its overlaps. Coordinates have an error of 2⁻²⁴ of 3.
        assert!((areas.iter().sum::<f32>() - 7.0).abs() < 1e-5, "{areas:?}");
        assert_eq!(messages(&scene).len(), 2, "material and camera: {:?}", messages(&scene));
    }
}

#[test]
fn large_polygons_take_linear_time() {
    let n = 200_000;
    let polygon = |radius: &dyn Fn(usize) -> f64| {
        let mut text = String::new();
        for i in 0..n {
            let (sin, cos) = (i as f64 / n as f64 * std::f64::consts::TAU).sin_cos();
            text += &format!("v {} {} 0\n", cos * radius(i), sin * radius(i));
        }
        let face: Vec<String> = (1..=n).map(|i| i.to_string()).collect();
        load_obj(&format!("{text}f {}", face.join(" ")))
    };
    // Not convex, and too large to be clipped.
    let scene = polygon(&|i| if i % 2 == 0 { 1.0 } else { 0.5 });
    assert_eq!(note(&scene, "too large to triangulate").unwrap().kind, NoteKind::Approximated);
}

#[test]
fn meshes_follow_materials_in_the_order_of_their_first_face() {
    let triangle = |i: usize| format!("v {i} 0 0\nv {i} 1 0\nv {i} 0 1\nf -3 -2 -1\n");
    let names = ["  red paint\t", "unused", "b", "red paint", "b#1", "b"];
    let mut text = triangle(0);
    for (i, name) in names.iter().enumerate() {
        text += &format!("o part {i}\ng a b\nusemtl {name}\n");
        if *name != "unused" {
            text += &triangle(i + 1);
        }
    }
    let scene = load_obj(&text);
    let got: Vec<(&str, Vec<f32>)> = scene
        .instances()
        .iter()
        .map(|i| {
            let mesh = &scene.meshes()[i.mesh.index()];
            let material = &scene.materials()[mesh.material.index()];
            assert_eq!(material.name, mesh.name());
            (material.name.as_str(), corners(mesh).iter().map(|t| t[0].x).collect())
        })
        .collect();
    let expected = [
        ("without material", vec![0.0]),
        ("red paint", vec![1.0, 4.0]),
        ("b", vec![3.0, 6.0]),
        ("b#1", vec![5.0]),
    ];
    assert_eq!(got, expected);
    assert!(scene.instances().iter().all(|i| i.is_identity()));
    let grey = Surface::Lambert { reflectance: Rgb::gray(0.5).into() };
    assert!(scene.materials().iter().all(|m| m.surface == grey));
    let undefined = note(&scene, "\"red paint\" is not defined").unwrap();
    assert_eq!((undefined.kind, undefined.first.line), (NoteKind::Repaired, Some(7)));
    assert_eq!(note(&scene, "faces without material").unwrap().kind, NoteKind::Defaulted);
}

/// A unit cube around the origin. Its faces are cut along diagonals, so that its corners have
/// different numbers of triangles.
fn cube() -> String {
    let mut text = String::new();
    for i in 0..8 {
        let c = |bit: u32| if i & bit == 0 { -1 } else { 1 };
        text += &format!("v {} {} {}\n", c(1), c(2), c(4));
    }
    text
}

const CUBE_FACES: &str = "f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\n\
    f 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 7 3\nf 2 4 8\nf 2 8 6\n";

#[test]
fn smoothing_does_not_depend_on_how_faces_are_cut() {
    let scene = load_obj(&format!("{}s 1\n{CUBE_FACES}", cube()));
    let mesh = &scene.meshes()[0];
    assert_eq!(mesh.positions().len(), 8);
    for (p, n) in mesh.positions().iter().zip(mesh.normals()) {
        // Without weights, or with weights by area, the normals are wrong by 0.1 and more. The
        // tolerance covers sums of a few rounded angles.
        assert!((p.normalize() - *n).length() < 1e-6, "{p}: {n}");
    }
}

#[test]
fn smoothing_groups_end_at_their_edges() {
    // Two squares that meet at a right angle along 2-3.
    let squares = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 -1\nv 1 1 -1\n";
    let load = |first: &str, second: &str| {
        load_obj(&format!("{squares}s {first}\nf 1 2 3 4\ns {second}\nf 2 5 6 3"))
    };
    let normals_at = |scene: &Scene, p: Vec3| -> Vec<Vec3> {
        let mesh = &scene.meshes()[0];
        mesh.positions().iter().zip(mesh.normals()).filter(|(q, _)| **q == p).map(|(_, n)| *n).collect()
    };
    let edge = Vec3::new(1.0, 1.0, 0.0);
    let shared = normals_at(&load("7", "7"), edge);
    assert_eq!(shared.len(), 1);
    assert!((shared[0] - Vec3::new(1.0, 0.0, 1.0).normalize()).length() < 1e-6);
    assert_eq!(normals_at(&load("1", "2"), edge), [Vec3::Z, Vec3::X]);
    for off in ["off", "0"] {
        let mixed = load("1", off);
        assert_eq!(normals_at(&mixed, edge), [Vec3::Z, Vec3::X], "a flat face beside a smooth one");
        assert!(load(off, off).meshes()[0].normals().is_empty(), "flat all over");
        assert_eq!(load(off, off).meshes()[0].positions().len(), 6);
    }
    let given = load_obj(&format!("{squares}vn 0 1 0\ns 1\nf 1//1 2//1 3//1 4//1\nf 2 5 6 3"));
    assert_eq!(normals_at(&given, edge), [Vec3::Y, Vec3::X], "given normals come before smooth ones");
}

#[test]
fn smoothing_weighs_reflex_corners_by_their_whole_angle() {
    // An L in the plane z = 0 with a reflex corner at (1, 1). A wall x = 1 stands on this corner.
    let text = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nv 1 1 1\nv 1 2 1\n\
                s 1\nf 1 2 3 4 5 6\nf 4 5 8 7\n";
    let scene = load_obj(text);
    let mesh = &scene.meshes()[0];
    let at = mesh.positions().iter().position(|p| *p == Vec3::new(1.0, 1.0, 0.0)).unwrap();
    // The floor has an angle of 270° at the corner, the wall one of 90°.
    let expected = Vec3::new(1.0, 0.0, 3.0).normalize();
    assert!((mesh.normals()[at] - expected).length() < 1e-6, "{}", mesh.normals()[at]);
}

#[test]
fn text_means_the_same_in_every_encoding_and_layout() {
    let plain = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0.5 1e1 0\nusemtl Wände 1\nf 1 2 3\n";
    let mtl = "newmtl Wände 1\nKd 0.25 0.5 0.75\n";
    let utf16 = |text: &str| -> Vec<u8> {
        [0xff, 0xfe].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect()
    };
    let latin1 =
        |text: &str| -> Vec<u8> { text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect() };
    let layout = "\u{feff}# C:\\models\\\r\n\tmtllib   a.mtl  \r\n v 0. -.0 +0\r\nv\t1 \\\r\n  0 0 \t\r\n\r\n\
                  v .5 1.0E+01 0e5 # apex\r\nusemtl  Wände 1 \r\n  f 1 2 3 # face\r\n# end";
    for (obj, mtl) in [
        (plain.as_bytes().to_vec(), mtl.as_bytes().to_vec()),
        (utf16(plain), latin1(mtl)),
        (latin1(plain), utf16(mtl)),
        (layout.as_bytes().to_vec(), mtl.replace('\n', "\r").into_bytes()),
    ] {
        let scene = load(&[("scene.obj", &obj), ("a.mtl", &mtl)]);
        assert_eq!(corners(&scene.meshes()[0]), [[Vec3::ZERO, Vec3::X, Vec3::new(0.5, 10.0, 0.0)]]);
        let expected = Surface::Lambert { reflectance: Rgb::new(0.25, 0.5, 0.75).into() };
        assert_eq!(
            (scene.materials()[0].name.as_str(), &scene.materials()[0].surface),
            ("Wände 1", &expected)
        );
        assert_eq!(messages(&scene).len(), 1, "camera: {:?}", messages(&scene));
    }
}

#[test]
fn what_is_left_out_is_noted_once_with_its_first_line_and_count() {
    let text = format!(
        "{POINTS}v 0 0 1 0.5\nv 1 0 0 1 0 0\nv 1 1 1 0 1 0\nl 1 2\nl 2 3\np 1\ncstype bezier\ncurv 0 1 1 2\n\
         lod 3\nmaplib a\ncall b.obj\nf 1 2\nf 1\nf 1 2 3\nvw 1 1\nvw 2 1\n"
    );
    let scene = load_obj(&text);
    let expected = [
        ("vertex colours", NoteKind::Ignored, 12, 2),
        ("line elements", NoteKind::Ignored, 14, 2),
        ("points", NoteKind::Ignored, 16, 1),
        ("free-form", NoteKind::Ignored, 17, 2),
        ("render attributes", NoteKind::Ignored, 19, 1),
        ("maplib", NoteKind::Ignored, 20, 1),
        ("call", NoteKind::Ignored, 21, 1),
        ("fewer than three corners", NoteKind::Repaired, 22, 2),
        ("\"vw\"", NoteKind::Ignored, 25, 2),
    ];
    for (part, kind, line, count) in expected {
        let n = note(&scene, part).unwrap_or_else(|| panic!("no note on {part}: {:?}", messages(&scene)));
        assert_eq!((n.kind, n.first.line, n.count), (kind, Some(line), count), "{part}");
    }
    assert_eq!(scene.instanced_triangles(), 1);
    // The expected notes, and the defaults for material and camera.
    assert_eq!(messages(&scene).len(), expected.len() + 2, "{:?}", messages(&scene));
}

#[test]
fn unknown_statements_are_named_up_to_twenty() {
    let unknown: String = (0..50).map(|i| format!("x{i} 1 2 3\n")).collect();
    let scene = load_obj(&format!("{POINTS}f 1 2 3\n{unknown}"));
    let named =
        messages(&scene).iter().filter(|m| m.contains("not of the format") && m.contains("\"x")).count();
    assert_eq!(named, 20);
    assert_eq!(note(&scene, "further statements").unwrap().count, 30);
}

#[test]
fn errors_name_the_line_the_value_and_what_is_expected() {
    for (line, expected) in [
        ("f 1 2 9", "scene.obj:11: vertex index 9; expected 1 to 4, as the file has 4 vertices (v)"),
        (
            "f 1/1 2/5 3/1",
            "scene.obj:11: texture coordinate index 5; expected 1 to 4, as the file has 4 texture",
        ),
        ("f 1//1 2//3 3//1", "scene.obj:11: normal index 3; expected 1 to 2, as the file has 2 normals (vn)"),
        (
            "f 1 2 -5",
            "scene.obj:11: vertex index -5 in \"-5\"; expected -1 to -4, as there are 4 vertices (v) so far",
        ),
        ("f 0/0/0 1/1/1 2/2/2", "scene.obj:11: vertex index 0 in \"0/0/0\"; expected an index from 1, or"),
        (
            "f 1 2 99999999999999999999",
            "scene.obj:11: vertex index 99999999999999999999; expected an index of at most",
        ),
        ("f 1 2 x", "scene.obj:11: face corner \"x\"; expected v, v/t, v//n or v/t/n with whole numbers"),
        ("f 1 2 1/2/3/4", "scene.obj:11: face corner \"1/2/3/4\"; expected v, v/t"),
        ("f 1 2 /1", "scene.obj:11: face corner \"/1\"; expected v, v/t"),
        ("f 1.0 2 3", "scene.obj:11: face corner \"1.0\"; expected v, v/t"),
        ("v 1 2", "scene.obj:11: v with 2 numbers; expected at least 3"),
        ("v 1,5 2 3", "scene.obj:11: v with \"1,5\"; expected a number"),
        ("vt", "scene.obj:11: vt with 0 numbers; expected at least 1"),
        ("vn 0 one 0", "scene.obj:11: vn with \"one\"; expected a number"),
    ] {
        let (_folder, result) = load_in(&[("scene.obj", format!("{POINTS}{line}\nf 1 2 3").as_bytes())]);
        let error = result.unwrap_err();
        assert!(matches!(error, Error::Invalid { .. }));
        assert!(error.to_string().contains(expected), "{error}\nfor {expected}");
    }
    let (_folder, result) = load_in(&[("scene.obj", b"Dear reader,\nthis is a letter.\n")]);
    let error = result.unwrap_err().to_string();
    assert!(error.contains("scene.obj:1: \"Dear\", and no OBJ statement in the whole file"), "{error}");
}

#[test]
fn files_without_faces_are_scenes_without_triangles() {
    for text in ["", "\n", "# nothing\n", "v 1 2 3\n", "g empty\n"] {
        let scene = load_obj(text);
        assert_eq!(scene.instanced_triangles(), 0);
        assert!(note(&scene, "no triangle to render").is_some());
    }
}

#[test]
fn indices_of_attributes_that_the_whole_file_lacks_are_left_out() {
    let scene = load_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1/1 2/2/2 3/3/3\n");
    let mesh = &scene.meshes()[0];
    assert!(mesh.uvs().is_empty() && mesh.normals().is_empty() && mesh.triangles().len() == 1);
    assert_eq!(note(&scene, "without any vn").unwrap().first.line, Some(4));
    assert_eq!(note(&scene, "without any vt").unwrap().count, 3);
}

/// Exporters write 0 for a missing texture coordinate or normal.
#[test]
fn corners_with_index_zero_go_without_the_attribute() {
    let scene = load_obj(&format!("{POINTS}f 1/0/2 2/0/2 3/0/2\nf 1/1/0 3/3/0 4/4/0\n"));
    let mesh = &scene.meshes()[0];
    assert_eq!(mesh.triangles().len(), 2);
    let said = note(&scene, "index 0 of a texture coordinate or normal").unwrap();
    assert_eq!((said.kind, said.first.line, said.count), (NoteKind::Repaired, Some(11), 6));
    let of_first = mesh.triangles()[0].map(|i| mesh.normals()[i as usize]);
    assert_eq!(of_first, [Vec3::X; 3], "normals that are there are kept");
    let of_second = mesh.triangles()[1].map(|i| mesh.normals()[i as usize]);
    assert_eq!(of_second, [Vec3::Z; 3], "the normal of the face stands in");
}

#[test]
fn materials_become_the_nearest_surface() {
    let rgb = Rgb::new;
    let lambert = |c: Rgb| Surface::Lambert { reflectance: c.into() };
    let phong = |d: Rgb, s: Rgb, exponent| Surface::Phong { diffuse: d.into(), specular: s.into(), exponent };
    let mirror = |c: Rgb| Surface::Mirror { reflectance: c.into() };
    let glass =
        |ior, t: Rgb| Surface::Glass { ior, reflectance: Rgb::WHITE, transmittance: t, facets: 0.0.into() };
    let (a, b) = (rgb(0.1, 0.2, 0.3), rgb(0.4, 0.5, 0.6));
    for (mtl, expected) in [
        ("Kd .1 .2 .3 # comment", lambert(a)),
        ("kd 0.25", lambert(Rgb::gray(0.25))),
        ("", lambert(Rgb::gray(0.5))),
        ("Kd spectral a.rfl", lambert(Rgb::gray(0.5))),
        ("Kd xyz 1 1 1", lambert(Rgb::gray(0.5))),
        ("Kd .1 .2 .3\nKs 0 0 0\nNs 30", lambert(a)),
        ("Kd .1 .2 .3\nKs .4 .5 .6\nNs 30\nillum 2", phong(a, b, 30.0)),
        ("Kd .1 .2 .3\nKs .4 .5 .6", phong(a, b, 10.0)),
        ("Kd .1 .2 .3\nKs .4 .5 .6\nNs 0\nillum 3", phong(a, b, 0.0)),
        ("Kd .1 .2 .3\nKs .4 .5 .6\nNs 30\nillum 1", lambert(a)),
        ("Kd 0 0 0\nKs .4 .5 .6\nNs 30\nillum 5", mirror(b)),
        ("Ks .4 .5 .6\nillum 3", mirror(b)),
        ("Kd .4 .5 .6\nKs .1 .2 .3\nNs 30\nillum 5", phong(b, a, 30.0)),
        ("Kd .1 .2 .3\nd 0.5\nNi 1.3\nillum 4", glass(1.3, Rgb::WHITE)),
        ("Kd .1 .2 .3\nTr 0.5\nillum 9", glass(1.5, Rgb::WHITE)),
        ("Kd .1 .2 .3\nTf .4 .5 .6\nNi 2\nillum 7", glass(2.0, b)),
        ("Kd .1 .2 .3\nTf 0 0 0\nd 0.5\nillum 6", lambert(a)),
        ("Kd .1 .2 .3\nd 1\nNi 1.5\nillum 4", lambert(a)),
        ("Kd .1 .2 .3\nd 0.5\nNi 1\nillum 4", lambert(a)),
        ("Kd .1 .2 .3\nTf 1 1 1\nNi 1.5\nillum 2", lambert(a)),
    ] {
        assert_eq!(material(mtl).surface, expected, "{mtl}");
    }
    let Surface::MetallicRoughness { base_color, metallic, roughness, specular_f0, .. } =
        material("Kd .1 .2 .3\nKs 1 1 1\nPr 0.2\nPm 0.3\nNi 2").surface
    else {
        panic!("physically based")
    };
    assert_eq!((base_color, metallic, roughness), (a.into(), 0.3.into(), 0.2.into()));
    assert!((specular_f0.factor.g - 1.0 / 9.0).abs() < 1e-7, "((2 − 1) / (2 + 1))²");
    let Surface::MetallicRoughness { metallic, roughness, specular_f0, .. } = material("Pm 1").surface else {
        panic!("physically based")
    };
    assert_eq!((metallic, roughness), (1.0.into(), 0.5.into()));
    assert!((specular_f0.factor.r - 0.04).abs() < 1e-7, "of index 1.5");
}

#[test]
fn materials_that_are_approximated_say_so() {
    for (mtl, part, kind) in [
        ("Ks 1\nillum 5", "perfect mirror", NoteKind::Approximated),
        ("d 0.5\nillum 4", "smooth glass", NoteKind::Approximated),
        ("d 0", "wholly transparent", NoteKind::Approximated),
        ("Ks 1", "without Ns", NoteKind::Defaulted),
        ("Ks 1\nillum 1", "without highlights", NoteKind::Ignored),
        ("Kd spectral a.rfl", "spectral", NoteKind::Ignored),
        ("map_Bump a.png", "bump", NoteKind::Ignored),
        ("norm -bm 3 a.png", "-bm", NoteKind::Ignored),
        ("disp a.png", "displacement", NoteKind::Ignored),
        ("refl -type sphere a.png", "reflection maps", NoteKind::Ignored),
        ("Pc 0.5\naniso 0.1", "clear coat", NoteKind::Ignored),
        ("Kt 0.1 0.2 0.3", "\"Kt\"", NoteKind::Ignored),
        ("map_Kd -clamp on", "without a file name", NoteKind::Ignored),
        ("Kd 1\nnewmtl m\nKd 0", "the first definition counts", NoteKind::Ignored),
        ("", "without Kd", NoteKind::Defaulted),
    ] {
        let scene = load_material(mtl, &[]);
        let n = note(&scene, part).unwrap_or_else(|| panic!("{mtl}: {:?}", messages(&scene)));
        assert_eq!(n.kind, kind, "{mtl}");
        assert!(n.first.file.ends_with("scene.mtl") && n.first.line.is_some(), "{mtl}: {}", n.first);
    }
    let silent =
        load_material("Kd 0.5\nKa 1 1 1\nmap_Ka a.png\nsharpness 60\nillum 2\nNs 10\nNi 1.5\nTf 1 1 1", &[]);
    assert_eq!(messages(&silent).len(), 1, "camera: {:?}", messages(&silent));
}

#[test]
fn materials_emit_and_let_light_through() {
    let e = material("Kd 0.5\nKe 17 12 4").emission.unwrap();
    assert_eq!((e.radiance, e.two_sided), (Rgb::new(17.0, 12.0, 4.0).into(), true));
    assert_eq!(material("Kd 0.5\nKe 0 0 0").emission, None);
    for (mtl, opacity) in [
        ("d 0.75", Some(0.75)),
        ("Tr 0.75", Some(0.25)),
        ("d 0.75\nTr 0.5", Some(0.75)),
        ("Tr 0.5\nd 0.75", Some(0.75)),
        ("d -halo 0.5", Some(0.5)),
        ("d 1\nTr 1", None),
        ("Tr 0", None),
        ("", None),
        ("illum 4\nd 0.5", None),
        ("illum 4\nd 0.5\nNi 1", Some(0.5)),
    ] {
        let alpha = material(mtl).alpha;
        assert_eq!(alpha.map(|a| a.value), opacity.map(FloatInput::from), "{mtl}");
        assert!(alpha.is_none_or(|a| a.mode == AlphaMode::Blend));
    }
}

/// Two rows of two texels: red and green above blue and white.
fn four_colors() -> Vec<u8> {
    png(2, &[[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 255]])
}

fn base(material: &Material) -> ColorInput {
    match material.surface {
        Surface::Lambert { reflectance } => reflectance,
        ref other => panic!("{other:?}"),
    }
}

#[test]
fn images_stand_upright_on_their_coordinates() {
    let obj = b"mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.25 0.25\nvt 0.75 0.25\n\
                vt 0.25 0.75\nf 1/1 2/2 3/3";
    let mtl = b"newmtl m\nKd 1 0.5 1\nmap_Kd my picture.png";
    let scene = load(&[("scene.obj", obj), ("a.mtl", mtl), ("my picture.png", &four_colors())]);
    let color = base(&scene.materials()[0]);
    let at: Vec<Rgb> = scene.meshes()[0].uvs().iter().map(|&uv| color.at(scene.textures(), uv)).collect();
    // The colours are blue at the lower left, white at the lower right, red at the upper left; all
    // times Kd.
    assert_eq!(at, [Rgb::new(0.0, 0.0, 1.0), Rgb::new(1.0, 0.5, 1.0), Rgb::new(1.0, 0.0, 0.0)]);
}

#[test]
fn texture_options_move_scale_and_clamp() {
    let lookup = |options: &str, up: Vec2| {
        let scene = load_material(&format!("map_Kd {options} a.png"), &[("a.png", &four_colors())]);
        let color = base(&scene.materials()[0]);
        color.at(scene.textures(), Vec2::new(up.x, 1.0 - up.y))
    };
    let (red, green, blue) = (Rgb::new(1.0, 0.0, 0.0), Rgb::new(0.0, 1.0, 0.0), Rgb::new(0.0, 0.0, 1.0));
    let low_left = Vec2::new(0.25, 0.25);
    assert_eq!(lookup("", low_left), blue);
    assert_eq!(lookup("-o 0 0.5", low_left), red, "up by half the image");
    assert_eq!(lookup("-o 0.5 0.5 0", low_left), green);
    assert_eq!(lookup("-s 1 3", low_left), red, "0.25 · 3 = 0.75");
    assert_eq!(lookup("-s 3 3 1", low_left), green);
    assert_eq!(
        lookup("-s 1 1.5", Vec2::new(0.25, 0.5)),
        red,
        "scaled about the low left corner of the image"
    );
    assert_eq!(lookup("-s 2 2 -o 0.25 -0.25", low_left), Rgb::WHITE, "(0.75, 0.25)");
    assert_eq!(lookup("", Vec2::new(1.25, -0.75)), blue, "repeated");
    assert_eq!(lookup("-clamp on", Vec2::new(7.0, 9.0)), green, "the corner's texel goes on");
    let scene = load_material("map_Kd -mm 0.1 2 a.png", &[("a.png", &four_colors())]);
    assert!(note(&scene, "-mm").is_some());
    let texture = base(&scene.materials()[0]).texture.unwrap();
    let Texture::Image(lookup) = scene.textures().nodes[texture.index()] else { panic!() };
    assert_eq!(lookup.wrap, [Wrap::Repeat; 2]);
}

#[test]
fn opacity_maps_use_alpha_or_else_red() {
    let with_alpha = png(1, &[[200, 0, 0, 51]]);
    let without = png(1, &[[51, 102, 0, 255]]);
    for (mtl, channel, value, images) in [
        ("map_d a.png", Channel::A, 0.2, 1),
        ("d 0.5\nmap_d a.png", Channel::A, 0.1, 1),
        ("map_Kd a.png\nmap_d a.png", Channel::A, 0.2, 1),
        ("map_d r.png", Channel::R, 0.2, 1),
        ("map_Kd r.png\nmap_d r.png", Channel::R, 0.2, 2),
        ("map_d -imfchan g r.png", Channel::G, 0.4, 1),
        ("illum 4\nd 0.5\nmap_d a.png", Channel::A, 0.2, 1),
    ] {
        let scene = load_material(mtl, &[("a.png", &with_alpha), ("r.png", &without)]);
        let alpha = scene.materials()[0].alpha.unwrap();
        assert_eq!(alpha.value.texture.unwrap().1, channel, "{mtl}");
        assert!((alpha.at(scene.textures(), Vec2::ZERO) - value).abs() < 1e-6, "{mtl}");
        assert_eq!(scene.images().len(), images, "{mtl}: one copy where one serves");
    }
}

#[test]
fn maps_without_a_factor_count_fully_and_numbers_are_linear() {
    let image = png(1, &[[51, 102, 153, 255]]);
    let scene =
        load_material("Pr 0.5\nmap_Pr a.png\nmap_Pm -imfchan b a.png\nmap_Ke a.png", &[("a.png", &image)]);
    let m = &scene.materials()[0];
    let Surface::MetallicRoughness { metallic, roughness, .. } = m.surface else { panic!() };
    assert!((roughness.at(scene.textures(), Vec2::ZERO) - 0.5 * 0.2).abs() < 1e-6);
    assert!((metallic.at(scene.textures(), Vec2::ZERO) - 0.6).abs() < 1e-6);
    let emitted = m.emission.unwrap().radiance.at(scene.textures(), Vec2::ZERO);
    assert!((emitted.r - 0.033_105).abs() < 1e-5, "51 of 255 through the sRGB curve: {}", emitted.r);
    let scene = load_material("Kd 0 0 0\nmap_Kd a.png\nmap_Ks a.png", &[("a.png", &image)]);
    let Surface::Phong { diffuse, specular, .. } = scene.materials()[0].surface else { panic!() };
    assert_eq!((diffuse.factor, specular.factor), (Rgb::WHITE, Rgb::WHITE));
    assert_eq!(note(&scene, "black Kd").unwrap().kind, NoteKind::Approximated);
    assert_eq!(scene.images().len(), 1, "one image for all of its uses");
}

#[test]
fn libraries_are_found_by_line_list_folder_and_last_part() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3";
    let definition: &[u8] = b"newmtl m\nKd 0.25\nmap_Kd t/a.png";
    let image = four_colors();
    for (statement, library, image_path) in [
        ("one two.mtl", "one two.mtl", "t/a.png"),
        ("none.mtl b.mtl none2.mtl", "b.mtl", "T/A.PNG"),
        ("none.mtl one\\ two.mtl", "one two.mtl", "t/a.png"),
        ("one\\ two.mtl", "one two.mtl", "t/a.png"),
        ("lib/b.mtl", "lib/b.mtl", "lib/t/a.png"),
        ("lib\\b.mtl", "lib/b.mtl", "t/a.png"),
        ("C:\\Users\\x\\b.mtl", "b.mtl", "a.png"),
        ("C:\\my files\\b.mtl", "b.mtl", "a.png"),
        ("none.mtl lib/b.mtl", "lib/b.mtl", "lib/t/a.png"),
    ] {
        let obj = format!("mtllib {statement}\n{triangle}");
        let scene = load(&[("scene.obj", obj.as_bytes()), (library, definition), (image_path, &image)]);
        let color = base(&scene.materials()[0]);
        assert_eq!(color.factor, Rgb::gray(0.25), "{statement}");
        assert!(color.texture.is_some(), "{statement}: {:?}", messages(&scene));
        assert_eq!(
            note(&scene, "\"none.mtl\" could not be read (no such file)").is_some(),
            statement.starts_with("none")
        );
        assert_eq!(note(&scene, "in the folder of the scene is used").is_some(), statement.starts_with("C:"));
    }
}

#[test]
fn the_first_of_several_libraries_counts() {
    let obj = b"mtllib a.mtl b.mtl\nmtllib ./a.mtl\nmtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n\
                usemtl m\nf 1 2 3\nusemtl n\nf 1 2 3";
    let scene = load(&[
        ("scene.obj", obj),
        ("a.mtl", b"newmtl m\nKd 0.25"),
        ("b.mtl", b"newmtl m\nKd 0.75\nnewmtl n\nKd 1"),
    ]);
    let factors: Vec<f32> = scene.materials().iter().map(|m| base(m).factor.r).collect();
    assert_eq!(factors, [0.25, 1.0]);
    assert_eq!(note(&scene, "defined again").unwrap().count, 1, "a.mtl is read once");
}

#[test]
fn equal_files_give_equal_scenes() {
    let text = format!("{}s 1\n{CUBE_FACES}s 2\n{CUBE_FACES}", cube());
    let [a, b] = [load_obj(&text), load_obj(&text)];
    let (a, b) = (&a.meshes()[0], &b.meshes()[0]);
    assert_eq!(a.positions(), b.positions());
    assert_eq!(a.normals(), b.normals());
    assert_eq!(a.triangles(), b.triangles());
}

#[test]
fn a_missing_image_is_told_at_the_line_of_its_statement() {
    let scene = load_material("Kd 1 1 1\nNs 2\nmap_Kd gone.png\n", &[]);
    let told = note(&scene, "gone.png").unwrap();
    assert_eq!((told.kind, told.first.line), (NoteKind::Missing, Some(4)));
    assert_eq!(told.first.item.as_deref(), Some("newmtl m"));
    // An equal definition of the same material on other lines gives no note.
    let twice = "map_Kd a.png\nnewmtl m\n\nmap_Kd a.png\n";
    assert!(note(&load_material(twice, &[]), "defined again").is_none());
}

#[test]
fn a_slip_is_refused_with_the_name_that_was_meant() {
    let refusal = |obj: &str, mtl: &str| {
        let files = [("scene.obj", obj.as_bytes()), ("scene.mtl", mtl.as_bytes())];
        let error = load_in(&files).1.unwrap_err();
        assert!(matches!(error, Error::Invalid { .. }), "{error}");
        error.to_string()
    };
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (obj, mtl, expected) in [
        (
            format!("{triangle}usemlt m\nf 1 2 3\n"),
            "",
            "scene.obj:4: statement \"usemlt\"; expected a known name: did you mean \"usemtl\"?",
        ),
        (
            format!("mtllib scene.mtl\n{triangle}f 1 2 3\n"),
            "newmtl m\nilum 2\n",
            "scene.mtl:2: material statement \"ilum\"",
        ),
        (
            format!("mtllib scene.mtl\n{triangle}usemtl glas\nf 1 2 3\n"),
            "newmtl glass\n",
            "did you mean \"glass\"?",
        ),
    ] {
        let said = refusal(&obj, mtl);
        assert!(said.contains(expected), "{said}");
    }
    // Numbered names, and keywords that differ in meaning, give notes and not errors.
    let scene = load(&[
        ("scene.obj", format!("mtllib scene.mtl\n{triangle}usemtl wall_2\nf 1 2 3\n").as_bytes()),
        ("scene.mtl", b"newmtl wall_1\nmap_Tr a.png\n"),
    ]);
    assert!(note(&scene, "\"wall_2\" is not defined").is_some() && note(&scene, "map_Tr").is_some());
}
