//! Replaces a world by a checked snapshot, and computes what the snapshot does not have.

use super::image::Stored;
use crate::access::{Access, bits};
use crate::config::Mode;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::limits::SUB_LEVELS;
use crate::memory::slab::{BoxParts, Parts};
use crate::memory::state::State;
use crate::simd::kernels::Kernels;
use crate::simd::{Phase, Simd};
use crate::step::recount::prove_at_once;
use crate::tree::cells::divide;
use crate::tree::{Cell, Frame, Leaf, Record, SUB_LEAVES, Straddler};

/// Replaces a world. Nothing can fail here. Slots beyond those in use become as new.
pub(super) fn replace<I: Index>(parts: &mut Parts<'_, I>, state: &State, stored: &Stored<'_, I>) {
    let mut state = *state;
    state.adopt(parts.state);
    state.pairs.unproven = 1;
    *parts.state = state;
    parts.boxes.tight = state.step.margins_in > 0;
    stored.now.copy_to(parts.boxes.now, KeyBox::EMPTY);
    stored.fat.copy_to(parts.boxes.fat, KeyBox::EMPTY);
    stored.margins.copy_to(parts.boxes.margins, 0.0);
    stored.filters.copy_to(parts.filters.of, Default::default());
    stored.classes.copy_to(parts.filters.classes, 0);
    stored.values.copy_to(parts.values.of, 0);
    stored.generations.copy_to(parts.generations, 0);
    stored.resting.copy_to(parts.resting, 0);
    stored.active.copy_to(parts.active, 0);
    let mut sets = [
        (parts.moved.reborrow(), &stored.moved),
        (parts.changed.reborrow(), &stored.changed),
        (parts.filters.changed.reborrow(), &stored.refiltered),
        (parts.former.reused.reborrow(), &stored.reused),
    ];
    for (set, words) in &mut sets {
        words.copy_to(set.words, 0);
        set.regroup();
    }
    for (slot, generation) in bits::ones(parts.former.reused.words).zip(stored.former.iter()) {
        parts.former.generations.put(slot, generation);
    }
    for (slot, value) in bits::ones(parts.former.reused.words).zip(stored.former_values.iter()) {
        parts.values.former.put(slot, value);
    }
    // What is behind the pairs means nothing.
    for (at, pair) in stored.pairs.iter().enumerate() {
        parts.output.pairs.put(at, pair);
    }
    for (at, pair) in stored.previous.iter().enumerate() {
        parts.output.previous.put(at, pair);
    }
    parts.output.segments.set_blocks(stored.segments.len() / 2);
    stored.segments.copy_to(parts.output.segments.ends, 0);
    last_boxes(parts, stored);
    parts.outdated.clear();
    parts.listed.fill(0);
    parts.home.fill(I::NONE);
    if !parts.sizes.is_small() && state.tree.built > 0 {
        planes(parts, stored);
        if state.tree.filled != 0 {
            leaves(parts, stored);
            Kernels::BASELINE.run(Records { parts, stored });
        }
    }
    if !cfg!(feature = "large") {
        prove_at_once(parts);
    }
}

/// The boxes that the last step reported: those that have not changed since, then the others.
fn last_boxes<I: Index>(parts: &mut Parts<'_, I>, stored: &Stored<'_, I>) {
    if parts.boxes.before.is_empty() {
        return;
    }
    let BoxParts { now, fat, before, .. } = &mut parts.boxes;
    let is_fat = parts.state.setup.mode() == Mode::Fat && !fat.is_empty();
    before.copy_in(if is_fat { fat } else { now });
    for (slot, before) in bits::ones(parts.changed.words).zip(stored.before.iter()) {
        parts.boxes.before.put(slot, before);
    }
}

/// Planes, and what leaves have even if they are not filled.
fn planes<I: Index>(parts: &mut Parts<'_, I>, stored: &Stored<'_, I>) {
    stored.planes.copy_to(parts.tree.planes, 0);
    parts.tree.leaves.fill(Leaf::default());
    let mut start = 0;
    for (leaf, counts) in parts.tree.leaves.iter_mut().zip(stored.leaves.iter()) {
        (leaf.start, leaf.len, leaf.room) = (start, counts.len, counts.room);
        leaf.baseline = counts.baseline;
        start += counts.room;
    }
}

/// Nodes, frames and cells.
fn leaves<I: Index>(parts: &mut Parts<'_, I>, stored: &Stored<'_, I>) {
    let (state, tree) = (&*parts.state, &mut parts.tree);
    let whole_leaves = 1usize << state.tree.depth;
    tree.nodes.put(0, KeyBox::NOTHING);
    for (node, around) in (1..).zip(stored.nodes.iter()) {
        tree.nodes.put(node, around);
    }
    for (bounds, lanes) in tree.bounds.iter_mut().zip(stored.bounds.iter()) {
        *bounds = Record { lanes, tag: 0 };
    }
    tree.cells.put(0, Cell::ALL);
    divide(tree.planes, 1, state.tree.depth, tree.cells);
    for (cell, far) in tree.cells.iter_mut().zip(stored.far.iter()) {
        *cell = Cell::new(cell.low(), cell.high(), far);
    }
    for (frame, [origin, scale]) in tree.frames.iter_mut().zip(stored.frames.iter()) {
        *frame = Frame::new(origin, scale);
    }
    if state.tree.subdivided == 0 {
        for (leaf, frame) in tree.leaves.iter_mut().zip(&*tree.frames).take(whole_leaves) {
            leaf.axis = frame.longest_axis() as u32;
        }
        return;
    }
    // From the back, so that each is read before it is overwritten.
    for whole in (0..whole_leaves).rev() {
        let cell = tree.cells.at(whole);
        let cells = tree.cells.span_mut(whole * SUB_LEAVES, SUB_LEAVES);
        cells.fill(Cell::NOWHERE);
        cells.put(0, cell);
        if state.tree.is_subdivided(whole) {
            divide(tree.planes, whole_leaves + whole, SUB_LEVELS, cells);
        }
    }
}

/// The records of leaves, the large objects, homes and places.
struct Records<'p, 'm, 'b, I> {
    parts: &'p mut Parts<'m, I>,
    stored: &'p Stored<'b, I>,
}

impl<I: Index> Phase for Records<'_, '_, '_, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { parts, stored } = self;
        let swept = parts.boxes.swept();
        let mut members = stored.members.iter();
        for (index, (leaf, cell)) in parts.tree.leaves.iter().zip(&*parts.tree.cells).enumerate() {
            let Leaf { start, len, .. } = *leaf;
            let frame = parts.tree.frames.get(index >> parts.state.tree.sub_levels());
            let records = parts.tree.records.span_mut(start as usize, len as usize);
            let (Some(frame), false) = (frame, records.is_empty()) else { continue };
            for (place, (record, slot)) in records.iter_mut().zip(members.by_ref()).enumerate() {
                let keys = simd.keys(KeyBox::of(swept, slot.at()));
                *record = simd.record(frame, keys, slot.slot() | cell.classify(simd, keys).marks());
                parts.home.put(slot.at(), I::from_slot(index as u32));
                parts.place.put(slot.at(), I::from_slot(place as u32));
            }
        }
        for (place, slot) in stored.large.iter().enumerate() {
            let straddler = Straddler { bounds: swept.at(slot.at()), slot: slot.slot(), unused: 0 };
            parts.tree.straddlers.put(parts.state.tree.large_start as usize + place, straddler);
            parts.home.put(slot.at(), I::LARGE);
            parts.place.put(slot.at(), I::from_slot(place as u32));
        }
    }
}
