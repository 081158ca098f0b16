//! Places, areas and normals of surfaces, in files and through `xform`.

use std::f32::consts::PI;

use super::*;

/// Checks the area of an object, and that each of its normals is along `normal` of its place.
fn check(scene: &Scene, name: &str, expected: f32, tolerance: f32, normal: impl Fn(Vec3) -> Vec3) {
    let found = area(scene, name);
    assert!((found / expected - 1.0).abs() < tolerance, "{name}: {found}, not {expected} m²");
    for (place, n, _) in triangles(scene, name) {
        // The shading normals vary by 6° between the columns of a mesh; flat triangles by 3°.
        assert!(n.dot(normal(place).normalize()) > 0.99, "{name} at {place}: {n}");
    }
}

#[test]
fn quadrics_have_their_area_and_face_as_the_manual_says() {
    let scene = grey_scene(
        "grey sphere sphere 0 0 4 1 2 3 .5\n\
         grey bubble bubble 0 0 4 1 2 3 .5\n\
         grey sphere negative 0 0 4 1 2 3 -.5\n\
         grey cylinder cylinder 0 0 7 1 0 0 1 0 3 .25\n\
         grey tube tube 0 0 7 1 0 0 1 0 3 .25\n\
         grey cone cone 0 0 8 0 0 0 0 0 2 1 .5\n\
         grey cup cup 0 0 8 0 0 0 0 0 2 1 .5\n\
         grey cone tip 0 0 8 0 0 1 0 0 0 0 1\n\
         grey ring ring 0 0 8 1 2 3 0 1 0 .5 1\n\
         grey ring disk 0 0 8 1 2 3 0 -1 0 2 0\n",
    );
    let center = Vec3::new(1.0, 2.0, 3.0);
    let around = |p: Vec3| Vec3::new(p.x - 1.0, p.y, 0.0);
    // Of the cone from radius 1 at height 0 to 1/2 at 2: the slope of the normal is 1/4.
    let slant = |p: Vec3| Vec3::new(p.x, p.y, 0.25 * p.truncate().length());
    let (exact, coarse) = (1e-5, 2e-3);
    check(&scene, "sphere", PI, exact, |p| p - center);
    check(&scene, "bubble", PI, exact, |p| center - p);
    check(&scene, "negative", PI, exact, |p| center - p);
    check(&scene, "cylinder", 1.5 * PI, exact, around);
    check(&scene, "tube", 1.5 * PI, exact, |p| -around(p));
    let cone = PI * 1.5 * 4.25_f32.sqrt();
    check(&scene, "cone", cone, coarse, slant);
    check(&scene, "cup", cone, coarse, |p| -slant(p));
    check(&scene, "tip", PI * 2.0_f32.sqrt(), coarse, |p| Vec3::new(p.x, p.y, p.truncate().length()));
    check(&scene, "ring", 0.75 * PI, exact, |_| Vec3::Y);
    check(&scene, "disk", 4.0 * PI, exact, |_| Vec3::NEG_Y);
    for (place, ..) in triangles(&scene, "cylinder") {
        assert!((around(place).length() - 0.25).abs() < 1e-3 && (0.0..=3.0).contains(&place.z), "{place}");
    }
    for (place, ..) in triangles(&scene, "ring") {
        let r = (place - center).length();
        assert!(place.y == 2.0 && r > 0.49 && r < 1.01, "{place}");
    }
    assert_eq!(notes(&scene), []);
}

#[test]
fn polygons_may_be_concave_and_have_holes_by_seams() {
    let scene = grey_scene(
        "grey polygon hook 0 0 18 0 0 0 2 0 0 2 1 0 1 1 0 1 2 0 0 2 0\n\
         grey polygon window 0 0 30 0 1 0 4 1 0 4 1 3 0 1 3 0 1 0 1 1 1 1 1 2 2 1 2 2 1 1 1 1 1\n\
         grey polygon down 0 0 12 0 0 5 0 1 5 1 1 5 1 0 5\n",
    );
    check(&scene, "hook", 3.0, 1e-6, |_| Vec3::Z);
    // 4 × 3 m with a hole of a square metre; the outer corners run around −y.
    check(&scene, "window", 11.0, 1e-6, |_| Vec3::NEG_Y);
    let inside = |p: Vec3| p.x > 1.0 && p.x < 2.0 && p.z > 1.0 && p.z < 2.0;
    assert!(triangles(&scene, "window").iter().all(|t| !inside(t.0)));
    check(&scene, "down", 1.0, 1e-6, |_| Vec3::NEG_Z);
    assert_eq!(notes(&scene), []);
}

