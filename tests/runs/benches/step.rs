//! Times of whole steps: `cargo bench -p trisap-runs --bench step`, or a part of it: `cargo bench -p trisap-runs --bench step -- degenerate`.
//!
//! Every benchmark of steps but `crowd` hands over all boxes of the next frame; frames run forwards and backwards in turn. The
//! pairs of a degenerate world are printed beside its time as throughput, since most of its cost is writing them.

// The macro of criterion makes a public function.
#![allow(missing_docs)]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use memmap2::MmapMut;
use std::hint::black_box;
use std::time::Duration;
use trisap_core::{Aabb, Boxes, Capacity, Config, Id, Kernels, Margin, World, layout};

/// Numbers from 0 to 1, the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    fn corner(&mut self, side: f32) -> [f32; 3] {
        [(); 3].map(|()| self.next() * side)
    }
}

type Frame = Vec<Aabb>;

fn cube(min: [f32; 3], edge: f32) -> Aabb {
    Aabb::new(min, min.map(|x| x + edge))
}

/// The side of the space in which unit cubes are as dense as in the recorded Brownian scene.
fn side(count: usize) -> f32 {
    (count as f32 * 8.0).cbrt()
}

fn cubes(count: usize) -> Frame {
    let mut random = Random(7);
    (0..count).map(|_| cube(random.corner(side(count)), 1.0)).collect()
}

/// Eight frames in which each box moves with this probability, by up to `length` on each axis.
fn moving(first: Frame, share: f32, length: f32) -> Vec<Frame> {
    let mut random = Random(11);
    let mut frames = vec![first];
    while frames.len() < 8 {
        let mut next = frames[frames.len() - 1].clone();
        for aabb in &mut next {
            if random.next() < share {
                let [x, y, z] = random.corner(2.0 * length).map(|x| x - length);
                for corner in [&mut aabb.min, &mut aabb.max] {
                    *corner = [corner[0] + x, corner[1] + y, corner[2] + z];
                }
            }
        }
        frames.push(next);
    }
    frames
}

/// A world in memory of its own, on Linux in huge pages, as `OwnedWorld` of the crate `trisap` takes it.
struct Fixture {
    slab: MmapMut,
    config: Config,
}

impl Fixture {
    fn new(config: Config) -> Self {
        let bytes = layout::<u32>(&config).expect("a layout").bytes;
        let mut slab = MmapMut::map_anon(bytes.next_multiple_of(2 << 20)).expect("memory");
        #[cfg(target_os = "linux")]
        slab.advise(memmap2::Advice::HugePage).ok();
        slab.fill(0);
        Self { slab, config }
    }

    /// A world that has made one step over the boxes.
    fn world(&mut self, boxes: &[Aabb], kernels: Kernels) -> World<'_> {
        let mut world = World::new_in(&mut self.slab, &self.config).expect("a world");
        world.insert_many(Boxes::new(boxes)).expect("room");
        world.set_kernels(kernels).step().expect("room for the pairs");
        world
    }
}

fn config(objects: usize, pairs: usize) -> Config {
    Config::new(Capacity::for_objects(objects as u32).with_leaf_refs(objects as u32).with_pairs(pairs as u32))
}

/// Times steps over frames that run to and fro. Returns the pairs of the last one.
fn steps(bencher: &mut criterion::Bencher<'_>, config: Config, frames: &[Frame], kernels: Kernels) {
    let mut fixture = Fixture::new(config);
    let mut world = fixture.world(&frames[0], kernels);
    let order: Vec<usize> = (1..frames.len()).chain((0..frames.len() - 1).rev()).collect();
    let mut next = order.iter().cycle();
    bencher.iter(|| {
        let frame = &frames[*next.next().unwrap_or(&0)];
        let step = world.set_kernels(kernels).step_over(Boxes::new(frame)).expect("room for the pairs");
        black_box(step.pairs().len())
    });
}

fn pairs_of(boxes: &[Aabb], room: usize) -> usize {
    let mut fixture = Fixture::new(config(boxes.len(), room));
    fixture.world(boxes, Kernels::detect()).pairs().len()
}

fn build(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("build");
    for count in [1000, 8000, 32_000] {
        let boxes = cubes(count);
        let mut fixture = Fixture::new(config(count, 20 * count));
        group.bench_function(BenchmarkId::from_parameter(count), |bencher| {
            bencher.iter(|| fixture.world(&boxes, Kernels::detect()).pairs().len());
        });
    }
}

