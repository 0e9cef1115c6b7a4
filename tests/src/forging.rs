//! Snapshots that are no snapshots: forged with a right checksum. And what is asked of a world that took one all the same.

use crate::checked::Outcome;
use crate::doing::On as _;
use crate::lives::saved;
use crate::scenes::{self, Rng, shifted};
use crate::worlds::{Setup, Slab, ample};
use crate::{SlotPair, oracle, sorted};
use std::sync::LazyLock;
use trisap_core::{Aabb, Config, Error, Id, Index, Mode, Region, World};

/// The checksum of the format, written out again.
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

/// Bytes of the header: a number, the length of what follows, its checksum.
pub const HEADER: usize = 24;

/// Where the state ends, which comes first: there is nothing else in the snapshot of a world without objects.
pub static FRONT: LazyLock<usize> = LazyLock::new(|| {
    let config = Config::new(ample(1, 1));
    Slab::new::<u32>(&config).world::<u32>(&config).snapshot_size()
});

/// Where the bytes of the state stand that have changed like this from one snapshot to another.
///
/// # Panics
/// If there are fewer, or more.
#[must_use]
pub fn places_of_change<const N: usize>([before, after]: &[Vec<u8>; 2], change: [u8; 2]) -> [usize; N] {
    let is_it = |at: &usize| [before[*at], after[*at]] == change;
    let places: Vec<usize> = (HEADER..*FRONT).filter(is_it).collect();
    places.try_into().unwrap_or_else(|places| panic!("{change:?} at {places:?}"))
}

/// Where a number of eight bytes stands in the state.
#[must_use]
pub fn places_of(snapshot: &[u8], number: u64) -> Vec<usize> {
    (HEADER..*FRONT).step_by(8).filter(|at| snapshot[*at..at + 8] == number.to_ne_bytes()).collect()
}

/// Makes length and checksum right.
///
/// # Panics
/// If there is no header.
pub fn seal(snapshot: &mut [u8]) {
    let len = (snapshot.len() - HEADER) as u64;
    snapshot[8..16].copy_from_slice(&len.to_ne_bytes());
    let sum = checksum(&snapshot[HEADER..]);
    snapshot[16..HEADER].copy_from_slice(&sum.to_ne_bytes());
}

/// Four bytes as a number.
///
/// # Panics
/// If there are none.
#[must_use]
pub fn get(bytes: &[u8], at: usize) -> u32 {
    u32::from_ne_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
}

/// Writes four bytes.
///
/// # Panics
/// If there are none.
pub fn put(bytes: &mut [u8], at: usize, number: u32) {
    bytes[at..at + 4].copy_from_slice(&number.to_ne_bytes());
}

/// Changes some numbers, most of them near the front, where the state is.
///
/// # Panics
/// If the snapshot is shorter than a state.
pub fn forge(snapshot: &mut Vec<u8>, rng: &mut Rng) {
    for _ in 0..1 + rng.below(3) {
        let reach = if rng.once_in(2) { snapshot.len().min(*FRONT) } else { snapshot.len() };
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
    }
    seal(snapshot);
}

/// Steps with few movers and with many, a query after each, compared with brute force. Whatever was loaded is as right as any
/// world from its first step on, and its events from the second one on: the first compares with what the bytes said.
///
/// # Panics
/// If anything is wrong.
pub fn go_on<I: Index>(world: &mut World<'_, I>, rng: &mut Rng, setup: Setup, name: &str) {
    let valid = |world: &World<'_, I>| world.validate().unwrap_or_else(|invalid| panic!("{name}: {invalid}"));
    valid(world);
    let again = saved(world);
    assert_eq!(world.load(&again), Ok(()), "{name}: what was loaded is saved");
    assert!(saved(world) == again, "{name}: it is saved as it was");
    let capacity = world.config().capacity.objects;
    let mut ids: Vec<Id> = (0..capacity).filter_map(|slot| world.id_at(slot)).collect();
    let mut last: Option<Vec<SlotPair>> = None;
    for share in [rng.below(2) * 3, 9, 2 * ids.len(), 3] {
        for _ in 0..if ids.is_empty() { 0 } else { share } {
            let id = ids[rng.below(ids.len())];
            let next = shifted(&world.aabb(id).expect("alive"), rng.point(-0.5, 0.5));
            world.set_aabb(id, next).expect("a living object");
        }
        if rng.once_in(3) && !ids.is_empty() {
            world.remove(ids.swap_remove(rng.below(ids.len()))).expect("a living object");
        }
        if rng.once_in(3) && !ids.is_empty() {
            let id = ids[rng.below(ids.len())];
            world.set_enabled(id, !world.is_enabled(id)).expect("a living object");
        }
        let result = world.under(&setup).step().map(|step| Outcome::of(&step));
        valid(world);
        let enabled = |slot| world.id_at(slot).filter(|id| world.is_enabled(*id));
        let boxes: Vec<Option<Aabb>> =
            (0..capacity).map(|slot| enabled(slot).and_then(|id| world.aabb(id))).collect();
        ask(world, &boxes, rng, setup, name);
        let Ok(outcome) = result else {
            assert!(matches!(result, Err(Error::PairsFull { .. })), "{name}: {result:?}");
            continue;
        };
        let pairs = sorted(&outcome.pairs);
        assert!(pairs.windows(2).all(|two| two[0] != two[1]), "{name}: a pair is told twice");
        if let (true, Some(last)) = (world.config().events, last) {
            let without = |some: &[SlotPair], others: &[SlotPair]| -> Vec<SlotPair> {
                some.iter().copied().filter(|pair| others.binary_search(pair).is_err()).collect()
            };
            assert_eq!(sorted(&outcome.found), without(&pairs, &last), "{name}: found");
            assert_eq!(sorted(&outcome.lost), without(&last, &pairs), "{name}: lost");
        }
        let all = oracle::overlaps(&boxes);
        if world.config().filters {
            // Nobody can read the class matrix. Asked about all pairs once more, the world says the same.
            let exact = world.config().mode == Mode::Exact;
            assert!(!exact || pairs.iter().all(|pair| all.binary_search(pair).is_ok()), "{name}: no pair");
            ids.iter().for_each(|id| world.refilter(*id).expect("a living object"));
            let step = world.under(&setup).step().expect("the same pairs have room");
            assert_eq!(pairs, sorted(&Outcome::of(&step).pairs), "{name}");
        } else if world.config().mode == Mode::Fat {
            assert!(all.iter().all(|pair| pairs.binary_search(pair).is_ok()), "{name}: a pair is missing");
        } else {
            assert_eq!(pairs, all, "{name}");
        }
        last = Some(pairs);
    }
}

/// A query.
fn ask<I: Index>(world: &mut World<'_, I>, boxes: &[Option<Aabb>], rng: &mut Rng, setup: Setup, name: &str) {
    let region = scenes::at(rng.point(0.0, 5.0), [3.0; 3]);
    let mut found = vec![None; boxes.len()];
    let count = world.with(setup).overlaps(&Region::Aabb(region), &mut found).expect("room");
    let slots: Vec<u32> = found[..count].iter().flatten().map(|id| id.slot()).collect();
    let meets = |slot: &u32| boxes[*slot as usize].is_some_and(|aabb| aabb.overlaps(&region));
    assert!(slots.iter().copied().eq((0..boxes.len() as u32).filter(meets)), "{name}: a query");
}
