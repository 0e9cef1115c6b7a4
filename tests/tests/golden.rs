//! Determinism: one hash over everything that a run says, equal for all kernels, job systems, numbers of workers and targets.

use trisap_tests::golden::{self, configs, hash};
use trisap_tests::jobs::Jobs;
use trisap_tests::recordings;
use trisap_tests::worlds::Setup;

#[test]
fn hashes_are_equal_over_kernels_workers_and_index_widths() {
    let jobs =
        [Jobs::Serial, Jobs::Threads(1), Jobs::Threads(2), Jobs::Threads(3), Jobs::Threads(8), Jobs::Crowd];
    for recording in recordings::all() {
        let mut hashes = Vec::new();
        for (mode, config) in configs() {
            let reference = hash::<u32>(&recording, config, Setup::REFERENCE);
            for setup in Setup::each(&jobs) {
                let name = &recording.name;
                assert_eq!(hash::<u32>(&recording, config, setup), reference, "{name} {setup:?} {mode}");
                assert_eq!(hash::<u16>(&recording, config, setup), reference, "{name} {setup:?} in 16 bits");
            }
            hashes.push(reference);
        }
        assert_ne!(hashes[0], hashes[2], "a hash that does not see the pairs");
    }
}

/// The other half of the test above: what is equal on one machine is also what all other targets say. Who changes the order
/// of pairs writes the table anew: `cargo run --release -p trisap-runs --bin golden > tests/golden.txt`.
#[test]
fn hashes_are_those_of_all_targets() {
    assert_eq!(golden::table(Setup::REFERENCE), golden::TABLE, "not the hashes of tests/golden.txt");
}
