//! Fills all leaves: a counting sort of the objects by leaf, in the order of their slots.
//!
//! The first pass finds the leaf of each object (its last leaf, or a walk down the tree) and counts. The second
//! pass writes records and large objects where the counts say. Both read the boxes in memory order and write
//! each leaf in sequence. Any worker may take any block of slots; the result is that of one worker that takes
//! them in order.

use super::cells::{cut, frame};
use super::enclose::{enclose, number_straddlers};
use super::shape::join;
use super::sharpen::sharpen;
use super::{Cell, Leaf, Nodes, Planes, Straddler, large, leaves_of, most};
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::limits::{ROOM, SLOT_BLOCKS, block_len, histogram_row, slot_blocks};
use crate::memory::slab::{Parts, TreeParts};
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;
use crate::parallel::shared::Shared;
use crate::simd::Simd;
use crate::simd::kernels::run;
use crate::tree::{Frame, Record};

/// Slots of which the leavers are listed, before they are told where they go.
const LISTED: usize = 128;

/// Finds the leaf of every object and counts. Then each leaf has its count, and the histogram tells where in
/// their leaf the objects of each block of slots begin. Returns the bounds of minima, and how many objects left
/// their leaf.
pub(crate) fn count<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> (KeyBox, u32) {
    let (leaves, extent) = (parts.state.tree.count as usize, parts.state.tree.extent);
    let TreeParts { boxes, splits, parents, tops, cells, .. } = &mut parts.tree;
    cut(Nodes { boxes, splits, parents, tops }, &extent, cells.span_mut(0, leaves), context);
    let nodes = parts.tree.nodes();
    let depths = nodes.tops.span(0, leaves).iter().map(|top| nodes.depth(*top as usize));
    parts.state.tree.height = depths.max().unwrap_or(0) as u16;
    let counted = count_in(parts, leaves, context);
    let counted_in = parts.tree.leaves.span_mut(0, leaves);
    counted_in.iter_mut().for_each(|leaf| leaf.len = 0);
    let (blocks, row) = (slot_blocks(context.workers), histogram_row(leaves));
    for histogram in parts.tree.histogram.span_mut(0, blocks * row).chunks_exact_mut(row.max(1)) {
        for (leaf, members) in counted_in.iter_mut().zip(histogram) {
            leaf.len += core::mem::replace(members, leaf.len);
        }
    }
    counted
}

/// Plans leaves twice as large, and joins what is smaller: ghosts and large objects are too many.
pub(crate) fn coarsen<I: Index>(parts: &mut Parts<'_, I>) {
    parts.state.tree.coarser += 1;
    let most = most(parts.state);
    let mut before = 0;
    while before != parts.state.tree.count {
        before = parts.state.tree.count;
        for leaf in (1..before as usize).rev() {
            join(&mut parts.tree, &mut parts.state.tree, leaf, most);
        }
    }
}

fn count_in<I: Index>(parts: &mut Parts<'_, I>, leaves: usize, context: StepContext<'_>) -> (KeyBox, u32) {
    let slots = parts.state.objects.slots as usize;
    let (blocks, row) = (slot_blocks(context.workers), histogram_row(leaves));
    let len = block_len(slots, blocks);
    let boxes = parts.boxes.swept();
    let planes = (&*parts.tree.splits, parts.state.tree.height);
    let cells = parts.tree.cells.span(0, leaves);
    let mut found = [(KeyBox::EMPTY, 0); SLOT_BLOCKS];
    let histogram = parts.tree.histogram.span_mut(0, blocks * row);
    histogram.fill(0);
    let blocks = (
        Chunks::new(parts.home.span_mut(0, slots), len),
        Chunks::new(histogram, row),
        Chunks::new(&mut found, 1),
    );
    context.each(blocks, |block, (homes, histogram, found)| {
        let boxes = boxes.span(block * len, homes.len());
        found.fill(run!(context.kernels, |simd| count_block(simd, boxes, homes, planes, cells, histogram)));
    });
    let (mut extent, mut left) = (KeyBox::EMPTY, 0);
    for (part, leavers) in &found {
        left += leavers;
        extent.include(part);
    }
    (extent, left)
}

/// The same for some consecutive slots.
#[inline(always)]
fn count_block<S: Simd, I: Index>(
    simd: S,
    boxes: &[KeyBox],
    homes: &mut [I],
    planes: Planes<'_>,
    cells: &[Cell],
    histogram: &mut [u32],
) -> (KeyBox, u32) {
    // Of one length, so that one check of an index is enough.
    let Some((counts, large)) = histogram.split_at_mut_checked(cells.len()) else {
        return (KeyBox::EMPTY, 0);
    };
    let (mut extent, mut left) = (KeyBox::EMPTY, 0);
    for (boxes, homes) in boxes.chunks(LISTED).zip(homes.chunks_mut(LISTED)) {
        // Listed first, since who leaves is hard to predict.
        let (mut leavers, mut count) = ([0u8; LISTED], 0);
        for (at, (bounds, home)) in boxes.iter().zip(&*homes).enumerate() {
            let mut stays = false;
            if let (Some(cell), Some(members)) = (cells.get(home.at()), counts.get_mut(home.at())) {
                stays = cell.classify(simd, simd.keys(bounds)).is_member();
                *members += u32::from(stays);
            }
            // Without a branch.
            let mask = -i32::from(stays);
            extent.include(&KeyBox {
                min: bounds.min.map(|low| low & mask | i32::MAX & !mask),
                max: bounds.min.map(|low| low & mask | i32::MIN & !mask),
            });
            leavers.put(count, at as u8);
            count += usize::from(!stays && (*home != I::NONE || !bounds.is_empty()));
        }
        for four in leavers.span(0, count).chunks(4) {
            let corner = |at| &KeyBox::of(boxes, four.at(at).into()).min;
            let goals = leaves_of(planes, [0, 1, 2, 3].map(|at: usize| corner(at.min(four.len() - 1))));
            for (at, leaf) in four.iter().map(|at| usize::from(*at)).zip(goals) {
                let (bounds, home) = (KeyBox::of(boxes, at), homes.at(at));
                let is_large = cells.at(leaf).classify(simd, simd.keys(bounds)).is_large();
                let goal = if bounds.is_empty() {
                    I::NONE
                } else if is_large {
                    large.put(0, large.at(0) + 1);
                    I::LARGE
                } else {
                    extent.include(&KeyBox::point(bounds.min));
                    counts.put(leaf, counts.at(leaf) + 1);
                    I::from_slot(leaf as u32)
                };
                // The object is new, large, or has left its leaf.
                left += u32::from(!bounds.is_empty() && home != I::LARGE);
                homes.put(at, goal);
            }
        }
    }
    // Infinite coordinates would make frames too coarse, as would large objects.
    extent.make_finite();
    (extent, left)
}

