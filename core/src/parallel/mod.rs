//! Work that several threads share: the caller's executor, the blocks that they claim, and the memory that they share.

pub(crate) mod block_queue;
pub(crate) mod context;
pub(crate) mod executor;
#[cfg(target_has_atomic = "32")]
pub(crate) mod offer;
pub(crate) mod shared;
