//! Determinism: all that a run says is equal for all kernels, job systems and numbers of workers, and its hash is that of all targets.

use trisap_core::{Config, Index};
use trisap_tests::SlotPair;
use trisap_tests::checked::slots;
use trisap_tests::golden::{self, configs, play};
use trisap_tests::jobs::Jobs;
use trisap_tests::recordings::{self, Recording};
use trisap_tests::worlds::Setup;

/// The pairs, the found and the lost of each frame. Lists are compared and not their hashes, which took as long as the steps.
fn told(recording: &Recording, config: Config) -> Vec<Vec<SlotPair>> {
    let mut told = Vec::new();
    play::<u32>(recording, config, Setup::REFERENCE, |pairs| told.push(slots(pairs)));
    told
}

fn compare<I: Index>(recording: &Recording, config: Config, setup: Setup, reference: &[Vec<SlotPair>]) {
    let (mut lists, name) = (0, &recording.name);
    play::<I>(recording, config, setup, |pairs| {
        let equal = pairs.len() == reference[lists].len()
            && pairs.iter().zip(&reference[lists]).all(|(pair, known)| pair.map(Index::slot) == *known);
        assert!(equal, "{name} {setup:?} in {} bits: list {lists}", 8 * size_of::<I>());
        lists += 1;
    });
    assert_eq!(lists, reference.len());
}

/// Each kernel and job system, for the recordings that `of` picks: the largest one takes as long as all others.
fn on_every_setup(of: impl Fn(&Recording) -> bool) {
    let jobs =
        [Jobs::Serial, Jobs::Threads(1), Jobs::Threads(2), Jobs::Threads(3), Jobs::Threads(8), Jobs::Crowd];
    for recording in recordings::all().iter().filter(|recording| of(recording)) {
        let mut modes = Vec::new();
        for (_, config) in configs() {
            let reference = told(recording, config);
            for setup in Setup::each(&jobs) {
                compare::<u32>(recording, config, setup, &reference);
                compare::<u16>(recording, config, setup, &reference);
            }
            modes.push(reference);
        }
        assert_ne!(modes[0], modes[2], "fat pairs are others, or there is nothing to compare");
    }
}

#[test]
fn small_recordings_are_equal_over_kernels_workers_and_index_widths() {
    on_every_setup(|recording| recording.objects() < LARGE);
}

#[test]
fn large_recordings_are_equal_over_kernels_workers_and_index_widths() {
    assert!(recordings::all().iter().any(|recording| recording.objects() >= LARGE));
    on_every_setup(|recording| recording.objects() >= LARGE);
}

/// Objects of a large recording.
const LARGE: usize = 5000;

/// The other half: what is equal on one machine is also what all other targets say. Who changes the order of pairs writes the
/// table anew: `cargo run --release -p trisap-runs --bin golden > tests/golden.txt`.
#[test]
fn hashes_are_those_of_all_targets() {
    assert_eq!(golden::table(Setup::REFERENCE), golden::TABLE, "not the hashes of tests/golden.txt");
}
