//! Makes the boxes around the members of leaves tight again, since movers only make them larger: some in each step with movers,
//! as many as the movers pay for, so that a crowd that is calm for hours stays as cheap as it was.

use super::Record;
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::limits::LEAF_TARGET;
use crate::memory::slab::Parts;
use crate::simd::{Phase, Simd};

/// Movers for each leaf of a full step that gets new boxes: a look at about one member for four movers.
const MOVERS_PER_LEAF: usize = 4 * LEAF_TARGET;
/// How many members ahead boxes are asked for: they are anywhere in memory.
const AHEAD: usize = 16;

/// Makes boxes tight after the records of so many movers were brought up to date.
pub(crate) struct Refit<'p, 'm, I> {
    pub(crate) parts: &'p mut Parts<'m, I>,
    pub(crate) movers: usize,
}

impl<I: Index> Phase for Refit<'_, '_, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { parts, movers } = self;
        let leaves = 1usize << parts.state.tree.depth;
        // A power of two, so that a mask keeps counts below it. Before, there may have been more leaves; and a snapshot can say
        // anything.
        let all = leaves * MOVERS_PER_LEAF;
        let start = parts.state.tree.moved_since_refit as usize & (all - 1);
        let end = start + movers;
        for turn in start / MOVERS_PER_LEAF..end / MOVERS_PER_LEAF {
            refit(simd, parts, turn & (leaves - 1));
        }
        parts.state.tree.moved_since_refit = (end & (all - 1)) as u32;
    }
}

/// Makes the boxes of one leaf of the last full step tight: its own, those of its parts, those of the nodes above.
#[inline(always)]
fn refit<S: Simd, I: Index>(simd: S, parts: &mut Parts<'_, I>, whole: usize) {
    let boxes = parts.boxes.swept();
    let tree = &mut parts.tree;
    let sub_levels = parts.state.tree.sub_levels();
    let mut around = KeyBox::NOTHING;
    for index in whole << sub_levels..(whole + 1) << sub_levels {
        let leaf = tree.leaves.at(index);
        let members = tree.records.span(leaf.start as usize, leaf.len as usize);
        let mut bounds = Record::NOTHING;
        for (place, record) in members.iter().enumerate() {
            if let Some(ahead) = members.get(place + AHEAD) {
                simd.prefetch(boxes, ahead.slot() as usize);
            }
            bounds.include(record);
            around.include(KeyBox::of(boxes, record.slot() as usize));
        }
        if sub_levels > 0 {
            tree.bounds.put(index, bounds);
        }
    }
    let mut node = (1usize << parts.state.tree.depth) + whole;
    while node > 0 {
        tree.nodes.put(node, around);
        // The two sides of the node above.
        around.include(KeyBox::of(tree.nodes, node ^ 1));
        node /= 2;
    }
}
