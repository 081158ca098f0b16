//! The program end to end, from its command line to its files.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::shell::{Outcome, Shell};

/// Number of pixels of the picture.
const PIXELS: u64 = 96 * 54;

/// Runs `render`, `info`, `vpl`, and commands that must be refused; returns the folder with the
/// files.
pub fn check(shell: &Shell, program: &Path) -> Outcome<PathBuf> {
    let room = shell.folder("room")?;
    for line in [
        "render --size 96x54 --truth vpl --vpls 500 --gather 1 --json render.json",
        "render builtin:tiny --method path --paths 4 --size 32x32 --quiet -o path.exr",
        "info --json info.json",
        "vpl --vpls 500 -o lights.vpl --json vpl.json",
        "render --size 96x54 --vpl-file lights.vpl --gather 1 --threads 1 -o again.exr --quiet",
    ] {
        shell.command(program, line).within(&room).run()?;
    }
    for (name, magic) in [
        ("render.exr", &b"\x76\x2f\x31\x01"[..]),
        ("render.png", b"\x89PNG"),
        ("path.exr", b"\x76\x2f\x31\x01"),
        ("lights.vpl", b"TASHIKAV"),
    ] {
        let bytes = read(&room, name)?;
        ensure(bytes.starts_with(magic) && bytes.len() > 1000, || format!("{name} is no such file"))?;
    }
    report(&json(&room, "render.json")?)?;
    for name in ["info.json", "vpl.json"] {
        ensure(json(&room, name)?.is_object(), || format!("{name} tells nothing"))?;
    }
    // The second render uses the same lights, from a file, and one thread. Its picture must be the
    // same, bit by bit.
    let same = read(&room, "render.png")? == read(&room, "again.png")?;
    ensure(same, || "threads or files changed the picture".to_owned())?;
    refusals(shell, program, &room)?;
    Ok(room)
}

/// Checks the summary of a render for scripts.
fn report(told: &Value) -> Outcome<()> {
    let keys = [
        "pixels",
        "tally",
        "promise_met",
        "budget_hit",
        "rays_per_pixel",
        "pairs_per_pixel",
        "seconds",
        "audit",
    ];
    for key in keys {
        ensure(told.get(key).is_some(), || format!("render.json has no {key}"))?;
    }
    for key in ["load", "vpls", "trees", "render"] {
        ensure(told["seconds"][key].is_number(), || format!("render.json has no seconds of {key}"))?;
    }
    let count = |value: &Value| value.as_u64().unwrap_or(u64::MAX);
    let tally = &told["tally"];
    let claiming = count(&tally["exact"]).saturating_add(count(&tally["calibrated"]));
    ensure(count(&told["pixels"]) == PIXELS && claiming == PIXELS, || format!("not all claim: {tally}"))?;
    ensure(count(&tally["out_of_budget"]) == 0, || format!("some ran out of budget: {tally}"))?;
    let by_old_names = [count(&told["promise_met"]), count(&told["budget_hit"])];
    ensure(by_old_names == [PIXELS, 0], || format!("old names: {by_old_names:?}"))
}

/// Checks the exit codes of a missing scene and of a wrong option, and that the missing file is
/// named.
fn refusals(shell: &Shell, program: &Path, room: &Path) -> Outcome<()> {
    let absent = shell.command(program, "render absent.glb -o absent.exr").within(room);
    let (code, said) = absent.ended()?;
    ensure(code == Some(3), || format!("a missing scene gave exit code {code:?}, expected 3"))?;
    ensure(said.contains("absent.glb"), || format!("the missing file is not named: {said}"))?;
    let (code, _) = shell.command(program, "render --size 96by54").within(room).ended()?;
    ensure(code == Some(2), || format!("a wrong option gave exit code {code:?}, expected 2"))
}

fn read(folder: &Path, name: &str) -> Outcome<Vec<u8>> {
    fs::read(folder.join(name)).map_err(|e| format!("{name}: {e}"))
}

fn json(folder: &Path, name: &str) -> Outcome<Value> {
    serde_json::from_slice(&read(folder, name)?).map_err(|e| format!("{name}: {e}"))
}

fn ensure(holds: bool, else_say: impl FnOnce() -> String) -> Outcome<()> {
    if holds { Ok(()) } else { Err(else_say()) }
}
