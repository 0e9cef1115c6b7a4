//! Steps of worlds without a tree: keep one list sorted and sweep along it (paper, sections III.A and IV).

use super::policy::SCAN_EVERY;
use crate::access::Access;
use crate::geometry::key::{KeyBox, length};
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
use crate::tree::cells::{Sample, longest_axis};

/// Sorts the list of one axis and sweeps its boxes.
pub(super) fn small<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> Progress {
    persistent::start_over(parts);
    context.executor.enter(Stage::Build);
    if parts.state.lists.stale != 0 || parts.state.lists.listed != parts.state.objects.live {
        links::list_all(parts);
    }
    let Parts { state, boxes, order, output, filters, .. } = parts;
    let boxes = boxes.swept().span(0, state.objects.slots as usize);
    let coarse = choose_axes(order[0].span(0, state.objects.live as usize), state, boxes);
    let axis = state.lists.axis as usize;
    let (live, slots) = (state.objects.live as usize, state.objects.slots);
    let [x, y, z] = order;
    let (sorted, parts, codes) = match axis {
        0 => (x, y, z),
        1 => (y, z, x),
        _ => (z, x, y),
    };
    let sorted = sorted.span_mut(0, live);
    let pair_filter = PairFilter::if_needed(filters, slots, &context);
    links::repair(sorted, boxes, axis);
    context.executor.enter(Stage::Sweep);
    let axes = [axis, state.lists.second_axis as usize];
    let mut found = Found::default();
    let mut sweep =
        |lists: [&[I]; 2]| small::sweep(lists, boxes, axes, pair_filter, output.pairs, &mut found);
    let mut spared = 0;
    if pair_filter.is_some_and(|filter| filter.tells_apart()) {
        spared = sweep_parts(pair_filter, sorted, [parts, codes], slots as usize, &mut sweep);
    } else {
        sweep([sorted, &[]]);
    }
    let work = Work { candidates: found.candidates as u64, spared, ..Work::default() };
    Progress { pairs: found.pairs as u64, work, leaves: 1, coarse, ..Progress::default() }
}

/// Sweeps the parts of a sorted list that meet. The two other lists are scratch: they end as the same objects
/// in another order. Returns how many pairs of objects were not compared, as their filters do not meet.
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
    codes.copy_in(sorted);
    plan.spared
}

/// Chooses the axes and tells whether `f32` is too coarse, in every eighth step and when objects are new: a
/// look at all boxes costs a third of their sweep.
fn choose_axes<I: Index>(slots: &[I], state: &mut State, boxes: &[KeyBox]) -> Option<bool> {
    if state.lists.scan_in > 0 && state.objects.has_inserted == 0 {
        state.lists.scan_in -= 1;
        return None;
    }
    state.lists.scan_in = SCAN_EVERY - 1;
    let bounds_scan = assign::scan_bounds(slots.iter().filter_map(|slot| boxes.get(slot.at())));
    // Where most boxes are.
    let extent = bounds_scan.extent.trimmed(&Sample::of_list(slots, boxes));
    state.lists.axis = longest_axis(&extent, state.lists.axis as usize) as u8;
    let side = |k: u8| length(extent.low[k as usize % 3], extent.high[k as usize % 3]);
    let (a, b) = ((state.lists.axis + 1) % 3, (state.lists.axis + 2) % 3);
    state.lists.second_axis = if side(b) > side(a) { b } else { a };
    Some(bounds_scan.is_coarse(state.objects.live))
}
