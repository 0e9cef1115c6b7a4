//! Steps of worlds without a tree: up to 32 objects are tested two by two; for more one list is kept sorted
//! and swept along (paper, sections III.A and IV).
//!
//! The list has each object once, by ascending minimum on one axis: an array of slots (erratum E12), in a
//! total order by key, then by slot (erratum E10). It is kept from step to step. Worlds with a tree have none
//! (erratum E13). Where there are filters, objects that can meet nobody stand at its end, in no order.

use super::policy::SCAN_EVERY;
use crate::access::Access;
use crate::config::{LISTS, TREE};
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::scratch::Work;
use crate::memory::slab::Parts;
use crate::memory::state::{ListState, ObjectState, slot};
use crate::pairs::pair_filter::PairFilter;
use crate::pairs::persistent;
use crate::parallel::context::StepContext;
use crate::parallel::executor::Stage;
use crate::sort::heapsort;
use crate::sweep::small;
use crate::tree::assign;

/// Objects that each object may overtake, on average, before it is cheaper to sort over long distances first.
const INVERSIONS_PER_OBJECT: usize = 4;

/// Finds all pairs. Returns how many there are.
pub(super) fn small<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> u64 {
    persistent::start_over(parts);
    context.executor.enter(Stage::Build);
    let has_list = LISTS && !parts.sizes.is_tiny();
    let ListState { stale, listed, .. } = parts.state.lists;
    if has_list && (stale != 0 || u32::from(listed) != parts.state.objects.live) {
        list_all(parts);
    }
    let Parts { state, boxes, list, output, filters, .. } = parts;
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
        let mut list = list.span_mut(0, live as usize);
        if let Some(pair_filter) = pair_filter.filter(PairFilter::tells_apart) {
            let met = pair_filter.leave_out(list);
            let pairs = |of: usize| (of * of.saturating_sub(1) / 2) as u64;
            spared = pairs(list.len()) - pairs(met);
            list = list.span_mut(0, met);
        }
        sort(boxes, list, &state.lists);
        context.executor.enter(Stage::Sweep);
        small::sweep(boxes, list, state.lists.axis, pair_filter, output.pairs)
    } else {
        context.executor.enter(Stage::Sweep);
        small::test_all(boxes, pair_filter.as_ref(), output.pairs)
    };
    let coarse = (TREE && looks).then(|| assign::scan_bounds(boxes.iter()).is_coarse(live));
    let work = Work { candidates: candidates as u64, spared, ..Work::default() };
    state.step.did(work, 1, 0, coarse);
    pairs as u64
}

/// Chooses the axis along which the fewest boxes overlap, and a grid over the sides on another one. O(slots).
#[inline(never)]
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
    let [_, u] = lists.axes();
    let least = boxes.iter().fold(i32::MAX, |least, bounds| least.min(bounds.min[u])) >> 16;
    let most = boxes.iter().fold(i32::MIN, |most, bounds| most.max(bounds.max[u])) >> 1;
    let unused = (most.wrapping_sub(least << 15) as u32).leading_zeros();
    (lists.least, lists.shift) = (least as i16, (u32::BITS - small::BITS).saturating_sub(unused) as u8);
}

/// Makes the list hold exactly the living objects, by slot. O(slots).
fn list_all<I: Index>(parts: &mut Parts<'_, I>) {
    let Parts { state, boxes, list, .. } = parts;
    let mut listed = 0;
    for (slot, bounds) in (0..state.objects.slots).zip(boxes.now.iter()) {
        if !bounds.is_empty() {
            list.put(listed, slot as i32);
            listed += 1;
        }
    }
    (state.lists.listed, state.lists.stale) = (listed as u16, 0);
}

/// Sorts the list, and writes its words anew: by insertion, or by the upper bits of minima before.
/// O(n + inversions), or O(n log n).
#[inline(never)]
fn sort(boxes: &[KeyBox], list: &mut [i32], lists: &ListState) {
    let [w, _] = lists.axes();
    let low = |word: i32| (KeyBox::of(boxes, slot(word)).min[w], slot(word));
    let (mut budget, mut last, mut next) = (INVERSIONS_PER_OBJECT * list.len() + 64, i32::MIN, 0);
    while let Some(word) = list.get_mut(next) {
        let at = slot(*word);
        let bounds = KeyBox::of(boxes, at);
        *word = small::word(bounds, at, lists);
        let (this, word, mut to) = ((bounds.min[w], at), *word, next);
        next += 1;
        if last < this.0 {
            // In order already, as most are.
            last = this.0;
            continue;
        }
        while to > 0 && low(list.at(to - 1)) > this {
            list.put(to, list.at(to - 1));
            to -= 1;
        }
        list.put(to, word);
        budget = budget.saturating_sub(next - 1 - to);
        if budget == 0 {
            list.iter_mut().for_each(|word| *word = low(*word).0 & !0xff | *word & 0xff);
            heapsort(list, |a, b| a < b);
            (budget, last, next) = (usize::MAX, i32::MIN, 0);
        }
    }
}
