//! Checks objects: slots, boxes, margins, filters, sets of slots.

use super::content::{Content, Set, count};
use super::{Invalid, check};
use crate::access::bits;
use crate::config::Margin;
use crate::filter::CLASSES;
use crate::geometry::key::KeyBox;
use crate::id::Index;

/// Checks all slots. O(slots).
pub(crate) fn objects<I: Index>(content: &impl Content<I>) -> Result<(), Invalid> {
    sets(content)?;
    let state = content.state();
    let slots = state.objects.slots as usize;
    let mut free = 0;
    for slot in 0..slots {
        let now = content.now(slot);
        check(content.generation(slot) != 0, "a slot has no generation", slot)?;
        if now.is_empty() {
            // Any other empty box might overlap something.
            check(now == KeyBox::free(now.next_free()), "a free slot has a box", slot)?;
            check(!content.is_in(Set::Resting, slot), "a free slot rests", slot)?;
            free += 1;
        } else {
            check(now.is_valid(), "a box is none", slot)?;
        }
        if content.sizes().fat > 0 {
            let fat = content.fat(slot);
            let fine = if state.step.margins_in > 0 {
                fat == now
            } else if now.is_empty() {
                fat == KeyBox::EMPTY
            } else {
                fat.is_valid() && fat.contains(&now)
            };
            check(fine, "a fat box does not hold its box", slot)?;
            check(Margin::length(content.margin(slot)).is_valid(), "a margin is none", slot)?;
        }
        if content.sizes().filters > 0 {
            let class = content.filter(slot).class;
            check((class as usize) < CLASSES, "a class that there is not", slot)?;
        }
    }
    check(free + state.objects.live as usize == slots, "the living objects are not counted right", slots)?;
    chain(content, free)?;
    last_boxes(content)?;
    former(content)
}

/// The chain of free slots has each of them once, and ends.
fn chain<I: Index>(content: &impl Content<I>, free: usize) -> Result<(), Invalid> {
    let used = content.state().objects.slots as usize;
    let mut next = content.state().objects.free as usize;
    for _ in 0..free {
        check(next >= 1 && next <= used, "the chain of free slots leaves the slots", next)?;
        let bounds = content.now(next - 1);
        check(bounds.is_empty(), "a living object is in the chain of free slots", next - 1)?;
        next = bounds.next_free() as usize;
    }
    // A chain that comes back to a slot never ends.
    check(next == 0, "the chain of free slots does not end", next)
}

/// Sets hold only slots that there are. Moved objects have changed, and objects with another filter count as moved.
fn sets<I: Index>(content: &impl Content<I>) -> Result<(), Invalid> {
    let state = content.state();
    let slots = state.objects.slots as usize;
    for set in [Set::Moved, Set::Resting, Set::Changed, Set::Active, Set::Refiltered, Set::Reused] {
        if !slots.is_multiple_of(32) {
            let last = content.word(set, slots / 32).unwrap_or(0);
            check(last >> (slots % 32) == 0, "a set has slots that there are not", slots)?;
        }
    }
    for index in 0..bits::words(slots) {
        let word = |set| content.word(set, index);
        let moved = word(Set::Moved).unwrap_or(0);
        check(
            word(Set::Changed).is_none_or(|changed| moved & !changed == 0),
            "an object has moved and not changed",
            index * 32,
        )?;
        check(
            word(Set::Refiltered).is_none_or(|refiltered| refiltered & !moved == 0),
            "a filter has changed of an object that has not moved",
            index * 32,
        )?;
    }
    let any = |set| count(content, set, slots) > 0;
    check(
        state.objects.dirty != 0 || !any(Set::Moved),
        "objects have moved and nothing is noted as changed",
        0,
    )?;
    check(state.objects.resting != 0 || !any(Set::Resting), "objects rest that were not put to rest", 0)
}

/// A reused slot had an object, and not the one that has it now.
fn former<I: Index>(content: &impl Content<I>) -> Result<(), Invalid> {
    let mut rank = 0;
    for index in 0..bits::words(content.state().objects.slots as usize) {
        for bit in bits::of_word(content.word(Set::Reused, index).unwrap_or(0)) {
            let slot = index * 32 + bit;
            let generation = content.former(slot, rank);
            let another = generation != 0 && generation != content.generation(slot);
            check(another, "no object had a slot that was given to another one", slot)?;
            rank += 1;
        }
    }
    Ok(())
}

/// The boxes of the last complete step, of objects that may have others now.
fn last_boxes<I: Index>(content: &impl Content<I>) -> Result<(), Invalid> {
    if content.sizes().before == 0 {
        return Ok(());
    }
    let mut rank = 0;
    for index in 0..bits::words(content.state().objects.slots as usize) {
        for bit in bits::of_word(content.word(Set::Changed, index).unwrap_or(0)) {
            let slot = index * 32 + bit;
            let before = content.before(slot, rank);
            let empty = before == KeyBox::EMPTY || before == KeyBox::free(before.next_free());
            check(empty || before.is_valid(), "a box of the last step is none", slot)?;
            let fresh = empty && !content.now(slot).is_empty();
            check(
                !fresh || content.state().objects.has_inserted != 0,
                "a new object that has not come",
                slot,
            )?;
            rank += 1;
        }
    }
    Ok(())
}
