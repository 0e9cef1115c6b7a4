//! Snapshots: a world that is loaded goes on as the one that was saved, byte for byte; and no bytes, however wrong, do
//! harm.

use trisap_core::{Aabb, Boxes, Capacity, Config, Error, Filter, Id, Index, Kernels, Margin, Mode, World};
use trisap_tests::checked::{Checked, Outcome};
use trisap_tests::effort;
use trisap_tests::jobs::Jobs;
use trisap_tests::model::Model;
use trisap_tests::queries::Questions;
use trisap_tests::scenes::{self, Brownian, Rng, shifted};
use trisap_tests::worlds::{Setup, Slab, ample};

fn configs() -> [Config; 4] {
    let plain = Config::new(ample(0, 0));
    let margin = plain.with_margin(Margin { per_extent: 0.05, min: 0.02, max: 1.0 });
    [
        plain,
        plain.with_events().with_filters(),
        margin.with_events(),
        margin.with_mode(Mode::Fat).with_events(),
    ]
}

fn saved<I: Index>(world: &World<'_, I>) -> Vec<u8> {
    let mut bytes = vec![0; world.snapshot_size()];
    assert_eq!(world.save(&mut bytes), Ok(bytes.len()));
    bytes
}

/// Something happens to a world, and then a step: for the same random numbers the same.
fn act<I: Index>(world: &mut World<'_, I>, rng: &mut Rng, setup: Setup) -> Result<Outcome, Error> {
    let slots = (0..world.config().capacity.objects).filter_map(|slot| world.id_at(slot));
    let ids: Vec<Id> = slots.collect();
    let aabb = |world: &World<'_, I>, id: Id| world.aabb(id).expect("alive");
    let some = |rng: &mut Rng| -> Vec<Id> {
        let share = [1, 5, ids.len() / 3][rng.below(3)];
        (0..share).filter(|_| !ids.is_empty()).map(|_| ids[rng.below(ids.len())]).collect()
    };
    for _ in 0..rng.below(3) {
        let mut chosen = some(rng);
        chosen.retain(|id| world.contains(*id));
        match rng.below(8) {
            0 => {
                let near: Vec<Aabb> = chosen.iter().map(|id| aabb(world, *id)).collect();
                // There may be no room for all of them.
                let _ = world.insert_many(Boxes::new(&near), &mut vec![None; near.len()]);
            }
            1 => {
                chosen.sort_unstable();
                chosen.dedup();
                world.remove_many(&chosen).expect("living objects");
            }
            2 => world.set_resting(&chosen).expect("living objects"),
            3 if world.config().filters => {
                for id in chosen {
                    let filter =
                        Filter { class: rng.below(3) as u32, ..Filter::groups(1 << rng.below(2), 3) };
                    world.set_filter(id, filter).expect("alive");
                }
            }
            4 if world.config().filters => {
                let mut meets = [u32::MAX; 32];
                meets[rng.below(3)] = 5;
                world.set_classes(&meets).expect("filters");
            }
            _ => {
                for id in chosen {
                    let next = shifted(&aabb(world, id), rng.point(-1.0, 1.0));
                    world.set_aabb(id, next).expect("alive");
                }
            }
        }
    }
    let step = if rng.once_in(4) {
        let last = ids.last().map_or(0, |id| id.slot() as usize + 1);
        let place = |slot: usize| world.id_at(slot as u32).map_or(Aabb::default(), |id| aabb(world, id));
        let mut boxes: Vec<Aabb> = (0..last).map(place).collect();
        scenes::walk(&mut boxes, [5, 1000][rng.below(2)], 0.5, rng);
        world.step_over(Boxes::new(&boxes), setup.kernels, &setup.jobs)
    } else {
        world.step(setup.kernels, &setup.jobs)
    };
    step.map(|step| Outcome::of(&step))
}

