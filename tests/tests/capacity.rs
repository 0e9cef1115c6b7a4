//! Every limit, from nothing to enough: the right error with the right need, a defined prefix, and a world that
//! goes on as if nothing had happened.

use trisap_core::{
    Aabb, Boxes, Capacity, Config, Error, Field, Id, InlineWorld, Layout, Margin, Mode, World, layout,
};
use trisap_tests::checked::{Checked, expected, slots};
use trisap_tests::jobs::Jobs;
use trisap_tests::scenes::{self, cube};
use trisap_tests::worlds::{Setup, Slab, ample};
use trisap_tests::{SlotPair, sorted};

fn config(objects: usize, pairs: usize) -> Config {
    Config::new(ample(objects, pairs)).with_events()
}

/// The pairs of a fresh world with room for all, in its own order.
fn ample_pairs(base: Config, boxes: &[Aabb], setup: Setup) -> Vec<SlotPair> {
    let config = setup.configure(base);
    let mut slab = Slab::new::<u32>(&config);
    let mut checked = Checked::<u32>::new(slab.world(&config));
    checked.insert_many(boxes);
    checked.step(setup).pairs
}

/// The boxes spread out until only the first two meet.
fn spread(count: usize) -> Vec<Aabb> {
    let place = |i: usize| cube(if i < 2 { 0.0 } else { 10.0 * i as f32 }, 0.0, 0.0);
    (0..count).map(place).collect()
}

/// Steps with too little room in every stage of a world's life.
fn overflow(boxes: &[Aabb], capacities: impl Iterator<Item = usize>, setup: Setup) {
    let needed = expected(boxes).len();
    // Without events, pairs stay in the order in which they are found.
    let mut without_events = config(boxes.len(), needed);
    without_events.events = false;
    let all = ample_pairs(without_events, boxes, setup);
    let apart = spread(boxes.len());
    for capacity in capacities {
        assert!(capacity < needed);
        let config = setup.configure(config(boxes.len(), capacity));
        let full = Error::PairsFull { needed: needed as u64, room: capacity as u32 };
        let mut slab = Slab::new::<u32>(&config);
        let mut checked = Checked::<u32>::new(slab.world(&config));
        checked.insert_many(boxes);
        for attempt in 0..3 {
            assert_eq!(checked.try_step(setup).expect_err("no room"), full, "attempt {attempt} {setup:?}");
            // Later attempts may find them in another order, as the planes have changed.
            if attempt == 0 {
                // The first ones, but those that are found come in the opposite order.
                assert_eq!(sorted(&slots(checked.world().pairs())), sorted(&all[..capacity]), "{setup:?}");
            }
        }
        if capacity == 0 {
            continue;
        }
        // The first complete step: everything is found. The model checks the events.
        assert_eq!(checked.step_over(&apart, setup).found, [[0, 1]]);
        // Overflow again, and back: nothing has happened since the last complete step.
        assert_eq!(checked.try_step_over(boxes, setup).expect_err("no room"), full);
        let outcome = checked.step_over(&apart, setup);
        assert!(outcome.found.is_empty() && outcome.lost.is_empty(), "{setup:?}: {outcome:?}");
        // Overflow, and back to something else: the difference skips the step that failed.
        assert_eq!(checked.try_step_over(boxes, setup).expect_err("no room"), full);
        let mut other = apart.clone();
        other[0] = cube(-50.0, 0.0, 0.0);
        let outcome = checked.step_over(&other, setup);
        assert_eq!((outcome.found.len(), outcome.lost), (0, vec![[0, 1]]), "{setup:?}");
    }
}

#[test]
fn pairs_from_nothing_to_enough_in_a_small_world() {
    let boxes =
        scenes::uniform(40, 1).iter().map(|b| Aabb::new(b.min, b.max.map(|x| x + 1.5))).collect::<Vec<_>>();
    let needed = expected(&boxes).len();
    assert!(needed > 60, "{needed} pairs");
    for setup in Setup::each(&Jobs::USUAL) {
        overflow(&boxes, 0..needed, setup);
        let exact = config(boxes.len(), needed);
        assert_eq!(ample_pairs(exact, &boxes, setup).len(), needed);
    }
}

