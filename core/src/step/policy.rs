//! Chooses the path of a step. All paths give the same pairs, and counts alone decide, so equal calls choose
//! equally. The table of constants in `NOTEBOOK.md` says what was measured.

use crate::access::{Access, bits};
use crate::config::{FINE_LEAVES, MOVERS_BY_LEAF, MOVERS_ONLY};
use crate::geometry::boxes::Boxes;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::layout::{reports_margins, sweeps_margins};
use crate::memory::limits::TRIAL;
use crate::memory::slab::{BoxParts, Parts};
use crate::memory::state::{State, StepState};
use crate::memory::stats::{Path, Reason, Route};
use crate::pairs::partition::is_clear_of;
use crate::parallel::context::StepContext;
use crate::parallel::executor::Stage;
use crate::simd::kernels::run;
use crate::tree::balance::{self, Due};
use crate::tree::subdivide::subdivide;

/// Movers are tested one by one while they are at most one in this many objects.
const MOVERS_SHARE: u64 = 13;
/// And this many halves more for each pair of an object.
const MOVERS_SHARE_PER_PAIR: u64 = 5;
/// A pair that is kept by leaf saves this much; the division costs one for each pair and two for each object.
const KEPT_SAVES: u64 = 3;
/// The same with events.
const KEPT_SAVES_WITH_EVENTS: u64 = 6;

/// Steps from one choice of the axes to the next, in a world without a tree.
pub(super) const SCAN_EVERY: u8 = 8;

/// Pairs that are sampled to tell how many stay.
const PAIR_SAMPLE: usize = 256;

/// After this many steps with few movers leaves are divided, since the next steps probably have few, too; or
/// after as many as there were before the last full step, where such a step comes again and again.
const CALM: [u8; 2] = [2, 16];

/// A full step, in the unit of these costs; what new fat boxes cost beyond a quiet step; a quiet step.
const FULL: u64 = 64;
const RENEWAL: u64 = 112;
const QUIET: u64 = 20;
/// About so many objects tell what all do.
const SAMPLE: usize = 64;
/// In a fat world all boxes that are reported are made anew where one in this many is left.
const REGROWN_SHARE: u64 = 16;
/// Where more than one in this many objects left its fat box in the last step, boxes are kept for events.
const KNOWN_SHARE: u32 = 256;
/// Where more than one in this many objects have left their fat boxes, these may not pay.
const MANY_SHARE: u64 = 32;
/// Steps without them after that. In the [last ones](TRIAL) some are tried.
const PAUSE: u8 = 64;

/// What a step costs beyond a quiet one, if so many objects have left their fat boxes.
fn upkeep(state: &State, moved: u64) -> u64 {
    let live = u64::from(state.objects.live).max(1);
    let unparked = (state.pairs.in_front() as u64).saturating_sub(u64::from(state.pairs.parked));
    let each = FULL * cost_of_movers(state) / live;
    // To look whether a pair stays takes a 40th of what a full step takes for an object.
    let cost = (moved.saturating_mul(each) + FULL * unparked / 40) / live;
    if moved == 0 { 0 } else { cost.min(FULL) }
}

/// Whether all fat boxes are to be made anew, after so many steps without that which have cost so much beyond
/// quiet ones, and one that costs so much: if that is more than the mean of all, with what making them costs.
fn is_due(step: &StepState, age: u32, cost: u64) -> bool {
    cost > 0 && cost * (u64::from(age) + 1) >= RENEWAL + u64::from(step.spent)
}

/// Whether fat boxes are in use that steps may make anew.
fn may_renew<I: Index>(parts: &Parts<'_, I>) -> bool {
    let fixed = parts.config().fixed_margins || parts.config().forced.of(MOVERS_ONLY).is_some();
    parts.boxes.are_fat() && !fixed && parts.state.tree.filled == 1
}

/// How many of so many slots something holds for, as it does for some of them.
fn estimate(slots: usize, holds: impl FnMut(&usize) -> bool) -> u64 {
    let each = (slots / SAMPLE).max(1);
    ((0..slots).step_by(each).filter(holds).count() * each) as u64
}

