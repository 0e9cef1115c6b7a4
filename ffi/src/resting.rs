//! Objects that the caller knows to rest, and disabled ones.

use crate::border::{self, Answers, living};
use crate::call::{Call, look, trisap_world, with};
use crate::status::trisap_status;
use crate::structs::{trisap_id, trisap_pair};

/// Puts objects to rest, all or none. The next step parks their pairs with each other, and steps ignore their boxes
/// in `trisap_world_step_over`. `trisap_world_update` and `trisap_world_update_many` wake an object. O(ids).
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
        Ok(call.world.set_resting(ids)?)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, rest) }
}

/// Wakes objects, all or none: steps take their boxes from `trisap_world_step_over` again. O(ids).
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
        Ok(call.world.wake(ids)?)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, wake) }
}

/// Disables objects, or enables them again if `enabled` is not 0; all or none. A disabled object is in no pair and in no answer, and
/// costs a step nothing. It keeps its id, box, margin, filter and value, and can be given others; `trisap_world_step_over` does not
/// read its box. Its pairs are lost at the next step, and found at the next one after it is enabled. It counts as resting
/// until it is woken or gets another box, and is awake when it is enabled. O(ids).
///
/// Errors: `TRISAP_STATUS_STALE_ID`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_set_enabled(
    world: *mut trisap_world,
    ids: *const trisap_id,
    count: usize,
    enabled: u32,
) -> trisap_status {
    let enable = |call: &mut Call| {
        // SAFETY: the caller's promise.
        let ids = unsafe { border::ids(ids, count, &call.range())? };
        Ok(call.world.set_enabled_many(ids, enabled != 0)?)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, enable) }
}

/// 1 if the object is enabled, else 0; 0 for misuse and stale ids. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_is_enabled(world: *const trisap_world, id: trisap_id) -> u32 {
    let mut enabled = 0;
    let ask = |call: &Call| {
        enabled = u32::from(call.world.is_enabled(living(id)?));
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) };
    enabled
}

/// Writes the pairs of the last step with at least one awake object to `pairs`, which has room for `room` of them,
/// and their number to `count`. An object is awake if it was not put to rest, or has been woken since. A narrow phase
/// that keeps the contacts of resting objects needs only these pairs. After `TRISAP_STATUS_OUTPUT_FULL` the room
/// holds as many as fit. O(pairs).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_awake_pairs(
    world: *const trisap_world,
    pairs: *mut trisap_pair,
    room: usize,
    count: *mut usize,
) -> trisap_status {
    let ask = |call: &Call| {
        // SAFETY: the caller's promise.
        let mut answers = unsafe { Answers::new(pairs, room, count, &call.range())? };
        call.world.awake_pairs().for_each(|[a, b]| answers.push(trisap_pair { a, b }));
        answers.conclude()
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// 1 if the object was put to rest and has not been woken since, else 0; 0 for misuse and stale ids. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_is_resting(world: *const trisap_world, id: trisap_id) -> u32 {
    let mut rests = 0;
    let ask = |call: &Call| {
        rests = u32::from(call.world.is_resting(living(id)?));
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) };
    rests
}