#[test]
fn pairs_from_nothing_to_enough_in_a_large_world() {
    let boxes = scenes::uniform(4000, 2);
    let needed = expected(&boxes).len();
    for setup in Setup::each(&[Jobs::Serial, Jobs::Threads(2), Jobs::Never, Jobs::Crowd]) {
        let some = [0, 1, 2, 3, 63, 64, 511, 512, 513, 1023, 1024, 1025, needed / 2, needed - 2, needed - 1];
        overflow(&boxes, some.into_iter().filter(|some| *some < needed), setup);
        let exact = config(boxes.len(), needed);
        assert_eq!(ample_pairs(exact, &boxes, setup).len(), needed);
    }
}

/// With fat boxes the pair buffer may have to hold more than the result: what the error says is enough, and one
/// less is not.
#[test]
fn the_need_that_an_error_tells_is_enough() {
    for boxes in [scenes::uniform(60, 3), scenes::uniform(1500, 3)] {
        for mode in [Mode::Exact, Mode::Fat] {
            for setup in Setup::each(&Jobs::USUAL) {
                let attempt = |pairs: u64| {
                    let base =
                        config(boxes.len(), pairs as usize).with_margin(Margin::length(0.2)).with_mode(mode);
                    let config = setup.configure(base);
                    let mut slab = Slab::new::<u32>(&config);
                    let mut checked = Checked::<u32>::new(slab.world(&config));
                    checked.insert_many(&boxes);
                    checked.try_step(setup).map(|outcome| outcome.pairs.len())
                };
                let Err(Error::PairsFull { needed, room: 0 }) = attempt(0) else {
                    panic!("no room is not enough")
                };
                for pairs in [1, needed / 2, needed - 1] {
                    let full = Error::PairsFull { needed, room: pairs as u32 };
                    assert_eq!(attempt(pairs), Err(full), "{setup:?}");
                }
                assert!(attempt(needed).is_ok(), "{setup:?}: {needed} pairs were said to be enough");
            }
        }
    }
}

#[test]
fn leaf_references_from_nothing_to_enough() {
    // Long boxes straddle a lot.
    let boxes =
        scenes::uniform(2000, 4).into_iter().map(|b| Aabb::new(b.min, [b.max[0] + 4.0, b.max[1], b.max[2]]));
    let boxes: Vec<Aabb> = boxes.collect();
    let moved: Vec<Aabb> = boxes.iter().rev().copied().collect();
    let pairs = expected(&boxes).len();
    let base = config(boxes.len(), 2 * pairs);
    for setup in Setup::each(&[Jobs::Serial, Jobs::Threads(2), Jobs::Never, Jobs::Crowd]) {
        for leaf_refs in (0..20).chain([50, 100, 200, 400, 800, 1600, 3200]) {
            let mut config = setup.configure(base);
            config.capacity.leaf_refs = leaf_refs;
            let mut slab = Slab::new::<u32>(&config);
            let mut checked = Checked::<u32>::new(slab.world(&config));
            checked.insert_many(&boxes);
            let leaves = checked.step(setup).stats.leaves;
            assert!(leaves == 1 || leaf_refs > 0, "no tree without leaf references");
            // All move, then a few, then all back.
            checked.step_over(&moved, setup);
            checked.step_over(&[&boxes[..10], &moved[10..]].concat(), setup);
            checked.step_over(&boxes, setup);
        }
    }
}

#[test]
fn objects_from_none_to_one_too_many() {
    let unit = cube(0.0, 0.0, 0.0);
    for count in [0_usize, 1, 2, 7, 512, 513, 1100] {
        let config = config(count, count * count);
        let setup = Setup::REFERENCE;
        let mut slab = Slab::new::<u16>(&config);
        let mut checked = Checked::<u16>::new(slab.world(&config));
        let full = |more: u64| Error::ObjectsFull { needed: count as u64 + more, room: count as u32 };
        assert!(checked.step(setup).pairs.is_empty());
        let many = vec![unit; count + 1];
        let error = checked.refuse(|world| world.insert_many(Boxes::new(&many)).map(drop));
        assert_eq!(error, full(1));
        let place = |i: usize| cube(2.0 * i as f32, 0.0, 0.0);
        let ids: Vec<Id> = (0..count).map(|i| checked.insert(place(i))).collect();
        assert_eq!(checked.refuse(|world| world.insert(unit)), full(1));
        assert_eq!(checked.refuse(|world| world.insert_many(Boxes::new(&[unit; 3])).map(drop)), full(3));
        checked.step(setup);
        // A slot that comes free is one object's room.
        if let Some(id) = ids.last() {
            checked.remove(*id);
            checked.insert(unit);
            assert_eq!(checked.refuse(|world| world.insert(unit)), full(1));
            checked.step(setup);
        }
        // Nothing inserted into a full world is fine.
        checked.insert_many(&[]);
    }
}

