//! Texts of coatings: the property is `petzval_fuzz::TARGETS`'.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| petzval_fuzz::property("coating")(bytes));
