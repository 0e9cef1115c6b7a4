//! A world of 1,024,000 cubes in Brownian motion: every frame is compared with an independent sweep, and every
//! allocation after construction is counted. Fails if a pair is wrong or anything was allocated.
//!
//! ```text
//! cargo run --release -p trisap-runs --bin million -- [OBJECTS [FRAMES]]
//! ```

use allocation_counter::measure;
use std::process::ExitCode;
use std::time::Instant;
use trisap_core::{Boxes, Config, Kernels, World};
use trisap_tests::checked::slots;
use trisap_tests::scenes::Brownian;
use trisap_tests::worlds::{Slab, ample};
use trisap_tests::{oracle, sorted};

fn main() -> ExitCode {
    let mut numbers = std::env::args().skip(1).map(|argument| argument.parse().expect("a number"));
    let count: usize = numbers.next().unwrap_or(1_024_000);
    let frames: usize = numbers.next().unwrap_or(3);

    let mut config = Config::new(ample(count, 8 * count)).with_events();
    config.capacity.leaf_refs = count as u32 / 2;
    let mut slab = Slab::new::<u32>(&config);
    let kernels = Kernels::detect();
    println!("{count} objects, {} MB, {} kernels", slab.bytes().len() / 1_000_000, kernels.name());

    let mut world: World<'_> = slab.world(&config);
    let mut scene = Brownian::new(count, 1);
    let mut failures = 0;
    for frame in 0..=frames {
        if frame > 0 {
            scene.advance();
        }
        let start = Instant::now();
        let allocations = measure(|| {
            if frame == 0 {
                world.insert_many(Boxes::new(scene.boxes())).expect("room for all");
            }
            world.set_kernels(kernels).step_over(Boxes::new(scene.boxes())).expect("room for all");
        });
        let time = start.elapsed();
        let exact = sorted(&slots(world.pairs())) == oracle::sweep(&oracle::all_live(scene.boxes()));
        let sound = world.validate().is_ok();
        let good = exact && sound && allocations.count_total == 0;
        failures += u32::from(!good);
        println!(
            "frame {frame}: {time:.1?}, {} pairs {}, {} allocations, {}, {:?}",
            world.pairs().len(),
            if exact { "as swept independently" } else { "BUT NOT THE RIGHT ONES" },
            allocations.count_total,
            if sound { "valid" } else { "INVALID" },
            world.stats(),
        );
    }
    if failures == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