#[test]
fn a_batch_is_inserted_whoever_takes_its_ids() {
    let boxes = [cube(0.0, 0.0, 0.0); 5];
    for taken in 0..=5 {
        let config = config(20, 100);
        let mut slab = Slab::new::<u32>(&config);
        let mut world = slab.world::<u32>(&config);
        let mut ids = world.insert_many(Boxes::new(&boxes)).expect("room");
        let first: Vec<Id> = ids.by_ref().take(taken).collect();
        assert_eq!((first.len(), ids.len()), (taken, 5 - taken));
        drop(ids);
        assert_eq!(world.len(), 5);
        assert!(first.iter().copied().eq(world.ids().take(taken)));
    }
}

#[test]
fn batches_are_all_or_nothing() {
    let config = config(20, 100);
    let mut slab = Slab::new::<u32>(&config);
    let mut checked = Checked::<u32>::new(slab.world(&config));
    let good = cube(0.0, 0.0, 0.0);
    let bad = Aabb::new([1.0; 3], [0.0; 3]);
    let ids = checked.insert_many(&[good; 6]);
    let gone = checked.insert(good);
    checked.remove(gone);
    let stale = Error::StaleId { id: gone };

    let batch = [good, good, bad, bad];
    assert_eq!(checked.refuse(|w| w.insert_many(Boxes::new(&batch)).map(drop)), Error::BadBox { index: 2 });
    let elsewhere = [cube(5.0, 5.0, 5.0); 3];
    let error = checked.refuse(|w| w.update_many(&[ids[0], gone, ids[1]], Boxes::new(&elsewhere)));
    assert_eq!(error, stale);
    let one_bad = [elsewhere[0], elsewhere[0], bad];
    let error = checked.refuse(|w| w.update_many(&ids[..3], Boxes::new(&one_bad)));
    assert_eq!(error, Error::BadBox { index: 2 });
    for count in [2, 4] {
        let error = checked.refuse(|w| w.update_many(&ids[..count], Boxes::new(&elsewhere)));
        assert!(matches!(error, Error::LengthMismatch { .. }), "{error}");
    }
    assert_eq!(checked.refuse(|w| w.remove_many(&[ids[0], ids[1], gone])), stale);
    // The second removal of the same object names no living one.
    let twice = [ids[0], ids[1], ids[0]];
    assert_eq!(checked.refuse(|w| w.remove_many(&twice)), Error::StaleId { id: ids[0] });
    // Of two boxes for one object the later one holds.
    checked.update_many(&[ids[0], ids[0]], &[elsewhere[0], good]);

    assert_eq!(checked.refuse(|w| w.insert(bad)), Error::BadBox { index: 0 });
    assert_eq!(checked.refuse(|w| w.set_aabb(ids[0], bad)), Error::BadBox { index: 0 });
    assert_eq!(checked.refuse(|w| w.set_aabb(gone, good)), stale);
    assert_eq!(checked.refuse(|w| w.remove(gone)), stale);
    assert_eq!(checked.refuse(|w| w.set_margin(gone, 1.0)), stale);
    let foreign = Id::from_bits((1 << 32) | 4_000_000).expect("an id");
    assert_eq!(checked.refuse(|w| w.remove(foreign)), Error::StaleId { id: foreign });
    assert_eq!(checked.world().aabb(gone), None);
    assert!(!checked.world().contains(foreign) && checked.world().id_at(4_000_000).is_none());
    checked.step(Setup::REFERENCE);
    checked.remove_many(&ids);
    assert!(checked.step(Setup::REFERENCE).pairs.is_empty());
}

