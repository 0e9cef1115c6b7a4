//! Disabled objects keep what they have, and are in no pair and in no answer.

use trisap_core::{Aabb, Boxes, Cast, Config, Filter, Id, Index, Kernels, Margin, Mode, Path, Region};
use trisap_tests::checked::Checked;
use trisap_tests::jobs::Jobs;
use trisap_tests::queries::{ask_cast, ask_nearest, ask_region};
use trisap_tests::scenes::{self, Rng, at};
use trisap_tests::worlds::{Setup, Slab, ample};

/// Queries of both boxes and rays, as brute force among the enabled answers them.
fn ask<I: Index>(world: &mut Checked<'_, I>, rng: &mut Rng, setup: Setup) {
    let (world, model) = world.parts_mut();
    for region in [at(rng.point(-2.0, 8.0), [4.0; 3]), Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3])]
    {
        ask_region(world, model, &Region::Aabb(region), setup);
    }
    ask_cast(world, model, &Cast::ray([-9.0, 3.0, 3.0], [1.0, 0.0, 0.0], 99.0), setup);
    ask_nearest(world, model, [3.0; 3], 5, setup);
}

fn live<I: Index>(config: Config, count: usize, setup: Setup, seed: u64) {
    let config =
        setup.configure(config.with_capacity(ample(count + 40, 60 * count)).with_filters().with_values());
    let mut slab = Slab::new::<I>(&config);
    let mut world = Checked::<I>::new(slab.world(&config)).like_the_reference(setup);
    let rng = &mut Rng::new(seed);
    let boxes: Vec<Aabb> =
        scenes::uniform(count, seed).iter().map(|aabb| at(aabb.min.map(|x| x * 0.6), [1.0; 3])).collect();
    let mut ids = world.insert_many(&boxes);
    let mut saved = world.save();
    for round in 0..24 {
        for _ in 0..[1, 3, count / 3][round % 3] {
            let id = ids[rng.below(ids.len())];
            match rng.below(9) {
                0..4 => world.set_enabled(&[id], rng.once_in(2)),
                4 => world.set_filter(id, Filter::class(id.slot() % 4)),
                5 if config.margin.is_some() => world.set_margin(id, 0.3),
                6 => world.set_resting(&[id]),
                7 => world.wake(&[id]),
                _ => world.set(id, at(rng.point(0.0, 6.0), [1.0; 3])),
            }
        }
        if round % 5 == 4 {
            // Some of them twice.
            let some: Vec<Id> = (0..5).map(|_| ids[rng.below(ids.len())]).collect();
            world.set_enabled(&some, round % 2 == 0);
            // One goes, enabled or not, and another one comes.
            let gone = ids.swap_remove(rng.below(ids.len()));
            world.remove(gone);
            world.refuse(|world| world.set_enabled_many(&[ids[0], gone], false));
            assert!(!world.world().is_enabled(gone));
            ids.push(world.insert(at(rng.point(0.0, 6.0), [1.0; 3])));
        }
        if round % 6 == 5 {
            let mut meets = [u32::MAX; 32];
            meets[rng.below(4)] = 5;
            world.set_classes(&meets);
        }
        ask(&mut world, rng, setup);
        if round % 4 == 3 {
            let slots = 0..world.model().boxes().len() as u32;
            let mut frame: Vec<Aabb> =
                slots.map(|slot| world.model().aabb(slot).unwrap_or_default()).collect();
            scenes::walk(&mut frame, 1000, 0.1, rng);
            world.step_over(&frame, setup);
        } else {
            world.step(setup);
        }
        ask(&mut world, rng, setup);
        match round {
            10 => saved = world.save(),
            15 => {
                world.load(&saved);
                ids = world.model().ids();
            }
            _ => {}
        }
    }
    world.set_enabled(&ids, true);
    world.step(setup);
}

#[test]
fn disabled_objects_are_in_no_pair_and_in_no_answer() {
    let plain = Config::new(ample(0, 0)).without_predicted_boxes();
    let margin = plain.with_margin(Margin::length(0.15));
    let configs = [
        plain,
        plain.with_events(),
        margin.with_events(),
        margin,
        margin.with_mode(Mode::Fat),
        Config::new(ample(0, 0)).with_events(),
    ];
    for setup in Setup::each(&Jobs::USUAL) {
        for (seed, config) in configs.into_iter().enumerate() {
            live::<u16>(config, 30, setup, seed as u64);
            live::<u32>(config.with_lean(), 120, setup, seed as u64);
            live::<u32>(config, 700, setup, seed as u64);
        }
    }
}

/// Where all move and leaves stay as they are, also the objects at the rim, whose cells end where boxes do.
#[test]
fn who_is_disabled_leaves_its_leaf_while_others_keep_theirs() {
    let setup = Setup { kernels: Kernels::BASELINE, jobs: Jobs::Serial };
    let config = Config::new(ample(2000, 20_000)).with_events().without_predicted_boxes();
    let mut slab = Slab::new::<u32>(&config);
    let mut world = Checked::<u32>::new(slab.world(&config)).like_the_reference(setup);
    let (mut boxes, mut rng) = (scenes::uniform(2000, 3), Rng::new(4));
    let ids = world.insert_many(&boxes);
    for round in 0..12 {
        let some: Vec<Id> = ids.iter().copied().filter(|id| id.slot() % 12 == round).collect();
        world.set_enabled(&some, false);
        scenes::walk(&mut boxes, 1000, 0.01, &mut rng);
        world.step_over(&boxes, setup);
        assert!(round < 3 || world.world().stats().path == Path::Full);
        world.set_enabled(&some, round % 2 == 0);
    }
}

/// Steps do not look at the boxes of disabled objects in the caller's array; and whoever is told of one by name takes it.
#[test]
fn a_disabled_object_takes_a_box_that_is_given_to_it_alone() {
    let config = Config::new(ample(4, 4)).with_events();
    let mut slab = Slab::new::<u32>(&config);
    let mut world = slab.world::<u32>(&config);
    // Whatever is in a side comes back.
    let sides =
        [f32::NEG_INFINITY, f32::MIN, -1.5, -f32::from_bits(1), 0.0, f32::from_bits(1), 1.0e-3, f32::MAX];
    let there = Aabb::new([-2.0; 3], [f32::INFINITY; 3]);
    let id = world.insert(there).expect("room");
    let other = world.insert(Aabb::new([0.0; 3], [1.0; 3])).expect("room");
    world.set_enabled(id, false).expect("alive");
    let bad = Aabb::new([f32::NAN; 3], [0.0; 3]);
    let step = world.step_over(Boxes::new(&[bad, Aabb::new([0.0; 3], [2.0; 3])])).expect("room");
    assert!(step.rejected().is_none() && step.pairs().is_empty());
    assert_eq!(world.aabb(id), Some(there));
    for low in sides {
        let aabb = Aabb::new([low, -7.0, f32::MIN], [f32::INFINITY, 9.0, f32::MAX]);
        world.set_aabb(id, aabb).expect("a good box");
        assert!(world.step().expect("room").pairs().is_empty());
        assert_eq!((world.aabb(id), world.is_enabled(id)), (Some(aabb), false));
    }
    world.set_aabb(id, there).expect("a good box");
    world.set_enabled_many(&[other, id], true).expect("alive");
    assert_eq!(world.step().expect("room").found(), [[0, 1]]);
}
