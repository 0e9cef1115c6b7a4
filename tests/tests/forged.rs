//! Snapshots that were forged with a right checksum: refused with the world as it was, or loaded, valid, and as right as brute
//! force from then on.

use trisap_core::{Config, Error, Id, Index, Kernels, World};
use trisap_tests::doing::On as _;
use trisap_tests::effort;
use trisap_tests::forging::{FRONT, HEADER, forge, get, go_on, places_of, places_of_change, put, seal};
use trisap_tests::jobs::Jobs;
use trisap_tests::lives::{act, configs, lived, saved};
use trisap_tests::model::Model;
use trisap_tests::queries::Questions;
use trisap_tests::scenes::{Rng, cube};
use trisap_tests::worlds::{Setup, Slab, ample};

/// Where numbers of the state stand that worlds differ in.
struct Numbers {
    live: usize,
    free: usize,
    dirty: usize,
    resting: usize,
    complete: usize,
    found: usize,
    /// And how many pairs are kept for that.
    lost: [usize; 2],
}

impl Numbers {
    /// Found by what happens to a row of cubes, in which each overlaps the next one.
    fn find() -> Self {
        let config = Config::new(ample(9, 12)).with_events();
        let mut slab = Slab::new::<u32>(&config);
        let mut world = slab.world::<u32>(&config);
        let row = (0..9).map(|k| cube(0.9 * k as f32, 0.0, 0.0));
        let ids: Vec<Id> = row.map(|aabb| world.insert(aabb).expect("room")).collect();
        let mut after = |act: &dyn Fn(&mut World<'_, u32>)| {
            let before = saved(&world);
            act(&mut world);
            [before, saved(&world)]
        };
        let step = |world: &mut World<'_, u32>| {
            let _ = world.step();
        };
        let crowd = |world: &mut World<'_, u32>| {
            let all = ids.iter().filter(|id| world.set_aabb(**id, cube(0.0, 0.0, 0.0)).is_ok());
            assert_eq!(all.count(), 7, "those that live");
            step(world);
        };
        let place = |k: usize| {
            let id = ids[k];
            move |world: &mut World<'_, u32>| world.set_aabb(id, cube(70.0, 0.0, 0.0)).expect("alive")
        };
        after(&step);
        let rest = after(&|world| world.set_resting(&ids[..1]).expect("alive"));
        let touched = after(&place(4));
        // It has left two.
        let parted = after(&step);
        let removed = [5, 4].map(|k| after(&|world| world.remove(ids[k]).expect("alive")));
        let crowded = after(&crowd);
        let [resting] = places_of_change(&rest, [0, 1]);
        let [dirty] = places_of_change(&touched, [0, 1]);
        let [found] = places_of_change(&parted, [8, 0]);
        let lost = places_of_change(&parted, [0, 2]);
        let [live] = places_of_change(&removed[0], [9, 8]);
        let [free] = places_of_change(&removed[1], [6, 5]);
        let [complete] = places_of_change(&crowded, [1, 0]);
        Self { live, free, dirty, resting, complete, found, lost }
    }
}

/// Where sections of a snapshot start, of a world with nothing that it could do without, 32 bits wide.
#[derive(Clone, Copy, Debug)]
struct Places {
    slots: usize,
    boxes: usize,
    generations: usize,
    moved: usize,
    resting: usize,
    pairs: usize,
    pair_count: usize,
}

impl Places {
    fn of(snapshot: &[u8], slots: usize, pair_count: usize) -> Self {
        let generations = *FRONT;
        let moved = generations + 4 * slots;
        // Those of which the tree knows, too.
        let resting = moved + 2 * 4 * slots.div_ceil(32);
        let boxes = resting + 4 * slots.div_ceil(32);
        // Behind the boxes what disabled objects have, and the slots that have gone to others.
        let pairs = boxes + (24 + 2) * slots + 4 * slots.div_ceil(32);
        assert_eq!(pairs + 8 * pair_count, snapshot.len(), "all sections");
        Self { slots, boxes, generations, moved, resting, pairs, pair_count }
    }
}

const PLAIN: Config = Config::new(ample(700, 9000)).without_predicted_boxes();

