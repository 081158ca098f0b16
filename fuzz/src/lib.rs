//! What all fuzz targets do with their bytes: write a scene into a folder, load it, and use what comes out.
//!
//! A finding is a panic, a hang, memory beyond the fuzzer's limit, or a scene that breaks what a [`Scene`] promises.

use std::fs;
use std::sync::Arc;

use tashika::accel::Tracer;
use tashika::gather::{GatherOptions, View};
use tashika::io::{LoadOptions, load_scene};
use tashika::scene::Scene;
use tashika::vpl::{VplOptions, VplSet};

/// Limits that a fuzzer's machine can bear.
fn options() -> LoadOptions {
    LoadOptions { allow_outside: false, max_image_texels: 1 << 20, max_file_bytes: 1 << 24 }
}

/// Loads the first of `files`, which lie in one folder, and renders a pixel of it.
pub fn load(files: &[(&str, &[u8])]) {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).expect("a file");
    }
    match load_scene(&folder.path().join(files[0].0), &options()) {
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
