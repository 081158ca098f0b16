//! Damaged and hostile OBJ and MTL files. Loading gives a scene or an error, never panics, and
//! reads nothing from outside the scene's folder.

use std::fs;
use std::path::PathBuf;

use tashika::error::{Error, Result};
use tashika::io::{LoadOptions, load_scene};
use tashika::math::Vec2;
use tashika::rng::{Purpose, Stream};
use tashika::scene::{NoteKind, Scene, Surface};
use tempfile::TempDir;

use crate::cases::lenient;

const OBJ: &str = "# everything that is read\nmtllib scene.mtl other.mtl\no thing\nv 0 0 0\nv 1 0 0 1\n\
    v 1 1 0 1 0 0\nv 0 1 .5e-1\nv -1 \\\n 2 3\nvt 0 0\nvt 1 0 0\nvt 1\nvn 0 0 1\nvn 0 1 0\ng a b\nusemtl one\n\
    s 1\nf 1 2 3 4\nf -1/-1 1/1/1 2//2\ns off\nusemtl two words\nf 1/1/1 2/2/2 3/3/1 4/1/2 5/2/2\nl 1 2\nvp 1\n\
    usemtl glass\nf 1 2 3\n";

const MTL: &str = "newmtl one\nKa 1 1 1\nKd 0.5 .25 1\nKs 0.5\nNs 10\nKe 1 2 3\nd 0.5\nillum 2\n\
    map_Kd -s 1 2 -o .5 -clamp on a.png\nmap_d a.png\nbump -bm 1 a.png\n\nnewmtl two words\nPr 0.5\nPm 1\n\
    map_Pr -imfchan g a.png\nTr 0.5\n\nnewmtl glass\nTf 1 1 1\nNi 1.5\nillum 4\n";

