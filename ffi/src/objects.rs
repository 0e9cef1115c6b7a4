//! Objects. None of these calls changes the result of the last step; the next step sees all of them at once.

use crate::aabb::trisap_aabb;
use crate::border::{self, Items, living};
use crate::call::{Call, look, trisap_world, with};
use crate::status::trisap_status;
use crate::structs::{TRISAP_NULL_ID, trisap_boxes, trisap_id};
use trisap_core::{Aabb, Error, Id};

/// A view of boxes one after another. For others, point `first` to the first minimum and set `stride` and
/// `max_offset`. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn trisap_default_boxes(boxes: *const trisap_aabb, count: usize) -> trisap_boxes {
    trisap_boxes {
        struct_size: size_of::<trisap_boxes>() as u32,
        max_offset: 12,
        first: boxes.cast(),
        stride: size_of::<trisap_aabb>(),
        count,
    }
}

/// The index of an object in pairs and in the boxes of `trisap_world_step_over`. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn trisap_id_slot(id: trisap_id) -> u32 {
    id as u32
}

/// Adds an object and writes its id to `id`. Slots are given out in ascending order from 0 until an object is
/// removed. O(1).
///
/// Errors: `TRISAP_STATUS_BAD_BOX`, `TRISAP_STATUS_OBJECTS_FULL`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_insert(
    world: *mut trisap_world,
    aabb: *const trisap_aabb,
    id: *mut trisap_id,
) -> trisap_status {
    let insert = |call: &mut Call| {
        border::check(aabb)?;
        border::span(id, 1, &call.range())?;
        // SAFETY: aligned, not null, and initialised by the caller's promise.
        let aabb = unsafe { aabb.read() };
        let new = call.world.insert(Aabb::from(aabb))?;
        // SAFETY: aligned, not null, and outside of the world.
        unsafe { id.write(new.to_bits()) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, insert) }
}

/// Adds an object in a slot that the caller names, so that worlds agree on slots, as those of a server and its clients.
/// O(free slots), and O(slots below) where it is the highest so far.
///
/// Errors: `TRISAP_STATUS_BAD_BOX`, `TRISAP_STATUS_SLOT_TAKEN`, `TRISAP_STATUS_OBJECTS_FULL`. The last one where there is
/// no such slot.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_insert_at(
    world: *mut trisap_world,
    slot: u32,
    aabb: *const trisap_aabb,
    id: *mut trisap_id,
) -> trisap_status {
    let insert = |call: &mut Call| {
        border::check(aabb)?;
        border::span(id, 1, &call.range())?;
        // SAFETY: aligned, not null, and initialised by the caller's promise.
        let aabb = unsafe { aabb.read() };
        let new = call.world.insert_at(slot, Aabb::from(aabb))?;
        // SAFETY: aligned, not null, and outside of the world.
        unsafe { id.write(new.to_bits()) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, insert) }
}

/// Gives an object another box. O(1).
///
/// Errors: `TRISAP_STATUS_STALE_ID`, `TRISAP_STATUS_BAD_BOX`. The object keeps its box then.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_update(
    world: *mut trisap_world,
    id: trisap_id,
    aabb: *const trisap_aabb,
) -> trisap_status {
    let update = |call: &mut Call| {
        border::check(aabb)?;
        // SAFETY: aligned, not null, and initialised by the caller's promise.
        let aabb = unsafe { aabb.read() };
        Ok(call.world.set_aabb(living(id)?, aabb.into())?)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, update) }
}

/// Removes an object. Its id becomes stale, and its pairs are lost at the next step. O(1).
///
/// Errors: `TRISAP_STATUS_STALE_ID`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_remove(world: *mut trisap_world, id: trisap_id) -> trisap_status {
    // SAFETY: the caller's promise.
    unsafe { with(world, |call| Ok(call.world.remove(living(id)?)?)) }
}

