//! Borrows room for a full leaf from its neighbours: a crowd that gathers needs no fill of all leaves.

use super::limits::NEIGHBOURS;
use super::{Leaf, most};
use crate::access::Access;
use crate::memory::slab::TreeParts;
use crate::memory::state::State;

/// Gives a full leaf half of the free room of its nearest neighbour that has some. The records of the leaves
/// between move along and keep their order, so the places of their objects stay. Returns whether there was
/// room. A leaf that is to be divided gets none. O(neighbours and their members).
///
/// At most `budget` records move: beyond that it costs less to fill all leaves anew.
pub(crate) fn borrow_slack(tree: &mut TreeParts<'_>, state: &State, full: usize, budget: &mut usize) -> bool {
    let leaves = state.leaves() as usize;
    if u64::from(tree.leaves.at(full).len) >= most(state) {
        return false;
    }
    let near = (1..=NEIGHBOURS).flat_map(|distance| [full + distance, full.wrapping_sub(distance)]);
    for giver in near.filter(|giver| *giver < leaves) {
        let Leaf { room, len, .. } = tree.leaves.at(giver);
        let given = (room - len).div_ceil(2);
        if given == 0 {
            continue;
        }
        // The leaves between the two move, and the one of the two that is further back.
        let (first, last) = (full.min(giver) + 1, full.max(giver));
        let moving = tree.leaves.span(first, last + 1 - first);
        let records = moving.iter().map(|leaf| leaf.len as usize).sum::<usize>();
        let Some(left) = budget.checked_sub(records) else { return false };
        *budget = left;
        for step in 0..=last - first {
            let (index, by) =
                if giver > full { (last - step, given as i32) } else { (first + step, -(given as i32)) };
            shift(tree, index, by);
        }
        let (from, to) = (tree.leaves.at(giver), tree.leaves.at(full));
        tree.leaves.put(giver, Leaf { room: room - given, ..from });
        tree.leaves.put(full, Leaf { room: to.room + given, ..to });
        return true;
    }
    false
}

/// Moves the records of a leaf to where no others are.
fn shift(tree: &mut TreeParts<'_>, index: usize, by: i32) {
    let mut leaf = tree.leaves.at(index);
    let from = leaf.start;
    leaf.start = from.wrapping_add_signed(by);
    for record in 0..leaf.len {
        // Backwards if the leaf moves up, so that each record is read before it is overwritten.
        let record = if by > 0 { leaf.len - 1 - record } else { record };
        let moved = tree.records.at((from + record) as usize);
        tree.records.put((leaf.start + record) as usize, moved);
    }
    tree.leaves.put(index, leaf);
}
