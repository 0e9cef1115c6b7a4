//! The tri-linked sorted lists: order from step to step, and the radix sort where much of it is lost.

pub(crate) mod links;
pub(crate) mod radix;
