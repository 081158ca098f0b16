//! Radiance.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| tashika_fuzz::load(&[("scene.rad", data)]));
