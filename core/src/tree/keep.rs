//! Keeps the leaves as they are where few objects leave theirs: all other records are written where they
//! stand, and the leavers are moved: workers that take slots list them for each leaf, and leave holes; and
//! workers that take leaves let who comes fill the holes.
//!
//! Cells and frames stay too, as the step that filled all leaves last has left them. No frame loses a
//! pair.

use super::enclose::{enclose, number_straddlers};
use super::relocate::{relocate_all, thirds};
use super::{Cell, Frame, Leaf, Planes, Record, Straddler, large, leaf_of};
use crate::access::{Access, bits};
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::limits::{SLOT_BLOCKS, histogram_row, slot_blocks};
use crate::memory::slab::Parts;
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;
use crate::parallel::shared::{Shared, SharedSlots};
use crate::simd::Simd;
use crate::simd::kernels::run;

/// One in so many objects may leave its leaf in a step in which all others keep their places.
pub(crate) const LEAVERS_SHARE: u32 = 8;

/// Steps in a row that keep the leaves: then all are filled anew, so that frames, the order of records and
/// the statistics of boxes are of late.
const MOST_KEPT: u8 = 32;

/// Brings all objects to their leaves, if few have left theirs in the last full step. Else all leaves must be
/// filled anew; returns how many objects have left theirs already.
pub(crate) fn keep<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> Result<(), u32> {
    let (live, tree, kept) = (parts.state.objects.live, &parts.state.tree, parts.state.step.kept);
    let filled = tree.filled;
    if tree.filled == 0 || tree.heavy != 0 || tree.uneven != 0 || !(1..=MOST_KEPT).contains(&kept) {
        return Err(0);
    }
    let left = rewrite(parts, context);
    parts.state.tree.filled = 0;
    if left > live / LEAVERS_SHARE || !settle(parts, context) {
        return Err(left);
    }
    let straddlers = number_straddlers(parts, context);
    let large = parts.state.tree.large;
    if !large::fit(parts, straddlers, large) {
        return Err(left);
    }
    large::seat(parts, parts.state.tree.large_list(), straddlers, large);
    large::renew(parts);
    large::arrange(parts, false);
    enclose(parts, context);
    parts.state.tree.filled = filled;
    parts.state.step.kept += 1;
    Ok(())
}

/// Slots in a block: half of those of other passes at least, as a slot takes longer here.
fn rewritten_len(slots: usize, workers: usize) -> usize {
    slots.div_ceil(slot_blocks(workers)).next_multiple_of(512).max(512)
}

/// Writes the records of all objects that are still in their leaf, and lists the leavers, new ones and large
/// ones; of removed ones that were not large nothing is left but a hole. Returns how many all of these are.
///
/// Each block of slots has a row of the histogram: for each leaf the first one that comes and the first hole,
/// and at last the first one that is to be moved alone, as it is or was in no leaf; all plus one, as zero ends
/// a list. The next one stands where the place of an object does, in the entry of a large one, and in the
/// record of a hole.
fn rewrite<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> u32 {
    let (slots, count) = (parts.state.objects.slots as usize, parts.state.tree.count as usize);
    let (blocks, row) = (slot_blocks(context.workers), histogram_row(count));
    let len = rewritten_len(slots, context.workers);
    let (boxes, moved) = (parts.boxes.swept(), &*parts.moved.words);
    let leaves = parts.tree.leaves.span(0, count);
    let planes = (&*parts.tree.splits, parts.state.tree.height);
    let tree = (&*parts.tree.cells, &*parts.tree.frames, planes, leaves);
    let (large, _) = large::split(&parts.state.tree, parts.tree.straddlers);
    let shared = (Shared::new(parts.tree.records), Shared::new(large));
    let mut left = [0; SLOT_BLOCKS];
    let blocks = (
        Chunks::new(parts.home.span_mut(0, slots), len),
        Chunks::new(parts.place.span_mut(0, slots), len),
        Chunks::new(parts.tree.histogram.span_mut(0, blocks * row), row),
        Chunks::new(&mut left, 1),
    );
    context.each(blocks, |block, (homes, places, lists, left)| {
        let (first, count) = (block * len, homes.len());
        lists.fill(0);
        let slots = (boxes.span(first, count), homes, places);
        let first = (first, moved.span(first / 32, count.div_ceil(32)));
        left.fill(run!(context.kernels, |simd| rewrite_block(simd, first, slots, tree, shared, lists)));
    });
    left.iter().sum()
}

