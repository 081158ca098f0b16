//! Common part of all fuzz targets. A target writes its bytes to a file, reads the file, and uses
//! the result.
//!
//! A finding is a panic, a hang, memory beyond the fuzzer's limit, a scene that breaks the
//! guarantees of a [`Scene`], an image that differs between the two ways to read it, or a tile of a
//! checkpoint that was never written.

use std::fs;
use std::sync::Arc;

use tashika::Renderer;
use tashika::accel::Tracer;
use tashika::film::{Film, PlaneSpec, SampleKind, Window};
use tashika::gather::{GatherOptions, View};
use tashika::io::{Checkpoint, ExrFile, LightChanges, LoadOptions, load_scene, read_exr};
use tashika::request::MethodName;
use tashika::scene::{Scene, builtin};
use tashika::vpl::{VplOptions, VplSet};

/// Options with limits that suit the machine of a fuzzer.
fn options() -> LoadOptions {
    LoadOptions {
        allow_missing: true,
        max_image_texels: 1 << 20,
        max_file_bytes: 1 << 24,
        // This time is between the keys of moving objects.
        at: Some(0.5),
        ..LoadOptions::default()
    }
}

/// Loads the first of `files`, which lie in one folder, and renders a pixel of it.
pub fn load(files: &[(&str, &[u8])]) {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).expect("a file");
    }
    // The scene is loaded once at a single time, and once with the shutter open around that time.
    for shutter in [None, Some([-0.25, 0.25])] {
        match load_scene(&folder.path().join(files[0].0), &LoadOptions { shutter, ..options() }) {
            Ok(scene) => look(scene),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
}

/// Adds light to a room: a lamp from an IES file with these bytes, and a light and an environment
/// from the bytes as text.
pub fn light(bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("lamp.ies");
    fs::write(&path, bytes).expect("a file");
    let words = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]);
    let mut lights = vec![format!("ies:{}@0,1,0", path.display()).parse().expect("a light")];
    lights.extend(words.parse());
    let changes =
        LightChanges { environment: words.parse().ok().filter(|_| words.starts_with("sky:")), lights };
    match changes.apply(builtin::tiny(), &options()) {
        Ok(scene) => look(scene),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// Uses a scene: traces a few lights and one pixel.
fn look(scene: Scene) {
    assert!(!scene.cameras().is_empty() && scene.bounds().size().is_finite());
    for mesh in scene.meshes() {
        let vertices = mesh.positions().len();
        assert!(mesh.triangles().iter().flatten().all(|&i| (i as usize) < vertices));
    }
    if scene.instanced_triangles() > 100_000 {
        return;
    }
    let tracer = Tracer::new(Arc::new(scene));
    if tracer.scene().moves() || tracer.scene().has_media() {
        let few = Renderer::on(&tracer).size([2, 2]).method(MethodName::Path).paths(2);
        let film = few.render().expect("valid options").film;
        assert!(film.colors().expect("colours").all(|c| c.is_valid()));
        return;
    }
    let lights = VplSet::trace(&tracer, &VplOptions { count: 16, max_depth: 4, ..VplOptions::default() });
    for light in lights.expect("valid options").lights() {
        assert!(light.intensity.is_valid() && light.position.is_finite());
    }
    let gather = GatherOptions { points: 2, ..GatherOptions::default() };
    let view = View { camera: &tracer.scene().cameras()[0], size: [4, 4], gather, seed: 1 };
    let sum = view.pixel(&tracer, [1, 2]);
    assert!(sum.background.is_valid());
}

/// Reads a set of VPLs.
pub fn load_vpls(bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("lights.vpl");
    fs::write(&path, bytes).expect("a file");
    if let Err(error) = tashika::io::load_vpls(&path) {
        assert!(!error.to_string().is_empty());
    }
}

/// Reads an OpenEXR image whole and in rows.
pub fn read_film(bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.exr");
    fs::write(&path, bytes).expect("a file");
    let whole = read_exr(&path);
    let Ok(file) = ExrFile::open(&path) else { return };
    let window = file.window();
    // Each call decompresses whole blocks. At least a block and at least 1/64 of the rows are read
    // at once, which limits the work.
    let step = file.rows_per_block().min(window.height).max(window.height.div_ceil(64));
    for top in (window.y..window.y + window.height).step_by(step as usize) {
        let rows = file.read_rows(top..(top + step).min(window.y + window.height));
        if let (Ok(whole), Ok(rows)) = (&whole, rows) {
            assert!(whole.cropped(rows.window()).expect("rows of the film") == rows, "rows from {top}");
        }
    }
}

/// Resumes a checkpoint from these bytes, once as its records and once as the whole file.
pub fn resume(bytes: &[u8]) {
    const SPECS: &[PlaneSpec] = &[
        PlaneSpec { name: "", channels: &["R", "G", "B"], unit: "1", kind: SampleKind::F32, doc: "" },
        PlaneSpec { name: "stop", channels: &["id"], unit: "1", kind: SampleKind::U32, doc: "" },
    ];
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.checkpoint");
    let film =
        Film::new([40, 30], Window { x: 3, y: 2, width: 20, height: 12 }, SPECS).expect("a sound window");
    drop(Checkpoint::open(&path, &film).expect("a new file"));
    let mut records = fs::read(&path).expect("what was written");
    records.extend(bytes);
    for content in [&records[..], bytes] {
        fs::write(&path, content).expect("a file");
        if let Ok((_, resumed)) = Checkpoint::open(&path, &film) {
            // Only tiles with a correct checksum are resumed.
            assert!(resumed.tiles.iter().all(|tile| film.window().covers(tile)));
            assert!(!resumed.tiles.is_empty() || resumed.film == film);
        }
    }
}
