//! The tri-linked sorted lists, kept in order from step to step.

pub(crate) mod links;
