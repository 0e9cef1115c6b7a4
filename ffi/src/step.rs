//! Steps and their results.

use crate::border;
use crate::status::{Refusal, trisap_status};
use crate::structs::{TRISAP_NULL_ID, trisap_boxes, trisap_jobs, trisap_result};
use crate::world::{Call, trisap_world, with};
use core::ffi::{c_char, c_void};
use trisap_core::{Error, Executor, Id, Kernels, Rejected, World};

/// Finds all overlapping pairs of the boxes as they are now, and writes them to `result`. `jobs` may be null: then
/// everything happens on the calling thread.
///
/// Expected O(n + pairs) where objects move, O(movers + pairs) where few do.
///
/// After `TRISAP_STATUS_PAIRS_FULL` the result is filled, too.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_world_step(
    world: *mut trisap_world,
    jobs: *const trisap_jobs,
    result: *mut trisap_result,
) -> trisap_status {
    let step = |call: &mut Call| {
        // SAFETY: the caller's promise.
        let (executor, result) = unsafe { (executor(jobs)?, output(result, call)?) };
        let outcome = call.world()?.step(Kernels::detect(), &executor).map(|step| step.rejected());
        conclude(call, outcome, result)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, step) }
}

/// As `trisap_world_step`, after giving every object the box that stands at its slot in `boxes`, the caller's own array:
/// one pass over it, no copy, no ids. The fastest way where most objects move.
///
/// What stands at the slots of no object does not matter; objects beyond the end of the boxes keep theirs, and so do
/// those whose new box is refused: see `trisap_result::rejected_count`.
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
        let (executor, result) = unsafe { (executor(jobs)?, output(result, call)?) };
        let outcome =
            call.world()?.step_over(boxes, Kernels::detect(), &executor).map(|step| step.rejected());
        conclude(call, outcome, result)
    };
    // SAFETY: the caller's promise.
    unsafe { with(world, step) }
}

/// Writes the result of the last step to `result` once more: after `trisap_world_open`, for instance. `rejected_count` is
/// zero.
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
    let (rejected, needed) = match outcome {
        Ok(rejected) => (rejected, None),
        Err(Error::PairsFull { needed }) => (None, Some(needed)),
        Err(error) => return Err(error.into()),
    };
    let slab = call.slab();
    let told = tell(slab, &call.world()?, rejected, needed);
    // SAFETY: `output` has checked the pointer.
    unsafe { result.0.write(told) };
    match needed {
        Some(needed) => Err(Error::PairsFull { needed }.into()),
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

/// The caller's job system as an executor.
enum Workers {
    Calling,
    Hook { user: *mut c_void, workers: u32, fork_join: ForkJoin },
}

type Run = unsafe extern "C" fn(task: *mut c_void);
type ForkJoin = unsafe extern "C" fn(*mut c_void, Option<Run>, *mut c_void, u32, *const c_char);

/// # Safety
/// A pointer that is not null points to a struct that begins with its size, and whose callback keeps its contract.
unsafe fn executor(jobs: *const trisap_jobs) -> Result<Workers, trisap_status> {
    if jobs.is_null() {
        return Ok(Workers::Calling);
    }
    // SAFETY: the same promise.
    let jobs = unsafe { border::read(jobs)? };
    match (jobs.worker_count, jobs.fork_join) {
        (0, _) => Err(trisap_status::InvalidArgument),
        (1, _) => Ok(Workers::Calling),
        (_, None) => Err(trisap_status::NullPointer),
        (workers, Some(fork_join)) => Ok(Workers::Hook { user: jobs.user, workers, fork_join }),
    }
}

impl Executor for Workers {
    fn workers(&self) -> u32 {
        match self {
            Self::Calling => 1,
            Self::Hook { workers, .. } => *workers,
        }
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        if let Self::Hook { user, fork_join, .. } = self {
            // A reference to a trait object is two pointers, and a task is one.
            let task = (&raw const job).cast_mut().cast::<c_void>();
            // SAFETY: the callback is called as its contract says, and by that contract every call of `run` has
            // returned when it returns, while `job` is still there.
            unsafe { fork_join(*user, Some(run), task, width, c"trisap step".as_ptr()) };
        }
    }
}

unsafe extern "C" fn run(task: *mut c_void) {
    if task.is_null() {
        return;
    }
    // SAFETY: the callback hands on the task that `fork_join` gave it, which is a job that lives until it returns; jobs
    // are made to be called by several threads at once.
    let job = unsafe { *task.cast::<&(dyn Fn() + Sync)>() };
    job();
}
