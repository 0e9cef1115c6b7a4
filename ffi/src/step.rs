//! Steps and their results.

use crate::border;
use crate::call::{Call, trisap_world, with};
use crate::jobs::executor;
use crate::status::{Refusal, trisap_status};
use crate::structs::{TRISAP_NULL_ID, trisap_boxes, trisap_jobs, trisap_result};
use core::ffi::{CStr, c_void};
use trisap_core::{Error, Id, Rejected, World};

const NAME: &CStr = c"trisap step";

/// An empty result. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn trisap_default_result() -> trisap_result {
    let none = core::ptr::null();
    trisap_result {
        struct_size: size_of::<trisap_result>() as u32,
        rejected_count: 0,
        first_rejected: TRISAP_NULL_ID,
        pairs: none,
        pair_count: 0,
        found: none,
        found_count: 0,
        lost: none,
        lost_count: 0,
        pairs_needed: 0,
    }
}

/// Finds all overlapping pairs of the boxes as they are now, and writes them to `result`. `jobs` may be null: then
/// everything happens on the calling thread. Expected O(n + pairs) where objects move, O(movers + pairs) where few do.
///
/// Errors: `TRISAP_STATUS_PAIRS_FULL`, `TRISAP_STATUS_INVALID_ARGUMENT`. After the first one the step has happened, and
/// the result is filled, too. The second one is about a `worker_count` of 0.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_step(
    world: *mut trisap_world,
    jobs: *const trisap_jobs,
    result: *mut trisap_result,
) -> trisap_status {
    let step = |call: &mut Call| {
        // SAFETY: the caller's promise.
        let (executor, result) = unsafe { (executor(jobs, NAME)?, output(result, call)?) };
        let outcome = call.world.on(&executor).step().map(|step| step.rejected());
        conclude(call, outcome, result)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, step) }
}

/// As `trisap_world_step`, after giving every object the box at its slot in `boxes`, the caller's own array: one
/// pass, no copy, no ids. The fastest way if most objects move.
///
/// Boxes at slots without an object do not matter. Objects beyond the end of the boxes keep theirs, and so do those
/// whose new box is refused: see `trisap_result::rejected_count`.
///
/// Errors: those of `trisap_world_step`; `TRISAP_STATUS_INVALID_ARGUMENT` also for a stride or an offset that boxes
/// cannot have.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_step_over(
    world: *mut trisap_world,
    boxes: *const trisap_boxes,
    jobs: *const trisap_jobs,
    result: *mut trisap_result,
) -> trisap_status {
    let step = |call: &mut Call| {
        // SAFETY: the caller's promise.
        let boxes = unsafe { border::boxes(boxes, &call.range())? };
        // SAFETY: the caller's promise.
        let (executor, result) = unsafe { (executor(jobs, NAME)?, output(result, call)?) };
        let outcome = call.world.on(&executor).step_over(boxes).map(|step| step.rejected());
        conclude(call, outcome, result)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, step) }
}

/// Brings the tree up to date for queries, without a look for pairs: a world that is only asked needs no step, and `config.pairs`
/// can be 0. The pairs and events of the last step stay, and the next one has those that it would have had. Without this, queries
/// look one by one at the objects that have changed since the last step, and at all before the first. Does nothing in worlds
/// without a tree. `jobs` may be null. O(objects that have changed), or O(n) where these are many.
///
/// Errors: `TRISAP_STATUS_INVALID_ARGUMENT` for a `worker_count` of 0.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_refresh(
    world: *mut trisap_world,
    jobs: *const trisap_jobs,
) -> trisap_status {
    let refresh = |call: &mut Call| {
        // SAFETY: the caller's promise.
        let executor = unsafe { executor(jobs, NAME)? };
        Ok(call.world.on(&executor).refresh()?)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, refresh) }
}

/// A rule of the caller: returns not 0 if the objects in two slots, the lower one first, make a pair.
///
/// Called from any worker at any time during the step, from several at once, and only for boxes that overlap with what is
/// around them (margins, predicted boxes) and that the filters let through. Has to answer the same until one of the
/// objects is given to `trisap_world_refilter`, since pairs of resting objects are not asked about again. Must not call
/// into the same world, which is refused as busy.
pub type trisap_rule = Option<unsafe extern "C" fn(user: *mut c_void, a: u32, b: u32) -> u32>;

