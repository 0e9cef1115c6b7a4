//! Checks what a snapshot has, before a world is replaced by it.

use super::stored::{Packed, Stored};
use crate::config::Margin;
use crate::filter::{CLASSES, meet};
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use core::fmt;

/// The first broken invariant that [`World::validate`](crate::World::validate) met: a fault of this library,
/// or something wrote to the slab.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(feature = "validate"), allow(unreachable_pub))]
pub struct Invalid {
    what: &'static str,
    at: usize,
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (at {})", self.what, self.at)
    }
}

impl core::error::Error for Invalid {}

pub(crate) fn check(holds: bool, what: &'static str, at: usize) -> Result<(), Invalid> {
    if holds { Ok(()) } else { Err(Invalid { what, at }) }
}

/// Checks all of it. O(slots + pairs).
pub(crate) fn all<I: Index>(stored: &Stored<'_, I>) -> Result<(), Invalid> {
    numbers(stored)?;
    sets(stored)?;
    let (mut free, mut empty) = (0, 0);
    for slot in 0..stored.now.len() {
        free += usize::from(stored.now.at(slot).is_free());
        empty += usize::from(stored.now.at(slot).is_empty());
        object(stored, slot)?;
    }
    let (living, disabled) = (stored.now.len() - empty, empty - free);
    check(stored.state.objects.live as usize == living, "the living objects are not counted right", living)?;
    let known = stored.state.objects.disabled as usize == disabled;
    check(known, "the disabled objects are not counted right", disabled)?;
    chain(stored, free)?;
    last_step(stored)?;
    pairs(stored)
}

/// Flags are flags, and counts agree.
fn numbers<I: Index>(stored: &Stored<'_, I>) -> Result<(), Invalid> {
    let (objects, pairs) = (&stored.state.objects, &stored.state.pairs);
    let came = objects.has_inserted.saturating_sub(1);
    let flags = [objects.dirty, objects.resting, came, pairs.complete, pairs.before_unknown];
    for (at, flag) in flags.into_iter().enumerate() {
        check(flag <= 1, "a number that is neither yes nor no", at)?;
    }
    check(stored.state.step.route().is_some(), "a path that there is not", 0)?;
    check(pairs.found <= pairs.reported, "more pairs are found than there are", pairs.found as usize)?;
    check(pairs.lost <= pairs.previous, "more pairs are lost than there were", pairs.lost as usize)?;
    let events = stored.config.events;
    check(events || pairs.found == 0 && pairs.previous == 0, "events in a world without events", 0)
}

/// Sets hold only slots that there are. Moved objects have changed; so have objects with another filter.
fn sets<I: Index>(stored: &Stored<'_, I>) -> Result<(), Invalid> {
    let Stored { moved, settled, resting, changed, refiltered, reused, .. } = stored;
    let slots = stored.now.len();
    for set in [moved, settled, resting, changed, refiltered, reused] {
        let last = if slots / 32 < set.len() { set.at(slots / 32) } else { 0 };
        check(last >> (slots % 32) == 0, "a set has slots that there are not", slots)?;
    }
    let is_part = |set: &Packed<'_, u32>, of: &Packed<'_, u32>| {
        set.len() != of.len() || set.iter().zip(of.iter()).all(|(word, of)| word & !of == 0)
    };
    check(is_part(moved, changed) && is_part(settled, changed), "an object has moved and not changed", 0)?;
    let known = refiltered.slots().all(|slot| moved.has(slot) || settled.has(slot));
    check(known, "a filter has changed of an object that has not moved", 0)?;
    let any = |set: &Packed<'_, u32>| set.iter().any(|word| word != 0);
    let objects = &stored.state.objects;
    check(objects.dirty != 0 || !any(moved), "objects have moved and nothing is noted as changed", 0)?;
    check(objects.resting != 0 || !any(resting), "objects rest that were not put to rest", 0)
}

/// Checks a slot by itself.
fn object<I: Index>(stored: &Stored<'_, I>, slot: usize) -> Result<(), Invalid> {
    let now = stored.now.at(slot);
    check(stored.generations.at(slot) != 0, "a slot has no generation", slot)?;
    let (free, low) = (now.is_free(), stored.cut.at(slot));
    let disabled = || now.enabled(low).is_valid() && now.enabled(low).disabled() == (now, low);
    let known = now.is_valid() || if free { is_free(&now) } else { disabled() };
    check(known, "a box is none", slot)?;
    check(!free || !stored.resting.has(slot), "a free slot rests", slot)?;
    if stored.given.len() > 0 {
        let given = stored.given.at(slot);
        let held = if now.is_empty() { is_free(&given) } else { given.is_valid() && now.contains(&given) };
        check(held, "a box with its margin does not hold the box", slot)?;
    }
    if stored.margins.len() > 0 {
        check(Margin::length(stored.margins.at(slot)).is_valid(), "a margin is none", slot)?;
    }
    let class = if stored.filters.len() > 0 { stored.filters.at(slot).class } else { 0 };
    check((class as usize) < CLASSES, "a class that there is not", slot)
}

/// Whether a box is a free slot's: any other empty box might overlap something.
fn is_free(bounds: &KeyBox) -> bool {
    *bounds == KeyBox::free(bounds.next_free())
}

/// The chain of free slots has each of them once, and ends.
fn chain<I: Index>(stored: &Stored<'_, I>, free: usize) -> Result<(), Invalid> {
    let mut next = stored.state.objects.free as usize;
    for _ in 0..free {
        check(next >= 1 && next <= stored.now.len(), "the chain of free slots leaves the slots", next)?;
        let bounds = stored.now.at(next - 1);
        check(bounds.is_free(), "a living object is in the chain of free slots", next - 1)?;
        next = bounds.next_free() as usize;
    }
    // A chain that comes back to a slot never ends.
    check(next == 0, "the chain of free slots does not end", next)
}

/// The boxes of the last complete step, of objects that may have others now; and who had slots before.
fn last_step<I: Index>(stored: &Stored<'_, I>) -> Result<(), Invalid> {
    for (slot, before) in stored.of_set(&stored.changed, &stored.before) {
        check(before.is_valid() || is_free(&before), "a box of the last step is none", slot)?;
    }
    for (slot, generation) in stored.of_set(&stored.reused, &stored.former) {
        let another = generation != 0 && generation != stored.generations.at(slot);
        check(another, "no object had a slot that was given to another one", slot)?;
    }
    Ok(())
}

/// Each pair has two slots in order. If nothing has changed since, the boxes of a pair of the result overlap,
/// and the filters let it through.
fn pairs<I: Index>(stored: &Stored<'_, I>) -> Result<(), Invalid> {
    let Stored { moved, settled, changed, filters, .. } = stored;
    let in_order = |pair: &Pair<I>| pair[0] < pair[1] && pair[1].at() < stored.now.len();
    let boxes = &stored.now;
    let stays = |slot: usize| ![moved, settled, changed].iter().any(|set| set.has(slot));
    let meets = |a, b| meet(&filters.at(a), &filters.at(b), |class| stored.classes.at(class));
    for (at, pair) in stored.pairs.iter().enumerate() {
        check(in_order(&pair), "a pair is not of two slots in order", at)?;
        let [a, b] = pair.map(Index::at);
        if stays(a) && stays(b) {
            check(boxes.at(a).overlaps(&boxes.at(b)), "a pair does not overlap", at)?;
            check(filters.len() == 0 || meets(a, b), "a pair that the filters do not let through", at)?;
        }
    }
    check(
        stored.previous.iter().all(|pair| in_order(&pair)),
        "a pair of the last step is not of two slots",
        0,
    )
}
