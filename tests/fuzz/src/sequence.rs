//! Any bytes are a sequence of operations: see `trisap_tests::sequence`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = trisap_tests::sequence::play(bytes);
});