#[test]
fn walls_may_have_several_windows_whose_seams_meet() {
    // A wall of 8 × 3 m with three windows of 1 × 1 m, whose seams begin at two corners.
    let window = |x: u32| format!("{x} 0 1 {} 0 1 {} 0 2 {x} 0 2 {x} 0 1", x + 1, x + 1);
    let (a, b, c) = (window(1), window(3), window(5));
    for (corners, area, count) in [
        (format!("0 0 0 0 0 3 8 0 3 8 0 0 0 0 0 {a} 0 0 0 {b}"), 22.0, 16),
        (format!("0 0 0 0 0 3 8 0 3 8 0 0 0 0 0 {a} 0 0 0 {b} 0 0 0"), 22.0, 17),
        (format!("0 0 0 0 0 3 {a} 0 0 3 {b} 0 0 3 8 0 3 8 0 0 {c} 8 0 0"), 21.0, 22),
    ] {
        for options in ["", "-rz 30 -rx 20 -t 3 1 7"] {
            let text = format!("{GREY}grey polygon wall 0 0 {} {corners}", 3 * count);
            let scene = load(&[("scene.rad", &format!("!xform {options} a.rad")), ("a.rad", &text)]).unwrap();
            assert_eq!(notes(&scene), [], "{corners}");
            let found = super::area(&scene, "wall");
            assert!((found / area - 1.0).abs() < 1e-5, "{corners}: {found}");
            if options.is_empty() {
                check(&scene, "wall", area, 1e-5, |_| Vec3::Y);
                let is_in = |x: f32, p: Vec3| p.x > x && p.x < x + 1.0 && p.z > 1.0 && p.z < 2.0;
                assert!(triangles(&scene, "wall").iter().all(|t| !is_in(1.0, t.0) && !is_in(3.0, t.0)));
            }
        }
    }
}

#[test]
fn polygons_of_one_name_are_one_object() {
    let square = |z: u32| format!("grey polygon floor 0 0 12 0 0 {z} 1 0 {z} 1 1 {z} 0 1 {z}\n");
    let scene = grey_scene(&[square(0), square(1), square(2)].concat());
    assert_eq!(names(&scene), ["floor"]);
    assert_eq!(area(&scene, "floor"), 3.0);
}

#[test]
fn surfaces_without_area_are_left_out_with_a_note() {
    for (text, why) in [
        ("grey sphere s 0 0 4 0 0 0 0", "spheres with a radius of 0"),
        ("grey cylinder s 0 0 7 0 0 0 0 0 0 1", "cylinders with two ends at one point"),
        ("grey cone s 0 0 8 0 0 0 0 0 1 -1 1", "cones with radii below 0, or of 0 at both ends"),
        ("grey ring s 0 0 8 0 0 0 0 0 1 1 1", "rings with radii that enclose no area"),
        ("grey ring s 0 0 8 0 0 0 0 0 0 0 1", "rings with a normal of length 0"),
        ("grey polygon s 0 0 9 0 0 0 1 0 0 2 0 0", "polygons with no area"),
    ] {
        let found = notes(&grey_scene(&format!("{text}\ngrey sphere other 0 0 4 0 0 0 1")));
        assert!(found.len() == 1 && found[0].1 == format!("{why}: left out"), "{text}: {found:?}");
    }
}

/// A triangle in the plane z = 0 with the corners (1, 0), (2, 0) and (1, 1), facing up.
const PART: &str = "grey polygon t 0 0 9 1 0 0 2 0 0 1 1 0\n";

/// Loads a command with [`PART`] in `a.rad`.
fn through(command: &str) -> Scene {
    let part = format!("{GREY}{PART}");
    let nested = format!("!xform -n in -m grey -t 0 5 0 a.rad\n{GREY}");
    load(&[("scene.rad", &format!("{GREY}{command}\n")), ("a.rad", &part), ("nested.rad", &nested)]).unwrap()
}

/// Centre and normal of the only triangle of an object.
fn only(scene: &Scene, name: &str) -> (Vec3, Vec3) {
    let [(center, normal, _)] = triangles(scene, name)[..] else { panic!("{name}") };
    (center, normal)
}

