//! The tri-linked sorted lists (paper, section III.A): a list an axis, all objects by ascending minimum.
//!
//! A list is an array of slots (erratum E12). Its order is total: by key, then by slot (erratum E10). No
//! array holds an object's position in a list: a search by its key finds it.
//!
//! Worlds without a tree keep the list of their sweep axis in order from step to step, by an insertion sort
//! while few objects overtake each other, else by a heap sort (erratum E13). Others have no lists.

use crate::access::{Access, bits};
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::slab::Parts;
use crate::sort::heapsort;

/// Objects that each object may overtake, on average, before another sort is cheaper.
const INVERSIONS_PER_OBJECT: usize = 4;

/// The total order of a list.
#[inline(always)]
pub(crate) fn precedes<I: Index>(boxes: &[KeyBox], axis: usize, a: I, b: I) -> bool {
    // By reference: one number of a box is needed.
    let low = |slot: I| boxes.get(slot.at()).map_or(0, |bounds| bounds.min[axis % 3]);
    (low(a), a) < (low(b), b)
}

/// Adds a slot to the end of all three lists; [`repair`] brings it to its place. O(1).
pub(crate) fn append<I: Index>(parts: &mut Parts<'_, I>, slot: u32) {
    // A slot that was freed since the lists were last cleaned is still in them.
    if parts.state.lists.stale == 0 && bits::set(parts.listed, slot as usize) {
        for order in &mut parts.order {
            order.put(parts.state.lists.listed as usize, I::from_slot(slot));
        }
        parts.state.lists.listed += 1;
    }
}

/// Makes the lists hold exactly the living objects, in their old order if there is one. O(n).
pub(crate) fn list_all<I: Index>(parts: &mut Parts<'_, I>) {
    let boxes = &*parts.boxes.now;
    if parts.state.lists.stale != 0 {
        parts.state.lists.listed = parts.state.objects.slots;
        for slot in 0..parts.state.objects.slots {
            for order in &mut parts.order {
                order.put(slot as usize, I::from_slot(slot));
            }
        }
    }
    let mut kept = 0;
    for order in &mut parts.order {
        kept = 0;
        for index in 0..parts.state.lists.listed as usize {
            let slot = order.at(index);
            if !boxes.at(slot.at()).is_empty() {
                order.put(kept, slot);
                kept += 1;
            }
        }
    }
    parts.state.lists.listed = kept as u32;
    parts.state.lists.stale = 0;
    parts.listed.fill(0);
    for slot in parts.order[0].span(0, kept) {
        bits::set(parts.listed, slot.at());
    }
}

/// Sorts one list: by insertion while that is cheap, else by a heap sort. O(n + inversions), or O(n log n).
#[inline(never)]
pub(crate) fn repair<I: Index>(order: &mut [I], boxes: &[KeyBox], axis: usize) {
    let low = |slot: I| boxes.get(slot.at()).map_or(0, |bounds| bounds.min[axis % 3]);
    let mut budget = INVERSIONS_PER_OBJECT * order.len() + 64;
    let Some(&first) = order.first() else { return };
    // The last one that is in order.
    let mut last = (low(first), first);
    for index in 1..order.len() {
        let slot = order.at(index);
        let this = (low(slot), slot);
        if last < this {
            last = this;
            continue;
        }
        let mut to = index;
        while to > 0 && precedes(boxes, axis, slot, order.at(to - 1)) {
            order.put(to, order.at(to - 1));
            to -= 1;
        }
        order.put(to, slot);
        match budget.checked_sub(index - to) {
            Some(left) => budget = left,
            None => return heapsort(order, |a, b| precedes(boxes, axis, a, b)),
        }
    }
}
