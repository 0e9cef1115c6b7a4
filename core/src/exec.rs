//! The job hook: how a step asks the caller for threads.

/// A job system, as far as a step needs one.
///
/// The job that a step hands over is index-less and idempotent: every call of it claims blocks of work until
/// none remain, and the step makes a last call itself. An executor may therefore run it more often than asked,
/// less often, one after the other or not at all; the result is the same, byte for byte. A job never blocks,
/// nests, locks or allocates.
///
/// ```
/// use trisap_core::Executor;
///
/// /// Runs jobs on freshly started threads.
/// struct Threads(u32);
///
/// impl Executor for Threads {
///     fn workers(&self) -> u32 {
///         self.0
///     }
///     fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
///         std::thread::scope(|scope| {
///             for _ in 0..width {
///                 scope.spawn(job);
///             }
///         });
///     }
/// }
/// ```
pub trait Executor {
    /// How many calls of a job can run at once, the calling thread included.
    fn workers(&self) -> u32;

    /// Calls `job` up to `width` times, on any threads, and returns when all these calls have returned. The
    /// return is the only completion signal.
    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync));
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

/// Runs `job` to its end, with help where the executor and the world's scratch allow it and the `blocks` of
/// work are enough to share.
pub(crate) fn run(executor: &dyn Executor, scratches: usize, blocks: usize, job: &(dyn Fn() + Sync)) {
    let width = (executor.workers() as usize).min(scratches).min(blocks);
    if width > 1 {
        executor.fork_join(width as u32 - 1, job);
    }
    job();
}
