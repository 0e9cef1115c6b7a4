//! The ways to find the overlaps of swept boxes, and the choice between them.
//!
//! All give the same set. Which one is cheapest follows from counts alone, so equal calls choose equally.

pub(crate) mod recount;

use crate::access::Access;
use crate::config::Choice;
use crate::geometry::extent::Extent;
use crate::geometry::key::{KeyBox, length};
use crate::id::Index;
use crate::lists::links;
use crate::memory::layout::{LEAVES_PER_BLOCK, ONE_LEAF};
use crate::memory::scratch::Work;
use crate::memory::slab::Parts;
use crate::memory::state::{Path, Progress, Reason, Route, State};
use crate::pairs::carry;
use crate::pairs::gate::Gate;
use crate::parallel::context::StepContext;
use crate::parallel::executor::Stage;
use crate::sweep::Collector;
use crate::sweep::leaves::{Grove, SweepLeaves};
use crate::sweep::list::SweepList;
use crate::sweep::movers::SweepMovers;
use crate::sweep::small;
use crate::sweep::strips::Striped;
use crate::tree::assign::Census;
use crate::tree::cells::{Sample, longest_axis};
use crate::tree::refine::{Refine, coarsen};
use crate::tree::relocate::{Relocate, order_movers};
use crate::tree::tighten::Tighten;
use crate::tree::{Frame, assign, balance};

/// One in this many objects may have moved for the movers-only path to be the cheaper one, and for a step to be calm.
const MOVERS_SHARE: u32 = 9;

/// After this many calm steps in a row leaves are refined, since the next ones are likely to be calm too.
const CALM: u32 = 2;

/// The fewest movers in a block of work, so that to hand them out is little beside testing them.
const MOVERS_PER_BLOCK: usize = 64;

/// Steps of a small world from one choice of its axes to the next.
const SURVEY_EVERY: u8 = 8;

/// The path for a number of objects that have moved, and why.
pub(crate) fn choose<I: Index>(parts: &Parts<'_, I>, moved: u32) -> Route {
    let state = &parts.state;
    let known = state.complete != 0 && state.without_surplus == 0;
    let fixed = state.movers_only().fixed();
    if known && moved == 0 && fixed != Some(false) {
        Route::UNCHANGED
    } else if parts.sizes.is_small() || state.live as usize <= ONE_LEAF {
        Route { path: Path::Lists, reason: Reason::FewObjects }
    } else if !known || state.filled == 0 {
        anew(parts, Reason::NothingKept)
    } else {
        let few = moved <= state.live / MOVERS_SHARE;
        match (fixed, fixed.unwrap_or(few)) {
            (None, true) => Route { path: Path::Movers, reason: Reason::FewMovers },
            (None, false) => anew(parts, Reason::ManyMovers),
            (Some(_), true) => Route { path: Path::Movers, reason: Reason::Fixed },
            (Some(_), false) => anew(parts, Reason::Fixed),
        }
    }
}

/// The path that finds all pairs anew, for a reason if there is none for new planes.
fn anew<I: Index>(parts: &Parts<'_, I>, reason: Reason) -> Route {
    if !balance::needs_planes(parts) {
        Route { path: Path::Full, reason }
    } else if parts.state.planted == 0 {
        Route { path: Path::Rebuilt, reason: Reason::NothingKept }
    } else if parts.state.divisible != 0 {
        Route { path: Path::Rebuilt, reason: Reason::OutOfBalance }
    } else {
        Route { path: Path::Rebuilt, reason: Reason::Outgrown }
    }
}

/// Gives a world in which few objects move smaller leaves, some in each step, until many move again.
pub(crate) fn refine_when_calm<I: Index>(
    parts: &mut Parts<'_, I>,
    path: Path,
    moved: u32,
    means: StepContext<'_>,
) {
    let (few, due) = match parts.state.fine_leaves() {
        Choice::Automatic => (moved <= parts.state.live / MOVERS_SHARE, CALM),
        Choice::Always => (true, 1),
        Choice::Never => return,
    };
    let calm = few && matches!(path, Path::Unchanged | Path::Movers);
    if parts.sizes.is_small() || parts.state.filled == 0 || !calm {
        return;
    }
    parts.state.calm = parts.state.calm.saturating_add(1);
    let some_are_whole = parts.state.refined <= 1 << parts.state.depth;
    if parts.state.calm >= due && some_are_whole {
        means.executor.enter(Stage::Fill);
        means.kernels.run(Refine(parts));
    }
}

/// Finds the overlaps by a path, which may have to give way to a wider one. Returns the one that was used.
pub(crate) fn find<I: Index>(
    parts: &mut Parts<'_, I>,
    route: Route,
    means: StepContext<'_>,
) -> (Route, Progress) {
    parts.state.without_surplus = 0;
    match route.path {
        Path::Unchanged => (route, unchanged(parts)),
        _ if parts.sizes.is_small() => (route, small(parts, means)),
        Path::Lists => (route, lists(parts, means)),
        Path::Movers => match movers(parts, means) {
            Some(progress) => (route, progress),
            None => full(parts, anew(parts, Reason::NoRoom), means),
        },
        Path::Full | Path::Rebuilt => full(parts, route, means),
    }
}

