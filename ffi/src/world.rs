//! Worlds in the caller's memory.

use crate::border;
use crate::call::{Call, HEADER, Header, Look, check_header, look, memory_range};
use crate::report;
use crate::status::{Refusal, trisap_status};
use crate::structs::{trisap_config, trisap_stats};
use core::ffi::c_void;
use core::ops::Range;
use trisap_core::{Error, Path, Reason, World, layout};

pub use crate::call::trisap_world;

/// The bytes of a world, header and slab.
fn size(config: &trisap_config) -> Result<usize, trisap_status> {
    let config = config.to_core()?;
    let slab = layout::<u32>(&config).ok_or(trisap_status::CapacityTooLarge)?;
    const { assert!(align_of::<Header>().is_multiple_of(64)) };
    debug_assert!(slab.align <= align_of::<Header>());
    slab.bytes.checked_add(HEADER).ok_or(trisap_status::CapacityTooLarge)
}

/// The bytes of memory that a world of this configuration needs, or 0 where there can be none: `trisap_world_init` then
/// says why. Grows linearly with objects, leaf references and pairs.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_size(config: *const trisap_config) -> usize {
    // SAFETY: the caller's promise.
    unsafe { border::read(config) }.and_then(|config| size(&config)).unwrap_or(0)
}

/// The boundary that the memory of a world starts on: 64 bytes.
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn trisap_world_align() -> usize {
    align_of::<Header>()
}

/// Makes an empty world in `memory` and writes where it is, which is `memory` itself, to `world`.
///
/// What was in the memory does not matter: so a world is cleared, too. What is beyond `trisap_world_size()` is not
/// touched. Nothing is allocated, neither here nor later. O(bytes).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_init(
    memory: *mut c_void,
    bytes: usize,
    config: *const trisap_config,
    world: *mut *mut trisap_world,
) -> trisap_status {
    let make = || {
        border::check(memory.cast::<Header>())?;
        // SAFETY: the caller's promise.
        let config = unsafe { border::read(config)? };
        let core_config = config.to_core()?;
        let make = |slab: &mut [u8]| World::<u32>::new_in(slab, &core_config).map(|_| ());
        // SAFETY: the caller's promise.
        unsafe { place(memory, bytes, &config, world, &[], make) }
    };
    report::conclude(make())
}

/// Moves a world to other memory and another configuration: larger, or smaller where all fits. Writes where it is, which is
/// `memory` itself, to `world`. The world `from` stays as it is, and can be forgotten. O(bytes).
///
/// Everything goes on: ids, boxes, margins, filters, who rests, and the last result, so that the next step tells what is found and
/// lost since. After `TRISAP_STATUS_PAIRS_FULL` a world can move to where there is room for the pairs, and a step there tells the
/// events as if there had been room from the beginning. Capacities, workers, the margin of new objects and all choices about speed
/// may change; mode, events, filters and whether there are margins may not: `TRISAP_STATUS_OTHER_CONFIG`.
///
/// Where the world does not fit, the status is `TRISAP_STATUS_OBJECTS_FULL` or `TRISAP_STATUS_PAIRS_FULL`, and the detail of `from`
/// says how many would have to fit. After each status but `TRISAP_STATUS_OK` nothing has been written to the memory.
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

/// Makes a world in memory, once everything that can be wrong with it has been looked at. The memory may not reach into what is
/// `taken`.
///
/// # Safety
/// The memory has so many bytes, and nobody else uses them.
unsafe fn place(
    memory: *mut c_void,
    bytes: usize,
    config: &trisap_config,
    world: *mut *mut trisap_world,
    taken: &[Range<usize>],
    mut make: impl FnMut(&mut [u8]) -> Result<(), Error>,
) -> Result<(), Refusal> {
    let header = memory.cast::<Header>();
    // What may be wrong with it shows without memory, so that a refusal leaves the memory alone.
    match make(&mut []) {
        Err(Error::SlabTooSmall { .. }) | Ok(()) => {}
        Err(error) => return Err(error.into()),
    }
    let needed = size(config)?;
    if bytes < needed {
        return Err(trisap_status::MemoryTooSmall.into());
    }
    border::span(world, 1, &memory_range(memory, needed))?;
    for taken in taken {
        border::span(world, 1, taken)?;
        border::span(memory.cast::<u8>(), needed, taken)?;
    }
    let slab_bytes = needed - HEADER;
    // SAFETY: by the caller's promise there are `bytes` bytes, and `needed` is no more. A slice needs initialised memory.
    unsafe { memory.cast::<u8>().write_bytes(0, needed) };
    // SAFETY: the bytes after the header, initialised just now.
    let slab = unsafe { core::slice::from_raw_parts_mut(header.add(1).cast::<u8>(), slab_bytes) };
    make(slab)?;
    // SAFETY: aligned, and the first bytes of the memory.
    unsafe { header.write(Header::new(slab_bytes)) };
    // SAFETY: aligned, not null, and outside of the memory.
    unsafe { world.write(header.cast()) };
    Ok(())
}

