//! Copies of worlds go on byte for byte, whatever was in the memory before; and sorted results are the same bytes in
//! worlds of other room and another past.

use trisap_core::{Boxes, Config, Error, Field, Filter, Id, Index, InlineWorld, Margin, World, layout};
use trisap_tests::doing::On as _;
use trisap_tests::lives::{act, configs, lived, saved};
use trisap_tests::oracle::overlaps;
use trisap_tests::scenes::{Rng, at, cube, shifted, uniform};
use trisap_tests::sorted;
use trisap_tests::worlds::{Setup, Slab, ample};

/// Worlds of all kinds: without a tree, lean, small, and with leaves that are divided.
fn kinds() -> impl Iterator<Item = (Config, usize)> {
    let [plain, events, margin, fat] = configs();
    let values = margin.with_filters().with_values();
    [plain, events, margin, fat, values, plain.with_margin(Margin::length(0.3))].into_iter().flat_map(
        |config| {
            let sized = |objects: usize, count| (config.with_capacity(ample(objects, 40 * count)), count);
            let (lean, count) = sized(220, 200);
            [sized(40, 30), (lean.with_lean(), count), sized(500, 450), sized(1800, 1600)]
        },
    )
}

fn go_on_alike<I: Index>(one: &mut World<'_, I>, other: &mut World<'_, I>, rng: &mut Rng, rounds: usize) {
    let setup = Setup::REFERENCE;
    for round in 0..rounds {
        let said = act(other, &mut rng.clone(), setup);
        assert!(act(one, rng, setup) == said, "round {round}: other pairs, or another order");
        assert!(saved(one) == saved(other), "round {round}");
    }
    one.validate().expect("a valid world");
    other.validate().expect("a valid world");
}

#[test]
fn a_copy_goes_on_byte_for_byte() {
    for (at, (config, count)) in kinds().enumerate() {
        let (mut slab, mut room) = (Slab::new::<u32>(&config), Slab::new::<u32>(&config));
        let mut world = lived::<u32>(&mut slab, &config, count, at % 6);
        // What lived in the memory of the copy before, and has more slots.
        let mut copy = lived::<u32>(&mut room, &config, count + 5, 5 - at % 6);
        let rng = &mut Rng::new(at as u64);
        for _ in 0..6 {
            copy.copy_from(&world).expect("the same configuration");
            assert_eq!(copy.stats(), world.stats());
            assert_eq!(
                (world.pairs(), world.found(), world.lost()),
                (copy.pairs(), copy.found(), copy.lost())
            );
            copy.validate().expect("a valid world");
            go_on_alike(&mut world, &mut copy, rng, 4);
            // Another way, and back.
            let kept = saved(&world);
            let _ = act(&mut world, &mut Rng::new(5), Setup::REFERENCE);
            world.copy_from(&copy).expect("the same configuration");
            assert!(saved(&world) == kept);
            go_on_alike(&mut world, &mut copy, rng, 2);
        }
        // The bytes themselves, opened again.
        let mut bytes = slab.clone();
        let mut copy = World::<u32>::open(bytes.bytes_mut()).expect("a copy of a world");
        let mut world = World::<u32>::open(slab.bytes_mut()).expect("the world");
        go_on_alike(&mut world, &mut copy, rng, 3);
    }
}

/// A world with strips along all axes, which are large objects, after some steps.
fn with_strips<'m>(slab: &'m mut Slab, config: &Config, steps: usize) -> World<'m, u32> {
    let mut rng = Rng::new(8);
    let mut boxes = uniform(1600, 3);
    for (k, aabb) in boxes.iter_mut().enumerate().step_by(11) {
        let (mut min, mut edges) = (aabb.min, [0.1; 3]);
        (min[k % 3], edges[k % 3]) = (-1.0, 80.0);
        *aabb = at(min, edges);
    }
    let mut world = slab.world::<u32>(config);
    let ids: Vec<Id> = world.insert_many(Boxes::new(&boxes)).expect("room").collect();
    for _ in 0..steps {
        world.step().expect("room");
        for _ in 0..20 {
            let k = rng.below(1600);
            world.set_aabb(ids[k], shifted(&boxes[k], rng.point(-0.5, 0.5))).expect("alive");
        }
    }
    world
}

