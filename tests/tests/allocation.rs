//! P2, the other half: after construction nothing allocates, on the calling thread or on any that helps.

use allocation_counter::{measure, opt_out};
use std::hint::black_box;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use trisap_core::{Aabb, Boxes, Config, Executor, Id, Kernels, Margin, Mode, World};
use trisap_tests::scenes::{self, Brownian, Rng};
use trisap_tests::worlds::{Slab, ample};

/// Threads whose own making is not counted, but all that the job does on them is.
struct Counted {
    workers: u32,
    allocations: AtomicU64,
    joins: AtomicU64,
}

impl Executor for Counted {
    fn workers(&self) -> u32 {
        self.workers
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        self.joins.fetch_add(1, Ordering::Relaxed);
        let counted = || {
            let allocations = measure(job).count_total;
            self.allocations.fetch_add(allocations, Ordering::Relaxed);
        };
        opt_out(|| {
            thread::scope(|scope| {
                for _ in 0..width {
                    scope.spawn(counted);
                }
            });
        });
    }
}

#[test]
fn the_counter_counts() {
    assert_eq!(measure(|| drop(black_box(vec![1, 2, 3]))).count_total, 1);
    assert_eq!(measure(|| opt_out(|| drop(black_box(vec![1, 2, 3])))).count_total, 0);
    let counted = Counted { workers: 2, allocations: AtomicU64::new(0), joins: AtomicU64::new(0) };
    let here = measure(|| counted.fork_join(2, &|| drop(black_box(vec![1, 2, 3])))).count_total;
    assert_eq!((here, counted.allocations.into_inner()), (0, 2));
}

/// A life of a world with everything in it, from the first object to the last.
fn live(config: Config, count: usize, kernels: Kernels, workers: u32) {
    let config = config.with_capacity(ample(count + 10, 30 * count)).with_events().with_workers(workers);
    let mut slab = Slab::new::<u32>(&config);
    let mut rng = Rng::new(1);
    let mut scene = Brownian::new(count, 1);
    let mut frames: Vec<Vec<Aabb>> = vec![scene.boxes().to_vec()];
    for _ in 0..3 {
        frames.push(scene.advance().to_vec());
    }
    let mut few = frames[3].clone();
    scenes::walk(&mut few, 5, 1.0, &mut rng);
    frames.extend([few.clone(), few, scenes::uniform(count, 2), scenes::clustered(count, 3)]);
    let mut known: Vec<Id> = Vec::with_capacity(count);
    let counted = Counted { workers, allocations: AtomicU64::new(0), joins: AtomicU64::new(0) };
    let mut pairs = 0;

    let here = measure(|| {
        let mut world = World::<u32>::new_in(slab.bytes_mut(), &config).expect("room");
        known.extend(world.insert_many(Boxes::new(&frames[0])).expect("room"));
        world.set_kernels(kernels).on(&counted).step().expect("room");
        for frame in &frames {
            let step = world.set_kernels(kernels).on(&counted).step_over(Boxes::new(frame)).expect("room");
            pairs += step.pairs().len() + step.surplus() as usize;
        }
        world.update_many(&known, Boxes::new(&frames[1])).expect("living objects");
        world.set_kernels(kernels).on(&counted).step().expect("room");
        let last = world.insert(frames[0][0]).expect("room");
        world.set_aabb(last, frames[0][1]).expect("a living object");
        assert_eq!(world.set_margin(last, 0.5).is_ok(), config.margin.is_some());
        world.set_kernels(kernels).on(&counted).step().expect("room");
        world.remove(last).expect("a living object");
        world.remove_many(&known[..count / 2]).expect("living objects");
        world.set_kernels(kernels).on(&counted).step().expect("room");
        // Failures allocate nothing either.
        assert!(world.remove(last).is_err() && world.insert(Aabb::new([1.0; 3], [0.0; 3])).is_err());
        let mut world = World::<u32>::open(slab.bytes_mut()).expect("the same world");
        world.set_kernels(kernels).on(&counted).step().expect("room");
        world.validate().expect("a valid world");
    });
    assert_eq!(here.count_total, 0, "allocations on the calling thread");
    assert_eq!(counted.allocations.into_inner(), 0, "allocations on the others");
    assert!(pairs > 0);
    assert_eq!(
        counted.joins.into_inner() > 0,
        workers > 1 && count > 1000,
        "help was asked for where there is some"
    );
}

#[test]
fn p2_nothing_allocates_after_construction() {
    for kernels in Kernels::all() {
        let plain = Config::new(ample(0, 0));
        let margin = plain.with_margin(Margin::length(0.05));
        for config in [plain, margin, margin.with_mode(Mode::Fat)] {
            for count in [300, 8000] {
                for workers in [1, 2] {
                    live(config, count, kernels, workers);
                }
            }
        }
    }
}

#[test]
fn a_full_buffer_allocates_nothing() {
    let boxes = scenes::uniform(3000, 4);
    for workers in [1, 2] {
        let config = Config::new(ample(3000, 10)).with_events().with_workers(workers);
        let mut slab = Slab::new::<u32>(&config);
        let counted = Counted { workers, allocations: AtomicU64::new(0), joins: AtomicU64::new(0) };
        let here = measure(|| {
            let mut world = World::<u32>::new_in(slab.bytes_mut(), &config).expect("room");
            world.insert_many(Boxes::new(&boxes)).expect("room");
            for _ in 0..3 {
                assert!(world.on(&counted).step().is_err());
            }
        });
        assert_eq!((here.count_total, counted.allocations.into_inner()), (0, 0));
    }
}

/// The keyed world stays open: single calls by known keys allocate nothing, in whatever order they come.
#[test]
fn calls_by_known_keys_allocate_nothing() {
    use trisap::{BroadPhase, Region};
    let boxes = scenes::uniform(500, 4);
    let mut keyed: BroadPhase<usize> = boxes.iter().copied().enumerate().collect();
    keyed.step().expect("room");
    let _ = keyed.as_world();
    let counted = measure(|| {
        for (key, aabb) in boxes.iter().enumerate() {
            assert!(!keyed.is_resting(&key) && keyed.update(&key, *aabb) == Ok(true));
            assert_eq!(keyed.insert(key, *aabb), Ok(()));
            assert!(keyed.set_resting(&key) && keyed.is_resting(&key) && keyed.wake(&key));
            assert_eq!(keyed.aabb(&key), Some(*aabb));
            let mut seen = 0;
            let visit = &mut |_| {
                seen += 1;
                std::ops::ControlFlow::Continue(())
            };
            keyed.visit_overlaps(&Region::Aabb(*aabb), visit).expect("a region");
            assert!(seen > 0);
        }
        keyed.extend(boxes.iter().copied().enumerate());
        assert_eq!(keyed.update_many(boxes.iter().copied().enumerate()), Ok(500));
    });
    assert_eq!(counted.count_total, 0);
}
