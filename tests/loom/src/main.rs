//! Runs the core's claiming of blocks and scratch and its offer of a job under every interleaving that loom finds, with every
//! value that a relaxed load may see. The code is the core's own files, letter by letter; only their atomics are loom's.
//!
//! `cargo run --manifest-path tests/loom/Cargo.toml`

/// Makes `core` mean this crate in the included files, and so `core::sync::atomic` mean loom's.
extern crate self as core;
#[doc(hidden)]
pub use std::{array, cell, marker, mem, num, slice};
#[doc(hidden)]
pub mod hint {
    pub use loom::hint::spin_loop;
}
#[doc(hidden)]
pub mod sync {
    pub use loom::sync::atomic;
}

// The models need a part of it.
#[allow(dead_code)]
#[path = "../../../core/src/parallel/block_queue.rs"]
mod block_queue;
#[path = "../../../std-adapter/src/offer.rs"]
mod offer;

use block_queue::{BlockQueue, Chunks};
use loom::cell::Cell;
use loom::sync::atomic::{AtomicBool, Ordering::Relaxed};
use offer::Offer;
use std::sync::atomic::AtomicUsize;

/// An item of a slice whose accesses loom watches: two at once, or one that does not see the one before, fail.
type Item = Cell<u32>;
type Part = &'static mut [Item];

/// Items that start at zero.
fn items(count: usize) -> Part {
    // Loom's threads may outlive any borrow; executions are many, but small.
    (0..count).map(|_| Cell::new(0)).collect::<Vec<_>>().leak()
}

fn leak<T>(value: T) -> &'static T {
    Box::leak(Box::new(value))
}

fn add(item: &Item, value: u32) {
    item.set(item.get() + value);
}

/// What an executor does, and then the step itself: `width` calls at once, one of them here, then a last one.
fn fork_join<T: 'static>(width: usize, job: &'static (dyn Fn() -> T + Sync)) -> Vec<T> {
    let threads: Vec<_> = (1..width).map(|_| loom::thread::spawn(job)).collect();
    let mut results = vec![job()];
    results.extend(threads.into_iter().map(|thread| thread.join().expect("no panic")));
    results.push(job());
    results
}

/// Every block is claimed once, by one, and what was written to it is seen when all calls have returned.
fn every_block_is_claimed_once(width: usize, blocks: usize) {
    let claims =
        leak(BlockQueue::new((Chunks::new(items(2 * blocks - 1), 2), Chunks::new(items(blocks), 1)), 1));
    let job = leak(move || {
        let mut claimed: Vec<(usize, Part, Part)> = Vec::new();
        while let Some((block, (pair, single))) = claims.claim_from(&mut 0) {
            pair.iter().chain(&*single).for_each(|item| add(item, block as u32 + 1));
            claimed.push((block, pair, single));
        }
        claimed
    });
    let mut results = fork_join(width, job);
    assert!(results.pop().is_some_and(|last| last.is_empty()), "nothing is left for the last call");
    let mut all: Vec<_> = results.into_iter().flatten().collect();
    all.sort_unstable_by_key(|&(block, ..)| block);
    assert_eq!(all.len(), blocks);
    for (at, (block, pair, single)) in all.iter().enumerate() {
        assert_eq!((*block, pair.len()), (at, if at + 1 == blocks { 1 } else { 2 }));
        assert!(pair.iter().chain(&**single).all(|item| item.get() == at as u32 + 1));
    }
    assert!(claims.claim_from(&mut 0).is_none());
}

/// Every part of all shares is claimed once, by one, also by workers that begin in one share.
fn every_part_of_all_shares_is_claimed_once(width: usize, shares: usize, parts: usize) {
    let claims = leak(BlockQueue::new(Chunks::new(items(parts), 1), shares));
    let job = leak(move || {
        let mut claimed: Vec<(usize, Part)> = Vec::new();
        let mut share = claims.arrive();
        while let Some((index, part)) = claims.claim_from(&mut share) {
            add(&part[0], index as u32 + 1);
            claimed.push((index, part));
        }
        claimed
    });
    let mut results = fork_join(width, job);
    assert!(results.pop().is_some_and(|last| last.is_empty()), "nothing is left for the last call");
    let mut all: Vec<_> = results.into_iter().flatten().collect();
    all.sort_unstable_by_key(|&(index, _)| index);
    assert_eq!(all.len(), parts);
    assert!(all.iter().enumerate().all(|(at, (index, part))| *index == at && part[0].get() == at as u32 + 1));
}

/// Loom's cells, to be reached by several threads.
struct Watched<T>(T);

// SAFETY: loom fails where two reach a cell at once.
unsafe impl<T> Sync for Watched<T> {}

impl<T> Watched<T> {
    const fn get(&self) -> &T {
        &self.0
    }
}

