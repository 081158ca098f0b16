//! Images in parts: shares of the tiles on several machines, and their merging.

use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

/// Runs the program in a folder.
fn run(folder: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tashika"));
    command.current_dir(folder).args(line.split_whitespace()).output().unwrap()
}

#[track_caller]
fn succeeds(folder: &Path, line: &str) {
    let output = run(folder, line);
    assert_eq!(output.status.code(), Some(0), "{line}: {}", String::from_utf8_lossy(&output.stderr));
}

#[track_caller]
fn fails(folder: &Path, line: &str, said: &[&str]) {
    let output = run(folder, line);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(3), "{line}: {stderr}");
    for words in said {
        assert!(stderr.contains(words), "{words:?} is not in: {stderr}");
    }
}

const RENDER: &str = "render builtin:tiny --size 70x50 --truth vpl --vpls 200 --gather 2 --error 5%";

#[test]
fn shares_are_merged_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    succeeds(folder, &format!("{RENDER} -o whole.exr -q"));
    // The parts read lights that were traced once; the whole image traces its own. The lights are
    // the same.
    succeeds(folder, "vpl builtin:tiny --vpls 200 -o lights.vpl -q");
    let shared = RENDER.replace("--vpls 200", "--vpl-file lights.vpl");
    for (number, threads) in [(1, 1), (2, 2), (3, 1)] {
        succeeds(folder, &format!("{shared} --tiles {number}/4 --threads {threads} -o part-{number}.exr -q"));
    }
    fails(
        folder,
        "merge part-1.exr part-3.exr part-2.exr -o merged.exr",
        &["of 4 shares these are missing: 4", "--partial"],
    );
    assert!(!folder.join("merged.exr").exists());
    succeeds(folder, "merge part-1.exr part-3.exr part-2.exr -o some.exr --partial");
    succeeds(folder, &format!("{RENDER} --tiles 4,2/4 -o rest.exr -q"));
    for parts in ["part-3.exr rest.exr part-1.exr part-2.exr", "some.exr rest.exr"] {
        succeeds(folder, &format!("merge {parts} -o merged.exr --json merged.json"));
        for ending in ["exr", "png"] {
            let bytes = |name: &str| fs::read(folder.join(format!("{name}.{ending}"))).unwrap();
            assert!(bytes("merged") == bytes("whole"), "{parts}: {ending}");
        }
    }
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.join("merged.json")).unwrap()).unwrap();
    assert_eq!(
        (&json["pixels"], &json["complete"], &json["missing"]),
        (&3500.into(), &true.into(), &serde_json::json!([]))
    );
}

#[test]
fn planes_of_light_groups_are_merged_and_kept_in_checkpoints() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let render = "render builtin:tiny --size 70x50 --method path --paths 4 --groups each -q";
    succeeds(folder, &format!("{render} -o whole.exr --checkpoint"));
    for number in 1..=2 {
        succeeds(folder, &format!("{render} --tiles {number}/2 -o part-{number}.exr"));
    }
    succeeds(folder, "merge part-2.exr part-1.exr -o merged.exr -q");
    let bytes = |name: &str| fs::read(folder.join(name)).unwrap();
    assert!(bytes("merged.exr") == bytes("whole.exr"));
    let film = tashika::io::read_exr(&folder.join("whole.exr")).unwrap();
    assert!(film.planes().iter().any(|plane| plane.name().starts_with("light_")));
    let output = run(folder, "render builtin:tiny --size 8x6 --truth vpl --groups each -o a.exr");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && said.contains("method path"), "{said}");
    // If pixels claim something, the planes of groups use separate paths, whose number is
    // `--paths`.
    let render =
        "render builtin:tiny --size 20x15 --error 50% --vpls 2000 --paths 4 --groups each --accept-budget -q";
    for (options, name) in [("", "all"), ("--tiles 1/2", "one"), ("--tiles 2/2", "two")] {
        let output = run(folder, &format!("{render} {options} -o {name}.exr"));
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success() && !said.contains("paths"), "{said}");
    }
    succeeds(folder, "merge one.exr two.exr -o both.exr -q --accept-budget");
    assert!(bytes("both.exr") == bytes("all.exr"));
}

