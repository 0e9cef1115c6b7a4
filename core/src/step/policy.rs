//! Chooses the kind of a step. All kinds give the same pairs, and counts alone decide, so equal calls choose equally.
//! The table of constants in `NOTEBOOK.md` says what was measured.

use crate::access::{Access, bits};
use crate::config::{Choice, Mode};
use crate::geometry::key::{KeyBox, length};
use crate::id::Index;
use crate::memory::slab::{BoxParts, Parts};
use crate::memory::state::{State, StepState};
use crate::memory::stats::{Path, Reason, Route};
use crate::objects::margins;
use crate::pairs::persistent;
use crate::parallel::context::StepContext;
use crate::parallel::executor::Stage;
use crate::simd::kernels::run;
use crate::tree::balance::{self, Due};
use crate::tree::subdivide::subdivide;

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

/// Fat boxes are made anew when more than one in this many objects have left theirs.
const RENEW_SHARE: u64 = 32;
/// Steps that they have to last, else they do not pay.
const LEAST_AGE: u32 = 3;
/// Fat boxes do not pay if half of them are so many times as large as the boxes, as a sample of about so many tells.
const MOST_GROWTH: f32 = 2.0;
const SIZE_SAMPLE: usize = 128;
/// Steps without them after that: the first time, and at most.
const PAUSES: [u8; 2] = [16, 64];

/// Has fat boxes made anew with the next boxes, if many have left theirs; leaves them unused, if they do not last; and uses them
/// again after some steps, if many move. All as one number tells: the steps from one time that they were made to the next.
/// Returns whether other boxes are swept now than objects were placed by. Boxes with margins that the caller has fixed stay, and
/// those of a fat world with margins are never left unused.
pub(crate) fn renew<I: Index>(parts: &mut Parts<'_, I>, moved: u32) -> bool {
    let (live, mode) = (u64::from(parts.state.objects.live), parts.mode());
    let many = u64::from(moved) * RENEW_SHARE > live;
    let has_margin = parts.state.setup.margin().is_some();
    let fixed = parts.state.setup.has_fixed_margins()
        || parts.state.setup.hooks().movers_only.fixed().is_some()
        || mode == Mode::Fat && !parts.state.setup.is_predicted();
    // Without leaves of the last step all objects count as moved.
    let kept = parts.state.tree.filled == 1;
    parts.state.tree.filled = parts.state.tree.filled.min(1);
    let step = &mut parts.state.step;
    step.age = if step.renews != 0 { 0 } else { step.age.saturating_add(1) };
    step.renews = step.renews.saturating_sub(1);
    if step.margins_in > 0 {
        // Where few move, they are tested one by one anyway.
        let waits = step.margins_in == 1 && !many && !has_margin;
        step.margins_in -= u8::from(!waits);
        if step.margins_in == 0 && !has_margin && are_swollen(parts) {
            lengthen_pause(&mut parts.state.step);
        } else if parts.state.step.margins_in == 0 {
            parts.state.step.renews = 1;
            margins::use_again(parts);
        }
        return false;
    }
    if parts.boxes.fat.is_empty() || fixed || parts.sizes.is_small() || !kept {
        return false;
    }
    if !many || step.age == 0 && (has_margin || !are_swollen(parts)) {
        return false;
    }
    let step = &mut parts.state.step;
    if step.age >= LEAST_AGE || has_margin && mode == Mode::Fat {
        step.renews = 1;
        step.margins_after = 0;
        return false;
    }
    pause(parts);
    true
}

/// Whether most fat boxes are so much larger than the boxes that they cost more than they spare, by a sample. Where none are
/// in use: whether they would be, as far as the boxes of the last step tell.
fn are_swollen<I: Index>(parts: &Parts<'_, I>) -> bool {
    let BoxParts { now, fat, before, tight, .. } = &parts.boxes;
    let slots = parts.state.objects.slots as usize;
    let (mut swollen, mut looked) = (0, 0);
    for slot in (0..slots).step_by((slots / SIZE_SAMPLE).max(1)) {
        let now = KeyBox::of(now, slot);
        let fat = match before.get(slot) {
            _ if !tight => fat.at(slot),
            Some(before) if bits::test(parts.changed.words, slot) => now.predicted(before, 0.0),
            _ => *now,
        };
        let mut growth = 1.0;
        for k in 0..3 {
            let (side, fat) = (length(now.min[k], now.max[k]), length(fat.min[k], fat.max[k]));
            // Not of flat and unbounded ones.
            if side > 0.0 && fat < f32::MAX {
                growth *= fat / side;
            }
        }
        looked += 1;
        swollen += usize::from(growth > MOST_GROWTH);
    }
    2 * swollen > looked
}

/// Leaves fat boxes unused for some steps.
pub(crate) fn pause<I: Index>(parts: &mut Parts<'_, I>) {
    lengthen_pause(&mut parts.state.step);
    margins::leave_unused(parts);
}

fn lengthen_pause(step: &mut StepState) {
    step.margins_after = step.margins_after.saturating_mul(2).clamp(PAUSES[0], PAUSES[1]);
    step.margins_in = step.margins_after;
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
    // A step in which nobody moves needs no leaves.
    if parts.state.step.calm >= due && some_are_undivided && moved > 0 {
        context.executor.enter(Stage::Fill);
        run!(context.kernels, |simd| subdivide(simd, parts));
    }
}
