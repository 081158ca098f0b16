//! Every command of the book, run at small sizes.
//!
//! Each line of an `sh` block is a command. The commands of `tashika` in a chapter are run in
//! order, in one folder that contains the book's room and the scenes of its gallery. Sizes, numbers
//! of paths, errors and times are replaced to make the runs short; all other words are as printed.
//! Exit code 4, for a picture that runs out of budget, is accepted.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;

/// Options whose values are replaced, with the values that make a run short.
const SMALL: [(&str, &str); 5] =
    [("--size", "12x12"), ("--paths", "4"), ("--error", "20%"), ("--time", "2s"), ("--audit", "2")];

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/book/src")
}

/// Paths of the chapters, relative to the book's source folder.
fn chapters() -> Vec<PathBuf> {
    let summary = fs::read_to_string(source().join("SUMMARY.md")).unwrap();
    let links = summary.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    links.map(|(link, _)| PathBuf::from(link)).collect()
}

/// Commands of the blocks of `sh`, without comments.
fn commands(chapter: &str) -> Vec<String> {
    let blocks = chapter.split("\n```").collect::<Vec<_>>();
    let blocks = blocks.iter().filter_map(|block| block.strip_prefix("sh\n"));
    let lines = blocks.flat_map(str::lines).map(|line| line.split(" # ").next().unwrap_or(line).trim());
    lines.filter(|line| !line.is_empty()).map(str::to_owned).collect()
}

/// Options by which a render has an end of its own. Others are audited pictures until a time limit.
const ENDS: [&str; 8] =
    ["--error", "--time", "--passes", "--quality", "--claim", "--method", "--truth", "--tiles"];

/// Words of a command with small values of options; the first is the program. Pictures that only a
/// time limit would end have two passes.
fn small(command: &str) -> Vec<String> {
    let mut words: Vec<String> = command.split_whitespace().map(str::to_owned).collect();
    for at in 1..words.len() {
        if let Some((_, small)) = SMALL.iter().find(|(option, _)| words[at - 1] == *option) {
            words[at] = (*small).to_owned();
        }
    }
    let has_end = words.iter().any(|word| ENDS.contains(&word.as_str()));
    if words.get(1).is_some_and(|command| command == "render") && !has_end {
        words.extend(["--passes", "2"].map(str::to_owned));
    }
    words
}

#[test]
fn every_command_of_the_book_works() {
    let mut run = 0;
    for chapter in chapters() {
        let text = fs::read_to_string(source().join(&chapter)).unwrap();
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("gallery")).unwrap();
        for scene in ["room.gltf", "gallery/fog.pbrt", "gallery/fan.xml", "gallery/marbles.usda"] {
            fs::copy(source().join(scene), folder.path().join(scene)).unwrap();
        }
        for command in commands(&text) {
            let words = small(&command);
            assert_eq!(words[0], "tashika", "{}: {command}", chapter.display());
            let mut program = Command::new(env!("CARGO_BIN_EXE_tashika"));
            let output = program.args(&words[1..]).current_dir(folder.path()).output().unwrap();
            let code = output.status.code();
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(matches!(code, Some(0 | 4)), "{}: {command}: {code:?}\n{said}", chapter.display());
            run += 1;
        }
    }
    assert!(run > 30, "{run} commands");
}

#[test]
fn links_of_the_book_lead_somewhere() {
    for chapter in chapters() {
        let text = fs::read_to_string(source().join(&chapter)).unwrap();
        let folder = source().join(&chapter).parent().unwrap().to_owned();
        for rest in text.split("](").skip(1) {
            let link = rest.split(')').next().unwrap();
            let file = link.split('#').next().unwrap();
            let is_here = file.is_empty() || link.contains("://") || folder.join(file).is_file();
            assert!(is_here, "{}: {link}", chapter.display());
        }
    }
}

#[test]
fn commands_are_found_and_made_small() {
    let chapter =
        "text\n```sh\ntashika render a --size 640x360 --paths 1024 # why\n\n```\n```text\nnot this\n```\n";
    let found = commands(chapter);
    assert_eq!(found, ["tashika render a --size 640x360 --paths 1024"]);
    assert_eq!(small(&found[0]).join(" "), "tashika render a --size 12x12 --paths 4 --passes 2");
    assert_eq!(small("tashika render a --error 2%").join(" "), "tashika render a --error 20%");
}

/// Runs the commands of the chapter on farms. The merged shares have the same bits and the same
/// truth as an image that is rendered in one piece.
#[test]
fn shares_of_the_chapter_on_farms_are_joined_to_what_one_machine_renders() {
    let text = fs::read_to_string(source().join("farm.md")).unwrap();
    assert!(text.contains("The joined picture has the same bits as one that a single\nmachine makes"));
    let folder = tempfile::tempdir().unwrap();
    fs::copy(source().join("room.gltf"), folder.path().join("room.gltf")).unwrap();
    let mut said = String::new();
    for command in commands(&text).into_iter().take_while(|command| !command.contains("--checkpoint")) {
        let mut words = small(&command);
        // The image has at least two tiles, so that no share is empty.
        if let Some(at) = words.iter().position(|word| word == "--size") {
            words[at + 1] = "40x36".to_owned();
        }
        let mut program = Command::new(env!("CARGO_BIN_EXE_tashika"));
        let output = program.args(&words[1..]).current_dir(folder.path()).output().unwrap();
        assert!(matches!(output.status.code(), Some(0 | 4)), "{command}: {output:?}");
        if words[1] == "merge" {
            said = String::from_utf8(output.stdout).unwrap();
        }
    }
    let [whole, joined] = ["whole.exr", "joined.exr"].map(|name| {
        let film = tashika::io::read_exr(&folder.path().join(name)).unwrap();
        assert_eq!(film.metadata().text("truth"), Some("transport"), "{name}");
        film
    });
    assert!(whole.planes() == joined.planes(), "the bits differ");
    assert!(said.contains("truth") && said.contains("light transport"), "{said}");
}
