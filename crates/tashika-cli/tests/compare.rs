//! Two renders of the same scene: what their intervals say of each other.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;
use tashika::film::Film;
use tashika::io::{read_exr, write_exr};

/// Runs the program in a folder; what it printed.
#[track_caller]
fn run(folder: &Path, line: &str) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tashika"));
    let output = command.current_dir(folder).args(line.split_whitespace()).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Compares two films of a folder; what was printed, and the numbers.
#[track_caller]
fn compared(folder: &Path, image: &str, reference: &str) -> (String, Value) {
    let said = run(folder, &format!("compare {image}.exr {reference}.exr --json numbers.json"));
    let json = fs::read(folder.join("numbers.json")).unwrap();
    (said, serde_json::from_slice(&json).unwrap())
}

fn samples<'f>(film: &'f Film, plane: &str) -> &'f [f32] {
    film.plane(plane).unwrap().f32_samples().unwrap()
}

#[test]
fn intervals_of_two_seeds_are_held_against_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let path = "render builtin:tiny --size 8x6 --method path -q";
    for seed in [1, 2] {
        run(folder, &format!("{path} --error 30% --seed {seed} -o {seed}.exr"));
    }
    let films = ["1.exr", "2.exr"].map(|name| read_exr(&folder.join(name)).unwrap());
    // The second film, brighter: further from the first than intervals of 30 % reach, wherever
    // there is light.
    let mut brighter = films[1].clone();
    for (x, y) in brighter.window().pixels() {
        let color = brighter.plane("").unwrap().f32_at(x, y).iter().map(|c| 9.0 * c).collect::<Vec<_>>();
        brighter.plane_mut("").unwrap().set_f32(x, y, &color);
    }
    write_exr(&folder.join("brighter.exr"), &brighter).unwrap();

    for (name, other) in [("2", &films[1]), ("brighter", &brighter)] {
        let (said, json) = compared(folder, "1", name);
        let found = &json["intervals"];
        // The same numbers from the samples; none of these is so close that rounding decides.
        let luminance = |film: &Film| -> Vec<f32> { film.colors().unwrap().map(|c| c.luminance()).collect() };
        let claims = |film: &Film| film.plane("claim").unwrap().u32_samples().unwrap().to_vec();
        let (a, b) = (luminance(&films[0]), luminance(other));
        let (h_a, h_b) = (samples(&films[0], "half_width"), samples(other, "half_width"));
        let (claim_a, claim_b) = (claims(&films[0]), claims(other));
        let claimed: Vec<usize> = (0..48).filter(|&i| claim_a[i] != 0 && claim_b[i] != 0).collect();
        let disjoint = claimed.iter().filter(|&&i| (a[i] - b[i]).abs() > h_a[i] + h_b[i]).count();
        assert!(claimed.len() > 40, "{found}");
        assert_eq!(
            (&found["claimed_in_both"], &found["disjoint"]),
            (&claimed.len().into(), &disjoint.into()),
            "{name}"
        );
        let number = |key: &str| found[key].as_f64().unwrap();
        assert_eq!((number("share"), number("confidence")), (disjoint as f64 / claimed.len() as f64, 0.95));
        assert!(number("low") <= number("share") && number("share") <= number("high"), "{found}");
        let row = format!("{disjoint} of {} that both films claim are disjoint", claimed.len());
        assert!(said.contains(&row), "{row:?} is not in: {said}");
        assert_eq!(said.contains("at least one is wrong"), disjoint > 0, "{said}");
        let lit = claimed.iter().filter(|&&i| a[i] > 0.0 && b[i] > 0.0).count();
        assert_eq!(disjoint == lit, name == "brighter", "{disjoint} of {lit} that are lit");
    }

    // A reference that claims nothing, and sums over VPLs of which each seed has its own.
    run(folder, &format!("{path} --paths 4 -o count.exr"));
    let sums = "render builtin:tiny --size 8x6 --truth vpl --vpls 100 --gather 1 -q";
    run(folder, &format!("{sums} --seed 1 -o sum.exr"));
    run(folder, &format!("{sums} --seed 2 -o other.exr"));
    run(folder, &format!("{sums} --seed 1 --method exact -o exact.exr"));
    for (image, reference) in [("1", "count"), ("sum", "other"), ("1", "sum")] {
        let (said, json) = compared(folder, image, reference);
        assert!(json["intervals"].is_null(), "{image} {reference}: {json}");
        assert!(!said.contains("intervals"), "{image} {reference}: {said}");
    }
    let (_, json) = compared(folder, "sum", "exact");
    let (claims, intervals) = (&json["claims"], &json["intervals"]);
    assert!(claims["of"].as_u64() > Some(40) && claims["same_truth"] == true, "{json}");
    assert_eq!(intervals["claimed_in_both"], claims["of"]);
    let broken = claims["of"].as_u64().unwrap() - claims["kept"].as_u64().unwrap();
    assert_eq!(intervals["disjoint"], broken, "claims that do not meet an exact reference are broken");
}
