//! Queries among some of the objects: as if the others were not there.

use crate::border;
use crate::call::{Look, look, trisap_world};
use crate::filter::trisap_filter;
use crate::objects::living;
use crate::query::{first_hit, hits, nearest, overlaps, trisap_cast, trisap_region};
use crate::status::trisap_status;
use crate::structs::{trisap_hit, trisap_id};
use core::ffi::c_void;
use trisap_core::Id;

/// Called with an object that a query has come to; not 0 if it may answer. It has to say the same of the same object. May look at the
/// world, for instance by `trisap_world_meets`; calls that change it are refused as busy.
pub type trisap_condition = Option<unsafe extern "C" fn(user: *mut c_void, id: trisap_id) -> u32>;

/// 1 if an object meets what has this filter, by groups and classes, else 0; 0 for misuse and stale ids. Objects of a world without
/// filters are in all groups and meet all. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_meets(
    world: *const trisap_world,
    id: trisap_id,
    filter: *const trisap_filter,
) -> u32 {
    let mut meets = 0;
    let ask = |call: &Look| {
        border::check(filter)?;
        // SAFETY: aligned, not null, and initialised by the caller's promise.
        let filter = unsafe { filter.read() };
        meets = u32::from(call.world()?.meets(living(id)?, &filter.into()));
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) };
    meets
}

/// A condition in the core's form.
fn accepts(condition: trisap_condition, user: *mut c_void) -> Result<impl Fn(Id) -> bool, trisap_status> {
    let condition = condition.ok_or(trisap_status::NullPointer)?;
    // SAFETY: called as its contract says.
    Ok(move |id: Id| unsafe { condition(user, id.to_bits()) } != 0)
}

/// `trisap_world_overlaps` of the objects that fulfil a condition; `user` is handed to it.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_overlaps_among(
    world: *const trisap_world,
    region: *const trisap_region,
    condition: trisap_condition,
    user: *mut c_void,
    ids: *mut trisap_id,
    room: usize,
    count: *mut usize,
) -> trisap_status {
    // SAFETY: the caller's promise.
    let ask =
        |call: &Look| unsafe { overlaps(call, region, Some(&accepts(condition, user)?), ids, room, count) };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// `trisap_world_first_hit` of the objects that fulfil a condition; `user` is handed to it.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_first_hit_among(
    world: *const trisap_world,
    cast: *const trisap_cast,
    condition: trisap_condition,
    user: *mut c_void,
    hit: *mut trisap_hit,
) -> trisap_status {
    // SAFETY: the caller's promise.
    let ask = |call: &Look| unsafe { first_hit(call, cast, Some(&accepts(condition, user)?), hit) };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// `trisap_world_hits` of the objects that fulfil a condition; `user` is handed to it.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_hits_among(
    world: *const trisap_world,
    cast: *const trisap_cast,
    condition: trisap_condition,
    user: *mut c_void,
    hits: *mut trisap_hit,
    room: usize,
    count: *mut usize,
) -> trisap_status {
    // SAFETY: the caller's promise.
    let ask =
        |call: &Look| unsafe { self::hits(call, cast, Some(&accepts(condition, user)?), hits, room, count) };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// `trisap_world_nearest` of the objects that fulfil a condition; `user` is handed to it.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_nearest_among(
    world: *const trisap_world,
    position: *const f32,
    condition: trisap_condition,
    user: *mut c_void,
    hits: *mut trisap_hit,
    room: usize,
    count: *mut usize,
) -> trisap_status {
    // SAFETY: the caller's promise.
    let ask =
        |call: &Look| unsafe { nearest(call, position, Some(&accepts(condition, user)?), hits, room, count) };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}
