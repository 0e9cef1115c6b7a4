//! Moves the records of moved objects to their leaves, in order (paper, section III.B.2).

use super::enclose::expand_ancestors;
use super::limits::{SLACK_AT_LEAST, SLACK_SHARE};
use super::slack::borrow_slack;
use super::{Cell, Frame, Leaf, Record, Straddler, home_of, large};
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::limits::MOVERS_PER_BLOCK;
use crate::memory::slab::Parts;
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;
use crate::parallel::shared::Shared;
use crate::simd::Simd;
use crate::simd::kernels::run;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Brings the first objects in the second of the sorted lists, as many as said, to their leaves or to the
/// large objects. Returns whether there was room. If a leaf and its neighbours or the list of large objects
/// are full, nothing is lost, but all leaves must be filled anew.
///
/// All are taken out of the leaves that they leave, and then put into others, in the order of the list. So
/// what comes of a leaf does not depend on other leaves, and workers share these.
pub(crate) fn relocate_all<I: Index>(
    parts: &mut Parts<'_, I>,
    count: usize,
    context: StepContext<'_>,
) -> bool {
    parts.state.lists.stale = 1;
    let special = find_leaves(parts, count, context);
    each_range(parts, 0..count, context, |range| range.take_out());
    let fits = put_in(parts, 0..count, context);
    (fits && !special) || finish(parts, count, context)
}

/// Finds the leaf of each mover, for the third of the sorted lists; the large objects, or nothing. Its leaf
/// of before goes to the first one. Returns whether some are or were not in leaves.
fn find_leaves<I: Index>(parts: &mut Parts<'_, I>, count: usize, context: StepContext<'_>) -> bool {
    let (boxes, homes, tree, state) = (parts.boxes.swept(), &*parts.home, &parts.tree, &*parts.state);
    let [before, movers, leaves] = &mut parts.order;
    let special = AtomicBool::new(false);
    let blocks = (
        Chunks::new(before.span_mut(0, count), MOVERS_PER_BLOCK),
        Chunks::new(leaves.span_mut(0, count), MOVERS_PER_BLOCK),
    );
    context.each(blocks, |block, (before, leaves)| {
        let movers = movers.iter().skip(block * MOVERS_PER_BLOCK);
        for (slot, (before, leaf)) in movers.zip(before.iter_mut().zip(leaves)) {
            let (bounds, home) = (boxes.at(slot.at()), homes.at(slot.at()));
            let min = &bounds.min;
            let holds = |cell: Cell| (0..3).all(|k| (cell.low()[k]..cell.high()[k]).contains(&min[k]));
            let stays = home < I::LARGE && holds(tree.cells.at(home.at()));
            *before = home;
            *leaf = if stays { home } else { I::from_slot(home_of(tree, state, min) as u32) };
            if bounds.is_empty() {
                *leaf = I::NONE;
            } else if tree.cells.at(leaf.at()).is_exceeded_by(&bounds) {
                *leaf = I::LARGE;
            }
            if home == I::LARGE || *leaf >= I::LARGE {
                special.store(true, Relaxed);
            }
        }
    });
    special.into_inner()
}

