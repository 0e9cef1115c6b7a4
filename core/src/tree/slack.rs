//! Gives a full leaf room of its neighbours, so that a step with few movers need not fill all leaves anew.

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
pub(crate) fn borrow_slack(tree: &mut TreeParts<'_>, state: &State, full: usize, budget: &mut usize) -> bool {
    let leaves = state.leaves() as usize;
    if tree.leaves.at(full).len as usize >= overfull(state) {
        return false;
    }
    for distance in 1..=NEIGHBOURS {
        for giver in [full + distance, full.wrapping_sub(distance)] {
            let mut bucket = if giver < leaves { tree.leaves.at(giver) } else { continue };
            let given = (bucket.room - bucket.len).div_ceil(2);
            if given == 0 {
                continue;
            }
            // Those between the two move, and the one of them that is further back.
            let moving = if giver > full { full + 1..giver + 1 } else { giver + 1..full + 1 };
            let records = moving.map(|index| tree.leaves.at(index).len as usize).sum::<usize>();
            match budget.checked_sub(records) {
                Some(left) => *budget = left,
                None => return false,
            }
            bucket.room -= given;
            tree.leaves.put(giver, bucket);
            if giver > full {
                for index in (full + 1..=giver).rev() {
                    shift(tree, index, |start| start + given);
                }
            } else {
                for index in giver + 1..=full {
                    shift(tree, index, |start| start - given);
                }
            }
            let mut bucket = tree.leaves.at(full);
            bucket.room += given;
            tree.leaves.put(full, bucket);
            return true;
        }
    }
    false
}

/// Moves the records of a leaf to a place where no others are.
fn shift(tree: &mut TreeParts<'_>, index: usize, to: impl Fn(u32) -> u32) {
    let mut bucket = tree.leaves.at(index);
    let start = to(bucket.start);
    for record in 0..bucket.len {
        // Backwards where it moves up, so that each is read before its place is taken.
        let record = if start > bucket.start { bucket.len - 1 - record } else { record };
        let moved = tree.records.at((bucket.start + record) as usize);
        tree.records.put((start + record) as usize, moved);
    }
    bucket.start = start;
    tree.leaves.put(index, bucket);
}
