//! Gives objects values for the caller's use.

use crate::border::{self, Answers, Items, living};
use crate::call::{Call, look, trisap_world, with};
use crate::events::{TRISAP_PAIRS_ALL, TRISAP_PAIRS_FOUND, TRISAP_PAIRS_LOST};
use crate::status::trisap_status;
use crate::structs::trisap_id;
use trisap_core::{Error, Id, World};

/// Two objects by value.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct trisap_value_pair {
    /// The value of the object in the lower slot.
    pub a: u64,
    /// The value of the object in the higher slot.
    pub b: u64,
}

/// Gives an object a value: an index, a pointer, an entity. A new object has 0. Needs `trisap_config::values`. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_set_value(
    world: *mut trisap_world,
    id: trisap_id,
    value: u64,
) -> trisap_status {
    // SAFETY: the caller's promise.
    unsafe { with(world, |call| Ok(call.world.set_value(living(id)?, value)?)) }
}

/// Gives objects values, all or none: the value of `ids[i]` begins `i * stride` bytes behind that of `ids[0]`. O(n).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_set_value_many(
    world: *mut trisap_world,
    ids: *const trisap_id,
    values: *const u64,
    stride: usize,
    count: usize,
) -> trisap_status {
    let set = |call: &mut Call| {
        let range = call.range();
        // SAFETY: the caller's promise.
        let (ids, values) =
            unsafe { (border::ids(ids, count, &range)?, Items::new(values, stride, count, &range)?) };
        let world = &mut call.world;
        for id in ids {
            known(world, *id)?;
        }
        for (at, id) in ids.iter().enumerate() {
            world.set_value(*id, values.get(at).unwrap_or_default())?;
        }
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, set) }
}

/// Writes the value of an object to `value`. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_value(
    world: *const trisap_world,
    id: trisap_id,
    value: *mut u64,
) -> trisap_status {
    let ask = |call: &Call| {
        border::span(value, 1, &call.range())?;
        let world = &call.world;
        let known = known(world, living(id)?)?;
        // SAFETY: aligned, not null, and outside of the world.
        unsafe { value.write(known) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// Writes the values of `count` objects to `values`. Their ids are `stride` bytes behind each other, as in the hits
/// of a query. After a refusal some may be written. O(n).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_values(
    world: *const trisap_world,
    ids: *const trisap_id,
    stride: usize,
    count: usize,
    values: *mut u64,
) -> trisap_status {
    let ask = |call: &Call| {
        let range = call.range();
        // SAFETY: the caller's promise.
        let ids = unsafe { Items::new(ids, stride, count, &range)? };
        if count > 0 {
            border::span(values, count, &range)?;
        }
        let world = &call.world;
        for at in 0..count {
            let value = known(world, living(ids.get(at).unwrap_or_default())?)?;
            // SAFETY: not null, aligned, within the caller's room and outside of the world.
            unsafe { values.add(at).write(value) };
        }
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// Writes pairs of the last step by value to `pairs`, which has room for `room`, and how many there are to `count`:
/// as `trisap_world_pair_ids` does by id, and to be called at the same time. Lost pairs have the values that
/// the objects of the pair had last, also if these were set since the step. After `TRISAP_STATUS_OUTPUT_FULL` the room
/// holds as many as fit. O(pairs).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_pair_values(
    world: *const trisap_world,
    what: u32,
    pairs: *mut trisap_value_pair,
    room: usize,
    count: *mut usize,
) -> trisap_status {
    let ask = |call: &Call| {
        // SAFETY: the caller's promise.
        let mut answers = unsafe { Answers::new(pairs, room, count, &call.range())? };
        let world = &call.world;
        if !world.config().values {
            return Err(Error::NoValues.into());
        }
        let mut push = |[a, b]: [u64; 2]| answers.push(trisap_value_pair { a, b });
        match what {
            TRISAP_PAIRS_ALL => world.pair_values().for_each(&mut push),
            TRISAP_PAIRS_FOUND => world.found_values().for_each(&mut push),
            TRISAP_PAIRS_LOST => world.lost_values().for_each(&mut push),
            _ => return Err(trisap_status::InvalidArgument.into()),
        }
        answers.conclude()
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// The value of an object, or why there is none.
fn known(world: &World<'_>, id: Id) -> Result<u64, Error> {
    let refusal = if world.contains(id) { Error::NoValues } else { Error::StaleId { id } };
    world.value(id).ok_or(refusal)
}

// The header asserts the same on the other side of the border.
const _: () = assert!(size_of::<trisap_value_pair>() == 16);
