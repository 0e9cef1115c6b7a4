//! The memory of a world: its size, the slab and the slices that it is carved into, and the state that is not an array.

pub(crate) mod layout;
pub(crate) mod leaf;
pub(crate) mod limits;
pub(crate) mod scratch;
pub(crate) mod slab;
pub(crate) mod slot_set;
pub(crate) mod state;
pub(crate) mod stats;
pub(crate) mod stripes;
