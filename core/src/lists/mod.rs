//! The tri-linked sorted lists: kept in order from step to step, or sorted anew by radix.

pub(crate) mod links;
pub(crate) mod radix;
