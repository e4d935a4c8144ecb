//! Rays through whole systems beside the 320-bit tracer: the property is `petzval_fuzz::TARGETS`'.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| petzval_fuzz::property("system")(bytes));
