//! `tashika sensors`: tables, shares, pages and faults.

use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

const OPTIONS: &str = "builtin:tiny --error 20% --vpls 20k";

fn run(folder: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tashika"));
    command.current_dir(folder).args(line.split_whitespace()).output().unwrap()
}

/// Standard output of a command that succeeds.
#[track_caller]
fn output(folder: &Path, line: &str) -> String {
    let output = run(folder, line);
    assert_eq!(output.status.code(), Some(0), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Lines of a table without its comments.
fn lines(table: &str) -> Vec<&str> {
    table.lines().filter(|line| !line.starts_with('#')).collect()
}

/// Writes a file of 400 sensors, which need two blocks of pixels, around the middle of the scene.
fn write_points(folder: &Path) {
    let line = |k: u32| format!("{} 0.2 {} 0 1 0\n", f64::from(k % 20) * 0.02, f64::from(k / 20) * 0.02);
    fs::write(folder.join("desk.pts"), (0..400).map(line).collect::<String>()).unwrap();
}

/// The table of the whole is the lines of its shares, whatever the number of threads.
#[test]
fn shares_have_the_lines_of_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_points(folder);
    let whole = output(folder, &format!("sensors {OPTIONS} --points desk.pts"));
    assert_eq!(lines(&whole).len(), 401);
    assert!(whole.contains("# mean ") && whole.contains("# uniformity U0 "), "{}", &whole[..400]);
    let mut of_shares: Vec<&str> = Vec::new();
    let parts = [1, 2]
        .map(|k| output(folder, &format!("sensors {OPTIONS} --points desk.pts --tiles {k}/2 --threads {k}")));
    for part in &parts {
        assert!(!part.contains("# mean"), "a share has no summary");
        let lines = lines(part);
        assert_eq!(lines[0], self::lines(&whole)[0]);
        assert!(lines.len() > 1 && lines.len() < 400);
        of_shares.extend(&lines[1..]);
    }
    of_shares.sort_by_key(|line| line.split(',').next().unwrap().parse::<u32>().unwrap());
    assert_eq!(of_shares, lines(&whole)[1..]);
}

/// The JSON file, the page and the table have the same values.
#[test]
fn files_have_the_values_of_the_table() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let table =
        "name,x,y,z,nx,ny,nz,shape\nwest,0,0.2,0,0,1,0,plane\n\"<b>, east\",0.2,0.2,0,0,1,0,cylinder\n";
    fs::write(folder.join("desk.csv"), table).unwrap();
    let line = "--points desk.csv -o out.csv --html out.html --json out.json";
    let rows = output(folder, &format!("sensors {OPTIONS} {line}"));
    for label in ["mean", "smallest", "uniformity", "out.csv, out.html"] {
        assert!(rows.contains(label), "{label}: {rows}");
    }
    let json: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(folder.join("out.json")).unwrap()).unwrap();
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(folder.join("out.csv")).unwrap();
    let head = reader.headers().unwrap().clone();
    let at = |name: &str| head.iter().position(|column| column == name).unwrap();
    for (record, sensor) in reader.records().zip(json["sensors"].as_array().unwrap()) {
        let record = record.unwrap();
        assert_eq!(record.get(at("name")), sensor["name"].as_str());
        assert_eq!(record.get(at("claim")), Some("calibrated"));
        let lux: f64 = record.get(at("illuminance")).unwrap().parse().unwrap();
        let exact = sensor["illuminance_lx"].as_f64().unwrap();
        assert!(lux > 0.0 && (lux - exact).abs() <= 1e-5 * exact);
        assert!(sensor["half_width_lx"].as_f64().unwrap() <= 0.2 * exact);
    }
    assert_eq!(json["summary"]["sensors"], 2);
    let page = fs::read_to_string(folder.join("out.html")).unwrap();
    assert!(page.contains("<title>west at 0.000 0.200 0.000") && !page.contains("<b>, east"));
    // The comments name the command and the unit.
    let written = fs::read_to_string(folder.join("out.csv")).unwrap();
    assert!(written.starts_with("# tashika sensors builtin:tiny"), "{written}");
    assert!(written.contains("illuminance in lx (photometry scene)"));
}

#[test]
fn daylight_factors_are_relative_to_the_sky() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("roof.pts"), "0 50 0 0 1 0\n").unwrap();
    let line = "sensors builtin:tiny --points roof.pts --daylight-factor --error 10% --vpls 20k";
    let table = output(folder, &format!("{line} --environment cie:overcast,illuminance=8000"));
    let row: Vec<&str> = lines(&table)[1].split(',').collect();
    let factor: f64 = row[row.len() - 2].parse().unwrap();
    assert!((factor - 100.0).abs() < 12.0, "nothing is above the roof: {factor}");
    let refused = run(folder, line);
    let stderr = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(refused.status.code() == Some(2) && stderr.contains("cie:overcast"), "{stderr}");
}

/// Each fault of the input ends the program with its exit code, and the message names the place.
#[test]
fn faults_are_reported_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_points(folder);
    fs::write(folder.join("zero.pts"), "0 0 0 0 1 0\n0 0 0 0 0 0\n").unwrap();
    fs::write(folder.join("nan.pts"), "0 0 nan 0 1 0\n").unwrap();
    fs::write(folder.join("columns.csv"), "x,y,z,lux\n0,0,0,1\n").unwrap();
    fs::write(folder.join("empty.pts"), "").unwrap();
    for (line, code, words) in [
        ("", 2, "--points"),
        ("--points absent.pts", 3, "absent.pts"),
        ("--points zero.pts", 3, "zero.pts:2: a normal of length zero"),
        ("--points nan.pts", 3, "nan.pts:1: z = \"nan\""),
        ("--points columns.csv", 3, "columns.csv:1: column \"lux\"; expected columns x, y, z"),
        ("--points empty.pts", 3, "no sensor"),
        ("--grid floor", 2, "no spacing"),
        ("--grid flor:1", 2, "the name of"),
        ("--points desk.pts --claim audited", 2, "calibrated or certified"),
        ("--points desk.pts --photometry lux", 2, "scene, cie, radiance"),
        ("--points desk.pts -o out.txt", 2, ".csv"),
        ("--points desk.pts --html page.png", 2, ".html"),
        ("--points desk.pts --json -", 2, "-o names a file"),
        ("--points desk.pts --jointly --tiles 1/2", 2, "--jointly"),
        ("--points desk.pts -o desk.pts", 2, ".csv"),
        ("--points columns.csv -o columns.csv", 2, "would be overwritten"),
    ] {
        let output = run(folder, &format!("sensors builtin:tiny {line}"));
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{line}: {stderr}");
        assert!(stderr.contains(words) && !stderr.contains("panicked"), "{line}: {stderr}");
    }
}
