//! Makes the boxes of nodes tight again, since movers only make them larger. Each step with movers refits as many
//! leaves as the movers pay for, so a crowd that is calm for hours stays as cheap as it was.

use super::Record;
use super::limits::MOVERS_PER_REFIT;
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::prefetch::REFIT_AHEAD;
use crate::memory::slab::Parts;
use crate::simd::{Phase, Simd};

/// Makes boxes tight, after the records of `movers` objects were moved.
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
        // A power of two, so that a mask keeps counts below it. A count may be too large: there may have been more
        // leaves before, and a snapshot may hold any number.
        let all = leaves * MOVERS_PER_REFIT;
        let start = parts.state.tree.moved_since_refit as usize & (all - 1);
        let end = start + movers;
        for turn in start / MOVERS_PER_REFIT..end / MOVERS_PER_REFIT {
            refit(simd, parts, turn & (leaves - 1));
        }
        parts.state.tree.moved_since_refit = (end & (all - 1)) as u32;
    }
}

/// Makes the boxes of one whole leaf tight: its own, those of its sub-leaves, those of the nodes above.
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
            if let Some(ahead) = members.get(place + REFIT_AHEAD) {
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
        // With the sibling it makes the node above.
        around.include(KeyBox::of(tree.nodes, node ^ 1));
        node /= 2;
    }
}
