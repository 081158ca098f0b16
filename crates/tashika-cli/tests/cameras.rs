//! Cameras of the command line: several in one call, other projections, lenses with blades.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use assert_cmd::Command;
use tashika::film::Film;
use tashika::io::read_exr;
use tempfile::TempDir;

/// A folder in which the program is run.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs the program in the folder; returns its exit code and the text of both streams.
    fn run(&self, line: &str) -> (Option<i32>, String) {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tashika"));
        let output = command.current_dir(self.0.path()).args(line.split_whitespace()).output().unwrap();
        let text = [output.stdout, output.stderr].map(|stream| String::from_utf8(stream).unwrap()).concat();
        (output.status.code(), text)
    }

    fn succeeds(&self, line: &str) -> String {
        let (code, text) = self.run(line);
        assert_eq!(code, Some(0), "{line}: {text}");
        text
    }

    fn refuses(&self, line: &str, said: &[&str]) {
        let (code, text) = self.run(line);
        assert_eq!(code, Some(2), "{line}: {text}");
        for words in said {
            assert!(text.contains(words), "{line}: {text}");
        }
    }

    fn film(&self, name: &str) -> Film {
        read_exr(&self.path(name)).unwrap()
    }

    fn names(&self) -> BTreeSet<String> {
        fs::read_dir(self.0.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
    }
}

const SMALL: &str = "--method path --paths 2 --size 16x8 --quiet";

fn pixels(film: &Film) -> Vec<[f32; 3]> {
    let plane = &film.planes()[0];
    let size = film.size();
    let at = |x, y| <[f32; 3]>::try_from(plane.f32_at(x, y)).unwrap();
    (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).map(|(x, y)| at(x, y)).collect()
}

#[test]
fn several_cameras_give_an_image_each_that_is_the_one_of_a_call_of_its_own() {
    let folder = Folder::new();
    let line = format!("render builtin:room {SMALL} --json numbers.json");
    folder.succeeds(&format!("{line} --camera all -o room.exr"));
    let room = tashika::scene::builtin::room();
    let cameras: Vec<&str> = room.cameras().iter().map(|c| c.name.as_str()).collect();
    assert!(cameras.len() > 1);
    let mut expected = BTreeSet::new();
    for camera in &cameras {
        expected.extend(["exr", "png", "html"].map(|ending| format!("room-{camera}.{ending}")));
        expected.insert(format!("numbers-{camera}.json"));
    }
    assert_eq!(folder.names(), expected);
    for camera in &cameras {
        folder.succeeds(&format!("{line} --camera {camera} -o alone.exr"));
        let (one, all) = (folder.film("alone.exr"), folder.film(&format!("room-{camera}.exr")));
        assert_eq!(all.metadata().text("camera"), Some(*camera));
        assert_eq!(pixels(&one), pixels(&all), "{camera}");
    }
    // Images are written in the order in which the cameras were typed, whether separated by commas
    // or in repeated options. The scene is read once.
    let both = format!("--camera {1},{0} --camera {1}", cameras[0], cameras[1]);
    let told =
        folder.succeeds(&format!("render builtin:room --method path --paths 1 --size 8x4 {both} -o b.exr"));
    let place = |camera: &str| told.find(&format!("b-{camera}.exr")).expect("it is told");
    assert!(place(cameras[1]) < place(cameras[0]), "{told}");
    assert_eq!(told.matches("reading ").count(), 1, "{told}");
}

#[test]
fn what_goes_with_one_image_is_refused_for_several() {
    let folder = Folder::new();
    for option in ["--checkpoint", "--serve --no-browser --log-file log", "--tev", "--write-vpls a.vpl"] {
        let name = option.split(' ').next().unwrap();
        let line = format!("render builtin:tiny {option} --camera all");
        folder.refuses(&line, &["--camera = all", &format!("one camera with {name}")]);
    }
    folder.refuses("farm slurm --out job -- render builtin:room --camera all", &["one camera of a job"]);
    folder.refuses("coverage builtin:room --camera all", &["one camera with this command"]);
    folder.refuses("render builtin:room --camera main,nobody", &["--camera = nobody", "main"]);
    assert_eq!(folder.names(), BTreeSet::new());
}

