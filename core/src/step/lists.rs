//! Steps of worlds without a tree: up to 32 objects are tested two by two; for more one list is kept sorted
//! and swept along (paper, sections III.A and IV).
//!
//! The list has each object once, by ascending minimum on one axis: an array of slots (erratum E12), in a
//! total order by key, then by slot (erratum E10). It is kept from step to step. Worlds with a tree have none
//! (erratum E13). Where there are filters, objects that can meet nobody stand at its end, in no order.

use super::policy::SCAN_EVERY;
use crate::access::Access;
use crate::config::LISTS;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::scratch::Work;
use crate::memory::slab::Parts;
use crate::memory::state::{ListState, ObjectState, slot};
use crate::pairs::pair_filter::PairFilter;
use crate::pairs::persistent;
use crate::parallel::context::StepContext;
use crate::parallel::executor::Stage;
use crate::sweep::small;
use core::cell::Cell;
use core::slice::Iter;

/// Objects that each object may overtake, on average, before it is cheaper to sort over long distances first.
const INVERSIONS_PER_OBJECT: usize = 4;

/// Finds all pairs. Returns how many there are.
pub(super) fn small<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> u64 {
    persistent::start_over(parts);
    context.executor.enter(Stage::Build);
    let has_list = LISTS && parts.sizes.list > 0;
    let ListState { stale, listed, .. } = parts.state.lists;
    let list_anew = has_list && (stale != 0 || u32::from(listed) != parts.state.objects.live);
    if list_anew {
        list_all(parts);
    }
    let Parts { state, boxes, list, output, filters, .. } = parts;
    let ObjectState { live, slots, has_inserted, .. } = state.objects;
    let boxes = boxes.swept().span(0, slots as usize);
    // Each eighth step and when objects are new.
    let looks = has_list && (state.lists.scan_in == 0 || has_inserted != 0);
    if has_list {
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
        match state.lists.axis {
            0 => sort::<0, 2>(boxes, list, &state.lists, list_anew),
            1 => sort::<1, 0>(boxes, list, &state.lists, list_anew),
            _ => sort::<2, 0>(boxes, list, &state.lists, list_anew),
        }
        context.executor.enter(Stage::Sweep);
        small::sweep(boxes, list, state.lists.axis, pair_filter, output.pairs)
    } else {
        context.executor.enter(Stage::Sweep);
        small::test_all(boxes, pair_filter.as_ref(), output.pairs)
    };
    let work = Work { candidates: candidates as u64, spared, ..Work::default() };
    state.step.did(work, 1, 0);
    pairs as u64
}

/// Chooses the axis along which the fewest boxes overlap, by a sample, and a grid over the sides on another one.
/// O(slots).
#[inline(never)]
fn choose_axis(lists: &mut ListState, boxes: &[KeyBox]) {
    let mut near = [0; 3];
    for index in (0..boxes.len()).step_by(boxes.len().div_ceil(64).max(1)) {
        // Multiples of the golden ratio are spread evenly.
        let other = (index as u32).wrapping_mul(0x9e37_79b9) >> 16;
        let (a, b) = (KeyBox::of(boxes, index), KeyBox::of(boxes, (other as usize * boxes.len()) >> 16));
        let meets = |k: usize| u32::from(a.min[k] <= b.max[k] && b.min[k] <= a.max[k]);
        near = [near[0] + meets(0), near[1] + meets(1), near[2] + meets(2)];
    }
    // The list of the last axis is in order already, so another one has to be clearly better.
    let last = (lists.axis as usize).min(2);
    lists.axis = (0..3).fold(last, |best, k| if 5 * near[k] < 4 * near[best] { k } else { best }) as u8;
    let u = if lists.axis == 0 { 2 } else { 0 };
    let (mut least, mut most) = (i32::MAX, i32::MIN);
    for bounds in boxes {
        (least, most) = (least.min(bounds.min[u]), most.max(bounds.max[u]));
    }
    least >>= 16;
    let unused = ((most >> 1).wrapping_sub(least << 15) as u32).leading_zeros();
    (lists.least, lists.shift) = (least as i16, (u32::BITS - small::BITS).saturating_sub(unused) as u8);
}

/// Makes the list hold exactly the living objects, by slot. O(slots).
fn list_all<I: Index>(parts: &mut Parts<'_, I>) {
    let Parts { state, boxes, list, .. } = parts;
    let mut listed = 0;
    for (slot, bounds) in (0..state.objects.slots).zip(boxes.now.iter()) {
        if !bounds.is_empty() {
            list.put(listed, (slot as i32) << 24);
            listed += 1;
        }
    }
    (state.lists.listed, state.lists.stale) = (listed as u16, 0);
}

/// Sorts the list, and writes its words anew: by insertion; where it is in no order, roughly before. O(n +
/// inversions), or about O(n^1.3) for as many as lists have.
fn sort<const W: usize, const U: usize>(boxes: &[KeyBox], list: &mut [i32], lists: &ListState, anew: bool) {
    let budget = if anew { 0 } else { INVERSIONS_PER_OBJECT * list.len() + 64 };
    if !sort_by_insertion::<W, U>(boxes, list, lists, budget) {
        sort_roughly(boxes, list, W);
        sort_by_insertion::<W, U>(boxes, list, lists, usize::MAX);
    }
}

/// Sorts over long distances (Shell's sort), by the upper bits of minima.
#[inline(never)]
fn sort_roughly(boxes: &[KeyBox], list: &mut [i32], w: usize) {
    for word in list.iter_mut() {
        let at = slot(*word);
        *word = KeyBox::of(boxes, at).min[w] >> 8 & 0xff_ffff | (at as i32) << 24;
    }
    for gap in [41_u8, 13, 4].map(usize::from) {
        for at in gap..list.len() {
            let (word, mut to) = (list.at(at), at);
            while to >= gap && list.at(to - gap) << 8 > word << 8 {
                list.put(to, list.at(to - gap));
                to -= gap;
            }
            list.put(to, word);
        }
    }
}

/// Returns whether the list is in order, as most of it is before, after so many inversions at most.
#[inline(never)]
fn sort_by_insertion<const W: usize, const U: usize>(
    boxes: &[KeyBox],
    list: &mut [i32],
    lists: &ListState,
    mut budget: usize,
) -> bool {
    let (list, mut last) = (Cell::from_mut(list).as_slice_of_cells(), i32::MIN);
    let mut rest = list.iter();
    while let Some(word) = rest.next() {
        let at = slot(word.get());
        let bounds = KeyBox::of(boxes, at);
        word.set(small::word::<U>(bounds, at, lists));
        if last < bounds.min[W] {
            last = bounds.min[W];
            continue;
        }
        let passed = insert(boxes, list, rest.clone(), W);
        if budget < passed {
            return false;
        }
        budget -= passed;
    }
    true
}

/// Brings the word before the last `behind` ones to its place among those before it. Returns how many it passes.
#[inline(never)]
fn insert(boxes: &[KeyBox], list: &[Cell<i32>], behind: Iter<'_, Cell<i32>>, w: usize) -> usize {
    let low = |word: i32| (KeyBox::of(boxes, slot(word)).min[w], slot(word));
    let upto = list.get(..list.len() - behind.len()).unwrap_or_default();
    let Some((mut place, before)) = upto.split_last() else { return 0 };
    let (word, this, mut passed) = (place.get(), low(place.get()), 0);
    for other in before.iter().rev().take_while(|other| low(other.get()) > this) {
        place.set(other.get());
        (place, passed) = (other, passed + 1);
    }
    place.set(word);
    passed
}
