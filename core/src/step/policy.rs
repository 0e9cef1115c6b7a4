//! Which kind of step finds the pairs. All kinds give the same pairs; which one is cheapest follows from counts alone, so equal
//! calls choose equally.

use crate::config::Choice;
use crate::id::Index;
use crate::memory::slab::Parts;
use crate::memory::stats::{Path, Reason, Route};
use crate::objects::margins;
use crate::parallel::context::StepContext;
use crate::parallel::executor::Stage;
use crate::tree::balance;
use crate::tree::subdivide::Subdivide;

/// One in this many objects may have moved for the movers-only path to be the cheaper one, and for a step to be calm.
const MOVERS_SHARE: u32 = 16;

/// After this many calm steps in a row leaves are refined, since the next ones are likely to be calm too.
const CALM: u8 = 2;

/// Steps for which margins are left unused where they do not help.
const MARGINS_PAUSE: u8 = 64;

/// Three steps of many movers in a row, or as many more than others, say that margins do not help.
const MARGINS_FAIL: u8 = 6;

/// Leaves margins unused from this step on where most objects move out of theirs all the time, so that each step is a full one, of
/// larger boxes; and uses them again after some steps. Returns whether other boxes are swept now than objects were placed by. Where
/// results speak of fat boxes, and where the caller has fixed the margins, they are used always.
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
    let many = moved > parts.state.objects.live / MOVERS_SHARE;
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

/// The path for a number of objects that have moved, and why.
pub(crate) fn choose<I: Index>(parts: &Parts<'_, I>, moved: u32) -> Route {
    let state = &parts.state;
    let known = state.pairs.complete != 0 && state.pairs.without_surplus == 0;
    let fixed = state.setup.hooks().movers_only.fixed();
    if known && moved == 0 && fixed != Some(false) {
        Route::UNCHANGED
    } else if parts.sizes.is_small() {
        Route { path: Path::Lists, reason: Reason::FewObjects }
    } else if !known || state.tree.filled == 0 {
        anew(parts, Reason::NothingKept)
    } else {
        let few = moved <= state.objects.live / MOVERS_SHARE;
        match (fixed, fixed.unwrap_or(few)) {
            (None, true) => Route { path: Path::Movers, reason: Reason::FewMovers },
            (None, false) => anew(parts, Reason::ManyMovers),
            (Some(_), true) => Route { path: Path::Movers, reason: Reason::Fixed },
            (Some(_), false) => anew(parts, Reason::Fixed),
        }
    }
}

/// The path that finds all pairs anew, for a reason if there is none for new planes.
pub(super) fn anew<I: Index>(parts: &Parts<'_, I>, reason: Reason) -> Route {
    if !balance::needs_planes(parts) {
        Route { path: Path::Full, reason }
    } else if parts.state.tree.built == 0 {
        Route { path: Path::Rebuilt, reason: Reason::NothingKept }
    } else if parts.state.tree.divisible != 0 {
        Route { path: Path::Rebuilt, reason: Reason::OutOfBalance }
    } else {
        Route { path: Path::Rebuilt, reason: Reason::Outgrown }
    }
}

/// Gives a world in which few objects move smaller leaves, some in each step, until many move again.
pub(crate) fn subdivide_when_calm<I: Index>(
    parts: &mut Parts<'_, I>,
    path: Path,
    moved: u32,
    context: StepContext<'_>,
) {
    let (few, due) = match parts.state.setup.hooks().fine_leaves {
        Choice::Automatic => (moved <= parts.state.objects.live / MOVERS_SHARE, CALM),
        Choice::Always => (true, 1),
        Choice::Never => return,
    };
    let calm = few && matches!(path, Path::Unchanged | Path::Movers);
    if parts.sizes.is_small() || parts.state.tree.filled == 0 || !calm {
        return;
    }
    parts.state.step.calm = parts.state.step.calm.saturating_add(1);
    let some_are_undivided = parts.state.tree.subdivided <= 1 << parts.state.tree.depth;
    if parts.state.step.calm >= due && some_are_undivided {
        context.executor.enter(Stage::Fill);
        context.kernels.run(Subdivide(parts));
    }
}
