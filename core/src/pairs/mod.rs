//! Turns overlaps of swept boxes into the result: filters, pairs that persist from step to step, events.

pub(crate) mod met;
pub(crate) mod pair_filter;
pub(crate) mod partition;
pub(crate) mod persistent;
pub(crate) mod results;