/// The box that an object gets, if it does not rest.
fn next_box<I: Index>(parts: &Parts<'_, I>, bounds: &Boxes<'_>, slot: usize) -> Option<KeyBox> {
    let rests = parts.state.objects.resting != 0 && bits::test(parts.resting, slot);
    if rests { None } else { KeyBox::from_aabb(&bounds.get(slot)?) }
}

/// In a fat world, before boxes are taken in: whether all get new boxes that are reported, as so many of a
/// sample leave theirs: so these are left in the same steps. By boxes alone, whatever the world's room.
pub(crate) fn regrows<I: Index>(parts: &Parts<'_, I>, bounds: &Boxes<'_>) -> bool {
    if !reports_margins(parts.config()) || parts.config().fixed_margins {
        return false;
    }
    let slots = (parts.state.objects.slots as usize).min(bounds.len());
    let left = estimate(slots, |&slot| {
        let now = parts.boxes.now.at(slot);
        !now.is_empty() && next_box(parts, bounds, slot).is_some_and(|new| !now.contains(&new))
    });
    left * REGROWN_SHARE >= slots.max(1) as u64
}

/// Before boxes are taken in, which may [regrow](regrows) reported ones: has all fat boxes made anew with
/// them, if so many of a sample leave theirs; has no boxes kept for events, if none of it does.
pub(crate) fn foresee<I: Index>(parts: &mut Parts<'_, I>, bounds: &Boxes<'_>, regrows: bool) {
    let age = parts.state.step.age.saturating_add(1);
    if parts.state.step.renews != 0 || !may_renew(parts) || !pays(&parts.state.step, age, 0) {
        return;
    }
    let slots = (parts.state.objects.slots as usize).min(bounds.len());
    let reports = reports_margins(parts.config());
    // Neighbours of the sample, in no pattern that these slots may have.
    let apart = |slot: usize| (slot as u32).wrapping_mul(0x9e37_79b9) as usize >> 16 & (slots / SAMPLE / 16);
    let moved = estimate(slots, |&slot| {
        let slot = (slot + apart(slot)).min(slots - 1);
        let (held, now) = (parts.boxes.fat.at(slot), parts.boxes.now.at(slot));
        let new = next_box(parts, bounds, slot);
        let leaves = |new: KeyBox| !reports || regrows || !now.contains(&new);
        let around = |new: &KeyBox| if reports { new.grown(parts.boxes.margins.at(slot)) } else { *new };
        !held.is_empty() && new.is_some_and(|new| leaves(new) && !held.contains(&around(&new)))
    });
    let (step, cost) = (&parts.state.step, upkeep(parts.state, moved));
    // Then new pairs are so few that the pairs of before tell events.
    let are_few = |moved: u32| moved.saturating_mul(KNOWN_SHARE) <= parts.state.objects.live;
    let few = moved == 0 && (age == 1 || are_few(step.moved)) && are_few(parts.moved.count());
    parts.state.pairs.before_unknown |= u8::from(few && parts.sizes.keeps_boxes());
    parts.state.step.renews = u16::from(is_due(step, age, cost) && pays(step, age, cost));
}

