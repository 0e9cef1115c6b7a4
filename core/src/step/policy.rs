//! Chooses the kind of a step. All kinds give the same pairs, and counts alone decide, so equal calls choose equally.
//! The table of constants in `PERFORMANCE.md` says what was measured.

use crate::access::Access;
use crate::config::Choice;
use crate::id::Index;
use crate::memory::slab::Parts;
use crate::memory::state::State;
use crate::memory::stats::{Path, Reason, Route};
use crate::objects::margins;
use crate::pairs::persistent;
use crate::parallel::context::StepContext;
use crate::parallel::executor::Stage;
use crate::tree::balance::{self, Due};
use crate::tree::subdivide::Subdivide;

/// Movers are tested one by one while they are at most one in this many objects.
const MOVERS_SHARE: u64 = 13;
/// And this many halves more for each pair of an object.
const MOVERS_SHARE_PER_PAIR: u64 = 5;
/// A pair that a step of many movers keeps saves this much. The division of leaves costs one for each pair and two for each object.
const KEPT_SAVES: u64 = 3;
/// The same with events.
const KEPT_SAVES_WITH_EVENTS: u64 = 6;

/// Steps from one choice of the axes to the next, in a world without a tree.
pub(super) const SCAN_EVERY: u8 = 8;

/// Pairs that are sampled to tell how many stay.
const PAIR_SAMPLE: usize = 256;

/// After this many steps with few movers in a row leaves are divided, since the next ones probably have few too.
const CALM: u8 = 2;

/// Steps for which margins are left unused if they do not help.
const MARGINS_PAUSE: u8 = 64;

/// Margins do not help after three steps of many movers in a row, or three more than others lately: a step of many
/// movers counts two, another takes one away.
const MARGINS_FAIL: u8 = 6;

/// Leaves margins unused from this step on if most objects keep leaving theirs, since each step is then a full one of
/// larger boxes; and uses them again after some steps. Returns whether other boxes are swept now than objects were
/// placed by. Margins stay in use in worlds that report fat boxes, and if the caller has fixed them.
pub(crate) fn weigh_margins<I: Index>(parts: &mut Parts<'_, I>, moved: u32) -> bool {
    let step = &mut parts.state.step;
    if step.margins_in > 0 {
        step.margins_in -= 1;
        if step.margins_in == 0 {
            margins::use_again(parts);
        }
        return false;
    }
    let fixed =
        parts.state.setup.has_fixed_margins() || parts.state.setup.hooks().movers_only.fixed().is_some();
    if !parts.has_surplus() || fixed || parts.sizes.is_small() {
        return false;
    }
    let many = !are_few(parts.state, moved);
    let step = &mut parts.state.step;
    let failed =
        if many { step.margins_failed.saturating_add(2) } else { step.margins_failed.saturating_sub(1) };
    let useless = many && failed >= MARGINS_FAIL;
    step.margins_failed = if useless { 0 } else { failed };
    if useless {
        step.margins_in = MARGINS_PAUSE;
        margins::leave_unused(parts);
    }
    useless
}

/// The path for a number of moved objects, and why.
pub(crate) fn choose<I: Index>(parts: &Parts<'_, I>, moved: u32) -> Route {
    let state = &parts.state;
    let known = state.pairs.complete != 0 && state.pairs.unkept == 0;
    let fixed = state.setup.hooks().movers_only.fixed();
    if known && moved == 0 && fixed != Some(false) {
        Route::UNCHANGED
    } else if parts.sizes.is_small() {
        Route { path: Path::Lists, reason: Reason::FewObjects }
    } else if !known || state.tree.filled == 0 {
        anew(parts, Reason::NothingKept)
    } else {
        let by_leaf = state.setup.hooks().movers_by_leaf.fixed();
        match fixed {
            Some(true) => Route { path: Path::Movers, reason: Reason::Fixed },
            Some(false) => anew(parts, Reason::Fixed),
            None if by_leaf == Some(true) && can_keep_pairs(parts) => {
                Route { path: Path::MoversByLeaf, reason: Reason::Fixed }
            }
            None if are_few(state, moved) => Route { path: Path::Movers, reason: Reason::FewMovers },
            None if by_leaf.is_none() && can_keep_pairs(parts) && should_keep_pairs(parts, moved) => {
                Route { path: Path::MoversByLeaf, reason: Reason::ManyMovers }
            }
            None => anew(parts, Reason::ManyMovers),
        }
    }
}

