//! Mitsuba's binary meshes, below a sound scene.
#![no_main]

const SCENE: &[u8] = br#"<scene version="0.6.0"><shape type="serialized"><string name="filename" value="m.serialized"/></shape></scene>"#;

libfuzzer_sys::fuzz_target!(|data: &[u8]| tashika_fuzz::load(&[
    ("scene.xml", SCENE),
    ("m.serialized", data)
]));
