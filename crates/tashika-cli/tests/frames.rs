//! Frames of an animation: the scene at the time of each frame, in files named after the frames.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use tashika::color::Rgb;
use tashika::io::read_exr;
use tempfile::TempDir;

/// A white square that moves from `x = 0` to `x = 4` in two seconds, before two cameras.
const SCENE: &str = r#"<scene version="3.0.0">
  <sensor type="orthographic" id="a"><film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="2"/></film>
    <transform name="to_world"><scale x="4"/><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform></sensor>
  <sensor type="orthographic" id="b"><film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/></film>
    <transform name="to_world"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform></sensor>
  <emitter type="constant"/>
  <shape type="rectangle"><animation name="to_world">
    <transform time="0"/><transform time="2"><translate x="4"/></transform></animation></shape>
</scene>"#;

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.xml"), SCENE).unwrap();
    folder
}

fn run(folder: &Path, line: &str) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tashika"));
    let output = command.current_dir(folder).args(line.split_whitespace()).output().unwrap();
    let text = [output.stdout, output.stderr].map(|stream| String::from_utf8(stream).unwrap()).concat();
    (output.status.code(), text)
}

#[track_caller]
fn succeeds(folder: &Path, line: &str) -> String {
    let (code, text) = run(folder, line);
    assert_eq!(code, Some(0), "{line}: {text}");
    text
}

