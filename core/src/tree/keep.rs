//! Keeps the leaves as they are where few objects leave theirs: all other records are written where they
//! stand, and the leavers are moved.
//!
//! Cells, frames and axes stay too, as the step that filled all leaves last has left them. No frame loses a
//! pair.

use super::enclose::{enclose, number_straddlers};
use super::relocate::relocate_all;
use super::{Cell, Frame, Leaf, Record, large};
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::limits::SLOT_BLOCKS;
use crate::memory::slab::Parts;
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;
use crate::parallel::shared::Shared;
use crate::simd::Simd;
use crate::simd::kernels::run;

/// One in so many objects may leave its leaf in a step in which all others keep their places.
pub(crate) const LEAVERS_SHARE: u32 = 8;

/// Steps in a row that keep the leaves: then all are filled anew, so that frames, the order of records and
/// the statistics of boxes are of late.
const MOST_KEPT: u8 = 32;

/// Brings all objects to their leaves, if few have left theirs in the last full step. Returns whether all
/// leaves are filled then; else they must be filled anew.
pub(crate) fn keep<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> bool {
    let (live, tree, kept) = (parts.state.objects.live, &parts.state.tree, parts.state.step.kept);
    let (leaves, filled) = (tree.count, tree.filled);
    if tree.filled == 0 || tree.heavy != 0 || tree.uneven != 0 || !(1..=MOST_KEPT).contains(&kept) {
        return false;
    }
    let left = rewrite(parts, context);
    parts.state.tree.filled = 0;
    if left > live / LEAVERS_SHARE || !relocate_all(parts, left as usize, context) {
        return false;
    }
    let large = parts.state.tree.large;
    let straddlers = number_straddlers(parts, context);
    if !large::fit(straddlers.into(), large.into(), leaves, live, parts.tree.straddlers.len()) {
        return false;
    }
    large::seat(parts, straddlers, large);
    large::arrange(parts, true);
    enclose(parts, true, context);
    parts.state.tree.filled = filled;
    parts.state.step.kept += 1;
    true
}

/// Writes the records of all objects that are still in their leaf, and the slots of the leavers, of new and
/// removed ones and of large ones to the front of the scratch memory. Returns how many those are.
fn rewrite<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> u32 {
    let slots = parts.state.objects.slots as usize;
    let len = slots.div_ceil(SLOT_BLOCKS).next_multiple_of(32);
    let (boxes, homes, places) = (parts.boxes.swept(), &*parts.home, &*parts.place);
    let leaves = parts.tree.leaves.span(0, parts.state.tree.count as usize);
    let (cells, frames) = (&*parts.tree.cells, &*parts.tree.frames);
    let records = Shared::new(parts.tree.records);
    let mut left = [0; SLOT_BLOCKS];
    let moved = &*parts.moved.words;
    let leavers = parts.spare.span_mut(0, slots);
    context.each((Chunks::new(leavers, len), Chunks::new(&mut left, 1)), |block, (leavers, left)| {
        let (first, count) = (block * len, leavers.len());
        let (boxes, homes, places) =
            (boxes.span(first, count), homes.span(first, count), places.span(first, count));
        let stay = moved.span(first / 32, count.div_ceil(32)).iter().all(|word| *word == 0);
        if stay && homes.iter().all(|home| *home == I::NONE) {
            // A pool of disabled objects.
            return;
        }
        let (slots, tree) = ((homes, places), (cells, frames, leaves));
        left.fill(run!(context.kernels, |simd| {
            rewrite_block(simd, (first, boxes), slots, tree, records, leavers)
        }));
    });
    let (list, mut end) = (&mut *parts.spare, 0);
    for (block, left) in left.iter().enumerate() {
        for index in block * len..block * len + *left as usize {
            list.put(end, list.at(index));
            end += 1;
        }
    }
    end as u32
}

/// The same for some consecutive slots, from a first one on.
#[inline(always)]
fn rewrite_block<S: Simd, I: Index>(
    simd: S,
    (first, boxes): (usize, &[KeyBox]),
    (homes, places): (&[I], &[I]),
    (cells, frames, leaves): (&[Cell], &[Frame], &[Leaf]),
    records: Shared<'_, Record>,
    leavers: &mut [I],
) -> u32 {
    // Of one length, so that one check of an index serves all.
    let (Some(cells), Some(frames)) = (cells.get(..leaves.len()), frames.get(..leaves.len())) else {
        return 0;
    };
    let mut left = 0;
    for (index, ((bounds, home), place)) in boxes.iter().zip(homes).zip(places).enumerate() {
        let slot = (first + index) as u32;
        let mut stays = bounds.is_empty() && *home == I::NONE;
        if let (Some(cell), Some(frame), Some(leaf)) =
            (cells.get(home.at()), frames.get(home.at()), leaves.get(home.at()))
        {
            let keys = simd.keys(bounds);
            let classified = cell.classify(simd, keys);
            // Also of one that leaves: it is moved anyway.
            let record = simd.record(frame, keys, slot | classified.marks());
            records.store(leaf.start as usize + place.at(), &record);
            stays = classified.is_member() && !bounds.is_empty();
        }
        // Written always, kept or not, so that nothing depends on a guess of the branch predictor.
        leavers.put(left as usize, I::from_slot(slot));
        left += u32::from(!stays);
    }
    left
}
