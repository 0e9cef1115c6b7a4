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
use crate::sweep::small;
use crate::tree::assign;
use crate::tree::cells::{Sample, longest_axis};

/// Sorts the list of one axis and sweeps its boxes.
pub(super) fn small<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> Progress {
    persistent::start_over(parts);
    context.executor.enter(Stage::Build);
    clean_lists(parts);
    let Parts { state, boxes, order, output, .. } = parts;
    let boxes = boxes.swept().span(0, state.objects.slots as usize);
    let coarse = choose_axes(order[0].span(0, state.objects.live as usize), state, boxes);
    let axis = state.lists.axis as usize;
    let order = list_of(order, axis, state);
    let pair_filter = PairFilter::if_needed(&parts.filters, state.objects.slots, &context);
    links::repair(order, boxes, axis);
    context.executor.enter(Stage::Sweep);
    let axes = [axis, state.lists.second_axis as usize];
    let found = small::sweep(order, boxes, axes, pair_filter, output.pairs);
    let work = Work { candidates: found.candidates as u64, ..Work::default() };
    Progress { pairs: found.pairs as u64, work, leaves: 1, coarse, ..Progress::default() }
}

/// Chooses the axes and tells whether `f32` is too coarse, in every eighth step and when objects are new: a look at
/// all boxes costs a third of their sweep.
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

/// Makes the lists hold exactly the living objects.
fn clean_lists<I: Index>(parts: &mut Parts<'_, I>) {
    if parts.state.lists.stale != 0 || parts.state.lists.listed != parts.state.objects.live {
        links::list_all(parts);
    }
}

/// The list of an axis.
fn list_of<'o, I: Index>(order: &'o mut [&mut [I]; 3], axis: usize, state: &State) -> &'o mut [I] {
    let [x, y, z] = order;
    match axis {
        0 => x,
        1 => y,
        _ => z,
    }
    .span_mut(0, state.objects.live as usize)
}
