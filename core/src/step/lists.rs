//! Steps of worlds without a tree: up to 32 objects are tested two by two; for more one list is kept sorted
//! and swept along (paper, sections III.A and IV).

use super::policy::SCAN_EVERY;
use crate::access::Access;
use crate::config::{LISTS, TREE};
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::lists::links;
use crate::memory::scratch::Work;
use crate::memory::slab::Parts;
use crate::memory::state::{ListState, ObjectState};
use crate::pairs::pair_filter::PairFilter;
use crate::pairs::persistent;
use crate::parallel::context::StepContext;
use crate::parallel::executor::Stage;
use crate::sweep::small;
use crate::tree::assign;

/// Finds all pairs. Returns how many there are.
pub(super) fn small<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> u64 {
    persistent::start_over(parts);
    context.executor.enter(Stage::Build);
    let has_list = LISTS && !parts.sizes.is_tiny();
    if has_list && (parts.state.lists.stale != 0 || parts.state.lists.listed != parts.state.objects.live) {
        links::list_all(parts);
    }
    let Parts { state, boxes, order: [order, kept, _], output, filters, .. } = parts;
    let ObjectState { live, slots, has_inserted, .. } = state.objects;
    let boxes = boxes.swept().span(0, slots as usize);
    // Each eighth step and when objects are new: which axis is best, and whether `f32` is too coarse.
    let looks = state.lists.scan_in == 0 || has_inserted != 0;
    state.lists.scan_in = if looks { SCAN_EVERY } else { state.lists.scan_in } - 1;
    let pair_filter = PairFilter::if_needed(filters, slots, &context);
    let mut spared = 0;
    let found = if has_list {
        if looks {
            choose_axis(&mut state.lists, boxes);
        }
        let order = order.span_mut(0, live as usize);
        links::repair(order, boxes, state.lists.axis.into());
        context.executor.enter(Stage::Sweep);
        let mut order = &*order;
        if let Some(pair_filter) = pair_filter.filter(PairFilter::tells_apart) {
            let met = pair_filter.leave_out(order, kept);
            let pairs = |of: usize| (of * of.saturating_sub(1) / 2) as u64;
            (spared, order) = (pairs(order.len()) - pairs(met), kept.span(0, met));
        }
        small::sweep(order, boxes, state.lists.axis, pair_filter, output.pairs)
    } else {
        context.executor.enter(Stage::Sweep);
        small::test_all(boxes, pair_filter.as_ref(), output.pairs)
    };
    let coarse = (TREE && looks).then(|| assign::scan_bounds(boxes.iter()).is_coarse(live));
    let work = Work { candidates: found.candidates as u64, spared, ..Work::default() };
    state.step.did(work, 1, 0, coarse);
    found.pairs as u64
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
