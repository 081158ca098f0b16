//! IES files, and the words of lights that are asked for.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| tashika_fuzz::light(data));
