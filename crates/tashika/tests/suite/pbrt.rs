//! The pbrt loader: directives, transforms, cameras, shapes, objects and included files, in
//! numbers.
//!
//! Lights, materials and textures are in `pbrt_appearance`, damaged files in `damaged_pbrt`.

use std::fs;
use std::io::Write;

use glam::{Vec2, Vec3};
use tashika::color::Rgb;
use tashika::error::{Error, Result};
use tashika::film::Window;
use tashika::io::load_scene;
use tashika::scene::{AlphaMode, CameraSample, Material, NoteKind, Projection, Scene, Surface};
use tempfile::TempDir;

use crate::cases::lenient;

/// Start of a scene, in each version of the format.
pub const V3: &str = "Film \"image\" Camera \"perspective\" WorldBegin\n";
pub const V4: &str = "Film \"rgb\" Camera \"perspective\" WorldBegin\n";

/// A triangle with its normal along +z.
pub const TRIANGLE: &str =
    " Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [0 0 0 1 0 0 0 1 0]\n";

/// A NanoVDB file with a grid `density`. Its root has only one tile of value 3. The active indices
/// are 0 and 1 on all axes, half a metre apart.
pub fn nvdb() -> Vec<u8> {
    let mut grid = vec![0; 672 + 64 + 64 + 32];
    let mut put = |at: usize, value: &[u8]| grid[at..at + value.len()].copy_from_slice(value);
    (0..3).for_each(|k| put(296 + 88 + 32 * k, &0.5_f64.to_le_bytes()));
    put(672 + 24, &64_u64.to_le_bytes());
    let root = 672 + 64;
    (3..6).for_each(|k| put(root + 4 * k, &1_i32.to_le_bytes()));
    put(root + 24, &1_u32.to_le_bytes());
    put(root + 64 + 20, &3_f32.to_le_bytes());
    let mut file = b"NanoVDB0".to_vec();
    file.extend((32_u32 << 21).to_le_bytes());
    file.extend([1, 0, 0, 0]);
    let mut metadata = [0; 176];
    metadata[..8].copy_from_slice(&(grid.len() as u64).to_le_bytes());
    metadata[8..16].copy_from_slice(&(grid.len() as u64).to_le_bytes());
    (metadata[32], metadata[136]) = (1, 8);
    file.extend(metadata);
    file.extend(b"density\0");
    file.extend(grid);
    file
}

/// Folder in which scenes are written and loaded.
pub struct Folder(pub TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        let path = self.0.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        // Rewriting a file in place makes some file systems flush it, which is slow. A new file
        // does not.
        let _ = fs::remove_file(&path);
        fs::write(path, bytes).unwrap();
    }

    pub fn load(&self, text: &str) -> Result<Scene> {
        self.write("scene.pbrt", text);
        load_scene(&self.0.path().join("scene.pbrt"), &lenient())
    }
}

