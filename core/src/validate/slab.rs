//! Checks what a slab has and a snapshot does not: numbers, lists, and what follows from the rest.

use super::sum;
use crate::access::{Access, bits};
use crate::id::Index;
use crate::memory::layout::Sizes;
use crate::memory::slab::Parts;
use crate::memory::state::{State, slot};
use crate::memory::stats::Path;
use crate::pairs::met;
use crate::snapshot::check::{self, Invalid, check};
use crate::snapshot::stored::Stored;
use crate::tree::large;

/// All that a snapshot has is right, and slots that were never in use are as new.
#[inline(never)]
pub(super) fn slots<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    check::all(&Stored::of(parts))?;
    let slots = parts.state.objects.slots as usize;
    let Parts { moved, settled, changed, outdated, filters, former, resting, active, .. } = parts;
    let sets = [moved, settled, changed, outdated, &filters.changed, &former.reused].map(|set| &*set.words);
    for set in sets.into_iter().chain([&**resting, active]) {
        let words = set.get(bits::words(slots)..).unwrap_or_default();
        check(words.iter().all(|word| *word == 0), "a set has slots that there are not", slots)?;
    }
    let generations = parts.generations.get(slots..).unwrap_or_default();
    check(generations.iter().all(|count| *count == 0), "a slot is not as new", slots)
}

/// A fat box holds its box. The box of the last complete step is the slot's, if it has not changed since.
pub(super) fn last_boxes<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    for (slot, now) in parts.boxes.now.iter().enumerate().take(parts.state.objects.slots as usize) {
        let swept = parts.boxes.swept().at(slot);
        let holds = if now.is_empty() { swept.is_empty() } else { swept.is_valid() && swept.contains(now) };
        check(holds, "a fat box does not hold its box", slot)?;
    }
    for (slot, before) in parts.boxes.before.iter().enumerate().take(parts.state.objects.slots as usize) {
        let known = !bits::test(parts.changed.words, slot) && !bits::test(parts.outdated.words, slot);
        let now = parts.boxes.now.at(slot);
        let same = *before == now || before.is_empty() && now.is_empty();
        check(!known || same, "a box of the last step is not kept", slot)?;
    }
    let last = met::last_result(parts.state, &parts.output);
    let bits: u32 = parts.met.iter().map(|word| word.count_ones()).sum();
    let known = bits as usize <= last.len() && last.iter().all(|pair| met::has::<I, false>(parts.met, pair));
    check(parts.met.is_empty() || known, "the bits are not those of the last pairs", bits as usize)
}

/// The list has every living object once, and is in order once it was swept.
pub(super) fn lists<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let (listed, boxes) = (parts.state.lists.listed as usize, parts.boxes.swept());
    if parts.state.lists.stale != 0 || listed != parts.state.objects.live as usize {
        return Ok(());
    }
    let (list, now) = (parts.list.span(0, listed).iter().map(|word| slot(*word)), &parts.boxes.now);
    let lives = list.clone().all(|slot| !now.at(slot).is_empty());
    let living = (0..parts.state.objects.slots).filter(|slot| !now.at(*slot as usize).is_empty());
    let listed_once = sum(list.clone().map(|slot| slot as u64)) == sum(living.map(u64::from));
    check(lives && listed_once, "the list does not hold each living object once", listed)?;
    let swept = parts.state.stats().path == Path::Lists
        && parts.state.pairs.unkept == 0
        && parts.filters.of.is_empty()
        && parts.moved.count() + parts.settled.count() == 0;
    let axis = parts.state.lists.axis as usize;
    let ascends = list.clone().is_sorted_by_key(|slot| (boxes.at(slot).min.at(axis), slot));
    check(!swept || ascends, "the swept list is not in order", axis)
}

/// Checks all numbers of a state before any is used in an index, but for the numbers that a snapshot has.
#[inline(never)]
pub(super) fn numbers(state: &State, sizes: &Sizes) -> Result<(), Invalid> {
    let State { objects, lists, tree, pairs, step, .. } = state;
    let (parked, surplus, swept) = (u64::from(pairs.parked), u64::from(pairs.surplus_parked), pairs.swept);
    let (end, events) = (pairs.reported, sizes.previous > 0);
    let flags = [lists.stale, tree.uneven, pairs.unkept, pairs.swapped, pairs.before_unknown];
    let all = [
        (flags.iter().all(|flag| *flag <= 1), "a number that is neither yes nor no"),
        (objects.slots as usize <= sizes.objects, "more slots than there is room for"),
        (lists.stale != 0 || u32::from(lists.listed) <= objects.slots, "the lists are too long"),
        (lists.axis < 3, "an axis that there is not"),
        (step.margins_in == 0 || sizes.fat > 0, "fat boxes that are not used where there are none"),
        (tree.count as usize <= sizes.whole_leaves, "more leaves than room"),
        (tree.filled <= 2, "leaves that are filled in no known way"),
        (tree.filled == 0 || tree.count > 0, "filled leaves without planes"),
        (tree.coarser < 32, "leaves of no size"),
        (tree.subdivided == 0 || sizes.tree > 0, "leaves are divided without a tree"),
        (tree.subdivided.saturating_sub(1) <= tree.count, "more leaves are divided than there are"),
        (large::has_room(tree, tree.large as usize, sizes.straddlers), "more large objects than room"),
        (swept <= sizes.pairs as u64, "more pairs than room"),
        (end.saturating_add(surplus) <= swept, "more pairs are exact, or surplus and parked, than swept"),
        (parked + surplus == 0 || sizes.tree > 0, "pairs are parked without a tree"),
        (sizes.fat > 0 || end == swept, "surplus without fat boxes"),
        (pairs.found.saturating_add(parked) <= end, "more pairs are found than there are"),
        (events || pairs.swapped == 0, "buffers that have not changed places"),
        (pairs.previous <= sizes.previous as u64, "more pairs of the last step than room"),
    ];
    all.into_iter().enumerate().try_for_each(|(at, (holds, what))| check(holds, what, at))
}
