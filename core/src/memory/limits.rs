//! The sizes at which a world changes how it works, the blocks that work is cut into, and the stacks of fixed
//! length. The table of constants in `NOTEBOOK.md` says what was measured for each.

use super::slot_set::GROUP;
use crate::config::{Forced, SMALL_LEAVES};

// Sizes of worlds and leaves.

/// Worlds for up to this many objects are lean: they have no tree and no scratch memory.
pub(crate) const TINY: usize = LEAF_TARGET / 8;
/// Worlds for up to this many objects test every two boxes. Without the feature `lists` all lean ones do.
pub(crate) const FEW: usize = 32;
/// The most objects of a lean world.
pub(crate) const SMALL: usize = 256;
/// The usual [`Forced::leaf_target`].
pub(crate) const LEAF_TARGET: usize = 512;
/// Levels of planes below the leaves of a full step: each of these divides into eight sub-leaves.
pub(crate) const SUB_LEVELS: u32 = 3;
/// Free records in a leaf of a full step, beside an eighth of its members: four for each sub-leaf.
pub(crate) const ROOM: u32 = 4 << SUB_LEVELS;
/// The most records that are swept at once. Larger leaves are swept tile by tile.
pub(crate) const BUCKET: usize = 2048;
/// Candidates that are collected before they are tested.
pub(crate) const BATCH: usize = 1024;

// Work that is shared. Blocks follow from counts and the configuration alone, and no result from the blocks.

/// From this many objects on a step is shared between workers.
pub(crate) const SHARED_FROM: u32 = 4096;
/// Blocks of slots in the passes over all objects.
pub(crate) const SLOT_BLOCKS: usize = 32;
/// A block of slots is a multiple of this: whole groups of a set, whole cache lines of every array by slot.
pub(crate) const SLOTS_PER_BLOCK: usize = GROUP;
/// The fewest objects in a block where each is tested by itself: its test outweighs the queue.
pub(crate) const MOVERS_PER_BLOCK: usize = 64;
/// Blocks of pairs where lists of pairs are divided.
pub(crate) const PAIR_BLOCKS: usize = 64;
/// The fewest pairs in such a block.
pub(crate) const PAIRS_PER_BLOCK: usize = 1024;
/// Pairs that are tested before the first of them changes its place: a bit each in one word.
pub(crate) const PAIRS_TOGETHER: usize = usize::BITS as usize;
/// Pairs that a worker of a shared sweep writes to one chunk.
pub(crate) const CHUNK: usize = 256;
/// Queries that a worker takes at a time.
pub(crate) const QUERIES_PER_BLOCK: usize = 32;
/// The most workers of a batch of queries, which need no scratch memory.
pub(crate) const QUERY_WORKERS: usize = 32;

// Stacks and lists of fixed length.

/// Nodes that wait on a walk through the tree: at most one a level, and a leaf. No tree becomes as deep.
pub(crate) const LEVELS: usize = 64;
/// Masks from which a round takes bits before it looks again whether there is room.
pub(crate) const MASKS_PER_ROUND: usize = 32;
/// About so many records of a bucket tell how many neighbours all have.
pub(crate) const NEIGHBOURS_SAMPLE: usize = 32;
/// Rows whose windows are compared in one pass. A power of two, so that an index into a list needs no check.
pub(crate) const ROWS: usize = 256;

/// The blocks of slots that so many workers take, in passes that count for each block by itself.
pub(crate) const fn slot_blocks(workers: usize) -> usize {
    if workers > 1 { SLOT_BLOCKS } else { 1 }
}

/// Slots in each of so many blocks.
pub(crate) fn block_len(slots: usize, blocks: usize) -> usize {
    slots.div_ceil(blocks).next_multiple_of(SLOTS_PER_BLOCK).max(SLOTS_PER_BLOCK)
}

/// Entries of one block's histogram: up to two numbers of each leaf, and one more.
pub(crate) const fn histogram_row(leaves: usize) -> usize {
    2 * leaves + 1
}

/// The depth of new leaves for a number of objects, so that none has more than `target` at exact medians
/// (erratum E14).
pub(crate) const fn depth_for(objects: usize, target: usize) -> u32 {
    let mut depth = 0;
    while objects > target << depth {
        depth += 1;
    }
    depth
}

impl Forced {
    /// The most objects in a leaf of new planes, at exact medians. Worlds for an eighth have no tree.
    pub(crate) const fn leaf_target(self) -> usize {
        if matches!(self.of(SMALL_LEAVES), Some(true)) { LEAF_TARGET / 32 } else { LEAF_TARGET }
    }
}

/// Steps at the end of a pause of fat boxes, and of the first ones of a new world, in which some objects try
/// them.
pub(crate) const TRIAL: u8 = 8;

/// Where the bits of a slot start that say something about it and each lower slot, in words: each slot has as
/// many words as it takes, behind those of all lower ones.
pub(crate) const fn row_of_bits(slot: usize) -> usize {
    (slot / 32 + 1) * (slot - slot / 32 * 16)
}
