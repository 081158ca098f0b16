//! Damaged and hostile pbrt files. Loading gives a scene or an error with its line. It never
//! panics, and takes no more memory or time than the size of the files justifies.

use std::fmt::Write as _;

use tashika::error::{Error, Result};
use tashika::io::{LoadOptions, load_scene};
use tashika::rng::{Purpose, Stream};
use tashika::scene::{NoteKind, Scene};

use super::pbrt::{Folder, TRIANGLE, V3, V4, noted, notes, refusal, scene};

/// A scene of each version of the format, with features of every kind.
const RICH_V3: &str = "LookAt 0 0 5 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" [40]\n\
    Film \"image\" \"integer xresolution\" 8 \"float cropwindow\" [0 1 0 .5]\nWorldBegin # comment\n\
    LightSource \"infinite\" \"color L\" [.1 .2 .3]\nTexture \"a\" \"float\" \"constant\" \"float value\" 0.5\n\
    Texture \"c\" \"color\" \"checkerboard\" \"rgb tex1\" [1 0 0] \"float uscale\" 2\n\
    MakeNamedMaterial \"m\" \"string type\" \"uber\" \"texture Kd\" \"c\" \"rgb Kt\" [.1 .1 .1]\n\
    Material \"mix\" \"string namedmaterial1\" \"m\" \"string namedmaterial2\" \"m\"\nAttributeBegin\n\
    AreaLightSource \"diffuse\" \"blackbody L\" [3000 2]\nTranslate 0 0 1 Rotate 30 1 0 0 Scale 1 2 1\n\
    Shape \"sphere\" \"float radius\" [.5] \"texture alpha\" \"a\"\nAttributeEnd\nObjectBegin \"o\"\n\
    Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [0 0 0 1 0 0 0 1 0] \"normal N\" [0 0 1 0 0 1 0 0 1]\n\
    ObjectEnd\nObjectInstance \"o\"\nMakeNamedMedium \"f\" \"string type\" \"homogeneous\" \"float g\" .2\n\
    MediumInterface \"f\" \"\" Material \"none\" Shape \"disk\"\nWorldEnd\n";
const RICH_V4: &str = "Option \"bool disablepixeljitter\" false ColorSpace \"srgb\" Film \"rgb\" \"integer pixelbounds\" [0 4 0 4]\n\
    Camera \"orthographic\" \"float screenwindow\" [-1 1 -1 1]\nWorldBegin\nAttribute \"shape\" \"float alpha\" 1\n\
    LightSource \"spot\" \"float power\" 10 \"spectrum I\" [400 1 700 2]\nMaterial \"conductor\" \"spectrum eta\" \"metal-Al-eta\"\n\
    Shape \"loopsubdiv\" \"integer levels\" 1 \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0]\n\
    Material \"coateddiffuse\" \"texture roughness\" \"t\" AreaLightSource \"diffuse\" \"float power\" 5\n\
    Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 1]\nShape \"disk\" ReverseOrientation\n";

/// Random numbers by which files are damaged.
struct Numbers(Stream);

impl Numbers {
    fn new(seed: u64) -> Self {
        Self(Stream::new(seed, Purpose::Test, 0))
    }

    /// Returns a number from 0 to `n` − 1.
    fn below(&mut self, n: usize) -> usize {
        self.0.below(n as u64) as usize
    }
}

