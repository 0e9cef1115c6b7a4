//! Which objects may answer a query.

use crate::border;
use crate::border::living;
use crate::call::{Call, look, trisap_world};
use crate::filter::trisap_filter;
use crate::structs::trisap_id;
use core::ffi::c_void;
use trisap_core::Id;

/// Which objects may answer a query; null stands for all. Called with an object that the query has found, and with
/// the query's `user`; returns not 0 if the object may answer. It has to say the same of the same object. It may look
/// at the world, for instance by `trisap_world_meets`; calls that change it are refused as busy. Batches with a job
/// system call it from several threads at once.
pub type trisap_condition = Option<unsafe extern "C" fn(user: *mut c_void, id: trisap_id) -> u32>;

/// 1 if an object meets whatever has this filter, by groups and classes, else 0; 0 for misuse and stale ids. In a
/// world without filters objects are in all groups and meet all. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_meets(
    world: *const trisap_world,
    id: trisap_id,
    filter: *const trisap_filter,
) -> u32 {
    let mut meets = 0;
    let ask = |call: &Call| {
        border::check(filter)?;
        // SAFETY: aligned, not null, and initialised by the caller's promise.
        let filter = unsafe { filter.read() };
        meets = u32::from(call.world.meets(living(id)?, &filter.into()));
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { look(world, ask) };
    meets
}

/// A condition in the core's form.
pub(crate) fn accepts(condition: trisap_condition, user: *mut c_void) -> impl Fn(Id) -> bool + Sync {
    let choice = Choice { condition, user };
    move |id| choice.accepts(id)
}

/// A condition, and what it is called with.
struct Choice {
    condition: trisap_condition,
    user: *mut c_void,
}

// SAFETY: a condition is made to be called by several threads at once.
unsafe impl Sync for Choice {}

impl Choice {
    fn accepts(&self, id: Id) -> bool {
        // SAFETY: called as its contract says.
        self.condition.is_none_or(|condition| unsafe { condition(self.user, id.to_bits()) != 0 })
    }
}