fn png() -> Vec<u8> {
    let picture = image::RgbaImage::from_pixel(2, 2, image::Rgba([255, 128, 0, 128]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// A folder with a valid scene. Tests replace some of its files.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        fs::create_dir(folder.0.path().join("scene")).unwrap();
        folder.write("scene.obj", OBJ.as_bytes());
        folder.write("scene.mtl", MTL.as_bytes());
        folder.write("a.png", &png());
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join("scene").join(name)
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        // The old file is removed first: some file systems flush a file that is rewritten in place,
        // which is slow.
        let _ = fs::remove_file(self.path(name));
        fs::write(self.path(name), bytes).unwrap();
    }

    fn load_with(&self, options: &LoadOptions) -> Result<Scene> {
        let scene = load_scene(&self.path("scene.obj"), options);
        match &scene {
            Ok(scene) => check(scene),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
        scene
    }

    fn load(&self) -> Result<Scene> {
        self.load_with(&lenient())
    }
}

/// Asserts all invariants of a scene that a loader could break.
fn check(scene: &Scene) {
    for mesh in scene.meshes() {
        let n = mesh.positions().len();
        assert!(mesh.triangles().iter().flatten().all(|&i| (i as usize) < n));
        assert!(mesh.normals().is_empty() || mesh.normals().len() == n);
        assert!(mesh.uvs().is_empty() || mesh.uvs().len() == n);
        assert!(mesh.triangles().iter().flatten().all(|&i| mesh.positions()[i as usize].is_finite()));
    }
    for material in scene.materials() {
        let alpha = material.alpha.map_or(1.0, |a| a.at(scene.textures(), Vec2::new(0.3, -7.0)));
        assert!((0.0..=1.0).contains(&alpha), "{}: {alpha}", material.name);
        if let Some(e) = material.emission {
            assert!(e.radiance.at(scene.textures(), Vec2::new(0.3, -7.0)).is_valid());
        }
        assert_eq!(scene.part_of(material, Vec2::new(1e30, 0.2), 0.5, 0.5).bsdf.validate(), Ok(()));
    }
}

fn messages(scene: &Scene) -> Vec<String> {
    scene.notes().iter().map(|n| n.message).collect()
}

#[test]
fn the_sound_scene_loads() {
    let scene = Folder::new().load().unwrap();
    assert_eq!((scene.instanced_triangles(), scene.materials().len(), scene.images().len()), (7, 3, 2));
    assert_eq!(scene.area_emitters().count(), 1);
}

#[test]
fn files_cut_off_anywhere_are_scenes_or_errors() {
    let folder = Folder::new();
    for end in 0..OBJ.len() {
        folder.write("scene.obj", &OBJ.as_bytes()[..end]);
        let _ = folder.load();
    }
    folder.write("scene.obj", OBJ.as_bytes());
    for end in 0..MTL.len() {
        folder.write("scene.mtl", &MTL.as_bytes()[..end]);
        let _ = folder.load();
    }
    folder.write("scene.mtl", MTL.as_bytes());
    let image = png();
    for end in 0..image.len() {
        folder.write("a.png", &image[..end]);
        assert!(folder.load().is_ok(), "an image is never worth an error");
    }
}

/// `text` with one to four random changes of bytes, words or lines.
fn damaged(text: &[u8], stream: &mut Stream) -> Vec<u8> {
    const WORDS: [&[u8]; 24] = [
        b"nan",
        b"-inf",
        b"1e39",
        b"-1",
        b"0",
        b"99999999999999999999",
        b"-99999999999999999999",
        b"/",
        b"//",
        b"1/",
        b"\\\n",
        b"\n",
        b"\r",
        b" ",
        b"#",
        b"f",
        b"v",
        b"vn",
        b"s 3",
        b"usemtl two words",
        b"-s",
        b"..",
        b"\xff\xfe",
        b"\"",
    ];
    let mut bytes = text.to_vec();
    for _ in 0..1 + stream.below(4) {
        let at = stream.below(bytes.len() as u64 + 1) as usize;
        let end = (at + 1 + stream.below(12) as usize).min(bytes.len());
        match stream.below(6) {
            0 if at < bytes.len() => bytes[at] = stream.below(256) as u8,
            1 if at < bytes.len() => bytes[at] ^= 1 << stream.below(8),
            2 => drop(bytes.drain(at..end)),
            3 => drop(bytes.splice(at..at, bytes[at..end].to_vec())),
            _ => {
                let word = WORDS[stream.below(WORDS.len() as u64) as usize];
                let end = if stream.below(2) == 0 { at } else { end };
                drop(bytes.splice(at..end, word.iter().copied()));
            }
        }
    }
    bytes
}

#[test]
fn random_damage_gives_scenes_or_errors() {
    let folder = Folder::new();
    let mut stream = Stream::new(1, Purpose::Test, 0);
    let mut outcomes = [0; 2];
    for (name, text) in [("scene.obj", OBJ), ("scene.mtl", MTL)] {
        for _ in 0..4000 {
            folder.write(name, &damaged(text.as_bytes(), &mut stream));
            outcomes[usize::from(folder.load().is_ok())] += 1;
        }
        folder.write(name, text.as_bytes());
    }
    assert!(outcomes.iter().all(|&n| n > 400), "the damage is neither harmless nor fatal: {outcomes:?}");
}

#[test]
fn points_that_are_not_finite_and_faces_without_area_are_left_out() {
    let folder = Folder::new();
    let points =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nv 1e400 0 0\nv 1.#IND 0 0\nv 2 0 0\nvn 0 0 nan\nvt nan 1\n";
    let faces =
        "s 1\nf 1 2 3\nf 1 2 4\nf 1 2 3 5\nf 6 1 2\nf 1 2 7\nf 1 1 1\nf 1 1 2 2\nf 1/1/1 2/1/1 3/1/1\n";
    folder.write("scene.obj", format!("{points}{faces}").as_bytes());
    let scene = folder.load().unwrap();
    // These are the first face, the first half of the third, and the last.
    assert_eq!(scene.instanced_triangles(), 3);
    let mesh = &scene.meshes()[0];
    let used = mesh.triangles().iter().flatten().map(|&i| mesh.normals()[i as usize]);
    assert!(used.into_iter().all(|n| n.is_finite()), "one bad face does not spoil its neighbours' normals");
    assert!(messages(&scene).iter().any(|m| m.contains("not finite: left out")), "{:?}", messages(&scene));
    assert!(scene.triangles_without_area() > 0);
}

#[test]
fn a_face_that_is_not_finite_does_not_spoil_the_smooth_normals_beside_it() {
    let folder = Folder::new();
    folder.write("scene.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\ns 1\nf 1 2 3\nf 1 2 4\n");
    let scene = folder.load().unwrap();
    let mesh = &scene.meshes()[0];
    for &i in mesh.triangles().iter().flatten() {
        assert_eq!(mesh.normals()[i as usize], tashika::math::Vec3::Z);
    }
}

#[test]
fn absurd_numbers_are_limited_and_noted() {
    let folder = Folder::new();
    for (mtl, part) in [
        ("Ks 1\nNs -3", "Ns outside 0 to 1000000"),
        ("Ks 1\nNs 1e30", "Ns outside 0 to 1000000"),
        ("Ks 1\nNs nan", "Ns outside 0 to 1000000"),
        ("Ns 1\nKd -1 0 2", "Kd with channels outside 0 to 1"),
        ("Kd nan inf -inf", "Kd with channels outside 0 to 1"),
        ("Kd -1\nmap_Kd a.png", "Kd with channels below 0 or not finite"),
        ("Ks inf", "Ks with channels outside 0 to 1"),
        ("Ke inf -1 nan", "Ke with channels outside 0 to 1000000000000"),
        ("Ke 1e38", "Ke with channels outside 0 to 1000000000000"),
        ("d 7", "d outside 0 to 1"),
        ("d nan", "d outside 0 to 1"),
        ("Tr -1e30", "Tr outside 0 to 1"),
        ("illum 7\nd 0.5\nNi 1e30", "Ni outside"),
        ("illum 7\nd 0.5\nNi nan", "Ni outside"),
        ("illum 7\nd -1\nTf -1 2 nan", "Tf with channels outside 0 to 1"),
        ("Pr -1", "Pr outside 0 to 1"),
        ("Pm nan\nNi nan", "Pm outside 0 to 1"),
        ("Kd 0.5\nillum -3", ""),
        ("Kd 0.5\nillum nan", ""),
        ("Kd 0.5\nillum 1e30", ""),
        ("map_Kd -s nan 0 -o inf a.png", ""),
    ] {
        folder.write("scene.mtl", format!("newmtl one\n{mtl}\nnewmtl two words\nKd 1").as_bytes());
        let scene = folder.load().unwrap();
        assert!(messages(&scene).iter().any(|m| m.contains(part)), "{mtl}: {:?}", messages(&scene));
    }
}

#[test]
fn numbers_that_are_none_are_errors_with_line_and_material() {
    let folder = Folder::new();
    for (statement, expected) in [
        ("Ns ten", "scene.mtl:2: newmtl one: Ns ten; expected a number"),
        ("Ns", "scene.mtl:2: newmtl one: Ns; expected a number"),
        ("illum x", "scene.mtl:2: newmtl one: illum x; expected a number"),
        ("Kd 0,5 0 0", "scene.mtl:2: newmtl one: Kd 0,5 0 0; expected one number, or three"),
        ("Kd 1 1", "scene.mtl:2: newmtl one: Kd 1 1; expected one number, or three"),
        ("Ke", "scene.mtl:2: newmtl one: Ke; expected one number, or three"),
        ("Kd 1 1 \0", "scene.mtl:2: a NUL byte"),
    ] {
        folder.write("scene.mtl", format!("newmtl one\n{statement}\n").as_bytes());
        let error = folder.load().unwrap_err();
        assert!(matches!(error, Error::Invalid { .. }) && error.to_string().contains(expected), "{error}");
    }
}

#[test]
fn missing_and_unreadable_files_leave_a_scene_and_a_note() {
    let grey = |scene: &Scene| match scene.materials()[0].surface {
        Surface::Lambert { reflectance } => reflectance.texture.is_none() && reflectance.factor.r == 0.5,
        _ => false,
    };
    let folder = Folder::new();
    for (name, image) in
        [("none.png", None), ("b.png", Some(&b"no image"[..])), ("c.png", Some(b"")), (".", None)]
    {
        image.inspect(|bytes| folder.write(name, bytes));
        folder.write(
            "scene.mtl",
            format!("newmtl one\nmap_Kd {name}\nmap_d {name}\nmap_Ke {name}\n").as_bytes(),
        );
        let scene = folder.load().unwrap();
        assert!(
            grey(&scene) && scene.materials()[0].alpha.is_none() && scene.materials()[0].emission.is_none()
        );
        let notes: Vec<_> =
            scene.notes().iter().filter(|n| n.message.contains("could not be read")).collect();
        let kind = if name == "none.png" { NoteKind::Missing } else { NoteKind::Repaired };
        assert!(notes.iter().any(|n| n.kind == kind && n.message.contains(&format!("image {name:?}"))));
        assert_eq!(notes.iter().map(|n| n.count).sum::<u64>(), 4, "three images and other.mtl: {notes:?}");
    }
    fs::remove_file(folder.path("scene.mtl")).unwrap();
    let scene = folder.load().unwrap();
    assert!(grey(&scene));
    assert!(messages(&scene).iter().any(|m| m.contains("material library \"scene.mtl\" could not be read")));
    assert!(messages(&scene).iter().any(|m| m.contains("\"one\" is not defined")));
}

#[test]
fn nothing_is_read_from_outside_the_folder_unless_permitted() {
    let folder = Folder::new();
    let outside = folder.0.path();
    fs::write(outside.join("secret.mtl"), "newmtl one\nKd 0.125\nmap_Ke ../secret.png").unwrap();
    fs::write(outside.join("secret.png"), png()).unwrap();
    let secret = outside.join("secret").to_str().unwrap().to_owned();
    let kd = |scene: &Scene| match scene.materials()[0].surface {
        Surface::Lambert { reflectance } => reflectance.factor.r,
        ref other => panic!("{other:?}"),
    };
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl one\nf 1 2 3";
    for library in ["../secret.mtl", "..\\secret.mtl", "./x/../../secret.mtl", &format!("{secret}.mtl")] {
        folder.write("scene.obj", format!("mtllib {library}\n{triangle}").as_bytes());
        let scene = folder.load().unwrap();
        assert!(
            kd(&scene) == 0.5 && messages(&scene).iter().any(|m| m.contains("allow-outside")),
            "{library}"
        );
    }
    folder.write("scene.obj", format!("mtllib scene.mtl\n{triangle}").as_bytes());
    for image in ["../secret.png", &format!("{secret}.png")] {
        folder.write("scene.mtl", format!("newmtl one\nmap_Ke {image}").as_bytes());
        let scene = folder.load().unwrap();
        assert!(scene.images().is_empty() && messages(&scene).iter().any(|m| m.contains("allow-outside")));
    }
    folder.write("scene.obj", format!("mtllib ../secret.mtl\n{triangle}").as_bytes());
    let scene = folder.load_with(&LoadOptions { allow_outside: true, ..LoadOptions::default() }).unwrap();
    assert!(kd(&scene) == 0.125 && scene.images().len() == 1);
}

#[test]
fn libraries_that_are_no_libraries_do_not_go_round_in_circles() {
    let folder = Folder::new();
    folder.write("scene.obj", format!("mtllib scene.obj\nmtllib ../scene/scene.obj\n{OBJ}").as_bytes());
    let scene = folder.load().unwrap();
    assert_eq!(scene.instanced_triangles(), 7);
    assert!(messages(&scene).iter().any(|m| m.contains("before the first newmtl")));
    folder.write("scene.obj", format!("mtllib a.png\n{OBJ}").as_bytes());
    let error = folder.load().unwrap_err().to_string();
    assert!(error.contains("a.png:") && error.contains("a NUL byte"), "{error}");
    folder.write("scene.obj", format!("mtllib .\n{OBJ}").as_bytes());
    assert!(folder.load().is_ok());
}

#[test]
fn floods_of_statements_stay_small() {
    let folder = Folder::new();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let libraries: String = (0..1500).map(|i| format!("mtllib {i}.mtl\nmtllib 0.mtl\n")).collect();
    let list: String = (0..2000).map(|i| format!(" {i}.mtl")).collect();
    let uses: String = (0..3000).map(|i| format!("usemtl {i}\nf 1 2 3\nq{i}\n")).collect();
    let definitions: String =
        (0..3000).map(|i| format!("newmtl {i}\nmap_Kd ../{i}.png\nmap_Ks x{i}\n")).collect();
    folder.write("scene.mtl", definitions.as_bytes());
    folder.write(
        "scene.obj",
        format!("mtllib scene.mtl\n{triangle}{libraries}mtllib{list}\n{uses}").as_bytes(),
    );
    let scene = folder.load().unwrap();
    assert_eq!(scene.materials().len(), 3000);
    assert!(scene.notes().iter().count() < 300);
    let count =
        |part: &str| scene.notes().iter().filter(|n| n.message.contains(part)).map(|n| n.count).sum::<u64>();
    assert_eq!(count("after the thousandth"), 1 + 1500 - 1000 + 1);
    assert_eq!(count("could not be read") - 999, 6000, "two images a material and 999 libraries");
    assert_eq!(count("further statements"), 2980);

    let line = "1 ".repeat(300_000);
    let continued = "\\\n".repeat(100_000);
    folder.write("scene.obj", format!("{triangle}f {line}\nf {continued}\ng {line}\n# {line}").as_bytes());
    assert_eq!(folder.load().unwrap().instanced_triangles(), 0);
}

#[test]
fn bytes_that_are_not_text_are_refused() {
    let folder = Folder::new();
    let mut stream = Stream::new(3, Purpose::Test, 0);
    let noise: Vec<u8> = (0..5000).map(|_| stream.below(256) as u8).collect();
    for bytes in [noise, png(), b"v 3E4570711268 \0 ".to_vec(), [0xff, 0xfe, 0, 0].to_vec()] {
        folder.write("scene.obj", &bytes);
        let error = folder.load().unwrap_err().to_string();
        assert!(error.contains("this is not a text file"), "{error}");
    }
}
