//! Images with pixels that are not finite: output and exit code of the program.

use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;
use tashika::film::{Claim, RenderFilm, Stop};
use tashika::io::read_exr;

/// White floor under the left half of the film. The radiance of the sky is close to the largest
/// number of single precision, so that light reflected by the floor may overflow.
const SCENE: &str = "\
LookAt 0 5 0  0 0 0  0 0 1
Camera \"orthographic\" \"float screenwindow\" [-2 2 -2 2]
WorldBegin
LightSource \"infinite\" \"rgb L\" [3e38 3e38 3e38]
Material \"diffuse\" \"rgb reflectance\" [1 1 1]
Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]
  \"point3 P\" [0 0 -9  0 0 9  9 0 9  9 0 -9]
";

fn run(folder: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tashika"));
    command.current_dir(folder).args(line.split_whitespace()).output().unwrap()
}

/// Returns the exit code and the output of the program.
fn ended(folder: &Path, line: &str) -> (i32, String) {
    let output = run(folder, line);
    (output.status.code().unwrap(), String::from_utf8(output.stdout).unwrap())
}

/// Counts the pixels of a film that are not finite. Asserts that exactly these have the stop `not
/// finite`, and that they claim nothing.
fn not_finite(film: &Path) -> u64 {
    let film = read_exr(film).unwrap();
    let (read, stop) = (RenderFilm::of(&film), film.plane("stop").unwrap());
    for (pixel, (x, y)) in film.window().pixels().enumerate() {
        let is_finite = read.color(pixel).unwrap().is_finite();
        assert_eq!(stop.u32_at(x, y) == [Stop::NotFinite.id()], !is_finite, "{x},{y}");
        assert!(is_finite || read.claim(pixel) == Claim::None, "{x},{y}");
        assert!(is_finite || read.at(x, y).half_width.is_nan(), "{x},{y}");
    }
    read.tally().not_finite
}

#[test]
fn pixels_that_are_not_finite_are_said_and_no_success() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("bright.pbrt"), SCENE).unwrap();
    for asked in ["--method path --paths 64", "--quality draft --vpls 500"] {
        let line = format!("render bright.pbrt --size 16x8 {asked} -o a.exr --json a.json");
        let (code, said) = ended(folder, &line);
        let count = not_finite(&folder.join("a.exr"));
        assert!(count > 0, "{asked}: {said}");
        assert_eq!(code, 6, "{asked}: {said}");
        let words = if count == 1 {
            "1 pixel is not finite".to_owned()
        } else {
            format!("{count} pixels are not finite")
        };
        assert!(said.contains("NOT FINITE") && said.contains(&words), "{asked}: {said}");
        assert!(fs::read_to_string(folder.join("a.html")).unwrap().contains(&words), "{asked}");
        let json: Value = serde_json::from_slice(&fs::read(folder.join("a.json")).unwrap()).unwrap();
        assert_eq!((&json["tally"]["not_finite"], &json["exit_code"]), (&count.into(), &6.into()), "{json}");
        assert!(json["mean_radiance"].as_array().unwrap().iter().all(Value::is_number), "{json}");
    }
}

/// A part with pixels that are not finite ends with exit code 6. A share of a job
/// (`--accept-budget`) ends with 0, and merging reports the pixels.
#[test]
fn parts_and_what_is_merged_from_them_say_it() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("bright.pbrt"), SCENE).unwrap();
    let part = |number: u32, more: &str| {
        let line = format!(
            "render bright.pbrt --size 40x40 --method path --paths 16 --tiles {number}/2 -o {number}.exr {more}"
        );
        ended(folder, &line)
    };
    let (code, said) = part(1, "");
    assert!(code == 6 && said.contains("NOT FINITE"), "{code}: {said}");
    for number in [1, 2] {
        let (code, said) = part(number, "--accept-budget");
        assert!(code == 0 && said.contains("NOT FINITE"), "{code}: {said}");
    }
    let (code, said) = ended(folder, "merge 1.exr 2.exr -o whole.exr --accept-budget");
    let of_parts: u64 = ["1.exr", "2.exr"].iter().map(|name| not_finite(&folder.join(name))).sum();
    assert!(code == 6 && said.contains(&format!("{of_parts} pixels are not finite")), "{code}: {said}");
    assert_eq!(not_finite(&folder.join("whole.exr")), of_parts);
}
