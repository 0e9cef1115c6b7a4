//! Makes the boxes of nodes, and lists straddlers by the marks of records.

use super::{Record, Straddler};
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::slab::Parts;
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;
use crate::parallel::shared::Shared;

/// Says where the straddlers of each leaf will be, by the marks of the records. Returns how many there are.
/// O(records).
pub(crate) fn number_straddlers<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> u32 {
    let records = &*parts.tree.records;
    let leaves = parts.tree.leaves.span_mut(0, parts.state.tree.count as usize);
    context.each(Chunks::new(leaves, 1), |_, leaves| {
        for leaf in leaves {
            let members = records.span(leaf.start as usize, leaf.len as usize);
            leaf.straddler_len = members.iter().map(|record| record.tag / Record::STRADDLES % 2).sum();
        }
    });
    let mut start = 0;
    for leaf in parts.tree.leaves.span_mut(0, parts.state.tree.count as usize) {
        leaf.straddler_start = start;
        start += leaf.straddler_len;
    }
    start
}

/// Lists the straddlers where [`number_straddlers`] says.
pub(crate) fn list_straddlers<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) {
    let (boxes, straddlers) = (parts.boxes.swept(), Shared::new(parts.tree.straddlers));
    let (records, leaves) = (&*parts.tree.records, &*parts.tree.leaves);
    context.each(parts.state.tree.count as usize, |index, ()| {
        let leaf = leaves.at(index);
        let members = records.span(leaf.start as usize, leaf.len as usize).iter();
        let marked = members.filter(|record| record.tag & Record::STRADDLES != 0);
        for (at, slot) in (leaf.straddler_start as usize..).zip(marked.map(Record::slot)) {
            let bounds = *KeyBox::of(boxes, slot as usize);
            straddlers.store(at, &Straddler { bounds, slot, long: 0 });
        }
    });
}

/// Makes the box of each node: a leaf's around its cell and straddlers, an inner node's around its children.
pub(crate) fn enclose<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) {
    let (tree, count) = (&mut parts.tree, parts.state.tree.count as usize);
    tree.boxes.span_mut(0, 2 * count).fill(KeyBox::NOTHING);
    let (leaves, cells, tops) = (&*tree.leaves, &*tree.cells, tree.tops.span(0, count));
    let (straddlers, nodes) = (&*tree.straddlers, Shared::new(tree.boxes));
    context.each(count, |index, ()| {
        let (leaf, mut around) = (leaves.at(index), cells.at(index).inside());
        for straddler in straddlers.span(leaf.straddler_start as usize, leaf.straddler_len as usize) {
            around.include(&straddler.bounds);
        }
        if leaf.len > 0 {
            nodes.store(tops.at(index) as usize, &around);
        }
    });
    let above = |node: usize| tree.parents.at(node / 2) as usize;
    for top in tops {
        let around = tree.boxes.at(*top as usize);
        expand_ancestors(tree.boxes, above, above(*top as usize), &around);
    }
}

/// Grows the boxes of a node and of the nodes above it to hold a box.
#[inline(always)]
pub(crate) fn expand_ancestors(
    boxes: &mut [KeyBox],
    above: impl Fn(usize) -> usize,
    mut node: usize,
    bounds: &KeyBox,
) {
    while node > 0 {
        let mut around = boxes.at(node);
        // Then the boxes above hold it too.
        if around.contains(bounds) {
            break;
        }
        around.include(bounds);
        boxes.put(node, around);
        node = above(node);
    }
}