/// Some of the leaves, and the movers, of which it takes its own.
struct Range<'b, 's, I: Index> {
    /// The first of the leaves.
    first: usize,
    leaves: &'b mut [Leaf],
    /// Of sub-leaves; or none.
    bounds: &'b mut [Record],
    records: Shared<'s, Record>,
    homes: Shared<'s, I, I>,
    places: Shared<'s, I, I>,
    /// Movers, the leaf of each before, and after.
    lists: (&'b [I], &'b [I], &'b [I]),
    boxes: &'b [KeyBox],
    cells: &'b [Cell],
    frames: &'b [Frame],
    sub_levels: u32,
    /// Some found no room, or are large objects still.
    full: &'b AtomicBool,
}

/// Puts some movers into their leaves. Returns whether there was room.
fn put_in<I: Index>(parts: &mut Parts<'_, I>, of: core::ops::Range<usize>, context: StepContext<'_>) -> bool {
    let kernels = context.kernels;
    each_range(parts, of, context, |range| run!(kernels, |simd| range.put_in(simd)))
}

/// Calls `work` with all leaves, in as many ranges as there are workers and movers for them. Returns whether
/// there was room.
fn each_range<I: Index>(
    parts: &mut Parts<'_, I>,
    of: core::ops::Range<usize>,
    context: StepContext<'_>,
    work: impl Fn(Range<'_, '_, I>) + Sync,
) -> bool {
    let leaves = parts.state.leaves() as usize;
    // Each looks at all movers.
    let workers = context.workers.min(context.executor.workers() as usize).min(of.len() / MOVERS_PER_BLOCK);
    let len = leaves.div_ceil(workers.max(1));
    let sub_levels = parts.state.tree.sub_levels();
    let bounds = parts.tree.bounds.span_mut(0, if sub_levels > 0 { leaves } else { 0 });
    let blocks = (Chunks::new(parts.tree.leaves.span_mut(0, leaves), len), Chunks::optional(bounds, len));
    let (records, homes) = (Shared::new(parts.tree.records), Shared::new(parts.home));
    let (places, boxes) = (Shared::new(parts.place), parts.boxes.swept());
    let [before, movers, after] = parts.order.each_ref().map(|list| list.span(of.start, of.len()));
    let (cells, frames) = (&*parts.tree.cells, &*parts.tree.frames);
    let full = &AtomicBool::new(false);
    context.each(blocks, |block, (leaves, bounds)| {
        let (first, lists) = (block * len, (movers, before, after));
        work(Range {
            first,
            leaves,
            bounds,
            records,
            homes,
            places,
            lists,
            boxes,
            cells,
            frames,
            sub_levels,
            full,
        });
    });
    !full.load(Relaxed)
}

impl<I: Index> Range<'_, '_, I> {
    /// Takes movers out of the leaves that they leave. The last one there takes the place of each.
    fn take_out(self) {
        let (movers, before, after) = self.lists;
        for ((slot, before), after) in movers.iter().zip(before).zip(after) {
            let Some(leaf) = self.leaves.get_mut(before.at().wrapping_sub(self.first)) else { continue };
            let place = self.places.load(slot.at());
            // It may be in the list twice.
            if before == after || place == I::NONE {
                continue;
            }
            leaf.len -= 1;
            let last = self.records.load((leaf.start + leaf.len) as usize);
            self.records.store(leaf.start as usize + place.at(), &last);
            self.places.store(last.slot() as usize, &place);
            self.places.store(slot.at(), &I::NONE);
        }
    }

