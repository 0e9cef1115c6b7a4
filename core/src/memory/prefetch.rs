//! How far ahead memory is asked for: boxes, leaves and records stand anywhere in memory, and a cache miss takes longer than the
//! work on what it brings. The table of constants in `NOTEBOOK.md` says what was measured for each.

/// Worlds of up to this many boxes have them in the cache: no boxes of pairs are prefetched.
pub(crate) const BOXES_NEAR: usize = 4096;
/// The same where some pairs are tested at once, which waits less for the boxes.
pub(crate) const BOXES_OF_SOME_NEAR: usize = 32_768;

/// Movers ahead whose leaves are prefetched when records are moved; twice as many ahead, what tells which leaves these are.
pub(crate) const RELOCATED_AHEAD: usize = 6;
/// Members ahead whose boxes are prefetched when the boxes of a leaf are made tight.
pub(crate) const REFIT_AHEAD: usize = 16;

/// Movers ahead whose boxes are prefetched when movers are tested.
pub(crate) const MOVERS_AHEAD: usize = 8;
/// Leaves near movers that are prefetched before the first of them is looked at.
pub(crate) const LEAVES_TOGETHER: usize = 16;
/// Records of a leaf that are prefetched; the processor sees for itself that the others follow.
pub(crate) const RECORDS_AHEAD: usize = 48;
