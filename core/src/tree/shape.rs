//! Divides and joins leaves in place. Nothing else of the tree changes its place, but for the leaf and the
//! two nodes with the highest numbers, which take over what becomes free: leaves and nodes stay without gaps.

use super::{Leaf, Split};
use crate::access::Access;
use crate::memory::slab::TreeParts;
use crate::memory::state::TreeState;

/// Makes a tree of one leaf.
pub(crate) fn plant(tree: &mut TreeParts<'_>, state: &mut TreeState) {
    (state.count, state.due, state.heavy, state.filled, state.unweighed) = (1, 0, 0, 0, 1);
    tree.leaves.put(0, Leaf::default());
    tree.stuck.put(0, 0);
    // There is no node above the root.
    tree.parents.put(0, 0);
    set_leaf(tree.splits, tree.tops, 1, 0);
}

pub(super) fn set_leaf(splits: &mut [Split], tops: &mut [u32], node: usize, leaf: usize) {
    splits.put(node, Split::leaf(leaf, node));
    tops.put(leaf, node as u32);
}

/// Joins a leaf with the leaf beside it if both have at most so many members; or gives up the plane above it
/// if it is empty.
pub(crate) fn join(tree: &mut TreeParts<'_>, state: &mut TreeState, leaf: usize, most: u64) {
    let node = tree.tops.at(leaf) as usize;
    if node <= 1 {
        return;
    }
    let above = tree.parents.at(node / 2) as usize;
    let beside = tree.splits.at(node ^ 1);
    let len = tree.leaves.at(leaf).len;
    match beside.as_leaf() {
        Some(other) if u64::from(len) + u64::from(tree.leaves.at(other).len) <= most => {
            let joined = Leaf { len: len + tree.leaves.at(other).len, ..tree.leaves.at(leaf) };
            tree.leaves.put(leaf, joined);
            set_leaf(tree.splits, tree.tops, above, leaf);
            release(tree, state, node / 2, other);
        }
        None if len == 0 => {
            move_node(tree, node ^ 1, above);
            release(tree, state, node / 2, leaf);
        }
        _ => {}
    }
}

/// Lets what stands at a node stand at another.
fn move_node(tree: &mut TreeParts<'_>, from: usize, to: usize) {
    let split = tree.splits.at(from);
    match split.as_leaf() {
        Some(leaf) => set_leaf(tree.splits, tree.tops, to, leaf),
        None => {
            tree.splits.put(to, split);
            tree.parents.put(split.below as usize / 2, to as u32);
        }
    }
}

/// Gives up two nodes and a leaf, for which the last ones come.
fn release(tree: &mut TreeParts<'_>, state: &mut TreeState, pair: usize, leaf: usize) {
    state.count -= 1;
    let last = state.count as usize;
    if pair != last {
        let above = tree.parents.at(last);
        tree.parents.put(pair, above);
        let split = Split { below: 2 * pair as u32, ..tree.splits.at(above as usize) };
        tree.splits.put(above as usize, split);
        move_node(tree, 2 * last, 2 * pair);
        move_node(tree, 2 * last + 1, 2 * pair + 1);
    }
    if leaf != last {
        tree.leaves.put(leaf, tree.leaves.at(last));
        tree.stuck.put(leaf, tree.stuck.at(last));
        let node = tree.tops.at(last) as usize;
        set_leaf(tree.splits, tree.tops, node, leaf);
    }
}
