//! Found and lost pairs where steps of one kind follow those of another: each step of these worlds is compared with brute force.

use trisap_core::{Config, Error, Filter, Id, Margin, Mode, Path, World};
use trisap_tests::checked::{Checked, Outcome};
use trisap_tests::doing::On as _;
use trisap_tests::forced::{Choice, Forced as _};
use trisap_tests::jobs::Jobs;
use trisap_tests::lives::saved;
use trisap_tests::scenes::{self, Brownian, shifted};
use trisap_tests::worlds::{Setup, Slab, ample};

/// Several blocks of leaves.
const COUNT: usize = 3000;
/// Room for all pairs of the scenes here.
const PAIRS: usize = 20 * COUNT;

/// Events in all modes, of kinds of steps that predicted boxes would change.
fn configs() -> [Config; 3] {
    let exact = Config::new(ample(COUNT + 10, PAIRS)).with_events().without_predicted_boxes();
    let margin = exact.with_margin(Margin::length(0.2));
    [exact, margin, margin.with_mode(Mode::Fat)]
}

/// Lives a life on all kernels, alone and with workers.
fn everywhere(config: Config, life: impl Fn(&mut Checked<'_>, &[Id], &mut Brownian, Setup)) {
    for setup in Setup::each(&[Jobs::Serial, Jobs::Threads(3)]) {
        let config = setup.configure(config);
        let mut slab = Slab::new::<u32>(&config);
        let mut world = Checked::new(slab.world(&config));
        let mut scene = Brownian::new(COUNT, 5);
        let ids = world.insert_many(scene.boxes());
        world.step(setup);
        for _ in 0..2 {
            full(&mut world, &mut scene, setup);
        }
        life(&mut world, &ids, &mut scene, setup);
        for _ in 0..2 {
            full(&mut world, &mut scene, setup);
        }
    }
}

/// All move.
fn full(world: &mut Checked<'_>, scene: &mut Brownian, setup: Setup) -> Outcome {
    let outcome = world.step_over(scene.advance(), setup);
    assert!(matches!(outcome.stats.path, Path::Full | Path::Rebuilt), "{:?}", outcome.stats.path);
    assert!(!outcome.found.is_empty() && !outcome.lost.is_empty(), "a step without events");
    outcome
}

/// One in forty moves.
fn few(world: &mut Checked<'_>, ids: &[Id], by: f32, setup: Setup) -> Outcome {
    for id in ids.iter().step_by(40) {
        if let Some(aabb) = world.world().aabb(*id) {
            world.world_mut().set_aabb(*id, shifted(&aabb, [by, 0.0, by])).expect("a living object");
            world.model_mut().set(*id, shifted(&aabb, [by, 0.0, by]));
        }
    }
    world.step(setup)
}

#[test]
fn steps_with_few_movers_stand_between_full_ones() {
    for config in configs() {
        everywhere(config, |world, ids, scene, setup| {
            for by in [0.7, 0.05, -0.9] {
                let path = few(world, ids, by, setup).stats.path;
                // So short a way is inside a margin.
                let inside = by == 0.05 && world.world().config().margin.is_some();
                assert!(path == Path::Movers || inside && path == Path::Unchanged, "{path:?}");
            }
            assert_eq!(world.step(setup).stats.path, Path::Unchanged);
            full(world, scene, setup);
            assert_eq!(few(world, ids, 0.6, setup).stats.path, Path::Movers);
        });
    }
}

#[test]
fn a_full_buffer_keeps_the_last_complete_result_for_the_next_step() {
    for config in configs() {
        everywhere(config, |world, ids, scene, setup| {
            let crowd = scenes::identical(COUNT);
            // Twice, and after each kind of step.
            for _ in 0..2 {
                let error = world.try_step_over(&crowd, setup).err();
                assert!(matches!(error, Some(Error::PairsFull { .. })), "{error:?}");
            }
            full(world, scene, setup);
            few(world, ids, 0.8, setup);
            assert!(world.try_step_over(&crowd, setup).is_err());
            full(world, scene, setup);
        });
    }
}

#[test]
fn a_buffer_that_few_movers_fill_keeps_the_parked_pairs_too() {
    for config in configs() {
        let config = config.with_movers_only(Choice::Automatic);
        everywhere(config, |world, ids, scene, setup| {
            for by in [0.3, 0.3, 0.3, 0.3] {
                few(world, &ids[..200], by, setup);
            }
            // A tenth of the objects in one place have more pairs than there is room for.
            let place = world.world().aabb(ids[0]).expect("alive");
            for id in &ids[..COUNT / 10] {
                world.world_mut().set_aabb(*id, place).expect("alive");
                world.model_mut().set(*id, place);
            }
            let few_fit = world.try_step(setup);
            assert_eq!(few_fit.is_err(), COUNT / 10 * (COUNT / 10 - 1) / 2 > PAIRS);
            full(world, scene, setup);
        });
    }
}

#[test]
fn filters_that_change_between_full_steps() {
    for config in configs() {
        everywhere(config.with_filters(), |world, ids, scene, setup| {
            for group in [1, 2, u32::MAX] {
                for id in ids.iter().step_by(7) {
                    let filter = Filter { group, mask: 1, ..Filter::ALL };
                    world.world_mut().set_filter(*id, filter).expect("a world with filters");
                    world.model_mut().set_filter(*id, filter);
                }
                full(world, scene, setup);
                full(world, scene, setup);
            }
        });
    }
}

#[test]
fn slots_that_go_to_other_objects_between_full_steps() {
    for config in configs() {
        everywhere(config, |world, ids, scene, setup| {
            let gone: Vec<Id> = ids.iter().copied().step_by(9).collect();
            let boxes: Vec<_> = gone.iter().map(|id| world.world().aabb(*id).expect("alive")).collect();
            world.remove_many(&gone);
            // Where the others were: their pairs are other pairs.
            let new = world.insert_many(&boxes);
            full(world, scene, setup);
            full(world, scene, setup);
            world.remove_many(&new[..new.len() / 2]);
            full(world, scene, setup);
            few(world, ids, 0.4, setup);
            world.insert_many(&boxes[..new.len() / 2]);
            full(world, scene, setup);
        });
    }
}

/// In a small world, too: the pair of the former object is lost, and that of the new one is found.
#[test]
fn a_slot_that_goes_to_another_object_is_another_pair() {
    for count in [4, 20, 40] {
        for config in [Config::new(ample(count, 90)), Config::new(ample(count, 90)).with_lean()] {
            let config = config.with_events();
            let mut slab = Slab::new::<u32>(&config);
            let mut world = slab.world::<u32>(&config);
            let cube = |x: f32| scenes::at([x, 0.0, 0.0], [1.0; 3]);
            let insert = |world: &mut World<'_>, x| world.insert(cube(x)).expect("room");
            let ids: Vec<Id> = (0..count).map(|at| insert(&mut world, 0.75 * at as f32)).collect();
            world.step().expect("room");
            world.remove(ids[1]).expect("alive");
            let other = insert(&mut world, 0.5);
            assert_eq!(other.slot(), 1);
            let step = world.step().expect("room");
            let sorted = |pairs: &[[u32; 2]]| {
                let mut pairs = pairs.to_vec();
                pairs.sort_unstable();
                pairs
            };
            assert_eq!(sorted(step.lost()), [[0, 1], [1, 2]], "{count} objects");
            assert_eq!(sorted(step.found()), [[0, 1], [1, 2]], "{count} objects");
            assert_eq!(step.pairs().len(), count - 1);
        }
    }
}

/// Of 32 neighbours all but one have got other boxes one by one before it moves: its last box is kept as theirs are.
#[test]
fn the_last_one_of_a_word_is_compared_with_its_last_box() {
    everywhere(configs()[0], |world, ids, scene, setup| {
        let home = scene.boxes().to_vec();
        world.step_over(&home, setup);
        let mut boxes = home.clone();
        for at in (5..128).step_by(32) {
            boxes[at] = shifted(&home[at], [-500.0, 0.0, 0.0]);
        }
        world.step_over(&boxes, setup);
        for at in (0..128).filter(|at| at % 32 != 5) {
            boxes[at] = shifted(&boxes[at], [0.01, 0.0, 0.0]);
            world.set(ids[at], boxes[at]);
        }
        for at in (5..128).step_by(32) {
            boxes[at] = home[at];
        }
        world.step_over(&boxes, setup);
    });
}

/// A script of all kinds of steps.
fn script(world: &mut World<'_>, setup: Setup) -> Vec<Result<Outcome, Error>> {
    let mut scene = Brownian::new(COUNT, 8);
    let crowd = scenes::identical(COUNT);
    let mut told = Vec::new();
    for round in 0..9 {
        let boxes = if round == 5 { &crowd[..] } else { scene.advance() };
        let boxes = trisap_core::Boxes::new(if round == 3 { &boxes[..40] } else { boxes });
        let step = world.under(&setup).step_over(boxes);
        told.push(step.map(|step| Outcome::of(&step)));
    }
    told
}

#[test]
fn workers_change_no_order() {
    for config in configs() {
        let mut plays =
            Setup::each(&[Jobs::Serial, Jobs::Threads(2), Jobs::Threads(4)]).into_iter().map(|setup| {
                let config = setup.configure(config);
                let mut slab = Slab::new::<u32>(&config);
                let mut world = slab.world(&config);
                assert_eq!(
                    world
                        .insert_many(trisap_core::Boxes::new(&scenes::uniform(COUNT, 1)))
                        .map(|ids| ids.len()),
                    Ok(COUNT)
                );
                (setup, script(&mut world, setup), saved(&world))
            });
        let (_, told, snapshot) = plays.next().expect("a setup");
        assert!(told.iter().any(Result::is_err));
        for (setup, other, bytes) in plays {
            assert!(other == told, "{setup:?}: other events, or another order");
            assert!(bytes == snapshot, "{setup:?}: another snapshot");
        }
    }
}

#[test]
fn worlds_that_move_or_are_loaded_go_on_with_their_events() {
    let setup = Setup { jobs: Jobs::Threads(2), ..Setup::REFERENCE };
    for config in configs() {
        let config = setup.configure(config);
        let larger = config.with_capacity(ample(2 * COUNT, 2 * PAIRS));
        let mut slab = Slab::new::<u32>(&config);
        let mut world = Checked::new(slab.world(&config));
        let mut scene = Brownian::new(COUNT, 6);
        let ids = world.insert_many(scene.boxes());
        for round in 0..6 {
            match round {
                2 => drop(few(&mut world, &ids, 0.5, setup)),
                4 => assert!(world.try_step_over(&scenes::identical(COUNT), setup).is_err()),
                _ => drop(world.step_over(scene.advance(), setup)),
            }
            let (model, next) = (world.model().clone(), scene.clone());
            let mut room = Slab::new::<u32>(&larger);
            let moved = world.world().move_into(room.bytes_mut(), &larger).expect("more room");
            let mut moved = Checked::resume(moved, model.clone());
            let mut copied = Slab::new::<u32>(&config);
            let mut copy = copied.world::<u32>(&config);
            copy.load(&saved(world.world())).expect("a good snapshot");
            let mut copy = Checked::resume(copy, model);
            let (mut one, mut two) = (next.clone(), next);
            for _ in 0..2 {
                moved.step_over(one.advance(), setup);
                copy.step_over(two.advance(), setup);
            }
        }
        // Worlds that load the same snapshot go on in the same order.
        let mut copied = Slab::new::<u32>(&config);
        let mut copy = copied.world::<u32>(&config);
        let snapshot = saved(world.world());
        copy.load(&snapshot).expect("a good snapshot");
        world.world_mut().load(&snapshot).expect("a good snapshot");
        let (mut one, mut two) = (scene.clone(), scene);
        let mut copy = Checked::resume(copy, world.model().clone());
        for _ in 0..3 {
            assert!(world.step_over(one.advance(), setup) == copy.step_over(two.advance(), setup));
            assert!(saved(world.world()) == saved(copy.world()));
        }
    }
}
