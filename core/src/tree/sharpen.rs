//! Makes frames narrower if their grid is far wider than where most members are: a few objects far from the
//! others, in a cell at the rim, stretch it until all other objects share a few steps. Outliers then get the
//! first or the last step, which loses no pair.

use super::cells::Sample;
use super::{Cell, Frame, Leaf, Record};
use crate::access::Access;
use crate::geometry::extent::Extent;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::slab::Parts;
use crate::simd::Simd;
use crate::simd::kernels::Kernels;
use crate::simd::kernels::run;

/// Makes such frames narrower, and the records of their leaves anew, as a sample of each leaf tells. O(leaves + members of
/// those leaves).
pub(crate) fn sharpen<I: Index>(parts: &mut Parts<'_, I>, kernels: Kernels) {
    let leaves = parts.state.tree.count as usize;
    let extent = parts.state.tree.extent;
    let boxes = parts.boxes.swept();
    let tree = &mut parts.tree;
    for ((cell, frame), leaf) in
        tree.cells.span(0, leaves).iter().zip(&mut *tree.frames).zip(&mut *tree.leaves)
    {
        let members = tree.records.span_mut(leaf.start as usize, leaf.len as usize);
        run!(kernels, |simd| sharpen_leaf(simd, boxes, &extent, cell, frame, leaf, members));
    }
}

/// Makes the frame of one leaf from where most of its members are.
#[inline(always)]
fn sharpen_leaf<S: Simd>(
    simd: S,
    boxes: &[KeyBox],
    extent: &Extent,
    cell: &Cell,
    frame: &mut Frame,
    leaf: &mut Leaf,
    members: &mut [Record],
) {
    let minimum = |at| members.get(at).map(|record: &Record| KeyBox::of(boxes, record.slot() as usize).min);
    let sample = Sample::of(members.len(), minimum);
    let (low, high) = extent.clip(cell);
    let narrow = Extent { low, high }.trimmed(&sample);
    // If they are all at one point, no grid tells them apart, but the wide one tells the rest.
    if (narrow.low, narrow.high) == (low, high) || narrow.low == narrow.high {
        return;
    }
    *frame = Frame::over(narrow.low, narrow.high);
    leaf.axis = frame.longest_axis() as u32;
    for record in members {
        let bounds = KeyBox::of(boxes, record.slot() as usize);
        *record = simd.record(frame, simd.keys(bounds), record.tag);
    }
}
