//! Checks what a slab has and a snapshot does not: numbers, lists, and what follows from the rest.

use super::sum;
use crate::access::{Access, bits};
use crate::config::Mode;
use crate::id::Index;
use crate::memory::layout::Sizes;
use crate::memory::slab::Parts;
use crate::memory::state::State;
use crate::memory::stats::Path;
use crate::snapshot::check::{Invalid, check};
use crate::tree::large;

/// Checks all of it.
pub(super) fn slab<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    unused(parts)?;
    last_boxes(parts)?;
    lists(parts)
}

/// Slots that were never in use are as new.
fn unused<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let slots = parts.state.objects.slots as usize;
    for set in [
        &*parts.moved.words,
        parts.settled.words,
        parts.changed.words,
        parts.outdated.words,
        parts.filters.changed.words,
        parts.resting,
        parts.active,
        parts.former.reused.words,
    ] {
        let words = set.get(bits::words(slots)..).unwrap_or_default();
        check(words.iter().all(|word| *word == 0), "a set has slots that there are not", slots)?;
    }
    let generations = parts.generations.get(slots..).unwrap_or_default();
    check(generations.iter().all(|count| *count == 0), "a slot is not as new", slots)
}

/// The box of the last complete step is the slot's, if it has not changed since.
fn last_boxes<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let reported = parts.boxes.reported(parts.mode());
    for (slot, before) in parts.boxes.before.iter().enumerate().take(parts.state.objects.slots as usize) {
        let known = !bits::test(parts.changed.words, slot) && !bits::test(parts.outdated.words, slot);
        let reported = reported.at(slot);
        let same = *before == reported || before.is_empty() && reported.is_empty();
        check(!known || same, "a box of the last step is not kept", slot)?;
    }
    Ok(())
}

/// The list has every living object once, and is in order once it was swept.
fn lists<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let (listed, boxes) = (parts.state.lists.listed as usize, parts.boxes.swept());
    if parts.state.lists.stale != 0 || listed != parts.state.objects.live as usize {
        return Ok(());
    }
    let (order, now) = (parts.order[0].span(0, listed), &parts.boxes.now);
    let lives = order.iter().all(|slot| !now.at(slot.at()).is_empty());
    let living = (0..parts.state.objects.slots).filter(|slot| !now.at(*slot as usize).is_empty());
    let listed_once = sum(order.iter().map(|slot| slot.slot().into())) == sum(living.map(u64::from));
    check(lives && listed_once, "the list does not hold each living object once", listed)?;
    let swept = parts.state.stats().path == Path::Lists
        && parts.state.pairs.unkept == 0
        && parts.moved.count() + parts.settled.count() == 0;
    let axis = parts.state.lists.axis as usize;
    let low = |slot: I| (boxes.at(slot.at()).min.at(axis), slot);
    let ascends = order.windows(2).all(|two| low(two.at(0)) < low(two.at(1)));
    check(!swept || ascends, "the swept list is not in order", axis)?;
    Ok(())
}

/// Checks all numbers of a state before any is used in an index, but for the numbers that a snapshot has.
pub(super) fn numbers(state: &State, sizes: &Sizes) -> Result<(), Invalid> {
    objects(state, sizes)?;
    tree(state, sizes)?;
    pairs(state, sizes)
}

fn objects(state: &State, sizes: &Sizes) -> Result<(), Invalid> {
    let slots = state.objects.slots;
    check(slots as usize <= sizes.objects, "more slots than there is room for", slots as usize)?;
    check(
        state.lists.stale != 0 || state.lists.listed <= slots,
        "the lists are too long",
        state.lists.listed as usize,
    )?;
    check(state.lists.axis < 3 && state.lists.second_axis < 3, "an axis that there is not", 0)?;
    let flags = [state.lists.stale, state.tree.uneven, state.pairs.unkept, state.pairs.swapped];
    for (at, flag) in flags.into_iter().enumerate() {
        check(flag <= 1, "a number that is neither yes nor no", at)?;
    }
    check(state.tree.filled <= 2, "leaves that are filled in no known way", state.tree.filled.into())?;
    check(state.step.margins_in == 0 || sizes.fat > 0, "fat boxes that are not used where there are none", 0)
}

fn tree(state: &State, sizes: &Sizes) -> Result<(), Invalid> {
    check(
        state.tree.count as usize <= sizes.whole_leaves,
        "more leaves than room",
        state.tree.count as usize,
    )?;
    check(state.tree.coarser < 32, "leaves of no size", state.tree.coarser as usize)?;
    check(
        state.tree.subdivided == 0 || sizes.tree > 0 && state.tree.subdivided <= state.tree.count + 1,
        "more leaves are divided than there are",
        state.tree.subdivided as usize,
    )?;
    check(state.tree.filled == 0 || state.tree.count > 0, "filled leaves without planes", 0)?;
    check(
        large::has_room(&state.tree, state.tree.large as usize, sizes.straddlers),
        "more large objects than there is room for",
        state.tree.large as usize,
    )
}

fn pairs(state: &State, sizes: &Sizes) -> Result<(), Invalid> {
    let (parked, surplus_parked) = (u64::from(state.pairs.parked), u64::from(state.pairs.surplus_parked));
    let end = surplus_parked.saturating_add(state.pairs.reported);
    let swept = state.pairs.swept;
    check(swept <= sizes.pairs as u64, "more pairs than room", swept as usize)?;
    check(end <= swept, "more pairs are exact, or surplus and parked, than swept", swept as usize)?;
    check(
        surplus_parked <= parked && parked <= end,
        "more pairs are parked than there are, or fewer than their surplus",
        state.pairs.parked as usize,
    )?;
    check(parked == 0 || sizes.tree > 0, "pairs are parked without a tree", state.pairs.parked as usize)?;
    let has_surplus = sizes.config.mode == Mode::Exact && sizes.fat > 0;
    check(has_surplus || surplus_parked == 0 && end == swept, "surplus without margins", swept as usize)?;
    check(
        state.pairs.found <= end - parked,
        "more pairs are found than there are",
        state.pairs.found as usize,
    )?;
    let events = sizes.previous > 0;
    check(events || state.pairs.swapped == 0, "buffers that have not changed places", 0)?;
    let previous = state.pairs.previous;
    // A step that finds all pairs anew adds the parked ones.
    let more = if state.pairs.complete != 0 || !events { 0 } else { parked - surplus_parked };
    check(
        previous <= sizes.previous as u64 && previous + more <= sizes.previous as u64,
        "more pairs of the last step than room",
        previous as usize,
    )
}
