//! The program's audited pictures: what is told of them, what they exit with, what `compare` says.

use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

/// A small picture of the built-in box, of which little is asked.
const RENDER: &str = "render builtin:tiny --size 48x36 --claim audited --vpls 5000";
const EASY: &str = "--share 90% --assurance 90% --audit 60";

/// Exit code, standard output, standard error.
fn run(folder: &Path, line: &str) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tashika"));
    let output = command.current_dir(folder).args(line.split_whitespace()).output().unwrap();
    let [out, err] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    (output.status.code(), out, err)
}

fn json(folder: &Path, name: &str) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join(name)).unwrap()).unwrap()
}

#[test]
fn a_picture_says_what_share_of_it_is_certain() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (code, told, err) = run(folder, &format!("{RENDER} {EASY} --error 25% -o a.exr --json a.json"));
    assert_eq!(code, Some(0), "{told}{err}");
    assert!(told.contains("within 25 % of light transport, 90 % sure; 60 pixels were checked"), "{told}");
    let claim = &json(folder, "a.json")["picture_claim"];
    assert_eq!((claim["audited"].as_u64(), claim["reached"].as_bool()), (Some(60), Some(true)), "{claim}");
    let page = std::fs::read_to_string(folder.join("a.html")).unwrap();
    assert!(page.contains("60 pixels were checked"), "the page says it, too");

    let reference = "render builtin:tiny --size 48x36 --method path --paths 512 -o truth.exr --quiet";
    assert_eq!(run(folder, reference).0, Some(0));
    let (_, told, _) = run(folder, "compare a.exr truth.exr --error 25% --json c.json");
    assert!(told.contains("at least") && told.contains("claimed: held"), "{told}");
    assert_eq!(json(folder, "c.json")["picture"]["held"].as_bool(), Some(true));
}

/// What is asked for is out of reach; the answer is there all the same.
#[test]
fn there_is_an_answer_when_the_time_is_up() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let line = format!("{RENDER} {EASY} --error 0.1% --time 0.001s -o a.exr --json a.json");
    let (code, told, _) = run(folder, &line);
    assert_eq!(code, Some(4), "{told}");
    assert!(told.contains("90 % were asked for"), "{told}");
    assert_eq!(json(folder, "a.json")["picture_claim"]["passes"].as_u64(), Some(1));
}

#[test]
fn what_does_not_go_with_it_is_said() {
    let folder = tempfile::tempdir().unwrap();
    for (options, expected) in [
        ("--tiles 1/2", "a share of a share"),
        ("--checkpoint", "--checkpoint"),
        ("--control channels", "luminance"),
        ("--truth vpl", "transport"),
        ("--share 120%", "share"),
        ("--assurance 10%", "assurance"),
        ("--audit 5", "are enough"),
        ("--quality best", "draft, good, final"),
        ("--time soon", "60s"),
    ] {
        let (code, _, err) = run(folder.path(), &format!("{RENDER} {options} -o a.exr"));
        assert_eq!(code, Some(2), "{options}: {err}");
        assert!(err.contains(expected), "{options}: {err}");
    }
    let line = "render builtin:tiny --size 8x6 --vpls 200 --max-pairs 64 --time 5s --share 90% -o b.exr";
    let (code, _, err) = run(folder.path(), line);
    assert_eq!(code, Some(0), "{err}");
    assert!(err.contains("--time means nothing") && err.contains("--share means nothing"), "{err}");
}
