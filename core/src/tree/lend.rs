//! Lends a full leaf room of its neighbours, so that a step with few movers need not fill all leaves anew.

use super::balance::overfull;
use crate::access::Access;
use crate::memory::slab::TreeParts;
use crate::memory::state::State;

/// Leaves on either side that are asked for room.
const NEIGHBOURS: usize = 16;

/// Gives a full leaf half of the room that the nearest of its neighbours can spare; the records of the leaves between move
/// along, in their order, so that the places of their objects stay. Tells whether there was any. A leaf that would be overfull
/// then gets none: it wants new planes. O(neighbours and their members).
///
/// No more records move than `budget` has left: to fill all leaves anew costs less then.
pub(crate) fn lend(tree: &mut TreeParts<'_>, state: &State, full: usize, budget: &mut usize) -> bool {
    let leaves = state.leaves() as usize;
    if tree.leaves.at(full).len as usize >= overfull(state) {
        return false;
    }
    for distance in 1..=NEIGHBOURS {
        for lender in [full + distance, full.wrapping_sub(distance)] {
            let mut bag = if lender < leaves { tree.leaves.at(lender) } else { continue };
            let given = (bag.room - bag.len).div_ceil(2);
            if given == 0 {
                continue;
            }
            // Those between the two move, and the one of them that is further back.
            let moving = if lender > full { full + 1..lender + 1 } else { lender + 1..full + 1 };
            let records = moving.map(|index| tree.leaves.at(index).len as usize).sum::<usize>();
            match budget.checked_sub(records) {
                Some(left) => *budget = left,
                None => return false,
            }
            bag.room -= given;
            tree.leaves.put(lender, bag);
            if lender > full {
                for index in (full + 1..=lender).rev() {
                    shift(tree, index, |start| start + given);
                }
            } else {
                for index in lender + 1..=full {
                    shift(tree, index, |start| start - given);
                }
            }
            let mut bag = tree.leaves.at(full);
            bag.room += given;
            tree.leaves.put(full, bag);
            return true;
        }
    }
    false
}

/// Moves the records of a leaf to where nobody's are.
fn shift(tree: &mut TreeParts<'_>, index: usize, to: impl Fn(u32) -> u32) {
    let mut bag = tree.leaves.at(index);
    let start = to(bag.start);
    for record in 0..bag.len {
        // Backwards where it moves up, so that each is read before its place is taken.
        let record = if start > bag.start { bag.len - 1 - record } else { record };
        let moved = tree.records.at((bag.start + record) as usize);
        tree.records.put((start + record) as usize, moved);
    }
    bag.start = start;
    tree.leaves.put(index, bag);
}
