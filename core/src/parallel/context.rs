//! What all phases of a step are given: kernels, executor, rule, and how many may work.

use super::block_queue::{BlockQueue, Parted};
use super::executor::{self, Executor};
use crate::filter::Rule;
use crate::simd::kernels::Kernels;

#[derive(Clone, Copy)]
pub(crate) struct StepContext<'e> {
    pub(crate) kernels: Kernels,
    pub(crate) executor: &'e dyn Executor,
    pub(crate) rule: Option<&'e Rule<'e>>,
    /// The most workers.
    pub(crate) workers: usize,
}

impl StepContext<'_> {
    /// Works on each part once. Workers share the parts if there are enough.
    pub(crate) fn each<P: Parted>(self, parts: P, work: impl Fn(usize, P::Part) + Sync) {
        let queue = BlockQueue::new(parts, (self.executor.workers() as usize).min(self.workers));
        executor::run(self.executor, self.workers, queue.count(), &|| {
            let mut share = queue.arrive();
            while let Some((index, part)) = queue.claim_from(&mut share) {
                work(index, part);
            }
        });
    }
}