fn setups() -> [Setup; 2] {
    [Setup::REFERENCE, Setup { kernels: Kernels::detect(), jobs: Jobs::Threads(2) }]
}

/// What is forged, and how.
type Forgery<'f> = (&'f str, &'f dyn Fn(&mut Vec<u8>));

/// Loads each forgery into a world with a life of its own. Returns the names of those that were loaded.
fn loaded<'n>(snapshot: &[u8], forgeries: &[Forgery<'n>], setup: Setup) -> Vec<&'n str> {
    let config = setup.configure(PLAIN);
    let (mut slab, mut room) = (Slab::new::<u32>(&config), Slab::new::<u32>(&config));
    let (mut world, mut twin) = (lived::<u32>(&mut slab, &config, 640, 4), room.world::<u32>(&config));
    let start = saved(&world);
    world.load(&start).expect("a good snapshot");
    twin.load(&start).expect("a good snapshot");
    let rng = &mut Rng::new(forgeries.len() as u64);
    let mut names = Vec::new();
    for (name, forge) in forgeries {
        let mut forged = snapshot.to_vec();
        forge(&mut forged);
        assert!(forged != snapshot, "{name} changes nothing");
        seal(&mut forged);
        let before = saved(&world);
        if world.load(&forged) == Err(Error::BadSnapshot) {
            assert!(saved(&world) == before, "{name}: the world has changed");
            world.validate().expect("a valid world");
            let again = &mut rng.clone();
            assert!(
                act(&mut world, rng, setup) == act(&mut twin, again, setup),
                "{name}: it goes on otherwise"
            );
        } else {
            names.push(*name);
            go_on(&mut world, rng, setup, name);
            world.load(&before).expect("a good snapshot");
            twin.load(&before).expect("a good snapshot");
        }
    }
    names
}

/// A calm world with few movers, a free slot and resting objects.
fn divided() -> (Vec<u8>, Places) {
    let mut slab = Slab::new::<u32>(&PLAIN);
    let mut world = lived::<u32>(&mut slab, &PLAIN, 650, 5);
    let id = world.id_at(9).expect("alive");
    world.remove(id).expect("alive");
    placed(&world)
}

/// A snapshot of a world that has had 650 objects at once.
fn placed(world: &World<'_, u32>) -> (Vec<u8>, Places) {
    let snapshot = saved(world);
    let places = Places::of(&snapshot, 650, world.pairs().len());
    (snapshot, places)
}

/// As it is after a full step in which all have moved.
fn whole() -> (Vec<u8>, Places) {
    let mut slab = Slab::new::<u32>(&PLAIN);
    placed(&lived::<u32>(&mut slab, &PLAIN, 650, 0))
}