/// `jobs` jobs one after another, and as many threads as `helpers` that look once for each. A call finds its job alive and
/// sees what was written before; the caller sees all that the calls have done, and waits for none that has not begun.
fn an_offer_ends_when_all_who_came_have_left(helpers: usize, jobs: usize) {
    let offer = leak(Offer::new());
    let threads: Vec<_> = (0..helpers)
        .map(|_| loom::thread::spawn(move || (0..jobs).filter(|_| offer.take_part()).count()))
        .collect();
    let mut calls = 0;
    for number in 0..jobs {
        let (before, done) = (Cell::new(0), items(helpers + 1));
        before.set(number + 1);
        let next = loom::sync::atomic::AtomicUsize::new(0);
        let watched = Watched((&before, &*done));
        let job = || {
            let (before, done) = watched.get();
            assert_eq!(before.get(), number + 1, "the job is another's");
            add(&done[next.fetch_add(1, Relaxed)], 1);
        };
        assert!(offer.lend(helpers as u32, &job, loom::thread::yield_now));
        let sum: u32 = watched.get().1.iter().map(Item::get).sum();
        assert_eq!(sum as usize, next.load(Relaxed), "a call is not seen");
        before.set(0);
        calls += sum as usize;
    }
    let came: usize = threads.into_iter().map(|thread| thread.join().expect("no panic")).sum();
    assert_eq!(calls, jobs + came);
}

/// How a sweep collects pairs: blocks with a chunk of output each, two areas of scratch, more chunks as they fill, linked in
/// order. Block `b` fills `b % 3` chunks beyond its own. With fewer chunks than that, everybody notices. Who finds no area
/// leaves the work to those that have one.
fn output_is_that_of_one_worker(width: usize, blocks: usize, chunks: usize) {
    let chunks_of = |block: usize| block % 3;
    let needed: usize = (0..blocks).map(chunks_of).sum();
    let next = leak(BlockQueue::new(Chunks::new(items(blocks), 1), 1));
    let output = leak(BlockQueue::new(Chunks::new(items(chunks), 1), 1));
    let areas = leak(BlockQueue::new(Chunks::new(items(2), 1), 1));
    let full = leak(AtomicBool::new(false));
    let job = leak(move || {
        let (_, area) = areas.claim_from(&mut 0)?;
        let mut filled: Vec<([usize; 2], Part)> = Vec::new();
        while let Some((block, first)) = next.claim_from(&mut 0) {
            add(&area[0], 1);
            add(&first[0], 10 * block as u32);
            filled.push(([block, 0], first));
            for number in 1..=chunks_of(block) {
                let Some((_, chunk)) = output.claim_from(&mut 0) else {
                    full.store(true, Relaxed);
                    break;
                };
                add(&chunk[0], (10 * block + number) as u32);
                filled.push(([block, number], chunk));
            }
        }
        Some((area[0].get(), filled))
    });
    let (swept, filled): (Vec<u32>, Vec<_>) = fork_join(width, job).into_iter().flatten().unzip();
    let mut all: Vec<_> = filled.into_iter().flatten().collect();
    assert_eq!(full.load(Relaxed), chunks < needed);
    assert_eq!(all.len(), blocks + needed.min(chunks));
    assert_eq!(swept.iter().sum::<u32>() as usize, blocks, "every block is swept once");
    if chunks >= needed {
        all.sort_unstable_by_key(|&(entry, _)| entry);
        let merged: Vec<u32> = all.iter().map(|(_, chunk)| chunk[0].get()).collect();
        let serial =
            (0..blocks).flat_map(|block| (0..=chunks_of(block)).map(move |n| (10 * block + n) as u32));
        assert_eq!(merged, serial.collect::<Vec<_>>());
    }
}

/// Runs a model; with a bound, under every interleaving with no more than so many preemptions.
fn model(name: &str, preemptions: Option<usize>, run: impl Fn() + Send + Sync + 'static) {
    static RUNS: AtomicUsize = AtomicUsize::new(0);
    RUNS.store(0, Relaxed);
    let mut builder = loom::model::Builder::new();
    builder.preemption_bound = preemptions;
    builder.check(move || {
        RUNS.fetch_add(1, Relaxed);
        run();
    });
    println!("{name}: {} interleavings", RUNS.load(Relaxed));
}

fn main() {
    model("2 workers claim 3 blocks", None, || every_block_is_claimed_once(2, 3));
    model("3 workers claim 2 blocks", None, || every_block_is_claimed_once(3, 2));
    model("4 workers claim 4 blocks", Some(2), || every_block_is_claimed_once(4, 4));
    model("2 workers share out 3 parts", None, || every_part_of_all_shares_is_claimed_once(2, 2, 3));
    model("3 workers share out 3 parts", Some(2), || every_part_of_all_shares_is_claimed_once(3, 2, 3));
    model("1 thread comes to 1 job", None, || an_offer_ends_when_all_who_came_have_left(1, 1));
    model("1 thread comes to 2 jobs", None, || an_offer_ends_when_all_who_came_have_left(1, 2));
    model("2 threads come to 1 job", Some(3), || an_offer_ends_when_all_who_came_have_left(2, 1));
    model("2 workers collect 3 blocks", None, || output_is_that_of_one_worker(2, 3, 3));
    model("2 workers collect 3 blocks, short of room", None, || output_is_that_of_one_worker(2, 3, 2));
    model("3 workers collect 4 blocks", Some(2), || output_is_that_of_one_worker(3, 4, 4));
}
