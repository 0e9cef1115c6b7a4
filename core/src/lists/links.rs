//! The sorted list (paper, section III.A): each object once, by ascending minimum on one axis.
//!
//! An array of slots (erratum E12), in a total order: by key, then by slot (erratum E10). Worlds without a
//! tree keep that of their sweep axis from step to step. Others have none (erratum E13).

use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::slab::Parts;

/// Objects that each object may overtake, on average, before it is cheaper to sort over long distances first.
const INVERSIONS_PER_OBJECT: usize = 4;

/// Makes the list hold exactly the living objects, by slot. O(slots).
pub(crate) fn list_all<I: Index>(parts: &mut Parts<'_, I>) {
    let Parts { state, boxes, order: [order, ..], .. } = parts;
    let mut listed = 0;
    for (slot, bounds) in (0..state.objects.slots).zip(boxes.now.iter()) {
        if !bounds.is_empty() {
            order.put(listed, I::from_slot(slot));
            listed += 1;
        }
    }
    (state.lists.listed, state.lists.stale) = (listed as u32, 0);
}

/// Sorts one list: by insertion while that is cheap, else Shell's sort. O(n + inversions), or about
/// O(n^1.3) for as many as lists have.
#[inline(never)]
pub(crate) fn repair<I: Index>(order: &mut [I], boxes: &[KeyBox], axis: usize) {
    let axis = axis.min(2);
    let low = |slot: I| KeyBox::of(boxes, slot.at()).min[axis];
    let mut budget = INVERSIONS_PER_OBJECT * order.len() + 64;
    for gap in [1_u8, 57, 23, 10, 4, 1] {
        let gap = usize::from(gap);
        let mut most = i32::MIN;
        for index in 0..order.len() {
            let slot = order.at(index);
            let (this, mut to) = (low(slot), index);
            if gap == 1 && most < this {
                // In order already, as most are.
                most = this;
                continue;
            }
            while to >= gap {
                let other = order.at(to - gap);
                if (low(other), other) < (this, slot) {
                    break;
                }
                order.put(to, other);
                to -= gap;
            }
            order.put(to, slot);
            budget = budget.saturating_sub(index - to);
            if budget == 0 {
                break;
            }
        }
        if gap == 1 && budget > 0 {
            return;
        }
        budget = usize::MAX;
    }
}
