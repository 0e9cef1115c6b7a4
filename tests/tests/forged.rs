//! Snapshots that were forged with a right checksum: refused with the world as it was, or loaded, valid, and as right as brute
//! force from then on.

use trisap_core::{Boxes, Config, Error, Index, Kernels, Margin};
use trisap_tests::checked::Outcome;
use trisap_tests::forging::{HEADER, STATE, forge, get, go_on, put, seal};
use trisap_tests::jobs::Jobs;
use trisap_tests::lives::{act, configs, lived, saved};
use trisap_tests::model::Model;
use trisap_tests::queries::Questions;
use trisap_tests::scenes::{self, Rng};
use trisap_tests::worlds::{Setup, Slab, ample};
use trisap_tests::{effort, sorted};

// Where numbers of the state stand.
const LIVE: usize = HEADER + 224;
const SLOTS: usize = HEADER + 228;
const FREE: usize = HEADER + 232;
const STALE_LISTS: usize = HEADER + 248;
const BUILT: usize = HEADER + 56;
const DEPTH: usize = HEADER + 60;
const SUBDIVIDED: usize = HEADER + 64;
const FILLED: usize = HEADER + 112;
const LARGE_START: usize = HEADER + 72;
const LARGE: usize = HEADER + 76;
const DIRTY: usize = HEADER + 240;
const RESTING: usize = HEADER + 241;
const MOVED_INSIDE_MARGIN: usize = HEADER + 243;
const BASELINE: usize = HEADER + 40;
const SWEPT: usize = HEADER + 120;
const PARKED: usize = HEADER + 160;
const REPORTED: usize = HEADER + 128;
const FOUND: usize = HEADER + 136;
const LOST: usize = HEADER + 144;
const COMPLETE: usize = HEADER + 172;
const CHOSEN: usize = HEADER + 220;

/// Where sections of a snapshot start, of a world with a tree and nothing that it could do without, 32 bits wide.
#[derive(Clone, Copy, Debug)]
struct Places {
    boxes: usize,
    generations: usize,
    moved: usize,
    resting: usize,
    awake: usize,
    planes: usize,
    leaves: usize,
    frames: usize,
    bounds: usize,
    nodes: usize,
    members: usize,
    pairs: usize,
    /// How many leaves there are, how many of the last full step, and how many pairs.
    leaf_count: usize,
    whole_count: usize,
    pair_count: usize,
}

impl Places {
    fn of(snapshot: &[u8]) -> Self {
        let [slots, depth, refined] = [SLOTS, DEPTH, SUBDIVIDED].map(|at| get(snapshot, at) as usize);
        assert!(snapshot[FILLED] == 1 && get(snapshot, BUILT) > 512 && get(snapshot, BUILT) <= 1024);
        let words = slots.div_ceil(32);
        let finer = if refined > 0 { 3 } else { 0 };
        let (whole_count, leaf_count) = (1 << depth, 1 << (depth + finer));
        let boxes = HEADER + STATE;
        let generations = boxes + 24 * slots;
        let moved = generations + 4 * slots;
        let resting = moved + 4 * words;
        let awake = resting + 4 * words;
        let planes = awake + 4 * words;
        // Two leaves were planned, with eight parts each.
        let leaves = planes + 4 * 16;
        let frames = leaves + 12 * leaf_count + 12 * whole_count;
        let bounds = frames + 24 * whole_count;
        let nodes = bounds + if refined > 0 { 12 * leaf_count } else { 0 };
        let members = nodes + 24 * (2 * whole_count - 1);
        let count: u32 = (0..leaf_count).map(|leaf| get(snapshot, leaves + 12 * leaf)).sum();
        let pairs = members + 4 * count as usize + 4 * get(snapshot, LARGE) as usize;
        let pair_count = get(snapshot, SWEPT) as usize;
        assert_eq!(pairs + 8 * pair_count, snapshot.len(), "all sections");
        Self {
            boxes,
            generations,
            moved,
            resting,
            awake,
            planes,
            leaves,
            frames,
            bounds,
            nodes,
            members,
            pairs,
            leaf_count,
            whole_count,
            pair_count,
        }
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
    twin.load(&saved(&world)).expect("a good snapshot");
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
        }
    }
    names
}

