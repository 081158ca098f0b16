//! Sets of VPLs.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| tashika_fuzz::load_vpls(data));
