//! Checks what a slab has and a snapshot does not: lists, and what follows from the rest.

use crate::access::{Access, bits};
use crate::id::Index;
use crate::lists::links;
use crate::memory::slab::Parts;
use crate::memory::stats::Path;
use crate::snapshot::check::{Invalid, check};

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

/// The box of the last complete step is that of the slot, if it has not changed since.
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

/// Slots that are looked for at a time. Their bits are on the stack, which is small on a microcontroller.
const SLOTS_AT_A_TIME: usize = if cfg!(feature = "large") { 1 << 15 } else { 1 << 8 };

/// Each list has every living object once, and the list that was swept is in order.
fn lists<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    if parts.state.lists.stale != 0 {
        return Ok(());
    }
    let (listed, slots) = (parts.state.lists.listed as usize, parts.state.objects.slots as usize);
    for slot in 0..slots {
        let lives = !parts.boxes.now.at(slot).is_empty();
        check(!lives || bits::test(parts.listed, slot), "a living object is not marked as listed", slot)?;
    }
    check(
        bits::count(parts.listed) as usize == listed,
        "the marks of the lists are not counted right",
        listed,
    )?;
    for order in &parts.order {
        let order = order.span(0, listed);
        for first in (0..slots).step_by(SLOTS_AT_A_TIME) {
            let mut met = [0; SLOTS_AT_A_TIME / 32];
            for slot in order {
                let marked = slot.at() < slots && bits::test(parts.listed, slot.at());
                check(marked, "a list holds a slot that is not marked", slot.at())?;
                if let Some(bit) = slot.at().checked_sub(first).filter(|bit| *bit < SLOTS_AT_A_TIME) {
                    check(bits::set(&mut met, bit), "a list holds a slot twice", slot.at())?;
                }
            }
        }
    }
    let swept = parts.state.stats().path == Path::Lists
        && parts.state.pairs.unkept == 0
        && parts.moved.count() + parts.settled.count() == 0;
    if swept && listed == parts.state.objects.live as usize {
        let axis = parts.state.lists.axis as usize;
        let order = parts.order.get(axis).map_or(&[][..], |order| order.span(0, listed));
        for (at, two) in order.windows(2).enumerate() {
            let boxes = parts.boxes.swept();
            let ascends = links::precedes(boxes, axis, two.at(0), two.at(1));
            check(ascends, "the swept list is not in order", at)?;
        }
    }
    Ok(())
}
