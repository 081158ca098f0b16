//! `tashika glare`, and pictures of luminances.

use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

const EYE: &str =
    "render builtin:tiny --projection fisheye --fov 180 --size 12x12 --error 40% --vpls 5k -o eye.exr";

fn run(folder: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tashika"));
    command.current_dir(folder).args(line.split_whitespace()).output().unwrap()
}

/// Standard output of a command that succeeds, or whose pixels ran out of budget.
#[track_caller]
fn output(folder: &Path, line: &str) -> String {
    let output = run(folder, line);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!([Some(0), Some(4)].contains(&output.status.code()), "{line}: {stderr}");
    String::from_utf8(output.stdout).unwrap()
}

/// The picture of luminances is beside the image and on the page, and `glare` reads the angle of
/// the render. Each index is inside its interval.
#[test]
fn a_fisheye_has_its_luminances_and_its_glare() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let rows = output(folder, &format!("{EYE} --false-color cd/m2:2"));
    assert!(rows.contains("eye-luminance.png"), "{rows}");
    assert!(fs::read(folder.join("eye-luminance.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(fs::read_to_string(folder.join("eye.html")).unwrap().contains("Luminance in false colours"));
    let rows = output(folder, "glare eye.exr --threshold 0.5 --image sources.png --json glare.json");
    for label in ["fisheye of 180 degrees", "lx at the eye", "UGR", "DGP", "sources.png"] {
        assert!(rows.contains(label), "{label}: {rows}");
    }
    let json = fs::read_to_string(folder.join("glare.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    for name in ["dgp", "vertical_illuminance", "background"] {
        let value = json[name]["value"].as_f64().unwrap();
        let [low, high] = [0, 1].map(|k| json[name]["interval"][k].as_f64().unwrap());
        assert!(low < value && value < high && high < 2.0 * value, "{name}: {}", json[name]);
    }
    assert_eq!((json["silent"].as_u64(), json["photometry"].as_str()), (Some(0), Some("scene")));
    assert!(folder.join("sources.png").exists());
}

/// Each fault ends the program with its exit code, and the message names the place.
#[test]
fn faults_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("text.exr"), "no image").unwrap();
    output(
        folder,
        "render builtin:tiny --size 8x8 --method path --paths 1 --projection perspective -o flat.exr",
    );
    for (line, code, message) in [
        ("glare absent.exr", 3, "absent.exr"),
        ("glare text.exr", 3, "text.exr"),
        ("glare flat.exr", 3, "flat.exr: an image of projection perspective"),
        ("glare flat.exr --angle 400", 2, "--angle = 400"),
        ("glare flat.exr --threshold -1", 2, "--threshold = -1"),
        ("glare flat.exr --image out.jpg", 2, ".png"),
        ("glare", 2, "FILE.exr"),
        ("render builtin:tiny --false-color lx", 2, "expected cd/m2"),
        ("render builtin:tiny --false-color cd/m2:0", 2, "above 0"),
        ("render builtin:tiny --photometry cie", 2, "--photometry goes with --false-color"),
    ] {
        let output = run(folder, line);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(code) && stderr.contains(message), "{line}: {stderr}");
    }
}
