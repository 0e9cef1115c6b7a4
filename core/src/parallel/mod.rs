//! Shares work between threads: the caller's executor, the blocks that workers claim, the slices that they
//! fill together.

pub(crate) mod block_queue;
pub(crate) mod context;
pub(crate) mod executor;
pub(crate) mod shared;

#[cfg(test)]
#[path = "../../tests/kernels/threads.rs"]
mod tests;
