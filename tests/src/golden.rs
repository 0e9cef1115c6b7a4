//! One hash over everything that a run says, and the table of these hashes, which is the same on every target.

use crate::doing::On as _;
use crate::recordings::{self, Recording};
use crate::worlds::{Setup, Slab, ample};
use std::fmt::Write as _;
use trisap_core::{Boxes, Config, Index, Margin, Mode, Pair, World};

/// The table that is checked in: a recording, what is reported, the hash.
pub const TABLE: &str = include_str!("../golden.txt");

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

/// What is hashed of each recording, and its name in the table.
#[must_use]
pub fn configs() -> [(&'static str, Config); 3] {
    let plain = Config::new(ample(0, 0)).with_events();
    let margin = plain.with_margin(Margin::share(0.1));
    [("exact", plain), ("margin", margin), ("fat", margin.with_mode(Mode::Fat))]
}

/// Tells the pairs, the found and the lost of all frames, in their order.
///
/// # Panics
/// If the recording does not fit.
pub fn play<I: Index>(recording: &Recording, config: Config, setup: Setup, mut tell: impl FnMut(&[Pair<I>])) {
    let objects = recording.objects();
    let config = setup.configure(config.with_capacity(ample(objects, 40 * objects)));
    let mut slab = Slab::new::<I>(&config);
    let mut world: World<'_, I> = slab.world(&config);
    world.insert_many(Boxes::padded(&recording.frames[0])).expect("room for all");
    for frame in &recording.frames {
        let step = world.under(&setup).step_over(Boxes::padded(frame)).expect("room for all");
        tell(step.pairs());
        tell(step.found());
        tell(step.lost());
    }
}

/// One number for all of it.
#[must_use]
pub fn hash<I: Index>(recording: &Recording, config: Config, setup: Setup) -> u64 {
    let mut fnv = Fnv(0xcbf2_9ce4_8422_2325);
    play::<I>(recording, config, setup, |pairs| fnv.pairs(pairs));
    fnv.0
}

/// The table for the recordings of the repository, by this target on these kernels, on one thread.
#[must_use]
pub fn table(setup: Setup) -> String {
    let mut table = String::new();
    for recording in recordings::own() {
        for (name, config) in configs() {
            let hash = hash::<u32>(&recording, config, setup);
            writeln!(table, "{} {name} {hash:016x}", recording.name).expect("room in a string");
        }
    }
    table
}