#[test]
fn arrays_of_xform_place_copies_with_numbered_names() {
    let scene = through("!xform -n w -rz 90 -a 2 -t 0 0 1 \\\n -a 2 -t 10 0 0 -i 1 -s 2 a.rad");
    assert_eq!(names(&scene), ["w.0.0.t", "w.0.1.t", "w.1.0.t", "w.1.1.t"]);
    // The centre is at (4/3, 1/3, 0), after the rotation at (−1/3, 4/3, 0).
    for (name, x, z) in
        [("w.0.0.t", 0.0, 0.0), ("w.0.1.t", 10.0, 0.0), ("w.1.0.t", 0.0, 1.0), ("w.1.1.t", 10.0, 1.0)]
    {
        let (center, normal) = only(&scene, name);
        let expected = 2.0 * Vec3::new(x - 1.0 / 3.0, 4.0 / 3.0, z);
        assert!((center - expected).length() < 1e-5, "{name}: {center}");
        assert_eq!(normal, Vec3::Z);
    }
    assert!((area(&scene, "w.0.0.t") - 2.0).abs() < 1e-5);
    assert_eq!(names(&through("!xform -a 2 -t 1 0 0 a.rad")), ["a0.t", "a1.t"]);
}

#[test]
fn commands_in_included_files_compose_with_those_around_them() {
    let scene = through("!xform -n out -s 2 nested.rad");
    let (center, _) = only(&scene, "out.in.t");
    assert!((center - 2.0 * Vec3::new(4.0 / 3.0, 16.0 / 3.0, 0.0)).length() < 1e-5, "{center}");
    let piped = through("!cat a.rad | xform -t 1 0 0 | xform -s 3");
    let (center, _) = only(&piped, "t");
    assert!((center - 3.0 * Vec3::new(7.0 / 3.0, 1.0 / 3.0, 0.0)).length() < 1e-5, "{center}");
}

#[test]
fn files_of_arguments_make_a_copy_for_each_line() {
    let part = format!("{GREY}{PART}");
    let files = [
        ("scene.rad", "!xform -n q -t 0 0 1 -f args -s 2 a.rad\n"),
        ("a.rad", &*part),
        ("args", "# x\n-t 1 0 0\n\n-t 2 0 0\n"),
    ];
    let scene = load(&files).unwrap();
    for (name, x) in [("q.0.t", 1.0), ("q.1.t", 2.0)] {
        let (center, _) = only(&scene, name);
        assert!(
            (center - 2.0 * Vec3::new(x + 4.0 / 3.0, 1.0 / 3.0, 1.0)).length() < 1e-5,
            "{name}: {center}"
        );
    }
}

#[test]
fn mirrored_and_inverted_surfaces_face_as_xform_turns_them() {
    for (options, normal) in [
        ("-mx", Vec3::Z),
        ("-mz", Vec3::NEG_Z),
        ("-I", Vec3::NEG_Z),
        ("-I -mz", Vec3::Z),
        ("-I -mx", Vec3::NEG_Z),
    ] {
        assert_eq!(only(&through(&format!("!xform {options} a.rad")), "t").1, normal, "{options}");
    }
    let sphere = format!("{GREY}grey sphere s 0 0 4 1 0 0 1\ngrey ring r 0 0 8 0 0 1 0 0 1 0 1\n");
    for (options, outward, up) in [
        ("", 1.0, 1.0),
        ("-mx -mz", 1.0, -1.0),
        ("-mz", 1.0, -1.0),
        ("-I", -1.0, -1.0),
        ("-I -mz", -1.0, 1.0),
    ] {
        let scene = load(&[("scene.rad", &format!("!xform {options} a.rad")), ("a.rad", &sphere)]).unwrap();
        let center = if options.contains("mx") { Vec3::NEG_X } else { Vec3::X };
        check(&scene, "s", 4.0 * PI, 1e-5, |p| outward * (p - center));
        check(&scene, "r", PI, 1e-5, |_| up * Vec3::Z);
    }
}

#[test]
fn modifiers_of_xform_replace_those_of_all_surfaces() {
    let text =
        format!("{GREY}void light lamp 0 0 3 1 1 1\n!xform -m lamp nested.rad\n!xform -n b -m lamp a.rad");
    let part = format!("{GREY}{PART}");
    let nested = "!xform -m grey a.rad";
    let scene = load(&[("scene.rad", &text), ("a.rad", &part), ("nested.rad", nested)]).unwrap();
    assert_eq!(scene.area_emitters().count(), 2, "the outer modifier counts");
}

#[test]
fn quadrics_of_one_kind_share_a_mesh() {
    let spheres: String = (0..50).map(|k| format!("grey sphere s{k} 0 0 4 {k} 0 0 .{}\n", k + 1)).collect();
    assert_eq!(grey_scene(&spheres).meshes().len(), 1);
}
