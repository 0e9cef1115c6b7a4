//! Snapshots that were forged with a right checksum: refused with the world as it was, or loaded, valid, and as right as brute
//! force from then on.

use trisap_core::{Config, Error, Index, Kernels};
use trisap_tests::effort;
use trisap_tests::forging::{HEADER, STATE, forge, get, go_on, put, seal};
use trisap_tests::jobs::Jobs;
use trisap_tests::lives::{act, configs, lived, saved};
use trisap_tests::model::Model;
use trisap_tests::queries::Questions;
use trisap_tests::scenes::Rng;
use trisap_tests::worlds::{Setup, Slab, ample};

// Where numbers of the state stand.
const LIVE: usize = HEADER + 256;
const SLOTS: usize = HEADER + 260;
const FREE: usize = HEADER + 264;
const STALE_LISTS: usize = HEADER + 280;
const BUILT: usize = HEADER + 56;
const DEPTH: usize = HEADER + 60;
const SUBDIVIDED: usize = HEADER + 68;
const FILLED: usize = HEADER + 120;
const LARGE_START: usize = HEADER + 80;
const DIRTY: usize = HEADER + 272;
const RESTING: usize = HEADER + 273;
const MOVED_INSIDE_MARGIN: usize = HEADER + 275;
const BASELINE: usize = HEADER + 40;
const SWEPT: usize = HEADER + 128;
const PARKED: usize = HEADER + 168;
const REPORTED: usize = HEADER + 136;
const FOUND: usize = HEADER + 144;
const LOST: usize = HEADER + 152;
const COMPLETE: usize = HEADER + 188;
const CHOSEN: usize = HEADER + 244;

/// Where sections of a snapshot start, of a world with nothing that it could do without, 32 bits wide.
#[derive(Clone, Copy, Debug)]
struct Places {
    boxes: usize,
    generations: usize,
    moved: usize,
    resting: usize,
    pairs: usize,
    pair_count: usize,
}

impl Places {
    fn of(snapshot: &[u8]) -> Self {
        let slots = get(snapshot, SLOTS) as usize;
        let generations = HEADER + STATE;
        let moved = generations + 4 * slots;
        let resting = moved + 4 * slots.div_ceil(32);
        let boxes = resting + 4 * slots.div_ceil(32);
        let pairs = boxes + 24 * slots;
        let pair_count = get(snapshot, SWEPT) as usize;
        assert_eq!(pairs + 8 * pair_count, snapshot.len(), "all sections");
        Self { boxes, generations, moved, resting, pairs, pair_count }
    }
}

const PLAIN: Config = Config::new(ample(700, 9000));

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
fn divided() -> Vec<u8> {
    let mut slab = Slab::new::<u32>(&PLAIN);
    let mut world = lived::<u32>(&mut slab, &PLAIN, 650, 5);
    let id = world.id_at(9).expect("alive");
    world.remove(id).expect("alive");
    saved(&world)
}

/// As it is after a full step in which all have moved.
fn whole() -> Vec<u8> {
    let mut slab = Slab::new::<u32>(&PLAIN);
    saved(&lived::<u32>(&mut slab, &PLAIN, 650, 0))
}

#[test]
fn what_a_forged_snapshot_cannot_have_is_refused() {
    for (snapshot, setup) in [divided(), whole()].iter().zip(setups()) {
        let p = Places::of(snapshot);
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
        let beyond = get(snapshot, SLOTS);
        let forgeries: &[Forgery<'_>] = &[
            ("a number of objects", &|b| put(b, LIVE, get(snapshot, LIVE) - 1)),
            ("a free slot", &|b| put(b, FREE, 1 + slot as u32)),
            ("lists", &|b| b[STALE_LISTS] = 0),
            ("planes", &|b| put(b, BUILT, 600)),
            ("filled leaves", &|b| b[FILLED] = 1),
            ("a deeper tree", &|b| put(b, DEPTH, get(snapshot, DEPTH) + 1)),
            ("leaves that are divided", &|b| put(b, SUBDIVIDED, get(snapshot, SUBDIVIDED) ^ 1)),
            ("where large objects start", &|b| put(b, LARGE_START, u32::MAX)),
            ("touched by nobody", &|b| b[DIRTY] = 2),
            ("margins that there are not", &|b| b[MOVED_INSIDE_MARGIN] = 1),
            ("squares beyond all numbers", &|b| b[BASELINE..BASELINE + 8].fill(255)),
            ("more pairs than room", &|b| put(b, SWEPT, 9001)),
            ("fewer pairs", &|b| put(b, SWEPT, get(snapshot, SWEPT) - 1)),
            ("surplus without margins", &|b| put(b, REPORTED, get(snapshot, REPORTED) - 1)),
            ("pairs that are set aside", &|b| put(b, PARKED, 1)),
            ("found without events", &|b| put(b, FOUND, 1)),
            ("lost without events", &|b| put(b, LOST, 1)),
            ("neither complete nor not", &|b| b[COMPLETE] = 2),
            ("a path that there is not", &|b| put(b, CHOSEN, 6)),
            ("a reason that there is not", &|b| put(b, CHOSEN, 10 << 8)),
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
            ("who has moved and is not touched", &|b| b[DIRTY] = 0),
            ("who is no more rests", &|b| bit(b, p.resting, free)),
            ("nobody was put to rest", &|b| b[RESTING] = 0),
            ("a free slot with a box", &|b| put(b, p.boxes + 24 * free + 12, 0)),
            ("a chain that does not end", &|b| put(b, p.boxes + 24 * free + 4, 1 + free as u32)),
        ];
        let there = if get(snapshot, LIVE) < beyond { divided.len() } else { 1 };
        assert_eq!(loaded(snapshot, &divided[..there], setup), [""; 0]);
    }
}

/// Whether pairs are missing, or there twice, does not matter to the first step: it finds all anew.
#[test]
fn pairs_that_are_not_all_are_found_anew() {
    for (snapshot, setup) in [divided(), whole()].iter().zip(setups()) {
        let p = Places::of(snapshot);
        let less = |b: &mut Vec<u8>| {
            let [swept, result] = [SWEPT, REPORTED].map(|at| get(snapshot, at) - 1);
            put(b, SWEPT, swept);
            put(b, REPORTED, result);
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
                let _ = world.set_kernels(setup.kernels).hits(cast, &mut [None; 8]);
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
