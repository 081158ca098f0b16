//! PLY meshes, below a sound pbrt scene.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| tashika_fuzz::load(&[
    ("scene.pbrt", b"WorldBegin\nShape \"plymesh\" \"string filename\" \"m.ply\"\n"),
    ("m.ply", data),
]));
