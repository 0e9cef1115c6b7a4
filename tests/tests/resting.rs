//! Objects at rest: those that the caller puts to rest, and those that just do not move, whose pairs steps set aside.

use trisap_core::{Aabb, Config, Error, Index, Margin, Mode, Path};
use trisap_tests::checked::Checked;
use trisap_tests::jobs::Jobs;
use trisap_tests::scenes::{self, Rng, cube, on_x, shifted};
use trisap_tests::worlds::{Setup, Slab, ample};

fn configs() -> [Config; 5] {
    let plain = Config::new(ample(0, 0));
    let margin = plain.with_margin(Margin::length(0.2));
    let events = margin.with_events();
    [plain, plain.with_events(), margin, events, events.with_mode(Mode::Fat)]
}

/// Denser than a uniform scene, so that most objects have pairs.
fn crowd(count: usize, seed: u64) -> Vec<Aabb> {
    scenes::uniform(count, seed).iter().map(|b| scenes::at(b.min.map(|x| x * 0.6), [1.0; 3])).collect()
}

#[test]
fn resting_objects_keep_their_boxes() {
    for setup in Setup::each(&Jobs::USUAL) {
        // Small, a list and a tree: the first three boxes are what it is about.
        for count in [3, 300, 900] {
            let config = setup.configure(Config::new(ample(count, 100 * count)).with_events());
            let mut slab = Slab::new::<u32>(&config);
            let mut world = Checked::<u32>::new(slab.world(&config));
            let mut boxes = vec![on_x(0.0, 1.0), on_x(0.5, 1.5), on_x(9.0, 10.0)];
            boxes.extend(crowd(count - 3, 2).iter().map(|b| shifted(b, [0.0, 100.0, 0.0])));
            let ids = world.insert_many(&boxes);
            world.step(setup);
            world.set_resting(&ids[..2]);
            assert!(world.world().is_resting(ids[0]) && !world.world().is_resting(ids[2]));
            // What the array says of resting objects does not matter, be it good or bad.
            let mut moved = boxes.clone();
            moved[0] = on_x(9.0, 10.0);
            moved[1] = Aabb::new([f32::NAN; 3], [0.0; 3]);
            let outcome = world.step_over(&moved, setup);
            assert!(outcome.found.is_empty() && outcome.lost.is_empty() && outcome.rejected.is_none());
            // Those that do not rest meet them.
            moved[2] = on_x(1.25, 1.5);
            assert_eq!(world.step_over(&moved, setup).found, [[1, 2]]);
            // A box of its own wakes an object, even the one that it has.
            world.set(ids[0], boxes[0]);
            assert!(!world.world().is_resting(ids[0]));
            world.update_many(&ids[1..2], &boxes[1..2]);
            assert!(!world.world().is_resting(ids[1]));
            moved[1] = on_x(20.0, 21.0);
            let outcome = world.step_over(&moved, setup);
            assert_eq!((outcome.found.len(), outcome.lost.len()), (0, 2), "{outcome:?}");
            // So does `wake`, and until then nothing does.
            world.set_resting(&ids);
            for _ in 0..3 {
                assert_eq!(world.step_over(&boxes, setup).stats.path, Path::Unchanged);
            }
            world.wake(&ids[..2]);
            let found = world.step_over(&boxes, setup).found;
            assert_eq!(
                trisap_tests::sorted(&found),
                [[0, 1], [1, 2]],
                "the third one still rests at the second one"
            );
            // The next object in a slot does not rest.
            world.remove(ids[2]);
            let new = world.insert(boxes[2]);
            assert!(new.slot() == 2 && !world.world().is_resting(new) && !world.world().is_resting(ids[2]));
            let stale = Error::StaleId { id: ids[2] };
            assert_eq!(world.refuse(|world| world.set_resting(&[new, ids[2]])), stale);
            assert_eq!(world.refuse(|world| world.wake(&[ids[0], ids[2]])), stale);
            world.set_resting(&[]);
            world.step_over(&moved, setup);
        }
    }
}

