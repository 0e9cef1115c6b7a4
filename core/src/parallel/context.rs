//! What all phases of a step are given: kernels, executor, rule, and how many may work.

use super::block_queue::{BlockQueue, Parted};
use super::executor::{self, Executor};
use crate::filter::Rule;
use crate::simd::kernels::Kernels;

/// See the module.
#[derive(Clone, Copy)]
pub(crate) struct StepContext<'e> {
    pub(crate) kernels: Kernels,
    pub(crate) executor: &'e dyn Executor,
    pub(crate) rule: Option<&'e Rule<'e>>,
    /// The most workers.
    pub(crate) workers: usize,
}

impl StepContext<'_> {
    /// As [`each`], with the workers of the step.
    pub(crate) fn each<P: Parted>(self, parts: P, work: impl Fn(usize, P::Part) + Sync) {
        each(self.executor, self.workers, parts, work);
    }

    /// Runs a job of so many blocks.
    pub(crate) fn run(self, blocks: usize, job: &(dyn Fn() + Sync)) {
        executor::run(self.executor, self.workers, blocks, job);
    }
}

/// Works on each part once. Workers, as many as said at most, share the parts if there are enough.
pub(crate) fn each<P: Parted>(
    executor: &dyn Executor,
    workers: usize,
    parts: P,
    work: impl Fn(usize, P::Part) + Sync,
) {
    let workers = (executor.workers() as usize).min(workers);
    within(workers, parts, work, &mut |parts, job| executor::run(executor, workers, parts, job));
}

/// The same in a job of the caller's, who is given the number of parts, and what each worker is to do.
pub(crate) fn within<P: Parted>(
    workers: usize,
    parts: P,
    work: impl Fn(usize, P::Part) + Sync,
    run: &mut dyn FnMut(usize, &(dyn Fn() + Sync)),
) {
    let queue = BlockQueue::new(parts, workers);
    run(queue.count(), &|| {
        let mut share = queue.arrive();
        while let Some((index, part)) = queue.claim_from(&mut share) {
            work(index, part);
        }
    });
}
