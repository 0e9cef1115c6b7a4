//! Steps through recordings for `tests/instructions.sh`, which counts the instructions of [`measured`] under callgrind, and for
//! `tests/targets.sh`, which counts those of the whole program.
//!
//! The recording, the kernels and, if not ten, the number of steps are the arguments. Without any it prints the kernels of this
//! CPU.

use trisap_core::{Boxes, Config, Kernels, World};
use trisap_tests::recordings;
use trisap_tests::worlds::{Slab, ample};

fn main() {
    if std::env::args().len() == 1 {
        Kernels::all().for_each(|kernels| println!("{}", kernels.name()));
        return;
    }
    let [name, kernels] = [1, 2].map(|index| std::env::args().nth(index).expect("a recording and kernels"));
    let kernels = Kernels::by_name(&kernels).expect("kernels of this CPU");
    let recording =
        recordings::all().into_iter().find(|r| r.name == name).expect("a recording of the repository");
    let objects = recording.objects();
    let config = Config::new(ample(objects, 20 * objects)).with_events();
    let mut slab = Slab::new::<u32>(&config);
    let mut world: World<'_> = slab.world(&config);
    world.insert_many(Boxes::padded(&recording.frames[0])).expect("room for all");
    // The first step builds: it is not what later ones cost.
    world.set_kernels(kernels).step().expect("room for the pairs");
    let steps = std::env::args().nth(3).map_or(10, |steps| steps.parse().expect("a number of steps"));
    let frames = &recording.frames[1..recording.frames.len().min(1 + steps)];
    let pairs = measured(&mut world, frames, kernels);
    println!("{} object steps, {pairs} pairs", frames.len() * objects);
}

#[inline(never)]
fn measured(world: &mut World<'_>, frames: &[Vec<[f32; 8]>], kernels: Kernels) -> usize {
    let mut pairs = 0;
    for frame in frames {
        pairs += world
            .set_kernels(kernels)
            .step_over(Boxes::padded(frame))
            .expect("room for the pairs")
            .pairs()
            .len();
    }
    pairs
}
