//! Random sequences of all operations that there are: see `trisap_tests::sequence`. `tests/fuzz` and `tests/soak.sh` play the same
//! with more patience, `tests/cpp/sequences.cpp` through the C ABI.

use proptest::prelude::*;
use trisap_tests::effort;
use trisap_tests::sequence::{Tally, format, play};

proptest! {
    #![proptest_config(ProptestConfig { cases: 300 * effort(), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_a_sequence(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = play(&bytes);
    }
}

/// Sequences of the long run, of which all that can happen has happened in the end.
#[test]
fn all_that_can_happen_does() {
    let mut tally = Tally::default();
    for seed in 0..1000 * u64::from(effort()) {
        tally += &play(&format::random(seed, 100));
    }
    println!("{tally}");
    assert!(tally.kinds.iter().all(|count| *count > 0), "{tally:?}");
    assert!(tally.paths.iter().all(|count| *count > 0), "{tally:?}");
    let numbers = tally.numbers();
    assert!(numbers.iter().all(|count| *count > 0), "{tally:?}");
}
