//! Borrows room for a full leaf from its neighbours, so that a step with few movers need not fill all leaves anew.

use super::limits::NEIGHBOURS;
use super::most;
use crate::access::Access;
use crate::memory::slab::TreeParts;
use crate::memory::state::State;

/// Gives a full leaf half of the free room of its nearest neighbour that has some. The records of the leaves between
/// move along and keep their order, so the places of their objects stay. Returns whether there was room. A leaf
/// that is to be divided gets none. O(neighbours and their members).
///
/// At most `budget` records move: beyond that it costs less to fill all leaves anew.
pub(crate) fn borrow_slack(tree: &mut TreeParts<'_>, state: &State, full: usize, budget: &mut usize) -> bool {
    let leaves = state.leaves() as usize;
    if tree.leaves.at(full).len as usize >= most(state) as usize {
        return false;
    }
    for distance in 1..=NEIGHBOURS {
        for giver in [full + distance, full.wrapping_sub(distance)] {
            let mut leaf = if giver < leaves { tree.leaves.at(giver) } else { continue };
            let given = (leaf.room - leaf.len).div_ceil(2);
            if given == 0 {
                continue;
            }
            // The leaves between the two move, and the one of the two that is further back.
            let moving = if giver > full { full + 1..giver + 1 } else { giver + 1..full + 1 };
            let records = moving.map(|index| tree.leaves.at(index).len as usize).sum::<usize>();
            match budget.checked_sub(records) {
                Some(left) => *budget = left,
                None => return false,
            }
            leaf.room -= given;
            tree.leaves.put(giver, leaf);
            if giver > full {
                for index in (full + 1..=giver).rev() {
                    shift(tree, index, |start| start + given);
                }
            } else {
                for index in giver + 1..=full {
                    shift(tree, index, |start| start - given);
                }
            }
            let mut leaf = tree.leaves.at(full);
            leaf.room += given;
            tree.leaves.put(full, leaf);
            return true;
        }
    }
    false
}

/// Moves the records of a leaf to where no others are.
fn shift(tree: &mut TreeParts<'_>, index: usize, to: impl Fn(u32) -> u32) {
    let mut leaf = tree.leaves.at(index);
    let start = to(leaf.start);
    for record in 0..leaf.len {
        // Backwards if the leaf moves up, so that each record is read before it is overwritten.
        let record = if start > leaf.start { leaf.len - 1 - record } else { record };
        let moved = tree.records.at((leaf.start + record) as usize);
        tree.records.put((start + record) as usize, moved);
    }
    leaf.start = start;
    tree.leaves.put(index, leaf);
}