/// Sets how far an object may move before it counts as moved, in place of the world's margin. It counts as moved
/// once. O(1).
///
/// Errors: `TRISAP_STATUS_STALE_ID`, `TRISAP_STATUS_NO_MARGINS`, `TRISAP_STATUS_BAD_MARGIN`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_set_margin(
    world: *mut trisap_world,
    id: trisap_id,
    length: f32,
) -> trisap_status {
    // SAFETY: the caller's promise.
    unsafe { with(world, |call| Ok(call.world.set_margin(living(id)?, length)?)) }
}

/// Adds objects, all or none, and writes their ids to `ids`, as many as boxes. O(boxes).
///
/// Errors: `TRISAP_STATUS_BAD_BOX`, `TRISAP_STATUS_OBJECTS_FULL`, `TRISAP_STATUS_INVALID_ARGUMENT`. The last one is
/// about the stride. After the first two the ids are null.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_insert_many(
    world: *mut trisap_world,
    boxes: *const trisap_boxes,
    ids: *mut trisap_id,
) -> trisap_status {
    let insert = |call: &mut Call| {
        // SAFETY: the caller's promise.
        let boxes = unsafe { border::boxes(boxes, &call.range())? };
        // SAFETY: the caller's promise.
        let ids = unsafe { border::new_ids(ids, boxes.len(), &call.range())? };
        let world = &mut call.world;
        for (id, new) in ids.iter_mut().zip(world.insert_many(boxes)?) {
            *id = Some(new);
        }
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, insert) }
}

/// Gives the objects of `ids` other boxes, all or none; as many as boxes. O(boxes).
///
/// Errors: `TRISAP_STATUS_STALE_ID`, `TRISAP_STATUS_BAD_BOX`, `TRISAP_STATUS_INVALID_ARGUMENT`. The last one is about
/// the stride.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_update_many(
    world: *mut trisap_world,
    ids: *const trisap_id,
    boxes: *const trisap_boxes,
) -> trisap_status {
    let update = |call: &mut Call| {
        // SAFETY: the caller's promise.
        let boxes = unsafe { border::boxes(boxes, &call.range())? };
        // SAFETY: the caller's promise.
        let ids = unsafe { border::ids(ids, boxes.len(), &call.range())? };
        Ok(call.world.update_many(ids, boxes)?)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, update) }
}

/// As `trisap_world_update_many`, with ids that stand `stride` bytes behind each other: inside of the caller's own
/// items, as their boxes do. O(boxes).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_update_strided(
    world: *mut trisap_world,
    ids: *const trisap_id,
    stride: usize,
    boxes: *const trisap_boxes,
) -> trisap_status {
    let update = |call: &mut Call| {
        let range = call.range();
        // SAFETY: the caller's promise.
        let boxes = unsafe { border::boxes(boxes, &range)? };
        // SAFETY: the caller's promise.
        let ids = unsafe { Items::new(ids, stride, boxes.len(), &range)? };
        let world = &mut call.world;
        let all = || (0..boxes.len()).filter_map(|at| Some((at, living(ids.get(at)?), boxes.get(at)?)));
        for (at, id, aabb) in all() {
            let id = id?;
            if !world.contains(id) {
                return Err(Error::StaleId { id }.into());
            }
            if !aabb.is_valid() {
                return Err(Error::BadBox { index: at as u32 }.into());
            }
        }
        for (_, id, aabb) in all() {
            world.set_aabb(id?, aabb)?;
        }
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, update) }
}

/// Removes objects, all or none. O(ids).
///
/// Errors: `TRISAP_STATUS_STALE_ID`. It is also the status of an id that comes twice.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_remove_many(
    world: *mut trisap_world,
    ids: *const trisap_id,
    count: usize,
) -> trisap_status {
    let remove = |call: &mut Call| {
        // SAFETY: the caller's promise.
        let ids = unsafe { border::ids(ids, count, &call.range())? };
        Ok(call.world.remove_many(ids)?)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, remove) }
}

