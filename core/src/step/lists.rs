//! Steps of worlds without a tree: a sorted list is swept.

use crate::access::Access;
use crate::geometry::extent::Extent;
use crate::geometry::key::{KeyBox, length};
use crate::id::Index;
use crate::lists::links;
use crate::memory::scratch::Work;
use crate::memory::slab::Parts;
use crate::memory::state::{Progress, State};
use crate::pairs::carry;
use crate::pairs::gate::Gate;
use crate::parallel::context::StepContext;
use crate::parallel::executor::Stage;
use crate::sweep::Collector;
use crate::sweep::list::SweepList;
use crate::sweep::small;
use crate::sweep::strips::Striped;
use crate::tree::assign::Census;
use crate::tree::cells::{Sample, longest_axis};
use crate::tree::{Frame, assign};

/// Steps of a small world from one choice of its axes to the next.
const SURVEY_EVERY: u8 = 8;

/// A world for few objects: keep the list of one axis in order and sweep its boxes.
pub(super) fn small<I: Index>(parts: &mut Parts<'_, I>, means: StepContext<'_>) -> Progress {
    carry::start_over(parts);
    means.executor.enter(Stage::Build);
    clean_lists(parts);
    let Parts { state, boxes, order, output, .. } = parts;
    let boxes = boxes.swept();
    let coarse = choose_axes(order[0].span(0, state.live as usize), state, boxes);
    let axis = state.list_axis as usize;
    let order = list_of(order, axis, state);
    let gate = Gate::new(&parts.filters, means.rule);
    let found = if let Some(planes) = output.planes.first_mut() {
        let axes = [axis, state.strip_axis as usize];
        let mut striped = Striped { order, boxes, axes, planes, members: output.members };
        if coarse.is_some() {
            striped.divide();
        }
        striped.arrange();
        means.executor.enter(Stage::Sweep);
        striped.sweep(gate, output.pairs)
    } else {
        links::repair(order, boxes, axis, &mut []);
        means.executor.enter(Stage::Sweep);
        small::sweep(order, boxes, axis, gate, output.pairs)
    };
    let work = Work { candidates: found.candidates as u64, ..Work::default() };
    Progress { pairs: found.pairs as u64, work, leaves: 1, coarse, ..Progress::default() }
}

/// Chooses the axes of a small world and tells whether boxes are coarse: now and then, since a look at all boxes costs as
/// much as a third of their sweep, and where objects are new.
fn choose_axes<I: Index>(slots: &[I], state: &mut State, boxes: &[KeyBox]) -> Option<bool> {
    if state.survey_in > 0 && state.entered == 0 {
        state.survey_in -= 1;
        return None;
    }
    state.survey_in = SURVEY_EVERY - 1;
    let (census, extent) = survey(slots, state, boxes);
    let side = |k: u8| length(extent.low[k as usize % 3], extent.high[k as usize % 3]);
    let (a, b) = ((state.list_axis + 1) % 3, (state.list_axis + 2) % 3);
    state.strip_axis = if side(b) > side(a) { b } else { a };
    Some(census.is_coarse(state.live))
}

/// A world for one leaf: keep the list of one axis in order and sweep it.
pub(super) fn lists<I: Index>(parts: &mut Parts<'_, I>, means: StepContext<'_>) -> Progress {
    carry::start_over(parts);
    means.executor.enter(Stage::Build);
    // Records of a tree that the world may have had are not kept up to date.
    parts.state.filled = 0;
    clean_lists(parts);
    let Parts { state, boxes, order, output, .. } = parts;
    let boxes = boxes.swept();
    let spare = bytemuck::try_cast_slice_mut(output.scratch).unwrap_or_default();
    let Sorted { order, axis, census, frame } = sort_list(order, state, boxes, spare);
    means.executor.enter(Stage::Sweep);
    let mut collector = Collector::new(output, &parts.sizes, Gate::new(&parts.filters, means.rule));
    let (pairs, work) = collector.collect(means.executor, 0, 1, &|_, scratch, sink| {
        means.kernels.run_wide(SweepList { order, axis, frame, boxes, scratch, sink });
    });
    let coarse = Some(census.is_coarse(parts.state.live));
    Progress { pairs, work, leaves: 1, coarse, ..Progress::default() }
}

/// Makes the lists hold the living objects, where they do not.
fn clean_lists<I: Index>(parts: &mut Parts<'_, I>) {
    if parts.state.stale_lists != 0 || parts.state.listed != parts.state.live {
        links::list_all(parts);
    }
}

/// The list of one axis, in order.
struct Sorted<'o, I> {
    order: &'o [I],
    axis: usize,
    census: Census,
    /// The grid for the whole world.
    frame: Frame,
}

/// Puts the list of the longest axis in order.
fn sort_list<'o, I: Index>(
    order: &'o mut [&mut [I]; 3],
    state: &mut State,
    boxes: &[KeyBox],
    spare: &mut [u32],
) -> Sorted<'o, I> {
    let (census, extent) = survey(order[0].span(0, state.live as usize), state, boxes);
    let axis = state.list_axis as usize;
    let order = list_of(order, axis, state);
    links::repair(order, boxes, axis, spare);
    Sorted { order, axis, census, frame: Frame::over(extent.low, extent.high) }
}

/// Looks at all boxes and chooses the axis of the list: by where most of them are.
fn survey<I: Index>(slots: &[I], state: &mut State, boxes: &[KeyBox]) -> (Census, Extent) {
    let census = assign::survey(slots.iter().filter_map(|slot| boxes.get(slot.at())));
    let extent = census.extent.trimmed(&Sample::of_list(slots, boxes));
    state.list_axis = longest_axis(&extent, state.list_axis as usize) as u8;
    (census, extent)
}

/// The list of an axis.
fn list_of<'o, I: Index>(order: &'o mut [&mut [I]; 3], axis: usize, state: &State) -> &'o mut [I] {
    let [x, y, z] = order;
    match axis {
        0 => x,
        1 => y,
        _ => z,
    }
    .span_mut(0, state.live as usize)
}