/// Gives leaves their places, writes all records there, lists straddlers and large objects, and finds the boxes
/// of nodes. Returns whether straddlers and large objects fit: leaves are to be [coarser](coarsen) if not.
pub(crate) fn fill<I: Index>(parts: &mut Parts<'_, I>, extent: &KeyBox, context: StepContext<'_>) -> bool {
    let leaves = parts.state.tree.count as usize;
    let (mut record, mut large) = (0, 0);
    let (most, row) = (most(parts.state) as u32, histogram_row(leaves));
    for leaf in parts.tree.leaves.span_mut(0, leaves) {
        leaf.start = record;
        // Some room, so that objects can come without a new fill; none where it would be too full.
        leaf.room = (leaf.len + leaf.len / 8 + ROOM).min(leaf.len.max(most));
        record += leaf.room;
    }
    // Where the large objects of each block go: to the end of the array, until the number of straddlers is known.
    for count in
        parts.tree.histogram.iter_mut().take(slot_blocks(context.workers) * row).skip(leaves).step_by(row)
    {
        large += core::mem::replace(count, large);
    }
    if !large::fit(parts, 0, large) {
        return false;
    }
    parts.state.tree.extent = *extent;
    frame(parts.tree.cells.span(0, leaves), extent, parts.tree.frames);
    let list = parts.tree.straddlers.len() - large as usize;
    scatter(parts, leaves, list, context);
    let straddlers = number_straddlers(parts, context);
    if !large::fit(parts, straddlers, large) {
        return false;
    }
    large::seat(parts, list, straddlers, large);
    large::arrange(parts, true);
    sharpen(parts, context);
    enclose(parts, context);
    parts.state.tree.filled = 1;
    true
}

/// Writes records, and the large objects, from a straddler on.
fn scatter<I: Index>(parts: &mut Parts<'_, I>, leaf_count: usize, list: usize, context: StepContext<'_>) {
    let slots = parts.state.objects.slots as usize;
    let (blocks, row) = (slot_blocks(context.workers), histogram_row(leaf_count));
    let len = block_len(slots, blocks);
    let boxes = parts.boxes.swept();
    let homes = &*parts.home;
    let (cells, frames, leaves) =
        (parts.tree.cells.span(0, leaf_count), &*parts.tree.frames, parts.tree.leaves.span(0, leaf_count));
    let tree = (cells, frames, leaves);
    let (records, straddlers) = (Shared::new(parts.tree.records), Shared::new(parts.tree.straddlers));
    let blocks = (
        Chunks::new(parts.place.span_mut(0, slots), len),
        Chunks::new(parts.tree.histogram.span_mut(0, blocks * row), row),
    );
    context.each(blocks, |block, (places, histogram)| {
        let first = block * len;
        let boxes = (first, boxes.span(first, places.len()));
        let (slots, list) = ((homes.span(first, places.len()), places), (straddlers, list));
        run!(context.kernels, |simd| scatter_block(simd, boxes, slots, tree, records, list, histogram));
    });
}

/// The same for some consecutive slots, from a first one on.
#[inline(always)]
fn scatter_block<S: Simd, I: Index>(
    simd: S,
    (first, boxes): (usize, &[KeyBox]),
    (homes, places): (&[I], &mut [I]),
    (cells, frames, leaves): (&[Cell], &[Frame], &[Leaf]),
    records: Shared<'_, Record>,
    (straddlers, list): (Shared<'_, Straddler>, usize),
    histogram: &mut [u32],
) {
    // Of one length, for the same reason.
    let (Some((next, large)), Some(cells), Some(frames)) =
        (histogram.split_at_mut_checked(leaves.len()), cells.get(..leaves.len()), frames.get(..leaves.len()))
    else {
        return;
    };
    for (index, ((bounds, home), place)) in boxes.iter().zip(homes).zip(places).enumerate() {
        let slot = (first + index) as u32;
        let leaf = home.at();
        if let (Some(next), Some(cell), Some(frame), Some(leaf)) =
            (next.get_mut(leaf), cells.get(leaf), frames.get(leaf), leaves.get(leaf))
        {
            let at = core::mem::replace(next, *next + 1);
            *place = I::from_slot(at);
            let keys = simd.keys(bounds);
            let record = simd.record(frame, keys, slot | cell.classify(simd, keys).marks());
            records.store((leaf.start + at) as usize, &record);
        } else if *home == I::LARGE {
            let at = large.at(0);
            large.put(0, at + 1);
            *place = I::from_slot(at);
            straddlers.store(list + at as usize, &Straddler { bounds: *bounds, slot, long: 0 });
        }
    }
}
