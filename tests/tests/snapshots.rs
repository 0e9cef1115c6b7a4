//! Snapshots: a world that is loaded goes on with the pairs and events of the one that was saved; and bytes that are
//! no snapshot are refused. What is forged with care is in `forged`.

use trisap_core::{Aabb, Boxes, Capacity, Config, Error, Field, Index, Margin, Mode, World};
use trisap_tests::checked::{Checked, Outcome};
use trisap_tests::doing::On as _;
use trisap_tests::forced::{Choice, Forced as _};
use trisap_tests::jobs::Jobs;
use trisap_tests::lives::{act, configs, lived, saved};
use trisap_tests::scenes::{self, Brownian, Rng, shifted, uniform};
use trisap_tests::worlds::{Setup, Slab, ample};
use trisap_tests::{SlotPair, sorted};

/// What a step says, in ascending order. After [`Error::PairsFull`] any pairs that fit are right.
fn sets(said: Result<Outcome, Error>) -> Result<[Vec<SlotPair>; 3], Error> {
    said.map(|o| [&o.pairs, &o.found, &o.lost].map(|pairs| sorted(pairs)))
}

/// At any point of a life: a snapshot goes to a world that has lived otherwise, with other workers, and both go on with
/// the same pairs and events; and the first one goes back and does all of it again, byte for byte as that other one.
/// Returns how many steps found no room for their pairs.
fn follow<I: Index>(config: Config, count: usize, pairs: usize, setup: Setup) -> usize {
    let config = config.with_capacity(ample(count + count / 8, pairs));
    let config = setup.configure(config);
    let other =
        Setup { jobs: if setup.jobs == Jobs::Serial { Jobs::Threads(3) } else { Jobs::Serial }, ..setup };
    let copied = other.configure(config);
    let (mut slab, mut room) = (Slab::new::<I>(&config), Slab::new::<I>(&copied));
    let mut world = slab.world::<I>(&config);
    let _ = room.world::<I>(&copied);
    let rng = &mut Rng::new(count as u64 * 31 + pairs as u64);
    let mut full = 0;
    for round in 0..40 {
        let snapshot = saved(&world);
        if round == 3 {
            world.insert_many(Boxes::new(&scenes::uniform(count, 1))).expect("room");
            continue;
        }
        // A fresh world now and then, else one that has been used before.
        let mut copy = if round % 10 == 9 {
            room.world::<I>(&copied)
        } else {
            World::open(room.bytes_mut()).expect("the world of the last round")
        };
        copy.load(&snapshot).expect("a good snapshot");
        copy.validate().expect("a valid world");
        assert_eq!(copy.config(), copied);
        assert_eq!((world.pairs(), world.found(), world.lost()), (copy.pairs(), copy.found(), copy.lost()));
        assert!(saved(&copy) == snapshot, "round {round}: what was loaded is saved as it was");
        let start = rng.clone();
        let mut told = Vec::new();
        for _ in 0..3 {
            let said = act(&mut copy, &mut rng.clone(), other);
            full += usize::from(said.is_err());
            assert!(sets(act(&mut world, rng, setup)) == sets(said.clone()), "round {round}: other pairs");
            told.push(said);
        }
        // Byte for byte: pairs, their order, events, statistics.
        world.load(&snapshot).expect("a good snapshot");
        let again = &mut start.clone();
        for said in told {
            assert!(act(&mut world, again, setup) == said, "round {round}: another order");
        }
        assert!(saved(&world) == saved(&copy), "round {round}: the same steps leave the same world");
        world.validate().expect("a valid world");
    }
    full
}