/// A world with leaves that are divided, few movers, a free slot and resting objects.
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
        let last = p.leaves + 12 * (p.leaf_count - 1);
        let full = (0..p.leaf_count).find(|leaf| get(snapshot, p.leaves + 12 * leaf) > 2).expect("a member");
        let full = p.leaves + 12 * full;
        let is_in =
            |set: usize, slot: u32| get(snapshot, set + slot as usize / 32 * 4) >> (slot % 32) & 1 != 0;
        let still = |slot: u32| !is_in(p.moved, slot);
        // Two objects in different corners that stay where they are, and a pair of two that stay.
        let member = (0..).find(|k| still(get(snapshot, p.members + 4 * k))).expect("one that stays");
        let slot = get(snapshot, p.members + 4 * member) as usize;
        let pair_at = |k: usize| p.pairs + 8 * k;
        let stays = |k: &usize| still(get(snapshot, pair_at(*k))) && still(get(snapshot, pair_at(*k) + 4));
        let pair = pair_at((0..p.pair_count).find(stays).expect("a pair that stays"));
        let bit = |bytes: &mut Vec<u8>, set: usize, slot: usize| {
            let word = get(bytes, set + slot / 32 * 4) ^ 1 << (slot % 32);
            put(bytes, set + slot / 32 * 4, word);
        };
        let beyond = get(snapshot, SLOTS);
        let forgeries: &[Forgery<'_>] = &[
            ("a number of objects", &|b| put(b, LIVE, get(snapshot, LIVE) - 1)),
            ("a free slot", &|b| put(b, FREE, 1 + slot as u32)),
            ("lists", &|b| b[STALE_LISTS] = 0),
            ("planes for fewer", &|b| put(b, BUILT, 512)),
            ("planes for nobody", &|b| put(b, BUILT, 0)),
            ("planes for too many", &|b| put(b, BUILT, 701)),
            ("a deeper tree", &|b| put(b, DEPTH, get(snapshot, DEPTH) + 1)),
            ("leaves that are divided", &|b| put(b, SUBDIVIDED, get(snapshot, SUBDIVIDED) ^ 1)),
            ("leaves that are not filled", &|b| b[FILLED] = 0),
            ("filled twice", &|b| b[FILLED] = 2),
            ("where large objects start", &|b| put(b, LARGE_START, u32::MAX)),
            ("a frame of no numbers", &|b| put(b, p.frames, 0x7fc0_0000)),
            ("a frame upside down", &|b| put(b, p.frames + 12, 0xbf80_0000)),
            ("a frame without end", &|b| put(b, p.frames + 24 * p.whole_count - 4, 0x7f80_0000)),
            ("touched by nobody", &|b| b[DIRTY] = 2),
            ("margins that there are not", &|b| b[MOVED_INSIDE_MARGIN] = 1),
            ("squares beyond all numbers", &|b| b[BASELINE..BASELINE + 8].fill(255)),
            ("more pairs than room", &|b| put(b, SWEPT, 9001)),
            ("fewer pairs", &|b| put(b, SWEPT, get(snapshot, SWEPT) - 1)),
            ("surplus without margins", &|b| put(b, REPORTED, get(snapshot, REPORTED) - 1)),
            ("more set aside than pairs", &|b| put(b, PARKED, get(snapshot, SWEPT) + 1)),
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
            ("a slot without an object is awake", &|b| bit(b, p.awake, beyond as usize)),
            ("an axis that there is not", &|b| put(b, p.planes + 4, get(snapshot, p.planes + 4) | 3)),
            ("an axis that there is not, below", &|b| {
                put(b, p.planes + 4 * 15, get(snapshot, p.planes + 4 * 15) | 3)
            }),
            ("a plane somewhere else", &|b| put(b, p.planes + 4, 0x5000_0000)),
            ("a member more", &|b| put(b, full, get(snapshot, full) + 1)),
            ("a member less", &|b| put(b, full, get(snapshot, full) - 1)),
            ("no room", &|b| put(b, full + 4, get(snapshot, full) - 1)),
            ("room up to the last record", &|b| {
                // Up to it and not beyond: there are as many records as a slab has room for, and eight.
                let records = 700 + 700 / 8 + 4 * 16 + 8;
                let sum: u32 = (0..p.leaf_count).map(|leaf| get(snapshot, p.leaves + 12 * leaf + 4)).sum();
                put(b, last + 4, get(snapshot, last + 4) + records - sum);
            }),
            ("room beyond all numbers", &|b| put(b, last + 4, u32::MAX)),
            ("members beyond all numbers", &|b| put(b, last, u32::MAX)),
            ("a leaf that was never so full", &|b| put(b, p.leaves + 8, u32::MAX)),
            ("a node that is none", &|b| put(b, p.nodes, i32::MAX as u32)),
            ("a root around little", &|b| {
                for k in 0..6 {
                    put(b, p.nodes + 4 * k, 0x4000_0000);
                }
            }),
            ("a leaf around nothing", &|b| {
                let node = p.nodes + 24 * (p.whole_count - 1);
                for k in 0..6 {
                    put(b, node + 4 * k, if k < 3 { 0x7f80_0000 } else { 0x8080_0000 });
                }
            }),
            ("a member twice", &|b| put(b, p.members + 4 * member + 4, slot as u32)),
            ("a member that there is not", &|b| put(b, p.members + 4 * member, beyond)),
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
            ("who is no more has not moved", &|b| bit(b, p.moved, free)),
            ("who is no more rests", &|b| bit(b, p.resting, free)),
            ("nobody was put to rest", &|b| b[RESTING] = 0),
            ("bounds around nothing", &|b| b[p.bounds..p.bounds + 12 * p.leaf_count].fill(255)),
            ("a free slot with a box", &|b| put(b, p.boxes + 24 * free + 12, 0)),
            ("a chain that does not end", &|b| put(b, p.boxes + 24 * free + 4, 1 + free as u32)),
            ("a pair of who is awake is set aside", &|b| {
                put(b, PARKED, get(snapshot, SWEPT));
                b[p.awake..p.planes].fill(0);
                bit(b, p.awake, get(snapshot, pair) as usize);
            }),
        ];
        let there = if get(snapshot, SUBDIVIDED) > 0 { divided.len() } else { 1 };
        assert_eq!(loaded(snapshot, &divided[..there], setup), [""; 0]);
    }
}

