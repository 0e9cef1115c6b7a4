//! Finds what is in parts of space of the caller's own: between planes, or where a callback says.

use crate::aabb::trisap_aabb;
use crate::among::{accepts, trisap_condition};
use crate::border::{self, Answers};
use crate::call::{Call, look, trisap_world};
use crate::query::{collect_ids, trisap_visit_id, visitor};
use crate::status::trisap_status;
use crate::structs::trisap_id;
use core::ffi::c_void;
use trisap_core::{Planes, Side, Volume};

/// Writes the objects whose boxes are on the inner side of all of `plane_count` planes, or touch it, to `ids`, which has room for `room`
/// of them, by ascending slot, and their number to `count`: what is in a frustum, for instance. A plane is four numbers: a normal that
/// points outward, and its distance along that. A box is outside if it is wholly beyond one plane, so that near edges and corners some
/// boxes that are not quite inside count. Expected O(objects at the border + answers + movers since the last step).
///
/// Errors: `TRISAP_STATUS_OUTPUT_FULL`. The number is right then, and `ids` holds some of them.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_within(
    world: *const trisap_world,
    planes: *const f64,
    plane_count: usize,
    condition: trisap_condition,
    user: *mut c_void,
    ids: *mut trisap_id,
    room: usize,
    count: *mut usize,
) -> trisap_status {
    let ask = |call: &Call| {
        let planes = if plane_count == 0 {
            &[]
        } else {
            let planes = planes.cast::<[f64; 4]>();
            border::span(planes, plane_count, &call.range())?;
            // SAFETY: not null, aligned, no longer than a slice may be, and initialised by the caller's promise.
            unsafe { core::slice::from_raw_parts(planes, plane_count) }
        };
        // SAFETY: the caller's promise.
        let answers = unsafe { Answers::new(ids, room, count, &call.range())? };
        let world = &call.world;
        collect_ids(answers, accepts(condition, user), |visit| {
            world.visit_within(&Planes(planes), visit);
            Ok(())
        })
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}

/// How a box lies to a part of space of the caller's own: less than 0 if it is outside, and so is each box inside it; more than 0 if it
/// is inside, and so is each box inside it; 0 if neither is certain: then it counts as touching. Asked about boxes of objects, and
/// about boxes around many. Calls that change the same world are refused as busy.
pub type trisap_side = Option<unsafe extern "C" fn(user: *mut c_void, aabb: *const trisap_aabb) -> i32>;

/// As a volume of the core.
struct Sides {
    side: unsafe extern "C" fn(user: *mut c_void, aabb: *const trisap_aabb) -> i32,
    user: *mut c_void,
}

impl Volume for Sides {
    fn side(&self, aabb: &trisap_core::Aabb) -> Side {
        let aabb = trisap_aabb { min: aabb.min, max: aabb.max };
        // SAFETY: called as its contract says.
        match unsafe { (self.side)(self.user, &aabb) } {
            0 => Side::Across,
            1.. => Side::Inside,
            _ => Side::Outside,
        }
    }
}

/// Visits the objects whose boxes are inside a part of space of the caller's own or across its border, each once, until the visitor
/// ends it: a capsule, an oriented box. `side_user` is passed to `side`, `user` to the visitor. Objects in nodes that are inside or
/// outside are not asked about. Expected as `trisap_world_within`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_visit_within(
    world: *const trisap_world,
    side: trisap_side,
    side_user: *mut c_void,
    visit: trisap_visit_id,
    user: *mut c_void,
) -> trisap_status {
    let ask = |call: &Call| {
        let mut visit = visitor(visit, user)?;
        let sides = Sides { side: side.ok_or(trisap_status::NullPointer)?, user: side_user };
        call.world.visit_within(&sides, &mut visit);
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) }
}
