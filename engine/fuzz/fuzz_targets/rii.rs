//! Glasses of refractiveindex.info: whatever the bytes, an answer or an error of one line.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| petzval_fuzz::glass_page(bytes));
