//! Every row of the OBJ loader's table, each in separate files.

use tashika::io::{Feature, Support, features};
use tashika::scene::{NormalInput, NoteKind, Pixels, Scene};

use super::obj::{load_material, load_obj, png};
use super::textures;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";

fn rows() -> &'static [Feature] {
    features().into_iter().find(|f| f.format == "OBJ").expect("a table of OBJ").rows
}

/// A scene with the feature of a row, and nothing else that deserves a note.
fn example(kind: &str, name: &str) -> Scene {
    let picture = png(1, &[[128, 128, 255, 255]]);
    let first = name.split([' ', ',']).next().unwrap();
    let wide = textures::wide();
    let images: &[(&str, &[u8])] =
        &[("a.png", &picture), ("wide.png", &wide), ("a.tx", textures::TX), ("u.1001.png", &picture)];
    let material = |text: &str| load_material(text, images);
    match kind {
        "statement" => {
            let statement = match (name, first) {
                ("v x y z r g b", _) => "v 0 0 0 1 0 0",
                (_, "v") => "v 0 0 0",
                (_, "vt") => "vt 0.5 0.5",
                (_, "vn") => "vn 0 0 1",
                (_, "f") => "fo 1 2 3",
                (_, "s") => "s 1",
                (_, "usemtl" | "mtllib") => "",
                (_, "o") => "o part\ng one two\nmg 1 0.5",
                (_, "p") => "p 1",
                (_, "l") => "l 1 2",
                (_, "vp") => "cstype bezier",
                (_, "lod") => "lod 3",
                (_, "maplib") => "usemap a",
                (_, "call") => "call b.obj",
                _ => panic!("no example of {name}"),
            };
            // The scene of a material already has usemtl and mtllib.
            if statement.is_empty() {
                material("Kd 1")
            } else {
                load_obj(&format!("{TRIANGLE}{statement}\n"))
            }
        }
        "material statement" => material(match (name, first) {
            ("Kd spectral, Kd xyz", _) => "Kd xyz 0.1 0.2 0.3",
            ("map_Kd -o -s -clamp -imfchan", _) => "Kd 1\nmap_Kd -o 0.5 -s 2 -clamp on -imfchan r a.png",
            ("map_Kd of 16 bits", _) => "Kd 1\nmap_Kd wide.png",
            ("map_Kd <UDIM>", _) => "Kd 1\nmap_Kd u.<UDIM>.png",
            ("map_Kd .tx", _) => "Kd 1\nmap_Kd a.tx",
            (_, "newmtl" | "Kd") => "Kd 1\nmap_Kd a.png",
            (_, "Ks" | "Ns") => "Kd 0.1\nKs 0.5\nNs 10\nmap_Ks a.png",
            (_, "Ke") => "Kd 1\nKe 1\nmap_Ke a.png",
            (_, "Ka") => "Kd 1\nKa 1\nmap_Ka a.png",
            (_, "d") => "Kd 1\nd 0.5\nmap_d a.png",
            (_, "Tr") => "Kd 1\nTr 0.5",
            (_, "Tf" | "Ni" | "illum") => "Kd 1\nTf 1 1 1\nNi 1.5\nillum 2",
            (_, "Pr" | "Pm") => "Kd 1\nPr 0.5\nPm 0.5\nmap_Pr a.png\nmap_Pm a.png",
            (_, "norm") => "Kd 1\nnorm a.png",
            (_, "-mm") => "Kd 1\nmap_Kd -mm 0 2 a.png",
            (_, "bump") => "Kd 1\nmap_bump a.png",
            (_, "refl") => "Kd 1\nrefl a.png",
            (_, "decal") => "Kd 1\ndecal a.png",
            (_, "map_Ns") => "Kd 1\nmap_Ns a.png",
            (_, "Ps") => "Kd 1\nPc 0.5",
            _ => panic!("no example of {name}"),
        }),
        "material" => material(match name {
            "illum 3, 5" => "Kd 0\nKs 1\nillum 5",
            "illum 4, 6, 7, 9" => "Kd 1\nd 0.5\nillum 4",
            "illum 0, 1 with Ks" => "Kd 1\nKs 1\nillum 1",
            "map_Kd with black Kd" => "Kd 0\nmap_Kd a.png",
            "d 0" => "Kd 1\nd 0",
            _ => panic!("no example of {name}"),
        }),
        _ => panic!("no example of {kind}"),
    }
}

#[test]
fn every_row_gives_its_note_and_no_other() {
    for row in rows() {
        let scene = example(row.kind, row.name);
        let said: Vec<(NoteKind, String)> = scene
            .notes()
            .iter()
            .filter(|n| n.kind != NoteKind::Defaulted)
            .map(|n| (n.kind, n.message))
            .collect();
        let message = format!("{} {:?}: {}", row.kind, row.name, row.how);
        let expected = match row.support {
            Support::Full => vec![],
            Support::Approximated => vec![(NoteKind::Approximated, message)],
            Support::Ignored => vec![(NoteKind::Ignored, message)],
            Support::Refused => panic!("{row:?}"),
        };
        assert_eq!(said, expected, "{row:?}");
    }
}

#[test]
fn normal_maps_are_numbers() {
    let scene = example("material statement", "norm");
    let Some(NormalInput::Map { scale, .. }) = scene.materials()[0].normal else { panic!() };
    assert_eq!(scale, 1.0);
    assert!(matches!(scene.images()[0].pixels, Pixels::Linear8(_)));
}
