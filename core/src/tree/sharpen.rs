//! Makes frames narrower if their grid is far wider than where most members are: a few objects far from the
//! others, in a cell at the rim, stretch it until all other objects share a few steps. Outliers then get the
//! first or the last step, which loses no pair.

use super::cells::Sample;
use super::limits::SPARSE;
use super::{Cell, Frame, Record};
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::geometry::record::GRID_MAX;
use crate::id::Index;
use crate::memory::slab::Parts;
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;
use crate::simd::Simd;
use crate::simd::kernels::run;

/// Makes such frames narrower, and the records of their leaves anew, as a sample of each leaf tells. O(n) at
/// most.
pub(crate) fn sharpen<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) {
    let (count, extent) = (parts.state.tree.count as usize, parts.state.tree.extent);
    let boxes = parts.boxes.swept();
    let tree = &mut parts.tree;
    let (cells, leaves, records) = (tree.cells.span(0, count), &*tree.leaves, &*tree.records);
    context.each(Chunks::new(tree.frames.span_mut(0, count), 1), |index, frame| {
        let leaf = leaves.at(index);
        let members = records.span(leaf.start as usize, leaf.len as usize);
        frame.fill(narrow(boxes, &extent, &cells.at(index), members));
    });
    for ((cell, frame), leaf) in cells.iter().zip(&*tree.frames).zip(leaves) {
        if *frame != Frame::over(&extent.clip(cell)) {
            let members = tree.records.span_mut(leaf.start as usize, leaf.len as usize);
            run!(context.kernels, |simd| for record in members {
                let bounds = KeyBox::of(boxes, record.slot() as usize);
                *record = simd.record(frame, simd.keys(bounds), record.tag);
            });
        }
    }
}

/// The frame of a leaf from where most of its members are.
fn narrow(boxes: &[KeyBox], extent: &KeyBox, cell: &Cell, members: &[Record]) -> Frame {
    let minimum = |at| members.get(at).map(|record: &Record| KeyBox::of(boxes, record.slot() as usize).min);
    let wide = extent.clip(cell);
    // Records, which are in order, tell it for most leaves; for the others boxes, which are anywhere.
    let lanes = |Record { lanes: [x, y, z, ..], .. }: &Record| [*x, *y, *z].map(i32::from);
    let steps = Sample::of(members.len(), |at| members.get(at).map(lanes));
    let (low, high) = steps.bounds();
    let is_flat = |k: usize| wide.min[k] == wide.max[k];
    if (0..3).all(|k| is_flat(k) || high[k].saturating_sub(low[k]) > (GRID_MAX / SPARSE) as i32 + 2) {
        return Frame::over(&wide);
    }
    let narrow = wide.trimmed(&Sample::of(members.len(), minimum));
    // If they are all at one point, no grid tells them apart, but the wide one tells the rest.
    Frame::over(if narrow.min == narrow.max { &wide } else { &narrow })
}
