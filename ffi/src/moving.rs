//! Worlds that go to other memory.

use crate::border;
use crate::call::{Call, HEADER, Header, Look, check_header, look, memory_range, trisap_world};
use crate::report;
use crate::status::trisap_status;
use crate::structs::trisap_config;
use crate::world::place;
use core::ffi::c_void;

/// The bytes that the world takes of its memory: what a copy for `trisap_world_open` has to copy. 0 for misuse. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_bytes(world: *const trisap_world) -> usize {
    // SAFETY: the caller's promise.
    unsafe { Look::enter(world) }.map_or(0, |look| look.range().len())
}

/// Finds the world in `memory`, a copy of the memory of another one, and writes where it is to `world`. O(1).
///
/// For copies within a program, and between programs that run the same version on the same kind of machine. Smaller,
/// and checked when they come back, are the snapshots of `trisap_world_save`.
///
/// Errors: `TRISAP_STATUS_MEMORY_TOO_SMALL`, `TRISAP_STATUS_NOT_A_WORLD`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_open(
    memory: *mut c_void,
    bytes: usize,
    world: *mut *mut trisap_world,
) -> trisap_status {
    let header = memory.cast::<Header>();
    let find = || {
        border::check(header)?;
        if bytes < HEADER {
            return Err(trisap_status::MemoryTooSmall.into());
        }
        // SAFETY: aligned, not null, and by the caller's promise as long as a header.
        let slab_bytes = unsafe { check_header(header)? };
        if bytes - HEADER < slab_bytes {
            return Err(trisap_status::MemoryTooSmall.into());
        }
        border::span(world, 1, &memory_range(memory, HEADER + slab_bytes))?;
        // A copy may have been made inside of a call.
        // SAFETY: as above.
        unsafe { (*header).release() };
        // SAFETY: a world, as far as the header tells.
        let mut call = unsafe { Call::enter(header.cast())? };
        call.world()?;
        drop(call);
        // SAFETY: aligned, not null, and outside of the memory.
        unsafe { world.write(header.cast()) };
        Ok(())
    };
    report::conclude(find())
}

/// Moves a world to other memory and another configuration: larger, or smaller where all fits. Writes where it is,
/// which is `memory` itself, to `world`. The world `from` stays as it is, and can be forgotten. O(bytes).
///
/// Everything goes on: ids, boxes, margins, filters, who rests, and the last result, so that the next step tells what
/// is found and lost since. After `TRISAP_STATUS_PAIRS_FULL` a world can move to where there is room for the pairs, and
/// a step there tells the events as if there had been room from the beginning. Capacities, workers and the margin of
/// new objects may change; mode, events, filters and whether there are margins may not.
///
/// Errors: those of `trisap_world_init`, `TRISAP_STATUS_OTHER_CONFIG`, and `TRISAP_STATUS_OBJECTS_FULL` or
/// `TRISAP_STATUS_PAIRS_FULL` where the world does not fit; the detail of `from` then says how many would have to.
/// Nothing has been written to the memory then.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_move(
    from: *const trisap_world,
    memory: *mut c_void,
    bytes: usize,
    config: *const trisap_config,
    world: *mut *mut trisap_world,
) -> trisap_status {
    let go = |call: &Look| {
        border::check(memory.cast::<Header>())?;
        // SAFETY: the caller's promise.
        let config = unsafe { border::read(config)? };
        let core_config = config.to_core()?;
        let taken = call.range();
        let from = call.world()?;
        let make = |slab: &mut [u8]| from.move_into(slab, &core_config).map(|_| ());
        // SAFETY: the caller's promise, and the memory is no part of the other world.
        unsafe { place(memory, bytes, &config, world, &[taken], make) }
    };
    // SAFETY: the caller's promise.
    unsafe { look(from, go) }
}