/// Finds the overlaps of the boxes as given, after a step of an exact world found more overlaps of fat boxes than fit: its pairs
/// may fit without the surplus. Nothing of that can be carried over, so the next step finds all pairs anew.
pub(crate) fn find_without_surplus<I: Index>(
    parts: &mut Parts<'_, I>,
    means: StepContext<'_>,
) -> (Route, Progress) {
    // What the result before has to tell is kept already.
    parts.state.complete = 0;
    parts.boxes.tight = true;
    let route = choose(parts, parts.state.live);
    let (route, progress) = find(parts, route, means);
    parts.boxes.tight = false;
    parts.state.filled = 0;
    parts.state.without_surplus = 1;
    (Route { reason: Reason::NoRoomForSurplus, ..route }, progress)
}

/// Nothing has moved: all pairs stay.
fn unchanged<I: Index>(parts: &mut Parts<'_, I>) -> Progress {
    let leaves = parts.state.leaves();
    Progress { pairs: carry::carry(parts), leaves, ..Progress::default() }
}

/// A world for few objects: keep the list of one axis in order and sweep its boxes.
fn small<I: Index>(parts: &mut Parts<'_, I>, means: StepContext<'_>) -> Progress {
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
fn lists<I: Index>(parts: &mut Parts<'_, I>, means: StepContext<'_>) -> Progress {
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

/// Few have moved: carry the resting pairs over and test the movers. `None` where the leaves have no room.
fn movers<I: Index>(parts: &mut Parts<'_, I>, means: StepContext<'_>) -> Option<Progress> {
    means.executor.enter(Stage::Fill);
    let moved = means.kernels.run(Relocate(parts))?;
    means.kernels.run(Tighten { parts, movers: moved });
    let count = order_movers(parts, moved);
    let kept = carry::carry(parts);
    means.executor.enter(Stage::Sweep);
    let leaves = parts.state.leaves();
    let per_block = count.div_ceil(parts.state.most_blocks()).max(MOVERS_PER_BLOCK);
    let [movers, _, homes] = &parts.order;
    let (movers, homes) = (movers.span(0, count), homes.span(0, count));
    let moved = &*parts.moved.words;
    let grove = Grove::new(parts.state, parts.boxes.swept(), &parts.tree);
    let gate = Gate::new(&parts.filters, means.rule);
    let mut collector = Collector::new(&mut parts.output, &parts.sizes, gate);
    let blocks = count.div_ceil(per_block);
    let (pairs, work) = collector.collect(means.executor, kept, blocks, &|block, scratch, sink| {
        let start = block * per_block;
        let len = per_block.min(count - start);
        let (movers, homes) = (movers.span(start, len), homes.span(start, len));
        means.kernels.run(SweepMovers { grove: &grove, moved, movers, homes, scratch, sink });
    });
    Some(Progress { pairs, work, leaves, ..Progress::default() })
}

/// Many have moved: fill all leaves and sweep them; where they are out of balance, after new planes.
fn full<I: Index>(parts: &mut Parts<'_, I>, mut route: Route, means: StepContext<'_>) -> (Route, Progress) {
    let StepContext { kernels, executor, .. } = means;
    let mut replant = route.path == Path::Rebuilt;
    carry::start_over(parts);
    executor.enter(Stage::Build);
    let was_refined = coarsen(parts);
    let rebalanced = if replant {
        balance::plant(parts, means);
        0
    } else if was_refined {
        0
    } else {
        balance::rebalance(parts, means)
    };
    balance::deepen(parts);
    executor.enter(Stage::Fill);
    let mut census = assign::count(parts, kernels, executor);
    if !replant && balance::is_out_of_balance(parts) {
        replant = true;
        route = Route { path: Path::Rebuilt, reason: Reason::OutOfBalance };
        executor.enter(Stage::Build);
        balance::plant(parts, means);
        executor.enter(Stage::Fill);
        census = assign::count(parts, kernels, executor);
    }
    if replant {
        balance::settle(parts);
    }
    assign::fill(parts, &census, kernels, executor);
    balance::review(parts);
    executor.enter(Stage::Sweep);
    let leaf_count = 1usize << parts.state.depth;
    let grove = Grove::new(parts.state, parts.boxes.swept(), &parts.tree);
    let gate = Gate::new(&parts.filters, means.rule);
    let mut collector = Collector::new(&mut parts.output, &parts.sizes, gate);
    let blocks = leaf_count.div_ceil(LEAVES_PER_BLOCK);
    let (pairs, work) = collector.collect(executor, 0, blocks, &|block, scratch, sink| {
        let first = block * LEAVES_PER_BLOCK;
        let leaves = first..(first + LEAVES_PER_BLOCK).min(leaf_count);
        kernels.run_wide(SweepLeaves { grove: &grove, leaves, scratch, sink });
    });
    balance::weigh(parts.state, work.candidates.saturating_sub(pairs), replant);
    let rebalanced = if replant { parts.state.live } else { rebalanced };
    let coarse = Some(census.is_coarse(parts.state.live));
    (route, Progress { pairs, work, leaves: leaf_count as u32, rebalanced, coarse })
}