/// Has fat boxes made anew with the next boxes, if that is due; leaves them unused, if they do not pay, and
/// has them tried later. Returns how many objects have another box that is swept. Fixed margins stay.
pub(crate) fn renew<I: Index>(parts: &mut Parts<'_, I>, moved: u32) -> u32 {
    let cost = upkeep(parts.state, u64::from(moved));
    // Without leaves of the last step all objects count as moved.
    let is_known = may_renew(parts);
    parts.state.tree.filled = parts.state.tree.filled.min(1);
    let step = &mut parts.state.step;
    let new = step.renews != 0;
    step.renews = 0;
    if step.margins_in > TRIAL {
        step.margins_in -= 1;
    } else if step.margins_in > 0 {
        // Where few move, they are tested one by one anyway.
        if u64::from(moved) * MANY_SHARE > u64::from(parts.state.objects.live) {
            try_on(parts);
        }
    } else {
        (step.age, step.spent) = if new { (0, 0) } else { (step.age.saturating_add(1), step.spent) };
        if !is_known || new || cost == 0 {
            return moved;
        }
        let due = is_due(step, step.age, cost);
        // Few get another box for long, and most of these leave their fat one.
        let in_vain = step.age > 64 && parts.changed.count() < 2 * moved;
        if in_vain || due && !pays(step, step.age, cost) {
            pause(parts);
            return parts.moved.count();
        }
        step.renews = u16::from(due);
        step.spent = step.spent.saturating_add(cost as u16);
    }
    moved
}

/// Whether fat boxes are worth what they have cost in so many steps, after one more that costs so much.
fn pays(step: &StepState, age: u32, cost: u64) -> bool {
    let steps = u64::from(age) + 1;
    RENEWAL + u64::from(step.spent) + cost + QUIET * steps < FULL * steps
}

/// In the last steps of a pause some of the first (age) slots try fat boxes; all do once that would pay.
fn try_on<I: Index>(parts: &mut Parts<'_, I>) {
    let steps = TRIAL - parts.state.step.margins_in;
    if steps == 0 {
        (parts.state.step.age, parts.state.step.spent) = (parts.state.objects.slots, 0);
    }
    let (predicted, sweeps_margins) = (parts.config().predicted, sweeps_margins(parts.config()));
    let BoxParts { now, fat, given, margins, tight, .. } = &mut parts.boxes;
    let left = estimate(parts.state.step.age as usize, |&slot| {
        let (now, old) = (now.at(slot), fat.at(slot));
        let given = given.get(slot).copied().unwrap_or(now);
        let margin = if sweeps_margins { margins.at(slot) } else { 0.0 };
        match steps {
            0 => fat.put(slot, given),
            1 => {
                let from = now.came_from(&old, &given);
                fat.put(slot, KeyBox::predicted(&now, &from, margin, predicted));
            }
            _ => return !now.is_empty() && !old.contains(&now),
        }
        false
    });
    let cost = upkeep(parts.state, left);
    let step = &mut parts.state.step;
    step.margins_in -= 1;
    if steps >= 2 && pays(step, u32::from(steps) - 2, cost) {
        // Each object gets another one than its box with its next box. What planes are worth is told by steps
        // of such boxes alone, from the next one on.
        fat.copy_in(now);
        *tight = false;
        (step.margins_in, step.renews) = (0, 1);
        parts.state.tree.unweighed = 2;
    } else if step.margins_in == 0 {
        step.margins_in = PAUSE;
    } else if steps > 1 {
        step.spent += cost as u16;
    }
}

/// Leaves fat boxes unused for some steps. Objects that had another one count as moved. O(slots).
pub(crate) fn pause<I: Index>(parts: &mut Parts<'_, I>) {
    for slot in 0..parts.state.objects.slots as usize {
        let now = parts.boxes.now.at(slot);
        if !now.is_empty() && parts.boxes.fat.at(slot) != now {
            parts.objects().touch(slot);
        }
    }
    (parts.state.step.margins_in, parts.boxes.tight) = (PAUSE, true);
    parts.state.tree.unweighed = 1;
}