#[test]
fn slabs_are_checked() {
    let config = config(100, 100);
    let Layout { bytes, align, .. } = layout::<u32>(&config).expect("a small world");
    let mut slab = Slab::new::<u32>(&Config::new(ample(200, 200)));
    let memory = slab.bytes_mut();
    assert!(memory.len() > bytes + align);
    for short in [0, 1, bytes / 2, bytes - 1] {
        let error = World::<u32>::new_in(&mut memory[..short], &config).err();
        assert_eq!(error, Some(Error::SlabTooSmall { needed: bytes, given: short }));
        assert!(World::<u32>::open(&mut memory[..short]).is_err());
    }
    let shifted = World::<u32>::new_in(&mut memory[1..], &config).err();
    assert_eq!(shifted, Some(Error::SlabMisaligned { align }));
    assert_eq!(World::<u32>::open(memory).err(), Some(Error::NotAWorld));
    World::<u32>::new_in(memory, &config).expect("more memory than needed");
    assert_eq!(World::<u32>::open(memory).map(|world| world.config()).ok(), Some(config));
    assert_eq!(World::<u16>::open(memory).err(), Some(Error::NotAWorld));
    assert_eq!(
        World::<u32>::open(&mut memory[..bytes - 1]).err(),
        Some(Error::SlabTooSmall { needed: bytes, given: bytes - 1 })
    );
    // Whatever lay in the memory before.
    memory.fill(0xa5);
    assert_eq!(World::<u32>::open(memory).err(), Some(Error::NotAWorld));
    let mut checked = Checked::<u32>::new(World::new_in(memory, &config).expect("a world"));
    checked.insert_many(&scenes::uniform(50, 4));
    checked.step(Setup::REFERENCE);
}

#[test]
fn capacities_beyond_the_index_width_are_refused() {
    assert_eq!(
        (Capacity::default(), Config::default().capacity),
        (Capacity::for_objects(1024), Capacity::default())
    );
    let objects = |objects: u32| Config::new(Capacity::for_objects(objects).with_leaf_refs(0).with_pairs(0));
    assert!(layout::<u16>(&objects(65_534)).is_some());
    assert!(layout::<u16>(&objects(65_535)).is_none());
    // More than 4 GiB.
    assert_eq!(layout::<u32>(&objects(1 << 27)).is_some(), size_of::<usize>() > 4);
    assert!(layout::<u32>(&objects((1 << 27) + 1)).is_none());
    assert!(layout::<u32>(&objects(u32::MAX)).is_none());
    for workers in [0, 33, u32::MAX] {
        assert!(layout::<u32>(&objects(10).with_workers(workers)).is_none(), "{workers} workers");
    }
    assert!(layout::<u32>(&objects(10).with_workers(32)).is_some());
    let too_large = |field, most| Some(Error::CapacityTooLarge { field, most });
    let refused = |config: Config| World::<u16>::new_in(&mut [], &config).err();
    assert_eq!(refused(objects(65_535)), too_large(Field::Objects, 65_534));
    assert_eq!(refused(objects(257).with_lean()), too_large(Field::Objects, 256));
    assert_eq!(refused(objects(10).with_workers(33)), too_large(Field::Workers, 32));
    assert_eq!(refused(objects(10).with_workers(0)), too_large(Field::Workers, 32));
    // Sixteen bits take less room, and events, margins and workers take more.
    let bytes = |config: &Config| layout::<u32>(config).map(|layout| layout.bytes).expect("a small world");
    let plain = Config::new(ample(1000, 1000));
    assert!(layout::<u16>(&plain).expect("a small world").bytes < bytes(&plain));
    for more in [plain.with_events(), plain.with_margin(Margin::length(0.0)), plain.with_workers(2)] {
        assert!(bytes(&more) > bytes(&plain));
    }
}

/// A sum that wraps around would give a small layout for a large capacity: there must be none, or one that grows.
#[test]
fn no_layout_is_beyond_the_address_space() {
    let most = Capacity::for_objects(1 << 27).with_leaf_refs(u32::MAX).with_pairs(u32::MAX);
    let parts: [fn(&mut Capacity) -> &mut u32; 3] =
        [|c| &mut c.objects, |c| &mut c.leaf_refs, |c| &mut c.pairs];
    for part in parts {
        for (events, workers) in [(false, 1), (false, 32), (true, 32)] {
            let mut before = Some(0);
            // From close to nothing to the most, so that every power of two is passed closely.
            for share in 0..2048 {
                let mut capacity = Capacity::for_objects(1000).with_leaf_refs(1000).with_pairs(1000);
                *part(&mut capacity) = (u64::from(*part(&mut most.clone())) * share / 2047) as u32;
                let mut config = Config::new(capacity).with_workers(workers);
                config.events = events;
                let bytes = layout::<u32>(&config).map(|layout| layout.bytes);
                match (before, bytes) {
                    (Some(before), Some(bytes)) => assert!(before <= bytes && bytes <= isize::MAX as usize),
                    (None, Some(bytes)) => panic!("{bytes} bytes for {capacity:?}, and none for less"),
                    (_, None) => assert!(size_of::<usize>() == 4, "no layout for {capacity:?}"),
                }
                before = bytes;
            }
        }
    }
}

