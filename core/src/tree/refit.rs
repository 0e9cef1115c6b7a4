//! Makes the boxes of nodes tight again, since movers only make them larger. Each step with movers refits as
//! many leaves as the movers pay for, so a crowd that is calm for hours stays as cheap as it was.

use super::Record;
use super::limits::REFIT_SHARE;
use crate::access::Access;
use crate::filter::offer;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::slab::Parts;

/// Makes boxes tight, after the records of `movers` objects were moved.
pub(crate) fn refit_some<I: Index>(parts: &mut Parts<'_, I>, movers: usize) {
    let moved = parts.state.tree.moved_since_refit as usize + movers;
    let movers_per_leaf = REFIT_SHARE * parts.config().forced.leaf_target();
    parts.state.tree.moved_since_refit = (moved % movers_per_leaf) as u32;
    for _ in 0..moved / movers_per_leaf {
        // There may have been more leaves before.
        let whole = if parts.state.tree.refit < parts.state.tree.count { parts.state.tree.refit } else { 0 };
        parts.state.tree.refit = whole + 1;
        refit(parts, whole as usize);
    }
}

/// Makes the boxes of one whole leaf tight: its own, its sub-leaves' and its nodes'.
fn refit<I: Index>(parts: &mut Parts<'_, I>, whole: usize) {
    let boxes = parts.boxes.swept();
    let tree = &mut parts.tree;
    let sub_levels = parts.state.tree.sub_levels();
    let mut around = KeyBox::NOTHING;
    for index in whole << sub_levels..(whole + 1) << sub_levels {
        let mut bounds = Record::NOTHING;
        for record in tree.leaves.at(index).members(tree.records) {
            bounds.include(record);
            bounds.tag |= offer(parts.filters.of, record.slot() as usize);
            around.include(KeyBox::of(boxes, record.slot() as usize));
        }
        if sub_levels > 0 {
            tree.bounds.put(index, bounds);
        }
    }
    let mut node = tree.tops.at(whole) as usize;
    while node > 0 {
        tree.boxes.put(node, around);
        // With the sibling it makes the node above.
        around.include(KeyBox::of(tree.boxes, node ^ 1));
        node = tree.parents.at(node / 2) as usize;
    }
}
