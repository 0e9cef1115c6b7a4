//! Makes worlds in the caller's memory.

use crate::border;
use crate::call::{Call, HEADER, Header, Inside, look, memory_range};
use crate::report;
use crate::status::{Refusal, trisap_status};
use crate::structs::trisap_config;
use core::ffi::c_void;
use core::ops::Range;
use trisap_core::{Error, World, layout};

pub use crate::call::trisap_world;

/// The bytes of a world, header and slab.
fn size(config: &trisap_config) -> Result<usize, trisap_status> {
    let config = config.to_core()?;
    let slab = layout::<u32>(&config).ok_or(trisap_status::CapacityTooLarge)?;
    const { assert!(align_of::<Header>().is_multiple_of(64)) };
    debug_assert!(slab.align <= align_of::<Header>());
    slab.bytes.checked_add(HEADER).ok_or(trisap_status::CapacityTooLarge)
}

/// The bytes of memory that a world of this configuration needs. They grow linearly with objects, leaf references and
/// pairs. O(1).
///
/// 0 if there can be no such world: `trisap_world_init` says why.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_size(config: *const trisap_config) -> usize {
    // SAFETY: the caller's promise.
    unsafe { border::read(config) }.and_then(|config| size(&config)).unwrap_or(0)
}

/// The alignment of the memory of a world: 64 bytes. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn trisap_world_align() -> usize {
    align_of::<Header>()
}

/// Makes an empty world in `memory` and writes where it is, which is `memory` itself, to `world`. O(bytes).
///
/// What was in the memory does not matter, so this also clears a world. Bytes beyond `trisap_world_size()` are not
/// touched. Nothing is allocated, now or later.
///
/// Errors: `TRISAP_STATUS_MEMORY_TOO_SMALL`, `TRISAP_STATUS_INVALID_ARGUMENT`, `TRISAP_STATUS_CAPACITY_TOO_LARGE`,
/// `TRISAP_STATUS_BAD_MARGIN`. Nothing is written then.
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

/// Makes a world in memory, after everything has been checked. The memory must not reach into what is `taken`.
///
/// # Safety
/// The memory has so many bytes, and nothing else uses them.
pub(crate) unsafe fn place(
    memory: *mut c_void,
    bytes: usize,
    config: &trisap_config,
    world: *mut *mut trisap_world,
    taken: &[Range<usize>],
    mut make: impl FnMut(&mut [u8]) -> Result<(), Error>,
) -> Result<(), Refusal> {
    let header = memory.cast::<Header>();
    // Checked without the memory, so that a refusal leaves it alone.
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

/// What the status of the last refused call was about: see `trisap_status`. 0 for a null or busy world. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_error_detail(world: *const trisap_world) -> u64 {
    // SAFETY: the caller's promise.
    unsafe { Inside::enter(world, false) }.map_or(0, |inside| {
        let detail = inside.detail();
        inside.leave();
        detail
    })
}

/// Writes what the world was made for to `config`, which has to have its `struct_size`. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_config(
    world: *const trisap_world,
    config: *mut trisap_config,
) -> trisap_status {
    let ask = |call: &Call| {
        // SAFETY: the caller's promise.
        unsafe { border::check_versioned(config)? };
        let known = trisap_config::from_core(&call.world.config());
        // SAFETY: checked above.
        unsafe { config.write(known) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}
