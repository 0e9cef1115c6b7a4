//! Where a list is exactly full, a buffer runs out or a number begins again: edges that scenes seldom touch. Each test names
//! the change to the core that nothing else noticed.

use trisap_core::{Aabb, Config, Error, Id, Index, Path, World};
use trisap_tests::checked::Checked;
use trisap_tests::doing::On as _;
use trisap_tests::forced::{Choice, Forced as _};
use trisap_tests::forging::{FRONT, get, put, seal};
use trisap_tests::jobs::Jobs;
use trisap_tests::lives::saved;
use trisap_tests::scenes::{Rng, at, cube, shifted, uniform};
use trisap_tests::worlds::{Setup, Slab, ample};

/// An object that becomes large when the list of large objects is exactly full starts a step that fills all leaves anew.
/// In `large::has_room`, `<` for the last `<=` would fill them where there is room, and an end that is one less would drop it.
#[test]
fn a_mover_becomes_large_when_the_list_is_full() {
    const COUNT: usize = 1100;
    let places: Vec<[f32; 3]> =
        (0..COUNT).map(|k| [k % 11, k / 11 % 10, k / 110].map(|x| 3.0 * x as f32)).collect();
    for leaf_refs in 1..=24 {
        let mut config = Config::new(ample(COUNT, 40 * COUNT)).with_movers_only(Choice::Always);
        config.capacity.leaf_refs = leaf_refs;
        let mut slab = Slab::new::<u32>(&config);
        let mut world = Checked::<u32>::new(slab.world(&config));
        let boxes: Vec<Aabb> = places.iter().map(|place| at(*place, [1.0; 3])).collect();
        let ids = world.insert_many(&boxes);
        world.step(Setup::REFERENCE);
        let (mut large, mut refilled) = (0, false);
        for step in 0..30 {
            // Anywhere in the scene, and over all of it.
            world.set(ids[step * 37 % COUNT], Aabb::new([-1.0; 3], [40.0; 3]));
            let stats = world.step(Setup::REFERENCE).stats;
            large = large.max(stats.large);
            refilled |= stats.path != Path::Movers;
        }
        assert!(large > 0, "{leaf_refs}: no mover became large");
        assert!(refilled, "{leaf_refs}: the list was never full");
    }
}

/// Straddlers may take all room up to the last one where there are no large objects, and all but what large ones need. A list of
/// large objects that began at the end of the array would be cut off before straddlers that end there.
#[test]
fn all_leaf_references_may_be_in_use() {
    const COUNT: usize = 1100;
    let boxes = uniform(COUNT, 21);
    let mut least = u32::MAX;
    for leaf_refs in 1..=260 {
        let mut config = Config::new(ample(COUNT, 40 * COUNT));
        config.capacity.leaf_refs = leaf_refs;
        let mut slab = Slab::new::<u32>(&config);
        let mut world = Checked::<u32>::new(slab.world(&config));
        let ids = world.insert_many(&boxes);
        least = least.min(world.step(Setup::REFERENCE).stats.fullest_leaf);
        for (k, id) in ids.iter().enumerate().take(10) {
            let strip = at([0.0, boxes[k].min[1], boxes[k].min[2]], [40.0, 0.1, 0.1]);
            world.set(*id, if k % 10 < 7 { strip } else { boxes[k] });
            if k > 12 {
                world.set(ids[k - 12], boxes[k - 12]);
            }
            world.step(Setup::REFERENCE);
        }
    }
    assert!(least < 400, "{least}: never enough room for small leaves");
}

/// Strips come by dozens and go again, one by one or all at once: their list and the nodes over it never stand over others.
#[test]
fn many_large_objects_come_and_go() {
    const COUNT: usize = 900;
    let boxes = uniform(COUNT, 22);
    let mut rng = Rng::new(5);
    for leaf_refs in [300, 500, 3600] {
        let mut config = Config::new(ample(COUNT, 80 * COUNT)).with_events();
        config.capacity.leaf_refs = leaf_refs;
        let mut slab = Slab::new::<u32>(&config);
        let mut world = Checked::<u32>::new(slab.world(&config));
        let ids = world.insert_many(&boxes);
        world.step(Setup::REFERENCE);
        let mut most = 0;
        for _ in 0..30 {
            let share = [1, 8, 40, 150][rng.below(4)];
            for _ in 0..share {
                let (k, axis) = (rng.below(COUNT / 5), rng.below(3));
                let (mut min, mut edges) = (boxes[k].min, [0.1; 3]);
                (min[axis], edges[axis]) = (-1.0, 60.0);
                world.set(ids[k], if rng.once_in(2) { at(min, edges) } else { boxes[k] });
            }
            if rng.once_in(6) {
                (0..COUNT / 5).for_each(|k| world.set(ids[k], boxes[k]));
            }
            // Others, so that there are more straddlers, or fewer.
            for _ in 0..[0, 300][rng.below(2)] {
                let k = COUNT / 5 + rng.below(4 * COUNT / 5);
                world.set(ids[k], shifted(&boxes[k], rng.point(-1.0, 1.0)));
            }
            most = most.max(world.step(Setup::REFERENCE).stats.large);
        }
        assert!(most > 20, "{most} large objects at once");
    }
}

