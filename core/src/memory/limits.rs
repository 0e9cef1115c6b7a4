//! The sizes at which a world changes how it works, and the sizes of blocks of work, each with the reason.

use super::slot_set::GROUP;

/// Worlds for up to this many objects are lean, and swept where their boxes are.
pub(crate) const TINY: usize = if cfg!(fuzzing) { 8 } else { 64 };
/// Lean worlds have at most this many objects.
pub(crate) const SMALL: usize = 256;
/// Objects that a leaf should have at most when planes are new. For random sequences of operations there are few, as they need many
/// small worlds that take all paths.
pub(crate) const LEAF_TARGET: usize = if cfg!(fuzzing) { 16 } else { 512 };
/// Levels of planes below those of a full step: leaves of an eighth as many objects, for steps and queries that look at a
/// few objects here and there.
pub(crate) const SUB_LEVELS: u32 = 3;
/// Records that a leaf of a full step has room for beside an eighth of its members: four for each of the leaves that it may be
/// divided into.
pub(crate) const ROOM: u32 = 4 << SUB_LEVELS;
/// Nodes that wait at once on a walk through the tree: at most one a level, and a leaf. The deepest tree has fewer levels.
pub(crate) const LEVELS: usize = 32;
/// Blocks of slots in the passes over all objects. Fixed, so that no result depends on the number of workers.
pub(crate) const SLOT_BLOCKS: usize = 32;
/// A block has so many slots or a multiple of that: whole groups of marks, whole cache lines of all that has an item a slot.
const SLOTS_PER_BLOCK: usize = GROUP;
/// Leaves in a block of the passes over all leaves, in a full step.
pub(crate) const LEAVES_PER_BLOCK: usize = 2;
/// Pairs that parallel workers write at a time.
pub(crate) const CHUNK: usize = 512;

/// Slots in a block of the passes over so many.
pub(crate) fn block_len(slots: usize) -> usize {
    slots.div_ceil(SLOT_BLOCKS).next_multiple_of(SLOTS_PER_BLOCK).max(SLOTS_PER_BLOCK)
}

/// Entries of one block's histogram at a depth: objects and straddlers of each leaf, two by two, and the large objects last.
pub(crate) const fn histogram_row(depth: u32) -> usize {
    (2 << depth) + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_few_and_whole() {
        for slots in [0, 1, 1024, 1025, 100_000, 1 << 27] {
            let len = block_len(slots);
            assert!(slots.div_ceil(len) <= SLOT_BLOCKS && len.is_multiple_of(GROUP), "{slots}: {len}");
        }
    }
}