fn full(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("full");
    for count in [1000, 8000, 32_000, 128_000] {
        let frames = moving(cubes(count), 1.0, 0.2);
        for kernels in Kernels::all() {
            group.bench_function(BenchmarkId::new(kernels.name(), count), |bencher| {
                steps(bencher, config(count, 20 * count), &frames, kernels);
            });
        }
        group.bench_function(BenchmarkId::new("events", count), |bencher| {
            steps(bencher, config(count, 20 * count).with_events(), &frames, Kernels::detect());
        });
    }
}

fn movers(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("movers");
    let count = 128_000;
    for (name, share) in [("0 %", 0.0), ("0.1 %", 0.001), ("1 %", 0.01), ("10 %", 0.1), ("100 %", 1.0)] {
        let frames = moving(cubes(count), share, 0.2);
        group.bench_function(name, |bencher| {
            steps(bencher, config(count, 20 * count), &frames, Kernels::detect());
        });
    }
    let frames: Vec<Frame> = (0..8)
        .map(|seed| {
            let mut random = Random(seed);
            (0..count).map(|_| cube(random.corner(side(count)), 1.0)).collect()
        })
        .collect();
    group.bench_function("all teleport", |bencher| {
        steps(bencher, config(count, 20 * count), &frames, Kernels::detect());
    });
}

/// Objects of a crowd of which nearly all rest, and how many do not.
const CROWD: usize = 1_000_000;
const RESTLESS: usize = 1000;

/// Where a cube goes in the next frame, from a random number, where it is, and a pace of its own.
type Motion = fn(&mut Random, [f32; 3], [f32; 3]) -> [f32; 3];

/// By up to a tenth of its size on each axis, another way in each frame or straight on; or anywhere.
const MOTIONS: [(&str, Motion); 3] = [
    ("to and fro", |random, from, _| onwards(from, random.corner(0.2))),
    ("straight on", |_, from, pace| onwards(from, pace)),
    ("anywhere", |random, _, _| random.corner(side(CROWD))),
];

fn onwards(from: [f32; 3], pace: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|k| from[k] + pace[k] - 0.1)
}

/// Only those who move are handed over; with found and lost pairs. Those who move have a margin, or nobody has.
fn crowd(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("crowd");
    let (boxes, kernels) = (cubes(CROWD), Kernels::detect());
    let movers: Frame = boxes.iter().copied().step_by(CROWD / RESTLESS).collect();
    let plain = config(CROWD, 4 * CROWD).with_events();
    let margins = plain.with_margin(Margin::length(0.0)).with_fixed_margins();
    for (margin_name, margin, config) in
        [("no margin", 0.0, plain), ("margin 0.3", 0.3, margins), ("margin 0.5", 0.5, margins)]
    {
        let mut fixture = Fixture::new(config);
        let mut world = fixture.world(&boxes, kernels);
        let slots = (0..CROWD as u32).step_by(CROWD / RESTLESS);
        let ids: Vec<Id> = slots.filter_map(|slot| world.id_at(slot)).collect();
        if config.margin.is_some() {
            ids.iter().for_each(|id| world.set_margin(*id, margin).expect("a living object"));
        }
        for (name, motion) in MOTIONS {
            let mut random = Random(13);
            let paces: Vec<[f32; 3]> = movers.iter().map(|_| random.corner(0.2)).collect();
            let mut frames = vec![movers.clone()];
            while frames.len() < 64 {
                let last = frames[frames.len() - 1].iter().zip(&paces);
                let next = last.map(|(aabb, pace)| cube(motion(&mut random, aabb.min, *pace), 1.0)).collect();
                frames.push(next);
            }
            let order: Vec<usize> = (1..frames.len()).chain((0..frames.len() - 1).rev()).collect();
            let mut next = order.iter().cycle();
            let mut step = || {
                let frame = &frames[*next.next().unwrap_or(&0)];
                world.update_many(&ids, Boxes::new(frame)).expect("living objects");
                let step = world.set_kernels(kernels).step().expect("room for the pairs");
                black_box(step.found().len() + step.lost().len())
            };
            // Until all leaves are divided.
            for _ in 0..200 {
                step();
            }
            group.bench_function(BenchmarkId::new(name, margin_name), |bencher| bencher.iter(&mut step));
        }
    }
}

fn churn(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("churn");
    for count in [8000, 32_000] {
        let boxes = cubes(count);
        let tenth = count / 10;
        let mut fixture = Fixture::new(config(count, 20 * count));
        let mut world = World::<u32>::new_in(&mut fixture.slab, &fixture.config).expect("a world");
        let mut ids: Vec<Id> = world.insert_many(Boxes::new(&boxes)).expect("room").collect();
        let mut first = 0;
        group.bench_function(BenchmarkId::new("remove and insert 10 %", count), |bencher| {
            bencher.iter(|| {
                world.remove_many(&ids[first..first + tenth]).expect("living objects");
                let new = world.insert_many(Boxes::new(&boxes[first..first + tenth])).expect("room");
                for (id, new) in ids[first..].iter_mut().zip(new) {
                    *id = new;
                }
                first = (first + tenth) % (10 * tenth);
                world.step().expect("room for the pairs").pairs().len()
            });
        });
    }
}