/// Calm and busy steps in all orders: nobody, one or a few move, the same ones again or others; now and then all do.
fn mixture<I: Index>(config: Config, count: usize, rounds: usize, setup: Setup) {
    let capacity = ample(count + 20, 40 * count);
    let config = setup.configure(config.with_capacity(capacity));
    let mut slab = Slab::new::<I>(&config);
    let mut world = Checked::<I>::new(slab.world(&config)).like_the_reference(setup);
    let rng = &mut Rng::new(count as u64);
    world.insert_many(&crowd(count, 4));
    world.step(setup);
    let mut movers = vec![0];
    let mut seen = Vec::new();
    for round in 0..rounds {
        let ids = world.model().ids();
        let mut boxes: Vec<Aabb> = world.model().boxes().iter().map(|b| b.unwrap_or_default()).collect();
        let any = |rng: &mut Rng| rng.below(ids.len());
        match rng.below(10) {
            0 | 1 => {}
            // The same ones again.
            2..=4 => {}
            5 => movers = vec![any(rng)],
            6 | 7 => movers = (0..5).map(|_| any(rng)).collect(),
            8 => movers = (0..count / 6).map(|_| any(rng)).collect(),
            _ => movers = vec![any(rng), movers[0]],
        }
        movers.retain(|at| *at < ids.len());
        if movers.is_empty() {
            movers.push(0);
        }
        let busy = round % 12 > 9;
        let length = [0.05, 0.7, 2.0][rng.below(3)];
        if busy {
            scenes::walk(&mut boxes, 1000, length, rng);
        } else if !rng.once_in(4) {
            for at in &movers {
                let slot = ids[*at].slot() as usize;
                boxes[slot] = shifted(&boxes[slot], rng.point(-length, length));
            }
        }
        match rng.below(10) {
            0 => {
                let some: Vec<_> = ids.iter().copied().filter(|_| rng.once_in(2)).collect();
                world.set_resting(&some);
            }
            1 => world.wake(&ids),
            2 => {
                world.remove(ids[any(rng)]);
                world.insert(boxes[ids[any(rng)].slot() as usize]);
            }
            3 => world.set_resting(&ids[..1]),
            // Refused without margins.
            4 => world.set_margin(ids[any(rng)], [0.0, 0.1, 0.5][rng.below(3)]),
            _ => {}
        }
        let handed_over = rng.once_in(3);
        let outcome = if handed_over {
            let ids: Vec<_> =
                movers.iter().map(|at| ids[*at]).filter(|id| world.model().contains(*id)).collect();
            let theirs: Vec<Aabb> = ids.iter().map(|id| boxes[id.slot() as usize]).collect();
            world.update_many(&ids, &theirs);
            world.step(setup)
        } else {
            world.step_over(&boxes, setup)
        };
        seen.push(outcome.stats.path);
    }
    if count >= 450 {
        for path in [Path::Movers, Path::Full] {
            assert!(seen.contains(&path), "no step was {path:?}: {seen:?}");
        }
    }
}

#[test]
fn calm_and_busy_steps_in_all_orders() {
    for setup in Setup::each(&Jobs::USUAL) {
        for config in configs() {
            mixture::<u16>(config, 25, 60, setup);
            mixture::<u32>(config.with_lean(), 200, 60, setup);
            mixture::<u32>(config, 450, 60, setup);
            mixture::<u32>(config, 600, 120, setup);
            mixture::<u16>(config, 1500, 60, setup);
        }
        mixture::<u32>(configs()[1], 5000, 48, setup);
        mixture::<u16>(configs()[3], 5000, 36, setup);
    }
}

/// Objects move in from a dense corner that all of it does not fit in: leaves grow out of balance while it is calm, and
/// the next busy step has to put that right.
#[test]
fn trees_that_grow_askew_while_it_is_calm() {
    for setup in Setup::each(&Jobs::USUAL) {
        for config in configs() {
            let count = 2000;
            let config = setup.configure(config.with_capacity(ample(count, 200 * count)));
            let mut slab = Slab::new::<u32>(&config);
            let mut world = Checked::<u32>::new(slab.world(&config)).like_the_reference(setup);
            let ids = world.insert_many(&scenes::uniform(count, 6));
            world.step(setup);
            let rng = &mut Rng::new(1);
            for part in ids.chunks(40).take(20) {
                let boxes: Vec<Aabb> =
                    part.iter().map(|_| scenes::at(rng.point(2.0, 6.0), [0.3; 3])).collect();
                world.update_many(part, &boxes);
                world.step(setup);
                world.step(setup);
            }
            for _ in 0..4 {
                let mut boxes: Vec<Aabb> = world.model().boxes().iter().flatten().copied().collect();
                scenes::walk(&mut boxes, 1000, 0.1, rng);
                world.step_over(&boxes, setup);
            }
        }
    }
}

