//! The program as a user runs it: output, files and exit codes.

use std::fs;
use std::path::PathBuf;

use assert_cmd::Command;
use serde_json::Value;
use tashika::film::Film;
use tashika::io::read_exr;
use tempfile::TempDir;

/// A floor under a square light: 4 triangles, in the default view.
const OBJ: &str = "\
mtllib scene.mtl
v -1 0 -1
v -1 0 1
v 1 0 1
v 1 0 -1
v -0.3 1.5 -0.3
v 0.3 1.5 -0.3
v 0.3 1.5 0.3
v -0.3 1.5 0.3
usemtl white
f 1 2 3 4
usemtl light
f 5 6 7 8
";

const MTL: &str = "\
newmtl white
Kd 0.7 0.7 0.7
newmtl light
Kd 0 0 0
Ke 5 5 5
";

/// A folder with the scene above.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("scene.obj"), OBJ).unwrap();
        fs::write(folder.path().join("scene.mtl"), MTL).unwrap();
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs the program in the folder.
    fn run(&self, line: &str) -> Run {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tashika"));
        let output = command.current_dir(self.0.path()).args(line.split_whitespace()).output().unwrap();
        Run {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    fn film(&self, name: &str) -> Film {
        read_exr(&self.path(name)).unwrap()
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&fs::read(self.path(name)).unwrap()).unwrap()
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(self.0.path())
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

struct Run {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Run {
    /// Asserts that the run failed with this code and printed these words.
    #[track_caller]
    fn fails(&self, code: i32, said: &[&str]) {
        assert_eq!(self.code, Some(code), "{}", self.stderr);
        for words in said {
            assert!(self.stderr.contains(words), "{words:?} is not in: {}", self.stderr);
        }
    }

    #[track_caller]
    fn succeeds(&self) -> &Self {
        assert_eq!(self.code, Some(0), "{}", self.stderr);
        self
    }
}

/// Returns true for each pixel that was rendered, by the plane `stop`.
fn rendered(film: &Film) -> Vec<bool> {
    film.plane("stop").unwrap().u32_samples().unwrap().iter().map(|&reason| reason != 0).collect()
}

#[test]
fn help_names_every_command_and_has_examples() {
    let folder = Folder::new();
    let help = folder.run("--help");
    for words in ["render", "info", "vpl", "compare", "coverage", "experiment", "Exit codes"] {
        assert!(help.succeeds().stdout.contains(words), "{words}");
    }
    let help = folder.run("render --help");
    for words in ["--vpl-file", "--exposure", "--tonemap", "Examples:", "[default: tashika]"] {
        assert!(help.succeeds().stdout.contains(words), "{words}");
    }
    assert_eq!(folder.run("").code, Some(2), "no command is a usage error");
}

#[test]
fn typing_errors_are_answered_with_what_would_be_accepted() {
    let folder = Folder::new();
    folder.run("render --gathr 4").fails(2, &["'--gathr'", "'--gather'"]);
    folder.run("rendr").fails(2, &["'render'"]);
    folder.run("render --method pth").fails(2, &["'pth'", "'path'"]);
    folder.run("render --size 12").fails(2, &["'12'", "--size", "640x480"]);
    folder.run("render --gather 0").fails(2, &["--gather = 0; expected 1 to 1024"]);
    folder
        .run("render --filter mitchell")
        .fails(2, &["'mitchell'", "--filter", "tent or gaussian or blackman"]);
    folder.run("render --vpls ten").fails(2, &["'ten'", "--vpls", "55k"]);
    folder.run("render --clamp -1").fails(2, &["--clamp = -1; expected"]);
    folder.run("render --tonemap sepia").fails(2, &["'sepia'", "natural, linear, filmic, aces, agx"]);
    folder.run("render --tiles 3/2").fails(2, &["'3/2'", "K from 1 to N"]);
    folder.run("render --size 9x9 --crop 0,0,10,9").fails(2, &["--crop = 0,0,10,9", "9x9"]);
    folder.run("render --vpls 5 --vpl-file a.vpl").fails(2, &["--vpls", "--vpl-file", "cannot be used"]);
    folder.run("render -o picture.png").fails(2, &["--output = picture.png", ".exr"]);
    folder.run("render scene.obj --camera top").fails(2, &["--camera = top; expected one of"]);
    folder.run("render builtin:hall").fails(2, &["error: scene = builtin:hall; expected builtin:room"]);
    folder.run("render --no-browser").fails(2, &["go with --serve"]);
    folder.run("render --serve --no-browser --quiet").fails(2, &["--quiet would leave nobody", "--log-file"]);
    folder.run("view a.exr --no-browser --quiet").fails(2, &["--quiet would leave nobody", "--json"]);
    assert_eq!(folder.names(), ["scene.mtl", "scene.obj"], "nothing was written");
}

#[test]
fn unusable_files_are_named() {
    let folder = Folder::new();
    folder.run("render none.obj").fails(3, &["none.obj"]);
    folder.run("render scene.mtl").fails(3, &["scene.mtl", "mtl"]);
    folder.run("info none.glb").fails(3, &["none.glb"]);
    folder.run("vpl scene.vpl").fails(3, &["scene.vpl"]);
    fs::write(folder.path("bad.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n").unwrap();
    let run = folder.run("render bad.obj --strict");
    run.fails(3, &["bad.obj:4"]);
}

#[test]
fn outputs_are_tried_before_anything_is_rendered() {
    let folder = Folder::new();
    let run = folder.run("render scene.obj -o none/a.exr");
    run.fails(3, &["none/a.exr", "no folder none"]);
    assert!(!run.stderr.contains("reading"), "it had begun: {}", run.stderr);
    folder.run("render scene.obj --json .").fails(3, &["is a folder"]);
    folder.run("render scene.obj -o a.exr --json a.exr").fails(2, &["a.exr would be written twice"]);
    folder.run("render scene.obj --json scene.obj").fails(2, &["scene.obj is an input"]);
    assert_eq!(folder.names(), ["scene.mtl", "scene.obj"], "no trace of the trial");
}

#[test]
fn a_render_writes_image_picture_and_numbers() {
    let folder = Folder::new();
    let run =
        folder.run("render scene.obj --size 12x8 --crop 2,1,9,5 --vpls 60 --gather 2 --seed 5 --json a.json");
    assert_eq!(
        folder.names(),
        ["a.json", "render.exr", "render.html", "render.png", "scene.mtl", "scene.obj"]
    );
    for words in ["4 triangles", "paths alone", "45", "render.exr, render.png"] {
        assert!(run.succeeds().stdout.contains(words), "{words:?} is not in: {}", run.stdout);
    }
    let film = folder.film("render.exr");
    assert_eq!((film.size(), film.window().area()), ([12, 8], 45));
    let metadata = film.metadata();
    assert_eq!((metadata.number("seed"), metadata.bool("complete")), (Some(5.0), Some(true)));
    let png = fs::read(folder.path("render.png")).unwrap();
    assert_eq!(png[16..24], [0, 0, 0, 9, 0, 0, 0, 5], "width and height of the PNG header");

    let json = folder.json("a.json");
    // By default, an audited picture of light transport is rendered.
    let [pixels, kept, out] = ["pixels", "promise_met", "budget_hit"].map(|key| json[key].as_u64().unwrap());
    assert_eq!((pixels, &json["truth"]), (45, &"transport".into()));
    assert!((1..=45).contains(&(kept + out)), "{kept} {out}");
    assert_eq!(json["picture_claim"]["error"].as_f64(), Some(0.1));
    assert!(json["audit"].is_null() && json["complete"] == Value::Bool(true));
    let sum_of_rays: f64 =
        film.plane("rays").unwrap().f32_samples().unwrap().iter().map(|r| f64::from(*r)).sum();
    assert!(sum_of_rays > 0.0);
    // A number written as a decimal may be read back with a different last bit.
    let told = 45.0 * json["rays_per_pixel"].as_f64().unwrap();
    assert!((told - sum_of_rays).abs() < 1e-9 * sum_of_rays, "{told} rays, {sum_of_rays}");
    assert!(json["pairs_per_pixel"].as_f64().unwrap() > 0.0);
    for part in ["load", "vpls", "trees", "render"] {
        assert!(json["seconds"][part].is_number(), "{part}");
    }
}

#[test]
fn an_audit_says_what_was_kept() {
    let folder = Folder::new();
    let stage = "render builtin:tiny --size 24x16 --truth vpl --vpls 300 --gather 2 --error 5%";
    let run = folder.run(&format!("{stage} --audit 60 --json a.json"));
    assert!(run.succeeds().stdout.contains("of 60 pixels at random are within the error"), "{}", run.stdout);
    let audit = folder.json("a.json")["audit"].clone();
    let number = |key: &str| audit[key].as_f64().unwrap();
    assert_eq!(number("of"), 60.0);
    assert!(number("kept") >= 54.0 && audit["contradicts"] == false, "{audit}");
    assert!(number("low") <= number("kept") / 60.0 && number("kept") / 60.0 <= number("high"));
    let kept = folder.film("render.exr").metadata().number("audit.kept");
    assert_eq!(kept, Some(number("kept")));

    folder.run(&format!("{stage} --crop 3,2,9,7 --audit 99 --json c.json")).succeeds();
    assert_eq!(folder.json("c.json")["audit"]["of"], 63, "all pixels of the part");

    // With a largest cut of 2 pairs, errors are large, but no pixel claims anything.
    let run = folder.run(&format!("{stage} --audit 60 --max-pairs 2 --json b.json"));
    assert_eq!(run.code, Some(4), "{}", run.stderr);
    let audit = folder.json("b.json")["audit"].clone();
    assert!(audit["within"].as_u64().unwrap() < 54, "{audit}");
    assert!(audit["contradicts"] == false && audit["claiming"].as_u64().unwrap() < 30, "{audit}");
    assert_eq!(audit["claiming_within"], audit["claiming"]);
    // With the published rule, the claims of 16 of 384 pixels are false.
    let published = "render builtin:tiny --size 24x16 --truth vpl --vpls 3000 --gather 64 --error 10%";
    let rule = "--method iwasaki2019 --confidence 99% --audit 384 --json d.json";
    let run = folder.run(&format!("{published} {rule}"));
    assert_eq!(run.code, Some(5), "{}", run.stderr);
    assert_eq!(folder.json("d.json")["audit"]["contradicts"], true);
    let exact = "render builtin:tiny --size 8x6 --vpls 200 --method exact --audit 9";
    folder.run(exact).fails(2, &["--audit = 9", "none with method exact"]);
}

/// With a claim about a sum, the program also prints how much another set of lights would change
/// the pixels. This change is larger with few lights than with many.
#[test]
fn a_promise_about_one_set_of_lights_says_what_another_would_change() {
    let folder = Folder::new();
    let differences = |options: &str| {
        let run = folder
            .run(&format!("render builtin:tiny --size 24x18 --truth vpl --error 2% {options} --json a.json"));
        run.succeeds();
        let other = folder.json("a.json")["other_set"].clone();
        let told = run.stdout.contains("as many others change a pixel by");
        assert_eq!(told, !other.is_null(), "{}", run.stdout);
        (!other.is_null()).then(|| {
            assert_eq!(other["pixels"], 64);
            ["median", "one_in_ten"].map(|key| other[key].as_f64().unwrap())
        })
    };
    let few = differences("--vpls 100").unwrap();
    let many = differences("--vpls 20k").unwrap();
    assert!(few[0] > 2.0 * many[0] && few[1] > 2.0 * many[1], "{few:?} {many:?}");
    assert!(many[0] > 0.0 && many[0] < many[1], "another set has other lights: {many:?}");
    assert!(few[1] > 0.1, "of a hundred lights each matters: {few:?}");
    folder.run("vpl builtin:tiny --vpls 100 -o a.vpl").succeeds();
    for without in ["--vpl-file a.vpl", "--vpls 100 --tiles 1/2"] {
        assert!(differences(without).is_none(), "{without}");
    }
}

#[test]
fn light_transport_is_promised_and_audited() {
    let folder = Folder::new();
    let stage = "render builtin:tiny --size 12x8 --truth transport --vpls 20k --gather 16 --error 20%";
    let run = folder.run(&format!("{stage} --audit 40 --json a.json"));
    assert!([Some(0), Some(4)].contains(&run.code), "{}", run.stderr);
    assert!(run.stderr.contains("audit by path"), "{}", run.stderr);
    assert!(run.stdout.contains("light transport"), "{}", run.stdout);
    let json = folder.json("a.json");
    assert_eq!(json["truth"], "transport");
    let audit = &json["audit"];
    // Pixels whose truth is too uncertain are not counted in `of`.
    assert!(audit["of"].as_u64() > Some(30) && audit["contradicts"] == false, "{audit}");
    assert!(json["error_budget"]["compensation"].as_f64() > Some(0.0), "{}", json["error_budget"]);
    let film = folder.film("render.exr");
    assert_eq!(film.metadata().text("truth"), Some("transport"));
    assert_eq!(film.plane("half_width_parts").unwrap().channels().len(), 3);

    for (more, answer) in [
        ("transport --claim certified", "--claim = certified; expected calibrated with truth transport"),
        ("transport --vpls 0", "1 to 100000000"),
        ("light", "expected vpl or clamped or transport"),
    ] {
        let run = folder.run(&format!("render builtin:tiny --truth {more}"));
        assert!(run.code == Some(2) && run.stderr.contains(answer), "{more}: {}", run.stderr);
    }
    let run = folder.run("render builtin:tiny --size 6x4 --method path --error 30% --json p.json");
    run.succeeds();
    assert_eq!(folder.json("p.json")["truth"], "transport");
}

#[test]
fn light_transport_is_measured_against_a_path_tracer() {
    let folder = Folder::new();
    let command =
        "experiment transport builtin:tiny --size 20x12 --pixels 20 --error 10%,20% --vpls 20k --gather 16";
    let run = folder.run(&format!("{command} --out . --paths 20k"));
    let rows = folder.json("table.json");
    let methods: Vec<_> = rows.as_array().unwrap().iter().map(|r| r["method"].as_str().unwrap()).collect();
    assert_eq!(methods, ["tashika", "tashika", "path", "path"], "{}", run.succeeds().stdout);
    for row in rows.as_array().unwrap() {
        assert!(row["pixels"].as_u64() > Some(10) && row["within_tolerance"].as_f64() > Some(0.6), "{row}");
    }
    // The truth was written to a file; a second run reads it.
    let again = folder.run(&format!("{command} --out again --paths 20k --reference reference.exr"));
    again.succeeds();
    for (a, b) in folder.json("again/table.json").as_array().unwrap().iter().zip(rows.as_array().unwrap()) {
        assert_eq!(a["within_tolerance"], b["within_tolerance"]);
    }
    // Two seeds have separate lights; their intervals are compared with each other.
    let seeds =
        folder.run(&format!("{command} --out seeds --methods tashika --seeds 2 --reference reference.exr"));
    assert!(
        seeds.succeeds().stdout.contains("pairs of claims of two seeds are disjoint"),
        "{}",
        seeds.stdout
    );
    assert_eq!(folder.json("seeds/table.json")[0]["seeds"], 2);
    let film = |name: &str| fs::read(folder.path(&format!("seeds/tashika-0.1{name}.exr"))).unwrap();
    assert!(film("") != film("-2"));
    let none = folder.run(&format!("{command} --out none --seeds 0"));
    assert!(none.code == Some(2) && none.stderr.contains("1 or more"), "{}", none.stderr);
}

#[test]
fn quiet_is_silent() {
    let folder = Folder::new();
    let run = folder.run("render scene.obj --size 2x2 --truth vpl --vpls 5 -q");
    assert_eq!((&*run.succeeds().stdout, &*run.stderr), ("", ""));
}

#[test]
fn threads_do_not_change_a_byte() {
    let folder = Folder::new();
    for (name, options) in [("exact", "--method exact"), ("picture", "--passes 1"), ("path", "--method path")]
    {
        for threads in [1, 2] {
            let file = format!("{name}{threads}.exr");
            folder
                .run(&format!("render scene.obj --size 70x9 {options} --threads {threads} -o {file}"))
                .succeeds();
        }
        let bytes = |n| fs::read(folder.path(&format!("{name}{n}.exr"))).unwrap();
        assert!(bytes(1) == bytes(2), "{name}");
    }
}

#[test]
fn lights_are_shared_by_a_file() {
    let folder = Folder::new();
    let traced = folder.run("vpl scene.obj --vpls 80 --seed 9 -o lights.vpl --json traced.json");
    assert!(traced.succeeds().stdout.contains("lights.vpl"));
    let told = folder.run("vpl lights.vpl --json told.json");
    told.succeeds();
    let (traced, told) = (folder.json("traced.json"), folder.json("told.json"));
    assert_eq!((&traced["count"], &traced["provenance"]), (&told["count"], &told["provenance"]));
    assert_eq!(told["provenance"]["seed"], 9);
    folder.run("vpl lights.vpl --vpls 5").fails(2, &["--vpls is for tracing", "lights.vpl"]);

    let common = "render scene.obj --size 6x6 --truth vpl --gather 1 --seed 9";
    folder.run(&format!("{common} --vpls 80 -o own.exr")).succeeds();
    folder.run(&format!("{common} --vpl-file lights.vpl -o file.exr")).succeeds();
    assert_eq!(folder.film("own.exr"), folder.film("file.exr"));
    // With `--truth transport`, the same lights are a sample of all possible lights.
    let command = "render scene.obj --size 6x6 --truth transport --max-pairs 200 --vpl-file lights.vpl";
    folder.run(&format!("{command} --accept-budget -o transport.exr --json t.json")).succeeds();
    let json = folder.json("t.json");
    assert_eq!((&json["truth"], &json["lights"]["count"]), (&"transport".into(), &told["count"]));
    assert_eq!(json["lights"]["file"], "lights.vpl");
    assert_ne!(folder.film("transport.exr").plane(""), folder.film("file.exr").plane(""));
    folder.run(&format!("{common} --vpl-file scene.mtl")).fails(3, &["scene.mtl", "VPL file"]);
    let other = folder.run("render builtin:tiny --size 2x2 --vpl-file lights.vpl");
    assert!(other.succeeds().stderr.contains("not in tiny"), "{}", other.stderr);
}

#[test]
fn info_counts_what_is_there() {
    let folder = Folder::new();
    let run = folder.run("info scene.obj --json info.json");
    for words in ["Wavefront OBJ", "4 stored, 4 instanced", "(2 triangles)"] {
        assert!(run.succeeds().stdout.contains(words), "{words:?} is not in: {}", run.stdout);
    }
    let json = folder.json("info.json");
    assert_eq!(json["triangles"]["stored"], 4);
    assert_eq!(json["emitters"]["area_triangles"], 2);
    assert_eq!(json["materials"]["count"], 2);
    assert_eq!(json["bounds"][1][1], 1.5);
    assert!(folder.run("info builtin:tiny").succeeds().stdout.contains("36 stored"));
}

/// Scenes with media: `info` lists them; they render by paths, or by VPLs if requested.
#[test]
fn media_are_told_and_rendered_by_paths_and_as_sums() {
    let folder = Folder::new();
    let fog = "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [.1 .2 .3]\n\
        MediumInterface \"\" \"fog\" Camera \"perspective\" WorldBegin\n\
        LightSource \"point\" Translate 0 0 2 Shape \"disk\"\n";
    fs::write(folder.path("fog.pbrt"), fog).unwrap();
    let info = folder.run("info fog.pbrt --json info.json");
    for words in [
        "fog: absorption 0.0011",
        "scattering 0.1000 0.2000 0.3000 per metre",
        "in fog",
        "rendered by path tracing, or by VPLs where the truth is named (--truth)",
    ] {
        assert!(info.succeeds().stdout.contains(words), "{words:?} is not in: {}", info.stdout);
    }
    let json = folder.json("info.json");
    assert_eq!((&json["has_media"], &json["cameras"][0]["medium"]), (&true.into(), &"fog".into()));
    assert_eq!(json["media"][0]["asymmetry"], 0.0);
    let small = "render fog.pbrt --size 4x4 -o fog.exr";
    folder.run("vpl fog.pbrt --vpls 300 -o fog.vpl --json vpl.json").succeeds();
    assert!(folder.json("vpl.json")["kinds"]["volume"].as_u64().unwrap() > 100);
    folder.run(&format!("{small} --truth transport --vpl-file fog.vpl --max-pairs 500 --json vpls.json"));
    let json = folder.json("vpls.json");
    assert_eq!((&json["method"], &json["truth"]), (&"tashika".into(), &"transport".into()));
    for method in ["exact", "mdlc"] {
        folder.run(&format!("{small} --method {method} --vpl-file fog.vpl")).succeeds();
    }
    let image = folder.run(&format!("{small} --paths 4 --vpls 100"));
    assert!(!image.succeeds().stderr.contains("--paths means"), "{}", image.stderr);
    assert!(image.stderr.contains("--vpls means nothing to method path"), "{}", image.stderr);
    assert!(image.stdout.contains("4 paths a pixel") && !image.stdout.contains("truth"), "{}", image.stdout);
    let lit = fog.replace("\"point\"", "\"point\" \"point3 from\" [0 3 1]");
    fs::write(folder.path("lit.pbrt"), lit).unwrap();
    let audited =
        folder.run("render lit.pbrt --size 4x4 --error 50% --absolute 10 --audit 9 --json audited.json");
    let said = &audited.succeeds().stdout;
    assert!(said.contains("of 9 pixels at random are within the error"), "{said}");
    assert_eq!(folder.json("audited.json")["audit"]["of"], 9);
    let nothing = folder.run(&format!("{small} --paths 4 --audit 9"));
    assert!(nothing.succeeds().stderr.contains("--audit means nothing to method path"), "{}", nothing.stderr);
    folder.run(&format!("{small} --quality draft --error 100% --share 50% --json fog.json")).succeeds();
    let json = folder.json("fog.json");
    assert_eq!((&json["method"], &json["picture_claim"]["reached"]), (&"path".into(), &true.into()));
}

/// A scene without light is rendered with default light, which is reported even if there are many
/// other notes. Requested light replaces it and is reported. Parts rendered in different light are
/// not merged.
#[test]
fn light_that_is_asked_for_is_told_and_not_mixed() {
    let folder = Folder::new();
    fs::write(folder.path("dark.obj"), "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nf 1 2 3 4\n").unwrap();
    let odd = format!(
        "curv 0 1 1\nmaplib a\np 1\nl 1 2\nlod 1\ncall a\n{}",
        "v -1 0 -1\nv -1 0 1\nv 1 0 1\nf 1 2 3\n"
    );
    fs::write(folder.path("odd.obj"), odd).unwrap();
    let small = "--size 32x2 --method path --paths 4";
    for scene in ["dark.obj", "odd.obj"] {
        let run = folder.run(&format!("render {scene} {small} --json r.json"));
        assert!(run.succeeds().stderr.contains("no light"), "{scene}: {}", run.stderr);
        assert!(run.stdout.contains("the program's own sky and sun"), "{}", run.stdout);
        assert_eq!(folder.json("r.json")["default_light"], true);
        assert!(folder.run(&format!("info {scene}")).succeeds().stdout.contains("the program's own"));
    }
    let sun = "--light sun:elevation=40,azimuth=120";
    let asked = folder.run(&format!("render dark.obj {small} {sun} --tiles 1/2 -o a.exr --json r.json"));
    assert!(!asked.succeeds().stderr.contains("no light"), "{}", asked.stderr);
    assert!(asked.stdout.contains("with light sun:elevation=40"), "{}", asked.stdout);
    let json = folder.json("r.json");
    assert_eq!(json["default_light"], false);
    assert_eq!(json["light_changes"][0], "light sun:elevation=40,azimuth=120,turbidity=3");
    let info = folder.run(&format!("info dark.obj {sun}"));
    assert!(
        info.succeeds().stdout.contains("asked for") && info.stdout.contains("1 directional"),
        "{}",
        info.stdout
    );
    let other = sun.replace("40", "41");
    for light in [other.as_str(), ""] {
        folder.run(&format!("render dark.obj {small} {light} --tiles 2/2 -o b.exr")).succeeds();
        folder.run("merge a.exr b.exr -o c.exr").fails(3, &["scene."]);
    }
    folder.run(&format!("render dark.obj {small} {sun} --tiles 2/2 -o b.exr")).succeeds();
    folder.run("merge a.exr b.exr -o c.exr").succeeds();
    folder.run("render dark.obj --light moon").fails(2, &["sun:elevation=DEG"]);
    folder.run("render dark.obj --environment absent.hdr").fails(3, &["absent.hdr"]);
    folder.run("render dark.obj --environment scene.mtl").fails(3, &["scene.mtl", "HDR"]);
}

/// One error message names both missing files; with `--allow-missing`, they are notes.
#[test]
fn missing_files_are_all_told_and_refused_unless_allowed() {
    let folder = Folder::new();
    let shape = "<shape type=\"rectangle\"><bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\">\
        <string name=\"filename\" value=\"wood.png\"/></texture></bsdf></shape>";
    let mesh = "<shape type=\"ply\"><string name=\"filename\" value=\"pot.ply\"/></shape>";
    let scene = format!("<scene version=\"3.0.0\">\n{shape}\n{mesh}\n</scene>");
    fs::write(folder.path("scene.xml"), scene).unwrap();
    let small = "--size 2x2 --vpls 5";
    let refused = folder.run(&format!("render scene.xml {small}"));
    refused.fails(3, &["scene.xml:2", "wood.png", "scene.xml:3", "pot.ply", "allow-missing"]);
    folder.run("info scene.xml").fails(3, &["wood.png", "pot.ply"]);
    let told = folder.run(&format!("render scene.xml {small} --allow-missing"));
    assert!(told.succeeds().stderr.contains("pot.ply"), "{}", told.stderr);
    let listed = folder.run("info scene.xml --allow-missing");
    assert!(listed.succeeds().stdout.contains("missing"), "{}", listed.stdout);
    folder.run(&format!("render scene.xml {small} --allow-missing --strict")).fails(3, &["--strict"]);
}

#[test]
fn there_is_nothing_to_render_in_empty_files() {
    let folder = Folder::new();
    let only_mesh = "<scene version=\"3.0.0\"><shape type=\"ply\"><string name=\"filename\" value=\"pot.ply\"/></shape></scene>";
    for (name, text) in [
        ("empty.pbrt", ""),
        ("empty.obj", ""),
        ("empty.xml", "<scene version=\"3.0.0\"/>"),
        ("mesh.xml", only_mesh),
        ("points.obj", "v 0 0 0\nv 1 0 0\n"),
        ("empty.gltf", "{\"asset\": {\"version\": \"2.0\"}}"),
    ] {
        fs::write(folder.path(name), text).unwrap();
        folder.run(&format!("render {name} --allow-missing")).fails(3, &[name, "nothing to render"]);
    }
}

#[test]
fn triangles_without_area_are_counted_and_no_obstacle() {
    let folder = Folder::new();
    fs::write(folder.path("flat.obj"), format!("{OBJ}f 1 1 2\n")).unwrap();
    let info = folder.run("info flat.obj");
    assert!(info.succeeds().stdout.contains("1 without area left out"), "{}", info.stdout);
    folder.run("render flat.obj --size 2x2 --vpls 5 --strict").succeeds();
}

#[test]
fn what_departs_from_the_file_is_told_and_refused_when_strict() {
    let folder = Folder::new();
    fs::write(folder.path("lines.obj"), format!("{OBJ}l 1 2 3\n")).unwrap();
    let info = folder.run("info lines.obj");
    assert!(info.succeeds().stdout.contains("lines.obj:14"), "{}", info.stdout);
    let small = "--size 2x2 --vpls 5";
    let told = folder.run(&format!("render lines.obj {small}"));
    assert!(told.succeeds().stderr.contains("note: lines.obj:14"), "{}", told.stderr);
    folder.run(&format!("render lines.obj {small} --strict")).fails(3, &["lines.obj:14", "--strict"]);
    folder.run(&format!("render builtin:tiny {small} --strict")).succeeds();
}

/// Sends SIGINT, as Ctrl-C does, once the render has begun. The finished tiles are written.
#[cfg(unix)]
#[test]
fn ctrl_c_leaves_a_valid_partial_image() {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};

    let folder = Folder::new();
    // The whole render would take many minutes, but each tile only a fraction of a second.
    let mut child = Command::new(env!("CARGO_BIN_EXE_tashika"))
        .current_dir(folder.0.path())
        .args("render scene.obj --size 600x600 --truth vpl --vpls 2000 --gather 64 --json a.json".split(' '))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let stderr = BufReader::new(child.stderr.take().unwrap());
    let mut lines = stderr.lines().map(Result::unwrap);
    assert!(lines.any(|line| line.starts_with("rendering 600x600")));
    let status = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(status.success());
    assert!(lines.any(|line| line.contains("interrupted")));
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    assert!(String::from_utf8(output.stdout).unwrap().contains("NOT COMPLETE"));
    let film = folder.film("render.exr");
    assert_eq!(film.metadata().bool("complete"), Some(false));
    let done = rendered(&film).iter().filter(|rendered| **rendered).count();
    let json = folder.json("a.json");
    assert_eq!((&json["pixels"], &json["complete"]), (&done.into(), &false.into()));
    assert!(done < 360_000 && folder.path("render.png").exists());
}

#[test]
fn two_renders_are_compared() {
    let folder = Folder::new();
    for seed in [1, 2] {
        folder
            .run(&format!(
                "render builtin:tiny --size 24x16 --truth vpl --vpls 300 --gather 2 --seed {seed} -o {seed}.exr -q"
            ))
            .succeeds();
    }
    let files = "--image error.png --html page.html --json numbers.json";
    let run = folder.run(&format!("compare 1.exr 2.exr --error 10% --absolute 0.01 {files}"));
    for words in ["10 % of the reference, or 0.01 where it is dark", "of other VPLs or gather points"] {
        assert!(run.succeeds().stdout.contains(words), "{words:?} is not in: {}", run.stdout);
    }
    let json = folder.json("numbers.json");
    for key in
        ["pixels", "within_tolerance", "mean", "median", "p95", "worst", "bias", "relative_l1", "error"]
    {
        assert!(json[key].is_number(), "{key}: {json}");
    }
    let (kept, low, high) = (&json["claims_kept"], &json["claims"]["low"], &json["claims"]["high"]);
    assert!(kept.as_f64() > low.as_f64() && kept.as_f64() < high.as_f64(), "{json}");
    let number = |key: &str| json[key].as_f64().unwrap();

    // The numbers are computed again from the samples.
    let luminance = |name: &str| -> Vec<f64> {
        folder.film(name).colors().unwrap().map(|c| f64::from(c.luminance())).collect()
    };
    let (image, reference) = (luminance("1.exr"), luminance("2.exr"));
    let mut errors: Vec<f64> =
        image.iter().zip(&reference).map(|(a, r)| (a - r).abs() / r.max(0.1)).collect();
    let within = errors.iter().filter(|e| **e <= 0.1).count() as f64 / 384.0;
    errors.sort_by(f64::total_cmp);
    let mean = errors.iter().sum::<f64>() / 384.0;
    let bias = image.iter().sum::<f64>() / reference.iter().sum::<f64>() - 1.0;
    assert!(
        within > 0.0 && within < 1.0 && errors[191] > 0.0,
        "two seeds differ, and not everywhere by much"
    );
    assert_eq!((number("pixels"), number("within_tolerance"), number("error")), (384.0, within, 0.1));
    for (key, expected) in [
        ("mean", mean),
        ("median", errors[191]),
        ("p95", errors[364]),
        ("worst", errors[383]),
        ("bias", bias),
    ] {
        assert!(
            (number(key) - expected).abs() < 1e-5 * (1.0 + expected),
            "{key}: {} {expected}",
            number(key)
        );
    }

    let png = fs::read(folder.path("error.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG\r\n") && png.len() > 1000);
    let page = fs::read_to_string(folder.path("page.html")).unwrap();
    assert!(page.contains("1.exr against 2.exr (reference)") && page.contains("\"name\":\"reference\""));
    let typed = format!("tashika compare 1.exr 2.exr --error 10% --absolute 0.01 {files}");
    assert!(page.contains(&typed), "how to make it again");

    let same = folder.run("compare 1.exr 1.exr --json same.json");
    assert!(same.succeeds().stdout.contains("100.0 % of 384 pixels"), "{}", same.stdout);
    let same = folder.json("same.json");
    assert_eq!(
        (&same["worst"], &same["claims_kept"]),
        (&0.0.into(), &1.0.into()),
        "exact claims hold for the same sum"
    );
}

#[test]
fn what_cannot_be_compared_is_told() {
    let folder = Folder::new();
    for (name, size) in [("a", "4x4"), ("b", "4x3")] {
        folder
            .run(&format!("render scene.obj --size {size} --truth vpl --vpls 5 --gather 1 -o {name}.exr -q"))
            .succeeds();
    }
    let before = folder.names();
    folder.run("compare a.exr b.exr --image e.png").fails(3, &["a.exr: an image of 4x4", "b.exr shows: 4x3"]);
    folder.run("compare a.exr none.exr").fails(3, &["none.exr"]);
    folder.run("compare a.exr scene.obj").fails(3, &["scene.obj"]);
    folder.run("compare a.exr").fails(2, &["REF.exr"]);
    folder.run("compare a.exr a.exr --error 2").fails(2, &["--error = 2;", "such as 2% or 0.02"]);
    folder.run("compare a.exr a.exr --error 0%").fails(2, &["--error = 0;"]);
    folder.run("compare a.exr a.exr --error two").fails(2, &["'two'", "--error"]);
    folder.run("compare a.exr a.exr --absolute -1").fails(2, &["--absolute = -1;"]);
    folder.run("compare a.exr a.exr --image e.jpg").fails(2, &["--image = e.jpg", ".png"]);
    folder.run("compare a.exr a.exr --html a.exr").fails(2, &["a.exr is an input"]);
    folder.run("compare a.exr a.exr --html x --json x").fails(2, &["x would be written twice"]);
    assert_eq!(folder.names(), before, "nothing was written");
}

/// Keys that every row of a measurement has.
const KEYS: [&str; 13] = [
    "method",
    "scene",
    "error",
    "confidence",
    "pixels",
    "seeds",
    "within_tolerance",
    "low",
    "high",
    "worst",
    "rays_per_pixel",
    "pairs_per_pixel",
    "seconds",
];

/// Returns the rows of a table for scripts. Asserts that each has all keys and consistent numbers.
#[track_caller]
fn sound_rows(json: Value) -> Vec<Value> {
    let Value::Array(rows) = json else { panic!("not rows: {json}") };
    for row in &rows {
        for key in KEYS {
            assert!(row.get(key).is_some(), "{key}: {row}");
        }
        let number = |key: &str| row[key].as_f64().unwrap_or_else(|| panic!("{key}: {row}"));
        assert!(
            number("low") <= number("within_tolerance") && number("within_tolerance") <= number("high"),
            "{row}"
        );
        assert!(number("median") <= number("p95") && number("p95") <= number("worst"), "{row}");
        let trials = number("pixels") * number("seeds");
        let within = number("within_tolerance") * trials;
        assert!((within - within.round()).abs() < 1e-9, "a number of trials: {row}");
        assert_eq!(number("within_tolerance") == 1.0, number("worst") <= number("error"), "{row}");
        assert_eq!(number("within_tolerance") >= 0.95, number("p95") <= number("error"), "{row}");
        assert!(number("rays_per_pixel") > 0.0 && number("pairs_per_pixel") > 0.0 && number("seconds") > 0.0);
        let states_interval = !["lightcuts", "mdlc"].contains(&row["method"].as_str().unwrap());
        assert_eq!(
            (row["confidence"].is_null(), row["claims_kept"].is_null()),
            (!states_interval, !states_interval)
        );
        assert_eq!(
            number("claims") + number("budget_hit"),
            if states_interval { trials } else { number("budget_hit") }
        );
    }
    rows
}

#[test]
fn coverage_is_measured_by_error_confidence_and_seed() {
    let folder = Folder::new();
    let common = "coverage builtin:tiny --size 24x16 --vpls 200 --gather 2 --pixels 15 --seeds 3 \
                  --methods mdlc,iwasaki2019 --error 10%,0.05 --confidence 50%,0.9";
    let run = folder.run(&format!("{common} --json rows.json"));
    let rows = sound_rows(folder.json("rows.json"));
    let asked: Vec<_> = rows
        .iter()
        .map(|r| (r["method"].as_str().unwrap(), r["error"].as_f64(), r["confidence"].as_f64()))
        .collect();
    let expected = [
        ("mdlc", Some(0.1), None),
        ("mdlc", Some(0.05), None),
        ("iwasaki2019", Some(0.1), Some(0.5)),
        ("iwasaki2019", Some(0.1), Some(0.9)),
        ("iwasaki2019", Some(0.05), Some(0.5)),
        ("iwasaki2019", Some(0.05), Some(0.9)),
    ];
    assert_eq!(asked, expected);
    assert!(rows.iter().all(|r| (&r["pixels"], &r["seeds"]) == (&15.into(), &3.into())));
    let lines: Vec<&str> = run.succeeds().stdout.lines().filter(|line| line.starts_with("| ")).collect();
    assert_eq!(lines.len(), 7, "{}", run.stdout);
    assert!(lines[0].contains("claims kept") && lines[6].contains("iwasaki2019"), "{}", run.stdout);
    assert!(run.stderr.contains("exact sums of 15 pixels"), "{}", run.stderr);

    // With one thread, all numbers are the same except the times.
    folder.run(&format!("{common} --json again.json --threads 1 -q")).succeeds();
    let timeless = |mut rows: Vec<Value>| {
        rows.iter_mut().for_each(|row| row["seconds"] = Value::Null);
        rows
    };
    assert_eq!(timeless(sound_rows(folder.json("again.json"))), timeless(rows));
}

#[test]
fn the_seed_experiment_is_what_render_and_compare_say() {
    let folder = Folder::new();
    let stage = "builtin:tiny --size 20x12 --vpls 150 --gather 2";
    let figures = format!("experiment iwasaki2019 {stage}");
    let run = folder.run(&format!("{figures} --out out --methods mdlc,sakai2018 --error 5%"));
    let rows = sound_rows(folder.json("out/table.json"));
    assert_eq!(rows.len(), 2);
    folder.run(&format!("render {stage} --method sakai2018 --error 5% -o s.exr -q")).succeeds();
    folder.run(&format!("render {stage} --method exact -o r.exr -q")).succeeds();
    folder.run("compare s.exr r.exr --error 5% --json c.json -q").succeeds();
    assert_eq!(folder.film("s.exr"), folder.film("out/sakai2018.exr"));
    assert_eq!(folder.film("r.exr"), folder.film("out/reference.exr"));
    let compared = folder.json("c.json");
    for key in ["within_tolerance", "mean", "median", "p95", "worst", "pixels", "claims_kept"] {
        assert_eq!(rows[1][key], compared[key], "{key}");
    }
    for method in ["mdlc", "sakai2018", "reference"] {
        assert!(folder.path(&format!("out/{method}.png")).exists(), "{method}");
    }
    let table = fs::read_to_string(folder.path("out/table.md")).unwrap();
    assert_eq!(run.succeeds().stdout, table);
    let page = fs::read_to_string(folder.path("out/index.html")).unwrap();
    for method in ["mdlc", "sakai2018"] {
        assert!(page.contains(&format!("\"label\":\"{method}\"")), "{method} can be looked at");
        let error = fs::read(folder.path(&format!("out/{method}-error.png"))).unwrap();
        assert!(error.starts_with(b"\x89PNG"), "{method}");
    }
    let csv = fs::read_to_string(folder.path("out/table.csv")).unwrap();
    let lines: Vec<&str> = csv.lines().collect();
    assert!(lines.len() == 3 && lines[0].starts_with("method,scene,") && lines[2].starts_with("sakai2018,"));
    assert!(fs::read_to_string(folder.path("out/quality-and-cost.svg")).unwrap().starts_with("<svg"));

    // The experiment is repeated with exact sums of only 9 pixels.
    folder.run(&format!("{figures} --out some --methods mdlc --pixels 9 --json some.json -q")).succeeds();
    let some = sound_rows(folder.json("some.json"));
    assert_eq!((&some[0]["pixels"], folder.json("some/table.json")), (&9.into(), Value::Array(some.clone())));
    assert_eq!(rendered(&folder.film("some/reference.exr")).iter().filter(|r| **r).count(), 9);
    assert!(rendered(&folder.film("some/mdlc.exr")).iter().all(|r| *r), "methods render everything");
}

#[test]
fn costs_are_measured_against_lights_and_gather_points() {
    let folder = Folder::new();
    let run = folder.run(
        "experiment scaling builtin:tiny --size 20x12 --out . --vpls 50,400 --gather 1,4 --pixels 8 --methods mdlc,nabata2016",
    );
    let rows = sound_rows(folder.json("table.json"));
    let cells: Vec<_> =
        rows.iter().map(|r| (r["method"].as_str().unwrap(), r["gather"].as_u64().unwrap())).collect();
    let curve = |method| [(method, 1), (method, 4), (method, 1), (method, 4)];
    assert_eq!(cells, [curve("mdlc"), curve("nabata2016")].concat(), "{}", run.succeeds().stdout);
    let vpls: Vec<u64> = rows.iter().map(|r| r["vpls"].as_u64().unwrap()).collect();
    assert!(vpls[0] == vpls[1] && vpls[2] == vpls[3] && vpls[2] > 3 * vpls[0], "{vpls:?}");
    let rays = |i: usize| rows[i]["rays_per_pixel"].as_f64().unwrap();
    assert!(rays(4) < rays(5) && rays(4) < rays(6), "more points and more lights cost more: {}", run.stdout);
}

#[test]
fn methods_are_brought_to_the_same_quality() {
    let folder = Folder::new();
    let run = folder
        .run("experiment equal-quality builtin:tiny --size 20x12 --out . --vpls 200 --pixels 40 --share 90%");
    let rows = sound_rows(folder.json("table.json"));
    assert!(run.succeeds().stdout.contains("90.0 % of the pixels within 2 %"), "{}", run.stdout);
    assert_eq!(rows.len(), 7);
    for row in &rows {
        assert!(row["within_tolerance"].as_f64().unwrap() >= 0.9 && row["error"] == 0.02, "{row}");
    }
    // With a largest cut of one pair, the error is large for any target.
    let run = folder.run(
        "experiment equal-quality builtin:tiny --size 20x12 --out . --vpls 200 --pixels 10 --max-pairs 1 --methods mdlc",
    );
    assert!(run.succeeds().stdout.contains("mdlc was not brought to 95.0 % within 2 %"), "{}", run.stdout);
    // Pixels without surfaces do not run out of budget, since they need no pair; others do.
    assert!(sound_rows(folder.json("table.json"))[0]["budget_hit"].as_u64() > Some(0));
}

#[test]
fn typing_errors_of_measurements_are_answered() {
    let folder = Folder::new();
    let before = folder.names();
    folder.run("coverage --methods exact").fails(2, &["'exact'", "--methods", "lightcuts, mdlc"]);
    folder.run("coverage --methods mdlc,,mdlc").fails(2, &["''", "--methods"]);
    folder.run("coverage --error 1%,two").fails(2, &["'two'", "--error"]);
    folder.run("coverage --error 1%,2").fails(2, &["--error = 2; expected"]);
    folder.run("coverage --confidence 50%,100%").fails(2, &["--confidence = 1; expected"]);
    folder.run("coverage --seeds 0").fails(2, &["--seeds = 0;"]);
    folder.run("coverage --max-pairs 0").fails(2, &["--max-pairs = 0;"]);
    folder
        .run("coverage builtin:tiny --vpls 5 --size 4x4 --pixels 17")
        .fails(2, &["--pixels = 17; expected 1 to 16"]);
    folder.run("coverage builtin:tiny --vpls 5 --size 4x4 --pixels 0").fails(2, &["--pixels = 0;"]);
    folder.run("coverage --json none/a.json").fails(3, &["none/a.json", "no folder none"]);
    folder.run("coverage none.obj").fails(3, &["none.obj"]);
    folder.run("experiment").fails(2, &["iwasaki2019", "scaling", "equal-quality"]);
    folder.run("experiment iwasaki").fails(2, &["'iwasaki'", "'iwasaki2019'"]);
    folder.run("experiment scaling --gather 4,2000").fails(2, &["--gather = 2000;"]);
    folder.run("experiment scaling --vpls 1k,0").fails(2, &["--vpls = 0;"]);
    folder.run("experiment equal-quality --share 0").fails(2, &["--share = 0;"]);
    folder.run("experiment seed --out scene.obj").fails(3, &["cannot write scene.obj"]);
    assert_eq!(folder.names(), before, "nothing was written");
}

/// Sends SIGINT, as Ctrl-C does, once the second row has begun. The first row is written.
#[cfg(unix)]
#[test]
fn ctrl_c_leaves_the_rows_that_are_finished() {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};

    let folder = Folder::new();
    // The first row takes a moment, the second many minutes, but each of its pixels little time.
    let line = "coverage builtin:tiny --size 8x8 --vpls 2k --gather 64 --pixels 5 --seeds 300 --json a.json \
                --methods mdlc --error 100%,0.001% --max-pairs 50k";
    let mut child = Command::new(env!("CARGO_BIN_EXE_tashika"))
        .current_dir(folder.0.path())
        .args(line.split_whitespace())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let stderr = BufReader::new(child.stderr.take().unwrap());
    let mut lines = stderr.lines().map(Result::unwrap);
    assert!(lines.any(|line| line.starts_with("mdlc, error 0.001 %")));
    let status = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(status.success());
    assert!(lines.any(|line| line.contains("interrupted")));
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    assert!(String::from_utf8(output.stdout).unwrap().contains("NOT COMPLETE: 1 of 2 rows"));
    assert_eq!(sound_rows(folder.json("a.json")).len(), 1);
}
