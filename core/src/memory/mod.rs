//! The memory of a world: how large it is, the slab and the slices that it is carved into, the numbers that
//! are not arrays, and all constants of sizes and distances.

pub(crate) mod layout;
pub(crate) mod leaf;
pub(crate) mod limits;
pub(crate) mod scratch;
pub(crate) mod sections;
pub(crate) mod slab;
pub(crate) mod slot_set;
pub(crate) mod state;
pub(crate) mod stats;
