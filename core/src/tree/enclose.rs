//! Makes the boxes of nodes, and lists straddlers by the marks of records.

use super::{Record, Straddler, Straddling};
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::slab::Parts;
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;
use crate::parallel::shared::Shared;
use crate::simd::kernels::run;
use crate::simd::{Simd, call};

/// Says where the straddlers of each leaf will be, by the marks of the records. Returns how many there are.
/// O(records).
pub(crate) fn number_straddlers<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> u32 {
    let (records, leaves) = (&*parts.tree.records, &*parts.tree.leaves);
    let straddling = parts.tree.straddling.span_mut(0, parts.state.tree.count as usize);
    context.each(Chunks::new(&mut *straddling, 1), |leaf, straddling| {
        let marks = leaves.at(leaf).members(records).iter().map(|record| record.tag / Record::STRADDLES % 2);
        straddling.fill(Straddling { start: 0, len: marks.sum() });
    });
    let mut start = 0;
    for straddling in straddling {
        straddling.start = start;
        start += straddling.len;
    }
    start
}

/// Lists the straddlers where [`number_straddlers`] says, and makes the box of each node: a leaf's around its
/// cell and straddlers, an inner node's around its children.
pub(crate) fn enclose<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) {
    let (boxes, tree, count) = (parts.boxes.swept(), &mut parts.tree, parts.state.tree.count as usize);
    tree.boxes.span_mut(0, 2 * count).fill(KeyBox::NOTHING);
    let (leaves, straddling) = (&*tree.leaves, &*tree.straddling);
    let (cells, tops) = (&*tree.cells, tree.tops.span(0, count));
    let (records, nodes, list) = (&*tree.records, Shared::new(tree.boxes), Shared::new(tree.straddlers));
    context.each(count, |index, ()| {
        let (members, inside) = (leaves.at(index).members(records), cells.at(index).inside());
        let list = (list, straddling.at(index).start as usize);
        let around = run!(context.kernels, |simd| enclose_leaf(simd, boxes, members, inside, list));
        if !members.is_empty() {
            nodes.store(tops.at(index) as usize, &around);
        }
    });
    let above = |node: usize| tree.parents.at(node / 2) as usize;
    for top in tops {
        let around = tree.boxes.at(*top as usize);
        expand_ancestors(tree.boxes, above, above(*top as usize), &around);
    }
}

/// Lists the straddlers of a leaf from a place on. Returns a box around them and another one.
#[inline(always)]
fn enclose_leaf<S: Simd>(
    simd: S,
    boxes: &[KeyBox],
    members: &[Record],
    mut around: KeyBox,
    (list, mut at): (Shared<'_, Straddler>, usize),
) -> KeyBox {
    call!(simd, {
        for members in members.chunks(64) {
            // Noted for all of them first, since which ones straddle is hard to predict.
            let marks = members.iter().map(|record| record.tag / Record::STRADDLES % 2);
            let mut marked = marks.rev().fold(0u64, |bits, mark| 2 * bits + u64::from(mark));
            while marked != 0 {
                let slot = members.at(marked.trailing_zeros() as usize).slot();
                let bounds = *KeyBox::of(boxes, slot as usize);
                list.store(at, &Straddler { bounds, slot, long: 0 });
                around.include(&bounds);
                (at, marked) = (at + 1, marked & (marked - 1));
            }
        }
        around
    })
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
