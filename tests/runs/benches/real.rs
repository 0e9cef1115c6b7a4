//! Times of whole steps in scenes of games: `cargo bench -p trisap-runs --bench real`.
//!
//! What is to be compared stands side by side: the same layer of cubes without a ground and on one without end, and a world that
//! has lived through a spawn or a hitch beside a fresh one on the same frames. Every box of the next frame is handed
//! over; frames run forwards and backwards in turn.

// The macro of criterion makes a public function.
#![allow(missing_docs)]

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Duration;
use trisap::scene::real::{Ground, HITCH_FRAME, Kind, Scene, Setup};
use trisap::{Aabb, Boxes, Capacity, Config, Filter, OwnedWorld, World};

type Frame = Vec<Aabb>;

/// Steps after what is sudden, and the frames that are timed then.
const AFTER: u32 = 8;
const TIMED: u32 = 9;

fn frames(kind: Kind, count: u32, frames: u32) -> Vec<Frame> {
    let mut scene = Scene::new(Setup { kind, count, seed: 1 }).expect("a good number of boxes");
    let next = |_| {
        let boxes = scene.boxes().to_vec();
        scene.advance();
        boxes
    };
    (0..frames).map(next).collect()
}

/// With room for so many pairs.
fn memory(count: u32, pairs: u32) -> OwnedWorld<u32> {
    OwnedWorld::new(&Config::new(Capacity::for_objects(count).with_pairs(pairs))).expect("memory")
}

fn step(world: &mut World<'_, u32>, frame: &Frame) -> usize {
    let step = world.step_over(Boxes::new(frame));
    step.expect("room for the pairs").pairs().len()
}

/// A world that has lived through these frames.
fn lived<'m>(memory: &'m mut OwnedWorld<u32>, frames: &[Frame]) -> World<'m, u32> {
    let mut world = memory.world();
    world.insert_many(Boxes::new(&frames[0])).expect("room");
    for frame in frames {
        step(&mut world, frame);
    }
    world
}

/// Times steps over frames that run to and fro, of which the world has just made the first.
fn to_and_fro(bencher: &mut criterion::Bencher<'_>, mut world: World<'_, u32>, frames: &[Frame]) {
    let order: Vec<usize> = (1..frames.len()).chain((0..frames.len() - 1).rev()).collect();
    let mut next = order.iter().cycle();
    bencher.iter(|| black_box(step(&mut world, &frames[*next.next().unwrap_or(&0)])));
}

fn real(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("real");
    for count in [1000, 8000, 32_000] {
        for ground in [Ground::None, Ground::Infinite].map(Kind::Ground) {
            let frames = frames(ground, count, TIMED);
            group.bench_function(BenchmarkId::new(ground.name(), count), |bencher| {
                let mut memory = memory(count, 4 * count);
                to_and_fro(bencher, lived(&mut memory, &frames[..1]), &frames);
            });
        }
    }
    // Every pair of spawned boxes overlaps at first, and a large box has a few hundred.
    for (kind, sudden, count, pairs) in
        [(Kind::Spawn, 0, 8000, 8000 * 4000), (Kind::Hitch, HITCH_FRAME, 32_000, 32_000 * 200)]
    {
        let frames = frames(kind, count, sudden + AFTER + TIMED);
        let begin = (sudden + AFTER) as usize;
        for (name, first) in [("lived through", 0), ("fresh world", begin)] {
            group.bench_function(BenchmarkId::new(format!("{kind}, {name}"), count), |bencher| {
                let mut memory = memory(count, pairs);
                to_and_fro(bencher, lived(&mut memory, &frames[first..=begin]), &frames[begin..]);
            });
        }
    }
}

/// Filters that let every pair pass, as a world without filters, as all objects have them at first, and as groups.
fn filters(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("filters that let everything pass");
    for kind in [Kind::Ground(Ground::Infinite), Kind::Level, Kind::Flat] {
        let frames = frames(kind, 8000, TIMED);
        for (name, groups) in [("none", None), ("as at first", Some(false)), ("groups", Some(true))] {
            group.bench_function(BenchmarkId::new(kind.to_string(), name), |bencher| {
                let capacity = Capacity::for_objects(8000).with_pairs(200_000);
                let config = Config::new(capacity);
                let config = if groups.is_some() { config.with_filters() } else { config };
                let mut memory = OwnedWorld::<u32>::new(&config).expect("memory");
                let mut world = memory.world();
                let ids: Vec<_> = world.insert_many(Boxes::new(&frames[0])).expect("room").collect();
                if groups == Some(true) {
                    for (group, id) in (0..).zip(ids) {
                        let filter = Filter { class: group % 4, ..Filter::groups(1 << (group % 5), 0b11111) };
                        world.set_filter(id, filter).expect("a class and filters");
                    }
                }
                step(&mut world, &frames[0]);
                to_and_fro(bencher, world, &frames);
            });
        }
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(30)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1));
    targets = real, filters
}
criterion_main!(benches);
