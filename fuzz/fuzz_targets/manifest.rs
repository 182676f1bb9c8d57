#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| planish_tests::fuzz::manifest(data));