/// The path for a number of moved objects, and why.
pub(crate) fn choose<I: Index>(parts: &Parts<'_, I>, moved: u32) -> Route {
    let state = &parts.state;
    let known = state.pairs.complete != 0 && state.pairs.unkept == 0;
    let fixed = parts.config().forced.of(MOVERS_ONLY);
    if known && moved == 0 && fixed != Some(false) {
        Route::UNCHANGED
    } else if parts.sizes.is_small() {
        Route { path: Path::Lists, reason: Reason::FewObjects }
    } else if !known || state.tree.filled == 0 {
        anew(parts, Reason::NothingKept)
    } else {
        let by_leaf = parts.config().forced.of(MOVERS_BY_LEAF);
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
    let (moved, live) = (u64::from(moved), u64::from(state.objects.live));
    moved.saturating_mul(cost_of_movers(state)) <= live * live
}

/// What it costs to test all objects as movers one by one, where a full step costs one for each object.
fn cost_of_movers(state: &State) -> u64 {
    let (live, pairs) = (u64::from(state.objects.live), state.pairs.swept);
    MOVERS_SHARE * live + MOVERS_SHARE_PER_PAIR * pairs.min(live << 8) / 2
}

/// Whether a step of many movers may keep the pairs of other objects. New planes are judged by all pairs, so
/// they need all.
fn can_keep_pairs<I: Index>(parts: &Parts<'_, I>) -> bool {
    cfg!(feature = "large") && !balance::needs_planes(parts.state)
}

/// Whether a step of many movers is cheaper if it keeps the pairs of other objects and sweeps leaves only for
/// those of moved ones. That saves the search for pairs that stay, and their events. It costs a division of
/// the records of each leaf, and a second look at each pair that goes.
fn should_keep_pairs<I: Index>(parts: &Parts<'_, I>, moved: u32) -> bool {
    let (pairs, live) = (parts.state.pairs.swept, u64::from(parts.state.objects.live));
    let saved = if parts.sizes.previous > 0 { KEPT_SAVES_WITH_EVENTS } else { KEPT_SAVES };
    let cost = pairs + 2 * live;
    // It does not pay even if all pairs stay, or hardly any can.
    if pairs.saturating_mul(saved) <= cost || 8 * u64::from(moved) > 7 * live {
        return false;
    }
    let list = parts.output.pairs.span(0, parts.state.pairs.in_front());
    let (mut looked, mut stay) = (0, 0);
    for pair in list.iter().step_by((list.len() / PAIR_SAMPLE).max(1)) {
        looked += 1;
        stay += u64::from(is_clear_of(parts.moved.words, pair));
    }
    pairs.saturating_mul(saved).saturating_mul(stay) > cost.saturating_mul(looked)
}

/// The path that finds all pairs anew. `reason` counts unless new planes are due.
pub(super) fn anew<I: Index>(parts: &Parts<'_, I>, reason: Reason) -> Route {
    let tree = &parts.state.tree;
    if !balance::needs_planes(parts.state) {
        return Route { path: Path::Full, reason };
    }
    let reason = match tree.count {
        0 => Reason::NothingKept,
        _ if tree.due == Due::Heavy as u8 => Reason::OutOfBalance,
        _ => Reason::Outgrown,
    };
    Route { path: Path::Rebuilt, reason }
}

/// Divides some leaves in each step of a calm world.
pub(crate) fn subdivide_when_calm<I: Index>(
    parts: &mut Parts<'_, I>,
    path: Path,
    moved: u32,
    context: StepContext<'_>,
) {
    if parts.sizes.is_small() || parts.state.tree.filled == 0 {
        return;
    }
    let StepState { was_calm, renews, .. } = parts.state.step;
    let (few, due) = match parts.config().forced.of(FINE_LEAVES) {
        // Nor are there few that move while many do inside their fat boxes: a full step comes next.
        None => (are_few(parts.state, moved.max(parts.changed.count())), was_calm.clamp(CALM[0], CALM[1])),
        Some(true) => (true, 1),
        Some(false) => return,
    };
    // Leaves of which a full step comes next are not divided.
    let calm = few && matches!(path, Path::Unchanged | Path::Movers) && renews == 0;
    if !calm {
        return;
    }
    parts.state.step.calm = parts.state.step.calm.saturating_add(1);
    let some_are_undivided = parts.state.tree.subdivided <= parts.state.tree.count;
    if parts.state.step.calm >= due && some_are_undivided {
        context.executor.enter(Stage::Fill);
        run!(context.kernels, |simd| subdivide(simd, parts));
    }
}
