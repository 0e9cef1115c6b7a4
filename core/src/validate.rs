//! Checks every invariant of a world. For tests and for debugging an embedding: O(n log n), never called by a step.

use crate::access::{Access, bits};
use crate::arch::{Simd as _, scalar::Scalar};
use crate::carry::is_clear_of;
use crate::id::Index;
use crate::key::KeyBox;
use crate::links;
use crate::state::Path;
use crate::storage::Parts;
use crate::sweep::strips;
use crate::tree::cells::cut;
use crate::tree::{Cell, home_of};
use crate::world::World;
use core::fmt;

/// The first broken invariant that [`World::validate`] met. It would be an error of this library, or of whoever wrote to
/// the slab.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

fn check(holds: bool, what: &'static str, at: usize) -> Result<(), Invalid> {
    if holds { Ok(()) } else { Err(Invalid { what, at }) }
}

impl<I: Index> World<'_, I> {
    /// Checks every invariant of the world: slots, boxes, lists, tree and pairs.
    ///
    /// # Errors
    /// The first broken one.
    pub fn validate(&self) -> Result<(), Invalid> {
        let parts = &self.parts;
        slots(parts)?;
        boxes(parts)?;
        lists(parts)?;
        if !parts.sizes.is_small() && parts.state.filled != 0 {
            tree(parts)?;
        }
        pairs(parts)
    }
}

/// Free slots are chained, each once, and all others live.
fn slots<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let used = parts.state.slots as usize;
    let free = (0..used).filter(|&slot| parts.boxes.now.at(slot).is_empty()).count();
    check(free + parts.state.live as usize == used, "the living objects are not counted right", used)?;
    let mut next = parts.state.free as usize;
    for _ in 0..free {
        check(next >= 1 && next <= used, "the chain of free slots leaves the slots", next)?;
        let bounds = parts.boxes.now.at(next - 1);
        check(bounds.is_empty(), "a living object is in the chain of free slots", next - 1)?;
        next = bounds.next_free() as usize;
    }
    check(next == 0, "the chain of free slots does not end", next)
}

/// Fat boxes hold their boxes.
fn boxes<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    for (slot, (now, fat)) in parts.boxes.now.iter().zip(&*parts.boxes.fat).enumerate() {
        let fine = if now.is_empty() { fat.is_empty() } else { fat.contains(now) };
        check(fine, "a fat box does not hold its box", slot)?;
    }
    Ok(())
}

/// Each list has every living object once, and the list that a step has swept is in order.
fn lists<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    if parts.state.stale_lists != 0 {
        return Ok(());
    }
    let listed = parts.state.listed as usize;
    for slot in 0..parts.state.slots as usize {
        let lives = !parts.boxes.now.at(slot).is_empty();
        check(!lives || bits::test(parts.listed, slot), "a living object is not marked as listed", slot)?;
    }
    check(
        bits::count(parts.listed) as usize == listed,
        "the marks of the lists are not counted right",
        listed,
    )?;
    for order in &parts.order {
        // The sum of distinct marked slots is that of all marked slots only if each stands there once.
        let mut sum = 0u64;
        for slot in order.span(0, listed) {
            check(bits::test(parts.listed, slot.at()), "a list holds a slot that is not marked", slot.at())?;
            sum += square(slot.at());
        }
        let marked: u64 = bits::ones(parts.listed).map(square).sum();
        check(sum == marked, "a list holds a slot twice", listed)?;
    }
    let swept = parts.state.stats().path == Path::Lists
        && parts.state.without_surplus == 0
        && parts.moved.count() == 0;
    if swept && listed == parts.state.live as usize {
        let axis = parts.state.list_axis as usize;
        let order = parts.order.get(axis).map_or(&[][..], |order| order.span(0, listed));
        for (at, two) in order.windows(2).enumerate() {
            let boxes = parts.boxes.swept();
            let ascends = match parts.output.planes.first() {
                Some(planes) => {
                    let axes = [axis, parts.state.strip_axis as usize];
                    let place = |slot: I| strips::place(&boxes.at(slot.at()), slot.slot(), axes, planes);
                    place(two.at(0)) < place(two.at(1))
                }
                None => links::precedes(boxes, axis, two.at(0), two.at(1)),
            };
            check(ascends, "the swept list is not in order", at)?;
        }
    }
    Ok(())
}

fn square(slot: usize) -> u64 {
    (slot as u64 + 1).pow(2)
}

