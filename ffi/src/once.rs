//! Finds the pairs of boxes that are there once: no world to keep, no room to guess.

use crate::border;
use crate::call::memory_range;
use crate::jobs::executor;
use crate::report;
use crate::status::{Refusal, trisap_status};
use crate::structs::{trisap_boxes, trisap_jobs, trisap_pair};
use core::ffi::{CStr, c_void};
use trisap_core::{Boxes, Capacity, Config, Error, Executor, Filter, World, layout};

const NAME: &CStr = c"trisap pairs";

/// Pairs for which the first call asks room, an object.
const PAIRS_PER_OBJECT: u32 = 8;
/// The class of boxes of the second side.
const SECOND: u32 = 1;

/// All pairs of boxes that overlap, each once, in no order, but the same for the same boxes: of `a`, by their positions, the lower one
/// first; or, where `b` is not null, of a box of `a` and a box of `b`, by their positions in each. `jobs` may be null. O(n log n + pairs).
///
/// `memory` has `*bytes` bytes on a multiple of `trisap_world_align()`, in any state. While they do not suffice, or `memory` is null,
/// the status is `TRISAP_STATUS_MEMORY_TOO_SMALL`, `*bytes` says how many will do for all that is known by then, and nothing is
/// reported: two calls are enough, three where boxes have more than eight pairs each. The pairs stand in the memory, from `*pairs` on.
///
/// Errors: `TRISAP_STATUS_BAD_BOX`, with the position of the box in `*count`, where boxes of `b` count on from those of `a`; `TRISAP_STATUS_CAPACITY_TOO_LARGE` for more than
/// 2^27 boxes or 2^32 pairs.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_pairs(
    a: *const trisap_boxes,
    b: *const trisap_boxes,
    jobs: *const trisap_jobs,
    memory: *mut c_void,
    bytes: *mut usize,
    pairs: *mut *const trisap_pair,
    count: *mut usize,
) -> trisap_status {
    let find = || -> Result<(), Refusal> {
        border::check(bytes)?;
        // SAFETY: aligned, not null, and initialised by the caller's promise.
        let room = if memory.is_null() { 0 } else { unsafe { bytes.read() } };
        let range = memory_range(memory, room);
        border::span(bytes, 1, &range)?;
        border::span(pairs, 1, &range)?;
        border::span(count, 1, &range)?;
        // SAFETY: the caller's promise.
        let a = unsafe { border::boxes(a, &range)? };
        // SAFETY: the caller's promise.
        let b = if b.is_null() { None } else { Some(unsafe { border::boxes(b, &range)? }) };
        // SAFETY: the caller's promise.
        let executor = unsafe { executor(jobs, NAME)? };
        let objects = a.len().saturating_add(b.map_or(0, |b| b.len()));
        let objects = u32::try_from(objects).map_err(|_| trisap_status::CapacityTooLarge)?;
        let config = |pairs: u32| {
            let capacity = Capacity::for_objects(objects).with_leaf_refs(objects).with_pairs(pairs);
            let config = Config::new(capacity).with_workers(executor.workers().clamp(1, 32));
            if b.is_some() { config.with_filters() } else { config }
        };
        let size = |pairs: u32| layout::<u32>(&config(pairs)).map(|layout| layout.bytes);
        let ask = |pairs: u64| {
            let needed = u32::try_from(pairs).ok().and_then(size).ok_or(trisap_status::CapacityTooLarge)?;
            // SAFETY: aligned and not null.
            unsafe { bytes.write(needed) };
            Err(Refusal { status: trisap_status::MemoryTooSmall, detail: needed as u64, quiet: true })
        };
        let fits = |pairs: u32| size(pairs).is_some_and(|bytes| bytes <= room);
        if memory.is_null() || !fits(0) {
            return ask(u64::from(objects) * u64::from(PAIRS_PER_OBJECT));
        }
        // As many pairs as the memory holds.
        let most = (0..32)
            .rev()
            .fold(0, |most: u32, bit| if fits(most | 1 << bit) { most | 1 << bit } else { most });
        let config = config(most);
        let needed = size(most).ok_or(trisap_status::CapacityTooLarge)?;
        if !memory.addr().is_multiple_of(layout::<u32>(&config).map_or(1, |layout| layout.align)) {
            return Err(trisap_status::Misaligned.into());
        }
        // SAFETY: by the caller's promise there are `room` bytes, and `needed` is no more. A slice needs initialised memory.
        unsafe { memory.cast::<u8>().write_bytes(0, needed) };
        // SAFETY: initialised just now, and nobody else uses it.
        let slab = unsafe { core::slice::from_raw_parts_mut(memory.cast::<u8>(), needed) };
        let mut world = World::<u32>::new_in(slab, &config)?;
        if let Err(error) = fill(&mut world, a, b) {
            let refusal = Refusal::from(error);
            // SAFETY: aligned, not null, and outside of the memory.
            unsafe { count.write(refusal.detail as usize) };
            return Err(refusal);
        }
        match world.on(&executor).step().map(drop) {
            Err(Error::PairsFull { needed, .. }) => return ask(needed),
            step => step?,
        }
        let (first, found) = border::lend::<_, trisap_pair>(memory, world.pairs());
        if b.is_some() {
            for at in 0..found {
                // SAFETY: the world is not used any more, and these pairs stand in the caller's memory.
                let pair = unsafe { &mut *first.cast_mut().add(at) };
                pair.b -= a.len() as u32;
            }
        }
        // SAFETY: aligned, not null, and outside of the memory.
        unsafe { (pairs.write(first), count.write(found)) };
        Ok(())
    };
    report::conclude(find())
}

/// Inserts the boxes of both sides, which meet each other alone.
fn fill(world: &mut World<'_>, a: Boxes<'_>, b: Option<Boxes<'_>>) -> Result<(), Error> {
    drop(world.insert_many(a)?);
    let Some(b) = b else { return Ok(()) };
    let mut meets = [0; 32];
    (meets[0], meets[SECOND as usize]) = (1 << SECOND, 1);
    world.set_classes(&meets)?;
    let first = world.len();
    drop(world.insert_many(b).map_err(|error| match error {
        Error::BadBox { index } => Error::BadBox { index: first + index },
        error => error,
    })?);
    for slot in first..world.len() {
        if let Some(id) = world.id_at(slot) {
            world.set_filter(id, Filter::class(SECOND))?;
        }
    }
    Ok(())
}