    /// Puts movers into their leaves, as far as there is room, and writes their records.
    #[inline(always)]
    fn put_in<S: Simd>(self, simd: S) {
        let (movers, _, after) = self.lists;
        for (slot, after) in movers.iter().zip(after) {
            let Some(leaf) = self.leaves.get_mut(after.at().wrapping_sub(self.first)) else { continue };
            let home = self.homes.load(slot.at());
            if home != *after {
                if home == I::LARGE || leaf.len == leaf.room {
                    self.full.store(true, Relaxed);
                    continue;
                }
                self.homes.store(slot.at(), after);
                self.places.store(slot.at(), &I::from_slot(leaf.len));
                leaf.len += 1;
            }
            let keys = simd.keys(KeyBox::of(self.boxes, slot.at()));
            let marks = self.cells.at(after.at()).classify(simd, keys).marks();
            let frame = self.frames.at(after.at() >> self.sub_levels);
            let record = simd.record(&frame, keys, slot.slot() | marks);
            self.records.store(leaf.start as usize + self.places.load(slot.at()).at(), &record);
            if let Some(bounds) = self.bounds.get_mut(after.at().wrapping_sub(self.first)) {
                bounds.include(&record);
            }
        }
    }
}

/// Does what is left: large objects, removed ones, and leaves that were full.
fn finish<I: Index>(parts: &mut Parts<'_, I>, count: usize, context: StepContext<'_>) -> bool {
    let mut budget = (parts.state.objects.live as usize / SLACK_SHARE).max(SLACK_AT_LEAST);
    let fits = (0..count).all(|index| {
        let (slot, leaf) = (parts.order[1].at(index).at(), parts.order[2].at(index));
        let home = parts.home.at(slot);
        if home == I::LARGE && leaf != I::LARGE {
            large::take(parts, parts.place.at(slot).at());
            parts.home.put(slot, I::NONE);
        }
        if leaf == I::NONE {
            parts.home.put(slot, I::NONE);
        } else if leaf == I::LARGE {
            let is_new = home != I::LARGE;
            let place = if is_new { parts.state.tree.large as usize } else { parts.place.at(slot).at() };
            let bounds = parts.boxes.swept().at(slot);
            return large::put(parts, place, Straddler { bounds, slot: slot as u32, long: 0 });
        } else if home != leaf {
            let Leaf { len, room, .. } = parts.tree.leaves.at(leaf.at());
            if len == room && !borrow_slack(&mut parts.tree, parts.state, leaf.at(), &mut budget) {
                return false;
            }
            put_in(parts, index..index + 1, context);
        }
        true
    });
    if !fits {
        parts.state.tree.filled = 0;
    }
    fits
}

/// Grows the boxes of nodes to hold the movers, so many, in the leaves where they are now.
pub(crate) fn enclose_movers<I: Index>(parts: &mut Parts<'_, I>, count: usize) {
    let (boxes, tree, sub_levels) = (parts.boxes.swept(), &mut parts.tree, parts.state.tree.sub_levels());
    let [_, movers, leaves] = &parts.order;
    for (slot, leaf) in movers.span(0, count).iter().zip(&**leaves).filter(|(_, leaf)| **leaf < I::LARGE) {
        let (bounds, top) = (KeyBox::of(boxes, slot.at()), tree.tops.at(leaf.at() >> sub_levels) as usize);
        expand_ancestors(tree.boxes, |node| tree.parents.at(node / 2) as usize, top, bounds);
    }
}

/// Orders the list of movers by leaf, or by whole leaf if they are few; large objects come last, and removed
/// ones are dropped. Their slots are then in the first of the sorted lists, their homes in the third. Returns
/// how many there are. O(movers + leaves).
pub(crate) fn order_movers<I: Index>(parts: &mut Parts<'_, I>, count: usize) -> usize {
    let leaves = parts.state.leaves() as usize;
    // With few movers, a count for each sub-leaf would take longer than it saves.
    let coarser = if count < leaves / 4 { parts.state.tree.sub_levels() } else { 0 };
    let leaves = leaves >> coarser;
    let starts = parts.tree.histogram.span_mut(0, leaves + 2);
    starts.fill(0);
    let [list, movers, homes] = &mut parts.order;
    let movers = movers.span(0, count);
    let all = &*parts.home;
    // Removed objects come last.
    let place_of = |home: I| if home == I::NONE { leaves + 1 } else { (home.at() >> coarser).min(leaves) };
    for slot in movers {
        let place = place_of(all.at(slot.at()));
        starts.put(place, starts.at(place) + 1);
    }
    let mut start = 0;
    for next in &mut *starts {
        start += core::mem::replace(next, start);
    }
    for slot in movers {
        let home = all.at(slot.at());
        let place = place_of(home);
        let at = starts.at(place);
        list.put(at as usize, *slot);
        homes.put(at as usize, home);
        starts.put(place, at + 1);
    }
    // Each entry is now where the next leaf starts.
    starts.at(leaves) as usize
}