#[test]
fn layouts_of_files_do_not_enter() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let bytes = |name: &str| fs::read(folder.join(name)).unwrap();
    succeeds(folder, &format!("{RENDER} -o whole.exr -q --exr parts,tiles,piz"));
    succeeds(folder, &format!("{RENDER} --tiles 1/2 -o a.exr -q --exr tiles,none"));
    succeeds(folder, &format!("{RENDER} --tiles 2/2 -o b.exr -q --exr parts"));
    succeeds(folder, "merge a.exr b.exr -o merged.exr -q --exr parts,tiles,piz");
    assert!(bytes("merged.exr") == bytes("whole.exr") && bytes("merged.exr") != bytes("a.exr"));
    succeeds(folder, "merge a.exr b.exr -o plain.exr -q");
    assert!(bytes("plain.exr") != bytes("merged.exr"));
    assert_eq!(
        tashika::io::read_exr(&folder.join("plain.exr")).unwrap(),
        tashika::io::read_exr(&folder.join("merged.exr")).unwrap()
    );
    let output = run(folder, &format!("{RENDER} -o whole.exr -q --exr dwaa"));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && said.contains("keeps all bits"), "{said}");
}

/// An image is rendered with several tone mappings. Only the PNG differs. Merged parts give the
/// same PNG as the whole image.
#[test]
fn tone_mappings_change_the_picture_alone() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let read = |name: &str| fs::read(folder.join(name)).unwrap();
    succeeds(folder, &format!("{RENDER} -o plain.exr -q"));
    succeeds(folder, &format!("{RENDER} --tonemap natural -o natural.exr -q"));
    assert_eq!(read("plain.png"), read("natural.png"), "the default");
    for tone in ["linear", "filmic", "aces", "agx"] {
        succeeds(folder, &format!("{RENDER} --tonemap {tone} -o {tone}.exr --json {tone}.json -q"));
        assert_eq!(read(&format!("{tone}.exr")), read("plain.exr"), "{tone}");
        assert_ne!(read(&format!("{tone}.png")), read("plain.png"), "{tone}");
        let page = String::from_utf8(read(&format!("{tone}.html"))).unwrap();
        assert!(page.contains(&format!("<option selected>{tone}</option>")), "{tone}");
        let told = String::from_utf8(read(&format!("{tone}.json"))).unwrap();
        assert!(told.contains(&format!("\"tonemap\": \"{tone}\"")), "{told}");
    }
    succeeds(folder, &format!("{RENDER} --tiles 1/2 -o 1.exr -q"));
    succeeds(folder, &format!("{RENDER} --tiles 2/2 --tonemap linear -o 2.exr -q"));
    succeeds(folder, "merge 1.exr 2.exr --tonemap agx -o merged.exr -q");
    assert_eq!(read("merged.png"), read("agx.png"));
}

#[test]
fn many_shares_are_small_films_that_merge_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let render = format!("{RENDER} --crop 3,5,60,40 --cryptomatte=4 --motion-vectors -q");
    succeeds(folder, &format!("{render} -o whole.exr"));
    let mut parts = Vec::new();
    for number in 1..=20 {
        let more = if number == 7 { "--audit 5 --checkpoint" } else { "" };
        succeeds(folder, &format!("{render} --tiles {number}/20 -o part-{number}.exr {more}"));
        let part = tashika::io::read_exr(&folder.join(format!("part-{number}.exr"))).unwrap();
        assert!(part.window().area() <= 60 * 40 / 4, "{:?}", part.window());
        parts.push(format!("part-{number}.exr"));
    }
    let all_but_one = parts[1..].join(" ");
    fails(folder, &format!("merge {all_but_one} -o a.exr"), &["of 20 shares these are missing: 1"]);
    parts.reverse();
    succeeds(folder, &format!("merge {} -o merged.exr -q", parts.join(" ")));
    same_as_whole(folder, "merged");
    // A part of another crop is refused.
    succeeds(
        folder,
        &format!("{RENDER} -q --cryptomatte=4 --motion-vectors --crop 3,5,60,41 --tiles 1/20 -o part-1.exr"),
    );
    fails(folder, &format!("merge {} -o a.exr", parts.join(" ")), &["window = 3,5,60,41"]);
}

