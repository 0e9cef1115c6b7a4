//! Steps are cut into blocks for many workers: gates by counts, in a model of workers that run in turns. What a step would take is
//! printed by `trisap run --workers-model`.

use trisap::model::{Course, Job, Workers, blocks};
use trisap_core::{Boxes, Capacity, Config, Kernels, Serial, Stage, World};
use trisap_tests::scenes::Brownian;
use trisap_tests::worlds::Slab;

/// The last of some steps in which all move, with events. The result is that of one thread.
fn step(count: usize, workers: u32) -> Course {
    let capacity = Capacity::for_objects(count as u32).with_pairs(8 * count as u32);
    let config = Config::new(capacity).with_events();
    let shared = config.with_workers(workers);
    let mut slabs = [Slab::new::<u32>(&config), Slab::new::<u32>(&shared)];
    let [alone, together] = &mut slabs;
    let mut worlds: [World<'_>; 2] = [alone.world(&config), together.world(&shared)];
    let mut scene = Brownian::new(count, 1);
    let executor = Workers::new(workers, 0, blocks);
    for world in &mut worlds {
        world.set_kernels(Kernels::detect());
        world.insert_many(Boxes::new(scene.boxes())).expect("room for all");
    }
    for _ in 0..8 {
        scene.advance();
        let [alone, together] = &mut worlds;
        alone.on(&Serial).step_over(Boxes::new(scene.boxes())).expect("room for all");
        together.on(&executor).step_over(Boxes::new(scene.boxes())).expect("room for all");
        assert!(alone.pairs() == together.pairs(), "other pairs");
        assert!(alone.found() == together.found() && alone.lost() == together.lost(), "other events");
    }
    executor.course()
}

#[test]
fn every_job_has_blocks_for_many_workers() {
    let course = step(32_000, 16);
    for stage in [Stage::Intake, Stage::Fill, Stage::Sweep, Stage::Results] {
        assert!(course.jobs_of(stage).count() > 0, "nothing of {stage:?} is shared: {course:?}");
    }
    // A pass over all, walks down the tree for objects that left their leaf, and two passes over the leaves.
    assert_eq!(course.jobs_of(Stage::Fill).count(), 4, "{course:?}");
    for job in &course.jobs {
        assert!(job.work >= 5 * job.span, "{job:?}");
    }
    let of = |read: fn(&Job) -> u64| course.jobs.iter().map(read).sum::<u64>();
    assert!(of(|job| job.work) >= 10 * of(|job| job.span), "{course:?}");
}

#[test]
fn a_model_of_workers_repeats() {
    assert_eq!(step(8_000, 12), step(8_000, 12));
}