/// A step in the middle of a calm time finds no room: what was set aside comes back as it was.
#[test]
fn a_full_buffer_in_a_calm_time() {
    for setup in Setup::each(&Jobs::USUAL) {
        for (config, retries) in configs().into_iter().flat_map(|config| [0, 1, 3].map(|n| (config, n))) {
            for count in [60, 400, 700, 2000] {
                let boxes = crowd(count, 5);
                // All pairs of the scene fit, with the fat ones, but not those of a box around everything.
                let pairs = 2 * trisap_tests::checked::expected(
                    &boxes
                        .iter()
                        .map(|b| Aabb::new(b.min.map(|x| x - 0.2), b.max.map(|x| x + 0.2)))
                        .collect::<Vec<_>>(),
                )
                .len();
                let capacity = ample(count, pairs.min(count * count / 4));
                let config = setup.configure(config.with_capacity(capacity));
                let mut slab = Slab::new::<u32>(&config);
                let mut world = Checked::<u32>::new(slab.world(&config)).like_the_reference(setup);
                let ids = world.insert_many(&boxes);
                let rng = &mut Rng::new(3);
                for calm in 0..5 {
                    if calm > 0 {
                        world.set(ids[7], shifted(&boxes[7], rng.point(-0.5, 0.5)));
                    }
                    world.step(setup);
                }
                let side = scenes::side(count);
                let huge: Vec<Aabb> =
                    (0..pairs.div_ceil(count) + 9).map(|_| Aabb::new([-1.0; 3], [side; 3])).collect();
                let giants = &ids[3..3 + huge.len()];
                world.update_many(giants, &huge);
                world.try_step(setup).expect_err("no room");
                for retry in 0..retries {
                    world.set(ids[1], shifted(&boxes[1], rng.point(-0.5, 0.5)));
                    if retry == 1 {
                        world.set_resting(&ids[20..30]);
                        world.remove(ids[0]);
                        world.insert(cube(0.0, 0.0, 0.0));
                    }
                    world.try_step(setup).expect_err("still no room");
                }
                // From somewhere else, as a box that shrinks stays inside its margins.
                world.update_many(giants, &vec![cube(-1e6, 0.0, 0.0); huge.len()]);
                world.update_many(giants, &boxes[3..3 + huge.len()]);
                for calm in 0..4 {
                    if calm > 1 {
                        world.set(ids[9], shifted(&boxes[9], rng.point(-0.5, 0.5)));
                    }
                    world.step(setup);
                }
            }
        }
    }
}

/// A pair has one who is awake until both are put to rest, be they still or not, and again when one gets a box or is woken.
#[test]
fn pairs_of_which_one_is_awake() {
    for config in configs() {
        for count in [5, 300, 900] {
            let config = config.with_capacity(ample(count, 100 * count));
            let mut slab = Slab::new::<u32>(&config);
            let mut world = slab.world::<u32>(&config);
            let boxes = crowd(count, 3);
            let ids: Vec<_> = world.insert_many(trisap_core::Boxes::new(&boxes)).expect("room").collect();
            // So still for so long that steps do not look at their pairs.
            for _ in 0..4 {
                world.step().expect("room");
            }
            assert!(world.awake_pairs().eq(world.pairs().iter().copied()), "nobody was put to rest");
            let rest = &ids[..count * 3 / 4];
            world.set_resting(rest).expect("alive");
            let mut awake = vec![true; count];
            rest.iter().for_each(|id| awake[id.slot() as usize] = false);
            let mut fewer = 0;
            for round in 0..4 {
                match round {
                    1 => world.wake(&ids[..2]).expect("alive"),
                    2 => world.set_aabb(ids[2], boxes[2]).expect("alive"),
                    _ => {}
                }
                awake[..[0, 2, 3, 3][round]].fill(true);
                let step = world.step().expect("room");
                let expected: Vec<_> = step
                    .pairs()
                    .iter()
                    .copied()
                    .filter(|pair| pair.iter().any(|slot| awake[*slot as usize]))
                    .collect();
                assert_eq!(step.awake_pairs().collect::<Vec<_>>(), expected, "{round}");
                fewer += step.pairs().len() - expected.len();
            }
            assert!(count == 5 || fewer > 100);
        }
    }
}