#[test]
fn parts_of_another_render_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    succeeds(folder, &format!("{RENDER} --tiles 1/2 -o a.exr -q"));
    succeeds(folder, &format!("{RENDER} --seed 2 --tiles 2/2 -o b.exr -q"));
    fails(folder, "merge a.exr b.exr -o c.exr", &["b.exr: ", "expected as in a.exr: ", "seed = "]);
    succeeds(folder, &format!("{RENDER} --filter tent --tiles 2/2 -o d.exr -q --json d.json"));
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.join("d.json")).unwrap()).unwrap();
    assert_eq!(report["filter"], "tent");
    let said = ["d.exr: gather.filter = tent", "expected as in a.exr: gather.filter = box"];
    fails(folder, "merge a.exr d.exr -o c.exr", &said);
    fails(folder, "merge a.exr absent.exr -o c.exr", &["absent.exr"]);
    assert!(!folder.join("c.exr").exists());
}

/// A render that takes some seconds and finishes hundreds of tiles a second.
const LONG: &str =
    "render builtin:tiny --size 160x90 --truth vpl --vpls 2k --gather 16 --error 2% --threads 2 --checkpoint";

/// Begins a render, and kills it once its checkpoint has `bytes` bytes. Returns false if the render
/// finished before.
fn killed(folder: &Path, bytes: u64) -> bool {
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_tashika"))
        .current_dir(folder)
        .args(LONG.split_whitespace())
        .args(["-o", "a.exr", "-q"])
        .spawn()
        .unwrap();
    let length = || fs::metadata(folder.join("a.exr.checkpoint")).map_or(0, |m| m.len());
    while length() < bytes {
        if child.try_wait().unwrap().is_some() {
            return false;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    true
}

/// Asserts that image and PNG have the same bytes as those of the whole render.
#[track_caller]
fn same_as_whole(folder: &Path, name: &str) {
    for ending in ["exr", "png"] {
        let bytes = |name: &str| fs::read(folder.join(format!("{name}.{ending}"))).unwrap();
        assert!(bytes(name) == bytes("whole"), "{name}.{ending}");
    }
}

#[test]
fn a_render_that_was_killed_goes_on_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let checkpoint = folder.join("a.exr.checkpoint");
    let report = |name: &str| -> serde_json::Value {
        serde_json::from_slice(&fs::read(folder.join(name)).unwrap()).unwrap()
    };
    succeeds(folder, &format!("{LONG} -o whole.exr -q --json whole.json"));
    assert!(!folder.join("whole.exr.checkpoint").exists(), "what is written is not kept twice");
    // The render is killed twice, the second time later.
    for bytes in [100_000, 400_000] {
        assert!(killed(folder, bytes), "it was over before it was ended");
        assert!(!folder.join("a.exr").exists());
    }
    fails(
        folder,
        &format!("{LONG} -o a.exr --seed 2"),
        &["a.exr.checkpoint", "seed = \"1\", not \"2\"", "remove it"],
    );
    let said = ["a.exr.checkpoint", "gather.filter = \"box\", not \"tent\"", "remove it"];
    fails(folder, &format!("{LONG} -o a.exr --filter tent"), &said);
    let again = run(folder, &format!("{LONG} -o a.exr --json a.json"));
    let stderr = String::from_utf8_lossy(&again.stderr).into_owned();
    assert!(stderr.contains("going on from a.exr.checkpoint: "), "{stderr}");
    same_as_whole(folder, "a");
    assert!(!checkpoint.exists());
    for key in ["pixels", "promise_met", "rays_per_pixel", "pairs_per_pixel", "mean_radiance", "complete"] {
        assert_eq!(report("a.json")[key], report("whole.json")[key], "{key}");
    }

    // Damage in the middle is reported, and tiles after it are rendered again.
    assert!(killed(folder, 400_000));
    let mut bytes = fs::read(&checkpoint).unwrap();
    bytes[200_000] ^= 1;
    fs::write(&checkpoint, &bytes).unwrap();
    let again = run(folder, &format!("{LONG} -o a.exr"));
    let stderr = String::from_utf8_lossy(&again.stderr).into_owned();
    assert!(stderr.contains("what was lost is rendered again") && stderr.contains("going on"), "{stderr}");
    same_as_whole(folder, "a");
}

/// A limit on the size of files simulates a full disk. Finished tiles stay in the checkpoint, and
/// the render resumes from them.
#[cfg(unix)]
#[test]
fn what_is_finished_survives_a_full_disk() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    succeeds(folder, &format!("{LONG} -o whole.exr -q"));
    let limited = |blocks: u32| {
        let program = env!("CARGO_BIN_EXE_tashika");
        let line = format!("trap '' XFSZ; ulimit -f {blocks}; exec {program} {LONG} -o a.exr");
        std::process::Command::new("sh").current_dir(folder).args(["-c", &line]).output().unwrap()
    };
    // A block has 512 or 1024 bytes, depending on the shell. In both cases the limit is too small
    // for the checkpoint and for the image.
    let output = limited(300);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(3), "{stderr}");
    assert!(stderr.contains("no more tiles are kept, those before are safe"), "{stderr}");
    assert!(!folder.join("a.exr").exists() && folder.join("a.exr.checkpoint").exists());
    let again = run(folder, &format!("{LONG} -o a.exr"));
    let stderr = String::from_utf8_lossy(&again.stderr).into_owned();
    assert!(stderr.contains("going on from a.exr.checkpoint: "), "{stderr}");
    same_as_whole(folder, "a");
}

