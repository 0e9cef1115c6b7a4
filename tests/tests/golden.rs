//! Determinism: one hash over everything that a run says, equal for all kernels, job systems and numbers of
//! workers.

use trisap_core::{Boxes, Config, Index, Margin, Mode, Pair, World};
use trisap_tests::jobs::Jobs;
use trisap_tests::recordings::{self, Recording};
use trisap_tests::worlds::{Setup, Slab, ample};

/// 64-bit FNV-1a.
struct Fnv(u64);

impl Fnv {
    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// The length keeps apart what follows one another.
    fn pairs<I: Index>(&mut self, pairs: &[Pair<I>]) {
        self.write(&(pairs.len() as u64).to_le_bytes());
        pairs.iter().flatten().for_each(|slot| self.write(&slot.slot().to_le_bytes()));
    }
}

/// The pairs, the found and the lost of all frames, in their order.
fn hash<I: Index>(recording: &Recording, config: Config, setup: Setup) -> u64 {
    let objects = recording.objects();
    let config = setup.configure(Config { capacity: ample(objects, 40 * objects), ..config });
    let mut slab = Slab::new::<I>(&config);
    let mut world: World<'_, I> = slab.world(&config);
    world.insert_many(Boxes::padded(&recording.frames[0]), &mut vec![None; objects]).expect("room for all");
    let mut fnv = Fnv(0xcbf2_9ce4_8422_2325);
    for frame in &recording.frames {
        let step = world.step_over(Boxes::padded(frame), setup.kernels, &setup.jobs).expect("room for all");
        fnv.pairs(step.pairs());
        fnv.pairs(step.found());
        fnv.pairs(step.lost());
    }
    fnv.0
}

#[test]
fn hashes_are_equal_over_kernels_workers_and_index_widths() {
    let plain = Config::new(ample(0, 0)).with_events();
    let margin = plain.with_margin(Margin::share(0.1));
    let jobs =
        [Jobs::Serial, Jobs::Threads(1), Jobs::Threads(2), Jobs::Threads(3), Jobs::Threads(8), Jobs::Crowd];
    for recording in recordings::all() {
        let mut hashes = Vec::new();
        for config in [plain, margin, margin.with_mode(Mode::Fat)] {
            let reference = hash::<u32>(&recording, config, Setup::REFERENCE);
            for setup in Setup::each(&jobs) {
                let name = &recording.name;
                assert_eq!(
                    hash::<u32>(&recording, config, setup),
                    reference,
                    "{name} {setup:?} {:?}",
                    config.mode
                );
                assert_eq!(hash::<u16>(&recording, config, setup), reference, "{name} {setup:?} in 16 bits");
            }
            hashes.push(reference);
        }
        assert_ne!(hashes[0], hashes[2], "a hash that does not see the pairs");
    }
}