/// Every object that has not moved since stands once where the planes say, with a record of its box, and the boxes of
/// nodes hold it.
fn tree<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let finer = parts.state.finer();
    let leaves = parts.state.leaves() as usize;
    let swept = parts.boxes.swept();
    for node in 1..2 << parts.state.depth {
        let around = parts.tree.nodes.at(node);
        // A cast computes with their sides.
        check(around == KeyBox::NOTHING || around.is_valid(), "the box of a node is none", node)?;
    }
    let mut members = 0;
    for index in 0..leaves {
        let leaf = parts.tree.leaves.at(index);
        check(leaf.len <= leaf.room, "a leaf has more records than room", index)?;
        members += leaf.len as usize;
        for at in 0..leaf.len as usize {
            let record = parts.tree.records.at(leaf.start as usize + at);
            let slot = record.slot() as usize;
            if bits::test(parts.moved.words, slot) {
                continue;
            }
            let bounds = swept.at(slot);
            check(!bounds.is_empty(), "a record has no object", slot)?;
            check(parts.home.at(slot).at() == index, "a record is not in its object's leaf", slot)?;
            check(parts.place.at(slot).at() == at, "a record is not at its object's place", slot)?;
            let home = home_of(parts.tree.planes, parts.state, &bounds.min);
            check(home == index, "an object is not where the planes say", slot)?;
            check(parts.tree.cells.at(index).holds(&bounds.min), "a minimum is outside its cell", slot)?;
            let expected = Scalar.record(&parts.tree.frames.at(index >> finer), bounds, slot as u32);
            check(record == expected, "a record is not that of its box", slot)?;
            let mut around = parts.tree.bounds.at(index);
            around.include(&record);
            check(
                finer == 0 || around == parts.tree.bounds.at(index),
                "the bounds of a leaf do not hold a member",
                index,
            )?;
            let mut node = (leaves + index) >> finer;
            while node > 0 {
                check(
                    parts.tree.nodes.at(node).contains(&bounds),
                    "the box of a node does not hold a member",
                    node,
                )?;
                node /= 2;
            }
        }
    }
    for at in 0..parts.state.large as usize {
        let front = parts.tree.fronts.at(parts.state.large_start as usize + at);
        let slot = front.slot as usize;
        if bits::test(parts.moved.words, slot) {
            continue;
        }
        check(front.bounds == swept.at(slot), "a large object's box is not its own", slot)?;
        check(parts.home.at(slot) == I::LARGE, "a large object has a leaf", slot)?;
        check(parts.place.at(slot).at() == at, "a large object is not at its place", slot)?;
    }
    let all = members + parts.state.large as usize;
    let moved = parts.moved.count() > 0;
    check(moved || all == parts.state.live as usize, "the tree does not hold every object once", all)?;
    cells(parts)
}

/// The cells are those of the planes, and the frames sound. Cut one by one, so that no room is needed.
fn cells<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let finer = parts.state.finer();
    let depth = parts.state.depth + finer;
    for index in 0..1usize << depth {
        let mut planes = [0; 32];
        let mut cell = Cell::ALL;
        let divided = finer == 0 || parts.state.is_refined(index >> finer);
        if !divided && index & ((1 << finer) - 1) != 0 {
            check(parts.tree.leaves.at(index).len == 0, "a part of a whole leaf has members", index)?;
            continue;
        }
        for level in 0..if divided { depth } else { depth - finer } {
            let node = ((1 << depth) + index) >> (depth - level);
            let right = ((1 << depth) + index) >> (depth - level - 1) & 1;
            planes.put(1, parts.tree.planes.at(node));
            let mut halves = [cell, cell];
            cut(&planes, 1, &parts.state.extent(), &mut halves);
            let half = halves.at(right);
            let (mut low, mut high) = (cell.low(), cell.high());
            for k in 0..3 {
                low[k] = low[k].max(half.low()[k]);
                high[k] = high[k].min(half.high()[k]);
            }
            cell = Cell::new(low, high, high);
        }
        let known = parts.tree.cells.at(index);
        check(
            (cell.low(), cell.high()) == (known.low(), known.high()),
            "a cell is not that of its planes",
            index,
        )?;
        check(
            parts.tree.frames.at(index >> finer).is_sound(),
            "a frame does not keep the order of numbers",
            index,
        )?;
    }
    Ok(())
}

/// The pairs are those of living, overlapping objects, if nothing has changed since.
fn pairs<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let state = &parts.state;
    check(state.found <= state.result_pairs, "more pairs are found than there are", state.found as usize)?;
    check(
        state.result().end as u64 <= state.swept_pairs,
        "more pairs are exact, or surplus and set aside, than swept",
        state.swept_pairs as usize,
    )?;
    check(
        state.swept_pairs <= parts.output.pairs.len() as u64,
        "more pairs than room",
        state.swept_pairs as usize,
    )?;
    check(
        (state.surplus_aside as usize..=state.result().end).contains(&(state.aside as usize)),
        "more pairs are set aside than there are, or fewer than their surplus",
        state.aside as usize,
    )?;
    for (at, pair) in parts.output.pairs.span(0, state.aside as usize).iter().enumerate() {
        check(is_clear_of(parts.awake, pair), "a pair of an object that is awake is set aside", at)?;
    }
    if state.complete == 0 || state.crept != 0 || parts.moved.count() > 0 {
        return Ok(());
    }
    let overlap = |boxes: &[KeyBox], pair: &[I; 2]| boxes.at(pair[0].at()).overlaps(&boxes.at(pair[1].at()));
    for (at, pair) in parts.output.pairs.span(0, state.swept_pairs as usize).iter().enumerate() {
        check(pair[0] < pair[1], "a pair is not in order", at)?;
        check(overlap(parts.boxes.swept(), pair), "a pair does not overlap", at)?;
        check(
            overlap(parts.boxes.reported(state.mode()), pair) == state.result().contains(&at),
            "a pair overlaps and is surplus, or does not and is reported",
            at,
        )?;
    }
    Ok(())
}