#[test]
fn projections_and_lenses_are_chosen_and_named_in_the_film() {
    let folder = Folder::new();
    let render = |options: &str| {
        folder.succeeds(&format!("render builtin:tiny --method path --paths 4 --quiet -o a.exr {options}"));
        folder.film("a.exr")
    };
    let sphere = render("--projection spherical");
    assert_eq!(sphere.size(), [64, 32], "twice as wide as the camera's image is high");
    assert_eq!(sphere.metadata().text("camera.projection"), Some("spherical"));
    let fisheye = render("--projection fisheye --fov 200 --size 30x20");
    let black = |film: &Film, x: u32, y: u32| film.planes()[0].f32_at(x, y).iter().all(|c| *c == 0.0);
    assert!(black(&fisheye, 0, 10) && black(&fisheye, 4, 10) && !black(&fisheye, 15, 10));
    let (sharp, wide) = (render(""), render("--lens-radius 0.2 --focus-distance 1"));
    let blades = render("--lens-radius 0.2 --focus-distance 1 --blades 3 --blade-rotation 10");
    assert_ne!(pixels(&sharp), pixels(&wide));
    assert_ne!(pixels(&wide), pixels(&blades), "the opening is another");
    for (options, said) in [
        ("--projection cylinder", "perspective or fisheye or spherical or equal-area"),
        ("--fov 180", "--fov = 180; expected degrees above 0 and below 180"),
        ("--projection spherical --fov 90", "only a perspective and a fisheye"),
        ("--lens-radius 0.1", "--lens-radius = 0.1; expected it with a focus distance"),
        ("--blades 2 --lens-radius 0.1 --focus-distance 1", "--blades = 2; expected 3 to 100"),
    ] {
        folder.refuses(&format!("render builtin:tiny {options}"), &[said]);
    }
}

/// Two parts are rendered with the same camera but different projections. Merging refuses them.
#[test]
fn parts_of_other_projections_are_not_joined() {
    let folder = Folder::new();
    let part = |k: u32, options: &str| {
        let line = "render builtin:tiny --method path --paths 1 --size 32x32 --quiet";
        folder.succeeds(&format!("{line} --tiles {k}/2 -o part-{k}.exr {options}"));
    };
    part(1, "--projection fisheye");
    part(2, "--projection fisheye --fov 120");
    let (code, text) = folder.run("merge part-1.exr part-2.exr -o whole.exr");
    assert_eq!(code, Some(3), "{text}");
    part(2, "--projection fisheye");
    folder.succeeds("merge part-1.exr part-2.exr -o whole.exr --quiet");
}

/// A scene without a camera is rendered with wide, tall and square images. The default camera shows
/// the whole scene: nothing touches the edge of the image, and in one direction the scene nearly
/// reaches both edges.
#[test]
fn a_file_without_a_camera_is_framed_in_any_proportions() {
    let folder = Folder::new();
    // Two walls, whose corners are the eight corners of a box.
    let wall = |z: f32| format!("v -1 0 {z}\nv 1 0 {z}\nv 1 3 {z}\nv -1 3 {z}\n");
    let quad = wall(0.0) + &wall(0.5) + "usemtl m\nf 1 2 3 4\nf 5 6 7 8\n";
    fs::write(folder.path("s.obj"), format!("mtllib s.mtl\n{quad}")).unwrap();
    fs::write(folder.path("s.mtl"), "newmtl m\nKd 0.5 0.5 0.5\n").unwrap();
    for (width, height) in [(120, 40), (40, 120), (80, 80)] {
        let line =
            format!("render s.obj --method tashika --truth vpl --vpls 10 --gather 4 --size {width}x{height}");
        folder.succeeds(&format!("{line} --accept-budget --quiet -o s.exr"));
        let film = folder.film("s.exr");
        let coverage = film.plane("coverage").expect("how much of a pixel is covered");
        let covered = |x: u32, y: u32| coverage.f32_at(x, y)[0] > 0.0;
        let columns: Vec<u32> = (0..width).filter(|x| (0..height).any(|y| covered(*x, y))).collect();
        let rows: Vec<u32> = (0..height).filter(|y| (0..width).any(|x| covered(x, *y))).collect();
        let free = |seen: &[u32], side: u32| [seen[0], side - 1 - seen[seen.len() - 1]];
        let (across, down) = (free(&columns, width), free(&rows, height));
        assert!(across.iter().chain(&down).all(|free| *free >= 1), "{across:?} {down:?}");
        let near = |free: [u32; 2], side: u32| free.iter().all(|free| *free <= side / 40 + 3);
        assert!(near(across, width) || near(down, height), "{width}x{height}: {across:?} {down:?}");
    }
}
