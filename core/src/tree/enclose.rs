//! What follows from the records of all leaves: the straddlers of each leaf, and the box of each node.

use super::{Cell, Leaf, Record, Straddler};
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::limits::LEAVES_PER_BLOCK;
use crate::memory::slab::Parts;
use crate::parallel::block_queue::{BlockQueue, Chunks};
use crate::parallel::executor::{self, Executor};
use crate::parallel::shared::Shared;
use crate::simd::kernels::Kernels;
use crate::simd::{Phase, Simd};

/// Says where the straddlers of each leaf are to stand, by the marks of the records. Returns how many there are. O(records).
pub(crate) fn number_straddlers<I: Index>(parts: &mut Parts<'_, I>, executor: &dyn Executor) -> u32 {
    let records = &*parts.tree.records;
    let leaves = parts.tree.leaves.span_mut(0, 1 << parts.state.tree.depth);
    let claims = BlockQueue::new(Chunks::new(leaves, LEAVES_PER_BLOCK));
    executor::run(executor, parts.sizes.workers, claims.count(), &|| {
        while let Some((_, leaves)) = claims.claim() {
            for leaf in leaves {
                let members = records.span(leaf.start as usize, leaf.len as usize);
                leaf.straddler_len = members.iter().map(|record| record.tag / Record::STRADDLES % 2).sum();
            }
        }
    });
    let mut start = 0;
    for leaf in parts.tree.leaves.span_mut(0, 1 << parts.state.tree.depth) {
        leaf.straddler_start = start;
        start += leaf.straddler_len;
    }
    start
}

/// Lists the straddlers, and finds the box of each node: for a leaf, around its cell and its straddlers; for an inner node,
/// around its children.
pub(crate) fn enclose<I: Index>(parts: &mut Parts<'_, I>, kernels: Kernels, executor: &dyn Executor) {
    let leaves = 1usize << parts.state.tree.depth;
    let boxes = parts.boxes.swept();
    let (cells, buckets, records) = (&*parts.tree.cells, &*parts.tree.leaves, &*parts.tree.records);
    let straddlers = Shared::new(parts.tree.straddlers);
    let (inner, outer) = parts.tree.nodes.split_at_mut_checked(leaves).unwrap_or_default();
    let outer = outer.span_mut(0, leaves);
    let claims = BlockQueue::new(Chunks::new(outer, LEAVES_PER_BLOCK));
    executor::run(executor, parts.sizes.workers, claims.count(), &|| {
        while let Some((block, nodes)) = claims.claim() {
            let first = block * LEAVES_PER_BLOCK;
            let (cells, leaves) = (cells.span(first, nodes.len()), buckets.span(first, nodes.len()));
            kernels.run(EncloseBlock { boxes, cells, leaves, records, straddlers, nodes });
        }
    });
    for node in (1..leaves).rev() {
        let mut around = KeyBox::NOTHING;
        for child in [2 * node, 2 * node + 1] {
            around.include(match child.checked_sub(leaves) {
                Some(leaf) => KeyBox::of(outer, leaf),
                None => KeyBox::of(inner, child),
            });
        }
        inner.put(node, around);
    }
}

struct EncloseBlock<'b, 's> {
    boxes: &'b [KeyBox],
    cells: &'b [Cell],
    leaves: &'b [Leaf],
    records: &'b [Record],
    straddlers: Shared<'s, Straddler>,
    nodes: &'b mut [KeyBox],
}

impl Phase for EncloseBlock<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { boxes, cells, leaves, records, straddlers, nodes } = self;
        for ((cell, leaf), node) in cells.iter().zip(leaves).zip(nodes) {
            *node = KeyBox::NOTHING;
            if leaf.len == 0 {
                continue;
            }
            let inside = simd.keys(&cell.inside());
            let (mut low, mut high) = (inside, inside);
            let mut at = leaf.straddler_start as usize;
            for records in records.span(leaf.start as usize, leaf.len as usize).chunks(64) {
                // Noted for all of them first: which ones are marked is hard to predict, and their boxes are anywhere in memory.
                let mut marked = 0u64;
                for (bit, record) in records.iter().enumerate() {
                    marked |= u64::from(record.tag / Record::STRADDLES % 2) << bit;
                }
                let mut ahead = marked;
                while ahead != 0 {
                    simd.prefetch(boxes, records.at(ahead.trailing_zeros() as usize).slot() as usize);
                    ahead &= ahead - 1;
                }
                while marked != 0 {
                    let slot = records.at(marked.trailing_zeros() as usize).slot();
                    marked &= marked - 1;
                    let bounds = KeyBox::of(boxes, slot as usize);
                    let keys = simd.keys(bounds);
                    (low, high) = (simd.lower(low, keys), simd.upper(high, keys));
                    straddlers.store(at, &Straddler { bounds: *bounds, slot, unused: 0 });
                    at += 1;
                }
            }
            *node = KeyBox { min: simd.bounds(low).min, max: simd.bounds(high).max };
        }
    }
}

/// Grows the boxes of a node and of those above it to hold a box.
#[inline(always)]
pub(crate) fn expand_ancestors(nodes: &mut [KeyBox], mut node: usize, bounds: &KeyBox) {
    while node > 0 {
        let mut around = nodes.at(node);
        // So do those above.
        if around.contains(bounds) {
            break;
        }
        around.include(bounds);
        nodes.put(node, around);
        node /= 2;
    }
}