#[test]
fn what_a_forged_snapshot_cannot_have_is_refused() {
    let n = Numbers::find();
    for ((snapshot, p), setup) in [divided(), whole()].iter().zip(setups()) {
        let mut copy = snapshot.clone();
        seal(&mut copy);
        assert!(&copy == snapshot, "the checksum is that of the format");
        let is_in =
            |set: usize, slot: u32| get(snapshot, set + slot as usize / 32 * 4) >> (slot % 32) & 1 != 0;
        let still = |slot: u32| !is_in(p.moved, slot);
        let pair_at = |k: usize| p.pairs + 8 * k;
        let stays = |k: &usize| still(get(snapshot, pair_at(*k))) && still(get(snapshot, pair_at(*k) + 4));
        let pair = pair_at((0..p.pair_count).find(stays).expect("a pair that stays"));
        let slot = get(snapshot, pair) as usize;
        let bit = |bytes: &mut Vec<u8>, set: usize, slot: usize| {
            let word = get(bytes, set + slot / 32 * 4) ^ 1 << (slot % 32);
            put(bytes, set + slot / 32 * 4, word);
        };
        let beyond = p.slots as u32;
        // Of all overlaps, and of the result.
        let counts = places_of(snapshot, p.pair_count as u64);
        assert_eq!(counts.len(), 2, "{counts:?}");
        let forgeries: &[Forgery<'_>] = &[
            ("a number of objects", &|b| put(b, n.live, get(snapshot, n.live) - 1)),
            ("a number of disabled objects", &|b| put(b, n.live + 4, 1)),
            ("a box beyond infinity", &|b| put(b, p.boxes + 24 * slot, 0x7fa0_0000)),
            ("a free slot", &|b| put(b, n.free, 1 + slot as u32)),
            ("touched by nobody", &|b| b[n.dirty] = 2),
            ("more pairs than room", &|b| put(b, counts[0], 9001)),
            ("fewer pairs", &|b| put(b, counts[0], p.pair_count as u32 - 1)),
            ("surplus without margins", &|b| put(b, counts[1], p.pair_count as u32 - 1)),
            ("found without events", &|b| put(b, n.found, 1)),
            ("lost without events", &|b| put(b, n.lost[0], 1)),
            ("kept without events", &|b| put(b, n.lost[1], 1)),
            ("neither complete nor not", &|b| b[n.complete] = 2),
            ("a box that is none", &|b| put(b, p.boxes + 24 * slot, i32::MAX as u32)),
            ("NaN in a box", &|b| put(b, p.boxes + 24 * slot + 12, 0x7fc0_0000)),
            ("a box somewhere else", &|b| {
                for k in 0..6 {
                    put(b, p.boxes + 24 * slot + 4 * k, 0x5000_0000);
                }
            }),
            ("no generation", &|b| put(b, p.generations + 4 * slot, 0)),
            ("a slot without an object has moved", &|b| bit(b, p.moved, beyond as usize)),
            ("a pair of an object with itself", &|b| put(b, pair + 4, get(snapshot, pair))),
            ("a pair in the wrong order", &|b| {
                let [x, y] = [get(snapshot, pair), get(snapshot, pair + 4)];
                put(b, pair, y);
                put(b, pair + 4, x);
            }),
            ("a pair of a slot that there is not", &|b| put(b, pair + 4, beyond)),
            ("nothing behind", &|b| b.truncate(b.len() - 8)),
            ("something behind", &|b| b.push(0)),
        ];
        assert_eq!(loaded(snapshot, forgeries, setup), [""; 0]);
        let apart = (0..beyond).find(|&other| {
            let key = |slot: u32, k: usize| get(snapshot, p.boxes + 24 * slot as usize + 4 * k) as i32;
            let mine = get(snapshot, pair);
            other > mine && still(other) && key(other, 0) > key(mine, 3)
        });
        let apart = apart.expect("two that do not touch");
        let free = 9;
        // The other one has nothing of this.
        let divided: &[Forgery<'_>] = &[
            ("a pair that does not overlap", &|b| put(b, pair + 4, apart)),
            ("who has moved and is not touched", &|b| b[n.dirty] = 0),
            ("who is no more rests", &|b| bit(b, p.resting, free)),
            ("nobody was put to rest", &|b| b[n.resting] = 0),
            ("a free slot with a box", &|b| put(b, p.boxes + 24 * free + 12, 0)),
            ("a chain that does not end", &|b| put(b, p.boxes + 24 * free + 4, 1 + free as u32)),
        ];
        let there = if get(snapshot, n.live) < beyond { divided.len() } else { 1 };
        assert_eq!(loaded(snapshot, &divided[..there], setup), [""; 0]);
    }
}

/// A world with more objects than any has is no damage of the bytes: the error says what is too large.
#[test]
fn a_capacity_that_there_is_not_is_named() {
    let (snapshot, _) = whole();
    // Behind the version.
    let capacity = HEADER + 4;
    assert_eq!(get(&snapshot, capacity), PLAIN.capacity.objects);
    let mut forged = snapshot.clone();
    put(&mut forged, capacity, u32::MAX);
    seal(&mut forged);
    let mut slab = Slab::new::<u32>(&PLAIN);
    let error = slab.world::<u32>(&PLAIN).load(&forged);
    assert!(matches!(error, Err(Error::CapacityTooLarge { .. })), "{error:?}");
}