#[test]
fn bad_margins_are_refused() {
    let good = config(4, 4).with_margin(Margin::share(0.1));
    let mut slab = Slab::new::<u32>(&good);
    let lengths = [-1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    for length in lengths {
        for margin in [
            Margin::length(length),
            Margin::share(length),
            Margin { per_extent: 0.0, min: length, max: 1.0 },
            Margin { per_extent: 0.0, min: 0.0, max: length },
            Margin { per_extent: 0.0, min: 2.0, max: 1.0 },
        ] {
            let error = World::<u32>::new_in(slab.bytes_mut(), &good.with_margin(margin)).err();
            assert_eq!(error, Some(Error::BadMargin), "{margin:?}");
        }
    }
    let mut checked = Checked::<u32>::new(slab.world(&good));
    let id = checked.insert(cube(0.0, 0.0, 0.0));
    for length in lengths {
        assert_eq!(checked.refuse(|world| world.set_margin(id, length)), Error::BadMargin, "{length}");
    }
    checked.set_margin(id, 0.0);
    checked.set_margin(id, f32::MAX);
    let plain = config(4, 4);
    let mut slab = Slab::new::<u32>(&plain);
    let mut without = slab.world::<u32>(&plain);
    let id = without.insert(cube(0.0, 0.0, 0.0)).expect("room");
    assert_eq!(without.set_margin(id, 1.0), Err(Error::NoMargins));
    checked.step(Setup::REFERENCE);
}

/// A world in its own memory is the same world.
#[test]
fn an_inline_world_is_a_world() {
    const CONFIG: Config = Config::new(Capacity::for_objects(600)).with_events();
    const BYTES: usize = match layout::<u16>(&CONFIG) {
        Some(layout) => layout.bytes,
        None => 0,
    };
    let mut inline = Box::new(InlineWorld::<BYTES>::EMPTY);
    assert_eq!(inline.world::<u16>().err(), Some(Error::NotAWorld));
    let mut slab = Slab::new::<u16>(&CONFIG);
    let frames = [scenes::uniform(600, 8), scenes::uniform(600, 9)];
    let mut outcomes = Vec::new();
    for world in [inline.init::<u16>(&CONFIG).expect("room"), slab.world(&CONFIG)] {
        let mut checked = Checked::new(world);
        checked.insert_many(&frames[0]);
        checked.step(Setup::REFERENCE);
        outcomes.push(checked.step_over(&frames[1], Setup::REFERENCE));
    }
    assert_eq!(outcomes[0], outcomes[1]);
    assert_eq!(inline.world::<u16>().expect("the same world again").len(), 600);
    assert_eq!(inline.world::<u32>().err(), Some(Error::NotAWorld));
}

/// Boxes that reach beyond their leaves are counted in all blocks of slots: here in the last ones, which alone have more of them than
/// there is room for.
#[test]
fn copies_are_counted_wherever_their_slots_are() {
    const COUNT: usize = 6000;
    let edge = 0.2 * scenes::side(COUNT);
    let mut boxes = scenes::uniform(COUNT, 11);
    for aabb in &mut boxes[COUNT / 2..] {
        *aabb = scenes::at(aabb.min, [edge; 3]);
    }
    for leaf_refs in [0, 200, 1000] {
        let mut base = config(COUNT, 200 * COUNT);
        base.capacity.leaf_refs = leaf_refs;
        let mut slab = Slab::new::<u32>(&base);
        let mut world = Checked::<u32>::new(slab.world(&base));
        world.insert_many(&boxes);
        let stats = world.step(Setup::REFERENCE).stats;
        assert!(stats.leaves < 16, "fewer leaves than without large boxes: {stats:?}");
    }
}