/// Loads a scene. Asserts that a scene is sound, and that an error names a line or an item.
fn load(folder: &Folder, bytes: &[u8]) -> Result<Scene> {
    folder.write("scene.pbrt", bytes);
    let loaded = load_scene(&folder.0.path().join("scene.pbrt"), &LoadOptions::default());
    match &loaded {
        Ok(scene) => {
            assert!(!scene.cameras().is_empty() && scene.bounds().size().is_finite());
            assert!(scene.instances().iter().all(|instance| instance.to_world.is_finite()));
        }
        // A fault of the scene as a whole and a file that cannot be decompressed have no line.
        Err(error @ Error::Invalid { at, .. }) => {
            let whole = error.to_string().contains("bounds") || bytes.starts_with(b"\x1f\x8b");
            assert!(at.line.is_some() || at.item.is_some() || whole, "{error}");
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    loaded
}

#[test]
fn a_text_that_ends_anywhere_is_a_scene_or_an_error() {
    let folder = Folder::new();
    for rich in [RICH_V3, RICH_V4] {
        let whole = load(&folder, rich.as_bytes()).unwrap();
        assert!(whole.instances().len() >= 2, "{:?}", notes(&whole));
        let errors = (0..rich.len()).filter(|&end| load(&folder, &rich.as_bytes()[..end]).is_err()).count();
        assert!((rich.len() / 4..rich.len()).contains(&errors), "{errors} of {}", rich.len());
    }
}

#[test]
fn mutated_bytes_do_not_panic() {
    let folder = Folder::new();
    let mut numbers = Numbers::new(1);
    let mut errors = 0;
    for round in 0..3000 {
        let mut mutated = [RICH_V3, RICH_V4][round % 2].as_bytes().to_vec();
        for _ in 0..=numbers.below(4) {
            let place = numbers.below(mutated.len());
            mutated[place] = match numbers.below(3) {
                0 => mutated[place] ^ (1 << numbers.below(8)),
                1 => numbers.below(256) as u8,
                _ => b"0123456789-+.eE[]\"# \n\\"[numbers.below(22)],
            };
        }
        errors += usize::from(load(&folder, &mutated).is_err());
    }
    assert!((300..2990).contains(&errors), "{errors}: the mutations are neither harmless nor all fatal");
}

#[test]
fn mutated_words_do_not_panic() {
    let folder = Folder::new();
    let mut numbers = Numbers::new(2);
    let hostile = [
        "0",
        "-1",
        "1e38",
        "-1e38",
        "1e-45",
        "2147483647",
        "-2147483648",
        "1e99",
        "nan",
        "[",
        "]",
        "\"\"",
        "\"float x\"",
        "\"m\"",
        "AttributeBegin",
        "AttributeEnd",
        "ObjectBegin",
        "ObjectEnd",
        "WorldBegin",
        "WorldEnd",
        "Identity",
        "true",
        "\"texture L\"",
        "ReverseOrientation",
        "\"mix\"",
        "\"sphere\"",
        "Shape",
        "Material",
        "\"rgb L\"",
        "[ ]",
        "Scale",
        "\"blackbody L\"",
    ];
    let mut errors = 0;
    for round in 0..3000 {
        let mut words: Vec<&str> = [RICH_V3, RICH_V4][round % 2].split_inclusive([' ', '\n']).collect();
        for _ in 0..=numbers.below(3) {
            let place = numbers.below(words.len());
            match numbers.below(8) {
                0 => drop(words.remove(place)),
                1 => words.insert(place, words[numbers.below(words.len())]),
                _ => words[place] = hostile[numbers.below(hostile.len())],
            }
        }
        errors += usize::from(load(&folder, words.join(" ").as_bytes()).is_err());
    }
    assert!((300..2900).contains(&errors), "{errors}");
}

#[test]
fn every_number_may_be_absurd() {
    let folder = Folder::new();
    for rich in [RICH_V3, RICH_V4] {
        let bytes = rich.as_bytes();
        let is_number = |i: usize| {
            bytes[i].is_ascii_digit() && matches!(bytes[i - 1], b' ' | b'[') && !rich[i..].starts_with("3 ")
        };
        let places: Vec<usize> = (1..bytes.len()).filter(|&i| is_number(i)).collect();
        assert!(places.len() > 25, "{}", places.len());
        for place in places {
            let length = bytes[place..].iter().position(|b| matches!(b, b' ' | b']' | b'\n')).unwrap();
            for absurd in ["0", "-7", "1e30", "-3e38", "1e-40", "99999999"] {
                let text = format!("{}{absurd}{}", &rich[..place], &rich[place + length..]);
                let _ = load(&folder, text.as_bytes());
            }
        }
    }
}

#[test]
fn includes_that_never_end_are_refused() {
    let folder = Folder::new();
    for text in ["Include \"scene.pbrt\"", "Import \"scene.pbrt\"", "AttributeBegin Include \"a.pbrt\""] {
        folder.write("a.pbrt", "Include \"scene.pbrt\"");
        let error = load(&folder, text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains("32 deep"), "{error}");
    }
    // Each file includes the next one ten times.
    for depth in 0..30 {
        folder.write(&format!("{depth}.pbrt"), format!("Include \"{}.pbrt\"\n", depth + 1).repeat(10));
    }
    folder.write("30.pbrt", "Identity");
    let error = load(&folder, b"Include \"0.pbrt\"").unwrap_err().to_string();
    assert!(error.contains("at most 10000 included files"), "{error}");
}

#[test]
fn includes_stay_in_the_folder_of_the_scene() {
    let folder = Folder::new();
    for outside in ["../x.pbrt", "/etc/passwd", "a/../../x.pbrt"] {
        let error = load(&folder, format!("\nInclude \"{outside}\"").as_bytes()).unwrap_err();
        assert!(matches!(&error, Error::Outside { at, .. } if at.line == Some(2)), "{error}");
    }
    let error = load(&folder, b"\nInclude \"\"").unwrap_err();
    assert!(matches!(&error, Error::Invalid { at, .. } if at.line == Some(2)), "{error}");
    let mesh =
        folder.load(&format!("{V4} Shape \"plymesh\" \"string filename\" \"../a.ply\" {TRIANGLE}")).unwrap();
    assert!(
        mesh.instances().len() == 1
            && noted(&mesh, NoteKind::Missing, "mesh file \"../a.ply\" could not be read (outside")
    );
}

#[test]
fn attributes_and_textures_without_end_are_refused() {
    let error = refusal(&format!("{V4} {}", "AttributeBegin ".repeat(10_001)));
    assert!(error.contains("10001 attributes that are not ended"), "{error}");
    let mut text = format!("{V4} Texture \"0\" \"spectrum\" \"checkerboard\"\n");
    for i in 0..200 {
        let (this, next) = (i, i + 1);
        writeln!(text, "Texture \"{next}\" \"spectrum\" \"scale\" \"texture tex1\" \"{this}\" \"texture tex2\" \"{this}\"").unwrap();
    }
    let error = refusal(&text);
    assert!(error.contains("a texture made of"), "{error}");
}

#[test]
fn a_product_of_objects_and_instances_does_not_fill_the_memory() {
    let mut text = format!("{V4} ObjectBegin \"o\"\n");
    text += &TRIANGLE.repeat(4200);
    text += "ObjectEnd\n";
    text += &"ObjectInstance \"o\"\n".repeat(1000);
    let error = refusal(&text);
    assert!(error.contains("placements of shapes; expected at most 4194304"), "{error}");
}

#[test]
fn counts_that_contradict_each_other_are_told() {
    let mesh = |text: &str| format!("{V4} Shape \"trianglemesh\" {text}");
    let points = "\"point3 P\" [0 0 0 1 0 0 0 1 0]";
    for (text, found) in [
        (mesh(&format!("{points} \"integer indices\" [0 1]")), "2 indices; expected a multiple of 3"),
        (mesh(&format!("{points} \"integer indices\" [0 1 -1]")), "vertex index -1"),
        (mesh("\"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]"), "a mesh of 4 points without \"indices\""),
        (mesh("\"point3 P\" [0 0 0 1]"), "4 numbers for parameter \"point3 P\""),
        (
            format!(
                "{V3} Shape \"heightfield\" \"integer nu\" 100000 \"integer nv\" 100000 \"float Pz\" [1 2]"
            ),
            "a heightfield of",
        ),
        (
            format!("{V3} Shape \"heightfield\" \"integer nu\" -2 \"integer nv\" -2 \"float Pz\" [1 2 3 4]"),
            "a heightfield of",
        ),
        (format!("{V3} Shape \"plymesh\""), "a plymesh without filename"),
    ] {
        let error = refusal(&text);
        assert!(error.contains(found), "{error}");
    }
    let text =
        mesh(&format!("{points} \"integer indices\" [0 1 2] \"normal N\" [0 0 1] \"point2 uv\" [0 0]"));
    let scene = scene(&text);
    assert!(scene.meshes()[0].normals().is_empty() && scene.meshes()[0].uvs().is_empty());
    assert_eq!(notes(&scene).len(), 2, "{:?}", notes(&scene));
    let deep =
        format!("{V4} Shape \"loopsubdiv\" \"integer levels\" 30 \"integer indices\" [0 1 2] {points}");
    let scene = self::scene(&deep);
    assert!(
        scene.stored_triangles() <= 1 << 20 && noted(&scene, NoteKind::Approximated, "subdivision into more")
    );
}

#[test]
fn texts_that_are_no_scene_are_refused() {
    let folder = Folder::new();
    for text in [
        &b"\x7fELF\x02\x01"[..],
        b"{\"asset\": 1}",
        b"<scene/>",
        b"\xff\xfeF\0i\0",
        b"\x1f\x8b\x08garbage",
        b"]",
    ] {
        assert!(load(&folder, text).is_err(), "{text:?}");
    }
    for empty in [&b""[..], b"# nothing\n", b"\xef\xbb\xbf"] {
        assert!(noted(&load(&folder, empty).unwrap(), NoteKind::Repaired, "no WorldBegin"));
    }
    let many: String = (0..300).map(|i| format!("Shape \"s{i}\" \"float p{i}\" 1\n")).collect();
    let scene = scene(&format!("{V4} {many}"));
    assert!(
        notes(&scene).len() <= 110,
        "names that mean nothing are counted beyond a hundred: {}",
        notes(&scene).len()
    );
}