/// Stand-in for Slurm's `sbatch`. It runs a submitted script at once, and each task of an array
/// once. The second task is first killed halfway and then run again.
#[cfg(unix)]
const SBATCH: &str = r#"#!/bin/sh
set -e
for script; do :; done
tasks=$(sed -n 's/#SBATCH --array=1-//p' "$script")
if [ -z "$tasks" ]; then sh "$script" >&2; else
  for SLURM_ARRAY_TASK_ID in $(seq "$tasks"); do
    export SLURM_ARRAY_TASK_ID
    [ "$SLURM_ARRAY_TASK_ID" != 2 ] || (ulimit -t 1; sh "$script" >&2 || true)
    sh "$script" >&2
  done
fi
echo 7
"#;

/// Runs the job in a folder with the stand-in for Slurm.
#[cfg(unix)]
fn submit(folder: &Path) {
    use std::os::unix::fs::PermissionsExt;
    let sbatch = folder.join("sbatch");
    fs::write(&sbatch, SBATCH).unwrap();
    fs::set_permissions(&sbatch, fs::Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:{}", folder.display(), std::env::var("PATH").unwrap());
    let output = std::process::Command::new(folder.join("job/submit.sh")).env("PATH", path).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[cfg(unix)]
#[test]
fn a_job_for_slurm_gives_the_same_bytes() {
    let folder = tempfile::Builder::new().prefix("it's a job ").tempdir().unwrap();
    let folder = folder.path();
    // Pixels run out of budget. The engine must not take the exit code 4 for a lost worker.
    let render = format!("{RENDER} --max-pairs 3");
    assert_eq!(run(folder, &format!("{render} -o whole.exr -q")).status.code(), Some(4));
    let program = env!("CARGO_BIN_EXE_tashika");
    let line = format!("farm slurm --shares 3 --out job --program {program} -- {render} -o a.exr");
    succeeds(folder, &line);
    submit(folder);
    same_as_whole(folder, "a");
    assert!(folder.join("job/part-3.exr").exists() && !folder.join("job/part-3.exr.checkpoint").exists());
}

/// A job with the default method. The set of VPLs is traced once for all shares.
#[cfg(unix)]
#[test]
fn a_picture_is_shared_with_the_lights_of_one() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let render = "render builtin:tiny --size 40x30 --vpls 20k --clamp 0.03 --max-pairs 150 --filter tent \
                  --accept-budget -q";
    succeeds(folder, &format!("{render} -o whole.exr"));
    let program = env!("CARGO_BIN_EXE_tashika");
    succeeds(folder, &format!("farm slurm --shares 3 --out job --program {program} -- {render} -o a.exr"));
    submit(folder);
    same_as_whole(folder, "a");
    assert!(folder.join("job/lights.vpl").exists());
    let share = fs::read_to_string(folder.join("job/share.sh")).unwrap();
    assert!(share.contains("lights.vpl") && !share.contains("--vpls"), "{share}");
    succeeds(
        folder,
        "merge --accept-budget job/part-1.exr job/part-2.exr job/part-3.exr -o b.exr --json b.json",
    );
    let json: serde_json::Value = serde_json::from_slice(&fs::read(folder.join("b.json")).unwrap()).unwrap();
    assert!(json["budget_hit"].as_u64().unwrap() > 0, "{json}");
}

/// A job for a scene in fog, which is rendered by path tracing. The job has no step that traces
/// lights.
#[cfg(unix)]
#[test]
fn a_scene_in_fog_is_shared_without_lights() {
    const FOG: &str = "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [.02 .02 .02]\n\
        MediumInterface \"\" \"fog\" Camera \"perspective\" WorldBegin\n\
        LightSource \"point\" \"point3 from\" [0 1 2] \"rgb I\" [5 5 5]\n\
        Shape \"sphere\" \"float radius\" 3";
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("fog.pbrt"), FOG).unwrap();
    let render = "render fog.pbrt --size 40x20 --error 50% --max-pairs 64 -q";
    run(folder, &format!("{render} -o whole.exr"));
    let program = env!("CARGO_BIN_EXE_tashika");
    succeeds(folder, &format!("farm slurm --shares 2 --out job --program {program} -- {render} -o a.exr"));
    submit(folder);
    same_as_whole(folder, "a");
    assert!(!folder.join("job/lights.sh").exists());
}

