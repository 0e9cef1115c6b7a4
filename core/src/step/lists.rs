//! Steps of worlds without a tree: keep one list sorted and sweep along it (paper, sections III.A and IV).

use super::policy::SCAN_EVERY;
use crate::access::Access;
use crate::config::TREE;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::lists::links;
use crate::memory::scratch::Work;
use crate::memory::slab::Parts;
use crate::memory::state::State;
use crate::memory::stats::Progress;
use crate::pairs::pair_filter::PairFilter;
use crate::pairs::persistent;
use crate::parallel::context::StepContext;
use crate::parallel::executor::Stage;
use crate::sweep::kinds::{Kinds, Pass};
use crate::sweep::small::{self, Found};
use crate::tree::assign;

/// Sorts the list of one axis and sweeps its boxes.
pub(super) fn small<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> Progress {
    persistent::start_over(parts);
    context.executor.enter(Stage::Build);
    if parts.state.lists.stale != 0 || parts.state.lists.listed != parts.state.objects.live {
        links::list_all(parts);
    }
    let Parts { state, boxes, order, output, filters, .. } = parts;
    let boxes = boxes.swept().span(0, state.objects.slots as usize);
    let coarse = choose_axes(state, boxes);
    let (live, slots, axis) = (state.objects.live as usize, state.objects.slots, state.lists.axis as usize);
    let [sorted, parts, codes] = order;
    let sorted = sorted.span_mut(0, live);
    let pair_filter = PairFilter::if_needed(filters, slots, &context);
    links::repair(sorted, boxes, axis);
    context.executor.enter(Stage::Sweep);
    let axes = [axis, state.lists.second_axis as usize];
    let mut found = Found::default();
    let mut sweep =
        |lists: [&[I]; 2]| small::sweep(lists, boxes, axes, pair_filter, output.pairs, &mut found);
    let mut spared = 0;
    if TREE && pair_filter.is_some_and(|filter| filter.tells_apart()) {
        spared = sweep_parts(pair_filter, sorted, [parts, codes], slots as usize, &mut sweep);
    } else {
        sweep([sorted, &[]]);
    }
    let work = Work { candidates: found.candidates as u64, spared, ..Work::default() };
    Progress { pairs: found.pairs as u64, work, leaves: 1, coarse, ..Progress::default() }
}

/// Sweeps the parts of a sorted list that meet; two lists are scratch. Returns how many pairs filters spare.
#[inline(never)]
fn sweep_parts<I: Index>(
    pair_filter: Option<PairFilter<'_>>,
    sorted: &[I],
    [parts, codes]: [&mut [I]; 2],
    slots: usize,
    sweep: &mut dyn FnMut([&[I]; 2]),
) -> u64 {
    let kinds = Kinds::new(pair_filter.as_ref(), None, codes.span_mut(0, slots));
    let plan = kinds.plan(&kinds.count(sorted.iter().map(|slot| slot.at())));
    if plan.whole {
        sweep([sorted, &[]]);
    } else {
        for Pass { sides: [sides, _], within } in plan.passes(false) {
            let [first, others] = kinds.divide(sorted, &sides, parts);
            if within {
                sweep([first, &[]]);
            }
            if !others.is_empty() {
                sweep([first, others]);
            }
        }
    }
    plan.spared
}

/// Chooses the axes along which the fewest boxes overlap, and whether `f32` is too coarse, each eighth step
/// and when objects are new. O(slots).
fn choose_axes(state: &mut State, boxes: &[KeyBox]) -> Option<bool> {
    if state.lists.scan_in > 0 && state.objects.has_inserted == 0 {
        state.lists.scan_in -= 1;
        return None;
    }
    state.lists.scan_in = SCAN_EVERY - 1;
    let mut near = [0; 3];
    for (slot, a) in (0u32..).zip(boxes) {
        // Multiples of the golden ratio are spread evenly.
        let b = KeyBox::of(boxes, ((slot.wrapping_mul(0x9e37_79b9) >> 16) as usize * boxes.len()) >> 16);
        (0..3).for_each(|k| near[k] += u32::from(a.min[k] <= b.max[k] && b.min[k] <= a.max[k]));
    }
    // The list of the last axis is in order already, so another one has to be clearly better.
    let last = state.lists.axis as usize % 3;
    let axis = (0..3).fold(last, |best, k| if 5 * near[k] < 4 * near[best] { k } else { best });
    let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
    state.lists.axis = axis as u8;
    state.lists.second_axis = if near[b] < near[a] { b as u8 } else { a as u8 };
    TREE.then(|| assign::scan_bounds(boxes.iter()).is_coarse(state.objects.live))
}