/// That pairs are missing, or there twice, is seen by the first step that would keep them.
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

/// A mark of a changed object does not excuse a wrong division into reported and surplus pairs, where the next step divides none.
#[test]
fn a_forged_mark_hides_no_wrong_division() {
    let margin = Margin { per_extent: 0.0, min: 0.2, max: 0.2 };
    let config = Config::new(ample(3, 8)).with_margin(margin).with_events();
    for setup in setups() {
        let config = setup.configure(config);
        let mut slab = Slab::new::<u32>(&config);
        let mut world = slab.world::<u32>(&config);
        // The first two overlap; the last two do with their margins alone.
        let row = [0.0, 0.5, 1.7].map(|x| scenes::at([x, 0.0, 0.0], [1.0; 3]));
        world.insert_many(Boxes::new(&row)).expect("room");
        let outcome = world
            .set_kernels(setup.kernels)
            .on(&setup.jobs)
            .step()
            .map(|step| Outcome::of(&step))
            .expect("room");
        assert_eq!(sorted(&outcome.pairs), [[0, 1]]);
        let snapshot = saved(&world);
        // Boxes, fat boxes, margins, generations, and the sets of moved and of resting objects come before the set of changed
        // ones; behind the pairs there is one word, the set of reused slots.
        let changed = HEADER + STATE + 3 * (24 + 24 + 4 + 4) + 4 + 4;
        let end = snapshot.len() - 4;
        let pairs = end - 2 * 8;
        assert_eq!([get(&snapshot, changed), get(&snapshot, pairs), get(&snapshot, pairs + 8)], [0, 0, 1]);
        assert_eq!((get(&snapshot, REPORTED), snapshot[MOVED_INSIDE_MARGIN]), (1, 0));
        // The second object is marked; a changed object has a former box.
        let mut marked = snapshot.clone();
        put(&mut marked, changed, 0b10);
        let former = HEADER + STATE + 24;
        marked.splice(end..end, snapshot[former..former + 24].iter().copied());
        let mut exchanged = marked.clone();
        exchanged[pairs..end].rotate_left(8);
        for forged in [&mut marked, &mut exchanged] {
            seal(forged);
        }
        assert_eq!(world.load(&exchanged), Err(Error::BadSnapshot));
        assert!(saved(&world) == snapshot, "the world has changed");
        assert_eq!(world.load(&marked), Ok(()), "the mark alone does no harm");
        go_on(&mut world, &mut Rng::new(1), setup, "marked");
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