/// Whether so few objects have moved that each is best tested by itself.
fn are_few(state: &State, moved: u32) -> bool {
    let (moved, live, pairs) = (u64::from(moved), u64::from(state.objects.live), state.pairs.swept);
    let cost = MOVERS_SHARE * live + MOVERS_SHARE_PER_PAIR * pairs.min(live << 8) / 2;
    moved.saturating_mul(cost) <= live * live
}

/// Whether a step of many movers may keep the pairs of other objects. New planes are judged by all pairs, so they
/// need all.
fn can_keep_pairs<I: Index>(parts: &Parts<'_, I>) -> bool {
    cfg!(feature = "large") && !balance::needs_planes(parts.state)
}

/// Whether a step of many movers is cheaper if it keeps the pairs of other objects and sweeps leaves only for those
/// of moved ones. That saves the search for pairs that stay, and their events. It costs a division of the records of
/// each leaf, and a second look at each pair that goes.
fn should_keep_pairs<I: Index>(parts: &Parts<'_, I>, moved: u32) -> bool {
    let (pairs, live) = (parts.state.pairs.swept, u64::from(parts.state.objects.live));
    let saved = if parts.sizes.previous > 0 { KEPT_SAVES_WITH_EVENTS } else { KEPT_SAVES };
    let cost = pairs + 2 * live;
    // It does not pay even if all pairs stay, or hardly any can.
    if pairs.saturating_mul(saved) <= cost || 8 * u64::from(moved) > 7 * live {
        return false;
    }
    let list = parts.output.pairs.span(0, pairs as usize);
    let (mut looked, mut stay) = (0, 0);
    for pair in list.iter().step_by((list.len() / PAIR_SAMPLE).max(1)) {
        looked += 1;
        stay += u64::from(persistent::is_clear_of(parts.moved.words, pair));
    }
    pairs.saturating_mul(saved).saturating_mul(stay) > cost.saturating_mul(looked)
}

/// The path that finds all pairs anew. `reason` counts unless new planes are due.
pub(super) fn anew<I: Index>(parts: &Parts<'_, I>, reason: Reason) -> Route {
    let tree = &parts.state.tree;
    if !balance::needs_planes(parts.state) {
        Route { path: Path::Full, reason }
    } else if tree.count == 0 {
        Route { path: Path::Rebuilt, reason: Reason::NothingKept }
    } else if tree.due == Due::Heavy as u8 {
        Route { path: Path::Rebuilt, reason: Reason::OutOfBalance }
    } else {
        Route { path: Path::Rebuilt, reason: Reason::Outgrown }
    }
}

/// Divides some leaves in each step of a calm world.
pub(crate) fn subdivide_when_calm<I: Index>(
    parts: &mut Parts<'_, I>,
    path: Path,
    moved: u32,
    context: StepContext<'_>,
) {
    let (few, due) = match parts.state.setup.hooks().fine_leaves {
        Choice::Automatic => (are_few(parts.state, moved), CALM),
        Choice::Always => (true, 1),
        Choice::Never => return,
    };
    let calm = few && matches!(path, Path::Unchanged | Path::Movers);
    if parts.sizes.is_small() || parts.state.tree.filled == 0 || !calm {
        return;
    }
    parts.state.step.calm = parts.state.step.calm.saturating_add(1);
    let some_are_undivided = parts.state.tree.subdivided <= parts.state.tree.count;
    if parts.state.step.calm >= due && some_are_undivided {
        context.executor.enter(Stage::Fill);
        context.kernels.run(Subdivide(parts));
    }
}
