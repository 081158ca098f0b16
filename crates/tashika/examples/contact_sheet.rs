//! Sheet of small pictures of many scenes, rendered with default options, for a quick visual check.
//!
//!     cargo run --release --example contact_sheet -- LIST FOLDER SHEET.png
//!
//! `LIST` names a scene file below `FOLDER` on each line, optionally followed by a tab and the name
//! of a camera. The sheet has [`COLUMNS`] pictures a row, in the order of the list. Each picture is
//! rendered at the largest size that fits into 320 × 180 pixels, and exposed by its own
//! log-average. Scenes that could not be loaded are red. The program prints a table of names,
//! sizes, times and half-widths.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program: what it prints is its result")]

use std::path::Path;
use std::time::Instant;
use std::{env, fs};

use tashika::Renderer;
use tashika::color::Rgb;
use tashika::error::Error;
use tashika::film::{Film, Plane, PlaneSpec, SampleKind, Window, planes};
use tashika::io::{Exposure, LoadOptions, ToneMap, load_scene, write_png};
use tashika::report::error_budget;

/// Pictures a row.
const COLUMNS: u32 = 5;
/// Size of a picture, its frame included (pixels).
const CELL: [u32; 2] = [324, 184];
/// Width of the frame around a picture.
const FRAME: u32 = 2;
/// Linear value to which the log-average of a picture is exposed.
const MIDDLE_GRAY: f64 = 0.18;

/// The sheet's one plane.
const SHEET: PlaneSpec = PlaneSpec {
    name: "",
    channels: &["R", "G", "B"],
    unit: "1",
    kind: SampleKind::F32,
    doc: "pictures of scenes, each exposed by itself",
};

type Colors = Vec<((u32, u32), Rgb)>;

/// A picture of a scene, with the text of its row.
fn picture(path: &Path, camera: Option<&str>) -> Result<(Colors, [u32; 2], String), Error> {
    let start = Instant::now();
    let scene = load_scene(path, &LoadOptions { allow_outside: true, ..LoadOptions::default() })?;
    let loaded = start.elapsed().as_secs_f64();
    let notes: u64 = scene.notes().iter().map(|n| n.count).sum();
    let told = format!("{} triangles, {} notes, loaded in {loaded:.1} s", scene.instanced_triangles(), notes);
    let camera = camera.and_then(|name| scene.camera(name)).unwrap_or(&scene.cameras()[0]).clone();
    let [w, h] = camera.resolution.unwrap_or([4, 3]);
    let most = CELL.map(|side| side - 2 * FRAME);
    let scale = (f64::from(most[0]) / f64::from(w)).min(f64::from(most[1]) / f64::from(h));
    let size = [w, h].map(|side| ((f64::from(side) * scale) as u32).max(1));
    let film = Renderer::new(scene).camera(camera).size(size).passes(5).render()?.film;
    let pixels = film.window().pixels();
    let half_width = error_budget(&film).map_or(0.0, |budget| 100.0 * budget.total);
    let told = format!("{told}, {:.0} s in all, half-width {half_width:.1} %", start.elapsed().as_secs_f64());
    let colors = film.plane(planes::RADIANCE).and_then(Plane::colors).expect("an image");
    Ok((pixels.zip(colors).collect(), size, told))
}

/// Factor that brings the log-average of all pixels that are not black to middle gray.
fn exposure(colors: &Colors) -> f32 {
    let logs: Vec<f64> =
        colors.iter().map(|(_, c)| f64::from(c.luminance())).filter(|l| *l > 1e-9).map(f64::ln).collect();
    let mean = logs.iter().sum::<f64>() / (logs.len().max(1) as f64);
    (MIDDLE_GRAY / mean.exp()) as f32
}

fn main() -> Result<(), Error> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [list, folder, sheet] = &arguments[..] else {
        eprintln!("usage: contact_sheet LIST FOLDER SHEET.png");
        std::process::exit(2);
    };
    let list = fs::read_to_string(list).map_err(|e| Error::io(list, e))?;
    let entries: Vec<&str> = list.lines().filter(|l| !l.is_empty() && !l.starts_with('#')).collect();
    let rows = (entries.len() as u32).div_ceil(COLUMNS);
    let size = [COLUMNS * CELL[0], rows * CELL[1]];
    let mut film = Film::new(size, Window::full(size), &[SHEET])?;
    println!("| picture | scene | |\n|---|---|---|");
    for (i, entry) in (0u32..).zip(&entries) {
        let (name, camera) = entry.split_once('\t').map_or((*entry, None), |(n, c)| (n, Some(c)));
        let corner = [(i % COLUMNS) * CELL[0] + FRAME, (i / COLUMNS) * CELL[1] + FRAME];
        let told = match picture(&Path::new(folder).join(name), camera) {
            Ok((colors, size, told)) => {
                let factor = exposure(&colors);
                let middle = [0, 1].map(|k| (CELL[k] - 2 * FRAME - size[k]) / 2);
                for ((x, y), color) in colors {
                    let at = [corner[0] + middle[0] + x, corner[1] + middle[1] + y];
                    film.planes_mut()[0].set_f32(at[0], at[1], &(color * factor).to_array());
                }
                told
            }
            Err(error) => {
                for (x, y) in (Window { x: corner[0], y: corner[1], width: 20, height: 20 }).pixels() {
                    film.planes_mut()[0].set_f32(x, y, &[1.0, 0.0, 0.0]);
                }
                error.to_string()
            }
        };
        println!("| {}, {} | `{entry}` | {told} |", i / COLUMNS + 1, i % COLUMNS + 1);
    }
    write_png(Path::new(sheet), &film, &ToneMap { exposure: Exposure::Stops(0.0), ..ToneMap::default() })?;
    Ok(())
}
