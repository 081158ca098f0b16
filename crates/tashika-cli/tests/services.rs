//! Behaviour of the program for scripts, schedulers and farms.

use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;

/// A render that takes a moment.
const TINY: &str = "render builtin:tiny --size 8x6 --truth vpl --vpls 50 --gather 1";

fn run(folder: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tashika"));
    command.current_dir(folder).args(line.split_whitespace()).output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

#[track_caller]
fn fails(folder: &Path, line: &str, code: i32, said: &[&str]) {
    let output = run(folder, line);
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{line}: {stderr}");
    for words in said {
        assert!(stderr.contains(words), "{line}: {words:?} is not in: {stderr}");
    }
}

#[track_caller]
fn succeeds(folder: &Path, line: &str) -> Output {
    let output = run(folder, line);
    assert_eq!(output.status.code(), Some(0), "{line}: {}", text(&output.stderr));
    output
}

#[test]
fn json_goes_to_standard_output_alone_and_the_log_to_standard_error() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let output = succeeds(folder, &format!("{TINY} --json - -o a.exr"));
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    assert_eq!(json["pixels"], 48);
    let output = succeeds(folder, "compare a.exr a.exr --json -");
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    assert_eq!(json["within_tolerance"], 1.0);
    let output = succeeds(folder, "info builtin:tiny --json -");
    assert!(serde_json::from_slice::<Value>(&output.stdout).is_ok(), "{}", text(&output.stdout));

    let output = succeeds(folder, &format!("{TINY} --quiet --log-file - -o a.exr"));
    assert!(text(&output.stderr).contains("rendering 8x6"), "{}", text(&output.stderr));
    let output = succeeds(folder, &format!("{TINY} --log-file - --json - -o a.exr"));
    assert_eq!(text(&output.stderr).matches("rendering 8x6").count(), 1, "told once");
    assert!(serde_json::from_slice::<Value>(&output.stdout).is_ok());
    let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["a.exr", "a.html", "a.png"], "no file is named -");
}

#[test]
fn the_json_of_a_render_has_notes_claims_and_the_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // The file has two lines, which are not surfaces. They give one note, with a count of two.
    fs::write(folder.join("a.obj"), "v -1 0 -1\nv -1 0 1\nv 1 0 1\nf 1 2 3\nl 1 2\nl 2 3\n").unwrap();
    let render = "render a.obj --size 8x6 --truth vpl -q --json a.json";
    let json = |line: &str, code: i32| -> Value {
        let output = run(folder, line);
        assert_eq!(output.status.code(), Some(code), "{}", text(&output.stderr));
        let json: Value = serde_json::from_slice(&fs::read(folder.join("a.json")).unwrap()).unwrap();
        assert_eq!(json["exit_code"], code);
        json
    };
    let told = json(&format!("{render} --vpls 50 --gather 4"), 0);
    let claiming: u64 =
        ["exact", "calibrated"].iter().map(|kind| told["tally"][*kind].as_u64().unwrap()).sum();
    assert_eq!((claiming, &told["pixels"]), (48, &48.into()), "{told}");
    let notes = told["notes"].as_array().unwrap();
    let lines = notes.iter().find(|note| note["first"] == "a.obj:5").expect("a note on line 5");
    assert_eq!(lines["count"], 2, "{lines}");
    assert!(lines["kind"].is_string() && lines["message"].as_str().unwrap().contains('l'), "{lines}");
    succeeds(folder, "info a.obj --json info.json");
    let info: Value = serde_json::from_slice(&fs::read(folder.join("info.json")).unwrap()).unwrap();
    assert_eq!(told["notes"], info["notes"], "the same as `info` has");
    json(&format!("{render} --max-pairs 1 --gather 64 --error 0.1% --vpls 5000"), 4);
}