#[test]
fn copies_have_the_order_of_large_objects_too() {
    for config in configs() {
        let config = config.with_capacity(ample(1800, 40_000));
        let [mut slab, mut room, mut again] = [(); 3].map(|()| Slab::new::<u32>(&config));
        let mut world = with_strips(&mut slab, &config, 6);
        let mut copy = lived::<u32>(&mut room, &config, 1700, 4);
        copy.copy_from(&world).expect("the same configuration");
        world.step().expect("room");
        copy.step().expect("room");
        assert!(world.stats().large > 90, "{:?}", world.stats());
        assert_eq!((world.stats(), world.pairs()), (copy.stats(), copy.pairs()));
        go_on_alike(&mut world, &mut copy, &mut Rng::new(3), 20);
        // Nor does a list matter that the memory had before.
        let _ = with_strips(&mut again, &config, 9);
        let (mut fresh, mut after) = (Slab::new::<u32>(&config), again);
        let [mut one, mut other] = [&mut fresh, &mut after].map(|slab| with_strips(slab, &config, 6));
        go_on_alike(&mut one, &mut other, &mut Rng::new(4), 20);
    }
}

#[test]
fn only_a_world_of_the_same_memory_is_copied() {
    let config = Config::new(ample(40, 100)).with_events();
    let mut slab = Slab::new::<u32>(&config);
    let world = lived::<u32>(&mut slab, &config, 30, 3);
    let others = [
        (config.with_filters(), Field::Filters),
        (config.with_capacity(ample(41, 100)), Field::Bytes),
        (config.with_capacity(ample(40, 101)), Field::Bytes),
    ];
    for (other, field) in others {
        let mut room = Slab::new::<u32>(&other);
        let mut there = lived::<u32>(&mut room, &other, 20, 1);
        let before = saved(&there);
        assert_eq!(there.copy_from(&world), Err(Error::OtherConfig { field }));
        assert!(saved(&there) == before);
    }
    const SMALL: Config = Config::new(ample(8, 28));
    let mut memory = InlineWorld::<{ layout::<u16>(&SMALL).unwrap().bytes }>::EMPTY;
    memory.init::<u16>(&SMALL).expect("room").insert(cube(0.0, 0.0, 0.0)).expect("room");
    assert_eq!(memory.clone().world::<u16>().expect("a copy").len(), 1);
}

#[test]
fn what_was_in_the_memory_does_not_matter() {
    for (at, (config, count)) in kinds().enumerate() {
        let config = config.with_workers(1 + at as u32 % 2);
        let (mut ones, mut zeros) = (Slab::new::<u16>(&config), Slab::new::<u16>(&config));
        zeros.bytes_mut().fill(0);
        assert!(ones.bytes().iter().all(|byte| *byte == 0xff));
        let mut one = lived::<u16>(&mut ones, &config, count, at % 5);
        let mut other = lived::<u16>(&mut zeros, &config, count, at % 5);
        go_on_alike(&mut one, &mut other, &mut Rng::new(at as u64), 30);
    }
}

/// Room for pairs is written when there are pairs.
#[test]
fn a_new_world_writes_only_what_must_be_clear() {
    let written = |config: &Config| {
        let mut slab = Slab::new::<u32>(config);
        slab.bytes_mut().fill(0xa5);
        slab.world::<u32>(config);
        slab.bytes().iter().filter(|byte| **byte != 0xa5).count()
    };
    for config in configs().map(|config| config.with_workers(2)) {
        let [few, many] = [10, 500_000].map(|pairs| config.with_capacity(ample(20_000, pairs)));
        assert_eq!(written(&few), written(&many));
        // Sets, generations, leaves; no boxes and no records.
        assert!(written(&few) < 20 * 20_000, "{} bytes", written(&few));
    }
}

/// Objects move, some go and as many come; then a step. The same for the same random numbers, whatever the room is.
fn play(world: &mut World<'_, u32>, rng: &mut Rng, movers: usize) {
    let ids: Vec<Id> = world.ids().collect();
    for at in 0..movers {
        let id = ids[rng.below(ids.len())];
        let Some(aabb) = world.aabb(id) else { continue };
        match rng.below(20) {
            0 => {
                world.remove(id).expect("alive");
                world.insert(shifted(&aabb, rng.point(-1.0, 1.0))).expect("room");
            }
            1 if world.config().filters => {
                world.set_filter(id, Filter::groups(1 << (at % 2), 3)).expect("filters");
            }
            _ => world.set_aabb(id, shifted(&aabb, rng.point(-1.0, 1.0))).expect("alive"),
        }
    }
    let setup = Setup::REFERENCE;
    world.under(&setup).step().expect("room");
}

