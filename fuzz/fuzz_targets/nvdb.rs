//! NanoVDB files, in a pbrt scene whose smoke they are.
#![no_main]

const SCENE: &[u8] = br#"Integrator "volpath" Camera "perspective" WorldBegin LightSource "infinite"
MakeNamedMedium "smoke" "string type" "nanovdb" "string filename" "a.nvdb"
MediumInterface "smoke" "" Material "interface" Shape "sphere""#;

libfuzzer_sys::fuzz_target!(|data: &[u8]| tashika_fuzz::load(&[("scene.pbrt", SCENE), ("a.nvdb", data)]));