/// `TRISAP_STATUS_OK` if `id` names a living object, else `TRISAP_STATUS_STALE_ID`. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_contains(world: *const trisap_world, id: trisap_id) -> trisap_status {
    let mut lives = false;
    let ask = |call: &Call| {
        let world = &call.world;
        lives = Id::from_bits(id).is_some_and(|id| world.contains(id));
        Ok(())
    };
    // SAFETY: the caller's promise.
    match unsafe { look(world, ask) } {
        trisap_status::Ok if !lives => trisap_status::StaleId,
        status => status,
    }
}

/// Writes the box of an object, as it was given last, to `aabb`. O(1).
///
/// Errors: `TRISAP_STATUS_STALE_ID`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_aabb(
    world: *const trisap_world,
    id: trisap_id,
    aabb: *mut trisap_aabb,
) -> trisap_status {
    let ask = |call: &Call| {
        border::span(aabb, 1, &call.range())?;
        let id = living(id)?;
        let known = call.world.aabb(id).ok_or(Error::StaleId { id })?;
        // SAFETY: aligned, not null, and outside of the world.
        unsafe { aabb.write(known.into()) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// Writes the boxes of `count` objects to `aabbs`, as `trisap_world_aabb` does of one. Their ids are `stride` bytes
/// behind each other. After a refusal some may be written. O(n).
///
/// Errors: `TRISAP_STATUS_STALE_ID`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_aabbs(
    world: *const trisap_world,
    ids: *const trisap_id,
    stride: usize,
    count: usize,
    aabbs: *mut trisap_aabb,
) -> trisap_status {
    let ask = |call: &Call| {
        let range = call.range();
        // SAFETY: the caller's promise.
        let ids = unsafe { Items::new(ids, stride, count, &range)? };
        if count > 0 {
            border::span(aabbs, count, &range)?;
        }
        let world = &call.world;
        for at in 0..count {
            let id = living(ids.get(at).unwrap_or_default())?;
            let known = world.aabb(id).ok_or(Error::StaleId { id })?;
            // SAFETY: not null, aligned, within the caller's room and outside of the world.
            unsafe { aabbs.add(at).write(known.into()) };
        }
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// The object that lives in `slot`, or `TRISAP_NULL_ID`, which is also the answer of a busy world and to misuse:
/// `trisap_world_find` tells them apart. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_id_at(world: *const trisap_world, slot: u32) -> trisap_id {
    let mut id = TRISAP_NULL_ID;
    let ask = |call: &Call| {
        id = call.world.id_at(slot).map_or(TRISAP_NULL_ID, Id::to_bits);
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) };
    id
}

/// As `trisap_world_id_at`, written to `id`. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_find(
    world: *const trisap_world,
    slot: u32,
    id: *mut trisap_id,
) -> trisap_status {
    let ask = |call: &Call| {
        border::span(id, 1, &call.range())?;
        let found = call.world.id_at(slot).map_or(TRISAP_NULL_ID, Id::to_bits);
        // SAFETY: aligned, not null, and outside of the world.
        unsafe { id.write(found) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// Living objects, written to `count`. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_count(world: *const trisap_world, count: *mut u32) -> trisap_status {
    let ask = |call: &Call| {
        border::span(count, 1, &call.range())?;
        let len = call.world.len();
        // SAFETY: aligned, not null, and outside of the world.
        unsafe { count.write(len) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// 1 if floats are too coarse for some box at its place: a side is shorter than four steps of its coordinate. A box
/// without any side counts only if the world has not even steps enough to tell such boxes apart. The pairs are right for
/// the boxes as given, but the boxes may have lost their shape before; shift the origin. 0 also of a busy world and for
/// misuse. O(slots that have been in use): ask now and then.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_is_coarse(world: *const trisap_world) -> u32 {
    let mut coarse = 0;
    let ask = |call: &Call| {
        coarse = u32::from(call.world.is_coarse());
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) };
    coarse
}

/// Living objects; 0 also of a busy world and for misuse, which `trisap_world_count` tells apart. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_len(world: *const trisap_world) -> u32 {
    let mut len = 0;
    let ask = |call: &Call| {
        len = call.world.len();
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) };
    len
}
