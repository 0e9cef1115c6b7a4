//! Steps through recordings, and queries, for `tests/instructions.sh`, which counts the instructions of [`measured`] and
//! [`measured_queries`] under callgrind, and for `tests/targets.sh`, which counts those of the whole program.
//!
//! The recording, the kernels and, if not ten, the number of steps are the arguments; instead of a number also `quiet`, `quiet_events`,
//! `regions`, `nearest` or `rays`. Without any it prints the kernels of this CPU.

use trisap_core::{Aabb, Boxes, Cast, Config, Kernels, Path, Region, World};
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
    let what = std::env::args().nth(3).unwrap_or_else(|| "10".into());
    if ["quiet", "quiet_events"].contains(&what.as_str()) {
        let config = Config::new(ample(objects, 20 * objects));
        let config = if what == "quiet" { config } else { config.with_events() };
        let pairs = quiet(&config, &recording.frames[0], kernels);
        println!("{} object steps, {pairs} pairs", QUIET * objects);
        return;
    }
    // From here on steps that search, so worlds without predicted boxes.
    let config = Config::new(ample(objects, 20 * objects)).with_events().without_predicted_boxes();
    let mut slab = Slab::new::<u32>(&config);
    let mut world: World<'_> = slab.world(&config);
    world.insert_many(Boxes::padded(&recording.frames[0])).expect("room for all");
    // The first step builds: it is not what later ones cost.
    world.set_kernels(kernels).step().expect("room for the pairs");
    let Ok(steps) = what.parse::<usize>() else {
        // Calm steps, in which one object moves, until all leaves are divided.
        let id = world.id_at(0).expect("an object");
        let aabb = world.aabb(id).expect("an object");
        for step in 0..20u8 {
            let max = aabb.max.map(|side| side + 0.001 * f32::from(step));
            world.set_aabb(id, Aabb::new(aabb.min, max)).expect("a box");
            world.step().expect("room for the pairs");
        }
        assert!(world.stats().fine_leaves, "leaves are divided");
        let hits = measured_queries(&world, &recording.frames[0], &what);
        println!("{objects} object steps, {hits} hits");
        return;
    };
    let frames = &recording.frames[1..recording.frames.len().min(1 + steps)];
    let pairs = measured(&mut world, frames, kernels);
    println!("{} object steps, {pairs} pairs", frames.len() * objects);
}

/// Steps in which all objects move, but stay in their predicted boxes.
const QUIET: usize = 10;

fn quiet(config: &Config, boxes: &[[f32; 8]], kernels: Kernels) -> usize {
    let shifted =
        |step: usize| boxes.iter().map(|lanes| lanes.map(|side| side + 0.001 * (step % 2) as f32)).collect();
    let frames: Vec<Vec<[f32; 8]>> = (0..QUIET).map(shifted).collect();
    let mut slab = Slab::new::<u32>(config);
    let mut world: World<'_> = slab.world(config);
    world.insert_many(Boxes::padded(&frames[0])).expect("room for all");
    // Until predicted boxes are in use, and have been for some steps.
    for frame in frames.iter().cycle().take(20 * QUIET) {
        world.set_kernels(kernels).step_over(Boxes::padded(frame)).expect("room for the pairs");
    }
    let pairs = measured(&mut world, &frames, kernels);
    assert_eq!(world.stats().path, Path::Unchanged, "nobody has left");
    pairs
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

/// One query from each object, in a calm world with small leaves.
#[inline(never)]
fn measured_queries(world: &World<'_>, boxes: &[[f32; 8]], what: &str) -> usize {
    let mut out = [None; 8];
    let mut nearest = [None; 8];
    let mut found = 0;
    for (at, lanes) in boxes.iter().enumerate() {
        let point = [lanes[0], lanes[1], lanes[2]];
        let direction = [[1.0, 0.1, 0.2], [-0.3, 1.0, 0.1], [0.2, -0.1, -1.0]][at % 3];
        found += match what {
            "regions" => {
                let region = Region::Aabb(Aabb::new(point, point.map(|x| x + 1.5)));
                world.overlaps(&region, &mut out).unwrap_or(out.len())
            }
            "nearest" => world.nearest(point, &mut nearest).expect("a point"),
            "rays" => {
                let ray = Cast::ray(point.map(|x| x - 0.1), direction, f32::INFINITY);
                usize::from(world.first_hit(&ray).expect("a ray").is_some())
            }
            _ => panic!("{what} is no kind of query"),
        };
    }
    found
}