/// The same for some consecutive slots, from a first one on, and of moved objects alone.
#[inline(always)]
fn rewrite_block<S: Simd, I: Index>(
    simd: S,
    (first, moved): (usize, &[u32]),
    (boxes, homes, places): (&[KeyBox], &mut [I], &mut [I]),
    (cells, frames, planes, leaves): (&[Cell], &[Frame], Planes<'_>, &[Leaf]),
    (records, large): (Shared<'_, Record>, Shared<'_, Straddler>),
    lists: &mut [u32],
) -> u32 {
    // Of one length, so that one check of an index serves all.
    let (Some(cells), Some(frames)) = (cells.get(..leaves.len()), frames.get(..leaves.len())) else {
        return 0;
    };
    let (lists, [alone]) = lists.as_chunks_mut::<2>() else { return 0 };
    let mut left = 0;
    let words = boxes.chunks(32).zip(homes.chunks_mut(32)).zip(places.chunks_mut(32)).zip(moved);
    // From the last one on, so that lists are in ascending order.
    for (word, (((boxes, homes), places), moved)) in words.enumerate().rev() {
        let at = 32 * word;
        // Noted for all of them first, since who leaves is hard to predict.
        let mut leavers = 0u32;
        let len = boxes.len();
        let (Some(held), Some(known)) = (homes.get(..len), places.get(..len)) else { return left };
        for bit in bits::of_word(*moved) {
            let (Some(bounds), Some(home), Some(place)) = (boxes.get(bit), held.get(bit), known.get(bit))
            else {
                break;
            };
            // An empty box is at home nowhere.
            let stays = if let (Some(cell), Some(frame), Some(leaf)) =
                (cells.get(home.at()), frames.get(home.at()), leaves.get(home.at()))
            {
                let keys = simd.keys(bounds);
                let classified = cell.classify(simd, keys);
                // Also of one that leaves: a hole will be there.
                let record = simd.record(frame, keys, (first + at + bit) as u32 | classified.marks());
                records.store(leaf.start as usize + place.at(), &record);
                classified.is_member()
            } else {
                bounds.is_empty() && *home == I::NONE
            };
            leavers |= u32::from(!stays) << bit;
        }
        while let Some(bit) = leavers.checked_ilog2() {
            leavers &= !(1 << bit);
            let bit = bit as usize;
            let (bounds, home) = (KeyBox::of(boxes, bit), homes.at(bit));
            let goal = leaf_of(planes, &bounds.min);
            let is_large = cells.at(goal).classify(simd, simd.keys(bounds)).is_large();
            if home == I::LARGE && is_large && !bounds.is_empty() {
                continue;
            }
            left += 1;
            if let (Some(leaf), Some([_, hole])) = (leaves.get(home.at()), lists.get_mut(home.at())) {
                let record = Record { tag: Record::HOLE | *hole, ..Record::NOTHING };
                *hole = places.at(bit).slot() + 1;
                records.store((leaf.start + *hole - 1) as usize, &record);
                homes.put(bit, I::NONE);
            }
            let this = (first + at + bit) as u32 + 1;
            if home == I::LARGE {
                let place = places.at(bit).at();
                let next = core::mem::replace(alone, this);
                large.store(place, &Straddler { slot: next, ..large.load(place) });
            } else if !bounds.is_empty() {
                let list = match lists.get_mut(goal) {
                    Some([comers, _]) if !is_large => {
                        homes.put(bit, I::from_slot(goal as u32));
                        comers
                    }
                    _ => &mut *alone,
                };
                places.put(bit, I::from_slot(core::mem::replace(list, this)));
            }
        }
    }
    left
}

/// Moves the leavers that [`rewrite`] has listed. Returns whether there was room.
fn settle<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> bool {
    let (slots, count) = (parts.state.objects.slots as usize, parts.state.tree.count as usize);
    let (len, row) = (rewritten_len(slots, context.workers), histogram_row(count));
    let lists = parts.tree.histogram.span(0, slots.div_ceil(len) * row);
    let rows = || lists.chunks_exact(row.max(1));
    let (boxes, places) = (parts.boxes.swept(), SharedSlots::new(parts.place));
    let (cells, frames) = (&*parts.tree.cells, &*parts.tree.frames);
    let records = Shared::new(parts.tree.records);
    let leaves = parts.tree.leaves.span_mut(0, count);
    context.each(Chunks::new(leaves, 1), |index, leaves| {
        for leaf in leaves {
            let firsts = [0, 1].map(|which| rows().map(move |row| row.at(2 * index + which)));
            let (tree, arrays) = ((&cells.at(index), &frames.at(index)), (boxes, places));
            run!(context.kernels, |simd| settle_leaf(simd, leaf, tree, firsts, arrays, records));
        }
    });
    let fits = leaves.iter().all(|leaf| leaf.len <= leaf.room);
    let ([movers, ..], mut alone) = (thirds(parts.spare), 0);
    let (large, _) = large::split(&parts.state.tree, parts.tree.straddlers);
    for mut link in rows().map(|row| row.at(2 * count)) {
        while let Some(slot) = link.checked_sub(1) {
            let Some(mover) = movers.get_mut(alone) else { return false };
            (*mover, alone) = (I::from_slot(slot), alone + 1);
            link = parts.place.at(slot as usize).slot();
            if parts.home.at(slot as usize) == I::LARGE
                && let Some(entry) = large.get_mut(link as usize)
            {
                link = core::mem::replace(&mut entry.slot, slot);
            }
        }
    }
    fits && relocate_all(parts, alone, context)
}

/// Who comes to a leaf takes the holes in it, then the free places; other holes are filled up from the end.
/// Too many members tell that there was no room.
#[inline(always)]
fn settle_leaf<S: Simd, I: Index>(
    simd: S,
    leaf: &mut Leaf,
    (cell, frame): (&Cell, &Frame),
    [comers, holes]: [impl Iterator<Item = u32>; 2],
    (boxes, places): (&[KeyBox], SharedSlots<'_, I>),
    records: Shared<'_, Record>,
) {
    let start = leaf.start;
    let mut comers = linked(comers, |slot| places.load(slot as usize).slot());
    let after = |hole| records.load((start + hole) as usize).tag & !Record::HOLE;
    // No more than there can be, whatever the memory holds.
    let mut holes = linked(holes, after).take(leaf.len as usize);
    loop {
        match (comers.next(), holes.next()) {
            (Some(slot), hole) => {
                let place = hole.unwrap_or(leaf.len);
                leaf.len = leaf.len.max(place + 1);
                if leaf.len > leaf.room {
                    return;
                }
                let keys = simd.keys(KeyBox::of(boxes, slot as usize));
                let record = simd.record(frame, keys, slot | cell.classify(simd, keys).marks());
                records.store((start + place) as usize, &record);
                places.store(slot as usize, I::from_slot(place));
            }
            (None, Some(hole)) => {
                while hole < leaf.len {
                    leaf.len -= 1;
                    let last = records.load((start + leaf.len) as usize);
                    if last.tag & Record::HOLE == 0 {
                        records.store((start + hole) as usize, &last);
                        places.store(last.slot() as usize, I::from_slot(hole));
                        break;
                    }
                }
            }
            (None, None) => return,
        }
    }
}

/// What is in some lists, one list after another. `after` an item comes the next one of its list.
#[inline(always)]
fn linked(mut firsts: impl Iterator<Item = u32>, after: impl Fn(u32) -> u32) -> impl Iterator<Item = u32> {
    let mut link = 0;
    core::iter::from_fn(move || {
        while link == 0 {
            link = firsts.next()?;
        }
        let this = link - 1;
        link = after(this);
        Some(this)
    })
}