/// A job for an audited picture. The options of the audit are passed to all shares, and the last
/// step audits the picture.
#[cfg(unix)]
#[test]
fn an_audited_picture_is_a_job_too() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let render = "render builtin:tiny --size 70x40 --method path --quality draft --error 50% --share 90% \
                  --assurance 90% --audit 60 -q";
    let program = env!("CARGO_BIN_EXE_tashika");
    let farm = |shares: u32, more: &str| {
        format!("farm slurm --shares {shares} --out job --program {program} -- {render} -o a.exr {more}")
    };
    for (line, said) in [(farm(1, ""), "shares = 1; expected 2 or more"), (farm(2, "--time 5s"), "--time")] {
        let output = run(folder, &line);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && stderr.contains(said), "{stderr}");
    }
    succeeds(folder, &farm(2, ""));
    submit(folder);
    let film = tashika::io::read_exr(&folder.join("a.exr")).unwrap();
    let claim = tashika::film::PictureClaim::of(film.metadata()).unwrap();
    assert!(claim.reached && claim.looks == 1, "{claim}");
    for number in 1..=3 {
        succeeds(folder, &format!("{render} --tiles {number}/3 -o part-{number}.exr"));
    }
    succeeds(folder, "merge part-1.exr part-2.exr part-3.exr -o whole.exr");
    same_as_whole(folder, "a");
}

