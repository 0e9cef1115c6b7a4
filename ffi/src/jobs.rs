//! The caller's job system.

use crate::border;
use crate::status::trisap_status;
use crate::structs::trisap_jobs;
use core::ffi::{CStr, c_char, c_void};
use trisap_core::Executor;

/// A job system of one worker, to be filled in. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn trisap_default_jobs() -> trisap_jobs {
    trisap_jobs {
        struct_size: size_of::<trisap_jobs>() as u32,
        worker_count: 1,
        user: core::ptr::null_mut(),
        fork_join: None,
    }
}

/// The caller's job system as an executor.
pub(crate) enum Workers {
    Calling,
    Hook { user: *mut c_void, workers: u32, fork_join: ForkJoin, name: &'static CStr },
}

pub(crate) type Run = unsafe extern "C" fn(task: *mut c_void);
pub(crate) type ForkJoin = unsafe extern "C" fn(*mut c_void, Option<Run>, *mut c_void, u32, *const c_char);

/// The executor; `name` is for the caller's profiler.
///
/// # Safety
/// A pointer that is not null points to a struct that begins with its size, and whose callback keeps its contract.
pub(crate) unsafe fn executor(
    jobs: *const trisap_jobs,
    name: &'static CStr,
) -> Result<Workers, trisap_status> {
    if jobs.is_null() {
        return Ok(Workers::Calling);
    }
    // SAFETY: the same promise.
    let jobs = unsafe { border::read(jobs)? };
    match (jobs.worker_count, jobs.fork_join) {
        (0, _) => Err(trisap_status::InvalidArgument),
        (1, _) => Ok(Workers::Calling),
        (_, None) => Err(trisap_status::NullPointer),
        (workers, Some(fork_join)) => Ok(Workers::Hook { user: jobs.user, workers, fork_join, name }),
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
        if let Self::Hook { user, fork_join, name, .. } = self {
            // A reference to a trait object is two pointers, and a task is one.
            let task = (&raw const job).cast_mut().cast::<c_void>();
            // SAFETY: the callback is called as its contract says, and by that contract every call of `run` has
            // returned when it returns, while `job` is still there.
            unsafe { fork_join(*user, Some(run), task, width, name.as_ptr()) };
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
