//! Options that contradict each other.

use std::fs;

use assert_cmd::Command;

#[test]
fn options_that_contradict_each_other_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let run = |line: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tashika"));
        let output = command.current_dir(folder.path()).args(line.split_whitespace()).output().unwrap();
        let [out, err] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        (output.status.code(), out, err)
    };
    let refused = |line: &str, said: &[&str]| {
        let (code, _, error) = run(line);
        assert_eq!(code, Some(2), "{line}: {error}");
        for words in said {
            assert!(error.contains(words), "{line}: {words:?} is not in: {error}");
        }
    };
    let small = "render scene.obj --size 2x2";
    for (options, said) in [
        ("--method path --paths 2 --vpls 7", ["--vpls = 7", "none with method path"]),
        (
            "--quality draft --error 5% --claim calibrated",
            ["--quality = draft", "none with claim calibrated"],
        ),
        ("--quality good --method mdlc", ["--quality = good", "none with method mdlc"]),
        ("--error 5% --time 5s", ["--time = 5s", "none without claim audited"]),
        ("--method path --vpl-file a.vpl", ["--vpl-file = given ones", "none with method path"]),
        ("--passes 3 --time 5s", ["--passes = 3", "none with time"]),
        ("--error 5% --passes 3", ["--passes = 3", "none without claim audited"]),
        ("--method path --audit 9", ["--audit = 9", "unless an error or a claim is asked for"]),
        ("--quality draft --write-vpls a.vpl", ["--write-vpls = a.vpl", "audited as a whole"]),
    ] {
        refused(&format!("{small} {options}"), &said);
    }
    // `--paths` is refused although some scenes need path tracing: this scene does not.
    refused(&format!("{small} --paths 7"), &["--paths = 7", "none with method tashika"]);
    let (code, said, error) = run(&format!("{small} --method path --paths 2"));
    assert!(code == Some(0) && said.contains("2 paths a pixel"), "{said}{error}");
}
