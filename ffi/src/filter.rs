//! Whom an object meets.

use crate::aabb::trisap_aabb;
use crate::border;
use crate::border::living;
use crate::call::{Call, look, trisap_world, with};
use crate::status::{Refusal, trisap_status};
use crate::structs::trisap_id;
use trisap_core::{Error, Filter, Object};

/// Whom an object meets. Two objects make a pair if each one's mask has a group of the other, and their classes meet
/// (see `trisap_world_set_classes`). Filled by `trisap_default_filter`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct trisap_filter {
    /// The groups that the object is in, one bit each. By default all.
    pub group: u32,
    /// The groups that it meets. By default all.
    pub mask: u32,
    /// Its class, below 32: static, kinematic, dynamic or sensor, for instance. By default 0.
    pub object_class: u32,
}

impl From<trisap_filter> for Filter {
    fn from(filter: trisap_filter) -> Self {
        Self { group: filter.group, mask: filter.mask, class: filter.object_class }
    }
}

impl From<Filter> for trisap_filter {
    fn from(filter: Filter) -> Self {
        Self { group: filter.group, mask: filter.mask, object_class: filter.class }
    }
}

/// The filter of a new object: in all groups, meets all groups, class 0. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn trisap_default_filter() -> trisap_filter {
    Filter::ALL.into()
}

/// Adds an object with its filter, its value and its margin, each of which may be null, and writes its id to `id`. O(1).
///
/// Errors: those of `trisap_world_insert`; with a filter `TRISAP_STATUS_NO_FILTERS` and `TRISAP_STATUS_BAD_CLASS`, with
/// a value `TRISAP_STATUS_NO_VALUES`, with a margin `TRISAP_STATUS_NO_MARGINS` and `TRISAP_STATUS_BAD_MARGIN`. There is
/// no new object then.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_insert_with(
    world: *mut trisap_world,
    aabb: *const trisap_aabb,
    filter: *const trisap_filter,
    value: *const u64,
    margin: *const f32,
    id: *mut trisap_id,
) -> trisap_status {
    let insert = |call: &mut Call| {
        border::check(aabb)?;
        border::span(id, 1, &call.range())?;
        // SAFETY: aligned, not null, and initialised by the caller's promise.
        let mut object = Object::new(unsafe { aabb.read() }.into());
        (object.filter, object.value, object.margin) = unsafe {
            // SAFETY: the caller's promise: null, or one of each.
            (border::optional(filter)?.map(Filter::from), border::optional(value)?, border::optional(margin)?)
        };
        let new = call.world.insert(object)?;
        // SAFETY: aligned, not null, and outside of the world.
        unsafe { id.write(new.to_bits()) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, insert) }
}

/// Sets whom an object meets. Its pairs follow at the next step. O(1).
///
/// Errors: `TRISAP_STATUS_STALE_ID`, `TRISAP_STATUS_NO_FILTERS`, `TRISAP_STATUS_BAD_CLASS`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_set_filter(
    world: *mut trisap_world,
    id: trisap_id,
    filter: *const trisap_filter,
) -> trisap_status {
    let set = |call: &mut Call| {
        border::check(filter)?;
        // SAFETY: aligned, not null, and initialised by the caller's promise.
        let filter = unsafe { filter.read() };
        Ok(call.world.set_filter(living(id)?, filter.into())?)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, set) }
}

/// Sets whom objects meet, all or none: the filter of `ids[i]` begins `i * stride` bytes behind that of `ids[0]`. With
/// a stride of 0 all get the same one. O(ids).
///
/// Errors: `TRISAP_STATUS_STALE_ID`, `TRISAP_STATUS_NO_FILTERS`, `TRISAP_STATUS_BAD_CLASS`,
/// `TRISAP_STATUS_INVALID_ARGUMENT`. The last one is about a stride that is not 0 and shorter than a filter.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_set_filter_many(
    world: *mut trisap_world,
    ids: *const trisap_id,
    filters: *const trisap_filter,
    stride: usize,
    count: usize,
) -> trisap_status {
    let set = |call: &mut Call| {
        let range = call.range();
        // SAFETY: the caller's promise.
        let (ids, filters) = unsafe {
            (border::ids(ids, count, &range)?, border::Items::new(filters, stride, count, &range)?)
        };
        let world = &mut call.world;
        let filters = || ids.iter().enumerate().filter_map(|(at, id)| Some((*id, filters.get(at)?)));
        // Everything that the core would refuse is found before anything is done.
        for (id, filter) in filters() {
            if !world.contains(id) {
                return Err(Error::StaleId { id }.into());
            }
            if filter.object_class >= CLASSES {
                return Err(Error::BadClass { class: filter.object_class }.into());
            }
        }
        for (id, filter) in filters() {
            world.set_filter(id, filter.into())?;
        }
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, set) }
}

/// Writes whom an object meets to `filter`. O(1).
///
/// Errors: `TRISAP_STATUS_STALE_ID`, `TRISAP_STATUS_NO_FILTERS`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_filter(
    world: *const trisap_world,
    id: trisap_id,
    filter: *mut trisap_filter,
) -> trisap_status {
    let ask = |call: &Call| {
        border::span(filter, 1, &call.range())?;
        let id = living(id)?;
        let world = &call.world;
        let refusal = if world.contains(id) { Error::NoFilters } else { Error::StaleId { id } };
        let known = world.filter(id).ok_or(refusal)?;
        // SAFETY: aligned, not null, and outside of the world.
        unsafe { filter.write(known.into()) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// The classes that there can be.
pub const TRISAP_CLASSES: u32 = 32;
const CLASSES: u32 = TRISAP_CLASSES;

/// Sets which classes meet, by `TRISAP_CLASSES` numbers. Two classes `a` and `b` meet if bit `b` of `meets[a]` and
/// bit `a` of `meets[b]` are set. At first all classes meet. The next step looks for all pairs anew. O(n).
///
/// Errors: `TRISAP_STATUS_NO_FILTERS`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_set_classes(
    world: *mut trisap_world,
    meets: *const u32,
) -> trisap_status {
    let set = |call: &mut Call| {
        let meets = meets.cast::<[u32; CLASSES as usize]>();
        border::span(meets, 1, &call.range())?;
        // SAFETY: aligned, not null, and by the caller's promise as many as there are classes.
        let meets = unsafe { meets.read() };
        Ok(call.world.set_classes(&meets)?)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, set) }
}

/// Makes the next step ask about all pairs of an object again, after a `trisap_rule` has changed its answer. O(1).
///
/// Errors: `TRISAP_STATUS_STALE_ID`, `TRISAP_STATUS_NO_FILTERS`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_refilter(world: *mut trisap_world, id: trisap_id) -> trisap_status {
    // SAFETY: the caller's promise.
    unsafe { with(world, |call| Ok::<(), Refusal>(call.world.refilter(living(id)?)?)) }
}

// The header asserts the same on the other side of the border.
const _: () = assert!(size_of::<trisap_filter>() == 12);