#[test]
fn sorted_results_are_the_same_whatever_the_room_and_the_past_are() {
    for (at, (config, count)) in kinds().enumerate() {
        let mut large = config.with_capacity(ample(3 * count, 60 * count)).with_workers(3);
        large.lean = false;
        let [mut slab, mut plain] = [(); 2].map(|()| Slab::new::<u32>(&config));
        let mut room = Slab::new::<u32>(&large);
        let mut world = lived::<u32>(&mut slab, &config, count, at % 6);
        let mut unsorted = lived::<u32>(&mut plain, &config, count, at % 6);
        let mut loaded = room.world::<u32>(&large);
        let rng = &mut Rng::new(at as u64);
        let mut told = 0;
        for round in 0..24 {
            // Late joiners, now and then.
            let mut more = Slab::new::<u32>(&large);
            let mut moved = world.move_into(more.bytes_mut(), &large).expect("more room");
            if round % 6 == 0 {
                loaded.load(&saved(&world)).expect("more room");
            }
            let movers = [count / 2, 3, 0, 20][round % 4];
            for world in [&mut unsorted, &mut world, &mut loaded] {
                play(world, &mut rng.clone(), movers);
            }
            play(&mut moved, rng, movers);
            let sets = [unsorted.pairs(), unsorted.found(), unsorted.lost()].map(sorted);
            let sort = |world: &mut World<'_, u32>| {
                world.sort_results();
                world.validate().expect("a valid world");
                [world.pairs(), world.found(), world.lost()].map(|pairs| pairs.to_vec())
            };
            let (one, two, three) = (sort(&mut world), sort(&mut loaded), sort(&mut moved));
            assert!(one == two && one == three, "round {round}: another order");
            let (persisting, found) = one[0].split_at(one[0].len() - one[1].len());
            assert!(persisting.is_sorted() && found.is_sorted() && one[2].is_sorted());
            assert!(one.each_ref().map(|pairs| sorted(pairs)) == sets, "round {round}: other pairs");
            told += one[1].len() + one[2].len();
        }
        assert!(!config.events || told > 0);
    }
}

/// Back over a shift of the origin to a world whose leaves were being divided by refreshes: what is asked, stepped over
/// and checked is right on either side.
#[test]
fn a_way_back_over_a_shift_while_leaves_are_divided() {
    let config = Config::new(ample(5000, 60_000)).with_events();
    let (mut slab, mut room) = (Slab::new::<u32>(&config), Slab::new::<u32>(&config));
    let boxes = uniform(5000, 21);
    let right = overlaps(&boxes.iter().copied().map(Some).collect::<Vec<_>>());
    for refreshes in 0..7 {
        let (mut world, mut kept) = (slab.world::<u32>(&config), room.world::<u32>(&config));
        let ids: Vec<Id> = world.insert_many(Boxes::new(&boxes)).expect("room").collect();
        (0..refreshes).for_each(|_| world.refresh().expect("whole"));
        kept.copy_from(&world).expect("the same configuration");
        // There, as boxes and shifts are whole numbers of a step of `f32`, all is as it was.
        let by = [4096.0, 0.0, -1024.0];
        world.shift_origin(by).expect("finite");
        world.refresh().expect("whole");
        world.remove_many(&ids[..9]).expect("they live");
        world.validate().expect("a valid world");
        world.step().expect("room for the pairs");
        world.refresh().expect("whole");
        world.validate().expect("a valid world");
        world.copy_from(&kept).expect("the same configuration");
        for _ in 0..3 {
            world.validate().expect("a valid world");
            let mut found = vec![None; boxes.len()];
            for (id, aabb) in ids.iter().zip(&boxes).step_by(77) {
                let count = world.overlaps(&(*aabb).into(), &mut found).expect("a good region");
                let expected = (0..boxes.len()).filter(|&at| boxes[at].overlaps(aabb)).map(|at| at as u32);
                assert!(found[..count].iter().flatten().map(|id| id.slot()).eq(expected), "{id}");
            }
            world.refresh().expect("whole");
        }
        assert!(sorted(world.step().expect("room for the pairs").pairs()) == right);
        assert_eq!(world.found().len(), right.len());
        world.validate().expect("a valid world");
    }
}
