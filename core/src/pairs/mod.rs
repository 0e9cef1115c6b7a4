//! Pairs on their way from the sweeps to the result: filters, the pairs that stay from step to step, events.

pub(crate) mod carry;
pub(crate) mod gate;
pub(crate) mod results;
