//! OpenEXR images, as films.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| tashika_fuzz::read_film(data));
