//! What every phase of a step works with.

use super::block_queue::{BlockQueue, Parted};
use super::executor::{self, Executor};
use crate::filter::Rule;
use crate::simd::kernels::Kernels;

/// What the phases of a step work with.
#[derive(Clone, Copy)]
pub(crate) struct StepContext<'e> {
    pub(crate) kernels: Kernels,
    pub(crate) executor: &'e dyn Executor,
    pub(crate) rule: Option<&'e Rule<'e>>,
    /// How many may work at once.
    pub(crate) workers: usize,
    /// Whether the world is too small to share work.
    pub(crate) small: bool,
}

impl StepContext<'_> {
    /// Does the work of each part once, shared between the workers where there are enough parts.
    pub(crate) fn each<P: Parted>(self, parts: P, work: impl Fn(usize, P::Part) + Sync) {
        let queue = BlockQueue::new(parts);
        executor::run(self.executor, self.workers, queue.count(), &|| {
            while let Some((index, part)) = queue.claim() {
                work(index, part);
            }
        });
    }

    pub(crate) const fn is_small(&self) -> bool {
        !cfg!(feature = "large") || self.small
    }
}