#[test]
fn a_loaded_world_goes_on_as_the_one_that_was_saved() {
    for setup in Setup::each(&Jobs::USUAL) {
        for config in configs() {
            // With room for all pairs, and with about as much as it takes.
            for tenths in [200, 3] {
                let mut full = follow::<u16>(config, 30, 3 * tenths, setup);
                full += follow::<u32>(config.with_lean(), 200, 20 * tenths, setup);
                full += follow::<u16>(config, 450, 45 * tenths, setup);
                full += follow::<u32>(config, 700, 70 * tenths, setup);
                full += follow::<u16>(config, 1600, 160 * tenths, setup);
                assert!(tenths > 3 || full > 9, "the buffer was full {full} times only");
            }
        }
        follow::<u32>(configs()[1], 5000, 60_000, setup);
    }
}

/// Hooks are no part of a snapshot: worlds go on with the same pairs, in orders of their own.
#[test]
fn a_snapshot_loads_whatever_the_hooks_are() {
    let choices = [Choice::Automatic, Choice::Never, Choice::Always];
    let mut parted = 0;
    for config in configs() {
        for (seed, [from, to]) in choices.iter().flat_map(|a| choices.map(|b| [*a, b])).enumerate() {
            let config = config.with_capacity(ample(1800, 300_000));
            let config = config.with_movers_only(from).with_fine_leaves(to);
            let copied = config.with_movers_only(to).with_fine_leaves(from).with_sharing(from);
            let (mut slab, mut room) = (Slab::new::<u16>(&config), Slab::new::<u16>(&copied));
            let mut world = lived::<u16>(&mut slab, &config, 1600, 3 + seed % 2);
            let mut copy = lived::<u16>(&mut room, &copied, 700, 5);
            let mut rng = Rng::new(seed as u64);
            for round in 0..6 {
                let snapshot = saved(&world);
                copy.load(&snapshot).expect("a good snapshot");
                copy.validate().expect("a valid world");
                assert!(saved(&copy) == snapshot, "what was loaded is saved as it was");
                assert_eq!(copy.config(), copied);
                for _ in 0..3 {
                    let mut again = rng.clone();
                    let one = act(&mut world, &mut rng, Setup::REFERENCE).expect("room");
                    let other = act(&mut copy, &mut again, Setup::REFERENCE).expect("room");
                    assert_eq!(one.rejected, other.rejected);
                    parted += usize::from(one.stats.path != other.stats.path);
                    assert!(sets(Ok(one)) == sets(Ok(other)), "{from:?} to {to:?}, round {round}");
                }
                copy.validate().expect("a valid world");
            }
        }
    }
    assert!(parted > 100, "{parted} steps took other paths");
}

#[test]
fn every_truncation_and_every_changed_byte_is_noticed() {
    for config in configs() {
        let config = config.with_capacity(ample(12, 60));
        let (mut slab, mut source) = (Slab::new::<u16>(&config), Slab::new::<u16>(&config));
        let snapshot = saved(&lived::<u16>(&mut source, &config, 10, 3));
        let mut checked = Checked::<u16>::new(slab.world(&config));
        checked.insert_many(&scenes::uniform(7, 5));
        checked.step(Setup::REFERENCE);
        let before = checked.save().0;
        let mut refuse = |bytes: &[u8], what: &str, at: usize| {
            assert_eq!(checked.world_mut().load(bytes), Err(Error::BadSnapshot), "{what} {at}");
            assert!(saved(checked.world()) == before, "{what} {at}: the world has changed");
        };
        for len in 0..snapshot.len() {
            refuse(&snapshot[..len], "cut to", len);
        }
        let mut bytes = snapshot.clone();
        for at in 0..snapshot.len() {
            for other in
                (0..8).map(|bit| snapshot[at] ^ 1 << bit).chain([0, 255, snapshot[at].wrapping_add(1)])
            {
                if other != snapshot[at] {
                    bytes[at] = other;
                    refuse(&bytes, "changed at", at);
                }
            }
            bytes[at] = snapshot[at];
        }
        checked.check();
        checked.step(Setup::REFERENCE);
        checked.world_mut().load(&bytes).expect("what has not been changed");
    }
}

