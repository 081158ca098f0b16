//! Comparison of two renders of a scene, by their intervals.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;
use tashika::film::{Film, Samples, planes};
use tashika::io::{read_exr, write_exr};

/// Runs the program in a folder; returns its standard output.
#[track_caller]
fn run(folder: &Path, line: &str) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tashika"));
    let output = command.current_dir(folder).args(line.split_whitespace()).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Compares two films of a folder; returns the printed text and the numbers.
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
    // The second film is made nine times as bright. Wherever there is light, its intervals of 30 %
    // are disjoint from those of the first film.
    let mut brighter = films[1].clone();
    for (x, y) in brighter.window().pixels() {
        let color = brighter.plane("").unwrap().f32_at(x, y).iter().map(|c| 9.0 * c).collect::<Vec<_>>();
        brighter.plane_mut("").unwrap().set_f32(x, y, &color);
    }
    write_exr(&folder.join("brighter.exr"), &brighter).unwrap();

    for (name, other) in [("2", &films[1]), ("brighter", &brighter)] {
        let (said, json) = compared(folder, "1", name);
        let found = &json["intervals"];
        // The counts are computed again from the samples. No pixel is so close to the limit that
        // rounding matters.
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

    // Intervals are not compared if the reference has no claims, or if the films are sums over
    // different sets of VPLs.
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

#[test]
fn an_image_is_judged_by_the_error_that_it_was_rendered_to() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let path = "render builtin:tiny --size 12x11 --method path -q";
    run(folder, &format!("{path} --error 30% --absolute 0.001 -o rendered.exr"));
    run(folder, &format!("{path} --paths 64 -o reference.exr"));
    let said = "30 % of the reference, or 0.001 where it is dark";
    let why = "the error that the image was rendered to; --error sets another";
    for (image, options, expected, told) in [
        ("rendered", "", (0.3, 0.001, "image"), true),
        ("rendered", "--absolute 0", (0.3, 0.0, "image"), true),
        ("rendered", "--error 30% --absolute 0.001", (0.3, 0.001, "asked"), false),
        ("rendered", "--error 2%", (0.02, 0.0, "asked"), false),
        ("reference", "", (0.02, 0.0, "default"), false),
    ] {
        let line = format!("compare {image}.exr reference.exr {options} --json numbers.json");
        let printed = run(folder, &line);
        let json: Value = serde_json::from_slice(&fs::read(folder.join("numbers.json")).unwrap()).unwrap();
        let found = (&json["error"], &json["absolute"], &json["error_from"]);
        assert_eq!(found, (&expected.0.into(), &expected.1.into(), &expected.2.into()), "{line}");
        assert_eq!(printed.contains(why), told, "{line}: {printed}");
        assert_eq!(printed.contains(said), (expected.0, expected.1) == (0.3, 0.001), "{line}: {printed}");
    }
}

#[test]
fn pixels_that_are_not_finite_have_failed_and_measures_are_of_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, "render builtin:tiny --size 16x12 --truth vpl --vpls 300 --gather 1 -q -o whole.exr");
    let film = read_exr(&folder.join("whole.exr")).unwrap();
    let window = film.window();
    let mut samples = samples(&film, "").to_vec();
    let spoiled = [5, 40, 191];
    for (pixel, value) in spoiled.into_iter().zip([f32::NAN, f32::INFINITY, f32::NEG_INFINITY]) {
        samples[3 * pixel] = value;
    }
    // One of the other pixels has an error of 0.5 in green.
    samples[3 * 100 + 1] += 0.5;
    let mut image = Film::new(film.size(), window, &[]).unwrap();
    image.add_plane(&planes::RADIANCE, Samples::F32(samples));
    write_exr(&folder.join("spoiled.exr"), &image).unwrap();

    let (said, json) = compared(folder, "spoiled", "whole");
    assert_eq!((&json["pixels"], &json["failed"]), (&192.into(), &3.into()));
    assert_eq!(json["within_tolerance"].as_f64(), Some(188.0 / 192.0), "{json}");
    assert_eq!((&json["left_out"]["not_finite"], &json["worst"]), (&0.into(), &Value::Null));
    let number = |key: &str| json[key].as_f64().unwrap_or_else(|| panic!("{key}: {json}"));
    assert!((number("rmse") - (0.25_f64 / 567.0).sqrt()).abs() < 1e-6, "{json}");
    assert!(number("psnr") > 20.0 && number("ssim") > 0.8 && number("relmse") > 0.0, "{json}");
    assert!(number("flip") > 0.0 && number("flip") < 0.1 && number("exposure_stops").is_finite(), "{json}");
    assert!(said.contains("3 pixels: not finite, outside of any tolerance"), "{said}");
    assert!(said.contains("RMSE") && said.contains("FLIP"), "{said}");
    // Pixels that are not finite in the reference are not counted.
    let (_, json) = compared(folder, "whole", "spoiled");
    assert_eq!((&json["pixels"], &json["failed"]), (&189.into(), &0.into()));
    assert_eq!(json["left_out"]["not_finite"], 3);
    // The ratio of equal pictures is infinite, which JSON cannot represent.
    let (said, json) = compared(folder, "whole", "whole");
    assert_eq!((&json["psnr"], &json["rmse"], &json["flip"]), (&Value::Null, &0.0.into(), &0.0.into()));
    assert!(said.contains("PSNR infinite"), "{said}");
}