/// Boxes that lie apart on the axis of the sweep are no candidates. In `sweep::small`, `found.candidates += passed` with another
/// number, or an interval that ends later, would be seen by no pair.
#[test]
fn small_worlds_count_candidates() {
    for axis in 0..3 {
        for (apart, candidates) in [(10.0, 0), (1.0, 39), (0.5, 39 + 38), (0.0, 40 * 39 / 2)] {
            let config = Config::new(ample(40, 800));
            let mut slab = Slab::new::<u16>(&config);
            let mut world = Checked::<u16>::new(slab.world(&config));
            let boxes: Vec<Aabb> = (0..40)
                .map(|k| {
                    let mut place = [0.0; 3];
                    place[axis] = apart * k as f32;
                    at(place, [1.0; 3])
                })
                .collect();
            world.insert_many(&boxes);
            let stats = world.step(Setup::REFERENCE).stats;
            assert_eq!(stats.path, Path::Lists);
            assert_eq!(stats.candidates, candidates, "{apart} apart on axis {axis}");
        }
    }
}

/// A step whose chunks ran out is swept once more by one worker. Without `scratch::reset` before `return None` in
/// `Collector::in_parallel` its candidates would count twice.
#[test]
fn a_step_without_chunks_counts_once() {
    let boxes: Vec<Aabb> =
        (0..6000).map(|k| at([k % 20, k / 20 % 20, k / 400].map(|x| 2.0 * x as f32), [5.0; 3])).collect();
    let stats = |setup: Setup| {
        let config = setup.configure(Config::new(ample(boxes.len(), 10)).with_sharing(Choice::Always));
        let mut slab = Slab::new::<u32>(&config);
        let mut world = Checked::<u32>::new(slab.world(&config));
        world.insert_many(&boxes);
        assert!(matches!(world.try_step(setup), Err(Error::PairsFull { .. })));
        world.world().stats()
    };
    let serial = stats(Setup::REFERENCE);
    assert!(serial.candidates > 100_000, "{serial:?}");
    for threads in [2, 4] {
        let shared = stats(Setup { jobs: Jobs::Threads(threads), ..Setup::REFERENCE });
        assert_eq!(serial, shared, "{threads} threads");
    }
}

/// The world again, with the generation of slot 0 as if it had been given out so many times.
fn aged<I: Index>(world: &mut World<'_, I>, generation: u32) -> Id {
    let mut snapshot = saved(world);
    let generations = *FRONT;
    assert_eq!(
        [0, 1, 2].map(|slot| get(&snapshot, generations + 4 * slot)),
        [1; 3],
        "these are the generations"
    );
    put(&mut snapshot, generations, generation);
    seal(&mut snapshot);
    world.load(&snapshot).expect("a generation is a number");
    let id = world.id_at(0).expect("alive");
    assert_eq!(id.generation(), generation);
    id
}

/// After the last generation comes the first, never none: in `World::enter`, `wrapping_add(1).max(1)` without `max` would
/// make an id of zero. Batches of removals mark a bit of generations, so that those around the middle are edges, too.
#[test]
fn generations_begin_again_at_one() {
    const HALF: u32 = 1 << 31;
    for (generation, next) in
        [(u32::MAX, 1), (u32::MAX - 1, u32::MAX), (HALF - 1, HALF), (HALF, HALF + 1), (HALF + 1, HALF + 2)]
    {
        for in_batch in [false, true] {
            let config = Config::new(ample(3, 8)).with_events();
            let mut slab = Slab::new::<u16>(&config);
            let mut world = slab.world::<u16>(&config);
            let ids = [0.0, 0.5, 9.0].map(|x| world.insert(cube(x, 0.0, 0.0)).expect("room"));
            let setup = Setup::REFERENCE;
            let id = aged(&mut world, generation);
            assert_eq!(world.under(&setup).step().expect("room").pairs(), [[0, 1]]);
            if in_batch {
                assert_eq!(world.remove_many(&[id, id]), Err(Error::StaleId { id }), "twice");
                world.remove_many(&[ids[2], id]).expect("both are alive");
            } else {
                world.remove(id).expect("alive");
            }
            let born = world.insert(cube(0.0, 0.0, 0.0)).expect("room");
            assert_eq!((born.slot(), born.generation()), (0, next), "after {generation}");
            assert_eq!(world.remove(id), Err(Error::StaleId { id }), "the id before it is stale");
            world.validate().expect("a valid world");
            let step = world.under(&setup).step().expect("room");
            assert_eq!(step.found(), [[0, 1]], "another object in the slot, another pair");
            assert_eq!(step.lost(), [[0, 1]]);
        }
    }
}
