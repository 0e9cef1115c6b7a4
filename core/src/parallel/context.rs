//! What every phase of a step works with.

use super::executor::Executor;
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
    pub(crate) const fn is_small(&self) -> bool {
        !cfg!(feature = "large") || self.small
    }
}