#[test]
fn too_little_room_is_an_error() {
    let config = configs()[1].with_capacity(ample(12, 60));
    let mut slab = Slab::new::<u32>(&config);
    let world = lived::<u32>(&mut slab, &config, 10, 2);
    let size = world.snapshot_size();
    for len in [0, 1, 23, 24, size - 1] {
        let mut out = vec![7; len];
        assert_eq!(world.save(&mut out), Err(Error::OutputFull { needed: size as u64, room: len }));
        assert!(out.iter().all(|byte| *byte == 7), "nothing is written");
    }
}

#[test]
fn a_foreign_snapshot_is_refused() {
    let capacity = Capacity::for_objects(100).with_leaf_refs(50).with_pairs(400);
    let margin = Margin::length(0.25);
    let base = Config::new(capacity).with_margin(margin);
    let mut slab = Slab::new::<u32>(&base);
    let snapshot = saved(&lived::<u32>(&mut slab, &base, 90, 3));
    let others = [
        (Config::new(capacity), Field::Margin),
        (base.with_events(), Field::Events),
        (base.with_filters(), Field::Filters),
        (base.with_mode(Mode::Fat), Field::Mode),
    ];
    for (config, field) in others {
        let mut slab = Slab::new::<u32>(&config);
        let mut checked = Checked::<u32>::new(slab.world(&config));
        checked.insert(scenes::cube(0.0, 0.0, 0.0));
        let said = checked.refuse(|world| world.load(&snapshot));
        assert_eq!(said, Error::OtherConfig { field }, "{config:?}");
    }
    let mut narrow = Slab::new::<u16>(&base);
    let other = Error::OtherConfig { field: Field::Index };
    assert_eq!(narrow.world::<u16>(&base).load(&snapshot), Err(other));
    for (objects, pairs, field, needed) in [(89, 400, Field::Objects, 90), (100, 1, Field::Pairs, 0)] {
        let config = base.with_capacity(
            Capacity::for_objects(objects).with_leaf_refs(capacity.leaf_refs).with_pairs(pairs),
        );
        let mut slab = Slab::new::<u32>(&config);
        let mut checked = Checked::<u32>::new(slab.world(&config));
        checked.insert(scenes::cube(0.0, 0.0, 0.0));
        let said = checked.refuse(|world| world.load(&snapshot));
        let Error::NoRoom { field: named, needed: told, room } = said else { panic!("{said}") };
        assert_eq!((named, room), (field, if field == Field::Objects { objects } else { pairs }));
        assert!(told > room && (needed == 0 || told == needed), "{told} of {needed}");
    }
    for workers in [1, 2, 32] {
        let config = base.with_workers(workers);
        let mut slab = Slab::new::<u32>(&config);
        let mut world = slab.world::<u32>(&config);
        world.load(&snapshot).expect("the number of workers does not matter");
        assert_eq!(world.config(), config);
        assert_eq!(World::<u32>::open(slab.bytes_mut()).map(|world| world.config()), Ok(config));
    }
}

/// What issue 8 allows: 64 bytes an object for 8,000 objects, 16 bits, no events.
#[test]
fn a_snapshot_is_small() {
    const COUNT: usize = 8000;
    let base = Config::new(Capacity::for_objects(COUNT as u32));
    let margin = base.with_margin(Margin::share(0.05));
    for (name, config) in [
        ("plain", base),
        ("events", base.with_events()),
        ("margin", margin),
        ("margin, events", margin.with_events()),
    ] {
        let mut slab = Slab::new::<u16>(&config);
        let mut world = slab.world::<u16>(&config);
        let mut scene = Brownian::new(COUNT, 1);
        world.insert_many(Boxes::new(scene.boxes())).expect("room");
        let mut sizes = Vec::new();
        for frame in 0..8 {
            let boxes = if frame < 4 { scene.advance() } else { scene.boxes() };
            let step =
                world.set_kernels(Setup::REFERENCE.kernels).on(&Jobs::Serial).step_over(Boxes::new(boxes));
            step.expect("room for all pairs");
            sizes.push(world.snapshot_size());
        }
        println!("{name}: {sizes:?}, {:.1} bytes an object when settled", sizes[7] as f64 / COUNT as f64);
        assert!(name != "plain" || sizes[7] <= 64 * COUNT, "{sizes:?}");
    }
}