/// Finds the world in `memory`, a copy of the memory of another one, and writes where it is to `world`. O(1).
///
/// For copies within a program, and between programs that run the same version on the same kind of machine. Smaller, and
/// checked when they come back, are the snapshots of `trisap_world_save`.
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

/// What the status of the last refused call was about: see `trisap_status`. 0 for a null or busy world.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_error_detail(world: *const trisap_world) -> u64 {
    // SAFETY: the caller's promise.
    unsafe { Look::enter(world) }.map_or(0, |look| look.detail())
}

/// The bytes that the world takes of its memory: what a copy for
/// `trisap_world_open` has to copy. 0 for misuse.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_bytes(world: *const trisap_world) -> usize {
    // SAFETY: the caller's promise.
    unsafe { Look::enter(world) }.map_or(0, |look| look.range().len())
}

/// Writes what the world was made for to `config`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_config(
    world: *const trisap_world,
    config: *mut trisap_config,
) -> trisap_status {
    let ask = |call: &Look| {
        // SAFETY: the caller's promise.
        unsafe { border::check_versioned(config)? };
        let known = trisap_config::from_core(&call.world()?.config());
        // SAFETY: checked above.
        unsafe { config.write(known) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// Writes what the last step did to `stats`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_stats(
    world: *const trisap_world,
    stats: *mut trisap_stats,
) -> trisap_status {
    let ask = |call: &Look| {
        // SAFETY: the caller's promise.
        unsafe { border::check_versioned(stats)? };
        let known = call.world()?.stats();
        let told = trisap_stats {
            struct_size: size_of::<trisap_stats>() as u32,
            path: match known.path {
                Path::Unchanged => crate::structs::TRISAP_PATH_UNCHANGED,
                Path::Lists => crate::structs::TRISAP_PATH_LISTS,
                Path::Movers => crate::structs::TRISAP_PATH_MOVERS,
                Path::Full => crate::structs::TRISAP_PATH_FULL,
                Path::Rebuilt => crate::structs::TRISAP_PATH_REBUILT,
            },
            objects: known.objects,
            moved: known.moved,
            leaves: known.leaves,
            leaves_in_use: known.leaves_in_use,
            fullest_leaf: known.fullest_leaf,
            large: known.large,
            rebalanced: known.rebalanced,
            coarse_resolution: u32::from(known.coarse_resolution),
            reason: match known.reason {
                Reason::NoMovers => crate::structs::TRISAP_REASON_NO_MOVERS,
                Reason::FewObjects => crate::structs::TRISAP_REASON_FEW_OBJECTS,
                Reason::FewMovers => crate::structs::TRISAP_REASON_FEW_MOVERS,
                Reason::ManyMovers => crate::structs::TRISAP_REASON_MANY_MOVERS,
                Reason::Fixed => crate::structs::TRISAP_REASON_FIXED,
                Reason::NothingKept => crate::structs::TRISAP_REASON_NOTHING_KEPT,
                Reason::NoRoom => crate::structs::TRISAP_REASON_NO_ROOM,
                Reason::Outgrown => crate::structs::TRISAP_REASON_OUTGROWN,
                Reason::OutOfBalance => crate::structs::TRISAP_REASON_OUT_OF_BALANCE,
                Reason::NoRoomForSurplus => crate::structs::TRISAP_REASON_NO_ROOM_FOR_SURPLUS,
                _ => crate::structs::TRISAP_REASON_OTHER,
            },
            fine_leaves: u32::from(known.fine_leaves),
            shared: u32::from(known.shared),
            outran: known.outran,
            copies: known.copies,
            candidates: known.candidates,
            tied: known.tied,
            pairs: known.pairs,
            found: known.found,
            lost: known.lost,
            surplus: known.surplus,
        };
        // SAFETY: checked above.
        unsafe { stats.write(told) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// Checks every invariant of the world, for debugging what else writes to its memory: `TRISAP_STATUS_CORRUPT` where one
/// is broken. O(n log n).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_validate(world: *const trisap_world) -> trisap_status {
    let ask = |call: &Look| call.world()?.validate().map_err(|_| trisap_status::Corrupt.into());
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}
