//! Moves worlds to other memory.

use crate::border;
use crate::call::{Call, HEADER, Header, Inside, check_header, look, memory_range, trisap_world, with};
use crate::report;
use crate::status::trisap_status;
use crate::structs::trisap_config;
use crate::world::place;
use core::ffi::c_void;

/// How many bytes of its memory the world takes: a copy for `trisap_world_open` needs these. 0 for misuse. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_bytes(world: *const trisap_world) -> usize {
    // SAFETY: the caller's promise.
    unsafe { Inside::enter(world, false) }.map_or(0, |inside| {
        inside.leave();
        inside.range().len()
    })
}

/// Whether full buffers of this world are to be reported: with 1, `TRISAP_STATUS_OBJECTS_FULL` and
/// `TRISAP_STATUS_PAIRS_FULL` are still the statuses, and the function of `trisap_set_report` is not called for them.
/// For those who move the world to more memory then, and call `trisap_refuse` where they cannot. A world that was moved
/// or opened reports everything again. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_set_growing(world: *mut trisap_world, growing: u32) -> trisap_status {
    let set = |call: &mut Call| {
        call.set_growing(growing != 0);
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, set) }
}

/// Opens the world in `memory`, a copy of the memory of another one, and writes where it is to `world`. O(1).
///
/// The way to go back, and for copies between programs of the same version on the same kind of machine: copy
/// `trisap_world_bytes(world)` bytes from where the world is to other memory of the same alignment, or back, and open it
/// there. Nothing of the world may run meanwhile. The copy goes on as the world would have, byte for byte. The bytes are
/// not checked; the snapshots of `trisap_world_save` are, and are smaller.
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
        // SAFETY: as above.
        unsafe { (*header).report_all() };
        // SAFETY: a world, as far as the header tells.
        let inside = unsafe { Inside::enter(header.cast(), true)? };
        // SAFETY: nobody else is inside.
        let opened = unsafe { inside.open() };
        inside.leave();
        opened?;
        // SAFETY: aligned, not null, and outside of the memory.
        unsafe { world.write(header.cast()) };
        Ok(())
    };
    report::conclude(find())
}

/// Moves a world to other memory and another configuration: larger, or smaller if all fits. Writes where it is, which
/// is `memory` itself, to `world`. The world `from` stays as it is and needs nothing more. O(bytes).
///
/// Everything goes on: ids, boxes, margins, filters, rest, and the last result, so the next step tells what is found
/// and lost since. After `TRISAP_STATUS_PAIRS_FULL` a world can move to where there is room for the pairs; a step
/// there tells events as if there had always been room. Capacities, workers and the margin of new objects may change.
/// The mode, events, filters, values and whether there are margins may not.
///
/// Errors: those of `trisap_world_init`, `TRISAP_STATUS_OTHER_CONFIG`, and `TRISAP_STATUS_OBJECTS_FULL` or
/// `TRISAP_STATUS_PAIRS_FULL` if the world does not fit; the detail of `from` then says how much would have to fit.
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
    let go = |call: &Call| {
        border::check(memory.cast::<Header>())?;
        // SAFETY: the caller's promise.
        let config = unsafe { border::read(config)? };
        let core_config = config.to_core()?;
        let taken = call.range();
        let from = &call.world;
        let make = |slab: &mut [u8]| from.move_into(slab, &core_config).map(|_| ());
        // SAFETY: the caller's promise, and the memory is no part of the other world.
        unsafe { place(memory, bytes, &config, world, &[taken], make) }
    };
    // SAFETY: the caller's promise.
    unsafe { look(from, go) }
}