/// A load leaves no more to the next step than to find all pairs, as in a world that has just been made.
#[test]
fn the_first_step_after_a_load_is_one_that_finds_all_pairs() {
    for config in configs() {
        let config = config.with_capacity(ample(2000, 60_000));
        let (mut slab, mut room) = (Slab::new::<u32>(&config), Slab::new::<u32>(&config));
        let mut world = lived::<u32>(&mut slab, &config, 1900, 4);
        let mut fresh = room.world::<u32>(&config);
        let boxes: Vec<Aabb> = world.iter().map(|(_, aabb)| aabb).collect();
        fresh.insert_many(Boxes::new(&boxes)).expect("room");
        world.load(&saved(&world)).expect("a good snapshot");
        let [loaded, made] = [&mut world, &mut fresh].map(|world| {
            let setup = Setup::REFERENCE;
            world.under(&setup).step().expect("room").stats()
        });
        assert_eq!((loaded.path, loaded.rebalanced), (made.path, made.rebalanced));
        // Fat boxes may have grown apart.
        assert!(loaded.candidates <= made.candidates * 5 / 4 && loaded.copies <= made.copies * 5 / 4);
    }
}

/// While a world leaves its margins unused it is saved, loaded, changed one by one, shifted and moved as any: all steps are
/// checked, also those after it uses them again.
#[test]
fn margins_that_are_left_unused_are_no_special_case() {
    const COUNT: usize = 700;
    let config = Config::new(ample(COUNT + 50, 40 * COUNT))
        .without_predicted_boxes()
        .with_margin(Margin::length(0.1))
        .with_events();
    let mut larger = config;
    larger.capacity = ample(2 * COUNT, 80 * COUNT);
    let (mut slab, mut other) = (Slab::new::<u32>(&config), Slab::new::<u32>(&larger));
    let mut checked = Checked::<u32>::new(slab.world(&config));
    let boxes = uniform(COUNT, 4);
    let mut ids = checked.insert_many(&boxes);
    let mut along = 0.0;
    let mut steps = |checked: &mut Checked<'_, u32>, count: usize, speed: f32| {
        for _ in 0..count {
            along += speed;
            let frame: Vec<Aabb> = boxes.iter().map(|b| shifted(b, [along, 0.0, 0.0])).collect();
            checked.step_over(&frame, Setup::REFERENCE);
        }
        along
    };
    steps(&mut checked, 10, 0.2);
    assert_eq!(checked.world().stats().surplus, 0, "margins are not used");
    let saved = checked.save();
    steps(&mut checked, 3, 0.2);
    let expected = checked.world().stats();
    checked.load(&saved);
    checked.remove(ids[3]);
    ids[3] = checked.insert(boxes[3]);
    checked.set_margin(ids[5], 0.3);
    steps(&mut checked, 3, 0.2);
    assert_eq!(checked.world().stats().pairs, expected.pairs);
    checked.world_mut().validate().expect("a good world");
    // To a larger world, where margins are used from the start.
    let model = checked.model().clone();
    let world = checked.world().move_into(other.bytes_mut(), &larger).expect("room");
    let mut moved = Checked::resume(world, model);
    steps(&mut moved, 2, 0.001);
    assert!(moved.world().stats().surplus > 0, "margins are used");
    // And in the old one after some time.
    steps(&mut checked, 70, 0.001);
    assert!(checked.world().stats().surplus > 0, "margins are used again");
    checked.world_mut().validate().expect("a good world");
}