#[test]
fn a_job_for_render_farms_is_the_lights_the_shares_and_the_merge() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    succeeds(folder, &format!("farm openjd --shares 7 --out job -- {RENDER} --seed 3 -o a.exr"));
    let template: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.join("job/template.json")).unwrap()).unwrap();
    let run_of = |step: usize| {
        template["steps"][step]["script"]["actions"]["onRun"]["args"].as_array().unwrap().clone()
    };
    let words = |step: usize| {
        run_of(step).iter().map(|w| w.as_str().unwrap().to_owned()).collect::<Vec<_>>().join(" ")
    };
    assert!(words(0).starts_with("render builtin:tiny ") && words(0).contains("--vpls 200"), "{}", words(0));
    assert!(words(0).contains("lights.vpl --quiet"), "{}", words(0));
    for part in ["--seed 3", "--tiles {{Task.Param.Share}}/7", "lights.vpl", "part-{{Task.Param.Share}}.exr"]
    {
        assert!(words(1).contains(part), "{part}: {}", words(1));
    }
    assert!(!words(1).contains("--vpls"), "the lights are those of the file: {}", words(1));
    assert_eq!(words(2).matches("part-").count(), 7);
    let range = &template["steps"][1]["parameterSpace"]["taskParameterDefinitions"][0]["range"];
    assert_eq!(
        (range, &template["steps"][2]["dependencies"][0]["dependsOn"]),
        (&"1-7".into(), &"Render".into())
    );
    let refused = |line: &str, said: &str| {
        let output = run(folder, line);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && stderr.contains(said), "{stderr}");
    };
    succeeds(folder, "vpl builtin:tiny --vpls 200 -o own.vpl -q");
    succeeds(folder, "farm openjd --out own -- render builtin:tiny --size 20x10 --vpl-file own.vpl -o b.exr");
    let template = fs::read_to_string(folder.join("own/template.json")).unwrap();
    let own = folder.join("own.vpl");
    assert!(template.contains(own.to_str().unwrap()), "a job runs in a folder of its own: {template}");
    // Files of lights are named by absolute paths, so that other machines find them.
    let lights = "--environment sky.hdr,scale=2 --light=ies:a.ies@1,2,3 --light point:1,2,3,4";
    succeeds(folder, &format!("farm openjd --out lit -- render builtin:tiny {lights} --size 20x10 -o b.exr"));
    let template = fs::read_to_string(folder.join("lit/template.json")).unwrap();
    let here = std::path::absolute(folder).unwrap();
    for named in [
        format!("{}/sky.hdr,scale=2", here.display()),
        format!("ies:{}/a.ies@1,2,3", here.display()),
        "point:1,2,3,4".to_owned(),
    ] {
        assert!(template.contains(&named), "{named} is not in {template}");
    }
    refused("farm openjd --out x -- info", "a job is a render");
    refused("farm openjd --out x -- render --size 4by4", "4by4");
    refused("farm slurm --out x --shares 0 -- render", "shares = 0");
    refused("farm slurm --out x -- render --tiles 1/2", "--tiles");
}

#[test]
fn parts_of_a_scene_that_was_changed_are_refused() {
    const TRIANGLE: &str = "v -1 0 -1\nv -1 0 1\nv 1 0 1\nusemtl a\nmtllib a.mtl\nf 1 2 3\n";
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("a.obj"), TRIANGLE).unwrap();
    fs::write(folder.join("a.mtl"), "newmtl a\nKd 0.5 0.5 0.5\n").unwrap();
    let render = "render a.obj --size 70x50 --truth vpl --vpls 20 --gather 1 -q";
    succeeds(folder, &format!("{render} --tiles 1/2 -o a.exr"));
    succeeds(folder, &format!("{render} --tiles 2/2 -o b.exr"));
    succeeds(folder, "merge a.exr b.exr -o c.exr");
    // The material file of the scene is changed. The number of lights stays the same.
    fs::write(folder.join("a.mtl"), "newmtl a\nKd 0.5 0.5 0.4\n").unwrap();
    succeeds(folder, &format!("{render} --tiles 2/2 -o b.exr"));
    fails(folder, "merge a.exr b.exr -o c.exr", &["b.exr: scene.digest = "]);
}
