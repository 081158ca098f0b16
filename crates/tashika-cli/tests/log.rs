//! Progress of a command: `--log` and `--log-file`.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

/// Runs the program in `folder`; returns exit code and standard error.
fn run(folder: &Path, line: &str) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tashika"));
    let output = command.current_dir(folder).args(line.split_whitespace()).output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

/// Reads events, one JSON object a line and nothing else, and returns them with their names.
fn events(lines: &str) -> Vec<(String, Value)> {
    let read = |line: &str| {
        let object: Value = serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"));
        (object["event"].as_str().expect("the event's name").to_owned(), object)
    };
    lines.lines().map(read).collect()
}

fn named<'a>(events: &'a [(String, Value)], name: &str) -> Vec<&'a Value> {
    events.iter().filter(|(n, _)| n == name).map(|(_, object)| object).collect()
}

const TINY: &str = "render builtin:tiny --size 32x24 --truth vpl --vpls 100 --gather 1";
/// Command with lights from a file. The program notes that the truth is the sum over these lights.
const NOTED: &str = "render builtin:tiny --size 32x24 --vpl-file lights.vpl --gather 1";

/// Writes the lights of [`NOTED`].
fn write_lights(folder: &Path) {
    let (code, said) = run(folder, "vpl builtin:tiny --vpls 100 -o lights.vpl");
    assert_eq!(code, Some(0), "{said}");
}

#[test]
fn programs_are_told_events_and_the_end() {
    let folder = tempfile::tempdir().unwrap();
    write_lights(folder.path());
    let (code, said) = run(folder.path(), &format!("{NOTED} --log json"));
    assert_eq!(code, Some(0), "{said}");
    let events = events(&said);
    let phases = named(&events, "phase");
    assert!(phases.iter().any(|p| p["what"].as_str().unwrap().starts_with("rendering 32x24")), "{said}");
    assert!(named(&events, "note")[0]["what"].as_str().unwrap().starts_with("what is rendered"), "{said}");
    let last = named(&events, "progress").pop().expect("the last pixel is told");
    assert_eq!((last["pixels"].as_u64(), last["of"].as_u64()), (Some(768), Some(768)));
    assert_eq!((last["promise_met"].as_u64(), last["promise_share"].as_f64()), (Some(768), Some(1.0)));
    assert_eq!(last["seconds_left"].as_f64(), Some(0.0));
    assert!(last["rays"].as_u64() > Some(0) && last["rays_per_second"].as_f64() > Some(0.0));
    assert!(last["seconds"].is_number());
    if cfg!(any(target_os = "linux", target_os = "macos", windows)) {
        assert!(last["memory_bytes"].as_u64() > Some(1_000_000), "{last}");
    }
    let (name, done) = events.last().unwrap();
    assert_eq!((name.as_str(), done["exit_code"].as_u64()), ("done", Some(0)));
    assert!(done["seconds"].as_f64() >= last["seconds"].as_f64());
}

#[test]
fn methods_without_a_promise_tell_no_share() {
    let folder = tempfile::tempdir().unwrap();
    let line = "render builtin:tiny --size 32x24 --method path --paths 1 --log json";
    let (_, said) = run(folder.path(), line);
    let events = events(&said);
    let progress = named(&events, "progress");
    assert!(!progress.is_empty() && progress.iter().all(|p| p["promise_met"].is_null()), "{said}");
}

#[test]
fn a_failure_is_the_last_event() {
    let folder = tempfile::tempdir().unwrap();
    let (code, said) = run(folder.path(), "info absent.obj --log json --log-file log.txt");
    assert_eq!(code, Some(3));
    let events = events(&said);
    let (name, error) = events.last().unwrap();
    assert_eq!((name.as_str(), error["exit_code"].as_u64()), ("error", Some(3)));
    assert!(error["what"].as_str().unwrap().contains("absent.obj"));
    assert_eq!(fs::read_to_string(folder.path().join("log.txt")).unwrap(), said);
    let (_, said) = run(folder.path(), "info absent.obj --log-file words.txt");
    assert_eq!(said.matches("error:").count(), 1, "{said}");
    assert_eq!(fs::read_to_string(folder.path().join("words.txt")).unwrap(), said);
}

#[test]
fn a_file_gets_the_same_lines_after_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("log.txt");
    fs::write(&log, "before\n").unwrap();
    write_lights(folder.path());
    let (code, said) = run(folder.path(), &format!("{NOTED} --log plain --log-file log.txt"));
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("note: what is rendered") && said.contains("rendering 32x24"), "{said}");
    assert_eq!(fs::read_to_string(&log).unwrap(), format!("before\n{said}"));
    let (_, quiet) = run(folder.path(), &format!("{NOTED} --quiet --log-file log.txt"));
    assert_eq!(quiet, "");
    assert_eq!(fs::read_to_string(&log).unwrap(), format!("before\n{said}{said}"), "the file hears all");
}

#[test]
fn a_file_that_cannot_be_written_is_told_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let (code, said) = run(folder.path(), &format!("{TINY} --log-file none/log.txt"));
    assert_eq!(code, Some(3));
    assert!(said.contains("cannot write none/log.txt") && !said.contains("reading"), "{said}");
    let (code, said) = run(folder.path(), &format!("{TINY} --json a.txt --log-file a.txt"));
    assert_eq!(code, Some(2));
    assert!(said.contains("a.txt would be written twice"), "{said}");
    let (code, said) = run(folder.path(), "info --log xml");
    assert_eq!(code, Some(2));
    assert!(said.contains("'xml'") && said.contains("plain, json"), "{said}");
}
