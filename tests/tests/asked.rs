//! Worlds that are asked between two steps, or without any: [`World::refresh`] brings the tree up to date, and changes nothing else.

use trisap_core::{Aabb, Boxes, Cast, Config, Error, Id, Margin, Path, Region, Stats, World};
use trisap_tests::checked::{Checked, slots};
use trisap_tests::forced::{Choice, Forced as _};
use trisap_tests::jobs::Jobs;
use trisap_tests::queries::{ask_cast, ask_nearest, ask_region};
use trisap_tests::scenes::{self, Rng, at, shifted, uniform};
use trisap_tests::worlds::{Setup, Slab, ample};
use trisap_tests::{SlotPair, sorted};

/// How many objects the tree has.
fn placed(world: &World<'_>) -> u32 {
    world.leaves().map(|leaf| leaf.objects).sum::<u32>() + world.large().count() as u32
}

/// A world without room for pairs: all of its objects are in the tree, whatever has been done since.
#[test]
fn a_world_that_is_only_asked_needs_no_step_and_no_pairs() {
    let boxes = uniform(3000, 3);
    let config = Config::new(ample(4000, 0).with_pairs(0));
    for setup in Setup::each(&Jobs::USUAL) {
        let config = setup.configure(config);
        let mut slab = Slab::new::<u32>(&config);
        let mut world = Checked::<u32>::new(slab.world(&config)).like_the_reference(setup);
        let (mut ids, rng) = (world.insert_many(&boxes[..2000]), &mut Rng::new(1));
        for round in 0..12 {
            let (asked, model) = world.parts_mut();
            assert_eq!(asked.set_kernels(setup.kernels).on(&setup.jobs).refresh(), Ok(()));
            asked.validate().expect("a valid world");
            assert_eq!(placed(asked), asked.len(), "round {round}");
            ask_region(asked, model, &Region::Aabb(at(rng.point(0.0, 9.0), [3.0; 3])), setup);
            ask_cast(asked, model, &Cast::ray([-1.0, 5.0, 5.0], [1.0, 0.0, 0.25], 99.0), setup);
            ask_nearest(asked, model, rng.point(0.0, 9.0), 5, setup);
            match round {
                // Some come, few move, many move, some go.
                0..3 => ids.extend(world.insert_many(&boxes[2000 + 300 * round..2300 + 300 * round])),
                3..9 => {
                    for _ in 0..[3, 1000][round % 2] {
                        let id = ids[rng.below(ids.len())];
                        let aabb = world.model().aabb(id.slot()).expect("alive");
                        world.set(id, shifted(&aabb, rng.point(-2.0, 2.0)));
                    }
                }
                9 => (0..50).for_each(|_| world.remove(ids.swap_remove(rng.below(ids.len())))),
                // A step finds no room; queries do not mind.
                _ => assert!(matches!(world.try_step(setup), Err(Error::PairsFull { room: 0, .. }))),
            }
        }
    }
}

/// Objects come, with a refresh after some, until more are there than the leaf had room for when it was filled last:
/// the full step that keeps all other records then has no leaf behind it that lends it room.
#[test]
fn a_leaf_fills_up_between_refreshes() {
    let (mut slab, rng) = (Slab::new::<u32>(&Config::new(ample(2000, 60_000))), &mut Rng::new(4));
    let mut world = Checked::<u32>::new(slab.world(&Config::new(ample(2000, 60_000))));
    let mut come = |world: &mut Checked<'_, u32>, count: usize| {
        let lows: Vec<f32> = (0..count).map(|_| rng.point(0.0, 200.0)[0]).collect();
        world.insert_many(&lows.iter().map(|&x| scenes::on_x(x, x + 1.5)).collect::<Vec<_>>())
    };
    let first = come(&mut world, 63)[0];
    // Calm steps divide the leaf, so that the refresh after them fills it anew.
    (0..3).for_each(|_| drop(world.step(Setup::REFERENCE)));
    world.set(first, scenes::on_x(104.0, 105.5));
    for count in [8, 5, 10, 12] {
        come(&mut world, count);
        world.world_mut().refresh().expect("a world");
        world.check();
    }
    come(&mut world, 14);
    assert_eq!(world.step(Setup::REFERENCE).stats.path, Path::Full);
    assert_eq!(world.world().leaves().count(), 1);
}

/// What a step says.
type Told = ([Vec<SlotPair>; 3], Stats);

fn told(world: &World<'_>) -> Told {
    ([world.pairs(), world.found(), world.lost()].map(|pairs| sorted(&slots(pairs))), world.stats())
}

/// The same steps, in one world with a refresh here and there: pairs, events and the kind of each step are the same.
#[test]
fn a_refresh_between_steps_changes_no_step() {
    let boxes = uniform(2000, 5);
    let predicted = Config::new(ample(2200, 20_000)).with_events();
    let plain = predicted.without_predicted_boxes();
    let margin = plain.with_margin(Margin::length(0.1));
    let fine = plain.with_fine_leaves(Choice::Always);
    for config in [plain, fine, margin, predicted, margin.with_mode(trisap_core::Mode::Fat)] {
        let live = |refreshes: bool| {
            let mut slab = Slab::new::<u32>(&config);
            let mut world = slab.world::<u32>(&config);
            let mut ids: Vec<Id> = world.insert_many(Boxes::new(&boxes)).expect("room").collect();
            let (mut steps, rng) = (Vec::new(), &mut Rng::new(9));
            for round in 0..40 {
                let share = [3, 20, 200, 1500][round / 3 % 4];
                for part in 0..3 {
                    for _ in 0..share / 3 {
                        let id = ids[rng.below(ids.len())];
                        let aabb = world.aabb(id).expect("alive");
                        world.set_aabb(id, shifted(&aabb, rng.point(-0.4, 0.4))).expect("a good box");
                    }
                    if round % 5 == 3 {
                        world.remove(ids.swap_remove(rng.below(ids.len()))).expect("alive");
                        ids.push(world.insert(at(rng.point(0.0, 9.0), [1.0; 3])).expect("room"));
                        let id = ids[rng.below(ids.len())];
                        world.set_enabled(id, !world.is_enabled(id)).expect("alive");
                    }
                    if refreshes && (round + part) % 2 == 0 {
                        world.refresh().expect("no fault");
                        world.validate().expect("a valid world");
                    }
                }
                if round % 2 == 0 {
                    world.step().expect("room");
                } else {
                    let all: Vec<Aabb> = (0..2200)
                        .map(|slot| world.id_at(slot).and_then(|id| world.aabb(id)).unwrap_or_default())
                        .collect();
                    world.step_over(Boxes::new(&all)).expect("room");
                }
                world.validate().expect("a valid world");
                steps.push(told(&world));
            }
            steps
        };
        let (with, without) = (live(true), live(false));
        assert!(without.iter().any(|(_, stats)| stats.path == Path::Movers));
        for (step, (with, without)) in with.iter().zip(&without).enumerate() {
            assert_eq!(with.0, without.0, "step {step}");
            assert_eq!((with.1.moved, with.1.pairs), (without.1.moved, without.1.pairs), "step {step}");
            // A step with many movers may fill its leaves, which were filled before, or not.
            let kind = |stats: &Stats| stats.path == Path::Movers;
            assert_eq!(kind(&with.1), kind(&without.1), "step {step}: {:?}, {:?}", with.1, without.1);
        }
    }
}
