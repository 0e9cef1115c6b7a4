//! A world of 200,000 objects against an independent sweep. (`tests/runs/src/bin/million.rs` has five times as many.)

use trisap_core::{Boxes, Config, Path, World};
use trisap_tests::checked::{Checked, slots};
use trisap_tests::jobs::Jobs;
use trisap_tests::scenes::{self, Brownian, Rng, at, shifted, walk};
use trisap_tests::worlds::{Setup, Slab, ample};
use trisap_tests::{oracle, sorted};

const COUNT: usize = 200_000;

#[test]
fn a_large_brownian_world_is_exact() {
    let mut scene = Brownian::new(COUNT, 200);
    let mut frames = vec![scene.boxes().to_vec(), scene.advance().to_vec(), scene.advance().to_vec()];
    let mut few = frames[2].clone();
    walk(&mut few, 3, 1.0, &mut Rng::new(201));
    frames.push(few);

    let mut config = Config::new(ample(COUNT, 8 * COUNT)).with_events().with_workers(2);
    config.capacity.leaf_refs = COUNT as u32 / 2;
    let mut slab = Slab::new::<u32>(&config);
    let mut world: World<'_> = slab.world(&config);
    world.insert_many(Boxes::new(&frames[0])).expect("room for all");
    let mut before = 0;
    for frame in &frames {
        let step = world.on(&Jobs::Threads(2)).step_over(Boxes::new(frame)).expect("room for all");
        let (stats, pairs) = (step.stats(), sorted(&slots(step.pairs())));
        let expected = oracle::sweep(&oracle::all_live(frame));
        assert!(pairs == expected, "{} pairs for {}: {stats:?}", pairs.len(), expected.len());
        assert_eq!(before + stats.found - stats.lost, stats.pairs);
        before = stats.pairs;
        world.validate().expect("a valid world");
    }
}

/// Leaves that are kept while more and fewer boxes reach beyond them, so that the list of large objects behind theirs moves a little
/// to and fro, over itself.
#[test]
fn large_objects_stay_in_their_list_as_others_grow_and_shrink() {
    const COUNT: usize = 2400;
    const LARGE: usize = 24;
    let rng = &mut Rng::new(6);
    let side = scenes::side(COUNT);
    let mut boxes = scenes::uniform(COUNT, 5);
    for aabb in &mut boxes[..LARGE] {
        *aabb = at(rng.point(0.0, 0.3 * side), [4.0 * side, 4.0 * side, 0.02]);
    }
    let mut config = Config::new(ample(COUNT, 40 * COUNT)).with_events();
    config.capacity.leaf_refs = 2 * COUNT as u32;
    let mut slab = Slab::new::<u32>(&config);
    let mut world = Checked::<u32>::new(slab.world(&config));
    world.insert_many(&boxes);
    for step in 0..40 {
        for (index, aabb) in boxes.iter_mut().enumerate() {
            *aabb = shifted(aabb, rng.point(-0.01, 0.01));
            // A few at a time become long, or short again.
            if index >= LARGE && index % 400 == step / 2 * 7 % 400 {
                aabb.max[0] = aabb.min[0] + if step % 2 == 0 { 0.3 * side } else { 1.0 };
            }
        }
        let stats = world.step_over(&boxes, Setup::REFERENCE).stats;
        assert!(stats.large >= LARGE as u32 / 2, "{stats:?}");
    }
}

/// More than a step lists to be moved by themselves, where leaves are kept; then all are filled anew. And fewer.
#[test]
fn many_objects_become_large_and_small_again_at_once() {
    const COUNT: usize = 10_000;
    let (rng, side) = (&mut Rng::new(9), scenes::side(COUNT));
    let mut config = Config::new(ample(COUNT, 40 * COUNT)).with_events().without_predicted_boxes();
    config.capacity.leaf_refs = 2 * COUNT as u32;
    let mut slab = Slab::new::<u32>(&config);
    let mut world = Checked::<u32>::new(slab.world(&config));
    let mut boxes = scenes::uniform(COUNT, 9);
    world.insert_many(&boxes);
    for step in 0..24 {
        // Of these, six in ten.
        let some = if step < 12 { 1500 } else { 300 };
        for (index, aabb) in boxes.iter_mut().enumerate() {
            *aabb = shifted(aabb, rng.point(-0.01, 0.01));
            if step % 4 > 1 && index < some {
                aabb.max[0] = aabb.min[0] + if step % 4 == 2 { 0.6 * side } else { 1.0 };
            }
        }
        let stats = world.step_over(&boxes, Setup::REFERENCE).stats;
        if step % 4 == 2 {
            // Those that are by themselves may be a twelfth of all. Were an eighth of all to leave, none would be kept.
            let many = COUNT as u32 / 12..COUNT as u32 / 8;
            assert_eq!(many.contains(&stats.large), step < 12, "{stats:?}");
        }
    }
}

/// Until the list has no room for another one in its groups; then all leaves are filled, and it gets more.
#[test]
fn large_objects_come_one_by_one() {
    const COUNT: usize = 2400;
    let (rng, side) = (&mut Rng::new(8), scenes::side(COUNT));
    let config = Config::new(ample(COUNT + 40, 100 * COUNT)).with_events();
    let mut slab = Slab::new::<u32>(&config);
    let mut world = Checked::<u32>::new(slab.world(&config));
    world.insert_many(&scenes::uniform(COUNT, 7));
    world.step(Setup::REFERENCE);
    let mut by_movers = 0;
    for _ in 0..40 {
        world.insert_many(&[at(rng.point(0.0, 0.3 * side), [4.0 * side, 4.0 * side, 0.02])]);
        by_movers += usize::from(world.step(Setup::REFERENCE).stats.path == Path::Movers);
    }
    assert!((20..40).contains(&by_movers), "{by_movers} of 40 steps by movers");
}