/// At any point of a life: a snapshot goes to a world that has lived otherwise, with other workers, and both go on alike;
/// and the first one goes back and does all of it again. Returns how many steps found no room for their pairs.
fn follow<I: Index>(config: Config, count: usize, pairs: usize, setup: Setup) -> usize {
    let config = Config { capacity: ample(count + count / 8, pairs), ..config };
    let config = setup.configure(config);
    let other =
        Setup { jobs: if setup.jobs == Jobs::Serial { Jobs::Threads(3) } else { Jobs::Serial }, ..setup };
    let copied = other.configure(config);
    let (mut slab, mut room) = (Slab::new::<I>(&config), Slab::new::<I>(&copied));
    let mut world = slab.world::<I>(&config);
    let _ = room.world::<I>(&copied);
    let rng = &mut Rng::new(count as u64 * 31 + pairs as u64);
    let compare = |one: &Result<Outcome, Error>, other: &Result<Outcome, Error>, round: usize| {
        let stats = |said: &Result<Outcome, Error>| said.as_ref().map(|o| o.stats).map_err(|e| *e);
        assert_eq!(stats(one), stats(other), "round {round}");
        assert!(one == other, "round {round}: the same pairs in another order, or others");
    };
    let mut full = 0;
    for round in 0..40 {
        let snapshot = saved(&world);
        if round == 3 {
            world.insert_many(Boxes::new(&scenes::uniform(count, 1)), &mut vec![None; count]).expect("room");
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
        assert_eq!(world.stats(), copy.stats());
        let again = rng.clone();
        let outcome = act(&mut world, rng, setup);
        full += usize::from(outcome.is_err());
        compare(&outcome, &act(&mut copy, &mut again.clone(), other), round);
        // Two more steps without a load between them.
        let after = saved(&world);
        for _ in 0..2 {
            let again = rng.clone();
            let outcome = act(&mut world, rng, setup);
            compare(&outcome, &act(&mut copy, &mut again.clone(), other), round);
        }
        let last = saved(&world);
        world.load(&snapshot).expect("a good snapshot");
        assert!(saved(&world) == snapshot, "round {round}: what was loaded is saved as it was");
        let mut again = again;
        compare(&outcome, &act(&mut world, &mut again, setup), round);
        assert!(saved(&world) == after, "round {round}: the same step leaves the same world");
        for _ in 0..2 {
            let _ = act(&mut world, &mut again, setup);
        }
        assert!(saved(&world) == last, "round {round}: the same steps leave the same world");
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

/// A world in the middle of its life, with something that has happened since the last step.
fn lived<'m, I: Index>(slab: &'m mut Slab, config: &Config, count: usize, calm: usize) -> World<'m, I> {
    let mut world = slab.world::<I>(config);
    let boxes: Vec<Aabb> =
        scenes::uniform(count, 2).iter().map(|b| scenes::at(b.min.map(|x| x * 0.6), [1.0; 3])).collect();
    let mut ids = vec![None; count];
    world.insert_many(Boxes::new(&boxes), &mut ids).expect("room");
    let ids: Vec<Id> = ids.into_iter().flatten().collect();
    let setup = Setup::REFERENCE;
    // Without room for all pairs it goes on all the same.
    let _ = world.step(setup.kernels, &setup.jobs);
    for at in 0..calm {
        world.set_aabb(ids[at], boxes[at + 1]).expect("alive");
        let _ = world.step(setup.kernels, &setup.jobs);
    }
    world.set_resting(&ids[..count / 3]).expect("alive");
    if calm % 2 == 1 {
        world.remove(ids[2]).expect("alive");
        world.remove(ids[count / 2]).expect("alive");
        world.insert(boxes[0]).expect("room");
        world.set_aabb(ids[0], boxes[3]).expect("alive");
    }
    world
}

#[test]
fn every_truncation_and_every_changed_byte_is_noticed() {
    for config in configs() {
        let config = Config { capacity: ample(12, 60), ..config };
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
    let config = Config { capacity: ample(12, 60), ..configs()[1] };
    let mut slab = Slab::new::<u32>(&config);
    let world = lived::<u32>(&mut slab, &config, 10, 2);
    let size = world.snapshot_size();
    for len in [0, 1, 23, 24, size - 1] {
        let mut out = vec![7; len];
        assert_eq!(world.save(&mut out), Err(Error::OutputFull { needed: size as u64 }));
        assert!(out.iter().all(|byte| *byte == 7), "nothing is written");
    }
}

#[test]
fn a_foreign_snapshot_is_refused() {
    let capacity = Capacity { objects: 100, leaf_refs: 50, pairs: 400 };
    let margin = Margin::length(0.25);
    let base = Config::new(capacity).with_margin(margin);
    let mut slab = Slab::new::<u32>(&base);
    let snapshot = saved(&lived::<u32>(&mut slab, &base, 90, 3));
    let others = [
        Config::new(capacity),
        base.with_events(),
        base.with_filters(),
        base.with_lean(),
        base.with_mode(Mode::Fat),
        base.with_margin(Margin { max: 0.5, ..margin }),
        base.with_margin(Margin { min: 0.125, ..margin }),
        base.with_margin(Margin { per_extent: 0.5, ..margin }),
        Config { capacity: Capacity { objects: 101, ..capacity }, ..base },
        Config { capacity: Capacity { leaf_refs: 51, ..capacity }, ..base },
        Config { capacity: Capacity { pairs: 401, ..capacity }, ..base },
    ];
    for config in others {
        let mut slab = Slab::new::<u32>(&config);
        let mut checked = Checked::<u32>::new(slab.world(&config));
        checked.insert(scenes::cube(0.0, 0.0, 0.0));
        assert_eq!(checked.refuse(|world| world.load(&snapshot)), Error::BadSnapshot, "{config:?}");
    }
    let mut narrow = Slab::new::<u16>(&base);
    assert_eq!(narrow.world::<u16>(&base).load(&snapshot), Err(Error::BadSnapshot));
    for workers in [1, 2, 32] {
        let config = base.with_workers(workers);
        let mut slab = Slab::new::<u32>(&config);
        let mut world = slab.world::<u32>(&config);
        world.load(&snapshot).expect("the number of workers does not matter");
        assert_eq!(world.config(), config);
        assert_eq!(World::<u32>::open(slab.bytes_mut()).map(|world| world.config()), Ok(config));
    }
}

/// The checksum of the format, written out again, to forge snapshots with.
fn checksum(bytes: &[u8]) -> u64 {
    let mix = |sum: u64, word: u64| (sum ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
    let whole = bytes.len() / 32 * 32;
    let mut sums = [1, 2, 3, 4];
    for (at, word) in bytes[..whole].chunks_exact(8).enumerate() {
        sums[at % 4] = mix(sums[at % 4], u64::from_ne_bytes(word.try_into().expect("eight bytes")));
    }
    let rest = bytes[whole..].iter().fold(bytes.len() as u64, |sum, byte| mix(sum, u64::from(*byte)));
    sums.into_iter().fold(rest, mix)
}

/// Bytes of the header; the checksum is the last eight of them.
const HEADER: usize = 24;

fn seal(snapshot: &mut [u8]) {
    let sum = checksum(&snapshot[HEADER..]);
    snapshot[HEADER - 8..HEADER].copy_from_slice(&sum.to_ne_bytes());
}

/// Changes some numbers, most of them near the front, where the state is.
fn forge(snapshot: &mut Vec<u8>, rng: &mut Rng) {
    for _ in 0..1 + rng.below(3) {
        let reach = if rng.once_in(2) { snapshot.len().min(HEADER + 400) } else { snapshot.len() };
        let at = HEADER + rng.below((reach - HEADER) / 2 - 4) * 2;
        let old = u32::from_ne_bytes(snapshot[at..at + 4].try_into().expect("four bytes"));
        let word = match rng.below(8) {
            0 => 0,
            1 => u32::MAX,
            2 => old.wrapping_add(1),
            3 => old.wrapping_sub(1),
            4 => old ^ 1 << rng.below(32),
            5 => rng.below(1000) as u32,
            6 => i32::MAX as u32,
            _ => rng.bits() as u32,
        };
        snapshot[at..at + 4].copy_from_slice(&word.to_ne_bytes());
    }
    if rng.once_in(20) {
        let len = HEADER + rng.below(snapshot.len() - HEADER);
        snapshot.resize(len, 0);
        let body = (len - HEADER) as u64;
        snapshot[8..16].copy_from_slice(&body.to_ne_bytes());
    }
    seal(snapshot);
}

/// Forged snapshots with a right checksum: an error, or a world that can be used without a panic. This build checks every
/// index and every sum.
fn survive<I: Index>(config: Config, count: usize, calm: usize, times: usize, setup: Setup) {
    let config = setup.configure(config);
    let mut source = Slab::new::<I>(&config);
    let snapshot = saved(&lived::<I>(&mut source, &config, count, calm));
    let mut copy = snapshot.clone();
    seal(&mut copy);
    assert!(copy == snapshot, "the checksum is that of the format");
    let mut slab = Slab::new::<I>(&config);
    let mut world = slab.world::<I>(&config);
    let rng = &mut Rng::new(count as u64 + calm as u64);
    let (mut good, mut bad) = (0, 0);
    for _ in 0..times {
        let mut forged = snapshot.clone();
        forge(&mut forged, rng);
        if let Err(error) = world.load(&forged) {
            assert_eq!(error, Error::BadSnapshot);
            world.validate().expect("a valid world");
            bad += 1;
            // Whatever was in the world before.
            if rng.once_in(2) {
                world.load(&snapshot).expect("a good snapshot");
            }
            continue;
        }
        good += 1;
        let questions = Questions::about(&Model::default(), 3, rng);
        for _ in 0..5 {
            query(&world, &questions, setup);
            let _ = act(&mut world, rng, setup);
            let _ = world.leaves().count() + world.planes().count() + world.large().count();
            let _ = world.validate();
            saved(&world);
        }
        let far: Vec<Aabb> = vec![scenes::cube(1e9, 0.0, 0.0); world.len() as usize];
        let _ = world.step_over(Boxes::new(&far), setup.kernels, &setup.jobs).map(|_| ());
    }
    assert!(good > 0 && bad > 0, "{good} loaded, {bad} refused");
}

fn query<I: Index>(world: &World<'_, I>, questions: &Questions, setup: Setup) {
    for region in &questions.regions {
        let _ = world.overlaps(region, setup.kernels, &mut [None; 8]);
    }
    for cast in &questions.casts {
        let _ = world.hits(cast, setup.kernels, &mut [None; 8]);
    }
    for (point, _) in &questions.points {
        let _ = world.nearest(*point, setup.kernels, &mut [None; 8]);
    }
}

#[test]
fn forged_snapshots_do_no_harm() {
    let times = effort() as usize;
    let last = Setup { kernels: Kernels::detect(), jobs: Jobs::Threads(2) };
    for setup in [Setup::REFERENCE, last] {
        for (at, config) in configs().into_iter().enumerate() {
            let sized = |objects: usize, pairs: usize| Config { capacity: ample(objects, pairs), ..config };
            survive::<u16>(sized(24, 100), 20, at, 800 * times, setup);
            survive::<u32>(sized(300, 4000), 290, at, 150 * times, setup);
            for calm in [0, 1, 4] {
                survive::<u16>(sized(700, 9000), 650, calm, 300 * times, setup);
            }
            // Without room for all pairs.
            survive::<u16>(sized(700, 90), 650, 1, 100 * times, setup);
        }
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
        world.insert_many(Boxes::new(scene.boxes()), &mut vec![None; COUNT]).expect("room");
        let mut sizes = Vec::new();
        for frame in 0..8 {
            let boxes = if frame < 4 { scene.advance() } else { scene.boxes() };
            let step = world.step_over(Boxes::new(boxes), Setup::REFERENCE.kernels, &Jobs::Serial);
            step.expect("room for all pairs");
            sizes.push(world.snapshot_size());
        }
        println!("{name}: {sizes:?}, {:.1} bytes an object when settled", sizes[7] as f64 / COUNT as f64);
        assert!(name != "plain" || sizes[7] <= 64 * COUNT, "{sizes:?}");
    }
}
