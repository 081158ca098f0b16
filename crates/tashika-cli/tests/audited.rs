//! Audited pictures of the program: output, exit codes, and comparison with a reference.

use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;
use tashika::film::planes;

/// A small audited picture of the built-in box.
const RENDER: &str = "render builtin:tiny --size 48x36 --claim audited --vpls 5000";
const EASY: &str = "--share 90% --assurance 90% --audit 60";
/// Options of a picture of six tiles that is rendered in parts.
const PARTS: &str = "render builtin:tiny --size 70x50 --method path --claim audited --error 50% --share 90% \
                     --assurance 90% --audit 60";

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
    let claim = &json(folder, "a.json")["picture_claim"];
    // If the first interim analysis leaves hope, twice as many pixels are checked.
    let audited = claim["audited"].as_u64().unwrap();
    assert!([60, 120].contains(&audited) && claim["reached"].as_bool() == Some(true), "{claim}");
    let said = format!("{audited} pixels were checked");
    assert!(told.contains(&format!("within 25 % of light transport, 90 % sure; {said}")), "{told}");
    let page = std::fs::read_to_string(folder.join("a.html")).unwrap();
    assert!(page.contains(&said), "the page says it, too");

    let reference = "render builtin:tiny --size 48x36 --method path --paths 512 -o truth.exr --quiet";
    assert_eq!(run(folder, reference).0, Some(0));
    let (_, told, _) = run(folder, "compare a.exr truth.exr --error 25% --json c.json");
    assert!(told.contains("at least") && told.contains("claimed: held"), "{told}");
    assert_eq!(json(folder, "c.json")["picture"]["held"].as_bool(), Some(true));
}

/// The requested error cannot be reached in the given time. The picture is written with the share
/// that is certain, and the exit code is 0: it ended as requested.
#[test]
fn there_is_an_answer_when_the_time_is_up() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let sure = "--share 90% --assurance 99% --audit 80";
    let line = format!("{RENDER} {sure} --error 0.1% --time 0.001s -o a.exr --json a.json");
    let (code, told, _) = run(folder, &line);
    assert_eq!(code, Some(0), "{told}");
    assert!(told.contains("up to the aim of 90 %"), "{told}");
    assert_eq!(json(folder, "a.json")["picture_claim"]["passes"].as_u64(), Some(1));
    assert!(told.contains("no map of half-widths"), "{told}");
    let page = std::fs::read_to_string(folder.join("a.html")).unwrap();
    assert!(page.contains("There is no map of half-widths") && !page.contains("ran out of budget"));
    assert!(!page.contains("do not rely on"), "what shows nothing is known");
}

/// A picture is rendered in two parts and in three. Parts claim nothing, and both merged files have
/// the same bytes.
#[test]
fn audited_parts_are_merged_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let succeeds = |line: &str| {
        let (code, told, err) = run(folder, line);
        assert_eq!(code, Some(0), "{line}: {told}{err}");
        told
    };
    for share in ["1/2", "2/2", "1/3", "2/3", "3/3"] {
        let name = share.replace('/', "-");
        // Checkpoints are permitted for parts.
        let line = format!("{PARTS} --tiles {share} --checkpoint -o {name}.exr --json {name}.json");
        let told = succeeds(&line);
        assert!(!told.contains("pixels were checked") && told.contains("merge"), "{told}");
        assert!(json(folder, &format!("{name}.json"))["picture_claim"].is_null());
    }
    let told = succeeds("merge 2-2.exr 1-2.exr -o two.exr --json two.json");
    assert!(told.contains("within 50 % of light transport, 90 % sure"), "{told}");
    let claim = &json(folder, "two.json")["picture_claim"];
    assert_eq!((claim["looks"].as_u64(), claim["reached"].as_bool()), (Some(1), Some(true)), "{claim}");
    let (code, _, err) = run(folder, "merge 1-3.exr 3-3.exr -o some.exr");
    assert!(code == Some(3) && err.contains("of 3 shares these are missing: 2"), "{err}");
    let told = succeeds("merge 1-3.exr 3-3.exr -o some.exr --partial");
    assert!(!told.contains("pixels were checked"), "{told}");
    succeeds("merge some.exr 2-3.exr -o three.exr");
    for ending in ["exr", "png"] {
        let bytes = |name: &str| std::fs::read(folder.join(format!("{name}.{ending}"))).unwrap();
        assert!(bytes("two") == bytes("three"), "{ending}");
    }
    // Merging the joined picture alone changes nothing; with one of its parts it is refused.
    succeeds("merge two.exr -o again.exr");
    assert!(
        std::fs::read(folder.join("again.exr")).unwrap() == std::fs::read(folder.join("two.exr")).unwrap()
    );
    let (code, _, err) = run(folder, "merge two.exr 1-2.exr -o a.exr");
    assert!(code == Some(3) && err.contains("1-2.exr"), "{err}");
    let (code, _, err) = run(folder, &format!("{PARTS} --seed 2 --tiles 2/2 -o other.exr"));
    assert_eq!(code, Some(0), "{err}");
    let (code, _, err) = run(folder, "merge 1-2.exr other.exr -o a.exr");
    assert!(code == Some(3) && err.contains("seed = 2"), "{err}");
}

/// The radiance in both parts is multiplied by 2.5. The audit then fails, and merging ends with
/// exit code 4.
#[test]
fn merging_ends_with_4_where_the_share_was_not_reached() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for share in ["1/2", "2/2"] {
        let path = folder.join(format!("{}.exr", share.replace('/', "-")));
        assert_eq!(run(folder, &format!("{PARTS} --tiles {share} -o {}", path.display())).0, Some(0));
        let mut part = tashika::io::read_exr(&path).unwrap();
        let halves = part.plane(planes::HALVES).unwrap().clone();
        for (x, y) in part.window().pixels() {
            let mut samples = halves.f32_at(x, y).to_vec();
            samples[..8].iter_mut().for_each(|sample| *sample *= 2.5);
            part.plane_mut(planes::HALVES).unwrap().set_f32(x, y, &samples);
        }
        tashika::io::write_exr(&path, &part).unwrap();
    }
    let (code, told, err) = run(folder, "merge 1-2.exr 2-2.exr -o a.exr --json a.json");
    assert_eq!(code, Some(4), "{told}{err}");
    assert!(told.contains("90 % were asked for"), "{told}");
    assert_eq!(json(folder, "a.json")["picture_claim"]["reached"].as_bool(), Some(false));
    assert_eq!(run(folder, "merge 1-2.exr 2-2.exr -o a.exr --accept-budget").0, Some(0));
}

#[test]
fn what_does_not_go_with_it_is_said() {
    let folder = tempfile::tempdir().unwrap();
    for (options, expected) in [
        ("--tiles 1/2 --time 5s", "fixed amount of work"),
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
    for option in ["--time 5s", "--share 90%", "--denoiser own"] {
        let line = format!("render builtin:tiny --size 8x6 --vpls 200 --max-pairs 64 {option} -o b.exr");
        let (code, _, err) = run(folder.path(), &line);
        assert_eq!(code, Some(2), "{option}: {err}");
        let name = option.split(' ').next().unwrap();
        assert!(err.contains(name) && err.contains("none without claim audited"), "{option}: {err}");
    }
}