/// Whether pairs are missing, or there twice, does not matter to the first step: it finds all anew.
#[test]
fn pairs_that_are_not_all_are_found_anew() {
    for ((snapshot, p), setup) in [divided(), whole()].iter().zip(setups()) {
        let less = |b: &mut Vec<u8>| {
            for at in places_of(snapshot, p.pair_count as u64) {
                put(b, at, p.pair_count as u32 - 1);
            }
            b.truncate(b.len() - 8);
        };
        let twice = |b: &mut Vec<u8>| {
            let last = p.pairs + 8 * (p.pair_count - 1);
            b.copy_within(last - 8..last, last);
        };
        let forgeries: [Forgery<'_>; 2] = [("a pair less", &less), ("a pair twice", &twice)];
        let names = loaded(snapshot, &forgeries, setup);
        assert_eq!(names, ["a pair less", "a pair twice"]);
    }
}

/// Each number of the state, made another one: most say what the objects or nothing say, and are refused.
#[test]
fn no_number_of_the_state_is_believed() {
    for ((snapshot, _), setup) in [divided(), whole()].iter().zip(setups()) {
        let (mut refused, mut numbers) = (0, 0);
        for at in (HEADER..*FRONT).step_by(4) {
            let old = get(snapshot, at);
            let forge = |new: u32| move |b: &mut Vec<u8>| put(b, at, new);
            let name = format!("byte {} of the state", at - HEADER);
            let others = [old ^ 1, old ^ 1 << 8, old ^ 1 << 16, old ^ 1 << 31, old.wrapping_add(7), !old];
            let others = others.map(forge);
            let forgeries = others.each_ref().map(|other| -> Forgery<'_> { (&name, other) });
            refused += usize::from(loaded(snapshot, &forgeries, setup).is_empty());
            numbers += 1;
        }
        assert!(2 * refused > numbers, "{refused} of {numbers}");
    }
}

/// Some numbers are changed at random: refused with the world as it was, which goes on as its twin; or loaded, and as right as
/// brute force.
fn forge_at_random<I: Index>(config: Config, count: usize, calm: usize, times: usize, setup: Setup) {
    let config = setup.configure(config);
    let mut source = Slab::new::<I>(&config);
    let snapshot = saved(&lived::<I>(&mut source, &config, count, calm));
    let (mut slab, mut room) = (Slab::new::<I>(&config), Slab::new::<I>(&config));
    let (mut world, mut twin) = (slab.world::<I>(&config), room.world::<I>(&config));
    let rng = &mut Rng::new(count as u64 + calm as u64);
    let (mut good, mut bad) = (0, 0);
    for round in 0..times {
        let mut forged = snapshot.clone();
        forge(&mut forged, rng);
        let (before, stats) = (saved(&world), world.stats());
        if world.load(&forged) == Err(Error::BadSnapshot) {
            bad += 1;
            assert!(saved(&world) == before && world.stats() == stats, "the world has changed");
            world.validate().expect("a valid world");
            let mut again = rng.clone();
            let outcome = act(&mut world, rng, setup);
            assert!(outcome == act(&mut twin, &mut again, setup), "it goes on otherwise");
        } else {
            good += 1;
            let questions = Questions::about(&Model::default(), 1, rng);
            for cast in &questions.casts {
                let _ = world.with(setup).hits(cast, &mut [None; 8]);
            }
            let _ = world.leaves().count() + world.planes().count() + world.large().count();
            go_on(&mut world, rng, setup, &format!("round {round}"));
            world.load(&before).expect("a good snapshot");
            twin.load(&before).expect("a good snapshot");
        }
        if rng.once_in(30) {
            world.load(&snapshot).expect("a good snapshot");
            twin.load(&snapshot).expect("a good snapshot");
        }
    }
    assert!(good > 0 && bad > 0, "{good} loaded, {bad} refused");
}

#[test]
fn forged_numbers_are_refused_or_as_right_as_any() {
    let times = effort() as usize;
    for setup in setups() {
        for (at, config) in configs().into_iter().enumerate() {
            let sized = |objects: usize, pairs: usize| config.with_capacity(ample(objects, pairs));
            forge_at_random::<u16>(sized(24, 100), 20, at, 400 * times, setup);
            forge_at_random::<u16>(sized(200, 3000).with_lean(), 180, at, 200 * times, setup);
            forge_at_random::<u32>(sized(300, 4000), 290, at, 100 * times, setup);
            for calm in [0, 1, 4] {
                forge_at_random::<u16>(sized(700, 9000), 650, calm, 90 * times, setup);
            }
            // Without room for all pairs.
            forge_at_random::<u16>(sized(700, 90), 650, 1, 50 * times, setup);
        }
    }
}