/// Snapshots of a world with found and lost pairs, all of whose objects move. Throughput is the bytes of a snapshot; how many
/// that are an object is in the name.
fn snapshot(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("snapshot");
    let count = 8000;
    let (frames, kernels) = (moving(cubes(count), 1.0, 0.2), Kernels::detect());
    let mut fixture = Fixture::new(config(count, 20 * count).with_events());
    let mut world = fixture.world(&frames[0], kernels);
    for frame in &frames {
        world.set_kernels(kernels).step_over(Boxes::new(frame)).expect("room for the pairs");
    }
    let mut bytes = vec![0; world.snapshot_size()];
    let name = format!("{count}, {:.1} bytes an object", bytes.len() as f64 / count as f64);
    group.throughput(Throughput::Bytes(bytes.len() as u64));
    group.bench_function(BenchmarkId::new("save", &name), |bencher| {
        bencher.iter(|| world.save(&mut bytes).expect("room"));
    });
    group.bench_function(BenchmarkId::new("load", &name), |bencher| {
        bencher.iter(|| world.load(&bytes).expect("a snapshot of this world"));
    });
    let mut other = Fixture::new(config(count, 20 * count).with_events());
    let mut other = other.world(&frames[0], kernels);
    group.bench_function(BenchmarkId::new("copy", &name), |bencher| {
        bencher.iter(|| other.copy_from(&world).expect("the same configuration"));
    });
    // The first step after a load finds all pairs anew.
    group.bench_function(BenchmarkId::new("load and a step", &name), |bencher| {
        bencher.iter(|| {
            world.load(&bytes).expect("a snapshot of this world");
            world.set_kernels(kernels).step().expect("room for the pairs");
        });
    });
}

fn small(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("small");
    for count in [32, 64, 128, 256, 1000] {
        let frames = moving(cubes(count), 1.0, 0.2);
        group.bench_function(BenchmarkId::from_parameter(count), |bencher| {
            steps(bencher, config(count, 20 * count), &frames, Kernels::detect());
        });
    }
}

fn degenerate(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("degenerate");
    let count = 4000;
    let mut random = Random(3);
    let flat_side = (count as f32 * 4.0).sqrt();
    let mut worlds: Vec<(&str, Frame)> = vec![("uniform", cubes(count))];
    let flat = |_| {
        let [x, y, _] = random.corner(flat_side);
        cube([x, y, 0.0], 1.0)
    };
    worlds.push(("flat", (0..count).map(flat).collect()));
    let mut random = Random(4);
    let line = |_| cube([random.next() * count as f32 * 0.5, 0.0, 0.0], 1.0);
    worlds.push(("line", (0..count).map(line).collect()));
    worlds.push(("all identical", vec![cube([1.0; 3], 1.0); count]));
    let mut huge = cubes(count);
    huge[count / 2] = cube([-10.0; 3], side(count) + 20.0);
    worlds.push(("one huge", huge));
    let mut random = Random(5);
    let clustered = |i: usize| {
        let reach = if i.is_multiple_of(10) { 8.0 } else { 1.0 };
        cube(random.corner(side(count) * reach), 1.0)
    };
    worlds.push(("90 % clustered", (0..count).map(clustered).collect()));
    let mut random = Random(6);
    let sizes = |_| {
        let edge = 10f32.powf(6.0 * random.next() - 3.0);
        cube(random.corner(4.0 * side(count)), edge)
    };
    worlds.push(("size ratio 1e6", (0..count).map(sizes).collect()));
    for (name, boxes) in worlds {
        let room = count * count / 2;
        group.throughput(Throughput::Elements(pairs_of(&boxes, room) as u64));
        // Moved by an amount that all boxes share, so that every one counts as moved and no pair changes.
        let shift =
            |by: f32| boxes.iter().map(|b| Aabb::new(b.min.map(|x| x + by), b.max.map(|x| x + by))).collect();
        let frames = [shift(0.0), shift(0.25)];
        group.bench_function(name, |bencher| steps(bencher, config(count, room), &frames, Kernels::detect()));
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(30)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1));
    targets = build, full, movers, crowd, churn, snapshot, small, degenerate
}
criterion_main!(benches);