#[test]
fn a_job_without_its_scene_or_over_another_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for engine in ["openjd", "slurm"] {
        let absent = format!("farm {engine} --out absent -- render absent.obj -o a.exr");
        fails(folder, &absent, 3, &["absent.obj: there is no such scene"]);
        assert!(!folder.join("absent").exists(), "nothing is made");
        let line = format!("farm {engine} --out {engine} -- {TINY} -o a.exr");
        succeeds(folder, &line);
        let files = || -> Vec<(std::ffi::OsString, Vec<u8>)> {
            let files = fs::read_dir(folder.join(engine)).unwrap().map(|e| e.unwrap());
            files.map(|e| (e.file_name(), fs::read(e.path()).unwrap())).collect()
        };
        let before = files();
        let other = format!("{line} --seed 7");
        fails(folder, &other, 3, &["is of a job that is there", "--out names another folder"]);
        assert!(!before.is_empty() && files() == before, "the job is as it was");
        // Even if one file of the job is moved away, the remaining files are not overwritten.
        fs::rename(folder.join(engine).join(&before[0].0), folder.join("moved")).unwrap();
        if before.len() > 1 {
            fails(folder, &other, 3, &["is of a job that is there"]);
        }
    }
}

#[test]
fn shells_and_man_are_told_what_there_is() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for shell in ["bash", "zsh", "fish"] {
        let script = succeeds(folder, &format!("completions {shell}")).stdout;
        assert!(text(&script).contains("tashika") && text(&script).contains("certified"), "{shell}");
    }
    fails(folder, "completions tcsh", 2, &["'tcsh'", "bash"]);
    let page = succeeds(folder, "man farm slurm").stdout;
    assert!(text(&page).contains("tashika\\-farm\\-slurm") && text(&page).contains("shares"));
    assert!(text(&succeeds(folder, "man").stdout).contains("Exit codes"));
    fails(folder, "man farm lsf", 2, &["no command \"lsf\"; expected one of openjd, slurm"]);
    fails(folder, "man info more", 2, &["no command \"more\"; expected no more words"]);
}

/// Begins a render that would take many minutes. Once it has begun, calls `meanwhile`, and then
/// sends `signal` to the process.
#[cfg(unix)]
fn ended_by(signal: &str, folder: &Path, temporary: &Path, meanwhile: impl FnOnce()) -> Output {
    use std::io::{BufRead, BufReader, Read};
    use std::process::{Command, Stdio};

    let line =
        "render builtin:tiny --size 600x600 --truth vpl --vpls 2000 --gather 64 -o out/a.exr --json a.json";
    fs::create_dir(folder.join("out")).unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_tashika"))
        .current_dir(folder)
        .env("TMPDIR", temporary)
        .args(line.split(' '))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut said = String::new();
    while !said.contains("rendering 600x600") {
        assert!(stderr.read_line(&mut said).unwrap() > 0, "{said}");
    }
    meanwhile();
    let status = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    assert!(status.success());
    stderr.read_to_string(&mut said).unwrap();
    let output = child.wait_with_output().unwrap();
    Output { stderr: said.into_bytes(), ..output }
}

#[cfg(unix)]
#[test]
fn sigterm_leaves_a_valid_partial_image_as_ctrl_c_does() {
    let folder = tempfile::tempdir().unwrap();
    let output = ended_by("-TERM", folder.path(), folder.path(), || {});
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("interrupted: finishing"), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("NOT COMPLETE"));
    let film = tashika::io::read_exr(&folder.path().join("out/a.exr")).unwrap();
    assert_eq!(film.metadata().bool("complete"), Some(false));
    let json: Value = serde_json::from_slice(&fs::read(folder.path().join("a.json")).unwrap()).unwrap();
    assert_eq!((&json["complete"], &json["exit_code"]), (&false.into(), &130.into()));
}

#[cfg(unix)]
#[test]
fn an_image_that_cannot_be_written_is_saved_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    let temporary = tempfile::tempdir().unwrap();
    let lose = || fs::remove_dir_all(folder.path().join("out")).unwrap();
    let output = ended_by("-INT", folder.path(), temporary.path(), lose);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("cannot write out/a.exr: there is no folder out"), "{said}");
    let saved = said.split("the image is saved as ").nth(1).expect("where it is").trim();
    assert!(Path::new(saved).starts_with(temporary.path()), "{saved}");
    let film = tashika::io::read_exr(Path::new(saved)).unwrap();
    assert_eq!((film.size(), film.metadata().bool("complete")), ([600, 600], Some(false)));

    let output = ended_by("-INT", folder.path(), &folder.path().join("none"), lose);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("nor could it be saved for the time being"), "{said}");
}
