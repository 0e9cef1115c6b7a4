//! The job hook: how a step asks the caller for threads.

use core::cell::Cell;

/// A job system, as far as a step needs one.
///
/// A step has a few stages, one after another, that can be shared. For each it makes a *job* on its own stack
/// and lends it to [`fork_join`](Self::fork_join). Each call of the job takes blocks of work, one by one,
/// until none is left, and returns. A call that comes later returns at once. After `fork_join` the step calls
/// the job once more itself, so nothing remains undone whatever the executor did.
///
/// # What an executor may do
/// The result is the same, byte for byte, if the executor
/// - makes `width` calls (what it should do), fewer, more, or none;
/// - makes them at once, one after another, in any order, on any threads, also the calling one, which is idle
///   until `fork_join` returns: a good executor has it make one of the calls, or run other tasks;
/// - makes a call late, when others have done all of the work, as long as that is before `fork_join` returns;
/// - calls the job inside a task that it runs while it waits for something else, on a stack however deep.
///
/// # What it must do
/// - **Complete:** `fork_join` returns only when every call of the job that has begun or may begin has returned.
///   That is the only sign of completion; the job's memory is gone afterwards. The borrow checker sees to it;
///   where a lifetime is lengthened for a long-lived thread, and behind a C interface, the executor has
///   to.
/// - **Order memory:** all that the caller did before `fork_join` *happens before* every call, and every call
///   before the return of `fork_join`. Starting and joining threads, mutexes, channels, and release stores
///   that acquire loads read do that; relaxed counters do not. The job adds no ordering: its blocks are
///   claimed with relaxed atomics.
///
/// # What it can rely on
/// A call never blocks, waits, locks, allocates, calls back into the executor or starts another job, panics only
/// if a rule does, and needs less than 16 KiB of stack. A step never has two jobs at once.
///
/// A step has some ten jobs, each of microseconds to milliseconds, and waits for the last call of each. So
/// beside other busy threads an executor that spins and waits can make a step several times slower than one
/// thread. `trisap::Offer` says how it never does, and has the hardest part.
///
/// If a call of the job unwinds, `fork_join` has to unwind, too, once all others have returned, as the blocks of
/// that call are not done. If a call of the executor unwinds, so does the step: see
/// [`World::step`](crate::World::step). A panic in [`Stage::Done`] comes after it. Targets without 32-bit
/// atomic exchange (`thumbv6m`) and WebAssembly without the feature `atomics`, which has no threads, never call
/// `fork_join`: steps are serial there.
///
/// ```
/// /// Runs jobs on freshly started threads and on the calling one.
/// struct Threads(u32);
///
/// impl trisap_core::Executor for Threads {
///     fn workers(&self) -> u32 {
///         self.0
///     }
///     fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
///         std::thread::scope(|scope| {
///             (1..width).for_each(|_| drop(scope.spawn(job)));
///             job();
///         });
///     }
/// }
/// ```
#[doc(alias("pool", "job_system", "thread_pool", "task_scheduler"))]
pub trait Executor {
    /// How many calls of a job can run at once, the calling thread's own included if it makes one. A hint:
    /// below 2 nothing is shared. The answer may change from call to call.
    fn workers(&self) -> u32;

    /// Calls `job` `width` times, at the same time if possible, and returns when all calls have returned.
    ///
    /// `width` is at least 2, and at most [`workers`](Self::workers) and the number of blocks of work; in a step
    /// also at most [`Config::workers`](crate::Config::workers), else 32. The trait says what else an executor may do.
    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync));

    /// Called on the calling thread when a step enters a stage; [`Stage::Done`] ends the step. For profilers,
    /// and for executors that compare the times of steps. An executor that wraps another passes it on.
    fn enter(&self, _stage: Stage) {}
}

/// The stages of a step, in order. Which ones a step enters depends on its [`Path`](crate::Path). It enters
/// each at most once, and always the last one, also if it ends with an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Stage {
    /// Takes in the caller's boxes.
    Intake,
    /// Makes planes, for all leaves or for leaves that are out of balance, or sorts the lists.
    Build,
    /// Brings the boxes of moved objects to their leaves.
    Fill,
    /// Finds the overlaps.
    Sweep,
    /// Sorts out the result and the events.
    Results,
    /// The step is done.
    Done,
}

impl Stage {
    /// All stages, in order.
    pub const ALL: [Self; 6] =
        [Self::Intake, Self::Build, Self::Fill, Self::Sweep, Self::Results, Self::Done];
}

impl<E: Executor + ?Sized> Executor for &E {
    fn workers(&self) -> u32 {
        (**self).workers()
    }
    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        (**self).fork_join(width, job);
    }
    fn enter(&self, stage: Stage) {
        (**self).enter(stage);
    }
}

/// Everything on the calling thread.
#[derive(Clone, Copy, Debug, Default)]
pub struct Serial;

impl Executor for Serial {
    fn workers(&self) -> u32 {
        1
    }
    fn fork_join(&self, _width: u32, _job: &(dyn Fn() + Sync)) {}
}

/// The executor of one step. It enters each stage once, in order, and gets work only if the step is shared.
pub(crate) struct OneStep<'e> {
    executor: &'e dyn Executor,
    shares: bool,
    entered: Cell<Option<Stage>>,
}

impl<'e> OneStep<'e> {
    pub(crate) const fn new(executor: &'e dyn Executor, shares: bool) -> Self {
        Self { executor, shares, entered: Cell::new(None) }
    }
}

impl Executor for OneStep<'_> {
    fn workers(&self) -> u32 {
        if self.shares { self.executor.workers() } else { 1 }
    }
    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        self.executor.fork_join(width, job);
    }
    /// A step may find that it has to do more, and go back. That is part of the stage that it had reached.
    fn enter(&self, stage: Stage) {
        if self.entered.get() < Some(stage) {
            self.entered.set(Some(stage));
            self.executor.enter(stage);
        }
    }
}

/// Whether a job can have two calls at once. A claim needs atomic addition, and WebAssembly has threads only
/// where it has atomics: a module for the web is loaded over a network, and needs no code for them.
pub(crate) const THREADS: bool =
    cfg!(all(target_has_atomic = "32", any(not(target_family = "wasm"), target_feature = "atomics")));

/// Runs `job` to its end. Other threads help if the executor, the areas of scratch memory and the blocks of
/// work allow it.
pub(crate) fn run(executor: &dyn Executor, scratches: usize, blocks: usize, job: &(dyn Fn() + Sync)) {
    let width = (executor.workers() as usize).min(scratches).min(blocks);
    if THREADS && width > 1 {
        executor.fork_join(width as u32, job);
    }
    job();
}