fn bytes(path: PathBuf) -> Vec<u8> {
    fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

const SMALL: &str = "render s.xml --method path --paths 1";

#[test]
fn frames_are_the_scene_at_their_times_in_files_of_their_numbers() {
    let folder = folder();
    let folder = folder.path();
    let told = succeeds(folder, &format!("{SMALL} --frames 9..11 --fps 10 -o walk.exr --json n.json"));
    let mut expected: BTreeSet<String> = ["s.xml".to_owned()].into();
    for number in ["0009", "0010", "0011"] {
        expected.extend(["exr", "png", "html"].map(|ending| format!("walk-{number}.{ending}")));
        expected.insert(format!("n-{number}.json"));
        assert!(told.contains(&format!("walk-{number}.exr")), "{told}");
    }
    let found = fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    assert_eq!(found.collect::<BTreeSet<_>>(), expected);
    let json: serde_json::Value = serde_json::from_slice(&bytes(folder.join("n-0011.json"))).unwrap();
    assert_eq!(json["time_seconds"], 1.1);
    // Each file has the same bytes as a render with `--at`.
    for (number, at) in [("0009", "0.9"), ("0010", "1"), ("0011", "1.1")] {
        succeeds(folder, &format!("{SMALL} --at {at} -o alone.exr -q"));
        assert!(bytes(folder.join("alone.exr")) == bytes(folder.join(format!("walk-{number}.exr"))), "{at}");
    }
    assert_ne!(bytes(folder.join("walk-0009.exr")), bytes(folder.join("walk-0011.exr")));
    let film = read_exr(&folder.join("walk-0009.exr")).unwrap();
    assert_eq!(film.metadata().number("scene.time"), Some(0.9));
    // Parts of pictures at different times are not joined.
    for (tiles, at) in [("1/2", "1"), ("2/2", "1.1")] {
        succeeds(folder, &format!("{SMALL} --size 64x64 --at {at} --tiles {tiles} -o {at}.exr -q"));
    }
    let (code, text) = run(folder, "merge 1.exr 1.1.exr -o m.exr");
    assert!(code == Some(3) && text.contains("scene.digest"), "{text}");
}

#[test]
fn frames_of_several_cameras_are_named_after_both_and_24_a_second() {
    let folder = folder();
    let folder = folder.path();
    succeeds(folder, &format!("{SMALL} --frames 12..12 --camera b,a -o v.exr -q"));
    for camera in ["a", "b"] {
        let film = read_exr(&folder.join(format!("v-{camera}-0012.exr"))).unwrap();
        assert_eq!(film.metadata().number("scene.time"), Some(0.5));
        assert_eq!(film.metadata().text("camera"), Some(camera));
    }
}

#[test]
fn what_goes_with_one_frame_is_refused_for_several() {
    let folder = folder();
    let folder = folder.path();
    for (line, said) in [
        ("render s.xml --frames 3..1", "1..48"),
        ("render s.xml --frames 1..3 --at 1", "cannot be used with"),
        ("render s.xml --fps 30", "--frames"),
        ("render s.xml --frames 1..2 --fps 0", "--fps = 0; expected frames a second, above 0"),
        ("render s.xml --at nan", "--at = NaN; expected a finite number of seconds"),
        (
            "render s.xml --frames 1..2 --checkpoint",
            "--frames = 1..2; expected --at, for one frame, with --checkpoint",
        ),
        ("render s.xml --frames 1..2 --vpl-file a.vpl", "with --vpl-file"),
        ("farm slurm --out job -- render s.xml --frames 1..2", "one frame of a job"),
        ("render s.xml --shutter 2,1", "such as 0,0.02"),
        ("vpl a.vpl --shutter 0,1", "--shutter is for tracing a scene"),
        ("vpl a.vpl --at 1", "--at is for tracing a scene"),
    ] {
        let (code, text) = run(folder, line);
        assert!(code == Some(2) && text.contains(said), "{line}: {text}");
    }
}

#[test]
fn cameras_are_blurred_while_the_shutter_is_open() {
    let folder = folder();
    let folder = folder.path();
    let scene = SCENE.replace(
        r#"<transform name="to_world"><scale x="4"/><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>"#,
        r#"<animation name="to_world">
          <transform time="0"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
          <transform time="2"><lookat origin="4,0,5" target="4,0,0" up="0,1,0"/></transform></animation>"#,
    );
    assert_ne!(scene, SCENE);
    fs::write(folder.join("s.xml"), scene).unwrap();
    let told = succeeds(folder, &format!("{SMALL} --at 1 --shutter -0.25,0.5 --json n.json -o b.exr"));
    assert!(told.contains("with its shutter open from 0.7500 to 1.5000 s"), "{told}");
    assert!(!told.contains("animations: shown"), "{told}");
    let json: serde_json::Value = serde_json::from_slice(&bytes(folder.join("n.json"))).unwrap();
    assert_eq!(json["shutter_seconds"], serde_json::json!([0.75, 1.5]));
    assert_eq!(json["time_seconds"], 1.125);
    let film = read_exr(&folder.join("b.exr")).unwrap();
    assert_eq!(film.metadata().text("camera.shutter"), Some("0.75,1.5"));
    // Shutter times are relative to the time of each frame.
    succeeds(folder, &format!("{SMALL} --frames 1..1 --fps 1 --shutter -0.25,0.5 -o f.exr -q"));
    assert!(bytes(folder.join("f-0001.exr")) == bytes(folder.join("b.exr")));
    let told = succeeds(folder, "info s.xml --shutter 0,1");
    assert!(
        told.contains("a: 8x2") && told.contains("moves with its shutter open from 0.0000 to 1.0000 s"),
        "{told}"
    );
    assert!(
        told.contains(
            "the shutter open from 0.0000 to 1.0000 s: rendered by path tracing, or as a sum over VPLs"
        ),
        "{told}"
    );
    let still = succeeds(folder, &format!("{SMALL} --at 1 -o s.exr"));
    assert!(!still.contains("shutter"), "{still}");
    // The shape moves while the shutter is open. The default is then path tracing; a sum needs
    // several instants.
    assert_eq!(film.metadata().text("method"), Some("path"));
    succeeds(folder, "render s.xml --shutter 0,1 --method mdlc --vpls 200 --instants 4 -o m.exr");
    let film = read_exr(&folder.join("m.exr")).unwrap();
    assert_eq!(film.metadata().text("method"), Some("mdlc"));
    assert_eq!(film.metadata().number("vpls.instants"), Some(4.0));
    let told = succeeds(folder, "vpl s.xml --shutter 0,1 --vpls 200 --instants 4");
    assert!(told.contains("4, each with lights of its own"), "{told}");
    let (code, said) = run(folder, "render s.xml --shutter 0,1 --method mdlc --instants 0 -o m.exr");
    assert!(code == Some(2) && said.contains("instants"), "{said}");
}

#[test]
fn info_says_when_a_scene_moves() {
    let folder = folder();
    let folder = folder.path();
    let told = succeeds(folder, "info s.xml --at 1.5 --json i.json");
    assert!(told.contains("from 0.000 to 2.000 s; shown at 1.500 s"), "{told}");
    let json: serde_json::Value = serde_json::from_slice(&bytes(folder.join("i.json"))).unwrap();
    assert_eq!(json["animated_seconds"], serde_json::json!([0.0, 2.0]));
    assert_eq!(json["bounds"][1][0], 4.0);
    let told = succeeds(folder, "info s.xml");
    assert!(
        told.contains("shown without a time (--at)") && told.contains("the first key is shown"),
        "{told}"
    );
    assert!(!succeeds(folder, "info builtin:tiny --at 3").contains("moves"));
}

/// A square that is hidden from frame 12 to frame 20, under a sky.
const HIDDEN: &str = r#"#usda 1.0
( timeCodesPerSecond = 24
 metersPerUnit = 1 )
def Camera "cam" { double3 xformOp:translate = (0, 0, 8)
 uniform token[] xformOpOrder = ["xformOp:translate"] }
def Mesh "q" {
 point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
 int[] faceVertexCounts = [4]
 int[] faceVertexIndices = [0, 1, 2, 3]
 token visibility.timeSamples = { 0: "inherited", 12: "invisible", 20: "inherited" } }
def DomeLight "d" { }
"#;

#[test]
fn frames_without_anything_visible_show_the_background() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("h.usda"), HIDDEN).unwrap();
    // Path tracing, a sum over VPLs, and an audited picture.
    for way in ["--method path --paths 1", "--method exact --vpls 10", "--quality draft --share 50%"] {
        succeeds(folder, &format!("render h.usda {way} --size 4x4 --frames 11..20 --fps 24 -o w.exr"));
        for number in [12, 19] {
            let film = read_exr(&folder.join(format!("w-{number:04}.exr"))).unwrap();
            assert!(film.colors().unwrap().all(|color| color == Rgb::WHITE), "{way}: {number}");
        }
        let film = read_exr(&folder.join("w-0011.exr")).unwrap();
        assert!(film.colors().unwrap().any(|color| color.r < 0.9), "{way}");
    }
    let (code, text) = run(folder, "render h.usda --method path --paths 1 --size 4x4 --at 0.6 -o a.exr");
    assert_eq!(code, Some(0), "{text}");
}
