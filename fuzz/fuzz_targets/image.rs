//! Images of every format, as the environment of a sound scene.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    // The ending decides only where the bytes do not.
    let name = if data.len() % 2 == 0 { "e.exr" } else { "e.tga" };
    let scene = format!("WorldBegin\nLightSource \"infinite\" \"string mapname\" \"{name}\"\n");
    tashika_fuzz::load(&[("scene.pbrt", scene.as_bytes()), (name, data)]);
});
