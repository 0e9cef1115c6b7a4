//! Snapshots: a world as plain bytes, for files and for those who join late.

use crate::border;
use crate::call::{Call, look, trisap_world, with};
use crate::status::trisap_status;
use core::ffi::c_void;
use trisap_core::Error;

/// The bytes of a snapshot of the world as it is now; 0 for misuse. O(n / 32).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_snapshot_size(world: *const trisap_world) -> usize {
    let mut size = 0;
    let ask = |call: &Call| {
        size = call.world.snapshot_size();
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) };
    size
}

/// Writes a snapshot of the world to `snapshot`, which has room for `room` bytes, and its length to `bytes`. Any
/// alignment is right. O(n + pairs).
///
/// A snapshot holds no addresses and no scratch memory. It is much smaller than the world, and any world that has
/// room can load it, in any program of the same version, on any machine of the same byte order.
///
/// Errors: `TRISAP_STATUS_OUTPUT_FULL`. Only the length is written then.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_save(
    world: *const trisap_world,
    snapshot: *mut c_void,
    room: usize,
    bytes: *mut usize,
) -> trisap_status {
    let save = |call: &Call| {
        let range = call.range();
        border::span(bytes, 1, &range)?;
        if room > 0 {
            border::span(snapshot.cast::<u8>(), room, &range)?;
        }
        let world = &call.world;
        let needed = world.snapshot_size();
        // SAFETY: aligned, not null, and outside of the world.
        unsafe { bytes.write(needed) };
        if needed > room {
            return Err(Error::OutputFull { needed: needed as u64, room }.into());
        }
        // SAFETY: not null, outside of the world, and no more than the caller's room. A slice needs initialised memory.
        unsafe { snapshot.cast::<u8>().write_bytes(0, needed) };
        // SAFETY: as above, and initialised just now.
        let out = unsafe { core::slice::from_raw_parts_mut(snapshot.cast::<u8>(), needed) };
        world.save(out)?;
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, save) }
}

/// Replaces the world by that of a snapshot, in its own configuration, which may differ as for `trisap_world_move`. The
/// result of its last step comes with it: see `trisap_world_result`. Older results mean nothing any more. O(bytes).
///
/// The next step finds all pairs anew, and tells as events what has changed since the result that was saved. The order
/// of pairs may differ from that of the world that was saved; worlds that load the same snapshot go on alike, byte for
/// byte, if their configurations are the same. To go back within a program, a copy of the memory is faster: see
/// `trisap_world_open`.
///
/// The checksum notices damage, not intent. Forged bytes with a right checksum are refused, or they are a world: each
/// object and each pair of it can be, and the pairs of every step are those of its boxes. The saved result and what the
/// events of the first step compare with are as the bytes say.
///
/// Errors: `TRISAP_STATUS_BAD_SNAPSHOT`; `TRISAP_STATUS_CAPACITY_TOO_LARGE` or `TRISAP_STATUS_BAD_MARGIN` if this library
/// cannot make such a world; `TRISAP_STATUS_OTHER_CONFIG`, `TRISAP_STATUS_OBJECTS_FULL`, `TRISAP_STATUS_PAIRS_FULL`. The
/// world is as it was then.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_load(
    world: *mut trisap_world,
    snapshot: *const c_void,
    bytes: usize,
) -> trisap_status {
    let load = |call: &mut Call| {
        let first = snapshot.cast::<u8>();
        border::span(first, bytes, &call.range())?;
        // SAFETY: not null, no longer than a slice may be, outside of the world, and by the caller's promise initialised.
        let snapshot = unsafe { core::slice::from_raw_parts(first, bytes) };
        Ok(call.world.load(snapshot)?)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, load) }
}