/// Scene of a text that needs no other files.
pub fn scene(text: &str) -> Scene {
    Folder::new().load(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Message of the error for a text, without the folder's name.
pub fn refusal(text: &str) -> String {
    let folder = Folder::new();
    let error = folder.load(text).unwrap_err().to_string();
    error.replace(&format!("{}/", folder.0.path().display()), "")
}

/// Kinds and messages of the notes, except those about a scene without light, camera or triangles.
pub fn notes(scene: &Scene) -> Vec<(NoteKind, String)> {
    let told = scene.notes().iter().filter(|note| note.kind != NoteKind::Defaulted);
    told.map(|note| (note.kind, note.message)).collect()
}

/// Returns true if a note of that kind begins with `start`.
pub fn noted(scene: &Scene, kind: NoteKind, start: &str) -> bool {
    notes(scene).iter().any(|(k, message)| *k == kind && message.starts_with(start))
}

/// World position of a point in the space of the first instance.
fn placed(scene: &Scene, point: [f32; 3]) -> Vec3 {
    scene.instances()[0].to_world.transform_point3(point.into())
}

fn close(a: Vec3, b: [f32; 3]) -> bool {
    (a - Vec3::from(b)).length() < 1e-5 * (1.0 + Vec3::from(b).length())
}

#[test]
fn the_format_is_told_by_what_the_files_use() {
    // The default size of a film differs: 640×480 and 1280×720.
    for (text, width) in [
        ("Camera \"perspective\" WorldBegin Material \"matte\"", 640),
        ("Camera \"perspective\" WorldBegin Material \"diffuse\"", 1280),
        ("Camera \"perspective\" WorldBegin Include \"a.pbrt\" Material \"diffuse\"", 640),
        ("ColorSpace \"srgb\" Camera \"perspective\" WorldBegin WorldEnd", 1280),
        ("Camera \"perspective\" WorldBegin", 1280),
    ] {
        let folder = Folder::new();
        folder.write("a.pbrt", "MakeNamedMaterial \"m\" \"string type\" \"uber\"");
        let scene = folder.load(text).unwrap();
        assert_eq!(scene.cameras()[0].resolution.unwrap()[0], width, "{text}");
    }
}

#[test]
fn transforms_multiply_from_the_right_in_the_order_of_the_text() {
    for (text, expected) in [
        ("Translate 1 2 3 Scale 2 3 4", [3.0, 5.0, 7.0]),
        ("Scale 2 3 4 Translate 1 2 3", [4.0, 9.0, 16.0]),
        ("Rotate 90 0 0 1", [-1.0, 1.0, 1.0]),
        ("Rotate 90 0 0 1 Translate 1 0 0", [-1.0, 2.0, 1.0]),
        ("Transform [1 0 0 0 0 1 0 0 0 0 1 0 5 6 7 1]", [6.0, 7.0, 8.0]),
        ("Translate 9 9 9 Transform [1 0 0 0 0 1 0 0 0 0 1 0 5 6 7 1]", [6.0, 7.0, 8.0]),
        ("Translate 1 1 1 ConcatTransform [0 1 0 0 1 0 0 0 0 0 2 0 0 0 0 1]", [2.0, 2.0, 3.0]),
        ("Translate 1 2 3 Identity", [1.0, 1.0, 1.0]),
        ("Translate 1 2 3 TransformBegin Scale 2 2 2 TransformEnd", [2.0, 3.0, 4.0]),
        ("Translate 1 2 3 CoordinateSystem \"a\" Identity CoordSysTransform \"a\"", [2.0, 3.0, 4.0]),
        // In the middle of the time, half of the motion.
        ("ActiveTransform EndTime Translate 1 2 3 ActiveTransform All", [1.5, 2.0, 2.5]),
        ("ActiveTransform StartTime Translate 1 2 3", [1.5, 2.0, 2.5]),
    ] {
        let scene = scene(&format!("{V4} {text} {TRIANGLE}"));
        assert!(close(placed(&scene, [1.0; 3]), expected), "{text}: {}", placed(&scene, [1.0; 3]));
        assert_eq!(scene.moves(), text.contains("Time"), "{text}");
        assert!(!noted(&scene, NoteKind::Approximated, "things that move"), "{text}");
    }
    // `camera` is the inverse of the transform at the camera, `world` the identity.
    let text = format!(
        "Film \"rgb\" Translate 0 0 5 Camera \"perspective\" WorldBegin CoordSysTransform \"camera\" {TRIANGLE}"
    );
    assert!(close(placed(&scene(&text), [0.0; 3]), [0.0, 0.0, -5.0]));
    for wrong in ["Rotate 90 0 0 0", "LookAt 1 1 1 1 1 1 0 1 0", "CoordSysTransform \"none\""] {
        let scene = scene(&format!("{V4} {wrong} {TRIANGLE}"));
        assert_eq!(notes(&scene)[0].0, NoteKind::Repaired, "{wrong}");
        assert_eq!(placed(&scene, [1.0; 3]), Vec3::ONE);
    }
    for flat in [
        "Scale 0 1 1",
        "Scale 1e30 1e30 1e30 Scale 1e30 1e30 1e30",
        "Transform [1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1]",
    ] {
        let scene = scene(&format!("{V4} {flat} {TRIANGLE}"));
        assert!(
            scene.instances().is_empty() && noted(&scene, NoteKind::Repaired, "shapes and lights with"),
            "{flat}"
        );
    }
}

#[test]
fn attributes_are_saved_and_restored() {
    let red = "Material \"diffuse\" \"rgb reflectance\" [1 0 0]";
    let green = "Material \"diffuse\" \"rgb reflectance\" [0 1 0]";
    let text = format!(
        "{V4} AreaLightSource \"diffuse\" {red} AttributeBegin {green} Translate 1 0 0 {TRIANGLE} AttributeEnd {TRIANGLE}\n\
         TransformBegin {green} Translate 2 0 0 TransformEnd {TRIANGLE}"
    );
    let scene = scene(&text);
    let colors: Vec<Rgb> = scene.area_emitters().map(|(id, _)| reflectance(scene.material_of(id))).collect();
    let (r, g) = (Rgb::new(1.0, 0.0, 0.0), Rgb::new(0.0, 1.0, 0.0));
    assert_eq!(colors, [g, r, g], "transforms alone are restored by TransformEnd");
    let x = |i: usize| scene.instances()[i].to_world.translation.x;
    assert_eq!([x(0), x(1), x(2)], [1.0, 0.0, 0.0]);
    assert!(scene.notes().first_departure().is_none());
}

fn reflectance(material: &Material) -> Rgb {
    match material.surface {
        Surface::Lambert { reflectance } => reflectance.factor,
        other => panic!("{other:?}"),
    }
}

#[test]
fn attributes_that_cross_objects_are_taken_as_pbrt_v3_takes_them() {
    let text = format!(
        "{V3} AttributeBegin Translate 1 0 0 ObjectBegin \"o\" AttributeBegin Translate 0 1 0 {TRIANGLE} AttributeEnd\n\
         AttributeEnd ObjectEnd {TRIANGLE} AttributeBegin Translate 5 0 0 ObjectInstance \"o\" AttributeEnd WorldEnd"
    );
    let scene = scene(&text);
    assert_eq!(notes(&scene).len(), 1, "{:?}", notes(&scene));
    assert!(noted(&scene, NoteKind::Repaired, "ends that do not match"));
    assert!(close(scene.instances()[0].to_world.translation.into(), [0.0; 3]), "all is taken back");
    assert!(close(scene.instances()[1].to_world.translation.into(), [6.0, 1.0, 0.0]));
    for stray in ["AttributeEnd", "TransformEnd", "ObjectEnd"] {
        let scene = self::scene(&format!("{V3} {stray} {TRIANGLE} WorldEnd"));
        assert_eq!((scene.instances().len(), notes(&scene).len()), (1, 1), "{stray}");
    }
    for open in ["AttributeBegin", "ObjectBegin \"o\""] {
        let scene = self::scene(&format!("{V3} {open} {TRIANGLE} WorldEnd"));
        assert!(noted(&scene, NoteKind::Repaired, "attributes or objects without end"), "{open}");
    }
}

#[test]
fn objects_are_kept_once_and_placed_by_both_transforms() {
    let mut text =
        format!("{V4} Translate 0 0 1 ObjectBegin \"o\" Scale 2 2 2 {TRIANGLE} Shape \"sphere\" ObjectEnd\n");
    for x in 0..10 {
        text += &format!("AttributeBegin Identity Translate {x} 0 0 ObjectInstance \"o\" AttributeEnd\n");
    }
    let scene = scene(&text);
    assert_eq!((scene.meshes().len(), scene.instances().len()), (2, 20));
    assert!(close(scene.instances()[6].to_world.transform_point3(Vec3::X), [5.0, 0.0, 1.0]));
    assert!(scene.notes().first_departure().is_none());
    let light = "AreaLightSource \"diffuse\"";
    let text = format!(
        "{V4} ObjectBegin \"a\" {light} {TRIANGLE} ObjectEnd ObjectBegin \"b\" ObjectInstance \"a\" ObjectEnd\n\
         ObjectInstance \"a\" ObjectInstance \"c\""
    );
    let scene = self::scene(&text);
    assert_eq!((scene.instances().len(), scene.area_emitters().count()), (1, 0));
    for (kind, start) in [
        (NoteKind::Ignored, "area lights of shapes in objects"),
        (NoteKind::Ignored, "instances inside objects"),
        (NoteKind::Repaired, "object \"c\" is not defined"),
    ] {
        assert!(noted(&scene, kind, start), "{start}: {:?}", notes(&scene));
    }
}

/// Ray through a point of the film, given in fractions from the top left.
fn ray(scene: &Scene, x: f32, y: f32) -> (Vec3, Vec3) {
    let camera = &scene.cameras()[0];
    let size = camera.resolution.unwrap();
    let film = Vec2::new(x * size[0] as f32, y * size[1] as f32);
    let ray = camera.ray(&CameraSample { film, lens: [0.5; 2], time: 0.5 }, size).unwrap();
    (ray.origin, ray.direction)
}

#[test]
fn cameras_show_x_to_the_right_of_z_and_mirrors_as_the_file_asks() {
    let film = "Film \"rgb\" \"integer xresolution\" 400 \"integer yresolution\" 200";
    let head =
        |before: &str, camera: &str| scene(&format!("{film} {before} Camera {camera} WorldBegin {TRIANGLE}"));
    // Without a transform pbrt looks along +z with +x to the right, a left-handed frame.
    let plain = head("", "\"perspective\" \"float fov\" 90");
    assert!(close(ray(&plain, 0.5, 0.5).1, [0.0, 0.0, 1.0]));
    let (_, corner) = ray(&plain, 1.0, 0.0);
    assert!(close(corner / corner.z, [2.0, 1.0, 1.0]), "fov is that of the shorter side: {corner}");
    let look_at = head("LookAt 1 2 3  1 2 -7  0 1 0", "\"perspective\"");
    assert!(close(ray(&look_at, 0.5, 0.5).0, [1.0, 2.0, 3.0]));
    // Looking along −z, pbrt's right is cross(up, forward) = −x: its frame is left-handed.
    assert!(ray(&look_at, 1.0, 0.5).1.x < 0.0 && ray(&look_at, 0.5, 0.0).1.y > 0.0);
    let mirrored = head("Scale -1 1 1 LookAt 1 2 3  1 2 -7  0 1 0", "\"perspective\"");
    assert!(ray(&mirrored, 1.0, 0.5).1.x > 0.0 && ray(&mirrored, 0.5, 0.0).1.y > 0.0);
}

#[test]
fn the_cornell_box_of_pbrt_v4_has_its_red_wall_on_the_left() {
    // Transform and field of view of a real scene; its red wall is at x = −1.
    let head = "Transform [1 -0 -0 -0 -0 1 -0 -0 -0 -0 -1 -0 -0 -1 6.8 1] Film \"rgb\" \"integer xresolution\" 100 \
                \"integer yresolution\" 100 Camera \"perspective\" \"float fov\" 19.5 WorldBegin";
    let scene = scene(&format!("{head} {TRIANGLE}"));
    let (origin, left) = ray(&scene, 0.0, 0.5);
    assert!(close(origin, [0.0, 1.0, 6.8]) && left.x < 0.0 && left.z < 0.0);
    let at_wall = origin + left * (5.8 / -left.z);
    assert!((-1.1..-0.9).contains(&at_wall.x), "{at_wall}");
}

#[test]
fn cameras_and_films_follow_their_parameters() {
    let film = "Film \"rgb\" \"integer xresolution\" 400 \"integer yresolution\" 200";
    let camera =
        |parameters: &str| scene(&format!("{film} Camera {parameters} WorldBegin")).cameras()[0].clone();
    let fov = |c: &tashika::scene::Camera| match c.projection {
        Projection::Perspective { vertical_fov } => vertical_fov.to_degrees(),
        Projection::Orthographic { height } => -height,
        other => panic!("{other:?}"),
    };
    let c = camera("\"perspective\" \"float fov\" 60 \"float lensradius\" 0.1 \"float focaldistance\" 7");
    assert!((fov(&c) - 60.0).abs() < 1e-3);
    assert_eq!((c.lens.radius, c.lens.focus_distance, c.shift), (0.1, 7.0, Vec2::ZERO));
    // tan 45° · (1 − 0.5)/2 on each side of a centre at 0.75; atan 0.25 = 14.036°.
    let c = camera("\"perspective\" \"float fov\" 90 \"float screenwindow\" [-1 0 0.5 1]");
    assert!((fov(&c) - 2.0 * 14.036_243).abs() < 1e-3);
    assert_eq!(c.shift, Vec2::new(-0.5, 1.5));
    let c = camera("\"orthographic\" \"float screenwindow\" [-4 4 -2 2]");
    assert_eq!(fov(&c), -4.0);
    assert_eq!(fov(&camera("\"orthographic\"")), -2.0);
    for (fov, kept) in [(-10.0, 0.01), (200.0, 179.0)] {
        let scene = scene(&format!("{film} Camera \"perspective\" \"float fov\" {fov} WorldBegin"));
        assert!(noted(&scene, NoteKind::Repaired, "fields of view"));
        let Projection::Perspective { vertical_fov } = scene.cameras()[0].projection else { panic!() };
        assert!((vertical_fov.to_degrees() - kept).abs() < 1e-3);
    }
    let portrait = scene(
        "Film \"image\" \"integer xresolution\" 100 \"integer yresolution\" 200 Camera \"perspective\" WorldBegin WorldEnd",
    );
    assert!((fov(&portrait.cameras()[0]) - 2.0 * 63.434_95).abs() < 1e-3);
}

#[test]
fn films_are_cropped_by_fractions_and_by_pixels() {
    let crop = |parameters: &str| {
        let text = format!(
            "Film \"rgb\" \"integer xresolution\" 10 \"integer yresolution\" 20 {parameters} Camera \"perspective\" WorldBegin"
        );
        scene(&text).cameras()[0].crop
    };
    let some = |x, y, width, height| Some(Window { x, y, width, height });
    assert_eq!(crop("\"float cropwindow\" [0.25 0.5 0 0.5]"), some(3, 0, 2, 10), "rounded up");
    assert_eq!(crop("\"integer pixelbounds\" [2 5 1 20]"), some(2, 1, 3, 19));
    assert_eq!(crop("\"integer pixelbounds\" [-2 50 1 20]"), some(0, 1, 10, 19));
    assert_eq!(crop("\"float cropwindow\" [0 1 0 1]"), None);
    assert_eq!(crop("\"float cropwindow\" [0.5 0.5 0 1]"), None);
}

/// Returns true for each of `+z` and `−z` if the only emitter emits towards it.
fn emits(text: &str) -> [bool; 2] {
    let scene = scene(text);
    let (instance, _) = scene.area_emitters().next().unwrap();
    let point = scene.surface_point(instance, 0, [0.4, 0.3, 0.3]);
    [Vec3::Z, Vec3::NEG_Z].map(|direction| !scene.emitted(&point, direction).is_black())
}

#[test]
fn shapes_emit_on_the_side_that_pbrt_gives_them() {
    let light = "AreaLightSource \"diffuse\"";
    let up = [true, false];
    let down = [false, true];
    let n = "\"normal N\" [0 0 -1 0 0 -1 0 0 -1]";
    let with_normals = format!("{} {n}", TRIANGLE.trim_end());
    for head in [V3, V4] {
        let emits = |before: &str, shape: &str| emits(&format!("{head} {light} {before} {shape}"));
        assert_eq!(emits("", TRIANGLE), up);
        assert_eq!(emits("ReverseOrientation", TRIANGLE), down);
        assert_eq!(emits("ReverseOrientation ReverseOrientation", TRIANGLE), up);
        // In pbrt, a mirror reverses the order of the corners; the exclusive or with its handedness
        // undoes that.
        assert_eq!(emits("Scale -1 1 1", TRIANGLE), up);
        assert_eq!(emits("Scale -1 1 1 ReverseOrientation", TRIANGLE), down);
        assert_eq!(emits("Scale 1 1 -1", TRIANGLE), down);
        assert_eq!(emits("", &with_normals), down, "the side of the vertex normals");
        assert_eq!(emits("ReverseOrientation", &with_normals), if head == V3 { down } else { up });
        assert_eq!(emits("", "Shape \"disk\""), up);
        assert_eq!(emits("ReverseOrientation", "Shape \"disk\""), down);
        assert_eq!(emits("Scale -1 1 1", "Shape \"disk\""), up);
    }
    let both = format!("{V4} AreaLightSource \"diffuse\" \"bool twosided\" true {TRIANGLE}");
    assert_eq!(emits(&both), [true, true]);
}

#[test]
fn shapes_have_the_texture_coordinates_of_pbrt_with_v_down() {
    let wall =
        "Texture \"t\" \"spectrum\" \"checkerboard\" Material \"diffuse\" \"texture reflectance\" \"t\"";
    let uvs = |text: &str| scene(&format!("{V4} {wall} {text}")).meshes()[0].uvs().to_vec();
    let given = format!("{} \"point2 uv\" [0 0 0.5 0 0 0.25]", TRIANGLE.trim_end());
    assert_eq!(uvs(&given), [Vec2::new(0.0, 1.0), Vec2::new(0.5, 1.0), Vec2::new(0.0, 0.75)]);
    let defaults = [Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::new(1.0, 0.0)];
    assert_eq!(uvs(TRIANGLE), defaults);
    // Two triangles that share corners each get the default coordinates.
    let quad =
        "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0]";
    assert_eq!(uvs(quad), [defaults, defaults].concat());
    assert!(scene(&format!("{V4} {TRIANGLE}")).meshes()[0].uvs().is_empty(), "none without need");
}

#[test]
fn shapes_of_all_kinds_have_their_size() {
    for (shape, lo, hi) in [
        ("\"sphere\" \"float radius\" 2", [-2.0; 3], [2.0; 3]),
        ("\"sphere\" \"float radius\" 2 \"float zmin\" 0", [-2.0, -2.0, 0.0], [2.0; 3]),
        ("\"disk\" \"float height\" 3 \"float radius\" 2", [-2.0, -2.0, 3.0], [2.0, 2.0, 3.0]),
        ("\"cylinder\" \"float zmin\" 0 \"float zmax\" 4", [-1.0, -1.0, 0.0], [1.0, 1.0, 4.0]),
        ("\"cone\" \"float height\" 3 \"float radius\" 2", [-2.0, -2.0, 0.0], [2.0, 2.0, 3.0]),
        ("\"paraboloid\" \"float radius\" 2 \"float zmax\" 3", [-2.0, -2.0, 0.0], [2.0, 2.0, 3.0]),
        ("\"hyperboloid\" \"point3 p1\" [1 0 0] \"point3 p2\" [1 0 2]", [-1.0, -1.0, 0.0], [1.0, 1.0, 2.0]),
        ("\"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 2 0 1 2 3]", [0.0; 3], [1.0, 2.0, 3.0]),
        (
            "\"heightfield\" \"integer nu\" 2 \"integer nv\" 2 \"float Pz\" [0 1 2 3]",
            [0.0; 3],
            [1.0, 1.0, 3.0],
        ),
    ] {
        let scene = scene(&format!("{V4} Shape {shape}"));
        assert!(scene.notes().first_departure().is_none(), "{shape}: {:?}", notes(&scene));
        let (l, h) = (scene.bounds().lo - Vec3::from(lo), scene.bounds().hi - Vec3::from(hi));
        let error = l.abs().max(h.abs()).max_element();
        assert!(error < 0.02, "{shape}: {:?}", scene.bounds());
    }
    let subdivided = "Shape \"loopsubdiv\" \"integer levels\" 2 \"integer indices\" [0 2 1 0 1 3 1 2 3 2 0 3] \
        \"point3 P\" [0 0 0 1 0 0 0 1 0 0 0 1]";
    assert_eq!(scene(&format!("{V4} {subdivided}")).stored_triangles(), 4 * 16);
    let bent = scene(&format!("{V4} Shape \"sphere\" \"float radius\" -1 {TRIANGLE}"));
    assert!(bent.instances().len() == 1 && noted(&bent, NoteKind::Repaired, "quadrics whose parameters"));
}

#[test]
fn shapes_with_the_same_parameters_share_a_mesh() {
    let folder = Folder::new();
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    folder.write("m/a.ply", ply);
    let mesh = "Shape \"plymesh\" \"string filename\" \"m/a.ply\"";
    let (ball, small) = ("Shape \"sphere\"", "Shape \"sphere\" \"float radius\" 0.5");
    let text = format!(
        "{V4} {mesh} {ball} {mesh} {ball} {small} ReverseOrientation {mesh} Material \"diffuse\" {mesh}"
    );
    let scene = folder.load(&text).unwrap();
    assert_eq!((scene.meshes().len(), scene.instances().len()), (5, 7));
    let missing =
        folder.load(&format!("{V4} Shape \"plymesh\" \"string filename\" \"m/b.ply\" {TRIANGLE}")).unwrap();
    assert_eq!(missing.instances().len(), 1);
    assert!(noted(
        &missing,
        NoteKind::Missing,
        "mesh file \"m/b.ply\" could not be read (no such file): left out"
    ));
}

#[test]
fn shapes_have_alpha_as_each_format_means_it() {
    let alpha = |head: &str, value: &str| {
        let scene = scene(&format!(
            "{head} Texture \"a\" \"float\" \"checkerboard\" {} {value}",
            TRIANGLE.trim_end()
        ));
        scene.materials().first().map(|material| material.alpha.map(|a| a.mode))
    };
    assert_eq!(alpha(V4, "\"texture alpha\" \"a\""), Some(Some(AlphaMode::Blend)));
    assert!(
        matches!(alpha(V3, "\"texture alpha\" \"a\""), Some(Some(AlphaMode::Mask { cutoff })) if cutoff > 0.0)
    );
    assert_eq!(alpha(V4, "\"float alpha\" 0.5"), Some(Some(AlphaMode::Blend)));
    assert_eq!(alpha(V3, "\"float alpha\" 0.5"), Some(None), "pbrt-v3 asks only whether alpha is 0");
    assert_eq!((alpha(V3, "\"float alpha\" 0"), alpha(V4, "\"float alpha\" 0")), (None, None), "invisible");
    assert_eq!(alpha(V4, "\"float alpha\" 1"), Some(None));
}

#[test]
fn includes_are_found_from_the_main_folder_beside_and_compressed() {
    let folder = Folder::new();
    folder.write("a/b.pbrt", format!("Include \"a/c.pbrt\" Include \"d.pbrt\" {TRIANGLE}"));
    folder.write("a/c.pbrt", "Translate 1 0 0");
    folder.write("a/d.pbrt", "Translate 0 1 0");
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    gzip.write_all(b"Translate 0 0 1").unwrap();
    folder.write("e.pbrt.gz", gzip.finish().unwrap());
    let scene = folder.load(&format!("{V4} Include \"e.pbrt.gz\" Include \"a/b.pbrt\" {TRIANGLE}")).unwrap();
    for instance in scene.instances() {
        assert!(close(instance.to_world.translation.into(), [1.0, 1.0, 1.0]));
    }
    // After Import, transform and material are restored; its definitions remain.
    folder.write(
        "f.pbrt",
        "Translate 9 9 9 MakeNamedMaterial \"m\" \"string type\" \"diffuse\" AttributeBegin",
    );
    let scene = folder.load(&format!("{V4} Import \"f.pbrt\" NamedMaterial \"m\" {TRIANGLE}")).unwrap();
    assert_eq!(placed(&scene, [0.0; 3]), Vec3::ZERO);
    assert!(scene.notes().first_departure().is_none(), "{:?}", notes(&scene));
    let missing = folder.load(&format!("{V4}\n  Include \"none.pbrt\"")).unwrap_err();
    assert!(
        matches!(&missing, Error::Io { .. }) && missing.to_string().contains("scene.pbrt:3:3"),
        "{missing}"
    );
}

#[test]
fn what_is_not_used_is_told_and_defaults_of_attributes_are_taken() {
    let scene = scene(&format!(
        "{V4} Shape \"sphere\" \"float radius\" 1 \"float quux\" 2 \"integer zmin\" 1 Material \"diffuse\" \"rgb Kd\" [1 1 1]"
    ));
    let unused: Vec<String> = notes(&scene).into_iter().map(|(_, message)| message).collect();
    assert!(
        unused.iter().any(|m| m == "parameter \"float quux\" of shape \"sphere\" is not used"),
        "{unused:?}"
    );
    assert!(unused.iter().any(|m| m == "parameter \"integer zmin\" of shape \"sphere\" is not used"));
    assert!(unused.iter().any(|m| m == "parameter \"rgb Kd\" of material \"diffuse\" is not used"));
    let text = format!(
        "{V4} AttributeBegin Attribute \"shape\" \"float radius\" 3 Shape \"sphere\" AttributeEnd Shape \"sphere\""
    );
    let scene = self::scene(&text);
    let largest = |i: usize| scene.meshes()[i].bounds().hi.z;
    assert!((largest(0) - 3.0).abs() < 0.01 && (largest(1) - 1.0).abs() < 0.01);
    assert_eq!(notes(&scene), []);
}

#[test]
fn frames_of_the_scene_are_checked() {
    let scene = scene(&format!("{V3} {TRIANGLE} WorldEnd {TRIANGLE}"));
    assert!(scene.instances().len() == 1 && noted(&scene, NoteKind::Ignored, "what follows WorldEnd"));
    let open = self::scene(&format!("{V3} {TRIANGLE}"));
    assert!(open.instances().len() == 1 && noted(&open, NoteKind::Repaired, "no WorldEnd"));
    let early = self::scene(TRIANGLE);
    assert!(noted(&early, NoteKind::Repaired, "no WorldBegin") && early.instances().len() == 1);
    for (text, start) in [
        ("WorldBegin\n Sphere", "scene.pbrt:2:2: \"Sphere\"; expected a directive"),
        ("WorldBegin 1", "scene.pbrt:1:12: \"1\"; expected a directive"),
        ("\"Shape\"", "scene.pbrt:1:1: the string \"Shape\"; expected a directive"),
        ("Shape sphere", "scene.pbrt:1:7: \"sphere\"; expected the name of a type"),
        ("Translate 1 2", "scene.pbrt:1:14: the end of the file; expected 3 finite numbers"),
        ("Translate [1 2 3 4]", "scene.pbrt:1:18: \"4\"; expected \"]\" after 3 numbers"),
        ("ActiveTransform Never", "scene.pbrt:1:17: \"Never\"; expected StartTime, EndTime or All"),
        (
            "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0]\n \"integer indices\" [0 1 3]",
            "scene.pbrt:2:2: vertex index 3",
        ),
    ] {
        let error = refusal(text);
        assert!(error.starts_with(start), "{error}");
    }
}
