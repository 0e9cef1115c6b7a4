//! Steps of worlds without a tree: up to 32 objects are tested two by two; for more one list is kept sorted
//! and swept along (paper, sections III.A and IV).
//!
//! The list has each object once, by ascending minimum on one axis: an array of slots (erratum E12), in a
//! total order by key, then by slot (erratum E10). It is kept from step to step. Worlds with a tree have none
//! (erratum E13).

use super::policy::SCAN_EVERY;
use crate::access::Access;
use crate::config::{LISTS, TREE};
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::scratch::Work;
use crate::memory::slab::Parts;
use crate::memory::state::{ListState, ObjectState};
use crate::pairs::pair_filter::PairFilter;
use crate::pairs::persistent;
use crate::parallel::context::StepContext;
use crate::parallel::executor::Stage;
use crate::sweep::small;
use crate::tree::assign;

/// Objects that each object may overtake, on average, before it is cheaper to sort over long distances first.
const INVERSIONS_PER_OBJECT: usize = 4;

/// Finds all pairs. Returns how many there are.
pub(super) fn small<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> u64 {
    persistent::start_over(parts);
    context.executor.enter(Stage::Build);
    let has_list = LISTS && !parts.sizes.is_tiny();
    if has_list && (parts.state.lists.stale != 0 || parts.state.lists.listed != parts.state.objects.live) {
        list_all(parts);
    }
    let Parts { state, boxes, order, spare, output, filters, .. } = parts;
    let ObjectState { live, slots, has_inserted, .. } = state.objects;
    let boxes = boxes.swept().span(0, slots as usize);
    // Each eighth step and when objects are new: which axis is best, and whether `f32` is too coarse; if there
    // is one to be chosen, or if the build looks at all.
    let mut looks = false;
    if has_list || TREE {
        looks = state.lists.scan_in == 0 || has_inserted != 0;
        state.lists.scan_in = if looks { SCAN_EVERY } else { state.lists.scan_in } - 1;
    }
    let pair_filter = PairFilter::if_needed(filters, slots, &context);
    let mut spared = 0;
    let (pairs, candidates) = if has_list {
        if looks {
            choose_axis(&mut state.lists, boxes);
        }
        let order = order.span_mut(0, live as usize);
        repair(order, boxes, state.lists.axis.into());
        context.executor.enter(Stage::Sweep);
        let mut order = &*order;
        if let Some(pair_filter) = pair_filter.filter(PairFilter::tells_apart) {
            let met = pair_filter.leave_out(order, spare);
            let pairs = |of: usize| (of * of.saturating_sub(1) / 2) as u64;
            (spared, order) = (pairs(order.len()) - pairs(met), spare.span(0, met));
        }
        small::sweep(order, boxes, state.lists.axis, pair_filter, output.pairs)
    } else {
        context.executor.enter(Stage::Sweep);
        small::test_all(boxes, pair_filter.as_ref(), output.pairs)
    };
    let coarse = (TREE && looks).then(|| assign::scan_bounds(boxes.iter()).is_coarse(live));
    let work = Work { candidates: candidates as u64, spared, ..Work::default() };
    state.step.did(work, 1, 0, coarse);
    pairs as u64
}

/// Chooses the axis along which the fewest boxes overlap. O(slots).
fn choose_axis(lists: &mut ListState, boxes: &[KeyBox]) {
    let mut near = [0; 3];
    for (slot, a) in (0u32..).zip(boxes) {
        // Multiples of the golden ratio are spread evenly.
        let b = KeyBox::of(boxes, ((slot.wrapping_mul(0x9e37_79b9) >> 16) as usize * boxes.len()) >> 16);
        (0..3).for_each(|k| near[k] += u32::from(a.min[k] <= b.max[k] && b.min[k] <= a.max[k]));
    }
    // The list of the last axis is in order already, so another one has to be clearly better.
    let last = (lists.axis as usize).min(2);
    lists.axis = (0..3).fold(last, |best, k| if 5 * near[k] < 4 * near[best] { k } else { best }) as u8;
}

/// Makes the list hold exactly the living objects, by slot. O(slots).
fn list_all<I: Index>(parts: &mut Parts<'_, I>) {
    let Parts { state, boxes, order, .. } = parts;
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
fn repair<I: Index>(order: &mut [I], boxes: &[KeyBox], axis: usize) {
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
