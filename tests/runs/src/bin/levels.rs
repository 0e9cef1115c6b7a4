//! The time of a step on each level of vectors of this CPU, beside scalar code: `cargo run --release -p trisap-runs --bin levels`.
//!
//! Each frame of each recording is stepped by every level in turn, forwards and backwards, so that a busy machine is busy for all of
//! them. Medians over all frames, and of the ratios frame by frame.

use std::time::Instant;
use trisap_core::{Boxes, Config, Kernels, World};
use trisap_tests::recordings;
use trisap_tests::worlds::{Slab, ample};

/// Frames a recording and level.
const FRAMES: usize = 400;

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() {
    let levels: Vec<Kernels> = Kernels::all().collect();
    for recording in recordings::own() {
        let objects = recording.objects();
        let config = Config::new(ample(objects, 20 * objects)).without_predicted_boxes();
        let mut slabs: Vec<Slab> = levels.iter().map(|_| Slab::new::<u32>(&config)).collect();
        let mut worlds: Vec<World<'_>> = slabs.iter_mut().map(|slab| slab.world(&config)).collect();
        for world in &mut worlds {
            world.insert_many(Boxes::padded(&recording.frames[0])).expect("room for all");
        }
        let there_and_back = recording.frames.iter().chain(recording.frames.iter().rev());
        let mut times = vec![Vec::new(); levels.len()];
        for (number, frame) in there_and_back.cycle().take(FRAMES + 20).enumerate() {
            let mut pairs = None;
            for ((world, &kernels), times) in worlds.iter_mut().zip(&levels).zip(&mut times) {
                let start = Instant::now();
                let step =
                    world.set_kernels(kernels).step_over(Boxes::padded(frame)).expect("room for the pairs");
                let time = start.elapsed().as_secs_f64();
                let found = step.pairs().len();
                assert_eq!(*pairs.get_or_insert(found), found, "{} differs", kernels.name());
                // The first steps make the tree.
                if number >= 20 {
                    times.push(1e6 * time);
                }
            }
        }
        for (kernels, own) in levels.iter().zip(&times) {
            let ratios = own.iter().zip(&times[0]).map(|(own, first)| own / first).collect();
            let [time, ratio] = [own.clone(), ratios].map(median);
            println!(
                "{}, {}: {time:.1} µs a step, {ratio:.3} of {}",
                recording.name,
                kernels.name(),
                levels[0].name()
            );
        }
    }
}
