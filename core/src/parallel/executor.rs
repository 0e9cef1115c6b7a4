//! The job hook: how a step asks the caller for threads.

use core::cell::Cell;

/// A job system, as far as a step needs one.
///
/// A step has a few stages, one after another, that can be shared. For each it makes a *job* on its own stack and
/// lends it to [`fork_join`](Self::fork_join). Every call of the job takes blocks of work, one by one, until none is
/// left, and then returns; a call that comes when nothing is left returns at once. When `fork_join` is back, the step
/// calls the job once more itself, so that nothing remains undone whatever the executor did.
///
/// # What an executor may do
/// The result is the same, byte for byte, if the executor
/// - makes `width` calls (what it should do), fewer, more, or none;
/// - makes them at the same time, one after another, in any order, on any threads, the calling thread included: it is
///   idle until `fork_join` returns, so a good executor has it make one of the calls, or run other tasks;
/// - makes a call late, when others have done all of the work, as long as that is before `fork_join` returns;
/// - calls the job from inside a task that it runs while it waits for something else, on a stack however deep.
///
/// # What it must do
/// - **Complete:** `fork_join` returns only when every call of the job that has begun or may still begin has returned.
///   That is the only sign of completion, and the job's memory is gone afterwards. The borrow checker sees to it;
///   where a lifetime is lengthened to hand the job to a long-lived thread, and behind a C interface, the executor has
///   to.
/// - **Order memory:** all that the calling thread did before `fork_join` *happens before* every call, and every call
///   happens before the return of `fork_join`. Starting and joining threads, mutexes, channels, and release stores
///   that acquire loads read all do that; relaxed counters do not. The job itself adds no ordering: its blocks are
///   claimed with relaxed atomics.
///
/// # What it can rely on
/// A call never blocks, waits, locks, allocates, panics, calls back into the executor or starts another job, and needs
/// less than 16 KiB of stack. A step never has two jobs at once.
///
/// # When others want the processors
/// A step has some ten jobs, each of microseconds to milliseconds, and waits for the last call of each. Beside busy threads of
/// the same program or of others, an executor that spins and waits can make a step several times slower than one thread.
/// It never does if it follows these rules, and keeps its gain where processors are free:
/// - **Wait only for calls that have begun.** When the caller's own call has returned, no work is left to begin: take the
///   other calls back. A thread that sleeps or has not been let run then costs nothing. [`Offer`](crate::Offer) does that.
/// - **Spin for microseconds only,** in the caller that waits for a call and in a thread that waits for the next job. Then
///   let others run (`yield_now`), and then sleep, so that a thread that holds a block but no processor gets this one.
/// - **Work alone after a long wait,** for many times as long as the wait was, and longer each time that it happens again.
///   Alone means that [`workers`](Self::workers) is 1, or that `fork_join` makes one call.
/// - **Compare.** Who works on what never changes a byte, so the time of steps may decide: where shared steps are no
///   faster than those done alone, stay alone, and try again later. [`enter`](Self::enter) tells when steps begin and end.
///
/// `trisap::Rayon` does all of this, and `ffi/examples/job_system.hpp` all but the last in C++.
///
/// If `fork_join` unwinds, so does the step, and the world is then half way through it: make it anew with
/// [`World::new_in`](crate::World::new_in). Memory stays sound.
///
/// Targets without 32-bit atomic exchange (`thumbv6m`) never call `fork_join`: steps are serial there.
///
/// ```
/// use trisap_core::Executor;
///
/// /// Runs jobs on freshly started threads and on the calling one.
/// struct Threads(u32);
///
/// impl Executor for Threads {
///     fn workers(&self) -> u32 {
///         self.0
///     }
///     fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
///         std::thread::scope(|scope| {
///             for _ in 1..width {
///                 scope.spawn(job);
///             }
///             job();
///         });
///     }
/// }
/// ```
pub trait Executor {
    /// How many calls of a job can run at once, the calling thread's own included where it makes one. A hint: below 2
    /// nothing is shared, and the answer may change from call to call.
    fn workers(&self) -> u32;

    /// Calls `job` `width` times, at once if it can be, and returns when all these calls have returned.
    ///
    /// `width` is 2 or more, and at most the least of [`workers`](Self::workers), of
    /// [`Config::workers`](crate::Config::workers) and of the blocks of work. See the trait for what else may be done.
    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync));

    /// A step enters a stage, on the calling thread. For profilers, and for executors that compare the times of steps.
    /// [`Stage::Done`] ends a step. An executor that wraps another hands it on.
    fn enter(&self, _stage: Stage) {}
}

/// The stages of a step, in order. Which ones a step enters depends on its [`Path`](crate::Path); each is entered once at most,
/// and the last one always, also where the step ends with an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Takes in the bounds array.
    Intake,
    /// Makes planes for all leaves or for the few that are out of balance, or puts the lists in order.
    Build,
    /// Brings the moved objects' boxes to their leaves.
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

/// Everything on the calling thread.
#[derive(Clone, Copy, Debug, Default)]
pub struct Serial;

impl Executor for Serial {
    fn workers(&self) -> u32 {
        1
    }
    fn fork_join(&self, _width: u32, _job: &(dyn Fn() + Sync)) {}
}

/// The executor of one step: it learns of each stage once, in order, and gets work only where the step is shared.
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
    /// A step that finds that it must do more than it began with goes back: that is part of the stage that it had come to.
    fn enter(&self, stage: Stage) {
        if self.entered.get() < Some(stage) {
            self.entered.set(Some(stage));
            self.executor.enter(stage);
        }
    }
}

/// Runs `job` to its end, with help where the executor and the world's scratch allow it and the `blocks` of
/// work are enough to share.
pub(crate) fn run(executor: &dyn Executor, scratches: usize, blocks: usize, job: &(dyn Fn() + Sync)) {
    let width = (executor.workers() as usize).min(scratches).min(blocks);
    // A claim is exclusive only where the counter changes in one piece.
    if cfg!(target_has_atomic = "32") && width > 1 {
        executor.fork_join(width as u32, job);
    }
    job();
}
