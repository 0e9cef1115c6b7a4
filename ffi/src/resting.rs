//! Objects that the caller knows to rest.

use crate::border;
use crate::call::{Call, Look, look, trisap_world, with};
use crate::objects::living;
use crate::status::trisap_status;
use crate::structs::trisap_id;

/// Puts objects to rest, all or none. The next step parks their pairs with each other, and steps do not look at what
/// the boxes of `trisap_world_step_over` have for them. `trisap_world_update` and `trisap_world_update_many` wake an
/// object. O(ids).
///
/// Errors: `TRISAP_STATUS_STALE_ID`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_set_resting(
    world: *mut trisap_world,
    ids: *const trisap_id,
    count: usize,
) -> trisap_status {
    let rest = |call: &mut Call| {
        // SAFETY: the caller's promise.
        let ids = unsafe { border::ids(ids, count, &call.range())? };
        Ok(call.world()?.set_resting(ids)?)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, rest) }
}

/// Has steps look at the boxes of `trisap_world_step_over` for objects again, all or none. O(ids).
///
/// Errors: `TRISAP_STATUS_STALE_ID`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_wake(
    world: *mut trisap_world,
    ids: *const trisap_id,
    count: usize,
) -> trisap_status {
    let wake = |call: &mut Call| {
        // SAFETY: the caller's promise.
        let ids = unsafe { border::ids(ids, count, &call.range())? };
        Ok(call.world()?.wake(ids)?)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, wake) }
}

/// 1 if the object was put to rest and has not been woken since, else 0; 0 for misuse and stale ids. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_is_resting(world: *const trisap_world, id: trisap_id) -> u32 {
    let mut rests = 0;
    let ask = |call: &Look| {
        rests = u32::from(call.world()?.is_resting(living(id)?));
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) };
    rests
}
