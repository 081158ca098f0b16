//! Runs the fuzz targets on their seeds, as the fuzzer does.

use std::path::Path;

use crate::fuzzing;

/// Calls `with` for each seed of a target.
fn each_seed(target: &str, with: impl Fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds").join(target);
    let seeds: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|seed| seed.unwrap().path()).collect();
    assert!(!seeds.is_empty(), "{target}");
    seeds.iter().for_each(|seed| with(&std::fs::read(seed).unwrap()));
}

#[test]
fn seeds_are_read_and_used() {
    for scene in [
        "scene.glb",
        "scene.gltf",
        "scene.obj",
        "scene.pbrt",
        "scene.rad",
        "scene.usda",
        "scene.usdc",
        "scene.usdz",
    ] {
        let (_, target) = scene.split_once('.').unwrap();
        each_seed(target, |bytes| fuzzing::load(&[(scene, bytes)]));
    }
    each_seed("mitsuba", |bytes| fuzzing::load(&[("scene.xml", bytes)]));
    each_seed("film", fuzzing::read_film);
    each_seed("light", fuzzing::light);
    // These targets have no seeds.
    fuzzing::load_vpls(&[]);
    fuzzing::resume(&[]);
}