/// As `trisap_world_step_over`, or if `boxes` is null as `trisap_world_step`, with a rule that decides the pairs that
/// the filters let through; `user` is passed to it. If a world has a rule in one step, it should have the same in
/// all.
///
/// Errors: those of `trisap_world_step_over`, and `TRISAP_STATUS_NO_FILTERS`.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_step_with_rule(
    world: *mut trisap_world,
    boxes: *const trisap_boxes,
    rule: trisap_rule,
    user: *mut c_void,
    jobs: *const trisap_jobs,
    result: *mut trisap_result,
) -> trisap_status {
    let step = |call: &mut Call| {
        let rule = Judge { rule: rule.ok_or(trisap_status::NullPointer)?, user };
        let boxes = if boxes.is_null() {
            None
        } else {
            // SAFETY: the caller's promise.
            Some(unsafe { border::boxes(boxes, &call.range())? })
        };
        // SAFETY: the caller's promise.
        let (executor, result) = unsafe { (executor(jobs, NAME)?, output(result, call)?) };
        let rule = |a: u32, b: u32| rule.meet(a, b);
        let world = &mut call.world;
        let stepper = world.on(&executor).with_rule(&rule);
        let outcome = match boxes {
            Some(boxes) => stepper.step_over(boxes),
            None => stepper.step(),
        };
        let outcome = outcome.map(|step| step.rejected());
        conclude(call, outcome, result)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, step) }
}

/// A rule, and what it is called with.
struct Judge {
    rule: unsafe extern "C" fn(*mut c_void, u32, u32) -> u32,
    user: *mut c_void,
}

// SAFETY: a rule is made to be called by several threads at once.
unsafe impl Sync for Judge {}

impl Judge {
    fn meet(&self, a: u32, b: u32) -> bool {
        // SAFETY: called as its contract says, within the step that it was given to.
        unsafe { (self.rule)(self.user, a, b) != 0 }
    }
}

/// Writes the result of the last step to `result` once more: after `trisap_world_open` or `trisap_world_load`, for
/// instance. `rejected_count` is zero. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_result(
    world: *mut trisap_world,
    result: *mut trisap_result,
) -> trisap_status {
    let ask = |call: &mut Call| {
        // SAFETY: the caller's promise.
        let result = unsafe { output(result, call)? };
        conclude(call, Ok(None), result)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, ask) }
}

/// Puts the result of the last step into an order of its own, and writes it to `result`: the pairs that the complete step
/// before had in ascending order, behind them the found ones in ascending order; the lost ones ascend, too. So worlds
/// with the same objects in the same slots give the same bytes, whatever their room, their workers and their past are.
/// After `TRISAP_STATUS_PAIRS_FULL` nothing is sorted. O(pairs log pairs), in place; the next step with
/// few movers looks at all pairs once more.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_sort_results(
    world: *mut trisap_world,
    result: *mut trisap_result,
) -> trisap_status {
    let sort = |call: &mut Call| {
        // SAFETY: the caller's promise.
        let result = unsafe { output(result, call)? };
        call.world.sort_results();
        conclude(call, Ok(None), result)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, sort) }
}

/// A result that can be written to.
struct Output(*mut trisap_result);

/// # Safety
/// A pointer that is not null points to a struct that begins with its size.
unsafe fn output(result: *mut trisap_result, call: &Call) -> Result<Output, trisap_status> {
    // SAFETY: the same promise.
    unsafe { border::check_versioned(result)? };
    border::span(result, 1, &call.range())?;
    Ok(Output(result))
}

/// Writes the result, if the step has happened.
fn conclude(
    call: &mut Call,
    outcome: Result<Option<Rejected>, Error>,
    result: Output,
) -> Result<(), Refusal> {
    let (rejected, full) = match outcome {
        Ok(rejected) => (rejected, None),
        Err(Error::PairsFull { needed, room }) => (None, Some((needed, room))),
        Err(error) => return Err(error.into()),
    };
    let slab = call.slab();
    let told = tell(slab, &call.world, rejected, full.map(|(needed, _)| needed));
    // SAFETY: `output` has checked the pointer.
    unsafe { result.0.write(told) };
    match full {
        Some((needed, room)) => Err(Error::PairsFull { needed, room }.into()),
        None => Ok(()),
    }
}

fn tell(
    slab: *const c_void,
    world: &World<'_>,
    rejected: Option<Rejected>,
    needed: Option<u64>,
) -> trisap_result {
    let (pairs, pair_count) = border::lend(slab, world.pairs());
    let (found, found_count) = border::lend(slab, world.found());
    let (lost, lost_count) = border::lend(slab, world.lost());
    trisap_result {
        struct_size: size_of::<trisap_result>() as u32,
        rejected_count: rejected.map_or(0, |rejected| rejected.count),
        first_rejected: rejected.map(|rejected| rejected.first).map_or(TRISAP_NULL_ID, Id::to_bits),
        pairs,
        pair_count,
        found,
        found_count,
        lost,
        lost_count,
        pairs_needed: needed.unwrap_or(pair_count as u64),
    }
}
