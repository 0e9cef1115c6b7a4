//! 92,683 identical boxes make more pairs than 32 bits can count: the step must tell their exact number, on every
//! kernel, and leave a valid world. Slow, as every pair is tested.
//!
//! ```text
//! cargo run --release -p trisap-runs --bin overflow
//! ```

use std::process::ExitCode;
use std::time::Instant;
use trisap_core::{Boxes, Config, Error, Kernels, World};
use trisap_tests::jobs::Jobs;
use trisap_tests::scenes;
use trisap_tests::worlds::{Slab, ample};

const COUNT: usize = 92_683;

fn main() -> ExitCode {
    let needed = COUNT as u64 * (COUNT as u64 - 1) / 2;
    assert!(needed > u64::from(u32::MAX));
    let config = Config::new(ample(COUNT, 1000)).with_events().with_workers(2);
    let boxes = scenes::identical(COUNT);
    let mut failures = 0;
    for kernels in Kernels::all() {
        let mut slab = Slab::new::<u32>(&config);
        let mut world: World<'_> = slab.world(&config);
        world.insert_many(Boxes::new(&boxes)).expect("room for all");
        let start = Instant::now();
        let error = world.set_kernels(kernels).on(&Jobs::Threads(2)).step().err();
        let time = start.elapsed();
        let good = error == Some(Error::PairsFull { needed, room: 1000 })
            && world.pairs().len() == 1000
            && world.found().is_empty()
            && world.lost().is_empty()
            && world.validate().is_ok();
        failures += u32::from(!good);
        println!("{}: {error:?} in {time:.1?}, {}", kernels.name(), if good { "right" } else { "WRONG" });
    }
    if failures == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
