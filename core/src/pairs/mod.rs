//! Pairs on their way from the sweeps to the result: filters, the pairs that stay from step to step, events.

pub(crate) mod events;
pub(crate) mod pair_filter;
pub(crate) mod partition;
pub(crate) mod persistent;
pub(crate) mod results;
