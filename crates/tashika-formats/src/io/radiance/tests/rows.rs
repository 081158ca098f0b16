//! Every row of the table of features, each in a file of its own.

use super::super::FEATURES;
use super::*;
use crate::io::{Feature, Support};

/// Text after the identifier of a material of this type.
fn arguments(name: &str) -> &'static str {
    match name {
        "plastic" | "metal" => "0 0 5 .5 .5 .5 .05 .1",
        "plastic2" | "metal2" => "4 0 0 1 a.cal 0 6 .5 .5 .5 .05 .1 .2",
        "trans" => "0 0 7 .5 .5 .5 .05 .1 .5 .5",
        "trans2" => "4 0 0 1 a.cal 0 8 .5 .5 .5 .05 .1 .2 .5 .5",
        "dielectric" => "0 0 5 .9 .9 .9 1.5 0",
        "interface" => "0 0 8 .9 .9 .9 1.5 1 1 1 1",
        "glass" => "0 0 3 .9 .9 .9",
        "mirror" | "light" | "illum" => "0 0 3 1 1 1",
        "glow" => "0 0 4 1 1 1 0",
        "spotlight" => "0 0 7 1 1 1 30 0 0 .001",
        _ => "0 0 0",
    }
}

/// A file with the feature of a row, and nothing else that deserves a note.
fn example(row: &Feature) -> String {
    let sphere = "m sphere s 0 0 4 0 0 0 1\n";
    let with = |kind: &str, arguments: &str| format!("void {kind} m {arguments}\n{sphere}");
    match (row.kind, row.name) {
        ("surface", "polygon") => format!("{GREY}grey polygon s 0 0 9 0 0 0 1 0 0 0 1 0"),
        ("surface", "sphere" | "bubble") => format!("{GREY}grey {} s 0 0 4 0 0 0 1", row.name),
        ("surface", "cylinder" | "tube") => format!("{GREY}grey {} s 0 0 7 0 0 0 0 0 1 1", row.name),
        ("surface", "cone" | "cup" | "ring") => format!("{GREY}grey {} s 0 0 8 0 0 0 0 0 1 1 .5", row.name),
        ("surface", "source") => "void light l 0 0 3 1 1 1\nl source s 0 0 4 0 0 1 1".to_owned(),
        ("surface", "surface of void") => "void sphere s 0 0 4 0 0 0 1".to_owned(),
        ("surface", "mesh" | "instance") => format!("void {} s 1 a 0 0", row.name),
        ("material", "dielectric dispersion") => with("dielectric", "0 0 5 1 1 1 1.5 2"),
        ("material", "mirror alternate") => with("mirror", "1 void 0 3 1 1 1"),
        ("material", "light alternate") => with("light", "1 void 0 3 1 1 1"),
        ("material", "glow maxrad below 0") => with("glow", "0 0 4 1 1 1 -1"),
        ("material", "spotlight focal length") => with("spotlight", "0 0 7 1 1 1 30 0 0 1"),
        ("material", "light of a luminaire") | ("modifier", "brightdata of ies2rad") => format!(
            "void brightdata d 4 corr a.dat source.cal src_theta 0 0\nd light m 0 0 3 1 1 1\n{sphere}"
        ),
        ("material", name) => with(name, arguments(name)),
        ("modifier", "brightfunc of gensky") => "void brightfunc d 2 skybr skybright.cal 0 3 2 1 1\n\
            d glow m 0 0 4 1 1 1 0\nm source s 0 0 4 0 0 1 180"
            .to_owned(),
        ("modifier", "brightfunc of gendaylit") => {
            "void brightfunc d 2 skybright perezlum.cal 0 10 1 1 -1 -.3 13 -3 .2 0 0 1\n\
            d glow m 0 0 4 1 1 1 0\nm source s 0 0 4 0 0 1 180"
                .to_owned()
        }
        ("modifier", name) => {
            format!("void {name} p 0 0 0\np plastic m 0 0 5 .5 .5 .5 0 0\n{sphere}")
        }
        ("command", "!xform") => "!xform -t 1 0 0 a.rad".to_owned(),
        ("command", "!cat") => "!cat a.rad | xform -t 1 0 0".to_owned(),
        ("command", "all other commands") => "!make".to_owned(),
        ("command", name) => name.to_owned(),
        (kind, name) => panic!("no example of {kind} {name}"),
    }
}

#[test]
fn every_row_gives_its_note_or_error_and_no_other() {
    let part = format!("{GREY}grey sphere s 0 0 4 0 0 0 1");
    for row in FEATURES {
        let files = [("scene.rad", &*example(row)), ("a.rad", &part), ("a.dat", "1 0 90 2 1 1")];
        let loaded = load(&files);
        let message = format!("{} {:?}: {}", row.kind, row.name, row.how);
        let kind = match row.support {
            Support::Full => None,
            Support::Approximated => Some(NoteKind::Approximated),
            Support::Ignored => Some(NoteKind::Ignored),
            Support::Refused => {
                let error = loaded.unwrap_err().to_string();
                assert!(error.contains("scene.rad:1: ") && error.ends_with(row.how), "{row:?}: {error}");
                continue;
            }
        };
        let mut found = notes(&loaded.unwrap_or_else(|error| panic!("{row:?}: {error}")));
        // Rows about a part of a material stand beside the row of the material.
        let other = ["spotlight", "light of a luminaire"];
        found.retain(|(_, note)| {
            let is_other = other.iter().any(|name| note.starts_with(&format!("material {name:?}")));
            *note == message || !is_other
        });
        let expected: Vec<_> = kind.map(|kind| (kind, message)).into_iter().collect();
        assert_eq!(found, expected, "{row:?}");
    }
}
