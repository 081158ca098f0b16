//! Untrusted names from files in the output of the program.

use std::fs;

use assert_cmd::Command;
use tempfile::TempDir;

/// Exit code, standard output and standard error of the program in a folder.
fn run(folder: &TempDir, line: &str) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tashika"));
    let output = command.current_dir(folder.path()).args(line.split_whitespace()).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// A name contains control characters that would colour the text after it and reverse the direction
/// of writing. It is used for an existing file, a missing file, a camera, and an unknown item in a
/// file. The program prints it escaped.
#[test]
fn names_of_others_do_not_steer_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let name = "a\u{1b}[31m\u{202e}\u{9b}2J";
    let scene = format!(
        "<scene version=\"3.0.0\"><sensor type=\"perspective\" id=\"{0}\"/><shape type=\"{0}\"/><shape type=\"cube\"/></scene>",
        name.replace('\u{1b}', "")
    );
    fs::write(folder.path().join(format!("{name}.xml")), scene).unwrap();
    let (code, summary, told) = run(&folder, &format!("info {name}.xml"));
    assert_eq!(code, Some(0), "{told}");
    assert!(summary.contains(r"\u{202e}\u{9b}2J"), "{summary}");
    let (code, nothing, error) = run(&folder, &format!("info {name}.obj"));
    assert_eq!(code, Some(3));
    assert!(error.contains(r"a\u{1b}[31m\u{202e}\u{9b}2J.obj"), "{error}");
    for text in [summary, told, nothing, error] {
        assert!(!text.contains(['\u{1b}', '\u{9b}', '\u{202e}']), "{text:?}");
    }
}

#[test]
fn a_film_that_is_too_large_is_the_files_unless_its_size_was_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let film = "<film type=\"hdrfilm\"><integer name=\"width\" value=\"65536\"/><integer name=\"height\" value=\"65536\"/></film>";
    let scene = format!(
        "<scene version=\"3.0.0\"><sensor type=\"perspective\" id=\"view\">{film}</sensor><shape type=\"cube\"/></scene>"
    );
    fs::write(folder.path().join("big.xml"), scene).unwrap();
    let (code, _, error) = run(&folder, "render big.xml -o a.exr");
    assert_eq!(code, Some(3), "{error}");
    let expected = "error: big.xml: camera view: a film of 65536x65536; expected at most";
    assert!(
        error.contains(expected) && error.contains("or another size") && !error.contains("--size"),
        "{error}"
    );
    let (code, _, error) = run(&folder, "render big.xml --size 65536x65536 -o a.exr");
    assert!(code == Some(2) && error.contains("--size = 65536x65536"), "{error}");
}
